use super::numbers::{WORD_ONE, power_of_ten, read_extended, read_fixed, read_whole};
use super::*;
use proptest::prelude::*;

fn list(numbers: &[u8]) -> Result<ItemList, ItemListError> {
    ItemList::new(Family::Fastrak, Format::Binary, numbers)
}

#[test]
fn lists_are_as_long_as_the_manual_says() {
    let bytes =
        |family, format, numbers: &[u8]| ItemList::new(family, format, numbers).unwrap().bytes();
    let ascii = |numbers: &[u8]| bytes(Family::Fastrak, Format::Ascii, numbers);
    let binary = |numbers: &[u8]| bytes(Family::Fastrak, Format::Binary, numbers);
    // The default list, and the one of VRPN.
    assert_eq!((ascii(&[2, 4, 1]), binary(&[2, 11, 0])), (44, 29));
    assert_eq!(ascii(&[52, 61, 51]), 39 + 52 + 2);
    assert_eq!(binary(&[5, 6, 7, 16, 21, 22, 23, 0]), 46);
    assert_eq!(binary(&[18, 20]), 14);
    let liberty = bytes(Family::Liberty, Format::Binary, &[2, 7, 8, 10, 0]);
    assert_eq!(liberty, 37);
}

#[test]
fn bad_lists_are_refused() {
    use ItemListError as E;
    let ascii = |numbers: &[u8]| ItemList::new(Family::Fastrak, Format::Ascii, numbers);
    let liberty = |numbers: &[u8]| ItemList::new(Family::Liberty, Format::Binary, numbers);
    assert_eq!(list(&[2, 3, 0]), Err(E::Unknown { number: 3 }));
    assert_eq!(liberty(&[2, 11, 0]), Err(E::Unknown { number: 11 }));
    let ascii_18 = E::Format {
        number: 18,
        format: Format::Ascii,
    };
    assert_eq!(ascii(&[18]), Err(ascii_18));
    assert_eq!(list(&[2, 52, 0]), Err(E::Repeated { number: 52 }));
    assert_eq!(list(&[11, 16, 16, 0]), Err(E::Repeated { number: 16 }));
    assert_eq!(
        list(&[2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]),
        Err(E::TooMany { items: 13 })
    );
    let most = ascii(&[52, 54, 55, 56, 57, 61, 66, 1]);
    assert_eq!(
        most,
        Err(E::TooLong {
            bytes: 8 + 39 * 5 + 52 + 2 + 2
        })
    );
    assert_eq!(list(&[]), Err(E::NoPose));
    assert_eq!(list(&[5, 6, 0]), Err(E::NoPose));
    assert_eq!(list(&[2, 11]), Err(E::NoEnd));
    assert_eq!(list(&[0, 2, 11]), Err(E::NoEnd));
    assert_eq!(list(&[18, 20, 0]), Err(E::Mixed));
    for error in [
        E::Unknown { number: 3 },
        ascii_18,
        E::NoEnd,
        E::NoPose,
        E::Mixed,
    ] {
        assert!(std::format!("{error}").contains("item"), "{error}");
    }
}

#[test]
fn commands_name_the_station_and_the_items() {
    let command = list(&[2, 11, 16, 61 - 40, 0]).unwrap().command(12);
    assert_eq!(command.as_slice(), b"O12,2,11,16,21,0\r");
    // The longest: it has room.
    let twelve = [52, 54, 55, 56, 57, 61, 66, 50, 50, 51, 21, 51];
    let command = list(&twelve).unwrap().command(10);
    assert_eq!(
        command.as_slice(),
        b"O10,52,54,55,56,57,61,66,50,50,51,21,51\r"
    );
}

#[test]
fn digits_are_read_as_devices_write_them() {
    let two = |text: &[u8]| read_fixed(text, 2);
    assert_eq!(two(b"   1.25"), Some(1.25));
    assert_eq!(two(b"-012.50"), Some(-12.5));
    assert_eq!(two(b" -12.50"), Some(-12.5));
    assert_eq!(two(b"+999.99"), Some(999.99));
    assert_eq!(read_fixed(b"-1.0000", 4), Some(-1.0));
    assert_eq!(read_fixed(b" 0.7070", 4), Some(0.707));
    for bad in [
        &b"   1.2x"[..],
        b"   .125",
        b"--12.50",
        b"   1,25",
        b"- 12.50",
        b"       ",
        b"1 2.250",
        // A digit where the sign stands.
        b"1000.00",
        b"0012.50",
    ] {
        assert_eq!(two(bad), None, "{bad:?}");
    }
    assert_eq!(read_extended(b" 1.25000E+01 "), Some(12.5));
    assert_eq!(read_extended(b"-3.00000E-02 "), Some(-0.03));
    assert_eq!(read_extended(b" 9.00000E+99 "), Some(f32::INFINITY));
    assert_eq!(read_extended(b" 9.00000E-99 "), Some(0.0));
    assert_eq!(read_extended(b" 1.25000E+01x"), None);
    assert_eq!(read_extended(b" 1.25000e+01 "), None);
    assert_eq!(read_whole(b"         12345"), Some(12_345));
    assert_eq!(read_whole(b"   99999999999"), None);
    assert_eq!(read_whole(b"              "), None);
}

#[test]
fn words_are_the_manuals() {
    // Ascension's example.
    let words =
        [[0xC8, 0x08], [0x51, 0x19], [0x59, 0x2A]].map(|[low, high]| from_seven_bits(low, high));
    assert_eq!(words, [0x1120, 0x3344, 0x5564]);
    for word in (-8_192..8_192).map(|word| word << 2) {
        let [low, high] = to_seven_bits(word);
        assert_eq!((low | high) & 0x80, 0);
        assert_eq!(from_seven_bits(low, high), word);
        assert_eq!(nearest_word(f32::from(word) / WORD_ONE), word);
    }
    assert_eq!(
        [
            nearest_word(1.0),
            nearest_word(-7.0),
            nearest_word(f32::NAN)
        ],
        [32_764, -32_768, 0]
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(if cfg!(miri) { 8 } else { 1024 }))]
    #[test]
    fn digits_survive(number in -99_999_i32..=99_999, decimals in prop::sample::select(&[2_u8, 4])) {
        let value = number as f32 / power_of_ten(u32::from(decimals));
        let mut record = Vec::new();
        write_fixed(value, decimals, &mut record).unwrap();
        prop_assert_eq!(read_fixed(&record, decimals), Some(value));
    }

    #[test]
    fn exponents_survive(value in prop::num::f32::NORMAL | prop::num::f32::ZERO) {
        prop_assume!(value.abs() > 1.0e-30 || value == 0.0);
        let mut record = Vec::new();
        write_extended(value, &mut record).unwrap();
        prop_assert_eq!(record.len(), 13);
        let read = read_extended(&record).unwrap();
        prop_assert!((read - value).abs() <= 1.0e-5 * value.abs(), "{} {}", read, value);
    }
}

//! How a record's numbers are written: decimal digits, and fourteen bits in two
//! bytes.

use super::Record;

/// Steps from 0 to 1 in the 14-bit form, two bits short of 16.
pub(super) const WORD_ONE: f32 = 32_768.0;

/// Returns the value of two bytes of seven bits; `None` where the second has its highest bit set.
pub(super) fn word_value(bytes: &[u8]) -> Option<f32> {
    let &[low, high] = bytes else { return None };
    if high & 0x80 != 0 {
        return None;
    }
    Some(f32::from(from_seven_bits(low, high)) / WORD_ONE)
}

/// Returns the word of two bytes of seven bits, whose lowest two bits are 0.
pub(crate) fn from_seven_bits(low: u8, high: u8) -> i16 {
    (u16::from(low & 0x7F) << 2 | u16::from(high & 0x7F) << 9) as i16
}

/// Returns the reverse of [`from_seven_bits`].
pub(crate) fn to_seven_bits(word: i16) -> [u8; 2] {
    let word = word as u16;
    [(word >> 2 & 0x7F) as u8, (word >> 9 & 0x7F) as u8]
}

/// `value`, from −1 to 1, in the nearest of 2¹⁴ steps.
pub(crate) fn nearest_word(value: f32) -> i16 {
    let steps = libm::roundf(value * WORD_ONE / 4.0).clamp(-8_192.0, 8_191.0);
    (steps as i16) << 2
}

pub(super) fn word_bytes(value: f32, first: bool) -> [u8; 2] {
    let [low, high] = to_seven_bits(nearest_word(value));
    [if first { low | 0x80 } else { low }, high]
}

/// Returns a number of `Sxxx.xx` or `Sx.xxxx`: the first column is the sign's or blank, no digit.
pub(super) fn read_fixed(bytes: &[u8], decimals: u8) -> Option<f32> {
    if bytes.first()?.is_ascii_digit() {
        return None;
    }
    let point = bytes.len().checked_sub(usize::from(decimals) + 1)?;
    let (before, after) = bytes.split_at_checked(point)?;
    let before = before.trim_ascii_start();
    let negative = before.first() == Some(&b'-');
    let signless = before.strip_prefix(b"-").or(before.strip_prefix(b"+"));
    let before = signless.unwrap_or(before);
    let [b'.', after @ ..] = after else {
        return None;
    };
    if before.is_empty() {
        return None;
    }
    let all = digits(before, 0)?;
    let all = digits(after, all)?;
    // Five digits and a power of ten are exact: one rounding.
    let value = all as f32 / power_of_ten(u32::from(decimals));
    Some(if negative { -value } else { value })
}

/// Returns a number of `Sx.xxxxxESxxb`.
pub(super) fn read_extended(bytes: &[u8]) -> Option<f32> {
    let &[
        sign,
        one,
        b'.',
        a,
        b,
        c,
        d,
        e,
        b'E',
        exponent_sign,
        tens,
        ones,
        b' ',
    ] = bytes
    else {
        return None;
    };
    let is_negative = |sign: u8| match sign {
        b' ' | b'+' => Some(false),
        b'-' => Some(true),
        _ => None,
    };
    let mantissa = digits(&[one, a, b, c, d, e], 0)?;
    let exponent = digits(&[tens, ones], 0)? as i32;
    let exponent = if is_negative(exponent_sign)? {
        -exponent
    } else {
        exponent
    } - 5;
    let mantissa = mantissa as f32;
    let power = power_of_ten(exponent.unsigned_abs());
    let value = if exponent < 0 {
        mantissa / power
    } else {
        mantissa * power
    };
    Some(if is_negative(sign)? { -value } else { value })
}

/// Returns a whole number, right-aligned.
pub(super) fn read_whole(bytes: &[u8]) -> Option<u32> {
    let bytes = bytes.trim_ascii_start();
    if bytes.is_empty() {
        None
    } else {
        digits(bytes, 0)
    }
}

/// Decimal digits after `before`; `None` for other characters, and for too many.
fn digits(bytes: &[u8], before: u32) -> Option<u32> {
    bytes.iter().try_fold(before, |number, &byte| {
        let digit = byte.is_ascii_digit().then(|| u32::from(byte - b'0'))?;
        number.checked_mul(10)?.checked_add(digit)
    })
}

/// Exact up to 10¹⁰; infinite where f32 ends.
pub(super) fn power_of_ten(exponent: u32) -> f32 {
    let mut power = 1.0;
    for _ in 0..exponent.min(110) {
        power *= 10.0;
    }
    power
}

pub(super) type Written = Result<(), heapless::CapacityError>;

/// Returns the last `N` decimal digits.
fn decimal<const N: usize>(mut number: u32) -> [u8; N] {
    let mut digits = [b'0'; N];
    for digit in digits.iter_mut().rev() {
        *digit += (number % 10) as u8;
        number /= 10;
    }
    digits
}

const fn sign(is_negative: bool, positive: u8) -> u8 {
    if is_negative { b'-' } else { positive }
}

pub(super) fn write_fixed(value: f32, decimals: u8, record: &mut Record) -> Written {
    let scaled = libm::roundf(value * power_of_ten(u32::from(decimals)));
    let scaled = scaled.clamp(-99_999.0, 99_999.0) as i32;
    let digits = decimal::<5>(scaled.unsigned_abs());
    let (whole, rest) = digits.split_at(5 - usize::from(decimals.min(5)));
    record.extend_from_slice(&[sign(scaled < 0, b' ')])?;
    record.extend_from_slice(whole)?;
    record.extend_from_slice(b".")?;
    record.extend_from_slice(rest)
}

pub(super) fn write_extended(value: f32, record: &mut Record) -> Written {
    let mut magnitude = if value.is_finite() { value.abs() } else { 0.0 };
    let mut exponent = 0_i32;
    // At most as often as f32 has powers of ten.
    for _ in 0..50 {
        if magnitude >= 10.0 {
            magnitude /= 10.0;
            exponent += 1;
        } else if magnitude < 1.0 && magnitude > 0.0 {
            magnitude *= 10.0;
            exponent -= 1;
        }
    }
    let mut mantissa = libm::roundf(magnitude * 100_000.0) as u32;
    if mantissa > 999_999 {
        mantissa /= 10;
        exponent += 1;
    }
    let [one, a, b, c, d, e] = decimal(mantissa);
    let [tens, ones] = decimal(exponent.unsigned_abs());
    let (signed, power) = (sign(value < 0.0, b' '), sign(exponent < 0, b'+'));
    record.extend_from_slice(&[
        signed, one, b'.', a, b, c, d, e, b'E', power, tens, ones, b' ',
    ])
}

pub(super) fn write_whole(mut number: u64, characters: u8, record: &mut Record) -> Written {
    let mut text = [b' '; 14];
    for place in text.iter_mut().rev() {
        *place = b'0' + (number % 10) as u8;
        number /= 10;
        if number == 0 {
            break;
        }
    }
    let from = text.len().saturating_sub(usize::from(characters));
    record.extend_from_slice(text.get(from..).unwrap_or_default())
}

/// Writes a number's decimal digits.
pub(crate) fn push_number(bytes: &mut crate::command::Bytes, number: u16) -> Written {
    let digits = decimal::<5>(number.into());
    let zeros = digits.iter().take(4).take_while(|&&digit| digit == b'0');
    bytes.extend_from_slice(digits.get(zeros.count()..).unwrap_or_default())
}

//! Light by wavelength, against figures worked out apart from this project at
//! 40 digits, from the coefficients that refractiveindex.info has; `shisen
//! medium` and `shisen spectrum`.

use serde_json::{Value, json};
use shisen_core::spectrum::{Medium, line};
use shisen_tests::command::{folder, refused, report, run, says};

/// The lines F, d and C, and the wavelengths 400, 550 and 700 nm.
const WAVELENGTHS: [f32; 6] = [line::F, line::D, line::C, 400.0, 550.0, 700.0];

/// Name, indices at those wavelengths, Abbe's number.
const BUILT_IN: &str = "\
    fused-silica 1.4631264847 1.4584636871 1.4563666203 1.470116119 1.459910886 1.455292466 67.821432
    quartz-o     1.5496637754 1.5442761854 1.5418536593 1.557730765 1.545948448 1.540613518 69.688616
    quartz-e     1.5589504423 1.5533786410 1.5508724786 1.567293663 1.555108220 1.549589047 68.504719
    n-bk7        1.5223762897 1.5168000345 1.5143223473 1.530848538 1.518522388 1.513063997 64.167336
    sf11         1.8064543855 1.7847198459 1.7759876790 1.845121460 1.791137957 1.771808976 25.756635
    diamond      2.4355379209 2.4174858740 2.4099055647 2.464126948 2.422951316 2.406240050 55.300647
    water        1.3374918561 1.3334033362 1.3315126037 1.343556681 1.334683329 1.330517591 55.760038";

/// Media that a user could describe, SF10, N-SF10, N-SF11 and water of 24 °C: the first
/// wavelength, B and C by form 2; and in the row below as above.
const DESCRIBED: &str = "\
    380 1.6162598 0.012753456 0.25922933 0.058198396 1.0776232 116.60768
    1.7464809119 1.7282502442 1.7208475086 1.778256121 1.733661433 1.717286237 28.410205
    380 1.621539 0.012224146 0.25628784 0.059573676 1.6444755 147.4688
    1.7464305084 1.7282770663 1.7209061660 1.778259755 1.733661888 1.717353849 28.532648
    370 1.737597 0.013188707 0.31374735 0.06230681 1.898781 155.2363
    1.8065127440 1.7847199423 1.7759551113 1.845422227 1.791154676 1.771750895 25.679998
    182 0.566696 0.005084152 0.17319001 0.018184885 0.02095952 0.026254395 0.11252284 10.738424
    1.3370976930 1.3330166735 1.3311306710 1.343154613 1.334294007 1.330138670 55.809526";

/// Single precision.
const TOLERANCE: f64 = 2.0e-6;

#[track_caller]
fn assert_near(found: f64, expected: f64, what: &str) {
    let error = (found / expected - 1.0).abs();
    assert!(
        error <= TOLERANCE,
        "{what}: {found}, not {expected}: {error:e}"
    );
}

fn named(name: &str) -> Medium {
    Medium::named(name).expect("a medium")
}

fn numbers(row: &str) -> Vec<f64> {
    row.split_whitespace()
        .map(|number| number.parse().expect("a number"))
        .collect()
}

#[test]
fn media_have_the_indices_of_the_reference() {
    let check = |medium: Medium, row: &str| {
        let row = numbers(row);
        for (nm, &expected) in WAVELENGTHS.into_iter().zip(&row) {
            let found = medium.index_in(nm).expect("in range");
            assert_near(found.into(), expected, "an index");
        }
        assert_near(
            medium.abbe().expect("in range").into(),
            row[6],
            "Abbe's number",
        );
    };
    for row in BUILT_IN.lines() {
        let (name, row) = row.trim().split_once(' ').expect("a name");
        check(named(name), row);
    }
    let rows: Vec<&str> = DESCRIBED.lines().collect();
    for pair in rows.chunks(2) {
        let form: Vec<f32> = numbers(pair[0])
            .into_iter()
            .map(|number| number as f32)
            .collect();
        let terms: Vec<[f32; 2]> = form[1..].chunks(2).map(|term| [term[0], term[1]]).collect();
        let medium = Medium::form2([form[0], 1_129.0], 0.0, &terms).expect("a medium");
        check(medium, pair[1]);
    }
}

const PRISMS: [(&str, [f64; 3]); 3] = [
    ("n-bk7", [39.138_108_74, 38.646_698_51, 38.429_136_70]),
    ("sf11", [69.171_128_32, 66.342_616_58, 65.244_452_48]),
    (
        "fused-silica",
        [34.035_213_51, 33.644_070_78, 33.468_619_93],
    ),
];

fn list(value: &Value) -> Vec<f64> {
    serde_json::from_value(value.clone()).expect("numbers")
}

#[test]
fn the_medium_command_has_the_reference() {
    let folder = folder();
    for (name, degrees) in PRISMS {
        let row = BUILT_IN
            .lines()
            .find_map(|row| row.trim().strip_prefix(name))
            .expect("a row");
        let row = numbers(row);
        let found = report(folder.path(), &format!("medium {name}"));
        says(&found, json!({ "name": name, "clamped": false }));
        assert_near(found["abbe"].as_f64().expect("a number"), row[6], name);
        for (place, expected) in degrees.into_iter().enumerate() {
            let found = |key: &str| found["wavelengths"][place][key].as_f64().expect("a number");
            assert_near(found("n"), row[place], name);
            assert_near(found("minimum_deviation_deg"), expected, name);
        }
    }
    // Diamond of 60° reflects all light inside.
    let diamond = report(folder.path(), "medium diamond --prism 60");
    assert_eq!(
        diamond["wavelengths"][0]["minimum_deviation_deg"],
        Value::Null
    );
    let clamped = report(folder.path(), "medium sf11 --wavelength 380 500 --clamp");
    assert_eq!(clamped["clamped"], true);
    let nm = [0, 1].map(|place| &clamped["wavelengths"][place]["nm"]);
    assert_eq!(nm, [390.0, 500.0]);
}

#[test]
fn the_spectrum_command_has_the_wavelengths_of_its_method() {
    let folder = folder();
    let spectrum = |words: &str| report(folder.path(), &format!("spectrum {words}"));
    for (words, nm, matching) in [
        ("3 --method fixed", &[450.0, 550.0, 650.0][..], "wyman"),
        ("1 --method paper", &[565.0], "endo"),
        ("2 --method fixed --range 500,600", &[525.0, 575.0], "wyman"),
        ("2 --method fixed --range 500 600", &[525.0, 575.0], "wyman"),
        ("1 --method fixed --matching table", &[550.0], "table"),
    ] {
        let report = spectrum(&format!("--wavelengths {words}"));
        assert_eq!(
            (&list(&report["wavelengths_nm"])[..], &report["matching"]),
            (nm, &json!(matching))
        );
    }
    for phase in [0, 5, 31] {
        let report = spectrum(&format!("--wavelengths 10 --phase {phase}"));
        says(&report, json!({ "method": "comb", "phases": 32 }));
        let offset = report["offset"].as_f64().expect("a number");
        for (k, nm) in list(&report["wavelengths_nm"]).into_iter().enumerate() {
            assert!((nm - (400.0 + 30.0 * (k as f64 + offset))).abs() < 1.0e-4);
        }
    }
    // The paper's wavelengths keep to what the medium is known for, and say so.
    let paper = "--wavelengths 7 --method paper --medium";
    let clamped = spectrum(&format!("{paper} sf11"));
    assert_eq!(clamped["clamped"], true);
    assert_eq!(list(&clamped["range_nm"]), [390.0, 750.0]);
    let said = run(folder.path(), &format!("spectrum {paper} sf11")).out;
    assert!(said.contains("clamped to what sf11 is known for"), "{said}");
    assert_eq!(spectrum(&format!("{paper} n-bk7"))["clamped"], false);
}

#[test]
fn unknown_media_and_wavelengths_are_refused() {
    refused(
        folder().path(),
        2,
        r#"
        medium sf11 --wavelength 380 => 390 to 2500 nm
        medium sf11 --wavelength 380 => --clamp
        medium water --wavelength nan => 182 to 1129 nm
        medium water --wavelength 0 => 182 to 1129 nm
        medium N-BK77 => did you mean "n-bk7"?
        medium cheese => fused-silica, quartz-o, quartz-e, n-bk7
        medium water --prism 0 => above 0 and below 180
        medium water --prism 180 => above 0 and below 180
        medium water --prism nan => above 0 and below 180
        medium => NAME
        spectrum --wavelengths 10 --phase 32 => from 0 to 31
        spectrum --wavelengths 7 --range 380,700 --medium sf11 => 390 to 2500 nm
        spectrum --wavelengths 7 --medium sf1 => did you mean "sf11"?
        spectrum --wavelengths 0 => from 1 to 64
        spectrum --wavelengths 4294967295 => from 1 to 64
        spectrum --wavelengths 1.5 => --wavelengths
        spectrum --wavelengths 4294967296 => --wavelengths
        spectrum --wavelengths 7 --range 700,400 => from 360 to 830 nm
        spectrum --wavelengths 7 --range 400,400 => from 360 to 830 nm
        spectrum --wavelengths 7 --range 300,700 => from 360 to 830 nm
        spectrum --wavelengths 7 --range nan,700 => from 360 to 830 nm
        spectrum --wavelengths 7 --range 400 => such as 400,700
        spectrum --wavelengths 7 --range 1,2,3 => --range
        spectrum --method comb => --wavelengths
        spectrum --wavelengths 7 --method hero => comb"#,
    );
}

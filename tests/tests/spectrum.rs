//! Light by wavelength, against figures worked out apart from this project at
//! 40 digits, from the coefficients that refractiveindex.info has; `shisen
//! medium` and `shisen spectrum`.

use glam::{DVec3, Vec2, Vec3};
use serde_json::Value;
use shisen::render::spectrum::{CIE_1931, minimum_deviation};
use shisen_core::spectrum::{Matching, Medium, SpectralSample, SpectralTable, Wavelengths, line};
use shisen_core::trace::refract;
use shisen_tests::command::shisen;

/// The lines F, d and C, and the wavelengths 400, 550 and 700 nm.
const WAVELENGTHS: [f32; 6] = [line::F, line::D, line::C, 400.0, 550.0, 700.0];

/// Name, indices at those wavelengths, Abbe's number.
const BUILT_IN: [(&str, [f64; 6], f64); 7] = [
    (
        "fused-silica",
        [
            1.463_126_484_7,
            1.458_463_687_1,
            1.456_366_620_3,
            1.470_116_119,
            1.459_910_886,
            1.455_292_466,
        ],
        67.821_432,
    ),
    (
        "quartz-o",
        [
            1.549_663_775_4,
            1.544_276_185_4,
            1.541_853_659_3,
            1.557_730_765,
            1.545_948_448,
            1.540_613_518,
        ],
        69.688_616,
    ),
    (
        "quartz-e",
        [
            1.558_950_442_3,
            1.553_378_641,
            1.550_872_478_6,
            1.567_293_663,
            1.555_108_22,
            1.549_589_047,
        ],
        68.504_719,
    ),
    (
        "n-bk7",
        [
            1.522_376_289_7,
            1.516_800_034_5,
            1.514_322_347_3,
            1.530_848_538,
            1.518_522_388,
            1.513_063_997,
        ],
        64.167_336,
    ),
    (
        "sf11",
        [
            1.806_454_385_5,
            1.784_719_845_9,
            1.775_987_679,
            1.845_121_46,
            1.791_137_957,
            1.771_808_976,
        ],
        25.756_635,
    ),
    (
        "diamond",
        [
            2.435_537_920_9,
            2.417_485_874,
            2.409_905_564_7,
            2.464_126_948,
            2.422_951_316,
            2.406_240_05,
        ],
        55.300_647,
    ),
    (
        "water",
        [
            1.337_491_856_1,
            1.333_403_336_2,
            1.331_512_603_7,
            1.343_556_681,
            1.334_683_329,
            1.330_517_591,
        ],
        55.760_038,
    ),
];

/// Media that a user could describe: range, B and C by form 2, and as above.
type Described = ([f32; 2], &'static [[f32; 2]], [f64; 6], f64);

const DESCRIBED: [Described; 4] = [
    // SF10.
    (
        [380.0, 2500.0],
        &[
            [1.616_259_8, 0.012_753_456],
            [0.259_229_33, 0.058_198_396],
            [1.077_623_2, 116.607_68],
        ],
        [
            1.746_480_911_9,
            1.728_250_244_2,
            1.720_847_508_6,
            1.778_256_121,
            1.733_661_433,
            1.717_286_237,
        ],
        28.410_205,
    ),
    // N-SF10.
    (
        [380.0, 2500.0],
        &[
            [1.621_539, 0.012_224_146],
            [0.256_287_84, 0.059_573_676],
            [1.644_475_5, 147.468_8],
        ],
        [
            1.746_430_508_4,
            1.728_277_066_3,
            1.720_906_166,
            1.778_259_755,
            1.733_661_888,
            1.717_353_849,
        ],
        28.532_648,
    ),
    // N-SF11.
    (
        [370.0, 2500.0],
        &[
            [1.737_597, 0.013_188_707],
            [0.313_747_35, 0.062_306_81],
            [1.898_781, 155.236_3],
        ],
        [
            1.806_512_744,
            1.784_719_942_3,
            1.775_955_111_3,
            1.845_422_227,
            1.791_154_676,
            1.771_750_895,
        ],
        25.679_998,
    ),
    // Water of 24 °C.
    (
        [182.0, 1129.0],
        &[
            [0.566_696, 0.005_084_152],
            [0.173_190_01, 0.018_184_885],
            [0.020_959_52, 0.026_254_395],
            [0.112_522_84, 10.738_424],
        ],
        [
            1.337_097_693,
            1.333_016_673_5,
            1.331_130_671,
            1.343_154_613,
            1.334_294_007,
            1.330_138_67,
        ],
        55.809_526,
    ),
];

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

fn index(name: &str, nm: f32) -> f64 {
    named(name).index_in(nm).expect("in range").into()
}

#[test]
fn media_have_the_indices_of_the_reference() {
    let check = |medium: Medium, indices: [f64; 6], abbe: f64, what: &str| {
        for (nm, expected) in WAVELENGTHS.into_iter().zip(indices) {
            let found = medium.index_in(nm).expect("in range");
            assert_near(found.into(), expected, what);
        }
        assert_near(medium.abbe().expect("in range").into(), abbe, what);
    };
    for (name, indices, abbe) in BUILT_IN {
        check(named(name), indices, abbe, name);
    }
    for (range, terms, indices, abbe) in DESCRIBED {
        let medium = Medium::form2(range, 0.0, terms).expect("a medium");
        check(medium, indices, abbe, "described");
    }
}

#[test]
fn prisms_turn_light_as_in_the_reference() {
    let sixty = 60f64.to_radians();
    for (name, degrees) in PRISMS {
        for (nm, expected) in WAVELENGTHS.into_iter().zip(degrees) {
            let found = minimum_deviation(index(name, nm), sixty).expect("an angle");
            assert_near(found.to_degrees(), expected, name);
        }
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

#[test]
fn a_prism_turns_rays_by_their_minimum_deviation() {
    // Light that enters at half of it and the apex goes straight across.
    let apex = 60f64.to_radians();
    for (name, degrees) in PRISMS {
        for (nm, expected) in WAVELENGTHS.into_iter().zip(degrees) {
            let n = named(name).index_in(nm).expect("in range");
            let normal = |turn: f64| Vec2::new(turn.cos() as f32, turn.sin() as f32).extend(0.0);
            let incidence = 0.5 * (expected.to_radians() + apex);
            // The first side faces −X turned up by half the apex.
            let first = -normal(-0.5 * apex);
            let direction = normal(incidence - 0.5 * apex);
            let inside = refract(direction, first, 1.0, n).direction.expect("in");
            let second = -normal(0.5 * apex);
            let out = refract(inside, second, n, 1.0).direction.expect("out");
            let turned = f64::from(direction.y).atan2(direction.x.into())
                - f64::from(out.y).atan2(out.x.into());
            assert_near(turned.to_degrees(), expected, name);
        }
    }
}

#[test]
fn a_rainbow_stands_where_water_puts_it() {
    let degrees = [41.429_370_77, 42.019_490_55, 42.294_898_46];
    for (nm, expected) in WAVELENGTHS.into_iter().zip(degrees) {
        let n = index("water", nm);
        let incidence = ((n * n - 1.0) / 3.0).sqrt().acos();
        let refracted = (incidence.sin() / n).asin();
        let found = 4.0 * refracted - 2.0 * incidence;
        assert_near(found.to_degrees(), expected, "rainbow");
    }
}

#[test]
fn media_reflect_as_in_the_reference() {
    for (name, normal, brewster, critical) in [
        ("fused-silica", 0.034_776_21, 55.563_399_21, 43.286_983_43),
        ("n-bk7", 0.042_164_57, 56.603_826_78, 41.245_189_23),
        ("sf11", 0.079_408_36, 60.737_565_34, 34.077_379_45),
        ("diamond", 0.172_037_86, 67.527_425_49, 24.434_510_68),
        ("water", 0.020_415_51, 53.131_546_22, 48.586_967_26),
    ] {
        let n = named(name).index_in(line::D).expect("in range");
        for (from, to) in [(1.0, n), (n, 1.0)] {
            let found = refract(Vec3::NEG_Y, Vec3::Y, from, to);
            assert_near(found.reflectance.into(), normal, name);
            assert_near(found.transmittance.into(), 1.0 - normal, name);
        }
        // At Brewster's angle half of the light, polarised across, is all that
        // is reflected, and there the refracted ray is at a right angle.
        let angle: f64 = brewster;
        let cos = angle.to_radians().cos();
        let found = refract(falling(cos as f32), Vec3::Y, 1.0, n);
        let s = cos * cos - angle.to_radians().sin().powi(2);
        assert_near(found.reflectance.into(), 0.5 * s * s, name);
        assert_near(f64::from(n).atan().to_degrees(), brewster, name);
        // The least cosine from inside that lets any light out.
        let (mut none, mut some) = (0f32, 1f32);
        while none.next_up() < some {
            let middle = f32::midpoint(none, some);
            match refract(falling(middle), Vec3::Y, n, 1.0).direction {
                Some(_) => some = middle,
                None => none = middle,
            }
        }
        assert_near(f64::from(some).acos().to_degrees(), critical, name);
    }
}

/// Light that comes down on a level border, at an angle of this cosine.
fn falling(cos: f32) -> Vec3 {
    Vec3::new(((1.0 - cos) * (1.0 + cos)).sqrt(), -cos, 0.0)
}

/// Where a ray along the axis at this height crosses it behind a ball of
/// radius 1, from the ball's centre; all in single precision.
fn focus(index: f32, height: f32) -> f32 {
    let enters = Vec3::new(-((1.0 - height) * (1.0 + height)).sqrt(), height, 0.0);
    let inside = refract(Vec3::X, enters, 1.0, index).direction.expect("in");
    let leaves = enters - inside * (2.0 * inside.dot(enters));
    let out = refract(inside, -leaves, index, 1.0).direction.expect("out");
    leaves.x - leaves.y * (out.x / out.y)
}

#[test]
fn a_ball_of_silica_focuses_as_in_the_reference() {
    for (height, places) in [
        // So near the axis that the next term does not count.
        (1.0e-4, [1.579_618_67, 1.590_598_92, 1.595_610_37]),
        (0.1, [1.575_004_61, 1.585_924_35, 1.590_908_21]),
        (0.5, [1.459_460_17, 1.468_831_36, 1.473_109_09]),
    ] {
        for (nm, expected) in WAVELENGTHS.into_iter().zip(places) {
            let n = Medium::FUSED_SILICA.index_in(nm).expect("in range");
            assert_near(focus(n, height).into(), expected, "focus");
        }
    }
}

/// The light in bands that rise and fall over 30 nm each, 5 nm from one to the
/// next: what the picture of a slit would show.
fn bands(samples: &[SpectralSample]) -> Vec<DVec3> {
    let band = |centre: f32| {
        let shares = samples.iter().map(|sample| {
            let share = (1.0 - (sample.nm - centre).abs() / 30.0).max(0.0);
            sample.weight.as_dvec3() * f64::from(share)
        });
        shares.sum()
    };
    (0..=60u8)
        .map(|i| band(400.0 + 5.0 * f32::from(i)))
        .collect()
}

#[test]
fn a_comb_has_the_colours_of_the_whole_spectrum() {
    let mut storage = vec![SpectralSample::default(); 2 * SpectralTable::MOST_SAMPLES];
    let mut picture = |count, phases, scale: f64| -> Vec<DVec3> {
        let wavelengths = Wavelengths::new(count, Wavelengths::RANGE).expect("wavelengths");
        let table = SpectralTable::new(wavelengths, phases, Matching::Wyman, &mut storage);
        let table = table.expect("a table");
        let all: Vec<_> = (0..phases)
            .flat_map(|phase| table.phase(phase))
            .copied()
            .collect();
        bands(&all)
            .into_iter()
            .map(|colour| colour * scale)
            .collect()
    };
    // Sixty-four at sixty-four offsets: as good as all there are.
    let whole = picture(64, 64, 1.0 / 64.0);
    let mut error = |count, phases: u32| {
        let colours = picture(count, phases, 1.0 / f64::from(phases));
        let apart = |(a, b): (&DVec3, &DVec3)| (*a - *b).abs().max_element();
        colours.iter().zip(&whole).map(apart).fold(0.0, f64::max)
    };
    // A fixed set leaves gaps between its stripes; the comb has none, and from
    // seven wavelengths on what scaling each offset to white costs is small.
    for (count, bound) in [(7, 0.008), (10, 0.001), (14, 0.0003), (28, 0.0003)] {
        let (comb, fixed) = (error(count, SpectralTable::COMB_PHASES), error(count, 1));
        assert!(comb <= bound, "{count}: {comb}");
        assert!(fixed >= 10.0 * comb, "{count}: {fixed} {comb}");
    }
}

#[test]
fn tables_and_fits_give_nearly_the_same_weights() {
    let wavelengths = Wavelengths::new(14, Wavelengths::RANGE).expect("wavelengths");
    let weights = |matching| {
        let mut storage = vec![SpectralSample::default(); SpectralTable::samples(wavelengths, 1)];
        let table = SpectralTable::new(wavelengths, 1, matching, &mut storage).expect("a table");
        let weights = table.phase(0).iter().map(|sample| sample.weight);
        weights.collect::<Vec<_>>()
    };
    let pairs = weights(Matching::Wyman)
        .into_iter()
        .zip(weights(Matching::Table(CIE_1931)));
    for (fit, table) in pairs {
        assert!((fit - table).abs().max_element() < 0.012, "{fit} {table}");
    }
}

/// What the command prints with `--json`.
fn report(arguments: &[&str]) -> Value {
    let folder = tempfile::tempdir().expect("a folder");
    let assert = shisen(folder.path())
        .args(arguments)
        .arg("--json")
        .assert()
        .success();
    let output = assert.get_output();
    assert!(output.stderr.is_empty());
    let text = String::from_utf8(output.stdout.clone()).expect("text");
    assert_eq!(text.lines().count(), 1);
    serde_json::from_str(&text).expect("JSON")
}

/// What it prints for people.
fn text(arguments: &[&str]) -> String {
    let folder = tempfile::tempdir().expect("a folder");
    let assert = shisen(folder.path()).args(arguments).assert().success();
    String::from_utf8(assert.get_output().stdout.clone()).expect("text")
}

/// What it says where it is asked for something that there is not.
fn refusal(arguments: &[&str]) -> String {
    let folder = tempfile::tempdir().expect("a folder");
    let assert = shisen(folder.path()).args(arguments).assert().code(2);
    let output = assert.get_output();
    assert!(output.stdout.is_empty());
    String::from_utf8(output.stderr.clone()).expect("text")
}

fn keys(value: &Value) -> Vec<&str> {
    let object = value.as_object().expect("an object");
    object.keys().map(String::as_str).collect()
}

fn numbers(value: &Value) -> Vec<f64> {
    let numbers = value.as_array().expect("an array").iter();
    numbers
        .map(|number| number.as_f64().expect("a number"))
        .collect()
}

#[test]
fn the_medium_command_has_the_reference() {
    for (name, indices, abbe) in BUILT_IN {
        let nm = ["486.1327", "587.5618", "656.2725", "400", "550", "700"];
        let report = report(&[&["medium", name, "--wavelength"], &nm[..]].concat());
        let expected = [
            "name",
            "range_nm",
            "abbe",
            "prism_deg",
            "clamped",
            "wavelengths",
        ];
        let mut found = keys(&report);
        found.sort_unstable();
        let mut expected = expected.to_vec();
        expected.sort_unstable();
        assert_eq!(found, expected);
        assert_eq!(report["name"], name);
        assert_eq!(report["clamped"], false);
        assert_near(report["abbe"].as_f64().expect("a number"), abbe, name);
        let rows = report["wavelengths"].as_array().expect("an array");
        assert_eq!(rows.len(), 6);
        for ((row, nm), expected) in rows.iter().zip(nm).zip(indices) {
            assert_eq!(row["nm"].as_f64(), nm.parse().ok(), "as it was given");
            assert_near(row["n"].as_f64().expect("a number"), expected, name);
        }
    }
}

#[test]
fn the_medium_command_has_prisms() {
    for (name, degrees) in PRISMS {
        let report = report(&["medium", name]);
        let rows = report["wavelengths"].as_array().expect("an array");
        assert_eq!(rows.len(), 3);
        for (row, expected) in rows.iter().zip(degrees) {
            let found = row["minimum_deviation_deg"].as_f64().expect("a number");
            assert_near(found, expected, name);
        }
    }
    // Diamond of 60° reflects all light inside.
    let report = report(&["medium", "diamond", "--prism", "60"]);
    assert_eq!(
        report["wavelengths"][0]["minimum_deviation_deg"],
        Value::Null
    );
    assert!(text(&["medium", "diamond"]).contains("all reflected"));
    let text = text(&[
        "medium",
        "sf11",
        "--prism",
        "30",
        "--wavelength",
        "390,2500",
    ]);
    assert!(
        text.contains("390 to 2500 nm, Abbe number 25.757"),
        "{text}"
    );
    assert_eq!(text.lines().count(), 4, "{text}");
}

#[test]
fn the_medium_command_clamps_where_asked() {
    let says = refusal(&["medium", "sf11", "--wavelength", "380"]);
    assert!(
        says.contains("390 to 2500 nm") && says.contains("--clamp"),
        "{says}"
    );
    let clamped = report(&["medium", "sf11", "--wavelength", "380", "500", "--clamp"]);
    assert_eq!(clamped["clamped"], true);
    assert_eq!(clamped["wavelengths"][0]["nm"], 390.0);
    assert_eq!(clamped["wavelengths"][1]["nm"], 500.0);
    let inside = report(&["medium", "sf11", "--wavelength", "500", "--clamp"]);
    assert_eq!(inside["clamped"], false);
    for nm in ["nan", "inf", "-1", "0"] {
        let says = refusal(&["medium", "water", "--wavelength", nm]);
        assert!(says.contains("182 to 1129 nm"), "{says}");
    }
}

#[test]
fn the_medium_command_refuses_what_there_is_not() {
    let says = refusal(&["medium", "N-BK77"]);
    assert!(says.contains("did you mean \"n-bk7\"?"), "{says}");
    let says = refusal(&["medium", "cheese"]);
    assert!(
        says.contains("fused-silica, quartz-o, quartz-e, n-bk7"),
        "{says}"
    );
    for prism in ["0", "180", "-60", "nan", "x"] {
        let says = refusal(&["medium", "water", "--prism", prism]);
        assert!(says.contains("above 0 and below 180"), "{says}");
    }
    assert!(refusal(&["medium"]).contains("NAME"));
}

#[test]
fn the_spectrum_command_sums_to_white() {
    for method in ["fixed", "comb", "paper"] {
        for count in [1usize, 2, 7, 10, 14, 64] {
            let count_text = count.to_string();
            let report = report(&["spectrum", "--wavelengths", &count_text, "--method", method]);
            let nm = numbers(&report["wavelengths_nm"]);
            let weights = report["weights"].as_array().expect("an array");
            assert_eq!((nm.len(), weights.len()), (count, count));
            assert!(nm.is_sorted_by(|a, b| a < b));
            let mut sum = [0.0; 3];
            for weight in weights {
                for (sum, channel) in sum.iter_mut().zip(numbers(weight)) {
                    *sum += channel;
                }
            }
            let white_error = report["white_error"].as_f64().expect("a number");
            assert_eq!(white_error, 0.0, "{method} {count}");
            // Reading decimals rounds.
            let error = sum.map(|sum| (sum - 1.0).abs());
            assert!(error.iter().all(|&error| error < 1.0e-14), "{error:?}");
        }
    }
}

#[test]
fn the_spectrum_command_has_the_centres_of_equal_parts() {
    let fixed = report(&["spectrum", "--wavelengths", "3", "--method", "fixed"]);
    assert_eq!(numbers(&fixed["wavelengths_nm"]), [450.0, 550.0, 650.0]);
    assert_eq!(
        (&fixed["method"], &fixed["matching"]),
        (&"fixed".into(), &"wyman".into())
    );
    assert_eq!(fixed["phases"], 1);
    let paper = report(&["spectrum", "--wavelengths", "1", "--method", "paper"]);
    assert_eq!(numbers(&paper["wavelengths_nm"]), [565.0]);
    assert_eq!(paper["matching"], "endo");
    assert_eq!(numbers(&paper["weights"][0]), [1.0; 3]);
    for range in [&["500,600"][..], &["500", "600"]] {
        let arguments = [
            &[
                "spectrum",
                "--wavelengths",
                "2",
                "--method",
                "fixed",
                "--range",
            ],
            range,
        ];
        let report = report(&arguments.concat());
        assert_eq!(numbers(&report["wavelengths_nm"]), [525.0, 575.0]);
    }
    let table = report(&["spectrum", "--wavelengths", "3", "--matching", "table"]);
    assert_eq!(table["matching"], "table");
}

#[test]
fn the_spectrum_command_shows_a_combs_phases() {
    let first = report(&["spectrum", "--wavelengths", "10"]);
    assert_eq!(first["method"], "comb");
    let phases = first["phases"].as_u64().expect("a number");
    assert_eq!(phases, 32);
    for phase in [0, 5, 31] {
        let phase_text = phase.to_string();
        let report = report(&["spectrum", "--wavelengths", "10", "--phase", &phase_text]);
        let offset = report["offset"].as_f64().expect("a number");
        for (k, nm) in numbers(&report["wavelengths_nm"]).into_iter().enumerate() {
            assert!((nm - (400.0 + 30.0 * (k as f64 + offset))).abs() < 1.0e-4);
        }
        assert_eq!(report["phase"], phase);
    }
    let says = refusal(&["spectrum", "--wavelengths", "10", "--phase", "32"]);
    assert!(says.contains("from 0 to 31"), "{says}");
    let text = text(&["spectrum", "--wavelengths", "10", "--phase", "1"]);
    assert!(
        text.contains("phase 1 of 32") && text.lines().count() == 14,
        "{text}"
    );
}

#[test]
fn the_papers_wavelengths_keep_to_the_medium_and_say_so() {
    let arguments = [
        "spectrum",
        "--wavelengths",
        "7",
        "--method",
        "paper",
        "--medium",
        "sf11",
    ];
    let clamped = report(&arguments);
    assert_eq!(clamped["clamped"], true);
    assert_eq!(numbers(&clamped["range_nm"]), [390.0, 750.0]);
    assert!(text(&arguments).contains("clamped to what sf11 is known for"));
    let free = report(&[
        "spectrum",
        "--wavelengths",
        "7",
        "--method",
        "paper",
        "--medium",
        "n-bk7",
    ]);
    assert_eq!(free["clamped"], false);
    let says = refusal(&[
        "spectrum",
        "--wavelengths",
        "7",
        "--range",
        "380,700",
        "--medium",
        "sf11",
    ]);
    assert!(says.contains("390 to 2500 nm"), "{says}");
    let says = refusal(&["spectrum", "--wavelengths", "7", "--medium", "sf1"]);
    assert!(says.contains("did you mean \"sf11\"?"), "{says}");
}

#[test]
fn the_spectrum_command_refuses_what_there_is_not() {
    for count in ["0", "65", "4294967295"] {
        let says = refusal(&["spectrum", "--wavelengths", count]);
        assert!(says.contains("from 1 to 64"), "{says}");
    }
    for count in ["-1", "x", "1.5", "4294967296"] {
        let says = refusal(&["spectrum", "--wavelengths", count]);
        assert!(says.contains("--wavelengths"), "{says}");
    }
    for range in ["700,400", "400,400", "300,700", "400,900", "nan,700"] {
        let says = refusal(&["spectrum", "--wavelengths", "7", "--range", range]);
        assert!(says.contains("from 360 to 830 nm"), "{says}");
    }
    let says = refusal(&["spectrum", "--wavelengths", "7", "--range", "400"]);
    assert!(says.contains("such as 400,700"), "{says}");
    assert!(refusal(&["spectrum", "--wavelengths", "7", "--range", "1,2,3"]).contains("--range"));
    assert!(refusal(&["spectrum", "--method", "comb"]).contains("--wavelengths"));
    assert!(refusal(&["spectrum", "--wavelengths", "7", "--method", "hero"]).contains("comb"));
}

//! Rooms measured with a tape, beside corners that another program found of the same lengths.

use super::*;
use crate::files::description::tests::check_faults;

/// The CAVE that another program measured: floor A B C D from the front left clockwise, E F G H
/// over it.
const ROOM: &str = include_str!("room.toml");

/// Lengths, heights and flatness of [`ROOM`], each with residual (mm), standardised residual and
/// redundancy, as the other program has them.
const RESIDUALS: &str = include_str!("residuals.csv");

/// Its corners.
const CORNERS: [(&str, [f64; 3]); 8] = [
    ("A", [0.0, 0.0, 0.0]),
    ("B", [3.003_120, 0.002_459, 0.0]),
    ("C", [3.012_632, 0.000_540, 2.990_993]),
    ("D", [0.014_295, -0.002_542, 3.002_290]),
    ("E", [0.001_970, 2.402_747, 0.001_561]),
    ("F", [3.007_683, 2.395_546, -0.000_610]),
    ("G", [3.017_133, 2.397_654, 2.981_295]),
    ("H", [0.017_022, 2.405_317, 2.999_353]),
];

fn survey(text: &str) -> Survey {
    Survey::from_toml(text, "room.toml").unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn corners_and_residuals_are_those_of_the_other_program() {
    let survey = survey(ROOM);
    assert_eq!((survey.measurements.len(), survey.unknowns), (31, 20));
    for (name, place) in CORNERS {
        let corner = survey.corners.iter().find(|corner| corner.name == name);
        let off = corner.unwrap().position.distance(place.into());
        assert!(off < 2e-6, "{name}: {off}");
    }
    let mut count = 0;
    for line in RESIDUALS.lines() {
        let fields: Vec<&str> = line.split(',').collect();
        let [kind, name, values @ ..] = fields.as_slice() else {
            panic!("{line}");
        };
        let found = survey.measurements.iter().find(|one| {
            let own = match one.quantity {
                Quantity::Length(_) => "distance",
                Quantity::Height(_) => "height",
                Quantity::Flatness(_) => "flat",
            };
            (own, one.name.as_str()) == (*kind, *name)
        });
        let one = found.unwrap_or_else(|| panic!("{line}"));
        let own = [1000.0 * one.residual, one.standardised, one.redundancy];
        for (value, own) in values.iter().zip(own) {
            let value: f64 = value.parse().unwrap();
            assert!((value - own).abs() < 2e-3, "{line}: {own}");
            count += 1;
        }
    }
    assert_eq!(count, 3 * 31);
    assert!(survey.suspects().is_empty());
}

#[test]
fn a_length_that_is_wrong_is_named_with_the_room_kept() {
    let survey = survey(&ROOM.replace("AF = 3.847", "AF = 3.897"));
    let suspects = survey.suspects();
    let [wrong] = suspects.as_slice() else {
        panic!("{suspects:?}");
    };
    assert_eq!(survey.measurements[*wrong].name, "AF");
    assert!((survey.measurements[*wrong].standardised + 18.6).abs() < 0.1);
}

/// Returns in how many of 60 trials a slip of 30 mm in one length is named alone, and rightly, by a
/// whole adjustment.
fn named_alone(survey: &Survey) -> u64 {
    let exact = CORNERS.map(|(name, place)| {
        let corner = survey.corners.iter().position(|corner| corner.name == name);
        (corner.unwrap(), DVec3::from(place))
    });
    let mut places = vec![DVec3::ZERO; 8];
    for (number, place) in exact {
        places[number] = place;
    }
    let free: Vec<usize> = (3..24).filter(|&axis| axis != 5).collect();
    let lengths = survey.measurements.iter();
    let lengths = lengths.filter(|one| matches!(one.quantity, Quantity::Length(_)));
    let lengths = lengths.count() as u64;
    let trials = (0..60).filter(|&trial| {
        let mut measurements = survey.measurements.clone();
        for (number, one) in measurements.iter_mut().enumerate() {
            let error = noise(trial + 1_000_000, number as u64);
            one.measured = match one.quantity {
                Quantity::Length([a, b]) => places[a].distance(places[b]) + one.sigma * error,
                Quantity::Height([a, b]) => places[b].y - places[a].y + one.sigma * error,
                Quantity::Flatness(_) => Odds::UNFLAT * error,
            };
        }
        let slipped = (trial % lengths) as usize;
        let sign = if trial < 30 { 1.0 } else { -1.0 };
        measurements[slipped].measured += sign * 0.03;
        let adjusted = Adjusted::new(&measurements, places.clone(), &free);
        let propagation = adjusted.propagation();
        let residuals = adjusted.residuals.iter().enumerate();
        let named = suspects(residuals.map(|(i, &own)| standardised(own, propagation[i][i])));
        named == [slipped]
    });
    trials.count() as u64
}

#[test]
fn the_odds_are_those_of_sixty_rooms_with_a_slip() {
    let back = "[lengths_m]\nCH = 3.835\nDG = 3.835";
    let base = ROOM.replace("[lengths_m]", back);
    let kept = |starts: &[&str]| {
        let lines = base.lines();
        let lines = lines.filter(|line| !starts.iter().any(|start| line.starts_with(start)));
        lines.collect::<Vec<_>>().join("\n") + "\n"
    };
    // Edges and diagonals of four walls and the floor; with two diagonals of the room; with
    // flatness; with both. The last number is the share of another program's 60 trials.
    for (left_out, of_others) in [
        (&["AG", "BH", "CE", "DF", "flat"][..], 23.0 / 60.0),
        (&["CE", "DF", "flat"], 40.0 / 60.0),
        (&["AG", "BH", "CE", "DF"], 51.0 / 60.0),
        (&["CE", "DF"], 49.0 / 60.0),
    ] {
        let survey = survey(&kept(left_out));
        let (quoted, tried) = (survey.odds.alone, named_alone(&survey) as f64 / 60.0);
        assert!(
            (quoted - tried).abs() < 0.13,
            "{left_out:?}: {quoted}, {tried}"
        );
        assert!(quoted < of_others + 0.1, "{left_out:?}: {quoted}");
        assert!(survey.odds.wrong < 0.05, "{left_out:?}: {:?}", survey.odds);
    }
}

#[test]
fn the_room_is_the_parallelograms_nearest_to_the_corners() {
    let survey = survey(ROOM);
    let text = survey.to_toml(survey.middle()).unwrap();
    let cave = Cave::from_toml(&text, "walls.toml", [7; 2]).unwrap();
    assert_eq!(cave.walls[0].pixels, [1920, 1536]);
    assert_eq!(cave.walls[3].pixels, [7; 2]);
    cave.check_eye(DVec3::ZERO).unwrap();
    for (wall, measured) in cave.walls.iter().zip(&survey.walls) {
        let deviation = survey.deviation(measured);
        let places = survey.places(measured).map(|place| place - survey.middle());
        let upper_right = wall.lower_right + wall.upper_left - wall.lower_left;
        let found = [
            wall.lower_left,
            wall.lower_right,
            upper_right,
            wall.upper_left,
        ];
        for (own, found) in places.into_iter().zip(found) {
            assert!((own.distance(found) - 0.25 * deviation).abs() < 2e-5);
        }
    }
}

#[test]
fn a_laser_over_the_corners_says_the_same_as_heights_of_one_over_another() {
    let (lengths, _) = ROOM.split_once("[heights_m]").unwrap();
    let text = format!("{lengths}[heights_m]\nA = -0.5\nB = -0.498\nC = -0.499\nD = -0.503");
    let over_laser = survey(&text);
    for (one, other) in over_laser.corners.iter().zip(&survey(ROOM).corners) {
        assert!(one.position.distance(other.position) < 0.001);
    }
}

/// As `check_faults` reads them.
const FAULTS: &str = r#"
AB = 3.003 | AB = nan | AB is NaN m
AB = 3.003 | AB = 3003 | AB is 3003 m
AB = 3.003 | AB = 0 | AB is 0 m
AB = 3.003 | AB = "3" | a value is metres
AB = 3.003 | AB = 9.003 | make no triangle
AB = 3.003 | AX = 3.003 | no wall has a corner X
AB = 3.003 | AA = 3.003 | to itself
AB = 3.003 | A = 3.003 | two corners
BC = 2.991 | BA = 2.991 | given already, as AB
tape_mm = 2 | tape_mm = 0 | tape_mm is 0
flat_mm = 3 | flat_mm = nan | flat_mm is NaN
"A B F E" | "A B F" | four corners
"A B F E" | "A B F A" | A twice
"D A E H" | "D A H E" | do not go round
"D A E H" | "A D H E" | turns its back
"right" | "Front" | two walls
"#;

#[test]
fn faults_are_named_with_their_line() {
    check_faults(ROOM, FAULTS, |text| Survey::from_toml(text, "room.toml"));
    let without = |starts: &[&str]| {
        let lines = ROOM.lines();
        let lines = lines.filter(|line| !starts.iter().any(|start| line.starts_with(start)));
        let text = lines.collect::<Vec<_>>().join("\n") + "\n";
        Survey::from_toml(&text, "room.toml")
            .unwrap_err()
            .to_string()
    };
    let error = without(&["BG", "EG", "AG", "FG", "HG"]);
    assert!(
        error.contains("corner G is not tied down: it has"),
        "{error}"
    );
    let error = without(&["AC =", "AD ="]);
    assert!(error.contains("which way is up"), "{error}");
    // The floor's and the ceiling's corners slide along the room.
    let error = without(&["flat", "AG", "BH", "CE", "DF", "AC = 4", "BD"]);
    assert!(
        error.contains("tied down") || error.contains("bend"),
        "{error}"
    );
}

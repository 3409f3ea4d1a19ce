//! Every public function of the core and of the tracker driver, and the host's
//! constructors, under hostile
//! numbers: a typed error, or a result whose every number is finite; or what its
//! documentation says instead, which its case then checks.
//!
//! The functions are read from the sources. Those that take nothing but
//! integers, truth values, text, bytes and types made of these have no number
//! that could be NaN, nor has what a constructor has checked; every other one must have
//! a case, or, of the host's, a stated
//! reason why it has none. So must every one that takes text, `FromStr`'s included, which
//! is given hostile text. Functions of other traits that are not the crates' own, such as
//! operators and conversions, are not among them.
//!
//! Those that take integers and nothing that could be NaN need a case, too, which gives them
//! borders of their types. Bytes from outside are the fuzz targets' (`tests/fuzz`).

mod colour;
mod exempt;
mod fields;
mod formulas;
mod frames;
mod geometry;
mod host;
mod integers;
mod live;
mod numbers;
mod records;
mod scenes;
mod seeing;
mod sources;
mod texts;
mod tracker;

use numbers::{Case, torment};
use shisen_tests::sizes::cases;
use sources::{Function, functions, functions_of};
use std::collections::BTreeSet;
use std::path::Path;

fn all_cases() -> Vec<(&'static str, Case)> {
    [
        geometry::CASES,
        colour::CASES,
        seeing::CASES,
        tracker::CASES,
        records::CASES,
        host::CASES,
        formulas::CASES,
        scenes::CASES,
        frames::CASES,
        live::CASES,
        fields::CASES,
    ]
    .concat()
}

fn workspace() -> Vec<Function> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent();
    let root = root.expect("the workspace");
    functions(&[
        ("core", &root.join("core")),
        ("tracker", &root.join("tracker-driver")),
        ("host", &root.join("host")),
    ])
}

/// What is wrong with a table of cases for those of these functions that take numbers.
fn gaps(functions: &[Function], cases: &[&str]) -> Vec<String> {
    gaps_of(functions, cases, ("numbers", |one| one.takes_floats))
}

/// The same for those that take something else.
fn gaps_of(
    functions: &[Function],
    cases: &[&str],
    (what, takes): (&str, fn(&Function) -> bool),
) -> Vec<String> {
    let needed: BTreeSet<&str> = functions
        .iter()
        .filter(|function| takes(function))
        .map(|function| function.name.as_str())
        .collect();
    let mut given = BTreeSet::new();
    let twice = cases.iter().filter(|name| !given.insert(**name));
    let mut gaps: Vec<String> = twice
        .map(|name| format!("`{name}` has two cases: remove one"))
        .collect();
    gaps.extend(needed.difference(&given).map(|name| {
        format!(
            "`{name}` has no case: add one to the CASES of a file in tests/tests/public_functions, \
             which gives it {what} and checks what its documentation promises"
        )
    }));
    gaps.extend(given.difference(&needed).map(|name| {
        format!("the case `{name}` is of no public function that takes {what}: rename or remove it")
    }));
    gaps
}

#[test]
fn every_function_that_takes_numbers_has_a_case() {
    let functions = workspace();
    // The walk through the modules reached all crates.
    assert!(functions.len() > 700, "{} functions", functions.len());
    let cases = all_cases();
    let exempt = exempt_by(exempt::EXEMPT);
    let cases: Vec<&str> = cases.iter().map(|(name, _)| *name).chain(exempt).collect();
    let gaps = gaps(&functions, &cases);
    assert!(gaps.is_empty(), "{}", gaps.join("\n"));
}

#[test]
fn every_function_that_takes_text_has_a_case() {
    let cases = texts::CASES.iter().map(|case| case.name);
    let cases: Vec<&str> = cases.chain(exempt_by(exempt::EXEMPT_OF_TEXT)).collect();
    let gaps = gaps_of(&workspace(), &cases, ("text", |one| one.takes_text));
    assert!(gaps.is_empty(), "{}", gaps.join("\n"));
}

#[test]
fn every_function_that_takes_integers_has_a_case() {
    let functions = workspace();
    // Those that take other numbers, too, may have both.
    let both = |name: &str| {
        let mut functions = functions.iter();
        functions.any(|one| one.name == name && one.takes_integers && one.takes_floats)
    };
    let cases = integers::CASES.iter().map(|(name, _)| *name);
    let cases = cases.filter(|name| !both(name));
    let cases: Vec<&str> = cases.chain(exempt_by(exempt::EXEMPT_OF_INTEGERS)).collect();
    let takes = |one: &Function| one.takes_integers && !one.takes_floats;
    let gaps = gaps_of(&functions, &cases, ("integers", takes));
    assert!(gaps.is_empty(), "{}", gaps.join("\n"));
}

#[test]
fn hostile_integers() {
    let mixtures = cases("mixtures a function", 500, 20_000);
    let wrong: Vec<String> = integers::CASES
        .iter()
        .filter_map(|case| integers::torment(case, mixtures).err())
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn hostile_texts() {
    let wrong: Vec<String> = texts::CASES
        .iter()
        .filter_map(|case| texts::torment(case).err())
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The functions that have a reason instead of a case, each called where it is said to be.
fn exempt_by(groups: &'static [exempt::Exempt]) -> impl Iterator<Item = &'static str> {
    groups.iter().flat_map(|group| {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent();
        let read = |file: &&str| {
            let path = root.expect("the workspace").join(file);
            std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
        };
        let text: String = group.run_by.iter().map(read).collect();
        assert!(group.why.len() > 20, "{}", group.why);
        group.names.iter().copied().inspect(move |name| {
            let (_, last) = name.rsplit_once("::").expect("a path");
            let called = text.contains(&format!("{last}(")) || text.contains(&format!("{last}::<"));
            assert!(
                called,
                "{name} is called in none of the files that are said to run it"
            );
        })
    })
}

fn tormented(cases_of: &[(&str, Case)], mixtures: usize) {
    all_tormented(cases_of, true, mixtures);
}

fn all_tormented(cases_of: &[(&str, Case)], alone: bool, mixtures: usize) {
    let wrong: Vec<String> = cases_of
        .iter()
        .enumerate()
        .filter_map(|(number, &(name, case))| {
            // One case of several functions is run once.
            let is_same = |other: &(&str, Case)| std::ptr::fn_addr_eq(other.1, case);
            if cases_of[..number].iter().any(is_same) {
                return None;
            }
            let wrong = torment(case, alone, mixtures).err()?;
            Some(format!("{name}: {wrong}"))
        })
        .collect();
    let count = wrong.len();
    assert!(wrong.is_empty(), "{count} functions:\n{}", wrong.join("\n"));
}

#[test]
fn numbers_shapes_and_capture() {
    tormented(
        geometry::CASES,
        cases("mixtures a function", 4_000, 100_000),
    );
}

#[test]
fn spectra() {
    tormented(colour::CASES, cases("mixtures a function", 4_000, 100_000));
}

#[test]
fn gazes_views_and_tracers() {
    tormented(seeing::CASES, cases("mixtures a function", 400, 10_000));
}

#[test]
fn estimates() {
    tormented(tracker::CASES, cases("mixtures a function", 2_000, 50_000));
}

#[test]
fn records_and_simulated_trackers() {
    tormented(records::CASES, cases("mixtures a function", 1_000, 20_000));
}

#[test]
fn the_hosts_constructors() {
    tormented(host::CASES, cases("mixtures a function", 200, 10_000));
}

#[test]
fn the_hosts_formulas() {
    tormented(formulas::CASES, cases("mixtures a function", 100, 5_000));
}

#[test]
fn scenes_of_the_host() {
    tormented(scenes::CASES, cases("mixtures a function", 100, 5_000));
}

#[test]
fn frames_and_reports_of_the_host() {
    // Frames take their time: each position alone is for those who have it.
    let mixtures = cases("mixtures a function", 20, 5_000);
    all_tormented(frames::CASES, mixtures == 5_000, mixtures);
}

#[test]
fn what_runs_by_itself_and_what_reads_files() {
    let mixtures = cases("mixtures a function", 20, 5_000);
    all_tormented(live::CASES, mixtures == 5_000, mixtures);
}

#[test]
fn methods_of_what_nobody_has_checked() {
    let mixtures = cases("mixtures a function", 50, 5_000);
    all_tormented(fields::CASES, true, mixtures);
}

/// The C library is no library of Rust's: its cases stand in its own tests, each
/// under the name of its function.
#[test]
fn functions_of_c_that_take_numbers_have_a_case() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent();
    let capi = root.expect("the workspace").join("core/capi");
    let functions = functions(&[("c", &capi)]);
    let text = std::fs::read_to_string(capi.join("src/hostile.rs")).expect("the cases");
    let mut cases = Vec::new();
    for function in functions.iter().filter(|function| function.takes_floats) {
        let (_, name) = function.name.rsplit_once("::").expect("a path");
        let is_case =
            text.contains(&format!("fn {name}()")) || text.contains(&format!("- `{name}`"));
        if is_case {
            cases.push(function.name.as_str());
        }
    }
    assert!(cases.len() > 10, "{cases:?}");
    let gaps = gaps(&functions, &cases);
    assert!(gaps.is_empty(), "{}", gaps.join("\n"));
}

#[test]
#[should_panic(expected = "a macro makes a public function")]
fn a_function_that_a_macro_makes_is_refused() {
    functions_of("macro_rules! made { () => { pub fn half(x: f32) -> f32 { x / 2.0 } } }");
}

#[test]
fn a_function_without_a_case_and_a_case_without_a_function_are_told() {
    let functions = functions_of("pub fn half(x: f32) -> f32 { x / 2.0 }");
    assert!(gaps(&functions, &["here half"]).is_empty());
    let [missing] = &gaps(&functions, &[])[..] else {
        panic!("one gap");
    };
    assert!(missing.starts_with("`here half` has no case"), "{missing}");
    let stale = gaps(&functions, &["here half", "here third"]);
    assert!(stale[0].contains("`here third` is of no"), "{stale:?}");
    let twice = gaps(&functions, &["here half", "here half"]);
    assert!(twice[0].contains("two cases"), "{twice:?}");
}

/// The rule by which functions need no case.
#[test]
fn only_what_holds_no_float_is_exempt() {
    let text = "
        pub enum Kind { A, B }
        pub struct Count(pub u64);
        pub struct Place { pub at: [f32; 2], kind: Kind }
        pub enum Either { Kind(Kind), Place { place: Place } }
        pub type Pixel = u32;
        pub type Light = [f32; 3];
        pub struct Loop<'a> { next: Option<&'a Loop<'a>>, count: Count }
        struct Inside;
        mod hidden { pub fn unseen(x: f32) {} pub fn seen(x: f32) {} pub trait Sealed {} }
        pub use hidden::seen;
        #[cfg(test)] mod tests { pub fn test_only(x: f32) {} }
        pub fn integers(a: u8, b: &[u8], c: &str, d: Kind, e: &Count, f: Option<bool>) {}
        pub fn looped(a: &Loop<'_>) {}
        pub fn alias(a: Pixel) {}
        pub fn file(a: &Path, b: &mut dyn FnMut(f32) -> io::Result<()>, c: impl Write) {}
        pub fn float(a: f32) {}
        pub fn slice(a: &[f64]) {}
        pub fn light(a: Light) {}
        pub fn read(a: impl FnMut(&Path) -> io::Result<f32>) {}
        pub fn record(a: Place) {}
        pub fn variant(a: &Either) {}
        pub fn foreign(a: Vec3) {}
        pub fn generic<T>(a: T) {}
        pub fn sealed<T: Sealed>(a: T) {}
        pub fn taker(a: impl FnMut(f32) -> u8, b: &mut dyn FnMut(Place)) {}
        pub fn giver(a: impl FnMut(u8) -> f32) {}
        pub(crate) fn inner(a: f32) {}
        impl Count {
            pub fn same(self, other: Self) {}
            pub fn scaled(self, by: f32) {}
            pub(super) fn inner(self, by: f32) {}
            fn own(self, by: f32) {}
        }
        impl Inside { pub fn inside(a: f32) {} }
        impl Place { pub fn only_itself(&self) {} pub fn with(self, other: Self) {} }
        pub struct Bare { pub at: f32 }
        impl Bare { pub fn unchecked(&self) {} }
        impl Either { pub fn unchecked(&self) {} }
        pub trait Open { fn open(&self, a: f32); fn shut(&self, a: u8); }
    ";
    let functions = functions_of(text);
    let of = |floats: bool| {
        let names = functions.iter().filter(|f| f.takes_floats == floats);
        names
            .map(|f| f.name.trim_start_matches("here "))
            .collect::<Vec<_>>()
    };
    assert_eq!(
        of(false),
        [
            "integers",
            "looped",
            "alias",
            "file",
            "sealed",
            "taker",
            "Count::same",
            "Place::only_itself",
            "Open::shut"
        ]
    );
    assert_eq!(
        of(true),
        [
            "hidden::seen",
            "float",
            "slice",
            "light",
            "read",
            "record",
            "variant",
            "foreign",
            "generic",
            "giver",
            "Count::scaled",
            "Place::with",
            "Bare::unchecked",
            "Either::unchecked",
            "Open::open"
        ]
    );
}

/// The rule by which functions need a text.
#[test]
fn text_is_found_in_what_wraps_it() {
    let text = "
        pub struct Name(String);
        pub struct Hidden(u8);
        pub fn plain(a: &str) {}
        pub fn owned(a: String) {}
        pub fn into(a: impl Into<String>, b: f32) {}
        pub fn pairs(a: &[(&str, String)]) {}
        pub fn maybe(a: Option<&str>) {}
        pub fn checked(a: &Name) {}
        pub fn bytes(a: &[u8], b: u32, c: &Path) {}
        pub fn gives() -> String {}
        impl FromStr for Hidden { type Err = Name; fn from_str(a: &str) -> Result<Self, Name> {} }
        impl From<&str> for Name { fn from(a: &str) -> Self {} }
        impl FromStr for Inside { fn from_str(a: &str) -> Result<Self, Name> {} }
    ";
    let functions = functions_of(text);
    let with_text = functions.iter().filter(|function| function.takes_text);
    let names = with_text.map(|function| function.name.trim_start_matches("here "));
    assert_eq!(
        names.collect::<Vec<_>>(),
        [
            "plain",
            "owned",
            "into",
            "pairs",
            "maybe",
            "Hidden::from_str"
        ]
    );
}

//! Public functions under hostile texts.

use super::numbers::{finite, finite_or_error, message};
use glam::{DVec2, DVec3};
use shisen::cave::{BuiltInCave, Cave, Wall};
use shisen::dashboard::Canvas;
use shisen::effects::Effects;
use shisen::live::FrameBudget;
use shisen::look::{Point, ViewDirection};
use shisen::mesh::TriangleMesh;
use shisen::picture::Picture;
use shisen::scene::Scene;
use shisen::scene::builtin::PaperScene;
use shisen::scene::file::material_names;
use shisen::selftest::selected;
use shisen::spectrum::medium;
use shisen::stereo::Stereo;
use shisen::tracker::calibration::CalibrationFile;
use shisen::tracker::{ProtocolSpec, Spec, features};
use shisen::warp::{Aim, Lens, Projector, Throw};
use shisen_core::scene::EffectSet;
use shisen_core::spectrum::Medium;
use shisen_tracker::head::fastrak::Status;
use shisen_tracker::hid::device::Device;
use shisen_tracker::protocol::Protocol;
use shisen_tracker::serial::Serial;
use std::error::Error;
use std::panic::catch_unwind;
use std::path::Path;
use std::str::FromStr;
use std::{fs, io};

/// A use of one public function.
pub(super) struct Case {
    /// `crate module::Type::name`.
    pub(super) name: &'static str,
    /// A text that it is made for.
    sane: &'static str,
    /// Gives it a text, and checks what comes of it.
    run: fn(&str),
}

/// `name` given what is `sane` and what is not.
macro_rules! cases {
    ($($name:literal, $sane:expr => $run:expr;)*) => {
        &[$(Case { name: $name, sane: $sane, run: $run }),*]
    };
}

pub(super) const CASES: &[Case] = cases! {
    "core scene::effects::EffectSet::named", "reflection" => |text| {
        if let Some(found) = EffectSet::named(text) {
            assert!(found.names().eq([text]), "{found:?}");
        }
    };
    "core spectrum::named::Medium::named", "quartz-o" => |text| {
        if let Some(found) = Medium::named(text) {
            finite(&found);
        }
    };
    "tracker protocol::Protocol::named", "fastrak" => |text| {
        assert_eq!(Protocol::named(text).is_some(), Protocol::NAMES.contains(&text));
    };
    "tracker head::fastrak::Status::from_text", "21S3F9" => |text| {
        if let Some(found) = Status::from_text(text) {
            assert!(text.starts_with(&format!("2{}S", found.station)), "{found:?}");
        }
    };
    "tracker serial::Serial::open", NOWHERE => |path| {
        assert!(Serial::open(path, 115_200).is_err());
    };
    "tracker hid::device::Device::open", NOWHERE => |path| {
        assert!(Device::open(path).is_err());
    };
    "host tracker::hid::features", NOWHERE => |path| {
        assert!(features(path).is_err());
    };
    "host cave::BuiltInCave::from_str", "three-wall" => parsed::<BuiltInCave>;
    "host effects::Effects::from_str", "auto,-reflection" => parsed::<Effects>;
    "host live::budget::FrameBudget::from_str", "33.5ms" => parsed::<FrameBudget>;
    "host look::ViewDirection::from_str", "-30,12.5" => |text| {
        parsed::<ViewDirection>(text);
        if let Ok(found) = text.parse::<ViewDirection>() {
            finite(&found);
        }
    };
    "host look::Point::from_str", "0.1,1.6,-2" => |text| {
        parsed::<Point>(text);
        if let Ok(found) = text.parse::<Point>() {
            finite(&found);
        }
    };
    "host scene::builtin::PaperScene::from_str", "A" => parsed::<PaperScene>;
    "host stereo::Stereo::from_str", "anaglyph" => parsed::<Stereo>;
    "host tracker::protocol::ProtocolSpec::from_str", "fastrak" => parsed::<ProtocolSpec>;
    "host tracker::protocol::ProtocolSpec::named", "fastrak" => |text| {
        said(ProtocolSpec::named(text));
    };
    "host tracker::spec::read::Spec::from_str", "serial:/dev/none?protocol=flock&baud=9600&head=2"
        => parsed::<Spec>;
    "host spectrum::medium", "quartz-o" => |text| {
        finite_or_error(medium(text));
    };
    "host scene::file::material_names", SCENE => |text| {
        let names = material_names(text);
        assert!(text.contains("materials") || names.is_empty(), "{names:?}");
    };
    "host scene::file::Scene::from_toml", SCENE => |text| {
        for (text, name) in [(text, "a.toml"), (SCENE, text)] {
            let square = |_: &_| Ok::<_, io::Error>(TriangleMesh::square());
            said(Scene::from_toml(text, name, Path::new("no such folder"), square));
        }
    };
    "host cave::file::Cave::from_toml", WALLS => |text| {
        for (text, name) in [(text, "a.toml"), (WALLS, text)] {
            said(Cave::from_toml(text, name, [8; 2]));
        }
    };
    "host cave::Wall::new", "front" => |text| {
        let [a, b, c] = [[-1.0, 0.0, -1.5], [1.0, 0.0, -1.5], [-1.0, 2.0, -1.5]].map(DVec3::from);
        said(Wall::new(text, a, b, c, [64, 48]));
    };
    "host warp::projector::Projector::new", "one" => |text| {
        let aim = Aim::Look {
            look: DVec3::NEG_Z,
            up: DVec3::Y,
        };
        let lens = Lens {
            throw: Throw::Degrees(40.0),
            vertical_degrees: None,
            shift: DVec2::ZERO,
        };
        said(Projector::new(text, DVec3::ZERO, aim, lens, [8, 8]));
    };
    "host warp::projector::Projector::from_toml", PROJECTOR => |text| {
        said(Projector::from_toml(text, "a.toml"));
        said(Projector::from_toml("", text));
    };
    "host tracker::calibration::CalibrationFile::from_toml", CALIBRATION => |text| {
        said(CalibrationFile::from_toml(text, "a.toml"));
        said(CalibrationFile::from_toml("", text));
    };
    "host selftest::selected", "box-beside-the-ray" => |text| {
        assert!(selected(text).all(|case| case.name.contains(text)));
    };
    "host dashboard::canvas::Canvas::write", "Shisen 0.1" => |text| {
        let mut canvas = Canvas::new(32, 16);
        let letters = text.chars().count() as u32;
        assert_eq!(canvas.write(3, 4, text, 0xFF_FF_FF), 3 + 8 * letters);
        assert_eq!(canvas.write(u32::MAX, u32::MAX, text, 0xFF_FF_FF), u32::MAX);
    };
    "host dashboard::canvas::Canvas::write_png", "Description" => |text| {
        let canvas = Canvas::new(2, 2);
        described(text, |path, about| canvas.write_png(path, about));
    };
    "host picture::Picture::write_png", "Description" => |text| {
        described(text, |path, about| black().write_png(path, about));
    };
    "host picture::Picture::write_png_with_alpha", "Description" => |text| {
        described(text, |path, about| black().write_png_with_alpha(path, about));
    };
    "host picture::Picture::write_exr", "Description" => |text| {
        described(text, |path, about| black().write_exr(path, about));
    };
};

/// No device, whatever stands in place of parts of it.
pub(super) const NOWHERE: &str = "/no/such/device0";

const SCENE: &str = r#"
[materials.chrome]
mirror = [0.8, 0.8, 0.8]
[[object]]
sphere = { radius = 0.5 }
material = "chrome"
position = [0, 0, -4]
"#;

pub(super) const WALLS: &str = r#"
[[wall]]
name = "front"
lower_left = [-1, 0, -1.5]
lower_right = [1, 0, -1.5]
upper_left = [-1, 2, -1.5]
"#;

const PROJECTOR: &str = r#"
name = "back"
position = [0.2, -1.2, 2]
look = [0, 0.6, -1]
up = [0, 1, 0]
horizontal_degrees = 60
resolution = [1920, 1200]
"#;

const CALIBRATION: &str = r#"
model = "affine"
head = [0, 0, 0]
[screen]
corner = [-0.5, 0.5, -1]
size = [1, 1]
[[target]]
direction = [0.2, 0, -1]
combined = [0.7, 0.5]
[[target]]
direction = [-0.2, 0, -1]
combined = [0.3, 0.5]
[[target]]
direction = [0, 0.2, -1]
combined = [0.5, 0.3]
"#;

/// A result, or an error that says something.
#[track_caller]
fn said<T, E: Error>(result: Result<T, E>) {
    if let Err(error) = result {
        assert!(!error.to_string().is_empty());
    }
}

/// What reads a text that stands for something.
fn parsed<T: FromStr<Err: Error>>(text: &str) {
    said(text.parse::<T>());
}

fn black() -> Picture {
    Picture::from_pixels(1, 1, vec![[0.0; 4]]).expect("a picture")
}

/// A file about which a text stands in it, or by which another text is named, is there
/// whole or not at all.
fn described<E: Error>(text: &str, write: impl Fn(&Path, &[(&str, String)]) -> Result<(), E>) {
    let folder = tempfile::tempdir().expect("a folder");
    for about in [("Title", text.to_owned()), (text, "of it".to_owned())] {
        let path = folder.path().join("a");
        let written = write(&path, &[about]);
        assert_eq!(written.is_ok(), path.exists());
        said(written);
        drop(fs::remove_file(path));
    }
}

/// What breaks readers of text: nothing, what is not seen, numbers that are none or that no
/// type holds, more than one byte a letter, and what means something in files.
const HOSTILE: [&str; 34] = [
    "",
    " ",
    "\0",
    "\n",
    "\r\n",
    "\t",
    "\u{feff}",
    "\u{202e}",
    "ä",
    "日本",
    "🦀",
    "é",
    "NaN",
    "nan",
    "-nan",
    "inf",
    "-inf",
    "infinity",
    "-0",
    "0",
    "-1",
    "+1",
    "1e400",
    "-1e400",
    "1e-400",
    "1e308",
    "18446744073709551616",
    "-9223372036854775809",
    "0x7f",
    "1_0",
    ",",
    ":",
    "=",
    "\"",
];

/// Gives a case its own text, each hostile one alone, before, behind and in place of each
/// number of its own, its own cut off at each letter, and very long ones.
pub(super) fn torment(case: &Case) -> Result<(), String> {
    let sane = case.sane;
    let mut texts = vec![sane.to_owned()];
    let cuts = sane.char_indices().map(|(at, _)| sane[..at].to_owned());
    texts.extend(cuts);
    for hostile in HOSTILE {
        texts.extend([
            hostile.to_owned(),
            format!("{hostile}{sane}"),
            format!("{sane}{hostile}"),
        ]);
        let digits = |c: char| c.is_ascii_digit() || c == '.';
        for (at, number) in sane.match_indices(digits) {
            let (before, after) = (&sane[..at], &sane[at + number.len()..]);
            let (before, after) = (
                before.trim_end_matches(digits),
                after.trim_start_matches(digits),
            );
            texts.push(format!("{before}{hostile}{after}"));
        }
    }
    for piece in ["a", "1", "[", "(", "\u{1f980}", "\0", ", ", sane] {
        texts.push(piece.repeat(20_000 / piece.len().max(1)));
    }
    texts.dedup();
    for text in texts {
        if let Err(panic) = catch_unwind(|| (case.run)(&text)) {
            let message = message(&*panic);
            let given: String = text.chars().take(200).collect();
            return Err(format!("{}: {message}\n    of {given:?}", case.name));
        }
    }
    Ok(())
}

/// Each case begins with what its function takes, or all others would be refused for one
/// reason.
#[test]
fn sane_texts_are_taken() {
    assert!(EffectSet::named("reflection").is_some());
    assert!(Medium::named("quartz-o").is_some() && medium("quartz-o").is_ok());
    assert!(Protocol::named("fastrak").is_some());
    assert!(Status::from_text("21S3F9").is_some());
    let sane = |name: &str| {
        let case = CASES.iter().find(|case| case.name.ends_with(name));
        case.expect("a case").sane
    };
    assert!(sane("BuiltInCave::from_str").parse::<BuiltInCave>().is_ok());
    assert!(sane("Effects::from_str").parse::<Effects>().is_ok());
    assert!(sane("FrameBudget::from_str").parse::<FrameBudget>().is_ok());
    assert!(
        sane("ViewDirection::from_str")
            .parse::<ViewDirection>()
            .is_ok()
    );
    assert!(sane("Point::from_str").parse::<Point>().is_ok());
    assert!(sane("PaperScene::from_str").parse::<PaperScene>().is_ok());
    assert!(sane("Stereo::from_str").parse::<Stereo>().is_ok());
    assert!(
        sane("ProtocolSpec::from_str")
            .parse::<ProtocolSpec>()
            .is_ok()
    );
    assert!(sane("::Spec::from_str").parse::<Spec>().is_ok());
    let square = |_: &_| Ok::<_, io::Error>(TriangleMesh::square());
    let scene = Scene::from_toml(SCENE, "a.toml", Path::new(""), square);
    assert_eq!(material_names(SCENE), ["chrome"]);
    assert!(scene.is_ok(), "{:?}", scene.err());
    let walls = Cave::from_toml(WALLS, "a.toml", [8; 2]);
    assert!(walls.is_ok(), "{:?}", walls.err());
    let projector = Projector::from_toml(PROJECTOR, "a.toml");
    assert!(projector.is_ok(), "{:?}", projector.err());
    let calibration = CalibrationFile::from_toml(CALIBRATION, "a.toml");
    assert!(calibration.is_ok(), "{:?}", calibration.err());
    assert_eq!(selected(sane("selected")).count(), 1);
}

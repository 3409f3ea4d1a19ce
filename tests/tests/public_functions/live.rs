//! What runs by itself under the same numbers: the live loop, whose eyes and looks are
//! anybody's, what shows it, and what reads files.

use super::numbers::{Case, Numbers, finite, finite_or_error};
use crate::scene_fuzz::scene_of;
use glam::{Quat, Vec3};
use shisen::bake::Baked;
use shisen::cave::{BuiltInCave, Cave, Eye, Viewer};
use shisen::dashboard::{About, Canvas, Dashboard, Frame, Latency, Status, ViewName};
use shisen::live::{
    self, Alone, Done, Engine, FrameBudget, FrameRecord, Gathered, LiveTracker, Look, Order,
    Purpose, SessionError, SessionSettings, Share, Stage, SwapError, SwapLock, Waits, eyes_of,
    with_engine,
};
use shisen::picture::Picture;
use shisen::render::{Observer, Options};
use shisen::scene::Scene;
use shisen::scene::builtin::grid;
use shisen::stereo::Stereo;
use shisen::tracker::calibration::{Calibrated, estimation};
use shisen::tracker::{Feed, Spec};
use shisen_core::frame::{LevelOfDetail, Spectrum, Tile};
use shisen_core::gaze::{Gaze, HeadPose, LineOfSight, VisualField};
use shisen_tracker::clock::{ClockConfig, ClockEstimator};
use shisen_tracker::estimate::GazeEstimator;
use std::fmt::Write as _;
use std::io;
use std::path::Path;
use std::sync::{Arc, LazyLock};

static SCENE: LazyLock<Baked<8>> = LazyLock::new(|| Baked::new(&grid(2.0)).expect("a scene"));

fn room(side: u32) -> Cave {
    Cave::built_in(BuiltInCave::ThreeWall, [side; 2]).expect("a room")
}

pub(super) fn look(n: &mut Numbers) -> Look {
    Look {
        head: HeadPose {
            position: n.vec3([0.0, 1.6, 0.0]),
            orientation: n.quat(),
        },
        position: n.vec3([0.0, 1.6, 0.0]),
        forward: n.vec3([0.1, -0.2, -1.0]),
        up: n.vec3([0.0, 1.0, 0.0]),
        widen: n.next(0.01),
    }
}

/// An eye that is where it likes, and sees as a look says, if that is one.
fn eye(n: &mut Numbers, look: &Look) -> Observer {
    let sight = LineOfSight::new(look.position, look.forward, look.up).ok();
    Observer {
        lod: sight.map(|sight| LevelOfDetail::new(Gaze::new(sight, VisualField::PAPER))),
        ..Observer::new(Eye::Left, n.dvec3([0.0, 1.6, 0.0]))
    }
}

/// A stage whose eyes are the next numbers, and that looks at what it is handed.
struct Theatre<'n> {
    numbers: &'n mut Numbers,
    shown: usize,
}

impl Stage<8> for Theatre<'_> {
    fn observe(&mut self, look: &Look, eyes: &mut Vec<Observer>) -> bool {
        *eyes = vec![eye(self.numbers, look)];
        self.numbers.are_sane()
    }

    fn gaze(&mut self) -> Option<Vec3> {
        Some(self.numbers.vec3([0.2, 0.0, -1.0]))
    }

    fn present(&mut self, engine: &Engine<'_, '_, 8>, _: &Look, _: &[Observer]) {
        for picture in engine.pictures().expect("pictures") {
            finite(&picture.pixels);
        }
        self.shown += 1;
    }

    fn after(&mut self, record: &FrameRecord) -> bool {
        finite(record);
        true
    }
}

/// Orders two frames, of two looks.
struct Orders(Vec<Look>);

impl SwapLock for Orders {
    fn share(&self) -> Share {
        Share::ALL
    }

    fn order(&mut self, _: &Order) -> Result<(), SwapError> {
        Ok(())
    }

    fn obey(&mut self) -> Result<Option<Order>, SwapError> {
        Ok(self.0.pop().map(|look| Order {
            frame: self.0.len() as u64,
            look,
            rung: 0,
            steps: Some(100_000),
            whole_fovea: false,
            purpose: Purpose::Shown,
        }))
    }

    fn gather(&mut self, own: &Done) -> Result<Gathered, SwapError> {
        Ok(Gathered {
            all: own.clone(),
            slowest: own.clone(),
        })
    }

    fn swap(&mut self, _: u64) -> Result<(), SwapError> {
        Ok(())
    }

    fn end(&mut self) -> Result<(), SwapError> {
        Ok(())
    }

    fn waits(&self) -> Option<Waits<'_>> {
        None
    }
}

/// Does something with an engine and a stage: how it ended, and how much was shown.
fn played(
    n: &mut Numbers,
    play: impl FnOnce(&mut Engine<'_, '_, 8>, &mut Theatre<'_>) -> Result<(), SessionError>,
) {
    let room = room(3);
    let place = Viewer::default().eye(Eye::Left);
    let eyes = [Observer::new(Eye::Left, place)];
    let options = Options {
        threads: 1,
        ..Options::default()
    };
    let scene = (SCENE.scene(), Spectrum::default());
    let of = |engine: &mut Engine<'_, '_, 8>| {
        let mut stage = Theatre {
            numbers: n,
            shown: 0,
        };
        let ended = play(engine, &mut stage);
        let (shown, sane) = (stage.shown, stage.numbers.are_sane());
        match ended {
            Ok(()) => assert!(shown > 0),
            Err(error) => assert!(!sane && !error.to_string().is_empty(), "{error}"),
        }
    };
    with_engine(scene, &room, &eyes, &options, None, Share::ALL, of).expect("an engine");
}

/// Frames that another machine orders.
fn following(n: &mut Numbers) {
    let orders = [look(n), look(n)];
    played(n, |engine, stage| {
        live::follow(engine, stage, &mut Orders(orders.into()))
    });
}

/// Frames of a simulated viewer, whose head rests anywhere.
fn session(n: &mut Numbers) {
    let spec: Spec = "mock:rate=1000".parse().expect("a tracker");
    let feed = Feed::open(&spec).expect("a feed");
    let head = HeadPose {
        position: n.vec3([0.0, 1.6, 0.0]),
        orientation: Quat::IDENTITY,
    };
    let config = estimation(&spec, feed.senses(&spec), head, None);
    let Some(estimator) = finite_or_error(GazeEstimator::new(config)) else {
        assert!(!n.are_sane());
        return;
    };
    let clock = ClockEstimator::new(ClockConfig::default()).expect("a clock");
    let tracker = LiveTracker::start(feed, clock, estimator, |_| {}).expect("a thread");
    let settings = SessionSettings {
        hz: 1_000,
        budget: FrameBudget::Steps(50_000),
        frames: Some(2),
        ..SessionSettings::default()
    };
    played(n, |engine, stage| {
        live::run(engine, &tracker, &settings, stage, &mut Alone).map(|report| {
            finite(&report);
        })
    });
}

/// A frame of anything, as it is shown to who watches.
fn dashboard(n: &mut Numbers) {
    let room = room(8);
    let look = look(n);
    let eyes = vec![eye(n, &look)];
    let light = [0.1, 0.5, 0.9, 1.0].map(|light| n.next(light));
    let pictures = eyes_of(&room, &eyes, Share::ALL)
        .map(|_| Picture::from_pixels(8, 8, vec![light; 64]).expect("a picture"));
    let tile = Tile {
        x: 0,
        y: 0,
        width: 8,
        height: 8,
    };
    let frame = Frame {
        about: Arc::new(About {
            scene: "A".to_owned(),
            lod: "paper".to_owned(),
            fill: "background".to_owned(),
            hz: 60,
            budget: "off".to_owned(),
        }),
        pictures: pictures.collect(),
        eyes,
        head: look.head,
        tiles: vec![(0, tile)],
        record: FrameRecord {
            position: look.position.to_array(),
            forward: look.forward.to_array(),
            state: "fresh",
            ..FrameRecord::default()
        },
        latencies: vec![Latency {
            milliseconds: Some(n.next(20.0)),
            late: false,
        }],
    };
    let [width, height] = Dashboard::SIZE;
    let mut canvas = Canvas::new(width, height);
    for (view, stereo) in [
        (ViewName::Net, Stereo::Anaglyph),
        (ViewName::Viewer, Stereo::SideBySide),
    ] {
        let mut dashboard = Dashboard::new(&room, stereo).expect("a dashboard");
        let status = Status::default();
        dashboard.wait(&mut canvas, &status);
        (dashboard.view, dashboard.levels, dashboard.tiles) = (view, true, true);
        dashboard
            .draw(&mut canvas, &frame, &status, 0)
            .expect("memory");
        for (x, y) in [(width / 4, height / 2), (width / 2, height / 3)] {
            if let Some(direction) = dashboard.direction(x, y, &frame) {
                assert!(direction.is_normalized(), "{direction}");
            }
        }
    }
}

/// As TOML has a number.
fn toml(number: f64) -> String {
    if number.is_nan() {
        "nan".to_owned()
    } else {
        format!("{number:?}")
    }
}

/// A scene file with other numbers; whether it was one.
fn scene(n: &mut Numbers, read: impl Fn(&str) -> bool) {
    let text = scene_of(|text| {
        let Ok(sane) = text.parse::<f64>() else {
            return text.to_owned(); // A dot between names.
        };
        let number = n.wide(sane);
        let same = number.to_bits() == sane.to_bits();
        if same { text.to_owned() } else { toml(number) }
    });
    assert!(read(&text) || !n.are_sane(), "{text}");
}

pub(super) const CASES: &[(&str, Case)] = &[
    ("host dashboard::Dashboard::direction", dashboard),
    ("host dashboard::Dashboard::draw", dashboard),
    ("host dashboard::Dashboard::new", dashboard),
    ("host dashboard::Dashboard::wait", dashboard),
    ("host live::session::Stage::after", session),
    ("host live::session::Stage::is_over", session),
    ("host live::session::Stage::observe", following),
    ("host live::session::Stage::present", following),
    ("host live::session::follow", following),
    ("host live::session::run", session),
    ("host live::swap::SwapLock::order", session),
    ("host live::tracking::LiveTracker::start", session),
    ("host tracker::feed::Feed::open", session),
    ("host tracker::feed::Feed::senses", session),
    ("host tracker::feed::simulated", session),
    ("host scene::file::Scene::from_toml", |n| {
        scene(n, crate::scene_fuzz::is_scene);
    }),
    ("host scene::file::Scene::load", |n| {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.toml");
        scene(n, |text| {
            std::fs::write(&path, text).expect("a file");
            let square = |_: &_| Ok::<_, io::Error>(shisen::mesh::TriangleMesh::square());
            let read = Scene::load(&path, square);
            // What is wrong with it is said as of the same text.
            assert_eq!(
                read.is_ok(),
                Scene::from_toml(text, "a.toml", folder.path(), square).is_ok()
            );
            finite_or_error(read).is_some()
        });
    }),
    ("host tracker::calibration::Calibrated::load", calibration),
    ("host tracker::calibration::device_name", calibration),
];

/// A file of what was looked at and what a tracker said.
fn calibration(n: &mut Numbers) {
    let mut list = |numbers: &[f64]| {
        let list: Vec<String> = numbers.iter().map(|&one| toml(n.wide(one))).collect();
        format!("[{}]", list.join(", "))
    };
    let mut text = format!(
        "model = \"affine\"\nhead = {}\n[room_from_tracker]\nposition = {}\norientation = {}\n\
         [screen]\ncorner = {}\nright = {}\ndown = {}\nsize = {}\n",
        list(&[0.0, 1.6, 0.0]),
        list(&[0.0, 2.0, -1.0]),
        list(&[0.0, 0.0, 0.0, 1.0]),
        list(&[-0.3, 1.8, -0.6]),
        list(&[1.0, 0.0, 0.0]),
        list(&[0.0, -1.0, 0.0]),
        list(&[0.6, 0.4]),
    );
    for (x, y) in [(0.0, 0.0), (0.3, 0.0), (0.0, 0.3), (-0.3, 0.1), (0.1, -0.3)] {
        let (direction, combined) = (list(&[x, y, -1.0]), list(&[x, y]));
        write!(
            text,
            "[[target]]\ndirection = {direction}\ncombined = {combined}\n"
        )
        .expect("text");
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("calibration.toml");
    std::fs::write(&path, &text).expect("a file");
    let spec: Spec = "mock".parse().expect("a tracker");
    let read = finite_or_error(Calibrated::load(Path::new(&path), &spec));
    assert!(read.is_some() || !n.are_sane(), "{text}");
}

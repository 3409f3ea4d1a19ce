//! What is rendered, drawn, warped and reported of under the same numbers: an eye
//! that is nowhere is refused, and what comes of the others is finite.

use super::host::{dome, wall};
use super::numbers::{Case, Numbers, finite, finite_or_error};
use super::seeing::pixels_of;
use super::tracker::a_sample;
use glam::{DVec2, DVec3, Vec2, Vec3};
use serde_json::Map;
use shisen::bake::Baked;
use shisen::bake::tree::{Bounds, BuildEffort, build};
use shisen::cave::{BuiltInCave, Cave, Eye};
use shisen::dashboard::Coordinates;
use shisen::dome::{Mirror, Projection, local_optima, optimum};
use shisen::effects::{self, Effects};
use shisen::live::{Engine, Quality, Share, eyes_of, with_engine};
use shisen::lod::{Coverage, OutsideDifference, levels, polygons, sampling};
use shisen::material::Material;
use shisen::mesh::TriangleMesh;
use shisen::overview::net::unfold;
use shisen::overview::viewer::{self, ViewerCamera};
use shisen::picture::Picture;
use shisen::render::{self, CaptureOptions, Filling, Frame, Observer, Options, RenderError};
use shisen::scene::builtin::grid;
use shisen::scene::camera::DomeCamera;
use shisen::simplify::{Ladder, PolygonLevels};
use shisen::stereo::Stereo;
use shisen::tracker::calibration::{CalibrationFile, Gatherer, SeenTarget, TimedTarget};
use shisen::tracker::{Recorder, Recording};
use shisen::tradeoff::{
    self, Build, Comparison, Limit, Measure, PictureDifference, Point, Report, Section, Sight,
};
use shisen::warp::{Aim, Lens, Nodes, Projector, Throw, Warp, bourke, mpcdi};
use shisen_core::Simd;
use shisen_core::frame::{DomeProjection, LevelOfDetail, Renderer, Settings, Spectrum, View};
use shisen_core::gaze::{Gaze, LineOfSight, VisualField};
use shisen_tracker::decoder::Event;
use shisen_tracker::estimate::EstimatorConfig;
use shisen_tracker::time::Micros;
use std::collections::HashMap;
use std::io::Cursor;
use std::sync::{LazyLock, Mutex, PoisonError};

/// Built once: what is tried is who looks at it.
static SCENE: LazyLock<Baked<8>> = LazyLock::new(|| Baked::new(&grid(2.0)).expect("a scene"));

fn options() -> Options {
    Options {
        threads: 1,
        ..Options::default()
    }
}

fn room() -> Cave {
    Cave::built_in(BuiltInCave::ThreeWall, [3; 2]).expect("a room")
}

/// An eye whose line of sight starts somewhere and goes anywhere.
fn eye(n: &mut Numbers) -> Observer {
    let place = n.dvec3([0.1, 1.6, 0.0]);
    Observer {
        lod: lod(n),
        ..Observer::new(Eye::Left, place)
    }
}

fn lod(n: &mut Numbers) -> Option<LevelOfDetail> {
    let (from, forward) = (n.vec3([0.0, 1.6, 0.0]), n.vec3([0.1, -0.2, -1.0]));
    let sight = finite_or_error(LineOfSight::new(from, forward, Vec3::Y))?;
    Some(LevelOfDetail::new(Gaze::new(sight, VisualField::PAPER)))
}

/// 8×8 pixels of a wall ahead.
fn view() -> View {
    let (right, down) = (Vec3::X / 4.0, Vec3::NEG_Y / 4.0);
    let first = Vec3::new(-0.9, 0.9, -1.0);
    View::new(Vec3::ZERO, first, right, down, [8, 8]).expect("a view")
}

fn shows_light(picture: &Picture) {
    finite(&picture.pixels);
}

/// A frame that is finite, or a refusal of eyes that see none.
fn check(frame: Result<Frame, RenderError>, sane: bool) {
    match frame {
        Ok(frame) => frame
            .pictures
            .iter()
            .for_each(|one| shows_light(&one.picture)),
        Err(error) => assert!(!sane && !error.to_string().is_empty(), "{error}"),
    }
}

/// 2×2 pixels of any light.
pub(super) fn picture(n: &mut Numbers) -> Picture {
    let pixels = (0..4).map(|_| [0.1, 0.5, 0.9, 1.0].map(|light| n.next(light)));
    Picture::from_pixels(2, 2, pixels.collect()).expect("a picture")
}

/// Frames of an engine that was made for one eye, of another.
fn engine(n: &mut Numbers) {
    let room = room();
    let (first, then) = (eye(n), eye(n));
    let capture = Some(CaptureOptions {
        size: 16,
        level: n.next(0.34),
        steps: None,
    });
    let quality = Quality {
        faces: n.next(1.0),
        field: n.next(1.0),
        ..Quality::FULL
    };
    let scene = (SCENE.scene(), Spectrum::default());
    let of = |engine: &mut Engine<'_, '_, 8>| {
        for eye in [first, then] {
            if engine.render(&[eye], &quality, Some(100_000)).is_err() {
                continue;
            }
            let whole = engine.render_whole_fovea(&[eye], &quality, Some(0));
            let is_whole = whole.is_ok_and(|frame| !frame.unfinished_fovea);
            assert!(is_whole || eye.lod.is_none());
            let mut pictures = engine.pictures().expect("pictures");
            engine.copy(&mut pictures);
            engine.copy_over(&mut pictures);
            pictures.iter().for_each(shows_light);
        }
    };
    let made = with_engine(scene, &room, &[first], &options(), capture, Share::ALL, of);
    if let Err(error) = made {
        assert!(!n.are_sane() && !error.to_string().is_empty(), "{error}");
    }
    // Which pictures there are is no matter of where eyes are.
    assert_eq!(eyes_of(&room, &[first, then], Share::ALL).count(), 6);
}

/// A projector and a dome, with what of its light the dome shows.
fn warped(n: &mut Numbers, write: impl Fn(&Warp<'_>) -> Vec<u8>) {
    let lens = Lens {
        throw: Throw::Degrees(n.wide(40.0)),
        vertical_degrees: Some(n.wide(30.0)),
        shift: DVec2::new(n.wide(0.0), n.wide(0.0)),
    };
    let aim = Aim::Look {
        look: n.dvec3([0.0, 1.0, -1.0]),
        up: n.dvec3([0.0, 1.0, 0.0]),
    };
    let projector = Projector::new("one", n.dvec3([0.0, 1.0, 0.0]), aim, lens, [64, 48]);
    let (Some(projector), Some(dome)) = (finite_or_error(projector), dome(n)) else {
        return;
    };
    for nodes in [Nodes::Corners, Nodes::Centres] {
        if let Some(warp) = finite_or_error(Warp::new(&dome, &projector, [4, 3], nodes)) {
            let written = write(&warp);
            let text = String::from_utf8_lossy(&written);
            assert!(!written.is_empty() && !text.contains("NaN"), "{text}");
        }
    }
}

/// A report whose numbers are the next ones.
fn report(n: &mut Numbers) -> Report {
    let point = |name: &str, n: &mut Numbers| Point {
        series: "one",
        name: name.to_owned(),
        settings: Map::new(),
        errors: vec![Some(n.wide(0.5)), None],
        seconds: n.wide(0.01),
        spread: n.wide(0.001),
        of_details: vec![n.wide(0.1), n.wide(0.2)],
        steps: Some(1_000),
        best_by_time: true,
        best_by_steps: true,
    };
    let label = |id| Measure { id, label: id };
    let points = ["first", "second", "third"].map(|name| point(name, n));
    let limit = n.wide(0.1);
    let comparison = |logarithmic: bool| Comparison {
        id: "all",
        title: "All",
        about: String::new(),
        measures: vec![label("off"), label("none")],
        limit: Limit {
            error: limit,
            because: "a bound",
        },
        other_limit: logarithmic.then_some(Limit {
            error: limit,
            because: "another",
        }),
        choice: "Choose one.".to_owned(),
        points: points.to_vec(),
        charts: Vec::new(),
        logarithmic,
    };
    Report {
        version: "0",
        quick: true,
        threads: 1,
        simd: "portable".to_owned(),
        build: Build::this(),
        mesh: "quadruped".to_owned(),
        seconds: n.wide(60.0),
        sections: vec![Section {
            id: "gaze",
            title: "Gaze",
            about: String::new(),
            choice: String::new(),
            comparisons: [false, true].map(comparison).into(),
            hard_cases: Vec::new(),
            tiles: Vec::new(),
            pictures: Vec::new(),
        }],
    }
}

/// The best mirrors are searched for: once for each ratio that is one.
fn searched(a: f64) -> bool {
    static FOUND: LazyLock<Mutex<HashMap<u64, bool>>> = LazyLock::new(Mutex::default);
    let mut found = FOUND.lock().unwrap_or_else(PoisonError::into_inner);
    *found.entry(a.to_bits()).or_insert_with(|| {
        let best = [Projection::Parallel, Projection::Perspective]
            .map(|projection| finite_or_error(optimum(a, projection)));
        let local = finite_or_error(local_optima(a));
        assert!(best.iter().all(|one| one.is_some() == local.is_some()));
        local.is_some()
    })
}

pub(super) const CASES: &[(&str, Case)] = &[
    ("host effects::renderer", |n| {
        let effects: Effects = "auto".parse().expect("effects");
        let spectrum = Spectrum::Single(n.next(550.0));
        let (scene, simd) = (SCENE.scene(), Simd::detect());
        match effects::renderer(scene, simd, Settings::default(), &effects, spectrum) {
            Ok(renderer) => finite(&pixels_of(&renderer, &view())),
            Err(error) => assert!(!n.are_sane() && !error.to_string().is_empty()),
        }
    }),
    ("host render::view", |n| {
        let eye = eye(n);
        if let Some(wall) = wall(n) {
            let view = finite_or_error(render::view(&wall, &eye));
            assert!(view.is_some() || !n.are_sane());
        }
        if let Some(dome) = dome(n) {
            finite_or_error(render::view(&dome, &eye));
        }
    }),
    ("host render::renderer", |n| {
        let observer = Observer::foveated(Eye::Left, n.dvec3([0.0; 3]), sight(), n.next(0.1));
        let scene = SCENE.scene();
        let renderer = render::renderer(&scene, &observer, &options(), Spectrum::default());
        let renderer = renderer.expect("a renderer");
        shows_light(&sampling(&renderer, &view()).expect("a picture"));
    }),
    ("host render::dome", |n| {
        let camera = DomeCamera::tilted(n.dvec3([0.0, 1.0, 0.0]), n.wide(0.3));
        let field_of_view = n.next(3.0);
        let projection = DomeProjection::Equidistant { field_of_view };
        let lod = lod(n);
        let view = finite_or_error(View::dome(projection, camera.pose(), 8));
        assert!(view.is_some() || !n.are_sane());
        if let Some(view) = view {
            let seen = render::dome(&SCENE.scene(), &view, lod, &options(), &|_, _| {});
            shows_light(&seen.expect("a picture").picture);
        }
    }),
    ("host render::cave_filled", |n| {
        let eyes = [eye(n)];
        let capture = Filling::Capture(CaptureOptions {
            size: 16,
            level: n.next(0.34),
            steps: None,
        });
        let (room, scene) = (room(), SCENE.scene());
        let frame = render::cave_filled(&scene, &room, &eyes, &options(), capture, &|_, _| {});
        check(frame, n.are_sane());
    }),
    ("host render::ledger::account", |n| {
        let eyes = [eye(n)];
        match render::account(&SCENE.scene(), &room(), &eyes, &options()) {
            Ok(account) => assert_eq!(account.pixels, 27),
            Err(error) => assert!(!n.are_sane() && !error.to_string().is_empty(), "{error}"),
        }
    }),
    ("host live::engine::with_engine", engine),
    ("host live::engine::eyes_of", engine),
    ("host live::engine::Engine::render", engine),
    ("host live::engine::Engine::render_whole_fovea", engine),
    ("host live::engine::Engine::copy", engine),
    ("host live::engine::Engine::copy_over", engine),
    ("host lod::Coverage::new", |n| {
        if let Some(lod) = lod(n) {
            let found = Coverage::new(&view(), &lod, 3);
            finite(&found);
            let all = found.central + found.peripheral + found.outside;
            assert!((all - 1.0).abs() < 1e-9, "{found:?}");
        }
    }),
    ("host lod::outside::OutsideDifference::add", |n| {
        let Some(lod) = lod(n) else { return };
        let light = [0; 2].map(|_| [0.1, 0.5, 0.9, 1.0].map(|light| n.next(light)));
        let [found, full] =
            light.map(|pixel| Picture::from_pixels(8, 8, vec![pixel; 64]).expect("a picture"));
        let mut error = OutsideDifference::default();
        error.add(&view(), &lod, &found, &full);
        finite(&error);
        assert!(error.root_mean_square().is_none_or(|off| off <= 255.0));
    }),
    ("host lod::pictures::levels", |n| {
        if let Some(lod) = lod(n) {
            shows_light(&levels(&view(), &lod).expect("a picture"));
        }
    }),
    ("host lod::pictures::sampling", |n| {
        if let Some(renderer) = following(lod(n)) {
            shows_light(&sampling(&renderer, &view()).expect("a picture"));
        }
    }),
    ("host lod::pictures::polygons", |n| {
        if let Some(renderer) = following(lod(n)) {
            let seen = polygons(&SCENE.scene(), &renderer, &view());
            shows_light(&seen.expect("a picture"));
        }
    }),
    ("host overview::net::unfold", |n| {
        let picture = picture(n);
        let light = n.within(f32::MAX / 16.0);
        if let Some(wall) = wall(n) {
            let net = unfold(&[(&wall, &picture)]);
            if let (Ok(net), true) = (&net, light) {
                shows_light(net);
            }
            assert!(net.is_ok() || !n.are_sane());
        }
    }),
    ("host overview::viewer::render", |n| {
        let picture = picture(n);
        let light = n.within(f32::MAX / 16.0);
        let (eye, forward) = (n.dvec3([0.0, 1.0, 3.0]), n.dvec3([0.0, 0.0, -1.0]));
        let camera = ViewerCamera::new(eye, forward, DVec3::Y, 1.0, [4, 4]);
        if let (Some(camera), Some(wall)) = (finite_or_error(camera), wall(n)) {
            let seen = viewer::render(&camera, &[(&wall, &picture)]);
            if let (Ok(seen), true) = (&seen, light) {
                shows_light(seen);
            }
            assert!(seen.is_ok() || !n.are_sane());
        }
    }),
    ("host dashboard::place_map::Coordinates::new", |n| {
        if let Some(wall) = wall(n) {
            let room = Cave::new(vec![wall]).expect("a room");
            finite_or_error(Coordinates::new(&room));
        }
    }),
    ("host dashboard::place_map::Coordinates::view", |n| {
        let room = room();
        let coordinates = Coordinates::new(&room).expect("coordinates");
        let (eye, forward) = (n.dvec3([0.0, 1.0, 3.0]), n.dvec3([0.0, 0.0, -1.0]));
        let camera = ViewerCamera::new(eye, forward, DVec3::Y, n.wide(1.0), [4, 4]);
        if let Some(camera) = finite_or_error(camera) {
            let map = coordinates.view(&camera).expect("a map");
            assert_eq!(map.places().len(), 16);
        }
    }),
    ("host stereo::Stereo::compose", |n| {
        let [left, right] = [0; 2].map(|_| picture(n));
        let shown = Stereo::Anaglyph.compose(&left, &right).expect("a picture");
        for one in shown {
            for [red, green, blue, _] in one.picture.pixels {
                finite(&[red, green, blue]);
            }
        }
    }),
    ("host tradeoff::metrics::PictureDifference::new", |n| {
        let light = [0; 2].map(|_| [0.1, 0.5, 0.9, 1.0].map(|light| n.next(light)));
        let [found, truth] =
            light.map(|pixel| Picture::from_pixels(8, 8, vec![pixel; 64]).expect("a picture"));
        let sight = Sight::new(&view(), Vec3::NEG_Z);
        finite(&PictureDifference::new(&[(&sight, &found, &truth)]));
    }),
    ("host tradeoff::page::html", |n| {
        let report = report(n);
        if let Some(page) = finite_page(tradeoff::html(&report)) {
            assert!(page.ends_with("</html>\n"));
        }
    }),
    ("host tradeoff::table::csv", |n| {
        // As many rows as points have numbers, and a head.
        let text = tradeoff::csv(&report(n)).expect("a table");
        assert!(text.lines().count() > 6, "{text}");
    }),
    ("host warp::Warp::new", |n| {
        warped(n, |warp| format!("{:?}", warp.node(0, 0)).into_bytes());
    }),
    ("host warp::bourke::write", |n| {
        warped(n, |warp| {
            let mut bytes = Vec::new();
            bourke::write(warp, &mut bytes).expect("a mesh");
            bytes
        });
    }),
    ("host warp::mpcdi::write", |n| {
        warped(n, |warp| {
            let mut bytes = Cursor::new(Vec::new());
            mpcdi::write(warp, &mut bytes).expect("an archive");
            bytes.into_inner()
        });
    }),
    ("host cave::view::Wall::flat_screen", |n| {
        if let Some(wall) = wall(n) {
            let screen = wall.flat_screen();
            // What f32 does not hold is refused by what it is seen from.
            if n.within(1.0e30) {
                finite(&screen);
            }
        }
    }),
    ("host dome::design::optimum", |n| {
        assert!(searched(n.wide(1.2)) || !n.are_sane());
    }),
    ("host dome::design::local_optima", |n| {
        let a = n.wide(1.2);
        let (least, most) = Mirror::AXIS_RATIOS;
        assert_eq!(searched(a), (least..=most).contains(&a), "{a}");
    }),
    ("host bake::tree::build", |n| {
        let boxes: Vec<Bounds> = (0..5)
            .map(|i| {
                let corners = [0.0, 1.0].map(|more| {
                    [0, 1, 2].map(|axis: u8| n.next(f32::from(axis) + i as f32 + more))
                });
                Bounds::of_points(&corners)
            })
            .collect();
        // Those of a scene, whose coordinates are bounded.
        if !n.within(1.0e15) {
            return;
        }
        for effort in [BuildEffort::Great, BuildEffort::Little] {
            let tree = build::<8>(&boxes, 2, effort);
            let mut primitives = tree.leaves.concat();
            primitives.sort_unstable();
            assert_eq!(primitives, [0, 1, 2, 3, 4]);
        }
    }),
    ("host mesh::TriangleMesh::shows_texture", |n| {
        assert!(!TriangleMesh::square().shows_texture(Some(&plain(n))));
    }),
    ("host mesh::TriangleMesh::has_coordinates_for", |n| {
        assert!(TriangleMesh::square().has_coordinates_for(Some(&plain(n))));
    }),
    ("host simplify::PolygonLevels::apply_to", |n| {
        let levels = PolygonLevels::new(1..=2, 2).expect("levels");
        assert!(levels.apply_to(&square(n)));
    }),
    ("host simplify::Ladder::new", |n| {
        let levels = PolygonLevels::new(1..=2, 2).expect("levels");
        if let Ok(ladder) = Ladder::new(&square(n), &levels) {
            assert!(!ladder.rungs().is_empty());
        }
    }),
    ("host tracker::calibration::gather::Gatherer::new", gathered),
    (
        "host tracker::calibration::gather::Gatherer::push",
        gathered,
    ),
    (
        "host tracker::calibration::CalibrationFile::residuals",
        |n| {
            let mut seen = |x: f32, y: f32| SeenTarget {
                place: None,
                direction: n.vec3([x, y, -1.0]),
                samples: None,
                measured: [0; 3].map(|_| Some(Vec2::new(n.next(x), n.next(y)))),
            };
            let targets = [(0.0, 0.0), (0.3, 0.0), (0.0, 0.3), (-0.3, 0.1), (0.1, -0.3)];
            let file = CalibrationFile {
                targets: targets.map(|(x, y)| seen(x, y)).into(),
                ..CalibrationFile::default()
            };
            if let Some(fits) = finite_or_error(file.fit()) {
                for target in &file.targets {
                    finite(&file.residuals(&fits, target));
                }
            }
        },
    ),
    ("host tracker::recording::Recorder::push", |n| {
        let sample = a_sample(n);
        let folder = tempfile::tempdir().expect("a folder");
        for name in ["samples.csv", "samples.bin"] {
            let path = folder.path().join(name);
            let mut recorder = Recorder::create(&path).expect("a file");
            recorder.push(&Event::Sample(sample), 0).expect("a sample");
            drop(recorder);
            // What is no number is refused where it is read, or is not there.
            if let Some(read) = finite_or_error(Recording::read(&path)) {
                assert_eq!(read.samples().count(), 1);
            }
        }
    }),
];

fn sight() -> LineOfSight {
    LineOfSight::new(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y).expect("a line of sight")
}

/// A renderer whose detail follows a gaze.
fn following(lod: Option<LevelOfDetail>) -> Option<Renderer<'static, 8>> {
    let observer = Observer {
        lod: Some(lod?),
        ..Observer::new(Eye::Left, DVec3::ZERO)
    };
    let renderer = render::renderer(&SCENE.scene(), &observer, &options(), Spectrum::default());
    Some(renderer.expect("a renderer"))
}

/// A chart of numbers that are none is refused.
fn finite_page(page: std::io::Result<String>) -> Option<String> {
    match page {
        Ok(page) => Some(page),
        Err(error) => {
            assert!(!error.to_string().is_empty());
            None
        }
    }
}

pub(super) fn plain(n: &mut Numbers) -> Material {
    Material {
        diffuse: [0.3; 3].map(|light| n.next(light)),
        shininess: n.next(20.0),
        ..Material::default()
    }
}

pub(super) fn square(n: &mut Numbers) -> TriangleMesh {
    let mut mesh = TriangleMesh::square();
    for place in &mut mesh.positions {
        *place = place.map(|x| n.next(x));
    }
    mesh
}

/// A target that is looked at, and what a tracker says meanwhile.
fn gathered(n: &mut Numbers) {
    let target = TimedTarget {
        start: Micros(0),
        end: Micros::from_millis(2_000),
        place: n.vec3([0.1, 1.6, -2.0]),
    };
    let mut gatherer = Gatherer::new(EstimatorConfig::default(), vec![target]);
    let mut sample = a_sample(n);
    for millis in 0..30 {
        sample.arrival = Micros::from_millis(500 + 10 * millis);
        gatherer.push(&sample, &mut |_| {});
    }
    assert_eq!(gatherer.targets().len(), 1);
}

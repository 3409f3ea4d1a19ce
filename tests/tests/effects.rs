//! Only the effects that a scene asks for: the same picture with more of them
//! compiled in, the right picture with fewer carried out, and a ledger that
//! adds up.

use glam::{DAffine3, DVec3, Vec3};
use serde_json::Value;
use shisen::bake::Baked;
use shisen::cave::{BuiltInCave, Cave, Eye, Viewer};
use shisen::render::effects::Effects;
use shisen::render::{self, Account, Frame, Observer, Options};
use shisen::scene::builtin::{PaperScene, grid, paper_scene};
use shisen::scene::camera::CameraPath;
use shisen::scene::material::{Graticule, Material};
use shisen::scene::texture::{Image, Pattern, Texture};
use shisen::scene::{Background, Light, Object, Scene, Shape};
use shisen_core::COMPILED;
use shisen_core::frame::{
    Budget, Entry, Ledger, Mode, Outcome, Pixel, Renderer, Settings, Spectrum, Tile, TileJob, View,
    Workspace,
};
use shisen_core::scene::format::{Header, effect, seal};
use shisen_core::scene::{EffectSet, SceneError};
use shisen_core::shape::Ray;
use shisen_core::spectrum::{Matching, Medium, SpectralSample, SpectralTable, Wavelengths};
use shisen_core::trace::Tracer;
use shisen_core::{Runs, Simd};
use shisen_tests::command::{folder, report, shisen};
use shisen_tests::meshes::icosphere;
use std::mem::offset_of;
use std::path::Path;
use std::sync::Arc;

const SHADOWS: EffectSet = EffectSet::SHADOWS;
const REFLECTION: EffectSet = EffectSet::REFLECTION;
const REFRACTION: EffectSet = EffectSet::REFRACTION;
const ABSORPTION: EffectSet = EffectSet::ABSORPTION;
const GRATICULE: EffectSet = EffectSet::GRATICULE;

fn sphere(radius: f32, material: usize, at: [f64; 3]) -> Object {
    Object {
        shape: Shape::Sphere { radius },
        material: Some(material),
        world_from_object: DAffine3::from_translation(DVec3::from(at)),
        casts_shadow: true,
        smooth: false,
    }
}

fn scene(materials: Vec<Material>, objects: Vec<Object>) -> Scene {
    Scene {
        name: "effects".into(),
        meshes: Vec::new(),
        materials,
        objects,
        lights: vec![Light::Directional {
            direction: DVec3::new(0.0, 0.0, -1.0),
            colour: [1.0; 3],
        }],
        background: Background::uniform([0.25, 0.5, 0.75]),
        ambient: [0.125; 3],
        camera: CameraPath::default(),
    }
}

fn mirror() -> Material {
    Material {
        diffuse: [0.25; 3],
        mirror: [0.5; 3],
        ..Material::default()
    }
}

fn glass() -> Material {
    Material {
        diffuse: [0.0; 3],
        transmission: [0.9; 3],
        absorption: [1.0, 0.5, 0.25],
        ..Material::default()
    }
}

/// Everything that there is, in one picture.
fn everything() -> Scene {
    let lines = Material {
        graticule: Some(Graticule {
            divisions: 3,
            width: 0.1,
        }),
        ..Material::default()
    };
    let objects = vec![
        sphere(0.5, 0, [-1.1, 0.0, -2.0]),
        sphere(0.5, 1, [0.0, 0.0, -2.0]),
        sphere(0.5, 2, [1.1, 0.0, -2.0]),
        sphere(0.3, 3, [0.2, 0.9, -1.8]),
        sphere(3.0, 3, [0.0, 0.0, -6.0]),
        sphere(0.2, 4, [-0.6, 0.8, -1.8]),
        sphere(0.2, 5, [-0.2, -0.9, -1.8]),
        sphere(0.1, 6, [0.6, -0.8, -1.8]),
    ];
    let textured = |pattern| Material {
        texture: Some(Texture {
            pattern,
            repeats: [4.0, 3.0],
        }),
        ..Material::default()
    };
    let image = Image::new(2, 1, &[[255, 0, 0], [0, 255, 99]]).expect("an image");
    let materials = vec![
        mirror(),
        Material {
            medium: Some(Medium::N_BK7),
            ..glass()
        },
        lines,
        Material::default(),
        textured(Pattern::Checker([[0.9; 3], [0.1; 3]])),
        textured(Pattern::Image(Arc::new(image))),
        Material {
            emission: [0.5; 3],
            ..Material::default()
        },
    ];
    let mut scene = scene(materials, objects);
    scene.lights.push(Light::Rectangle {
        centre: DVec3::new(0.0, 2.0, 0.0),
        right: DVec3::new(-0.5, 0.0, 0.0),
        up: DVec3::new(0.0, 0.0, -0.5),
        colour: [2.0; 3],
        samples: 2,
        two_sided: false,
    });
    scene
}

fn frame<const W: usize>(baked: &Baked<W>, side: u32, effects: Effects) -> Frame
where
    Simd: Runs<W>,
{
    let (room, eyes) = room(side);
    render::cave(&baked.scene(), &room, &eyes, &options(effects), &|_, _| {}).expect("a frame")
}

fn account<const W: usize>(baked: &Baked<W>, side: u32, effects: Effects) -> Account
where
    Simd: Runs<W>,
{
    let (room, eyes) = room(side);
    render::account(&baked.scene(), &room, &eyes, &options(effects)).expect("an account")
}

fn room(side: u32) -> (Cave, [Observer; 2]) {
    let room = Cave::built_in(BuiltInCave::ThreeWall, [side; 2]).expect("a room");
    let viewer = Viewer::default();
    let eyes = Eye::STEREO.map(|eye| Observer::new(eye, viewer.eye(eye)));
    (room, eyes)
}

fn options(effects: Effects) -> Options {
    Options {
        effects,
        threads: 2,
        ..Options::default()
    }
}

/// What a renderer makes of 48² pixels from the origin, as bits.
fn picture<const W: usize>(renderer: &Renderer<'_, W>) -> Vec<[u32; 4]>
where
    Simd: Runs<W>,
{
    let (view, tile) = small_view();
    let mut pixels = vec![Pixel::default(); 48 * 48];
    let mut workspace = Workspace::new();
    let outcome = TileJob::new(tile).render(
        renderer,
        &view,
        &mut pixels,
        &mut { Budget::UNLIMITED },
        &mut workspace,
    );
    assert_eq!(outcome, Ok(Outcome::Finished));
    bits(&pixels)
}

fn bits(pixels: &[Pixel]) -> Vec<[u32; 4]> {
    let bits = |p: &Pixel| [p.red, p.green, p.blue, p.alpha].map(f32::to_bits);
    pixels.iter().map(bits).collect()
}

/// A square of 3 m at 1.5 m.
fn small_view() -> (View, Tile) {
    let (right, down) = (Vec3::X / 16.0, Vec3::NEG_Y / 16.0);
    let first = Vec3::new(-1.5, 1.5, -1.5) + (right + down) / 2.0;
    let view = View::new(Vec3::ZERO, first, right, down, [48, 48]).expect("a view");
    let tile = Tile {
        x: 0,
        y: 0,
        width: 48,
        height: 48,
    };
    (view, tile)
}

/// Shading that is compiled for a set, if the set is one of those that a
/// program might fix.
fn fixed<const W: usize>(baked: &Baked<W>, set: EffectSet, mode: Mode) -> Renderer<'_, W>
where
    Simd: Runs<W>,
{
    const NOTHING: u32 = 0;
    const OPAQUE: u32 = SHADOWS.bits();
    const MIRRORS: u32 = SHADOWS.union(REFLECTION).bits();
    const GLASS: u32 = REFRACTION.union(ABSORPTION).union(SHADOWS).bits();
    let (scene, simd) = (baked.scene(), Simd::PORTABLE);
    let settings = Settings {
        mode,
        ..Settings::default()
    };
    match set.bits() {
        NOTHING => Renderer::for_effects::<NOTHING>(scene, simd, settings),
        OPAQUE => Renderer::for_effects::<OPAQUE>(scene, simd, settings),
        MIRRORS => Renderer::for_effects::<MIRRORS>(scene, simd, settings),
        GLASS => Renderer::for_effects::<GLASS>(scene, simd, settings),
        _ => Renderer::new(scene, simd, settings),
    }
}

#[test]
fn papers_pictures_are_the_same_with_more_effects() {
    for which in PaperScene::ALL {
        let scene = paper_scene(which, icosphere(3)).expect("a scene");
        let (fast, compact) = (Baked::<8>::new(&scene), Baked::<4>::new(&scene));
        let (fast, compact) = (fast.expect("a scene"), compact.expect("a scene"));
        let mirrors = matches!(which, PaperScene::A | PaperScene::C);
        let asked = if mirrors {
            SHADOWS | REFLECTION
        } else {
            SHADOWS
        };
        assert_eq!(fast.scene().effects(), asked);
        assert_eq!(compact.scene().effects(), asked);
        let auto = frame(&fast, 40, Effects::AUTO);
        let supersets = COMPILED.iter().map(|&set| Effects::AUTO.more(set));
        let refracting = Effects::AUTO.more(REFRACTION);
        for effects in supersets.chain([Effects::ALL, refracting]) {
            for found in [frame(&fast, 40, effects), frame(&compact, 40, effects)] {
                // A superset with mirrors is still that of a scene without.
                assert_eq!(found.hash(), auto.hash(), "{}: {effects}", which.name());
                assert_eq!(found.statistics.shadow, auto.statistics.shadow);
                assert_eq!(found.statistics.reflected, auto.statistics.reflected);
            }
        }
    }
}

#[test]
fn shading_fixed_to_a_set_gives_the_same_pixels() {
    let scenes = [
        (
            paper_scene(PaperScene::B, icosphere(2)).expect("a scene"),
            SHADOWS,
        ),
        (
            paper_scene(PaperScene::A, icosphere(2)).expect("a scene"),
            SHADOWS | REFLECTION,
        ),
        (
            scene(
                vec![glass(), Material::default()],
                vec![
                    sphere(0.5, 0, [0.0, 0.0, -2.0]),
                    sphere(1.0, 1, [0.3, 0.0, -4.0]),
                ],
            ),
            SHADOWS | REFRACTION | ABSORPTION,
        ),
    ];
    for (scene, set) in scenes {
        let compact = Baked::<4>::new(&scene).expect("a scene");
        assert_eq!(compact.scene().effects(), set);
        let everything = Renderer::new(compact.scene(), Simd::PORTABLE, Settings::default());
        let expected = picture(&everything);
        for mode in [Mode::Single, Mode::Tile] {
            let fixed = fixed(&compact, set, mode);
            assert_eq!(fixed.tracer().effects(), set);
            assert_eq!(picture(&fixed), expected, "{set}");
        }
        // Compiled out or left out: the same picture.
        for less in [EffectSet::NONE, SHADOWS] {
            let left_out = everything.without(EffectSet::ALL.difference(less));
            assert_eq!(
                picture(&fixed(&compact, less, Mode::Tile)),
                picture(&left_out)
            );
        }
        // No shadow falls on what is seen of the first.
        let bare = picture(&fixed(&compact, EffectSet::NONE, Mode::Tile));
        assert_eq!(bare == expected, set == SHADOWS, "{set}");
    }
}

#[test]
fn grids_without_lines_are_whole() {
    let baked = Baked::<8>::new(&grid(100.0)).expect("a scene");
    assert_eq!(baked.scene().effects(), GRATICULE);
    let renderer = Renderer::new(baked.scene(), Simd::detect(), Settings::default());
    let white = |pixels: Vec<[u32; 4]>| {
        let one = 1f32.to_bits();
        pixels.iter().filter(|pixel| **pixel == [one; 4]).count()
    };
    let lines = white(picture(&renderer));
    assert!((1..48 * 48 / 2).contains(&lines), "{lines} pixels of lines");
    assert_eq!(white(picture(&renderer.without(GRATICULE))), 48 * 48);
    // Dome masters test for lines eight rays at a time.
    let size = 64;
    let pose = shisen_core::frame::DomePose {
        position: Vec3::ZERO,
        room_from_capture: glam::Mat3::IDENTITY,
    };
    let projection = shisen_core::frame::DomeProjection::Equidistant {
        field_of_view: std::f32::consts::PI,
    };
    let view = View::dome(projection, pose, size).expect("a dome");
    let master = |effects| render::dome(&baked.scene(), &view, None, &options(effects), &|_, _| {});
    let black = |effects| {
        let picture = master(effects).expect("a dome master").picture;
        let pixels = (0..size).flat_map(|y| (0..size).map(move |x| (x, y)));
        pixels
            .filter(|&(x, y)| picture.pixel(x, y) == Some([0.0, 0.0, 0.0, 1.0]))
            .count()
    };
    assert!(black(Effects::AUTO) > 1000);
    assert_eq!(black(Effects::AUTO.less(GRATICULE)), 0);
}

#[test]
fn what_is_left_out_is_seen_as_documented() {
    let material = mirror();
    let objects = vec![
        sphere(1.0, 0, [0.0, 0.0, -3.0]),
        sphere(0.2, 0, [0.0, 0.0, 1.0]),
    ];
    let baked = Baked::<8>::new(&scene(vec![material], objects)).expect("a scene");
    let ahead = Ray::new(Vec3::ZERO, Vec3::NEG_Z).expect("a ray");
    let red = |without: EffectSet| {
        let tracer = Tracer::new(baked.scene(), Simd::detect(), 1).without(without);
        let budget = &mut { Budget::UNLIMITED };
        tracer.radiance(&ahead, budget, &mut Workspace::new()).red
    };
    // Ambient light on it, and in the mirror ambient light on the other, whose
    // far side the light is on.
    let (ambient, lit) = (0.25 * 0.125, 0.25);
    assert_eq!(red(SHADOWS | REFLECTION), ambient + lit);
    assert_eq!(red(REFLECTION), ambient);
    assert_eq!(red(EffectSet::NONE), ambient + 0.5 * ambient);
    assert_eq!(red(SHADOWS), ambient + lit + 0.5 * ambient);

    let body = Material {
        diffuse: [0.5; 3],
        ..glass()
    };
    let scene = Scene {
        lights: Vec::new(),
        ..scene(vec![body], vec![sphere(1.0, 0, [0.0, 0.0, -3.0])])
    };
    let baked = Baked::<8>::new(&scene).expect("a scene");
    let red = |without: EffectSet| {
        let tracer = Tracer::new(baked.scene(), Simd::detect(), 2).without(without);
        let budget = &mut { Budget::UNLIMITED };
        tracer.radiance(&ahead, budget, &mut Workspace::new()).red
    };
    // Opaque: its diffuse reflectance under ambient light.
    assert_eq!(red(REFRACTION | ABSORPTION), 0.5 * 0.125);
    assert_eq!(red(REFRACTION), 0.5 * 0.125);
    // Two metres inside, one neper a metre: what is behind, less that.
    let (clear, absorbing) = (red(ABSORPTION), red(EffectSet::NONE));
    assert!(clear > 0.25 * 0.96 * 0.96 * 0.81, "{clear}");
    assert!(absorbing < 0.5 * clear, "{absorbing} {clear}");
}

#[test]
fn the_ledger_adds_up_and_its_pixels_are_the_picture_s() {
    let baked = Baked::<8>::new(&everything()).expect("a scene");
    assert_eq!(baked.scene().effects(), EffectSet::ALL);
    let settings = Settings {
        samples: 3,
        mode: Mode::Single,
        ..Settings::default()
    };
    let mut storage = [SpectralSample::default(); 3 + SpectralTable::BROAD];
    let three = Wavelengths::new(3, Wavelengths::RANGE).expect("three wavelengths");
    let table = SpectralTable::new(three, 1, Matching::Wyman, &mut storage).expect("a table");
    let renderer = Renderer::new(baked.scene(), Simd::detect(), settings)
        .with_spectrum(Spectrum::Comb { table, each: 3 })
        .expect("wavelengths at which glass is known");
    let (view, tile) = small_view();
    let mut pixels = vec![Pixel::default(); 48 * 48];
    let (mut ledger, mut workspace) = (Ledger::EMPTY, Workspace::new());
    renderer
        .account(&view, tile, &mut pixels, &mut ledger, &mut workspace)
        .expect("a tile of the view");
    assert_eq!(bits(&pixels), picture(&renderer));
    let found = workspace.statistics;
    let all = ledger.entry(EffectSet::ALL);
    assert_eq!(all.rays, found.reflected + found.refracted + found.shadow);
    assert_eq!(found.primary, 3 * 48 * 48);
    let soft = ledger.entry(EffectSet::SOFT_LIGHT).rays;
    assert_eq!(ledger.entry(SHADOWS).rays + soft, found.shadow);
    let mirrored = ledger.entry(REFLECTION).rays;
    let refracting = ledger.entry(REFRACTION).rays;
    let dispersing = ledger.entry(EffectSet::DISPERSION).rays;
    assert_eq!(
        mirrored + refracting + dispersing,
        found.reflected + found.refracted
    );
    assert!(refracting > 0 && dispersing > 0 && mirrored > 0);
    // What is entered for dispersion is what the frame takes more by it: the
    // first wavelength's rays would be there as well, but for what another index
    // reflects.
    let (mut plain, mut workspace) = (Ledger::EMPTY, Workspace::new());
    renderer
        .without(EffectSet::DISPERSION)
        .account(&view, tile, &mut pixels, &mut plain, &mut workspace)
        .expect("a tile of the view");
    let plain = plain.entry(REFLECTION).rays + plain.entry(REFRACTION).rays;
    let ratio = (mirrored + refracting) as f64 / plain as f64;
    assert!((ratio - 1.0).abs() < 0.05, "{ratio}");
    for &(effect, name) in EffectSet::NAMED {
        let Entry {
            pixels,
            rays,
            steps,
        } = ledger.entry(effect);
        assert!(pixels > 0 && pixels < 48 * 48, "{name}: {pixels} pixels");
        assert!(steps >= rays, "{name}: {steps} steps of {rays} rays");
        let traces =
            SHADOWS | EffectSet::SOFT_LIGHT | REFLECTION | REFRACTION | EffectSet::DISPERSION;
        let traces = traces.contains(effect);
        assert_eq!(rays > 0, traces, "{name}: {rays} rays");
    }
    // Without an effect nothing is entered for it, and less for no other but
    // those that its rays had met.
    for &(effect, name) in EffectSet::NAMED {
        let (mut less, mut workspace) = (Ledger::EMPTY, Workspace::new());
        let renderer = renderer.without(effect);
        renderer
            .account(&view, tile, &mut pixels, &mut less, &mut workspace)
            .expect("a tile of the view");
        assert_eq!(less.entry(effect), Entry::default(), "{name}");
    }
}

#[test]
fn pixels_are_counted_as_geometry_says() {
    // One mirror, and nothing that it could reflect but the background.
    let at = DVec3::new(0.3, -0.2, -2.5);
    let objects = vec![sphere(0.7, 0, at.to_array())];
    let baked = Baked::<8>::new(&scene(vec![mirror()], objects)).expect("a scene");
    let (room, eyes) = room(60);
    let mut expected = 0;
    for screen in room.screens() {
        for eye in &eyes {
            let view = render::view(screen, eye).expect("a view");
            for (x, y) in (0..60).flat_map(|y| (0..60).map(move |x| (x, y))) {
                let towards = view
                    .direction(x as f32, y as f32)
                    .expect("a screen's pixel");
                let towards = towards.as_dvec3().normalize();
                let from = at - eye.place;
                let off = from - towards * from.dot(towards);
                expected += u64::from(off.length() < f64::from(0.7f32));
            }
        }
    }
    let found = account(&baked, 60, Effects::AUTO);
    let reflection = found.ledger.entry(REFLECTION);
    assert!(expected > 300);
    assert_eq!((reflection.pixels, reflection.rays), (expected, expected));
    assert_eq!(found.pixels, 6 * 60 * 60);
    // Light from behind the eyes is on all that they see of it, but for a rim.
    let shadows = found.ledger.entry(SHADOWS);
    assert!(shadows.pixels <= expected && shadows.pixels > expected * 9 / 10);
    assert_eq!(found.ledger.entry(REFRACTION), Entry::default());
}

#[test]
fn an_account_is_the_same_on_any_threads_and_layout() {
    let scene = everything();
    let fast = Baked::<8>::new(&scene).expect("a scene");
    let compact = Baked::<4>::new(&scene).expect("a scene");
    let (room, eyes) = room(24);
    let reference = account(&fast, 24, Effects::AUTO);
    for threads in [1, 3] {
        let options = Options {
            threads,
            tile: 7,
            ..options(Effects::AUTO)
        };
        let found = render::account(&fast.scene(), &room, &eyes, &options).expect("an account");
        assert_eq!(found, reference);
    }
    let other = account(&compact, 24, Effects::AUTO);
    for &(effect, name) in EffectSet::NAMED {
        let (one, other) = (reference.ledger.entry(effect), other.ledger.entry(effect));
        assert_eq!((one.pixels, one.rays), (other.pixels, other.rays), "{name}");
    }
    let frame = frame(&fast, 24, Effects::AUTO);
    let rays = |s: shisen_core::frame::Statistics| [s.primary, s.reflected, s.refracted, s.shadow];
    assert_eq!(rays(frame.statistics), rays(reference.statistics));
}

#[test]
fn scenes_ask_for_what_their_records_ask_for() {
    let baked = Baked::<8>::new(&everything()).expect("a scene");
    let mut bytes = baked.as_bytes().to_vec();
    let at = offset_of!(Header, effects);
    let asked = EffectSet::ALL.bits();
    assert_eq!(bytes[at..at + 4], asked.to_le_bytes());
    for stored in [0, asked & !effect::REFRACTION, asked | 1 << 30] {
        bytes[at..at + 4].copy_from_slice(&stored.to_le_bytes());
        assert!(seal(&mut bytes));
        let expected = SceneError::Effects { stored, asked };
        assert_eq!(Baked::<8>::from_bytes(&bytes).map(|_| ()), Err(expected));
    }
}

fn explain(folder: &Path, arguments: &[&str]) -> Value {
    let mut command = shisen(folder);
    command.args(["explain", "--size", "24", "--repeat", "1"]);
    report(command.args(arguments))
}

fn of_each<'v>(report: &'v Value, list: &str, key: &str) -> Vec<&'v str> {
    let all = report[list].as_array().unwrap().iter();
    all.map(|one| one[key].as_str().unwrap()).collect()
}

#[test]
fn papers_scenes_are_explained() {
    let folder = folder();
    for (name, material, asked) in [
        ("A", "chrome", vec!["shadows", "reflection"]),
        ("C", "chrome", vec!["shadows", "reflection"]),
        ("B", "clay", vec!["shadows"]),
    ] {
        let report = explain(folder.path(), &[name]);
        assert_eq!(report["scene"], name);
        assert_eq!(report["mesh"], "quadruped");
        assert_eq!(report["pixels"], 6 * 24 * 24);
        assert_eq!(report["primary"]["rays"], 6 * 24 * 24);
        assert_eq!(of_each(&report, "effects", "effect"), asked);
        let left_out = of_each(&report, "not_simulated", "effect");
        assert!(left_out.contains(&"refraction"), "{left_out:?}");
        assert_eq!(left_out.len() + asked.len(), EffectSet::NAMED.len());
        for one in report["effects"].as_array().unwrap() {
            assert_eq!(one["materials"], serde_json::json!([material]));
            let (rays, steps) = (
                one["rays"].as_u64().unwrap(),
                one["steps"].as_u64().unwrap(),
            );
            let pixels = one["pixels"].as_u64().unwrap();
            assert!(rays >= pixels && pixels > 0 && steps >= rays, "{one}");
            for seconds in [&report["seconds"], &one["seconds_without"], &one["seconds"]] {
                let median = seconds["median"].as_f64().unwrap();
                let [low, high] = [0, 1].map(|end| seconds["quartiles"][end].as_f64().unwrap());
                assert!(low <= median && median <= high, "{one}");
            }
            assert!(one["seconds_without"]["quartiles"][0].as_f64().unwrap() > 0.0);
        }
        let lights = &report["effects"][0]["lights"];
        assert_eq!(*lights, serde_json::json!(["light 0 (point)"]));
        for one in report["not_simulated"].as_array().unwrap() {
            assert!(one["reason"].as_str().unwrap().len() > 10, "{one}");
        }
        assert!(!report["not_built"].as_array().unwrap().is_empty());
    }
}

#[test]
fn materials_of_a_file_are_named() {
    let folder = folder();
    let text = "[materials.water]\ntransmission = [0.9, 0.9, 0.9]\nabsorption = [0.1, 0.1, 0.1]\n\
                [materials.chrome]\nmirror = [0.8, 0.8, 0.8]\ndiffuse = [0.0, 0.0, 0.0]\n\
                [materials.unused]\ndiffuse = [0.5, 0.5, 0.5]\n\
                [[object]]\nsphere = { radius = 0.5 }\nmaterial = \"water\"\nposition = [0.0, 0.0, -3.0]\n\
                [[object]]\nsphere = { radius = 0.5 }\nmaterial = \"chrome\"\nposition = [1.0, 0.0, -3.0]\n";
    std::fs::write(folder.path().join("pond.toml"), text).unwrap();
    let report = explain(folder.path(), &["--scene", "pond.toml", "--eyes", "1"]);
    let asked = of_each(&report, "effects", "effect");
    assert_eq!(asked, ["reflection", "refraction", "absorption"]);
    for (number, material) in [(0, "chrome"), (1, "water"), (2, "water")] {
        let materials = &report["effects"][number]["materials"];
        assert_eq!(*materials, serde_json::json!([material]), "{number}");
    }
    let reasons = of_each(&report, "not_simulated", "reason");
    assert_eq!(reasons[0], "there is no light to keep out");
    // Baked, names are gone; numbers are those of the description.
    let mut bake = shisen(folder.path());
    bake.args(["bake", "pond.toml", "-o", "pond.shisen"])
        .assert()
        .success();
    let report = explain(folder.path(), &["pond.shisen", "--eyes", "1"]);
    let materials = &report["effects"][0]["materials"];
    assert_eq!(*materials, serde_json::json!(["material 0"]));
}

#[test]
fn what_is_explained_is_what_the_command_line_leaves() {
    let folder = folder();
    let whole = explain(folder.path(), &["spheres", "--eyes", "1"]);
    let asked = of_each(&whole, "effects", "effect");
    assert!(asked.contains(&"dispersion") && asked.contains(&"checker-texture"));
    assert_eq!(whole["left_out"], serde_json::json!([]));
    assert_eq!(whole["lod"], "off");
    let few = ["spheres", "--eyes", "1", "--wavelengths", "3"];
    let few = explain(folder.path(), &few);
    assert_eq!(few["dispersion"]["wavelengths"], 3);
    let dispersion = |report: &Value| {
        let effects = report["effects"].as_array().unwrap().iter();
        let mut found = effects.filter(|one| one["effect"] == "dispersion");
        found.next().unwrap()["rays"].as_u64().unwrap()
    };
    assert!(dispersion(&whole) > 2 * dispersion(&few).max(1));
    let less = [
        "spheres",
        "--eyes",
        "1",
        "--wavelengths",
        "1",
        "--effects=-checker-texture",
    ];
    let less = explain(folder.path(), &less);
    let left_out = of_each(&less, "left_out", "effect");
    assert_eq!(left_out, ["dispersion", "checker-texture"]);
    let left: Vec<&str> = asked
        .iter()
        .copied()
        .filter(|name| !left_out.contains(name))
        .collect();
    assert_eq!(of_each(&less, "effects", "effect"), left);
    assert!(
        of_each(&less, "not_simulated", "effect").len() + asked.len() == EffectSet::NAMED.len()
    );
    // Fewer rays where the gaze is elsewhere.
    let gaze = [
        "A", "--lod", "paper", "--look", "right", "--head", "0,0.2,0",
    ];
    let gaze = explain(folder.path(), &gaze);
    assert_eq!(gaze["lod"], "paper");
    assert!(gaze["primary"]["rays"].as_u64() < gaze["pixels"].as_u64());
}

#[test]
fn people_get_a_table() {
    let folder = folder();
    let mut command = shisen(folder.path());
    let output = command
        .args(["explain", "C", "--size", "16", "--repeat", "1"])
        .assert()
        .success()
        .get_output()
        .clone();
    let text = String::from_utf8(output.stdout).unwrap();
    for expected in [
        "scene C of quadruped on front, right, floor for 2 eyes: 1536 pixels",
        "reflection",
        "chrome",
        "refraction: no material lets light through",
        "not built:",
    ] {
        assert!(text.contains(expected), "{expected}: {text}");
    }
}

#[test]
fn effects_are_chosen_on_the_command_line() {
    let folder = folder();
    let cave = |list: &str| {
        let mut command = shisen(folder.path());
        command.args([
            "cave",
            "--size",
            "24",
            "--view-size",
            "32x24",
            "--effects",
            list,
        ]);
        report(&mut command)
    };
    let asked = serde_json::json!(["shadows", "reflection"]);
    let auto = cave("auto");
    assert_eq!(auto["effects"], asked);
    assert_eq!(auto["effects_asked"], asked);
    for (list, count) in [("all", EffectSet::NAMED.len()), ("+refraction", 3)] {
        let found = cave(list);
        assert_eq!(found["frame_hash"], auto["frame_hash"], "{list}");
        assert_eq!(found["effects_asked"], asked);
        assert_eq!(found["effects"].as_array().unwrap().len(), count, "{list}");
    }
    let found = cave("-shadows,-reflection");
    assert_ne!(found["frame_hash"], auto["frame_hash"]);
    assert_eq!(found["effects"], serde_json::json!([]));
    assert_eq!(found["rays"]["shadow"], 0);
    assert_eq!(found["rays"]["reflected"], 0);
    // One wavelength is no dispersion.
    let mut one = shisen(folder.path());
    one.args([
        "cave",
        "--scene",
        "prism",
        "--size",
        "8",
        "--wavelengths",
        "1",
    ]);
    let one = report(&mut one);
    let named = |key: &str| one[key].as_array().unwrap().contains(&"dispersion".into());
    assert!(named("effects_asked") && !named("effects"));
    let dome = report(shisen(folder.path()).args([
        "dome",
        "render",
        "--scene",
        "grid",
        "--size",
        "16",
        "--effects=-graticule",
    ]));
    assert_eq!(dome["effects"], serde_json::json!([]));
    assert_eq!(dome["effects_asked"], serde_json::json!(["graticule"]));
}

#[test]
fn what_is_no_effect_is_refused() {
    let folder = folder();
    for (list, expected) in [
        ("-shadow", "did you mean \"shadows\"?"),
        ("+caustics", "use one of: shadows, reflection"),
        ("shadows", "write +shadows or -shadows"),
    ] {
        let mut command = shisen(folder.path());
        let output = command
            .args(["cave", "--size", "8", "--effects", list])
            .assert()
            .code(2)
            .get_output()
            .clone();
        let text = String::from_utf8(output.stderr).unwrap();
        assert!(text.contains(expected), "{list}: {text}");
    }
    let mut both = shisen(folder.path());
    both.args(["explain", "A", "--scene", "B"]).assert().code(2);
}

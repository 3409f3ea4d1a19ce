//! Only the effects that a scene asks for: the same picture with more of them
//! compiled in, the right picture with fewer carried out, and a ledger that
//! adds up.

use crate::blob_fuzz::small_scene;
use glam::{DVec3, Vec3};
use serde_json::{Value, json};
use shisen::bake::{AnyScene, Baked};
use shisen::render::effects::Effects;
use shisen::render::{self, Account, Frame, Options};
use shisen::scene::builtin::{PaperScene, grid, paper_scene};
use shisen::scene::material::Material;
use shisen::scene::{Background, Light, Object, Scene};
use shisen_core::COMPILED;
use shisen_core::frame::{
    Budget, DomePose, DomeProjection, Entry, Ledger, Mode, Pixel, Renderer, Settings, Spectrum,
    View, Workspace,
};
use shisen_core::scene::format::{Header, effect, seal};
use shisen_core::scene::{EffectSet, SceneError};
use shisen_core::shape::Ray;
use shisen_core::spectrum::{Matching, SpectralSample, SpectralTable, Wavelengths};
use shisen_core::trace::Tracer;
use shisen_core::{Runs, Simd};
use shisen_tests::command::{folder, list, report, says};
use shisen_tests::meshes::{icosphere, write_ball};
use shisen_tests::paths::Paths;
use shisen_tests::scenes::{self, bits, both_eyes, empty, pixels, sphere, three_walls, tile};
use shisen_tests::ways;
use std::mem::offset_of;

const SHADOWS: EffectSet = EffectSet::SHADOWS;
const REFLECTION: EffectSet = EffectSet::REFLECTION;
const REFRACTION: EffectSet = EffectSet::REFRACTION;
const ABSORPTION: EffectSet = EffectSet::ABSORPTION;
const GRATICULE: EffectSet = EffectSet::GRATICULE;

fn scene(materials: Vec<Material>, objects: Vec<Object>) -> Scene {
    Scene {
        materials,
        objects,
        lights: vec![Light::Directional {
            direction: DVec3::new(0.0, 0.0, -1.0),
            colour: [1.0; 3],
        }],
        background: Background::uniform([0.25, 0.5, 0.75]),
        ambient: [0.125; 3],
        ..empty()
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

fn frame(scene: AnyScene<'_>, side: u32, effects: Effects) -> Frame {
    scenes::frame(scene, &three_walls(side), &both_eyes(), &options(effects))
}

fn account(scene: AnyScene<'_>, side: u32, options: &Options) -> Account {
    render::account(scene, &three_walls(side), &both_eyes(), options).expect("an account")
}

fn options(effects: Effects) -> Options {
    Options {
        effects,
        threads: 2,
        ..Options::default()
    }
}

/// Returns what a renderer makes of 48² pixels from the origin, as bits.
fn picture<const W: usize>(renderer: &Renderer<'_, W>) -> Vec<[u32; 4]>
where
    Simd: Runs<W>,
{
    bits(&pixels(renderer, &small_view()))
}

/// Returns a square of 3 m at 1.5 m.
fn small_view() -> View {
    let (right, down) = (Vec3::X / 16.0, Vec3::NEG_Y / 16.0);
    let first = Vec3::new(-1.5, 1.5, -1.5) + (right + down) / 2.0;
    View::new(Vec3::ZERO, first, right, down, [48, 48]).expect("a view")
}

/// Shading that is compiled for one of the sets that are asked for below.
fn fixed(baked: &Baked<4>, set: EffectSet, mode: Mode) -> Renderer<'_, 4> {
    const OPAQUE: u32 = SHADOWS.bits();
    const GLASS: u32 = REFRACTION
        .union(ABSORPTION)
        .union(SHADOWS)
        .union(EffectSet::CLEAR_SHADOWS)
        .bits();
    let (scene, simd) = (baked.scene(), Simd::PORTABLE);
    let settings = ways::settings(mode, 1);
    match set.bits() {
        0 => Renderer::for_effects::<0>(scene, simd, settings),
        OPAQUE => Renderer::for_effects::<OPAQUE>(scene, simd, settings),
        GLASS => Renderer::for_effects::<GLASS>(scene, simd, settings),
        _ => panic!("no shading is compiled for {set}"),
    }
}

#[test]
fn papers_pictures_are_the_same_with_more_effects() {
    for which in PaperScene::ALL {
        let scene = paper_scene(which, icosphere(3)).expect("a scene");
        let Paths { fast, compact } = Paths::new(&scene);
        let auto = frame(fast.scene().into(), 24, Effects::AUTO);
        let supersets = COMPILED.iter().map(|&set| Effects::AUTO.more(set));
        let refracting = Effects::AUTO.more(REFRACTION);
        for effects in supersets.chain([Effects::ALL, refracting]) {
            for found in [
                frame(fast.scene().into(), 24, effects),
                frame(compact.scene().into(), 24, effects),
            ] {
                // A superset with mirrors is still that of a scene without.
                let rays = |frame: &Frame| (frame.statistics.shadow, frame.statistics.reflected);
                let [found, auto] = [&found, &auto].map(|one| (one.hash(), rays(one)));
                assert_eq!(found, auto, "{}: {effects}", which.name());
            }
        }
    }
}

#[test]
fn shading_fixed_to_a_set_gives_the_same_pixels() {
    let paper = |which| paper_scene(which, icosphere(2)).expect("a scene");
    let balls = [
        sphere(0.5, 0, [0.0, 0.0, -2.0]),
        sphere(1.0, 1, [0.3, 0.0, -4.0]),
    ];
    let clear = scene(vec![glass(), Material::default()], balls.to_vec());
    for (scene, set) in [
        (paper(PaperScene::B), SHADOWS),
        (
            clear,
            SHADOWS | REFRACTION | ABSORPTION | EffectSet::CLEAR_SHADOWS,
        ),
    ] {
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
fn grids_without_lines_are_white() {
    let baked = Baked::<8>::new(&grid(100.0)).expect("a scene");
    // Dome masters test for lines eight rays at a time.
    let projection = DomeProjection::Equidistant {
        field_of_view: std::f32::consts::PI,
    };
    let view = View::dome(projection, DomePose::over_room(Vec3::ZERO), 64).expect("a dome");
    let black = |effects| {
        let master = render::dome(
            baked.scene().into(),
            &view,
            None,
            &options(effects),
            &|_, _| {},
        );
        let picture = master.expect("a dome master").picture;
        let is_black = |pixel: &&[f32; 4]| **pixel == [0.0, 0.0, 0.0, 1.0];
        picture.pixels.iter().filter(is_black).count()
    };
    assert!(black(Effects::AUTO) > 1000);
    assert_eq!(black(Effects::AUTO.less(GRATICULE)), 0);
    let screen = Renderer::new(baked.scene(), Simd::detect(), Settings::default());
    let whole = picture(&screen.without(GRATICULE));
    assert!(whole.iter().all(|pixel| *pixel == [1f32.to_bits(); 4]) && picture(&screen) != whole);
}

#[test]
fn what_is_left_out_is_seen_as_documented() {
    let red = |scene: &Scene, without: EffectSet| {
        let baked = Baked::<8>::new(scene).expect("a scene");
        let ahead = Ray::new(Vec3::ZERO, Vec3::NEG_Z).expect("a ray");
        let tracer = Tracer::new(baked.scene(), Simd::detect(), 2).without(without);
        let budget = &mut { Budget::UNLIMITED };
        tracer.radiance(&ahead, budget, &mut Workspace::new()).red
    };
    let ball = sphere(1.0, 0, [0.0, 0.0, -3.0]);
    let behind = sphere(0.2, 1, [0.0, 0.0, 1.0]);
    let matt = Material {
        diffuse: [0.25; 3],
        ..Material::default()
    };
    let mirrors = scene(vec![mirror(), matt], vec![ball.clone(), behind]);
    // Ambient light on it, and in the mirror ambient light on the other, whose
    // far side the light is on.
    let (ambient, lit) = (0.25 * 0.125, 0.25);
    assert_eq!(red(&mirrors, SHADOWS | REFLECTION), ambient + lit);
    assert_eq!(red(&mirrors, REFLECTION), ambient);
    assert_eq!(red(&mirrors, EffectSet::NONE), ambient + 0.5 * ambient);
    assert_eq!(red(&mirrors, SHADOWS), ambient + lit + 0.5 * ambient);

    let body = Material {
        diffuse: [0.5; 3],
        ..glass()
    };
    let bodies = Scene {
        lights: Vec::new(),
        ..scene(vec![body], vec![ball])
    };
    // Opaque: its diffuse reflectance under ambient light.
    assert_eq!(red(&bodies, REFRACTION | ABSORPTION), 0.5 * 0.125);
    assert_eq!(red(&bodies, REFRACTION), 0.5 * 0.125);
    // Two metres inside, one neper a metre: what is behind, less that.
    let (clear, absorbing) = (red(&bodies, ABSORPTION), red(&bodies, EffectSet::NONE));
    assert!(clear > 0.25 * 0.96 * 0.96 * 0.81, "{clear}");
    assert!(absorbing < 0.5 * clear, "{absorbing} {clear}");
}

#[test]
fn the_ledger_adds_up_and_its_pixels_are_the_picture_s() {
    let baked = Baked::<8>::new(&small_scene()).expect("a scene");
    assert_eq!(baked.scene().effects(), EffectSet::ALL);
    let settings = ways::settings(Mode::Single, 3);
    let mut storage = [SpectralSample::default(); 3 + SpectralTable::BROAD];
    let three = Wavelengths::new(3, Wavelengths::RANGE).expect("three wavelengths");
    let table = SpectralTable::new(three, 1, Matching::Wyman, &mut storage).expect("a table");
    let renderer = Renderer::new(baked.scene(), Simd::detect(), settings)
        .with_spectrum(Spectrum::Comb { table, each: 3 })
        .expect("wavelengths at which glass is known");
    let mut pixels = vec![Pixel::default(); 48 * 48];
    let mut account = |renderer: &Renderer<'_>| {
        let (mut ledger, mut workspace) = (Ledger::EMPTY, Workspace::new());
        let tile = tile([0, 0, 48, 48]);
        let done = renderer.account(
            &small_view(),
            tile,
            &mut pixels,
            &mut ledger,
            &mut workspace,
        );
        done.expect("a tile of the view");
        (ledger, workspace.statistics, bits(&pixels))
    };
    let (ledger, found, pixels) = account(&renderer);
    assert_eq!(pixels, picture(&renderer));
    let rays = |effect| ledger.entry(effect).rays;
    let bounced = found.reflected + found.refracted;
    assert_eq!(rays(EffectSet::ALL), bounced + found.shadow);
    let to_lights = SHADOWS | EffectSet::SOFT_LIGHT | EffectSet::CLEAR_SHADOWS;
    assert_eq!(rays(to_lights), found.shadow);
    let onwards = REFLECTION | REFRACTION | EffectSet::DISPERSION | EffectSet::ALPHA;
    assert_eq!(rays(onwards), bounced);
    assert_eq!(found.primary, 3 * 48 * 48);
    let traces = to_lights | onwards;
    for &(effect, name) in EffectSet::NAMED {
        let entry = ledger.entry(effect);
        assert!(
            entry.pixels > 0 && entry.pixels < 48 * 48,
            "{name}: {entry:?}"
        );
        assert!(entry.steps >= entry.rays, "{name}: {entry:?}");
        assert_eq!(entry.rays > 0, traces.contains(effect), "{name}: {entry:?}");
        // Without an effect nothing is entered for it.
        let (less, ..) = account(&renderer.without(effect));
        assert_eq!(less.entry(effect), Entry::default(), "{name}");
    }
}

#[test]
fn an_account_is_the_same_on_any_threads_and_layout() {
    let Paths { fast, compact } = Paths::new(&small_scene());
    let reference = account(fast.scene().into(), 24, &options(Effects::AUTO));
    for threads in [1, 3] {
        let options = Options {
            threads,
            tile: 7,
            ..options(Effects::AUTO)
        };
        assert_eq!(account(fast.scene().into(), 24, &options), reference);
    }
    let other = account(compact.scene().into(), 24, &options(Effects::AUTO));
    for &(effect, name) in EffectSet::NAMED {
        let (one, other) = (reference.ledger.entry(effect), other.ledger.entry(effect));
        assert_eq!((one.pixels, one.rays), (other.pixels, other.rays), "{name}");
    }
    let frame = frame(fast.scene().into(), 24, Effects::AUTO);
    let rays = |s: shisen_core::frame::Statistics| [s.primary, s.reflected, s.refracted, s.shadow];
    assert_eq!(rays(frame.statistics), rays(reference.statistics));
}

#[test]
fn scenes_ask_for_what_their_records_ask_for() {
    let baked = Baked::<8>::new(&small_scene()).expect("a scene");
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

/// Returns the effects of a list of the report.
fn names<'v>(report: &'v Value, key: &str) -> Vec<&'v str> {
    let all = list(report, key).iter();
    all.map(|one| one["effect"].as_str().unwrap()).collect()
}

#[test]
fn what_is_explained_is_what_the_command_line_leaves() {
    let folder = folder();
    let explain = |words: &str| {
        let words = format!("explain --size 16 --repeat 1 --eyes 1 {words}");
        report(folder.path(), &words)
    };
    let whole = explain("spheres");
    let asked = names(&whole, "effects");
    assert!(asked.contains(&"dispersion") && asked.contains(&"checker-texture"));
    says(&whole, json!({ "left_out": [], "lod": "off" }));
    let less = explain("spheres --wavelengths 1 --effects=-checker-texture");
    let left_out = names(&less, "left_out");
    assert_eq!(left_out, ["dispersion", "checker-texture"]);
    let left = asked
        .iter()
        .copied()
        .filter(|name| !left_out.contains(name));
    assert_eq!(names(&less, "effects"), left.collect::<Vec<_>>());
    let others = names(&less, "not_simulated").len();
    assert_eq!(others + asked.len(), EffectSet::NAMED.len());
    // Fewer rays where the gaze is elsewhere.
    let gaze = explain("spheres --lod paper --look right --head 0,0.2,0");
    assert!(gaze["primary"]["rays"].as_u64() < gaze["pixels"].as_u64());
}

#[test]
fn effects_are_chosen_on_the_command_line() {
    let folder = folder();
    write_ball(folder.path());
    let cave = |effects: &str| {
        let small = "cave --mesh ball.obj --size 16 --view-size 8x6";
        report(folder.path(), &format!("{small} --effects {effects}"))
    };
    let asked = json!(["shadows", "reflection"]);
    let auto = cave("auto");
    says(&auto, json!({ "effects": asked, "effects_asked": asked }));
    for (all, count) in [("all", EffectSet::NAMED.len()), ("+refraction", 3)] {
        let found = cave(all);
        says(
            &found,
            json!({ "frame_hash": auto["frame_hash"], "effects_asked": asked }),
        );
        assert_eq!(list(&found, "effects").len(), count, "{all}");
    }
    let found = cave("-shadows,-reflection");
    assert_ne!(found["frame_hash"], auto["frame_hash"]);
    says(&found, json!({ "effects": [] }));
    says(&found["rays"], json!({ "shadow": 0, "reflected": 0 }));
    // One wavelength is no dispersion.
    let one = report(
        folder.path(),
        "cave --scene prism --size 8 --view-size 8x6 --wavelengths 1",
    );
    let is_in = |key: &str| list(&one, key).contains(&"dispersion".into());
    assert!(is_in("effects_asked") && !is_in("effects"));
    let words = "dome render --scene grid --size 16 --effects=-graticule";
    let dome = report(folder.path(), words);
    says(
        &dome,
        json!({ "effects": [], "effects_asked": ["graticule"] }),
    );
}

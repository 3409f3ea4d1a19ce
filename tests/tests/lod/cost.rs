//! How far rays bounce, how many faces they meet, and in how many steps.

use super::{
    GAZES, exact_sight, eyes, frame, is_on_a_border, level, levels, levels_of, lod, places,
    reference, samples, views,
};
use glam::{DVec3, Vec3};
use shisen::bake::Baked;
use shisen::bake::simplify::PolygonLevels;
use shisen::render::gaze_reference;
use shisen::render::{Options, renderer};
use shisen::scene::builtin::{PaperScene, paper_scene};
use shisen::scene::camera::CameraPath;
use shisen::scene::material::Material;
use shisen::scene::{Background, Object, Scene, Shape};
use shisen_core::frame::{
    Budget, Mode, Outcome, Pixel, Renderer, Settings, Spectrum, Statistics, Tile, TileJob, View,
    Workspace,
};
use shisen_core::gaze::Zone;
use shisen_tests::meshes::{meshes, torus};
use shisen_tests::sizes::cases;

/// A hollow ball of mirror around the room: no ray gets out, and none becomes
/// too faint.
fn hall_of_mirrors() -> Scene {
    Scene {
        name: "hall".into(),
        meshes: Vec::new(),
        materials: vec![Material {
            diffuse: [0.0; 3],
            mirror: [0.99; 3],
            ..Material::default()
        }],
        objects: vec![Object {
            shape: Shape::Spheroid {
                equatorial_radius: 4.0,
                polar_radius: 5.5,
            },
            material: Some(0),
            world_from_object: glam::DAffine3::from_rotation_x(0.4),
            casts_shadow: true,
            smooth: false,
        }],
        lights: Vec::new(),
        background: Background::uniform([1.0; 3]),
        ambient: [0.0; 3],
        camera: CameraPath::default(),
    }
}

#[test]
fn no_ray_bounces_more_than_its_level_allows() {
    let baked = Baked::<8>::new(&hall_of_mirrors()).expect("a scene");
    let scene = baked.scene();
    for (most, gaze) in [3, 16, 1].into_iter().zip(GAZES.into_iter().skip(1)) {
        let lod = lod(gaze);
        for mode in [Mode::Single, Mode::Tile] {
            let settings = Settings {
                depth: most,
                mode,
                ..Settings::default()
            };
            let options = Options {
                settings,
                ..Options::default()
            };
            let (size, eyes) = ([33, 31], eyes(Some(lod)));
            let mut allowed_to_all = 0;
            let mut kinds = vec![0; usize::from(most) + 1];
            for (view, eye) in views(size, &eyes) {
                let renderer = renderer(&scene, &eye, &options, Spectrum::Rgb).unwrap();
                for at in places(&view) {
                    let level = level(&lod, &view, at);
                    let allowed = (f64::from(level) * f64::from(most)).floor() as u64;
                    let found = statistics_of_pixel(&renderer, &view, at);
                    assert_eq!(found.reflected, allowed, "{mode:?}, level {level}");
                    assert_eq!(found.primary, u64::from(level > 0.0));
                    allowed_to_all += allowed;
                    kinds[allowed as usize] += 1;
                }
            }
            let found = frame(&scene, size, &eyes, &options).statistics;
            assert_eq!(found.reflected, allowed_to_all, "{gaze:?}");
            println!("{mode:?}: pixels a number of bounces {kinds:?}");
            assert!(kinds.iter().all(|&pixels| pixels > 0), "{kinds:?}");
        }
    }
}

fn statistics_of_pixel(renderer: &Renderer<'_>, view: &View, (x, y): (u32, u32)) -> Statistics {
    let tile = Tile {
        x,
        y,
        width: 1,
        height: 1,
    };
    let mut workspace = Workspace::new();
    let outcome = TileJob::new(tile).render(
        renderer,
        view,
        &mut [Pixel::default()],
        &mut Budget::UNLIMITED.clone(),
        &mut workspace,
    );
    assert_eq!(outcome, Ok(Outcome::Finished));
    workspace.statistics
}

/// How far what pixels see is from equation 10.
#[derive(Debug, Default)]
struct Deviation {
    /// As a share of the range of faces.
    largest: f64,
    at_level: f64,
    traced: u32,
    /// Not central, in a block that has pixels of level 1.
    beside_central: u32,
    /// In a block in which not all pixels see the same mesh.
    in_mixed_blocks: u32,
}

/// Pixels a side of the blocks that go through the scene together.
const BLOCK: u32 = 8;

impl Deviation {
    /// Takes a block of a view, by its first pixel.
    fn take(
        &mut self,
        renderer: &Renderer<'_>,
        exact: &gaze_reference::Gaze,
        view: &View,
        (x, y): (u32, u32),
    ) {
        let meshes = renderer.tracer().scene().meshes();
        let faces = |rung: u8| f64::from(meshes[usize::from(rung)].faces);
        let (min, max) = (f64::from(PolygonLevels::FEWEST_FACES), faces(0));
        let [right, below] =
            [(x, view.columns()), (y, view.rows())].map(|(first, all)| (first + BLOCK).min(all));
        let (mut rungs, mut central, mut others) = (Vec::new(), 0, 0);
        for at in (y..below).flat_map(|y| (x..right).map(move |x| (x, y))) {
            let Some(detail) = renderer.detail(view, at.0, at.1) else {
                continue;
            };
            let sight = exact_sight(exact, view, at);
            rungs.push(detail.rung);
            let seen = faces(detail.rung);
            if sight.zone == Zone::Central && !is_on_a_border(&sight) {
                assert_eq!(seen, max, "a central pixel, {at:?}");
                central += 1;
                continue;
            }
            others += 1;
            let wanted = sight.level * (max - min) + min;
            let share = (seen - wanted).abs() / (max - min);
            if share > self.largest {
                (self.largest, self.at_level) = (share, sight.level);
            }
        }
        let count = rungs.len() as u32;
        self.traced += count;
        self.beside_central += if central > 0 { others } else { 0 };
        let is_mixed = rungs.iter().any(|rung| *rung != rungs[0]);
        self.in_mixed_blocks += if is_mixed { count } else { 0 };
    }
}

#[test]
fn faces_are_those_of_equation_10_to_five_hundredths() {
    let stride = cases("every nth block of large views", 59, 1);
    let with_many = ("torus", torus(60, 30), &[33, 64][..]);
    let with_default = meshes()
        .into_iter()
        .map(|(name, mesh)| (name, mesh, &[16][..]));
    for (name, mesh, ladders) in with_default.chain([with_many]) {
        let scene = paper_scene(PaperScene::A, mesh).expect("a scene");
        for &rungs in ladders {
            let baked = Baked::<8>::with_levels(&scene, &levels_of(rungs)).expect("a scene");
            let scene = baked.scene();
            assert_eq!(scene.meshes().len(), rungs as usize);
            for side in [16, 60, 128, 256, 1024] {
                let stride = if side > 128 { stride } else { 1 };
                let mut met = Deviation::default();
                for gaze in GAZES {
                    // One eye: the other's field is all but the same.
                    let eyes = &eyes(Some(lod(gaze)))[..1];
                    for (view, eye) in views([side; 2], eyes) {
                        let renderer = renderer(&scene, &eye, &samples(1), Spectrum::Rgb).unwrap();
                        let blocks = |all: u32| (0..all).step_by(BLOCK as usize);
                        let places = blocks(side).flat_map(|y| blocks(side).map(move |x| (x, y)));
                        for place in places.step_by(stride) {
                            met.take(&renderer, &reference(gaze), &view, place);
                        }
                    }
                }
                println!("{name}, {rungs} rungs, {side}²: {met:?}");
                assert!(met.traced > 1000);
                assert!(met.beside_central > 0);
                assert!(met.in_mixed_blocks > 0);
                // Five hundredths of the range, to the last face.
                assert!(
                    met.largest <= 0.05,
                    "{name}, {rungs} rungs, {side}²: {met:?}"
                );
            }
        }
    }
}

/// `count` directions spread evenly over the sphere (Fibonacci's spiral).
fn directions(count: usize) -> impl Iterator<Item = Vec3> {
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    (0..count).map(move |number| {
        let y = 1.0 - (2 * number + 1) as f64 / count as f64;
        let (s, c) = (golden * number as f64).sin_cos();
        let r = (1.0 - y * y).sqrt();
        DVec3::new(r * c, y, r * s).as_vec3()
    })
}

/// Every so many-eth of 200 directions; for scenes that are before the front
/// wall only, all that are within 24° of its middle, too: that is where most
/// of them is seen.
fn looks(which: PaperScene, stride: usize) -> Vec<Vec3> {
    let is_ahead = matches!(which, PaperScene::C | PaperScene::D);
    let is_front = |forward: &Vec3| is_ahead && forward.dot(Vec3::NEG_Z) > 0.91;
    let chosen = directions(200).enumerate();
    let chosen = chosen.filter(|(number, forward)| number % stride == 0 || is_front(forward));
    chosen.map(|(_, forward)| forward).collect()
}

#[test]
fn no_gaze_is_dearer_than_plain_tracing() {
    let stride = cases("every nth of 200 lines of sight", 23, 1);
    let mut dearer = Vec::new();
    for (name, mesh) in meshes() {
        for which in PaperScene::ALL {
            let scene = paper_scene(which, mesh.clone()).expect("a scene");
            let plain = Baked::<8>::new(&scene).expect("a scene");
            let ladder = Baked::<8>::with_levels(&scene, &levels()).expect("a scene");
            let (plain, ladder) = (plain.scene(), ladder.scene());
            // Ray by ray is slow, and every one of its rays costs less.
            for (mode, side) in [(Mode::Tile, 256), (Mode::Single, 64)] {
                let options = Options {
                    settings: Settings {
                        mode,
                        ..Settings::default()
                    },
                    ..Options::default()
                };
                let size = [side; 2];
                let all = frame(&plain, size, &eyes(None), &options).statistics;
                // Ray by ray it counts that blocks are spared by covers, which hold all
                // levels of a mesh: a gaze is held against the same scene, which is held
                // against the one without levels.
                let all = if mode == Mode::Single {
                    let in_full = frame(&ladder, size, &eyes(None), &options).statistics;
                    assert_eq!(in_full.rays(), all.rays(), "{name}");
                    let dearer = in_full.steps as f64 / all.steps as f64;
                    println!("{name}, {}: levels in the scene {dearer:.4}", which.name());
                    assert!(dearer <= 1.02, "{name}, {}: {dearer}", which.name());
                    in_full
                } else {
                    all
                };
                let (mut worst, mut towards, mut sum) = (0.0, Vec3::ZERO, 0.0);
                let looks = looks(which, stride);
                for &forward in &looks {
                    let up = if forward.y.abs() < 0.9 {
                        Vec3::Y
                    } else {
                        Vec3::NEG_Z
                    };
                    let eyes = eyes(Some(lod((forward, up))));
                    let found = frame(&ladder, size, &eyes, &options).statistics;
                    let ratio = found.steps as f64 / all.steps as f64;
                    sum += ratio;
                    if ratio > worst {
                        (worst, towards) = (ratio, forward);
                    }
                    assert!(
                        found.rays() <= all.rays(),
                        "{name}, {}, towards {forward}",
                        which.name()
                    );
                }
                let what = format!("{name}, {}, {mode:?}, {side}²", which.name());
                println!(
                    "{what}: at most {worst:.4} of {} steps, towards {towards}; mean {:.4} of {}",
                    all.steps,
                    sum / looks.len() as f64,
                    looks.len()
                );
                if worst > 1.0 {
                    dearer.push(format!("{what}: {worst:.4}"));
                }
            }
        }
    }
    assert!(dearer.is_empty(), "{dearer:?}");
}

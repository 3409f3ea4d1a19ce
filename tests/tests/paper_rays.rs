//! The rays of the paper's frames, against a count made elsewhere, and the
//! relations between them that hold for any animal.

use serde_json::Value;
use shisen::bake::Baked;
use shisen::render::{Observer, Options};
use shisen::scene::builtin::{PaperScene, paper_scene};
use shisen::scene::mesh::TriangleMesh;
use shisen_core::Simd;
use shisen_core::frame::{Budget, Statistics, Workspace};
use shisen_core::trace::Tracer;
use shisen_tests::meshes::{cow, meshes};
use shisen_tests::scenes::{both_eyes, frame, three_walls};

const REFERENCE: &str = include_str!("../reference/paper-rays.json");

const SIZE: u32 = 256;

/// Everything that a frame is counted by.
struct Count {
    /// Primary rays that hit something.
    hits: u64,
    /// By depth, 0 to 3.
    frames: [Statistics; 4],
}

fn count(which: PaperScene, mesh: TriangleMesh) -> Count {
    let mut scene = paper_scene(which, mesh).expect("a scene");
    for object in &mut scene.objects {
        object.smooth = false;
    }
    let baked = Baked::<8>::new(&scene).expect("a scene");
    let (room, eyes) = (three_walls(SIZE), both_eyes());
    let frames = [0, 1, 2, 3].map(|depth| {
        let mut options = Options::default();
        options.settings.depth = depth;
        frame(baked.scene().into(), &room, &eyes, &options).statistics
    });
    let tracer = Tracer::new(baked.scene(), Simd::detect(), 0);
    let mut workspace = Workspace::new();
    let mut hits = 0;
    for wall in &room.walls {
        for Observer { place: eye, .. } in eyes {
            let view = wall.view_from(eye).expect("a wall before the eye");
            for (y, x) in (0..SIZE).flat_map(|y| (0..SIZE).map(move |x| (y, x))) {
                let ray = view.ray(x as f32, y as f32).expect("a ray");
                let hit = tracer.nearest(&ray, &mut Budget::UNLIMITED.clone(), &mut workspace);
                hits += u64::from(hit.is_some());
            }
        }
    }
    Count { hits, frames }
}

/// By bounce: what each depth adds to the one before.
fn reflected(count: &Count) -> [u64; 3] {
    [1, 2, 3].map(|depth| count.frames[depth].reflected - count.frames[depth - 1].reflected)
}

#[test]
fn counts_of_any_animal_fit_together() {
    for (name, mesh) in meshes() {
        let [a, b, c, d] = PaperScene::ALL.map(|which| count(which, mesh.clone()));
        for (mirror, diffuse) in [(&a, &b), (&c, &d)] {
            assert!(mirror.hits > 10_000, "{name}: {}", mirror.hits);
            assert_eq!(mirror.hits, diffuse.hits, "{name}");
            for (depth, statistics) in mirror.frames.iter().enumerate() {
                let (seen, diffuse) = (diffuse.hits, &diffuse.frames[depth]);
                assert_eq!(statistics.primary, 6 * u64::from(SIZE * SIZE), "{name}");
                assert_eq!(diffuse.primary, statistics.primary, "{name}");
                assert_eq!([diffuse.reflected, diffuse.refracted], [0, 0], "{name}");
                assert_eq!(statistics.refracted, 0, "{name}");
                // At most a shadow ray, for the one light, from each hit.
                assert!(diffuse.shadow <= diffuse.primary.min(seen), "{name}");
            }
            let by_bounce = reflected(mirror);
            assert_eq!(by_bounce[0], mirror.hits, "{name}: every hit reflects once");
            assert!(
                by_bounce.is_sorted_by(|a, b| a > b),
                "{name}: {by_bounce:?}"
            );
            assert!(by_bounce[2] > 0, "{name}: reflections of reflections");
        }
        assert!(a.hits != c.hits, "{name}: other places, other pictures");
    }
}

#[test]
fn the_cows_counts_are_the_references() {
    let reference: Value = serde_json::from_str(REFERENCE).expect("JSON");
    let Some(mesh) = cow() else { return };
    for which in PaperScene::ALL {
        let name = which.name();
        let scene = &reference["scenes"][name];
        let expected = |value: &Value| value.as_u64().expect("a number");
        let near = |what: &str, found: u64, expected: u64| {
            let off = found.abs_diff(expected);
            println!("{name}, {what}: {found}, the reference has {expected}");
            assert!(
                off as f64 <= 5e-4 * expected as f64,
                "{name}, {what}: {found}, not {expected}"
            );
        };
        let counted = count(which, mesh.clone());
        assert_eq!(
            counted.frames[3].primary,
            expected(&scene["primary"]),
            "{name}"
        );
        near("hits", counted.hits, expected(&scene["hits"]));
        let secondary = [0, 1, 2].map(|bounce| expected(&scene["secondary"][bounce]));
        if name == "A" || name == "C" {
            let total = reflected(&counted).iter().sum();
            near("secondary rays", total, secondary.iter().sum());
        } else {
            assert_eq!(counted.frames[3].reflected, 0, "{name}");
        }
    }
}

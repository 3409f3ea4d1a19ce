//! A slow renderer that has nothing of levels of detail in it: each pixel from
//! a scene that has one rung and nothing else in place of the ladder, to the
//! depth that the paper's equations in f64 give.

use super::{
    GAZES, ROUNDING, bits, empty_scene, exact_sight, eyes, frame, is_on_a_border, levels, lod,
    pixel, places, reference, samples, scenes, views,
};
use shisen::bake::Baked;
use shisen::bake::simplify::Ladder;
use shisen::render::gaze_reference::bounces;
use shisen::render::renderer;
use shisen::scene::Scene;
use shisen::scene::mesh::TriangleMesh;
use shisen_core::Simd;
use shisen_core::frame::Spectrum;
use shisen_core::gaze::Zone;
use shisen_core::scene::Scene as CoreScene;
use shisen_core::trace::Tracer;
use shisen_tests::meshes::meshes;
use shisen_tests::sizes::cases;

/// Returns the rungs of a scene's first mesh, each as a mesh of its own.
fn rungs_as_meshes(mesh: &TriangleMesh) -> Vec<TriangleMesh> {
    let ladder = Ladder::new(mesh, &levels());
    let all = ladder.versions();
    let normals = mesh.vertex_normals().into_owned();
    assert_eq!(all.positions, mesh.positions);
    let rungs = ladder.rungs().iter();
    rungs
        .map(|rung| TriangleMesh {
            positions: all.positions.clone(),
            normals: normals.clone(),
            triangles: rung.iter().map(|&t| all.triangles[t as usize]).collect(),
            ..TriangleMesh::default()
        })
        .collect()
}

/// What was met on the way.
#[derive(Debug, Default)]
struct Met {
    pixels: u64,
    undecided: u64,
    /// By rung.
    used: [u64; 32],
    shallow: u64,
    /// Other than plain tracing shows: the comparison can tell.
    other: u64,
}

impl Met {
    /// Compares frames with what each pixel should be.
    fn compare(
        &mut self,
        scene: &Scene,
        alone: &[CoreScene<'_, 8>],
        number: usize,
        sizes: &[([u32; 2], u16)],
    ) {
        let baked = Baked::<8>::with_levels(scene, &levels()).expect("a scene");
        let nothing = Baked::<8>::new(&empty_scene(scene.background)).expect("a scene");
        let nothing = Tracer::new(nothing.scene(), Simd::PORTABLE, 0);
        let ladder = baked.scene();
        let gaze = GAZES[number % GAZES.len()];
        let exact = reference(gaze);
        let eyes = eyes(Some(lod(gaze)));
        for &(size, samples_a_pixel) in sizes {
            let options = samples(samples_a_pixel);
            let most = options.settings.depth;
            let found = frame(ladder, size, &eyes, &options);
            for (number, (view, eye)) in views(size, &eyes).iter().enumerate() {
                let renderer = renderer(&ladder, eye, &options, Spectrum::Rgb).unwrap();
                for at in places(view) {
                    self.pixels += 1;
                    let sight = exact_sight(&exact, view, at);
                    let steps = sight.level * f64::from(most);
                    let is_between = sight.zone == Zone::Peripheral;
                    let is_near = (steps - steps.round()).abs() < ROUNDING * f64::from(most);
                    if is_on_a_border(&sight) || is_between && is_near {
                        self.undecided += 1;
                        continue;
                    }
                    let of = |tracer: &Tracer<'_>| bits(pixel(tracer, view, at, samples_a_pixel));
                    let what = || {
                        let name = &scene.name;
                        format!("{name}, {gaze:?}, {size:?}, picture {number}, {at:?}")
                    };
                    let picture = &found.pictures[number].picture;
                    let seen = bits(picture.pixel(at.0, at.1).expect("a pixel"));
                    let detail = renderer.detail(view, at.0, at.1);
                    if sight.zone == Zone::Outside {
                        assert_eq!(detail, None, "{}", what());
                        assert_eq!(seen, of(&nothing), "{}", what());
                        continue;
                    }
                    let detail = detail.expect("a pixel in the field is traced");
                    let depth = bounces(sight.level, most);
                    assert_eq!(detail.depth, depth, "{}", what());
                    let rung = usize::from(detail.rung);
                    let tracer = |scene, depth| Tracer::<8>::new(scene, Simd::PORTABLE, depth);
                    assert_eq!(seen, of(&tracer(alone[rung], depth)), "{}", what());
                    self.used[rung] += 1;
                    self.shallow += u64::from(depth < most);
                    self.other += u64::from(seen != of(&tracer(alone[0], most)));
                }
            }
        }
    }
}

#[test]
fn frames_are_those_of_a_slow_renderer() {
    // Both mirrors and the mixed scene, which has clay in it, at least.
    let every = cases("every nth scene", 2, 1);
    for (name, mesh) in meshes() {
        let rungs = rungs_as_meshes(&mesh);
        let mut met = Met::default();
        for (number, scene) in scenes(&mesh).into_iter().enumerate().step_by(every) {
            let alone: Vec<Baked<8>> = rungs
                .iter()
                .map(|rung| {
                    let scene = Scene {
                        meshes: vec![rung.clone()],
                        ..scene.clone()
                    };
                    Baked::new(&scene).expect("a scene")
                })
                .collect();
            // Once: a scene is checked whenever it is taken out of its bytes.
            let alone: Vec<_> = alone.iter().map(Baked::scene).collect();
            met.compare(&scene, &alone, number, &[([27, 30], 1), ([14, 11], 4)]);
        }
        println!("{name}: {met:?}");
        assert!(met.undecided * 1000 < met.pixels);
        assert!(met.used.iter().filter(|&&pixels| pixels > 0).count() >= 12);
        assert!(met.shallow > 1000 && met.other > 100);
    }
}

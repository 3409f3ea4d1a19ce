//! Scenes of meshes with too few faces for a ladder.

use super::{GAZES, bits, eyes, frame, lod, mixed_scene, pixel, places, samples, views};
use shisen::bake::Baked;
use shisen::bake::simplify::PolygonLevels;
use shisen::render::renderer;
use shisen_core::Simd;
use shisen_core::frame::Spectrum;
use shisen_core::trace::Tracer;
use shisen_tests::meshes::icosphere;

fn assert_traced_as_told(name: &str, baked: &Baked<8>) {
    let scene = baked.scene();
    for gaze in [GAZES[0], GAZES[2]] {
        let (size, options) = ([33, 29], samples(1));
        let eyes = eyes(Some(lod(gaze)));
        let found = frame(&scene, size, &eyes, &options);
        let mut hit = 0;
        for (number, (view, eye)) in views(size, &eyes).iter().enumerate() {
            let renderer = renderer(&scene, eye, &options, Spectrum::Rgb).unwrap();
            for at in places(view) {
                let picture = &found.pictures[number].picture;
                let seen = picture.pixel(at.0, at.1).expect("a pixel");
                assert!(seen.iter().all(|c| c.is_finite()), "{name}: {at:?}");
                let Some(detail) = renderer.detail(view, at.0, at.1) else {
                    continue;
                };
                let tracer = Tracer::new(scene, Simd::PORTABLE, detail.depth);
                let expected = pixel(&tracer.at_rung(detail.rung), view, at, 1);
                assert_eq!(bits(seen), bits(expected), "{name}, {gaze:?}, {at:?}");
                hit += u32::from(seen[3] > 0.26);
            }
        }
        assert!(hit > 100, "{name}: only {hit} pixels hit");
    }
}

#[test]
fn ladders_of_meshes_with_too_few_faces() {
    // One mesh of a ladder beside one that is as coarse as it may get.
    let mut scene = mixed_scene(icosphere(1));
    scene.meshes.push(icosphere(4));
    for object in scene.objects.iter_mut().step_by(2) {
        if object.shape == shisen::scene::Shape::Mesh(0) {
            object.shape = shisen::scene::Shape::Mesh(1);
        }
    }
    let levels = PolygonLevels::new(500..=u32::MAX, 16).expect("levels");
    let baked = Baked::<8>::with_levels(&scene, &levels).expect("a scene");
    let faces: Vec<_> = baked
        .scene()
        .meshes()
        .iter()
        .map(|m| (m.rungs, m.faces))
        .collect();
    assert_eq!(faces[0], (1, 80));
    assert_eq!(faces[1], (16, 5120));
    assert_eq!(faces.len(), 17);
    assert_traced_as_told("few faces", &baked);
    let only_few = mixed_scene(icosphere(0));
    let baked = Baked::<8>::with_levels(&only_few, &levels).expect("a scene");
    assert_traced_as_told("20 faces", &baked);
}

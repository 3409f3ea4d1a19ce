//! Scenes of meshes with too few faces for a ladder.

use super::{GAZES, bits, eyes, frame, lod, mixed_scene, pixel, places, samples, views};
use shisen::bake::Baked;
use shisen::bake::simplify::PolygonLevels;
use shisen::render::renderer;
use shisen_core::Simd;
use shisen_core::frame::Spectrum;
use shisen_core::trace::Tracer;
use shisen_tests::meshes::icosphere;

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
    let scene = baked.scene();
    let faces = scene.meshes().iter().map(|m| (m.rungs, m.faces));
    let faces: Vec<_> = faces.collect();
    assert_eq!((faces[0], faces[1], faces.len()), ((1, 80), (16, 5120), 17));
    for gaze in [GAZES[0], GAZES[2]] {
        let (size, options) = ([33, 29], samples(1));
        let eyes = eyes(Some(lod(gaze)));
        let found = frame(scene, size, &eyes, &options);
        let mut hit = 0;
        for ((view, eye), shown) in views(size, &eyes).iter().zip(&found.pictures) {
            let renderer = renderer(&scene, eye, &options, Spectrum::Rgb).unwrap();
            for at in places(view) {
                let seen = shown.picture.pixel(at.0, at.1).expect("a pixel");
                let Some(detail) = renderer.detail(view, at.0, at.1) else {
                    continue;
                };
                let tracer = Tracer::new(scene, Simd::PORTABLE, detail.depth);
                let expected = pixel(&tracer.at_rung(detail.rung), view, at, 1);
                assert_eq!(bits(seen), bits(expected), "{gaze:?}, {at:?}");
                hit += u32::from(seen[3] > 0.26);
            }
        }
        assert!(hit > 100, "only {hit} pixels hit");
    }
}

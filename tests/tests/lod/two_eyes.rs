//! Two eyes that have one line of sight, or one each.

use super::{GAZES, eyes, frame, levels, lod, mixed_scene, samples};
use glam::Vec3;
use shisen::bake::Baked;
use shisen::render::Observer;

/// Both eyes look at a point.
fn fixating(point: Vec3) -> [Observer; 2] {
    eyes(None).map(|eye| Observer {
        lod: Some(lod((point - eye.place.as_vec3(), Vec3::Y))),
        ..eye
    })
}

#[test]
fn each_eye_has_its_own_detail() {
    let (size, options) = ([45, 38], samples(1));
    let baked = Baked::<8>::with_levels(
        &mixed_scene(shisen::scene::quadruped::quadruped()),
        &levels(),
    );
    let baked = baked.expect("a scene");
    let scene = baked.scene();
    let mut ways = vec![
        fixating(Vec3::new(0.1, -0.2, -0.4)),
        fixating(Vec3::new(1.2, -0.3, -0.9)),
        eyes(Some(lod(GAZES[2]))),
    ];
    // As different as they can be: to opposite sides, and one without any.
    let [mut left, mut right] = eyes(None);
    left.lod = Some(lod((Vec3::NEG_Y, Vec3::NEG_Z)));
    right.lod = Some(lod((Vec3::X, Vec3::Y)));
    ways.push([left, right]);
    right.lod = None;
    ways.push([left, right]);
    for eyes in ways {
        let both = frame(&scene, size, &eyes, &options);
        for eye in eyes {
            let alone = frame(&scene, size, &[eye], &options);
            let of_both = both.pictures.iter().filter(|one| one.eye == eye.eye);
            assert!(of_both.eq(&alone.pictures), "{eyes:?}");
        }
    }
}

//! Two eyes that have one line of sight, or one each.

use super::{
    GAZES, direction, eyes, frame, level, levels, lod, mixed_scene, places, room, samples, views,
};
use glam::Vec3;
use shisen::bake::Baked;
use shisen::cave::{Eye, Viewer};
use shisen::render::Observer;
use shisen_core::frame::View;

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

/// The pixel of a view that a point is seen through, where it has one.
fn pixel_towards(view: &View, point: Vec3) -> Option<(u32, u32)> {
    let towards = (point - view.eye()).normalize();
    let (at, cosine) = places(view)
        .map(|at| {
            let direction = direction(view, at);
            (at, direction.normalize().dot(towards))
        })
        .max_by(|a, b| a.1.total_cmp(&b.1))?;
    // Half a pixel's width, at the wall's middle, and some more.
    let first = direction(view, (0, 0));
    let pixel = (direction(view, (1, 0)) - first).length() / first.length();
    (cosine > (1.5 * pixel).cos()).then_some(at)
}

#[test]
fn the_central_field_of_each_eye_is_about_the_point_that_both_look_at() {
    let size = [96; 2];
    // So close that the lines of sight are 8° apart, and the point's pictures
    // on the wall many pixels.
    for point in [Vec3::new(0.02, -0.05, -0.45), Vec3::new(0.4, 0.05, -0.2)] {
        let eyes = fixating(point);
        let mut seen = Vec::new();
        for (view, eye) in views(size, &eyes) {
            let Some(at) = pixel_towards(&view, point) else {
                continue;
            };
            let lod = eye.lod.expect("a line of sight");
            let towards = direction(&view, at);
            let sight = lod.gaze.sight(towards).expect("a direction");
            assert!(sight.l < 0.02, "{point}: {sight:?}");
            // All around, as far as the central field goes, it is level 1.
            for (x, y) in places(&view) {
                let direction = direction(&view, (x, y)).normalize();
                let angle = direction.dot((point - view.eye()).normalize()).acos();
                if angle < 28.7f32.to_radians() {
                    assert_eq!(level(&lod, &view, (x, y)), 1.0, "{point}, {x} {y}");
                }
            }
            seen.push((eye.eye, at));
        }
        let [left, right] = Eye::STEREO.map(|which| {
            let mut of_eye = seen.iter().filter(|(eye, _)| *eye == which);
            of_eye.next().expect("a wall that the point is seen on").1
        });
        println!("{point}: through pixel {left:?} by the left eye, {right:?} by the right");
        assert!(left.0 > right.0 + 2, "crossed: it is before the wall");
    }
}

#[test]
fn with_one_line_of_sight_the_eyes_mirror_each_other() {
    // Straight ahead, the left eye's front wall and floor are the right eye's
    // in a mirror.
    let lod = lod(GAZES[0]);
    let size = [64, 51];
    let walls = room(size).walls;
    let views = views(size, &eyes(Some(lod)));
    for (wall, pair) in walls.iter().zip(views.chunks(2)) {
        let [(left, _), (right, _)] = pair else {
            panic!("two eyes");
        };
        let mut largest = 0.0f32;
        for (x, y) in places(left) {
            let mirrored = (left.columns() - 1 - x, y);
            let apart = (level(&lod, left, (x, y)) - level(&lod, right, mirrored)).abs();
            largest = largest.max(apart);
        }
        println!("{}: levels up to {largest:e} apart", wall.name);
        if wall.name == "right" {
            // It is nearer to the right eye.
            assert!(largest > 1.0e-3);
        } else {
            assert!(largest < 2.0e-6, "{}", wall.name);
        }
    }
    // And the two lines of sight are one: the eyes' distance does not matter.
    let viewer = Viewer::default();
    let [left, right] = Eye::STEREO.map(|eye| viewer.eye(eye));
    assert!(left.distance(right) > 0.05);
}

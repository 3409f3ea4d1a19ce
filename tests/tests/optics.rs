//! Closed forms of light: what a picture must show, worked out by hand.
//!
//! Panels without lights shine with the ambient light times their colour,
//! which makes them emitters of known radiance.

use glam::{DAffine3, DQuat, DVec3};
use shisen::bake::Baked;
use shisen::scene::material::Material;
use shisen::scene::mesh::TriangleMesh;
use shisen::scene::texture::{Pattern, Texture};
use shisen::scene::{Background, Light, Scene, Shape};
use shisen_core::Simd;
use shisen_core::frame::{Budget, LEAST_WEIGHT, MAX_DEPTH, Pixel, Workspace};
use shisen_core::scene::EffectSet;
use shisen_core::shape::Ray;
use shisen_core::trace::Tracer;
use shisen_tests::scenes::{empty, object};

const RED: [f32; 3] = [1.0, 0.0, 0.0];
const GREEN: [f32; 3] = [0.0, 1.0, 0.0];

fn black() -> Material {
    Material {
        diffuse: [0.0; 3],
        ..Material::default()
    }
}

fn matt(colour: [f32; 3]) -> Material {
    Material {
        diffuse: colour,
        ..Material::default()
    }
}

fn glass(index_of_refraction: f32) -> Material {
    Material {
        transmission: [1.0; 3],
        index_of_refraction,
        ..black()
    }
}

fn add(scene: &mut Scene, shape: Shape, material: Material, map: DAffine3) {
    scene
        .objects
        .push(object(shape, scene.materials.len(), map));
    scene.materials.push(material);
}

fn add_sphere(scene: &mut Scene, radius: f32, centre: DVec3, material: Material) {
    let map = DAffine3::from_translation(centre);
    add(scene, Shape::Sphere { radius }, material, map);
}

/// Adds the convex body of the half-spaces' corners, as a fan of quadrilaterals.
fn add_body(scene: &mut Scene, positions: &[[f32; 3]], faces: &[&[u32]], material: Material) {
    let triangles = faces
        .iter()
        .flat_map(|face| (2..face.len()).map(|i| [face[0], face[i - 1], face[i]]))
        .collect();
    scene.meshes.push(TriangleMesh {
        positions: positions.to_vec(),
        triangles,
        ..TriangleMesh::default()
    });
    let mesh = Shape::Mesh(scene.meshes.len() - 1);
    add(scene, mesh, material, DAffine3::IDENTITY);
}

/// Adds a box from corner to corner, faces outwards.
fn add_box(scene: &mut Scene, low: [f32; 3], high: [f32; 3], material: Material) {
    let corners: Vec<[f32; 3]> = (0..8)
        .map(|i| [0, 1, 2].map(|axis| if i >> axis & 1 == 0 { low } else { high }[axis]))
        .collect();
    let faces: [&[u32]; 6] = [
        &[0, 4, 6, 2],
        &[1, 3, 7, 5],
        &[0, 1, 5, 4],
        &[2, 6, 7, 3],
        &[0, 2, 3, 1],
        &[4, 5, 7, 6],
    ];
    add_body(scene, &corners, &faces, material);
}

/// Adds a box that reaches `half` metres to all sides of the z axis, between two values of z.
fn add_wall(scene: &mut Scene, half: f32, [from, to]: [f32; 2], material: Material) {
    add_box(scene, [-half, -half, from], [half, half, to], material);
}

/// Returns what the eye sees, the same in both layouts.
fn seen(scene: &Scene, depth: u8, origin: [f32; 3], direction: [f32; 3]) -> Pixel {
    seen_without(EffectSet::empty(), scene, depth, origin, direction)
}

fn seen_without(
    effects: EffectSet,
    scene: &Scene,
    depth: u8,
    origin: [f32; 3],
    direction: [f32; 3],
) -> Pixel {
    let ray = Ray::new(origin.into(), direction.into()).expect("a ray");
    let (mut budget, mut workspace) = (Budget::UNLIMITED, Workspace::new());
    let fast = Baked::<8>::new(scene).expect("a scene");
    let tracer = Tracer::new(fast.scene(), Simd::detect(), depth).without(effects);
    let pixel = tracer.radiance(&ray, &mut budget, &mut workspace);
    let compact = Baked::<4>::new(scene).expect("a scene");
    let tracer = Tracer::new(compact.scene(), Simd::PORTABLE, depth).without(effects);
    assert_eq!(pixel, tracer.radiance(&ray, &mut budget, &mut workspace));
    pixel
}

#[track_caller]
fn assert_near(found: f32, expected: f64, tolerance: f64) {
    assert!(
        (f64::from(found) - expected).abs() <= tolerance,
        "{found}, expected {expected}"
    );
}

#[test]
fn parallel_mirrors_give_a_geometric_series_that_ends_at_the_depth() {
    for mirror in [0.9f32, 0.5] {
        let mut scene = empty();
        let chrome = Material {
            mirror: [mirror; 3],
            ..matt([0.25, 0.25, 0.25])
        };
        add_wall(&mut scene, 5.0, [-2.0, -1.0], chrome.clone());
        add_wall(&mut scene, 5.0, [1.0, 2.0], chrome);
        let m = f64::from(mirror);
        for depth in 0..=MAX_DEPTH {
            // A little askew, so that no ray meets its own start.
            let pixel = seen(&scene, depth, [0.1, -0.2, 0.3], [0.01, 0.02, -1.0]);
            let expected: f64 = (0..=i32::from(depth))
                .map(|k| m.powi(k))
                .filter(|&weight| weight >= f64::from(LEAST_WEIGHT))
                .map(|weight| 0.25 * weight)
                .sum();
            assert_near(pixel.red, expected, 1e-6 * expected);
            assert_eq!(pixel.alpha, 1.0);
        }
    }
}

/// Glass from z = −0.5 to 0.5, green behind it and red before it (behind the
/// eye).
fn slab(index: f32) -> Scene {
    let mut scene = empty();
    add_wall(&mut scene, 9.0, [-0.5, 0.5], glass(index));
    add_wall(&mut scene, 9.0, [-4.0, -3.0], matt(GREEN));
    add_wall(&mut scene, 9.0, [5.0, 6.0], matt(RED));
    scene
}

#[test]
fn a_slab_splits_light_into_fresnels_series() {
    for index in [1.33f32, 1.5, 2.4] {
        let n = f64::from(index);
        let r = ((n - 1.0) / (n + 1.0)).powi(2);
        let scene = slab(index);
        for depth in 0..=8u8 {
            // Through after 2, 4, 6 … borders; back after 1, 3, 5 …. What is not
            // followed further inside leaves at once.
            let (mut through, mut back) = (0.0, 0.0);
            let mut inside = 1.0 - r;
            if depth >= 1 {
                back += r;
            }
            for borders in 2..=depth {
                let stays = inside * r;
                let is_followed = borders < depth && stays >= f64::from(LEAST_WEIGHT);
                let leaves = if is_followed { inside - stays } else { inside };
                *(if borders % 2 == 0 {
                    &mut through
                } else {
                    &mut back
                }) += leaves;
                inside -= leaves;
            }
            let pixel = seen(&scene, depth, [0.3, 0.2, 3.0], [0.0, 0.0, -1.0]);
            assert_near(pixel.green, through, 2e-6);
            assert_near(pixel.red, back, 2e-6);
        }
    }
}

#[test]
fn a_slab_under_an_angle_agrees_with_fresnel_and_leaves_the_direction() {
    for degrees in [20.0f64, 50.0, 75.0] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let n = 1.5;
        let sin_inside = sin / n;
        let cos_inside = (1.0 - sin_inside * sin_inside).sqrt();
        let s = (cos - n * cos_inside) / (cos + n * cos_inside);
        let p = (cos_inside - n * cos) / (cos_inside + n * cos);
        let r = f64::midpoint(s * s, p * p);
        let mut scene = empty();
        add_wall(&mut scene, 9.0, [-0.5, 0.5], glass(1.5));
        // A small target where the shifted ray, of the same direction, goes.
        let entry = 0.0;
        let leaves = entry + sin_inside / cos_inside;
        let target = DVec3::new(leaves + 3.0 * sin / cos, 0.01, -3.5);
        add_sphere(&mut scene, 0.005, target, matt(GREEN));
        let origin = [(entry - sin / cos) as f32, 0.01, 1.5];
        let pixel = seen(&scene, 3, origin, [sin as f32, 0.0, -cos as f32]);
        assert_near(pixel.green, (1.0 - r).powi(2), 3e-6);
    }
}

#[test]
fn a_prism_turns_light_by_total_reflection() {
    // A right angle at the origin; legs along +x and +y, light enters the
    // leg x = 0 … along +x, turns at the hypotenuse and leaves by y = 0.
    let mut scene = empty();
    let ends = [-1.0, 1.0].map(|z| [[0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]]);
    let positions = ends.as_flattened();
    let faces: [&[u32]; 5] = [
        &[0, 2, 1],
        &[3, 4, 5],
        &[0, 1, 4, 3],
        &[0, 3, 5, 2],
        &[1, 2, 5, 4],
    ];
    add_body(&mut scene, positions, &faces, glass(1.5));
    add_box(
        &mut scene,
        [-5.0, -3.0, -5.0],
        [5.0, -2.0, 5.0],
        matt(GREEN),
    );
    add_box(&mut scene, [3.0, -1.0, -5.0], [4.0, 5.0, 5.0], matt(RED));
    let r = 0.04f64;
    let view = |scene: &Scene, depth| seen(scene, depth, [-2.0, 0.4, 0.1], [1.0, 0.0, 0.0]);
    assert_near(view(&scene, 4).green, (1.0 - r).powi(2), 2e-6);
    // The last bounce lets everything out.
    assert_near(view(&scene, 3).green, 1.0 - r, 2e-6);
    assert_eq!(view(&scene, 3).red, 0.0, "light got through the hypotenuse");
    assert_eq!(
        view(&scene, 2).green,
        0.0,
        "three borders take three bounces"
    );
    // Below the critical index of √2 some light goes on, bent away.
    scene.materials[0].index_of_refraction = 1.3;
    assert!(view(&scene, 3).red > 0.5);
}

#[test]
fn glass_absorbs_by_beers_law() {
    for absorption in [0.1f32, 1.0, 3.0] {
        for (direction, length) in [([0.0, 0.0, -1.0], 1.0), ([0.6, 0.0, -0.8], 1.25f64)] {
            let mut scene = slab(1.0);
            scene.materials[0].absorption = [0.0, absorption, 0.0];
            let pixel = seen(&scene, 2, [0.3, 0.2, 3.0], direction);
            // Rays start clear of the surface, by some 50 µm where corners are
            // 9 m out.
            let deep = f64::from(absorption) * length;
            assert_near(pixel.green, (-deep).exp(), 2e-4 * deep * (-deep).exp());
            assert_eq!(pixel.red, 0.0, "no border, no reflection");
        }
    }
    // Directions of any length, and a map that scales, are still metres.
    let mut scene = slab(1.0);
    scene.materials[0].absorption = [1.0; 3];
    scene.objects[0].world_from_object = DAffine3::from_scale(DVec3::new(1.0, 1.0, 2.0));
    let pixel = seen(&scene, 2, [0.3, 0.2, 3.0], [0.0, 0.0, -7.0]);
    assert_near(pixel.green, (-2.0f64).exp(), 1e-4);
}

#[test]
fn spheres_and_spheroids_face_along_their_gradient() {
    let light = DVec3::new(1.0, 2.0, 3.0).normalize();
    let mut scene = empty();
    scene.ambient = [0.0; 3];
    scene.lights.push(Light::Directional {
        direction: -light,
        colour: [1.0; 3],
    });
    let turn = DQuat::from_rotation_z(0.5);
    let spheroid = Shape::Spheroid {
        equatorial_radius: 1.0,
        polar_radius: 0.5,
    };
    add(
        &mut scene,
        spheroid,
        matt([1.0; 3]),
        DAffine3::from_quat(turn),
    );
    let mut lit = 0;
    for i in 0..200 {
        let (x, y) = (-0.9 + 0.009 * f64::from(i), 0.31 - 0.002 * f64::from(i));
        let pixel = seen(&scene, 0, [x as f32, y as f32, 5.0], [0.0, 0.0, -1.0]);
        // The quadratic in z, in the turned frame, in f64.
        let scale = DVec3::new(1.0, 0.5, 1.0);
        let (o, d) = (DVec3::new(x, y, 5.0), DVec3::NEG_Z);
        let (o, d) = (turn.inverse() * o / scale, turn.inverse() * d / scale);
        let (a, h, c) = (d.dot(d), o.dot(d), o.dot(o) - 1.0);
        let Some(root) = Some(h * h - a * c).filter(|&root| root > 1e-3) else {
            continue;
        };
        let point = o + d * ((-h - root.sqrt()) / a);
        let normal = (turn * (point / scale)).normalize();
        assert_near(pixel.red, normal.dot(light).max(0.0), 1e-5);
        lit += i32::from(pixel.red > 0.0);
    }
    assert!(lit > 100, "{lit}");
}

/// Returns a wide floor under a light, which is all that lights it.
fn floor(light: Light) -> Scene {
    let mut scene = empty();
    scene.ambient = [0.0; 3];
    add_box(
        &mut scene,
        [-50.0, -1.0, -50.0],
        [50.0, 0.0, 50.0],
        matt([0.5; 3]),
    );
    scene.lights.push(light);
    scene
}

#[test]
fn point_lights_fall_off_and_cast_shadows() {
    let look = |scene: &Scene| seen(scene, 0, [0.0, 3.0, 4.0], [0.0, -3.0, -4.0]).green;
    for (x, height) in [(0.0f64, 1.0f64), (0.0, 5.0), (2.0, 3.0), (30.0, 40.0)] {
        let position = DVec3::new(x, height, 0.0);
        let distance2 = position.length_squared();
        let cosine = height / distance2.sqrt();
        for inverse_square in [true, false] {
            let mut scene = floor(Light::Point {
                position,
                colour: [8.0; 3],
                inverse_square,
            });
            let expected = 0.5 * 8.0 * cosine / if inverse_square { distance2 } else { 1.0 };
            assert_near(look(&scene), expected, 1e-6 * expected);
            // Something past the light, or beside the way, changes nothing.
            add_sphere(&mut scene, 0.1, 1.2 * position, matt([1.0; 3]));
            let beside = DVec3::new(x - 0.4, 0.5 * height, 0.0);
            add_sphere(&mut scene, 0.1, beside, matt([1.0; 3]));
            assert_near(look(&scene), expected, 1e-6 * expected);
            add_sphere(&mut scene, 0.1, 0.5 * position, matt([1.0; 3]));
            assert_eq!(look(&scene), 0.0, "a ball between them");
            // What is told not to casts no shadow, and what is clear hardly one.
            scene.objects.last_mut().expect("the ball").casts_shadow = false;
            assert_near(look(&scene), expected, 1e-6 * expected);
            *scene.materials.last_mut().expect("the ball's") = glass(1.0);
            scene.objects.last_mut().expect("the ball").casts_shadow = true;
            assert_near(look(&scene), expected, 1e-6 * expected);
        }
    }
}

#[test]
fn a_spot_is_full_within_its_cone_and_falls_off_to_its_border() {
    let (full, none) = (20f64.to_radians(), 35f64.to_radians());
    let look = |x: f64| {
        let spot = Light::Spot {
            position: DVec3::new(x, 2.0, 0.0),
            direction: DVec3::NEG_Y,
            cone: [full, none],
            colour: [8.0; 3],
            inverse_square: false,
        };
        seen(&floor(spot), 0, [0.0, 3.0, 4.0], [0.0, -3.0, -4.0]).green
    };
    for degrees in [0.0f64, 15.0, 19.9, 22.0, 28.0, 34.0, 35.1, 60.0] {
        let angle = degrees.to_radians();
        let share = (angle.cos() - none.cos()) / (full.cos() - none.cos());
        let expected = 4.0 * angle.cos() * share.clamp(0.0, 1.0).powi(2);
        assert_near(look(2.0 * angle.tan()), expected, 1e-5);
    }
}

#[test]
fn a_texture_stains_glass_but_not_what_is_behind_a_veil() {
    let seen_through = |material: Material| {
        let mut scene = empty();
        scene.background = Background::uniform([1.0; 3]);
        add_sphere(&mut scene, 1.0, DVec3::ZERO, material);
        seen(&scene, 4, [0.2, 0.1, 3.0], [0.0, 0.0, -1.0])
    };
    let colour = [0.25, 0.5, 0.75];
    let stained = |index| Material {
        texture: Some(Texture::new(Pattern::Checker([colour; 2]), [1.0; 2])),
        ..glass(index)
    };
    let coloured = Material {
        transmission: colour,
        ..glass(1.5)
    };
    assert_eq!(seen_through(stained(1.5)), seen_through(coloured));
    assert_eq!(seen_through(stained(1.0)), seen_through(glass(1.0)));
}

#[test]
fn glass_before_a_transparent_background_covers_what_it_reflects() {
    for (index, transmission) in [(1.0f32, 1.0f32), (1.0, 0.7), (1.5, 1.0), (1.5, 0.9)] {
        let mut scene = empty();
        scene.background.alpha = 0.0;
        let material = Material {
            transmission: [transmission; 3],
            ..glass(index)
        };
        add_wall(&mut scene, 9.0, [-0.5, 0.5], material);
        let n = f64::from(index);
        let r = ((n - 1.0) / (n + 1.0)).powi(2);
        let border = f64::from(transmission) * (1.0 - r);
        // What goes in comes out on one side or the other: only the light off
        // the first border is the glass's own.
        for depth in 2..=4 {
            let (mut through, mut inside) = (0.0, border);
            for borders in 2..=depth {
                let stays = inside * r;
                let is_followed = borders < depth && stays >= f64::from(LEAST_WEIGHT);
                through += inside * border + if is_followed { 0.0 } else { stays };
                inside = if is_followed { stays } else { 0.0 };
            }
            let pixel = seen(&scene, depth, [0.3, 0.2, 3.0], [0.0, 0.0, -1.0]);
            assert_near(pixel.alpha, 1.0 - through, 2e-6);
        }
        let past = seen(&scene, 4, [20.0, 0.2, 3.0], [0.0, 0.0, -1.0]);
        assert_eq!(past, Pixel::default());
    }
    // A mirror covers all, whatever it shows.
    let mut scene = empty();
    scene.background.alpha = 0.0;
    let mirror = Material {
        mirror: [0.5; 3],
        ..black()
    };
    add_sphere(&mut scene, 1.0, DVec3::ZERO, mirror);
    let covered = seen(&scene, 3, [0.1, 0.2, 3.0], [0.0, 0.0, -1.0]);
    assert_eq!(covered.alpha, 1.0);
}

#[test]
fn a_half_covering_background_is_premultiplied_but_whole_in_a_mirror() {
    let mut scene = empty();
    scene.background = Background {
        alpha: 0.25,
        ..Background::uniform([0.5, 1.0, 2.0])
    };
    let mirror = Material {
        mirror: [1.0; 3],
        ..black()
    };
    add_wall(&mut scene, 1.0, [-2.0, -1.0], mirror);
    let past = seen(&scene, 1, [5.0, 0.0, 3.0], [0.0, 0.0, -1.0]);
    let channels = |pixel: Pixel| [pixel.red, pixel.green, pixel.blue, pixel.alpha];
    assert_eq!(channels(past), [0.125, 0.25, 0.5, 0.25]);
    let mirrored = seen(&scene, 1, [0.1, 0.2, 3.0], [0.0, 0.0, -1.0]);
    assert_eq!(channels(mirrored), [0.5, 1.0, 2.0, 1.0]);
}

/// Returns a ball of water in a ball of glass before a wall of lamps, whose lamps differ.
fn nested(glass: Material, water: Material) -> Scene {
    let mut scene = empty();
    scene.background = Background {
        zenith: [1.0, 0.0, 0.0],
        horizon: [0.1, 0.2, 0.3],
        nadir: [0.0, 1.0, 0.0],
        ..Background::uniform([0.0; 3])
    };
    add_sphere(&mut scene, 1.0, DVec3::ZERO, glass);
    add_sphere(&mut scene, 0.6, DVec3::new(0.1, 0.05, 0.0), water);
    scene
}

#[test]
fn water_within_glass_bends_light_by_the_ratio_of_their_indices() {
    let of = |index: f32, priority: u32, absorption: [f32; 3]| Material {
        priority,
        absorption,
        ..glass(index)
    };
    let blue = [2.0, 1.0, 0.1];
    let found = nested(of(1.5, 1, [0.0; 3]), of(1.333, 2, blue));
    // Without the effect a border says the same by the ratio alone.
    let expected = nested(of(1.5, 0, [0.0; 3]), of(1.333 / 1.5, 0, blue));
    // The second of two of one priority, or of none, fills the place; a lower one has no border.
    let equal = nested(of(1.5, 3, [0.0; 3]), of(1.333, 3, blue));
    let unsaid = nested(of(1.5, 0, [0.0; 3]), of(1.333, 0, blue));
    let lower = nested(of(1.5, 3, [0.0; 3]), of(1.333, 1, blue));
    let mut solid = nested(of(1.5, 0, [0.0; 3]), of(1.333, 0, blue));
    solid.objects.pop();
    // More of the same changes nothing.
    let mut onion = solid.clone();
    for radius in [0.9, 0.8, 0.7] {
        let mut skin = onion.objects[0].clone();
        skin.shape = Shape::Sphere { radius };
        onion.objects.push(skin);
    }
    // A stone is seen through all that is before it.
    let mut stone = nested(of(1.5, 1, [0.0; 3]), of(1.333, 2, blue));
    add_sphere(&mut stone, 0.3, DVec3::new(0.1, 0.05, 0.0), matt([1.0; 3]));
    let mut differs = 0.0f32;
    for step in 0..200 {
        let height = -0.99 + f64::from(step) / 100.0;
        let from = [0.05, height as f32, 5.0];
        let of = |pixel: Pixel| DVec3::new(pixel.red.into(), pixel.green.into(), pixel.blue.into());
        let look = |scene: &Scene| of(seen(scene, 5, from, [0.0, 0.0, -1.0]));
        let ratio = EffectSet::NESTED_MEDIA;
        let expected = of(seen_without(ratio, &expected, 5, from, [0.0, 0.0, -1.0]));
        let alone = look(&solid);
        let peeled = of(seen(&onion, 12, from, [0.0, 0.0, -1.0]));
        let whole = of(seen(&solid, 12, from, [0.0, 0.0, -1.0]));
        assert!(
            (peeled - whole).abs().max_element() < 2e-4,
            "{height}: {peeled} {whole}"
        );
        assert!(
            (look(&found) - expected).abs().max_element() < 2e-4,
            "{height}"
        );
        for one in [&equal, &unsaid] {
            assert!(
                (look(one) - expected).abs().max_element() < 2e-4,
                "{height}"
            );
        }
        assert!(
            (look(&lower) - alone).abs().max_element() < 1e-6,
            "{height}"
        );
        differs = differs.max((expected - alone).abs().max_element() as f32);
    }
    assert!(differs > 0.1);
    // Straight at the stone's middle: Fresnel's equations twice, and 0.3 m of water.
    let pixel = seen(&stone, 1 + 1, [0.1, 0.05, 5.0], [0.0, 0.0, -1.0]);
    let borders = [1.5f64, 1.5 / 1.333].map(|ratio| 1.0 - ((ratio - 1.0) / (ratio + 1.0)).powi(2));
    let water = borders[0] * borders[1] * (-0.3f64 * 2.0).exp();
    assert!(
        (f64::from(pixel.red) - water).abs() < 0.03,
        "{} {water}",
        pixel.red
    );
}

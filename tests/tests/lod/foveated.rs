//! Foveated sampling: as fine in the periphery as the eye resolves.

use super::{GAZES, bits, direction, eyes, frame, levels, lod, mixed_scene, places, views};
use glam::Vec3;
use shisen::bake::Baked;
use shisen::live::FOVEA;
use shisen::picture::Picture;
use shisen::render::{Observer, Options};
use shisen::scene::builtin::{PaperScene, paper_scene};
use shisen::scene::material::Material;
use shisen::scene::{Background, Object, Scene};
use shisen_core::Simd;
use shisen_core::frame::{Mode, Renderer};
use shisen_core::gaze::{Acuity, LineOfSight};
use shisen_tests::meshes::icosphere;
use shisen_tests::scenes::sphere;
use shisen_tests::ways::{self, options};

/// How many times as fast acuity falls in these small pictures, so that samples are as far apart
/// as in large ones.
const COARSE: f32 = 6.0;

fn pixel(picture: &Picture, (x, y): (u32, u32)) -> [f32; 4] {
    picture.pixel(x, y).expect("a pixel")
}

fn sight((forward, up): (Vec3, Vec3)) -> LineOfSight {
    LineOfSight::new(Vec3::ZERO, forward, up).expect("a line of sight")
}

/// Returns both eyes, whose acuity falls `times` as fast as usual.
fn foveated(gaze: (Vec3, Vec3), times: f32) -> [Observer; 2] {
    eyes(None).map(|eye| {
        let eye = Observer::foveated(eye.eye, eye.place, sight(gaze), 0.0);
        Observer {
            acuity: eye.acuity.map(|acuity| acuity.steeper(times)),
            ..eye
        }
    })
}

fn renderer<'a>(baked: &'a Baked<8>, mode: Mode, eye: &Observer) -> Renderer<'a> {
    let settings = ways::settings(mode, 1);
    let renderer = Renderer::new(baked.scene(), Simd::detect(), settings);
    let (lod, acuity) = (eye.lod.expect("a gaze"), eye.acuity.expect("an acuity"));
    renderer.with_foveation(lod, acuity)
}

#[test]
fn a_frame_has_one_hash() {
    let scene = mixed_scene(icosphere(3));
    let fast = Baked::<8>::with_levels(&scene, &levels()).expect("a scene");
    let compact = Baked::<4>::with_levels(&scene, &levels()).expect("a scene");
    let size = [61, 50];
    let mut hashes = Vec::new();
    for gaze in [GAZES[0], GAZES[4]] {
        let full = foveated(gaze, COARSE);
        // With the paper's levels, whose border crosses squares, and without them.
        let paper = full.map(|eye| Observer {
            lod: Some(lod(gaze)),
            ..eye
        });
        for eyes in [full, paper, eyes(Some(lod(gaze)))] {
            let single = options(1, 32, Mode::Single, Simd::PORTABLE);
            let reference = frame(fast.scene(), size, &eyes, &single);
            for mode in [Mode::Single, Mode::Tile] {
                for (threads, tile, simd) in [
                    (2, 8, Simd::detect()),
                    (1, 13, Simd::PORTABLE),
                    (3, 64, Simd::detect()),
                ] {
                    let options = options(threads, tile, mode, simd);
                    let found = frame(fast.scene(), size, &eyes, &options);
                    assert_eq!(found.hash(), reference.hash(), "{gaze:?}, {options:?}");
                    let found = frame(compact.scene(), size, &eyes, &options);
                    assert_eq!(
                        found.hash(),
                        reference.hash(),
                        "{gaze:?}, {options:?}, 4 wide"
                    );
                }
            }
            hashes.push(reference.hash());
        }
    }
    hashes.sort_unstable();
    hashes.dedup();
    assert_eq!(
        hashes.len(),
        6,
        "each gaze and each way has its own picture"
    );
}

#[test]
fn around_the_line_of_sight_every_pixel_is_what_it_would_be() {
    let baked = Baked::<8>::with_levels(&mixed_scene(icosphere(3)), &levels()).expect("a scene");
    let size = [180, 150];
    for gaze in [GAZES[0], GAZES[3]] {
        let eyes = foveated(gaze, 2.0);
        let found = frame(baked.scene(), size, &eyes, &Options::default());
        let full = eyes.map(|eye| Observer::new(eye.eye, eye.place));
        let full = frame(baked.scene(), size, &full, &Options::default());
        let (mut own, mut shared) = (0, 0);
        let pictures = found.pictures.iter().zip(&full.pictures);
        for ((view, eye), (found, full)) in views(size, &eyes).into_iter().zip(pictures) {
            let renderer = renderer(&baked, Mode::Tile, &eye);
            for (x, y) in places(&view) {
                if renderer.stride(&view, x, y) > 1 {
                    shared += 1;
                    continue;
                }
                own += 1;
                let of = |picture: &Picture| bits(pixel(picture, (x, y)));
                assert_eq!(of(&found.picture), of(&full.picture), "{x} {y}");
            }
        }
        assert!(
            own > 1_000 && shared > 10 * own,
            "{own} and {shared} pixels"
        );
    }
}

#[test]
fn the_fovea_has_every_ray_and_samples_are_as_close_as_the_eye_sees() {
    let baked = Baked::<8>::new(&mixed_scene(icosphere(0))).expect("a scene");
    let size = [1024; 2];
    for gaze in GAZES {
        let eyes = foveated(gaze, 1.0);
        for (view, eye) in views(size, &eyes) {
            let renderer = renderer(&baked, Mode::Tile, &eye);
            for (x, y) in places(&view).filter(|(x, y)| x % 5 == 0 && y % 5 == 0) {
                let stride = renderer.stride(&view, x, y);
                let towards = direction(&view, (x, y));
                let angle = towards.angle_between(sight(gaze).forward());
                // Pixels at the edge between walls appear under half the angle.
                if angle <= FOVEA && GAZES[..2].contains(&gaze) {
                    assert_eq!(stride, 1, "{x} {y}");
                }
                // Samples are no farther apart than the eye resolves there, give or take
                // the differences of pixels along a square's side.
                // A chord: the cosine of so small an angle is 1.
                let next = direction(&view, (x + 1, y)).normalize() - towards.normalize();
                let seen = Acuity::GUENTER.least_angle(angle);
                let apart = stride as f32 * next.length();
                assert!(stride == 1 || apart <= seen * 1.05, "{x} {y}: {stride}");
            }
        }
    }
}

/// Returns a scene with a shining sphere on black, to the right of the line of sight.
fn lamp() -> Scene {
    let mut scene = paper_scene(PaperScene::B, icosphere(0)).expect("a scene");
    scene.materials = vec![Material {
        diffuse: [0.0; 3],
        emission: [1.0; 3],
        ..Material::default()
    }];
    scene.objects = vec![Object {
        casts_shadow: false,
        ..sphere(0.7, 0, [3.0, 0.2, 0.1])
    }];
    scene.background = Background {
        zenith: [0.0; 3],
        horizon: [0.0; 3],
        nadir: [0.0; 3],
        ..scene.background
    };
    scene
}

#[test]
fn an_edge_in_the_periphery_stays_sharp() {
    let baked = Baked::<8>::new(&lamp()).expect("a scene");
    let size = [256; 2];
    let eyes = foveated(GAZES[0], 4.0);
    let found = frame(baked.scene(), size, &eyes, &Options::default());
    let full = eyes.map(|eye| Observer::new(eye.eye, eye.place));
    let full = frame(baked.scene(), size, &full, &Options::default());
    let (mut own, mut of_blocks, mut lit) = (0.0, 0.0, 0);
    let pictures = found.pictures.iter().zip(&full.pictures);
    for ((view, eye), (found, full)) in views(size, &eyes).into_iter().zip(pictures) {
        let renderer = renderer(&baked, Mode::Tile, &eye);
        let light = |x: u32, y: u32| pixel(&full.picture, (x.min(255), y.min(255)))[0];
        for (x, y) in places(&view) {
            let stride = renderer.stride(&view, x, y);
            let (seen, truth) = (pixel(&found.picture, (x, y))[0], light(x, y));
            // No pixel is between the lamp's colour and black.
            assert!(
                seen == 0.0 || (seen - 1.0).abs() < 1.0e-6,
                "{x} {y}: {seen}"
            );
            let sample = light(x / stride * stride, y / stride * stride);
            own += (seen - truth).abs();
            of_blocks += (sample - truth).abs();
            lit += u32::from(truth > 0.0 && stride >= 8);
            // A wrong pixel is near the edge: closer than half the distance of the
            // finest samples, diagonally.
            if (seen - truth).abs() > 0.5 {
                let near = (stride / 4).max(2);
                let around = (x.saturating_sub(near)..=x + near)
                    .flat_map(|x| (y.saturating_sub(near)..=y + near).map(move |y| (x, y)));
                let mut around = around.map(|(x, y)| light(x, y));
                assert!(around.any(|light| light == seen.round()), "{x} {y}");
            }
        }
    }
    println!("{own} pixels off, {of_blocks} by the nearest sample of each block");
    assert!(lit > 1_000, "{lit} lit pixels in the periphery");
    assert!(own < 0.4 * of_blocks, "{own} and {of_blocks}");
}

#[test]
fn an_unknown_gaze_is_sampled_more_finely() {
    let baked = Baked::<8>::new(&mixed_scene(icosphere(0))).expect("a scene");
    let [eye, _] = eyes(None);
    let sight = sight(GAZES[0]);
    let known = Observer::foveated(eye.eye, eye.place, sight, 0.0);
    let vague = Observer::foveated(eye.eye, eye.place, sight, 0.2);
    let unknown = Observer::foveated(eye.eye, eye.place, sight, 4.0);
    let ahead = Some(sight.forward());
    let all = Observer { ahead, ..eye };
    assert_eq!(unknown, all, "everything is traced");
    let mut finer = 0;
    for (view, _) in views([512; 2], &[eye]) {
        let (known, vague) = (
            renderer(&baked, Mode::Tile, &known),
            renderer(&baked, Mode::Tile, &vague),
        );
        for (x, y) in places(&view).filter(|(x, y)| x % 8 == 0 && y % 8 == 0) {
            let strides = (known.stride(&view, x, y), vague.stride(&view, x, y));
            assert!(strides.1 <= strides.0, "{x} {y}: {strides:?}");
            finer += u32::from(strides.1 < strides.0);
        }
    }
    assert!(finer > 1_000, "{finer}");
}

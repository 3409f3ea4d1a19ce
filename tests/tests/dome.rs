//! Dome masters through the renderer.

use glam::{Mat3, Vec3, Vec4};
use shisen::bake::Baked;
use shisen::picture::Picture;
use shisen::render;
use shisen::scene::Scene;
use shisen::scene::builtin::{PaperScene, grid, paper_scene};
use shisen_core::Simd;
use shisen_core::capture::{Mapping, SpheroidMirror};
use shisen_core::frame::{DomePose, DomeProjection, DomeScreen, MirrorCamera, Mode, View};
use shisen_tests::meshes::icosphere;
use shisen_tests::paths::Paths;
use shisen_tests::scenes;
use shisen_tests::ways::options;
use std::f32::consts::{PI, TAU};

const UPRIGHT: DomePose = DomePose::over_room(Vec3::ZERO);

fn camera(mirror: SpheroidMirror, mapping: Mapping) -> MirrorCamera {
    MirrorCamera {
        mirror,
        mapping,
        radius: 1.0e-3,
        viewpoint: mirror.screen_distance(),
        mirrored: false,
    }
}

/// Dome masters turned about all axes, and a dome that an eye beside its centre looks at.
fn views(size: u32) -> Vec<View> {
    let pose = DomePose {
        position: Vec3::ZERO,
        room_from_capture: Mat3::from_euler(glam::EulerRot::XYZ, 0.3, -1.1, 2.0),
    };
    let mirror = |mapping| DomeProjection::Mirror(camera(SpheroidMirror::BEST, mapping));
    let projections = [
        mirror(Mapping::Screen),
        mirror(Mapping::Exact),
        DomeProjection::Equidistant { field_of_view: PI },
        DomeProjection::Equisolid { field_of_view: TAU },
        DomeProjection::MirrorBall,
    ];
    let screen = DomeScreen {
        pose,
        radius: 2.0,
        field_of_view: 4.0,
    };
    let eye = Vec3::new(0.7, -0.2, 0.4);
    let masters = projections.map(|projection| View::dome(projection, pose, size));
    let all = masters
        .into_iter()
        .chain([View::dome_screen(screen, eye, size)]);
    all.collect::<Result<_, _>>().expect("domes")
}

fn small_scene() -> Scene {
    let mut scene = paper_scene(PaperScene::A, icosphere(2)).expect("a scene");
    scene.background.alpha = 0.25;
    scene
}

#[test]
fn the_same_bytes_come_from_any_threads_tiles_vectors_and_layouts() {
    let lod = scenes::lod(Vec3::ZERO, Vec3::new(0.3, 0.6, -1.0), Vec3::Y);
    for scene in [small_scene(), grid(0.1)] {
        let Paths { fast, compact } = Paths::new(&scene);
        for view in views(45) {
            for (samples, lod) in [(1, None), (1, Some(lod)), (5, None), (4, Some(lod))] {
                let options = |threads, tile, mode, simd| {
                    let mut options = options(threads, tile, mode, simd);
                    options.settings.samples = samples;
                    options
                };
                let single = options(1, 64, Mode::Single, Simd::PORTABLE);
                let reference = render::dome(fast.scene().into(), &view, lod, &single, &|_, _| ());
                let reference = reference.expect("a picture");
                for (threads, tile, simd, mode) in [
                    (1, 8, Simd::detect(), Mode::Single),
                    (3, 13, Simd::PORTABLE, Mode::Tile),
                    (2, 1, Simd::detect(), Mode::Tile),
                ] {
                    let options = options(threads, tile, mode, simd);
                    let fast = render::dome(fast.scene().into(), &view, lod, &options, &|_, _| ());
                    let found = fast.expect("a picture");
                    assert_eq!(found.picture, reference.picture, "{view:?} {options:?}");
                    let rays = [found.statistics, reference.statistics].map(|s| s.primary);
                    assert_eq!(rays[0], rays[1]);
                    let compact =
                        render::dome(compact.scene().into(), &view, lod, &options, &|_, _| ());
                    assert_eq!(compact.expect("a picture").picture, reference.picture);
                }
            }
        }
    }
}

const SIDE: u32 = 64;

fn picture(projection: DomeProjection) -> Picture {
    let baked = Baked::<8>::new(&small_scene()).expect("a scene");
    let view = View::dome(projection, UPRIGHT, SIDE).expect("a dome master");
    let options = options(1, 8, Mode::Tile, Simd::detect());
    let found = render::dome(baked.scene().into(), &view, None, &options, &|_, _| ());
    found.expect("a picture").picture
}

fn pixels() -> impl Iterator<Item = (u32, u32)> {
    (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y)))
}

#[test]
fn mirrored_pictures_are_left_as_mirrors_give_them() {
    for mapping in [Mapping::Screen, Mapping::Exact] {
        let [straight, flipped] = [false, true].map(|mirrored| {
            let camera = camera(SpheroidMirror::BEST_PARALLEL, mapping);
            picture(DomeProjection::Mirror(MirrorCamera { mirrored, ..camera }))
        });
        assert_ne!(straight, flipped);
        for (x, y) in pixels() {
            assert_eq!(straight.pixel(x, y), flipped.pixel(SIDE - 1 - x, y));
        }
    }
}

/// By a tiny mirror the picture is a fisheye's, also in the scene's mirrors.
#[test]
fn the_mirror_is_in_no_reflection_and_casts_no_shadow() {
    let camera = MirrorCamera {
        radius: 1.0e-6,
        ..camera(SpheroidMirror::BEST, Mapping::Exact)
    };
    let mirror = picture(DomeProjection::Mirror(camera));
    let fisheye = picture(DomeProjection::Equidistant { field_of_view: PI });
    let differs = |&(x, y): &(u32, u32)| {
        let [a, b] = [&mirror, &fisheye].map(|one| Vec4::from(one.pixel(x, y).expect("a pixel")));
        (a - b).abs().max_element() > 0.02
    };
    // A silhouette or two.
    assert!(pixels().filter(differs).count() <= 4);
}

#[test]
fn impossible_poses_and_projections_are_refused() {
    let lens = |field_of_view| DomeProjection::Equidistant { field_of_view };
    let good = camera(SpheroidMirror::BEST, Mapping::Screen);
    let [large, far] = [(1.0e7, good.viewpoint), (1.0, 1001.0)].map(|(radius, viewpoint)| {
        DomeProjection::Mirror(MirrorCamera {
            radius,
            viewpoint,
            ..good
        })
    });
    let distant = DomePose::over_room(Vec3::X * -1.0e12);
    let skewed = Mat3::from_cols(Vec3::X, Vec3::new(1.0e-3, 1.0, 0.0), Vec3::Z);
    let left_handed = Mat3::from_cols(Vec3::X, Vec3::Y, Vec3::NEG_Z);
    let turned = |room_from_capture| DomePose {
        position: Vec3::ZERO,
        room_from_capture,
    };
    for (projection, pose, size, expected) in [
        (lens(PI), distant, 8, "position"),
        (lens(PI), turned(skewed), 8, "right-handed"),
        (lens(PI), turned(left_handed), 8, "right-handed"),
        (lens(PI), UPRIGHT, 0, "pixels"),
        (lens(PI), UPRIGHT, View::MOST_PIXELS + 1, "pixels"),
        (lens(0.0), UPRIGHT, 8, "above 0, to 6.28"),
        (lens(TAU.next_up()), UPRIGHT, 8, "above 0, to 6.28"),
        (large, UPRIGHT, 8, "from 1e-9 to 1e6"),
        (far, UPRIGHT, 8, "viewpoint"),
    ] {
        let error = View::dome(projection, pose, size).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
    // A rotation is one whatever its rounding.
    let turned = turned(Mat3::from_rotation_y(1.0));
    assert!(View::dome(lens(PI), turned, 8).is_ok());
}

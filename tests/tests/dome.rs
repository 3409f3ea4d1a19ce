//! Dome masters through the renderer.

use glam::{DMat3, DVec2, Mat3, Vec3};
use shisen::bake::Baked;
use shisen::picture::Picture;
use shisen::render;
use shisen::scene::Scene;
use shisen::scene::builtin::{PaperScene, grid, paper_scene};
use shisen_core::Simd;
use shisen_core::capture::{Mapping, SpheroidMirror};
use shisen_core::frame::{
    DomePose, DomeProjection, DomeScreen, LevelOfDetail, MirrorCamera, Mode, View,
};
use shisen_tests::meshes::icosphere;
use shisen_tests::paths::Paths;
use shisen_tests::scenes;
use shisen_tests::ways::options;
use std::f32::consts::{PI, TAU};

const MAPPINGS: [Mapping; 2] = [Mapping::Screen, Mapping::Exact];

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

fn by_mirror(camera: MirrorCamera, pose: DomePose, size: u32) -> View {
    View::dome(DomeProjection::Mirror(camera), pose, size).expect("a dome master")
}

fn projections() -> Vec<DomeProjection> {
    let mirrors = MAPPINGS.map(|mapping| camera(SpheroidMirror::BEST, mapping));
    let mirrors = mirrors.into_iter().map(DomeProjection::Mirror);
    let lenses = [
        DomeProjection::Equidistant { field_of_view: PI },
        DomeProjection::Equisolid { field_of_view: TAU },
        DomeProjection::MirrorBall,
    ];
    mirrors.chain(lenses).collect()
}

/// Those turned about all axes, and a dome that an eye beside its centre looks at.
fn views(size: u32) -> Vec<View> {
    let pose = askew(Vec3::ZERO);
    let masters = projections()
        .into_iter()
        .map(|projection| View::dome(projection, pose, size).expect("a dome master"));
    let screen = DomeScreen {
        pose,
        radius: 2.0,
        field_of_view: 4.0,
    };
    let eye = Vec3::new(0.7, -0.2, 0.4);
    let screen = View::dome_screen(screen, eye, size).expect("a dome");
    masters.chain([screen]).collect()
}

/// Turned about all axes.
fn askew(position: Vec3) -> DomePose {
    let room_from_capture = Mat3::from_euler(glam::EulerRot::XYZ, 0.3, -1.1, 2.0);
    DomePose {
        position,
        room_from_capture,
    }
}

/// (u, v) of a pixel.
fn place((x, y): (u32, u32), size: u32) -> DVec2 {
    let size = f64::from(size);
    let at = |pixel: u32| (2.0 * f64::from(pixel) + 1.0 - size) / size;
    DVec2::new(at(x), -at(y))
}

#[test]
fn far_from_the_origin_directions_are_the_same() {
    let size = 256;
    for mapping in MAPPINGS {
        let camera = camera(SpheroidMirror::PAPER_SPHEROID, mapping);
        let here = by_mirror(camera, UPRIGHT, size);
        // 10⁵ radii off, where f32 has steps of a 128th of a radius.
        let off = Vec3::new(100.0, -30.0, 70.0);
        let there = by_mirror(camera, DomePose::over_room(off), size);
        for (x, y) in (0..size).flat_map(|y| (0..size).map(move |x| (x, y))) {
            let (x, y) = (x as f32, y as f32);
            let (a, b) = (here.ray(x, y), there.ray(x, y));
            assert_eq!(a.map(|r| r.direction()), b.map(|r| r.direction()));
            if let (Some(a), Some(b)) = (a, b) {
                // Half an ulp of each coordinate.
                let moved = b.origin() - off;
                assert!((moved - a.origin()).abs().max_element() <= 4.0e-6);
            }
        }
    }
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
                let reference = render::dome(&fast.scene(), &view, lod, &single, &|_, _| ());
                let reference = reference.expect("a picture");
                for (threads, tile, simd, mode) in [
                    (1, 8, Simd::detect(), Mode::Single),
                    (3, 13, Simd::PORTABLE, Mode::Tile),
                    (2, 1, Simd::detect(), Mode::Tile),
                ] {
                    let options = options(threads, tile, mode, simd);
                    let fast = render::dome(&fast.scene(), &view, lod, &options, &|_, _| ());
                    let found = fast.expect("a picture");
                    assert_eq!(found.picture, reference.picture, "{view:?} {options:?}");
                    let rays = [found.statistics, reference.statistics].map(|s| s.primary);
                    assert_eq!(rays[0], rays[1]);
                    let compact = render::dome(&compact.scene(), &view, lod, &options, &|_, _| ());
                    assert_eq!(compact.expect("a picture").picture, reference.picture);
                }
            }
        }
    }
}

fn render(scene: &Scene, view: &View, lod: Option<LevelOfDetail>, samples: u16) -> Picture {
    let baked = Baked::<8>::new(scene).expect("a scene");
    let mut options = options(1, 8, Mode::Tile, Simd::detect());
    options.settings.samples = samples;
    let picture = render::dome(&baked.scene(), view, lod, &options, &|_, _| ());
    picture.expect("a picture").picture
}

fn all(size: u32) -> impl Iterator<Item = (u32, u32)> {
    (0..size).flat_map(move |y| (0..size).map(move |x| (x, y)))
}

#[test]
fn outside_the_rim_is_transparent_and_costs_no_ray() {
    let scene = small_scene();
    let baked = Baked::<8>::new(&scene).expect("a scene");
    let size = 50;
    for projection in projections() {
        let view = View::dome(projection, UPRIGHT, size).expect("a dome master");
        let options = options(1, 8, Mode::Tile, Simd::detect());
        let found = render::dome(&baked.scene(), &view, None, &options, &|_, _| ());
        let found = found.expect("a picture");
        let mut inside = 0;
        for at in all(size) {
            let pixel = found.picture.pixel(at.0, at.1).expect("a pixel");
            if place(at, size).length() > 1.0 {
                assert_eq!(pixel, [0.0; 4]);
            } else {
                inside += 1;
                assert!(pixel[3] >= 0.25, "alpha is kept");
            }
        }
        assert_eq!(found.statistics.primary, inside);
        // The rim itself is covered as far as its samples are inside.
        let fine = render(&scene, &view, None, 64);
        let partly = all(size).filter(|&(x, y)| {
            let alpha = fine.pixel(x, y).expect("a pixel")[3];
            alpha > 0.0 && alpha < 0.24
        });
        assert!(partly.count() > 50);
    }
}

#[test]
fn mirrored_pictures_are_left_as_mirrors_give_them() {
    let scene = small_scene();
    let size = 48;
    for mapping in MAPPINGS {
        let camera = camera(SpheroidMirror::BEST_PARALLEL, mapping);
        let flipped = MirrorCamera {
            mirrored: true,
            ..camera
        };
        let straight = render(&scene, &by_mirror(camera, UPRIGHT, size), None, 1);
        let flipped = render(&scene, &by_mirror(flipped, UPRIGHT, size), None, 1);
        assert_ne!(straight, flipped);
        for (x, y) in all(size) {
            assert_eq!(straight.pixel(x, y), flipped.pixel(size - 1 - x, y));
        }
    }
}

#[test]
fn the_mirror_is_in_no_reflection_and_casts_no_shadow() {
    // Far beyond the mirror's size, the picture is a fisheye's: the mirror is
    // nowhere in the scene, in whose mirrors it would be seen.
    let scene = small_scene();
    let camera = MirrorCamera {
        radius: 1.0e-6,
        ..camera(SpheroidMirror::BEST, Mapping::Exact)
    };
    let size = 64;
    let lens = DomeProjection::Equidistant { field_of_view: PI };
    let fisheye = View::dome(lens, UPRIGHT, size).expect("a dome master");
    let mirror = render(&scene, &by_mirror(camera, UPRIGHT, size), None, 1);
    let fisheye = render(&scene, &fisheye, None, 1);
    let differ = all(size).filter(|&(x, y)| {
        let (a, b) = (mirror.pixel(x, y), fisheye.pixel(x, y));
        let apart = a
            .zip(b)
            .map(|(a, b)| (0..4).any(|c| (a[c] - b[c]).abs() > 0.02));
        apart == Some(true)
    });
    // A silhouette or two.
    assert!(differ.count() <= 4);
}

#[test]
fn grids_have_their_rings_where_a_true_dome_master_has() {
    let size = 512;
    let lens = DomeProjection::Equidistant { field_of_view: PI };
    let view = View::dome(lens, UPRIGHT, size).expect("a dome master");
    let picture = render(&grid(100.0), &view, None, 1);
    for at in all(size) {
        let pixel = place(at, size);
        let radius = pixel.length();
        if radius >= 1.0 {
            continue;
        }
        let longitude = pixel.y.atan2(pixel.x).to_degrees();
        let off = |angle: f64| (angle - (angle / 10.0).round() * 10.0).abs();
        let along = radius * 90.0;
        let across = (off(longitude).to_radians().sin() * along.to_radians().sin()).asin();
        let nearest = off(along).min(across.to_degrees());
        let white = picture.pixel(at.0, at.1) == Some([1.0; 4]);
        let black = picture.pixel(at.0, at.1) == Some([0.0, 0.0, 0.0, 1.0]);
        assert!(white || black);
        if (nearest - 0.15).abs() > 1.0e-3 {
            assert_eq!(white, nearest < 0.15, "{at:?} {nearest}");
        }
    }
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
    let turned = turned(DMat3::from_rotation_y(1.0).as_mat3());
    assert!(View::dome(lens(PI), turned, 8).is_ok());
}

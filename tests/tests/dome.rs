//! Dome masters through the renderer.

use glam::{DMat3, DVec2, DVec3, Mat3, Vec3};
use shisen::bake::Baked;
use shisen::dome::Mirror;
use shisen::picture::Picture;
use shisen::render::{self, Options};
use shisen::scene::Scene;
use shisen::scene::builtin::{PaperScene, grid, paper_scene};
use shisen_core::Simd;
use shisen_core::capture::{Mapping, SpheroidMirror};
use shisen_core::frame::{
    Budget, DomeError, DomePose, DomeProjection, DomeScreen, LevelOfDetail, MirrorCamera, Mode,
    Outcome, Pixel, Renderer, Settings, Tile, TileJob, View, Workspace,
};
use shisen_core::gaze::{Gaze, LineOfSight, VisualField};
use shisen_tests::meshes::icosphere;
use std::f32::consts::{PI, TAU};
use std::f64::consts::FRAC_PI_2;

const NAMED: [SpheroidMirror; 5] = [
    SpheroidMirror::PAPER_PARALLEL,
    SpheroidMirror::PAPER_SPHERE,
    SpheroidMirror::PAPER_SPHEROID,
    SpheroidMirror::BEST_PARALLEL,
    SpheroidMirror::BEST,
];

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

/// Pixels of a picture of 4096², as an angle between directions.
fn pixels_apart(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b)) / FRAC_PI_2 * 2048.0
}

/// Some pixels all over a picture: centre and rim too.
fn some_pixels(size: u32) -> Vec<(u32, u32)> {
    let (middle, last) = (size / 2, size - 1);
    let mut places = vec![(middle, middle), (middle - 1, middle)];
    places.extend([(middle, 0), (0, middle), (last, middle), (middle, last)]);
    for i in 0..64 {
        for j in 0..64 {
            places.push((i * last / 63, j * last / 63));
        }
    }
    places
}

#[test]
fn rays_are_the_mirrors_in_f64() {
    let size = 4096;
    let mut worst = [0f64; 2];
    for single in NAMED {
        let a = f64::from(single.axis_ratio());
        let double = match single.viewpoint() {
            None => Mirror::parallel(a),
            Some(p) => Mirror::perspective(a, f64::from(p)),
        }
        .expect("a mirror");
        let b1 = double.parameters().b1;
        let pose = askew(Vec3::ZERO);
        let room_from_capture = pose.room_from_capture.as_dmat3();
        for (worst, mapping) in worst.iter_mut().zip(MAPPINGS) {
            let view = by_mirror(camera(single, mapping), pose, size);
            for at in some_pixels(size) {
                let pixel = place(at, size);
                let ray = view.ray(at.0 as f32, at.1 as f32);
                if (pixel.length() - 1.0).abs() < 1.0e-6 {
                    continue;
                }
                assert_eq!(ray.is_some(), pixel.length() < 1.0, "{at:?}");
                let Some(ray) = ray else { continue };
                let exact = match mapping {
                    Mapping::Screen => double.reflect(pixel * b1).1,
                    Mapping::Exact => {
                        let theta = pixel.length() * FRAC_PI_2;
                        let outwards = pixel.normalize() * theta.sin();
                        outwards.extend(-theta.cos())
                    }
                };
                let error = pixels_apart(ray.direction().as_dvec3(), room_from_capture * exact);
                *worst = worst.max(error);
            }
        }
    }
    println!("screen, exact: {worst:.5?} px at 4096");
    // The rotation rounds too.
    assert!(worst.iter().all(|&w| w <= 1.0e-3), "{worst:?}");
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

#[test]
fn rays_start_on_the_mirror_around_the_viewpoint() {
    let mirror = SpheroidMirror::PAPER_SPHERE;
    for mapping in MAPPINGS {
        for offset in [0.0f32, -0.5, 0.25] {
            let mut camera = camera(mirror, mapping);
            camera.radius = 2.0;
            camera.viewpoint += offset;
            let view = by_mirror(camera, UPRIGHT, 33);
            // The zenith is seen in the pole.
            let pole = view.ray(16.0, 16.0).expect("a ray");
            let up = 2.0 * (mirror.axis_ratio() - mirror.screen_distance() - offset);
            assert!((pole.origin() - Vec3::Y * up).length() < 1.0e-6);
            assert!((pole.direction() - Vec3::Y).length() < 1.0e-6);
            for x in 0..33 {
                let ray = view.ray(x as f32, 16.0).expect("a ray");
                let centre = Vec3::Y * -2.0 * (mirror.screen_distance() + offset);
                assert!(((ray.origin() - centre).length() - 2.0).abs() < 1.0e-5);
            }
        }
    }
}

#[test]
fn centre_and_rim_are_finite_and_right() {
    for mapping in MAPPINGS {
        for mirror in NAMED {
            // An odd size has a pixel at the very centre; of one pixel it is
            // that alone.
            let view = by_mirror(camera(mirror, mapping), UPRIGHT, 1);
            let centre = view.ray(0.0, 0.0).expect("a ray").direction();
            assert!((centre - Vec3::Y).length() < 1.0e-6, "{centre}");
            // Half a pixel out from there is the rim: front at the bottom.
            for (at, exact) in [
                ((0.5, 0.0), Vec3::X),
                ((-0.5, 0.0), Vec3::NEG_X),
                ((0.0, 0.5), Vec3::NEG_Z),
                ((0.0, -0.5), Vec3::Z),
            ] {
                let rim = view.ray(at.0, at.1).expect("a ray").direction();
                assert!((rim - exact).length() < 1.0e-6, "{mirror:?} {rim} {exact}");
            }
            assert_eq!(view.ray(0.500_1, 0.0), None);
        }
    }
}

fn small_scene() -> Scene {
    let mut scene = paper_scene(PaperScene::A, icosphere(2)).expect("a scene");
    scene.background.alpha = 0.25;
    scene
}

fn options(threads: usize, tile: u32, simd: Simd, settings: Settings) -> Options {
    Options {
        settings,
        threads,
        tile,
        simd,
        ..Options::default()
    }
}

#[test]
fn the_same_bytes_come_from_any_threads_tiles_vectors_and_layouts() {
    let lod = lod();
    for scene in [small_scene(), grid(0.1)] {
        let (fast, compact) = (
            Baked::<8>::new(&scene).expect("a scene"),
            Baked::<4>::new(&scene).expect("a scene"),
        );
        for view in views(61) {
            for (samples, lod) in [(1, None), (1, Some(lod)), (11, None), (4, Some(lod))] {
                let settings = |mode| Settings {
                    samples,
                    mode,
                    ..Settings::default()
                };
                let single = options(1, 64, Simd::PORTABLE, settings(Mode::Single));
                let reference = render::dome(&fast.scene(), &view, lod, &single, &|_, _| ());
                let reference = reference.expect("a picture");
                for (threads, tile, simd, mode) in [
                    (1, 8, Simd::detect(), Mode::Single),
                    (3, 13, Simd::PORTABLE, Mode::Tile),
                    (2, 1, Simd::detect(), Mode::Tile),
                ] {
                    let options = options(threads, tile, simd, settings(mode));
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

#[test]
fn interrupted_pictures_are_the_same() {
    let baked = Baked::<8>::new(&small_scene()).expect("a scene");
    for (mode, samples) in [
        (Mode::Single, 1),
        (Mode::Tile, 1),
        (Mode::Single, 9),
        (Mode::Tile, 9),
    ] {
        let settings = Settings {
            samples,
            mode,
            ..Settings::default()
        };
        let renderer = Renderer::new(baked.scene(), Simd::detect(), settings);
        let size = 61;
        for view in views(size) {
            let tile = Tile {
                x: 3,
                y: 2,
                width: size - 5,
                height: size - 2,
            };
            let count = (tile.width * tile.height) as usize;
            let mut whole = vec![Pixel::default(); count];
            let mut workspace = Workspace::new();
            let mut unlimited = Budget::UNLIMITED;
            let outcome = TileJob::new(tile).render(
                &renderer,
                &view,
                &mut whole,
                &mut unlimited,
                &mut workspace,
            );
            assert_eq!(outcome, Ok(Outcome::Finished));
            let mut pixels = vec![Pixel::default(); count];
            let mut job = TileJob::new(tile);
            let mut calls = 0;
            loop {
                calls += 1;
                let mut budget = Budget::steps(1 + calls % 90);
                let outcome =
                    job.render(&renderer, &view, &mut pixels, &mut budget, &mut workspace);
                if outcome == Ok(Outcome::Finished) {
                    break;
                }
                assert_eq!(outcome, Ok(Outcome::BudgetSpent));
            }
            assert_eq!(pixels, whole, "{view:?}");
            assert!(calls > 10);
        }
    }
}

fn render(scene: &Scene, view: &View, lod: Option<LevelOfDetail>, samples: u16) -> Picture {
    let baked = Baked::<8>::new(scene).expect("a scene");
    let settings = Settings {
        samples,
        ..Settings::default()
    };
    let options = options(1, 8, Simd::detect(), settings);
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
        let options = options(1, 8, Simd::detect(), Settings::default());
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

fn lod() -> LevelOfDetail {
    let sight = LineOfSight::new(Vec3::ZERO, Vec3::new(0.3, 0.6, -1.0), Vec3::Y);
    LevelOfDetail::new(Gaze::new(
        sight.expect("a line of sight"),
        VisualField::PAPER,
    ))
}

#[test]
fn level_zero_shows_the_background_and_level_one_all() {
    let scene = small_scene();
    let empty = {
        let mut scene = scene.clone();
        for object in &mut scene.objects {
            object.world_from_object.translation = DVec3::new(0.0, 0.0, 1.0e6);
        }
        scene
    };
    let (size, lod) = (72, lod());
    for projection in projections() {
        let view = View::dome(projection, UPRIGHT, size).expect("a dome master");
        let [with, without, background] = [
            render(&scene, &view, Some(lod), 1),
            render(&scene, &view, None, 1),
            render(&empty, &view, None, 1),
        ];
        let (mut dark, mut central) = (0, 0);
        for (x, y) in all(size) {
            let Some(direction) = view.direction(x as f32, y as f32) else {
                continue;
            };
            let level = lod.gaze.level(direction).expect("a level");
            let pixel = with.pixel(x, y);
            if level == 0.0 {
                dark += 1;
                assert_eq!(pixel, background.pixel(x, y), "{projection:?} {x} {y}");
            } else if level == 1.0 {
                central += 1;
                assert_eq!(pixel, without.pixel(x, y), "{projection:?} {x} {y}");
            }
        }
        assert!(dark > 100 && central > 50, "{dark} {central}");
    }
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
fn poses_and_projections_that_cannot_be_are_refused() {
    let lens = DomeProjection::Equidistant { field_of_view: PI };
    for bad in [f32::NAN, f32::INFINITY, -1.0e12] {
        for position in [Vec3::X * bad, Vec3::Y * bad, Vec3::new(0.0, 0.0, bad)] {
            let found = View::dome(lens, DomePose::over_room(position), 8);
            assert!(
                matches!(found, Err(DomeError::Position { .. })),
                "{found:?}"
            );
        }
    }
    let skewed = Mat3::from_cols(Vec3::X, Vec3::new(1.0e-3, 1.0, 0.0), Vec3::Z);
    let left_handed = Mat3::from_cols(Vec3::X, Vec3::Y, Vec3::NEG_Z);
    for axes in [
        Mat3::NAN,
        Mat3::ZERO,
        Mat3::IDENTITY * 1.01,
        skewed,
        left_handed,
    ] {
        let pose = DomePose {
            position: Vec3::ZERO,
            room_from_capture: axes,
        };
        let found = View::dome(lens, pose, 8);
        assert!(matches!(found, Err(DomeError::Axes { .. })), "{found:?}");
        let says = found.unwrap_err().to_string();
        assert!(says.contains("right-handed"), "{says}");
    }
    for size in [0, View::MOST_PIXELS + 1] {
        assert_eq!(
            View::dome(lens, UPRIGHT, size),
            Err(DomeError::Size { size })
        );
    }
    for field_of_view in [0.0, -1.0, TAU.next_up(), f32::NAN] {
        for lens in [
            DomeProjection::Equidistant { field_of_view },
            DomeProjection::Equisolid { field_of_view },
        ] {
            let error = View::dome(lens, UPRIGHT, 8).unwrap_err();
            assert!(matches!(error, DomeError::FieldOfView { .. }));
            assert!(error.to_string().contains("above 0, to 6.28"), "{error}");
        }
    }
    let good = camera(SpheroidMirror::BEST, Mapping::Screen);
    for radius in [0.0, -1.0, f32::NAN, 1.0e7, 1.0e-10] {
        let projection = DomeProjection::Mirror(MirrorCamera { radius, ..good });
        let error = View::dome(projection, UPRIGHT, 8).unwrap_err();
        assert!(matches!(error, DomeError::Radius { .. }));
        assert!(error.to_string().contains("from 1e-9 to 1e6"), "{error}");
    }
    for viewpoint in [f32::NAN, 1001.0, f32::NEG_INFINITY] {
        let projection = DomeProjection::Mirror(MirrorCamera { viewpoint, ..good });
        let error = View::dome(projection, UPRIGHT, 8).unwrap_err();
        assert!(matches!(error, DomeError::Viewpoint { .. }));
    }
    // A rotation is one whatever its rounding.
    let turned = DMat3::from_rotation_y(1.0).as_mat3();
    let pose = DomePose {
        position: Vec3::ZERO,
        room_from_capture: turned,
    };
    assert!(View::dome(lens, pose, 8).is_ok());
}

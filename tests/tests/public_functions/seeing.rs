//! Gaze, views, renderers and tracers: whatever is a view, a gaze or a scene
//! gives pixels that are numbers.

mod scenes;

use super::geometry::a_ray;
use super::numbers::{Case, Numbers, finite, finite_or_error};
use crate::blob_fuzz::small_scene;
use glam::{Mat3, Vec3};
use scenes::{numbers_of_a_scene, of_a_scene, write};
use shisen::bake::Baked;
use shisen_core::capture::{Mapping, SpheroidMirror};
use shisen_core::frame::{
    Budget, DomePose, DomeProjection, DomeScreen, Fill, FlatScreen, FrameJob, LARGEST_STRIDE,
    Ledger, LevelOfDetail, MirrorCamera, Mode, Outcome, Part, Pixel, Place, Progress, Renderer,
    Settings, Surroundings, Tile, TileJob, View, Workspace,
};
use shisen_core::gaze::{
    Acuity, Boundary, Detail, FaceRange, Gaze, LineOfSight, VisualField, VisualFieldLimits,
};
use shisen_core::scene::format::{Header, Material};
use shisen_core::scene::{EffectSet, Records};
use shisen_core::shape::Ray;
use shisen_core::spectrum::{Matching, SpectralSample, SpectralTable, Wavelengths};
use shisen_core::trace::{MeshTracer, Spectrum, TileRays, Tracer, TraversalStack};
use shisen_core::{Runs, Simd};
use std::sync::LazyLock;
use zerocopy::FromBytes as _;

pub(super) const CASES: &[(&str, Case)] = &[
    ("core gaze::detail::Detail::of_level", |n| {
        if let Some(detail) = Detail::of_level(n.next(0.5)) {
            let faces = FaceRange::new(8, 20).expect("a range");
            assert!((8..=20).contains(&detail.faces(faces)));
            assert!(detail.bounces(5) <= 5);
            assert!(detail.wavelengths(40) <= 40);
            assert!((0.0..=1.0).contains(&detail.level()));
        }
    }),
    ("core gaze::level::Gaze::new", |n| {
        finite(&a_gaze(n));
    }),
    ("core gaze::level::Gaze::level", |n| {
        let direction = n.vec3([0.1, 0.2, -1.0]);
        for gaze in gazes(n) {
            let level = gaze.level(direction);
            let is_one = direction.is_finite() && direction != Vec3::ZERO;
            assert_eq!(level.is_some(), is_one);
            assert!(
                level.is_none_or(|level| (0.0..=1.0).contains(&level)),
                "{level:?}"
            );
        }
    }),
    ("core gaze::level::Gaze::sight", |n| {
        let direction = n.vec3([0.1, 0.2, -1.0]);
        for gaze in gazes(n) {
            finite(&gaze.sight(direction));
        }
    }),
    ("core gaze::level::Gaze::levels_of_row", |n| {
        let [x, y, z] = [[0.1; 9], [0.2; 9], [-1.0; 9]].map(|row: [f32; 9]| row.map(|c| n.next(c)));
        for gaze in gazes(n) {
            let mut levels = [7.0; 9];
            gaze.levels_of_row(Simd::detect(), &x, &y, &z, &mut levels);
            for (i, level) in levels.into_iter().enumerate() {
                let own = gaze.level(Vec3::new(x[i], y[i], z[i])).unwrap_or(0.0);
                assert_eq!(level.to_bits(), own.to_bits(), "of lane {i}");
            }
        }
    }),
    ("core gaze::line_of_sight::LineOfSight::new", |n| {
        if let Some(sight) = finite_or_error(line_of_sight(n)) {
            for unit in [sight.forward(), sight.right(), sight.up()] {
                assert!((unit.length() - 1.0).abs() < 1.0e-5, "{unit}");
            }
        }
    }),
    ("core gaze::visual_field::VisualField::new", |n| {
        finite_or_error(visual_field(n));
    }),
    ("core gaze::visual_field::VisualField::wider", |n| {
        let by = n.next(0.1);
        finite(&VisualField::PAPER.wider(by));
        if let Ok(field) = visual_field(n) {
            finite(&field.wider(by));
        }
    }),
    ("core frame::detail::LevelOfDetail::new", |n| {
        if let Some(gaze) = a_gaze(n) {
            finite(&LevelOfDetail::new(gaze));
        }
    }),
    ("core frame::detail::LevelOfDetail::in_full", |n| {
        if let Some(gaze) = a_gaze(n) {
            finite(&LevelOfDetail::in_full(gaze));
        }
    }),
    ("core gaze::acuity::Acuity::new", |n| {
        finite_or_error(Acuity::new(n.next(0.02), n.next(0.001)));
    }),
    ("core gaze::acuity::Acuity::steeper", |n| {
        let steeper = Acuity::GUENTER.steeper(n.next(2.0));
        finite(&steeper);
        assert!(steeper.slope() >= Acuity::GUENTER.slope());
        assert!(steeper.slope() <= Acuity::STEEPEST);
    }),
    ("core gaze::acuity::Acuity::steeper_beyond", |n| {
        let steeper = Acuity::GUENTER.steeper_beyond(n.next(2.0), n.next(0.1));
        finite(&steeper);
        let (near, far) = (steeper.least_angle(0.0), steeper.least_angle(3.0));
        assert_eq!(near, Acuity::GUENTER.fovea());
        assert!(far >= Acuity::GUENTER.least_angle(3.0) && far.is_finite());
    }),
    ("core gaze::acuity::Acuity::around", |n| {
        finite(&Acuity::GUENTER.around(n.next(0.1)));
    }),
    ("core gaze::acuity::Acuity::least_angle", |n| {
        let eccentricity = n.next(0.5);
        if let Ok(acuity) = Acuity::new(n.next(0.02), n.next(0.001)) {
            let least = acuity.around(n.next(0.1)).least_angle(eccentricity);
            assert!(least >= acuity.fovea(), "{least}");
            assert!(least <= acuity.least_angle(4.0), "{least}");
        }
    }),
    ("core frame::foveation::Renderer::with_foveation", |n| {
        let acuity = Acuity::new(n.next(0.02), n.next(0.001));
        if let (Some(gaze), Ok(acuity)) = (a_gaze(n), acuity) {
            for mode in [Mode::Tile, Mode::Single] {
                shows(&renderer(mode).with_foveation(LevelOfDetail::in_full(gaze), acuity));
            }
        }
    }),
    ("core frame::foveation::Renderer::stride", |n| {
        let gaze = a_gaze(n);
        for view in some_views(n) {
            let renderer = renderer(Mode::Tile);
            let renderer = gaze.map_or(renderer, |gaze| {
                renderer.with_foveation(LevelOfDetail::in_full(gaze), Acuity::GUENTER)
            });
            for place in [0, 3, 7, 8, u32::MAX] {
                let stride = renderer.stride(&view, place, place);
                assert!(stride.is_power_of_two() && stride <= LARGEST_STRIDE);
            }
        }
    }),
    ("core frame::view::dome::DomePose::over_room", |n| {
        let position = n.vec3([0.0, 1.0, 0.0]);
        let pose = DomePose::over_room(position);
        let view = View::dome(DomeProjection::MirrorBall, pose, 8);
        finite_or_error(view).inspect(rays_are_rays);
    }),
    ("core frame::view::dome::MirrorCamera::best", |n| {
        let projection = DomeProjection::Mirror(MirrorCamera::best(n.next(0.01)));
        let view = View::dome(projection, DomePose::over_room(Vec3::Y), 8);
        finite_or_error(view).inspect(rays_are_rays);
    }),
    (
        "core frame::view::flat_screen::FlatScreen::from_corners",
        |n| {
            let corners = [[-1.0, -1.0, -1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0]];
            let [left, right, upper] = corners.map(|corner| n.vec3(corner));
            for size in [[8, 8], [0, 8], [u32::MAX, 1]] {
                let screen = FlatScreen::from_corners(left, right, upper, size);
                finite_or_error(screen.view_from(Vec3::ZERO)).inspect(rays_are_rays);
            }
        },
    ),
    (
        "core frame::view::flat_screen::FlatScreen::view_from",
        |n| {
            let screen = FlatScreen {
                first_pixel: n.vec3([-0.9, 0.9, -1.0]),
                column_step: n.vec3([0.2, 0.0, 0.0]),
                row_step: n.vec3([0.0, -0.2, 0.0]),
                size: [8, 8],
            };
            finite_or_error(screen.view_from(n.vec3([0.0; 3]))).inspect(rays_are_rays);
        },
    ),
    ("core frame::view::View::new", |n| {
        a_flat_view(n).iter().for_each(rays_are_rays);
    }),
    ("core frame::view::View::dome", |n| {
        for view in dome_views(n) {
            finite(&view);
            rays_are_rays(&view);
        }
    }),
    ("core frame::view::View::dome_screen", |n| {
        a_dome_screen_view(n).iter().for_each(rays_are_rays);
    }),
    ("core frame::view::View::direction", |n| {
        let (x, y) = (n.next(3.0), n.next(4.0));
        for view in every_view() {
            let direction = view.direction(x, y);
            if n.within(1.0e18) {
                finite(&direction);
            }
        }
    }),
    ("core frame::view::View::ray", |n| {
        let (x, y) = (n.next(3.0), n.next(4.0));
        for view in every_view() {
            finite(&view.ray(x, y));
        }
    }),
    ("core frame::fill::Surroundings::views", |n| {
        if let Some(views) = finite_or_error(Surroundings::views(a_pose(n), 8)) {
            views.iter().for_each(rays_are_rays);
        }
    }),
    ("core frame::fill::Surroundings::new", |n| {
        let pixels = [Pixel::default(); 64];
        finite_or_error(Surroundings::new(a_pose(n), 8, [&pixels; 2]));
    }),
    ("core frame::fill::Renderer::fill", |n| {
        let gaze = a_gaze(n);
        let shown = a_pixel(n);
        let renderer = renderer(Mode::Tile);
        let hemisphere = [shown; 64];
        let place = Surroundings::new(DomePose::over_room(Vec3::Y), 8, [&hemisphere; 2]);
        let surroundings = Fill::Surroundings(place.expect("surroundings"));
        for fill in [surroundings, Fill::Pixels(&hemisphere)] {
            for view in every_view() {
                let lod = gaze.map_or(renderer, |gaze| {
                    renderer.with_level_of_detail(LevelOfDetail::new(gaze))
                });
                let mut pixels = [Pixel::default(); 64];
                assert_eq!(lod.fill(&view, TILE, &fill, &mut pixels), Ok(()));
                // Past pixels are blended as they are.
                if [shown.red, shown.green, shown.blue, shown.alpha]
                    .iter()
                    .all(|channel| channel.abs() <= 1.0e18)
                {
                    finite(&pixels);
                }
            }
        }
    }),
    ("core frame::ledger::Renderer::account", |n| {
        let views = some_views(n);
        for view in views {
            let (mut pixels, mut ledger) = ([Pixel::default(); 64], Ledger::default());
            let renderer = renderer(Mode::Single);
            let done =
                renderer.account(&view, TILE, &mut pixels, &mut ledger, &mut Workspace::new());
            assert_eq!(done, Ok(()));
            finite(&pixels);
        }
    }),
    ("core frame::job::FrameJob::new", |n| {
        frames(n);
    }),
    ("core frame::job::FrameJob::render", |n| {
        frames(n);
    }),
    ("core frame::Renderer::new", |n| {
        of_a_scene(n, |scene| {
            shows(&Renderer::new(scene, Simd::detect(), Settings::default()));
        });
    }),
    ("core frame::Renderer::for_effects", |n| {
        of_a_scene(n, |scene| {
            shows(&Renderer::for_effects::<{ EffectSet::ALL.bits() }>(
                scene,
                Simd::detect(),
                Settings::default(),
            ));
        });
    }),
    ("core frame::Renderer::single", |n| {
        of_a_scene(n, |scene| {
            shows(&Renderer::single::<{ EffectSet::ALL.bits() }>(
                scene,
                Simd::detect(),
                Settings::default(),
            ));
        });
    }),
    ("core frame::Renderer::with_spectrum", |n| {
        of_spectra(n, |spectrum| {
            if let Some(renderer) = finish(renderer(Mode::Tile).with_spectrum(spectrum)) {
                shows(&renderer);
            }
            // Without media that refuse it there is no limit to wavelengths.
            let plain = Renderer::new(PLAIN.scene(), Simd::detect(), Settings::default());
            if let Some(renderer) = finish(plain.with_spectrum(spectrum)) {
                shows(&renderer);
            }
        });
    }),
    ("core frame::Renderer::at_level", |n| {
        shows(&renderer(Mode::Tile).at_level(n.next(0.5)));
    }),
    ("core frame::Renderer::with_faces_of_level", |n| {
        shows(&renderer(Mode::Tile).with_faces_of_level(n.next(0.5)));
    }),
    ("core frame::Renderer::with_level_of_detail", |n| {
        if let Some(gaze) = a_gaze(n) {
            for mode in [Mode::Tile, Mode::Single] {
                shows(&renderer(mode).with_level_of_detail(LevelOfDetail::new(gaze)));
            }
        }
    }),
    ("core frame::Renderer::below_level", |n| {
        let level = n.next(0.5);
        for gaze in gazes(n) {
            shows(&renderer(Mode::Tile).below_level(gaze, level));
        }
    }),
    ("core frame::Renderer::detail", |n| {
        let lod = a_gaze(n).map(LevelOfDetail::new);
        for view in some_views(n) {
            let renderer = renderer(Mode::Tile);
            let renderer = lod.map_or(renderer, |lod| renderer.with_level_of_detail(lod));
            for place in [0, 3, 7, 8, u32::MAX] {
                let detail = renderer.detail(&view, place, place);
                assert!(detail.is_none_or(|detail| detail.depth <= Settings::default().depth));
            }
        }
    }),
    ("core frame::TileJob::render", |n| {
        for view in some_views(n) {
            for mode in [Mode::Tile, Mode::Single] {
                finite(&pixels_of(&renderer(mode), &view));
            }
        }
    }),
    ("core frame::TileJob::give_up", |n| {
        for view in some_views(n) {
            let mut pixels = [Pixel::default(); 64];
            let mut job = TileJob::new(TILE);
            let given_up = job.give_up(&renderer(Mode::Tile), &view, &mut pixels);
            assert_eq!(given_up, Ok(()));
            finite(&pixels);
        }
    }),
    ("core scene::effects::EffectSet::of_material", |n| {
        let mut bytes = BAKED.as_bytes().to_vec();
        write(&mut bytes, &numbers_of_a_scene(n));
        let (header, _) = Header::read_from_prefix(&bytes).expect("a header");
        let at = header.materials.offset as usize;
        let (material, _) = Material::read_from_prefix(&bytes[at..]).expect("a material");
        let asked = EffectSet::of_material(&material);
        assert!(EffectSet::ALL.contains(asked), "{asked}");
    }),
    ("core scene::effects::EffectSet::of_records", |n| {
        of_a_scene(n, |scene| {
            let records: Records<'_> = scene.records();
            assert_eq!(EffectSet::of_records(&records), scene.effects());
        });
    }),
    ("core trace::mesh::MeshTracer::new", |n| {
        of_a_scene(n, |scene| {
            for mesh in [0, 1, usize::MAX] {
                if let Some(tracer) = MeshTracer::new(&scene, mesh, Simd::detect()) {
                    let ray = Ray::new(Vec3::Z * 4.0, Vec3::NEG_Z);
                    let ray = ray.expect("a ray");
                    finite(&tracer.nearest(&ray, &mut TraversalStack::EMPTY.clone()));
                }
            }
        });
    }),
    ("core trace::mesh::MeshTracer::nearest", |n| {
        if let Some(ray) = a_ray(n) {
            for mesh in 0..BAKED.scene().meshes().len() {
                let tracer = mesh_tracer(mesh);
                finite(&tracer.nearest(&ray, &mut TraversalStack::EMPTY.clone()));
            }
        }
    }),
    ("core simd::Runs::run_along", |n| {
        // What goes along a ray is a search, on either path.
        if let Some(ray) = a_ray(n) {
            let scene = BAKED.scene();
            for mesh in 0..scene.meshes().len() {
                let found = [Simd::PORTABLE, Simd::detect()].map(|simd| {
                    let tracer = MeshTracer::new(&scene, mesh, simd).expect("a mesh");
                    tracer.nearest(&ray, &mut TraversalStack::EMPTY.clone())
                });
                assert_eq!(found[0], found[1]);
            }
        }
    }),
    ("core trace::mesh::MeshTracer::any", |n| {
        if let Some(ray) = a_ray(n) {
            for mesh in 0..BAKED.scene().meshes().len() {
                let (tracer, stack) = (mesh_tracer(mesh), &mut TraversalStack::EMPTY.clone());
                let (nearest, steps) = tracer.nearest(&ray, stack);
                let (any, fewer) = tracer.any(&ray, stack);
                assert_eq!(any, nearest.is_some());
                assert!(fewer <= steps, "{fewer} steps, and {steps} for the nearest");
            }
        }
    }),
    ("core trace::mesh::MeshTracer::nearest_of_each", |n| {
        let rays = [a_ray(n), None, a_ray(n)];
        for mesh in 0..BAKED.scene().meshes().len() {
            let (tracer, stack) = (mesh_tracer(mesh), &mut TraversalStack::EMPTY.clone());
            let mut found = Vec::new();
            tracer.nearest_of_each(rays.into_iter(), stack, |hit| found.push(hit));
            let alone = rays.map(|ray| ray.and_then(|ray| tracer.nearest(&ray, stack).0));
            assert_eq!(found, alone);
        }
    }),
    ("core trace::mesh::MeshTracer::any_of_each", |n| {
        let rays = [a_ray(n), None, a_ray(n)];
        for mesh in 0..BAKED.scene().meshes().len() {
            let (tracer, stack) = (mesh_tracer(mesh), &mut TraversalStack::EMPTY.clone());
            let mut found = Vec::new();
            tracer.any_of_each(rays.into_iter(), stack, |any| found.push(any));
            assert_eq!(
                found,
                rays.map(|ray| ray.is_some_and(|ray| tracer.any(&ray, stack).0))
            );
        }
    }),
    ("core trace::mesh::MeshTracer::nearest_of_tile", |n| {
        let rays = tile_rays(n);
        for mesh in 0..BAKED.scene().meshes().len() {
            let (hits, _) =
                mesh_tracer(mesh).nearest_of_tile(&rays, &mut TraversalStack::EMPTY.clone());
            each_place(|column, row| finite(&hits.at(column, row)));
        }
    }),
    ("core trace::tile::TileRays::new", |n| {
        let rays = tile_rays(n);
        each_place(|column, row| finite(&rays.at(column, row)));
    }),
    ("core trace::tracer::Tracer::new", |n| {
        of_a_scene(n, |scene| sees(&Tracer::new(scene, Simd::detect(), 3)));
    }),
    ("core trace::tracer::Tracer::for_effects", |n| {
        of_a_scene(n, |scene| {
            sees(&Tracer::for_effects::<{ EffectSet::ALL.bits() }>(
                scene,
                Simd::detect(),
                3,
            ));
        });
    }),
    ("core trace::tracer::Tracer::with_spectrum", |n| {
        of_spectra(n, |spectrum| {
            if let Some(tracer) = finish(tracer().with_spectrum(spectrum)) {
                sees(&tracer);
            }
        });
    }),
    ("core trace::tracer::Tracer::nearest", |n| {
        if let Some(ray) = a_ray(n) {
            let hit = tracer().nearest(&ray, &mut Budget::UNLIMITED.clone(), &mut Workspace::new());
            finite(&hit);
        }
    }),
    ("core trace::tracer::Tracer::nearest_of_tile", |n| {
        let rays = tile_rays(n);
        let hits =
            tracer().nearest_of_tile(&rays, &mut Budget::UNLIMITED.clone(), &mut Workspace::new());
        each_place(|column, row| finite(&hits.at(column, row)));
    }),
    ("core trace::tracer::Tracer::may_hit", |n| {
        let origin = n.vec3([0.1, 0.2, 0.3]);
        let corners = [0.05, 0.06, 0.07, 0.08].map(|x| n.vec3([x, -0.02, -1.0]));
        let (budget, workspace) = (&mut Budget::UNLIMITED.clone(), &mut Workspace::new());
        let may_hit = tracer().may_hit(origin, &corners, budget, workspace);
        assert!(workspace.statistics.steps <= 16);
        // What lies between the corners, component by component.
        let (low, high) = corners[1..]
            .iter()
            .fold((corners[0], corners[0]), |(low, high), &corner| {
                (low.min(corner), high.max(corner))
            });
        for direction in [low, high, 0.5 * (low + high)].into_iter().chain(corners) {
            if let Some(ray) = Ray::new(origin, direction) {
                let hit = tracer().nearest(&ray, budget, workspace);
                assert!(may_hit || hit.is_none(), "{origin} {corners:?} {ray:?}");
            }
        }
    }),
    ("core trace::tracer::Tracer::is_occluded", |n| {
        let limit = n.next(5.0);
        if let Some(ray) = a_ray(n) {
            let (budget, workspace) = (&mut Budget::UNLIMITED.clone(), &mut Workspace::new());
            let any = tracer().nearest(&ray, budget, workspace).is_some();
            let occluded = tracer().is_occluded(&ray, limit, budget, workspace);
            // Nothing is in front of a start, and nothing behind NaN.
            assert!(!occluded || any && limit > 0.0, "up to {limit}");
        }
    }),
    ("core trace::tracer::Tracer::radiance", |n| {
        if let Some(ray) = a_ray(n) {
            let (budget, workspace) = (&mut Budget::UNLIMITED.clone(), &mut Workspace::new());
            finite(&tracer().radiance(&ray, budget, workspace));
        }
    }),
];

pub(super) static BAKED: LazyLock<Baked<8>> =
    LazyLock::new(|| Baked::new(&small_scene()).expect("a scene that can be baked"));

/// The same without glass: no medium says which wavelengths there are.
static PLAIN: LazyLock<Baked<8>> = LazyLock::new(|| {
    let mut scene = small_scene();
    for material in &mut scene.materials {
        material.medium = None;
    }
    Baked::new(&scene).expect("a scene that can be baked")
});

const TILE: Tile = Tile {
    x: 0,
    y: 0,
    width: 8,
    height: 8,
};

pub(super) fn renderer(mode: Mode) -> Renderer<'static> {
    let settings = Settings {
        mode,
        ..Settings::default()
    };
    Renderer::new(BAKED.scene(), Simd::detect(), settings)
}

pub(super) fn tracer() -> Tracer<'static> {
    Tracer::new(BAKED.scene(), Simd::detect(), 3)
}

fn mesh_tracer(mesh: usize) -> MeshTracer<'static, 8> {
    MeshTracer::new(&BAKED.scene(), mesh, Simd::detect()).expect("one of its meshes")
}

fn line_of_sight(n: &mut Numbers) -> Result<LineOfSight, shisen_core::gaze::LineOfSightError> {
    LineOfSight::new(
        n.vec3([0.0, 0.1, 0.0]),
        n.vec3([0.1, 0.0, -1.0]),
        n.vec3([0.0, 1.0, 0.1]),
    )
}

fn visual_field(n: &mut Numbers) -> Result<VisualField, shisen_core::gaze::VisualFieldError> {
    let limits = VisualFieldLimits {
        central: n.next(0.3),
        up: n.next(1.0),
        down: n.next(1.1),
        left: n.next(1.6),
        right: n.next(1.7),
    };
    VisualField::new(limits, Boundary::Ellipse)?;
    VisualField::new(limits, Boundary::Printed)
}

fn a_gaze(n: &mut Numbers) -> Option<Gaze> {
    let (sight, field) = (line_of_sight(n).ok(), visual_field(n).ok());
    sight
        .zip(field)
        .map(|(sight, field)| Gaze::new(sight, field))
}

/// The paper's field straight ahead, and one of these numbers.
fn gazes(n: &mut Numbers) -> Vec<Gaze> {
    let ahead = LineOfSight::new(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y).expect("a line of sight");
    let mut gazes = vec![Gaze::new(ahead, VisualField::PAPER)];
    gazes.extend(a_gaze(n));
    gazes
}

fn a_pixel(n: &mut Numbers) -> Pixel {
    Pixel {
        red: n.next(0.1),
        green: n.next(0.2),
        blue: n.next(0.3),
        alpha: n.next(1.0),
    }
}

fn a_flat_view(n: &mut Numbers) -> Option<View> {
    finite_or_error(View::new(
        n.vec3([0.0, 0.1, 0.2]),
        n.vec3([-0.9, 0.9, -1.0]),
        n.vec3([0.2, 0.0, 0.0]),
        n.vec3([0.0, -0.2, 0.0]),
        [8, 8],
    ))
}

fn a_pose(n: &mut Numbers) -> DomePose {
    DomePose {
        position: n.vec3([0.1, 0.2, -1.0]),
        room_from_capture: n.mat3(Mat3::from_cols(Vec3::X, Vec3::Z, Vec3::NEG_Y)),
    }
}

/// Of every projection.
fn dome_views(n: &mut Numbers) -> Vec<View> {
    let pose = a_pose(n);
    let mirror = MirrorCamera {
        mirror: SpheroidMirror::BEST,
        mapping: Mapping::Exact,
        radius: n.next(0.05),
        viewpoint: n.next(0.5),
        mirrored: false,
    };
    let field_of_view = n.next(3.0);
    [
        DomeProjection::Mirror(mirror),
        DomeProjection::Equidistant { field_of_view },
        DomeProjection::Equisolid { field_of_view },
        DomeProjection::MirrorBall,
    ]
    .into_iter()
    .filter_map(|projection| finite_or_error(View::dome(projection, pose, 8)))
    .collect()
}

fn a_dome_screen_view(n: &mut Numbers) -> Option<View> {
    let screen = DomeScreen {
        pose: a_pose(n),
        radius: n.next(2.0),
        field_of_view: n.next(3.0),
    };
    finite_or_error(View::dome_screen(screen, n.vec3([0.2, 0.3, -1.1]), 8))
}

fn some_views(n: &mut Numbers) -> Vec<View> {
    let mut views = dome_views(n);
    views.extend(a_flat_view(n));
    views.extend(a_dome_screen_view(n));
    views
}

/// One of every kind, of sane numbers.
pub(super) fn every_view() -> [View; 4] {
    let pose = DomePose::over_room(Vec3::new(0.0, 1.0, 0.0));
    let mirror = MirrorCamera {
        mirror: SpheroidMirror::BEST,
        mapping: Mapping::Screen,
        radius: 0.05,
        viewpoint: 0.0,
        mirrored: true,
    };
    let dome = |projection| View::dome(projection, pose, 8).expect("a dome");
    let screen = DomeScreen {
        pose,
        radius: 2.0,
        field_of_view: 3.0,
    };
    let (right, down) = (Vec3::X / 4.0, Vec3::NEG_Y / 4.0);
    let first = Vec3::new(-0.9, 0.9, -1.0);
    [
        View::new(Vec3::ZERO, first, right, down, [8, 8]).expect("a screen"),
        dome(DomeProjection::Mirror(mirror)),
        dome(DomeProjection::Equidistant { field_of_view: 3.0 }),
        View::dome_screen(screen, Vec3::Y, 8).expect("a dome screen"),
    ]
}

fn rays_are_rays(view: &View) {
    for y in 0..view.rows().min(8) {
        for x in 0..view.columns().min(8) {
            finite(&view.direction(x as f32, y as f32));
            finite(&view.ray(x as f32, y as f32));
        }
    }
}

pub(super) fn pixels_of<const W: usize>(renderer: &Renderer<'_, W>, view: &View) -> [Pixel; 64]
where
    Simd: Runs<W>,
{
    let mut pixels = [Pixel::default(); 64];
    let (mut budget, mut workspace) = (Budget::UNLIMITED, Workspace::new());
    let outcome =
        TileJob::new(TILE).render(renderer, view, &mut pixels, &mut budget, &mut workspace);
    assert_eq!(outcome, Ok(Outcome::Finished));
    pixels
}

/// Pixels through a screen and by a mirror.
#[track_caller]
fn shows<const W: usize>(renderer: &Renderer<'_, W>)
where
    Simd: Runs<W>,
{
    for view in &every_view()[..2] {
        finite(&pixels_of(renderer, view));
    }
}

/// Light along some rays.
#[track_caller]
fn sees(tracer: &Tracer<'_>) {
    let view = &every_view()[0];
    let (budget, workspace) = (&mut Budget::UNLIMITED.clone(), &mut Workspace::new());
    for place in 0..8u8 {
        let ray = view.ray(f32::from(place), f32::from(place));
        finite(&tracer.radiance(&ray.expect("a ray"), budget, workspace));
    }
}

/// A whole frame of two pictures, and its order.
fn frames(n: &mut Numbers) {
    let gaze = a_gaze(n);
    let renderer = renderer(Mode::Tile);
    let renderer = gaze.map_or(renderer, |gaze| {
        renderer.with_level_of_detail(LevelOfDetail::new(gaze))
    });
    for view in some_views(n) {
        let parts = [view, every_view()[0]].map(|view| Part {
            view,
            renderer: &renderer,
        });
        let mut places = [Place::default(); 8];
        let mut pixels = [Pixel::default(); 16];
        let (mut slice, mut workspace) = (Budget::UNLIMITED, Workspace::new());
        let mut job = FrameJob::new(&parts[..], 4, Budget::UNLIMITED, &mut places)
            .expect("room for eight tiles");
        let mut tiles = 0;
        loop {
            match job.render(&parts[..], &mut pixels, &mut slice, &mut workspace) {
                Ok(Progress::Tile { .. }) => {
                    finite(&pixels);
                    tiles += 1;
                }
                Ok(Progress::Finished) => break,
                other => panic!("{other:?}"),
            }
        }
        assert_eq!(tiles, 8);
    }
}

/// Rays of a tile of which four places' directions are these numbers.
fn tile_rays(n: &mut Numbers) -> TileRays {
    let origin = n.vec3([0.1, 0.2, 0.3]);
    let own = [(); 4].map(|()| n.vec3([0.05, -0.02, -1.0]));
    TileRays::new(origin, |column, row| match (column, row) {
        (0, 0) => own[0],
        (3, 1) => own[1],
        (4, 7) => own[2],
        (7, 7) => own[3],
        _ => Vec3::new(column as f32 - 3.5, row as f32 - 3.5, -8.0),
    })
}

fn each_place(mut look: impl FnMut(usize, usize)) {
    for row in 0..8 {
        for column in 0..8 {
            look(column, row);
        }
    }
}

/// Single wavelengths, and a table of a range.
fn of_spectra(n: &mut Numbers, check: impl Fn(Spectrum<'_>)) {
    check(Spectrum::Single(n.next(550.0)));
    let range = [n.next(400.0), n.next(700.0)];
    let Ok(wavelengths) = Wavelengths::new(5, range) else {
        return;
    };
    let mut storage = [SpectralSample::default(); 64];
    for matching in [Matching::Wyman, Matching::Endo] {
        let table = SpectralTable::new(wavelengths, 4, matching, &mut storage);
        let table = table.expect("room for a table");
        for each in [0, 1, 255] {
            check(Spectrum::Comb { table, each });
        }
    }
}

/// As [`finite_or_error`], of what has too many numbers to print.
fn finish<T, E: std::error::Error>(made: Result<T, E>) -> Option<T> {
    made.inspect_err(|error| assert!(!error.to_string().is_empty()))
        .ok()
}

//! Views, renderers and tracers of any numbers give pixels that are numbers.

use super::*;
use crate::capture::{Mapping, SpheroidMirror};
use crate::gaze::Acuity;
use crate::gaze::hostile::gazes;
use crate::hostile::{Numbers, a_ray, finite, finite_or_error, with_hostile_numbers};
use crate::shape::Ray;
use glam::{Mat3, Vec3};
use std::vec::Vec;
use zerocopy::IntoBytes as _;

const TILE: Tile = Tile {
    x: 0,
    y: 0,
    width: 8,
    height: 8,
};

/// Returns every kind of view that the numbers make.
fn views(n: &mut Numbers) -> Vec<View> {
    let pose = DomePose {
        position: n.vector([0.1, 0.2, -1.0]),
        room_from_capture: n.matrix(Mat3::from_cols(Vec3::X, Vec3::Z, Vec3::NEG_Y)),
    };
    let mirror = DomeProjection::Mirror(MirrorCamera {
        mirror: SpheroidMirror::BEST,
        mapping: Mapping::Exact,
        radius: n.next(0.05),
        viewpoint: n.next(0.5),
        mirrored: false,
    });
    let field_of_view = n.next(3.0);
    let equidistant = DomeProjection::Equidistant { field_of_view };
    let equisolid = DomeProjection::Equisolid { field_of_view };
    let projections = [mirror, equidistant, equisolid, DomeProjection::MirrorBall];
    let masters = projections.map(|projection| View::dome(projection, pose, 8));
    let screen = DomeScreen {
        pose,
        radius: n.next(2.0),
        field_of_view,
    };
    let dome_screen = View::dome_screen(screen, n.vector([0.2, 0.3, -1.1]), 8);
    let cylinder = CylinderScreen {
        pose,
        radius: n.next(2.0),
        angle: field_of_view,
        heights: [n.next(-1.0), n.next(1.5)],
    };
    let eye = n.vector([0.2, 0.3, -1.1]);
    let cylinder_screen = View::cylinder_screen(cylinder, eye, [8, 8]);
    let domes = masters.into_iter().chain([dome_screen, cylinder_screen]);
    let eye = n.vector([0.0, 0.1, 0.2]);
    let (first, right) = (n.vector([-0.9, 0.9, -1.0]), n.vector([0.2, 0.0, 0.0]));
    let flat = View::new(eye, first, right, n.vector([0.0, -0.2, 0.0]), [8, 8]);
    let corners = [[-1.0, -1.0, -1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0]];
    let [left, right, upper] = corners.map(|corner| n.vector(corner));
    let wall = FlatScreen::from_corners(left, right, upper, [8, 8]).view_from(eye);
    let around = finite_or_error(Surroundings::views(pose, 8));
    let mut views: Vec<_> = domes.filter_map(finite_or_error).collect();
    views.extend([flat, wall].into_iter().filter_map(finite_or_error));
    views.extend(around.into_iter().flatten());
    views
}

#[test]
fn views_of_any_numbers_have_finite_rays() {
    with_hostile_numbers(|n| {
        let (x, y) = (n.next(3.0), n.next(4.0));
        let is_near = n.within(64.0);
        for view in views(n) {
            finite(&view.ray(x, y));
            if is_near {
                finite(&view.direction(x, y));
            }
            for number in 0..64 {
                finite(&view.ray((number % 8) as f32, (number / 8) as f32));
            }
        }
    });
}

#[test]
fn pixels_of_any_views_and_gazes_are_finite() {
    let bytes = crate::ball::scene();
    let scene = Scene::<4>::from_bytes(bytes.as_bytes()).unwrap();
    with_hostile_numbers(|n| {
        let (level, acuity) = (n.next(0.5), Acuity::new(n.next(0.02), n.next(0.001)));
        let (views, gazes) = (views(n), gazes(n));
        let mut workspace = Workspace::new();
        for mode in [Mode::Tile, Mode::Single] {
            let settings = Settings {
                mode,
                ..Settings::default()
            };
            let plain = Renderer::new(scene, Simd::detect(), settings);
            let mut renderers =
                Vec::from([plain.at_level(level), plain.with_faces_of_level(level)]);
            for gaze in &gazes {
                let lod = LevelOfDetail::new(*gaze);
                renderers.extend([
                    plain.with_level_of_detail(lod),
                    plain.below_level(*gaze, level),
                ]);
                renderers.extend(
                    acuity
                        .ok()
                        .map(|acuity| plain.with_foveation(gaze.line_of_sight(), acuity)),
                );
            }
            for (view, renderer) in views
                .iter()
                .flat_map(|v| renderers.iter().map(move |r| (v, r)))
            {
                let mut pixels = [Pixel::default(); 64];
                let budget = &mut { Budget::UNLIMITED };
                let done =
                    TileJob::new(TILE).render(renderer, view, &mut pixels, budget, &mut workspace);
                assert_eq!(done, Ok(Outcome::Finished));
                finite(&pixels);
                assert_eq!(
                    TileJob::new(TILE).give_up(renderer, view, &mut pixels),
                    Ok(())
                );
                finite(&pixels);
                assert!(renderer.unit(view, 3, 7) <= LARGEST_UNIT);
            }
        }
        if let Some(ray) = a_ray(n) {
            let tracer = Tracer::new(scene, Simd::detect(), 3);
            let budget = &mut { Budget::UNLIMITED };
            let hit = tracer.nearest(&ray, budget, &mut workspace);
            let limit = n.next(5.0);
            let is_dark = tracer.is_occluded(&ray, limit, budget, &mut workspace);
            assert!(!is_dark || hit.is_some() && limit > 0.0, "up to {limit}");
            finite(&(hit, tracer.radiance(&ray, budget, &mut workspace)));
            let corner = n.vector([0.05, -0.02, -1.0]);
            let may_hit = tracer.may_hit(ray.origin(), &[corner; 4], budget, &mut workspace);
            let along = Ray::new(ray.origin(), corner);
            let hit = along.and_then(|ray| tracer.nearest(&ray, budget, &mut workspace));
            assert!(may_hit || hit.is_none());
        }
    });
}

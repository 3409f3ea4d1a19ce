//! What the viewer sees on the walls is what stands behind them: the
//! re-projection of rendered walls against a picture traced from the eye.
//!
//! Walls are sampled at pixel centres and interpolated bilinearly, so a pixel
//! of the viewer's picture is a mean of what its eye sees within the size of
//! a wall's pixel around it: between the least and the greatest value there.
//! The direct picture, traced finer, tells these; where it is smooth the two
//! agree, and at silhouettes the error is bounded by the step across them.

use glam::DVec3;
use shisen::bake::Baked;
use shisen::cave::{Eye, Viewer};
use shisen::picture::Picture;
use shisen::render::{Observer, Options};
use shisen::scene::builtin::{PaperScene, paper_scene};
use shisen::show::overview::viewer::{ViewerCamera, render};
use shisen_core::Simd;
use shisen_core::frame::{Renderer, Settings, View};
use shisen_tests::meshes::meshes;
use shisen_tests::scenes::{frame, pixels, three_walls};

/// Pixels of the viewer's picture.
const SIZE: [u32; 2] = [160, 120];
/// Radians, across.
const FIELD_OF_VIEW: f64 = 1.0;
/// Directions: the middle of each wall, and over the seams between them.
const LOOKS: [[f64; 3]; 7] = [
    [0.0, 0.0, -1.0],
    [1.0, 0.0, 0.0],
    [0.2, -1.0, -0.3],
    [1.0, 0.0, -1.0],
    [0.0, -1.0, -1.0],
    [1.0, -1.0, 0.1],
    [1.0, -1.0, -1.0],
];
/// Rays of the direct picture a side of a viewer's pixel.
const FINER: u32 = 3;
/// The least and the greatest value may still hide between those rays.
const TOLERANCE: f32 = 0.02;

/// The camera's rays as the core's view, `finer` times as many each way.
fn direct_view(camera: &ViewerCamera, eye: DVec3, finer: u32) -> View {
    let [columns, rows] = SIZE.map(f64::from);
    let forward = camera.ray(0.5 * columns, 0.5 * rows);
    // The camera's directions are unit ones; at depth 1 they are affine.
    let at = |x: f64, y: f64| {
        let direction = camera.ray(x, y);
        direction / direction.dot(forward)
    };
    let pixel = 1.0 / f64::from(finer);
    let first = at(0.5 * pixel, 0.5 * pixel);
    let column = at(0.5 * pixel + columns, 0.5 * pixel) - first;
    let row = at(0.5 * pixel, 0.5 * pixel + rows) - first;
    View::new(
        eye.as_vec3(),
        first.as_vec3(),
        (column * (pixel / columns)).as_vec3(),
        (row * (pixel / rows)).as_vec3(),
        SIZE.map(|side| side * finer),
    )
    .expect("a view")
}

fn traced(baked: &Baked, view: &View) -> Vec<[f32; 3]> {
    let renderer = Renderer::new(baked.scene(), Simd::detect(), Settings::default());
    let pixels = pixels(&renderer, view);
    pixels.iter().map(|p| [p.red, p.green, p.blue]).collect()
}

/// How a re-projection differs from the direct picture.
#[derive(Debug, Clone, Copy, Default)]
struct Errors {
    /// Over all channels.
    mean: f64,
    /// Number of pixels outside the values around them.
    outside: f64,
    /// Number of pixels compared.
    compared: u32,
}

fn errors(
    walls: &[(&shisen::cave::Wall, &Picture)],
    side: u32,
    baked: &Baked,
    eye: DVec3,
    look: [f64; 3],
) -> Errors {
    let camera =
        ViewerCamera::new(eye, look.into(), DVec3::Y, FIELD_OF_VIEW, SIZE).expect("a camera");
    let view = render(&camera, walls).expect("a picture");
    let direct = traced(baked, &direct_view(&camera, eye, FINER));
    let [columns, rows] = SIZE.map(|side| side * FINER);
    // A wall's pixel, 3 m / side wide and 1.5 m away, as the viewer's picture
    // shows it, in rays of the direct picture; half a diagonal more.
    let step = f64::from(columns) / (2.0 * (0.5 * FIELD_OF_VIEW).tan());
    let reach = (1.5 * step * 3.0 / f64::from(side) / 1.5).ceil() as u32;
    let (mut sum, mut outside, mut compared) = (0.0, 0, 0);
    for (y, x) in (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (y, x))) {
        let found = view.pixel(x, y).expect("a pixel");
        if found[3] < 1.0 {
            // No wall, or its border.
            continue;
        }
        let [cx, cy] = [x, y].map(|c| c * FINER + FINER / 2);
        if cx < reach || cy < reach || cx + reach >= columns || cy + reach >= rows {
            continue;
        }
        compared += 1;
        let mut is_outside = false;
        for (channel, &found) in found[..3].iter().enumerate() {
            let (mut least, mut most) = (f32::INFINITY, f32::NEG_INFINITY);
            for row in cy - reach..=cy + reach {
                for column in cx - reach..=cx + reach {
                    let value = direct[(row * columns + column) as usize][channel];
                    least = least.min(value);
                    most = most.max(value);
                }
            }
            is_outside |= found < least - TOLERANCE || found > most + TOLERANCE;
            let centre = direct[(cy * columns + cx) as usize][channel];
            sum += f64::from((found - centre).abs());
        }
        outside += u32::from(is_outside);
    }
    Errors {
        mean: sum / f64::from(3 * compared),
        outside: f64::from(outside) / f64::from(compared),
        compared,
    }
}

#[test]
fn animals_are_seen_where_they_stand() {
    for (name, mesh) in meshes() {
        let scene = paper_scene(PaperScene::A, mesh).expect("a scene");
        let baked = Baked::<8>::new(&scene).expect("a scene");
        let eye = Viewer::default().eye(Eye::Left) + DVec3::new(0.1, 0.2, -0.15);
        let [coarse, fine] = [256, 512].map(|side| {
            let room = three_walls(side);
            let eyes = [Observer::new(Eye::Left, eye)];
            let frame = frame(&baked, &room, &eyes, &Options::default());
            let walls: Vec<_> = frame
                .pictures
                .iter()
                .map(|p| (&room.walls[p.wall], &p.picture))
                .collect();
            LOOKS.map(|look| errors(&walls, side, &baked, eye, look))
        });
        for (look, (coarse, fine)) in LOOKS.iter().zip(coarse.iter().zip(&fine)) {
            let what = format!("{name}, {look:?}: {coarse:?} {fine:?}");
            assert!(coarse.compared > SIZE[0] * SIZE[1] / 2, "{what}");
            assert!(coarse.mean < MEAN && fine.mean < MEAN, "{what}");
            assert!(coarse.outside < OUTSIDE && fine.outside < OUTSIDE, "{what}");
        }
        let mean = |errors: &[Errors; 7]| errors.iter().map(|e| e.mean).sum::<f64>();
        let ratio = mean(&coarse) / mean(&fine);
        assert!(ratio > 1.4, "{name}: the error falls by {ratio} only");
    }
}

/// Bounds of the mean error of a channel, and of the share of pixels outside
/// the values around them.
const MEAN: f64 = 0.012;
const OUTSIDE: f64 = 0.001;

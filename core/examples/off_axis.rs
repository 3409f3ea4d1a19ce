//! Renders a wall for an eye that is not in front of its middle.
//!
//! ```sh
//! cargo run -p shisen-core --example off_axis > wall.pgm
//! ```
//!
//! writes a grey picture. The eye is 0.4 m to the left of the wall's middle, so the
//! ball, which is behind the middle, appears to the left of it.

mod ball;

use glam::Vec3;
use shisen_core::Simd;
use shisen_core::frame::{
    Budget, FlatScreen, Outcome, Pixel, Renderer, Settings, Tile, TileJob, Workspace,
};
use shisen_core::scene::CompactScene;
use std::error::Error;
use std::io::Write as _;
use zerocopy::IntoBytes as _;

const SIDE: u32 = 128;

fn main() -> Result<(), Box<dyn Error>> {
    let bytes = ball::scene();
    let scene = CompactScene::from_bytes(bytes.as_bytes())?;
    let settings = Settings {
        samples: 4,
        ..Settings::default()
    };
    let renderer = Renderer::new(scene, Simd::detect(), settings);

    // The front wall of a 3 m room with the origin at its centre, and an eye beside the origin.
    let corner = |x, y| 1.5 * Vec3::new(x, y, -1.0);
    let (left, right, up) = (corner(-1.0, -1.0), corner(1.0, -1.0), corner(-1.0, 1.0));
    let wall = FlatScreen::from_corners(left, right, up, [SIDE; 2]);
    let view = wall.view_from(Vec3::new(-0.4, 0.0, 0.0))?;

    let mut pixels = vec![Pixel::default(); (SIDE * SIDE) as usize];
    let mut job = TileJob::new(Tile {
        x: 0,
        y: 0,
        width: SIDE,
        height: SIDE,
    });
    let (mut budget, mut workspace) = (Budget::UNLIMITED, Workspace::new());
    let outcome = job.render(&renderer, &view, &mut pixels, &mut budget, &mut workspace)?;
    assert_eq!(outcome, Outcome::Finished);

    // Light is linear; a picture file needs a display's transfer function.
    let code = |pixel: &Pixel| (255.0 * pixel.green.powf(1.0 / 2.2)) as u8;
    let codes: Vec<u8> = pixels.iter().map(code).collect();
    let mut out = std::io::stdout().lock();
    writeln!(out, "P5 {SIDE} {SIDE} 255")?;
    out.write_all(&codes)?;
    Ok(())
}

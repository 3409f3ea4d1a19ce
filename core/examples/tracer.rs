//! The smallest tracer: one ray, then one tile of 40×20 pixels, a few steps at a time.
//!
//! ```sh
//! cargo run -p shisen-core --example tracer
//! ```
//!
//! It says how far the ball is and how bright each pixel, and checks both: the
//! distance by a subtraction, the tile by one that was not interrupted.

mod ball;

use glam::Vec3;
use shisen_core::Simd;
use shisen_core::frame::{
    Budget, FlatScreen, Outcome, Pixel, Renderer, Settings, Tile, TileJob, Workspace,
};
use shisen_core::scene::CompactScene;
use shisen_core::shape::Ray;
use std::error::Error;
use zerocopy::IntoBytes as _;

fn main() -> Result<(), Box<dyn Error>> {
    let bytes = ball::scene();
    let scene = CompactScene::from_bytes(bytes.as_bytes())?;
    let renderer = Renderer::new(scene, Simd::detect(), Settings::default());
    let mut workspace = Workspace::new();

    let ray = Ray::new(Vec3::ZERO, Vec3::NEG_Z).ok_or("not a ray")?;
    let hit = renderer
        .tracer()
        .nearest(&ray, &mut Budget::steps(100), &mut workspace)
        .ok_or("the ball is not there")?;
    println!("the ball is {} m away", hit.on.t);
    assert_eq!(hit.on.t, ball::DISTANCE - ball::RADIUS);

    // As an eye at the origin sees it through a screen of 1.2 m a side.
    let corner = |x, y| Vec3::new(x, y, -2.0);
    let (left, right, up) = (corner(-0.6, -0.6), corner(0.6, -0.6), corner(-0.6, 0.6));
    let view = FlatScreen::from_corners(left, right, up, [40, 20]).view_from(Vec3::ZERO)?;
    let tile = Tile {
        x: 0,
        y: 0,
        width: 40,
        height: 20,
    };
    let mut render = |steps| {
        let (mut job, mut pixels, mut calls) = (TileJob::new(tile), [Pixel::default(); 800], 0);
        loop {
            calls += 1;
            let mut budget = Budget::steps(steps);
            // Between two calls something else may have its turn.
            match job.render(&renderer, &view, &mut pixels, &mut budget, &mut workspace) {
                Ok(Outcome::BudgetSpent) => {}
                Ok(Outcome::Finished) => return Ok((pixels, calls)),
                Err(error) => return Err(error),
            }
        }
    };
    let (pixels, calls) = render(100)?;
    for row in pixels.chunks(40) {
        let shades = b" .:-=+*#%@";
        let shade = |pixel: &Pixel| shades[(pixel.green * 9.99) as usize] as char;
        println!("{}", row.iter().map(shade).collect::<String>());
    }
    println!("100 steps at a time, in {calls} calls");
    assert_eq!(pixels, render(u64::MAX)?.0);
    Ok(())
}

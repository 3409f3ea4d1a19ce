//! A wall in 30 lines: what each eye sees on the front wall of a room of 3 m.
//!
//! ```sh
//! cargo run --release -p shisen --example wall
//! ```
//!
//! writes `front-left.png` and `front-right.png` of scene A of the paper, mirrors
//! behind the walls, and checks that one thread makes the same bits as all of them.

use glam::DVec3;
use shisen::bake::{BakedScene, Layout};
use shisen::cave::{Cave, Eye, Viewer, Wall};
use shisen::render::{self, Observer, Options};
use shisen::scene::builtin::{PaperScene, paper_scene};
use shisen::scene::quadruped::quadruped;
use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let baked = BakedScene::new(
        &paper_scene(PaperScene::A, quadruped())?,
        None,
        Layout::Fast,
    )?;

    // Three corners as the viewer sees them, metres; the viewer is at the origin.
    let corner = |x, y| 1.5 * DVec3::new(x, y, -1.0);
    let (left, right, up) = (corner(-1.0, -1.0), corner(1.0, -1.0), corner(-1.0, 1.0));
    let room = Cave::new(vec![Wall::new("front", left, right, up, [256; 2])?])?;
    let viewer = Viewer::default();
    let eyes = Eye::STEREO.map(|eye| Observer::new(eye, viewer.eye(eye)));

    let options = Options::default();
    let frame = render::cave(baked.scene(), &room, &eyes, &options, &|_, _| {})?;
    for seen in &frame.pictures {
        let name = format!("front-{}.png", seen.eye);
        seen.picture.write_png(Path::new(&name), &[])?;
        println!("{name}");
    }
    println!(
        "{} primary rays, frame {:016x}",
        frame.statistics.primary,
        frame.hash()
    );

    let alone = Options {
        threads: 1,
        ..options
    };
    let again = render::cave(baked.scene(), &room, &eyes, &alone, &|_, _| {})?;
    assert_eq!(frame.hash(), again.hash());
    Ok(())
}

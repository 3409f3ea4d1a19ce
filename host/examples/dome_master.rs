//! A dome master: half of all directions in one picture, as a true fisheye takes it and
//! as a camera sees it in a small mirrored spheroid.
//!
//! ```sh
//! cargo run --release -p shisen --example dome_master
//! ```
//!
//! writes `fisheye.png` and `mirror.png`, the front at the bottom, and checks that they
//! show the same: the mirror is optics, not an object, so its picture lacks nothing.

use shisen::bake::{BakedScene, Layout};
use shisen::render::{self, Options};
use shisen::scene::builtin::{PaperScene, paper_scene};
use shisen::scene::camera::DomeCamera;
use shisen::scene::quadruped::quadruped;
use shisen_core::frame::{DomeProjection, MirrorCamera, View};
use std::error::Error;
use std::f32::consts::PI;
use std::path::Path;

const SIZE: u32 = 256;

fn main() -> Result<(), Box<dyn Error>> {
    let baked = BakedScene::new(
        &paper_scene(PaperScene::A, quadruped())?,
        None,
        Layout::Fast,
    )?;
    // Metres: next to nothing beside the room, so that nothing is displaced.
    let by_mirror = MirrorCamera::best(1.0e-6);
    let render = |name: &str, projection| -> Result<_, Box<dyn Error>> {
        let view = View::dome(projection, DomeCamera::UPRIGHT.pose(), SIZE)?;
        let options = Options::default();
        let dome = render::dome(baked.scene(), &view, None, &options, &|_, _| {})?;
        dome.picture.write_png_with_alpha(Path::new(name), &[])?;
        println!("{name}, {} primary rays", dome.statistics.primary);
        Ok(dome.picture)
    };
    let fisheye = render(
        "fisheye.png",
        DomeProjection::Equidistant { field_of_view: PI },
    )?;
    let mirror = render("mirror.png", DomeProjection::Mirror(by_mirror))?;

    let pixels = fisheye.core_pixels().iter().zip(mirror.core_pixels());
    let other = pixels.filter(|(one, other)| (one.green - other.green).abs() > 1.0 / 255.0);
    let share = other.count() as f64 / f64::from(SIZE * SIZE);
    println!(
        "{:.2} % of the pixels differ by more than 1/255",
        100.0 * share
    );
    assert!(share < 0.01);
    Ok(())
}

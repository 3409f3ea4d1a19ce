//! Scenes as bytes and as text: each is refused with a word why, or gives
//! pixels that are numbers. For the fuzz targets, and for the tests with
//! damaged scene files.

use glam::Vec3;
use shisen::bake::Baked;
use shisen::scene::Scene;
use shisen::scene::file::MeshSource;
use shisen::scene::mesh::TriangleMesh;
use shisen_core::Simd;
use shisen_core::frame::{Budget, Mode, Pixel, Renderer, Settings, Tile, TileJob, View, Workspace};
use shisen_core::scene::format::seal;
use std::path::Path;

/// Returns a baked scene; its checksum is mended, or nothing else of it would be read.
/// Says whether it was one.
pub(crate) fn blob(bytes: &[u8]) -> bool {
    let mut bytes = bytes.to_vec();
    seal(&mut bytes);
    match Baked::<8>::from_bytes(&bytes) {
        Ok(baked) => {
            show(&baked);
            true
        }
        Err(error) => {
            assert!(!error.to_string().is_empty());
            false
        }
    }
}

/// Returns a scene file, whose meshes are all the same square. Says whether it was
/// one.
pub(crate) fn file(text: &str) -> bool {
    let square = |_: &MeshSource| Ok::<_, std::io::Error>(TriangleMesh::square());
    let nowhere = Path::new("no such folder");
    let scene = match Scene::from_toml(text, "a.toml", nowhere, square) {
        Ok(scene) => scene,
        Err(fault) => {
            assert!(!fault.to_string().is_empty());
            return false;
        }
    };
    // What a file may say can be too large or too small all together.
    match Baked::<8>::new(&scene) {
        Ok(baked) => show(&baked),
        Err(error) => assert!(!error.to_string().is_empty()),
    }
    true
}

/// Renders 8×8 pixels within a budget of steps.
fn show(baked: &Baked<8>) {
    let (right, down) = (Vec3::X / 4.0, Vec3::NEG_Y / 4.0);
    let view = View::new(Vec3::ZERO, Vec3::new(-0.9, 0.9, -1.0), right, down, [8, 8]);
    let view = view.expect("a screen");
    let tile = Tile {
        x: 0,
        y: 0,
        width: 8,
        height: 8,
    };
    for mode in [Mode::Tile, Mode::Single] {
        let settings = Settings {
            mode,
            ..Settings::default()
        };
        let renderer = Renderer::new(baked.scene(), Simd::detect(), settings);
        let mut pixels = [Pixel::default(); 64];
        let mut job = TileJob::new(tile);
        let (mut budget, mut workspace) = (Budget::steps(20_000), Workspace::new());
        let rendered = job.render(&renderer, &view, &mut pixels, &mut budget, &mut workspace);
        assert!(rendered.is_ok(), "{rendered:?}");
        for pixel in &pixels {
            let channels = [pixel.red, pixel.green, pixel.blue, pixel.alpha];
            assert!(channels.iter().all(|c| c.is_finite()), "{pixel:?}");
        }
    }
}

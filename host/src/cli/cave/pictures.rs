//! The pictures of a frame and the files they go to.

use super::report::{Image, Written, hexadecimal};
use crate::cli::failure::Failure;
use glam::DVec3;
use shisen::cave::{Cave, Eye, Wall};
use shisen::net;
use shisen::picture::Picture;
use shisen::render::Frame;
use shisen::viewer::{self, ViewerCamera};
use std::path::Path;

/// What viewer.png looks at.
pub(super) struct View {
    /// Whose pictures it shows.
    pub(super) eye: Eye,
    /// Where that eye is: metres, in the room.
    pub(super) position: DVec3,
    /// Where it looks.
    pub(super) forward: DVec3,
    /// What is up in the picture.
    pub(super) up: DVec3,
    /// Horizontal: radians.
    pub(super) field_of_view: f64,
    /// Columns and rows.
    pub(super) size: [u32; 2],
}

/// Where pictures go and what is noted in them.
pub(super) struct Writer<'a> {
    /// Exists.
    pub(super) folder: &'a Path,
    /// What the pictures show.
    pub(super) title: &'a str,
    /// Whether to write linear files, too.
    pub(super) exr: bool,
}

impl Writer<'_> {
    /// Writes all pictures of a frame, the walls' own first.
    ///
    /// # Errors
    /// A file that cannot be written, or a composite that cannot be made.
    pub(super) fn write(
        &self,
        frame: &Frame,
        cave: &Cave,
        view: &View,
    ) -> Result<Written, Failure> {
        let mut images = Vec::new();
        let mut exr = Vec::new();
        let mut seen: Vec<(&Wall, &Picture)> = Vec::new();
        for one in &frame.pictures {
            let Some(wall) = cave.walls.get(one.wall) else {
                continue;
            };
            if one.eye == view.eye {
                seen.push((wall, &one.picture));
            }
            let name = format!("{}-{}", wall.name, one.eye);
            let note = format!("{}, wall {}, {} eye", self.title, wall.name, one.eye);
            let path = self.write_png(&name, &one.picture, note.clone())?;
            if self.exr {
                let path = self.folder.join(format!("{name}.exr"));
                one.picture
                    .write_exr(&path, &metadata(note))
                    .map_err(Failure::from_error)?;
                exr.push(path.display().to_string());
            }
            images.push(Image {
                wall: wall.name.clone(),
                eye: one.eye.name(),
                path,
                hash: hexadecimal(one.picture.hash()),
            });
        }
        let net = net::unfold(&seen).map_err(Failure::from_error)?;
        let note = format!("{}, all walls, {} eye", self.title, view.eye);
        let cave = self.write_png("cave", &net, note)?;
        let camera = ViewerCamera::new(
            view.position,
            view.forward,
            view.up,
            view.field_of_view,
            view.size,
        )
        .map_err(Failure::from_error)?;
        let seen = viewer::render(&camera, &seen).map_err(Failure::from_error)?;
        let note = format!("{}, as the {} eye sees the walls", self.title, view.eye);
        let viewer = self.write_png("viewer", &seen, note)?;
        Ok(Written {
            images,
            exr,
            cave,
            viewer,
        })
    }

    /// Writes a PNG and returns its path: the folder as given, and its name.
    fn write_png(&self, name: &str, picture: &Picture, note: String) -> Result<String, Failure> {
        let path = self.folder.join(format!("{name}.png"));
        picture
            .write_png(&path, &metadata(note))
            .map_err(Failure::from_error)?;
        Ok(path.display().to_string())
    }
}

/// What is noted in a file: no time or place, so that equal pictures give
/// equal files.
fn metadata(note: String) -> [(&'static str, String); 2] {
    let software = concat!("Shisen ", env!("CARGO_PKG_VERSION"));
    [("Software", software.to_owned()), ("Description", note)]
}

//! The pictures of a frame and the files they go to.

use super::lod::LodPictures;
use super::report::{Image, Written};
use crate::cave::{Cave, Eye, Screen};
use crate::cli::output::failure::Failure;
use crate::cli::output::picture_files::{hexadecimal, metadata};
use crate::picture::Picture;
use crate::render::{Capture, Frame, Observer};
use crate::show::overview::net;
use crate::show::overview::viewer::{self, ViewerCamera};
use crate::show::stereo::Stereo;
use std::path::Path;

/// Where pictures go and what is noted in them.
pub(super) struct Writer<'a> {
    /// Exists.
    pub(super) folder: &'a Path,
    /// What the pictures show.
    pub(super) title: &'a str,
    /// Whether to write linear files, too.
    pub(super) exr: bool,
    /// How to write both eyes' pictures for a display of one.
    pub(super) stereo: Stereo,
}

impl Writer<'_> {
    /// Writes all pictures of a frame, the walls' own first; those of the first
    /// eye are put together, as the first of `cameras` sees them too, and those of
    /// both for a display of one picture, where they are wanted so.
    ///
    /// # Errors
    /// A file that cannot be written, or a composite that cannot be made.
    pub(super) fn write(
        &self,
        frame: &Frame,
        cave: &Cave,
        observers: &[Observer],
        cameras: &[ViewerCamera],
        lod: Option<&LodPictures>,
    ) -> Result<Written, Failure> {
        let eye = observers
            .first()
            .map_or(Eye::Centre, |observer| observer.eye);
        let mut images = Vec::new();
        let mut exr = Vec::new();
        let mut seen: Vec<(Screen<'_>, &Picture)> = Vec::new();
        for one in &frame.pictures {
            let Some(screen) = cave.screens().nth(one.wall) else {
                continue;
            };
            if one.eye == eye {
                seen.push((screen, &one.picture));
            }
            let name = format!("{}-{}", screen.name(), one.eye);
            let kind = match screen {
                Screen::Wall(_) => "wall",
                Screen::Dome(_) => "dome",
            };
            let note = format!("{}, {kind} {}, {} eye", self.title, screen.name(), one.eye);
            let path = self.write_screen(&name, screen, &one.picture, note.clone())?;
            if self.exr {
                let path = self.folder.join(format!("{name}.exr"));
                one.picture
                    .write_exr(&path, &metadata(note))
                    .map_err(Failure::from_error)?;
                exr.push(path.display().to_string());
            }
            images.push(Image {
                wall: screen.name().to_owned(),
                eye: one.eye.name(),
                path,
                hash: hexadecimal(one.picture.hash()),
            });
        }
        let net = net::unfold(&seen).map_err(Failure::from_error)?;
        let note = format!("{}, all walls, {eye} eye", self.title);
        let stereo = self.write_stereo(frame, cave, cameras)?;
        let cave = self.write_png("cave", &net, note)?;
        let camera = cameras.first();
        let viewer = camera.map(|camera| {
            let seen = viewer::render(camera, &seen).map_err(Failure::from_error)?;
            let note = format!("{}, as the {eye} eye sees the walls", self.title);
            self.write_png("viewer", &seen, note)
        });
        let viewer = viewer.transpose()?.unwrap_or_default();
        let (mut levels, mut polygons, mut difference) = (None, None, None);
        if let Some(lod) = lod {
            let note = |what: &str| format!("{}, {what}, {eye} eye", self.title);
            let write = |name, picture, what| self.write_png(name, picture, note(what)).map(Some);
            levels = write("levels", &lod.levels, "level of each pixel")?;
            polygons = write("polygons", &lod.polygons, "faces that each pixel sees")?;
            difference = write("difference", &lod.difference, "against full tracing")?;
        }
        Ok(Written {
            images,
            exr,
            cave,
            viewer,
            stereo,
            levels,
            polygons,
            difference,
        })
    }

    /// Writes a screen's own PNG, a dome's with alpha, as [`Self::write_png`].
    fn write_screen(
        &self,
        name: &str,
        screen: Screen<'_>,
        picture: &Picture,
        note: String,
    ) -> Result<String, Failure> {
        if let Screen::Wall(_) = screen {
            return self.write_png(name, picture, note);
        }
        let path = self.folder.join(format!("{name}.png"));
        picture
            .write_png_with_alpha(&path, &metadata(note))
            .map_err(Failure::from_error)?;
        Ok(path.display().to_string())
    }

    /// Writes what was captured of the surroundings, if anything was: the paths.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(super) fn write_capture(&self, capture: Option<&Capture>) -> Result<Vec<String>, Failure> {
        let Some(capture) = capture else {
            return Ok(Vec::new());
        };
        let names = ["capture-ahead", "capture-behind"];
        names
            .into_iter()
            .zip(&capture.hemispheres)
            .map(|(name, picture)| {
                let path = self.folder.join(format!("{name}.png"));
                let note = format!("{}, surroundings", self.title);
                picture
                    .write_png_with_alpha(&path, &metadata(note))
                    .map_err(Failure::from_error)?;
                Ok(path.display().to_string())
            })
            .collect()
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

//! The files of a frame's pictures.

use super::lod::LodPictures;
use super::report::{Image, StereoReport, Written};
use crate::cave::{Cave, Eye, Screen};
use crate::cli::output::picture_files::{hexadecimal, metadata};
use crate::cli::prelude::*;
use crate::picture::Picture;
use crate::render::{Capture, Frame, Observer};
use crate::show::overview::net;
use crate::show::overview::viewer::{self, ViewerCamera};
use crate::show::stereo::Stereo;

pub(super) struct Writer<'a> {
    /// Existing folder of the pictures.
    pub(super) folder: &'a Path,
    /// What the pictures show, as a note in the files.
    pub(super) title: &'a str,
    /// Whether to write linear files too.
    pub(super) exr: bool,
    /// How to write both eyes' pictures for a display of one picture.
    pub(super) stereo: Stereo,
}

impl Writer<'_> {
    /// Writes all pictures of a frame: those of the walls, the first eye's unfolded and as the first
    /// of `cameras` sees them, those for a display of one picture, and those of a level of detail.
    pub(super) fn write(
        &self,
        frame: &Frame,
        cave: &Cave,
        observers: &[Observer],
        cameras: &[ViewerCamera],
        lod: Option<&LodPictures>,
    ) -> Result<Written, Failure> {
        let eye = observers.first().map_or(Eye::Centre, |one| one.eye);
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
            let path = match screen {
                Screen::Wall(_) => self.write_png(&name, &one.picture, note.clone())?,
                Screen::Dome(_) => self.write_with_alpha(&name, &one.picture, note.clone())?,
            };
            if self.exr {
                let path = self.folder.join(format!("{name}.exr"));
                one.picture.write_exr(&path, &metadata(note)).or_fail()?;
                exr.push(path.display().to_string());
            }
            images.push(Image {
                wall: screen.name().to_owned(),
                eye: one.eye.name(),
                path,
                hash: hexadecimal(one.picture.hash()),
            });
        }
        let net = net::unfold(&seen).or_fail()?;
        let note = format!("{}, all walls, {eye} eye", self.title);
        let stereo = self.write_stereo(frame, cave, cameras)?;
        let cave = self.write_png("cave", &net, note)?;
        let camera = cameras.first();
        let viewer = camera.map(|camera| {
            let seen = viewer::render(camera, &seen).or_fail()?;
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

    /// Writes the captured surroundings, if any, and returns the paths.
    pub(super) fn write_capture(&self, capture: Option<&Capture>) -> Result<Vec<String>, Failure> {
        let Some(capture) = capture else {
            return Ok(Vec::new());
        };
        let names = ["capture-ahead", "capture-behind"].into_iter();
        let note = format!("{}, surroundings", self.title);
        let write = |(name, picture)| self.write_with_alpha(name, picture, note.clone());
        names.zip(&capture.hemispheres).map(write).collect()
    }

    fn write_with_alpha(
        &self,
        name: &str,
        picture: &Picture,
        note: String,
    ) -> Result<String, Failure> {
        let path = self.folder.join(format!("{name}.png"));
        let notes = metadata(note);
        picture.write_png_with_alpha(&path, &notes).or_fail()?;
        Ok(path.display().to_string())
    }

    /// Writes a PNG and returns its path.
    fn write_png(&self, name: &str, picture: &Picture, note: String) -> Result<String, Failure> {
        let path = self.folder.join(format!("{name}.png"));
        picture.write_png(&path, &metadata(note)).or_fail()?;
        Ok(path.display().to_string())
    }

    /// Writes both eyes' walls unfolded and as `cameras`, one an eye, see them, for a display of one
    /// picture; nothing if one eye is enough.
    fn write_stereo(
        &self,
        frame: &Frame,
        cave: &Cave,
        cameras: &[ViewerCamera],
    ) -> Result<Option<StereoReport>, Failure> {
        let [left, right] = cameras else {
            return Ok(None);
        };
        if self.stereo == Stereo::Mono {
            return Ok(None);
        }
        let mut images = Vec::new();
        let [of_left, of_right] = Eye::STEREO.map(|eye| seen_by(eye, frame, cave));
        let unfold = |seen: &[_]| net::unfold(seen).or_fail();
        let nets = [unfold(&of_left)?, unfold(&of_right)?];
        self.write_pair("stereo-cave", &nets, &mut images)?;
        let look = |camera, seen: &[_]| viewer::render(camera, seen).or_fail();
        let views = [look(left, &of_left)?, look(right, &of_right)?];
        self.write_pair("stereo-viewer", &views, &mut images)?;
        Ok(Some(StereoReport {
            format: self.stereo.name(),
            eye_order: Eye::STEREO.map(Eye::name),
            images,
        }))
    }

    fn write_pair(
        &self,
        name: &str,
        [left, right]: &[Picture; 2],
        paths: &mut Vec<String>,
    ) -> Result<(), Failure> {
        for one in self.stereo.compose(left, right).or_fail()? {
            let suffix = one.eye.map_or(String::new(), |eye| format!("-{eye}"));
            let path = self.folder.join(format!("{name}{suffix}.png"));
            let mut notes = metadata(format!("{}, both eyes", self.title)).to_vec();
            notes.extend(self.stereo.metadata(one.eye));
            one.picture.write_png(&path, &notes).or_fail()?;
            paths.push(path.display().to_string());
        }
        Ok(())
    }
}

fn seen_by<'f>(eye: Eye, frame: &'f Frame, cave: &'f Cave) -> Vec<(Screen<'f>, &'f Picture)> {
    let pictures = frame.pictures.iter().filter(|one| one.eye == eye);
    let pictures = pictures.filter_map(|one| Some((cave.screens().nth(one.wall)?, &one.picture)));
    pictures.collect()
}

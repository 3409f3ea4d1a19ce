//! The files of a frame's pictures.

use super::lod::LodPictures;
use super::report::{Image, StereoReport, Written};
use crate::cave::{Eye, Screen};
use crate::cli::prelude::*;
use crate::picture::Picture;
use crate::render::{Capture, Frame, Observer};
use crate::show::overview::net;
use crate::show::overview::viewer::{self, ViewerCamera};
use crate::show::stereo::Stereo;

/// How the files of both eyes in one picture begin.
pub(in crate::cli) const STEREO_FILES: [&str; 2] = ["stereo-cave", "stereo-viewer"];

pub(in crate::cli) struct Writer<'a> {
    /// Existing folder of the pictures.
    pub(in crate::cli) folder: &'a Path,
    /// What the pictures show, as a note in the files.
    pub(in crate::cli) title: &'a str,
    /// Whether to write linear files too.
    pub(in crate::cli) exr: bool,
    /// How to write both eyes' pictures for a display of one picture.
    pub(in crate::cli) stereo: Stereo,
}

impl Writer<'_> {
    /// Writes all pictures of a frame: those of the walls, the first eye's unfolded and as the first
    /// of `cameras` sees them, those for a display of one picture, and those of a level of detail.
    pub(in crate::cli) fn write(
        &self,
        frame: &Frame,
        cave: &Cave,
        observers: &[Observer],
        cameras: &[ViewerCamera],
        lod: Option<&LodPictures>,
    ) -> Result<Written, Failure> {
        let eye = observers.first().map_or(Eye::Centre, |one| one.eye);
        let mut written = Written::default();
        for one in &frame.pictures {
            let Some(screen) = cave.screens().nth(one.wall) else {
                continue;
            };
            let name = format!("{}-{}", screen.name(), one.eye);
            let is_dome = matches!(screen, Screen::Dome(_));
            let note = format!("{} {}, {} eye", screen.kind(), screen.name(), one.eye);
            let path = self.write_png(&name, &one.picture, &note, is_dome)?;
            if self.exr {
                let path = self.folder.join(format!("{name}.exr"));
                one.picture.write_exr(&path, &self.notes(&note)).or_fail()?;
                written.exr.push(path.display().to_string());
            }
            written.images.push(Image {
                wall: screen.name().to_owned(),
                eye: one.eye.name(),
                path,
                hash: hexadecimal(one.picture.hash()),
                rays: one.statistics.into(),
            });
        }
        let seen = seen_by(eye, frame, cave);
        let net = net::unfold(&seen).or_fail()?;
        written.stereo = self.write_stereo(frame, cave, cameras)?;
        written.cave = self.write_png("cave", &net, &format!("all walls, {eye} eye"), false)?;
        if let Some(camera) = cameras.first() {
            let picture = viewer::render(camera, &seen).or_fail()?;
            let note = format!("as the {eye} eye sees the walls");
            written.viewer = self.write_png("viewer", &picture, &note, false)?;
        }
        if let Some(lod) = lod {
            let write = |name, picture, what| {
                let note = format!("{what}, {eye} eye");
                self.write_png(name, picture, &note, false).map(Some)
            };
            written.levels = write("levels", &lod.levels, "level of each pixel")?;
            written.polygons = write("polygons", &lod.polygons, "faces that each pixel sees")?;
            written.difference = write("difference", &lod.difference, "against full tracing")?;
        }
        Ok(written)
    }

    /// Writes the captured surroundings, if any, and returns the paths.
    pub(in crate::cli) fn write_capture(
        &self,
        capture: Option<&Capture>,
    ) -> Result<Vec<String>, Failure> {
        let names = ["capture-ahead", "capture-behind"].into_iter();
        let pictures = capture.iter().flat_map(|capture| &capture.hemispheres);
        let write = |(name, picture)| self.write_png(name, picture, "surroundings", true);
        names.zip(pictures).map(write).collect()
    }

    fn notes(&self, note: &str) -> [(&'static str, String); 2] {
        metadata(format!("{}, {note}", self.title))
    }

    /// Writes a PNG and returns its path.
    fn write_png(
        &self,
        name: &str,
        picture: &Picture,
        note: &str,
        with_alpha: bool,
    ) -> Result<String, Failure> {
        let path = self.folder.join(format!("{name}.png"));
        let notes = self.notes(note);
        let written = if with_alpha {
            picture.write_png_with_alpha(&path, &notes)
        } else {
            picture.write_png(&path, &notes)
        };
        written.or_fail()?;
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
        let [of_left, of_right] = &Eye::STEREO.map(|eye| seen_by(eye, frame, cave));
        let nets = [net::unfold(of_left), net::unfold(of_right)];
        let views = [
            viewer::render(left, of_left),
            viewer::render(right, of_right),
        ];
        for (name, [left, right]) in STEREO_FILES.into_iter().zip([nets, views]) {
            let composed = self.stereo.compose(&left.or_fail()?, &right.or_fail()?);
            for one in composed.or_fail()? {
                let suffix = one.eye.map_or(String::new(), |eye| format!("-{eye}"));
                let path = self.folder.join(format!("{name}{suffix}.png"));
                let mut notes = self.notes("both eyes").to_vec();
                notes.extend(self.stereo.metadata(one.eye));
                one.picture.write_png(&path, &notes).or_fail()?;
                images.push(path.display().to_string());
            }
        }
        Ok(Some(StereoReport {
            format: self.stereo.name(),
            eye_order: Eye::STEREO.map(Eye::name),
            images,
        }))
    }
}

fn seen_by<'f>(eye: Eye, frame: &'f Frame, cave: &'f Cave) -> Vec<(Screen<'f>, &'f Picture)> {
    let pictures = frame.pictures.iter().filter(|one| one.eye == eye);
    let pictures = pictures.filter_map(|one| Some((cave.screens().nth(one.wall)?, &one.picture)));
    pictures.collect()
}

//! The pictures of `--view png`.

use crate::cave::{Cave, Eye};
use crate::cli::output::failure::Failure;
use crate::cli::output::picture_files::{make_writable, metadata};
use crate::live::{Share, eyes_of};
use crate::picture::Picture;
use crate::render::Observer;
use crate::show::overview::net;
use crate::show::stereo::Stereo;
use std::path::{Path, PathBuf};

/// Files, one or two a frame.
pub(super) struct Files {
    folder: PathBuf,
    stereo: Stereo,
    cave: Cave,
    /// Where there are several machines, each writes its walls by themselves.
    share: Share,
}

impl Files {
    /// In a folder, which is made where it does not exist.
    ///
    /// # Errors
    /// A folder that cannot be written to.
    pub(super) fn new(
        folder: &Path,
        stereo: Stereo,
        cave: &Cave,
        share: Share,
    ) -> Result<Self, Failure> {
        make_writable(folder)?;
        Ok(Self {
            folder: folder.to_owned(),
            stereo,
            cave: cave.clone(),
            share,
        })
    }

    /// Writes a frame: its walls, unfolded.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(super) fn write(
        &self,
        number: u64,
        pictures: &[Picture],
        eyes: &[Observer],
    ) -> Result<(), Failure> {
        if self.share != Share::ALL {
            return self.write_walls(number, pictures, eyes);
        }
        let mut nets = Vec::new();
        for eye in eyes {
            // Mono shows the first eye, and the other's walls need no unfolding.
            if nets.is_empty() || self.stereo != Stereo::Mono {
                nets.push(self.net(eye.eye, pictures, eyes)?);
            }
        }
        let (Some(left), Some(right)) = (nets.first(), nets.last()) else {
            return Ok(());
        };
        let shown = self.stereo.compose(left, right);
        for one in shown.map_err(Failure::from_error)? {
            let suffix = match (self.stereo, one.eye) {
                (Stereo::Sequential, Some(eye)) => format!("-{eye}"),
                _ => String::new(),
            };
            let path = self.folder.join(format!("frame-{number:06}{suffix}.png"));
            let eye = match self.stereo {
                Stereo::Mono => eyes.first().map(|eye| eye.eye),
                _ => one.eye,
            };
            let mut notes = metadata(format!("frame {number}, all walls")).to_vec();
            notes.extend(self.stereo.metadata(eye));
            one.picture
                .write_png(&path, &notes)
                .map_err(Failure::from_error)?;
        }
        Ok(())
    }

    /// A file for each wall and eye.
    fn write_walls(
        &self,
        number: u64,
        pictures: &[Picture],
        eyes: &[Observer],
    ) -> Result<(), Failure> {
        for ((screen, eye), picture) in eyes_of(&self.cave, eyes, self.share).zip(pictures) {
            let Some(screen) = self.cave.screens().nth(screen) else {
                continue;
            };
            let name = format!("frame-{number:06}-{}-{eye}.png", screen.name());
            let notes = metadata(format!("frame {number}, {}, {eye} eye", screen.name()));
            picture
                .write_png(&self.folder.join(name), &notes)
                .map_err(Failure::from_error)?;
        }
        Ok(())
    }

    fn net(&self, eye: Eye, pictures: &[Picture], eyes: &[Observer]) -> Result<Picture, Failure> {
        let pictures = eyes_of(&self.cave, eyes, self.share).zip(pictures);
        let seen: Vec<_> = pictures
            .filter(|((_, of), _)| *of == eye)
            .filter_map(|((screen, _), picture)| Some((self.cave.screens().nth(screen)?, picture)))
            .collect();
        net::unfold(&seen).map_err(Failure::from_error)
    }
}

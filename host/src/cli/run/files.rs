//! The pictures of `--view png`, and the file of `--record`.

use crate::cave::Eye;
use crate::cli::prelude::*;
use crate::live::{FrameRecord, Share, eyes_of};
use crate::picture::Picture;
use crate::render::Observer;
use crate::show::overview::net;
use crate::show::stereo::Stereo;
use std::fs::File;
use std::io::{BufWriter, Write};

pub(super) struct Files {
    folder: PathBuf,
    stereo: Stereo,
    cave: Cave,
    /// This machine's walls and eyes.
    share: Share,
}

impl Files {
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
            // Mono shows the first eye only.
            if nets.is_empty() || self.stereo != Stereo::Mono {
                nets.push(self.net(eye.eye, pictures, eyes)?);
            }
        }
        let (Some(left), Some(right)) = (nets.first(), nets.last()) else {
            return Ok(());
        };
        for one in self.stereo.compose(left, right).or_fail()? {
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
            one.picture.write_png(&path, &notes).or_fail()?;
        }
        Ok(())
    }

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
                .or_fail()?;
        }
        Ok(())
    }

    fn net(&self, eye: Eye, pictures: &[Picture], eyes: &[Observer]) -> Result<Picture, Failure> {
        let pictures = eyes_of(&self.cave, eyes, self.share).zip(pictures);
        let seen: Vec<_> = pictures
            .filter(|((_, one), _)| *one == eye)
            .filter_map(|((screen, _), picture)| Some((self.cave.screens().nth(screen)?, picture)))
            .collect();
        net::unfold(&seen).or_fail()
    }
}

/// Writes a line for each frame.
pub(super) struct Log {
    path: PathBuf,
    file: BufWriter<File>,
}

impl Log {
    pub(super) fn create(path: &Path) -> Result<Self, Failure> {
        let file = File::create(path).map_err(Fault::write(path))?;
        Ok(Self {
            path: path.to_owned(),
            file: BufWriter::with_capacity(1 << 20, file),
        })
    }

    pub(super) fn write(&mut self, record: &FrameRecord) -> Result<(), Failure> {
        let written = serde_json::to_writer(&mut self.file, record).map_err(Into::into);
        let written = written.and_then(|()| self.file.write_all(b"\n"));
        Ok(written.map_err(Fault::write(&self.path))?)
    }

    pub(super) fn finish(mut self) -> Result<(), Failure> {
        Ok(self.file.flush().map_err(Fault::write(&self.path))?)
    }
}

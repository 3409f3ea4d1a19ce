//! The pictures of `--view png`, and the file of `--report`.

use crate::cave::{Eye, Screen};
use crate::cli::prelude::*;
use crate::live::{FrameRecord, Share, eyes_of};
use crate::picture::Picture;
use crate::render::Observer;
use crate::show::overview::net;
use crate::show::stereo::Stereo;
use std::fs::File;
use std::io::{BufWriter, Write};

pub(in crate::cli) struct Files {
    /// Existing folder of the pictures.
    pub(in crate::cli) folder: PathBuf,
    pub(in crate::cli) stereo: Stereo,
    pub(in crate::cli) cave: Cave,
    /// This machine's walls and eyes.
    pub(in crate::cli) share: Share,
}

impl Files {
    pub(in crate::cli) fn write(
        &self,
        number: u64,
        pictures: &[Picture],
        eyes: &[Observer],
    ) -> Result<(), Failure> {
        if self.share != Share::ALL {
            return self.write_walls(number, pictures, eyes);
        }
        let count = if self.stereo == Stereo::Mono { 1 } else { 2 };
        let nets = eyes.iter().take(count);
        let nets = nets.map(|eye| self.net(eye.eye, pictures, eyes));
        let nets = nets.collect::<Result<Vec<_>, _>>()?;
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
        for (screen, eye, picture) in self.seen(pictures, eyes) {
            let name = format!("frame-{number:06}-{}-{eye}.png", screen.name());
            let notes = metadata(format!("frame {number}, {}, {eye} eye", screen.name()));
            picture
                .write_png(&self.folder.join(name), &notes)
                .or_fail()?;
        }
        Ok(())
    }

    fn seen<'a>(
        &'a self,
        pictures: &'a [Picture],
        eyes: &'a [Observer],
    ) -> impl Iterator<Item = (Screen<'a>, Eye, &'a Picture)> {
        let seen = eyes_of(&self.cave, eyes, self.share).zip(pictures);
        seen.filter_map(|((screen, eye), picture)| {
            Some((self.cave.screens().nth(screen)?, eye, picture))
        })
    }

    fn net(&self, eye: Eye, pictures: &[Picture], eyes: &[Observer]) -> Result<Picture, Failure> {
        let seen = self.seen(pictures, eyes).filter(|(_, one, _)| *one == eye);
        let seen: Vec<_> = seen.map(|(screen, _, picture)| (screen, picture)).collect();
        net::unfold(&seen).or_fail()
    }
}

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

//! The file of `--record`.

use crate::cli::output::failure::{Failure, Fault};
use crate::live::FrameRecord;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// A line a frame.
pub(super) struct Log {
    path: PathBuf,
    file: BufWriter<File>,
}

impl Log {
    pub(super) fn create(path: &Path) -> Result<Self, Failure> {
        let file = File::create(path).map_err(|reason| Fault::Write {
            path: path.to_owned(),
            reason,
        })?;
        Ok(Self {
            path: path.to_owned(),
            file: BufWriter::with_capacity(1 << 20, file),
        })
    }

    pub(super) fn write(&mut self, record: &FrameRecord) -> Result<(), Failure> {
        let written = serde_json::to_writer(&mut self.file, record).map_err(Into::into);
        let written = written.and_then(|()| self.file.write_all(b"\n"));
        written.map_err(|reason| self.failed(reason))
    }

    pub(super) fn finish(mut self) -> Result<(), Failure> {
        let flushed = self.file.flush();
        flushed.map_err(|reason| self.failed(reason))
    }

    fn failed(&self, reason: std::io::Error) -> Failure {
        Fault::Write {
            path: self.path.clone(),
            reason,
        }
        .into()
    }
}

//! The firmware's image, built where none is given.

use miette::Diagnostic;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;
use thiserror::Error;

/// The processor's target.
const TARGET: &str = "thumbv7em-none-eabihf";

/// An image for the emulated board.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Image {
    path: PathBuf,
    elf: Vec<u8>,
}

/// Why there is no image.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum ImageError {
    /// It cannot be read.
    #[error("the image {} cannot be read: {reason}", path.display())]
    #[diagnostic(help("give the path of an ELF file that tests/firmware/run built"))]
    Read {
        /// Which.
        path: PathBuf,
        /// What the system said.
        reason: io::Error,
    },
    /// It is no program for the board.
    #[error("{} is no ELF file of a 32-bit Arm processor", path.display())]
    #[diagnostic(help("give the path of an ELF file that tests/firmware/run built"))]
    NotAnImage {
        /// Which.
        path: PathBuf,
    },
    /// The sources are not where the command was built from.
    #[error("there are no sources of the firmware in {}", path.display())]
    #[diagnostic(help("give a built image with --image, or run the command from its checkout"))]
    Sources {
        /// Where they would be.
        path: PathBuf,
    },
    /// The compiler has nothing for the target.
    #[error("the firmware cannot be built: the target {TARGET} is not installed")]
    #[diagnostic(help("install it: rustup target add {TARGET}"))]
    Target,
    /// There is no cargo.
    #[error("the firmware cannot be built: cargo does not start: {reason}")]
    #[diagnostic(help("install Rust with rustup, or give a built image with --image"))]
    Cargo {
        /// What the system said.
        reason: io::Error,
    },
    /// The build fails.
    #[error("the firmware cannot be built:\n{output}")]
    #[diagnostic(help("`tests/firmware/run` builds it, too, and says what is missing"))]
    Build {
        /// What cargo said.
        output: String,
    },
}

impl Image {
    /// One that has been built.
    ///
    /// # Errors
    /// A file that cannot be read, or is no image.
    pub fn open(path: &Path) -> Result<Self, ImageError> {
        let elf = std::fs::read(path).map_err(|reason| ImageError::Read {
            path: path.to_owned(),
            reason,
        })?;
        // Its class, its byte order and its machine.
        let is_arm = elf.starts_with(b"\x7fELF\x01\x01") && elf.get(18..20) == Some(&[40, 0]);
        if !is_arm {
            return Err(ImageError::NotAnImage {
                path: path.to_owned(),
            });
        }
        Ok(Self {
            path: path.to_owned(),
            elf,
        })
    }

    /// Builds the controller, with wavelengths or without.
    ///
    /// # Errors
    /// Sources or a target that are not there; what the compiler says.
    pub fn build(dispersion: bool) -> Result<Self, ImageError> {
        let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("firmware");
        let manifest = sources.join("Cargo.toml");
        if !manifest.is_file() {
            return Err(ImageError::Sources { path: sources });
        }
        let name = if dispersion {
            "dispersion"
        } else {
            "controller"
        };
        let target = match std::env::var_os("CARGO_TARGET_DIR") {
            Some(target) => PathBuf::from(target),
            None => sources.join("../../target"),
        };
        let target = target.join("firmware").join(name);
        let features = if dispersion {
            "controller,log,fpv5,dispersion"
        } else {
            "controller,log,fpv5"
        };
        let built = Command::new("cargo")
            .args([
                "build",
                "--quiet",
                "--locked",
                "--release",
                "--bin",
                "controller",
            ])
            .args([
                "--target",
                TARGET,
                "--features",
                features,
                "--manifest-path",
            ])
            .arg(&manifest)
            .arg("--target-dir")
            .arg(&target)
            // As tests/firmware/run builds it.
            .env(
                "RUSTFLAGS",
                "-C llvm-args=-inline-threshold=20 -C target-cpu=cortex-m7 -C link-arg=-Tdefmt.x",
            )
            .env("DEFMT_LOG", "info")
            .output()
            .map_err(|reason| ImageError::Cargo { reason })?;
        if !built.status.success() {
            let output = String::from_utf8_lossy(&built.stderr).into_owned();
            return Err(if output.contains("target may not be installed") {
                ImageError::Target
            } else {
                ImageError::Build { output }
            });
        }
        Self::open(&target.join(TARGET).join("release/controller"))
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Its bytes.
    pub fn elf(&self) -> &[u8] {
        &self.elf
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_image_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("image");
        assert!(matches!(Image::open(&path), Err(ImageError::Read { .. })));
        for bytes in [&b""[..], b"\x7fELF\x02\x01", b"#!/bin/sh\n"] {
            std::fs::write(&path, bytes).unwrap();
            assert!(matches!(
                Image::open(&path),
                Err(ImageError::NotAnImage { .. })
            ));
        }
        let mut elf = b"\x7fELF\x01\x01\x01".to_vec();
        elf.resize(18, 0);
        elf.extend([40, 0]);
        std::fs::write(&path, &elf).unwrap();
        assert_eq!(Image::open(&path).unwrap().elf(), elf);
    }
}

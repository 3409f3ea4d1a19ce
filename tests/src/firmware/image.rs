//! The firmware's image, built if no file is given.

use super::FirmwareError;
use std::path::{Path, PathBuf};
use std::process::Command;

const TARGET: &str = "thumbv7em-none-eabihf";

/// An image for the emulated board.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Image {
    path: PathBuf,
    elf: Vec<u8>,
}

const AN_IMAGE: &str = "give the path of an ELF file that tests/firmware/run built";

impl Image {
    /// Reads an image that has been built.
    ///
    /// # Errors
    /// A file that cannot be read, or is not an image for the board.
    pub fn open(path: &Path) -> Result<Self, FirmwareError> {
        let shown = path.display();
        let elf = std::fs::read(path).map_err(|reason| {
            FirmwareError::new(
                format!("the image {shown} cannot be read: {reason}"),
                AN_IMAGE,
            )
        })?;
        // Its class, its byte order and its machine.
        let is_arm = elf.starts_with(b"\x7fELF\x01\x01") && elf.get(18..20) == Some(&[40, 0]);
        if !is_arm {
            let what = format!("{shown} is no ELF file of a 32-bit Arm processor");
            return Err(FirmwareError::new(what, AN_IMAGE));
        }
        Ok(Self {
            path: path.to_owned(),
            elf,
        })
    }

    /// Builds the controller, with wavelengths or without.
    ///
    /// # Errors
    /// Missing sources, a missing target, or errors of the compiler.
    pub fn build(dispersion: bool) -> Result<Self, FirmwareError> {
        let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("firmware");
        let manifest = sources.join("Cargo.toml");
        if !manifest.is_file() {
            return Err(FirmwareError::new(
                format!(
                    "there are no sources of the firmware in {}",
                    sources.display()
                ),
                "give a built image with --image, or run the command from its checkout",
            ));
        }
        let (name, features) = if dispersion {
            ("dispersion", "controller,log,fpv5,dispersion")
        } else {
            ("controller", "controller,log,fpv5")
        };
        let target = match std::env::var_os("CARGO_TARGET_DIR") {
            Some(target) => PathBuf::from(target),
            None => sources.join("../../target"),
        };
        let target = target.join("firmware").join(name);
        let built = Command::new("cargo")
            .args("build --quiet --locked --release --bin controller --target".split(' '))
            .args([TARGET, "--features", features, "--manifest-path"])
            .arg(&manifest)
            .arg("--target-dir")
            .arg(&target)
            // The same flags as in tests/firmware/run.
            .env(
                "RUSTFLAGS",
                "-C llvm-args=-inline-threshold=20 -C target-cpu=cortex-m7 -C link-arg=-Tdefmt.x",
            )
            .env("DEFMT_LOG", "info")
            .output()
            .map_err(|reason| {
                FirmwareError::new(
                    format!("the firmware cannot be built: cargo does not start: {reason}"),
                    "install Rust with rustup, or give a built image with --image",
                )
            })?;
        if !built.status.success() {
            let output = String::from_utf8_lossy(&built.stderr).into_owned();
            return Err(if output.contains("target may not be installed") {
                FirmwareError::new(
                    format!("the firmware cannot be built: the target {TARGET} is not installed"),
                    "install it: rustup target add thumbv7em-none-eabihf",
                )
            } else {
                FirmwareError::new(
                    format!("the firmware cannot be built:\n{output}"),
                    "`tests/firmware/run` builds it, too, and says what is missing",
                )
            });
        }
        Self::open(&target.join(TARGET).join("release/controller"))
    }

    /// Returns its path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns its bytes.
    pub fn elf(&self) -> &[u8] {
        &self.elf
    }
}

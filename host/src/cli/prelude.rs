//! What nearly every command needs.

pub(super) use crate::bake::BakedScene;
pub(super) use crate::cave::Cave;
pub(super) use crate::cli::numbers::{number, whole, within};
pub(super) use crate::cli::output::failure::{Failure, OrFail as _, misuse};
pub(super) use crate::cli::output::picture_files::{hexadecimal, is_png, make_writable, metadata};
pub(super) use crate::cli::output::{counted, print, say, warn};
pub(super) use crate::files::Fault;
pub(super) use crate::with_scene;
pub(super) use clap::{Args, ValueEnum};
pub(super) use miette::Diagnostic;
pub(super) use schemars::JsonSchema;
pub(super) use serde::Serialize;
pub(super) use std::fmt;
pub(super) use std::path::{Path, PathBuf};
pub(super) use std::time::{Duration, Instant};
pub(super) use thiserror::Error;

//! In place of graphics cards, for systems other than Linux.

use super::display::{Display, Heard};
use super::pane::NewPane;
use crate::outputs::Output;
use crate::show::window::WindowError;
use std::sync::Arc;
use std::sync::mpsc::Sender;

fn refused() -> WindowError {
    let message = "only Linux shows pictures without a desktop".to_owned();
    WindowError::refused(message, "take --backend x11")
}

pub(super) fn assign<'o>(_: impl Iterator<Item = &'o mut Output>) -> Result<(), WindowError> {
    Err(refused())
}

pub(super) fn open(
    _: usize,
    _: &str,
    _: Vec<NewPane>,
    _: Sender<Heard>,
) -> Result<Arc<dyn Display>, WindowError> {
    Err(refused())
}

//! What becomes of frames.

use super::files::Files;
use super::log::Log;
use super::shortfall::Shortfall;
use super::watch::Watch;
use super::watched::{Command, Watched};
use super::{Arguments, FillName, View};
use crate::cli::output::failure::Failure;
use crate::cli::output::warn;
use crate::cli::play::{Audience, Change, Newest, Prepared};
use crate::cli::tracker::Interrupt;
use crate::live::{FrameRecord, Share};
use crate::picture::Picture;
use crate::render::Observer;
use crate::show::dashboard::About;
use glam::Vec3;
use shisen_core::gaze::HeadPose;
use std::time::Instant;

/// Where they go.
pub(super) enum Output {
    /// Nowhere.
    None,
    /// To files.
    Files(Files),
    /// To a window.
    Window(Box<Watch>),
}

impl Output {
    /// What was asked for.
    ///
    /// # Errors
    /// A folder that cannot be written to; a window that there is not.
    pub(super) fn open(
        arguments: &Arguments,
        prepared: &Prepared,
        share: Share,
    ) -> Result<Self, Failure> {
        let Arguments {
            out, stereo, view, ..
        } = arguments;
        Ok(match view {
            View::None => Self::None,
            View::Png => Self::Files(Files::new(out, *stereo, &prepared.cave, share)?),
            View::Window => {
                let watch = Watch::open(&prepared.cave, *stereo, out)?;
                Self::Window(Box::new(watch))
            }
        })
    }
}

/// Sends frames where they go, until there are enough.
pub(super) struct Frames<'s> {
    arguments: &'s Arguments,
    interrupt: &'s Interrupt,
    /// Some seconds after the first frame.
    end: Option<Instant>,
    log: Option<Log>,
    output: Output,
    fill: FillName,
    /// What is shown, where it goes on to files or into the next frame.
    pictures: Vec<Picture>,
    shown: u64,
    change: Option<Change>,
    failure: Option<Failure>,
    shortfall: Shortfall,
}

impl<'s> Frames<'s> {
    pub(super) fn new(
        arguments: &'s Arguments,
        interrupt: &'s Interrupt,
        log: Option<Log>,
        output: Output,
    ) -> Self {
        Self {
            arguments,
            interrupt,
            end: None,
            log,
            output,
            fill: arguments.fill,
            pictures: Vec::new(),
            shown: 0,
            change: None,
            failure: None,
            shortfall: Shortfall::default(),
        }
    }

    /// Before the first frame of a scene.
    pub(super) fn begin(&mut self, prepared: &Prepared) {
        // Another scene's pictures are nothing to fill from.
        self.pictures.clear();
        if let Output::Window(watch) = &mut self.output {
            watch.begin(About {
                scene: prepared.scene.clone(),
                lod: prepared.arguments.lod.name().to_owned(),
                fill: self.fill.name().to_owned(),
                hz: prepared.hz,
                budget: prepared.budget.to_string(),
            });
        }
    }

    /// What shows where the gaze skips rays, by now.
    pub(super) const fn fill(&self) -> FillName {
        self.fill
    }

    /// What was asked for last, if it is not shown yet.
    pub(super) fn change(&mut self) -> Option<Change> {
        self.change.take()
    }

    /// What became of the window, if there was one, and of the files: of one that could not
    /// be written, why.
    pub(super) fn finish(self) -> (Option<Watched>, Result<(), Failure>) {
        let files = match (self.failure, self.log) {
            (Some(failure), _) => Err(failure),
            (None, Some(log)) => log.finish(),
            (None, None) => Ok(()),
        };
        let window = match self.output {
            Output::Window(watch) => Some(watch.finish()),
            Output::None | Output::Files(_) => None,
        };
        (window, files)
    }

    fn show(
        &mut self,
        newest: &dyn Newest,
        head: HeadPose,
        eyes: &[Observer],
    ) -> Result<(), Failure> {
        let filled = self.fill == FillName::Previous;
        match &mut self.output {
            Output::None => {}
            Output::Files(files) => {
                newest.pictures(&mut self.pictures, filled)?;
                files.write(self.shown, &self.pictures, eyes)?;
            }
            Output::Window(watch) => {
                let wanted = watch.is_wanted();
                // What is not looked at is not copied, but where it goes on into the
                // next frame.
                if filled && watch.is_open() {
                    newest.pictures(&mut self.pictures, true)?;
                }
                if let (true, Some(frame)) = (wanted, watch.frame()) {
                    if filled {
                        frame.pictures.clone_from(&self.pictures);
                    } else {
                        newest.pictures(&mut frame.pictures, false)?;
                    }
                    newest.tiles(&mut frame.tiles);
                    frame.head = head;
                    frame.eyes.clear();
                    frame.eyes.extend_from_slice(eyes);
                }
            }
        }
        Ok(())
    }

    /// Does what keys of the window ask for; whether frames go on.
    fn obey(&mut self) -> bool {
        let Output::Window(watch) = &mut self.output else {
            return true;
        };
        while let Some(command) = watch.command() {
            match command {
                Command::Change(change) => {
                    self.change = Some(change);
                    return false;
                }
                Command::Fill => {
                    let before = self.arguments.fills(self.fill);
                    self.fill = self.fill.next();
                    self.pictures.clear();
                    watch.set_fill(self.fill.name());
                    let capture = self.arguments.fills(self.fill);
                    if capture != before {
                        self.change = Some(Change::Capture(capture));
                        return false;
                    }
                }
                Command::End => return false,
            }
        }
        let unlimited = self.arguments.frames.is_none() && self.arguments.seconds.is_none();
        !(watch.was_closed() && unlimited)
    }
}

impl Audience for Frames<'_> {
    fn gaze(&mut self) -> Option<Vec3> {
        match &self.output {
            Output::Window(watch) => watch.gaze(),
            Output::None | Output::Files(_) => None,
        }
    }

    fn is_over(&mut self) -> bool {
        self.interrupt.came()
    }

    fn see(&mut self, newest: &dyn Newest, head: HeadPose, eyes: &[Observer]) {
        if let Err(failure) = self.show(newest, head, eyes) {
            self.failure.get_or_insert(failure);
        }
        self.shown += 1;
    }

    fn hear(&mut self, record: &FrameRecord) -> bool {
        if let Some(log) = &mut self.log
            && let Err(failure) = log.write(record)
        {
            self.failure.get_or_insert(failure);
        }
        if let Output::Window(watch) = &mut self.output {
            watch.hear(record);
        }
        if let Some(told) = self.shortfall.hear(record) {
            warn(&told);
        }
        let now = Instant::now();
        let end = self
            .arguments
            .seconds
            .map(|span| *self.end.get_or_insert(now + span));
        let over = end.is_some_and(|end| now >= end)
            || self.arguments.frames == Some(self.shown)
            || self.failure.is_some()
            || self.interrupt.came();
        // Keys that come too late are not obeyed.
        !over && self.obey()
    }
}

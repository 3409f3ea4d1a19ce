//! Sends frames to files, to a window or nowhere.

use super::files::{Files, Log};
use super::recorder::Recorder;
use super::shortfall::Shortfall;
use super::watch::{Command, Watch, Watched};
use super::{Arguments, View};
use crate::cli::arguments::SceneName;
use crate::cli::arguments::filling::Fill;
use crate::cli::output::Warner;
use crate::cli::play::{Change, Prepared};
use crate::cli::prelude::*;
use crate::cli::tracker::Interrupt;
use crate::live::{Display, Engine, FrameRecord, Order, Refresh, Share};
use crate::outputs::Outputs;
use crate::picture::Picture;
use crate::render::Observer;
use crate::show::dashboard::About;
use crate::tracker::Steering;
use glam::Vec3;

enum Output {
    None,
    Files(Files),
    Window(Box<Watch>),
}

/// Sends frames to their output, until there are enough.
pub(super) struct Frames<'s> {
    arguments: &'s Arguments,
    interrupt: &'s Interrupt,
    /// When to end, by `--seconds`.
    end: Option<Instant>,
    log: Option<Log>,
    recorder: Option<Recorder>,
    output: Output,
    pub(super) outputs: Option<Outputs>,
    pub(super) fill: Fill,
    /// The newest frame, for files or for the next frame.
    pictures: Vec<Picture>,
    shown: u64,
    /// What a key asked for.
    pub(super) change: Option<Change>,
    failure: Option<Failure>,
    shortfall: Shortfall,
    warner: Warner,
}

impl<'s> Frames<'s> {
    /// Opens the output, a folder or a window.
    pub(super) fn open(
        arguments: &'s Arguments,
        interrupt: &'s Interrupt,
        (log, recorder): (Option<Log>, Option<Recorder>),
        prepared: &Prepared,
        share: Share,
        outputs: Option<Outputs>,
    ) -> Result<Self, Failure> {
        let (out, stereo, cave) = (&arguments.out, arguments.stereo, &prepared.cave);
        let output = match arguments.view() {
            View::None => {
                let lacks_display = !arguments.cluster && !super::watch::is_possible();
                let is_file = matches!(arguments.live.scene, SceneName::File(_));
                if arguments.view.is_none() && is_file && lacks_display {
                    say("no display: frames are only measured; --view png writes pictures");
                }
                Output::None
            }
            View::Png => {
                make_writable(out)?;
                Output::Files(Files {
                    folder: out.clone(),
                    stereo,
                    cave: cave.clone(),
                    share,
                })
            }
            View::Window => match Watch::open(cave, stereo, out) {
                Ok(watch) => Output::Window(Box::new(watch)),
                Err(failure) if arguments.view.is_some() => return Err(failure),
                Err(failure) => {
                    let _ = failure.print();
                    warn("frames are only measured, as with --view none");
                    Output::None
                }
            },
        };
        Ok(Self {
            arguments,
            interrupt,
            end: None,
            log,
            recorder,
            output,
            outputs,
            fill: arguments.fill,
            pictures: Vec::new(),
            shown: 0,
            change: None,
            failure: None,
            shortfall: Shortfall::default(),
            warner: Warner::start(),
        })
    }

    /// Takes note of what a key changed.
    pub(super) fn note(&mut self, change: Change) {
        if let Some(recorder) = &mut self.recorder {
            recorder.note(change);
        }
    }

    pub(super) fn begin(&mut self, prepared: &Prepared) {
        // Pictures of another scene fill nothing.
        self.pictures.clear();
        self.shortfall = Shortfall::of(prepared.arguments.lod.choice());
        if let Some(recorder) = &mut self.recorder
            && let Err(failure) = recorder.begin(prepared, self.fill)
        {
            self.failure.get_or_insert(failure);
        }
        if let Output::Window(watch) = &mut self.output {
            watch.begin(About {
                scene: prepared.shown.scene.clone(),
                lod: prepared.arguments.lod.name().to_owned(),
                fill: self.fill.name().to_owned(),
                hz: prepared.hz,
                budget: prepared.budget.to_string(),
            });
        }
    }

    /// Returns the mean part of the visual field that frames show, and advice if that is little.
    pub(super) fn shown_of_field(&self) -> (Option<f64>, Option<String>) {
        if let Some(warning) = self.shortfall.end() {
            self.warner.warn(warning);
        }
        (self.shortfall.shown(), self.shortfall.advice())
    }

    /// Ends the window, and returns its report and the first error of a file.
    pub(super) fn finish(self) -> (Option<Watched>, Result<(), Failure>) {
        let log = self.log.map_or(Ok(()), Log::finish);
        let record = self.recorder.map_or(Ok(()), Recorder::finish);
        let files = self.failure.map_or(Ok(()), Err).and(log).and(record);
        let window = match self.output {
            Output::Window(watch) => Some(watch.finish()),
            Output::None | Output::Files(_) => None,
        };
        (window, files)
    }

    fn show(
        &mut self,
        newest: &dyn Engine,
        order: &Order,
        eyes: &[Observer],
    ) -> Result<(), Failure> {
        let filled = self.fill == Fill::Previous;
        // Frames that nobody looks at are copied only for the next frame.
        let are_needed = match &self.output {
            Output::None => false,
            Output::Files(_) => true,
            Output::Window(watch) => filled && watch.is_open(),
        };
        if self.outputs.is_none() && (are_needed || filled && self.recorder.is_some()) {
            newest.pictures(&mut self.pictures, filled)?;
        }
        match &mut self.output {
            Output::None => {}
            Output::Files(files) => files.write(self.shown, &self.pictures, eyes)?,
            Output::Window(watch) => {
                if let Some(frame) = watch.wanted() {
                    if filled {
                        frame.pictures.clone_from(&self.pictures);
                    } else {
                        newest.pictures(&mut frame.pictures, false)?;
                    }
                    newest.tiles(&mut frame.tiles);
                    frame.head = order.look.head;
                    frame.eyes.clear();
                    frame.eyes.extend_from_slice(eyes);
                }
            }
        }
        Ok(())
    }

    /// Adds a frame to the record.
    fn record(
        &mut self,
        newest: &dyn Engine,
        order: &Order,
        eyes: &[Observer],
        when: Instant,
    ) -> Result<(), Failure> {
        let Some(recorder) = &mut self.recorder else {
            return Ok(());
        };
        let filled = (self.fill == Fill::Previous).then_some(self.pictures.as_slice());
        recorder.add(newest, order, (eyes, filled), when)
    }

    /// Does what keys ask for; returns whether frames go on.
    fn obey(&mut self) -> bool {
        let Output::Window(watch) = &mut self.output else {
            return true;
        };
        while let Ok(command) = watch.commands.try_recv() {
            match command {
                Command::Change(change) => {
                    self.change = Some(change);
                    return false;
                }
                Command::Fill => {
                    let before = self.arguments.capture_for(self.fill);
                    self.fill = match self.fill {
                        Fill::Background => Fill::Previous,
                        // A record has no captures.
                        Fill::Previous if self.recorder.is_some() => Fill::Background,
                        Fill::Previous => Fill::Capture,
                        Fill::Capture => Fill::Background,
                    };
                    self.pictures.clear();
                    watch.set_fill(self.fill.name());
                    if let Some(recorder) = &mut self.recorder
                        && let Err(failure) = recorder.begin_again(self.fill)
                    {
                        self.failure.get_or_insert(failure);
                    }
                    let capture = self.arguments.capture_for(self.fill);
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

impl Display for Frames<'_> {
    fn gaze(&mut self) -> Option<Vec3> {
        match &self.output {
            Output::Window(watch) => watch.gaze(),
            Output::None | Output::Files(_) => None,
        }
    }

    fn steering(&mut self) -> Steering {
        match &self.output {
            Output::Window(watch) => watch.steering(),
            Output::None | Output::Files(_) => Steering::default(),
        }
    }

    fn is_over(&mut self) -> bool {
        self.interrupt.came()
    }

    fn prepare(&mut self, newest: &dyn Engine) {
        if let Some(outputs) = &mut self.outputs {
            let filled = self.fill == Fill::Previous;
            match newest.pictures(&mut self.pictures, filled) {
                Ok(()) => outputs.prepare(&self.pictures),
                Err(error) => {
                    self.failure.get_or_insert(error.into());
                }
            }
        }
    }

    fn waits(&self) -> bool {
        self.outputs.as_ref().is_some_and(Outputs::is_open)
    }

    fn present(
        &mut self,
        newest: &dyn Engine,
        order: &Order,
        eyes: &[Observer],
        at: Instant,
    ) -> Option<Refresh> {
        let shown = self.outputs.as_mut().and_then(|outputs| {
            let shown = outputs.present(at);
            outputs.said().for_each(|text| self.warner.warn(text));
            shown
        });
        let now = Instant::now();
        let when = shown.map_or(now, |refresh| refresh.shown);
        let kept = self.show(newest, order, eyes);
        if let Err(failure) = kept.and_then(|()| self.record(newest, order, eyes, when)) {
            self.failure.get_or_insert(failure);
        }
        self.shown += 1;
        shown
    }

    fn after(&mut self, record: &FrameRecord) -> bool {
        if let Some(log) = &mut self.log
            && let Err(failure) = log.write(record)
        {
            self.failure.get_or_insert(failure);
        }
        if let Output::Window(watch) = &mut self.output {
            watch.hear(record);
        }
        if let Some(warning) = self.shortfall.hear(record) {
            self.warner.warn(warning);
        }
        let now = Instant::now();
        let seconds = self.arguments.seconds;
        let end = seconds.map(|span| *self.end.get_or_insert(now + span));
        let over = end.is_some_and(|end| now >= end)
            || self.arguments.frames == Some(self.shown)
            || self.failure.is_some()
            || self.interrupt.came();
        // Keys after the last frame have no effect.
        !over && self.obey()
    }
}

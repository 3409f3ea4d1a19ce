//! The record of `--record`.

use super::Arguments;
use crate::cli::arguments::filling::Fill;
use crate::cli::arguments::room::RoomArguments;
use crate::cli::play::{Change, Prepared};
use crate::cli::prelude::*;
use crate::live::{Decision, Engine, Look, Order, Quality, RoomPlace};
use crate::picture::Picture;
use crate::record::{RecordedFrame, RecordedPicture, Setup, Writer, of_pictures, of_tiles};
use crate::render::Observer;
use crate::tracker::RawBytes;

/// Writes what decides each frame, and hashes of what it was.
pub(super) struct Recorder {
    writer: Writer,
    room: RoomArguments,
    setup: Setup,
    raw: Vec<RawBytes>,
    /// The newest look from which a screen was seen.
    seen: Option<Look>,
    /// When the first frame was shown.
    begun: Option<Instant>,
    frame: RecordedFrame,
    tiles: Vec<u64>,
}

impl Recorder {
    /// Creates the file, if one is asked for.
    pub(super) fn create(
        arguments: &Arguments,
        raw: Vec<RawBytes>,
    ) -> Result<Option<Self>, Failure> {
        let Some(path) = &arguments.record else {
            return Ok(None);
        };
        let words = std::env::args_os().skip(1);
        let words = words.map(|word| word.to_string_lossy().into_owned());
        let folder = std::env::current_dir().unwrap_or_default();
        let room = &arguments.live.room;
        let walls = room.walls_file().map(std::fs::read_to_string).transpose();
        let head = room.head();
        Ok(Some(Self {
            writer: Writer::create(path)?,
            room: room.clone(),
            setup: Setup {
                program: env!("CARGO_PKG_VERSION").to_owned(),
                arguments: words.collect(),
                folder: folder.display().to_string(),
                changes: Vec::new(),
                fill: String::new(),
                scene: String::new(),
                scene_hash: String::new(),
                walls: walls.or_fail()?,
                tile: 1,
                pictures: Vec::new(),
                rungs: Quality::LADDER.to_vec(),
            },
            raw,
            seen: None,
            begun: None,
            frame: RecordedFrame {
                number: 0,
                shown_us: 0,
                time: 0.0,
                place: RoomPlace::START,
                look: Look {
                    head,
                    position: head.position,
                    forward: glam::Vec3::NEG_Z,
                    up: glam::Vec3::Y,
                    widen: 0.0,
                },
                decision: Decision::FULL,
                cuts: Vec::new(),
                walls: Vec::new(),
            },
            tiles: Vec::new(),
        }))
    }

    /// Takes note of what a key changed before the next session.
    pub(super) fn note(&mut self, change: Change) {
        match change {
            Change::Scene(scene) => self.setup.changes.push(format!("scene {}", scene.name())),
            Change::Detail => self.setup.changes.push("detail".to_owned()),
            Change::Capture(_) => {}
        }
    }

    /// Begins a session.
    pub(super) fn begin(&mut self, prepared: &Prepared, fill: Fill) -> Result<(), Failure> {
        let eyes: Vec<_> = self.room.eyes(self.room.head()).collect();
        let pictured = prepared.cave.pictured();
        let pictures = pictured.flat_map(|pictured| {
            let picture = |eye: &(crate::cave::Eye, glam::DVec3)| RecordedPicture {
                name: pictured.name().to_owned(),
                eye: eye.0.name().to_owned(),
                size: pictured.size(),
            };
            eyes.iter().map(picture).collect::<Vec<_>>()
        });
        self.setup.pictures = pictures.collect();
        self.setup.tile = prepared.options.tile;
        self.setup.scene.clone_from(&prepared.shown.scene);
        self.setup.scene_hash = hexadecimal(prepared.scene_hash());
        self.seen = None;
        self.begin_again(fill)
    }

    /// Begins a session of the same scene with another fill.
    pub(super) fn begin_again(&mut self, fill: Fill) -> Result<(), Failure> {
        fill.name().clone_into(&mut self.setup.fill);
        Ok(self.writer.session(&self.setup)?)
    }

    /// Adds a frame that was shown; `filled` are its pictures where they are more than its tiles.
    pub(super) fn add(
        &mut self,
        engine: &dyn Engine,
        order: &Order,
        (eyes, filled): (&[Observer], Option<&[Picture]>),
        shown: Instant,
    ) -> Result<(), Failure> {
        for (number, raw) in (0..).zip(&self.raw) {
            let bytes = raw.take();
            if !bytes.is_empty() {
                self.writer.raw(number, &bytes)?;
            }
        }
        // Eyes that see no screen stay where they were.
        let head = order.look.head;
        let has_moved = self.room.eyes(head).next().map(|(_, place)| place)
            == eyes.first().map(|eye| eye.place);
        let start = Look {
            head: self.room.head(),
            ..order.look
        };
        if has_moved || self.seen.is_none() {
            self.seen = Some(if has_moved { order.look } else { start });
        }
        let begun = *self.begun.get_or_insert(shown);
        let frame = &mut self.frame;
        frame.shown_us = shown.saturating_duration_since(begun).as_micros() as u64;
        frame.time = order.time;
        frame.place = order.place;
        frame.look = self.seen.unwrap_or(order.look);
        frame.decision = order.decision;
        engine.cuts(&mut frame.cuts);
        if let Some(pictures) = filled {
            of_pictures(&self.setup, pictures, &mut frame.walls);
        } else {
            engine.tile_hashes(&mut self.tiles);
            of_tiles(&self.setup, &self.tiles, &mut frame.walls);
        }
        self.writer.frame(frame)?;
        frame.number += 1;
        Ok(())
    }

    pub(super) fn finish(self) -> Result<(), Failure> {
        Ok(self.writer.finish()?)
    }
}

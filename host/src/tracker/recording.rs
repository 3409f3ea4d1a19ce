//! Recordings: a table for people, or frames of our own link.
//!
//! A table (`.csv`) has a line a sample; a cell is empty where the device said
//! nothing. Any other file holds [`link`] frames, messages among them, each
//! sample behind a text `arrival N`, N being its time of arrival in
//! microseconds (`arrival N lost M` where M records of the device were missing until
//! then): a recording is what a bridge board could have sent, and what
//! one did send can be replayed, by the device's own times.

mod table;

use crate::files::explain;
use miette::Diagnostic;
use shisen_tracker::decoder::{Counts, Decoder, Event, Message, Text};
use shisen_tracker::link;
use shisen_tracker::sample::Sample;
use shisen_tracker::time::Micros;
use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Between samples of a recording without any time.
const UNTIMED_STEP: Micros = Micros(10_000);

/// How a recording is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RecordingFormat {
    /// A table.
    Csv,
    /// Frames of our link.
    Link,
}

impl RecordingFormat {
    /// By the file's extension: `.csv`, in any case, is a table.
    pub fn of(path: &Path) -> Self {
        let extension = path.extension();
        if extension.is_some_and(|found| found.eq_ignore_ascii_case("csv")) {
            Self::Csv
        } else {
            Self::Link
        }
    }
}

/// A recording that cannot be read or written.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum RecordingError {
    /// The system does not let it be read.
    #[error("{}: {reason}", path.display())]
    #[diagnostic(help(
        "give the path of a recording that you may read; `shisen tracker record` writes one"
    ))]
    Read {
        /// Which.
        path: PathBuf,
        /// What the system said.
        reason: io::Error,
    },
    /// The system does not let it be written.
    #[error("{}: cannot write: {}", path.display(), explain(reason))]
    #[diagnostic(help("give the path of a file that you may write"))]
    Write {
        /// Which.
        path: PathBuf,
        /// What the system said.
        reason: io::Error,
    },
    /// No sample is in it.
    #[error("{} holds no sample", path.display())]
    #[diagnostic(help(
        "give a file that `shisen tracker record` wrote; a table needs the extension .csv"
    ))]
    Empty {
        /// Which.
        path: PathBuf,
    },
    /// The table has other columns.
    #[error("{}: line 1 is not the header of a recording", path.display())]
    #[diagnostic(help("give a table that `shisen tracker record` wrote; it has these columns: {}", table::header().join(",")))]
    Header {
        /// Which.
        path: PathBuf,
    },
    /// A cell cannot be used.
    #[error("{}: line {line}: {what}", path.display())]
    #[diagnostic(help(
        "each line has a cell for each column, empty where there is nothing; numbers are finite, directions and quaternions have length 1"
    ))]
    Line {
        /// Which.
        path: PathBuf,
        /// From 1.
        line: u64,
        /// What is wrong.
        what: String,
    },
}

/// What was recorded.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// Samples, in the order of their arrival, messages, and what was damaged.
    pub events: Vec<Event>,
    /// What had become of the file when each of them came.
    pub counts: Vec<Counts>,
}

impl Recording {
    /// Reads a file.
    ///
    /// # Errors
    /// A file that cannot be read, holds no sample, or a table with a cell
    /// that cannot be used. Damaged frames are [`Event::Dropped`].
    pub fn read(path: &Path) -> Result<Self, RecordingError> {
        let bytes = std::fs::read(path).map_err(|reason| RecordingError::Read {
            path: path.into(),
            reason,
        })?;
        let recording = match RecordingFormat::of(path) {
            RecordingFormat::Csv => table::read(path, &bytes)?,
            RecordingFormat::Link => from_link(&bytes),
        };
        if recording.samples().next().is_none() {
            return Err(RecordingError::Empty { path: path.into() });
        }
        Ok(recording)
    }

    /// When the first sample came.
    pub fn begin(&self) -> Micros {
        self.samples()
            .next()
            .map_or(Micros(0), |first| first.arrival)
    }

    /// The samples.
    pub fn samples(&self) -> impl Iterator<Item = &Sample> {
        self.events.iter().filter_map(|event| match event {
            Event::Sample(sample) => Some(sample),
            _ => None,
        })
    }
}

fn unwritten(path: &Path) -> impl FnOnce(io::Error) -> RecordingError {
    let path = path.to_owned();
    move |reason| RecordingError::Write { path, reason }
}

/// Writes a recording, event after event. What was in its file stays there until
/// the first comes.
#[derive(Debug)]
pub struct Recorder {
    path: PathBuf,
    to: To,
}

#[derive(Debug)]
enum To {
    /// Nothing has come; whether the file was there before.
    Nothing(File, bool),
    Csv(Box<csv::Writer<File>>),
    Link(BufWriter<File>, link::Encoder),
}

impl To {
    /// Empties the file, and begins to write into it.
    fn begin(file: File, format: RecordingFormat) -> io::Result<Self> {
        file.set_len(0)?;
        Ok(match format {
            RecordingFormat::Csv => {
                let mut table = csv::Writer::from_writer(file);
                table.write_record(table::header())?;
                Self::Csv(Box::new(table))
            }
            RecordingFormat::Link => Self::Link(BufWriter::new(file), link::Encoder::new()),
        })
    }
}

impl Recorder {
    /// Opens the file, or makes it.
    ///
    /// # Errors
    /// Those of the system.
    pub fn create(path: &Path) -> Result<Self, RecordingError> {
        let existed = path.exists();
        let mut options = File::options();
        let file = options.write(true).create(true).truncate(false).open(path);
        let to = To::Nothing(file.map_err(unwritten(path))?, existed);
        let path = path.to_owned();
        Ok(Self { path, to })
    }

    /// Writes an event; a table takes samples alone. `lost` is how many of the
    /// device's records are missing so far, which a table does not say.
    ///
    /// # Errors
    /// Those of the system.
    pub fn push(&mut self, event: &Event, lost: u64) -> Result<(), RecordingError> {
        let format = RecordingFormat::of(&self.path);
        let is_kept = match event {
            Event::Sample(_) => true,
            Event::Message(_) => format == RecordingFormat::Link,
            _ => false,
        };
        if !is_kept {
            return Ok(());
        }
        if let To::Nothing(file, _) = &self.to {
            let begun = file.try_clone().and_then(|file| To::begin(file, format));
            self.to = begun.map_err(unwritten(&self.path))?;
        }
        let written = match (&mut self.to, event) {
            (To::Csv(table), Event::Sample(sample)) => {
                table.write_record(table::cells(sample)).map_err(Into::into)
            }
            (To::Link(file, encoder), Event::Sample(sample)) => {
                let mut text = format!("{ARRIVAL}{}", sample.arrival.0);
                if lost > 0 {
                    let _ = write!(text, "{LOST}{lost}");
                }
                let text = Message::Text(Text::new(text.as_bytes()));
                let frames = [encoder.message(&text), encoder.sample(sample)];
                frames.iter().try_for_each(|frame| file.write_all(frame))
            }
            (To::Link(file, encoder), Event::Message(message)) => {
                file.write_all(&encoder.message(message))
            }
            _ => Ok(()),
        };
        written.map_err(unwritten(&self.path))
    }

    /// Writes all that is still in memory. A file that was not there before, and that
    /// nothing came for, is not there after.
    ///
    /// # Errors
    /// Those of the system.
    pub fn finish(mut self) -> Result<(), RecordingError> {
        let flushed = match &mut self.to {
            To::Nothing(_, true) => Ok(()),
            To::Nothing(_, false) => std::fs::remove_file(&self.path),
            To::Csv(table) => table.flush(),
            To::Link(file, _) => file.flush(),
        };
        flushed.map_err(unwritten(&self.path))
    }
}

const ARRIVAL: &str = "arrival ";
const LOST: &str = " lost ";

fn from_link(bytes: &[u8]) -> Recording {
    let mut decoder = link::Link::new();
    let mut times = Times::default();
    let (mut events, mut counts) = (Vec::new(), Vec::new());
    // Byte after byte, to know the counts at each event.
    let (mut came, mut lost) = (Vec::new(), 0);
    for byte in bytes {
        decoder.feed(&[*byte], Micros(0), &mut |event| came.push(event));
        let missing = decoder.counts().lost - lost;
        if missing > 0 {
            times.lose(missing);
            lost += missing;
        }
        events.extend(came.drain(..).filter_map(|event| times.place(&event)));
        if counts.len() < events.len() {
            counts.push(times.without_own(*decoder.counts()));
        }
    }
    // The last frame may have been cut off.
    decoder.reset();
    if let Some(last) = counts.last_mut() {
        *last = times.without_own(*decoder.counts());
    }
    Recording { events, counts }
}

/// When the samples of a file of frames arrived.
#[derive(Default)]
struct Times {
    /// Of the next sample, as the text before it says.
    next: Option<Micros>,
    /// By the device's clock.
    first: Option<u64>,
    last: Option<Micros>,
    /// Such texts, which are no device's messages.
    own: u64,
    /// Of the frames that are missing in the file, so many were such texts.
    own_lost: u64,
    /// Records of the device that were missing when it was recorded.
    lost: u64,
}

impl Times {
    /// Frames are missing before the next. In a recording of ours every second one is
    /// the text that says when the next sample came: the first of them, unless it
    /// was such a text that came last.
    fn lose(&mut self, frames: u64) {
        if self.own > 0 {
            self.own_lost += match self.next {
                Some(_) => frames / 2,
                None => frames.div_ceil(2),
            };
        }
        self.next = None;
    }

    /// The event at its time; `None` of what only says a time.
    fn place(&mut self, event: &Event) -> Option<Event> {
        match *event {
            Event::Message(Message::Text(text)) if text.as_str().starts_with(ARRIVAL) => {
                let said = &text.as_str()[ARRIVAL.len()..];
                let (time, lost) = said.split_once(LOST).unwrap_or((said, "0"));
                self.next = time.parse().ok().map(Micros);
                self.lost = lost.parse().map_or(self.lost, |lost| self.lost.max(lost));
                self.own += 1;
                None
            }
            Event::Sample(mut sample) => {
                let device = sample.device_time.map(|time| time.microseconds);
                let by_device = device.map(|time| {
                    let first = *self.first.get_or_insert(time);
                    Micros(time.saturating_sub(first))
                });
                let untimed = self.last.map_or(Micros(0), |last| last.after(UNTIMED_STEP));
                let time = self.next.take().or(by_device).unwrap_or(untimed);
                // A recording does not go back.
                sample.arrival = self.last.map_or(time, |last| time.max(last));
                self.last = Some(sample.arrival);
                Some(Event::Sample(sample))
            }
            _ => Some(*event),
        }
    }

    fn without_own(&self, mut counts: Counts) -> Counts {
        counts.messages -= self.own;
        counts.lost = (counts.lost - self.own_lost).saturating_add(self.lost);
        counts
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tracker::{Feed, Notice, Spec};
    use shisen_tracker::decoder::DropReason;

    fn recorded(spec: &str, name: &str) -> (Vec<Event>, Vec<Event>) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        let mut feed = Feed::open(&spec.parse::<Spec>().unwrap()).unwrap();
        let mut recorder = Recorder::create(&path).unwrap();
        let mut events = Vec::new();
        feed.poll(Micros::from_millis(2_000), &mut |notice| {
            if let Notice::Decoded(event) = notice {
                recorder.push(&event, 0).unwrap();
                events.push(event);
            }
        });
        recorder.finish().unwrap();
        assert!(events.len() > 100, "{spec}");
        (events, Recording::read(&path).unwrap().events)
    }

    #[test]
    fn recordings_are_what_was_recorded() {
        for spec in [
            "mock",
            "mock:as=fastrak",
            "mock:as=iscan",
            "mock:as=hid",
            "mock:as=adhawk",
        ] {
            for name in ["a.csv", "a.CSV", "a.link"] {
                let (written, read) = recorded(spec, name);
                assert_eq!(written, read, "{spec} {name}");
            }
        }
    }

    /// Damage is counted as a line's would be that the frames came over.
    #[test]
    fn damage_in_a_recording_is_dropped() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.link");
        let spec = Spec::Replay(crate::tracker::ReplaySpec {
            path: path.clone(),
            head: None,
            times: crate::tracker::Times::default(),
        });
        let mut recorder = Recorder::create(&path).unwrap();
        for i in 0..200 {
            let sample = Sample::arrived(Micros(1_000 * i));
            recorder.push(&Event::Sample(sample), 0).unwrap();
        }
        recorder.finish().unwrap();
        let intact = std::fs::read(&path).unwrap();
        let counts = |bytes: &[u8]| {
            std::fs::write(&path, bytes).unwrap();
            let mut feed = Feed::open(&spec).unwrap();
            let mut events = 0;
            feed.poll(Micros(u64::MAX), &mut |_| events += 1);
            assert!(feed.is_over());
            (feed.counts(), events)
        };
        let (all, events) = counts(&intact);
        assert_eq!((all.samples, all.messages, events), (200, 0, 200));
        assert_eq!((all.lost, all.dropped_bytes), (0, 0));
        let mut damaged = intact.clone();
        let length = damaged.len();
        for at in [length / 4, length / 2, length - 3] {
            damaged[at] ^= 0x10;
        }
        // Before the end, half a frame.
        damaged.truncate(length - 2);
        let mut live = link::Link::new();
        live.feed(&damaged, Micros(0), &mut |_| {});
        live.reset();
        let (found, events) = counts(&damaged);
        assert_eq!(found.dropped, live.counts().dropped);
        assert_eq!(found.dropped_bytes, live.counts().dropped_bytes);
        // Each of the samples that are missing, and none of the texts.
        assert_eq!(found.lost + found.samples, 200 - 1, "{found:?}");
        assert_eq!(found.bytes, damaged.len() as u64);
        assert!(found.dropped.iter().sum::<u32>() >= 3, "{found:?}");
        assert!(found.samples >= 195 && events > found.samples);
    }

    /// A table whose writer was ended while it wrote.
    #[test]
    fn a_table_that_was_cut_off_is_read_up_to_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        let head = table::header().join(",");
        let line = |at| table::cells(&Sample::arrived(Micros(at))).join(",");
        let read = |text: &str| {
            std::fs::write(&path, text).unwrap();
            Recording::read(&path)
        };
        let cut = format!("{head}\n{}\n{}\n7,,,", line(5), line(6));
        let found = read(&cut).unwrap();
        assert_eq!(found.events.len(), 2);
        let counts = found.counts[1];
        assert_eq!(counts.dropped_for(DropReason::Truncated), 1);
        assert_eq!((counts.dropped_bytes, counts.samples), (4, 2));
        // A line that is whole needs no end; one that has an end was not cut off.
        let whole = format!("{head}\n{}\n{}", line(5), line(6));
        assert_eq!(read(&whole).unwrap().events.len(), 2);
        let said = read(&format!("{cut}\n")).unwrap_err().to_string();
        assert!(said.contains("line 4"), "{said}");
        let said = read(&format!("{head}\n5,,,")).unwrap_err().to_string();
        assert!(said.contains("line 2"), "{said}");
    }

    #[test]
    fn tables_that_cannot_be_used_say_where() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        let read = |text: &str| {
            std::fs::write(&path, text).unwrap();
            Recording::read(&path).unwrap_err().to_string()
        };
        assert!(read("x,y\n1,2\n").contains("line 1"));
        let head = table::header().join(",");
        assert!(read(&head).contains("holds no sample"));
        let mut cells = table::cells(&Sample::arrived(Micros(5)));
        cells[5] = "mouse".into();
        let said = read(&format!("{head}\n{}\n", cells.join(",")));
        assert!(said.contains("line 2: gaze_frame is \"mouse\""), "{said}");
        cells[5] = "head".into();
        cells[10..14].clone_from_slice(&["0", "0", "0", "2"].map(String::from));
        let said = read(&format!("{head}\n{}\n", cells.join(",")));
        assert!(
            said.contains("line 2: the sample is no direction"),
            "{said}"
        );
    }
}

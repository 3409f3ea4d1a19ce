//! Recordings: a table for people, or frames of our own link.
//!
//! A table (`.csv`) has one line a sample; a cell is empty where the device measured nothing.
//! Any other file holds [`link`] frames: messages, and samples each after a text `arrival N`,
//! N being its time of arrival in microseconds (`arrival N lost M` after M missing records of
//! the device). A bridge board could have sent such a file; frames without these texts are
//! replayed by the device's own times. Or it holds the device's bytes, which its decoder reads again.

mod table;

use super::raw::{self, RawBytes};
use crate::files::Fault;
use shisen_tracker::decoder::{Counts, Decoder, Event, Message, Text};
use shisen_tracker::link;
use shisen_tracker::sample::Sample;
use shisen_tracker::time::Micros;
use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// The time between samples of a recording without times.
const UNTIMED_STEP: Micros = Micros(10_000);

/// Returns whether a file is a table: `.csv`, in upper or lower case; others hold link frames.
fn is_table(path: &Path) -> bool {
    let extension = path.extension();
    extension.is_some_and(|found| found.eq_ignore_ascii_case("csv"))
}

/// A recording in memory.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// Samples in the order of their arrival, messages, and damage, each with the counts then.
    pub events: Vec<(Event, Counts)>,
}

impl Recording {
    /// Reads a file.
    ///
    /// # Errors
    /// A file that cannot be read or holds no sample, or a table with an unusable line.
    /// Damaged frames are [`Event::Dropped`].
    pub fn read(path: &Path) -> Result<Self, Fault> {
        let shown = path.display();
        let bytes = std::fs::read(path).map_err(|reason| {
            let help = "give the path of a recording that you may read; `shisen tracker record` \
                        writes one";
            Fault::new(format!("{shown}: {reason}"), help)
        })?;
        let recording = if raw::is_raw(&bytes) {
            Self {
                events: raw::read(path, &bytes)?,
            }
        } else if is_table(path) {
            table::read(path, &bytes)?
        } else {
            from_link(&bytes)
        };
        let has_bytes = raw::is_raw(&bytes) && !recording.events.is_empty();
        if recording.samples().next().is_none() && !has_bytes {
            return Err(Fault::new(
                format!("{shown} holds no sample"),
                "give a file that `shisen tracker record` wrote; a table needs the extension .csv",
            ));
        }
        Ok(recording)
    }

    /// Returns when the first sample came; 0 without samples.
    pub fn begin(&self) -> Micros {
        let first = self.samples().next();
        first.map_or(Micros(0), |first| first.arrival)
    }

    /// Returns the samples.
    pub fn samples(&self) -> impl Iterator<Item = &Sample> {
        self.events.iter().filter_map(|(event, _)| match event {
            Event::Sample(sample) => Some(sample),
            _ => None,
        })
    }
}

/// Writes a recording, event after event. Its file keeps its contents until the first event.
#[derive(Debug)]
pub struct Recorder {
    path: PathBuf,
    to: Output,
}

#[derive(Debug)]
enum Output {
    /// No event yet; whether the file existed before.
    Nothing(File, bool),
    Csv(Box<csv::Writer<File>>),
    Link(BufWriter<File>, link::Encoder),
    /// Bytes in place of events.
    Raw(BufWriter<File>, RawBytes),
}

impl Output {
    fn begin(file: File, is_table: bool) -> io::Result<Self> {
        file.set_len(0)?;
        if !is_table {
            return Ok(Self::Link(BufWriter::new(file), link::Encoder::new()));
        }
        let mut table = csv::Writer::from_writer(file);
        table.write_record(table::header())?;
        Ok(Self::Csv(Box::new(table)))
    }
}

impl Recorder {
    /// Opens or creates the file.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn create(path: &Path) -> Result<Self, Fault> {
        let existed = path.exists();
        let mut options = File::options();
        let file = options.write(true).create(true).truncate(false).open(path);
        let to = Output::Nothing(file.map_err(Fault::write(path))?, existed);
        let path = path.to_owned();
        Ok(Self { path, to })
    }

    /// Creates the file of the bytes of a tracker.
    ///
    /// # Errors
    /// A file that cannot be written, and a table's name.
    pub fn of_bytes(path: &Path, bytes: RawBytes) -> Result<Self, Fault> {
        if is_table(path) {
            let message = format!("{}: bytes are no table", path.display());
            return Err(Fault::new(
                message,
                "give a name without .csv, such as head.raw",
            ));
        }
        let file = File::create(path).map_err(Fault::write(path))?;
        let (path, to) = (path.to_owned(), Output::Raw(BufWriter::new(file), bytes));
        Ok(Self { path, to })
    }

    /// Writes an event; a table takes samples only. `lost` is the number of the device's
    /// records missing so far, for which a table has no column.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn push(&mut self, event: &Event, lost: u64) -> Result<(), Fault> {
        let is_table = is_table(&self.path);
        let is_kept = match event {
            Event::Sample(_) => true,
            Event::Message(_) => !is_table,
            _ => false,
        };
        if !is_kept || matches!(self.to, Output::Raw(..)) {
            return Ok(());
        }
        if let Output::Nothing(file, _) = &self.to {
            let begun = file
                .try_clone()
                .and_then(|file| Output::begin(file, is_table));
            self.to = begun.map_err(Fault::write(&self.path))?;
        }
        let written = match (&mut self.to, event) {
            (Output::Csv(table), Event::Sample(sample)) => {
                table.write_record(table::cells(sample)).map_err(Into::into)
            }
            (Output::Link(file, encoder), Event::Sample(sample)) => {
                let mut text = format!("{ARRIVAL}{}", sample.arrival.0);
                if lost > 0 {
                    let _ = write!(text, "{LOST}{lost}");
                }
                let text = Message::Text(Text::new(text.as_bytes()));
                let frames = [encoder.message(&text), encoder.sample(sample)];
                frames.iter().try_for_each(|frame| file.write_all(frame))
            }
            (Output::Link(file, encoder), Event::Message(message)) => {
                file.write_all(&encoder.message(message))
            }
            _ => Ok(()),
        };
        written.map_err(Fault::write(&self.path))
    }

    /// Writes the bytes that have come, from the first on.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn keep_bytes(&mut self) -> Result<(), Fault> {
        match &mut self.to {
            Output::Raw(file, raw) => raw.write(file).map_err(Fault::write(&self.path)),
            _ => Ok(()),
        }
    }

    /// Writes what is still in memory. Removes a new file for which no event came.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn finish(mut self) -> Result<(), Fault> {
        let flushed = match &mut self.to {
            Output::Nothing(_, true) => Ok(()),
            Output::Nothing(_, false) => std::fs::remove_file(&self.path),
            Output::Csv(table) => table.flush(),
            Output::Link(file, _) => file.flush(),
            Output::Raw(file, raw) => raw.write(file).and_then(|()| file.flush()),
        };
        flushed.map_err(Fault::write(&self.path))
    }
}

const ARRIVAL: &str = "arrival ";
const LOST: &str = " lost ";

fn from_link(bytes: &[u8]) -> Recording {
    let mut decoder = link::Link::new();
    let mut times = Times::default();
    let mut events = Vec::new();
    // Byte after byte, for the counts at each event.
    let (mut came, mut lost) = (Vec::new(), 0);
    for byte in bytes {
        decoder.feed(&[*byte], Micros(0), &mut |event| came.push(event));
        let missing = decoder.counts().lost - lost;
        if missing > 0 {
            times.lose(missing);
            lost += missing;
        }
        for event in came.drain(..) {
            let placed = times.place(&event);
            events.extend(placed.map(|event| (event, times.without_own(*decoder.counts()))));
        }
    }
    // The last frame may have been cut off.
    decoder.reset();
    if let Some((_, last)) = events.last_mut() {
        *last = times.without_own(*decoder.counts());
    }
    Recording { events }
}

/// The arrival times of the samples in a file of frames.
#[derive(Default)]
struct Times {
    /// The arrival of the next sample, as the text before it says.
    next: Option<Micros>,
    /// The first sample's time on the device's clock.
    first: Option<u64>,
    last: Option<Micros>,
    /// Texts of ours, which are no messages of the device.
    own: u64,
    /// Texts of ours among the frames missing in the file.
    own_lost: u64,
    /// Records of the device that were missing in the recording.
    lost: u64,
}

impl Times {
    /// Counts missing frames; in a recording of ours every second one is an arrival text.
    fn lose(&mut self, frames: u64) {
        if self.own > 0 {
            self.own_lost += match self.next {
                Some(_) => frames / 2,
                None => frames.div_ceil(2),
            };
        }
        self.next = None;
    }

    /// Returns the event at its time; `None` for an arrival text.
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
    use miette::Diagnostic as _;
    use shisen_tracker::decoder::DropReason;

    /// Records 2 s of a mock.
    fn record(feed: &mut Feed, mut recorder: Recorder) -> Vec<Event> {
        let mut events = Vec::new();
        feed.poll(Micros::from_millis(2_000), &mut |notice| {
            if let Notice::Decoded(event) = notice {
                recorder.push(&event, 0).unwrap();
                events.push(event);
            }
        });
        recorder.finish().unwrap();
        assert!(events.len() > 100);
        events
    }

    /// Records 2 s of a mock; returns what was written and what was read.
    fn recorded(spec: &str, path: &Path) -> (Vec<Event>, Vec<Event>) {
        let mut feed = Feed::open(&spec.parse::<Spec>().unwrap()).unwrap();
        let events = record(&mut feed, Recorder::create(path).unwrap());
        let read = Recording::read(path).unwrap().events;
        (events, read.into_iter().map(|(event, _)| event).collect())
    }

    /// Bytes that were kept give the same events again, with the same counts.
    #[test]
    fn bytes_are_decoded_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bytes");
        for name in ["mock:as=fastrak", "mock:as=flock&seed=3", "mock:as=link"] {
            let (mut feed, bytes) = Feed::open_raw(name, &name.parse().unwrap()).unwrap();
            let events = record(&mut feed, Recorder::of_bytes(&path, bytes).unwrap());
            let read = Recording::read(&path).unwrap().events;
            let (read, counts): (Vec<_>, Vec<_>) = read.into_iter().unzip();
            assert_eq!(events, read, "{name}");
            assert_eq!(*counts.last().unwrap(), feed.counts(), "{name}");
        }
        let whole = std::fs::read(&path).unwrap();
        std::fs::write(&path, &whole[..whole.len() - 5]).unwrap();
        let cut = Recording::read(&path).unwrap().events;
        assert!(matches!(cut.last(), Some((Event::Dropped(_), _))));
        std::fs::write(&path, b"shisen raw 2\nmock:as=link\n").unwrap();
        let other = Recording::read(&path).unwrap_err().to_string();
        assert!(other.contains("of another version than 1"), "{other}");
        for (name, says) in [
            ("mock", "mock:as=fastrak"),
            ("lsl:type=Gaze", "LabRecorder"),
        ] {
            let fault = Feed::open_raw(name, &name.parse().unwrap()).unwrap_err();
            assert!(fault.help().unwrap().to_string().contains(says), "{name}");
        }
    }

    #[test]
    fn recordings_are_what_was_recorded() {
        let folder = tempfile::tempdir().unwrap();
        for spec in ["mock", "mock:as=fastrak", "mock:as=iscan", "mock:as=hid"] {
            for name in ["a.csv", "b.CSV", "a.link"] {
                let (written, read) = recorded(spec, &folder.path().join(name));
                assert_eq!(written, read, "{spec} {name}");
            }
        }
    }

    /// Damage is counted as on a line that the frames came over.
    #[test]
    fn damage_in_a_recording_is_dropped() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.link");
        let mut recorder = Recorder::create(&path).unwrap();
        for i in 0..200 {
            let sample = Sample::arrived(Micros(1_000 * i));
            recorder.push(&Event::Sample(sample), 0).unwrap();
        }
        recorder.finish().unwrap();
        let mut bytes = std::fs::read(&path).unwrap();
        let counts = |bytes: &[u8]| {
            let read = from_link(bytes);
            (read.events.last().unwrap().1, read.events.len() as u64)
        };
        let (all, events) = counts(&bytes);
        assert_eq!((all.samples, all.messages, events), (200, 0, 200));
        assert_eq!((all.lost, all.dropped_bytes), (0, 0));
        let length = bytes.len();
        for at in [length / 4, length / 2, length - 3] {
            bytes[at] ^= 0x10;
        }
        // The last frame is cut off.
        bytes.truncate(length - 2);
        let mut live = link::Link::new();
        live.feed(&bytes, Micros(0), &mut |_| {});
        live.reset();
        let (found, events) = counts(&bytes);
        assert_eq!(found.dropped, live.counts().dropped);
        assert_eq!(found.dropped_bytes, live.counts().dropped_bytes);
        // Each missing sample counts, and none of the texts.
        assert_eq!(found.lost + found.samples, 200 - 1, "{found:?}");
        assert_eq!(found.bytes, bytes.len() as u64);
        assert!(found.samples >= 195 && events > found.samples);
    }

    #[test]
    fn tables_are_read_up_to_a_cut_and_faults_say_where() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        let head = table::header().join(",");
        let line = |at| table::cells(&Sample::arrived(Micros(at))).join(",");
        let read = |text: &str| {
            std::fs::write(&path, text).unwrap();
            Recording::read(&path)
        };
        let whole = format!("{head}\n{}\n{}", line(5), line(6));
        assert_eq!(read(&whole).unwrap().events.len(), 2);
        let cut = format!("{whole}\n7,,,");
        let found = read(&cut).unwrap();
        assert_eq!(found.events.len(), 2);
        let counts = found.events[1].1;
        assert_eq!(counts.dropped_for(DropReason::Truncated), 1);
        assert_eq!((counts.dropped_bytes, counts.samples), (4, 2));
        let with = |first: usize, changed: &[&str]| {
            let mut cells = table::cells(&Sample::arrived(Micros(5)));
            for (cell, text) in cells[first..].iter_mut().zip(changed) {
                *cell = (*text).to_owned();
            }
            format!("{head}\n{}\n", cells.join(","))
        };
        for (text, expected) in [
            // A line that has an end was not cut off.
            (format!("{cut}\n"), "line 4 has 4 cells, not 55"),
            (format!("{head}\n5,,,"), "line 2 has 4 cells"),
            ("x,y\n1,2\n".to_owned(), "column 1 is not arrival_us"),
            (head.replace("sensor", "censor"), "column 4 is not sensor"),
            (format!("{head},x"), "more than 55 columns"),
            (head.clone(), "holds no sample"),
            (
                with(0, &["8000x"]),
                "line 2: arrival_us is \"8000x\", but it must be a number",
            ),
            (with(3, &["300"]), "must be a whole number from 0 to 255"),
            (
                with(5, &["mouse"]),
                "line 2: gaze_frame is \"mouse\", but it must be head or",
            ),
            (with(6, &["1", "", "1"]), "line 2: head_y is empty"),
            (
                with(10, &["0", "0", "0", "2"]),
                "line 2: the sample is no direction",
            ),
        ] {
            let error = read(&text).unwrap_err().to_string();
            assert!(error.contains(expected), "{expected}: {error}");
        }
    }
}

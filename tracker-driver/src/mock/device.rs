//! The device's side of a line: what a simulated tracker makes of what the
//! host says.

use super::wire::Format;
use crate::eye::{adhawk, iscan};
use crate::link;
use heapless::Vec;

/// Most bytes of a command that are kept.
const MOST_HEARD: usize = 64;
/// Most bytes of an answer.
const MOST_ANSWER: usize = 64;

/// FASTRAK's status: station 1, binary, inches, continuous; no error, and the
/// version of a device that there is not.
const FASTRAK_STATUS: &[u8] = b"21S009   00.00 SHISEN MOCK                           \r\n";

/// The device at the other end of the line, as far as it takes commands.
///
/// It streams from the start on, until it is told to stop; what it does
/// not know, it passes over.
#[derive(Debug, Clone)]
pub struct Device {
    language: Language,
    heard: Vec<u8, MOST_HEARD>,
    link: link::Commands,
    streams: bool,
    rate: Option<u32>,
}

/// How commands are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Language {
    Link,
    Fastrak,
    Liberty,
    Flock,
    Hatire,
    Iscan,
    AdHawk,
    /// The device takes none.
    None,
}

/// What became of the commands' first bytes.
enum Heard {
    /// They are not whole yet.
    More,
    /// So many of them are dealt with.
    Took(usize),
}

impl Device {
    /// A device that streams records of this format.
    pub fn new(format: &Format) -> Self {
        let language = match format {
            Format::Link => Language::Link,
            Format::Fastrak(_) => Language::Fastrak,
            Format::Liberty(_) => Language::Liberty,
            Format::Flock(_) => Language::Flock,
            Format::Hatire(_) => Language::Hatire,
            Format::Iscan(_) => Language::Iscan,
            Format::AdHawk => Language::AdHawk,
            Format::OsvrHdk | Format::Asl(_) | Format::EyeTracker(_) => Language::None,
        };
        Self {
            language,
            heard: Vec::new(),
            link: link::Commands::new(),
            streams: true,
            rate: None,
        }
    }

    /// Whether it sends records.
    pub const fn streams(&self) -> bool {
        self.streams
    }

    /// The samples per second that the host asked for, if it did.
    pub const fn rate(&self) -> Option<u32> {
        self.rate
    }

    /// Takes what the host said, and hands over the answers.
    pub fn feed(&mut self, bytes: &[u8], answer: &mut dyn FnMut(&[u8])) {
        if self.language == Language::Link {
            let (streams, rate) = (&mut self.streams, &mut self.rate);
            return self.link.feed(bytes, &mut |command| match command {
                link::Command::Stop => *streams = false,
                link::Command::Start => *streams = true,
                link::Command::Rate { hertz } => *rate = Some(hertz.into()),
            });
        }
        for &byte in bytes {
            if self.heard.push(byte).is_err() {
                // No command is as long.
                self.heard.clear();
                continue;
            }
            while !self.heard.is_empty() {
                let Heard::Took(count) = self.step(answer) else {
                    break;
                };
                let count = count.clamp(1, self.heard.len());
                self.heard.rotate_left(count);
                self.heard.truncate(self.heard.len() - count);
            }
        }
    }

    fn step(&mut self, answer: &mut dyn FnMut(&[u8])) -> Heard {
        let Some(&first) = self.heard.first() else {
            return Heard::More;
        };
        match self.language {
            Language::Link | Language::None => Heard::Took(1),
            Language::Fastrak => self.fastrak(first, answer),
            Language::Liberty => self.liberty(first),
            Language::Flock => self.flock(first),
            Language::Hatire => self.set(first, b'S', b's'),
            Language::Iscan => self.set(first, iscan::START[0], iscan::STOP[0]),
            Language::AdHawk => self.adhawk(first, answer),
        }
    }

    fn set(&mut self, byte: u8, start: u8, stop: u8) -> Heard {
        if byte == start || byte == stop {
            self.streams = byte == start;
        }
        Heard::Took(1)
    }

    /// Up to the end of a line.
    fn line(&self) -> Heard {
        match self.heard.iter().position(|&byte| byte == b'\r') {
            Some(end) => Heard::Took(end + 1),
            None => Heard::More,
        }
    }

    fn fastrak(&mut self, first: u8, answer: &mut dyn FnMut(&[u8])) -> Heard {
        match first {
            b'S' => answer(FASTRAK_STATUS),
            // Lists of items, the line's speed, stations, and frames.
            b'O' | b'o' | b'l' | b'A' | b'G' | b'H' | b'N' | b'V' | b'Q' | b'r' | b'x' => {
                return self.line();
            }
            _ => {}
        }
        self.set(first, b'C', b'c')
    }

    fn liberty(&mut self, first: u8) -> Heard {
        if first == b'P' {
            self.streams = false;
            return Heard::Took(1);
        }
        let line = self.line();
        if matches!(line, Heard::Took(_)) && first == b'C' {
            self.streams = true;
        }
        line
    }

    fn flock(&mut self, first: u8) -> Heard {
        match first {
            // A parameter's number and its value; what is asked for one.
            b'P' if self.heard.len() < 3 => return Heard::More,
            b'P' => return Heard::Took(3),
            b'O' if self.heard.len() < 2 => return Heard::More,
            b'O' => return Heard::Took(2),
            b'G' => self.streams = false,
            _ => {}
        }
        self.set(first, b'@', b'B')
    }

    fn adhawk(&mut self, first: u8, answer: &mut dyn FnMut(&[u8])) -> Heard {
        let (&[_, low, high, ..], 0xAA) = (self.heard.as_slice(), first) else {
            return if first == 0xAA {
                Heard::More
            } else {
                Heard::Took(1)
            };
        };
        let length = usize::from(u16::from_le_bytes([low, high]));
        if length > MOST_HEARD - 3 {
            return Heard::Took(1);
        }
        let Some(payload) = self.heard.get(3..3 + length) else {
            return Heard::More;
        };
        if let &[low, high, kind, ref rest @ ..] = payload {
            let number = u16::from_le_bytes([low, high]);
            let tracking = adhawk::Request::Tracking(true).kind();
            let rate = adhawk::Request::Rate { hertz: 0.0 }.kind();
            match *rest {
                [1, on] if kind == tracking => self.streams = on != 0,
                [13, a, b, c, d] if kind == rate => {
                    let hertz = f32::from_le_bytes([a, b, c, d]);
                    self.rate = (hertz >= 1.0).then_some(hertz as u32);
                }
                _ => {}
            }
            let response: Vec<u8, MOST_ANSWER> =
                Vec::from_slice(&adhawk::encode_response(number, kind, 0)).unwrap_or_default();
            answer(&response);
        }
        Heard::Took(3 + length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::{Action, Script, Session};
    use crate::decoder::{Decoder, Event, Message};
    use crate::head::{fastrak, flock, hatire, liberty};
    use crate::sample::Sample;
    use crate::time::Micros;

    /// Plays a script against the device, to its end.
    fn play(device: &mut Device, script: Script) {
        let mut session = Session::new(script);
        let mut adhawk = adhawk::AdHawk::new();
        let mut now = Micros(0);
        for _ in 0..100 {
            let mut heard = std::vec::Vec::new();
            match session.poll(now) {
                Action::Send(bytes) => device.feed(bytes, &mut |bytes| heard.extend(bytes)),
                Action::Wait(until) if device.streams() && until > now => {
                    session.on_event(&Event::Sample(Sample::arrived(now)));
                    now = until;
                }
                Action::Wait(until) => now = until,
                Action::Done => return,
                other => panic!("{other:?}"),
            }
            adhawk.feed(&heard, now, &mut |event| session.on_event(&event));
        }
        panic!("the script does not end");
    }

    #[test]
    fn every_device_starts_and_stops_by_its_own_script() {
        for name in Format::NAMES {
            let format = Format::named(name).unwrap();
            let (start, stop) = match &format {
                Format::Link => (link::start(Some(240)), link::stop()),
                Format::Fastrak(config) => (config.start(true), fastrak::stop()),
                Format::Liberty(config) => (config.start(true), liberty::stop()),
                Format::Flock(config) => (config.start(1, 1, true), flock::stop()),
                Format::Hatire(_) => (hatire::start(true), hatire::stop()),
                Format::Iscan(_) => (iscan::start(), iscan::stop()),
                Format::AdHawk => (adhawk::start(2, 250.0), adhawk::stop()),
                _ => continue,
            };
            let mut device = Device::new(&format);
            assert!(device.streams(), "{name}");
            play(&mut device, stop);
            assert!(!device.streams(), "{name}");
            play(&mut device, start);
            assert!(device.streams(), "{name}");
            let rate = match name {
                "link" => Some(240),
                "adhawk" => Some(250),
                _ => None,
            };
            assert_eq!(device.rate(), rate, "{name}");
        }
    }

    #[test]
    fn a_fastrak_says_how_it_is() {
        let format = Format::named("fastrak").unwrap();
        let Format::Fastrak(config) = &format else {
            panic!("another device");
        };
        let mut decoder = fastrak::Fastrak::new(config.clone());
        let mut texts = 0;
        Device::new(&format).feed(b"S", &mut |answer| {
            decoder.feed(answer, Micros(0), &mut |event| {
                if let Event::Message(Message::Text(text)) = event {
                    let status = fastrak::Status::from_text(text.as_str()).unwrap();
                    assert!(status.continuous);
                    texts += 1;
                }
            });
        });
        assert_eq!(texts, 1);
    }

    #[test]
    fn noise_is_passed_over() {
        for name in Format::NAMES {
            let mut device = Device::new(&Format::named(name).unwrap());
            for byte in 0..=u8::MAX {
                device.feed(&[byte; 3], &mut |_| {});
            }
            assert!(device.heard.len() <= MOST_HEARD);
        }
    }
}

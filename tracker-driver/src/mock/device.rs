//! The device's side of a line: what a simulated tracker makes of what the
//! host says.

use super::wire::Format;
use crate::eye::{adhawk, iscan};
use crate::head::flock::{self, Mode};
use crate::head::polhemus::{Family, Format as Written, ItemList, MOST_ITEMS, Units};
use crate::link;
use heapless::Vec;

/// Most bytes of a command that are kept.
const MOST_HEARD: usize = 64;
/// Most bytes of an answer.
const MOST_ANSWER: usize = 64;

/// What follows the flags in FASTRAK's status: no error, and the version of a
/// device that there is not.
const FASTRAK_STATUS: &[u8] = b"   00.00 SHISEN MOCK                           \r\n";

/// The device at the other end of the line, as far as it takes commands.
///
/// It streams from the start on, until it is told to stop, and as it is told
/// to: [`Device::format`]. What it does not know, it passes over.
#[derive(Debug, Clone)]
pub struct Device {
    format: Format,
    heard: Vec<u8, MOST_HEARD>,
    link: link::Commands,
    streams: bool,
    rate: Option<u32>,
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
        Self {
            format: format.clone(),
            heard: Vec::new(),
            link: link::Commands::new(),
            streams: true,
            rate: None,
        }
    }

    /// How it writes its records, which commands change.
    pub const fn format(&self) -> &Format {
        &self.format
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
        if self.format == Format::Link {
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
        match self.format {
            Format::Link | Format::OsvrHdk | Format::Asl(_) | Format::EyeTracker(..) => {
                Heard::Took(1)
            }
            Format::Fastrak(_) => self.fastrak(first, answer),
            Format::Liberty(_) => self.liberty(first),
            Format::Flock(_) => self.flock(first),
            Format::Hatire(_) => self.set(first, b'S', b's'),
            Format::Iscan(_) => self.set(first, iscan::START[0], iscan::STOP[0]),
            Format::AdHawk => self.adhawk(first, answer),
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
        let Format::Fastrak(config) = &mut self.format else {
            return Heard::Took(1);
        };
        match first {
            b'S' => {
                let flags = u8::from(config.items.format() == Written::Binary)
                    | u8::from(config.units == Units::Centimetres) << 1
                    | u8::from(self.streams) << 3;
                let digit = b"0123456789ABCDEF".get(usize::from(flags)).copied();
                let mut status: Vec<u8, MOST_ANSWER> = Vec::new();
                let _ = status.extend_from_slice(b"21S00");
                let _ = status.push(digit.unwrap_or(b'0'));
                let _ = status.extend_from_slice(FASTRAK_STATUS);
                answer(&status);
            }
            b'U' => config.units = Units::Inches,
            b'u' => config.units = Units::Centimetres,
            b'F' => relist(
                &mut config.items,
                Family::Fastrak,
                Some(Written::Ascii),
                None,
            ),
            b'f' => relist(
                &mut config.items,
                Family::Fastrak,
                Some(Written::Binary),
                None,
            ),
            // Lists of items, the line's speed, stations, and frames.
            b'O' | b'o' | b'l' | b'A' | b'G' | b'H' | b'N' | b'V' | b'Q' | b'r' | b'x' => {
                let line = self.heard.split(|&byte| byte == b'\r').next();
                if let Some(numbers) = line.and_then(of_first_station)
                    && self.heard.contains(&b'\r')
                {
                    relist(&mut config.items, Family::Fastrak, None, Some(&numbers));
                }
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
        let (Heard::Took(_), Format::Liberty(config)) = (&line, &mut self.format) else {
            return line;
        };
        match self.heard.split(|&byte| byte == b'\r').next() {
            Some([b'C', ..]) => self.streams = true,
            Some(b"U0") => config.units = Units::Inches,
            Some(b"U1") => config.units = Units::Centimetres,
            Some(command) => {
                if let Some(numbers) = of_first_station(command) {
                    relist(&mut config.items, Family::Liberty, None, Some(&numbers));
                }
            }
            None => {}
        }
        line
    }

    fn flock(&mut self, first: u8) -> Heard {
        let Format::Flock(config) = &mut self.format else {
            return Heard::Took(1);
        };
        match (first, self.heard.as_slice()) {
            // A parameter's number and its value; what is asked for one.
            (b'P', &[_, flock::GROUP_MODE, on, ..]) => {
                config.group = on != 0;
                return Heard::Took(3);
            }
            (b'P', parameter) if parameter.len() < 3 => return Heard::More,
            (b'P', _) => return Heard::Took(3),
            (b'O', asked) if asked.len() < 2 => return Heard::More,
            (b'O', _) => return Heard::Took(2),
            (b'G', _) => self.streams = false,
            _ => {}
        }
        if let Some(mode) = Mode::ALL.into_iter().find(|mode| mode.command() == first) {
            config.mode = mode;
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

/// The numbers of the command `O` for station 1, up to its end.
fn of_first_station(command: &[u8]) -> Option<Vec<u8, MOST_ITEMS>> {
    let text = core::str::from_utf8(command).ok()?.strip_prefix("O1,")?;
    let mut numbers = Vec::new();
    for number in text.split(',') {
        numbers.push(number.parse().ok()?).ok()?;
    }
    Some(numbers)
}

/// Changes a list's format or its items, where that makes a list.
fn relist(items: &mut ItemList, family: Family, format: Option<Written>, numbers: Option<&[u8]>) {
    let same: Vec<u8, MOST_ITEMS> = items.numbers().collect();
    let format = format.unwrap_or(items.format());
    if let Ok(list) = ItemList::new(family, format, numbers.unwrap_or(&same)) {
        *items = list;
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

    /// Whatever it was set to before, it sends what its script asks for.
    #[test]
    fn a_device_streams_as_it_is_told() {
        let of = |format, items| ItemList::new(Family::Fastrak, format, items).unwrap();
        let mut fastrak = fastrak::Config::new(of(Written::Ascii, &[2, 4, 1]));
        fastrak.units = Units::Centimetres;
        let items = ItemList::new(Family::Liberty, Written::Binary, &[2, 7, 0]);
        let mut liberty = liberty::Config::new(items.unwrap());
        liberty.units = Units::Centimetres;
        for (name, script) in [
            ("fastrak", fastrak.start(false)),
            ("liberty", liberty.start(false)),
        ] {
            let mut device = Device::new(&Format::named(name).unwrap());
            play(&mut device, script);
            match device.format() {
                Format::Fastrak(config) => assert_eq!(config, &fastrak),
                Format::Liberty(config) => assert_eq!(config, &liberty),
                other => panic!("{other:?}"),
            }
            let Some(Format::Fastrak(usual)) = Format::named("fastrak") else {
                panic!("it is one");
            };
            if name == "fastrak" {
                play(&mut device, usual.start(false));
                assert_eq!(device.format(), &Format::Fastrak(usual));
            }
        }
        for mode in Mode::ALL {
            let config = flock::Config {
                mode,
                group: true,
                ..flock::Config::default()
            };
            let mut device = Device::new(&Format::named("flock").unwrap());
            play(&mut device, config.start(2, 1, false));
            assert_eq!(device.format(), &Format::Flock(config));
        }
        // A list that is none changes nothing.
        let mut device = Device::new(&Format::named("fastrak").unwrap());
        device.feed(b"O1,2,11\rO1,999,0\rO1\r", &mut |_| {});
        assert_eq!(Some(device.format().clone()), Format::named("fastrak"));
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
                    assert_eq!(status.format, Written::Binary);
                    assert_eq!(status.units, Units::Inches);
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

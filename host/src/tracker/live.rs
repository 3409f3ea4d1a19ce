//! A device that is plugged in, unplugged, and plugged in again.

use super::feed::Notice;
use super::protocol::Protocol;
use super::spec::{HidName, HidSpec, SerialSpec};
use miette::Diagnostic;
use shisen_tracker::command::{Action, Failure, Session, Watch};
use shisen_tracker::decoder::{Counts, Decoder, Event};
use shisen_tracker::head::osvr_hdk;
use shisen_tracker::hid::device::{Device, Found, devices};
use shisen_tracker::hid::eye_tracker::{Axes, EyeTracker, LayoutError, Mode};
use shisen_tracker::serial::Serial;
use shisen_tracker::time::Micros;
use std::io;
use std::time::Instant;
use thiserror::Error;

/// The first wait before a device is looked for again, and the longest.
const BACK_OFF: [Micros; 2] = [Micros::from_millis(20), Micros::from_millis(500)];

/// Bytes that are read at once; no report is longer.
const CHUNK: usize = 4096;

/// How long a device's samples are held back while it is set up: what it sends
/// until then may be in other units than it is asked for; a reset's time comes
/// on top. One that takes longer,
/// or takes no commands at all, is believed.
const SETTING_UP: Micros = Micros::from_millis(800);

/// A device that has said nothing for so long is told again what to send: it may
/// have been switched on only now.
const AGAIN: Micros = Micros::from_millis(5_000);

/// How long a device that is there again may refuse to be used before that is
/// said: the system takes a moment to let others than root use it.
const REFUSING: Micros = Micros::from_millis(300);

/// Why a device cannot be used.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum LiveError {
    /// The system does not let it be opened.
    #[error("{path} cannot be opened: {reason}")]
    #[diagnostic(help("{}", advice(reason)))]
    Open {
        /// Which.
        path: String,
        /// What the system said.
        reason: io::Error,
    },
    /// No such device is plugged in.
    #[error("no HID device {:04x}:{:04x} is plugged in", id.0, id.1)]
    #[diagnostic(help("plug it in; `shisen tracker list` shows what there is"))]
    NotFound {
        /// Vendor and product.
        id: (u16, u16),
    },
    /// More than one device is meant.
    #[error("{} devices are {:04x}:{:04x}: {}", paths.len(), id.0, id.1, paths.join(", "))]
    #[diagnostic(help("give one by its path, such as hid:{}", paths.first().map_or("", |p| p)))]
    Several {
        /// Vendor and product.
        id: (u16, u16),
        /// Where they are.
        paths: Vec<String>,
    },
    /// It is no tracker.
    #[error("{path}: {reason}")]
    #[diagnostic(help("`shisen tracker list` marks the devices that are trackers"))]
    Layout {
        /// Which.
        path: String,
        /// Why.
        reason: LayoutError,
    },
}

fn advice(reason: &io::Error) -> &'static str {
    match reason.kind() {
        io::ErrorKind::NotFound => {
            "plug the device in, or give another path; `shisen tracker list` shows what there is"
        }
        io::ErrorKind::PermissionDenied => {
            "a udev rule is missing: copy tracker-driver/udev/70-shisen-trackers.rules to \
             /etc/udev/rules.d, run `udevadm control --reload` and plug the device in again; \
             for a serial port, joining the group dialout does too"
        }
        io::ErrorKind::ResourceBusy => "another program uses it: end that first",
        _ => "check the path and the device",
    }
}

impl LiveError {
    /// Whether no such device is there at all.
    fn is_absence(&self) -> bool {
        match self {
            Self::Open { reason, .. } => reason.kind() == io::ErrorKind::NotFound,
            Self::NotFound { .. } => true,
            _ => false,
        }
    }

    /// What is wrong and what to do, on a line.
    fn told(&self) -> String {
        match self.help() {
            Some(help) => format!("{self}: {help}"),
            None => self.to_string(),
        }
    }
}

/// A device that is there and cannot be used.
struct Refusal {
    reason: String,
    since: Micros,
    said: bool,
}

enum Wanted {
    Serial(Box<SerialSpec>),
    Hid(HidSpec),
}

enum Port {
    Serial(Serial),
    Hid(Device),
}

/// A device, or the wait for it.
pub(super) struct Live {
    wanted: Wanted,
    port: Option<Port>,
    /// Where it is, or was last.
    path: String,
    decoder: Box<dyn Decoder + Send>,
    session: Option<Session>,
    watch: Watch,
    /// There is trouble, and it was said.
    said: bool,
    /// A plug that is not announced yet.
    announce: bool,
    retry_at: Micros,
    back_off: Micros,
    refusal: Option<Refusal>,
    /// From then on samples are handed on whether or not it is set up.
    believed_at: Micros,
    /// When it is told again what to send if nothing comes until then.
    again_at: Micros,
    /// It was told again: that this is in vain was said before.
    again: bool,
}

impl Live {
    pub(super) fn serial(spec: SerialSpec) -> Result<Self, LiveError> {
        Self::open(Wanted::Serial(Box::new(spec)))
    }

    pub(super) fn hid(spec: HidSpec) -> Result<Self, LiveError> {
        Self::open(Wanted::Hid(spec))
    }

    fn open(wanted: Wanted) -> Result<Self, LiveError> {
        let (port, path, decoder) = plug(&wanted)?;
        let mut live = Self {
            session: session(&wanted),
            wanted,
            port: Some(port),
            path,
            decoder,
            watch: Watch::new(),
            said: false,
            announce: true,
            retry_at: Micros(0),
            back_off: BACK_OFF[0],
            refusal: None,
            believed_at: SETTING_UP,
            again_at: AGAIN,
            again: false,
        };
        live.believed_at = believed(&live.wanted, Micros(0));
        live.request_all();
        Ok(live)
    }

    pub(super) fn counts(&self) -> Counts {
        *self.decoder.counts()
    }

    pub(super) fn protocol(&self) -> Option<&Protocol> {
        match &self.wanted {
            Wanted::Serial(spec) => Some(&spec.protocol),
            Wanted::Hid(_) => None,
        }
    }

    /// Whether it is being reset, which it is silent for.
    pub(super) fn is_resetting(&self) -> bool {
        let resets = matches!(&self.wanted, Wanted::Serial(spec) if spec.reset);
        resets && self.session.is_some() && !self.again
    }

    /// Says what came within 2 ms.
    pub(super) fn poll(&mut self, start: Instant, sink: &mut dyn FnMut(Notice)) {
        let now = || Micros(start.elapsed().as_micros() as u64);
        if self.announce {
            self.announce = false;
            sink(Notice::Plugged(self.path.clone()));
        }
        if self.port.is_none() {
            self.look_for_it(now(), sink);
            return;
        }
        let heard = self.listen(now, sink);
        let spoken = heard.and_then(|()| self.speak(now(), sink));
        if let Err(reason) = spoken {
            self.port = None;
            self.decoder.reset();
            self.back_off = BACK_OFF[0];
            self.retry_at = now().after(self.back_off);
            sink(Notice::Unplugged {
                path: self.path.clone(),
                reason: reason.to_string(),
            });
            return;
        }
        if self.is_resetting() {
            return;
        }
        self.tell_again(now());
        let trouble = self.watch.trouble(now());
        if let Some(trouble) = trouble.filter(|_| !self.said) {
            sink(Notice::Trouble(trouble));
        }
        self.said = trouble.is_some();
    }

    fn listen(&mut self, now: impl Fn() -> Micros, sink: &mut dyn FnMut(Notice)) -> io::Result<()> {
        let mut buffer = [0; CHUNK];
        let read = match &mut self.port {
            Some(Port::Serial(port)) => port.read(&mut buffer)?,
            Some(Port::Hid(device)) => device.read(&mut buffer)?,
            None => 0,
        };
        if read == 0 {
            return Ok(());
        }
        let now = now();
        self.watch.on_bytes(read, now);
        if let Some(session) = &mut self.session {
            session.on_bytes(read);
        }
        let (watch, session) = (&mut self.watch, &mut self.session);
        let again_at = &mut self.again_at;
        let set_up = session.as_ref().is_none_or(Session::has_said_all) || now >= self.believed_at;
        self.decoder.feed(&buffer[..read], now, &mut |event| {
            watch.on_event(&event, now);
            if matches!(event, Event::Sample(_) | Event::Message(_)) {
                *again_at = now.after(AGAIN);
            }
            if let Some(session) = session.as_mut() {
                session.on_event(&event);
            }
            if set_up || !matches!(event, Event::Sample(_)) {
                sink(Notice::Decoded(Box::new(event)));
            }
        });
        Ok(())
    }

    fn speak(&mut self, now: Micros, sink: &mut dyn FnMut(Notice)) -> io::Result<()> {
        let (Some(session), Some(Port::Serial(port))) = (&mut self.session, &mut self.port) else {
            return Ok(());
        };
        loop {
            match session.poll(now) {
                Action::Send(bytes) => port.write(bytes)?,
                Action::Speed(baud) => port.set_speed(baud)?,
                Action::Wait(_) => return Ok(()),
                Action::Done => {
                    self.session = None;
                    self.again_at = now.after(AGAIN);
                    return Ok(());
                }
                Action::Failed(failure) => {
                    self.session = None;
                    self.again_at = now.after(AGAIN);
                    // These two the watch says, and earlier.
                    let by_watch = matches!(failure, Failure::Silent | Failure::NoRecord { .. });
                    if !by_watch && !self.again {
                        sink(Notice::Trouble(failure));
                    }
                    return Ok(());
                }
            }
        }
    }

    /// Begins the session of a silent device again, without a reset: one that
    /// was switched on only now has none to be undone.
    fn tell_again(&mut self, now: Micros) {
        let Wanted::Serial(spec) = &self.wanted else {
            return;
        };
        if self.session.is_some() || now < self.again_at {
            return;
        }
        self.session = Some(Session::new(spec.protocol.start(false)));
        self.again = true;
        self.believed_at = now.after(SETTING_UP);
    }

    fn look_for_it(&mut self, now: Micros, sink: &mut dyn FnMut(Notice)) {
        if now < self.retry_at {
            std::thread::sleep(std::time::Duration::from_millis(2));
            return;
        }
        match plug(&self.wanted) {
            Ok((port, path, _)) => {
                // The decoder stays: its counts go on.
                (self.port, self.path) = (Some(port), path);
                self.session = session(&self.wanted);
                self.watch = Watch::new();
                self.said = false;
                self.announce = true;
                self.refusal = None;
                self.believed_at = believed(&self.wanted, now);
                self.again = false;
                self.again_at = now.after(AGAIN);
                self.request_all();
            }
            Err(error) => {
                self.retry_at = now.after(self.back_off);
                self.back_off = Micros(2 * self.back_off.0).min(BACK_OFF[1]);
                self.refused(&error, now, sink);
            }
        }
    }

    /// Says why the device cannot be used again, once for each reason.
    fn refused(&mut self, error: &LiveError, now: Micros, sink: &mut dyn FnMut(Notice)) {
        if error.is_absence() {
            self.refusal = None;
            return;
        }
        let reason = error.told();
        match &mut self.refusal {
            Some(refusal) if refusal.reason == reason => {
                if !refusal.said && now.since(refusal.since) >= REFUSING {
                    refusal.said = true;
                    sink(Notice::Refused { reason });
                }
            }
            _ => {
                self.refusal = Some(Refusal {
                    reason,
                    since: now,
                    said: false,
                });
            }
        }
    }

    /// Asks a HID eye tracker for all it has; one that takes no requests
    /// sends of itself.
    fn request_all(&mut self) {
        let Some(Port::Hid(device)) = &mut self.port else {
            return;
        };
        let descriptor = device.descriptor().ok();
        let tracker = descriptor.and_then(|bytes| EyeTracker::new(&bytes, Axes::default()).ok());
        if let Some(request) = tracker.and_then(|tracker| tracker.mode_request(Mode::ALL)) {
            let _ = device.set_feature(&request);
        }
    }
}

fn session(wanted: &Wanted) -> Option<Session> {
    match wanted {
        Wanted::Serial(spec) => Some(Session::new(spec.protocol.start(spec.reset))),
        Wanted::Hid(_) => None,
    }
}

/// From when on a device is believed that is set up from `now` on.
fn believed(wanted: &Wanted, now: Micros) -> Micros {
    let reset = match wanted {
        Wanted::Serial(spec) => spec.protocol.start(spec.reset).once_only_time(),
        Wanted::Hid(_) => Micros(0),
    };
    now.after(reset).after(SETTING_UP)
}

type Plugged = (Port, String, Box<dyn Decoder + Send>);

fn plug(wanted: &Wanted) -> Result<Plugged, LiveError> {
    match wanted {
        Wanted::Serial(spec) => {
            let path = spec.path.clone();
            let refused = |reason| LiveError::Open {
                path: path.clone(),
                reason,
            };
            let mut port = Serial::open(&path, spec.baud).map_err(refused)?;
            set_rts(spec, |high| port.set_rts(high)).map_err(refused)?;
            let decoder = spec.protocol.decoder();
            let decoder = decoder.ok_or_else(|| refused(io::ErrorKind::Unsupported.into()))?;
            Ok((Port::Serial(port), path, decoder))
        }
        Wanted::Hid(spec) => plug_hid(spec),
    }
}

/// Puts a line's RTS where it has to be. A port that has none is taken as it is,
/// unless it was asked for.
fn set_rts(spec: &SerialSpec, mut set: impl FnMut(bool) -> io::Result<()>) -> io::Result<()> {
    match (spec.rts, spec.protocol.rts()) {
        (Some(high), _) => set(high).map_err(|reason| {
            io::Error::new(
                reason.kind(),
                format!("its RTS cannot be set ({reason}); leave rts out"),
            )
        }),
        (None, Some(high)) => {
            let _ = set(high);
            Ok(())
        }
        (None, None) => Ok(()),
    }
}

fn plug_hid(spec: &HidSpec) -> Result<Plugged, LiveError> {
    let at = |path: &str| {
        let path = path.to_owned();
        move |reason| LiveError::Open { path, reason }
    };
    let all = devices().map_err(at("the list of HID devices"))?;
    let path = match &spec.name {
        HidName::Path(path) => path.clone(),
        HidName::Id(vendor, product) => one_of(&all, (*vendor, *product))?,
    };
    let id = all.iter().find(|found| found.path == path);
    let id = id.map(|found| found.id);
    let device = Device::open(&path).map_err(at(&path))?;
    let decoder: Box<dyn Decoder + Send> = if id.is_some_and(|id| osvr_hdk::USB_IDS.contains(&id)) {
        Box::new(osvr_hdk::Decoder::new())
    } else {
        let descriptor = device.descriptor().map_err(at(&path))?;
        let tracker = EyeTracker::new(&descriptor, spec.axes);
        Box::new(tracker.map_err(|reason| LiveError::Layout {
            path: path.clone(),
            reason,
        })?)
    };
    Ok((Port::Hid(device), path, decoder))
}

/// Vendor and product of the device at a path.
pub(super) fn hid_id(path: &str) -> Option<(u16, u16)> {
    let all = devices().ok()?;
    let found = all.iter().find(|found| found.path == path)?;
    Some(found.id)
}

/// The path of the one device that is meant: of several with the same id, the
/// one that says it is a tracker.
fn one_of(all: &[Found], id: (u16, u16)) -> Result<String, LiveError> {
    let same: Vec<&Found> = all.iter().filter(|found| found.id == id).collect();
    let trackers: Vec<&Found> = same.iter().copied().filter(|f| f.is_tracker()).collect();
    match (same.as_slice(), trackers.as_slice()) {
        ([], _) => Err(LiveError::NotFound { id }),
        ([one], _) | (_, [one]) => Ok(one.path.clone()),
        (several, _) => Err(LiveError::Several {
            id,
            paths: several.iter().map(|found| found.path.clone()).collect(),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(path: &str, id: (u16, u16), page: u16) -> Found {
        Found {
            path: path.into(),
            id,
            product: String::new(),
            serial_number: String::new(),
            usages: vec![(page, 1)],
        }
    }

    #[test]
    fn several_devices_are_listed_and_a_tracker_among_them_is_taken() {
        let id = (0x1532, 0x0B00);
        let mut all = vec![found("/dev/a", id, 1), found("/dev/c", (1, 2), 0x12)];
        assert_eq!(one_of(&all, id).unwrap(), "/dev/a");
        all.push(found("/dev/b", id, 1));
        let error = one_of(&all, id).unwrap_err();
        assert_eq!(error.to_string(), "2 devices are 1532:0b00: /dev/a, /dev/b");
        all.push(found("/dev/d", id, 0x12));
        assert_eq!(one_of(&all, id).unwrap(), "/dev/d");
        let error = one_of(&all, (9, 9)).unwrap_err();
        assert!(error.to_string().contains("0009:0009"), "{error}");
    }

    #[test]
    fn a_refusal_names_the_rules() {
        let error = LiveError::Open {
            path: "/dev/hidraw0".into(),
            reason: io::ErrorKind::PermissionDenied.into(),
        };
        let help = error.help().unwrap().to_string();
        assert!(help.contains("70-shisen-trackers.rules"), "{help}");
    }

    /// All that a FASTRAK is told within 60 s in which it says nothing.
    #[cfg(unix)]
    fn told_while_silent(reset: bool) -> Vec<u8> {
        use crate::tracker::Spec;
        use crate::tracker::pty::Pty;
        use std::time::Duration;
        let name = format!("shisen-live-{}-{reset}", std::process::id());
        let path = std::env::temp_dir().join(name);
        let mut pty = Pty::open(&path).unwrap();
        let spec = format!(
            "serial:{}?protocol=fastrak&reset={}",
            path.display(),
            u8::from(reset)
        );
        let Spec::Serial(spec) = spec.parse().unwrap() else {
            panic!("{spec}");
        };
        let mut live = Live::serial(spec).unwrap();
        let mut told = Vec::new();
        let mut buffer = [0; 256];
        // The clock is moved on by 50 ms a call.
        for step in 0..1_200 {
            let start = Instant::now()
                .checked_sub(Duration::from_millis(50 * step))
                .unwrap();
            live.poll(start, &mut |_| {});
            let read = pty.receive(&mut buffer).unwrap();
            told.extend_from_slice(&buffer[..read]);
        }
        told
    }

    /// What is plugged in where the device was and is none is said once, until it
    /// is something else that is none.
    #[cfg(unix)]
    #[test]
    fn a_device_that_cannot_be_used_again_is_told_once() {
        use crate::tracker::Spec;
        use crate::tracker::pty::Pty;
        use std::time::Duration;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("line");
        let pty = Pty::open(&path).unwrap();
        let spec = format!("serial:{}?protocol=hatire", path.display());
        let Ok(Spec::Serial(spec)) = spec.parse() else {
            panic!("{spec}");
        };
        let mut live = Live::serial(spec).unwrap();
        let mut step = 0;
        // The clock is moved on by 50 ms a call, 5 s in all.
        let mut poll = || {
            let mut said = Vec::new();
            for _ in 0..100 {
                step += 1;
                let start = Instant::now()
                    .checked_sub(Duration::from_millis(50 * step))
                    .unwrap();
                live.poll(start, &mut |notice| said.push(notice));
            }
            said
        };
        poll();
        drop(pty);
        let [Notice::Unplugged { .. }] = poll()[..] else {
            panic!("it is gone");
        };
        assert_eq!(poll(), []);
        let reason = |said: Vec<Notice>| match &said[..] {
            [Notice::Refused { reason }] => reason.clone(),
            other => panic!("{other:?}"),
        };
        std::fs::write(&path, "no port").unwrap();
        let of_file = reason(poll());
        assert!(of_file.contains("line cannot be opened"), "{of_file}");
        assert!(of_file.contains("check the path"), "{of_file}");
        assert_eq!(poll(), []);
        std::fs::remove_file(&path).unwrap();
        std::fs::create_dir(&path).unwrap();
        assert_ne!(reason(poll()), of_file);
        assert_eq!(poll(), []);
        std::fs::remove_dir(&path).unwrap();
        assert_eq!(poll(), []);
        std::fs::write(&path, "no port").unwrap();
        assert_eq!(reason(poll()), of_file);
        std::fs::remove_file(&path).unwrap();
        let _pty = Pty::open(&path).unwrap();
        assert_eq!(poll()[0], Notice::Plugged(path.display().to_string()));
    }

    #[cfg(unix)]
    #[test]
    fn a_silent_device_is_told_again_and_reset_once_at_most() {
        for reset in [false, true] {
            let told = told_while_silent(reset);
            let count = |byte| told.split(|&found| found == byte).count() - 1;
            // Continuous output is asked for.
            assert!(count(b'C') >= 6, "{told:?}");
            assert_eq!(count(0x19), usize::from(reset), "{told:?}");
        }
    }

    #[test]
    fn a_flocks_line_is_out_of_reset() {
        use crate::tracker::Spec;
        for (options, expected) in [
            ("protocol=flock", Some(false)),
            ("protocol=flock&rts=1", Some(true)),
            ("protocol=fastrak", None),
            ("protocol=fastrak&rts=0", Some(false)),
        ] {
            let Ok(Spec::Serial(spec)) = format!("serial:/dev/ttyS0?{options}").parse() else {
                panic!("{options}");
            };
            let mut told = None;
            set_rts(&spec, |high| {
                told = Some(high);
                Ok(())
            })
            .unwrap();
            assert_eq!(told, expected, "{options}");
            let without = || io::Error::from(io::ErrorKind::Unsupported);
            let set = set_rts(&spec, |_| Err(without()));
            assert_eq!(set.is_err(), options.contains("rts"), "{options}");
        }
    }

    #[test]
    fn a_device_is_believed_after_its_reset() {
        use crate::tracker::Spec;
        let wanted = |spec: &str| match spec.parse() {
            Ok(Spec::Serial(spec)) => Wanted::Serial(Box::new(spec)),
            other => panic!("{other:?}"),
        };
        let now = Micros(7);
        let usual = wanted("serial:/dev/ttyS0?protocol=fastrak");
        assert_eq!(believed(&usual, now), now.after(SETTING_UP));
        let reset = wanted("serial:/dev/ttyS0?protocol=fastrak&reset=1");
        let least = now.after(Micros::from_millis(10_000)).after(SETTING_UP);
        assert_eq!(believed(&reset, now), least);
    }
}

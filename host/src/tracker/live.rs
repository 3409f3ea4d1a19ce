//! A device that is plugged in, unplugged, and plugged in again.

mod permission;

use super::feed::{Notice, Trouble};
use super::hid::{self, Features};
use super::protocol::ProtocolSpec;
use super::spec::{HidName, HidSpec, SerialSpec};
use miette::Diagnostic;
use shisen_tracker::command::{Action, Failure, Script, Session, SettingUp, Watch};
use shisen_tracker::decoder::{Counts, Decoder, Event};
use shisen_tracker::hid::device::Device;
use shisen_tracker::hid::eye_tracker::LayoutError;
use shisen_tracker::serial::Serial;
use shisen_tracker::time::Micros;
use std::io;
use std::time::Instant;
use thiserror::Error;

/// The first wait before a device is looked for again, and the longest.
const BACK_OFF: [Micros; 2] = [Micros::from_millis(20), Micros::from_millis(500)];

/// Bytes that are read at once; no report is longer.
const CHUNK: usize = 4096;

/// How much longer a device is set up whose line's speed is changed first.
const CHANGING_SPEED: Micros = Micros::from_millis(600);

/// A device that has said nothing for so long is told again what to send: it may
/// have been switched on only now.
const AGAIN: Micros = Micros::from_millis(5_000);

/// A device that sends a sample so long after it was told to restart, or later, is
/// back, or never went: it is not waited for any longer.
const RESTARTING: Micros = Micros::from_millis(1_000);

/// How long a device that is there again may refuse to be used before that is
/// said: the system takes a moment to let others than root use it.
const REFUSING: Micros = Micros::from_millis(300);

/// Why a device cannot be used.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum LiveError {
    /// The system does not let it be opened.
    #[error("{path} cannot be opened: {reason}")]
    #[diagnostic(help("{}", advice(path, reason)))]
    Open {
        /// Which.
        path: String,
        /// What the system said.
        reason: io::Error,
    },
    /// No such device is plugged in.
    #[error("no HID device {name} is plugged in")]
    #[diagnostic(help("plug it in; `shisen tracker list` shows what there is"))]
    NotFound {
        /// Which was meant.
        name: HidName,
    },
    /// More than one device is meant.
    #[error("{} devices are {name}: {}", paths.len(), paths.join(", "))]
    #[diagnostic(help("give one by its path, such as hid:{}", paths.first().map_or("", |p| p)))]
    Several {
        /// Which was meant.
        name: HidName,
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

fn advice(path: &str, reason: &io::Error) -> String {
    match reason.kind() {
        io::ErrorKind::NotFound => {
            "plug the device in, or give another path; `shisen tracker list` shows what there is"
                .to_owned()
        }
        io::ErrorKind::PermissionDenied => permission::advice(path),
        io::ErrorKind::ResourceBusy => "another program uses it: end that first".to_owned(),
        _ => "check the path and the device".to_owned(),
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
    Hid(Box<HidSpec>),
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
    /// Of the decoders before: each time that it is plugged in it has one of its
    /// own, since it may describe its reports otherwise.
    before: Counts,
    /// What an eye tracker said of itself, until that is announced.
    features: Option<Features>,
    session: Option<Session>,
    /// What is said after it: the line's speed is changed before the device is
    /// set up.
    then: Option<Script>,
    watch: Watch,
    /// There is trouble, and it was said.
    said: bool,
    /// A plug that is not announced yet.
    announce: bool,
    retry_at: Micros,
    back_off: Micros,
    refusal: Option<Refusal>,
    /// Until that is over, samples are held back.
    setting_up: SettingUp,
    /// When it is told again what to send if nothing comes until then.
    again_at: Micros,
    /// Since when it is waited for, after it was told to restart.
    resets_since: Option<Micros>,
    /// It was told again: that this is in vain was said before.
    again: bool,
    /// Samples that came before it was set up.
    held_back: u64,
}

impl Live {
    pub(super) fn serial(spec: SerialSpec) -> Result<Self, LiveError> {
        Self::open(Wanted::Serial(Box::new(spec)))
    }

    pub(super) fn hid(spec: HidSpec) -> Result<Self, LiveError> {
        Self::open(Wanted::Hid(Box::new(spec)))
    }

    fn open(wanted: Wanted) -> Result<Self, LiveError> {
        let plugged = plug(&wanted)?;
        Ok(Self {
            session: session(&wanted),
            then: script_after(&wanted),
            watch: watch(&wanted),
            setting_up: setting_up(&wanted, Micros(0)),
            resets_since: resets_since(&wanted, Micros(0)),
            wanted,
            port: Some(plugged.port),
            path: plugged.path,
            decoder: plugged.decoder,
            before: Counts::new(),
            features: plugged.features,
            said: false,
            announce: true,
            retry_at: Micros(0),
            back_off: BACK_OFF[0],
            refusal: None,
            again_at: AGAIN,
            again: false,
            held_back: 0,
        })
    }

    pub(super) fn counts(&self) -> Counts {
        self.before.plus(self.decoder.counts())
    }

    pub(super) const fn held_back(&self) -> u64 {
        self.held_back
    }

    pub(super) fn protocol(&self) -> Option<&ProtocolSpec> {
        match &self.wanted {
            Wanted::Serial(spec) => Some(&spec.protocol),
            Wanted::Hid(_) => None,
        }
    }

    /// Whether it is being reset, which it is silent for.
    pub(super) fn is_resetting(&self) -> bool {
        self.resets_since.is_some() && self.session.is_some()
    }

    /// Says what came within 2 ms.
    pub(super) fn poll(&mut self, start: Instant, sink: &mut dyn FnMut(Notice)) {
        let now = || Micros(start.elapsed().as_micros() as u64);
        if self.announce {
            self.announce = false;
            sink(Notice::Plugged(self.path.clone()));
            if let Some(features) = self.features.take() {
                sink(Notice::Described(Box::new(features)));
            }
            if self.is_resetting() {
                sink(Notice::Restarting(reset_time(&self.wanted)));
            }
        }
        if self.port.is_none() {
            self.look_for_it(now(), sink);
            return;
        }
        let heard = self.listen(now, sink);
        let spoken = heard.and_then(|()| self.speak(now(), sink));
        let spoken = spoken.and_then(|()| {
            if self.is_resetting() {
                Ok(())
            } else {
                self.tell_again(now())
            }
        });
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
        let trouble = self.watch.trouble(now());
        if let Some(trouble) = trouble.filter(|_| !self.said) {
            sink(self.trouble(trouble));
        }
        self.said = trouble.is_some();
    }

    fn trouble(&self, failure: Failure) -> Notice {
        Notice::Trouble(Trouble {
            failure,
            fields_seen: self.decoder.fields_seen(),
        })
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
        let resets_since = self.resets_since.filter(|_| self.is_resetting());
        let back = resets_since.is_some_and(|since| now.since(since) >= RESTARTING);
        let (watch, session) = (&mut self.watch, &mut self.session);
        let mut goes_on = false;
        let (again_at, held_back) = (&mut self.again_at, &mut self.held_back);
        let has_said_all =
            session.as_ref().is_none_or(Session::has_said_all) && self.then.is_none();
        let set_up = self.setting_up.is_over(has_said_all, now);
        self.decoder.feed(&buffer[..read], now, &mut |event| {
            watch.on_event(&event, now);
            goes_on |= back && matches!(event, Event::Sample(_));
            if matches!(event, Event::Sample(_) | Event::Message(_)) {
                *again_at = now.after(AGAIN);
            }
            if let Some(session) = session.as_mut() {
                session.on_event(&event);
            }
            if set_up || !matches!(event, Event::Sample(_)) {
                sink(Notice::Decoded(event));
            } else {
                *held_back += 1;
            }
        });
        if goes_on && let Wanted::Serial(spec) = &self.wanted {
            self.session = Some(Session::new(spec.protocol.start(false)));
            self.resets_since = None;
            self.setting_up = SettingUp::since(now, Micros(0));
        }
        Ok(())
    }

    fn speak(&mut self, now: Micros, sink: &mut dyn FnMut(Notice)) -> io::Result<()> {
        let (Some(session), Some(Port::Serial(port))) = (&mut self.session, &mut self.port) else {
            return Ok(());
        };
        loop {
            match session.poll(now) {
                Action::Send(bytes) => {
                    port.write(bytes)?;
                    self.decoder.on_sent(bytes, now);
                }
                Action::Speed(baud) => port.set_speed(baud)?,
                Action::Wait(_) => return Ok(()),
                Action::Done if self.then.is_some() => {
                    *session = Session::new(self.then.take().unwrap_or_default());
                }
                Action::Done => {
                    self.session = None;
                    self.again_at = now.after(AGAIN);
                    return Ok(());
                }
                Action::Failed(failure) => {
                    self.session = None;
                    self.then = None;
                    self.again_at = now.after(AGAIN);
                    // These two the watch says, and earlier.
                    let by_watch = matches!(
                        failure,
                        Failure::Silent | Failure::NoRecord { .. } | Failure::Unusable { .. }
                    );
                    if !by_watch && !self.again {
                        sink(self.trouble(failure));
                    }
                    return Ok(());
                }
            }
        }
    }

    /// Begins the session of a silent device again, without a reset: one that
    /// was switched on only now has none to be undone, and is at its own speed.
    fn tell_again(&mut self, now: Micros) -> io::Result<()> {
        let (Wanted::Serial(spec), Some(Port::Serial(port))) = (&self.wanted, &mut self.port)
        else {
            return Ok(());
        };
        if self.session.is_some() || now < self.again_at {
            return Ok(());
        }
        self.session = Some(match spec.speed {
            Some(speed) => {
                port.set_speed(spec.baud)?;
                Session::new(
                    spec.protocol
                        .protocol()
                        .change_speed(speed)
                        .unwrap_or_default(),
                )
            }
            None => Session::new(spec.protocol.start(false)),
        });
        self.then = script_after(&self.wanted);
        self.resets_since = None;
        self.again = true;
        self.setting_up = SettingUp::since(now, speed_time(&self.wanted));
        Ok(())
    }

    fn look_for_it(&mut self, now: Micros, sink: &mut dyn FnMut(Notice)) {
        if now < self.retry_at {
            std::thread::sleep(std::time::Duration::from_millis(2));
            return;
        }
        match plug(&self.wanted) {
            Ok(plugged) => {
                self.before = self.counts();
                self.decoder = plugged.decoder;
                self.features = plugged.features;
                (self.port, self.path) = (Some(plugged.port), plugged.path);
                self.session = session(&self.wanted);
                self.then = script_after(&self.wanted);
                self.watch = watch(&self.wanted);
                self.said = false;
                self.announce = true;
                self.refusal = None;
                self.setting_up = setting_up(&self.wanted, now);
                self.again = false;
                self.resets_since = resets_since(&self.wanted, now);
                self.again_at = now.after(AGAIN);
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
}

impl Drop for Live {
    /// Leaves a device silent that is to be left so, as far as its line still
    /// takes a word.
    fn drop(&mut self) {
        let (Wanted::Serial(spec), Some(Port::Serial(port))) = (&self.wanted, &mut self.port)
        else {
            return;
        };
        if !spec.stop {
            return;
        }
        let mut session = Session::new(spec.protocol.protocol().stop());
        while let Action::Send(bytes) = session.poll(Micros(0)) {
            if port.write(bytes).is_err() {
                return;
            }
        }
    }
}

/// What is said first to a device that was plugged in.
fn session(wanted: &Wanted) -> Option<Session> {
    let Wanted::Serial(spec) = wanted else {
        return None;
    };
    let faster = spec
        .speed
        .and_then(|speed| spec.protocol.protocol().change_speed(speed));
    Some(Session::new(
        faster.unwrap_or_else(|| spec.protocol.start(spec.reset)),
    ))
}

/// What is said after a change of the line's speed.
fn script_after(wanted: &Wanted) -> Option<Script> {
    match wanted {
        Wanted::Serial(spec) if spec.speed.is_some() => Some(spec.protocol.start(false)),
        _ => None,
    }
}

/// Since when one is waited for that is told to restart when it is plugged in.
fn resets_since(wanted: &Wanted, now: Micros) -> Option<Micros> {
    matches!(wanted, Wanted::Serial(spec) if spec.reset).then_some(now)
}

fn watch(wanted: &Wanted) -> Watch {
    match wanted {
        Wanted::Serial(_) => Watch::new(),
        Wanted::Hid(_) => Watch::of_reports(),
    }
}

/// How long samples are held back of a device that was plugged in `now`.
fn setting_up(wanted: &Wanted, now: Micros) -> SettingUp {
    SettingUp::since(now, reset_time(wanted).after(speed_time(wanted)))
}

/// How long a change of the line's speed takes, where one is asked for.
fn speed_time(wanted: &Wanted) -> Micros {
    if script_after(wanted).is_some() {
        CHANGING_SPEED
    } else {
        Micros(0)
    }
}

/// How long one is silent that is told to restart.
fn reset_time(wanted: &Wanted) -> Micros {
    match wanted {
        Wanted::Serial(spec) => spec.protocol.start(spec.reset).once_only_time(),
        Wanted::Hid(_) => Micros(0),
    }
}

struct Plugged {
    port: Port,
    path: String,
    decoder: Box<dyn Decoder + Send>,
    features: Option<Features>,
}

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
            Ok(Plugged {
                port: Port::Serial(port),
                path,
                decoder,
                features: None,
            })
        }
        Wanted::Hid(spec) => {
            let plugged = hid::plug(spec)?;
            Ok(Plugged {
                port: Port::Hid(plugged.device),
                path: plugged.path,
                decoder: plugged.decoder,
                features: plugged.features,
            })
        }
    }
}

/// Puts a line's RTS where it has to be. A port that has none is taken as it is,
/// unless it was asked for.
fn set_rts(spec: &SerialSpec, mut set: impl FnMut(bool) -> io::Result<()>) -> io::Result<()> {
    match (spec.rts, spec.protocol.protocol().rts()) {
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

#[cfg(test)]
mod tests;

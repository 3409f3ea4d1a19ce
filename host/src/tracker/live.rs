//! A device that is plugged in, unplugged, and plugged in again.

use super::hid;
use super::notice::{Features, LiveError, Notice, Trouble};
use super::port::{Plugged, Port, open_serial};
use super::raw::{Piece, Tap};
use super::spec::{SerialSpec, TrackerKind};
use shisen_tracker::command::{Action, Failure, Script, Session, SettingUp, Watch};
use shisen_tracker::decoder::{Counts, Decoder, Event};
use shisen_tracker::time::Micros;
use std::io;
use std::time::Instant;

/// The first and the longest wait before an unplugged device is looked for again.
const BACK_OFF: [Micros; 2] = [Micros::from_millis(20), Micros::from_millis(500)];

/// Bytes read at once; no report is longer.
const CHUNK: usize = 4096;

/// How much longer setting up takes where the line's speed is changed first.
const CHANGING_SPEED: Micros = Micros::from_millis(600);

/// Silence after which a device is set up again: it may have been switched on only now.
const REPEAT_SETUP: Micros = Micros::from_millis(5_000);

/// A device that sends this long after it was told to restart is back, or never went.
const LEAST_RESTART: Micros = Micros::from_millis(1_000);

/// How long a device that is plugged in again may refuse to open before that is reported.
const REFUSAL_GRACE: Micros = Micros::from_millis(300);

/// Why a device does not open again, and since when.
struct Refusal {
    reason: String,
    since: Micros,
    reported: bool,
}

pub(super) struct Live {
    spec: TrackerKind,
    port: Option<Port>,
    path: String,
    /// A new one each time that the device is plugged in: its description may change.
    decoder: Box<dyn Decoder + Send>,
    before: Counts,
    /// What an eye tracker said of itself, until that is reported.
    features: Option<Features>,
    session: Option<Session>,
    /// What follows the session: the set-up after a change of the line's speed.
    then: Option<Script>,
    watch: Watch,
    trouble_reported: bool,
    plug_reported: bool,
    retry_at: Micros,
    back_off: Micros,
    refusal: Option<Refusal>,
    /// Samples are held back until this is over.
    setting_up: SettingUp,
    repeat_at: Micros,
    /// When the device was told to restart, while it is waited for.
    resets_since: Option<Micros>,
    /// The device was set up again: a further failure was reported before.
    again: bool,
    held_back: u64,
    tap: Tap,
}

impl Live {
    pub(super) fn open(spec: TrackerKind, tap: Tap) -> Result<Self, LiveError> {
        let plugged = plug(&spec)?;
        Ok(Self::new(spec, plugged, Micros(0), tap))
    }

    fn new(spec: TrackerKind, plugged: Plugged, now: Micros, tap: Tap) -> Self {
        tap.take(Piece::Opened, &plugged.descriptor, now);
        let serial = serial(&spec);
        let watch = serial.map_or_else(Watch::of_reports, |_| Watch::new());
        let resets_since = serial.filter(|spec| spec.reset).map(|_| now);
        let longer = reset_time(serial).after(speed_time(serial));
        Self {
            session: serial.map(|spec| Session::new(first_script(spec, spec.reset))),
            then: serial.and_then(script_after),
            watch,
            setting_up: SettingUp::since(now, longer),
            resets_since,
            spec,
            port: Some(plugged.port),
            path: plugged.path,
            decoder: plugged.decoder,
            before: Counts::new(),
            features: plugged.features,
            trouble_reported: false,
            plug_reported: false,
            retry_at: now,
            back_off: BACK_OFF[0],
            refusal: None,
            repeat_at: now.after(REPEAT_SETUP),
            again: false,
            held_back: 0,
            tap,
        }
    }

    pub(super) fn counts(&self) -> Counts {
        self.before.plus(self.decoder.counts())
    }

    pub(super) const fn held_back(&self) -> u64 {
        self.held_back
    }

    pub(super) fn is_resetting(&self) -> bool {
        self.resets_since.is_some() && self.session.is_some()
    }

    /// Hands over what comes within 2 ms.
    pub(super) fn poll(&mut self, start: Instant, sink: &mut dyn FnMut(Notice)) {
        let now = || Micros(start.elapsed().as_micros() as u64);
        if !std::mem::replace(&mut self.plug_reported, true) {
            sink(Notice::Plugged(self.path.clone()));
            if let Some(features) = self.features.take() {
                sink(Notice::Described(Box::new(features)));
            }
            if self.is_resetting() {
                sink(Notice::Restarting(reset_time(serial(&self.spec))));
            }
        }
        if self.port.is_none() {
            self.look_for_device(now(), sink);
            return;
        }
        let listened = self.listen(now, sink);
        let spoken = listened.and_then(|()| self.speak(now(), sink));
        if let Err(reason) = spoken.and_then(|()| self.repeat_setup(now())) {
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
        if let Some(trouble) = trouble.filter(|_| !self.trouble_reported) {
            sink(self.trouble(trouble));
        }
        self.trouble_reported = trouble.is_some();
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
            Some(port) => port.read(&mut buffer)?,
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
        let may_be_back = resets_since.is_some_and(|since| now.since(since) >= LEAST_RESTART);
        let (watch, session) = (&mut self.watch, &mut self.session);
        let mut is_back = false;
        let (repeat_at, held_back) = (&mut self.repeat_at, &mut self.held_back);
        let is_complete = session.as_ref().is_none_or(Session::is_complete) && self.then.is_none();
        let set_up = self.setting_up.is_over(is_complete, now);
        let piece = if set_up { Piece::Came } else { Piece::Early };
        self.tap.take(piece, &buffer[..read], now);
        self.decoder.feed(&buffer[..read], now, &mut |event| {
            watch.on_event(&event, now);
            is_back |= may_be_back && matches!(event, Event::Sample(_));
            if matches!(event, Event::Sample(_) | Event::Message(_)) {
                *repeat_at = now.after(REPEAT_SETUP);
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
        if is_back && let Some(spec) = serial(&self.spec) {
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
                    self.tap.take(Piece::Sent, bytes, now);
                    self.decoder.on_sent(bytes, now);
                }
                Action::Speed(baud) => port.set_speed(baud)?,
                Action::Wait(_) => return Ok(()),
                Action::Done if self.then.is_some() => {
                    *session = Session::new(self.then.take().unwrap_or_default());
                }
                Action::Done => {
                    self.session = None;
                    self.repeat_at = now.after(REPEAT_SETUP);
                    return Ok(());
                }
                Action::Failed(failure) => {
                    (self.session, self.then) = (None, None);
                    self.repeat_at = now.after(REPEAT_SETUP);
                    // The watch reports these, and earlier.
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

    /// Sets a silent device up again, at its first speed and without a reset.
    fn repeat_setup(&mut self, now: Micros) -> io::Result<()> {
        let (Some(spec), Some(Port::Serial(port))) = (serial(&self.spec), &mut self.port) else {
            return Ok(());
        };
        if self.session.is_some() || now < self.repeat_at {
            return Ok(());
        }
        if spec.speed.is_some() {
            port.set_speed(spec.baud)?;
        }
        self.session = Some(Session::new(first_script(spec, false)));
        self.then = script_after(spec);
        self.resets_since = None;
        self.again = true;
        self.setting_up = SettingUp::since(now, speed_time(Some(spec)));
        Ok(())
    }

    fn look_for_device(&mut self, now: Micros, sink: &mut dyn FnMut(Notice)) {
        if now < self.retry_at {
            std::thread::sleep(std::time::Duration::from_millis(2));
            return;
        }
        match plug(&self.spec) {
            Ok(plugged) => {
                let mut next = Self::new(self.spec.clone(), plugged, now, self.tap.clone());
                next.before = self.counts();
                next.held_back = self.held_back;
                *self = next;
            }
            Err(error) => {
                self.retry_at = now.after(self.back_off);
                self.back_off = Micros(2 * self.back_off.0).min(BACK_OFF[1]);
                self.report_refusal(&error, now, sink);
            }
        }
    }

    /// Reports once for each reason why the device does not open again.
    fn report_refusal(&mut self, error: &LiveError, now: Micros, sink: &mut dyn FnMut(Notice)) {
        if error.is_absence() {
            self.refusal = None;
            return;
        }
        let reason = error.full_text();
        let known = self.refusal.take().filter(|known| known.reason == reason);
        let mut refusal = known.unwrap_or(Refusal {
            reason,
            since: now,
            reported: false,
        });
        if !refusal.reported && now.since(refusal.since) >= REFUSAL_GRACE {
            refusal.reported = true;
            sink(Notice::Refused(refusal.reason.clone()));
        }
        self.refusal = Some(refusal);
    }
}

impl Drop for Live {
    /// Stops a device that is to be left silent, as far as its line still takes a word.
    fn drop(&mut self) {
        if let (Some(spec), Some(Port::Serial(port))) = (serial(&self.spec), &mut self.port)
            && spec.stop
        {
            let mut session = Session::new(spec.protocol.protocol().stop());
            while let Action::Send(bytes) = session.poll(Micros(0)) {
                if port.write(bytes).is_err() {
                    return;
                }
            }
        }
    }
}

fn plug(spec: &TrackerKind) -> Result<Plugged, LiveError> {
    match spec {
        TrackerKind::Serial(spec) => open_serial(spec),
        TrackerKind::Hid(spec) => hid::plug(spec),
        _ => Err(LiveError::Open(
            String::new(),
            io::ErrorKind::Unsupported.into(),
        )),
    }
}

const fn serial(spec: &TrackerKind) -> Option<&SerialSpec> {
    match spec {
        TrackerKind::Serial(spec) => Some(spec),
        _ => None,
    }
}

/// Returns the first script of a session: a change of the line's speed, or else the set-up.
fn first_script(spec: &SerialSpec, reset: bool) -> Script {
    let protocol = spec.protocol.protocol();
    let change = spec.speed.and_then(|speed| protocol.change_speed(speed));
    change.unwrap_or_else(|| spec.protocol.start(reset))
}

fn script_after(spec: &SerialSpec) -> Option<Script> {
    spec.speed.map(|_| spec.protocol.start(false))
}

/// Returns how long a change of the line's speed takes, where the specification asks for one.
fn speed_time(spec: Option<&SerialSpec>) -> Micros {
    let change = spec.and_then(|spec| spec.speed);
    change.map_or(Micros(0), |_| CHANGING_SPEED)
}

fn reset_time(spec: Option<&SerialSpec>) -> Micros {
    spec.map_or(Micros(0), |spec| {
        spec.protocol.start(spec.reset).once_only_time()
    })
}

#[cfg(all(test, unix))]
mod tests;

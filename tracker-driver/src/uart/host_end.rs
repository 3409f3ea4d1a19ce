//! The host's end of a line: sends a tracker its commands and reads it, one step in each
//! round of a firmware's loop.

use super::drain;
use crate::command::{Action, Bytes, Failure, Script, Session};
use crate::decoder::{Decoder, Event};
use crate::time::Micros;
use embedded_io::{Read, ReadReady, Write, WriteReady};

/// A port with the decoder and the set-up session of its device; no step waits.
#[derive(Debug, Clone)]
pub struct HostEnd<D> {
    decoder: D,
    session: Session,
    /// A command that the port has taken in part, and the number of bytes it took.
    command: Bytes,
    written: usize,
}

/// The caller's duty after a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Due {
    /// The port is full; the rest of a command waits for it.
    Room,
    /// The caller changes the line to this speed, baud, once what was written is out
    /// (`embedded_io::Write::flush` waits for that), before the next step.
    Speed(u32),
    /// No command is due before this time, unless bytes come in.
    Wait(Micros),
    /// All commands are sent and answered.
    Nothing,
    /// The set-up has failed. The device is still read.
    Failed(Failure),
}

impl<D: Decoder> HostEnd<D> {
    /// Returns the end for a device that gets these commands.
    pub fn new(decoder: D, script: Script) -> Self {
        Self {
            decoder,
            session: Session::new(script),
            command: Bytes::new(),
            written: 0,
        }
    }

    /// Returns the device's decoder.
    pub const fn decoder(&self) -> &D {
        &self.decoder
    }

    /// Returns whether all commands are sent, see [`Session::is_complete`].
    pub fn is_complete(&self) -> bool {
        self.written >= self.command.len() && self.session.is_complete()
    }

    /// Sends another script from now on, such as one to stop, after any command under way.
    pub fn say(&mut self, script: Script) {
        self.session = Session::new(script);
    }

    /// Feeds the decoder the bytes that the port has received by `now`, `most` or a few more, then
    /// writes the next command as far as the port takes it. Never waits; call it again soon, and
    /// after [`Due::Room`] once the port has room.
    ///
    /// # Errors
    /// Those of the port: reading as [`drain`], writing with the rest left to the next call.
    pub fn serve<P>(
        &mut self,
        port: &mut P,
        now: Micros,
        most: usize,
        sink: &mut dyn FnMut(Event),
    ) -> Result<Due, P::Error>
    where
        P: Read + ReadReady + Write + WriteReady,
    {
        let session = &mut self.session;
        let before = self.decoder.counts().bytes;
        let read = drain(port, &mut self.decoder, now, most, &mut |event| {
            session.on_event(&event);
            sink(event);
        });
        let fed = self.decoder.counts().bytes.saturating_sub(before);
        session.on_bytes(usize::try_from(fed).unwrap_or(usize::MAX));
        read?;
        loop {
            while let Some(rest) = self.command.get(self.written..)
                && !rest.is_empty()
            {
                if !port.write_ready()? {
                    return Ok(Due::Room);
                }
                let written = port.write(rest)?;
                if written == 0 {
                    return Ok(Due::Room);
                }
                self.written = self.written.saturating_add(written);
                if self.written >= self.command.len() {
                    self.decoder.on_sent(&self.command, now);
                }
            }
            match self.session.poll(now) {
                Action::Send(bytes) => {
                    self.command.clear();
                    // A script's commands are no longer.
                    let _ = self.command.extend_from_slice(bytes);
                    self.written = 0;
                }
                Action::Speed(baud) => return Ok(Due::Speed(baud)),
                Action::Wait(until) => return Ok(Due::Wait(until)),
                Action::Done => return Ok(Due::Nothing),
                Action::Failed(failure) => return Ok(Due::Failed(failure)),
            }
        }
    }
}

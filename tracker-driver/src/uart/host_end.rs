//! The host's end of a line: a tracker is told what to send, and read, in one step of a
//! firmware's loop.

use super::drain;
use crate::command::{Action, Bytes, Failure, Script, Session};
use crate::decoder::{Decoder, Event};
use crate::time::Micros;
use embedded_io::{Read, ReadReady, Write, WriteReady};

/// A decoder and what is said to its device, at a port, served without waiting.
#[derive(Debug, Clone)]
pub struct HostEnd<D> {
    decoder: D,
    session: Session,
    /// A command that the port has not taken whole, and how many of its bytes it has.
    command: Bytes,
    written: usize,
}

/// What is due after a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Due {
    /// The port is full; the rest of a command waits for it.
    Room,
    /// The caller changes the line to this speed, baud, once what was written is out
    /// (`embedded_io::Write::flush` waits for that), before the next step.
    Speed(u32),
    /// Nothing is to be said before this time, unless something comes in.
    Wait(Micros),
    /// All was said and answered.
    Nothing,
    /// The device does not do as it was told. It is read all the same.
    Failed(Failure),
}

impl<D: Decoder> HostEnd<D> {
    /// The end for a device that is to be told this.
    pub fn new(decoder: D, script: Script) -> Self {
        Self {
            decoder,
            session: Session::new(script),
            command: Bytes::new(),
            written: 0,
        }
    }

    /// What reads the device.
    pub const fn decoder(&self) -> &D {
        &self.decoder
    }

    /// Whether nothing is left to be said, see [`Session::has_said_all`].
    pub fn has_said_all(&self) -> bool {
        self.written >= self.command.len() && self.session.has_said_all()
    }

    /// Says something else from now on, such as to stop, after a command that was begun.
    pub fn say(&mut self, script: Script) {
        self.session = Session::new(script);
    }

    /// One step: feeds the decoder what the port has received by `now`, `most` bytes or a few
    /// more, then writes what is due as far as the port takes it. It never waits; call it again
    /// before long, and after [`Due::Room`] once the port has room.
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
                    // No command of a script is longer.
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

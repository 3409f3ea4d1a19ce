//! Ports for tests.

use embedded_io::{ErrorKind, ErrorType, Read, ReadReady, Write, WriteReady};
use std::collections::VecDeque;

/// One end of a line that takes `room` more bytes.
#[derive(Default)]
pub(super) struct End {
    pub(super) received: VecDeque<u8>,
    pub(super) sent: VecDeque<u8>,
    pub(super) room: usize,
    pub(super) broken: bool,
    pub(super) ended: bool,
}

impl ErrorType for End {
    type Error = ErrorKind;
}

impl ReadReady for End {
    fn read_ready(&mut self) -> Result<bool, ErrorKind> {
        Ok(self.ended || !self.received.is_empty())
    }
}

impl Read for End {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize, ErrorKind> {
        if self.broken {
            return Err(ErrorKind::BrokenPipe);
        }
        assert!(
            self.ended || !self.received.is_empty(),
            "the port was read while it was not ready"
        );
        let count = buffer.len().min(self.received.len());
        for byte in &mut buffer[..count] {
            *byte = self.received.pop_front().unwrap();
        }
        Ok(count)
    }
}

impl WriteReady for End {
    fn write_ready(&mut self) -> Result<bool, ErrorKind> {
        Ok(self.room > 0 || self.broken)
    }
}

impl Write for End {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, ErrorKind> {
        if self.broken {
            return Err(ErrorKind::BrokenPipe);
        }
        assert!(self.room > 0, "the port was written while it was not ready");
        let count = bytes.len().min(self.room);
        self.sent.extend(&bytes[..count]);
        self.room -= count;
        Ok(count)
    }

    fn flush(&mut self) -> Result<(), ErrorKind> {
        Ok(())
    }
}

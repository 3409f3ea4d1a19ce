//! Waiting for a port's bytes by its descriptor.

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{Mode, OFlags};
use rustix::termios::isatty;
use std::fs::File;
use std::io::{self, Read};
use std::time::Duration;

/// Returns the port, to be read without waiting; [`io::ErrorKind::InvalidInput`] if it is none.
pub(super) fn open(path: &str) -> io::Result<File> {
    let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
    let port = File::from(rustix::fs::open(path, flags, Mode::empty())?);
    if !isatty(&port) {
        let what = "it is not a serial port";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, what));
    }
    Ok(port)
}

/// Returns what came in after a wait; [`io::ErrorKind::TimedOut`] if nothing. Takes no memory.
pub(super) fn read(port: &mut File, buffer: &mut [u8], wait: Duration) -> io::Result<usize> {
    let wait = Timespec {
        tv_sec: wait.as_secs() as i64,
        tv_nsec: wait.subsec_nanos().into(),
    };
    let mut ready = [PollFd::new(&*port, PollFlags::IN)];
    match poll(&mut ready, Some(&wait))? {
        0 => Err(io::ErrorKind::TimedOut.into()),
        _ => port.read(buffer),
    }
}

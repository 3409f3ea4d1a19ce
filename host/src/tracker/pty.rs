//! A pseudo-terminal as the serial port of a simulated device.

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{OFlags, fcntl_getfl, fcntl_setfl};
use rustix::io::Errno;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};
use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::os::fd::AsFd;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};

/// The device's end of a line; the other end has a path.
#[derive(Debug)]
pub struct Pty {
    device: File,
    /// The other end, held open so that the line stays while nobody reads it.
    line: Option<File>,
    /// Bytes still to send of a message that was sent in part.
    rest: Vec<u8>,
    name: PathBuf,
    link: PathBuf,
}

impl Pty {
    /// Opens a line and names its other end `link`. A dangling link is replaced.
    ///
    /// # Errors
    /// Errors of the system; [`io::ErrorKind::ResourceBusy`] where `link` leads to something,
    /// such as the line of another device; [`io::ErrorKind::AlreadyExists`] where it is no
    /// link.
    pub fn open(link: &Path) -> io::Result<Self> {
        let target = fs::read_link(link).ok();
        // A line's name is gone as soon as its device is.
        if let Some(target) = target.as_ref().filter(|_| link.exists()) {
            let busy = format!("it is a link to {}, which is in use", target.display());
            return Err(io::Error::new(io::ErrorKind::ResourceBusy, busy));
        }
        let device = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY)?;
        grantpt(&device)?;
        unlockpt(&device)?;
        let name = ptsname(&device, Vec::new())?;
        let name = PathBuf::from(name.to_string_lossy().into_owned());
        let flags = fcntl_getfl(&device)?;
        fcntl_setfl(&device, flags | OFlags::NONBLOCK)?;
        let line = other_end(&name)?;
        // Bytes, not lines, and none of them sent back.
        let mut termios = tcgetattr(line.as_fd())?;
        termios.make_raw();
        tcsetattr(line.as_fd(), OptionalActions::Now, &termios)?;
        if target.is_some() {
            fs::remove_file(link)?;
        }
        symlink(&name, link)?;
        Ok(Self {
            device: device.into(),
            line: Some(line),
            rest: Vec::new(),
            name,
            link: link.to_owned(),
        })
    }

    /// Returns the system's path of the other end.
    pub fn name(&self) -> &Path {
        &self.name
    }

    /// Returns the speed that the other end is set to, baud. It does not slow the line down.
    ///
    /// # Errors
    /// Errors of the system.
    pub fn speed(&self) -> io::Result<u32> {
        Ok(tcgetattr(self.device.as_fd())?.output_speed())
    }

    /// Closes the other end, so that [`is_read`](Self::is_read) sees other readers.
    pub fn release(&mut self) {
        self.line = None;
    }

    /// Opens the other end again where its reader allows: the line outlives that.
    pub fn hold(&mut self) {
        if self.line.is_none() {
            self.line = other_end(&self.name).ok();
        }
    }

    /// Returns whether the other end is open: by a reader, after [`release`](Self::release).
    ///
    /// # Errors
    /// Errors of the system.
    pub fn is_read(&self) -> io::Result<bool> {
        let at_once = Timespec::default();
        let mut ready = [PollFd::new(&self.device, PollFlags::empty())];
        poll(&mut ready, Some(&at_once))?;
        Ok(!ready[0].revents().contains(PollFlags::HUP))
    }

    /// Sends bytes without waiting, and returns whether it did: not where the line is full,
    /// as when nobody reads. What fits only in part is completed before anything else.
    ///
    /// # Errors
    /// Errors of the system.
    pub fn send(&mut self, bytes: &[u8]) -> io::Result<bool> {
        let before = self.write(&self.rest)?;
        self.rest.drain(..before);
        if !self.rest.is_empty() {
            return Ok(false);
        }
        let sent = self.write(bytes)?;
        if sent > 0 {
            self.rest.extend_from_slice(&bytes[sent..]);
        }
        Ok(sent > 0 || bytes.is_empty())
    }

    fn write(&self, bytes: &[u8]) -> io::Result<usize> {
        match (&self.device).write(bytes) {
            Err(error) if is_wait(&error) => Ok(0),
            written => written,
        }
    }

    /// Reads what the other end has sent; returns how many bytes.
    ///
    /// # Errors
    /// Errors of the system.
    pub fn receive(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self.device.read(buffer) {
            Err(error) if is_wait(&error) => Ok(0),
            read => read,
        }
    }
}

impl Drop for Pty {
    fn drop(&mut self) {
        // Another device may have taken the name.
        if fs::read_link(&self.link).is_ok_and(|to| to == self.name) {
            let _ = fs::remove_file(&self.link);
        }
    }
}

fn other_end(name: &Path) -> io::Result<File> {
    let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC;
    Ok(rustix::fs::open(name, flags, rustix::fs::Mode::empty())?.into())
}

/// Returns whether nobody reads or writes at the moment; without any reader the error is `EIO`.
fn is_wait(error: &io::Error) -> bool {
    use io::ErrorKind::{Interrupted, WouldBlock};
    let nobody = error.raw_os_error() == Some(Errno::IO.raw_os_error());
    nobody || matches!(error.kind(), WouldBlock | Interrupted)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_pass_both_ways_and_are_sent_whole() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("tracker");
        let mut pty = Pty::open(&path).unwrap();
        let mut other = fs::OpenOptions::new();
        let mut other = other.read(true).write(true).open(&path).unwrap();
        other.write_all(b"c\r\x03").unwrap();
        let mut buffer = [0; 16];
        assert_eq!(pty.receive(&mut buffer).unwrap(), 3);
        assert_eq!(&buffer[..3], b"c\r\x03");
        let all: Vec<u8> = (0..=255).collect();
        let (mut found, mut taken) = (vec![0; 256], 0);
        // Nobody reads: the line fills up without waiting.
        while pty.send(&all).unwrap() {
            taken += 1;
        }
        for n in 0..taken {
            if n == taken - 1 {
                // Now there is room for the rest of the last one.
                assert!(pty.send(&[7]).unwrap());
            }
            other.read_exact(&mut found).unwrap();
            assert_eq!(found, all, "{n} of {taken}");
        }
        other.read_exact(&mut found[..1]).unwrap();
        assert_eq!(found[0], 7);
    }

    #[test]
    fn a_name_stays_another_devices_and_a_file_is_not_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("tracker");
        let pty = Pty::open(&path).unwrap();
        fs::remove_file(&path).unwrap();
        let next = Pty::open(&path).unwrap();
        drop(pty);
        assert_eq!(fs::read_link(&path).unwrap(), next.name());
        drop(next);
        fs::write(&path, "a file").unwrap();
        let error = Pty::open(&path).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::AlreadyExists);
    }
}

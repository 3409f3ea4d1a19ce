//! A pseudo-terminal: a serial port without a wire, for a simulated device.

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

/// The device's end of a line whose other end has a path.
#[derive(Debug)]
pub struct Pty {
    device: File,
    /// Held open, so that the line stays while nobody reads it.
    line: Option<File>,
    /// The rest of what there was room for only in part.
    rest: Vec<u8>,
    name: PathBuf,
    link: Option<PathBuf>,
}

impl Pty {
    /// A line, and `link` as a name for its other end. A link that was left
    /// over and leads nowhere gives way, anything else does not.
    ///
    /// # Errors
    /// Those of the system; [`io::ErrorKind::ResourceBusy`] where `link` leads
    /// to something, such as the line of another device, and
    /// [`io::ErrorKind::AlreadyExists`] where it is something else than a link.
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
            link: Some(link.to_owned()),
        })
    }

    /// The other end's own path.
    pub fn name(&self) -> &Path {
        &self.name
    }

    /// The speed that the other end is set to, baud: a line without a wire is as
    /// fast at any.
    ///
    /// # Errors
    /// Those of the system.
    pub fn speed(&self) -> io::Result<u32> {
        Ok(tcgetattr(self.device.as_fd())?.output_speed())
    }

    /// Lets go of the other end, so that [`is_read`](Self::is_read) can tell whether
    /// somebody else holds it.
    pub fn release(&mut self) {
        self.line = None;
    }

    /// Holds the other end open again, as far as whoever reads it lets others have it:
    /// the line stays when its reader goes.
    pub fn hold(&mut self) {
        if self.line.is_none() {
            self.line = other_end(&self.name).ok();
        }
    }

    /// Whether somebody holds the other end open: a reader, once it was released.
    ///
    /// # Errors
    /// Those of the system.
    pub fn is_read(&self) -> io::Result<bool> {
        let at_once = Timespec::default();
        let mut ready = [PollFd::new(&self.device, PollFlags::empty())];
        poll(&mut ready, Some(&at_once))?;
        Ok(!ready[0].revents().contains(PollFlags::HUP))
    }

    /// Sends it whole, or not at all where there is no room for more, as when nobody reads:
    /// a line does not wait. What there is room for only in part is sent in part, and its
    /// rest before anything else. Whether it was sent.
    ///
    /// # Errors
    /// Those of the system.
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

    /// Writes what there is room for, and says how much.
    fn write(&self, bytes: &[u8]) -> io::Result<usize> {
        match (&self.device).write(bytes) {
            Err(error) if is_wait(&error) => Ok(0),
            written => written,
        }
    }

    /// What was said at the other end since; 0 where nothing was.
    ///
    /// # Errors
    /// Those of the system.
    pub fn receive(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self.device.read(buffer) {
            Err(error) if is_wait(&error) => Ok(0),
            read => read,
        }
    }
}

impl Drop for Pty {
    fn drop(&mut self) {
        // Another device may have taken the name over.
        if let Some(link) = self.link.take()
            && fs::read_link(&link).is_ok_and(|to| to == self.name)
        {
            let _ = fs::remove_file(link);
        }
    }
}

fn other_end(name: &Path) -> io::Result<File> {
    let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC;
    Ok(rustix::fs::open(name, flags, rustix::fs::Mode::empty())?.into())
}

/// Whether nobody reads, or says anything, at the moment; nobody at all is an error of
/// input and output.
fn is_wait(error: &io::Error) -> bool {
    use io::ErrorKind::{Interrupted, WouldBlock};
    let nobody = error.raw_os_error() == Some(Errno::IO.raw_os_error());
    nobody || matches!(error.kind(), WouldBlock | Interrupted)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reader_is_noticed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("tracker");
        let mut pty = Pty::open(&path).unwrap();
        assert!(pty.is_read().unwrap(), "its own end");
        pty.release();
        for _ in 0..2 {
            assert!(!pty.is_read().unwrap());
            assert_eq!(pty.receive(&mut [0; 8]).unwrap(), 0);
        }
        let open = || fs::OpenOptions::new().read(true).write(true).open(&path);
        let mut reader = open().unwrap();
        assert!(pty.is_read().unwrap());
        // Still raw: no echo, no lines.
        assert!(pty.send(b"\x03a\n").unwrap());
        let mut found = [0; 3];
        reader.read_exact(&mut found).unwrap();
        assert_eq!(&found, b"\x03a\n");
        assert_eq!(pty.receive(&mut [0; 8]).unwrap(), 0);
        // It goes, and another comes.
        drop(reader);
        assert!(!pty.is_read().unwrap());
        let reader = open().unwrap();
        assert!(pty.is_read().unwrap());
        // The line stays when that goes.
        pty.hold();
        drop(reader);
        assert!(pty.is_read().unwrap());
        assert!(pty.send(b"b").unwrap());
    }

    #[test]
    fn bytes_pass_both_ways_and_the_name_goes_with_the_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("tracker");
        let mut pty = Pty::open(&path).unwrap();
        let mut other = fs::OpenOptions::new();
        let mut other = other.read(true).write(true).open(&path).unwrap();
        let all: Vec<u8> = (0..=255).collect();
        assert!(pty.send(&all).unwrap());
        let mut found = vec![0; 256];
        other.read_exact(&mut found).unwrap();
        assert_eq!(found, all);
        let mut buffer = [0; 16];
        assert_eq!(pty.receive(&mut buffer).unwrap(), 0);
        other.write_all(b"c\r\x03").unwrap();
        assert_eq!(pty.receive(&mut buffer).unwrap(), 3);
        assert_eq!(&buffer[..3], b"c\r\x03");
        // Nobody reads: it does not wait, and what it took is whole.
        let mut taken = 0;
        while pty.send(&all).unwrap() {
            taken += 1;
        }
        for n in 0..taken {
            if n == taken - 1 {
                // There is room for the rest of the last one now.
                assert!(pty.send(&[7]).unwrap());
            }
            other.read_exact(&mut found).unwrap();
            assert_eq!(found, all, "{n} of {taken}");
        }
        other.read_exact(&mut found[..1]).unwrap();
        assert_eq!(found[0], 7);
        // Another device does not take the name over while this one is there.
        let error = Pty::open(&path).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::ResourceBusy);
        let name = pty.name().display().to_string();
        assert!(error.to_string().contains(&name), "{error}");
        assert_eq!(fs::read_link(&path).unwrap(), pty.name());
        // The name is gone with it, if it is still its own.
        fs::remove_file(&path).unwrap();
        let next = Pty::open(&path).unwrap();
        drop(pty);
        assert_eq!(fs::read_link(&path).unwrap(), next.name());
        drop(next);
        assert!(fs::symlink_metadata(&path).is_err());
        // One that leads nowhere, as one that was left over does, gives way.
        symlink("/dev/pts/gone", &path).unwrap();
        let line = Pty::open(&path).unwrap();
        assert_eq!(fs::read_link(&path).unwrap(), line.name());
        drop(line);
        fs::write(&path, "a file").unwrap();
        let error = Pty::open(&path).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::AlreadyExists);
    }
}

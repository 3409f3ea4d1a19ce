//! The board in QEMU: three serial ports over sockets, and a clock that counts
//! instructions.

use super::{FirmwareError, Image};
use defmt_decoder::{DecodeError, StreamDecoder, Table};
use std::io::{self, Read, Write};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

const PROGRAM: &str = "qemu-system-arm";
/// QEMU's option that loads a file at the address of the board's scene.
const LOADER: &str = "loader,addr=0x60000000,force-raw=on,file=";
const START: Duration = Duration::from_secs(20);
const WAIT: Duration = Duration::from_millis(2);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Port {
    Tracker,
    /// The display's port: reports out, orders in.
    Display,
    Log,
}

pub(super) struct Emulator {
    child: Child,
    /// The sockets of the ports, by the numbers of [`Port`].
    ports: Vec<UnixStream>,
    table: Option<Box<Table>>,
    /// Bytes of the log that are not decoded yet.
    said: Vec<u8>,
    /// Folder of the scene's file and the sockets.
    _folder: TempDir,
}

impl Emulator {
    pub(super) fn start(image: &Image, scene: &[u8]) -> Result<Self, FirmwareError> {
        let table = Table::parse(image.elf()).map_err(|e| {
            FirmwareError::other_sources(format!("the image's log cannot be read: {e}"))
        })?;
        let folder = tempfile::tempdir()?;
        let blob = folder.path().join("scene");
        std::fs::write(&blob, scene)?;
        let names = ["tracker", "display", "log"].map(|name| folder.path().join(name));
        let [a, b, c] = names.each_ref().map(PathBuf::as_path);
        let bind = UnixListener::bind::<&Path>;
        let listeners = [bind(a)?, bind(b)?, bind(c)?];
        let mut command = Command::new(PROGRAM);
        command
            .args("-M mps2-an500 -cpu cortex-m7 -icount shift=0".split(' '))
            .args("-display none -monitor none".split(' '))
            .arg("-device")
            .arg(with_path(LOADER, &blob))
            .arg("-kernel")
            .arg(image.path());
        for name in &names {
            command.arg("-serial").arg(with_path("unix:", name));
        }
        let child = command
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(|reason| {
                FirmwareError::new(
                    format!("{PROGRAM} does not start: {reason}"),
                    "install it (on Debian and Ubuntu: apt-get install qemu-system-arm)",
                )
            })?;
        let mut emulator = Self {
            child,
            ports: Vec::new(),
            table: table.map(Box::new),
            said: Vec::new(),
            _folder: folder,
        };
        for listener in &listeners {
            let port = emulator.accept(listener)?;
            port.set_nonblocking(true)?;
            emulator.ports.push(port);
        }
        Ok(emulator)
    }

    fn accept(&mut self, listener: &UnixListener) -> Result<UnixStream, FirmwareError> {
        listener.set_nonblocking(true)?;
        let since = Instant::now();
        loop {
            match listener.accept() {
                Ok((stream, _)) => return Ok(stream),
                Err(error) if error.kind() != io::ErrorKind::WouldBlock => return Err(error.into()),
                Err(_) => {}
            }
            if self.child.try_wait()?.is_some() || since.elapsed() > START {
                return Err(self.ended());
            }
            std::thread::sleep(WAIT);
        }
    }

    pub(super) fn send(&mut self, port: Port, bytes: &[u8]) -> Result<(), FirmwareError> {
        let mut left = bytes;
        let since = Instant::now();
        while !left.is_empty() {
            match self.ports[port as usize].write(left) {
                Ok(sent) => left = left.get(sent..).unwrap_or_default(),
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => {
                    if since.elapsed() > START {
                        return Err(io::Error::from(io::ErrorKind::TimedOut).into());
                    }
                    std::thread::sleep(WAIT);
                }
                Err(_) => return Err(self.ended()),
            }
        }
        Ok(())
    }

    /// Returns the bytes that have come; waits a little if there are none.
    pub(super) fn receive(&mut self, port: Port) -> Result<Vec<u8>, FirmwareError> {
        let mut buffer = vec![0; 1 << 16];
        match self.ports[port as usize].read(&mut buffer) {
            Ok(0) => Err(self.ended()),
            Ok(count) => {
                buffer.truncate(count);
                Ok(buffer)
            }
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => {
                std::thread::sleep(WAIT);
                Ok(Vec::new())
            }
            Err(_) => Err(self.ended()),
        }
    }

    /// Returns the lines logged since the last call.
    pub(super) fn log(&mut self) -> Result<Vec<String>, FirmwareError> {
        let bytes = self.receive(Port::Log)?;
        self.said.extend_from_slice(&bytes);
        let Some(table) = &self.table else {
            return Ok(Vec::new());
        };
        let mut decoder: Box<dyn StreamDecoder + '_> = table.new_stream_decoder();
        decoder.received(&self.said);
        let mut lines = Vec::new();
        loop {
            match decoder.decode() {
                Ok(frame) => lines.push(frame.display(false).to_string()),
                Err(DecodeError::UnexpectedEof) => break,
                Err(DecodeError::Malformed) => lines.push("(a damaged line)".to_owned()),
            }
        }
        // An incomplete frame at the end is decoded with the bytes that follow it.
        let rest = self.said.iter().rposition(|&byte| byte == 0);
        self.said.drain(..rest.map_or(0, |end| end + 1));
        Ok(lines)
    }

    /// Returns an error with the output of an emulator that has ended or is stopped.
    fn ended(&mut self) -> FirmwareError {
        let _ = self.child.kill();
        let status = self.child.wait();
        let status = status.map_or_else(|e| e.to_string(), |s| s.to_string());
        let mut output = String::new();
        if let Some(stderr) = &mut self.child.stderr {
            // An output that cannot be read is left out.
            let _ = stderr.read_to_string(&mut output);
        }
        FirmwareError::new(
            format!("{PROGRAM} ended ({status}): {}", output.trim()),
            "is the image one for the board mps2-an500?",
        )
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        // The process may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn with_path(before: &str, path: &Path) -> std::ffi::OsString {
    let mut argument = std::ffi::OsString::from(before);
    argument.push(path);
    argument
}

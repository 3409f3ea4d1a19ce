//! Serial ports of a host, by `serialport`.

#[cfg(unix)]
mod input;

use core::fmt;
use serialport::{ClearBuffer, ErrorKind, SerialPort, SerialPortType};
use std::boxed::Box;
#[cfg(not(unix))]
use std::io::Read;
use std::io::{self, Write};
use std::string::String;
use std::time::Duration;
use std::vec::Vec;

/// How long [`Serial::read`] waits.
const READ_WAIT: Duration = Duration::from_millis(2);

/// A serial port: 8 bits, no parity, one stop bit, no handshake.
pub struct Serial {
    port: Box<dyn SerialPort>,
    /// The same port to read from: a wait in vain in `serialport` allocates.
    #[cfg(unix)]
    input: std::fs::File,
}

impl fmt::Debug for Serial {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Serial")
            .field("name", &self.port.name())
            .finish_non_exhaustive()
    }
}

impl Serial {
    /// Opens the port at `path`, for nobody else. What came in before is
    /// forgotten.
    ///
    /// # Errors
    /// [`io::ErrorKind::NotFound`] where there is no such port,
    /// [`io::ErrorKind::PermissionDenied`] where it may not be used,
    /// [`io::ErrorKind::ResourceBusy`] where somebody else has it,
    /// [`io::ErrorKind::InvalidInput`] where it is no port, and others of the system's.
    pub fn open(path: &str, baud: u32) -> io::Result<Self> {
        // What serialport makes of a failure does not tell these apart.
        #[cfg(not(unix))]
        std::fs::metadata(path)?;
        // Before serialport does, which keeps others out.
        #[cfg(unix)]
        let input = input::open(path)?;
        let port = serialport::new(path, baud).timeout(READ_WAIT).open();
        let port = port.map_err(|error| match error.kind() {
            ErrorKind::Io(kind) => io::Error::new(kind, error.description),
            ErrorKind::NoDevice => io::Error::new(io::ErrorKind::ResourceBusy, error.description),
            ErrorKind::InvalidInput => {
                io::Error::new(io::ErrorKind::InvalidInput, error.description)
            }
            ErrorKind::Unknown => io::Error::other(error.description),
        })?;
        port.clear(ClearBuffer::Input)?;
        Ok(Self {
            port,
            #[cfg(unix)]
            input,
        })
    }

    /// What has come in, after a wait of 2 ms at most for some; 0 where
    /// nothing has. A byte that comes in ends the wait at once; on Unix it takes no
    /// memory.
    ///
    /// # Errors
    /// Those of the system: the port is gone.
    pub fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        #[cfg(unix)]
        let read = input::read(&mut self.input, buffer, READ_WAIT);
        #[cfg(not(unix))]
        let read = self.port.read(buffer);
        match read {
            // A port that is there never is at its end.
            Ok(0) => Err(io::ErrorKind::BrokenPipe.into()),
            Err(error) if is_wait(&error) => Ok(0),
            read => read,
        }
    }

    /// Sends all of it.
    ///
    /// # Errors
    /// Those of the system.
    pub fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.port.write_all(bytes)
    }

    /// Raises the line RTS (request to send) or lowers it; opening a port raises it
    /// on most systems.
    ///
    /// # Errors
    /// Those of the system: a pseudo-terminal, and some adapters, have no such line.
    pub fn set_rts(&mut self, high: bool) -> io::Result<()> {
        Ok(self.port.write_request_to_send(high)?)
    }

    /// Changes the speed once everything sent is out.
    ///
    /// # Errors
    /// Those of the system, above all a speed that the port does not have.
    pub fn set_speed(&mut self, baud: u32) -> io::Result<()> {
        self.port.flush()?;
        Ok(self.port.set_baud_rate(baud)?)
    }
}

fn is_wait(error: &io::Error) -> bool {
    use io::ErrorKind::{Interrupted, TimedOut, WouldBlock};
    matches!(error.kind(), TimedOut | WouldBlock | Interrupted)
}

/// A port that a host has.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Port {
    /// Its path, or its name.
    pub path: String,
    /// Vendor and product, where it is on USB.
    pub usb_id: Option<(u16, u16)>,
    /// What the device calls itself.
    pub product: Option<String>,
}

/// The ports of this host, in the order of their names.
///
/// # Errors
/// Those of the system.
pub fn ports() -> io::Result<Vec<Port>> {
    let found = serialport::available_ports()?;
    let mut ports: Vec<_> = found
        .into_iter()
        .map(|port| {
            let usb = match port.port_type {
                SerialPortType::UsbPort(usb) => Some(usb),
                _ => None,
            };
            Port {
                path: port.port_name.clone(),
                usb_id: usb.as_ref().map(|usb| (usb.vid, usb.pid)),
                product: usb.and_then(|usb| usb.product),
            }
        })
        .collect();
    ports.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(ports)
}

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

/// Longest wait of [`Serial::read`].
const READ_WAIT: Duration = Duration::from_millis(2);

/// A serial port: 8 bits, no parity, one stop bit, no handshake.
pub struct Serial {
    port: Box<dyn SerialPort>,
    /// The same port for reading: a timeout in `serialport` would allocate.
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
    /// Opens the port at `path` for exclusive use. Bytes that came in before are
    /// dropped.
    ///
    /// # Errors
    /// [`io::ErrorKind::NotFound`] if there is no such port,
    /// [`io::ErrorKind::PermissionDenied`] if the user may not use it,
    /// [`io::ErrorKind::ResourceBusy`] if another program uses it,
    /// [`io::ErrorKind::InvalidInput`] if it is not a port, and I/O errors from the system.
    pub fn open(path: &str, baud: u32) -> io::Result<Self> {
        // Errors of serialport do not distinguish these.
        #[cfg(not(unix))]
        std::fs::metadata(path)?;
        // Tried before serialport, whose open locks the port.
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

    /// Reads the bytes that have come in, and returns their number: 0 if none came
    /// within 2 ms. A byte that comes in ends the wait at once. Allocates nothing on
    /// Unix.
    ///
    /// # Errors
    /// I/O errors from the system: the port is gone.
    pub fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        #[cfg(unix)]
        let read = input::read(&mut self.input, buffer, READ_WAIT);
        #[cfg(not(unix))]
        let read = self.port.read(buffer);
        match read {
            // A port that is present has no end of file.
            Ok(0) => Err(io::ErrorKind::BrokenPipe.into()),
            Err(error) if is_wait(&error) => Ok(0),
            read => read,
        }
    }

    /// Sends all bytes.
    ///
    /// # Errors
    /// I/O errors from the system.
    pub fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.port.write_all(bytes)
    }

    /// Raises the line RTS (request to send) or lowers it; opening a port raises it
    /// on most systems.
    ///
    /// # Errors
    /// I/O errors from the system: a pseudo-terminal, and some adapters, have no such line.
    pub fn set_rts(&mut self, high: bool) -> io::Result<()> {
        Ok(self.port.write_request_to_send(high)?)
    }

    /// Changes the speed once all bytes are sent.
    ///
    /// # Errors
    /// I/O errors from the system, above all for a speed that the port does not have.
    pub fn set_speed(&mut self, baud: u32) -> io::Result<()> {
        self.port.flush()?;
        Ok(self.port.set_baud_rate(baud)?)
    }
}

fn is_wait(error: &io::Error) -> bool {
    use io::ErrorKind::{Interrupted, TimedOut, WouldBlock};
    matches!(error.kind(), TimedOut | WouldBlock | Interrupted)
}

/// A port of this host.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Port {
    /// The port's path, or its name.
    pub path: String,
    /// Vendor and product numbers of a USB device.
    pub usb_id: Option<(u16, u16)>,
    /// The product's name, by the device.
    pub product: Option<String>,
}

/// Returns the ports of this host, in the order of their names.
///
/// # Errors
/// I/O errors from the system.
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

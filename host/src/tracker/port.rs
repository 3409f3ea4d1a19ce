//! An open device, serial or HID.

use super::notice::{Features, LiveError};
use super::spec::SerialSpec;
use shisen_tracker::decoder::Decoder;
use shisen_tracker::hid::device::Device;
use shisen_tracker::serial::Serial;
use std::io;

pub(super) enum Port {
    Serial(Serial),
    Hid(Device),
}

impl Port {
    /// Reads what comes within 2 ms; returns how many bytes.
    pub(super) fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::Serial(port) => port.read(buffer),
            Self::Hid(device) => device.read(buffer),
        }
    }
}

pub(super) struct Plugged {
    pub(super) port: Port,
    pub(super) path: String,
    pub(super) decoder: Box<dyn Decoder + Send>,
    /// A HID device's report descriptor, where its decoder needs it.
    pub(super) descriptor: Vec<u8>,
    /// What an eye tracker said of itself when it was opened.
    pub(super) features: Option<Features>,
}

/// Opens a serial port, its lines set as the specification has them.
pub(super) fn open_serial(spec: &SerialSpec) -> Result<Plugged, LiveError> {
    let refused = |reason| LiveError::Open(spec.path.clone(), reason);
    let mut port = Serial::open(&spec.path, spec.baud).map_err(refused)?;
    set_rts(spec, |high| port.set_rts(high)).map_err(refused)?;
    let decoder = spec.protocol.decoder();
    Ok(Plugged {
        port: Port::Serial(port),
        path: spec.path.clone(),
        decoder: decoder.ok_or_else(|| refused(io::ErrorKind::Unsupported.into()))?,
        descriptor: Vec::new(),
        features: None,
    })
}

/// Sets a line's RTS; a port without RTS is an error only where the specification asks for it.
pub(super) fn set_rts(
    spec: &SerialSpec,
    mut set: impl FnMut(bool) -> io::Result<()>,
) -> io::Result<()> {
    if let Some(high) = spec.rts {
        return set(high).map_err(|reason| {
            let text = format!("its RTS cannot be set ({reason}); leave rts out");
            io::Error::new(reason.kind(), text)
        });
    }
    if let Some(high) = spec.protocol.protocol().rts() {
        let _ = set(high);
    }
    Ok(())
}

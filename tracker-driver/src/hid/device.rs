//! Human interface devices of a host, by `hidapi`.

use super::usages::PAGE;
use hidapi::{HidApi, HidDevice, HidError};
use std::ffi::CString;
use std::io;
use std::string::String;
use std::vec::Vec;

/// How long [`Device::read`] waits, milliseconds.
const READ_WAIT: i32 = 2;

/// Most bytes of a report descriptor: hidapi reads no more.
const MOST_DESCRIPTOR_BYTES: usize = hidapi::MAX_REPORT_DESCRIPTOR_SIZE;

/// A device of this host.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Found {
    /// The path that [`Device::open`] takes.
    pub path: String,
    /// USB vendor and product numbers.
    pub id: (u16, u16),
    /// The product's name, by the device.
    pub product: String,
    /// The serial number; empty if the device has none.
    pub serial_number: String,
    /// Usage pages and usages of the device's collections.
    pub usages: Vec<(u16, u16)>,
}

impl Found {
    /// Returns whether its usages are those of an eye or head tracker.
    pub fn is_tracker(&self) -> bool {
        self.usages.iter().any(|&(page, _)| page == PAGE)
    }
}

/// Returns the devices of this host, in the order of their paths.
///
/// # Errors
/// I/O errors from the system; a host without such devices has an empty list.
pub fn devices() -> io::Result<Vec<Found>> {
    let api = HidApi::new().map_err(system)?;
    let mut devices: Vec<Found> = Vec::new();
    for info in api.device_list() {
        let path = info.path().to_string_lossy().into_owned();
        let usage = (info.usage_page(), info.usage());
        if let Some(known) = devices.iter_mut().find(|device| device.path == path) {
            known.usages.push(usage);
            continue;
        }
        devices.push(Found {
            path,
            id: (info.vendor_id(), info.product_id()),
            product: info.product_string().unwrap_or_default().into(),
            serial_number: info.serial_number().unwrap_or_default().into(),
            usages: [usage].into(),
        });
    }
    devices.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(devices)
}

/// An open device.
#[derive(Debug)]
pub struct Device {
    device: HidDevice,
}

impl Device {
    /// Opens the device at `path`.
    ///
    /// # Errors
    /// [`io::ErrorKind::NotFound`] without a device there,
    /// [`io::ErrorKind::PermissionDenied`] if the user may not use it, and
    /// other I/O errors from the system.
    pub fn open(path: &str) -> io::Result<Self> {
        // hidapi passes on the text of a failure, not its kind.
        #[cfg(unix)]
        std::fs::OpenOptions::new()
            .read(true)
            .write(true)
            .open(path)?;
        let name = CString::new(path).map_err(|_| io::ErrorKind::InvalidInput)?;
        let api = HidApi::new().map_err(system)?;
        let device = api.open_path(&name).map_err(system)?;
        Ok(Self { device })
    }

    /// Returns the report descriptor.
    ///
    /// # Errors
    /// I/O errors from the system.
    pub fn descriptor(&self) -> io::Result<Vec<u8>> {
        let mut bytes = std::vec![0; MOST_DESCRIPTOR_BYTES];
        let length = self.device.get_report_descriptor(&mut bytes);
        bytes.truncate(length.map_err(system)?);
        Ok(bytes)
    }

    /// Reads the next input report, its id in front where the device uses ids, and
    /// returns its length: 0 if none came within 2 ms.
    ///
    /// # Errors
    /// I/O errors from the system: the device is gone.
    pub fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self.device.read_timeout(buffer, READ_WAIT) {
            Err(HidError::IoError { error }) if error.kind() == io::ErrorKind::Interrupted => Ok(0),
            read => read.map_err(system),
        }
    }

    /// Sends the feature report `id`: its bytes, its id in front where the device
    /// uses ids, which are above 0.
    ///
    /// # Errors
    /// I/O errors from the system: the device refuses the report, or is gone.
    pub fn set_feature(&mut self, id: u8, report: &[u8]) -> io::Result<()> {
        let sent = as_sent(id, report);
        self.device.send_feature_report(&sent).map_err(system)
    }

    /// Reads the feature report `id` of `length` bytes at most: its bytes, its id
    /// in front where the device uses ids.
    ///
    /// # Errors
    /// I/O errors from the system: the device has no such report, or is gone.
    pub fn feature(&mut self, id: u8, length: usize) -> io::Result<Vec<u8>> {
        let mut report = as_sent(id, &[]);
        report.resize(room(id, length), 0);
        if let Some(first) = report.first_mut() {
            *first = id;
        }
        let read = self.device.get_feature_report(&mut report);
        report.truncate(read.map_err(system)?);
        Ok(as_read(id, length, report))
    }
}

/// Returns the report with an id in front, as the system requires: 0 for a report without one.
fn as_sent(id: u8, report: &[u8]) -> Vec<u8> {
    let none: &[u8] = if id == 0 { &[0] } else { &[] };
    [none, report].concat()
}

/// Returns the buffer length for a report of `length` bytes.
fn room(id: u8, length: usize) -> usize {
    length.max(1) + usize::from(id == 0)
}

/// Removes the zero that most systems put before a report without an id.
fn as_read(id: u8, length: usize, mut report: Vec<u8>) -> Vec<u8> {
    if id == 0 && report.len() > length {
        report.remove(0);
    }
    report
}

fn system(error: HidError) -> io::Error {
    match error {
        HidError::IoError { error } => error,
        other => io::Error::other(other),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reports_without_an_id_have_a_zero_before_them_on_the_way() {
        assert_eq!(as_sent(7, &[7, 1]), [7, 1]);
        assert_eq!(as_sent(0, &[1]), [0, 1]);
        assert_eq!((room(7, 3), room(0, 3), room(7, 0)), (3, 4, 1));
        assert_eq!(as_read(7, 3, [7, 1, 2].into()), [7, 1, 2]);
        assert_eq!(as_read(0, 2, [0, 1, 2].into()), [1, 2]);
        // A report without the zero that most systems add, or a short one, stays as it is.
        assert_eq!(as_read(0, 2, [1, 2].into()), [1, 2]);
    }
}

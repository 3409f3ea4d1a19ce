//! Human interface devices of a host, by `hidapi`.

use super::usages::PAGE;
use hidapi::{HidApi, HidDevice, HidError};
use std::ffi::CString;
use std::io;
use std::string::String;
use std::vec::Vec;

/// How long [`Device::read`] waits, milliseconds.
const READ_WAIT: i32 = 2;

/// Most bytes of a report descriptor, which is what hidapi reads.
const MOST_DESCRIPTOR_BYTES: usize = hidapi::MAX_REPORT_DESCRIPTOR_SIZE;

/// A device that a host has.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Found {
    /// Its path.
    pub path: String,
    /// USB's vendor and product.
    pub id: (u16, u16),
    /// What it calls itself.
    pub product: String,
    /// Its serial number; empty where it has none.
    pub serial_number: String,
    /// Its collections' usage pages and usages.
    pub usages: Vec<(u16, u16)>,
}

impl Found {
    /// Whether it says of itself that it tracks eyes or heads.
    pub fn is_tracker(&self) -> bool {
        self.usages.iter().any(|&(page, _)| page == PAGE)
    }
}

/// The devices of this host, in the order of their paths.
///
/// # Errors
/// Those of the system; a host without such devices has an empty list.
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
pub struct Device {
    device: HidDevice,
}

impl Device {
    /// Opens the device at `path`.
    ///
    /// # Errors
    /// [`io::ErrorKind::NotFound`] where there is none,
    /// [`io::ErrorKind::PermissionDenied`] where it may not be used, and
    /// others of the system's.
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

    /// The report descriptor.
    ///
    /// # Errors
    /// Those of the system.
    pub fn descriptor(&self) -> io::Result<Vec<u8>> {
        let mut bytes = std::vec![0; MOST_DESCRIPTOR_BYTES];
        let length = self.device.get_report_descriptor(&mut bytes);
        bytes.truncate(length.map_err(system)?);
        Ok(bytes)
    }

    /// The next input report, its id in front where the device uses ids,
    /// after a wait of 2 ms at most; 0 where none has come.
    ///
    /// # Errors
    /// Those of the system: the device is gone.
    pub fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self.device.read_timeout(buffer, READ_WAIT) {
            Err(HidError::IoError { error }) if error.kind() == io::ErrorKind::Interrupted => Ok(0),
            read => read.map_err(system),
        }
    }

    /// Sends a feature report, its id in front (0 where it has none).
    ///
    /// # Errors
    /// Those of the system: the device refuses it, or is gone.
    pub fn set_feature(&mut self, report: &[u8]) -> io::Result<()> {
        self.device.send_feature_report(report).map_err(system)
    }

    /// Reads the feature report `id` into `report`: its bytes, its id among
    /// them.
    ///
    /// # Errors
    /// Those of the system: the device has none, or is gone.
    pub fn feature<'r>(&mut self, id: u8, report: &'r mut [u8]) -> io::Result<&'r [u8]> {
        if let Some(first) = report.first_mut() {
            *first = id;
        }
        let length = self.device.get_feature_report(report).map_err(system)?;
        Ok(report.get(..length).unwrap_or_default())
    }
}

fn system(error: HidError) -> io::Error {
    match error {
        HidError::IoError { error } => error,
        other => io::Error::other(other),
    }
}

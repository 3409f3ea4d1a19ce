//! Human interface devices: which one is meant, how it is read, and what it says of
//! itself.

use super::live::LiveError;
use super::spec::{HidName, HidSpec};
use shisen_tracker::decoder::Decoder;
use shisen_tracker::head::osvr_hdk;
use shisen_tracker::hid::device::{Device, Found, devices};
use shisen_tracker::hid::eye_tracker::{
    Axes, Capabilities, Configuration, EyeTracker, Mode, ReportError, Status,
};
use std::io;

/// A device that is open, where it is, and what reads it.
pub(super) struct Plugged {
    pub(super) device: Device,
    pub(super) path: String,
    pub(super) decoder: Box<dyn Decoder + Send>,
    /// Of an eye tracker: what it said of itself when it was opened.
    pub(super) features: Option<Features>,
}

/// What an eye tracker of usage page 0x12 says of itself in its feature reports.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Features {
    /// What it can do.
    pub capabilities: Option<Capabilities>,
    /// How it was set up.
    pub configuration: Option<Configuration>,
    /// How it is.
    pub status: Option<Status>,
    /// Reports that its descriptor has and that could not be read, and why.
    pub unread: Vec<String>,
    /// Why it did not take the request to send all that it has, if it was asked and
    /// did not.
    pub refused: Option<String>,
}

impl Features {
    /// Asks a device for them.
    fn of(device: &mut Device, tracker: &EyeTracker) -> Self {
        let [capabilities, configuration, status, _] = tracker.feature_reports();
        let mut unread = Vec::new();
        let mut said = |name, report: Option<(u8, usize)>| {
            let (id, bytes) = report?;
            let read = device.feature(id, bytes);
            read.map_err(|reason| unread.push(format!("{name} ({id:#04x}): {reason}")))
                .ok()
        };
        let [capabilities, configuration, status] = [
            ("capabilities", capabilities),
            ("configuration", configuration),
            ("status", status),
        ]
        .map(|(name, report)| said(name, report));
        let mut read = |error: ReportError| unread.push(error.to_string());
        Self {
            capabilities: capabilities
                .and_then(|bytes| tracker.capabilities(&bytes).map_err(&mut read).ok()),
            configuration: configuration
                .and_then(|bytes| tracker.configuration(&bytes).map_err(&mut read).ok()),
            status: status.and_then(|bytes| tracker.status(&bytes).map_err(&mut read).ok()),
            unread,
            refused: None,
        }
    }
}

/// What the eye tracker at a path says of itself; `None` of another device.
///
/// # Errors
/// Where the system does not let it be opened or described.
pub fn features(path: &str) -> io::Result<Option<Features>> {
    let mut device = Device::open(path)?;
    let tracker = EyeTracker::new(&device.descriptor()?, Axes::default());
    Ok(tracker.ok().map(|t| Features::of(&mut device, &t)))
}

/// Opens the device that is meant, asks an eye tracker what it is, and asks it to
/// send all that it has; one that takes no requests sends of itself, and one that
/// refuses may not.
pub(super) fn plug(spec: &HidSpec) -> Result<Plugged, LiveError> {
    let at = |path: &str| {
        let path = path.to_owned();
        move |reason| LiveError::Open { path, reason }
    };
    let all = devices().map_err(at("the list of HID devices"))?;
    let path = one_of(&all, &spec.name)?;
    let id = all.iter().find(|found| found.path == path);
    let id = id.map(|found| found.id);
    let mut device = Device::open(&path).map_err(at(&path))?;
    if id.is_some_and(|id| osvr_hdk::USB_IDS.contains(&id)) {
        return Ok(Plugged {
            device,
            path,
            decoder: Box::new(osvr_hdk::OsvrHdk::new()),
            features: None,
        });
    }
    let descriptor = device.descriptor().map_err(at(&path))?;
    let tracker = EyeTracker::new(&descriptor, spec.axes).map_err(|reason| LiveError::Layout {
        path: path.clone(),
        reason,
    })?;
    let mut features = Features::of(&mut device, &tracker);
    let [.., control] = tracker.feature_reports();
    if let (Some((id, _)), Some(request)) = (control, tracker.mode_request(Mode::ALL)) {
        let asked = device.set_feature(id, &request);
        features.refused = asked.err().map(|reason| reason.to_string());
    }
    Ok(Plugged {
        device,
        path,
        decoder: Box::new(tracker),
        features: Some(features),
    })
}

/// Vendor and product of the device that is meant, as far as that is plugged in.
pub(super) fn usb_id(name: &HidName) -> Option<(u16, u16)> {
    if let HidName::Id(vendor, product) = name {
        return Some((*vendor, *product));
    }
    let all = devices().ok()?;
    let path = one_of(&all, name).ok()?;
    let found = all.iter().find(|found| found.path == path)?;
    Some(found.id)
}

/// The path of the one device that is meant: of several with the same id, the
/// one that says it is a tracker.
fn one_of(all: &[Found], name: &HidName) -> Result<String, LiveError> {
    let same: Vec<&Found> = match name {
        HidName::Path(path) => return Ok(path.clone()),
        HidName::Id(vendor, product) => {
            let same = all.iter().filter(|found| found.id == (*vendor, *product));
            same.collect()
        }
        HidName::Usage { page, usage } => {
            let is = |&(p, u): &(u16, u16)| p == *page && usage.is_none_or(|usage| usage == u);
            let same = all.iter().filter(|found| found.usages.iter().any(is));
            same.collect()
        }
    };
    let trackers: Vec<&Found> = same.iter().copied().filter(|f| f.is_tracker()).collect();
    match (same.as_slice(), trackers.as_slice()) {
        ([], _) => Err(LiveError::NotFound { name: name.clone() }),
        ([one], _) | (_, [one]) => Ok(one.path.clone()),
        (several, _) => Err(LiveError::Several {
            name: name.clone(),
            paths: several.iter().map(|found| found.path.clone()).collect(),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(path: &str, id: (u16, u16), usages: &[(u16, u16)]) -> Found {
        Found {
            path: path.into(),
            id,
            product: String::new(),
            serial_number: String::new(),
            usages: usages.to_vec(),
        }
    }

    #[test]
    fn several_devices_are_listed_and_a_tracker_among_them_is_taken() {
        let id = (0x1532, 0x0B00);
        let name = HidName::Id(id.0, id.1);
        let mut all = vec![
            found("/dev/a", id, &[(1, 1)]),
            found("/dev/c", (1, 2), &[(0x12, 1)]),
        ];
        assert_eq!(one_of(&all, &name).unwrap(), "/dev/a");
        all.push(found("/dev/b", id, &[(1, 1)]));
        let error = one_of(&all, &name).unwrap_err();
        assert_eq!(error.to_string(), "2 devices are 1532:0b00: /dev/a, /dev/b");
        all.push(found("/dev/d", id, &[(0x12, 1)]));
        assert_eq!(one_of(&all, &name).unwrap(), "/dev/d");
        let error = one_of(&all, &HidName::Id(9, 9)).unwrap_err();
        assert!(error.to_string().contains("0009:0009"), "{error}");
    }

    #[test]
    fn a_device_is_found_by_what_it_is() {
        let page = |usage| HidName::Usage { page: 0x12, usage };
        let mut all = vec![
            found("/dev/a", (1, 1), &[(1, 6), (0x0C, 1)]),
            found("/dev/b", (1, 2), &[(1, 2), (0x12, 2)]),
        ];
        assert_eq!(one_of(&all, &page(None)).unwrap(), "/dev/b");
        assert_eq!(one_of(&all, &page(Some(2))).unwrap(), "/dev/b");
        let error = one_of(&all, &page(Some(1))).unwrap_err();
        let expected = "no HID device usage=0012:0001 is plugged in";
        assert_eq!(error.to_string(), expected);
        all.push(found("/dev/c", (1, 3), &[(0x12, 1)]));
        assert_eq!(one_of(&all, &page(Some(1))).unwrap(), "/dev/c");
        let error = one_of(&all, &page(None)).unwrap_err();
        let expected = "2 devices are usage=0012: /dev/b, /dev/c";
        assert_eq!(error.to_string(), expected);
    }
}

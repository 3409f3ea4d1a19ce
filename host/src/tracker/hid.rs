//! Human interface devices: which one a name means, and what an eye tracker says of itself.

use super::notice::{Features, LiveError};
use super::port::{Plugged, Port};
use super::spec::{HidName, HidSpec};
use shisen_tracker::decoder::Decoder;
use shisen_tracker::head::osvr_hdk;
use shisen_tracker::hid::device::{Device, Found, devices};
use shisen_tracker::hid::eye_tracker::{Axes, EyeTracker, Mode, ReportError};
use std::io;

fn read_features(device: &mut Device, tracker: &EyeTracker) -> Features {
    let mut unread = Vec::new();
    let [capabilities, configuration, status, _] = tracker.feature_reports();
    let mut read = |name, report: Option<(u8, usize)>| {
        let (id, bytes) = report?;
        let read = device.feature(id, bytes);
        read.map_err(|reason| unread.push(format!("{name} ({id:#04x}): {reason}")))
            .ok()
    };
    let capabilities = read("capabilities", capabilities);
    let configuration = read("configuration", configuration);
    let status = read("status", status);
    let mut note = |error: ReportError| unread.push(error.to_string());
    Features {
        capabilities: capabilities
            .and_then(|bytes| tracker.capabilities(&bytes).map_err(&mut note).ok()),
        configuration: configuration
            .and_then(|bytes| tracker.configuration(&bytes).map_err(&mut note).ok()),
        status: status.and_then(|bytes| tracker.status(&bytes).map_err(&mut note).ok()),
        unread,
        refused: None,
    }
}

/// Returns what the eye tracker at a path says of itself; `None` for another device.
pub(crate) fn features(path: &str) -> io::Result<Option<Features>> {
    let mut device = Device::open(path)?;
    let tracker = EyeTracker::new(&device.descriptor()?, Axes::default());
    Ok(tracker.ok().map(|t| read_features(&mut device, &t)))
}

/// Opens a device, and asks an eye tracker what it is and to send all that it has.
pub(super) fn plug(spec: &HidSpec) -> Result<Plugged, LiveError> {
    let at = |path: &str| {
        let path = path.to_owned();
        move |reason| LiveError::Open(path, reason)
    };
    let all = devices().map_err(at("the list of HID devices"))?;
    let path = one_of(&all, &spec.name)?;
    let mut device = Device::open(&path).map_err(at(&path))?;
    let found = all.iter().find(|found| found.path == path);
    let is_osvr = found.is_some_and(|found| osvr_hdk::USB_IDS.contains(&found.id));
    let mut descriptor = Vec::new();
    let (decoder, features): (Box<dyn Decoder + Send>, _) = if is_osvr {
        (Box::new(osvr_hdk::OsvrHdk::new()), None)
    } else {
        descriptor = device.descriptor().map_err(at(&path))?;
        let tracker = EyeTracker::new(&descriptor, spec.axes);
        let tracker = tracker.map_err(|reason| LiveError::Layout(path.clone(), reason))?;
        let mut features = read_features(&mut device, &tracker);
        let [.., control] = tracker.feature_reports();
        if let (Some((id, _)), Some(request)) = (control, tracker.mode_request(Mode::ALL)) {
            let asked = device.set_feature(id, &request);
            features.refused = asked.err().map(|reason| reason.to_string());
        }
        (Box::new(tracker), Some(features))
    };
    Ok(Plugged {
        port: Port::Hid(device),
        path,
        decoder,
        descriptor,
        features,
    })
}

/// Returns the vendor and product that a name means, as far as the device is plugged in.
pub(super) fn usb_id(name: &HidName) -> Option<(u16, u16)> {
    if let HidName::Id(vendor, product) = name {
        return Some((*vendor, *product));
    }
    let all = devices().ok()?;
    let path = one_of(&all, name).ok()?;
    let found = all.iter().find(|found| found.path == path)?;
    Some(found.id)
}

/// Returns the path of the one device with a name: among several, the one tracker.
fn one_of(all: &[Found], name: &HidName) -> Result<String, LiveError> {
    if let HidName::Path(path) = name {
        return Ok(path.clone());
    }
    let has_name = |found: &&Found| match name {
        HidName::Path(_) => false,
        HidName::Id(vendor, product) => found.id == (*vendor, *product),
        HidName::Usage { page, usage } => {
            let mut usages = found.usages.iter();
            usages.any(|(p, u)| p == page && usage.is_none_or(|usage| usage == *u))
        }
    };
    let same: Vec<&Found> = all.iter().filter(has_name).collect();
    let trackers: Vec<&Found> = same.iter().copied().filter(|f| f.is_tracker()).collect();
    match (same.as_slice(), trackers.as_slice()) {
        ([], _) => Err(LiveError::NotFound(name.clone())),
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

    #[test]
    fn a_name_means_one_device_or_says_which_there_are() {
        let found = |path: &str, id, usages: &[(u16, u16)]| Found {
            path: path.into(),
            id,
            product: String::new(),
            serial_number: String::new(),
            usages: usages.to_vec(),
        };
        let id = (0x1532, 0x0B00);
        let (same, page) = (HidName::Id(id.0, id.1), |usage| HidName::Usage {
            page: 0x12,
            usage,
        });
        let mut all = vec![
            found("a", id, &[(1, 6), (0x0C, 1)]),
            found("c", (1, 2), &[(0x12, 2)]),
        ];
        let mut check = |more: Option<Found>, name: &HidName, expected: Result<&str, &str>| {
            all.extend(more);
            let one = one_of(&all, name).map_err(|error| error.to_string());
            assert_eq!(one.as_deref().map_err(String::as_str), expected);
        };
        check(None, &same, Ok("a"));
        check(None, &page(None), Ok("c"));
        check(None, &page(Some(2)), Ok("c"));
        let missing = "no HID device usage=0012:0001 is plugged in";
        check(None, &page(Some(1)), Err(missing));
        let another = found("b", id, &[(1, 1)]);
        check(Some(another), &same, Err("2 devices are 1532:0b00: a, b"));
        // A tracker among several is the one.
        check(Some(found("d", id, &[(0x12, 1)])), &same, Ok("d"));
        check(None, &page(Some(1)), Ok("d"));
        check(None, &page(None), Err("2 devices are usage=0012: c, d"));
        let missing = "no HID device 0009:0009 is plugged in";
        check(None, &HidName::Id(9, 9), Err(missing));
    }
}

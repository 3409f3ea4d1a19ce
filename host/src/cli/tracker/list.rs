//! `shisen tracker list`: what is plugged in.

use super::features::FeatureReport;
use crate::cli::output::failure::Failure;
use crate::cli::output::{print, warn};
use crate::tracker::features;
use clap::Args;
use serde::Serialize;
use shisen_tracker::hid::device::{Found, devices};
use shisen_tracker::serial::ports;
use std::fmt;

/// Lists serial ports and HID devices
///
/// With --json, one object: serial (path, id (vendor:product, null where it is
/// not on USB) and product each) and hid (path, id, product, serial, usages
/// (page and usage), tracker (whether it says that it tracks eyes or heads,
/// usage page 0x12) and features each). Features is what such a tracker says of itself,
/// null where it is none or cannot be asked: capabilities (quality, `nearest_m`,
/// `best_m`, `furthest_m`, `widest_screen_m`, `highest_screen_m`), configuration
/// (manufacturer, product, `serial_number` and `manufacturer_date` of the display,
/// `screen_width_m`, `screen_height_m`), status (code, meaning, `rate_hz`), each null
/// where the device does not say it, unread (which reports could not be read, and
/// why) and refused (why it did not take the request to send all that it has; null
/// where it did, has no such request, or, as here, was not asked).
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Serialize)]
struct Report {
    serial: Vec<Port>,
    hid: Vec<Device>,
}

#[derive(Debug, Serialize)]
struct Port {
    path: String,
    id: Option<String>,
    product: Option<String>,
}

#[derive(Debug, Serialize)]
struct Device {
    path: String,
    id: String,
    product: String,
    serial: String,
    usages: Vec<(u16, u16)>,
    tracker: bool,
    features: Option<FeatureReport>,
}

fn hexadecimal((vendor, product): (u16, u16)) -> String {
    format!("{vendor:04x}:{product:04x}")
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    // A host without such devices may not even have the lists.
    let serial = ports().unwrap_or_else(|reason| {
        warn(&format!("the serial ports cannot be listed: {reason}"));
        Vec::new()
    });
    let hid = devices().unwrap_or_else(|reason| {
        warn(&format!("the HID devices cannot be listed: {reason}"));
        Vec::new()
    });
    let report = Report {
        serial: serial
            .into_iter()
            .map(|port| Port {
                path: port.path,
                id: port.usb_id.map(hexadecimal),
                product: port.product,
            })
            .collect(),
        hid: hid
            .into_iter()
            .map(|found| Device {
                tracker: found.is_tracker(),
                features: asked(&found),
                path: found.path,
                id: hexadecimal(found.id),
                product: found.product,
                serial: found.serial_number,
                usages: found.usages,
            })
            .collect(),
    };
    print(&report, arguments.json)
}

/// What a tracker says of itself.
fn asked(found: &Found) -> Option<FeatureReport> {
    if !found.is_tracker() {
        return None;
    }
    let said = features(&found.path).unwrap_or_else(|reason| {
        let path = &found.path;
        warn(&format!("{path} cannot be asked what it can do: {reason}"));
        None
    });
    said.as_ref().map(FeatureReport::from)
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.serial.is_empty() && self.hid.is_empty() {
            return f.write_str("no serial port and no HID device");
        }
        let mut lines = Vec::new();
        for port in &self.serial {
            let id = port.id.as_deref().unwrap_or("-");
            let product = port.product.as_deref().unwrap_or("");
            lines.push(format!("serial:{}  {id}  {product}", port.path));
        }
        for device in &self.hid {
            let mark = if device.tracker { "  [tracker]" } else { "" };
            let Device {
                path, id, product, ..
            } = device;
            lines.push(format!("hid:{path}  {id}  {product}{mark}"));
            if let Some(features) = &device.features {
                lines.push(format!("  {features}"));
            }
        }
        f.write_str(&lines.join("\n"))
    }
}

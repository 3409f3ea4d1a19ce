//! `shisen tracker list`: serial ports and HID devices.

use super::features::FeatureReport;
use crate::cli::prelude::*;
use crate::tracker::features;
use shisen_tracker::hid::device::{Found, devices};
use shisen_tracker::serial::ports;

/// Lists serial ports and HID devices
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// Serial ports and HID devices.
#[derive(Debug, Serialize, JsonSchema)]
pub(in crate::cli) struct Report {
    /// Serial ports.
    serial: Vec<Port>,
    /// HID devices.
    hid: Vec<Device>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Port {
    /// Path of the port.
    path: String,
    /// USB vendor and product, as in 1532:0b00; null if the port is not on USB.
    id: Option<String>,
    /// Name of the product, or null.
    product: Option<String>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Device {
    /// Path of the device.
    path: String,
    /// USB vendor and product, as in 1532:0b00.
    id: String,
    /// Name of the product.
    product: String,
    /// Serial number.
    serial: String,
    /// Usage page and usage of each collection.
    usages: Vec<(u16, u16)>,
    /// Whether the device is an eye or head tracker, usage page 0x12.
    tracker: bool,
    /// What a tracker says of itself; null for other devices, or if it cannot be asked.
    features: Option<FeatureReport>,
}

fn hexadecimal((vendor, product): (u16, u16)) -> String {
    format!("{vendor:04x}:{product:04x}")
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    // A system without such devices may not have these lists.
    let serial = ports().unwrap_or_else(|reason| {
        warn(&format!("the serial ports cannot be listed: {reason}"));
        Vec::new()
    });
    let hid = devices().unwrap_or_else(|reason| {
        warn(&format!("the HID devices cannot be listed: {reason}"));
        Vec::new()
    });
    let serial = serial.into_iter().map(|port| Port {
        path: port.path,
        id: port.usb_id.map(hexadecimal),
        product: port.product,
    });
    let hid = hid.into_iter().map(|found| Device {
        tracker: found.is_tracker(),
        features: asked(&found),
        path: found.path,
        id: hexadecimal(found.id),
        product: found.product,
        serial: found.serial_number,
        usages: found.usages,
    });
    let (serial, hid) = (serial.collect(), hid.collect());
    print(&Report { serial, hid }, arguments.json)
}

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
            let (path, id, product) = (&device.path, &device.id, &device.product);
            lines.push(format!("hid:{path}  {id}  {product}{mark}"));
            if let Some(features) = &device.features {
                lines.push(format!("  {features}"));
            }
        }
        f.write_str(&lines.join("\n"))
    }
}

//! `shisen tracker list`: serial ports, HID devices, and trackers on the network.

use super::features::FeatureReport;
use crate::cli::prelude::*;
use crate::files::with_help;
use crate::tracker::{Server, Stream, devices as vrpn_senders, features, streams};
use shisen_tracker::hid::device::{Found, devices};
use shisen_tracker::serial::ports;

/// Lists serial ports, HID devices, and LSL streams of the local network
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    /// Also list the LSL streams and the devices of the VRPN server of a host, as in
    /// 192.168.1.5 or vrpnhost:3884
    #[arg(long, value_name = "HOST")]
    host: Option<String>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// Serial ports, HID devices, and trackers on the network.
#[derive(Debug, Serialize, JsonSchema)]
pub(in crate::cli) struct Report {
    /// Serial ports.
    serial: Vec<Port>,
    /// HID devices.
    hid: Vec<Device>,
    /// LSL streams.
    lsl: Vec<LslStream>,
    /// Devices of the VRPN server of --host; null without one.
    vrpn: Option<Vec<VrpnDevice>>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct LslStream {
    /// Name of the stream.
    name: String,
    /// Type of the stream; may be empty.
    kind: String,
    /// Number of channels.
    channels: u8,
    /// Samples per second; 0 if irregular.
    rate_hz: f64,
    /// Address of the host.
    host: String,
}

#[derive(Debug, Serialize, JsonSchema)]
struct VrpnDevice {
    /// Name of the device.
    name: String,
    /// Host and port of the server.
    server: String,
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
    let host = arguments.host.as_deref();
    let report = Report {
        serial: serial.collect(),
        hid: hid.collect(),
        lsl: lsl_streams(host),
        vrpn: host.map(vrpn_devices).transpose()?,
    };
    print(&report, arguments.json)
}

/// How long answers from the network are waited for.
const PATIENCE: Duration = Duration::from_secs(1);

fn lsl_streams(host: Option<&str>) -> Vec<LslStream> {
    let host = host.map(|host| host.split_once(':').map_or(host, |(host, _)| host));
    let found = streams(host, PATIENCE, |_| false).unwrap_or_else(|fault| {
        warn(&with_help(&fault));
        Vec::new()
    });
    let found = found.into_iter().map(|Stream { info, host }| LslStream {
        name: info.name.to_string(),
        kind: info.kind.to_string(),
        channels: info.channels,
        rate_hz: info.rate,
        host: host.to_string(),
    });
    found.collect()
}

fn vrpn_devices(host: &str) -> Result<Vec<VrpnDevice>, Failure> {
    let server = Server::of_vrpn(host)?;
    let names = vrpn_senders(&server, PATIENCE)?.into_iter();
    let server = server.to_string();
    let found = names.map(|name| VrpnDevice {
        name,
        server: server.clone(),
    });
    Ok(found.collect())
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
        for stream in &self.lsl {
            let (name, kind, host) = (&stream.name, &stream.kind, &stream.host);
            let channels = stream.channels;
            lines.push(format!(
                "lsl:name={name}&type={kind}  {host}  {channels} channels"
            ));
        }
        for device in self.vrpn.iter().flatten() {
            lines.push(format!("vrpn:{}@{}", device.name, device.server));
        }
        if lines.is_empty() {
            return f.write_str("no serial port, no HID device and no LSL stream");
        }
        f.write_str(&lines.join("\n"))
    }
}

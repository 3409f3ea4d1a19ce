//! The monitors of an X server, by name.

use crate::show::window::WindowError;
use std::collections::HashMap;
use x11rb::connection::RequestConnection;
use x11rb::protocol::randr::{ConnectionExt as _, ModeInfo};
use x11rb::protocol::xproto::ConnectionExt as _;
use x11rb::rust_connection::RustConnection;

/// A monitor and its place in the root window.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Monitor {
    pub(super) name: String,
    /// The upper left corner, pixels.
    pub(super) corner: [i16; 2],
    /// Columns and rows.
    pub(super) size: [u16; 2],
    /// Refreshes per second by its mode, if it has one.
    pub(super) hz: Option<f64>,
}

/// Returns the monitor of a name among those of a display.
pub(super) fn named<'m>(
    monitors: &'m [Monitor],
    name: &str,
    display: &str,
) -> Result<&'m Monitor, WindowError> {
    let found = monitors.iter().find(|monitor| monitor.name == name);
    found.ok_or_else(|| {
        let all: Vec<String> = monitors
            .iter()
            .map(|monitor| {
                format!(
                    "{} ({} × {})",
                    monitor.name, monitor.size[0], monitor.size[1]
                )
            })
            .collect();
        let there = if all.is_empty() {
            "none".to_owned()
        } else {
            all.join(", ")
        };
        WindowError::refused(
            format!("{display} has no monitor {name}; there are {there}"),
            "give --outputs SCREEN=MONITOR with one of these names",
        )
    })
}

/// Returns the monitors of a server that are inside its root window.
pub(super) fn all(connection: &RustConnection, root: u32) -> Result<Vec<Monitor>, WindowError> {
    if connection.extension_information("RANDR")?.is_none() {
        return Err(WindowError::no_window(
            "the X server has no RandR, which names monitors",
            "take --view window, or a server with RandR 1.5",
        ));
    }
    connection.randr_query_version(1, 5)?.reply()?;
    let extent = connection.get_geometry(root)?.reply()?;
    let found = connection.randr_get_monitors(root, true)?.reply()?;
    let rates = rates(connection, root)?;
    let mut monitors = Vec::new();
    for monitor in found.monitors {
        let name = connection.get_atom_name(monitor.name)?.reply()?.name;
        let inside = monitor.x < extent.width as i16 && monitor.y < extent.height as i16;
        if inside && monitor.width > 0 && monitor.height > 0 {
            monitors.push(Monitor {
                name: String::from_utf8_lossy(&name).into_owned(),
                corner: [monitor.x, monitor.y],
                size: [monitor.width, monitor.height],
                hz: (monitor.outputs.iter()).find_map(|output| rates.get(output).copied()),
            });
        }
    }
    Ok(monitors)
}

/// Returns refreshes per second by the number of the output.
fn rates(connection: &RustConnection, root: u32) -> Result<HashMap<u32, f64>, WindowError> {
    let all = connection
        .randr_get_screen_resources_current(root)?
        .reply()?;
    let mut rates = HashMap::new();
    for crtc in &all.crtcs {
        let about = connection.randr_get_crtc_info(*crtc, all.config_timestamp)?;
        let about = about.reply()?;
        let mode = all.modes.iter().find(|mode| mode.id == about.mode);
        if let Some(hz) = mode.and_then(refreshes) {
            rates.extend(about.outputs.iter().map(|&output| (output, hz)));
        }
    }
    Ok(rates)
}

/// Returns the refreshes per second of a mode, if it says.
pub(super) fn refreshes(mode: &ModeInfo) -> Option<f64> {
    let pixels = f64::from(mode.htotal) * f64::from(mode.vtotal);
    let hz = f64::from(mode.dot_clock) / pixels;
    (1.0..=1_000.0).contains(&hz).then_some(hz)
}

//! What an eye tracker says of itself, for reports.

use crate::cli::prelude::*;
use crate::tracker::Features;
use shisen_tracker::hid::eye_tracker::status_name;

/// What a HID eye tracker says of itself. A value is null if the device does not say it.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub(super) struct FeatureReport {
    /// What the tracker can do.
    capabilities: Option<Capabilities>,
    /// The display that it is set up for.
    configuration: Option<Configuration>,
    /// Its state.
    status: Option<Status>,
    /// Reports that could not be read, and why.
    unread: Vec<String>,
    /// Why it refused the request to send everything; null if it accepted the request, has no such
    /// request, or was not asked.
    refused: Option<String>,
}

#[derive(Debug, Clone, Serialize, JsonSchema)]
struct Capabilities {
    /// Quality of the tracking.
    quality: Option<u32>,
    /// Least distance of the eyes, metres.
    nearest_m: Option<f32>,
    /// Best distance of the eyes, metres.
    best_m: Option<f32>,
    /// Greatest distance of the eyes, metres.
    furthest_m: Option<f32>,
    /// Greatest width of a screen, metres.
    widest_screen_m: Option<f32>,
    /// Greatest height of a screen, metres.
    highest_screen_m: Option<f32>,
}

#[derive(Debug, Clone, Serialize, JsonSchema)]
struct Configuration {
    /// Manufacturer of the display.
    manufacturer: Option<u32>,
    /// Product number of the display.
    product: Option<u32>,
    /// Serial number of the display.
    serial_number: Option<u32>,
    /// When the display was made.
    manufacturer_date: Option<u32>,
    /// Width of the screen, metres.
    screen_width_m: Option<f32>,
    /// Height of the screen, metres.
    screen_height_m: Option<f32>,
}

#[derive(Debug, Clone, Serialize, JsonSchema)]
struct Status {
    /// Number of the state.
    code: Option<u32>,
    /// Meaning of that number.
    meaning: &'static str,
    /// Samples per second.
    rate_hz: Option<f32>,
}

impl From<&Features> for FeatureReport {
    fn from(features: &Features) -> Self {
        Self {
            capabilities: features.capabilities.map(|said| Capabilities {
                quality: said.quality,
                nearest_m: said.nearest,
                best_m: said.best,
                furthest_m: said.furthest,
                widest_screen_m: said.widest_screen,
                highest_screen_m: said.highest_screen,
            }),
            configuration: features.configuration.map(|said| Configuration {
                manufacturer: said.manufacturer,
                product: said.product,
                serial_number: said.serial_number,
                manufacturer_date: said.manufacturer_date,
                screen_width_m: said.screen_width,
                screen_height_m: said.screen_height,
            }),
            status: features.status.map(|said| Status {
                code: said.configuration,
                meaning: said.configuration.map_or("", status_name),
                rate_hz: said.sampling_frequency,
            }),
            unread: features.unread.clone(),
            refused: features.refused.clone(),
        }
    }
}

/// A value, or a question mark.
struct Or<T>(Option<T>);

impl<T: fmt::Display> fmt::Display for Or<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0 {
            Some(value) => value.fmt(f),
            None => f.write_str("?"),
        }
    }
}

impl fmt::Display for FeatureReport {
    /// Writes one line.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut parts = Vec::new();
        if let Some(said) = &self.capabilities {
            let (near, far, best) = (Or(said.nearest_m), Or(said.furthest_m), Or(said.best_m));
            let (width, height) = (Or(said.widest_screen_m), Or(said.highest_screen_m));
            parts.push(format!(
                "tracks from {near:.3} to {far:.3} m (best {best:.3}), screens up to {width:.3} by \
                 {height:.3} m, quality {}",
                Or(said.quality)
            ));
        }
        if let Some(said) = &self.configuration {
            let (width, height) = (Or(said.screen_width_m), Or(said.screen_height_m));
            let (maker, product) = (said.manufacturer.unwrap_or(0), said.product.unwrap_or(0));
            parts.push(format!(
                "set up for {width:.3} by {height:.3} m of display {maker:#06x}:{product:#06x}, \
                 serial number {}",
                Or(said.serial_number)
            ));
        }
        if let Some(said) = &self.status {
            let meaning = Some(said.meaning).filter(|meaning| !meaning.is_empty());
            let meaning = meaning.unwrap_or("unknown");
            let (code, rate) = (Or(said.code), Or(said.rate_hz));
            parts.push(format!("status {code} ({meaning}), {rate} Hz"));
        }
        let unread = self.unread.iter();
        parts.extend(unread.map(|unread| format!("cannot be read: {unread}")));
        if let Some(reason) = &self.refused {
            parts.push(format!("refused the request to send everything: {reason}"));
        }
        if parts.is_empty() {
            parts.push("it says nothing of itself".to_owned());
        }
        f.write_str(&parts.join("; "))
    }
}

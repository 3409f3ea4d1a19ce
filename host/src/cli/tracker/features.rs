//! What an eye tracker says of itself, for reports.

use crate::tracker::Features;
use serde::Serialize;
use shisen_tracker::hid::eye_tracker::{Capabilities, Configuration, Status, status_name};
use std::fmt;

/// Null where the device does not say.
#[derive(Debug, Clone, Serialize)]
pub(super) struct FeatureReport {
    capabilities: Option<CapabilityReport>,
    configuration: Option<ConfigurationReport>,
    status: Option<StatusReport>,
    /// Reports that it has and that could not be read, and why.
    unread: Vec<String>,
    /// Why it did not take the request to send all that it has.
    refused: Option<String>,
}

#[derive(Debug, Clone, Serialize)]
struct CapabilityReport {
    quality: Option<u32>,
    nearest_m: Option<f32>,
    best_m: Option<f32>,
    furthest_m: Option<f32>,
    widest_screen_m: Option<f32>,
    highest_screen_m: Option<f32>,
}

#[derive(Debug, Clone, Serialize)]
struct ConfigurationReport {
    manufacturer: Option<u32>,
    product: Option<u32>,
    serial_number: Option<u32>,
    manufacturer_date: Option<u32>,
    screen_width_m: Option<f32>,
    screen_height_m: Option<f32>,
}

#[derive(Debug, Clone, Serialize)]
struct StatusReport {
    code: Option<u32>,
    meaning: &'static str,
    rate_hz: Option<f32>,
}

impl From<&Features> for FeatureReport {
    fn from(features: &Features) -> Self {
        Self {
            capabilities: features.capabilities.map(CapabilityReport::of),
            configuration: features.configuration.map(ConfigurationReport::of),
            status: features.status.map(StatusReport::of),
            unread: features.unread.clone(),
            refused: features.refused.clone(),
        }
    }
}

impl CapabilityReport {
    fn of(of: Capabilities) -> Self {
        Self {
            quality: of.quality,
            nearest_m: of.nearest,
            best_m: of.best,
            furthest_m: of.furthest,
            widest_screen_m: of.widest_screen,
            highest_screen_m: of.highest_screen,
        }
    }
}

impl ConfigurationReport {
    fn of(of: Configuration) -> Self {
        Self {
            manufacturer: of.manufacturer,
            product: of.product,
            serial_number: of.serial_number,
            manufacturer_date: of.manufacturer_date,
            screen_width_m: of.screen_width,
            screen_height_m: of.screen_height,
        }
    }
}

impl StatusReport {
    fn of(of: Status) -> Self {
        Self {
            code: of.configuration,
            meaning: of.configuration.map_or("", status_name),
            rate_hz: of.sampling_frequency,
        }
    }
}

/// A value, or a word of its lack.
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
    /// On a line.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut parts = Vec::new();
        if let Some(of) = &self.capabilities {
            parts.push(format!(
                "tracks from {:.3} to {:.3} m (best {:.3}), screens up to {:.3} by {:.3} m, \
                 quality {}",
                Or(of.nearest_m),
                Or(of.furthest_m),
                Or(of.best_m),
                Or(of.widest_screen_m),
                Or(of.highest_screen_m),
                Or(of.quality)
            ));
        }
        if let Some(of) = &self.configuration {
            parts.push(format!(
                "set up for {:.3} by {:.3} m of display {:#06x}:{:#06x}, serial number {}",
                Or(of.screen_width_m),
                Or(of.screen_height_m),
                of.manufacturer.unwrap_or(0),
                of.product.unwrap_or(0),
                Or(of.serial_number)
            ));
        }
        if let Some(of) = &self.status {
            let meaning = if of.meaning.is_empty() {
                "unknown"
            } else {
                of.meaning
            };
            parts.push(format!(
                "status {} ({meaning}), {} Hz",
                Or(of.code),
                Or(of.rate_hz)
            ));
        }
        for unread in &self.unread {
            parts.push(format!("cannot be read: {unread}"));
        }
        if let Some(reason) = &self.refused {
            parts.push(format!(
                "it did not take the request to send all that it has: {reason}"
            ));
        }
        if parts.is_empty() {
            return f.write_str("it says nothing of itself");
        }
        f.write_str(&parts.join("; "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_it_says_is_told_and_what_it_does_not_is_open() {
        let features = Features {
            capabilities: Some(Capabilities {
                quality: Some(1),
                nearest: Some(0.5),
                best: None,
                furthest: Some(0.9),
                widest_screen: Some(0.7),
                highest_screen: Some(0.4),
            }),
            configuration: None,
            status: Some(Status {
                configuration: Some(3),
                sampling_frequency: Some(90.0),
            }),
            unread: vec!["configuration (0x12): no".into()],
            refused: Some("broken pipe".into()),
        };
        let report = FeatureReport::from(&features);
        assert_eq!(
            report.to_string(),
            "tracks from 0.500 to 0.900 m (best ?), screens up to 0.700 by 0.400 m, quality 1; \
             status 3 (the screen has to be set up), 90 Hz; \
             cannot be read: configuration (0x12): no; \
             it did not take the request to send all that it has: broken pipe"
        );
        let json = serde_json::to_value(&report).unwrap();
        assert_eq!(json["capabilities"]["quality"], 1);
        assert!(json["capabilities"]["best_m"].is_null() && json["configuration"].is_null());
        assert_eq!(json["refused"], "broken pipe");
        assert_eq!(json["status"]["meaning"], "the screen has to be set up");
        let silent = FeatureReport::from(&Features::default());
        assert_eq!(silent.to_string(), "it says nothing of itself");
    }
}

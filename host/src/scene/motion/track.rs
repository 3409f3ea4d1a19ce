//! Values at keys, and how they change between these.

use glam::{DQuat, DVec4};
use thiserror::Error;

/// What a track changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Property {
    /// A node's place from its parent: three numbers.
    Position,
    /// A node's turn as a quaternion, x y z w; keys need not be of unit length.
    Rotation,
    /// A node's turn as yaw, pitch and roll in degrees, as scene files have them.
    Angles,
    /// A node's three factors.
    Scale,
    /// The weights of this number of morph targets.
    Weights(usize),
}

impl Property {
    /// Returns how many numbers a value has.
    pub const fn width(self) -> usize {
        match self {
            Self::Position | Self::Angles | Self::Scale => 3,
            Self::Rotation => 4,
            Self::Weights(count) => count,
        }
    }
}

/// How values change between keys.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Interpolation {
    /// Not before the next key.
    Step,
    /// Evenly; rotations turn the short way at an even speed.
    Linear,
    /// Along Hermite's cubic, whose slopes the keys have.
    Cubic,
}

named!(Interpolation { Step => "step", Linear => "linear", Cubic => "cubic" });

/// Values of one property at times.
#[derive(Debug, Clone, PartialEq)]
pub struct Track {
    property: Property,
    interpolation: Interpolation,
    /// Seconds, none before the one before it.
    times: Vec<f64>,
    /// For each key its value; for cubic keys the slope before it, its value and the slope after it.
    values: Vec<f64>,
}

/// Keys that make no track. Keys count from 0.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[allow(missing_docs, reason = "the messages are the docs")]
pub enum TrackError {
    #[error("has no keys")]
    NoKeys,
    #[error("has key {key} at {time} s, and not at {before} s or later")]
    Time { key: usize, before: f64, time: f64 },
    #[error("has {found} numbers for its keys, which need {needed}")]
    Count { found: usize, needed: usize },
    #[error("has a value at key {key} that is not finite, or a rotation of zero length")]
    Value { key: usize },
}

impl Track {
    /// Returns a track of keys. `times` are seconds; `values` has as many numbers a key as the
    /// property, and three times as many for cubic keys: slope before, value, slope after.
    ///
    /// # Errors
    /// No keys, times below 0 or before those of the key before, another number of values, values
    /// that are not finite and quaternions of no length.
    pub fn new(
        property: Property,
        interpolation: Interpolation,
        times: Vec<f64>,
        values: Vec<f64>,
    ) -> Result<Self, TrackError> {
        let track = Self {
            property,
            interpolation,
            times,
            values,
        };
        if track.times.is_empty() {
            return Err(TrackError::NoKeys);
        }
        let mut before = 0.0;
        for (key, &time) in track.times.iter().enumerate() {
            // NaN is refused, too.
            if !(before..f64::INFINITY).contains(&time) {
                return Err(TrackError::Time { key, before, time });
            }
            before = time;
        }
        let (found, needed) = (track.values.len(), track.times.len() * track.stride());
        if found != needed {
            return Err(TrackError::Count { found, needed });
        }
        for key in 0..track.times.len() {
            let all = &track.values[key * track.stride()..][..track.stride()];
            let is_finite = all.iter().all(|value| value.is_finite());
            let turns =
                property != Property::Rotation || track.value(key).iter().any(|v| *v != 0.0);
            if !(is_finite && turns) {
                return Err(TrackError::Value { key });
            }
        }
        Ok(track)
    }

    /// Returns a track that goes smoothly through values: the slope at a key is that between its
    /// neighbours.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn smooth(
        property: Property,
        times: Vec<f64>,
        values: Vec<f64>,
    ) -> Result<Self, TrackError> {
        let track = Self::new(property, Interpolation::Linear, times, values)?;
        let last = track.times.len() - 1;
        let mut cubic = Vec::with_capacity(3 * track.values.len());
        for key in 0..=last {
            let (a, b) = (key.saturating_sub(1), (key + 1).min(last));
            let span = track.times[b] - track.times[a];
            let ends = track.value(a).iter().zip(track.value(b));
            let slope = ends.map(|(a, b)| if span > 0.0 { (b - a) / span } else { 0.0 });
            let slope: Vec<f64> = slope.collect();
            cubic.extend_from_slice(&slope);
            cubic.extend_from_slice(track.value(key));
            cubic.extend(slope);
        }
        Self::new(property, Interpolation::Cubic, track.times, cubic)
    }

    /// Returns what it changes.
    pub const fn property(&self) -> Property {
        self.property
    }

    /// Returns the time of its last key: seconds.
    pub fn duration(&self) -> f64 {
        self.times.last().copied().unwrap_or(0.0)
    }

    /// Numbers of a key.
    const fn stride(&self) -> usize {
        match self.interpolation {
            Interpolation::Cubic => 3 * self.property.width(),
            _ => self.property.width(),
        }
    }

    /// Returns a part of a key: of a cubic one the slope before (0), the value (1) or the slope
    /// after (2).
    fn part(&self, key: usize, part: usize) -> &[f64] {
        let width = self.property.width();
        &self.values[key * self.stride() + part * width..][..width]
    }

    fn value(&self, key: usize) -> &[f64] {
        let is_cubic = self.interpolation == Interpolation::Cubic;
        self.part(key, usize::from(is_cubic))
    }

    /// Writes the value at a time in seconds: that of the first key before it, that of the last key
    /// after it. A quaternion is then of unit length. `value` has the property's width.
    pub fn sample(&self, time: f64, value: &mut [f64]) {
        let next = self.times.partition_point(|key| *key <= time);
        let before = next.saturating_sub(1);
        if next == 0 || next == self.times.len() || self.interpolation == Interpolation::Step {
            value.copy_from_slice(self.value(before));
        } else {
            let span = self.times[next] - self.times[before];
            let t = (time - self.times[before]) / span;
            self.between([before, next], span, t, value);
        }
        if self.property == Property::Rotation {
            let turn = DVec4::from_slice(value).normalize_or(DVec4::W);
            value.copy_from_slice(&turn.to_array());
        }
    }

    /// Writes the value at the share `t` of the way from one key to the next, `span` seconds apart.
    fn between(&self, [before, next]: [usize; 2], span: f64, t: f64, value: &mut [f64]) {
        let (a, b) = (self.value(before), self.value(next));
        match (self.interpolation, self.property) {
            (Interpolation::Cubic, _) => {
                let (out, into) = (self.part(before, 2), self.part(next, 0));
                let (t2, t3) = (t * t, t * t * t);
                for (i, value) in value.iter_mut().enumerate() {
                    *value = a[i] * (2.0 * t3 - 3.0 * t2 + 1.0)
                        + out[i] * span * (t3 - 2.0 * t2 + t)
                        + b[i] * (3.0 * t2 - 2.0 * t3)
                        + into[i] * span * (t3 - t2);
                }
            }
            (_, Property::Rotation) => {
                let [a, b] = [a, b].map(|turn| DQuat::from_slice(turn).normalize());
                value.copy_from_slice(&a.slerp(b, t).to_array());
            }
            _ => {
                for (i, value) in value.iter_mut().enumerate() {
                    *value = a[i] + (b[i] - a[i]) * t;
                }
            }
        }
    }
}

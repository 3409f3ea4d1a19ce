//! `--what-if`: what is changed of a frame.

use crate::cli::arguments::lod::Choice;
use clap::ValueEnum as _;
use glam::{Quat, Vec3};
use shisen_core::gaze::LineOfSight;
use std::str::FromStr;

use crate::live::Look;

/// What is changed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum WhatIf {
    /// What follows the gaze.
    Lod(Choice),
    /// The line of sight, by degrees to the right and upwards.
    Gaze([f32; 2]),
    /// The budget: steps, or no end.
    Budget(Option<u64>),
}

impl FromStr for WhatIf {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let read = |(key, value): (&str, &str)| match (key, value) {
            ("lod", name) => Choice::from_str(name, false).ok().map(Self::Lod),
            ("gaze", angles) => {
                let (right, up) = angles.split_once(',')?;
                let angle = |text: &str| text.parse::<f32>().ok().filter(|a| a.abs() <= 180.0);
                Some(Self::Gaze([angle(right)?, angle(up)?]))
            }
            ("budget", "off") => Some(Self::Budget(None)),
            ("budget", steps) => {
                let steps = steps.strip_suffix("steps").unwrap_or(steps).parse().ok();
                steps.map(|steps| Self::Budget(Some(steps)))
            }
            _ => None,
        };
        text.split_once('=').and_then(read).ok_or_else(|| {
            "give lod=off, paper, paper-ellipse or foveated; gaze=+2,0 (degrees to the right and up); \
             or budget=off or 2000000steps"
                .to_owned()
        })
    }
}

impl WhatIf {
    /// Returns a look with the line of sight that is asked for.
    pub(super) fn look(self, look: &Look) -> Look {
        let Self::Gaze([right, up]) = self else {
            return *look;
        };
        let side = look.forward.cross(look.up);
        let turn = Quat::from_axis_angle(look.up, -right.to_radians())
            * Quat::from_axis_angle(side, up.to_radians());
        let forward = turn * look.forward;
        let ups = [turn * look.up, Vec3::Y, Vec3::NEG_Z];
        let mut lines = ups
            .into_iter()
            .filter_map(|up| LineOfSight::new(look.position, forward, up).ok());
        lines.next().map_or(*look, |line| Look {
            forward: line.forward(),
            up: line.up(),
            ..*look
        })
    }
}

//! `--navigate`: the buttons and axes by which a viewer flies through a scene.

use super::settings::Options;
use super::spec::Spec;
use crate::files::Fault;
use glam::{Quat, Vec3};
use shisen_tracker::decoder::{Control, ControlState, Event, Message};
use shisen_tracker::time::Micros;
use std::str::FromStr;

/// How a viewer flies, and by what.
#[derive(Debug, Clone, PartialEq)]
pub struct Navigation {
    /// How fast.
    pub flight: Flight,
    /// What steers.
    pub by: By,
    wand: WandAxes,
}

/// What steers.
#[derive(Debug, Clone, PartialEq)]
pub enum By {
    /// The keys of the window.
    Keyboard,
    /// What the tracker itself has: the Flystick of the controller that tracks the head.
    Tracker,
    /// Another device.
    Wand(Box<Spec>),
}

/// The speeds of a wand that is pushed all the way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Flight {
    /// Metres a second.
    pub speed: f64,
    /// Radians a second.
    pub turn: f64,
}

impl Default for Flight {
    /// 2 m/s and 60° a second.
    fn default() -> Self {
        Self {
            speed: 2.0,
            turn: 60_f64.to_radians(),
        }
    }
}

/// What the axes of a wand do.
#[derive(Debug, Clone, Copy, PartialEq)]
struct WandAxes {
    /// Numbers of those that turn to the right and fly forwards, and whether they do the reverse.
    numbers: [u8; 2],
    reversed: [bool; 2],
    /// Up to this part of its way an axis does nothing.
    dead_zone: f32,
}

/// Where a viewer steers now; each from −1 to 1.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Steering {
    /// Along [`pointing`](Self::pointing).
    pub forward: f32,
    /// To the right.
    pub turn: f32,
    /// Upwards.
    pub rise: f32,
    /// Where the wand points, a direction in the room; `None`: as the head.
    pub pointing: Option<Vec3>,
    /// Back to where the viewer began.
    pub is_homeward: bool,
}

impl Steering {
    /// Returns whether the viewer stays.
    pub fn is_still(&self) -> bool {
        [self.forward, self.turn, self.rise] == [0.0; 3]
    }

    /// Returns what both ask for.
    #[must_use]
    pub fn with(self, other: &Self) -> Self {
        let sum = |one: f32, other: f32| (one + other).clamp(-1.0, 1.0);
        Self {
            forward: sum(self.forward, other.forward),
            turn: sum(self.turn, other.turn),
            rise: sum(self.rise, other.rise),
            pointing: self.pointing.or(other.pointing),
            is_homeward: self.is_homeward || other.is_homeward,
        }
    }
}

impl Navigation {
    /// Returns its wand, whose axes point in the room as `room_from_tracker` says.
    pub fn wand(&self, room_from_tracker: Quat) -> Wand {
        Wand {
            does: self.wand,
            room_from_tracker,
            axes: [0.0; 2],
            buttons: [false; 3],
            sensor: None,
            pointing: None,
            heard: None,
        }
    }
}

impl FromStr for Navigation {
    type Err = Fault;

    /// Reads `keyboard`, `tracker` or a SPEC, with `speed=`, `turn=`, `dead=`, `x=` and `y=` among
    /// its options.
    fn from_str(text: &str) -> Result<Self, Fault> {
        let (target, rest) = text.rsplit_once('?').unwrap_or((text, ""));
        let mut options = Options::read(rest)?;
        let mut flight = Flight::default();
        let speeds = "metres a second, above 0 to 1000";
        options.number(&mut flight.speed, "speed", (1.0e-3, 1.0e3), speeds)?;
        options.set(
            &mut flight.turn,
            "turn",
            "degrees a second, 0 to 360",
            |text| {
                let degrees = text.parse().ok().filter(|d| (0.0..=360.0).contains(d));
                degrees.map(f64::to_radians)
            },
        )?;
        // A Flystick's first axis grows to the left.
        let is_flystick = target.starts_with("dtrack:");
        let mut wand = WandAxes {
            numbers: [0, 1],
            reversed: [is_flystick, false],
            dead_zone: 0.1,
        };
        options.number(&mut wand.dead_zone, "dead", (0.0, 0.9), "0 to 0.9")?;
        for (key, axis) in [("x", 0), ("y", 1)] {
            let mut read = (wand.numbers[axis], wand.reversed[axis]);
            options.set(
                &mut read,
                key,
                "the number of an axis, from 0; -0 is the same one reversed",
                |text| {
                    let number = text.strip_prefix('-').unwrap_or(text).parse().ok();
                    number.map(|number| (number, text.starts_with('-')))
                },
            )?;
            (wand.numbers[axis], wand.reversed[axis]) = read;
        }
        let rest = options.rest();
        let by = match target {
            "keyboard" | "tracker" if !rest.is_empty() => {
                let message = format!("{target} has no option {rest:?}");
                let help = "give speed=2, turn=60, and for a tracker dead=0.1, x=0, y=1";
                return Err(Fault::new(message, help));
            }
            "keyboard" => By::Keyboard,
            "tracker" => By::Tracker,
            _ if rest.is_empty() => By::Wand(Box::new(target.parse()?)),
            _ => By::Wand(Box::new(format!("{target}?{rest}").parse()?)),
        };
        Ok(Self { flight, by, wand })
    }
}

/// After this silence a wand that has been sending poses is let go, as it would fly on for ever.
const LOST: Micros = Micros::from_millis(500);

/// The state of a wand.
#[derive(Debug, Clone)]
pub struct Wand {
    does: WandAxes,
    room_from_tracker: Quat,
    /// To the right and forwards.
    axes: [f32; 2],
    /// Forwards, back, and to where the viewer began.
    buttons: [bool; 3],
    /// The sensor of its controls; that of the first that moves.
    sensor: Option<u8>,
    pointing: Option<Vec3>,
    /// When its newest pose came.
    heard: Option<Micros>,
}

impl Wand {
    /// Takes note of what a device sends.
    pub fn hear(&mut self, event: &Event, now: Micros) {
        match event {
            Event::Message(Message::Control(control)) => self.take(control),
            Event::Sample(sample) if self.sensor == Some(sample.sensor) => {
                let turn = sample.head.orientation.filter(|turn| turn.tracked);
                if let Some(turn) = turn {
                    self.pointing = Some(self.room_from_tracker * (turn.value * Vec3::NEG_Z));
                    self.heard = Some(now);
                }
            }
            _ => {}
        }
    }

    fn take(&mut self, control: &Control) {
        if *self.sensor.get_or_insert(control.sensor) != control.sensor {
            return;
        }
        match control.state {
            ControlState::Button(is_pressed) => {
                if let Some(button) = self.buttons.get_mut(usize::from(control.number)) {
                    *button = is_pressed;
                }
            }
            ControlState::Axis(value) => {
                let axes = self.axes.iter_mut().zip(self.does.numbers);
                let axes = axes.zip(self.does.reversed);
                for ((axis, number), is_reversed) in axes {
                    if number == control.number {
                        *axis = if is_reversed { -value } else { value };
                    }
                }
            }
        }
    }

    /// Lets go of all, as a device that is gone.
    pub fn release(&mut self) {
        (self.axes, self.buttons) = ([0.0; 2], [false; 3]);
        (self.pointing, self.heard) = (None, None);
    }

    /// Returns where it steers.
    pub fn steering(&mut self, now: Micros) -> Steering {
        if self.heard.is_some_and(|heard| now.since(heard) > LOST) {
            self.release();
        }
        let dead = self.does.dead_zone;
        let [turn, forward] = self.axes.map(|value| {
            let beyond = (value.abs().min(1.0) - dead).max(0.0) / (1.0 - dead);
            beyond.copysign(value)
        });
        let [ahead, back, is_homeward] = self.buttons;
        let pressed = f32::from(i8::from(ahead) - i8::from(back));
        Steering {
            forward: (forward + pressed).clamp(-1.0, 1.0),
            turn,
            rise: 0.0,
            pointing: self.pointing,
            is_homeward,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shisen_tracker::sample::{Reading, Sample};

    fn control(number: u8, state: ControlState) -> Event {
        Event::Message(Message::Control(Control {
            sensor: 32,
            number,
            state,
            device_time: None,
        }))
    }

    #[test]
    fn a_wand_steers_until_it_is_lost() {
        let text = "dtrack:5000?dead=0.2&y=3&speed=5&frame=right,up,back";
        let navigation: Navigation = text.parse().unwrap();
        assert_eq!(navigation.flight.speed, 5.0);
        let By::Wand(spec) = &navigation.by else {
            panic!("{navigation:?}");
        };
        assert_eq!(**spec, "dtrack:5000?frame=right,up,back".parse().unwrap());
        let mut wand = navigation.wand(Quat::from_rotation_y(std::f32::consts::FRAC_PI_2));
        let axis = |number, value| control(number, ControlState::Axis(value));
        for event in [axis(0, -0.6), axis(1, 1.0), axis(3, 0.1)] {
            wand.hear(&event, Micros(0));
        }
        let right = wand.steering(Micros(0));
        assert!(
            (right.turn - 0.5).abs() < 1.0e-6 && right.forward == 0.0,
            "{right:?}"
        );
        // One without poses may be silent for ever.
        assert_eq!(wand.steering(Micros::from_millis(90_000)), right);
        let mut sample = Sample {
            sensor: 32,
            ..Sample::arrived(Micros(0))
        };
        sample.head.orientation = Some(Reading::tracked(Quat::IDENTITY));
        wand.hear(&Event::Sample(sample), Micros(0));
        wand.hear(&control(1, ControlState::Button(true)), Micros(0));
        let back = wand.steering(Micros::from_millis(500));
        assert_eq!(back.forward, -1.0);
        assert!(back.pointing.unwrap().distance(Vec3::NEG_X) < 1.0e-6);
        assert!(wand.steering(Micros::from_millis(501)).is_still());
    }

    #[test]
    fn what_cannot_steer_is_refused_with_what_can() {
        for (text, says) in [
            (
                "keyboard?dead=0.1&rate=5",
                "keyboard has no option \"rate=5\"",
            ),
            (
                "vrpn:Wand0@localhost?speed=0",
                "speed=\"0\" is not possible",
            ),
            ("tracker?x=a", "x=\"a\" is not possible"),
            ("joystick", "is not a kind of tracker"),
        ] {
            let refused = text.parse::<Navigation>().unwrap_err().to_string();
            assert!(refused.contains(says), "{refused}");
        }
    }
}

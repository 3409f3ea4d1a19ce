//! `--navigate`: the buttons and axes by which a viewer flies through a scene.

use super::net::{Datagrams, NetSpec};
use super::settings::Options;
use super::spec::{Spec, TrackerKind};
use crate::files::Fault;
use glam::{Quat, Vec3};
use shisen_tracker::decoder::{Control, ControlState, Event, Message};
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
            only: match &self.by {
                By::Wand(spec) => spec.head,
                By::Keyboard | By::Tracker => None,
            },
            hands: Vec::new(),
            is_present: true,
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
            _ if rest.is_empty() => By::Wand(Box::new(steering(target)?)),
            _ => By::Wand(Box::new(steering(&format!("{target}?{rest}"))?)),
        };
        Ok(Self { flight, by, wand })
    }
}

/// Reads the SPEC of a device that has buttons or axes.
fn steering(text: &str) -> Result<Spec, Fault> {
    let spec: Spec = text.parse()?;
    check_controls(text, &spec)?;
    Ok(spec)
}

/// Refuses a device that has neither buttons nor axes.
///
/// # Errors
/// Such a device, by its name.
pub(crate) fn check_controls(name: &str, spec: &Spec) -> Result<(), Fault> {
    let has_controls = match &spec.kind {
        TrackerKind::Net(NetSpec::Datagrams { protocol, .. }) => {
            matches!(protocol, Datagrams::DTrack(_))
        }
        TrackerKind::Net(net) => matches!(net, NetSpec::Vrpn { .. }),
        TrackerKind::Mock(_) => false,
        TrackerKind::Serial(_) | TrackerKind::Hid(_) | TrackerKind::Replay(_) => true,
    };
    if has_controls {
        return Ok(());
    }
    let message = format!("{name} has no buttons and no axes");
    let help = "give vrpn:DEVICE@HOST, dtrack:PORT, tracker (for such a one) or keyboard";
    Err(Fault::new(message, help))
}

/// Most sensors whose controls are followed.
const MOST_HANDS: usize = 8;

/// The state of a wand, or of several of one device: the first that is moved steers.
#[derive(Debug, Clone)]
pub struct Wand {
    does: WandAxes,
    room_from_tracker: Quat,
    /// The sensor in the hand, if the SPEC names it: `head=N`.
    only: Option<u8>,
    hands: Vec<Hand>,
    /// Whether the device is there: one that is not steers nowhere.
    pub is_present: bool,
}

/// The controls of a sensor.
#[derive(Debug, Clone, Default)]
struct Hand {
    sensor: u8,
    /// To the right and forwards.
    axes: [f32; 2],
    /// Forwards, back, and to where the viewer began.
    buttons: [bool; 3],
    pointing: Option<Vec3>,
}

impl Wand {
    /// Takes note of what a device sends.
    pub fn hear(&mut self, event: &Event) {
        match event {
            Event::Message(Message::Control(control)) => self.take(control),
            Event::Sample(sample) => {
                let turn = sample.head.orientation.filter(|turn| turn.tracked);
                let pointing = turn.map(|turn| self.room_from_tracker * (turn.value * Vec3::NEG_Z));
                let only = self.only;
                // Sensor 0 is the head's where no other is named.
                let is_its = |hand: &&mut Hand| match only {
                    Some(only) => only == sample.sensor,
                    None => hand.sensor == sample.sensor && hand.sensor > 0,
                };
                for hand in self.hands.iter_mut().filter(is_its) {
                    hand.pointing = pointing.or(hand.pointing);
                }
            }
            _ => {}
        }
    }

    fn take(&mut self, control: &Control) {
        // Protocols whose controls have no sensor give them 0.
        let is_other = |only| control.sensor != only && control.sensor > 0;
        if self.only.is_some_and(is_other) {
            return;
        }
        let sensor = control.sensor;
        let known = self.hands.iter().position(|hand| hand.sensor == sensor);
        let at = known.unwrap_or_else(|| {
            self.hands.truncate(MOST_HANDS - 1);
            self.hands.push(Hand {
                sensor,
                ..Hand::default()
            });
            self.hands.len() - 1
        });
        let hand = &mut self.hands[at];
        match control.state {
            ControlState::Button(is_pressed) => {
                if let Some(button) = hand.buttons.get_mut(usize::from(control.number)) {
                    *button = is_pressed;
                }
            }
            ControlState::Axis(value) => {
                let axes = hand.axes.iter_mut().zip(self.does.numbers);
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
        self.hands.clear();
    }

    /// Returns where it steers.
    pub fn steering(&self) -> Steering {
        let hands = self.hands.iter().filter(|_| self.is_present);
        let mut steering = hands.map(|hand| self.steered_by(hand));
        let moved = steering.find(|one| !one.is_still() || one.is_homeward);
        moved.unwrap_or_default()
    }

    fn steered_by(&self, hand: &Hand) -> Steering {
        let dead = self.does.dead_zone;
        let [turn, forward] = hand.axes.map(|value| {
            let beyond = (value.abs().min(1.0) - dead).max(0.0) / (1.0 - dead);
            beyond.copysign(value)
        });
        let [ahead, back, is_homeward] = hand.buttons;
        let pressed = f32::from(i8::from(ahead) - i8::from(back));
        Steering {
            forward: (forward + pressed).clamp(-1.0, 1.0),
            turn,
            rise: 0.0,
            pointing: hand.pointing,
            is_homeward,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shisen_tracker::sample::{Reading, Sample};
    use shisen_tracker::time::Micros;

    fn control(sensor: u8, number: u8, state: ControlState) -> Event {
        Event::Message(Message::Control(Control {
            sensor,
            number,
            state,
            device_time: None,
        }))
    }

    #[test]
    fn a_wand_steers_while_it_is_there() {
        let text = "dtrack:5000?dead=0.2&y=3&speed=5&frame=right,up,back";
        let navigation: Navigation = text.parse().unwrap();
        assert_eq!(navigation.flight.speed, 5.0);
        let By::Wand(spec) = &navigation.by else {
            panic!("{navigation:?}");
        };
        assert_eq!(**spec, "dtrack:5000?frame=right,up,back".parse().unwrap());
        let mut wand = navigation.wand(Quat::from_rotation_y(std::f32::consts::FRAC_PI_2));
        let axis = |number, value| control(32, number, ControlState::Axis(value));
        // One that lies about does not keep another from steering.
        wand.hear(&control(33, 0, ControlState::Axis(0.05)));
        for event in [axis(0, -0.6), axis(1, 1.0), axis(3, 0.1)] {
            wand.hear(&event);
        }
        let right = wand.steering();
        assert!(
            (right.turn - 0.5).abs() < 1.0e-6 && right.forward == 0.0,
            "{right:?}"
        );
        let mut sample = Sample {
            sensor: 32,
            ..Sample::arrived(Micros(0))
        };
        sample.head.orientation = Some(Reading::tracked(Quat::IDENTITY));
        wand.hear(&Event::Sample(sample));
        wand.hear(&control(32, 1, ControlState::Button(true)));
        // Hidden, it points where it did.
        sample.head.orientation = None;
        wand.hear(&Event::Sample(sample));
        let back = wand.steering();
        assert_eq!(back.forward, -1.0);
        assert!(back.pointing.unwrap().distance(Vec3::NEG_X) < 1.0e-6);
        wand.is_present = false;
        assert!(wand.steering().is_still());
        wand.is_present = true;
        assert_eq!(wand.steering(), back);
        wand.release();
        assert!(wand.steering().is_still());
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
            ("lsl:type=Gaze", "has no buttons and no axes"),
        ] {
            let refused = text.parse::<Navigation>().unwrap_err().to_string();
            assert!(refused.contains(says), "{refused}");
        }
    }
}

//! Trackers on the network, as a `SPEC` names them.

use crate::files::Fault;
use crate::tracker::settings::{FRAME, Options, directions, set_frames, wrong};
use shisen_tracker::head::axes::Axes;
use shisen_tracker::net::{dtrack, natnet, opentrack, vrpn};
use std::fmt;
use std::net::{IpAddr, Ipv4Addr, SocketAddr};

/// A tracker on the network, or a program that sends its samples.
#[derive(Debug, Clone, PartialEq)]
pub enum NetSpec {
    /// `vrpn:Tracker0@host:3883`: a device of a VRPN server.
    Vrpn {
        /// The device.
        device: vrpn::Config,
        /// The server.
        server: Server,
    },
    /// `dtrack:5000`, `udp:4242?protocol=opentrack`: datagrams that come without being asked for.
    Datagrams {
        /// Where they come to.
        listen: SocketAddr,
        /// What they hold.
        protocol: Datagrams,
    },
    /// `natnet:host`: a server of `OptiTrack`'s.
    NatNet {
        /// The server.
        server: Server,
        /// The name of the viewer's rigid body, if it is not given by its number.
        body: Option<String>,
        /// The server's axes.
        axes: Axes,
    },
    /// `lsl:type=Gaze`: a stream of the Lab Streaming Layer.
    Lsl(LslSpec),
    /// `stdin:`: lines of JSON on standard input.
    Stdin,
    /// `tcp:host:port`: lines of JSON.
    Lines(Server),
}

/// A host and a port.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Server {
    /// The host's name or address.
    pub host: String,
    /// The port.
    pub port: u16,
}

impl Server {
    /// Reads a VRPN server's host and, if it is not the usual one, port.
    ///
    /// # Errors
    /// A text that is neither.
    pub(crate) fn of_vrpn(text: &str) -> Result<Self, Fault> {
        server(text, Some(vrpn::PORT), "192.168.1.5")
    }
}

impl fmt::Display for Server {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.host, self.port)
    }
}

/// What datagrams hold.
#[derive(Debug, Clone, PartialEq)]
pub enum Datagrams {
    /// Frames of ART `DTrack`.
    DTrack(dtrack::Config),
    /// opentrack's numbers.
    Opentrack(opentrack::Config),
    /// `FreeD`'s message D1.
    FreeD,
}

/// A stream, and what its channels mean.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LslSpec {
    /// The stream's name; `None`: any.
    pub name: Option<String>,
    /// The stream's type; `None`: any.
    pub kind: Option<String>,
    /// The host that is asked besides this machine and the local network.
    pub host: Option<String>,
    /// Its gaze.
    pub gaze: GazeSpec,
}

/// Which channels are the gaze, and what they mean.
#[derive(Debug, Clone, PartialEq)]
pub struct GazeSpec {
    /// The labels of x, y and z, or numbers of channels from 0; `None`: found by usual labels.
    pub axes: [Option<String>; 3],
    /// The label of the confidence.
    pub confidence: Option<String>,
    /// The confidence below which there is no gaze.
    pub least_confidence: f64,
    /// Whether x and y that are both 0 mean that the eyes are lost.
    pub is_zero_lost: bool,
    /// The scene camera's focal lengths and principal point, pixels.
    pub camera: Option<[f64; 4]>,
    /// The wall whose pixels x and y are.
    pub screen: Option<String>,
    /// The columns and rows that x and y count; `None`: they are 0 to 1.
    pub pixels: Option<[f64; 2]>,
    /// Whether y grows upwards from the lower edge.
    pub is_upward: bool,
    /// Where the axes of a direction point; `None`: as is usual for its labels.
    pub directions: Option<glam::Quat>,
}

impl Default for GazeSpec {
    fn default() -> Self {
        Self {
            axes: [None, None, None],
            confidence: None,
            least_confidence: 0.6,
            is_zero_lost: false,
            camera: None,
            screen: None,
            pixels: None,
            is_upward: false,
            directions: None,
        }
    }
}

/// The names of these kinds of trackers.
pub(in crate::tracker) const KINDS: [&str; 7] =
    ["vrpn", "lsl", "dtrack", "natnet", "udp", "tcp", "stdin"];

impl NetSpec {
    /// Reads what follows a kind's name, and its options as far as they are its own. Returns them
    /// and the sensor on the viewer's head.
    pub(in crate::tracker) fn read(
        kind: &str,
        target: &str,
        options: &mut Options<'_>,
        head: &mut Option<u8>,
    ) -> Result<Self, Fault> {
        Ok(match kind {
            "vrpn" => read_vrpn(target, options)?,
            "natnet" => {
                let body = take_body(options, head);
                Self::NatNet {
                    server: server(target, Some(natnet::COMMAND_PORT), "natnet:192.168.1.5")?,
                    body,
                    axes: axes(options)?,
                }
            }
            "dtrack" => {
                if let Some(body) = take_body(options, head) {
                    return Err(wrong("body", &body, "the number of a body, 0 to 31"));
                }
                Self::Datagrams {
                    listen: listen(target, "dtrack:5000")?,
                    protocol: Datagrams::DTrack(dtrack::Config {
                        axes: axes(options)?,
                    }),
                }
            }
            "udp" => Self::Datagrams {
                listen: listen(target, "udp:4242")?,
                protocol: datagrams(options)?,
            },
            "lsl" => Self::Lsl(read_lsl(target, options)?),
            "tcp" => Self::Lines(server(target, None, "tcp:localhost:7000")?),
            _ if target.is_empty() => Self::Stdin,
            _ => {
                let message = format!("stdin:{target} names something after stdin:");
                return Err(Fault::new(message, "give stdin: alone"));
            }
        })
    }

    /// Returns the options that it has besides those of every tracker, for people.
    pub(in crate::tracker) const fn options(&self) -> &'static str {
        match self {
            Self::Vrpn { .. } => {
                "head=SENSOR, unit=m|cm|mm, frame=right,up,back, sensor=right,up,back"
            }
            Self::NatNet { .. } => "body=NAME or NUMBER, frame=right,up,back, sensor=right,up,back",
            Self::Datagrams { protocol, .. } => match protocol {
                Datagrams::DTrack(_) => "body=NUMBER, frame=right,up,back, sensor=right,up,back",
                Datagrams::Opentrack(_) => {
                    "protocol=opentrack|freed, reversed=x,y,z,yaw,pitch,roll"
                }
                Datagrams::FreeD => "protocol=opentrack|freed, head=CAMERA",
            },
            Self::Lsl(_) => {
                "x=LABEL, y=LABEL, z=LABEL, confidence=LABEL, least_confidence=0.6, lost=nan|zero, \
                 axes=right,up,back, camera=FX,FY,CX,CY, screen=WALL, pixels=COLUMNS,ROWS, \
                 origin=top|bottom, host=HOST"
            }
            Self::Stdin | Self::Lines(_) => "head=SENSOR",
        }
    }

    /// Returns whether its devices can have several sensors, one of them the viewer's head.
    pub(in crate::tracker) const fn has_sensors(&self) -> bool {
        !matches!(
            self,
            Self::Lsl(_)
                | Self::Datagrams {
                    protocol: Datagrams::Opentrack(_),
                    ..
                }
        )
    }

    /// Returns whether it measures the head, and whether it measures the eyes.
    pub(in crate::tracker) const fn senses(&self) -> [bool; 2] {
        match self {
            Self::Lsl(_) => [false, true],
            Self::Stdin | Self::Lines(_) => [true, true],
            _ => [true, false],
        }
    }

    /// Returns its kind's name.
    pub(in crate::tracker) const fn kind(&self) -> &'static str {
        match self {
            Self::Vrpn { .. } => "vrpn",
            Self::NatNet { .. } => "natnet",
            Self::Datagrams { protocol, .. } => match protocol {
                Datagrams::DTrack(_) => "dtrack",
                Datagrams::Opentrack(_) => "opentrack",
                Datagrams::FreeD => "freed",
            },
            Self::Lsl(_) => "lsl",
            Self::Stdin => "stdin",
            Self::Lines(_) => "tcp",
        }
    }

    /// Returns whether the device's clock is measured, or there is none: no unknown delay is left.
    pub(in crate::tracker) const fn knows_delay(&self) -> bool {
        matches!(self, Self::Lsl(_) | Self::NatNet { .. })
    }
}

impl fmt::Display for NetSpec {
    /// Its name in messages.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Vrpn { device, server, .. } => write!(f, "vrpn:{}@{server}", device.device),
            Self::Datagrams { listen, .. } => write!(f, "{} at UDP {listen}", self.kind()),
            Self::NatNet { server, .. } => write!(f, "natnet:{server}"),
            Self::Lsl(spec) => {
                let (name, kind) = (&spec.name, &spec.kind);
                write!(
                    f,
                    "lsl:{}",
                    name.as_ref().or(kind.as_ref()).map_or("", |one| one)
                )
            }
            Self::Stdin => f.write_str("standard input"),
            Self::Lines(server) => write!(f, "tcp:{server}"),
        }
    }
}

fn read_vrpn(target: &str, options: &mut Options<'_>) -> Result<NetSpec, Fault> {
    let help = "give the device's name, the server's host and, if it is not 3883, its port, such \
                as vrpn:Tracker0@192.168.1.5";
    let fault = || {
        Fault::new(
            format!("vrpn:{target} does not name a device of a host"),
            help,
        )
    };
    let (name, host) = target.split_once('@').ok_or_else(fault)?;
    let host = host.strip_prefix("tcp://").unwrap_or(host);
    let mut device = vrpn::Config::new(name).filter(|_| !name.is_empty());
    if let Some(device) = &mut device {
        device.axes = axes(options)?;
        let metres = &mut device.metres;
        options.word(metres, "unit", "m cm mm", [1.0, 1.0e-2, 1.0e-3])?;
    }
    Ok(NetSpec::Vrpn {
        device: device.ok_or_else(fault)?,
        server: server(host, Some(vrpn::PORT), "vrpn:Tracker0@192.168.1.5")?,
    })
}

fn datagrams(options: &mut Options<'_>) -> Result<Datagrams, Fault> {
    let allowed = "opentrack or freed";
    match options.take("protocol") {
        Some("freed") => Ok(Datagrams::FreeD),
        Some("opentrack") => {
            const NUMBERS: [&str; 6] = ["x", "y", "z", "yaw", "pitch", "roll"];
            let mut config = opentrack::Config::default();
            let some = "some of x, y, z, yaw, pitch and roll, such as yaw,roll";
            options.set(&mut config.reversed, "reversed", some, |value| {
                let mut reversed = [false; 6];
                for name in value.split(',') {
                    reversed[NUMBERS.iter().position(|one| *one == name)?] = true;
                }
                Some(reversed)
            })?;
            Ok(Datagrams::Opentrack(config))
        }
        Some(other) => Err(wrong("protocol", other, allowed)),
        None => Err(Fault::new(
            "udp: does not name the protocol of its datagrams",
            "append ?protocol=opentrack or ?protocol=freed; ART's controllers have dtrack:5000",
        )),
    }
}

fn read_lsl(target: &str, options: &mut Options<'_>) -> Result<LslSpec, Fault> {
    let mut wanted = Options::read(target)?;
    let text = |value: &str| {
        let is_text = !value.is_empty() && value.len() < 64;
        is_text.then(|| value.to_owned())
    };
    let mut spec = LslSpec::default();
    wanted.set(&mut spec.kind, "type", "the type of a stream", text)?;
    wanted.set(&mut spec.name, "name", "the name of a stream", text)?;
    wanted.end(
        "lsl",
        "type=Gaze or name=NAME, and other options after a ?",
        None,
    )?;
    if spec.kind.is_none() && spec.name.is_none() {
        return Err(Fault::new(
            "lsl: names no stream",
            "give lsl:type=Gaze or lsl:name=NAME; `shisen tracker list` shows those that are there",
        ));
    }
    options.set(&mut spec.host, "host", "the host of the stream", text)?;
    let gaze = &mut spec.gaze;
    let label = "the label of a channel, or its number from 0";
    for (axis, key) in gaze.axes.iter_mut().zip(["x", "y", "z"]) {
        options.set(axis, key, label, text)?;
    }
    options.set(&mut gaze.confidence, "confidence", label, text)?;
    let least = &mut gaze.least_confidence;
    options.number(least, "least_confidence", (0.0, 1.0), "0 to 1")?;
    options.word(&mut gaze.is_zero_lost, "lost", "nan zero", [false, true])?;
    options.word(&mut gaze.is_upward, "origin", "top bottom", [false, true])?;
    options.set(&mut gaze.directions, "axes", FRAME, directions)?;
    let camera = "focal lengths and principal point, pixels: FX,FY,CX,CY, such as 770,770,800,600";
    options.set(&mut gaze.camera, "camera", camera, |value| {
        numbers(value).filter(|camera: &[f64; 4]| camera[0] > 0.0 && camera[1] > 0.0)
    })?;
    options.set(&mut gaze.screen, "screen", "the name of a wall", text)?;
    let pixels = "the screen's columns and rows, such as 1920,1080";
    options.set(&mut gaze.pixels, "pixels", pixels, |value| {
        numbers(value).filter(|sides: &[f64; 2]| sides.iter().all(|side| *side >= 1.0))
    })?;
    if gaze.camera.is_some() && gaze.screen.is_some() {
        return Err(Fault::new(
            "camera and screen exclude each other",
            "x and y are pixels of a scene camera or of a screen: leave one out",
        ));
    }
    if gaze.pixels.is_some() && gaze.screen.is_none() {
        let help = "name the screen: screen=front";
        return Err(Fault::new("pixels are those of a screen", help));
    }
    Ok(spec)
}

/// Reads finite numbers between commas.
fn numbers<const N: usize>(value: &str) -> Option<[f64; N]> {
    let numbers: Result<Vec<f64>, _> = value.split(',').map(str::parse).collect();
    let numbers: [f64; N] = numbers.ok()?.try_into().ok()?;
    numbers
        .iter()
        .all(|number| number.is_finite())
        .then_some(numbers)
}

/// Takes `body`: a number is the head's sensor; returns a name.
fn take_body(options: &mut Options<'_>, head: &mut Option<u8>) -> Option<String> {
    let body = options.take("body")?;
    match body.parse() {
        Ok(number) => {
            *head = Some(number);
            None
        }
        Err(_) => Some(body.to_owned()),
    }
}

/// Takes the axes, which are ours unless they are given.
fn axes(options: &mut Options<'_>) -> Result<Axes, Fault> {
    let mut axes = Axes::SAME;
    set_frames(&mut axes, None, options)?;
    Ok(axes)
}

/// Reads `host`, `host:port` or `[address]:port`.
fn server(text: &str, usual: Option<u16>, example: &str) -> Result<Server, Fault> {
    let fault = || {
        let help = format!("give a host and, if it is not the usual one, a port: {example}");
        Fault::new(format!("{text:?} names no host and port"), help)
    };
    let (host, port) = match text.rsplit_once(':') {
        Some((host, port)) if !host.contains(':') || host.ends_with(']') => {
            let port = port.parse().ok().filter(|port| *port > 0);
            (host, Some(port.ok_or_else(fault)?))
        }
        _ => (text, usual),
    };
    let host = host.trim_start_matches('[').trim_end_matches(']');
    if host.is_empty() {
        return Err(fault());
    }
    Ok(Server {
        host: host.to_owned(),
        port: port.ok_or_else(fault)?,
    })
}

/// Reads `port`, of this machine alone, or `address:port`.
fn listen(text: &str, example: &str) -> Result<SocketAddr, Fault> {
    let port = text.parse().ok().filter(|port: &u16| *port > 0);
    let own = port.map(|port| SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), port));
    let given = own.or_else(|| text.parse().ok());
    given.ok_or_else(|| {
        let help = format!(
            "give a UDP port, as in {example}, which hears this machine alone, or an address of \
             this machine and a port: 0.0.0.0 is all of them"
        );
        Fault::new(format!("{text:?} is no port, nor address and port"), help)
    })
}

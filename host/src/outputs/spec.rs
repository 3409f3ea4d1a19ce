//! Which screen is shown on which monitor.

use crate::cave::{Eye, RoomError};
use crate::files::description::{FileError, Located, Source, UnknownName, read_description};
use crate::show::stereo::Stereo;
use serde::Deserialize;
use std::path::Path;
use std::str::FromStr;

/// A full-screen window: what it shows, where, and how.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Output {
    /// The name of a screen or a projector of the room.
    pub show: String,
    /// The name of a monitor of the X server, as `xrandr --listmonitors` has it, or of a connector,
    /// as the kernel has it.
    pub monitor: String,
    /// The X server; `None` for that of `DISPLAY`.
    pub server: Option<String>,
    /// How it shows two eyes; `None` as the command says.
    pub stereo: Option<Stereo>,
    /// The eye that it shows alone: for two projectors a screen with filters before them.
    pub eye: Option<Eye>,
    /// Whether the left eye's picture is where the right one's belongs.
    pub swap_eyes: bool,
    /// The corner of a square that is white in every other frame, for an instrument.
    pub sync_patch: Option<Corner>,
}

/// What shows the outputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Backend {
    /// Windows on X servers.
    X11,
    /// Connectors of graphics cards, by the Linux kernel's mode setting.
    Kms,
}

named!(Backend { X11 => "x11", Kms => "kms" });

/// Who places the window of an output.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Placing {
    /// The program alone: for projectors.
    Override,
    /// The window manager, which is asked for the full screen: for a desk.
    Managed,
}

named!(Placing { Override => "override", Managed => "managed" });

/// A corner of a monitor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names say it")]
pub enum Corner {
    UpperLeft,
    UpperRight,
    LowerLeft,
    LowerRight,
}

named!(Corner {
    UpperLeft => "upper-left",
    UpperRight => "upper-right",
    LowerLeft => "lower-left",
    LowerRight => "lower-right",
});

const SYNTAX: &str = "an output is an [[output]] with show (a screen or a projector) and monitor (names) and, if wanted, \
    server (such as \":0\"), stereo (mono, sequential, side-by-side, top-bottom or anaglyph), eye \
    (left or right), swap_eyes (true or false) and sync_patch (upper-left, upper-right, lower-left \
    or lower-right)";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entries {
    #[serde(default)]
    output: Vec<Entry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    show: String,
    monitor: String,
    server: Option<String>,
    stereo: Option<String>,
    eye: Option<String>,
    #[serde(default)]
    swap_eyes: bool,
    sync_patch: Option<String>,
}

impl Output {
    /// Reads a list such as `front=HDMI-1,right=DP-2`; `None` where the text is no such list.
    pub fn list(text: &str) -> Option<Vec<Self>> {
        let one = |pair: &str| {
            let (show, monitor) = pair.split_once('=')?;
            let (show, monitor) = (show.trim(), monitor.trim());
            (!show.is_empty() && !monitor.is_empty()).then(|| Self {
                show: show.to_owned(),
                monitor: monitor.to_owned(),
                server: None,
                stereo: None,
                eye: None,
                swap_eyes: false,
                sync_patch: None,
            })
        };
        text.split(',').map(one).collect()
    }

    /// Reads a file of outputs.
    ///
    /// ```toml
    /// [[output]]
    /// show = "front"              # a screen or a projector
    /// monitor = "HDMI-1"          # a name of `xrandr --listmonitors`
    /// server = ":0"               # optional: DISPLAY
    /// stereo = "side-by-side"     # optional: as --stereo says
    /// eye = "left"                # optional: this eye alone
    /// swap_eyes = false           # optional
    /// sync_patch = "lower-left"   # optional: a square that blinks with the frames
    /// ```
    ///
    /// # Errors
    /// A file that cannot be read, or the first fault and its place: text that is not TOML,
    /// unknown or missing keys, no output, a value that is none of those allowed.
    pub fn load(path: &Path) -> Result<Vec<Self>, FileError<RoomError>> {
        let help = "give NAME=MONITOR,… or the path of a TOML file of outputs";
        let text = read_description(path, "the outputs", help)?;
        Ok(Self::from_toml(&text, &path.to_string_lossy())?)
    }

    /// As [`Self::load`], from the text of a file; `name` is what messages call it.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub fn from_toml(text: &str, name: &str) -> Result<Vec<Self>, Located<RoomError>> {
        let source = Source { name, text };
        let entries: Entries =
            source.parse(SYNTAX, |message, help| RoomError::new("", message, help))?;
        if entries.output.is_empty() {
            let message = "the file describes no outputs".to_owned();
            let help = "add an [[output]] with show and monitor";
            return Err(Located::new(
                RoomError::new("", message, help),
                &source,
                None,
            ));
        }
        let outputs = entries.output.into_iter().enumerate();
        let outputs = outputs.map(|(number, entry)| {
            entry.output().map_err(|fault| {
                let span = source.span_of(Some(("output", number)), fault.key);
                Located::new(fault, &source, span)
            })
        });
        outputs.collect()
    }

    /// Checks that outputs show screens or projectors of these names, each monitor once.
    ///
    /// # Errors
    /// The first output that does not.
    pub fn check(outputs: &[Self], names: &[&str]) -> Result<(), RoomError> {
        for (number, output) in outputs.iter().enumerate() {
            let (show, monitor) = (&output.show, &output.monitor);
            if !names.contains(&show.as_str()) {
                return Err(RoomError::new(
                    "show",
                    format!("monitor {monitor} is to show \"{show}\", which there is not"),
                    format!("there are {}", names.join(", ")),
                ));
            }
            let same = |one: &&Self| one.monitor == *monitor && one.display() == output.display();
            if let Some(other) = outputs[..number].iter().find(same) {
                return Err(RoomError::new(
                    "monitor",
                    format!(
                        "monitor {monitor} is to show \"{}\" and \"{show}\"",
                        other.show
                    ),
                    "give each output a monitor of its own; xrandr --listmonitors names them",
                ));
            }
        }
        Ok(())
    }

    /// Returns its X server by the shortest name.
    fn display(&self) -> Option<String> {
        let given = self
            .server
            .clone()
            .or_else(|| std::env::var("DISPLAY").ok());
        given.map(|name| name.strip_suffix(".0").unwrap_or(&name).to_owned())
    }
}

impl Entry {
    fn output(self) -> Result<Output, RoomError> {
        let eye = read("eye", self.eye.as_deref(), "left or right", |name| {
            Eye::STEREO.into_iter().find(|eye| eye.name() == name)
        })?;
        let formats = "mono, sequential, side-by-side, top-bottom or anaglyph";
        let stereo = read("stereo", self.stereo.as_deref(), formats, |name| {
            name.parse().ok()
        })?;
        let corners = "upper-left, upper-right, lower-left or lower-right";
        let sync_patch = read("sync_patch", self.sync_patch.as_deref(), corners, |name| {
            Corner::ALL.into_iter().find(|corner| corner.name() == name)
        })?;
        if let (Some(eye), Some(stereo)) = (eye, stereo) {
            return Err(RoomError::new(
                "eye",
                format!("an output shows the {eye} eye alone and both by {stereo}"),
                "give eye or stereo",
            ));
        }
        Ok(Output {
            show: self.show,
            monitor: self.monitor,
            server: self.server,
            stereo,
            eye,
            swap_eyes: self.swap_eyes,
            sync_patch,
        })
    }
}

fn read<T>(
    key: &'static str,
    given: Option<&str>,
    known: &'static str,
    find: impl Fn(&str) -> Option<T>,
) -> Result<Option<T>, RoomError> {
    let value = given.map(|name| {
        find(name).ok_or_else(|| {
            let (kind, given) = (key, name.into());
            let message = UnknownName { kind, given, known }.to_string();
            RoomError::new(key, message, format!("give {known}"))
        })
    });
    value.transpose()
}

/// `--outputs`: a list, or a file.
#[derive(Debug, Clone)]
pub enum OutputsName {
    /// `NAME=MONITOR,…`.
    List(Vec<Output>),
    /// A TOML file.
    File(std::path::PathBuf),
}

impl FromStr for OutputsName {
    type Err = std::convert::Infallible;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Ok(Output::list(text).map_or_else(|| Self::File(text.into()), Self::List))
    }
}

impl OutputsName {
    /// Returns the outputs.
    ///
    /// # Errors
    /// As [`Output::load`].
    pub fn load(&self) -> Result<Vec<Output>, FileError<RoomError>> {
        match self {
            Self::List(list) => Ok(list.clone()),
            Self::File(path) => Output::load(path),
        }
    }
}

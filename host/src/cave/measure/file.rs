//! Files of measured rooms.

use super::{Corner, MeasuredWall, Measurement, Odds, Quantity, RoomError, Survey};
use crate::files::description::{FileError, Located, Source, read_description};
use glam::DVec3;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;
use toml::Spanned;

const SYNTAX: &str = "a wall is a [[wall]] with name, corners (\"A B F E\": lower left, lower right, \
    upper right, upper left, as its viewer sees them) and, if wanted, flat_mm and pixels; \
    [lengths_m] has lines such as AB = 3.003 or AB = { m = 3.003, sigma_mm = 5 }, [heights_m] lines \
    such as A = 0.512 or AB = 0.002; tape_mm and level_mm, before all tables, are their standard \
    deviations";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SurveyEntry {
    #[serde(default = "tape")]
    tape_mm: f64,
    #[serde(default = "level")]
    level_mm: f64,
    #[serde(default)]
    wall: Vec<WallEntry>,
    #[serde(default)]
    lengths_m: BTreeMap<String, Spanned<Value>>,
    #[serde(default)]
    heights_m: BTreeMap<String, Spanned<Value>>,
}

fn tape() -> f64 {
    2.0
}

fn level() -> f64 {
    1.0
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WallEntry {
    name: String,
    corners: String,
    flat_mm: Option<f64>,
    pixels: Option<[u32; 2]>,
}

#[derive(Deserialize, Clone, Copy)]
#[serde(
    untagged,
    expecting = "a value is metres, such as 3.003, or { m = 3.003, sigma_mm = 5 }"
)]
enum Value {
    Metres(f64),
    Own(OwnSigma),
}

#[derive(Deserialize, Clone, Copy)]
#[serde(deny_unknown_fields)]
struct OwnSigma {
    m: f64,
    sigma_mm: f64,
}

/// A fault and its place in the file.
type Placed = (RoomError, Option<Range<usize>>);

impl Survey {
    /// Most corners.
    const MOST_CORNERS: usize = 32;
    /// Largest distance, metres.
    const LONGEST: f64 = 200.0;

    /// Reads a file of a measured room and finds its corners.
    ///
    /// # Errors
    /// A file that cannot be read, or as [`Self::from_toml`].
    pub fn load(path: &Path) -> Result<Self, FileError<RoomError>> {
        let help = "give the path of a TOML file of walls and lengths: see shisen room measure \
                    --help";
        let text = read_description(path, "the measured room", help)?;
        Ok(Self::from_toml(&text, &path.to_string_lossy())?)
    }

    /// As [`Self::load`], from the text of a file; `name` is what messages call it.
    ///
    /// # Errors
    /// The first fault and its place: text that is not TOML; unknown or missing keys; a wall
    /// without a usable name or four corners; a length of an unknown corner, given twice, that is
    /// no distance, or longer than the way round; corners that lengths do not tie down; lengths
    /// that do not fit together; walls that turn their backs.
    pub fn from_toml(text: &str, name: &str) -> Result<Self, Located<RoomError>> {
        let source = Source { name, text };
        let entries: SurveyEntry =
            source.parse(SYNTAX, |message, help| RoomError::new("", message, help))?;
        let survey = Self::read(entries, &source);
        let survey = survey.map_err(|(fault, span)| Located::new(fault, &source, span))?;
        survey.solve().map_err(|(fault, wall)| {
            let span = source.span_of(wall.map(|number| ("wall", number)), fault.key);
            Located::new(fault, &source, span)
        })
    }

    fn read(entries: SurveyEntry, source: &Source<'_>) -> Result<Self, Placed> {
        for (key, millimetres) in [("tape_mm", entries.tape_mm), ("level_mm", entries.level_mm)] {
            check_sigma(key, millimetres).map_err(|fault| (fault, source.span_of(None, key)))?;
        }
        let mut survey = Self {
            corners: Vec::new(),
            walls: Vec::new(),
            measurements: Vec::new(),
            odds: Odds::default(),
            unknowns: 0,
        };
        let mut flatness = Vec::new();
        for (number, wall) in entries.wall.into_iter().enumerate() {
            let flat = survey.add_wall(wall).map_err(|fault| {
                let span = source.span_of(Some(("wall", number)), fault.key);
                (fault, span)
            })?;
            flatness.extend(flat);
        }
        if survey.walls.is_empty() {
            let fault = RoomError::new("", "the file describes no walls".to_owned(), SYNTAX);
            return Err((fault, None));
        }
        let level = survey.corners.len();
        let mut spans = Vec::new();
        for (is_height, table, sigma) in [
            (false, entries.lengths_m, entries.tape_mm),
            (true, entries.heights_m, entries.level_mm),
        ] {
            let mut values: Vec<_> = table.into_iter().collect();
            values.sort_by_key(|(_, value)| value.span().start);
            let first = survey.measurements.len();
            for (name, value) in values {
                let span = value.span();
                let one =
                    survey.measurement(name, *value.get_ref(), is_height.then_some(level), sigma);
                let one = one.and_then(|one| survey.check_new(one, first));
                survey
                    .measurements
                    .push(one.map_err(|fault| (fault, Some(span.clone())))?);
                spans.push(span);
            }
        }
        if let Some((fault, number)) = survey.broken_triangle() {
            return Err((fault, spans.get(number).cloned()));
        }
        survey.measurements.append(&mut flatness);
        Ok(survey)
    }

    /// Adds a wall and its corners. Returns the measurement of its flatness.
    fn add_wall(&mut self, entry: WallEntry) -> Result<Option<Measurement>, RoomError> {
        RoomError::check_name(
            "wall",
            &entry.name,
            "pictures are named after their walls",
            "front",
        )?;
        let wall = format!("wall \"{}\"", entry.name);
        let lower_case = entry.name.to_lowercase();
        if self
            .walls
            .iter()
            .any(|other| other.name.to_lowercase() == lower_case)
        {
            let help = "give each wall its own name, different in more than upper and lower case";
            let message = format!("two walls are named \"{}\"", entry.name);
            return Err(RoomError::new("name", message, help));
        }
        if let Some(pixels) = entry.pixels {
            RoomError::check_pixels("pixels", format_args!("{wall}"), pixels)?;
        }
        let names: Vec<&str> = entry.corners.split_whitespace().collect();
        let is_name = |name: &&str| name.chars().all(|c| c.is_ascii_alphanumeric());
        let wrong = |message: String| {
            RoomError::new(
                "corners",
                message,
                "for example, corners = \"A B F E\": lower left, lower right, upper right, upper \
                 left, as the wall's viewer sees them; a name is letters and digits",
            )
        };
        let (&[a, b, c, d], true) = (names.as_slice(), names.iter().all(is_name)) else {
            return Err(wrong(format!(
                "{wall} is not between four corners: \"{}\"",
                entry.corners.escape_debug()
            )));
        };
        if let Some(twice) = [(a, b), (a, c), (a, d), (b, c), (b, d), (c, d)]
            .into_iter()
            .find(|(one, other)| one == other)
        {
            return Err(wrong(format!("{wall} has corner {} twice", twice.0)));
        }
        let corners = [a, b, c, d].map(|name| {
            let known = self.number(name);
            known.unwrap_or_else(|| {
                self.corners.push(Corner {
                    name: name.to_owned(),
                    position: DVec3::ZERO,
                    sigma: 0.0,
                });
                self.corners.len() - 1
            })
        });
        if self.corners.len() > Self::MOST_CORNERS {
            return Err(wrong(format!(
                "{wall} brings the corners to more than {}",
                Self::MOST_CORNERS
            )));
        }
        if let Some(millimetres) = entry.flat_mm {
            check_sigma("flat_mm", millimetres)?;
        }
        self.walls.push(MeasuredWall {
            name: entry.name,
            corners,
            pixels: entry.pixels,
        });
        let separator = if names.iter().all(|name| name.len() == 1) {
            ""
        } else {
            "-"
        };
        Ok(entry.flat_mm.map(|millimetres| {
            let name = names.join(separator);
            Measurement::new(name, Quantity::Flatness(corners), 0.0, millimetres)
        }))
    }

    fn number(&self, corner: &str) -> Option<usize> {
        self.corners.iter().position(|known| known.name == corner)
    }

    /// Reads a length or, over the corner `level` where the name has one corner, a height.
    fn measurement(
        &self,
        name: String,
        value: Value,
        level: Option<usize>,
        sigma_mm: f64,
    ) -> Result<Measurement, RoomError> {
        let key = if level.is_some() {
            "heights_m"
        } else {
            "lengths_m"
        };
        let fault = |message, help: &str| RoomError::new(key, message, help);
        let between = match name.split_once('-') {
            Some(ends) => Some(ends),
            None if name.chars().count() == 2 => Some(name.split_at(1)),
            None => None,
        };
        let number = |corner: &str| {
            self.number(corner).ok_or_else(|| {
                let known: Vec<&str> = self.corners.iter().map(|one| one.name.as_str()).collect();
                let help = format!("the walls' corners are {}", known.join(", "));
                fault(format!("{name}: no wall has a corner {corner}"), &help)
            })
        };
        let ends = match (self.number(&name), level, between) {
            (Some(corner), Some(level), _) => [level, corner],
            (_, _, Some((from, to))) => [number(from)?, number(to)?],
            _ => {
                let help = "write AB from corner A to corner B, or A1-B1 where names are longer";
                return Err(fault(format!("{name} does not name two corners"), help));
            }
        };
        if ends[0] == ends[1] {
            let help = "name two different corners";
            return Err(fault(format!("{name} is from a corner to itself"), help));
        }
        let (metres, sigma_mm) = match value {
            Value::Metres(metres) => (metres, sigma_mm),
            Value::Own(own) => (own.m, own.sigma_mm),
        };
        check_sigma("sigma_mm", sigma_mm)?;
        let least = if level.is_some() {
            -Self::LONGEST
        } else {
            0.001
        };
        if !(least..=Self::LONGEST).contains(&metres) {
            let most = Self::LONGEST;
            let help = format!("give metres from {least} to {most}: 3003 mm are 3.003");
            return Err(fault(format!("{name} is {metres} m"), &help));
        }
        let quantity = match level {
            Some(_) => Quantity::Height(ends),
            None => Quantity::Length(ends),
        };
        Ok(Measurement::new(name, quantity, metres, sigma_mm))
    }

    /// Refuses what one of the measurements from `first` on gives already.
    fn check_new(&self, new: Measurement, first: usize) -> Result<Measurement, RoomError> {
        let ends = |one: &Measurement| match one.quantity {
            Quantity::Length([a, b]) | Quantity::Height([a, b]) => [a.min(b), a.max(b)],
            Quantity::Flatness(_) => [0; 2],
        };
        let mut others = self.measurements.iter().skip(first);
        match others.rfind(|other| ends(other) == ends(&new)) {
            None => Ok(new),
            Some(other) => Err(RoomError::new(
                "lengths_m",
                format!("{} is given already, as {}", new.name, other.name),
                "leave one of the two out, or write their mean",
            )),
        }
    }

    /// Returns the fault of the length that is longest beside two others between its ends, and the
    /// length's number.
    fn broken_triangle(&self) -> Option<(RoomError, usize)> {
        let lengths = self.measurements.iter();
        let lengths = lengths.map_while(|one| match one.quantity {
            Quantity::Length(ends) => Some((ends, one)),
            _ => None,
        });
        let lengths: Vec<_> = lengths.collect();
        let find = |a, b| {
            let mut all = lengths.iter();
            let found = all.find(|(ends, _)| *ends == [a, b] || *ends == [b, a]);
            found.map(|(_, one)| *one)
        };
        let mut worst = None;
        let mut most = 0.0;
        for (number, &([from, to], long)) in lengths.iter().enumerate() {
            for corner in 0..self.corners.len() {
                let (Some(first), Some(second)) = (find(from, corner), find(corner, to)) else {
                    continue;
                };
                let slack = 5.0 * (long.sigma + first.sigma + second.sigma);
                let excess = long.measured - first.measured - second.measured - slack;
                if excess > most {
                    most = excess;
                    worst = Some((number, [long, first, second]));
                }
            }
        }
        let (number, [long, first, second]) = worst?;
        let message = format!(
            "{}, {} and {} make no triangle: {} m is longer than {} m and {} m together",
            long.name, first.name, second.name, long.measured, first.measured, second.measured
        );
        let help = "compare the three with what the tape says, or measure them again";
        Some((RoomError::new("lengths_m", message, help), number))
    }
}

impl Measurement {
    fn new(name: String, quantity: Quantity, measured: f64, sigma_mm: f64) -> Self {
        Self {
            name,
            quantity,
            measured,
            sigma: sigma_mm / 1000.0,
            residual: 0.0,
            standardised: 0.0,
            redundancy: 0.0,
        }
    }
}

fn check_sigma(key: &'static str, millimetres: f64) -> Result<(), RoomError> {
    if (0.01..=1000.0).contains(&millimetres) {
        return Ok(());
    }
    Err(RoomError::new(
        key,
        format!("{key} is {millimetres}"),
        "give a standard deviation of 0.01 to 1000 mm: 2 for a tape, 1 for a level, 3 or more for \
         the flatness of a wall",
    ))
}

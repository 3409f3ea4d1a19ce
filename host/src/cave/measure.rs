//! Corners of walls from lengths that a tape gives, by least squares.
//!
//! [`Survey::load`] reads a file of walls by the names of their corners, and of lengths, heights
//! and flatness:
//!
//! ```toml
//! tape_mm = 2                 # optional: standard deviation of a length
//! level_mm = 1                # optional: of a height
//!
//! [[wall]]
//! name = "front"
//! corners = "A B F E"         # lower left, lower right, upper right, upper left, as viewed
//! flat_mm = 3                 # optional: standard deviation of its flatness, else not assumed
//! pixels = [1920, 1200]       # optional
//!
//! [lengths_m]                 # edges and diagonals of walls, of the floor, of the room
//! AB = 3.003
//! AG = { m = 4.871, sigma_mm = 5 }
//!
//! [heights_m]
//! A = 0.512                   # over the line of a levelled laser
//! AB = 0.002                  # or of B over A
//! ```
//!
//! The first wall is upright and faces +Z. Its lower left corner is the origin, its lower right
//! one is at z = 0, and heights say which way is up. Nothing else is assumed: a wall need not be
//! a rectangle, nor flat.

mod adjust;
mod eigen;
mod file;
mod start;

use super::{Cave, RoomError, Wall};
use adjust::Adjusted;
use glam::DVec3;

/// A measured room and its corners.
#[derive(Debug, Clone, PartialEq)]
pub struct Survey {
    /// In the order in which the walls name them.
    pub corners: Vec<Corner>,
    /// In the order of the file.
    pub walls: Vec<MeasuredWall>,
    /// Lengths, heights, flatness, each in the order of the file.
    pub measurements: Vec<Measurement>,
    /// How sure it is that a wrong length stands out.
    pub odds: Odds,
    /// Number of unknown coordinates.
    pub unknowns: usize,
}

/// A corner of walls.
#[derive(Debug, Clone, PartialEq)]
pub struct Corner {
    /// Name in lengths and messages.
    pub name: String,
    /// Metres from the first wall's lower left corner.
    pub position: DVec3,
    /// Standard deviation of the position, metres: square root of the mean of the axes' squares.
    pub sigma: f64,
}

/// A wall between four corners.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredWall {
    /// Name for file names and messages.
    pub name: String,
    /// Numbers of its lower left, lower right, upper right and upper left corner, as its viewer
    /// sees them.
    pub corners: [usize; 4],
    /// Columns and rows, if the file says.
    pub pixels: Option<[u32; 2]>,
}

/// What was measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Quantity {
    /// The distance of two corners.
    Length([usize; 2]),
    /// The height of the second corner over the first, or over the level's line.
    Height([usize; 2]),
    /// The distance of a wall's third corner from the plane of the others, on its viewer's side.
    Flatness([usize; 4]),
}

/// A measurement and how well it fits.
#[derive(Debug, Clone, PartialEq)]
pub struct Measurement {
    /// Name: that of the file, or for flatness those of the wall's corners.
    pub name: String,
    /// What was measured.
    pub quantity: Quantity,
    /// Metres.
    pub measured: f64,
    /// Standard deviation, metres.
    pub sigma: f64,
    /// The value at the adjusted corners less the measured one, metres.
    pub residual: f64,
    /// The residual by its own standard deviation; 0 where [`Self::redundancy`] is too small.
    pub standardised: f64,
    /// The share of an error that shows in the measurement's own residual, 0 to 1.
    pub redundancy: f64,
}

/// What becomes of a slip of [`Self::SLIP`] in one length, while all others are as exact as their
/// standard deviations: shares of simulated trials, 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Odds {
    /// The right length alone is named.
    pub alone: f64,
    /// The right length is named with others.
    pub among: f64,
    /// Wrong lengths are named.
    pub wrong: f64,
}

impl Odds {
    /// The slip, metres.
    pub const SLIP: f64 = 0.03;
    /// Number of trials.
    pub const TRIALS: u64 = 600;
    /// Standard deviation of walls' flatness in the trials, metres: real walls are less flat than
    /// their files say, and flatness that is believed hides the length that is wrong.
    const UNFLAT: f64 = 0.01;
}

impl Survey {
    /// Standardised residual from which a measurement stands out: good sets of measurements stay
    /// below it in 19 of 20 cases.
    pub const NOTICEABLE: f64 = 2.8;
    /// Measurements whose standardised residual is this share of the largest stand out with it.
    const TIED: f64 = 0.9;
    /// Redundancy below which nothing checks a measurement.
    pub const UNCHECKED: f64 = 0.01;
    /// Largest standard deviation of a corner that counts as tied down, metres.
    const LOOSE: f64 = 0.1;
    /// Largest residual that can be a slip of the tape and not of the pen, metres.
    const CONTRADICTION: f64 = 0.25;

    /// Returns the numbers of the measurements that stand out, the largest residual first: these
    /// are to be measured again.
    pub fn suspects(&self) -> Vec<usize> {
        suspects(self.measurements.iter().map(|one| one.standardised))
    }

    /// Returns the distance of the upper right corner of a wall from where a parallelogram of the
    /// other three has it, metres.
    pub fn deviation(&self, wall: &MeasuredWall) -> f64 {
        let [lower_left, lower_right, upper_right, upper_left] = self.places(wall);
        (lower_left - lower_right + upper_right - upper_left).length()
    }

    fn places(&self, wall: &MeasuredWall) -> [DVec3; 4] {
        wall.corners.map(|corner| self.corners[corner].position)
    }

    /// Returns the middle of all corners, metres.
    pub fn middle(&self) -> DVec3 {
        middle(self.corners.iter().map(|corner| corner.position))
    }

    /// Returns the room, with `origin` (metres, as the corners) at its origin. Each wall is the
    /// parallelogram nearest to its four corners: each of them moves by a quarter of
    /// [`Self::deviation`]. Walls without pixels have `size`.
    ///
    /// # Errors
    /// As [`Cave::new`].
    pub fn cave(&self, origin: DVec3, size: [u32; 2]) -> Result<Cave, RoomError> {
        let walls = self.walls.iter().map(|wall| {
            let [lower_left, lower_right, upper_right, upper_left] = self.places(wall);
            let across = 0.5 * (lower_right - lower_left + upper_right - upper_left);
            let upward = 0.5 * (upper_left - lower_left + upper_right - lower_right);
            let middle = middle(self.places(wall).into_iter());
            let corner = middle - origin - 0.5 * (across + upward);
            Wall {
                name: wall.name.clone(),
                lower_left: corner,
                lower_right: corner + across,
                upper_left: corner + upward,
                pixels: wall.pixels.unwrap_or(size),
            }
        });
        Cave::new(walls.collect())
    }

    /// Returns [`Self::cave`] as the text of a room's file.
    ///
    /// # Errors
    /// As [`Cave::new`].
    pub fn to_toml(&self, origin: DVec3) -> Result<String, RoomError> {
        let cave = self.cave(origin, [1; 2])?;
        let walls = cave.walls.iter().zip(&self.walls);
        let entries = walls.map(|(wall, measured)| wall.to_toml(measured.pixels));
        Ok(entries.collect::<Vec<_>>().join("\n"))
    }

    /// Finds the corners of a survey whose lengths are read and which has none so far.
    ///
    /// # Errors
    /// What is wrong, and the number of the wall with which it is.
    fn solve(mut self) -> Result<Self, (RoomError, Option<usize>)> {
        let anywhere = |fault| (fault, None);
        self.check_counts().map_err(anywhere)?;
        let mut places = start::first_guess(&self).map_err(anywhere)?;
        let count = places.len();
        let heights = self.measurements.iter();
        let over_level = heights.filter_map(|one| match one.quantity {
            Quantity::Height([from, to]) if from == count => Some(places[to].y - one.measured),
            _ => None,
        });
        let over_level: Vec<f64> = over_level.collect();
        // All but the first corner and z of the second: heights say how the room is tipped.
        let mut free: Vec<usize> = (3..3 * count).filter(|&axis| axis != 5).collect();
        if !over_level.is_empty() {
            // The level's line is one more corner, of which only the height counts.
            free.push(3 * count + 1);
            let height = over_level.iter().sum::<f64>() / over_level.len() as f64;
            places.push(DVec3::new(0.0, height, 0.0));
        }
        let adjusted = Adjusted::new(&self.measurements, places, &free);
        self.unknowns = free.len();
        self.check_tied(&adjusted).map_err(anywhere)?;
        for (number, corner) in self.corners.iter_mut().enumerate() {
            corner.position = adjusted.places[number];
            corner.sigma = adjusted.sigma(number);
        }
        let propagation = adjusted.propagation();
        for (number, one) in self.measurements.iter_mut().enumerate() {
            let redundancy = propagation[number][number].clamp(0.0, 1.0);
            one.residual = adjusted.residuals[number] * one.sigma;
            one.redundancy = redundancy;
            one.standardised = standardised(adjusted.residuals[number], redundancy);
        }
        self.check_fit().map_err(anywhere)?;
        for (number, wall) in self.walls.iter().enumerate() {
            let checked = self.check_wall(wall, number == 0);
            checked.map_err(|fault| (fault, Some(number)))?;
        }
        self.odds = self.odds_of(&propagation);
        Ok(self)
    }

    fn check_counts(&self) -> Result<(), RoomError> {
        for (number, corner) in self.corners.iter().enumerate() {
            let ties = self.measurements.iter().filter(|one| match one.quantity {
                Quantity::Length(ends) | Quantity::Height(ends) => ends.contains(&number),
                Quantity::Flatness(corners) => corners.contains(&number),
            });
            let ties = ties.count();
            if ties < 3 {
                return Err(RoomError::new(
                    "lengths_m",
                    format!(
                        "corner {} is not tied down: it has {ties} of at least 3 measurements",
                        corner.name
                    ),
                    "measure its distances to three more corners that are not in one plane with \
                     it: along edges and across walls, the floor and the room",
                ));
            }
        }
        let heights = self.measurements.iter();
        let heights = heights.filter(|one| matches!(one.quantity, Quantity::Height(_)));
        if heights.count() < 2 {
            return Err(RoomError::new(
                "heights_m",
                "nothing says which way is up".to_owned(),
                "set up a levelled laser and write how high over its line three corners are that \
                 are not in one line, as in [heights_m] A = 0.512",
            ));
        }
        Ok(())
    }

    /// Names the corners that could be elsewhere without any measurement's noticing.
    fn check_tied(&self, adjusted: &Adjusted) -> Result<(), RoomError> {
        let Some((sigma, moves)) = adjusted.loosest() else {
            return Ok(());
        };
        if sigma < Self::LOOSE {
            return Ok(());
        }
        let largest = moves.iter().map(|one| one.length()).fold(0.0, f64::max);
        let named = self.corners.iter().zip(moves);
        let named = named.filter(|(_, moved)| moved.length() > 0.3 * largest);
        let (names, moves): (Vec<_>, Vec<_>) = named
            .map(|(corner, moved)| (corner.name.as_str(), moved.abs()))
            .unzip();
        if 2 * names.len() > self.corners.len() {
            return Err(RoomError::new(
                "heights_m",
                "the room can tip, or bend as a whole, without any measurement's changing"
                    .to_owned(),
                "add to [heights_m] until three corners have heights that are not in one line, \
                 and diagonals of each wall, the floor and the room to [lengths_m]",
            ));
        }
        let most = moves.into_iter().sum::<DVec3>();
        let direction = match most.max_position() {
            0 => "to the left and right",
            1 => "up and down",
            _ => "to the front and back",
        };
        let (noun, verb) = match names.len() {
            1 => ("corner", "is"),
            _ => ("corners", "are"),
        };
        Err(RoomError::new(
            "lengths_m",
            format!(
                "{noun} {} {verb} not tied down {direction}",
                names.join(", ")
            ),
            "six lengths of one wall do not say whether it is flat: add diagonals through the \
             room, heights by a level, or flat_mm of that wall",
        ))
    }

    /// Refuses lengths that are wrong by more than a tape can be.
    fn check_fit(&self) -> Result<(), RoomError> {
        let sizes = self.measurements.iter().map(|one| one.residual.abs());
        // What is not a number does not fit either.
        if sizes.clone().all(|size| size <= Self::CONTRADICTION) {
            return Ok(());
        }
        let largest = sizes.fold(0.0, f64::max);
        let mut order: Vec<&Measurement> = self.measurements.iter().collect();
        order.sort_by(|a, b| b.standardised.abs().total_cmp(&a.standardised.abs()));
        let names: Vec<&str> = order.iter().take(3).map(|one| one.name.as_str()).collect();
        Err(RoomError::new(
            "lengths_m",
            format!("the measurements do not fit together: one is {largest:.2} m off"),
            format!(
                "compare {} with what the tape says: those fit worst, in this order",
                names.join(", ")
            ),
        ))
    }

    /// Refuses a wall whose corners are in another order than it says.
    fn check_wall(&self, wall: &MeasuredWall, is_first: bool) -> Result<(), RoomError> {
        let places = self.places(wall);
        let [normal, turns @ ..] = [0, 1, 2, 3].map(|corner| {
            let [before, here, after] = [corner + 3, corner, corner + 1].map(|i| places[i % 4]);
            (here - before).cross(after - here)
        });
        let order = "name its corners in this order: lower left, lower right, upper right, upper \
                     left, as its viewer sees them";
        let name = &wall.name;
        let (message, help) = if turns.iter().any(|turn| turn.dot(normal) <= 0.0) {
            (
                format!("the corners of wall \"{name}\" do not go round it"),
                order,
            )
        } else if start::facing(places, self.middle()) < -Self::LOOSE {
            (
                format!("wall \"{name}\" turns its back to the room: its corners go clockwise"),
                order,
            )
        } else if is_first && (places[3] - places[0]).normalize().y < 0.5 {
            (
                format!("the first wall, \"{name}\", is not upright"),
                "put an upright wall first: it is the room's front",
            )
        } else {
            return Ok(());
        };
        Err(RoomError::new("corners", message, help))
    }

    fn odds_of(&self, propagation: &[Vec<f64>]) -> Odds {
        let lengths = self.measurements.iter().enumerate();
        let lengths = lengths.filter(|(_, one)| matches!(one.quantity, Quantity::Length(_)));
        let lengths: Vec<usize> = lengths.map(|(number, _)| number).collect();
        let mut odds = Odds::default();
        for trial in 0..Odds::TRIALS {
            let slipped = lengths[trial as usize % lengths.len()];
            let count = self.measurements.len() as u64;
            let errors = self.measurements.iter().zip(0..).map(|(one, number)| {
                let is_flatness = matches!(one.quantity, Quantity::Flatness(_));
                let larger = if is_flatness {
                    Odds::UNFLAT / one.sigma
                } else {
                    1.0
                };
                larger.max(1.0) * noise(trial, number)
            });
            let mut errors: Vec<f64> = errors.collect();
            let sign = noise(trial, count).signum();
            errors[slipped] += sign * Odds::SLIP / self.measurements[slipped].sigma;
            let residuals = propagation.iter().enumerate().map(|(number, row)| {
                let sum = row.iter().zip(&errors).map(|(part, error)| part * error);
                standardised(sum.sum(), row[number])
            });
            let named = suspects(residuals);
            let share = match (named.contains(&slipped), named.len()) {
                (true, 1) => &mut odds.alone,
                (true, _) => &mut odds.among,
                (false, 1..) => &mut odds.wrong,
                (false, 0) => continue,
            };
            *share += 1.0 / Odds::TRIALS as f64;
        }
        odds
    }
}

/// Returns a whitened residual by its own standard deviation.
fn standardised(residual: f64, redundancy: f64) -> f64 {
    if redundancy < Survey::UNCHECKED {
        0.0
    } else {
        residual / redundancy.sqrt()
    }
}

/// As [`Survey::suspects`], from standardised residuals.
fn suspects(standardised: impl Iterator<Item = f64>) -> Vec<usize> {
    let sizes: Vec<f64> = standardised.map(f64::abs).collect();
    let largest = sizes.iter().copied().fold(0.0, f64::max);
    let least = Survey::NOTICEABLE.max(Survey::TIED * largest);
    let mut named: Vec<usize> = (0..sizes.len()).filter(|&i| sizes[i] >= least).collect();
    named.sort_by(|&a, &b| sizes[b].total_cmp(&sizes[a]));
    named
}

/// Returns nearly normal noise of standard deviation 1, the same for the same numbers.
fn noise(trial: u64, number: u64) -> f64 {
    let bits = xxhash_rust::xxh3::xxh3_64_with_seed(&number.to_le_bytes(), trial);
    // Four uniform parts have a variance of a third.
    let parts = [0, 16, 32, 48].map(|shift| f64::from((bits >> shift) as u16) / 65_536.0 - 0.5);
    3f64.sqrt() * parts.into_iter().sum::<f64>()
}

fn middle(places: impl ExactSizeIterator<Item = DVec3>) -> DVec3 {
    let count = places.len() as f64;
    places.sum::<DVec3>() / count
}

#[cfg(test)]
mod tests;

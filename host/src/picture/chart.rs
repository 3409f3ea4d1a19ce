//! Charts of lines: as a picture for people and as numbers for programs.

mod axis;

pub use axis::Axis;

use crate::files::write_atomically;
use plotters::coord::Shift;
use plotters::coord::ranged1d::{AsRangedCoord, Ranged, ValueFormatter};
use plotters::element::{Circle, EmptyElement, PathElement, Text};
use plotters::prelude::{
    ChartBuilder, DrawingArea, DrawingAreaErrorKind, IntoDrawingArea, IntoLogRange, LineSeries,
    RGBColor, SVGBackend, SeriesLabelPosition,
};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{BLACK, Color, IntoTextStyle, ShapeStyle, WHITE};
use std::fmt::Write as _;
use std::io;
use std::ops::Range;
use std::path::Path;

const SIZE: [u32; 2] = [800, 500];

/// Drawing units a pixel: `plotters` has whole numbers only, and steps would show.
const PARTS: u32 = 10;

/// The length of the line beside a name.
const KEY: i32 = 22 * PARTS as i32;

/// Names below a chart that stand beside each other, and the height of a row of them.
const NAMES_A_ROW: usize = 3;
const NAME_ROW: u32 = 20;

const DOT: u32 = 5 * PARTS;

/// Okabe and Ito's colours, which people with any kind of colour vision can distinguish.
pub(crate) const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(90, 90, 90),
];

/// A chart.
#[derive(Debug, Clone)]
pub struct Chart {
    /// The title, above the chart.
    pub title: String,
    /// The axis to the right.
    pub x: Axis,
    /// The axis upwards.
    pub y: Axis,
    /// The lines and dots.
    pub lines: Vec<Line>,
    /// Where the names of the lines stand.
    pub names: Names,
    /// Words beside places.
    pub notes: Vec<Note>,
}

/// A word beside a place of a chart.
#[derive(Debug, Clone, PartialEq)]
pub struct Note {
    /// The place.
    pub at: (f64, f64),
    /// The word.
    pub text: String,
    /// Where it stands from the place.
    pub side: Corner,
}

/// Where the names of the lines of a chart stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Names {
    /// In a corner, over what is there.
    In(Corner),
    /// In rows below the chart, which is higher by them.
    Below,
}

/// A corner of a chart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Corner {
    /// Upper left.
    UpperLeft,
    /// Upper right.
    UpperRight,
    /// Lower left.
    LowerLeft,
    /// Lower right.
    LowerRight,
}

/// A line through points.
#[derive(Debug, Clone)]
pub struct Line {
    /// The name.
    pub name: String,
    /// Points from left to right (dots in any order); the line breaks where y is `None`, and a
    /// single point is a dot.
    pub points: Vec<(f64, Option<f64>)>,
    /// The number of its colour; more than there are begin again.
    pub colour: usize,
    /// Whether it is drawn thin and pale, for comparison.
    pub faint: bool,
    /// Whether its points are dots that no line joins.
    pub dots: bool,
}

impl Line {
    /// Returns a line that is not there for comparison only, through points from left to right.
    pub fn new(
        name: impl Into<String>,
        colour: usize,
        points: impl IntoIterator<Item = (f64, Option<f64>)>,
    ) -> Self {
        Self {
            name: name.into(),
            points: points.into_iter().collect(),
            colour,
            faint: false,
            dots: false,
        }
    }
}

const LARGEST: f64 = 1.0e300;

/// Returns whether an axis can have a range: `plotters` would not end on a logarithmic one from 0.
pub fn is_drawable(range: &Range<f64>, logarithmic: bool) -> bool {
    let least = if logarithmic { 1.0 / LARGEST } else { -LARGEST };
    least <= range.start && range.start < range.end && range.end <= LARGEST
}

impl Chart {
    /// Writes the picture, SVG.
    ///
    /// # Errors
    /// What the system reports.
    pub fn write_svg(&self, path: &Path) -> io::Result<()> {
        let picture = self.svg(SIZE)?;
        write_atomically(path, |file| file.write_all(picture.as_bytes()))
    }

    /// Writes the numbers as CSV: a line's name, x and y in each row; y may be empty.
    ///
    /// # Errors
    /// What the system reports.
    pub fn write_csv(&self, path: &Path) -> io::Result<()> {
        let numbers = self.csv();
        write_atomically(path, |file| file.write_all(numbers.as_bytes()))
    }

    fn csv(&self) -> String {
        let mut text = format!("line,{},{}\n", self.x.name, self.y.name);
        for line in &self.lines {
            // Quoted as RFC 4180 has it: names have commas.
            let name = line.name.replace('"', "\"\"");
            for (x, y) in &line.points {
                let y = y.map_or(String::new(), |y| y.to_string());
                // Writing to a string does not fail.
                let _ = writeln!(text, "\"{name}\",{x},{y}");
            }
        }
        text
    }

    /// Returns the picture as SVG text of `size` columns and rows, with more rows for names below
    /// it. Letters have the same size in charts of any size.
    ///
    /// # Errors
    /// A range that no axis can have.
    pub fn svg(&self, [width, height]: [u32; 2]) -> io::Result<String> {
        for axis in [&self.x, &self.y] {
            if !is_drawable(&axis.range, axis.logarithmic) {
                let scale = if axis.logarithmic { "logarithmic " } else { "" };
                let (Range { start, end }, name) = (&axis.range, axis.name);
                let message = format!("no {scale}axis goes from {start} to {end}: {name}");
                return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
            }
        }
        let mut picture = String::new();
        let size = (width, height + self.names_height());
        let (x, y) = (self.x.range.clone(), self.y.range.clone());
        match (self.x.logarithmic, self.y.logarithmic) {
            (false, false) => self.draw(&mut picture, size, x, y),
            (false, true) => self.draw(&mut picture, size, x, y.log_scale()),
            (true, false) => self.draw(&mut picture, size, x.log_scale(), y),
            (true, true) => self.draw(&mut picture, size, x.log_scale(), y.log_scale()),
        }
        .map_err(|error| io::Error::other(error.to_string()))?;
        let written = |parts: u32| {
            let (width, height) = (size.0 * parts, size.1 * parts);
            format!("width=\"{width}\" height=\"{height}\" ")
        };
        Ok(picture.replacen(&written(PARTS), &written(1), 1))
    }

    // Long, because it sets each part of one drawing in turn.
    fn draw<X, Y>(
        &self,
        picture: &mut String,
        size: (u32, u32),
        x: X,
        y: Y,
    ) -> Result<(), DrawingError>
    where
        X: AsRangedCoord<Value = f64>,
        Y: AsRangedCoord<Value = f64>,
        X::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
        Y::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
    {
        let (width, height) = (size.0 * PARTS, size.1 * PARTS);
        let area = SVGBackend::with_string(picture, (width, height)).into_drawing_area();
        area.fill(&WHITE)?;
        let below = area
            .margin(10 * PARTS, 0, 0, 0)
            .titled(&self.title, ("sans-serif", 20 * PARTS))?;
        let (below, names) =
            below.split_vertically(below.dim_in_pixel().1 - self.names_height() * PARTS);
        let mut chart = ChartBuilder::on(&below)
            .margin(12 * PARTS)
            // Half of the last tick's number.
            .margin_right(24 * PARTS)
            .x_label_area_size(44 * PARTS)
            .y_label_area_size(72 * PARTS)
            .build_cartesian_2d(x, y)?;
        chart
            .configure_mesh()
            // Numbers of several digits have room beside each other.
            .x_labels((size.0 / 80).max(2) as usize)
            .y_labels(((size.1 - self.names_height()) / 40).max(2) as usize)
            .x_desc(self.x.label)
            .y_desc(self.y.label)
            .x_label_formatter(&|x| self.x.tick(*x))
            .y_label_formatter(&|y| self.y.tick(*y))
            .label_style(("sans-serif", 14 * PARTS))
            .axis_desc_style(("sans-serif", 15 * PARTS))
            .axis_style(BLACK.stroke_width(PARTS))
            .bold_line_style(BLACK.mix(0.15).stroke_width(PARTS))
            .light_line_style(BLACK.mix(0.04).stroke_width(PARTS))
            .set_all_tick_mark_size(5 * PARTS)
            .draw()?;
        for line in &self.lines {
            let style = line.style();
            let dots = self.dots(line);
            if !dots.is_empty() {
                let dots = dots
                    .into_iter()
                    .map(|at| Circle::new(at, DOT, style.filled()));
                chart
                    .draw_series(dots)?
                    .label(&line.name)
                    .legend(move |(x, y)| Circle::new((x + KEY / 2, y), DOT, style.filled()));
            }
            if line.dots {
                continue;
            }
            let mut named = false;
            for part in self.parts(line) {
                let drawn = chart.draw_series(LineSeries::new(part, style))?;
                if !named {
                    drawn
                        .label(&line.name)
                        .legend(move |(x, y)| PathElement::new([(x, y), (x + KEY, y)], style));
                    named = true;
                }
            }
        }
        let notes = self.notes.iter().filter(|note| self.shows(note.at));
        chart.draw_series(notes.map(|note| {
            let (across, aside) = match note.side {
                Corner::UpperRight | Corner::LowerRight => (HPos::Left, 8),
                Corner::UpperLeft | Corner::LowerLeft => (HPos::Right, -8),
            };
            let (upright, above) = match note.side {
                Corner::UpperRight | Corner::UpperLeft => (VPos::Bottom, -4),
                Corner::LowerRight | Corner::LowerLeft => (VPos::Top, 4),
            };
            let style = ("sans-serif", 13 * PARTS)
                .into_text_style(&below)
                .pos(Pos::new(across, upright));
            let parts = PARTS as i32;
            EmptyElement::at(note.at)
                + Text::new(note.text.clone(), (aside * parts, above * parts), style)
        }))?;
        if let (Names::In(corner), true) = (self.names, self.lines.len() > 1) {
            chart
                .configure_series_labels()
                .position(match corner {
                    Corner::UpperLeft => SeriesLabelPosition::UpperLeft,
                    Corner::UpperRight => SeriesLabelPosition::UpperRight,
                    Corner::LowerLeft => SeriesLabelPosition::LowerLeft,
                    Corner::LowerRight => SeriesLabelPosition::LowerRight,
                })
                .label_font(("sans-serif", 14 * PARTS))
                .legend_area_size(30 * PARTS)
                .margin(10 * PARTS)
                .background_style(WHITE.mix(0.85))
                .border_style(BLACK.mix(0.2).stroke_width(PARTS))
                .draw()?;
        }
        self.draw_names(&names)?;
        area.present()
    }

    fn names_height(&self) -> u32 {
        if self.names == Names::Below && self.lines.len() > 1 {
            // And half of one to the edge.
            NAME_ROW * self.lines.len().div_ceil(NAMES_A_ROW) as u32 + NAME_ROW / 2
        } else {
            0
        }
    }

    fn draw_names(&self, area: &DrawingArea<SVGBackend<'_>, Shift>) -> Result<(), DrawingError> {
        if self.names_height() == 0 {
            return Ok(());
        }
        let (width, _) = area.dim_in_pixel();
        let (indent, row) = (24 * PARTS as i32, (NAME_ROW * PARTS) as i32);
        let column = (width as i32 - indent) / NAMES_A_ROW as i32;
        let style = ("sans-serif", 14 * PARTS)
            .into_text_style(area)
            .pos(Pos::new(HPos::Left, VPos::Center));
        for (number, line) in self.lines.iter().enumerate() {
            let (below, beside) = (number / NAMES_A_ROW, number % NAMES_A_ROW);
            let x = indent + column * beside as i32;
            let y = row / 2 + row * below as i32;
            if line.dots {
                let dot = Circle::new((x + KEY / 2, y), DOT, line.style().filled());
                area.draw(&dot)?;
            } else {
                area.draw(&PathElement::new([(x, y), (x + KEY, y)], line.style()))?;
            }
            let at = (x + KEY + 8 * PARTS as i32, y);
            area.draw(&Text::new(line.name.clone(), at, style.clone()))?;
        }
        Ok(())
    }

    fn shows(&self, (x, y): (f64, f64)) -> bool {
        let within = |axis: &Axis, at: f64| (axis.range.start..=axis.range.end).contains(&at);
        within(&self.x, x) && within(&self.y, y)
    }

    /// Returns the places of a line's dots inside the chart.
    fn dots(&self, line: &Line) -> Vec<(f64, f64)> {
        if !line.dots && line.points.len() != 1 {
            return Vec::new();
        }
        let places = line.points.iter().filter_map(|&(x, y)| Some((x, y?)));
        places.filter(|&at| self.shows(at)).collect()
    }

    /// Returns the unbroken parts of a line inside the chart, each at least two points.
    fn parts(&self, line: &Line) -> Vec<Vec<(f64, f64)>> {
        let (x, y) = (&self.x, &self.y);
        let mut parts: Vec<Vec<(f64, f64)>> = Vec::new();
        for pair in line.points.windows(2) {
            let &[(x0, Some(y0)), (x1, Some(y1))] = pair else {
                continue;
            };
            // No logarithm, no place.
            if ![x.place(x0), x.place(x1), y.place(y0), y.place(y1)]
                .iter()
                .all(|place| place.is_finite())
            {
                continue;
            }
            let along_x = x.inside(x0, x1);
            let along_y = y.inside(y0, y1);
            let (from, to) = (along_x.0.max(along_y.0), along_x.1.min(along_y.1));
            if !(from < to) {
                continue;
            }
            let at = |part: f64| (x.between(x0, x1, part), y.between(y0, y1, part));
            match parts.last_mut() {
                Some(part) if from == 0.0 && part.last() == Some(&(x0, y0)) => part.push(at(to)),
                _ => parts.push(vec![at(from), at(to)]),
            }
        }
        parts
    }
}

impl Line {
    fn style(&self) -> ShapeStyle {
        let colour = COLOURS[self.colour % COLOURS.len()];
        ShapeStyle {
            color: colour.mix(if self.faint { 0.5 } else { 1.0 }),
            filled: false,
            stroke_width: if self.faint { PARTS } else { 2 * PARTS },
        }
    }
}

type DrawingError = DrawingAreaErrorKind<io::Error>;

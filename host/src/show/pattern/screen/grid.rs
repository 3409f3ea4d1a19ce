//! A numbered grid: metres on a wall, degrees on a dome.

use super::resolution;
use crate::cave::DomeScreen;
use crate::picture::{Picture, PictureError};
use crate::show::pattern::ScreenView;
use crate::show::pattern::sheet::{LINE, Sheet, stroke};
use glam::DVec2;
use std::f64::consts::TAU;

/// The side of a cell on a wall: metres.
pub(crate) const CELL: f64 = 0.25;

/// The side of a cell on a dome: degrees.
const DEGREES: f64 = 10.0;

/// The fewest pixels from line to line.
const LEAST: f64 = 8.0;

/// The light of lines between the bright ones.
const THIN: f32 = 0.15;

/// The place of a crossing in its number, in dots: two to the right of the line, two above it.
const BESIDE: DVec2 = DVec2::new(-2.0, LINE + 2.0);

pub(crate) fn grid(view: &ScreenView<'_>) -> Result<Picture, PictureError> {
    let sheet = Sheet::new(view);
    let thickness = (sheet.size.min_element() / 600.0).round().max(1.0);
    let title = format!("↑ {} {}", view.screen.name(), resolution(&sheet));
    match sheet.dome() {
        Some(dome) => of_dome(&sheet, dome, thickness, &title),
        None => of_wall(&sheet, thickness, &title),
    }
}

fn of_wall(sheet: &Sheet<'_>, thickness: f64, title: &str) -> Result<Picture, PictureError> {
    let (pitch, span) = (sheet.pitch(), sheet.span());
    let mut cell = CELL;
    while cell < LEAST * pitch.max_element() {
        cell *= 2.0;
    }
    let columns = ruled(sheet.size.x, span.x, cell, thickness);
    let mut rows = ruled(sheet.size.y, span.y, cell, thickness);
    rows.reverse();
    let mut picture = sheet.paint(|at| [columns[at.x as usize].max(rows[at.y as usize]); 3])?;
    let counts = (span / cell - 1.0e-9).floor();
    let letters = format!("{},{}", counts.x, counts.y).chars().count() as f64;
    // Numbers stand at every crossing, or as often as they have room.
    let text = LINE * letters + 2.0;
    let stride = (pitch.max_element() * text / cell).ceil().max(1.0);
    let pixel = pitch.max_element();
    let dot = pixel * (stride * cell / text / pixel).floor().max(1.0);
    for number in 1..=(counts.y / stride) as u32 {
        let row = stride * f64::from(number);
        for number in 1..=(counts.x / stride) as u32 {
            let column = stride * f64::from(number);
            let at = DVec2::new(column * cell / pitch.x, sheet.size.y - row * cell / pitch.y);
            // No room up to the edge.
            if span.x - column * cell < dot * text {
                continue;
            }
            let mut sign = sheet.sign(&format!("{column},{row}"), at, BESIDE, dot);
            sign.margin = DVec2::ZERO;
            sheet.show(&mut picture, &sign, sheet.head);
        }
    }
    // The lowest cells have no numbers.
    let (title, width) = if sheet.is_flat() {
        (&format!("{title}, cells of {cell} m"), 0.9 * span.x)
    } else {
        // Letters on a straight line leave their row on a curved screen.
        (&title.to_owned(), 4.0 * cell)
    };
    if let Some(dot) = sheet.fit(title, DVec2::new(width, 0.6 * cell)) {
        let at = DVec2::new(0.5, 1.0 - 0.5 * cell / span.y) * sheet.size;
        let sign = sheet.centred(title, at, dot);
        sheet.show(&mut picture, &sign, sheet.head);
    }
    Ok(picture)
}

/// Returns the light of each of `count` pixels along `length` metres: a line at each cell's end,
/// brighter at each metre and at both ends.
fn ruled(count: f64, length: f64, cell: f64, thickness: f64) -> Vec<f32> {
    let mut lights = vec![0.0; count as usize];
    let last = (length / cell + 1.0e-9).floor() as u32;
    for number in 0..=last {
        let metres = f64::from(number) * cell;
        let light = if metres.fract() == 0.0 { 1.0 } else { THIN };
        let middle = metres / length * count;
        let start = (middle - 0.5 * thickness).round();
        let start = start.clamp(0.0, count - thickness) as usize;
        lights[start..start + thickness as usize].fill(light);
    }
    for end in [0, lights.len() - 1] {
        lights[end] = 1.0;
    }
    lights
}

fn of_dome(
    sheet: &Sheet<'_>,
    dome: &DomeScreen,
    thickness: f64,
    title: &str,
) -> Result<Picture, PictureError> {
    let half_field = 0.5 * dome.field_of_view_degrees;
    let pixels_per_degree = 0.5 * sheet.size.x / half_field;
    let mut picture = sheet.paint(|at| {
        let from_middle = at - 0.5 * sheet.size;
        let radius = from_middle.length();
        let from_zenith = radius / pixels_per_degree;
        let azimuth = libm::atan2(from_middle.x, from_middle.y).to_degrees();
        let nearest = |angle: f64, step: f64| step * (angle / step).round();
        let parallel = nearest(from_zenith, DEGREES);
        let off = (from_zenith - parallel) * pixels_per_degree;
        let mut light = stroke(off, thickness) * strength(parallel);
        // Meridians end where they would crowd.
        let per_degree = radius * TAU / 360.0;
        if let Some(step) = meridians(per_degree, LEAST) {
            let meridian = nearest(azimuth, step);
            let off = (azimuth - meridian) * per_degree;
            light = light.max(stroke(off, thickness) * strength(meridian));
        }
        let rim = 0.5 * sheet.size.x - radius;
        [light.max(f32::from(rim < thickness)); 3]
    })?;
    let dot = sheet.pitch().x * (sheet.size.x / 1000.0).round().max(1.0);
    let dot_pixels = dot / sheet.pitch().x;
    let stride = ((LINE + 4.0) * dot_pixels / (DEGREES * pixels_per_degree)).ceil();
    let rings = ((half_field - 1.0e-9) / (stride * DEGREES)) as u32;
    for ring in 1..=rings {
        let from_zenith = f64::from(ring) * stride * DEGREES;
        let per_degree = from_zenith * pixels_per_degree * TAU / 360.0;
        let widest = (LINE * 7.0 + 3.0) * dot_pixels;
        let Some(step) = meridians(per_degree, widest) else {
            continue;
        };
        for number in 0..(360.0 / step) as u32 {
            let azimuth = f64::from(number) * step;
            let signed = if azimuth > 180.0 {
                azimuth - 360.0
            } else {
                azimuth
            };
            let at = sheet.dome_place(azimuth.to_radians(), from_zenith / half_field);
            let text = format!("{signed},{from_zenith}");
            let sign = sheet.sign(&text, at, BESIDE, dot);
            sheet.show(&mut picture, &sign, sheet.head);
        }
    }
    // Below the last numbers.
    let at = sheet.dome_place(0.0, 1.0 - 0.5 * DEGREES / half_field);
    sheet.show(&mut picture, &sheet.centred(title, at, dot), sheet.head);
    Ok(picture)
}

/// Returns the degrees from meridian to meridian, at least `room` pixels apart; `None` without
/// room.
fn meridians(pixels_per_degree: f64, room: f64) -> Option<f64> {
    let mut steps = [DEGREES, 3.0 * DEGREES, 9.0 * DEGREES].into_iter();
    steps.find(|step| step * pixels_per_degree >= room)
}

fn strength(degrees: f64) -> f32 {
    if degrees % (3.0 * DEGREES) == 0.0 {
        1.0
    } else {
        THIN
    }
}

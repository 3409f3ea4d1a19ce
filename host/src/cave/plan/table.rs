//! The table beside the drawings: screens, projectors, remarks.

use super::Plan;
use super::sheet::{self, Anchor, Sheet};
use crate::cave::Screen;
use glam::{DVec2, DVec3};

/// Rows that are written downwards.
#[derive(Debug)]
pub(super) struct Table<'s> {
    sheet: &'s mut Sheet,
    /// The left end of the next row's line.
    at: DVec2,
    /// The right end.
    right: f64,
    /// Where the last row may be.
    bottom: f64,
}

impl<'s> Table<'s> {
    /// Highest row, millimetres.
    const ROW: f64 = 5.5;
    /// Height of a line of a remark, millimetres, and width of a letter.
    const LINE: f64 = 3.9;
    const LETTER: f64 = 1.55;

    /// Returns a table whose first row is at `corner`.
    pub(super) fn new(corner: DVec2, bottom: f64, sheet: &'s mut Sheet) -> Self {
        Self {
            sheet,
            at: corner,
            right: Sheet::SIZE.x - Plan::MARGIN,
            bottom,
        }
    }

    pub(super) fn write(mut self, plan: &Plan<'_>) {
        let eyes = plan.middle();
        let screens: Vec<_> = plan.cave.screens().zip(sheet::colours()).collect();
        let rows = screens.len() + plan.beams.len() + 3;
        let height = (0.75 * (self.bottom - self.at.y) / rows as f64).min(Self::ROW);
        self.heading(["screen", "size", "pixels", "field from the eyes"]);
        for (screen, colour) in screens {
            let field = match screen.field_from(eyes) {
                Some([across, upward]) => format!("{across:.1}° × {upward:.1}°"),
                None => "not from its front".to_owned(),
            };
            self.at.y += height;
            self.sheet.patch(self.at - DVec2::new(4.5, 2.2), &colour);
            let pixels = pixels(screen.size());
            self.row([screen.name(), &size(screen), &pixels, &field], "cell");
        }
        if !plan.beams.is_empty() {
            self.at.y += 1.5 * height;
            self.heading(["projector", "screen", "pixels", "on the screen"]);
        }
        for beam in plan.beams {
            self.at.y += height;
            let share = format!("{:.0} %", 100.0 * beam.share);
            let pixels = pixels(beam.projector.resolution);
            let cells = [&beam.projector.name, beam.screen.name(), &pixels, &share];
            self.row(cells, "cell");
        }
        self.at.y += 3.0;
        // Millimetres, and no minus before a zero.
        let [x, y, z] = eyes
            .to_array()
            .map(|metres| (1e3 * metres).round() / 1e3 + 0.0);
        self.remark(&format!(
            "Eyes: {x:.3} m right, {y:.3} m up, {z:.3} m back of the origin"
        ));
        plan.remarks.iter().for_each(|remark| self.remark(remark));
    }

    fn row(&mut self, cells: [&str; 4], class: &str) {
        let width = self.right - self.at.x;
        let columns = [0.0, 0.46, 0.7, 1.0].map(|share| self.at.x + share * width);
        let anchors = [Anchor::Start, Anchor::End, Anchor::End, Anchor::End];
        for ((x, anchor), cell) in columns.into_iter().zip(anchors).zip(cells) {
            self.sheet
                .text(DVec2::new(x, self.at.y), anchor, class, cell);
        }
    }

    fn heading(&mut self, cells: [&str; 4]) {
        self.row(cells, "heading");
        let [from, to] = [self.at.x, self.right].map(|x| DVec2::new(x, self.at.y + 1.6));
        self.sheet.line(from, to, "rule");
    }

    /// Writes a sentence, as far as there is room.
    fn remark(&mut self, text: &str) {
        let letters = ((self.right - self.at.x) / Self::LETTER) as usize;
        let lines = wrapped(text, letters);
        self.at.y += 1.5;
        for line in lines {
            self.at.y += Self::LINE;
            if self.at.y <= self.bottom {
                self.sheet.text(self.at, Anchor::Start, "note", &line);
            } else if self.at.y <= self.bottom + Self::LINE {
                let more = "… more in the command's report";
                self.sheet.text(self.at, Anchor::Start, "note", more);
            }
        }
    }
}

fn pixels([columns, rows]: [u32; 2]) -> String {
    format!("{columns} × {rows}")
}

fn size(screen: Screen<'_>) -> String {
    match screen {
        Screen::Wall(wall) => {
            let [width, height] = [wall.across(), wall.upward()].map(DVec3::length);
            format!("{width:.3} × {height:.3} m")
        }
        Screen::Dome(dome) => format!("radius {:.3} m", dome.radius),
        Screen::Cylinder(cylinder) => {
            let [low, high] = cylinder.height;
            format!("radius {:.3}, {:.3} m high", cylinder.radius, high - low)
        }
    }
}

/// Breaks a text into lines of at most so many letters, where words allow.
fn wrapped(text: &str, letters: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + word.chars().count() < letters => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

//! An A4 page as SVG.

use crate::picture::chart::COLOURS;
use glam::DVec2;
use std::fmt::Write as _;

/// A page, landscape; all lengths are millimetres, y downwards.
#[derive(Debug)]
pub(super) struct Sheet(String);

/// Which part of a text is at its place.
#[derive(Debug, Clone, Copy)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// How classes look.
const STYLE: &str = "
text { font-family: 'Helvetica Neue', Helvetica, Arial, 'Liberation Sans', sans-serif; \
font-size: 3.1px; fill: #333; }
.title { font-size: 6px; font-weight: bold; fill: #111; }
.side { font-size: 3.4px; fill: #666; }
.heading { fill: #666; }
.note { font-size: 3px; fill: #555; }
.label { font-size: 3.1px; font-weight: bold; paint-order: stroke; stroke: #fff; \
stroke-width: 0.9px; stroke-linejoin: round; }
.grid { stroke: #eee; stroke-width: 0.2px; }
.axis { stroke: #ccc; stroke-width: 0.3px; }
.rule { stroke: #999; stroke-width: 0.2px; }
.edge { fill: none; stroke-width: 1px; stroke-linejoin: round; stroke-linecap: round; }
.face { fill-opacity: 0.06; stroke-width: 0.4px; stroke-linejoin: round; }
.cut { fill: none; stroke-width: 0.3px; stroke-dasharray: 1.6 1.2; }
.thin { fill: none; stroke-width: 0.15px; }
.field { fill-opacity: 0.07; stroke-width: 0.2px; stroke-dasharray: 0.8 0.8; stroke-opacity: 0.7; }
.beam { fill: #f0e442; fill-opacity: 0.16; stroke: #7a7000; stroke-width: 0.15px; }
.lit { fill: none; stroke: #222; stroke-width: 0.3px; stroke-dasharray: 0.4 1; stroke-linecap: round; }
.lens { fill: #222; stroke: #fff; stroke-width: 0.3px; }
.device { font-size: 2.8px; fill: #222; paint-order: stroke; stroke: #fff; stroke-width: 0.8px; }
.head { fill: #fff; stroke: #222; stroke-width: 0.4px; }
.look { stroke: #222; stroke-width: 0.4px; stroke-linecap: round; }
.eye { fill: #222; }
.bar { stroke: #333; stroke-width: 0.25px; }
";

/// Returns the colours of screens, which begin again after some.
pub(super) fn colours() -> impl Iterator<Item = String> + Clone {
    let colours = COLOURS.iter().cycle();
    colours.map(|colour| format!("#{:02x}{:02x}{:02x}", colour.0, colour.1, colour.2))
}

impl Sheet {
    /// A4, landscape.
    pub(super) const SIZE: DVec2 = DVec2::new(297.0, 210.0);

    pub(super) fn new() -> Self {
        let DVec2 { x, y } = Self::SIZE;
        Self(format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{x}mm\" height=\"{y}mm\" \
             viewBox=\"0 0 {x} {y}\">\n<style>{STYLE}</style>\n\
             <rect width=\"{x}\" height=\"{y}\" fill=\"#fff\"/>\n"
        ))
    }

    pub(super) fn finish(mut self) -> String {
        self.0.push_str("</svg>\n");
        self.0
    }

    fn push(&mut self, element: std::fmt::Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.0, "{element}");
    }

    pub(super) fn line(&mut self, from: DVec2, to: DVec2, class: &str) {
        self.push(format_args!(
            "<line x1=\"{:.2}\" y1=\"{:.2}\" x2=\"{:.2}\" y2=\"{:.2}\" class=\"{class}\"/>",
            from.x, from.y, to.x, to.y
        ));
    }

    pub(super) fn circle(&mut self, centre: DVec2, radius: f64, class: &str) {
        let DVec2 { x, y } = centre;
        self.push(format_args!(
            "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{radius:.2}\" class=\"{class}\"/>"
        ));
    }

    pub(super) fn outline(&mut self, points: &[DVec2], colour: &str, class: &str) {
        let points = list(points);
        self.push(format_args!(
            "<polygon points=\"{points}\" class=\"{class}\" stroke=\"{colour}\"/>"
        ));
    }

    pub(super) fn open_line(&mut self, points: &[DVec2], colour: &str) {
        let points = list(points);
        self.push(format_args!(
            "<polyline points=\"{points}\" class=\"thin\" stroke=\"{colour}\"/>"
        ));
    }

    pub(super) fn filled(&mut self, points: &[DVec2], colour: &str) {
        let points = list(points);
        self.push(format_args!(
            "<polygon points=\"{points}\" class=\"face\" fill=\"{colour}\" stroke=\"{colour}\"/>"
        ));
    }

    /// Draws a polygon that looks as its class says.
    pub(super) fn shaded(&mut self, points: &[DVec2], class: &str) {
        let points = list(points);
        self.push(format_args!(
            "<polygon points=\"{points}\" class=\"{class}\"/>"
        ));
    }

    pub(super) fn wedge(&mut self, eye: DVec2, ends: [DVec2; 2], colour: &str) {
        let points = list(&[ends[0], eye, ends[1]]);
        self.push(format_args!(
            "<polyline points=\"{points}\" class=\"field\" fill=\"{colour}\" stroke=\"{colour}\"/>"
        ));
    }

    pub(super) fn patch(&mut self, corner: DVec2, colour: &str) {
        let DVec2 { x, y } = corner;
        self.push(format_args!(
            "<rect x=\"{x:.2}\" y=\"{y:.2}\" width=\"2.6\" height=\"2.6\" fill=\"{colour}\"/>"
        ));
    }

    pub(super) fn bar(&mut self, corner: DVec2, width: f64, is_dark: bool) {
        let (DVec2 { x, y }, fill) = (corner, if is_dark { "#333" } else { "#fff" });
        self.push(format_args!(
            "<rect x=\"{x:.2}\" y=\"{y:.2}\" width=\"{width:.2}\" height=\"1.4\" class=\"bar\" \
             fill=\"{fill}\"/>"
        ));
    }

    pub(super) fn text(&mut self, place: DVec2, anchor: Anchor, class: &str, text: &str) {
        let (DVec2 { x, y }, anchor, text) = (place, anchor.name(), escaped(text));
        self.push(format_args!(
            "<text x=\"{x:.2}\" y=\"{y:.2}\" text-anchor=\"{anchor}\" class=\"{class}\">{text}</text>"
        ));
    }

    /// Writes a label, turned clockwise by so many degrees about its place.
    pub(super) fn coloured_text(
        &mut self,
        place: DVec2,
        anchor: Anchor,
        colour: &str,
        turn: f64,
        text: &str,
    ) {
        let (DVec2 { x, y }, anchor, text) = (place, anchor.name(), escaped(text));
        self.push(format_args!(
            "<text transform=\"translate({x:.2} {y:.2}) rotate({turn:.1})\" \
             text-anchor=\"{anchor}\" class=\"label\" style=\"fill: {colour}\">{text}</text>"
        ));
    }
}

impl Anchor {
    fn name(self) -> &'static str {
        match self {
            Self::Start => "start",
            Self::Middle => "middle",
            Self::End => "end",
        }
    }
}

fn list(points: &[DVec2]) -> String {
    let points = points
        .iter()
        .map(|point| format!("{:.2},{:.2}", point.x, point.y));
    points.collect::<Vec<_>>().join(" ")
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}

//! What screens look like from a side.

use super::Frame;
use super::sheet::{Anchor, Sheet};
use crate::cave::Screen;
use glam::{DVec2, DVec3};

/// Returns points all over a screen: metres, in the room.
pub(super) fn surface(screen: Screen<'_>) -> Vec<DVec3> {
    match screen {
        Screen::Wall(wall) => wall.corners().to_vec(),
        Screen::Dome(dome) => {
            let rings = (0..=16).flat_map(|ring| around(f64::from(ring) / 16.0));
            rings.map(|place| dome.point(place)).collect()
        }
        Screen::Cylinder(_) => border(screen),
    }
}

/// Returns the border of a cylinder's picture, once round: metres, in the room.
fn border(screen: Screen<'_>) -> Vec<DVec3> {
    let upper = (0..=64).map(|step| DVec2::new(f64::from(step) / 64.0, 0.0));
    let lower = upper.clone().rev().map(|place| place + DVec2::Y);
    let places = upper.chain(lower);
    places.map(|place| screen.point(place)).collect()
}

/// Returns places on a ring of the unit disc, once round.
fn around(radius: f64) -> impl Iterator<Item = DVec2> {
    (0..=72).map(move |step| radius * DVec2::from_angle(f64::from(step).to_radians() * 5.0))
}

/// How a wall is seen, in the order of drawing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Layer {
    /// From behind.
    Cut,
    /// From the front.
    Face,
    /// From its edge.
    Edge,
}

pub(super) fn draw(
    screen: Screen<'_>,
    frame: &Frame,
    layer: Layer,
    colour: &str,
    sheet: &mut Sheet,
) {
    match screen {
        Screen::Wall(wall) => {
            let corners = wall.corners().map(|corner| frame.at(corner));
            let own = match frame.side.towards(wall.normal()) {
                ..-0.05 => Layer::Cut,
                0.05.. => Layer::Face,
                _ => Layer::Edge,
            };
            match layer {
                _ if layer != own => {}
                Layer::Cut => sheet.outline(&corners, colour, "cut"),
                Layer::Face => sheet.filled(&corners, colour),
                Layer::Edge => sheet.outline(&corners, colour, "edge"),
            }
        }
        Screen::Cylinder(_) => {
            let mut border: Vec<DVec2> = border(screen).iter().map(|&one| frame.at(one)).collect();
            if !is_from_above(frame) {
                border = hull(border);
            }
            match layer {
                Layer::Cut => {}
                Layer::Face => sheet.filled(&border, colour),
                Layer::Edge => sheet.outline(&border, colour, "edge"),
            }
        }
        Screen::Dome(_) if layer != Layer::Face => {}
        Screen::Dome(dome) => {
            let places: Vec<DVec2> = surface(screen).iter().map(|&one| frame.at(one)).collect();
            sheet.filled(&hull(places), colour);
            for ring in [1.0, 2.0 / 3.0, 1.0 / 3.0] {
                let line: Vec<DVec2> = around(ring).map(|at| frame.at(dome.point(at))).collect();
                let class = if ring == 1.0 { "edge" } else { "thin" };
                sheet.outline(&line, colour, class);
            }
            for meridian in 0..4 {
                let way = DVec2::from_angle(f64::from(meridian) * 45f64.to_radians());
                let along = (-16..=16).map(|step| f64::from(step) / 16.0 * way);
                let line: Vec<DVec2> = along.map(|at| frame.at(dome.point(at))).collect();
                sheet.open_line(&line, colour);
            }
        }
    }
}

fn is_from_above(frame: &Frame) -> bool {
    frame.side.towards(DVec3::Y) > 0.5
}

/// A screen that is seen from its edge.
#[derive(Debug)]
pub(super) struct EdgeOn {
    /// The middles of the edges between which it is.
    pub(super) ends: [DVec2; 2],
    /// Its own middle.
    pub(super) middle: DVec2,
    /// Whether its width is seen, and not its height.
    pub(super) is_width: bool,
}

/// Returns how a screen is seen from its edge, if it is.
pub(super) fn edge_on(screen: Screen<'_>, frame: &Frame) -> Option<EdgeOn> {
    let at = |s, t| frame.at(screen.point(DVec2::new(s, t)));
    let (width, height) = ([at(0.0, 0.5), at(1.0, 0.5)], [at(0.5, 1.0), at(0.5, 0.0)]);
    let is_width = match screen {
        Screen::Wall(wall) if frame.side.towards(wall.normal()).abs() <= 0.5 => {
            width[0].distance(width[1]) >= height[0].distance(height[1])
        }
        Screen::Cylinder(_) if is_from_above(frame) => true,
        _ => return None,
    };
    Some(EdgeOn {
        ends: if is_width { width } else { height },
        middle: at(0.5, 0.5),
        is_width,
    })
}

/// Writes a screen's name and size beside it, or in its lower left corner.
pub(super) fn write_name(screen: Screen<'_>, frame: &Frame, colour: &str, sheet: &mut Sheet) {
    let name = screen.name();
    match screen {
        Screen::Wall(wall) => {
            if let Some(EdgeOn { ends, is_width, .. }) = edge_on(screen, frame) {
                let edge = if is_width {
                    wall.across()
                } else {
                    wall.upward()
                };
                let text = format!("{name}  {:.2} m", edge.length());
                let middle = ends[0].midpoint(ends[1]);
                let outwards = frame.side.place(-wall.normal()) * DVec2::new(1.0, -1.0);
                let mut along = (ends[1] - ends[0]).normalize_or(DVec2::X);
                if along.x < -0.1 || along.x < 0.1 && along.y > 0.0 {
                    along = -along;
                }
                // Letters stand on a line, so below one they are farther away.
                let up = DVec2::new(along.y, -along.x);
                let distance = if up.dot(outwards) > 0.0 { 1.6 } else { 4.0 };
                let place = middle + distance * outwards.normalize_or_zero();
                let turn = along.to_angle().to_degrees();
                sheet.coloured_text(place, Anchor::Middle, colour, turn, &text);
            } else if frame.side.towards(wall.normal()) > 0.0 {
                let corners = wall.corners().map(|corner| frame.at(corner));
                let lowest = |at: DVec2| at.y - at.x;
                let corner = corners
                    .into_iter()
                    .max_by(|a, b| lowest(*a).total_cmp(&lowest(*b)));
                let place = corner.unwrap_or_default() + DVec2::new(2.0, -2.0);
                sheet.coloured_text(place, Anchor::Start, colour, 0.0, name);
            }
        }
        Screen::Dome(dome) => below(screen, frame, colour, dome.radius, sheet),
        Screen::Cylinder(cylinder) => match edge_on(screen, frame) {
            None => below(screen, frame, colour, cylinder.radius, sheet),
            Some(seen) => {
                let outwards = (seen.middle - frame.at(cylinder.centre)).normalize_or_zero();
                let place = seen.middle + 3.0 * outwards + DVec2::Y;
                let text = format!("{}  radius {:.2} m", screen.name(), cylinder.radius);
                sheet.coloured_text(place, Anchor::Middle, colour, 0.0, &text);
            }
        },
    }
}

/// Writes a curved screen's name and radius below it.
fn below(screen: Screen<'_>, frame: &Frame, colour: &str, radius: f64, sheet: &mut Sheet) {
    let [least, most] = frame.side.extent(&surface(screen));
    let lowest = DVec2::new(0.5 * (least.x + most.x), least.y);
    let text = format!("{}  radius {radius:.2} m", screen.name());
    let place = frame.on_page(lowest) + 4.5 * DVec2::Y;
    sheet.coloured_text(place, Anchor::Middle, colour, 0.0, &text);
}

/// Returns the convex hull of points, once round.
pub(super) fn hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let half = |points: &mut dyn Iterator<Item = DVec2>| {
        let mut chain: Vec<DVec2> = Vec::new();
        for point in points {
            while let [.., before, last] = chain.as_slice()
                && (last - before).perp_dot(point - last) <= 0.0
            {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let mut round = half(&mut points.iter().copied());
    round.append(&mut half(&mut points.iter().rev().copied()));
    round
}

//! Vrui's configuration: sections of tags; screens by their lower left corner and two axes.

use super::{ImportedRoom, numbers, wall};
use crate::cave::Wall;
use crate::files::Fault;
use glam::{DMat3, DVec3};

/// Most sections in one another.
const DEPTH: usize = 64;

/// A section: its tags and the sections in it.
#[derive(Debug, Default)]
struct Section<'a> {
    name: &'a str,
    tags: Vec<(&'a str, &'a str)>,
    sections: Vec<Self>,
}

impl Section<'_> {
    fn tag(&self, name: &str) -> Option<&str> {
        let mut tags = self.tags.iter();
        tags.find(|(tag, _)| *tag == name).map(|(_, value)| *value)
    }

    /// Returns the value of a tag of this section, or of the environment in it.
    fn in_environment(&self, names: [&str; 2]) -> Option<&str> {
        let environment = self.sections.iter().find(|one| one.name == "Environment");
        let own = environment.and_then(|section| section.tag(names[0]));
        own.or_else(|| self.tag(names[1]))
    }
}

pub(super) fn read(text: &str, section: Option<&str>) -> Result<ImportedRoom, Fault> {
    let whole = parse(text)?;
    // A file is one section Vrui, of which each section is a room.
    let rooms = whole.sections.iter().flat_map(|vrui| &vrui.sections);
    let rooms = rooms.filter(|room| section.is_none_or(|name| name == room.name));
    let mut found = Vec::new();
    let mut ignored = vec!["windows, stereo, viewers and devices".to_owned()];
    for room in rooms {
        let walls = walls(room, &mut ignored)?;
        if !walls.is_empty() {
            found.push((room.name, walls));
        }
    }
    if let [(one, _), (other, _), ..] = found.as_slice() {
        return Err(Fault::new(
            format!("the file has several rooms with screens, such as {one} and {other}"),
            format!("give --section {one}, or another"),
        ));
    }
    Ok(ImportedRoom {
        program: "Vrui",
        walls: found.pop().map(|(_, walls)| walls).unwrap_or_default(),
        ignored,
    })
}

fn parse(text: &str) -> Result<Section<'_>, Fault> {
    let mut open = vec![Section::default()];
    for line in text.lines() {
        let line = line.split('#').next().unwrap_or_default().trim();
        let (tag, value) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        match tag {
            "section" if open.len() > DEPTH => {
                return Err(Fault::new(
                    format!("there are more than {DEPTH} sections in one another"),
                    "write as many lines endsection as section",
                ));
            }
            "section" => open.push(Section {
                name: value.trim(),
                ..Section::default()
            }),
            "endsection" => {
                let closed = open.pop();
                match (open.last_mut(), closed) {
                    (Some(parent), Some(closed)) => parent.sections.push(closed),
                    _ => break,
                }
            }
            _ => {
                if let Some(section) = open.last_mut() {
                    section.tags.push((tag, value.trim()));
                }
            }
        }
    }
    let whole = open.pop();
    match whole {
        Some(whole) if open.is_empty() && !whole.sections.is_empty() => Ok(whole),
        _ => Err(Fault::new(
            "this is no file of nDisplay, Vrui, VR Juggler or MiddleVR, or a part of one",
            "give a .ndisplay, Vrui.cfg, a .jconf of VR Juggler, or a .vrx of MiddleVR; in Vrui.cfg, as many \
             lines endsection as section",
        )),
    }
}

fn walls(room: &Section<'_>, ignored: &mut Vec<String>) -> Result<Vec<Wall>, Fault> {
    let metres = metres(room)?;
    let axis = |names, usual| {
        let text = room.in_environment(names);
        text.map_or(Ok(usual), |text| {
            numbers::<3>(text, names[0]).map(DVec3::from)
        })
    };
    let up = axis(["up", "upDirection"], DVec3::Z)?.normalize_or_zero();
    let front = axis(["forward", "forwardDirection"], DVec3::Y)?.normalize_or_zero();
    let here_from_file = DMat3::from_cols(front.cross(up), up, -front).transpose();
    let mut walls = Vec::new();
    for screen in &room.sections {
        let Some(origin) = screen.tag("origin") else {
            continue;
        };
        let name = screen.name;
        if screen.tag("deviceMounted") == Some("true") {
            ignored.push(format!("screen \"{name}\", which a device moves"));
            continue;
        }
        if screen.tag("offAxis") == Some("true") {
            ignored.push(format!("the homography of screen \"{name}\""));
        }
        let of = |tag: &str| format!("{tag} of screen \"{name}\"");
        let value = |tag| screen.tag(tag).unwrap_or_default();
        let edge = |axis, length| -> Result<DVec3, Fault> {
            let [size] = numbers::<1>(value(length), &of(length))?;
            let along = DVec3::from(numbers::<3>(value(axis), &of(axis))?);
            Ok(size * along.normalize_or_zero())
        };
        let across = edge("horizontalAxis", "width")?;
        let upward = edge("verticalAxis", "height")?;
        let corner = DVec3::from(numbers::<3>(origin, &of("origin"))?);
        let corners = [
            corner,
            corner + across,
            corner + across + upward,
            corner + upward,
        ];
        walls.push(wall(
            name,
            corners.map(|one| metres * (here_from_file * one)),
        )?);
    }
    Ok(walls)
}

/// Returns the metres of one unit.
fn metres(room: &Section<'_>) -> Result<f64, Fault> {
    if let Some(unit) = room.in_environment(["unit", ""]) {
        let inner = unit.trim_start_matches('(').trim_end_matches(')');
        let (name, factor) = inner.split_once(',').unwrap_or((inner, "1"));
        let size = match name.trim().to_lowercase().as_str() {
            "inch" => 0.0254,
            "foot" => 0.3048,
            "yard" => 0.9144,
            "millimeter" => 0.001,
            "centimeter" => 0.01,
            "meter" => 1.0,
            _ => {
                let message = format!("the unit {unit} of section {} is unknown", room.name);
                return Err(Fault::new(message, "give Inch, Foot, Meter or Centimeter"));
            }
        };
        return Ok(size * numbers::<1>(factor, "unit")?[0]);
    }
    for (tag, size) in [("meterScale", 1.0), ("inchScale", 0.0254)] {
        if let Some(scale) = room.tag(tag) {
            return Ok(size / numbers::<1>(scale, tag)?[0]);
        }
    }
    // Vrui's own unit.
    Ok(0.0254)
}

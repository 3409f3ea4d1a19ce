//! MiddleVR's configuration: screens by their centres, in a tree of nodes; +Y to the front, +Z up.

use super::{ImportedRoom, numbers, wall};
use crate::files::Fault;
use glam::{DAffine3, DQuat, DVec3};
use roxmltree::{Document, Node};

/// Deepest tree.
const DEPTH: usize = 64;

pub(super) fn read(document: &Document<'_>) -> Result<ImportedRoom, Fault> {
    let mut room = ImportedRoom {
        program: "MiddleVR",
        walls: Vec::new(),
        ignored: vec!["viewports, stereo, cameras and devices".to_owned()],
    };
    let screens = document
        .descendants()
        .filter(|node| node.tag_name().name() == "Screen");
    for node in screens {
        let name = node.attribute("Name").unwrap_or("screen");
        let [width, height] = ["Width", "Height"].map(|key| {
            let of = format!("{key} of screen \"{name}\"");
            numbers::<1>(node.attribute(key).unwrap_or_default(), &of)
        });
        let ([width], [height]) = (width?, height?);
        let (mut room_from_here, mut next) = (DAffine3::IDENTITY, Some(node));
        for depth in 0.. {
            let Some(here) = next else {
                break;
            };
            if depth == DEPTH {
                return Err(Fault::new(
                    format!("screen \"{name}\" has more than {DEPTH} parents"),
                    "a node must not be its own parent: correct Parent",
                ));
            }
            room_from_here = local(here)? * room_from_here;
            let parent = here.attribute("Parent");
            next = document.descendants().find(|node| {
                node.attribute("Name")
                    .is_some_and(|name| Some(name) == parent)
                    && node
                        .attribute("PositionLocal")
                        .or(node.attribute("Tracker"))
                        .is_some()
            });
            if here != node
                && here
                    .attribute("Tracker")
                    .is_some_and(|tracker| tracker != "0")
            {
                let parent = here.attribute("Name").unwrap_or_default();
                let ignored = format!("the tracker of \"{parent}\"");
                if !room.ignored.contains(&ignored) {
                    room.ignored.push(ignored);
                }
            }
        }
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, z)| {
            let corner = DVec3::new(0.5 * x * width, 0.0, 0.5 * z * height);
            let DVec3 { x, y, z } = room_from_here.transform_point3(corner);
            DVec3::new(x, z, -y)
        });
        room.walls.push(wall(name, corners)?);
    }
    Ok(room)
}

/// Returns where a node is in its parent.
fn local(node: Node<'_, '_>) -> Result<DAffine3, Fault> {
    let of = |key: &str| {
        format!(
            "{key} of \"{}\"",
            node.attribute("Name").unwrap_or_default()
        )
    };
    let place = node.attribute("PositionLocal").unwrap_or("0,0,0");
    let turn = node.attribute("OrientationLocal").unwrap_or("0,0,0,1");
    let place = numbers::<3>(place, &of("PositionLocal"))?;
    let turn = DQuat::from_array(numbers::<4>(turn, &of("OrientationLocal"))?);
    // Files have six digits.
    let turn = if turn.length_squared() > 0.0 {
        turn.normalize()
    } else {
        DQuat::IDENTITY
    };
    Ok(DAffine3::from_rotation_translation(turn, place.into()))
}

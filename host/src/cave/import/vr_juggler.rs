//! VR Juggler's configuration: four corners a screen, in axes as ours.

use super::{ImportedRoom, numbers, wall};
use crate::files::Fault;
use glam::DVec3;
use roxmltree::{Document, Node};

pub(super) fn read(document: &Document<'_>) -> Result<ImportedRoom, Fault> {
    let mut room = ImportedRoom {
        program: "VR Juggler",
        walls: Vec::new(),
        ignored: vec!["windows, stereo and devices".to_owned()],
    };
    let nodes = document.descendants();
    for node in nodes.filter(|node| node.has_tag_name_of("surface_viewport")) {
        let name = node.attribute("name").unwrap_or("screen");
        if texts(node, "tracked").any(|text| matches!(text.trim(), "true" | "1")) {
            room.ignored
                .push(format!("screen \"{name}\", which a tracker moves"));
            continue;
        }
        let corner = |tag: &str| -> Result<DVec3, Fault> {
            let values: Vec<&str> = texts(node, tag).collect();
            let of = format!("{tag} of screen \"{name}\"");
            numbers::<3>(&values.join(","), &of).map(DVec3::from)
        };
        let corners = [
            corner("lower_left_corner")?,
            corner("lower_right_corner")?,
            corner("upper_right_corner")?,
            corner("upper_left_corner")?,
        ];
        room.walls.push(wall(name, corners)?);
    }
    Ok(room)
}

fn texts<'a>(node: Node<'a, 'a>, tag: &str) -> impl Iterator<Item = &'a str> {
    let children = node.children();
    let children = children.filter(move |child| child.has_tag_name_of(tag));
    children.filter_map(|child| child.text())
}

/// Names of elements whatever their name space is.
trait HasTagName {
    fn has_tag_name_of(&self, name: &str) -> bool;
}

impl HasTagName for Node<'_, '_> {
    fn has_tag_name_of(&self, name: &str) -> bool {
        self.is_element() && self.tag_name().name() == name
    }
}

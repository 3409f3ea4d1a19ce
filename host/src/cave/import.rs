//! Screens of nDisplay's configurations (`.ndisplay`, JSON).
//!
//! There, lengths are centimetres, X is forward, Y to the right and Z up; angles are degrees. A
//! screen is centred on its node, as wide as its Y and as high as its Z goes, and seen from its −X.
//! Only screens and the pixels of viewports that show them are read.

use super::angle::sin_cos_degrees;
use super::{Cave, RoomError, Wall};
use glam::{DMat3, DVec3};
use serde_json::{Map, Value};

/// Walls of another program's room.
#[derive(Debug, Clone, PartialEq)]
pub struct ImportedRoom {
    /// In the order of the file.
    pub walls: Vec<Wall>,
    /// What the file has and a room's file has not: words for a message.
    pub ignored: Vec<String>,
}

impl ImportedRoom {
    /// Reads the screens of a configuration. Those that no viewport shows have `size` pixels.
    ///
    /// # Errors
    /// Text that is not such JSON, a parent that is not there, a screen that makes no wall.
    pub fn from_ndisplay(text: &str, size: [u32; 2]) -> Result<Self, RoomError> {
        read(text, size)
    }

    /// Returns the text of a room's file.
    pub fn to_toml(&self) -> String {
        let entries = self.walls.iter();
        let entries = entries.map(|wall| wall.to_toml(Some(wall.pixels)));
        entries.collect::<Vec<_>>().join("\n")
    }
}

/// A place and axes in a parent's.
#[derive(Clone, Copy)]
struct Pose {
    axes: DMat3,
    location: DVec3,
}

/// Most parents of a node.
const DEEPEST: usize = 64;

fn read(text: &str, size: [u32; 2]) -> Result<ImportedRoom, RoomError> {
    let fault = |message: String| {
        RoomError::new(
            "",
            message,
            "export the configuration from Unreal's editor as .ndisplay",
        )
    };
    let root: Value = serde_json::from_str(text)
        .map_err(|reason| fault(format!("this is not JSON: {reason}")))?;
    let root = root.get("nDisplay").unwrap_or(&root);
    let scene = root.get("scene");
    let screens = scene
        .and_then(|scene| scene.get("screens"))
        .and_then(Value::as_object);
    let none = Map::new();
    let xforms = scene
        .and_then(|scene| scene.get("xforms"))
        .and_then(Value::as_object);
    let xforms = xforms.unwrap_or(&none);
    let (viewports, mut ignored) = viewports(root);
    let mut cave = Cave::default();
    for (name, screen) in screens.unwrap_or(&none) {
        let mut pose = pose_of(screen);
        let mut parent = parent_of(screen);
        for depth in 0.. {
            let Some(id) = parent.filter(|id| !id.is_empty()) else {
                break;
            };
            let node = xforms.get(id).filter(|_| depth < DEEPEST).ok_or_else(|| {
                fault(format!(
                    "the parent \"{id}\" of screen \"{name}\" is not there, or is its own"
                ))
            })?;
            let outer = pose_of(node);
            pose = Pose {
                axes: outer.axes * pose.axes,
                location: outer.location + outer.axes * pose.location,
            };
            parent = parent_of(node);
        }
        let sides = screen.get("size");
        let [width, height] = ["width", "height"].map(|side| number(sides, side));
        let room = |point: DVec3| {
            let millimetres = 10.0 * DVec3::new(point.y, point.z, -point.x);
            // Without the last digits of sines.
            (millimetres * 1.0e6).round() / 1.0e9
        };
        let (across, upward) = (
            0.5 * width * pose.axes.y_axis,
            0.5 * height * pose.axes.z_axis,
        );
        let shown = viewports.iter().find(|(screen, _)| screen == name);
        cave.add_wall(Wall {
            name: name.clone(),
            lower_left: room(pose.location - across - upward),
            lower_right: room(pose.location + across - upward),
            upper_left: room(pose.location - across + upward),
            pixels: shown.map_or(size, |(_, pixels)| *pixels),
        })?;
    }
    if cave.walls.is_empty() {
        return Err(fault(
            "it has no screens in nDisplay.scene.screens".to_owned(),
        ));
    }
    for key in ["cameras", "sceneComponents"] {
        let count = scene
            .and_then(|scene| scene.get(key)?.as_object())
            .map_or(0, Map::len);
        if count > 0 {
            ignored.push(format!(
                "{count} {key}: give the viewer with --head and --ipd"
            ));
        }
    }
    Ok(ImportedRoom {
        walls: cave.walls,
        ignored,
    })
}

/// Returns the screens that viewports show and their pixels, and what other viewports there are.
fn viewports(root: &Value) -> (Vec<(String, [u32; 2])>, Vec<String>) {
    let (mut shown, mut ignored) = (Vec::new(), Vec::new());
    let nodes = root
        .get("cluster")
        .and_then(|cluster| cluster.get("nodes")?.as_object());
    let viewports = nodes.into_iter().flat_map(Map::values);
    let viewports = viewports.filter_map(|node| node.get("viewports")?.as_object());
    for (name, viewport) in viewports.flatten() {
        let policy = viewport.get("projectionPolicy");
        let kind = policy
            .and_then(|policy| policy.get("type")?.as_str())
            .unwrap_or("none");
        let screen = policy.and_then(|policy| policy.get("parameters")?.get("screen")?.as_str());
        let pixels = ["width", "height"].map(|side| {
            let side = number(viewport.get("region"), side);
            side.clamp(0.0, f64::from(u32::MAX)) as u32
        });
        match screen {
            Some(screen) if kind.eq_ignore_ascii_case("simple") && !pixels.contains(&0) => {
                shown.push((screen.to_owned(), pixels));
            }
            _ => ignored.push(format!(
                "viewport {name} of projection {kind}: give a [[projector]] for it"
            )),
        }
    }
    (shown, ignored)
}

/// Returns a number of an object; 0 where there is none.
fn number(object: Option<&Value>, key: &str) -> f64 {
    let keys = [key, &key[..1]];
    // Regions have w and h, or width and height.
    let found = keys.iter().find_map(|key| object?.get(*key)?.as_f64());
    found.unwrap_or(0.0)
}

fn parent_of(node: &Value) -> Option<&str> {
    node.get("parentId")?.as_str()
}

/// Returns a node's pose in its parent: turned by roll about X, then pitch, then yaw.
fn pose_of(node: &Value) -> Pose {
    let (place, turn) = (node.get("location"), node.get("rotation"));
    let [(sp, cp), (sy, cy), (sr, cr)] =
        ["pitch", "yaw", "roll"].map(|angle| sin_cos_degrees(number(turn, angle)));
    let forward = DVec3::new(cp * cy, cp * sy, sp);
    let right = DVec3::new(sr * sp * cy - cr * sy, sr * sp * sy + cr * cy, -sr * cp);
    let up = DVec3::new(-(cr * sp * cy + sr * sy), cy * sr - cr * sp * sy, cr * cp);
    Pose {
        axes: DMat3::from_cols(forward, right, up),
        location: DVec3::from(["x", "y", "z"].map(|axis| number(place, axis))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROOM: &str = r#"{"nDisplay": {"scene": {
        "xforms": {
            "cave_center": {"parentId": "", "location": {"x":0,"y":0,"z":110},
                            "rotation": {"pitch":0,"yaw":0,"roll":0}},
            "angle_left": {"parentId": "cave_center", "location": {"x":150,"y":-150,"z":0},
                           "rotation": {"pitch":0,"yaw":-90,"roll":0}}},
        "cameras": {"camera": {}},
        "screens": {"scr_left": {"size": {"width":300,"height":200}, "parentId": "angle_left",
                    "location": {"x":0,"y":-150,"z":0}, "rotation": {"pitch":0,"yaw":0,"roll":0}}}},
        "cluster": {"nodes": {"node": {"viewports": {
            "left": {"region": {"x":0,"y":0,"w":1920,"h":1080},
                     "projectionPolicy": {"type": "simple", "parameters": {"screen": "scr_left"}}},
            "warped": {"projectionPolicy": {"type": "mpcdi", "parameters": {}}}}}}}}}"#;

    #[test]
    fn screens_stand_where_their_parents_put_them() {
        let imported = read(ROOM, [9, 9]).unwrap();
        let [wall] = &imported.walls[..] else {
            panic!()
        };
        assert_eq!(wall.name, "scr_left");
        assert_eq!(wall.lower_left, DVec3::new(-1.5, 0.1, 1.5));
        assert_eq!(wall.lower_right, DVec3::new(-1.5, 0.1, -1.5));
        assert_eq!(wall.upper_left, DVec3::new(-1.5, 2.1, 1.5));
        assert_eq!(wall.pixels, [1920, 1080]);
        let [viewport, cameras] = &imported.ignored[..] else {
            panic!()
        };
        assert!(viewport.contains("warped") && cameras.contains("1 cameras"));
        // A child higher up whose pitch leans it back: its top goes away from the viewer.
        let pitched = ROOM.replace(
            "\"pitch\":0,\"yaw\":0,\"roll\":0}}}},",
            "\"pitch\":90,\"yaw\":0,\"roll\":0}}}},",
        );
        let wall = read(&pitched, [9, 9]).unwrap().walls.remove(0);
        assert_eq!(wall.upper_left - wall.lower_left, DVec3::new(2.0, 0.0, 0.0));
        for (from, to, says) in [
            (
                "\"parentId\": \"angle_left\"",
                "\"parentId\": \"gone\"",
                "\"gone\"",
            ),
            (
                "\"parentId\": \"\"",
                "\"parentId\": \"angle_left\"",
                "is its own",
            ),
            ("\"width\":300", "\"width\":0", "no width"),
            ("screens", "screen", "no screens"),
            ("{\"nDisplay\"", "nDisplay", "not JSON"),
        ] {
            assert!(ROOM.contains(from), "{from}");
            let error = read(&ROOM.replacen(from, to, 1), [9, 9]).unwrap_err();
            assert!(error.to_string().contains(says), "{says}: {error}");
        }
    }
}

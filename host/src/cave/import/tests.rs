//! The same front and left wall, 3.2 m by 2.4 m, as three programs describe them.

use super::*;

const VRUI: &str = "
section Vrui # all rooms
    section Cave
        screenNames (Front, \\
                     Left)
        section Environment
            unit (Inch)
            up (0.0, 0.0, 1.0)
            forward (0.0, 1.0, 0.0)
        endsection
        section Front
            origin (-62.992126, 47.244094, -1.574803)
            horizontalAxis (1.0, 0.0, 0.0)
            width 125.984252
            verticalAxis (0.0, 0.0, 2.0)
            height 94.488189
        endsection
        section Left
            origin (-62.992126, -78.740157, -1.574803)
            horizontalAxis (0.0, 1.0, 0.0)
            width 125.984252
            verticalAxis (0.0, 0.0, 1.0)
            height 94.488189
        endsection
        section Glasses
            deviceMounted true
            origin (0, 0, 0)
        endsection
    endsection
endsection
";

const MIDDLEVR: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<MiddleVR><DisplayManager>
  <Node3D Name="Centre" Parent="None" Tracker="Mouse.Tracker" />
  <Node3D Name="Screens" Parent="Centre" Tracker="0" PositionLocal="0,0,1.160000"
    OrientationLocal="0,0,0,1" />
  <Screen Name="Front" Parent="Screens" PositionLocal="0,1.2,0" OrientationLocal="0,0,0,1"
    Width="3.2" Height="2.4" />
  <Screen Name="Left" Parent="Screens" PositionLocal="-1.6,-0.4,0"
    OrientationLocal="0,0,0.707107,0.707106" Width="3.2" Height="2.4" />
</DisplayManager></MiddleVR>"#;

/// Returns the same of VR Juggler.
fn vr_juggler() -> String {
    let screens = WALLS.map(|(name, corners)| {
        let names = ["lower_left", "lower_right", "upper_right", "upper_left"];
        let corners = names.into_iter().zip(corners).flat_map(|(corner, place)| {
            place.map(|value| format!("<{corner}_corner>{value}</{corner}_corner>\n"))
        });
        let corners: String = corners.collect();
        format!("<surface_viewport name=\"{name}\" version=\"2\">{corners}</surface_viewport>")
    });
    let name_space = "http://www.vrjuggler.org/jccl/xsd/3.0/configuration";
    format!(
        "<configuration xmlns=\"{name_space}\">{}</configuration>",
        screens.concat()
    )
}

const WALLS: [(&str, [[f64; 3]; 4]); 2] = [
    (
        "Front",
        [
            [-1.6, -0.04, -1.2],
            [1.6, -0.04, -1.2],
            [1.6, 2.36, -1.2],
            [-1.6, 2.36, -1.2],
        ],
    ),
    (
        "Left",
        [
            [-1.6, -0.04, 2.0],
            [-1.6, -0.04, -1.2],
            [-1.6, 2.36, -1.2],
            [-1.6, 2.36, 2.0],
        ],
    ),
];

#[test]
fn walls_of_three_programs_are_the_same() {
    for (text, ignored) in [
        (VRUI.to_owned(), "\"Glasses\""),
        (MIDDLEVR.to_owned(), "\"Centre\""),
        (vr_juggler(), "windows"),
    ] {
        let room = ImportedRoom::from_text(&text, None, [9; 2]).unwrap();
        let program = room.program;
        assert_eq!(room.walls.len(), 2, "{program}");
        for (wall, (name, corners)) in room.walls.iter().zip(WALLS) {
            assert_eq!(wall.name, name);
            for (own, expected) in wall.corners().into_iter().zip(corners) {
                let off = own.distance(expected.into());
                assert!(off < 5e-6, "{program} {name}: {off}");
            }
        }
        assert!(
            room.ignored.iter().any(|one| one.contains(ignored)),
            "{program}"
        );
    }
}

#[test]
fn files_that_are_no_rooms_are_refused_with_what_is_wrong() {
    let bent = vr_juggler().replacen("<upper_right_corner>1.6", "<upper_right_corner>1.602", 1);
    let several = VRUI.replace("endsection\nendsection\n", "endsection\n")
        + &VRUI["\nsection Vrui # all rooms\n".len()..].replace("section Cave", "section Desk");
    let looped = MIDDLEVR.replace("Parent=\"None\"", "Parent=\"Screens\"");
    for (text, says) in [
        (bent, "2.0 mm off"),
        (several.clone(), "several rooms"),
        (looped, "parents"),
        (VRUI.replace("(Inch)", "(Cubit)"), "(Cubit)"),
        (VRUI.replace("width 125.984252", "width wide"), "\"wide\""),
        (VRUI.replace("endsection", ""), "no file of nDisplay, Vrui"),
        (VRUI.replace("125.984252", "NaN"), "lower right"),
        ("section x\n".repeat(100_000), "sections in one another"),
        ("<configuration/>".to_owned(), "no flat screens"),
        ("<configuration>".to_owned(), "XML"),
        (String::new(), "no file of nDisplay, Vrui"),
    ] {
        let error = ImportedRoom::from_text(&text, None, [9; 2])
            .unwrap_err()
            .to_string();
        assert!(error.contains(says), "{says}: {error}");
    }
    assert!(ImportedRoom::from_text(&several, Some("Desk"), [9; 2]).is_ok());
}

//! Domes as screens: their pictures for an eye anywhere inside, and the warps
//! that bring these onto them.

use glam::{DVec2, DVec3};
use serde_json::{Value, json};
use shisen::bake::Baked;
use shisen::cave::warp::{Nodes, Projector, Warp};
use shisen::cave::{Cave, DomeScreen, Eye, Wall};
use shisen::picture::Picture;
use shisen::render::{Observer, Options};
use shisen::scene::builtin::{PaperScene, paper_scene};
use shisen::scene::material::Material;
use shisen::scene::{Background, Scene};
use shisen::show::overview::viewer::{self, ViewerCamera};
use shisen_tests::command::{folder, refused, report, says};
use shisen_tests::meshes::icosphere;
use shisen_tests::scenes::{empty, frame, sphere};
use std::fs;
use std::io::{Cursor, Read};

const SIZE: u32 = 256;

/// Larger than a hemisphere, leaning to the front, beside the origin.
fn room(size: u32) -> Cave {
    let text = r#"
        [[dome]]
        name = "sky"
        radius = 2.5
        centre = [0.2, -0.5, 0.3]
        tilt_degrees = 25
        field_of_view_degrees = 230
    "#;
    Cave::from_toml(text, "room.toml", [size; 2]).expect("a room")
}

/// Off the dome's centre, by two thirds of its radius.
const EYE: DVec3 = DVec3::new(-0.9, 0.6, 0.6);

/// What an eye is shown.
fn shown(scene: &Scene, room: &Cave, eye: DVec3) -> Picture {
    let baked = Baked::<8>::new(scene).expect("a scene");
    let eyes = [Observer::new(Eye::Centre, eye)];
    frame(&baked, room, &eyes, &Options::default())
        .pictures
        .remove(0)
        .picture
}

/// A ball alone, white before nothing.
fn ball(place: DVec3, radius: f64) -> Scene {
    Scene {
        materials: vec![Material {
            diffuse: [1.0; 3],
            ..Material::default()
        }],
        objects: vec![sphere(radius as f32, 0, place)],
        background: Background {
            alpha: 0.0,
            ..Background::uniform([0.0; 3])
        },
        ..empty()
    }
}

/// The mean direction of what is opaque, each pixel by its solid angle;
/// `direction` is that of a point of the picture, in pixels from its corner.
fn middle(picture: &Picture, direction: impl Fn(DVec2) -> DVec3) -> DVec3 {
    let mut sum = DVec3::ZERO;
    for (x, y) in (0..picture.height).flat_map(|y| (0..picture.width).map(move |x| (x, y))) {
        let alpha = f64::from(picture.pixel(x, y).expect("a pixel")[3]);
        if alpha > 0.0 {
            let at = DVec2::new(f64::from(x), f64::from(y)) + 0.5;
            let half = |step: DVec2| direction(at + 0.5 * step) - direction(at - 0.5 * step);
            let solid_angle = half(DVec2::X).cross(half(DVec2::Y)).length();
            sum += alpha * solid_angle * direction(at);
        }
    }
    sum.normalize()
}

/// Where a point of a dome's picture is on it, seen from an eye.
fn through(dome: &DomeScreen, eye: DVec3) -> impl Fn(DVec2) -> DVec3 {
    let side = f64::from(dome.size);
    move |at| {
        let place = (2.0 * at / side - 1.0) * DVec2::new(1.0, -1.0);
        (dome.point(place) - eye).normalize()
    }
}

#[test]
fn things_are_seen_where_they_stand() {
    let room = room(SIZE);
    let dome = &room.domes[0];
    let mut worst = [0f64; 2];
    for (distance, direction) in [0.3, 1.0, 4.0, 60.0].into_iter().flat_map(|distance| {
        [
            DVec3::new(0.0, 0.0, -1.0),
            DVec3::new(1.0, 0.3, -0.2),
            DVec3::new(-0.4, 1.0, 0.3),
            DVec3::new(0.5, 0.6, 0.8),
            DVec3::new(-0.7, -0.2, -0.6),
        ]
        .map(|direction| (distance, direction.normalize()))
    }) {
        let place = EYE + distance * direction;
        let scene = ball(place, 0.05 * distance);
        let picture = shown(&scene, &room, EYE);
        let found = middle(&picture, through(dome, EYE));
        // The dome as large as it looks from its centre; as the eye sees it,
        // pixels are up to three times that.
        let pixel = dome.field_of_view() / f64::from(SIZE);
        let apart = found.angle_between(direction) / pixel;
        worst[0] = worst[0].max(apart);
        // Looking there, the viewer sees it in the middle of the view.
        let up = direction.any_orthonormal_vector();
        let camera = ViewerCamera::new(EYE, direction, up, 0.5, [201, 151]);
        let camera = camera.expect("a camera");
        let view = viewer::render(&camera, &[(dome, &picture)]).expect("a view");
        let seen = middle(&view, |at| camera.ray(at.x, at.y));
        let apart = seen.angle_between(direction) / pixel;
        worst[1] = worst[1].max(apart);
    }
    assert!(worst[0] < 0.3 && worst[1] < 0.3, "{worst:?}");
}

#[test]
fn a_cave_with_a_dome_is_reported_and_drawn_whole() {
    let folder = folder();
    let folder = folder.path();
    let walls = "[[dome]]\nname = \"sky\"\nradius = 2\ncentre = [0, 0, 0]\nsize = 96\n\
                 [[wall]]\nname = \"floor\"\nlower_left = [-1, -1, 1]\n\
                 lower_right = [1, -1, 1]\nupper_left = [-1, -1, -1]\n";
    fs::write(folder.join("room.toml"), walls).expect("a file");
    let report = report(folder, "cave --walls room.toml --size 64 --lod paper --exr");
    let images = report["images"].as_array().expect("images");
    assert_eq!(images.len(), 4);
    assert_eq!(images[0]["wall"], "floor");
    for (key, expected) in [
        ("wall", "sky"),
        ("eye", "right"),
        ("path", "shisen-out/sky-right.png"),
    ] {
        assert_eq!(images[3][key], expected);
    }
    let open = |name: &str| image::open(folder.join("shisen-out").join(name)).expect("a picture");
    let dome = open("sky-left.png");
    assert_eq!(dome.color(), image::ColorType::Rgba8);
    let dome = dome.into_rgba8();
    assert_eq!(dome.dimensions(), (96, 96));
    assert_eq!(dome.get_pixel(0, 0).0, [0; 4]);
    assert_eq!(dome.get_pixel(48, 0).0[3], 255);
    assert_eq!(open("floor-left.png").color(), image::ColorType::Rgb8);
    for name in ["cave", "viewer", "levels", "polygons", "difference"] {
        assert!(open(&format!("{name}.png")).width() > 96, "{name}");
    }
    // Shares are of the pixels that the dome has.
    let field = report["lod"]["field"].as_array().expect("fields");
    assert_eq!(field.len(), 4);
    for field in field {
        let share = |key: &str| field[key].as_f64().expect("a share");
        let all = share("central") + share("peripheral") + share("outside");
        assert!((all - 1.0).abs() < 1e-12);
        if field["wall"] == "sky" {
            assert!(share("central") > 0.05 && share("outside") < 0.7, "{field}");
        }
    }
}

const PROJECTOR: &str = r#"
name = "back"
position = [0.3, -0.9, 2.2]
look = [0, 0.3, -1]
horizontal_degrees = 80
lens_shift = [0, 0.2]
resolution = [640, 400]
"#;

const ROOM: &str = r#"
[[dome]]
name = "sky"
radius = 2.5
centre = [0.2, -0.5, 0.3]
tilt_degrees = 25
field_of_view_degrees = 170
"#;

/// A folder with both, the same as the library reads them, and what the
/// command said of a warp written to `out` there.
fn warped(format: &str, grid: &str) -> (Vec<u8>, DomeScreen, Projector, Value) {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("room.toml"), ROOM).expect("a file");
    fs::write(folder.join("back.toml"), PROJECTOR).expect("a file");
    let words = format!(
        "dome warp --walls room.toml --dome sky --projector back.toml --format {format} -o out {grid}"
    );
    let found = report(folder, &words);
    says(&found, json!({ "path": "out", "format": format }));
    says(&found, json!({ "dome": "sky", "projector": "back" }));
    let cave = Cave::from_toml(ROOM, "", [1; 2]).expect("a room");
    let projector = Projector::from_toml(PROJECTOR, "").expect("a projector");
    let file = fs::read(folder.join("out")).expect("a warp");
    (file, cave.domes[0].clone(), projector, found)
}

/// Where a projector's light to a point of the room is on its picture, −1 to 1
/// to the right and upwards: the opposite way to that of the warp.
fn projected(projector: &Projector, point: DVec3) -> DVec2 {
    let towards = projector.axes.transpose() * (point - projector.position);
    let at = towards.truncate() / -towards.z;
    let [left, right, down, up] = projector.edges;
    DVec2::new(
        (2.0 * at.x - left - right) / (right - left),
        (2.0 * at.y - down - up) / (up - down),
    )
}

#[test]
fn a_bourke_mesh_brings_the_dome_master_where_light_arrives() {
    for (grid, expected) in [("", [80, 60]), ("--grid 33x21", [33, 21])] {
        let (file, dome, projector, report) = warped("bourke", grid);
        assert_eq!([&report["columns"], &report["rows"]], expected);
        assert!(report["profile"].is_null());
        let text = String::from_utf8(file).expect("text");
        let mut lines = text.lines();
        assert_eq!(lines.next(), Some("2"));
        let [columns, rows] = expected;
        assert_eq!(lines.next(), Some(format!("{columns} {rows}").as_str()));
        let nodes: Vec<[f64; 5]> = lines
            .map(|line| {
                let numbers = line.split(' ').map(str::parse::<f64>);
                let numbers: Vec<f64> = numbers.collect::<Result<_, _>>().expect("numbers");
                numbers.try_into().expect("five numbers")
            })
            .collect();
        assert_eq!(nodes.len(), columns * rows);
        let mut drawn = 0;
        for (number, [x, y, u, v, i]) in nodes.into_iter().enumerate() {
            let (column, row) = (number % columns, number / columns);
            let along =
                |number: usize, count: usize| 2.0 * number as f64 / (count - 1) as f64 - 1.0;
            assert!((x - 1.6 * along(column, columns)).abs() < 1e-6);
            assert!((y - along(row, rows)).abs() < 1e-6);
            if i < 0.0 {
                assert_eq!([u, v, i], [0.0, 0.0, -1.0]);
                continue;
            }
            drawn += 1;
            assert_eq!(i, 1.0);
            let place = 2.0 * DVec2::new(u, v) - 1.0;
            assert!(place.length() < 1.0 + 1e-6);
            let back = projected(&projector, dome.point(place));
            assert!(
                (back - DVec2::new(x / 1.6, y)).length() < 3e-6,
                "{back} {x} {y}"
            );
        }
        assert_eq!(report["drawn"], drawn);
        // Some of its light goes past the rim.
        assert!(
            drawn > columns * rows / 2 && drawn < columns * rows,
            "{drawn}"
        );
    }
}

/// A projector where the viewer's eye is has to show what the eye sees: a plain
/// perspective, in spite of the dome between.
#[test]
fn a_warp_for_a_projector_at_the_eye_shows_a_plain_perspective() {
    let scene = paper_scene(PaperScene::B, icosphere(4)).expect("a scene");
    let room = room(1024);
    let dome = &room.domes[0];
    let master = shown(&scene, &room, EYE);
    let text = format!(
        "name = \"eye\"\nposition = [{}, {}, {}]\nlook = [0.2, 0.1, -1]\n\
         horizontal_degrees = 70\nresolution = [200, 150]\n",
        EYE.x, EYE.y, EYE.z
    );
    let projector = Projector::from_toml(&text, "").expect("a projector");
    let warp = Warp::new(dome, &projector, [200, 150], Nodes::Centres).expect("a warp");
    // The same picture, traced as a flat wall's at distance 1.
    let [left, right, down, up] = projector.edges;
    let corner = |x: f64, y: f64| EYE + projector.axes * DVec3::new(x, y, -1.0);
    let wall = Wall::new(
        "picture",
        corner(left, down),
        corner(right, down),
        corner(left, up),
        [200, 150],
    );
    let flat = Cave::new(vec![wall.expect("a wall")]).expect("a room");
    let direct = shown(&scene, &flat, EYE);
    let (mut sum, mut count) = (0.0, 0);
    for (x, y) in (0..150).flat_map(|y| (0..200).map(move |x| (x, y))) {
        let Some(node) = warp.node(x, y) else {
            continue;
        };
        let at = (node.place * DVec2::new(1.0, -1.0) + 1.0) * 512.0;
        let found = master.sample(at.x, at.y);
        let expected = direct.pixel(x, y).expect("a pixel");
        let apart = found
            .iter()
            .zip(expected)
            .map(|(a, b)| f64::from((a - b).abs()));
        sum += apart.sum::<f64>();
        count += 4;
    }
    let mean = sum / f64::from(count);
    assert!(mean < 0.005 && count / 4 > 25_000, "{mean} {count}");
}

/// The text of the first element of a name.
fn text<'x>(xml: &'x str, name: &str) -> &'x str {
    let (_, rest) = xml.split_once(&format!("<{name}>")).expect("an element");
    rest.split('<').next().unwrap_or_default()
}

/// A portable float map: columns, rows, and points from the upper left one.
fn points(file: &[u8]) -> ([usize; 2], Vec<DVec3>) {
    let mut lines = file.splitn(4, |&byte| byte == b'\n');
    let mut line = || std::str::from_utf8(lines.next().expect("a line")).expect("text");
    assert_eq!(line(), "PF");
    let size: Vec<usize> = line()
        .split(' ')
        .map(|n| n.parse().expect("a number"))
        .collect();
    // Below 0: the least byte first.
    assert_eq!(line().parse::<f64>(), Ok(-1.0));
    let [columns, rows] = size.try_into().expect("columns and rows");
    let bytes = lines.next().expect("points");
    assert_eq!(bytes.len(), 12 * columns * rows);
    let floats: Vec<f64> = bytes
        .as_chunks()
        .0
        .iter()
        .map(|&bytes| f64::from(f32::from_le_bytes(bytes)))
        .collect();
    let upwards: Vec<DVec3> = floats.chunks(3).map(DVec3::from_slice).collect();
    let from_above = upwards.chunks(columns).rev().flatten().copied();
    ([columns, rows], from_above.collect())
}

#[test]
fn an_mpcdi_archive_has_the_points_that_light_arrives_at() {
    for (grid, expected) in [("", [640, 400]), ("--grid 50x30", [50, 30])] {
        let (file, dome, projector, report) = warped("mpcdi", grid);
        assert_eq!([&report["columns"], &report["rows"]], expected);
        assert_eq!(report["profile"], "a3");
        let mut archive = zip::ZipArchive::new(Cursor::new(file)).expect("an archive");
        let mut entry = |name: &str| {
            let mut bytes = Vec::new();
            let mut entry = archive.by_name(name).expect("an entry");
            entry.read_to_end(&mut bytes).expect("bytes");
            bytes
        };
        let xml = String::from_utf8(entry("mpcdi.xml")).expect("text");
        assert!(
            xml.contains("profile=\"a3\"") && xml.contains("Xresolution=\"640\""),
            "{xml}"
        );
        for (name, value) in [
            ("posy", "-0.900000000"),
            ("rollz", "-1.000000000"),
            ("geometricUnit", "m"),
            ("interpolation", "linear"),
            ("originOf3DData", "idealEyePoint"),
            ("bitDepth", "8"),
        ] {
            assert_eq!(text(&xml, name), value, "{name}");
        }
        // The frustum's edges are the projector's.
        for (name, edge) in ["left", "right", "down", "up"]
            .into_iter()
            .zip(projector.edges)
        {
            let degrees: f64 = text(&xml, &format!("{name}Angle"))
                .parse()
                .expect("a number");
            assert!((degrees.to_radians().tan() - edge).abs() < 1e-9, "{name}");
        }
        let path_after = |name: &str| {
            let (_, rest) = xml.split_once(&format!("<{name}>")).expect("an element");
            text(rest, "path")
        };
        let (size, points) = points(&entry(path_after("geometryWarpFile")));
        assert_eq!(size, expected);
        let weights = entry(path_after("alphaMap"));
        let weights = image::load_from_memory(&weights).expect("a picture");
        assert_eq!(weights.color(), image::ColorType::L8);
        let weights = weights.into_luma8();
        let [columns, rows] = size;
        assert_eq!(weights.dimensions(), (columns as u32, rows as u32));
        let mut drawn = 0;
        for (number, (point, weight)) in points.into_iter().zip(weights.pixels()).enumerate() {
            assert_eq!(weight.0 == [255], !point.is_nan());
            if weight.0 == [0] {
                assert!(point.is_nan_mask().all());
                continue;
            }
            drawn += 1;
            assert!((point.distance(dome.centre) - 2.5).abs() < 1e-6);
            assert!(dome.place(point).expect("a place").length() < 1.0 + 1e-6);
            let at = |number: usize, count: usize| (2 * number + 1) as f64 / count as f64 - 1.0;
            let expected = DVec2::new(at(number % columns, columns), -at(number / columns, rows));
            let back = projected(&projector, point);
            assert!((back - expected).length() < 2e-6, "{back} {expected}");
        }
        assert_eq!(report["drawn"], drawn);
    }
}

#[test]
fn impossible_warps_are_refused_and_nothing_is_written() {
    let folder = folder();
    let folder = folder.path();
    let file = |name: &str, text: String| fs::write(folder.join(name), text).expect("a file");
    file("room.toml", ROOM.to_owned());
    let two = format!("{ROOM}{}", ROOM.replace("sky", "small"));
    file("two.toml", two);
    let wall = "lower_left = [-1, -1, -1]\nlower_right = [1, -1, -1]\nupper_left = [-1, 1, -1]\n";
    file("flat.toml", format!("[[wall]]\nname = \"front\"\n{wall}"));
    file("bad.toml", ROOM.replace("170", "400"));
    file("back.toml", PROJECTOR.to_owned());
    file("away.toml", PROJECTOR.replace("0.3, -1]", "-1, -0.1]"));
    file("wide.toml", PROJECTOR.replace("80", "200"));
    file("key.toml", PROJECTOR.replace("look", "looks"));
    for (code, walls, projector, more, expected) in [
        (1, "room", "away", "bourke", "does not see dome \"sky\""),
        (1, "room", "wide", "bourke", "200°"),
        (1, "room", "key", "bourke", "unknown field `looks`"),
        (1, "room", "no", "bourke", "no.toml"),
        (1, "bad", "back", "bourke", "400°"),
        (2, "flat", "back", "bourke", "no dome in --walls"),
        (2, "two", "back", "bourke", "sky, small"),
        (2, "two", "back", "bourke --dome large", "no dome \"large\""),
        (2, "room", "back", "bourke --grid 1x9", "1 × 9"),
        (2, "room", "back", "bourke --grid 0x9", "--grid"),
        (2, "room", "back", "pdf", "mpcdi"),
    ] {
        let files = format!("--walls {walls}.toml --projector {projector}.toml");
        let words = format!("dome warp {files} --format {more} -o out");
        refused(folder, code, &format!("{words} => {expected}"));
        assert!(!folder.join("out").exists());
    }
    let outside = "cave --walls dome --head 0,1,0 --out new => not inside dome & 2.475";
    refused(folder, 1, outside);
    assert!(!folder.join("new").exists());
}

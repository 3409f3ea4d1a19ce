//! Domes as screens: their pictures for an eye anywhere inside, and the warps
//! that bring these onto them.

use glam::{DAffine3, DVec2, DVec3};
use quick_xml::Reader;
use quick_xml::events::Event;
use serde_json::Value;
use shisen::bake::Baked;
use shisen::cave::warp::{Nodes, Projector, Warp};
use shisen::cave::{Cave, DomeScreen, Eye, Wall};
use shisen::picture::Picture;
use shisen::render::{self, Observer, Options};
use shisen::scene::builtin::{PaperScene, paper_scene};
use shisen::scene::material::Material;
use shisen::scene::{Background, Object, Scene, Shape};
use shisen::show::overview::viewer::{self, ViewerCamera};
use shisen_core::Simd;
use shisen_core::frame::{LevelOfDetail, Mode, Settings};
use shisen_core::gaze::{Gaze, LineOfSight, VisualField};
use shisen_tests::command::shisen;
use shisen_tests::meshes::icosphere;
use std::collections::HashMap;
use std::fs;
use std::io::{Cursor, Read};
use std::path::Path;

const SIZE: u32 = 512;

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
    let options = Options::default();
    let frame = render::cave(&baked.scene(), room, &eyes, &options, &|_, _| {});
    frame.expect("a frame").pictures.remove(0).picture
}

/// A ball alone, white before nothing.
fn ball(place: DVec3, radius: f64) -> Scene {
    Scene {
        name: "ball".to_owned(),
        meshes: Vec::new(),
        materials: vec![Material {
            diffuse: [1.0; 3],
            ..Material::default()
        }],
        objects: vec![Object {
            shape: Shape::Sphere {
                radius: radius as f32,
            },
            material: Some(0),
            world_from_object: DAffine3::from_translation(place),
            casts_shadow: true,
            smooth: true,
        }],
        lights: Vec::new(),
        background: Background {
            alpha: 0.0,
            ..Background::uniform([0.0; 3])
        },
        ambient: [1.0; 3],
        camera: shisen::scene::camera::CameraPath::default(),
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
    let side = f64::from(dome.size());
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
        let camera = ViewerCamera::new(EYE, direction, up, 0.5, [401, 301]);
        let camera = camera.expect("a camera");
        let view = viewer::render(&camera, &[(dome, &picture)]).expect("a view");
        let seen = middle(&view, |at| camera.ray(at.x, at.y));
        let apart = seen.angle_between(direction) / pixel;
        worst[1] = worst[1].max(apart);
    }
    println!(
        "pixels of the dome's centre: picture {}, view {}",
        worst[0], worst[1]
    );
    assert!(worst[0] < 0.3 && worst[1] < 0.3, "{worst:?}");
}

#[test]
fn a_wrong_eye_sees_them_elsewhere() {
    let room = room(SIZE);
    let dome = &room.domes[0];
    let place = DVec3::new(0.5, 0.8, -6.0);
    let picture = shown(&ball(place, 0.3), &room, EYE);
    let wrong = EYE + DVec3::new(0.05, 0.0, 0.0);
    let apart = |eye: DVec3| middle(&picture, through(dome, eye)).angle_between(place - eye);
    assert!(
        apart(wrong) > 10.0 * apart(EYE),
        "{} {}",
        apart(wrong),
        apart(EYE)
    );
}

/// As for walls: what the viewer sees on the dome is what a picture traced from
/// the eye shows.
#[test]
fn a_dome_and_flat_walls_show_the_same_scene() {
    let scene = paper_scene(PaperScene::B, icosphere(4)).expect("a scene");
    let text = r#"
        [[wall]]
        name = "all"
        lower_left = [-40, -30, -5]
        lower_right = [40, -30, -5]
        upper_left = [-40, 30, -5]
        pixels = [4096, 3072]
    "#;
    let flat = Cave::from_toml(text, "flat.toml", [1; 2]).expect("a room");
    let dome = room(2048);
    let pictures = [&flat, &dome].map(|room| shown(&scene, room, EYE));
    let look = DVec3::new(0.2, 0.1, -1.0);
    let camera = |eye| ViewerCamera::new(eye, look, DVec3::Y, 1.2, [200, 150]).expect("a camera");
    let view =
        |eye, screen, picture| viewer::render(&camera(eye), &[(screen, picture)]).expect("a view");
    let screens = [&flat, &dome].map(|room| room.screens().next().expect("a screen"));
    let direct = view(EYE, screens[0], &pictures[0]);
    let apart = |eye| {
        let seen = view(eye, screens[1], &pictures[1]);
        let mut sum = 0.0;
        for (a, b) in seen.pixels.iter().zip(&direct.pixels) {
            sum += a
                .iter()
                .zip(b)
                .map(|(a, b)| f64::from((a - b).abs()))
                .sum::<f64>();
        }
        sum / (4 * seen.pixels.len()) as f64
    };
    let (right, wrong) = (apart(EYE), apart(EYE + DVec3::new(0.05, 0.0, 0.0)));
    println!("mean difference {right}, of a wrong eye {wrong}");
    assert!(right < 0.004 && wrong > 3.0 * right, "{right} {wrong}");
}

#[test]
fn the_same_bytes_come_from_any_threads_tiles_and_vectors() {
    let mut scene = paper_scene(PaperScene::A, icosphere(2)).expect("a scene");
    scene.background.alpha = 0.25;
    let baked = (
        Baked::<8>::new(&scene).expect("a scene"),
        Baked::<4>::new(&scene).expect("a scene"),
    );
    let room = room(61);
    let line = LineOfSight::new(
        EYE.as_vec3(),
        glam::Vec3::new(0.3, 0.6, -1.0),
        glam::Vec3::Y,
    );
    let gaze = Gaze::new(line.expect("a line of sight"), VisualField::PAPER);
    let lod = LevelOfDetail::new(gaze);
    for (samples, lod) in [(1, None), (1, Some(lod)), (11, None), (4, Some(lod))] {
        let mut hashes = Vec::new();
        for (threads, tile, simd, mode) in [
            (1, 64, Simd::PORTABLE, Mode::Single),
            (1, 8, Simd::detect(), Mode::Single),
            (3, 13, Simd::PORTABLE, Mode::Tile),
            (2, 1, Simd::detect(), Mode::Tile),
        ] {
            let settings = Settings {
                samples,
                mode,
                ..Settings::default()
            };
            let options = Options {
                settings,
                threads,
                tile,
                simd,
                ..Options::default()
            };
            let place = EYE;
            let eye = Eye::Left;
            let eyes = [Observer {
                lod,
                ..Observer::new(eye, place)
            }];
            let frame = render::cave(&baked.0.scene(), &room, &eyes, &options, &|_, _| {});
            let frame = frame.expect("a frame");
            hashes.push((frame.hash(), frame.statistics.primary));
            let frame = render::cave(&baked.1.scene(), &room, &eyes, &options, &|_, _| {});
            let frame = frame.expect("a frame");
            hashes.push((frame.hash(), frame.statistics.primary));
        }
        hashes.dedup();
        assert_eq!(hashes.len(), 1, "{samples} {lod:?}");
    }
}

fn run(folder: &Path, arguments: &[&str]) -> Value {
    let output = shisen(folder)
        .args(arguments)
        .arg("--json")
        .assert()
        .success();
    serde_json::from_slice(&output.get_output().stdout).expect("JSON")
}

/// From a dome's centre its picture is the dome master that is taken there.
#[test]
fn at_the_centre_the_picture_is_the_true_dome_master() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    for (scene, tilt, degrees) in [("A", "0", "180"), ("C", "30", "180"), ("B", "-65", "300")] {
        let text = format!(
            "[[dome]]\nname = \"sky\"\nradius = 2.5\ncentre = [0.3, -0.2, 0.1]\n\
             tilt_degrees = {tilt}\nfield_of_view_degrees = {degrees}\n"
        );
        fs::write(folder.join("room.toml"), text).expect("a file");
        let at = "0.3,-0.2,0.1";
        let common = ["--scene", scene, "--size", "333", "--quiet"];
        let mut cave = vec!["cave", "--walls", "room.toml", "--eyes", "1", "--head", at];
        let mut dome = vec!["dome", "render", "--mapping", "true", "--at", at];
        cave.extend(["--out", "cave", "--view-size", "8x6"]);
        dome.extend(["--tilt", tilt, "--fov", degrees, "--out", "dome/one.png"]);
        let cave = run(folder, &[&cave[..], &common].concat());
        let dome = run(folder, &[&dome[..], &common].concat());
        let [a, b] = ["cave/sky-centre.png", "dome/one_00001.png"].map(|name| {
            image::open(folder.join(name))
                .expect("a picture")
                .into_rgba8()
        });
        let differ = a.pixels().zip(b.pixels()).filter(|(a, b)| a != b).count();
        println!(
            "{scene}, {tilt}°, {degrees}°: {differ} of {} pixels differ",
            333 * 333
        );
        assert_eq!(differ, 0);
        assert_eq!(cave["images"][0]["hash"], dome["images"][0]["hash"]);
        assert_eq!(cave["rays"]["primary"], dome["rays"]["primary"]);
    }
}

#[test]
fn a_cave_with_a_dome_is_reported_and_drawn_whole() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let walls = "[[dome]]\nname = \"sky\"\nradius = 2\ncentre = [0, 0, 0]\nsize = 96\n\
                 [[wall]]\nname = \"floor\"\nlower_left = [-1, -1, 1]\n\
                 lower_right = [1, -1, 1]\nupper_left = [-1, -1, -1]\n";
    fs::write(folder.join("room.toml"), walls).expect("a file");
    let arguments = [
        "cave",
        "--walls",
        "room.toml",
        "--size",
        "64",
        "--lod",
        "paper",
    ];
    let report = run(folder, &[&arguments[..], &["--exr"]].concat());
    let images = report["images"].as_array().expect("images");
    let names: Vec<_> = images
        .iter()
        .map(|image| {
            (
                image["wall"].as_str(),
                image["eye"].as_str(),
                &image["path"],
            )
        })
        .collect();
    assert_eq!(names.len(), 4);
    assert_eq!(names[0].0, Some("floor"));
    assert_eq!((names[3].0, names[3].1), (Some("sky"), Some("right")));
    assert_eq!(names[3].2, "shisen-out/sky-right.png");
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
    // Shown in words, too.
    let output = shisen(folder)
        .args(["cave", "--walls", "dome", "--size", "32", "--quiet"])
        .args(["--view-size", "8x6"])
        .assert()
        .success();
    let text = String::from_utf8(output.get_output().stdout.clone()).expect("text");
    assert!(text.contains(": 1 dome, 2 eyes, traced"), "{text}");
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
fn warped(format: &str, grid: Option<&str>) -> (Vec<u8>, DomeScreen, Projector, Value) {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    fs::write(folder.join("room.toml"), ROOM).expect("a file");
    fs::write(folder.join("back.toml"), PROJECTOR).expect("a file");
    let mut arguments = vec!["dome", "warp", "--walls", "room.toml", "--dome", "sky"];
    arguments.extend(["--projector", "back.toml", "--format", format, "-o", "out"]);
    if let Some(grid) = grid {
        arguments.extend(["--grid", grid]);
    }
    let report = run(folder, &arguments);
    assert_eq!(report["path"], "out");
    assert_eq!(report["format"], format);
    assert_eq!(report["dome"], "sky");
    assert_eq!(report["projector"], "back");
    let cave = Cave::from_toml(ROOM, "", [1; 2]).expect("a room");
    let projector = Projector::from_toml(PROJECTOR, "").expect("a projector");
    let file = fs::read(folder.join("out")).expect("a warp");
    // The same warp is the same file.
    run(folder, &arguments);
    assert_eq!(fs::read(folder.join("out")).expect("a warp"), file);
    (file, cave.domes[0].clone(), projector, report)
}

/// Where a projector's light to a point of the room is on its picture, −1 to 1
/// to the right and upwards: the opposite way to that of the warp.
fn projected(projector: &Projector, point: DVec3) -> DVec2 {
    let towards = projector.axes().transpose() * (point - projector.position());
    let at = towards.truncate() / -towards.z;
    let [left, right, down, up] = projector.edges();
    DVec2::new(
        (2.0 * at.x - left - right) / (right - left),
        (2.0 * at.y - down - up) / (up - down),
    )
}

#[test]
fn a_bourke_mesh_brings_the_dome_master_where_light_arrives() {
    for (grid, expected) in [(None, [80, 60]), (Some("33x21"), [33, 21])] {
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
                let numbers = line
                    .split(' ')
                    .map(|number| number.parse().expect("a number"));
                numbers
                    .collect::<Vec<f64>>()
                    .try_into()
                    .expect("five numbers")
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
    let room = room(2048);
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
    let [left, right, down, up] = projector.edges();
    let corner = |x: f64, y: f64| EYE + projector.axes() * DVec3::new(x, y, -1.0);
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
        let at = (node.place * DVec2::new(1.0, -1.0) + 1.0) * 1024.0;
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
    println!("mean difference {mean} of {} pixels", count / 4);
    assert!(mean < 0.003 && count / 4 > 25_000, "{mean} {count}");
}

/// The text of each element by its path, and its attributes as `path@name`.
fn elements(xml: &str) -> HashMap<String, String> {
    let mut reader = Reader::from_str(xml);
    let (mut path, mut found) = (Vec::new(), HashMap::new());
    loop {
        match reader.read_event().expect("XML") {
            Event::Start(element) => {
                path.push(element.name().as_ref().to_owned());
                for attribute in element.attributes() {
                    let attribute = attribute.expect("an attribute");
                    let key = attribute.key.as_ref().to_owned();
                    let value = attribute.value.into_owned();
                    found.insert(format!("{}@{key}", path.join("/")), value);
                }
            }
            Event::Text(text) => {
                let text = text.trim().to_owned();
                if !text.is_empty() {
                    found.insert(path.join("/"), text);
                }
            }
            Event::End(_) => drop(path.pop()),
            Event::Eof => return found,
            _ => {}
        }
    }
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
    for (grid, expected) in [(None, [640, 400]), (Some("50x30"), [50, 30])] {
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
        let xml = elements(std::str::from_utf8(&entry("mpcdi.xml")).expect("text"));
        let region = "MPCDI/display/buffer/region";
        let files = "MPCDI/files/fileset";
        for (key, value) in [
            ("MPCDI@profile", "a3"),
            ("MPCDI@level", "1"),
            ("MPCDI@version", "1.0"),
            ("MPCDI@date", "1980-01-01 00:00:00"),
            ("MPCDI/display/buffer@id", "sky"),
            (&format!("{region}@id"), "back"),
            (&format!("{region}@Xresolution"), "640"),
            (&format!("{region}@Yresolution"), "400"),
            (&format!("{region}@x"), "0"),
            (&format!("{region}@ysize"), "1"),
            (&format!("{region}/coordinateFrame/posy"), "-0.900000000"),
            (&format!("{region}/coordinateFrame/rollz"), "-1.000000000"),
            (&format!("{files}@region"), "back"),
            (&format!("{files}/geometryWarpFile/geometricUnit"), "m"),
            (&format!("{files}/geometryWarpFile/interpolation"), "linear"),
            (
                &format!("{files}/geometryWarpFile/originOf3DData"),
                "idealEyePoint",
            ),
            (&format!("{files}/alphaMap/bitDepth"), "8"),
        ] {
            assert_eq!(xml.get(key).map(String::as_str), Some(value), "{key}");
        }
        // The frustum's edges are the projector's.
        for (name, edge) in ["left", "right", "down", "up"]
            .into_iter()
            .zip(projector.edges())
        {
            let degrees: f64 = xml[&format!("{region}/frustum/{name}Angle")]
                .parse()
                .expect("a number");
            assert!((degrees.to_radians().tan() - edge).abs() < 1e-9, "{name}");
        }
        let (size, points) = points(&entry(&xml[&format!("{files}/geometryWarpFile/path")]));
        assert_eq!(size, expected);
        let weights = entry(&xml[&format!("{files}/alphaMap/path")]);
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
            assert!((point.distance(dome.centre()) - 2.5).abs() < 1e-6);
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
fn what_cannot_be_is_said_and_nothing_is_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let file = |name: &str, text: String| fs::write(folder.join(name), text).expect("a file");
    file("room.toml", ROOM.to_owned());
    file(
        "two.toml",
        format!("{ROOM}{}", ROOM.replace("sky", "small")),
    );
    file("bad.toml", ROOM.replace("170", "400"));
    file("back.toml", PROJECTOR.to_owned());
    file("away.toml", PROJECTOR.replace("0.3, -1]", "-1, -0.1]"));
    file("wide.toml", PROJECTOR.replace("80", "200"));
    file("key.toml", PROJECTOR.replace("look", "looks"));
    for (walls, projector, more, code, words) in [
        (
            "room.toml",
            "away.toml",
            &[][..],
            1,
            "does not see dome \"sky\"",
        ),
        ("room.toml", "wide.toml", &[], 1, "200°"),
        ("room.toml", "key.toml", &[], 1, "unknown field `looks`"),
        ("room.toml", "no.toml", &[], 1, "no.toml"),
        ("bad.toml", "back.toml", &[], 1, "400°"),
        ("cube", "back.toml", &[], 2, "no dome in --walls"),
        ("two.toml", "back.toml", &[], 2, "sky, small"),
        (
            "two.toml",
            "back.toml",
            &["--dome", "large"],
            2,
            "no dome \"large\"",
        ),
        ("room.toml", "back.toml", &["--grid", "1x9"], 2, "1 × 9"),
        ("room.toml", "back.toml", &["--grid", "0x9"], 2, "--grid"),
        ("room.toml", "back.toml", &["--format", "pdf"], 2, "mpcdi"),
    ] {
        let mut command = shisen(folder);
        command.args(["dome", "warp", "--walls", walls, "--projector", projector]);
        if !more.contains(&"--format") {
            command.args(["--format", "bourke"]);
        }
        let output = command.args(more).args(["-o", "out"]).assert().code(code);
        let says = String::from_utf8(output.get_output().stderr.clone()).expect("text");
        assert!(says.contains(words), "{words}: {says}");
        assert!(!folder.join("out").exists());
    }
    // A head outside the dome.
    let arguments = ["cave", "--walls", "dome", "--head", "0,1,0", "--out", "new"];
    let output = shisen(folder).args(arguments).assert().code(1);
    let says = String::from_utf8(output.get_output().stderr.clone()).expect("text");
    assert!(
        says.contains("not inside dome") && says.contains("2.475"),
        "{says}"
    );
    assert!(!folder.join("new").exists());
}

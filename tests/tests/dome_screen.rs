//! Domes and walls as screens: what the viewer sees on them is what stands behind, from
//! anywhere inside; and the warps that bring pictures onto domes.

use glam::{DVec2, DVec3};
use shisen::bake::Baked;
use shisen::cave::{Cave, DomeScreen, Eye, Viewer, Wall};
use shisen::picture::Picture;
use shisen::projection::Projector;
use shisen::projection::warp::{Nodes, Warp};
use shisen::render::{Observer, Options};
use shisen::scene::builtin::{PaperScene, paper_scene};
use shisen::scene::material::Material;
use shisen::scene::{Background, Scene};
use shisen::show::overview::viewer::{self, ViewerCamera};
use shisen_tests::command::{folder, list, number, refused, report};
use shisen_tests::meshes::icosphere;
use shisen_tests::png_file::PngFile;
use shisen_tests::scenes::{empty, frame, sphere, three_walls};
use std::fs;

const SIZE: u32 = 256;

/// A dome larger than a hemisphere, leaning to the front, beside the origin.
const ROOM: &str = r#"
[[dome]]
name = "sky"
radius = 2.5
centre = [0.2, -0.5, 0.3]
tilt_degrees = 25
field_of_view_degrees = 230
"#;

fn room(size: u32) -> Cave {
    Cave::from_toml(ROOM, "room.toml", [size; 2]).expect("a room")
}

/// Off the dome's centre, by two thirds of its radius.
const EYE: DVec3 = DVec3::new(-0.9, 0.6, 0.6);

/// Returns what an eye is shown.
fn shown(scene: &Scene, room: &Cave, eye: DVec3) -> Picture {
    let baked = Baked::<8>::new(scene).expect("a scene");
    let eyes = [Observer::new(Eye::Centre, eye)];
    frame(baked.scene().into(), room, &eyes, &Options::default())
        .pictures
        .remove(0)
        .picture
}

/// Returns a ball alone, white before nothing.
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

/// Returns the mean direction of what is opaque, each pixel by its solid angle;
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

/// Returns where a point of a dome's picture is on it, seen from an eye.
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

/// The same on walls: in the middle of each, and over the seams between them.
#[test]
fn things_are_seen_on_walls_where_they_stand() {
    let room = three_walls(SIZE);
    let eye = Viewer::default().eye(Eye::Left) + DVec3::new(0.1, 0.2, -0.15);
    for look in [
        DVec3::NEG_Z,
        DVec3::X,
        DVec3::new(0.2, -1.0, -0.3),
        DVec3::new(1.0, 0.0, -1.0),
        DVec3::new(0.0, -1.0, -1.0),
        DVec3::new(1.0, -1.0, 0.1),
        DVec3::new(1.0, -1.0, -1.0),
    ] {
        let direction = look.normalize();
        let baked = Baked::<8>::new(&ball(eye + 4.0 * direction, 0.2)).expect("a scene");
        let eyes = [Observer::new(Eye::Left, eye)];
        let shown = frame(baked.scene().into(), &room, &eyes, &Options::default());
        let walls = shown.pictures.iter();
        let walls: Vec<_> = walls.map(|p| (&room.walls[p.wall], &p.picture)).collect();
        let up = direction.any_orthonormal_vector();
        let camera = ViewerCamera::new(eye, direction, up, 0.5, [201, 151]).expect("a camera");
        let view = viewer::render(&camera, &walls).expect("a view");
        let seen = middle(&view, |at| camera.ray(at.x, at.y));
        // Walls of 3 m, 1.5 m away: a pixel looks as large as this at most.
        let pixel = 2.0 / f64::from(SIZE);
        let apart = seen.angle_between(direction) / pixel;
        assert!(apart < 0.3, "{look}: {apart} pixels");
    }
}

#[test]
fn a_cave_with_a_dome_is_reported_and_drawn_whole() {
    let folder = folder();
    let folder = folder.path();
    let walls = "[[dome]]\nname = \"sky\"\nradius = 2\ncentre = [0, 0, 0]\nsize = 96\n\
                 [[wall]]\nname = \"floor\"\nlower_left = [-1, -1, 1]\n\
                 lower_right = [1, -1, 1]\nupper_left = [-1, -1, -1]\n";
    fs::write(folder.join("room.toml"), walls).expect("a file");
    let report = report(
        folder,
        "cave --walls room.toml --size 64 --view-size 128x96 --lod paper",
    );
    let paths = list(&report, "images")
        .iter()
        .map(|image| image["path"].as_str());
    let names = ["floor-left", "floor-right", "sky-left", "sky-right"];
    let names = names.map(|name| format!("shisen-out/{name}.png"));
    assert!(
        paths.eq(names.iter().map(|name| Some(name.as_str()))),
        "{report}"
    );
    for name in ["cave", "viewer", "levels", "polygons", "difference"] {
        let picture = PngFile::open(folder.join(format!("shisen-out/{name}.png")));
        assert!(picture.width > 96, "{name}");
    }
    // Shares are of the pixels that the dome has.
    for field in list(&report["lod"], "field") {
        let all = ["central", "peripheral", "outside"].map(|key| number(field, key));
        assert!((all.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{field}");
        assert!(
            field["wall"] == "floor" || all[0] > 0.05 && all[2] < 0.7,
            "{field}"
        );
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

/// A projector where the viewer's eye is has to show what the eye sees: a plain
/// perspective, in spite of the dome between.
#[test]
fn a_warp_for_a_projector_at_the_eye_shows_a_plain_perspective() {
    let scene = paper_scene(PaperScene::B, icosphere(4)).expect("a scene");
    let room = room(1024);
    let master = shown(&scene, &room, EYE);
    let text = format!(
        "name = \"eye\"\nposition = [{}, {}, {}]\nlook = [0.2, 0.1, -1]\n\
         horizontal_degrees = 70\nresolution = [200, 150]\n",
        EYE.x, EYE.y, EYE.z
    );
    let projector = Projector::from_toml(&text, "").expect("a projector");
    let lens = *projector.lens().expect("a lens");
    let mut lit = room.clone();
    lit.add_projector(projector).expect("light on the dome");
    let blends = lit.blends().expect("a projector");
    let warp = Warp::new(&blends[0], "eye", [200, 150], Nodes::Centres).expect("a warp");
    // The same picture, traced as a flat wall's at distance 1.
    let [left, right, down, up] = lens.edges;
    let corner = |x: f64, y: f64| EYE + lens.axes * DVec3::new(x, y, -1.0);
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
        let at = node.place * 1024.0;
        let found = master.sample(at.x, at.y);
        let expected = direct.pixel(x, y).expect("a pixel");
        let apart = glam::Vec4::from(found) - glam::Vec4::from(expected);
        sum += f64::from(apart.abs().element_sum()) / 4.0;
        count += 1;
    }
    let mean = sum / f64::from(count);
    assert!(mean < 0.005 && count > 25_000, "{mean} {count}");
}

#[test]
fn impossible_warps_are_refused_and_nothing_is_written() {
    let folder = folder();
    let folder = folder.path();
    let file = |name: &str, text: String| fs::write(folder.join(name), text).expect("a file");
    file("room.toml", ROOM.to_owned());
    let two = format!("{ROOM}{}", ROOM.replace("sky", "small"));
    file("two.toml", two);
    file("bad.toml", ROOM.replace("230", "400"));
    file("back.toml", PROJECTOR.to_owned());
    file("away.toml", PROJECTOR.replace("0.3, -1]", "-1, -0.1]"));
    file("wide.toml", PROJECTOR.replace("80", "200"));
    file("key.toml", PROJECTOR.replace("look", "looks"));
    for (code, walls, projector, more, expected) in [
        (1, "room", "away", "bourke", "does not see dome \"sky\""),
        (1, "room", "wide", "bourke", "200°"),
        (1, "room", "key", "bourke", "unknown key `looks`"),
        (1, "room", "no", "bourke", "no.toml"),
        (1, "bad", "back", "bourke", "400°"),
        (2, "two", "back", "bourke", "sky, small"),
        (
            2,
            "two",
            "back",
            "bourke --screen large",
            "\"large\", which is not there",
        ),
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

//! Scenes of the host under the same numbers: refused when they are baked, or traced
//! to light that is finite; and pictures and charts of what was measured.

use super::host::wall;
use super::numbers::{Case, Numbers, finite};
use glam::{DAffine3, DMat3, Vec3};
use shisen::bake::tree::Bounds;
use shisen::bake::{BakeError, Baked, BakedScene, Layout, lone_mesh};
use shisen::cave::{BuiltInCave, Cave, Eye, Wall};
use shisen::lod::difference;
use shisen::material::Material;
use shisen::mesh::TriangleMesh;
use shisen::picture::Picture;
use shisen::render::{self, Observer, Options};
use shisen::scene::builtin::{PaperScene, PrismBench, grid, paper_scene};
use shisen::scene::camera::{CameraKey, CameraPath, DomeCamera};
use shisen::scene::{Background, Light, Normalisation, Object, Placement, Scene, Shape};
use shisen::simplify::{Ladder, PolygonLevels, Topology};
use shisen::tradeoff::{Ring, Sight};
use shisen_core::Simd;
use shisen_core::frame::FlatScreen;
use shisen_core::shape::Ray;
use shisen_core::trace::{Budget, Tracer, Workspace};

/// A pyramid with four sides.
fn mesh(n: &mut Numbers) -> TriangleMesh {
    let corners = [
        [-1.0, 0.0, -1.0],
        [1.0, 0.0, -1.0],
        [0.0, 0.0, 1.0],
        [0.0, 1.5, 0.0],
    ];
    TriangleMesh {
        positions: corners.map(|corner| corner.map(|x| n.next(x))).to_vec(),
        triangles: vec![[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]],
        ..TriangleMesh::default()
    }
}

fn colour(n: &mut Numbers) -> [f32; 3] {
    [0.3, 0.5, 0.7].map(|channel| n.next(channel))
}

fn material(n: &mut Numbers) -> Material {
    Material {
        diffuse: colour(n),
        specular: colour(n),
        shininess: n.next(20.0),
        mirror: colour(n),
        emission: colour(n),
        ..Material::default()
    }
}

fn glass(n: &mut Numbers) -> Material {
    Material {
        transmission: colour(n),
        index_of_refraction: n.next(1.5),
        absorption: colour(n),
        ..Material::default()
    }
}

fn lights(n: &mut Numbers) -> Vec<Light> {
    vec![
        Light::Point {
            position: n.dvec3([3.0, 4.0, 5.0]),
            colour: colour(n),
            inverse_square: true,
        },
        Light::Directional {
            direction: n.dvec3([0.2, -1.0, 0.1]),
            colour: colour(n),
        },
        Light::Rectangle {
            centre: n.dvec3([0.0, 5.0, 0.0]),
            right: n.dvec3([1.0, 0.0, 0.0]),
            up: n.dvec3([0.0, 0.0, 1.0]),
            colour: colour(n),
            samples: 2,
            two_sided: true,
        },
    ]
}

fn object(shape: Shape, material: usize, world_from_object: DAffine3) -> Object {
    Object {
        shape,
        material: Some(material),
        world_from_object,
        casts_shadow: true,
        smooth: false,
    }
}

/// A scene with one of everything, every number of which is the next.
fn scene(n: &mut Numbers) -> Scene {
    let turned = DMat3::from_cols(
        n.dvec3([0.8, 0.0, 0.6]),
        n.dvec3([0.0, 1.0, 0.0]),
        n.dvec3([-0.6, 0.0, 0.8]),
    );
    let placed = DAffine3::from_mat3_translation(turned, n.dvec3([0.0, 0.0, -5.0]));
    let ball = Shape::Sphere {
        radius: n.next(0.7),
    };
    let beside = DAffine3::from_translation(n.dvec3([1.0, 0.5, -4.0]));
    Scene {
        name: "hostile".to_owned(),
        meshes: vec![mesh(n)],
        materials: vec![material(n), glass(n)],
        objects: vec![object(Shape::Mesh(0), 0, placed), object(ball, 1, beside)],
        lights: lights(n),
        background: Background::uniform(colour(n)),
        ambient: colour(n),
        camera: CameraPath::default(),
    }
}

/// What is baked is traced to finite light, along rays that meet it and pass it.
fn traced(baked: Result<Baked<8>, BakeError>, sane: bool) {
    let baked = match baked {
        Ok(baked) => baked,
        Err(error) => {
            assert!(!sane && !error.to_string().is_empty(), "{error}");
            return;
        }
    };
    let mut workspace = Workspace::new();
    let tracer = Tracer::new(baked.scene(), Simd::detect(), 4);
    for target in [[0.0, 0.4, -5.0], [1.0, 0.5, -4.0], [0.0, 9.0, -1.0]] {
        let ray = Ray::new(Vec3::ZERO, Vec3::from(target)).expect("a ray");
        let light = tracer.radiance(&ray, &mut Budget::steps(10_000), &mut workspace);
        finite(&light);
    }
}

/// What an eye sees on the screens of a room is finite, or refused.
fn check_frame(room: &Cave, eye: Observer, sane: bool) {
    let baked = Baked::<8>::new(&grid(2.0)).expect("a scene");
    let options = Options {
        threads: 1,
        ..Options::default()
    };
    match render::cave(&baked.scene(), room, &[eye], &options, &|_, _| {}) {
        Ok(frame) => {
            for seen in &frame.pictures {
                finite(&seen.picture.pixels);
            }
        }
        Err(error) => assert!(!sane && !error.to_string().is_empty(), "{error}"),
    }
}

pub(super) const CASES: &[(&str, Case)] = &[
    ("host bake::Baked::new", |n| {
        let scene = scene(n);
        traced(Baked::new(&scene), n.are_sane());
    }),
    ("host bake::Baked::with_levels", |n| {
        let scene = scene(n);
        let levels = PolygonLevels::new(4..=8, 2).expect("levels");
        traced(Baked::with_levels(&scene, &levels), n.are_sane());
    }),
    ("host bake::lone_mesh", |n| {
        let scene = lone_mesh(mesh(n));
        traced(Baked::new(&scene), n.are_sane());
    }),
    ("host bake::layout::BakedScene::new", |n| {
        let baked = BakedScene::new(&scene(n), Layout::Compact);
        assert!(baked.is_ok() || !n.are_sane());
    }),
    ("host bake::layout::BakedScene::with_levels", |n| {
        let levels = PolygonLevels::new(4..=8, 2).expect("levels");
        let baked = BakedScene::with_levels(&scene(n), &levels, Layout::Compact);
        assert!(baked.is_ok() || !n.are_sane());
    }),
    ("host bake::tree::Bounds::of_points", |n| {
        let mesh = mesh(n);
        let Bounds { low, high } = Bounds::of_points(&mesh.positions);
        // Of places that are numbers, the least and the greatest.
        let places = mesh.positions.iter().flatten();
        if places.clone().all(|x| x.is_finite()) {
            for (axis, (low, high)) in low.into_iter().zip(high).enumerate() {
                let along = mesh.positions.iter().map(|place| place[axis]);
                assert!(along.clone().all(|x| low <= x && x <= high));
                assert!(along.clone().any(|x| x == low) && along.clone().any(|x| x == high));
            }
        }
    }),
    ("host render::Observer::new", |n| {
        let eye = Observer::new(Eye::Left, n.dvec3([0.1, 1.6, 0.0]));
        let room = Cave::built_in(BuiltInCave::ThreeWall, [3; 2]).expect("a room");
        check_frame(&room, eye, n.are_sane());
    }),
    ("host render::cave", |n| {
        let Some(wall) = wall(n) else {
            return;
        };
        let room = Cave::new(vec![Wall {
            pixels: [3; 2],
            ..wall
        }])
        .expect("a room");
        let eye = Observer::new(Eye::Left, n.dvec3([0.1, 1.6, 0.0]));
        check_frame(&room, eye, n.are_sane());
    }),
    ("host scene::camera::CameraPath::new", |n| {
        let key = |frame, n: &mut Numbers| CameraKey {
            frame,
            camera: DomeCamera {
                position: n.dvec3([0.0, 1.0, 2.0]),
                zenith: n.dvec3([0.0, 1.0, 0.1]),
                top: n.dvec3([0.0, 0.1, 1.0]),
            },
        };
        let keys = vec![key(1, n), key(10, n), key(20, n)];
        let Ok(path) = CameraPath::new(keys) else {
            assert!(!n.are_sane());
            return;
        };
        for frame in [0, 1, 5, 10, 19, 20, u32::MAX] {
            let camera = path.camera(frame).expect("a camera");
            assert!(camera.is_usable(), "{frame}: {camera:?}");
            finite(&camera);
            finite(&camera.pose());
        }
    }),
    ("host scene::placement::Normalisation::of", |n| {
        let mesh = mesh(n);
        let found = Normalisation::of(&mesh);
        finite(&found);
        assert!(found.is_some() || !n.are_sane());
    }),
    ("host scene::placement::Placement::world_from_object", |n| {
        let placement = Placement {
            position: n.dvec3([0.0, 1.0, -3.0]),
            rotation_degrees: [10.0, 20.0, 30.0].map(|degrees| n.wide(degrees)),
            scale: n.dvec3([1.0, 2.0, 1.0]),
        };
        let normalisation = Normalisation::of(&mesh(n)).unwrap_or(Normalisation::NONE);
        let map = placement.world_from_object(&normalisation);
        // What is no map is refused when the scene is baked.
        let placed = Scene {
            objects: vec![object(Shape::Sphere { radius: 1.0 }, 0, map)],
            materials: vec![Material::default()],
            ..grid(1.0)
        };
        traced(Baked::new(&placed), n.are_sane());
    }),
    ("host scene::builtin::paper_scene", |n| {
        let Ok(scene) = paper_scene(PaperScene::A, mesh(n)) else {
            assert!(!n.are_sane());
            return;
        };
        traced(Baked::new(&scene), n.are_sane());
    }),
    ("host scene::builtin::glass::PrismBench::new", |n| {
        let bench = PrismBench::new(n.next(550.0));
        finite(&bench);
        finite(&[bench.centre(), bench.slit()]);
    }),
    ("host simplify::topology::Topology::of", |n| {
        let found = Topology::of(&mesh(n));
        // Corners at one place are one corner, so that faces may fall together.
        assert!(found.open_edges <= 12 && found.crowded_edges <= 6 && found.pinched_vertices <= 4);
        assert!(!n.are_sane() || found.open_edges == 0);
    }),
    ("host simplify::Ladder::single", |n| {
        let mesh = mesh(n);
        assert_eq!(Ladder::single(&mesh).rungs(), [[0, 1, 2, 3]]);
    }),
    ("host tradeoff::metrics::Sight::new", |n| {
        let corners = [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0]].map(|[x, y]| Vec3::new(x, y, -1.5));
        let [lower_left, lower_right, upper_left] = corners;
        let screen = FlatScreen::from_corners(lower_left, lower_right, upper_left, [8; 2]);
        let view = screen.view_from(Vec3::ZERO).expect("a view");
        let sight = Sight::new(&view, n.vec3([0.1, 0.0, -1.0]));
        finite(&sight.pixels_per_degree());
        assert!(
            Ring::ALL
                .iter()
                .map(|&ring| sight.pixels(ring))
                .sum::<usize>()
                <= 64
        );
    }),
    ("host lod::pictures::difference", |n| {
        let [a, b] = [0; 2].map(|_| {
            let pixel = [0.1, 0.5, 0.9, 1.0].map(|light| n.next(light));
            Picture::from_pixels(1, 1, vec![pixel]).expect("a picture")
        });
        let apart = difference(&a, &b).expect("a picture");
        finite(&apart.pixel(0, 0));
    }),
];

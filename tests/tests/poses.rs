//! Instances that move and meshes that deform are hit like those of a scene that is baked anew.

use crate::watertight::{aimed, assert_none_lost, targets};
use glam::{DAffine3, DMat3, DQuat, DVec3, Vec3};
use shisen::bake::simplify::PolygonLevels;
use shisen::bake::{Baked, Stage, StageMemory};
use shisen::scene::import;
use shisen::scene::mesh::TriangleMesh;
use shisen::scene::{Object, Scene, Shape};
use shisen_core::frame::{Budget, Workspace};
use shisen_core::scene::format::{Instance, Node};
use shisen_core::scene::{self as core, PoseError, Poses, Tables};
use shisen_core::shape::Ray;
use shisen_core::trace::{Hit, Tracer};
use shisen_core::{Runs, Simd};
use shisen_evidence::walker::walker;
use shisen_tests::meshes::{gridded_cube, icosphere, torus};
use shisen_tests::rays::Random;
use shisen_tests::scenes::{empty, levels};
use shisen_tests::sizes::cases;
use zerocopy::FromZeros as _;

fn map(random: &mut Random, room: f64) -> DAffine3 {
    let axis = DVec3::from(random.direction());
    let turn = DQuat::from_axis_angle(axis, random.range(-3.0, 3.0));
    let scale = DVec3::from_array([0; 3].map(|_| 2f64.powf(random.range(-3.0, 1.0))));
    let place = DVec3::from(random.direction()) * random.range(0.0, room);
    DAffine3::from_scale_rotation_translation(scale, turn, place)
}

/// Returns sixty meshes and balls in a room of 6 m.
fn crowd(random: &mut Random) -> Scene {
    let shapes = [
        Shape::Mesh(0),
        Shape::Mesh(1),
        Shape::Sphere { radius: 0.5 },
        Shape::Spheroid {
            equatorial_radius: 0.2,
            polar_radius: 0.7,
        },
    ];
    let objects = (0..60).map(|number| Object {
        world_from_object: map(random, 6.0),
        ..Object::new(shapes[number % shapes.len()])
    });
    Scene {
        meshes: vec![torus(40, 20), gridded_cube(6)],
        objects: objects.collect(),
        ..empty()
    }
}

fn ray(random: &mut Random, room: f64) -> Ray {
    let origin = DVec3::from(random.direction()) * random.range(0.0, room);
    let target = DVec3::from(random.direction()) * random.range(0.0, room);
    Ray::new(origin.as_vec3(), (target - origin).as_vec3()).expect("a finite ray")
}

/// Returns a ray at one of a scene's objects.
fn towards(scene: &Scene, random: &mut Random) -> Ray {
    let object = &scene.objects[random.below(scene.objects.len())];
    let target = object.world_from_object.translation + DVec3::from(random.direction()) * 0.3;
    let origin = target + DVec3::from(random.direction()) * random.range(0.0, 20.0);
    Ray::new(origin.as_vec3(), (target - origin).as_vec3()).expect("a finite ray")
}

/// Returns the bits of the nearest hit of each ray.
fn hits<const W: usize>(scene: core::Scene<'_, W>, simd: Simd, rays: &[Ray]) -> Vec<[u32; 3]>
where
    Simd: Runs<W>,
{
    let tracer = Tracer::new(scene, simd, 0);
    let mut workspace = Workspace::new();
    let mut nearest =
        |ray: &Ray| tracer.nearest(ray, &mut Budget::UNLIMITED.clone(), &mut workspace);
    rays.iter()
        .map(|ray| {
            nearest(ray).map_or([u32::MAX; 3], |Hit { instance, on }| {
                [instance, on.triangle, on.t.to_bits()]
            })
        })
        .collect()
}

fn top<const W: usize>(scene: &core::Scene<'_, W>) -> Vec<Node<W>> {
    vec![Node::EMPTY; scene.top_nodes()]
}

fn instances<const W: usize>(scene: &core::Scene<'_, W>) -> Vec<Instance> {
    vec![Instance::new_zeroed(); scene.instances().len()]
}

fn assert_moves_like_a_bake<const W: usize>(levels: Option<&PolygonLevels>)
where
    Simd: Runs<W>,
{
    let mut random = Random::new(0x905E);
    let mut scene = crowd(&mut random);
    let bake = |scene: &Scene| match levels {
        Some(levels) => Baked::<W>::with_levels(scene, levels).expect("a scene"),
        None => Baked::<W>::new(scene).expect("a scene"),
    };
    let baked = bake(&scene);
    let (mut top, mut instances) = (top(&baked.scene()), instances(&baked.scene()));
    let mut poses = Poses::new(baked.scene(), &mut top, &mut instances).expect("memory");
    for room in [6.0, 6.0, 600.0, 3.0] {
        for _ in 0..30 {
            let number = random.below(scene.objects.len());
            let map = map(&mut random, room);
            scene.objects[number].world_from_object = map;
            poses.set(number, &map).expect("a pose");
        }
        let steps = poses.refit();
        assert_eq!(steps, baked.scene().top_nodes() as u64);
        let anew = bake(&scene);
        let rays: Vec<Ray> = (0..4_000).map(|_| towards(&scene, &mut random)).collect();
        for simd in [Simd::detect(), Simd::PORTABLE] {
            let expected = hits(anew.scene(), simd, &rays);
            assert!(expected.iter().filter(|hit| hit[0] != u32::MAX).count() > 300);
            assert_eq!(hits(poses.scene(), simd, &rays), expected, "{room} m");
        }
    }
}

#[test]
fn moved_instances_are_hit_as_if_they_were_baked_there() {
    assert_moves_like_a_bake::<8>(None);
    assert_moves_like_a_bake::<8>(Some(&levels(4)));
    assert_moves_like_a_bake::<4>(None);
}

/// Instances go a hundred times as far away as the scene was large.
#[test]
fn no_edge_is_lost_after_a_long_way() {
    let mesh = torus(60, 30);
    let targets = targets(&mesh);
    let scene = Scene {
        meshes: vec![mesh],
        objects: vec![Object::new(Shape::Mesh(0)); 2],
        ..empty()
    };
    let baked = Baked::<8>::new(&scene).expect("a scene");
    let (mut top, mut instances) = (top(&baked.scene()), instances(&baked.scene()));
    let mut poses = Poses::new(baked.scene(), &mut top, &mut instances).expect("memory");
    let turn = DQuat::from_euler(glam::EulerRot::YXZ, 0.4, -1.2, 2.5);
    let map = DAffine3::from_rotation_translation(turn, DVec3::new(310.0, -250.0, 90.0));
    poses.set(0, &map).expect("a pose");
    poses
        .set(1, &DAffine3::from_translation(DVec3::splat(-400.0)))
        .expect("a pose");
    poses.refit();
    let tracer = Tracer::new(poses.scene(), Simd::detect(), 0);
    let mut workspace = Workspace::new();
    let search = |ray: &Ray| tracer.nearest(ray, &mut Budget::UNLIMITED.clone(), &mut workspace);
    assert_none_lost(
        "a torus from within its tube",
        vec![("moved".to_owned(), Box::new(search))],
        |hit| hit.on.t,
        cases(
            "rays at edges of an instance that moved far",
            20_000,
            1_000_000,
        ),
        |random| {
            // The tube's centre line is a circle of 3 about the Y axis.
            let angle = random.range(0.0, std::f64::consts::TAU);
            let origin = DVec3::new(3.0 * angle.cos(), 0.0, -3.0 * angle.sin());
            let targets = &targets[random.below(2)];
            let target = targets[random.below(targets.len())];
            aimed(map.transform_point3(origin), map.transform_point3(target)).expect("a direction")
        },
    );
}

/// Waves run over a ball and a cube flattens, on both layouts; the ball gets a new tree.
fn assert_deforms_like_a_bake<const W: usize>()
where
    Simd: Runs<W>,
{
    let mut random = Random::new(0xDEF);
    let turn = |y: f64| DAffine3::from_rotation_y(y);
    let scene = Scene {
        meshes: vec![icosphere(4), gridded_cube(8)],
        objects: vec![
            Object::new(Shape::Mesh(0)),
            Object {
                world_from_object: turn(1.0),
                ..Object::new(Shape::Mesh(1))
            },
        ],
        ..empty()
    };
    let bent = |time: f64| {
        let mut bent = scene.clone();
        for (number, mesh) in bent.meshes.iter_mut().enumerate() {
            for position in &mut mesh.positions {
                let at = Vec3::from(*position).as_dvec3();
                let wave = 1.0 + 0.8 * time * (9.0 * at.y + 5.0 * time).sin();
                let flat = DVec3::new(1.0, 1.0 - 0.3 * time, 1.0 + time);
                let twist = DMat3::from_rotation_y(4.0 * time * at.y);
                let at = if number == 0 {
                    twist * at * wave
                } else {
                    at * flat
                };
                *position = at.as_vec3().to_array();
            }
            mesh.normals = mesh.vertex_normals().to_vec();
        }
        bent.objects[0].world_from_object = turn(time);
        bent
    };
    let baked = Baked::<W>::new(&scene).expect("a scene");
    let base = baked.scene();
    let (mut top, mut instances) = (top(&base), instances(&base));
    let (nodes, leaves, _) = base.sizes();
    let is_fast = W == 8;
    let mut table = (
        vec![Node::EMPTY; nodes],
        vec![core::format::LeafBlock::<W>::EMPTY; if is_fast { leaves } else { 0 }],
        vec![[0.0; 3]; base.vertices()],
        vec![[0.0; 3]; if is_fast { 0 } else { base.vertices() }],
        vec![core::format::Mesh::new_zeroed(); base.meshes().len()],
    );
    let poses = Poses::new(base, &mut top, &mut instances).expect("memory");
    let mut poses = poses
        .with_tables(Tables {
            nodes: &mut table.0,
            leaves: &mut table.1,
            normals: &mut table.2,
            tangents: &mut [],
            positions: &mut table.3,
            meshes: &mut table.4,
        })
        .expect("memory");
    for time in [0.1, 0.5, 1.0, 0.0] {
        let bent = bent(time);
        for (number, mesh) in bent.meshes.iter().enumerate() {
            let shape: &TriangleMesh = mesh;
            poses
                .deform(number, &shape.positions, &shape.normals)
                .expect("a shape");
        }
        poses
            .set(0, &bent.objects[0].world_from_object)
            .expect("a pose");
        poses.refit();
        let anew = Baked::<W>::new(&bent).expect("a scene");
        let rays: Vec<Ray> = (0..3_000).map(|_| ray(&mut random, 3.0)).collect();
        let expected = hits(anew.scene(), Simd::detect(), &rays);
        assert!(expected.iter().filter(|hit| hit[0] != u32::MAX).count() > 300);
        assert_eq!(
            hits(poses.scene(), Simd::detect(), &rays),
            expected,
            "{time} s"
        );
    }
}

#[test]
fn deformed_meshes_are_hit_as_if_they_were_baked_so() {
    assert_deforms_like_a_bake::<8>();
    assert_deforms_like_a_bake::<4>();
}

#[test]
fn what_is_no_pose_is_refused_and_changes_nothing() {
    let scene = crowd(&mut Random::new(1));
    let baked = Baked::<8>::new(&scene).expect("a scene");
    let base = baked.scene();
    let (mut top, mut instances) = (top(&base), instances(&base));
    let short = Poses::new(base, &mut top[1..], &mut instances);
    assert!(matches!(
        short,
        Err(PoseError::Memory { what: "nodes", .. })
    ));
    let mut poses = Poses::new(base, &mut top, &mut instances).expect("memory");
    let flat = DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0));
    let far = DAffine3::from_translation(DVec3::splat(1e13));
    let unknown = DAffine3::from_translation(DVec3::splat(f64::NAN));
    for map in [flat, far, unknown] {
        assert_eq!(
            poses.set(3, &map),
            Err(PoseError::Transform { instance: 3 })
        );
    }
    let beyond = poses.set(60, &DAffine3::IDENTITY);
    assert_eq!(beyond, Err(PoseError::NoInstance { instance: 60 }));
    assert_eq!(
        poses.deform(0, &[], &[]),
        Err(PoseError::NoMesh { mesh: 0 })
    );
    poses.refit();
    let rays: Vec<Ray> = (0..500).map(|n| ray(&mut Random::new(n), 6.0)).collect();
    let simd = Simd::detect();
    assert_eq!(hits(poses.scene(), simd, &rays), hits(base, simd, &rays));
}

/// An animal walks on its joints.
#[test]
fn a_stage_is_hit_as_if_its_moments_were_baked() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("walker.glb");
    std::fs::write(&path, walker(0)).expect("a file");
    let model = import::load(&path).expect("a model");
    let scene = Scene::of_model(model, None, None, None);
    let baked = Baked::<8>::new(&scene).expect("a scene");
    let mut memory = StageMemory::of(&baked.scene(), &scene);
    let mut stage = Stage::new(baked.scene(), &scene, &mut memory).expect("a stage");
    let mut random = Random::new(0x57A6);
    for time in [0.0, 0.3, 0.77, 1.3] {
        stage.set_time(time).expect("a pose");
        let anew = Baked::<8>::new(&scene.at(time)).expect("a scene");
        let rays: Vec<Ray> = (0..4_000)
            .map(|_| {
                let target = DVec3::new(0.0, -0.9, -2.5) + DVec3::from(random.direction()) * 0.5;
                aimed(DVec3::ZERO, target).expect("a direction")
            })
            .collect();
        let expected = hits(anew.scene(), Simd::detect(), &rays);
        assert!(expected.iter().filter(|hit| hit[0] != u32::MAX).count() > 1_000);
        assert_eq!(
            hits(stage.scene(), Simd::detect(), &rays),
            expected,
            "{time} s"
        );
    }
}

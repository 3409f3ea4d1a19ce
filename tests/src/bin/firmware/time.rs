//! Checks that a slice takes at most steps × C1 + C0 instructions, with scenes made to take
//! long, and at most its budget and the steps of one sample.

use crate::{Bench, Wrong, bake};
use glam::{DAffine3, DQuat, DVec3};
use shisen::scene::material::Material;
use shisen::scene::mesh::TriangleMesh;
use shisen::scene::{Object, Scene, Shape};
use shisen_core::frame::FlatScreen;
use shisen_tests::firmware::ShownFrame;
use shisen_tests::meshes::{gridded_cube, icosphere};
use shisen_tests::scenes::object;
use std::cell::Cell;

/// Pixels a side of the wall on which the scenes are seen.
const SIDE: u32 = 32;
const SLICES: [u32; 4] = [1, 100, 3_000, 1_000_000];

#[derive(Default)]
pub(crate) struct Slices {
    count: Cell<u64>,
    /// Most instructions of a slice beyond its steps × C1.
    besides: Cell<i64>,
    /// Most instructions for each step, in slices of 1,000 steps or more.
    a_step: Cell<u64>,
}

impl Bench {
    pub(crate) fn in_time(&self, frame: &ShownFrame, budget: u32) -> Result<(), Wrong> {
        let (per_step, per_slice) = (self.limits.per_step, self.limits.per_slice);
        let seen = &self.slices;
        for slice in &frame.slices {
            let (steps, taken) = (u64::from(slice.steps), u64::from(slice.instructions));
            seen.count.set(seen.count.get() + 1);
            let besides = taken as i64 - (steps * per_step) as i64;
            seen.besides.set(seen.besides.get().max(besides));
            if steps >= 1_000 {
                seen.a_step.set(seen.a_step.get().max(taken / steps));
            }
            ensure!(
                taken <= steps * per_step + per_slice,
                "a slice of {budget} steps took {steps} and {taken} instructions, \
                     more than {per_step} a step and {per_slice}"
            );
        }
        Ok(())
    }

    /// Returns a sentence about the slices of all checks so far.
    pub(crate) fn slices(&self) -> String {
        let seen = &self.slices;
        format!(
            "{} slices, at most {} instructions a step and {} besides; the longest of 1,000 steps \
             or more took {} a step, and none more than {} besides",
            seen.count.get(),
            self.limits.per_step,
            self.limits.per_slice,
            seen.a_step.get(),
            seen.besides.get(),
        )
    }

    pub(crate) fn bounded_time(&self) -> Result<String, Wrong> {
        let front = FlatScreen {
            size: [SIDE; 2],
            column_step: self.screens[0].column_step * (crate::SIDE / SIDE) as f32,
            row_step: self.screens[0].row_step * (crate::SIDE / SIDE) as f32,
            ..self.screens[0]
        };
        let mut said = Vec::new();
        for (name, scene, depth) in scenes() {
            let scene = bake(&scene);
            let mut dearest = 0;
            for slice in SLICES {
                let mut run = self.run(scene.as_bytes(), None);
                run.screens = std::slice::from_ref(&front);
                run.frames = 1;
                (run.rendering.slice, run.rendering.depth) = (slice, depth);
                // The same rays in each run.
                run.rendering.lod = false;
                let watched = self
                    .same(&scene, run)
                    .map_err(|wrong| format!("{name}: {wrong}"))?;
                let frame = watched.frames.first().ok_or("no frame")?;
                let most = frame.slices.iter().map(|slice| slice.steps).max();
                let most = most.ok_or("no slice")?;
                if slice == 1 {
                    // Each slice is one pixel of one sample.
                    dearest = most;
                }
                ensure!(
                    most < slice + dearest,
                    "{name}: a slice of {slice} took {most} steps, and a pixel {dearest}"
                );
            }
            said.push(format!("{name} {dearest}"));
        }
        Ok(format!(
            "within budget and one pixel; steps of the dearest pixel: {}",
            said.join(", ")
        ))
    }
}

/// Returns scenes made to take long, and bounces.
fn scenes() -> Vec<(&'static str, Scene, u8)> {
    let ahead = DAffine3::from_translation(DVec3::new(0.0, 0.0, -3.0));
    let mirror = Material {
        mirror: [0.95; 3],
        ..Material::default()
    };
    let glass = Material {
        transmission: [1.0; 3],
        index_of_refraction: 1.5,
        ..Material::default()
    };
    let plate = DAffine3::from_scale_rotation_translation(
        DVec3::new(1.0, 1.0, 1e-5),
        DQuat::from_rotation_y(0.3),
        DVec3::new(0.0, 0.0, -2.0),
    );
    let hall = DAffine3::from_scale(DVec3::splat(4.0));
    let far = DAffine3::from_scale_rotation_translation(
        DVec3::splat(2e5),
        DQuat::IDENTITY,
        DVec3::new(0.0, 0.0, -1e6),
    );
    vec![
        ("copies of one triangle", one(copies(), None, ahead), 3),
        (
            "triangles and boxes of no area",
            one(slivers(), None, ahead),
            3,
        ),
        (
            "a hall of mirrors",
            one(gridded_cube(6), Some(mirror), hall),
            5,
        ),
        ("thin glass", one(gridded_cube(4), Some(glass), plate), 5),
        ("a mesh far away", one(icosphere(3), None, far), 3),
    ]
}

fn one(mesh: TriangleMesh, material: Option<Material>, world_from_object: DAffine3) -> Scene {
    let object = Object {
        material: material.as_ref().map(|_| 0),
        ..object(Shape::Mesh(0), 0, world_from_object)
    };
    let empty = shisen::scene::builtin::grid(1.0);
    Scene {
        name: "made to take long".to_owned(),
        meshes: vec![mesh],
        materials: material.into_iter().collect(),
        objects: vec![object],
        ..empty
    }
}

/// Returns hundreds of copies of one triangle: a ray that hits one leaf hits all.
fn copies() -> TriangleMesh {
    TriangleMesh {
        positions: vec![[-2.0, -2.0, 0.0], [2.0, -2.0, 0.0], [0.0, 2.0, 0.0]],
        triangles: vec![[0, 1, 2]; 400],
        ..TriangleMesh::default()
    }
}

/// Returns triangles with two corners or three in one place, edge-on and flat ones, and one that is
/// none of these.
fn slivers() -> TriangleMesh {
    let mut mesh = TriangleMesh {
        positions: vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2]],
        ..TriangleMesh::default()
    };
    for number in 0..100u32 {
        let at = number as f32 * 0.01 - 0.5;
        let first = mesh.positions.len() as u32;
        let (low, high, middle) = ([at, -1.0, 0.0], [at, 1.0, 0.0], [at, 0.0, 0.0]);
        let all = [low, high, middle, low, middle, middle, [at, 0.0, 1.0]];
        mesh.positions.extend(all);
        let triangles = [[0, 1, 2], [0, 3, 1], [2, 4, 5], [0, 1, 6]];
        mesh.triangles
            .extend(triangles.map(|triangle| triangle.map(|corner| first + corner)));
    }
    mesh
}

//! Instances that move on the Cortex-M7 are hit as they are here.

use crate::{Bench, PaperScene, Wrong, paper};
use glam::{DAffine3, DMat3, DVec3, Vec3};
use shisen_core::Simd;
use shisen_core::frame::{Budget, FlatScreen, Workspace};
use shisen_core::scene::Poses;
use shisen_core::scene::format::{Instance, Node};
use shisen_core::trace::Tracer;

/// Pixels a side of the wall that `rays` looks at.
const SIDE: u32 = 64;

/// Returns where `rays` moves an instance.
fn moved(instance: &Instance) -> DAffine3 {
    let columns = instance
        .world_from_object
        .map(|column| column.map(f64::from));
    let turn = DMat3::from_cols_array(&[0.6, 0.0, -0.8, 0.0, 1.0, 0.0, 0.8, 0.0, 0.6]);
    let nearer = DAffine3::from_mat3_translation(turn * 0.75, DVec3::new(0.2, 0.1, -1.0));
    nearer * DAffine3::from_cols_array_2d(&columns)
}

impl Bench {
    pub(crate) fn poses(&self) -> Result<String, Wrong> {
        let text = std::fs::read_to_string(&self.measured.0)?;
        let found = text
            .lines()
            .find_map(|line| line.strip_prefix("posed_hits "));
        let found: u32 = found.ok_or("the rays tell of no poses")?.trim().parse()?;
        let baked = paper(PaperScene::A);
        let scene = baked.scene();
        let mut top = vec![Node::EMPTY; scene.top_nodes()];
        let mut instances = scene.instances().to_vec();
        let mut poses = Poses::new(scene, &mut top, &mut instances)?;
        for (number, instance) in scene.instances().iter().enumerate() {
            poses.set(number, &moved(instance))?;
        }
        poses.refit();
        let tracer = Tracer::new(poses.scene(), Simd::PORTABLE, 0);
        let mut workspace = Workspace::new();
        let corner = |x: f32, y: f32| 1.5 * Vec3::new(x, y, -1.0);
        let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(-1.0, 1.0)];
        let [lower_left, lower_right, upper_left] = corners;
        let wall = FlatScreen::from_corners(lower_left, lower_right, upper_left, [SIDE; 2]);
        let view = wall.view_from(Vec3::ZERO)?;
        let (mut sum, mut count) = (0u32, 0);
        for number in 0..SIDE * SIDE {
            let ray = view.ray((number % SIDE) as f32, (number / SIDE) as f32);
            let ray = ray.ok_or("a pixel without a ray")?;
            let hit = tracer.nearest(&ray, &mut { Budget::UNLIMITED }, &mut workspace);
            let bits = hit.map_or(0, |hit| {
                hit.on.t.to_bits() ^ hit.on.triangle ^ hit.instance << 24
            });
            sum = sum.wrapping_mul(31).wrapping_add(bits);
            count += u32::from(hit.is_some());
        }
        ensure!(found == sum, "rays hit {found:#x}, here {sum:#x}");
        ensure!(count > 100, "only {count} rays hit");
        Ok(format!("{count} hits as here"))
    }
}

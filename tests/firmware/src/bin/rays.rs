//! Measures the core on a Cortex-M7 before shading: instructions of a primary ray
//! through scene A and of a pixel's level of detail. The emulator's clock counts
//! them: each takes a nanosecond.
//!
//! The emulator's loader puts the scene into memory. The wall is the paper's front
//! wall in 64×64 pixels, seen from the middle of its room. Prints a name and a
//! number in each line; tests/firmware/run compares them with the limits.
#![no_std]
#![no_main]

use core::hint::black_box;
use cortex_m_rt::entry;
use cortex_m_semihosting::hprintln;
use glam::{DAffine3, DMat3, DVec3, Vec3};
use shisen_core::Simd;
use shisen_core::frame::{
    Budget, CompactRenderer, FlatScreen, LevelOfDetail, Renderer, Settings, View, Workspace,
};
use shisen_core::gaze::{Gaze, LineOfSight, VisualField};
use shisen_core::scene::format::{Instance, Node};
use shisen_core::scene::{CompactScene, EffectSet, Poses};
use shisen_core::shape::Ray;
use shisen_core::trace::Tracer;
use shisen_firmware::measure;

/// Address of the scene, and the bytes of memory from there on.
const SCENE: (usize, usize) = (0x6000_0000, 16 << 20);
/// Pixels a side of the wall.
const SIDE: u32 = 64;
/// Pixels a side of the blocks for which the renderer chooses levels.
const BLOCK: u32 = 8;
/// The controller's effects: those of Whitted's model but dispersion.
const EFFECTS: u32 = EffectSet::WHITTED.bits() & !EffectSet::DISPERSION.bits();

fn instructions(run: impl FnMut()) -> u32 {
    measure::instructions(1, run)
}

fn front_wall() -> Option<View> {
    let corner = |x: f32, y: f32| 1.5 * Vec3::new(x, y, -1.0);
    let corners = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0)].map(|(x, y)| corner(x, y));
    let [lower_left, lower_right, upper_left] = corners;
    FlatScreen::from_corners(lower_left, lower_right, upper_left, [SIDE; 2])
        .view_from(Vec3::ZERO)
        .ok()
}

/// A wall, the tracer and memory for measuring its rays.
struct Wall<'a> {
    view: View,
    renderer: CompactRenderer<'a>,
    workspace: &'a mut Workspace,
}

impl Wall<'_> {
    /// Returns the instructions of `run` for the rays that hit, for those that miss, or for
    /// all; and the number of these rays.
    fn each(
        &mut self,
        hit: Option<bool>,
        hits: &[bool],
        act: impl Fn(&Self, &Ray, &mut Workspace),
    ) -> (u32, u32) {
        let mut workspace = self.workspace.clone();
        let mut count = 0;
        let sum = instructions(|| {
            count = 0;
            for y in 0..SIDE {
                for x in 0..SIDE {
                    let known = hits.get((y * SIDE + x) as usize).copied();
                    if hit.is_some() && known != hit {
                        continue;
                    }
                    if let Some(ray) = self.view.ray(x as f32, y as f32) {
                        act(self, &ray, &mut workspace);
                        count += 1;
                    }
                }
            }
        });
        (sum, count)
    }

    /// Returns the instructions of a ray, without those of the loop and of making the ray.
    fn per_ray(
        &mut self,
        hit: Option<bool>,
        hits: &[bool],
        act: impl Fn(&Self, &Ray, &mut Workspace),
    ) -> u32 {
        let (with, count) = self.each(hit, hits, act);
        let (without, _) = self.each(hit, hits, |_, ray, _| {
            black_box(ray);
        });
        with.saturating_sub(without) / count.max(1)
    }

    /// Returns whether the rays of a block of pixels may hit anything, by one test.
    fn reaches(&self, (x, y): (u32, u32), workspace: &mut Workspace) -> bool {
        let tracer = self.renderer.tracer();
        let corner = |dx, dy| {
            let (x, y) = ((x + dx) as f32, (y + dy) as f32);
            self.view.direction(x, y).unwrap_or(Vec3::ZERO)
        };
        let end = BLOCK - 1;
        let corners = [(0, 0), (end, 0), (0, end), (end, end)].map(|(x, y)| corner(x, y));
        tracer.may_hit(Vec3::ZERO, &corners, &mut { Budget::UNLIMITED }, workspace)
    }

    /// Returns the instructions of a ray as the renderer traces it: one test finds a block
    /// that sees nothing.
    fn per_ray_in_blocks(&self) -> u32 {
        let mut workspace = self.workspace.clone();
        let mut reached = [false; (SIDE * SIDE / BLOCK / BLOCK) as usize];
        let each = |number: usize| {
            let (number, row) = (number as u32, SIDE / BLOCK);
            (number % row * BLOCK, number / row * BLOCK)
        };
        let rays = |(x, y): (u32, u32)| {
            (0..BLOCK * BLOCK).filter_map(move |number| {
                let (x, y) = (x + number % BLOCK, y + number / BLOCK);
                self.view.ray(x as f32, y as f32)
            })
        };
        let with = instructions(|| {
            for (number, reached) in reached.iter_mut().enumerate() {
                *reached = self.reaches(each(number), &mut workspace);
                if *reached {
                    rays(each(number)).for_each(|ray| nearest(self, &ray, &mut workspace));
                }
            }
        });
        let without = instructions(|| {
            for (number, _) in reached.iter().enumerate().filter(|(_, reached)| **reached) {
                rays(each(number)).for_each(|ray| {
                    black_box(ray);
                });
            }
        });
        with.saturating_sub(without) / (SIDE * SIDE)
    }
}

fn nearest(wall: &Wall<'_>, ray: &Ray, workspace: &mut Workspace) {
    let tracer = wall.renderer.tracer();
    black_box(tracer.nearest(black_box(ray), &mut { Budget::UNLIMITED }, workspace));
}

fn radiance(wall: &Wall<'_>, ray: &Ray, workspace: &mut Workspace) {
    let tracer = wall.renderer.tracer();
    black_box(tracer.radiance(black_box(ray), &mut { Budget::UNLIMITED }, workspace));
}

/// Most nodes of the tree over instances, and most instances.
const PLACES: (usize, usize) = (16, 16);

/// Returns where an instance moves.
fn moved(instance: &Instance) -> DAffine3 {
    let columns = instance
        .world_from_object
        .map(|column| column.map(f64::from));
    let turn = DMat3::from_cols_array(&[0.6, 0.0, -0.8, 0.0, 1.0, 0.0, 0.8, 0.0, 0.6]);
    let nearer = DAffine3::from_mat3_translation(turn * 0.75, DVec3::new(0.2, 0.1, -1.0));
    nearer * DAffine3::from_cols_array_2d(&columns)
}

/// Returns a number for what all rays hit after the instances have moved: the host works out the
/// same (tests/src/bin/firmware/poses.rs).
fn posed_hits(scene: CompactScene<'_>, view: &View, workspace: &mut Workspace) -> Option<u32> {
    let mut top = [Node::EMPTY; PLACES.0];
    let mut instances = [*scene.instances().first()?; PLACES.1];
    let mut poses = Poses::new(scene, &mut top, &mut instances).ok()?;
    for (number, instance) in scene.instances().iter().enumerate() {
        poses.set(number, &moved(instance)).ok()?;
    }
    poses.refit();
    let tracer = Tracer::for_effects::<EFFECTS>(poses.scene(), Simd::PORTABLE, 0);
    let mut sum = 0u32;
    for number in 0..SIDE * SIDE {
        let ray = view.ray((number % SIDE) as f32, (number / SIDE) as f32)?;
        let hit = tracer.nearest(&ray, &mut { Budget::UNLIMITED }, workspace);
        let bits = hit.map_or(0, |hit| {
            hit.on.t.to_bits() ^ hit.on.triangle ^ hit.instance << 24
        });
        sum = sum.wrapping_mul(31).wrapping_add(bits);
    }
    Some(sum)
}

fn measured(workspace: &mut Workspace) -> Option<()> {
    // SAFETY: the board has this memory, and nothing writes to it.
    let bytes = unsafe { core::slice::from_raw_parts(SCENE.0 as *const u8, SCENE.1) };
    let scene = CompactScene::from_bytes(bytes).ok()?;
    let view = front_wall()?;
    let at_depth = |depth| {
        let settings = Settings {
            depth,
            ..Settings::default()
        };
        Renderer::single::<EFFECTS>(scene, Simd::PORTABLE, settings)
    };
    let mut wall = Wall {
        view,
        renderer: at_depth(0),
        workspace,
    };
    let mut hits = [false; (SIDE * SIDE) as usize];
    for (number, hit) in (0..).zip(&mut hits) {
        let ray = view.ray((number % SIDE) as f32, (number / SIDE) as f32)?;
        let (tracer, budget) = (wall.renderer.tracer(), &mut { Budget::UNLIMITED });
        *hit = tracer.nearest(&ray, budget, wall.workspace).is_some();
    }
    hprintln!("rays_that_hit {}", hits.iter().filter(|&&hit| hit).count());
    let found = wall.per_ray(Some(true), &hits, nearest);
    hprintln!("primary_ray {}", wall.per_ray_in_blocks());
    hprintln!("primary_ray_alone {}", wall.per_ray(None, &hits, nearest));
    hprintln!("primary_ray_that_hits {found}");
    hprintln!(
        "primary_ray_that_misses {}",
        wall.per_ray(Some(false), &hits, nearest)
    );
    let shaded = wall.per_ray(Some(true), &hits, radiance);
    hprintln!("shaded_hit {}", shaded.saturating_sub(found));

    hprintln!("posed_hits {}", posed_hits(scene, &view, wall.workspace)?);

    let sight = LineOfSight::new(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y).ok()?;
    let gaze = Gaze::new(sight, VisualField::PAPER);
    let level = wall.per_ray(None, &hits, |_, ray, _| {
        black_box(gaze.level(black_box(ray.direction())));
    });
    hprintln!("level_of_a_ray {level}");
    wall.renderer = wall.renderer.with_level_of_detail(LevelOfDetail::new(gaze));
    // The renderer decides all pixels of a block at once.
    let blocks = instructions(|| {
        for y in (0..SIDE).step_by(BLOCK as usize) {
            for x in (0..SIDE).step_by(BLOCK as usize) {
                black_box(wall.renderer.detail(black_box(&wall.view), x, y));
            }
        }
    });
    hprintln!("level_of_a_pixel {}", blocks / (SIDE * SIDE));
    Some(())
}

#[entry]
fn main() -> ! {
    static mut WORKSPACE: Workspace = Workspace::new();
    measure::start();
    let done = measured(WORKSPACE);
    if done.is_none() {
        hprintln!("there is no scene to be measured");
    }
    measure::end(done.is_some())
}

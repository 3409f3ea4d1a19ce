//! Rays that start inside a closed mesh: how many hit nothing.

use super::contender::{Contender, RaySet, Subject};
use super::meshes::{edges, ellipsoid, gridded_cube, position};
use super::rays::Random;
use super::report::{Report, Row};
use glam::DVec3;
use shisen::bake::BakeError;
use shisen_peers_interface::{Hit, NONE, Task};

/// Rays traced at a time.
const CHUNK: usize = 1 << 20;

/// Squares along an edge of the cube, so that its lines are not on round numbers.
const CELLS: u32 = 40;

/// Counts the lost rays of all contenders for nearest hits: `count` at the middles of edges
/// and at vertices of an ellipsoid, a fifth of that along the lines of a cube.
pub fn measure(
    contenders: &[Contender],
    count: usize,
    seed: u64,
    report: &mut Report,
) -> Result<(), BakeError> {
    let mesh = ellipsoid();
    let middles: Vec<_> = edges(&mesh)
        .into_iter()
        .map(|[a, b]| 0.5 * (position(&mesh, a) + position(&mesh, b)))
        .collect();
    let vertices: Vec<_> = (0..mesh.positions.len() as u32)
        .map(|vertex| position(&mesh, vertex))
        .collect();
    let subject = Subject::new("ellipsoid", mesh)?;
    for (what, targets) in [("edges", middles), ("vertices", vertices)] {
        let next = |random: &mut Random| aimed(random, &targets);
        count_lost(contenders, &subject, what, count, seed, next, report);
    }
    let cube = Subject::new("cube", gridded_cube(CELLS))?;
    count_lost(
        contenders,
        &cube,
        "axis rays",
        count / 5,
        seed,
        along_a_line,
        report,
    );
    Ok(())
}

fn count_lost(
    contenders: &[Contender],
    subject: &Subject,
    what: &'static str,
    count: usize,
    seed: u64,
    next: impl Fn(&mut Random) -> [f32; 6],
    report: &mut Report,
) {
    let seekers = contenders
        .iter()
        .filter(|contender| contender.task == Task::Nearest);
    let mut seekers: Vec<_> = seekers
        .filter_map(|contender| Some((contender, contender.open(subject)?, 0)))
        .collect();
    let mut random = Random::new(seed);
    let mut left = count;
    while left > 0 {
        let size = left.min(CHUNK);
        left -= size;
        let set = RaySet {
            name: what,
            rays: (0..size).map(|_| next(&mut random)).collect(),
            side: 0,
        };
        let mut hits = vec![Hit::MISS; size];
        for (_, opened, lost) in &mut seekers {
            opened.trace(&set, &mut hits);
            *lost += hits.iter().filter(|hit| hit.triangle == NONE).count();
        }
    }
    for (contender, _, lost) in seekers {
        if contender.is_ours() && lost != 0 {
            let Contender { name, mode, .. } = contender;
            let failure = format!("{name} {mode}: {lost} of {count} rays lost, {what}");
            report.failures.push(failure);
        }
        report.rows.push(Row {
            value: lost as f64,
            unit: "lost",
            rays: Some(count as u64),
            ..contender.row("rays lost inside closed meshes", &subject.name, what)
        });
    }
}

/// Returns a ray from around the ellipsoid's middle to one of the targets: aimed in f64, rounded to
/// f32.
fn aimed(random: &mut Random, targets: &[DVec3]) -> [f32; 6] {
    let origin = DVec3::from(random.direction()) * random.range(0.0, 0.3);
    let direction = targets[random.below(targets.len())] - origin;
    let ([a, b, c], [d, e, f]) = (origin.to_array(), direction.to_array());
    [a, b, c, d, e, f].map(|component| component as f32)
}

/// Returns a ray exactly along an axis, on lines of the grid both ways.
fn along_a_line(random: &mut Random) -> [f32; 6] {
    let axis = random.below(3);
    let mut ray = [0.0; 6];
    for across in [(axis + 1) % 3, (axis + 2) % 3] {
        let line = 1 + random.below(CELLS as usize - 1);
        ray[across] = (2.0 * line as f64 / f64::from(CELLS) - 1.0) as f32;
    }
    ray[axis] = random.range(-0.99, 0.99) as f32;
    ray[3 + axis] = if random.bits() & 1 == 0 { 1.0 } else { -1.0 };
    ray
}

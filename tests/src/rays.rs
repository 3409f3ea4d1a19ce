//! Sets of rays for benchmarks and watertightness, and their files.

use crate::meshes::position;
use glam::{DVec3, Vec3};
use shisen::scene::mesh::TriangleMesh;
use shisen_core::shape::Ray;

/// Origin and direction.
pub type RawRay = [f32; 6];

/// A small generator with good statistics and a stated sequence (splitmix64,
/// Steele, Lea & Flood 2014): the same rays on every machine.
#[derive(Debug, Clone)]
pub struct Random(u64);

impl Random {
    /// From a seed.
    pub const fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    /// From 0 up to 1.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// Between two numbers.
    pub fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Below `limit`.
    pub fn below(&mut self, limit: usize) -> usize {
        (self.unit() * limit as f64) as usize
    }

    /// Evenly over the unit sphere.
    pub fn direction(&mut self) -> [f64; 3] {
        let z = self.range(-1.0, 1.0);
        let (s, c) = self.range(0.0, std::f64::consts::TAU).sin_cos();
        let r = (1.0 - z * z).sqrt();
        [r * c, r * s, z]
    }
}

fn ray(origin: DVec3, direction: DVec3) -> RawRay {
    let ([a, b, c], [d, e, f]) = (origin.as_vec3().into(), direction.as_vec3().into());
    [a, b, c, d, e, f]
}

/// Returns rays as the core has them.
pub fn to_rays(raw: &[RawRay]) -> Vec<Ray> {
    let ray = |&[a, b, c, d, e, f]: &RawRay| Ray::new([a, b, c].into(), [d, e, f].into());
    raw.iter().map(|raw| ray(raw).expect("a ray")).collect()
}

/// Returns a pinhole picture of `side`² pixels of a mesh of radius 10 about the
/// origin; `half_width` is the tangent of half its field. 0.55 sees the whole
/// object, 0.12 little but it.
pub fn pinhole(side: u32, half_width: f64) -> Vec<RawRay> {
    let eye = DVec3::new(9.0, 7.0, 20.0);
    let forward = -eye.normalize();
    let right = forward.cross(DVec3::Y).normalize();
    let up = right.cross(forward);
    let at = |i: u32| ((f64::from(i) + 0.5) / f64::from(side) * 2.0 - 1.0) * half_width;
    let towards = |i: u32| forward + right * at(i % side) - up * at(i / side);
    (0..side * side).map(|i| ray(eye, towards(i))).collect()
}

/// From a sphere of 1.5 radii to random points of the mesh's box.
pub fn incoherent(mesh: &TriangleMesh, count: usize, random: &mut Random) -> Vec<RawRay> {
    let (low, high) = mesh.bounds();
    let one = |_| {
        let origin = DVec3::from(random.direction()) * 15.0;
        let target = [0, 1, 2].map(|a| random.range(low[a].into(), high[a].into()));
        ray(origin, DVec3::from(target) - origin)
    };
    (0..count).map(one).collect()
}

/// From the points where `rays` hit, `t` and triangle of each being given,
/// cosine-distributed about the normal on the ray's side.
pub fn bounce(
    mesh: &TriangleMesh,
    rays: &[RawRay],
    hits: &[Option<(f32, u32)>],
    count: usize,
    random: &mut Random,
) -> Vec<RawRay> {
    let found = rays.iter().zip(hits).filter_map(|(r, h)| Some((r, (*h)?)));
    let found: Vec<_> = found.collect();
    let one = |i: usize| {
        let (&[a, b, c, d, e, f], (t, triangle)) = found[i * found.len() / count];
        let [origin, direction] = [[a, b, c], [d, e, f]].map(|v| Vec3::from(v).as_dvec3());
        let [a, b, c] = mesh.triangles[triangle as usize].map(|vertex| position(mesh, vertex));
        let normal = (b - a).cross(c - a).normalize();
        let normal = normal * -normal.dot(direction).signum();
        let from = origin + direction * f64::from(t) + normal * 1e-3;
        ray(from, normal * 1.000_001 + DVec3::from(random.direction()))
    };
    (0..count).map(one).collect()
}

//! Sets of rays for benchmarks and watertightness, and their files.

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

fn ray(origin: [f64; 3], direction: [f64; 3]) -> RawRay {
    let ([a, b, c], [d, e, f]) = (origin, direction);
    [a, b, c, d, e, f].map(|x| x as f32)
}

/// Rays as the core has them.
///
/// # Panics
/// Where one is not finite or has no direction.
pub fn to_rays(raw: &[RawRay]) -> Vec<Ray> {
    let ray = |&[a, b, c, d, e, f]: &RawRay| Ray::new([a, b, c].into(), [d, e, f].into());
    raw.iter().map(|raw| ray(raw).expect("a ray")).collect()
}

/// A pinhole picture of `side`² pixels of a mesh of radius 10 about the
/// origin; `half_width` is the tangent of half its field. 0.55 sees the whole
/// object, 0.12 little but it.
pub fn pinhole(side: u32, half_width: f64) -> Vec<RawRay> {
    let eye: [f64; 3] = [9.0, 7.0, 20.0];
    let length = eye.iter().map(|c| c * c).sum::<f64>().sqrt();
    let forward = eye.map(|c| -c / length);
    let right = {
        let (x, z) = (-forward[2], forward[0]);
        let length = x.hypot(z);
        [x / length, 0.0, z / length]
    };
    let up = [
        right[1] * forward[2] - right[2] * forward[1],
        right[2] * forward[0] - right[0] * forward[2],
        right[0] * forward[1] - right[1] * forward[0],
    ];
    let at = |i: u32| ((f64::from(i) + 0.5) / f64::from(side) * 2.0 - 1.0) * half_width;
    (0..side * side)
        .map(|i| {
            let (x, y) = (at(i % side), -at(i / side));
            ray(
                eye,
                std::array::from_fn(|a| forward[a] + right[a] * x + up[a] * y),
            )
        })
        .collect()
}

/// From a sphere of 1.5 radii to random points of the mesh's box.
pub fn incoherent(mesh: &TriangleMesh, count: usize, random: &mut Random) -> Vec<RawRay> {
    let (low, high) = mesh.bounds();
    (0..count)
        .map(|_| {
            let origin = random.direction().map(|c| c * 15.0);
            let target: [f64; 3] =
                std::array::from_fn(|a| random.range(f64::from(low[a]), f64::from(high[a])));
            ray(origin, std::array::from_fn(|a| target[a] - origin[a]))
        })
        .collect()
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
    let found: Vec<_> = rays
        .iter()
        .zip(hits)
        .filter_map(|(r, h)| Some((r, (*h)?)))
        .collect();
    (0..count)
        .map(|i| {
            let (from, (t, triangle)) = found[i * found.len() / count];
            let from = from.map(f64::from);
            let corner = |i: usize| {
                let vertex = mesh.triangles[triangle as usize][i] as usize;
                mesh.positions[vertex].map(f64::from)
            };
            let (a, b, c) = (corner(0), corner(1), corner(2));
            let e: [f64; 3] = std::array::from_fn(|i| b[i] - a[i]);
            let f: [f64; 3] = std::array::from_fn(|i| c[i] - a[i]);
            let n = [
                e[1] * f[2] - e[2] * f[1],
                e[2] * f[0] - e[0] * f[2],
                e[0] * f[1] - e[1] * f[0],
            ];
            let length = n.iter().map(|c| c * c).sum::<f64>().sqrt();
            let facing = (0..3).map(|i| n[i] * from[3 + i]).sum::<f64>();
            let n = n.map(|c| -c * facing.signum() / length);
            let d = random.direction();
            let direction = std::array::from_fn(|i| n[i] * 1.000_001 + d[i]);
            let origin =
                std::array::from_fn(|i| from[i] + from[3 + i] * f64::from(t) + n[i] * 1e-3);
            ray(origin, direction)
        })
        .collect()
}

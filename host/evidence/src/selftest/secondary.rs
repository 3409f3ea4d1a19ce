//! Rays that start where another one ended.

use super::input::{Inputs, aimed, single};
use super::meshes::ellipsoid;
use super::{Case, Effort, Errors, wrong};
use crate::textbook::{exact_refraction, textbook_refraction};
use glam::{DAffine3, DVec3, Vec3};
use shisen::bake::{Baked, lone_mesh};
use shisen::scene::material::Material;
use shisen::scene::mesh::TriangleMesh;
use shisen::scene::{Background, Light, Object, Scene, Shape};
use shisen_core::Simd;
use shisen_core::frame::{Budget, Pixel, Workspace};
use shisen_core::shape::Ray;
use shisen_core::trace::Tracer;

const EPSILON: &str = "the same rays, started a fixed 10⁻⁴ m off the surface";

pub(super) const CASES: &[Case] = cases! {
    ["lit places that are dark (acne), and places behind a wall of a thousandth of the size that are \
      lit (leaks)",
     "a convex body lights itself nowhere it faces the light; a closed box is dark",
     EPSILON]:
    "shadow-rays-at-1e-3", 0.0, |effort| shadows(1.0e-3, effort),
        "bodies of a millimetre";
    "shadow-rays-at-1", 0.0, |effort| shadows(1.0, effort),
        "bodies of a metre";
    "shadow-rays-at-1e3", 0.0, |effort| shadows(1.0e3, effort),
        "bodies of a kilometre";
    "shadow-rays-at-1e6", 0.0, |effort| shadows(1.0e6, effort),
        "bodies of a thousand kilometres";
    ["of the light, relative", "the geometric series of the reflectance", EPSILON]:
    "hall-of-mirrors", 1.0e-6, hall,
        "two mirrors 50 µm apart, eight reflections";
    ["of the light through it, of 1",
     "Fresnel's series of the borders, ended as documented",
     EPSILON]:
    "glass-slab-of-10-micrometres", 2.0e-7, |_| slab(|_| Vec3::NEG_Z, false),
        "both borders of a slab of glass that is 10 µm thick and a metre wide";
    "glass-slab-at-an-angle", 1.0e-6, |_| slab(slanting, false),
        "the same slab, seen at up to 80° to its normal";
    ["of the light through it, of 1",
     "Fresnel's series of the borders, ended as documented",
     "the textbook's way with the file's normals"]:
    "glass-slab-with-inside-out-normals", 1.0e-6, |_| slab(slanting, true),
        "the same, smooth, of a file whose normals all point into the glass";
    ["rays that do", "a convex body is met once", EPSILON]:
    "mirror-ball-of-any-size", 0.0, balls,
        "light off a ball of 10⁻³ to 10⁶ m that must not meet the ball again";
};

/// The usual fixed offset of secondary rays, metres.
const OFF: f32 = 1.0e-4;

fn empty() -> Scene {
    Scene {
        meshes: Vec::new(),
        objects: Vec::new(),
        ..lone_mesh(TriangleMesh::default())
    }
}

fn matt(colour: f32) -> Material {
    Material {
        diffuse: [colour; 3],
        specular: [0.0; 3],
        ..Material::default()
    }
}

fn add(scene: &mut Scene, shape: Shape, material: Material) {
    scene.materials.push(material);
    scene.objects.push(Object {
        shape,
        material: Some(scene.materials.len() - 1),
        world_from_object: DAffine3::IDENTITY,
        casts_shadow: true,
        smooth: false,
    });
}

fn add_mesh(scene: &mut Scene, mesh: TriangleMesh, material: Material) {
    scene.meshes.push(mesh);
    add(scene, Shape::Mesh(scene.meshes.len() - 1), material);
}

/// Returns a box from corner to corner, faces outwards.
fn cuboid(low: DVec3, high: DVec3) -> TriangleMesh {
    let (low, high) = (single(low).to_array(), single(high).to_array());
    let corner = |i: usize| [0, 1, 2].map(|axis| [low, high][i >> axis & 1][axis]);
    let faces = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    TriangleMesh {
        positions: (0..8).map(corner).collect(),
        triangles: faces
            .iter()
            .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
            .collect(),
        ..TriangleMesh::default()
    }
}

struct Eye<'a> {
    tracer: Tracer<'a>,
    workspace: Workspace,
}

impl<'a> Eye<'a> {
    fn new(baked: &'a Baked<8>, depth: u8) -> Self {
        Self {
            tracer: Tracer::new(baked.scene(), Simd::detect(), depth),
            workspace: Workspace::new(),
        }
    }

    fn sees(&mut self, ray: &Ray) -> Pixel {
        let mut budget = Budget::UNLIMITED;
        self.tracer.radiance(ray, &mut budget, &mut self.workspace)
    }

    /// Distance and number of the triangle.
    fn nearest(&mut self, ray: &Ray) -> Option<(f32, usize)> {
        let mut budget = Budget::UNLIMITED;
        let hit = self.tracer.nearest(ray, &mut budget, &mut self.workspace)?;
        Some((hit.on.t, hit.on.triangle as usize))
    }

    fn is_dark(&mut self, from: Vec3, light: DVec3) -> bool {
        let Some(ray) = aimed(from.as_dvec3(), light) else {
            return true;
        };
        let mut budget = Budget::UNLIMITED;
        self.tracer
            .is_occluded(&ray, 1.0, &mut budget, &mut self.workspace)
    }
}

fn normal(mesh: &TriangleMesh, triangle: usize) -> Option<DVec3> {
    let corners = mesh.triangles.get(triangle)?;
    let [a, b, c] = corners.map(|v| Vec3::from(mesh.positions[v as usize]).as_dvec3());
    (b - a).cross(c - a).try_normalize()
}

fn shadows(size: f64, effort: Effort) -> Option<Errors> {
    let (acne, leaks) = (acne(size, effort)?, leaks(size, effort)?);
    Some(Errors::new(
        acne.ours + leaks.ours,
        acne.naive + leaks.naive,
    ))
}

fn lit_from(light: DVec3) -> Scene {
    let mut scene = empty();
    scene.lights.push(Light::Point {
        position: light,
        colour: [1.0; 3],
        inverse_square: false,
    });
    scene
}

/// Counts places of a convex body that face the light and are dark.
fn acne(size: f64, effort: Effort) -> Option<Errors> {
    let mut mesh = ellipsoid();
    for p in &mut mesh.positions {
        *p = p.map(|x| (f64::from(x) * size) as f32);
    }
    let light = DVec3::new(5.0, 7.0, 6.0) * size;
    let mut scene = lit_from(light);
    add_mesh(&mut scene, mesh.clone(), matt(1.0));
    let baked = Baked::<8>::new(&scene).ok()?;
    let mut eye = Eye::new(&baked, 0);
    // The other half faces away from the light.
    wrong(400, effort.of(200_000), 0.25, |inputs, dark| {
        let from = inputs.direction() * 4.0 * size;
        // Its least half axis is 0.37 of the size.
        let ray = aimed(from, inputs.in_ball() * 0.35 * size)?;
        let Some((t, triangle)) = eye.nearest(&ray) else {
            return dark.lost();
        };
        let normal = normal(&mesh, triangle)?;
        let at = ray.at(t);
        let towards = (light - at.as_dvec3()).normalize();
        if normal.dot(towards) >= 0.02 {
            let off = at + single(normal) * OFF;
            dark.wrong(eye.sees(&ray).red == 0.0, eye.is_dark(off, light));
        }
        Some(())
    })
}

/// Counts places inside a closed box with thin walls that light from outside reaches.
fn leaks(size: f64, effort: Effort) -> Option<Errors> {
    let thick = 1.0e-3 * size;
    let light = DVec3::new(3.0, 4.0, 5.0) * size;
    let mut scene = lit_from(light);
    // Each wall is a box of its own, and reaches past its neighbours.
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let (mut low, mut high) = (DVec3::splat(-size - thick), DVec3::splat(size + thick));
            let [inner, outer] = [side * size, side * (size + thick)];
            low[axis] = f64::min(inner, outer);
            high[axis] = f64::max(inner, outer);
            add_mesh(&mut scene, cuboid(low, high), matt(1.0));
        }
    }
    let baked = Baked::<8>::new(&scene).ok()?;
    let mut eye = Eye::new(&baked, 0);
    wrong(401, effort.of(200_000), 0.5, |inputs, lit| {
        let from = inputs.in_ball() * 0.9 * size;
        let ray = Ray::new(single(from), single(inputs.direction()))?;
        let Some((t, _)) = eye.nearest(&ray) else {
            return lit.lost();
        };
        // Off the surface towards the light, as a shadow ray starts.
        let at = ray.at(t);
        let towards = single((light - at.as_dvec3()).normalize());
        let naive = !eye.is_dark(at + towards * OFF, light);
        lit.wrong(eye.sees(&ray).red != 0.0, naive);
        Some(())
    })
}

fn hall(_: Effort) -> Option<Errors> {
    const GAP: f64 = 5.0e-5;
    const MIRROR: f32 = 0.9;
    // The mirrors at −z and at +z differ, so that hits of the wrong one show.
    const DIFFUSE: [f32; 2] = [0.25, 0.5];
    let mut scene = empty();
    scene.ambient = [1.0; 3];
    for (side, diffuse) in [(-1.0, DIFFUSE[0]), (1.0, DIFFUSE[1])] {
        let chrome = Material {
            mirror: [MIRROR; 3],
            ..matt(diffuse)
        };
        let (near, far) = (side * GAP / 2.0, side * (GAP / 2.0 + 0.01));
        let low = DVec3::new(-0.5, -0.5, f64::min(near, far));
        let high = DVec3::new(0.5, 0.5, f64::max(near, far));
        add_mesh(&mut scene, cuboid(low, high), chrome);
    }
    let baked = Baked::<8>::new(&scene).ok()?;
    let mut worst = Errors::NONE;
    let mut inputs = Inputs::new(402);
    for depth in 0..=8 {
        let mut eye = Eye::new(&baked, depth);
        let light_of = |k: i32, side: usize| f64::from(DIFFUSE[side]) * f64::from(MIRROR).powi(k);
        for _ in 0..100 {
            let [x, y, z] = [0; 3].map(|_| inputs.range(-0.4, 0.4));
            let at = DVec3::new(x, y, z * GAP);
            let [x, y] = [0; 2].map(|_| inputs.range(-0.1, 0.1));
            let way = DVec3::new(x, y, inputs.sign());
            let Some(ray) = Ray::new(single(at), single(way)) else {
                continue;
            };
            let first = usize::from(way.z > 0.0);
            let bounces = 0..=i32::from(depth);
            let expected: f64 = bounces.map(|k| light_of(k, (first + k as usize) % 2)).sum();
            worst.ours(f64::from(eye.sees(&ray).red) / expected - 1.0);
            // From mirror to mirror, each ray starts a fixed distance off: inside the other.
            let (mut light, mut ray) = (0.0, ray);
            for k in 0..=i32::from(depth) {
                let Some((t, _)) = eye.nearest(&ray) else {
                    break;
                };
                light += light_of(k, usize::from(ray.at(t).z > 0.0));
                let off = ray.at(t) - Vec3::Z * (OFF * ray.direction().z.signum());
                let back = ray.direction() * Vec3::new(1.0, 1.0, -1.0);
                let Some(reflected) = Ray::new(off, back) else {
                    break;
                };
                ray = reflected;
            }
            worst.naive(light / expected - 1.0);
        }
    }
    Some(worst)
}

/// Returns a direction down at up to 80° to the normal.
fn slanting(inputs: &mut Inputs) -> Vec3 {
    let (sin, cos) = libm::sincos(inputs.range(0.0, 80f64.to_radians()));
    let across = inputs.across(DVec3::Z);
    single(across * sin - DVec3::Z * cos).normalize()
}

/// With `inwards` the normals of its vertices, by which it is smooth, point into the glass.
fn slab(way: fn(&mut Inputs) -> Vec3, inwards: bool) -> Option<Errors> {
    const THICK: f64 = 1.0e-5;
    let mut worst = Errors::NONE;
    for index in [1.33f32, 1.5, 2.4] {
        let glass = Material {
            transmission: [1.0; 3],
            index_of_refraction: index,
            ..matt(0.0)
        };
        let mut scene = empty();
        scene.ambient = [1.0; 3];
        let half = DVec3::new(0.5, 0.5, THICK / 2.0);
        let mut mesh = cuboid(-half, half);
        if inwards {
            let inwards = |p: &[f32; 3]| [0.0, 0.0, -p[2].signum()];
            mesh.normals = mesh.positions.iter().map(inwards).collect();
        }
        add_mesh(&mut scene, mesh, glass);
        for object in &mut scene.objects {
            object.smooth = inwards;
        }
        // Wide enough to be seen through the slab at any of the angles.
        let panel = [DVec3::new(-4.0, -4.0, -0.5), DVec3::new(4.0, 4.0, -0.4)];
        add_mesh(&mut scene, cuboid(panel[0], panel[1]), matt(1.0));
        let baked = Baked::<8>::new(&scene).ok()?;
        let mut inputs = Inputs::new(403);
        for depth in 2..=8u8 {
            let mut eye = Eye::new(&baked, depth);
            for _ in 0..100 {
                let way = way(&mut inputs);
                let [x, y] = [0; 2].map(|_| inputs.range(-0.2, 0.2) as f32);
                let middle = Vec3::new(x, y, 0.0);
                let Some(ray) = Ray::new(middle - way * 0.05, way) else {
                    continue;
                };
                let through = through(f64::from(-way.z), index.into(), depth);
                worst.ours(f64::from(eye.sees(&ray).green) - through);
                worst.naive(stepped(&mut eye, &ray, (1.0, index), inwards, depth) - through);
            }
        }
    }
    Some(worst)
}

/// Returns the light that leaves a slab of this index after 2, 4, 6 … up to `depth` borders. Light
/// that is not followed further inside leaves at once.
fn through(cos: f64, index: f64, depth: u8) -> f64 {
    let Some((r, _)) = exact_refraction(cos, 1.0, index) else {
        return f64::NAN;
    };
    let (mut through, mut inside) = (0.0, 1.0 - r);
    for borders in 2..=depth {
        let stays = inside * r;
        let least = f64::from(shisen_core::frame::LEAST_WEIGHT);
        let followed = borders < depth && stays >= least;
        let leaves = if followed { inside - stays } else { inside };
        if borders % 2 == 0 {
            through += leaves;
        }
        inside -= leaves;
    }
    through
}

/// Returns the light of a ray down through the slab to the panel by the textbook, where both rays
/// start a fixed distance off each border; from index `m` into `n`.
fn stepped(eye: &mut Eye<'_>, ray: &Ray, (m, n): (f32, f32), inwards: bool, depth: u8) -> f64 {
    let Some((t, _)) = eye.nearest(ray) else {
        return 0.0;
    };
    let at = ray.at(t);
    if at.z < -0.3 {
        return 1.0;
    }
    if depth == 0 {
        return 0.0;
    }
    let facing = Vec3::NEG_Z * ray.direction().z.signum();
    let normal = if inwards { -facing } else { facing };
    let mut follow = |way: Vec3, media: (f32, f32), part: f64| {
        let next = Ray::new(at + way * OFF, way);
        part * next.map_or(0.0, |ray| stepped(eye, &ray, media, inwards, depth - 1))
    };
    let back = ray.direction() * Vec3::new(1.0, 1.0, -1.0);
    match textbook_refraction(ray.direction(), normal, m, n) {
        Some((r, t, onward)) => {
            follow(onward, (n, m), f64::from(t)) + follow(back, (m, n), f64::from(r))
        }
        None => follow(back, (m, n), 1.0),
    }
}

fn balls(effort: Effort) -> Option<Errors> {
    let (mut inputs, mut met_again) = (Inputs::new(404), Errors::NONE);
    let tries = effort.of(20_000);
    for exponent in -3..=6 {
        let size = 10f64.powi(exponent);
        let mut scene = empty();
        // White surroundings, a black ball.
        scene.background = Background::uniform([1.0; 3]);
        let mirror = Material {
            mirror: [1.0; 3],
            ..matt(0.0)
        };
        let radius = size as f32;
        add(&mut scene, Shape::Sphere { radius }, mirror);
        let baked = Baked::<8>::new(&scene).ok()?;
        let mut eye = Eye::new(&baked, 8);
        for _ in 0..tries {
            // Grazing too: a hundredth of them within a thousandth of the rim.
            let side = inputs.direction();
            let along = inputs.across(side);
            let inwards = inputs.magnitude(-5.0, 0.0);
            let foot = side * (1.0 - inwards) * size;
            let Some(ray) = aimed(foot - along * 3.0 * size, foot) else {
                continue;
            };
            // The nearest to the rim goes 10⁻⁵ of the radius inside of it.
            let (t, _) = eye.nearest(&ray)?;
            let at = ray.at(t);
            let normal = at.normalize();
            let d = ray.direction().normalize();
            let reflected = d - normal * (2.0 * d.dot(normal));
            let again = Ray::new(at + reflected * OFF, reflected).and_then(|ray| eye.nearest(&ray));
            met_again.wrong(eye.sees(&ray).red < 0.999, again.is_some());
        }
    }
    met_again.of_at_least(5.0 * tries as f64)
}

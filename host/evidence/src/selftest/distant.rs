//! Rays and closed meshes that are far away from the origin of the world.

use super::input::single;
use super::meshes::{ellipsoid, positions};
use super::triangles::LEAST;
use super::{Case, Effort, Errors, UNIT, largest};
use crate::textbook::moller_trumbore;
use glam::{DAffine3, DQuat, DVec3, EulerRot, Vec3};
use shisen::bake::{Baked, lone_mesh};
use shisen::scene::mesh::TriangleMesh;
use shisen::scene::quadruped::quadruped;
use shisen::scene::{Object, Scene};
use shisen_core::Simd;
use shisen_core::frame::{Budget, Workspace};
use shisen_core::shape::Ray;
use shisen_core::trace::Tracer;
use std::collections::BTreeMap;

const BESIDE: &str = "how far surfaces or outlines would have to be moved for the answer to be \
                      right, 2⁻²⁴ of how far the object is away";
const REFERENCE: &str = "every triangle in f64, where the object is in f64";
const NAIVE: &str = "vertices moved in f32, Möller and Trumbore's test of each";

pub(super) const CASES: &[Case] = cases! {
    [BESIDE, REFERENCE, NAIVE]:
    // A few roundings of 10 cm, beside one of 100 km.
    "mesh-of-millimetres-far-away", 1.0e-5, millimetres,
        "a mesh of triangles of a millimetre, 100 km away from the origin, seen from 10 cm";
    "mesh-a-million-metres-away", 1.0e-4, moved,
        "an animal of 2 m moved by 1,000 km, seen from 3 m";
    // Rays are turned into the object's axes: the matrix, where the object's origin is,
    // three products and their sums are rounded, at this place by up to 1.35 each. The
    // textbook's way rounds once, but has a copy of the mesh for each object.
    "mesh-turned-a-million-metres-away", 3.0, turned,
        "the same, turned and moved by no whole metres: where it is has to be rounded";
    [BESIDE,
     "every triangle in f64, of the same vertices",
     "planes of the triangles from the origin in f32, as they are stored for speed"]:
    "mesh-of-vertices-far-away", 2.0e-3, vertices_far_away,
        "a mesh whose own vertices are 100 km away from the origin, seen from 30 m";
};

fn moved(effort: Effort) -> Option<Errors> {
    let away = DVec3::new(1.0e6, -0.5e6, 0.75e6);
    placed(207, effort, &quadruped(), DAffine3::from_translation(away))
}

fn turned(effort: Effort) -> Option<Errors> {
    let turn = DQuat::from_euler(EulerRot::YXZ, 0.7, 1.1, 0.2);
    let away = DVec3::new(1.0e6, -0.5e6, 0.75e6) + DVec3::new(0.123, 0.456, 0.789);
    let place = DAffine3::from_rotation_translation(turn, away);
    placed(210, effort, &quadruped(), place)
}

fn millimetres(effort: Effort) -> Option<Errors> {
    let mut mesh = ellipsoid();
    for p in &mut mesh.positions {
        *p = p.map(|x| x * 0.02);
    }
    let away = DVec3::new(-1.0e5, 1.0e5, 0.5e5);
    placed(209, effort, &mesh, DAffine3::from_translation(away))
}

fn placed(seed: u64, effort: Effort, mesh: &TriangleMesh, place: DAffine3) -> Option<Errors> {
    let in_f64 = |v: Vec3| place.transform_point3(v.as_dvec3());
    let exact = corners(mesh).map(|t| t.map(in_f64)).collect();
    let rounded: Vec<[Vec3; 3]> = corners(mesh)
        .map(|t| t.map(|v| single(in_f64(v))))
        .collect();
    compared(seed, effort, mesh, place, exact, |ray| {
        let hits = rounded
            .iter()
            .filter_map(|&t| moller_trumbore(t, ray, LEAST));
        hits.min_by(f32::total_cmp)
    })
}

fn vertices_far_away(effort: Effort) -> Option<Errors> {
    let mut mesh = ellipsoid();
    let away = DVec3::new(1.0e5, 0.5e5, -0.75e5);
    for p in &mut mesh.positions {
        *p = single(Vec3::from(*p).as_dvec3() * 4.0 + away).to_array();
    }
    let exact = corners(&mesh).map(|t| t.map(Vec3::as_dvec3)).collect();
    let planes: Vec<Plane> = corners(&mesh).map(Plane::new).collect();
    compared(211, effort, &mesh, DAffine3::IDENTITY, exact, |ray| {
        let hits = planes.iter().filter_map(|plane| plane.hit(ray));
        hits.min_by(f32::total_cmp)
    })
}

/// A triangle as its plane and those through its edges, by their distance from the origin.
struct Plane {
    normal: Vec3,
    distance: f32,
    edges: [(Vec3, f32); 3],
}

impl Plane {
    fn new([a, b, c]: [Vec3; 3]) -> Self {
        let normal = (b - a).cross(c - a);
        let edge = |p: Vec3, q: Vec3| {
            let inwards = normal.cross(q - p);
            (inwards, inwards.dot(p))
        };
        Self {
            normal,
            distance: normal.dot(a),
            edges: [edge(a, b), edge(b, c), edge(c, a)],
        }
    }

    fn hit(&self, ray: &Ray) -> Option<f32> {
        let t = (self.distance - self.normal.dot(ray.origin())) / self.normal.dot(ray.direction());
        let point = ray.origin() + ray.direction() * t;
        let inside = |&(inwards, distance): &(Vec3, f32)| inwards.dot(point) >= distance;
        (t >= 0.0 && self.edges.iter().all(inside)).then_some(t)
    }
}

fn corners(mesh: &TriangleMesh) -> impl Iterator<Item = [Vec3; 3]> {
    mesh.triangles.iter().map(|&t| positions(mesh, t))
}

/// Aims rays at a placed mesh; `exact` are its triangles in the world.
fn compared(
    seed: u64,
    effort: Effort,
    mesh: &TriangleMesh,
    place: DAffine3,
    exact: Vec<[DVec3; 3]>,
    naive: impl Fn(&Ray) -> Option<f32>,
) -> Option<Errors> {
    let alone = lone_mesh(mesh.clone());
    let there = Scene {
        objects: vec![Object {
            world_from_object: place,
            ..alone.objects[0].clone()
        }],
        ..alone
    };
    let baked = Baked::<8>::new(&there).ok()?;
    let tracer = Tracer::new(baked.scene(), Simd::detect(), 0);
    let mut workspace = Workspace::new();
    let truth = Truth::new(mesh, exact);
    let (low, high) = mesh.bounds();
    let [low, high] = [low, high].map(|p| Vec3::from(p).as_dvec3());
    let middle = place.transform_point3((low + high) / 2.0);
    let size = (high - low).length();
    let unit = UNIT * middle.abs().max_element();
    largest(seed, effort.of(5_000), |inputs, worst| {
        // Rounded, so that all ways have the same ray.
        let from = single(middle + inputs.direction() * 1.5 * size);
        let target = middle + inputs.in_ball() * 0.5 * size;
        let ray = Ray::new(from, single((target - from.as_dvec3()).normalize()))?;
        let met = truth.met_by(&ray);
        let hit = tracer.nearest(&ray, &mut Budget::UNLIMITED.clone(), &mut workspace);
        worst.ours(met.error(hit.map(|hit| hit.on.t)) / unit);
        worst.naive(met.error(naive(&ray)) / unit);
        Some(())
    })
}

struct Truth {
    triangles: Vec<[DVec3; 3]>,
    edges: Vec<([DVec3; 2], Vec<usize>)>,
}

impl Truth {
    fn new(mesh: &TriangleMesh, triangles: Vec<[DVec3; 3]>) -> Self {
        let mut edges: BTreeMap<[u32; 2], ([DVec3; 2], Vec<usize>)> = BTreeMap::new();
        for (number, (of, at)) in mesh.triangles.iter().zip(&triangles).enumerate() {
            for [i, j] in [[0, 1], [1, 2], [2, 0]] {
                let edge = [of[i].min(of[j]), of[i].max(of[j])];
                let known = edges.entry(edge).or_insert(([at[i], at[j]], Vec::new()));
                known.1.push(number);
            }
        }
        Self {
            triangles,
            edges: edges.into_values().collect(),
        }
    }

    fn met_by(&self, ray: &Ray) -> Met<'_> {
        let (origin, direction) = (ray.origin().as_dvec3(), ray.direction().as_dvec3());
        let planes: Vec<Option<Crossing>> = self
            .triangles
            .iter()
            .map(|&corners| Crossing::new(corners, origin, direction))
            .collect();
        let hits = planes.iter().flatten().filter(|one| one.beside == 0.0);
        let nearest = hits.map(|one| one.t).min_by(f64::total_cmp);
        Met {
            truth: self,
            origin,
            direction,
            planes,
            nearest,
        }
    }
}

struct Crossing {
    t: f64,
    /// The distance from the triangle, metres; 0 for a hit.
    beside: f64,
    /// The sine of the angle to the plane; below 0 where it comes from behind.
    sine: f64,
}

impl Crossing {
    fn new([a, b, c]: [DVec3; 3], origin: DVec3, direction: DVec3) -> Option<Self> {
        let normal = (b - a).cross(c - a).try_normalize()?;
        let sine = -normal.dot(direction) / direction.length();
        let t = normal.dot(a - origin) / normal.dot(direction);
        if !t.is_finite() || t < 0.0 {
            return None;
        }
        let point = origin + direction * t;
        let outside = [[a, b], [b, c], [c, a]].map(|[p, q]| {
            let outwards = (q - p).cross(normal).normalize_or_zero();
            (point - p).dot(outwards)
        });
        let beside = outside.into_iter().fold(0.0, f64::max);
        Some(Self { t, beside, sine })
    }
}

struct Met<'t> {
    truth: &'t Truth,
    origin: DVec3,
    direction: DVec3,
    planes: Vec<Option<Crossing>>,
    nearest: Option<f64>,
}

impl Met<'_> {
    /// Returns the distance by which surfaces or outlines would have to move, metres, for the
    /// nearest hit to be as found.
    fn error(&self, found: Option<f32>) -> f64 {
        let (found, nearest) = match (found.map(f64::from), self.nearest) {
            (None, None) => return 0.0,
            (None, Some(_)) => return self.outline(),
            (Some(found), _) if !found.is_finite() => return f64::INFINITY,
            (Some(found), nearest) => (found, nearest.unwrap_or(f64::INFINITY)),
        };
        // The hit is at or beside a triangle's plane; if that is behind the nearest hit, the ray
        // can only have passed an outline.
        let least = |is_behind: bool| {
            let all = self.planes.iter().flatten();
            all.filter(|one| (one.t > nearest) == is_behind)
                .map(|one| (one.beside).max((found - one.t).abs() * one.sine.abs()))
                .fold(f64::INFINITY, f64::min)
        };
        let (error, behind) = (least(false), least(true));
        if behind < error {
            error.min(behind.max(self.outline()))
        } else {
            error
        }
    }

    /// Returns the distance of the ray's line from the nearest edge between a front and a back
    /// face, metres: the mesh can be missed there and nowhere else.
    fn outline(&self) -> f64 {
        let sines = |of: &[usize]| {
            let faces = |&triangle: &usize| {
                let one = self.planes[triangle].as_ref();
                one.map_or(0.0, |one| one.sine)
            };
            of.iter().map(faces).collect::<Vec<f64>>()
        };
        let mut least = f64::INFINITY;
        for (edge, triangles) in &self.truth.edges {
            let sines = sines(triangles);
            let front = sines.iter().all(|&sine| sine > 0.0);
            let back = sines.iter().all(|&sine| sine < 0.0);
            if sines.len() < 2 || !(front || back) {
                least = least.min(self.distance_to(*edge));
            }
        }
        least
    }

    fn distance_to(&self, [p, q]: [DVec3; 2]) -> f64 {
        let along = self.direction.normalize();
        let across = |v: DVec3| v - along * v.dot(along);
        let (p, edge) = (across(p - self.origin), across(q - p));
        let share = (-p.dot(edge) / edge.length_squared()).clamp(0.0, 1.0);
        let share = if share.is_nan() { 0.0 } else { share };
        (p + edge * share).length()
    }
}

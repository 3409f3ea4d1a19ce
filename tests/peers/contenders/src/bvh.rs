//! `bvh`, which finds the boxes that a ray meets. Triangles in them are tested here, from both
//! sides (Möller and Trumbore 1997), since the crate's own test is for one side only.

use super::library::{Trace, contender};
use bvh::aabb::{Aabb, Bounded};
use bvh::bounding_hierarchy::BHShape;
use bvh::bvh::Bvh;
use bvh::ray::Ray;
use glam::Vec3;
use nalgebra::{Point3, Vector3};
use shisen_peers_interface::{Contender, Hit, Task};

pub(crate) const ITERATOR: Contender = contender::<Tree>(
    c"bvh",
    c"traverse_iterator",
    c"native build, SSE, 4 wide",
    Task::Nearest,
);

struct Triangle {
    corners: [[f32; 3]; 3],
    number: u32,
    node: usize,
}

struct Tree {
    tree: Bvh<f32, 3>,
    triangles: Vec<Triangle>,
}

impl Bounded<f32, 3> for Triangle {
    fn aabb(&self) -> Aabb<f32, 3> {
        let [a, b, c] = self.corners.map(Point3::from);
        Aabb::empty().grow(&a).grow(&b).grow(&c)
    }
}

impl BHShape<f32, 3> for Triangle {
    fn set_bh_node_index(&mut self, index: usize) {
        self.node = index;
    }

    fn bh_node_index(&self) -> usize {
        self.node
    }
}

impl Triangle {
    fn distance(&self, origin: Vec3, direction: Vec3) -> Option<f32> {
        let [a, b, c] = self.corners.map(Vec3::from);
        let (e, f) = (b - a, c - a);
        let p = direction.cross(f);
        let reciprocal = 1.0 / e.dot(p);
        let s = origin - a;
        let u = s.dot(p) * reciprocal;
        let q = s.cross(e);
        let v = direction.dot(q) * reciprocal;
        let t = f.dot(q) * reciprocal;
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t >= 0.0).then_some(t)
    }
}

impl Trace for Tree {
    fn open(corners: &'static [[[f32; 3]; 3]], _: &'static [u8]) -> Option<Self> {
        let mut triangles: Vec<_> = (0..)
            .zip(corners)
            .map(|(number, &corners)| Triangle {
                corners,
                number,
                node: 0,
            })
            .collect();
        let tree = Bvh::build(&mut triangles);
        Some(Self { tree, triangles })
    }

    fn trace(&self, rays: &[[f32; 6]], _: usize, hits: &mut [Hit]) {
        for (&[a, b, c, d, e, f], hit) in rays.iter().zip(hits) {
            *hit = Hit::MISS;
            let (origin, direction) = (Vec3::new(a, b, c), Vec3::new(d, e, f));
            let ray = Ray::new(Point3::new(a, b, c), Vector3::new(d, e, f));
            for triangle in self.tree.traverse_iterator(&ray, &self.triangles) {
                match triangle.distance(origin, direction) {
                    Some(t) if t < hit.t => {
                        *hit = Hit {
                            triangle: triangle.number,
                            t,
                        }
                    }
                    _ => {}
                }
            }
        }
    }
}

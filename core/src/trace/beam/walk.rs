//! The walk through a scene's trees, down to the shapes between a beam's borders.

use super::paper::{Paper, SurfaceId, Surfaces};
use super::samples::Samples;
use super::spheroid::Spheroid;
use super::triangles::{Corners, Triangles};
use super::{Beam, Placed};
use crate::numeric::map3;
use crate::scene::Scene;
use crate::scene::format::{Instance, LEAF, Node, flag, kind};
use crate::simd::{Kernel, Lanes, Runs, Simd};
use crate::trace::leaves::MeshView;
use crate::trace::stack::{TraversalStack, Work};
use crate::trace::walk::leaf_index;
use glam::Vec3;

/// An instance, and the least height over a plane of its parts that cast shadows on it: metres.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SelfShadow {
    pub(crate) instance: u32,
    pub(crate) least: f32,
}

/// Draws all shapes between a beam's borders on paper.
pub(crate) struct Drawing<'d, 'a, const W: usize, P> {
    pub(crate) scene: &'d Scene<'a, W>,
    pub(crate) simd: Simd,
    pub(crate) beam: &'d Beam,
    /// The instance that the shadows fall on, if it may shade itself from another height on.
    pub(crate) own: Option<SelfShadow>,
    /// Rung of the meshes.
    pub(crate) rung: u8,
    pub(crate) samples: &'d Samples,
    pub(crate) surfaces: &'d mut Surfaces,
    pub(crate) paper: &'d mut P,
    pub(crate) stack: &'d mut TraversalStack,
    /// Most steps.
    pub(crate) most: u64,
    pub(crate) work: Work,
}

impl<const W: usize, P: Paper> Kernel<W> for Drawing<'_, '_, W, P>
where
    Simd: Runs<W>,
{
    type Output = Work;

    #[inline(always)]
    fn run<L: Lanes<W>>(mut self, l: L) -> Work {
        let mut top = 0;
        self.push(&mut top, self.scene.header.root);
        let sides = self.beam.sides;
        while top > 0 {
            top -= 1;
            let node = node(self.scene.top, self.stack, top);
            let Some(node) = node.filter(|_| self.step()) else {
                break;
            };
            let mut entered = entered(l, node, &sides);
            while entered != 0 {
                let lane = entered.trailing_zeros() as usize & (W - 1);
                entered &= entered - 1;
                let child = node.child[lane];
                if child & LEAF == 0 {
                    self.push(&mut top, child);
                    continue;
                }
                let number = leaf_index(child);
                let Some(instance) = self.scene.instances.get(number as usize) else {
                    continue;
                };
                if P::IS_SHADOW && instance.flags & flag::OCCLUDES == 0 {
                    continue;
                }
                if !self.step() {
                    break;
                }
                if instance.kind == kind::SPHEROID {
                    self.spheroid(number, instance);
                } else {
                    self.mesh(l, number, instance, top);
                }
            }
        }
        self.work
    }
}

impl<const W: usize, P: Paper> Drawing<'_, '_, W, P>
where
    Simd: Runs<W>,
{
    /// Takes a step; false without any left.
    #[inline(always)]
    fn step(&mut self) -> bool {
        let is_left = self.work.steps < self.most;
        self.work.steps += u64::from(is_left);
        is_left
    }

    #[inline(always)]
    fn push(&mut self, top: &mut usize, node: u32) {
        // The stack of a checked scene is never full.
        if let Some(place) = self.stack.children.get_mut(*top) {
            *place = node;
            *top += 1;
            self.work.deepest = self.work.deepest.max(*top as u32);
        }
    }

    /// Returns the least height of what of an instance casts shadows.
    #[inline(always)]
    fn least(&self, instance: u32) -> f32 {
        match (self.own, &self.beam.plane) {
            (Some(own), Some(_)) if own.instance == instance => own.least,
            (_, Some(plane)) => plane.least,
            (_, None) => 0.0,
        }
    }

    #[inline(always)]
    fn spheroid(&mut self, number: u32, instance: &Instance) {
        let map = &instance.world_from_object;
        let [equatorial, polar] = instance.radii;
        let axes = [
            Vec3::from_array(map[0]) * equatorial,
            Vec3::from_array(map[1]) * polar,
            Vec3::from_array(map[2]) * equatorial,
        ];
        let placed = self.beam.placed(axes, Vec3::from_array(map[3]));
        let used = <Simd as Runs<8>>::run(
            self.simd,
            Spheroid {
                samples: self.samples,
                beam: self.beam,
                placed: &placed,
                instance,
                number: self.surfaces.next(),
                paper: &mut *self.paper,
                surfaces: &*self.surfaces,
                id: SurfaceId {
                    instance: number,
                    triangle: 0,
                    leaf: 0,
                    lane: 0,
                },
            },
        );
        if used {
            self.surfaces.push(SurfaceId {
                instance: number,
                triangle: 0,
                leaf: 0,
                lane: 0,
            });
            if self.surfaces.is_full() {
                self.paper.forget(self.surfaces);
            }
        }
    }

    #[inline(always)]
    fn mesh<L: Lanes<W>>(&mut self, l: L, number: u32, instance: &Instance, base: usize) {
        let Some(mesh) = self.scene.mesh_at(instance.geometry, self.rung) else {
            return;
        };
        let mesh = MeshView::new(self.scene, mesh);
        let [x, y, z, translation] = instance.world_from_object;
        let axes = map3([x, y, z], Vec3::from_array);
        let translation = Vec3::from_array(translation);
        let placed = self.beam.placed(axes, translation);
        let sides = self.beam.sides.map(|(normal, distance)| {
            let inside = Vec3::from_array(axes.map(|axis| axis.dot(normal)));
            (inside, distance + normal.dot(translation))
        });
        let mut top = base;
        self.push(&mut top, mesh.root);
        while top > base {
            top -= 1;
            let node = node(self.scene.nodes, self.stack, top);
            let Some(node) = node.filter(|_| self.step()) else {
                return;
            };
            let mut entered = entered(l, node, &sides);
            while entered != 0 {
                let lane = entered.trailing_zeros() as usize & (W - 1);
                entered &= entered - 1;
                let child = node.child[lane];
                if child & LEAF == 0 {
                    self.push(&mut top, child);
                } else if self.step() {
                    self.leaf(number, &mesh, &placed, leaf_index(child));
                } else {
                    return;
                }
            }
        }
    }

    #[inline(always)]
    fn leaf(&mut self, instance: u32, mesh: &MeshView<'_, W>, placed: &Placed, number: u32) {
        let Some(leaf) = mesh.leaves.leaf(number) else {
            return;
        };
        let mut corners: Corners = [[[0.0; 8]; 3]; 3];
        let mut count = 0;
        if let (8, Some(block)) = (W, mesh.leaves.block(number)) {
            for (corner, from) in corners.iter_mut().zip(&block.corners) {
                for (axis, from) in corner.iter_mut().zip(from) {
                    if let Some(from) = from.first_chunk() {
                        *axis = *from;
                    }
                }
            }
            count = leaf.ids.iter().take_while(|id| **id != u32::MAX).count();
        } else {
            for (lane, _) in leaf
                .ids
                .iter()
                .enumerate()
                .take_while(|(_, id)| **id != u32::MAX)
            {
                let Some(triangle) = leaf.triangle(lane as u32) else {
                    break;
                };
                for (to, from) in corners.iter_mut().zip(triangle.0) {
                    for (axis, from) in to.iter_mut().zip(from.to_array()) {
                        axis[lane & 7] = from;
                    }
                }
                count = lane + 1;
            }
        }
        let id = |lane: usize| SurfaceId {
            instance,
            triangle: leaf.ids[lane & (W - 1)],
            leaf: number,
            lane: lane as u32,
        };
        let mut used = <Simd as Runs<8>>::run(
            self.simd,
            Triangles {
                samples: self.samples,
                placed,
                least: self.least(instance),
                corners: &corners,
                count,
                number: self.surfaces.next(),
                paper: &mut *self.paper,
                surfaces: &*self.surfaces,
                id: &id,
            },
        );
        while used != 0 {
            let lane = used.trailing_zeros() as usize;
            used &= used - 1;
            self.surfaces.push(id(lane));
        }
        if self.surfaces.is_full() {
            self.paper.forget(self.surfaces);
        }
    }
}

#[inline(always)]
fn node<'a, const W: usize>(
    nodes: &'a [Node<W>],
    stack: &TraversalStack,
    top: usize,
) -> Option<&'a Node<W>> {
    nodes.get(*stack.children.get(top)? as usize)
}

/// The children of a node that may lie between all sides.
#[inline(always)]
fn entered<const W: usize, L: Lanes<W>>(l: L, node: &Node<W>, sides: &[(Vec3, f32); 4]) -> u32 {
    let low = map3([0, 1, 2], |axis: usize| l.load(&node.planes[2 * axis]));
    let high = map3([0, 1, 2], |axis: usize| l.load(&node.planes[2 * axis + 1]));
    let mut inside = l.le(low[0], high[0]);
    for &(normal, distance) in sides {
        let [x, y, z] = normal.to_array();
        let x = most(l, x, low[0], high[0]);
        let y = most(l, y, low[1], high[1]);
        let z = most(l, z, low[2], high[2]);
        let distance = l.splat(distance + SLACK * distance.abs());
        let sum = l.add(l.add(x, y), l.add(z, distance));
        inside = l.and(inside, l.le(l.splat(0.0), sum));
    }
    l.bits(inside)
}

/// Share of a side's distance that rounding may take away.
const SLACK: f32 = 1.0e-5;

#[inline(always)]
fn most<const W: usize, L: Lanes<W>>(l: L, factor: f32, low: L::F, high: L::F) -> L::F {
    l.mul(l.splat(factor), if factor < 0.0 { low } else { high })
}

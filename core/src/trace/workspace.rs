//! The memory that tracing works in, and what it hands around.

use super::budget::{Budget, Statistics};
use super::cone::Width;
use super::dispersion::Balance;
use super::media::Media;
use super::stack::{TraversalStack, Work};
use crate::shape::Ray;
use glam::Vec3;
use heapless::Vec;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

/// Most bounces of a ray tree.
pub const MAX_DEPTH: u8 = 16;

/// Most rays that wait: a ray is popped before it pushes at most two children.
const MOST_PENDING: usize = MAX_DEPTH as usize + 2;

/// Linear light and coverage, premultiplied.
#[derive(Debug, Clone, Copy, PartialEq, Default, FromBytes, IntoBytes, Immutable, KnownLayout)]
#[repr(C)]
pub struct Pixel {
    /// Linear red.
    pub red: f32,
    /// Linear green.
    pub green: f32,
    /// Linear blue.
    pub blue: f32,
    /// 0 where only a transparent background is seen, 1 where it is not.
    pub alpha: f32,
}

impl Pixel {
    /// Nothing: black and transparent.
    pub const NONE: Self = Self {
        red: 0.0,
        green: 0.0,
        blue: 0.0,
        alpha: 0.0,
    };

    #[inline(always)]
    pub(crate) fn new(light: Vec3, alpha: f32) -> Self {
        let [red, green, blue] = light.to_array();
        Self {
            red,
            green,
            blue,
            alpha,
        }
    }

    /// `f` of the numbers of two pixels, channel by channel.
    #[inline(always)]
    pub(crate) fn zip(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        Self {
            red: f(self.red, other.red),
            green: f(self.green, other.green),
            blue: f(self.blue, other.blue),
            alpha: f(self.alpha, other.alpha),
        }
    }
}

/// The memory that tracing needs: the caller's, 2 KiB, used for one ray
/// after another.
#[derive(Debug, Clone, Default)]
pub struct Workspace {
    pub(crate) stack: TraversalStack,
    pub(super) pending: Vec<Pending, MOST_PENDING>,
    /// Colour balance of the last sample, until its pixel takes it.
    pub(crate) balance: Balance,
    /// Counts of the work done with this workspace; the caller clears them.
    pub statistics: Statistics,
}

impl Workspace {
    /// Returns a workspace whose counts are zero.
    pub const fn new() -> Self {
        Self {
            stack: TraversalStack::EMPTY,
            pending: Vec::new(),
            balance: Balance::NONE,
            statistics: Statistics {
                primary: 0,
                lit: 0,
                leaves: 0,
                reflected: 0,
                refracted: 0,
                shadow: 0,
                steps: 0,
                deepest_stack: 0,
            },
        }
    }

    /// Adds a ray to the tree, if there is one. Returns false without a ray or without room.
    pub(super) fn push(&mut self, next: Option<Pending>) -> bool {
        next.is_some_and(|next| self.pending.push(next).is_ok())
    }

    pub(crate) fn account(&mut self, work: Work, budget: &mut Budget) {
        self.statistics.steps += work.steps;
        self.statistics.deepest_stack = self.statistics.deepest_stack.max(work.deepest);
        budget.spend(work.steps);
    }
}

/// The detail of a primary ray and of the rays that follow from it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RayDetail {
    /// Most reflections and refractions in a row.
    pub depth: u8,
    /// The rung of each mesh's ladder of polygon levels, the finest being 0.
    /// A mesh without such a rung is traced as it is.
    pub rung: u8,
    /// Wavelengths that dispersive media distinguish; 1 for no dispersion.
    pub wavelengths: u8,
    /// Width of a primary ray after a unit of its direction: metres.
    pub spread: Width,
}

/// A ray of the tree that is still to be traced.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pending {
    pub(super) ray: Ray,
    /// Weight of its light in the pixel.
    pub(super) weight: Vec3,
    /// Share of the pixel's coverage that a transparent background behind it removes.
    pub(super) uncovered: f32,
    pub(super) bounces: u8,
    /// The effect that sent it, by its bit's number.
    pub(super) cause: u8,
    /// The clear bodies that it starts in.
    pub(super) media: Media,
    /// Its width where it starts.
    pub(super) width: Width,
    /// Whether glass reflects it with a sample's wavelengths.
    pub(super) is_tinted: bool,
}

impl Pending {
    pub(super) const fn primary(ray: &Ray) -> Self {
        Self {
            ray: *ray,
            weight: Vec3::ONE,
            uncovered: 1.0,
            bounces: 0,
            cause: 0,
            media: Media::NONE,
            width: Width::ZERO,
            is_tinted: false,
        }
    }
}

const _: () = assert!(size_of::<Workspace>() <= 2 * 1024 + 128);

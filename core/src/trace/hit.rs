/// A ray's hit on a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshHit {
    /// Distance in units of the ray's direction, 0 or more.
    pub t: f32,
    /// The triangle, in the mesh's order.
    pub triangle: u32,
    /// Index of the triangle's leaf block.
    pub(crate) leaf: u32,
    /// Lane of the triangle in its leaf block.
    pub(crate) lane: u32,
}

impl MeshHit {
    /// No hit: farther than any.
    pub(crate) const NONE: Self = Self {
        t: f32::INFINITY,
        triangle: u32::MAX,
        leaf: u32::MAX,
        lane: 0,
    };

    /// Takes `other` if it is nearer, or equally near with a lower number.
    #[inline(always)]
    pub(crate) fn take_nearer(&mut self, other: Self) {
        if other.t < self.t || (other.t == self.t && other.triangle < self.triangle) {
            *self = other;
        }
    }
}

/// A ray's nearest hit in the scene. Among equally near hits, the one of the lowest instance
/// counts, then of the lowest triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Number of the instance.
    pub instance: u32,
    /// Distance and triangle; shapes other than meshes have triangle 0 where the
    /// ray enters and 1 where it leaves.
    pub on: MeshHit,
}

impl Hit {
    pub(crate) const NONE: Self = Self {
        instance: u32::MAX,
        on: MeshHit::NONE,
    };
}

/// The goal of a search.
pub(super) trait Goal: Copy {
    /// Returns whether any hit ends the search, not only the nearest.
    fn is_any(self) -> bool;
}

/// The nearest hit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Nearest;

impl Goal for Nearest {
    #[inline(always)]
    fn is_any(self) -> bool {
        false
    }
}

/// Any hit, for shadows.
#[derive(Debug, Clone, Copy)]
pub(super) struct Any;

impl Goal for Any {
    #[inline(always)]
    fn is_any(self) -> bool {
        true
    }
}

/// A goal chosen at run time, any hit if true: one compiled walk serves both goals.
impl Goal for bool {
    #[inline(always)]
    fn is_any(self) -> bool {
        self
    }
}

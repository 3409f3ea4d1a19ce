/// Where a ray meets a mesh.
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

    /// Takes `other` where it is nearer, or as near with a lower number.
    #[inline(always)]
    pub(crate) fn take_nearer(&mut self, other: Self) {
        if other.t < self.t || (other.t == self.t && other.triangle < self.triangle) {
            *self = other;
        }
    }
}

/// Where a ray meets the scene: the nearest point; among equally near points that of the
/// lowest instance, then of the lowest triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Number of the instance.
    pub instance: u32,
    /// Distance, and the triangle; for other shapes than meshes 0 on the way
    /// in and 1 on the way out.
    pub on: MeshHit,
}

impl Hit {
    pub(crate) const NONE: Self = Self {
        instance: u32::MAX,
        on: MeshHit::NONE,
    };
}

/// What a search looks for.
pub(super) trait Goal: Copy {
    /// Whether any hit ends the search, not only the nearest.
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

/// Whether it is any hit, at run time: one compiled walk for both goals.
impl Goal for bool {
    #[inline(always)]
    fn is_any(self) -> bool {
        self
    }
}

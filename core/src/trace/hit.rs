/// Where a ray meets a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshHit {
    /// Distance in units of the ray's direction, 0 or more.
    pub t: f32,
    /// The triangle, in the mesh's order.
    pub triangle: u32,
    /// Its leaf block.
    pub(crate) leaf: u32,
    /// Its lane there.
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

/// Where a ray meets the scene: the nearest point, and of equally near ones
/// that with the lowest instance, then the lowest triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// The instance.
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

/// Which hit a search is for.
pub(super) trait Sought: Copy {
    /// Whether any will do, and not only the nearest.
    fn is_any(self) -> bool;
}

/// The nearest.
#[derive(Debug, Clone, Copy)]
pub(super) struct Nearest;

impl Sought for Nearest {
    #[inline(always)]
    fn is_any(self) -> bool {
        false
    }
}

/// Any, as for shadows.
#[derive(Debug, Clone, Copy)]
pub(super) struct Any;

impl Sought for Any {
    #[inline(always)]
    fn is_any(self) -> bool {
        true
    }
}

/// What is said when the search begins: for both, one walk in the program.
#[derive(Debug, Clone, Copy)]
pub(super) struct AsTold {
    pub(super) is_any: bool,
}

impl Sought for AsTold {
    #[inline(always)]
    fn is_any(self) -> bool {
        self.is_any
    }
}

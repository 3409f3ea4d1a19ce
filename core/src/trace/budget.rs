/// Work that may still be done, in steps: one a node visited, one a
/// primitive tested. Time is the caller's to translate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Budget {
    left: u64,
}

impl Budget {
    /// So much that no frame spends it.
    pub const UNLIMITED: Self = Self { left: u64::MAX };

    /// This many steps.
    pub const fn steps(steps: u64) -> Self {
        Self { left: steps }
    }

    /// Steps that may still be done.
    pub const fn left(&self) -> u64 {
        self.left
    }

    /// Whether nothing is left.
    pub const fn is_spent(&self) -> bool {
        self.left == 0
    }

    /// Takes steps off; what is not there is not owed.
    pub(crate) const fn spend(&mut self, steps: u64) {
        self.left = self.left.saturating_sub(steps);
    }
}

/// What has been done since this was last cleared.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Statistics {
    /// Rays from the eye.
    pub primary: u64,
    /// Rays off mirrors and off glass.
    pub reflected: u64,
    /// Rays into and out of glass.
    pub refracted: u64,
    /// Rays to lights.
    pub shadow: u64,
    /// Nodes visited and primitives tested.
    pub steps: u64,
    /// Most entries of the traversal stack in use.
    pub deepest_stack: u32,
}

impl Statistics {
    /// Takes another part of the same frame in. In any order: sums and a
    /// maximum.
    pub const fn add(&mut self, other: &Self) {
        self.primary += other.primary;
        self.reflected += other.reflected;
        self.refracted += other.refracted;
        self.shadow += other.shadow;
        self.steps += other.steps;
        if other.deepest_stack > self.deepest_stack {
            self.deepest_stack = other.deepest_stack;
        }
    }

    /// All rays.
    pub const fn rays(&self) -> u64 {
        self.primary + self.reflected + self.refracted + self.shadow
    }
}

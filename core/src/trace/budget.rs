/// Limit of the work to do, in steps: one per node visited or primitive tested. The caller
/// translates steps to time.
///
/// No sample of a pixel is begun on a spent budget. A sample, or a square of samples that are
/// apart, that was begun before is finished, with as many steps as that takes, or at most the
/// [overrun](Self::with_overrun). A search that was broken off returns what it had found so
/// far: callers must check whether the budget [is exhausted](Self::is_exhausted).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Budget {
    left: u64,
    /// Steps left including the overrun, or [`ENDLESS`]. At least `left`.
    most: u64,
}

/// The overrun of a budget without a limit for what has been begun.
const ENDLESS: u64 = u64::MAX;

impl Budget {
    /// A budget that no frame spends.
    pub const UNLIMITED: Self = Self {
        left: u64::MAX,
        most: ENDLESS,
    };

    /// Returns a budget of this many steps, and as many more as it takes to finish the last sample.
    pub const fn steps(steps: u64) -> Self {
        Self {
            left: steps,
            most: ENDLESS,
        }
    }

    /// Returns the same budget with at most `overrun` steps above it. A sample that needs more is
    /// broken off and its steps are lost; to finish it, give a budget of at least one step
    /// more than it takes.
    #[must_use]
    pub const fn with_overrun(self, overrun: u64) -> Self {
        Self {
            left: self.left,
            most: self.left.saturating_add(overrun),
        }
    }

    /// Returns the lesser of two budgets.
    #[must_use]
    pub(crate) fn within(self, other: Self) -> Self {
        Self {
            left: self.left.min(other.left),
            most: self.most.min(other.most),
        }
    }

    /// Returns steps left.
    pub const fn left(&self) -> u64 {
        self.left
    }

    /// Returns whether nothing is left.
    pub const fn is_spent(&self) -> bool {
        self.left == 0
    }

    /// Returns whether the overrun is used up too: the current sample may be incomplete.
    pub const fn is_exhausted(&self) -> bool {
        self.most == 0
    }

    /// Returns steps left for the current sample, overrun included.
    pub(crate) const fn most(&self) -> u64 {
        self.most
    }

    /// Subtracts steps, down to 0.
    pub(crate) const fn spend(&mut self, steps: u64) {
        self.left = self.left.saturating_sub(steps);
        if self.most != ENDLESS {
            self.most = self.most.saturating_sub(steps);
        }
    }
}

/// Counts of the work done since they were last cleared.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Statistics {
    /// Rays from the eye.
    pub primary: u64,
    /// Points that such rays see, whose light was computed.
    pub lit: u64,
    /// Parts of a picture with a colour of their own, where their size follows the gaze: pixels,
    /// or squares of them.
    pub leaves: u64,
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
    /// Adds the counts of another part of the same frame, in any order.
    pub const fn add(&mut self, other: &Self) {
        self.primary += other.primary;
        self.lit += other.lit;
        self.leaves += other.leaves;
        self.reflected += other.reflected;
        self.refracted += other.refracted;
        self.shadow += other.shadow;
        self.steps += other.steps;
        if other.deepest_stack > self.deepest_stack {
            self.deepest_stack = other.deepest_stack;
        }
    }

    /// Number of all rays.
    pub const fn rays(&self) -> u64 {
        self.primary + self.reflected + self.refracted + self.shadow
    }
}

/// Work that may still be done, in steps: one a node visited, one a
/// primitive tested. Time is the caller's to translate.
///
/// Nothing is begun where a budget is spent. What has been begun by then goes on to its
/// end, a pixel or a square of them, and takes a little more: as much as it takes, or,
/// [with an overrun](Self::with_overrun), that many steps and never one more. What a
/// search says that was broken off is what it had come to: whoever asks has to look whether
/// the budget [is exhausted](Self::is_exhausted).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Budget {
    left: u64,
    /// All that may be done, whatever has been begun, or [`ENDLESS`]. Not less than `left`.
    most: u64,
}

/// What has been begun takes what it takes.
const ENDLESS: u64 = u64::MAX;

impl Budget {
    /// So much that no frame spends it.
    pub const UNLIMITED: Self = Self {
        left: u64::MAX,
        most: ENDLESS,
    };

    /// This many steps, and what it takes to end what has been begun with them.
    pub const fn steps(steps: u64) -> Self {
        Self {
            left: steps,
            most: ENDLESS,
        }
    }

    /// The same, with which at most `overrun` steps are taken above it. What that does
    /// not suffice for is broken off in the middle, and not finished: to finish it takes a
    /// budget with at least a step more than it takes. Steps that it did take are gone.
    #[must_use]
    pub const fn with_overrun(self, overrun: u64) -> Self {
        Self {
            left: self.left,
            most: self.left.saturating_add(overrun),
        }
    }

    /// What both of two budgets allow.
    #[must_use]
    pub(crate) fn within(self, other: Self) -> Self {
        Self {
            left: self.left.min(other.left),
            most: self.most.min(other.most),
        }
    }

    /// Steps that may still be done.
    pub const fn left(&self) -> u64 {
        self.left
    }

    /// Whether nothing is left.
    pub const fn is_spent(&self) -> bool {
        self.left == 0
    }

    /// Whether nothing is left for what has been begun either: it may be broken off.
    pub const fn is_exhausted(&self) -> bool {
        self.most == 0
    }

    /// Whether what has been begun takes what it takes.
    pub(crate) const fn is_endless(&self) -> bool {
        self.most == ENDLESS
    }

    /// Steps that may still be done to end what has been begun.
    pub(crate) const fn most(&self) -> u64 {
        self.most
    }

    /// Takes steps off; what is not there is not owed.
    pub(crate) const fn spend(&mut self, steps: u64) {
        self.left = self.left.saturating_sub(steps);
        if !self.is_endless() {
            self.most = self.most.saturating_sub(steps);
        }
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

//! Clear bodies within one another: which of them a ray is in (Schmidt & Budge 2002, "Simple Nested
//! Dielectrics in Ray Traced Images").

use crate::scene::format::Material;

/// Most bodies that a ray can be in; further ones are as if they were not there. A fifth of one
/// material is left where the fourth would be.
const MOST: usize = 4;

/// The clear bodies that a ray is in, in the order in which it has entered them: the numbers of
/// their materials, and 1; 0 behind the last.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Media([u8; MOST]);

/// What is on both sides of a border: the numbers of materials, `None` for the surroundings.
#[derive(Debug, Clone, Copy)]
pub(super) struct Border {
    pub(super) before: Option<u8>,
    pub(super) beyond: Option<u8>,
    /// The bodies that a ray is in beyond.
    pub(super) after: Media,
}

impl Media {
    /// The surroundings alone.
    pub(super) const NONE: Self = Self([0; MOST]);

    /// Returns the body that fills a place: the last of those with the highest priority.
    pub(super) fn top(self, materials: &[Material]) -> Option<u8> {
        let mut top = None;
        let mut highest = 0;
        for number in self.0 {
            let Some(number) = number.checked_sub(1) else {
                break;
            };
            let material = materials.get(usize::from(number));
            let priority = material.map_or(0, |material| material.priority);
            if priority >= highest {
                (top, highest) = (Some(number), priority);
            }
        }
        top
    }

    /// Returns what is on both sides of the border of a body that a ray leaves or enters.
    pub(super) fn border(self, body: u8, leaves: bool, materials: &[Material]) -> Border {
        let (inner, outer) = if leaves {
            // A ray that starts in a body has not entered it.
            let inner = if self.has(body) { self } else { self.and(body) };
            (inner, inner.without(body))
        } else {
            (self.and(body), self)
        };
        let [within, around] = [inner, outer].map(|media| media.top(materials));
        if leaves {
            Border {
                before: within,
                beyond: around,
                after: outer,
            }
        } else {
            Border {
                before: around,
                beyond: within,
                after: inner,
            }
        }
    }

    fn has(self, body: u8) -> bool {
        self.0.contains(&body.saturating_add(1))
    }

    fn and(mut self, body: u8) -> Self {
        if let Some(free) = self.0.iter_mut().find(|number| **number == 0) {
            *free = body.saturating_add(1);
        }
        self
    }

    fn without(self, body: u8) -> Self {
        let mut left = Self::NONE;
        let mut is_there = true;
        for number in self.0.into_iter().filter(|number| *number != 0) {
            if is_there && number == body.saturating_add(1) {
                is_there = false;
            } else {
                left = left.and(number - 1);
            }
        }
        left
    }
}

//! What of a file is not shown.

use std::fmt;

/// Kinds of things that a file has and no picture shows, with how often: in the order of first
/// meeting.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Unused {
    kinds: Vec<(String, u64)>,
    /// Kinds beyond [`Self::MOST`].
    further: u64,
}

impl Unused {
    /// Most kinds that are named.
    const MOST: usize = 24;

    /// Counts things of a kind. Its name has `{s}` where the plural has an s; without it, the name
    /// is of one thing, and no count is told.
    pub fn add(&mut self, kind: impl Into<String>, count: u64) {
        let kind = kind.into();
        if count == 0 {
            return;
        }
        if let Some((_, known)) = self.kinds.iter_mut().find(|(name, _)| *name == kind) {
            *known += count;
        } else if self.kinds.len() < Self::MOST {
            self.kinds.push((kind, count));
        } else {
            self.further += 1;
        }
    }

    /// Returns whether all of the file is shown.
    pub const fn is_empty(&self) -> bool {
        self.kinds.is_empty()
    }

    /// Returns each kind in words: "2 animations".
    pub fn names(&self) -> Vec<String> {
        let named = self.kinds.iter().map(|(kind, count)| {
            if !kind.contains("{s}") {
                return kind.clone();
            }
            let ending = if *count == 1 { "" } else { "s" };
            format!("{count} {}", kind.replace("{s}", ending))
        });
        let further = (self.further > 0).then(|| format!("and {} more", self.further));
        named.chain(further).collect()
    }
}

impl fmt::Display for Unused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.names().join(", "))
    }
}

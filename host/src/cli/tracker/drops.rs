//! Dropped bytes, in words.

use crate::tracker::Trouble;
use shisen_tracker::decoder::{Counts, DropReason};
use std::collections::BTreeMap;
use std::fmt;

/// Drops of bytes by reason, without reasons that did not occur.
pub(super) fn by_reason(counts: &Counts) -> BTreeMap<&'static str, u32> {
    let all = DropReason::ALL.into_iter();
    let all = all.map(|reason| (reason.name(), counts.dropped_for(reason)));
    all.filter(|&(_, count)| count > 0).collect()
}

/// Words such as ` (3 truncated, 1 out of step)`; nothing without drops.
pub(super) struct ByReason<'a>(pub(super) &'a BTreeMap<&'static str, u32>);

impl fmt::Display for ByReason<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, (reason, count)) in self.0.iter().enumerate() {
            let before = if i == 0 { " (" } else { ", " };
            write!(f, "{before}{count} {reason}")?;
        }
        f.write_str(if self.0.is_empty() { "" } else { ")" })
    }
}

/// Words what is wrong, and why bytes were dropped so far.
pub(super) fn with_drops(trouble: &Trouble, counts: &Counts) -> String {
    let reasons = by_reason(counts);
    if reasons.is_empty() {
        return trouble.to_string();
    }
    format!("{trouble}; dropped so far:{}", ByReason(&reasons))
}

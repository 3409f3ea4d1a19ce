//! Dropped bytes, in words.

use crate::tracker::Trouble;
use shisen_tracker::decoder::{Counts, DropReason};
use std::collections::BTreeMap;

/// Drops of bytes by reason, without reasons that did not occur.
pub(super) fn by_reason(counts: &Counts) -> BTreeMap<&'static str, u32> {
    let all = DropReason::ALL.into_iter();
    let all = all.map(|reason| (reason.name(), counts.dropped_for(reason)));
    all.filter(|&(_, count)| count > 0).collect()
}

/// Returns words such as ` (3 truncated, 1 out of step)`; nothing without drops.
pub(super) fn in_words(reasons: &BTreeMap<&'static str, u32>) -> String {
    let all = reasons
        .iter()
        .map(|(reason, count)| format!("{count} {reason}"));
    match all.collect::<Vec<_>>().join(", ") {
        words if words.is_empty() => words,
        words => format!(" ({words})"),
    }
}

/// Puts into words what is wrong, and why bytes were dropped so far.
pub(super) fn with_drops(trouble: &Trouble, counts: &Counts) -> String {
    match in_words(&by_reason(counts)) {
        words if words.is_empty() => trouble.to_string(),
        words => format!("{trouble}; dropped so far:{words}"),
    }
}

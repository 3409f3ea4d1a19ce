//! What the system takes from the process, which may make frames late.

use crate::cli::prelude::*;
use std::fs;

/// What was taken from this process; `None` if the system does not say.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Interference {
    /// How often the system took the processor away from a thread; null if unknown.
    pub involuntary_switches: Option<u64>,
    /// Processor time that the hypervisor took, seconds; null if unknown.
    pub stolen_seconds: Option<f64>,
}

impl Interference {
    /// Counts for all present threads since they began, and for the machine since it started.
    pub fn so_far() -> Self {
        Self {
            involuntary_switches: involuntary_switches(),
            stolen_seconds: stolen_seconds(),
        }
    }

    /// Returns the difference from an earlier count.
    #[must_use]
    pub fn since(&self, before: &Self) -> Self {
        let switches = self.involuntary_switches.zip(before.involuntary_switches);
        let stolen = self.stolen_seconds.zip(before.stolen_seconds);
        Self {
            involuntary_switches: switches.map(|(now, then)| now.saturating_sub(then)),
            stolen_seconds: stolen.map(|(now, then)| now - then),
        }
    }
}

fn involuntary_switches() -> Option<u64> {
    let mut all = 0;
    for task in fs::read_dir("/proc/self/task").ok()? {
        // The thread may have ended.
        let Ok(status) = fs::read_to_string(task.ok()?.path().join("status")) else {
            continue;
        };
        let mut lines = status.lines();
        let count = lines.find_map(|line| line.strip_prefix("nonvoluntary_ctxt_switches:"));
        all += count?.trim().parse::<u64>().ok()?;
    }
    Some(all)
}

fn stolen_seconds() -> Option<f64> {
    let all = fs::read_to_string("/proc/stat").ok()?;
    let stolen = all.lines().next()?.split_whitespace().nth(8)?;
    // Linux counts in hundredths of a second here.
    Some(stolen.parse::<f64>().ok()? * 1.0e-2)
}

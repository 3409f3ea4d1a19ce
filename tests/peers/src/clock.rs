//! Processor time, which other programs do not lengthen.

use rustix::time::{ClockId, clock_gettime};
use shisen::live::quantiles::median;

/// Returns seconds that this process's threads have run.
pub fn cpu_seconds() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + 1.0e-9 * time.tv_nsec as f64
}

/// Processor seconds of all child processes that have ended.
#[allow(unsafe_code)]
pub fn children_seconds() -> f64 {
    // SAFETY: zeros are a valid value, and the call fills it in.
    let usage = unsafe {
        let mut usage: libc::rusage = std::mem::zeroed();
        libc::getrusage(libc::RUSAGE_CHILDREN, &raw mut usage);
        usage
    };
    let seconds = |time: libc::timeval| time.tv_sec as f64 + 1.0e-6 * time.tv_usec as f64;
    seconds(usage.ru_utime) + seconds(usage.ru_stime)
}

/// Returns the seconds that a call adds to a clock.
pub fn by(clock: fn() -> f64, run: impl FnOnce()) -> f64 {
    let start = clock();
    run();
    clock() - start
}

/// Returns the median of the processor seconds of several runs.
pub fn cpu_median(rounds: usize, mut run: impl FnMut()) -> f64 {
    median((0..rounds).map(|_| by(cpu_seconds, &mut run)).collect())
}

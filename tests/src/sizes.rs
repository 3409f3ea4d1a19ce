//! How large a test is made.

/// Returns the number of cases of a test: `quick`, or `heavy` where `SHISEN_HEAVY`
/// is set to 1. Prints which.
pub fn cases(what: &str, quick: usize, heavy: usize) -> usize {
    let full = std::env::var_os("SHISEN_HEAVY").is_some_and(|value| value == "1");
    let count = if full { heavy } else { quick };
    println!("{what}: {count} ({})", if full { "heavy" } else { "quick" });
    count
}

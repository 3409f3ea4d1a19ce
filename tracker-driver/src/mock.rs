//! A simulated viewer behind a simulated tracker.

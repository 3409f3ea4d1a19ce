//! The `shisen` command.
fn main() {}

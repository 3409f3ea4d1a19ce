//! Evidence: whether Shisen is right, how fast it is, and what accuracy costs in time.
//!
//! ```sh
//! cargo run --release -p shisen-evidence -- bench table2
//! cargo run --release -p shisen-evidence -- selftest
//! cargo run --release -p shisen-evidence -- tradeoff --quick --out report
//! ```

#[doc(hidden)]
pub mod cli;
pub mod measure;
mod quartz;
pub mod selftest;
pub mod table;
mod textbook;
pub mod tradeoff;
pub mod walker;

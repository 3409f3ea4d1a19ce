//! A command as the crate that has it, built with the tests.

fn main() -> std::process::ExitCode {
    shisen::cli::main()
}

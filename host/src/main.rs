//! The `shisen` command.

fn main() -> std::process::ExitCode {
    shisen::cli::main()
}

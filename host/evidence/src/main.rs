//! The `shisen-evidence` command.

fn main() -> std::process::ExitCode {
    shisen_evidence::cli::main()
}

//! `shisen completions`: scripts that shells complete command lines by.
#![cfg(unix)]

use shisen_tests::command::{folder, run};
use std::process::Command;

#[test]
fn bash_completes_commands_arguments_and_values() {
    let folder = folder();
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = run(folder.path(), &format!("completions {shell}")).out;
        assert!(script.contains("nearfield"), "{shell}");
        std::fs::write(folder.path().join(shell), script).unwrap();
    }
    for (words, expected) in [
        ("shisen do", "dome"),
        ("shisen dome near", "nearfield"),
        ("shisen cave --lod pa", "paper paper-ellipse"),
        ("shisen run --cl", "--cluster"),
    ] {
        let line = format!(
            "source ./bash; COMP_WORDS=({words}); COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1)); \
             _shisen shisen \"${{COMP_WORDS[-1]}}\" \"${{COMP_WORDS[-2]}}\"; echo \"${{COMPREPLY[@]}}\""
        );
        let mut bash = Command::new("bash");
        let bash = bash
            .current_dir(folder.path())
            .args(["--norc", "-c", &line]);
        let output = bash.output().unwrap();
        assert!(output.stderr.is_empty(), "{output:?}");
        assert_eq!(
            String::from_utf8(output.stdout).unwrap().trim(),
            expected,
            "{words}"
        );
    }
}

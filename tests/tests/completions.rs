//! `shisen completions`: scripts that shells complete command lines by.

use shisen_tests::command::shisen;
#[cfg(unix)]
use std::process::Command;

fn script(shell: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let assert = shisen(folder.path())
        .args(["completions", shell])
        .assert()
        .success();
    let output = assert.get_output();
    assert!(output.stderr.is_empty(), "{shell}");
    String::from_utf8(output.stdout.clone()).unwrap()
}

#[test]
fn every_shell_has_one() {
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = script(shell);
        for word in ["shisen", "cave", "nearfield", "completions"] {
            assert!(script.contains(word), "{shell}: {word}");
        }
    }
}

/// What bash offers for the last of some words.
#[cfg(unix)]
fn offered(words: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("shisen.bash"), script("bash")).unwrap();
    let line = format!(
        "source ./shisen.bash; COMP_WORDS=({words}); COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1)); \
         _shisen shisen \"${{COMP_WORDS[-1]}}\" \"${{COMP_WORDS[-2]}}\"; echo \"${{COMPREPLY[@]}}\""
    );
    let output = Command::new("bash")
        .current_dir(folder.path())
        .args(["--norc", "-c", &line])
        .output()
        .unwrap();
    assert!(output.stderr.is_empty(), "{output:?}");
    String::from_utf8(output.stdout).unwrap().trim().to_owned()
}

#[cfg(unix)]
#[test]
fn bash_completes_commands_arguments_and_values() {
    assert_eq!(offered("shisen do"), "dome");
    assert_eq!(offered("shisen dome near"), "nearfield");
    assert_eq!(offered("shisen cave --lod pa"), "paper paper-ellipse");
    assert_eq!(offered("shisen run --cl"), "--cluster");
}

#[test]
fn a_shell_that_there_is_not_is_a_wrong_command_line() {
    let folder = tempfile::tempdir().unwrap();
    let assert = shisen(folder.path())
        .args(["completions", "tcsh"])
        .assert()
        .code(2);
    let said = String::from_utf8(assert.get_output().stderr.clone()).unwrap();
    assert!(said.contains("bash") && said.contains("zsh"), "{said}");
}

//! What each command's help ends with: lines to try.

use super::program::Examples;

/// Examples of every command, and of every group of commands.
pub(super) const EXAMPLES: Examples = &[
    (
        "",
        &[
            (
                "Three walls of a CAVE for two eyes, into the folder shisen-out",
                "shisen cave",
            ),
            (
                "A simulated viewer in a window, each frame in its time",
                "shisen run --view window --seconds 30",
            ),
            (
                "What is plugged in to follow a viewer by",
                "shisen tracker list",
            ),
        ],
    ),
    (
        "cave",
        &[
            (
                "Three walls for two eyes, into the folder frame",
                "shisen cave --out frame",
            ),
            (
                "A mesh of your own as in scene B, the viewer 0.5 m back",
                "shisen cave --scene B --mesh cow.obj --head 0,0,0.5",
            ),
            (
                "Detail where the viewer looks, on the floor",
                "shisen cave --lod paper --look floor",
            ),
        ],
    ),
    (
        "run",
        &[
            (
                "A simulated viewer in a window, at 60 frames a second",
                "shisen run --view window --seconds 30",
            ),
            (
                "A tracker on a line; each frame 8 ms at most; what each was into a file",
                "shisen run --tracker 'serial:/dev/ttyUSB0?protocol=fastrak' --budget 8ms \
                 --record frames.jsonl",
            ),
        ],
    ),
    (
        "bake",
        &[
            (
                "A scene with eight polygon levels, down to 100 faces a mesh",
                "shisen bake lawn.toml --faces 100.. --levels 8 -o lawn.shisen",
            ),
            (
                "For microcontrollers",
                "shisen bake A --layout compact -o a.shisen",
            ),
        ],
    ),
    (
        "inspect",
        &[("What is in a baked scene", "shisen inspect lawn.shisen")],
    ),
    (
        "explain",
        &[
            (
                "What scene A asks for, and what each effect costs",
                "shisen explain A",
            ),
            (
                "The same of a description, with detail that follows the gaze",
                "shisen explain lawn.toml --lod paper",
            ),
        ],
    ),
    (
        "gaze",
        &[(
            "Of directions, three numbers a line: level, bounces and faces",
            "shisen gaze --look 0,0,-1 --faces 500..5804 < directions.txt",
        )],
    ),
    (
        "medium",
        &[(
            "How a prism of SF11 bends three colours",
            "shisen medium sf11 --wavelength 400 550 700 --prism 60",
        )],
    ),
    (
        "spectrum",
        &[(
            "Which wavelengths seven rays take, and what each counts for",
            "shisen spectrum --wavelengths 7 --method comb",
        )],
    ),
    (
        "dome",
        &[
            (
                "The best mirror for a camera close to it",
                "shisen dome design --projection perspective",
            ),
            (
                "A dome master of scene A through it",
                "shisen dome render --config best --mapping exact --size 2048",
            ),
        ],
    ),
    (
        "dome design",
        &[
            (
                "The best mirror for a camera close to it",
                "shisen dome design --projection perspective",
            ),
            (
                "What one of the paper's comes to",
                "shisen dome design --config paper-3",
            ),
        ],
    ),
    (
        "dome curve",
        &[(
            "The error of mirrors by their axis ratio, as charts",
            "shisen dome curve --out curves",
        )],
    ),
    (
        "dome map",
        &[(
            "Which direction each ring of a picture shows",
            "shisen dome map --config paper-3 --step 5",
        )],
    ),
    (
        "dome nearfield",
        &[(
            "By how much surroundings at 2 and 20 radii are displaced",
            "shisen dome nearfield --config best --distance 2,20",
        )],
    ),
    (
        "dome render",
        &[
            (
                "A dome master of scene A through the best mirror",
                "shisen dome render --config best --mapping exact --size 2048",
            ),
            (
                "A true one of a scene of your own, leaning 30° to the front",
                "shisen dome render --scene lawn.toml --mapping true --tilt 30",
            ),
        ],
    ),
    (
        "dome compare",
        &[(
            "Through a mirror beside a true one, of a grid ten radii away",
            "shisen dome compare --distance 10 --config best",
        )],
    ),
    (
        "dome warp",
        &[(
            "What a projector has to show, as a mesh",
            "shisen dome warp --walls hall.toml --projector back.toml --format bourke -o back.data",
        )],
    ),
    (
        "tracker",
        &[
            ("What is plugged in", "shisen tracker list"),
            (
                "What it says",
                "shisen tracker monitor 'serial:/dev/ttyUSB0?protocol=fastrak'",
            ),
            (
                "A simulated one that others can read",
                "shisen tracker mock --as fastrak --pty /tmp/tracker",
            ),
        ],
    ),
    (
        "tracker list",
        &[("What is plugged in", "shisen tracker list")],
    ),
    (
        "tracker monitor",
        &[
            (
                "A simulated tracker, for 120 frames",
                "shisen tracker monitor mock:seed=7 --frames 120",
            ),
            (
                "A device on a serial line that is set up otherwise than usual",
                "shisen tracker monitor 'serial:/dev/ttyUSB0?protocol=fastrak&units=cm'",
            ),
        ],
    ),
    (
        "tracker record",
        &[(
            "Half a minute of a HID eye tracker",
            "shisen tracker record hid:usage=0012 eyes.csv --seconds 30",
        )],
    ),
    (
        "tracker calibrate",
        &[(
            "Directions from an ISCAN's camera, by targets whose places are known",
            "shisen tracker calibrate 'serial:/dev/ttyUSB0?protocol=iscan' eye.toml \
             --targets four.csv",
        )],
    ),
    (
        "tracker mock",
        &[(
            "A FASTRAK that others can read",
            "shisen tracker mock --as fastrak --pty /tmp/tracker",
        )],
    ),
    (
        "tracker replay",
        &[(
            "A recording as the device said it",
            "shisen tracker replay eyes.csv --to /tmp/tracker --as fastrak",
        )],
    ),
    (
        "completions",
        &[
            (
                "For bash, from the next shell on",
                "shisen completions bash > ~/.local/share/bash-completion/completions/shisen",
            ),
            (
                "For zsh, where fpath has ~/.zfunc",
                "shisen completions zsh > ~/.zfunc/_shisen",
            ),
            (
                "For fish",
                "shisen completions fish > ~/.config/fish/completions/shisen.fish",
            ),
        ],
    ),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::Shisen;
    use crate::cli::program::{read, with_examples};
    use clap::{Command, CommandFactory as _};
    use std::iter;

    /// The arguments of a line as a shell takes them apart, up to a redirection.
    fn words(line: &str) -> Vec<String> {
        let mut words = Vec::new();
        for (number, part) in line.split('\'').enumerate() {
            if number % 2 == 1 {
                words.push(part.to_owned());
            } else {
                words.extend(part.split_whitespace().map(str::to_owned));
            }
        }
        let end = words.iter().position(|word| matches!(&**word, "<" | ">"));
        words.truncate(end.unwrap_or(words.len()));
        words
    }

    /// The paths of a command and of all within it.
    fn paths(command: &Command, of: &str) -> Vec<String> {
        let within = command.get_subcommands().filter(|one| {
            !matches!(
                one.get_name(),
                "help" | "bench" | "selftest" | "tradeoff" | "firmware"
            )
        });
        let within = within.flat_map(|one| paths(one, &format!("{of} {}", one.get_name())));
        iter::once(of.trim_start().to_owned())
            .chain(within)
            .collect()
    }

    #[test]
    fn every_command_has_one_to_three() {
        let command = Shisen::command();
        let mut there = paths(&command, "");
        let mut given: Vec<&str> = EXAMPLES.iter().map(|(path, _)| *path).collect();
        assert!(there.len() > 15, "{there:?}");
        there.sort_unstable();
        given.sort_unstable();
        // Elsewhere some commands are missing.
        #[cfg(unix)]
        assert_eq!(given, there);
        for (path, examples) in EXAMPLES {
            assert!((1..=3).contains(&examples.len()), "{path}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn each_is_a_command_line_of_its_command() {
        for (path, examples) in EXAMPLES {
            for (purpose, line) in *examples {
                assert!(line.starts_with(&format!("shisen {path}")), "{line}");
                assert!(!purpose.ends_with(['.', ':']), "{purpose}");
                let parsed = read::<Shisen>(words(line));
                assert!(parsed.is_ok(), "{line}: {}", parsed.unwrap_err());
            }
        }
    }

    #[test]
    fn help_ends_with_them() {
        let mut command = with_examples(Shisen::command(), EXAMPLES);
        let mut one = &mut command;
        for name in ["dome", "warp"] {
            one = one.find_subcommand_mut(name).unwrap();
        }
        for help in [one.render_help(), one.render_long_help()] {
            let help = help.to_string();
            let end = help.split("Examples:\n").nth(1).unwrap();
            assert!(end.contains("shisen dome warp --walls hall.toml"), "{end}");
        }
    }

    #[test]
    fn what_help_ends_with_already_stays() {
        let mut command = with_examples(Shisen::command(), EXAMPLES);
        let tracker = command.find_subcommand_mut("tracker").unwrap();
        let help = tracker.render_long_help().to_string();
        let (settings, examples) = help.split_once("Examples:\n").unwrap();
        assert!(settings.contains("not set up as usual"), "{settings}");
        assert!(examples.contains("shisen tracker list"), "{examples}");
    }
}

//! What each command's help ends with: lines to try.

use shisen::cli::program::Examples;

/// Examples of every command, and of every group of commands.
pub(super) const EXAMPLES: Examples = &[
    (
        "bench",
        &[
            (
                "Frames with detail that follows the gaze beside frames without",
                "shisen-evidence bench table2",
            ),
            (
                "From a movement of the eye to the wall, for five seconds",
                "shisen-evidence bench latency --seconds 5",
            ),
        ],
    ),
    (
        "bench rays",
        &[(
            "A file of rays against a mesh; what each hit into another",
            "shisen-evidence bench rays --mesh cow.obj --rays rays.bin --hits hits.bin",
        )],
    ),
    (
        "bench table2",
        &[(
            "The frames of the paper's Table 2",
            "shisen-evidence bench table2 --mesh cow.obj",
        )],
    ),
    (
        "bench sweep",
        &[(
            "Gazes all around, on one thread",
            "shisen-evidence bench sweep --directions 50 --threads 1",
        )],
    ),
    (
        "bench fill",
        &[(
            "What fills where the gaze skips rays",
            "shisen-evidence bench fill --mesh cow.obj",
        )],
    ),
    (
        "bench foveated",
        &[(
            "Fewer rays in the periphery, on walls of 1024² pixels",
            "shisen-evidence bench foveated --size 1024",
        )],
    ),
    (
        "bench spectrum",
        &[(
            "The methods for wavelengths, in less time than as they stand",
            "shisen-evidence bench spectrum --size 128 --samples 28 --wavelengths 1,7",
        )],
    ),
    (
        "bench budget",
        &[(
            "Frames at half of what they take, fewer and smaller than as they stand",
            "shisen-evidence bench budget --frames 1000 --size 128",
        )],
    ),
    (
        "bench latency",
        &[(
            "From a movement of the eye to the wall, by a tracker on a line",
            "shisen-evidence bench latency --budget 8ms --seconds 5",
        )],
    ),
    (
        "selftest",
        &[
            ("All hard cases", "shisen-evidence selftest"),
            (
                "Those of spheres, with less of each",
                "shisen-evidence selftest sphere --quick",
            ),
        ],
    ),
    (
        "tradeoff",
        &[
            (
                "The short report",
                "shisen-evidence tradeoff --quick --out report",
            ),
            (
                "Only how detail follows the gaze, with another animal",
                "shisen-evidence tradeoff --only gaze --mesh cow.obj",
            ),
        ],
    ),
];

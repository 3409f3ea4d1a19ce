//! The host's functions that can hold such a number and have no case of their own:
//! why, and by which file they are run instead.

/// Functions that are exempt for one reason.
pub(super) struct Exempt {
    pub(super) why: &'static str,
    /// In one of these, from the workspace's root, each of them is called.
    pub(super) run_by: &'static [&'static str],
    pub(super) names: &'static [&'static str],
}

pub(super) const EXEMPT: &[Exempt] = &[
    Exempt {
        why: "they are the live loop's, and what implements it: what they take is an engine, a \
              look and eyes, and the cases of these are above; threads and machines are in it",
        run_by: &[
            "host/src/live/session.rs",
            "host/src/live/swap/tests.rs",
            "host/src/cli/live.rs",
        ],
        names: &[
            "host live::session::Stage::after",
            "host live::session::Stage::observe",
            "host live::session::Stage::present",
            "host live::session::follow",
            "host live::session::run",
            "host live::swap::SwapLock::order",
            "host live::swap::cluster::Cluster::new",
            "host live::tracking::LiveTracker::start",
        ],
    },
    Exempt {
        why: "they show a room and frames of it, whose light becomes codes of 8 bits: the case is \
              that of picture::srgb_from_linear, and the room's that of Coordinates::new",
        run_by: &["host/src/dashboard/tests.rs"],
        names: &[
            "host dashboard::Dashboard::direction",
            "host dashboard::Dashboard::draw",
            "host dashboard::Dashboard::new",
            "host dashboard::Dashboard::wait",
        ],
    },
    Exempt {
        why: "numbers come to them as text, or as a mesh that is checked when it is baked; files \
              with each number damaged are in scene_fuzz",
        run_by: &[
            "tests/tests/scene_fuzz.rs",
            "tests/fuzz/src/scenes.rs",
            "host/src/cli/source.rs",
        ],
        names: &[
            "host scene::file::Scene::load",
            "host scene::file::Scene::from_toml",
        ],
    },
    Exempt {
        why: "they run the firmware in an emulator, or what it does; the numbers are what its scene \
              and its tracker's bytes say, which are checked where they are read",
        run_by: &["host/src/cli/firmware.rs"],
        names: &[
            "host firmware::reference::reference",
            "host firmware::watch",
        ],
    },
    Exempt {
        why: "a specification's numbers are checked when it is read, which has a case (Times::set); \
              devices, files and pipes are behind them",
        run_by: &[
            "host/src/cli/tracker/serve.rs",
            "host/src/cli/tracker/monitor.rs",
            "host/src/cli/tracker/calibrate.rs",
            "host/src/cli/live.rs",
        ],
        names: &[
            "host tracker::calibration::Calibrated::load",
            "host tracker::calibration::device_name",
            "host tracker::feed::simulated",
            "host tracker::feed::Feed::open",
            "host tracker::feed::Feed::senses",
            "host tracker::serve::serve",
        ],
    },
    Exempt {
        why: "it measures for seconds; of its numbers there is a mesh alone, which Baked::new checks",
        run_by: &["host/src/cli/tradeoff.rs"],
        names: &["host tradeoff::Topic::measure"],
    },
    Exempt {
        why: "what they take only looks like numbers: hashes, one of two eyes, colours of 8 bits",
        run_by: &[
            "host/src/render.rs",
            "host/src/cli/run/files.rs",
            "host/src/cli/run/watch/presenter.rs",
        ],
        names: &[
            "host render::frame_hash",
            "host stereo::Stereo::metadata",
            "host window::Window::show",
        ],
    },
    Exempt {
        why: "their trait is the module's own: pictures of wavelengths are what calls them, whose \
              weights are those of spectra that have cases",
        run_by: &["host/src/render/images.rs"],
        names: &[
            "host render::images::Image::add",
            "host render::images::Image::weigh",
        ],
    },
];

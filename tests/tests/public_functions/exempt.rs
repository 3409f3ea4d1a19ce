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
        why: "it joins the processes of a cluster; the looks that go between them are \
              anybody's in the case of follow",
        run_by: &["host/src/live/swap/tests.rs"],
        names: &["host live::swap::cluster::Cluster::new"],
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
        why: "it sends what a mock measures until somebody stops it: the mock has cases",
        run_by: &["host/src/cli/tracker/serve.rs"],
        names: &["host tracker::serve::serve"],
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

/// Those that take text.
pub(super) const EXEMPT_OF_TEXT: &[Exempt] = &[
    Exempt {
        why: "its text goes to `selected`, which has a case; it runs all cases of the empty one",
        run_by: &["host/src/cli/selftest.rs"],
        names: &["host selftest::run"],
    },
    Exempt {
        why: "it opens a window wherever there is a screen: the tests of it are tests/window/run's",
        run_by: &["host/src/cli/run/watch.rs"],
        names: &["host window::Window::open"],
    },
];

/// Those that take integers.
pub(super) const EXEMPT_OF_INTEGERS: &[Exempt] = &[
    Exempt {
        why: "devices are what takes them: simulated ones on a bus, and those of a virtual machine",
        run_by: &[
            "tracker-driver/src/i2c/tests.rs",
            "tests/hid-machine/src/main.rs",
            "host/src/tracker/live.rs",
        ],
        names: &[
            "tracker hid::device::Device::feature",
            "tracker hid::device::Device::set_feature",
            "tracker i2c::I2cHid::get_feature",
            "tracker i2c::I2cHid::new",
            "tracker i2c::I2cHid::set_feature",
            "tracker serial::Serial::set_speed",
        ],
    },
    Exempt {
        why: "machines that know each other call them, with ranks and frames of their own",
        run_by: &[
            "host/src/live/swap/tests.rs",
            "host/src/live/swap/cluster.rs",
        ],
        names: &[
            "host live::swap::SwapLock::swap",
            "host live::swap::cluster::Wire::poll",
            "host live::swap::cluster::Wire::send",
        ],
    },
    Exempt {
        why: "its integers are what it gives: the tiles of a frame",
        run_by: &["host/src/cli/play.rs"],
        names: &["host live::engine::Engine::tiles"],
    },
    Exempt {
        why: "their trait is the module's own, and has the name of another that is not",
        run_by: &["core/src/trace/ledger.rs"],
        names: &[
            "core trace::ledger::Record::ray",
            "core trace::ledger::Record::touch",
        ],
    },
    Exempt {
        why: "grids of two nodes or more a side have no place that is no number; its nodes are \
              floating-point functions' with cases",
        run_by: &["host/src/warp/bourke.rs", "host/src/warp.rs"],
        names: &["host warp::Warp::at", "host warp::Warp::node"],
    },
    Exempt {
        why: "it opens a window wherever there is a screen: the tests of it are tests/window/run's",
        run_by: &["host/src/cli/run/watch.rs"],
        names: &["host window::Window::open"],
    },
];

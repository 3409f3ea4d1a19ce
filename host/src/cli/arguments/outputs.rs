//! Arguments of commands that show pictures on monitors.

use crate::cave::{Cave, Eye};
use crate::cli::arguments::choices;
use crate::cli::prelude::*;
use crate::outputs::{Backend, Output, Outputs, OutputsName, Placing};
use crate::projection::Projection;
use crate::show::stereo::Stereo;

#[derive(Debug, Clone, Args)]
pub struct OutputsArguments {
    /// Screens and projectors full-screen on monitors, as xrandr --listmonitors names them, presented
    /// on their refresh: front=HDMI-1,right=DP-2, or a TOML file of outputs
    #[arg(long, value_name = "NAME=MONITOR,…|FILE")]
    outputs: Option<OutputsName>,
    /// What shows --outputs
    #[arg(long, value_enum, default_value = "x11", requires = "outputs")]
    backend: Backend,
    /// Who places the windows of --outputs
    #[arg(long, value_enum, default_value = "override", requires = "outputs")]
    window: Placing,
}

/// `--project`, for commands that trace what outputs show.
#[derive(Debug, Clone, Copy, Args)]
pub struct ProjectArguments {
    /// How the pixels of projectors are made [default: per screen what takes fewer rays]
    #[arg(long, value_enum, requires = "outputs")]
    project: Option<Project>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Project {
    /// From the pictures of their screens
    Warp,
    /// By rays of their own, which needs --view none
    Direct,
}

impl ProjectArguments {
    /// Returns the names of the projectors whose own pixels are to be traced. Where screens are
    /// looked at, too, (`needs_screens`) there are none.
    pub fn direct(
        self,
        outputs: &OutputsArguments,
        cave: &Cave,
        needs_screens: bool,
    ) -> Result<Vec<String>, Failure> {
        let (is_asked, mut names) = (self.project == Some(Project::Direct), Vec::new());
        let Some(outputs) = outputs
            .outputs
            .as_ref()
            .filter(|_| self.project != Some(Project::Warp))
        else {
            return Ok(names);
        };
        if needs_screens {
            return if is_asked {
                Err(misuse!(
                    "--project direct leaves no pictures of screens: give --view none"
                ))
            } else {
                Ok(names)
            };
        }
        let outputs = outputs.load()?;
        let shows = |name: &str| outputs.iter().any(|output| output.show == name);
        for screen in cave.screens() {
            let mut own = Vec::new();
            for projector in cave.projectors.iter().filter(|one| shows(&one.name)) {
                if cave.screen_of(projector)? == screen {
                    own.push(projector);
                }
            }
            if own.is_empty() {
                continue;
            }
            let mut able = own.iter().map(|projector| cave.can_be_direct(projector));
            match able.find_map(Result::err) {
                Some(fault) if is_asked => return Err(fault.into()),
                None if is_asked && shows(screen.name()) => {
                    return Err(misuse!(
                        "--project direct leaves no picture of \"{}\", which a monitor shows as \
                         it is: leave that output out, or give --project warp",
                        screen.name()
                    ));
                }
                Some(_) => {}
                None => {
                    let pixels = own.iter().map(|one| one.resolution.map(u64::from));
                    let pixels: u64 = pixels.map(|[columns, rows]| columns * rows).sum();
                    if is_asked || pixels <= screen.pixels() && !shows(screen.name()) {
                        names.extend(own.iter().map(|one| one.name.clone()));
                    }
                }
            }
        }
        if is_asked && names.is_empty() {
            return Err(misuse!(
                "--project direct is for projectors, and --outputs names none: name a projector of \
                 the room"
            ));
        }
        Ok(names)
    }
}

choices!(Backend {
    X11 => "Windows on X servers; on Wayland by XWayland, which the compositor delays",
    Kms => "No desktop: each connector of the graphics cards, as the kernel names it (HDMI-A-1), flips by itself",
});

choices!(Placing {
    Override => "The program: windows without a frame that nothing covers",
    Managed => "The window manager, which is asked for the full screen",
});

impl OutputsArguments {
    pub const fn is_given(&self) -> bool {
        self.outputs.is_some()
    }

    /// Opens windows for the outputs of those pictures that there are, of a screen and an eye each.
    /// `screens` are all there could be, and `projections` what their projectors show.
    pub fn open(
        &self,
        screens: &[&str],
        pictures: &[(&str, Eye)],
        projections: &[Projection],
        stereo: Stereo,
    ) -> Result<Option<Outputs>, Failure> {
        let Some(name) = &self.outputs else {
            return Ok(None);
        };
        let outputs = name.load()?;
        let names: Vec<&str> = projections.iter().map(Projection::name).collect();
        Output::check(&outputs, &[screens, &names].concat())?;
        let shows = |name: &str| outputs.iter().any(|output| output.show == name);
        let of = |screen: &str| {
            let own = projections.iter().filter(|one| one.screen() == screen);
            let all: Vec<&str> = own.map(Projection::name).collect();
            all
        };
        // A screen is shown as it is, or by all of its projectors.
        let hidden = screens
            .iter()
            .filter(|screen| !shows(screen))
            .flat_map(|screen| {
                let own = of(screen);
                if own.is_empty() { vec![*screen] } else { own }
            });
        let hidden: Vec<&str> = hidden.filter(|name| !shows(name)).collect();
        if !hidden.is_empty() {
            let hidden = hidden.join(", ");
            warn(&format!(
                "no monitor shows {hidden}: add NAME=MONITOR to --outputs where one should"
            ));
        }
        let (backend, placing) = (self.backend, self.window);
        if (backend, placing) == (Backend::Kms, Placing::Managed) {
            return Err(misuse!(
                "--window managed is for X servers: with --backend kms there are no windows"
            ));
        }
        let opened = Outputs::open(&outputs, pictures, projections, stereo, backend, placing)?;
        Ok(Some(opened))
    }
}

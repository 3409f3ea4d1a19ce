//! Test pictures: what walls, domes and projectors show while a room is set up.
//!
//! A pattern is drawn in a screen's picture, as a scene is, and goes through a projector's warp and
//! blend; or in an output's own pixels, past both.

mod output;
mod screen;
mod sheet;

use crate::cave::{Eye, Screen, Viewer};
use crate::picture::{Picture, PictureError};
use crate::show::dashboard::Canvas;
use glam::DVec2;

/// The screen's picture that a pattern is drawn in, and its viewer.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ScreenView<'a> {
    /// The screen.
    pub(crate) screen: Screen<'a>,
    /// The viewer before it.
    pub(crate) viewer: Viewer,
    /// The eye that the picture is for.
    pub(crate) eye: Eye,
}

/// The output that a pattern is drawn for: a projector or a monitor.
#[derive(Debug, Clone, Copy)]
pub(crate) struct OutputView<'a> {
    /// The name that the picture shows.
    pub(crate) name: &'a str,
    /// The output's number among all of them, from 0: sets its colour.
    pub(crate) number: usize,
    /// Columns and rows.
    pub(crate) size: [u32; 2],
    /// The outlines of other projectors' pictures, in pixels from this one's upper left corner.
    /// They run along the outer edges of the outermost pixels.
    pub(crate) neighbours: &'a [Vec<DVec2>],
}

/// The refresh that an output's picture is for.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Refresh {
    /// The count of refreshes (MSC).
    pub(crate) msc: u64,
    /// Whether an event, such as a key, came since the refresh before.
    pub(crate) is_event: bool,
}

/// The place of a pattern, and the function that draws it there.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Drawing {
    /// In a screen's picture.
    Screen {
        /// Draws it for one eye.
        draw: fn(&ScreenView<'_>) -> Result<Picture, PictureError>,
        /// Whether it shows nothing to a single eye.
        is_stereo: bool,
    },
    /// In the pixels of an output, the same for both eyes.
    Output {
        /// Draws it for one refresh.
        draw: fn(&OutputView<'_>, Refresh) -> Canvas,
        /// Whether it changes from refresh to refresh.
        is_moving: bool,
    },
}

/// A test picture.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pattern {
    /// The name on command lines.
    pub(crate) name: &'static str,
    /// The purpose, a sentence.
    pub(crate) purpose: &'static str,
    /// What is seen if all is well, and what to do if not.
    pub(crate) look_for: &'static str,
    /// Where and how it is drawn.
    pub(crate) drawing: Drawing,
}

impl Pattern {
    /// Returns the pattern of a name.
    pub(crate) fn named(name: &str) -> Option<&'static Self> {
        PATTERNS.iter().find(|one| one.name == name)
    }
}

const fn screen(draw: fn(&ScreenView<'_>) -> Result<Picture, PictureError>) -> Drawing {
    let is_stereo = false;
    Drawing::Screen { draw, is_stereo }
}

const fn stereo(draw: fn(&ScreenView<'_>) -> Result<Picture, PictureError>) -> Drawing {
    let is_stereo = true;
    Drawing::Screen { draw, is_stereo }
}

const fn still(draw: fn(&OutputView<'_>, Refresh) -> Canvas) -> Drawing {
    let is_moving = false;
    Drawing::Output { draw, is_moving }
}

const fn moving(draw: fn(&OutputView<'_>, Refresh) -> Canvas) -> Drawing {
    let is_moving = true;
    Drawing::Output { draw, is_moving }
}

/// All patterns, in the order in which a room is set up.
pub(crate) const PATTERNS: [Pattern; 24] = [
    Pattern {
        name: "edges",
        purpose: "Each screen's name, size and outermost pixels show which output is which, and \
                  whether all of a picture is seen.",
        look_for: "All four edges of the line around, one pixel wide, and the crosshair in the \
                   middle. A missing edge: turn overscan and scaling off in the projector. \
                   Mirrored or turned letters: change the projector's mounting (ceiling, rear). \
                   Another screen's name: exchange the outputs.",
        drawing: screen(screen::edges),
    },
    Pattern {
        name: "focus",
        purpose: "Single pixels, a Siemens star and small letters show focus and scaling.",
        look_for: "An even checkerboard and sharp letters in the middle and in all corners. \
                   Stripes or moiré in the checkerboard: the projector scales; give it its own \
                   resolution. Sharp in the middle only: focus again, halfway to the corners.",
        drawing: still(output::focus),
    },
    Pattern {
        name: "convergence",
        purpose: "White lines of one pixel show whether a projector's red, green and blue meet.",
        look_for: "White lines without coloured edges. Colours on one side: align the panels in \
                   the projector's menu, or the lens is decentred.",
        drawing: still(output::convergence),
    },
    Pattern {
        name: "grid",
        purpose: "Numbered cells of 0.25 m on walls, of 10° on domes, show whether a picture has \
                  its right place and size.",
        look_for: "Hold a ruler to it: every fourth line is bright and 1 m from the last. Numbers \
                   are columns and rows from the lower left corner, on domes degrees to the right \
                   of the front and from the zenith. Cells too small or bent: measure the \
                   screen's corners, or the projector's pins, again.",
        drawing: screen(screen::grid),
    },
    Pattern {
        name: "circles",
        purpose: "Circles by the eye's rays must look round from the viewer's place, across \
                  corners too.",
        look_for: "Close one eye and stand where --head is. An ellipse or a step at a corner: the \
                   head's place, the wall's corners or the tracker's origin is wrong. Numbers are \
                   degrees to the right and upwards.",
        drawing: screen(screen::circles),
    },
    Pattern {
        name: "border-pair",
        purpose: "Lines at the borders of overlaps show whether neighbouring projectors are \
                  aligned to the pixel.",
        look_for: "A yellow line where a projector's border meets its neighbour's inner one. Red \
                   and green side by side: move a projector, or correct its pins, by as many \
                   pixels.",
        drawing: still(output::border_pair),
    },
    Pattern {
        name: "coverage",
        purpose: "Each output in a colour of its own shows what it covers, and the order of \
                  outputs.",
        look_for: "Mixed colours exactly where projectors overlap, no black gap on the screen. A \
                   gap: move or widen a projector. A wrong name: exchange the outputs.",
        drawing: still(output::coverage),
    },
    Pattern {
        name: "gamma",
        purpose: "Fields of one code beside alternate lines of 0 and 255 show a projector's gamma: \
                  without the right one no blend adds up.",
        look_for: "Step back until the lines merge. The field that vanishes in them gives the \
                   gamma to write for the projector: 186 is 2.2, 188 is sRGB. Another one for \
                   red, green or blue: write a gamma for each channel.",
        drawing: still(output::gamma),
    },
    Pattern {
        name: "steps",
        purpose: "A wedge of 32 greys shows whether dark and bright codes can be told apart.",
        look_for: "32 different steps, all grey. The last ones alike: lower the projector's \
                   contrast, or its input expects 16 to 235. The first ones alike: raise its \
                   brightness. A tint: correct its white balance.",
        drawing: still(output::steps),
    },
    Pattern {
        name: "near-black",
        purpose: "Codes 0 to 16 show the black level, and its lift where fewer projectors overlap.",
        look_for: "In the dark, fields from about 2 on, and no bands at overlaps. Bright bands: \
                   raise the black level of the blend. Fields missing up to 16: set the input's \
                   range to full.",
        drawing: screen(screen::near_black),
    },
    Pattern {
        name: "bars",
        purpose: "Colour bars and ramps show the order of channels and a missing one, and compare \
                  projectors.",
        look_for: "Each bar in the colour that is written on it, smooth ramps. Colours exchanged: \
                   a channel's cable or setting. Different whites: match the projectors' white \
                   balance and gain.",
        drawing: screen(screen::bars),
    },
    flat("red", "Full red compares projectors.", |view| {
        screen::flat(view, [255, 0, 0])
    }),
    flat("green", "Full green compares projectors.", |view| {
        screen::flat(view, [0, 255, 0])
    }),
    flat("blue", "Full blue compares projectors.", |view| {
        screen::flat(view, [0, 0, 255])
    }),
    flat(
        "grey-25",
        "Code 64 of 255 shows bands of a blend.",
        |view| screen::flat(view, [64; 3]),
    ),
    flat(
        "grey-50",
        "Code 128 of 255 shows bands of a blend.",
        |view| screen::flat(view, [128; 3]),
    ),
    flat(
        "grey-75",
        "Code 191 of 255 shows bands of a blend.",
        |view| screen::flat(view, [191; 3]),
    ),
    flat("grey-100", "White shows bands of a blend.", |view| {
        screen::flat(view, [255; 3])
    }),
    Pattern {
        name: "stereo",
        purpose: "L and R, each for its eye only, show whether each eye gets its picture alone.",
        look_for: "The left eye sees a red left half with an L, the right eye a cyan right half \
                   with an R. The other way round: set swap_eyes. Both letters in one eye: the \
                   glasses or the display are not in stereo. A faint second letter is crosstalk.",
        drawing: stereo(screen::stereo),
    },
    Pattern {
        name: "depth",
        purpose: "Three bars at half, at once and at twice the screen's distance show the eyes' \
                  order and distance.",
        look_for: "The bar \"nearer\" before the screen, \"farther\" behind it. The other way \
                   round: set swap_eyes. Double pictures that do not fuse: check --ipd, and face \
                   the screen with --look.",
        drawing: stereo(screen::depth),
    },
    Pattern {
        name: "eye-swap",
        purpose: "White for the left eye and black for the right one, for a photodiode behind a \
                  shutter.",
        look_for: "Steady light behind the left shutter, none behind the right one. The other \
                   way round: set swap_eyes. A blink now and then: refreshes are missed.",
        drawing: stereo(screen::eye_swap),
    },
    Pattern {
        name: "latency",
        purpose: "A square of 100 pixels in the lower left corner is white on the frame after an \
                  event, for a photodiode.",
        look_for: "Record the event and the photodiode together: the time between them is from \
                   motion to light. Different times on two walls: they are not locked.",
        drawing: moving(output::latency),
    },
    Pattern {
        name: "bar",
        purpose: "A bar that moves by its own width at each refresh shows dropped frames and \
                  tearing.",
        look_for: "Photograph 1 s: an even band. Gaps are dropped frames, a broken bar is \
                   tearing, a jump at a seam is a wall out of step.",
        drawing: moving(output::bar),
    },
    Pattern {
        name: "counter",
        purpose: "The count of refreshes in binary, eight squares, lets a camera read which frame \
                  each wall shows.",
        look_for: "In one photograph all walls show one number. Different numbers: they are not \
                   locked; the difference is in refreshes.",
        drawing: moving(output::counter),
    },
];

/// A field of one colour.
const fn flat(
    name: &'static str,
    purpose: &'static str,
    draw: fn(&ScreenView<'_>) -> Result<Picture, PictureError>,
) -> Pattern {
    Pattern {
        name,
        purpose,
        look_for: "One even colour. A band along an overlap: measure the projectors' gamma with \
                   the pattern gamma. Different colours: match their white balance and gain.",
        drawing: screen(draw),
    }
}

#[cfg(test)]
mod tests;

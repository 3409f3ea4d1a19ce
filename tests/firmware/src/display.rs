//! What is shown: the screens, the eyes before them, and how they are rendered.

use crate::say;
use glam::Vec3;
use heapless::Vec;
use shisen_core::frame::{FlatScreen, LevelOfDetail, Part, Pictures, Renderer, View};
use shisen_core::gaze::{Gaze, HeadPose, LineOfSight, VisualField};
use shisen_tracker::link::display::{Order, Rendering};

/// Screens at most.
pub const MOST_SCREENS: usize = 6;
/// Pixels a side of a tile.
pub const TILE: u32 = 16;

/// Pixels a side of the screens that nobody has told of.
const SIDE: u32 = 64;

/// Radians that the gaze may move in a frame unless told otherwise: 5°, beyond which the
/// centre of the retina sees what was rendered for its surroundings.
const RESTART_ANGLE: f32 = 0.087_266_46;

/// What is shown, and how.
pub struct Display {
    screens: Vec<FlatScreen, MOST_SCREENS>,
    /// How to render.
    pub rendering: Rendering,
    /// Orders obeyed; wraps.
    pub orders: u8,
    /// The dome master that was asked for.
    pub capture: Option<(u16, Vec3)>,
}

impl Display {
    /// Front, right and floor of a 3 m cube, in full, as the paper's method would.
    pub fn new() -> Self {
        // Lower left, lower right and upper left, in half sides of the cube.
        const CORNERS: [[[f32; 3]; 3]; 3] = [
            [[-1., -1., -1.], [1., -1., -1.], [-1., 1., -1.]],
            [[1., -1., -1.], [1., -1., 1.], [1., 1., -1.]],
            [[-1., -1., 1.], [1., -1., 1.], [-1., -1., -1.]],
        ];
        let mut screens = Vec::new();
        for corners in CORNERS {
            let [left, right, top] = corners.map(|corner| 1.5 * Vec3::from_array(corner));
            let _ = screens.push(FlatScreen::from_corners(left, right, top, [SIDE; 2]));
        }
        Self {
            screens,
            rendering: Rendering {
                budget: u64::MAX,
                slice: 10_000,
                depth: 3,
                wavelengths: 1,
                lod: true,
                eye_distance: 0.0,
                display_delay: 20_000,
                restart_angle: RESTART_ANGLE,
            },
            orders: 0,
            capture: None,
        }
    }

    /// Obeys an order; one that makes no sense changes nothing.
    pub fn obey(&mut self, order: &Order) {
        self.orders = self.orders.wrapping_add(1);
        match *order {
            Order::Screens { count } => {
                self.screens.truncate(usize::from(count).max(1));
                while let Some(&last) = self.screens.last()
                    && self.screens.len() < usize::from(count)
                    && self.screens.push(last).is_ok()
                {}
            }
            Order::Screen { index, screen } => {
                // One that can be seen from somewhere.
                let normal = screen
                    .row_step
                    .cross(screen.column_step)
                    .normalize_or_zero();
                if let Some(place) = self.screens.get_mut(usize::from(index))
                    && screen.view_from(screen.first_pixel + normal).is_ok()
                {
                    *place = screen;
                }
            }
            Order::Rendering(rendering) => {
                if rendering.budget == 0 {
                    say!(warn, "no steps for a frame: only the background is shown");
                }
                self.rendering = Rendering {
                    // With none it would never come to an end.
                    slice: rendering.slice.max(1),
                    ..rendering
                };
            }
            Order::Capture { size, place } => self.capture = Some((size, place)),
        }
    }

    /// The screens.
    pub fn screens(&self) -> &[FlatScreen] {
        &self.screens
    }

    /// Where the eyes of a head are, if they see all screens.
    pub fn eyes(&self, head: &HeadPose) -> Option<[Vec3; 2]> {
        let aside = head.orientation * (Vec3::X * (0.5 * self.rendering.eye_distance));
        let eyes = [head.position - aside, head.position + aside];
        let sees = |screen: &FlatScreen| eyes.iter().all(|&eye| screen.view_from(eye).is_ok());
        self.screens.iter().all(sees).then_some(eyes)
    }

    /// The screens as eyes see them, each along its own gaze.
    pub fn seen<'r, 'a>(
        &'r self,
        eyes: [Vec3; 2],
        renderers: &'r [Renderer<'a, 4>; 2],
    ) -> Seen<'r, 'a> {
        Seen {
            screens: &self.screens,
            eyes,
            count: 1 + usize::from(self.rendering.eye_distance != 0.0),
            renderers,
        }
    }
}

/// What follows the gaze of an eye: nothing where the field has no end.
pub fn level_of_detail(eye: Vec3, forward: Vec3, up: Vec3, widen: f32) -> Option<LevelOfDetail> {
    let field = VisualField::PAPER.wider(widen)?;
    let sight = LineOfSight::new(eye, forward, up).ok()?;
    Some(LevelOfDetail::new(Gaze::new(sight, field)))
}

/// The screens as eyes see them: screen by screen, and eye by eye in each.
pub struct Seen<'r, 'a> {
    screens: &'r [FlatScreen],
    eyes: [Vec3; 2],
    /// Number of eyes.
    count: usize,
    renderers: &'r [Renderer<'a, 4>; 2],
}

impl Seen<'_, '_> {
    /// The screen and the eye of a picture.
    fn place(&self, number: usize) -> (usize, usize) {
        if self.count == 1 {
            (number, 0)
        } else {
            (number / 2, number % 2)
        }
    }
}

impl<'a> Pictures<'a, 4> for Seen<'_, 'a> {
    fn count(&self) -> usize {
        self.screens.len() * self.count
    }

    fn view(&self, number: usize) -> Option<View> {
        let (screen, eye) = self.place(number);
        self.screens
            .get(screen)?
            .view_from(*self.eyes.get(eye)?)
            .ok()
    }

    fn renderer(&self, number: usize) -> Option<&Renderer<'a, 4>> {
        self.renderers.get(self.place(number).1)
    }
}

/// What a frame shows.
pub enum Shown<'r, 'a> {
    /// The screens.
    Screens(Seen<'r, 'a>),
    /// A dome master.
    Capture([Part<'r, 'a, 4>; 1]),
}

impl<'a> Pictures<'a, 4> for Shown<'_, 'a> {
    fn count(&self) -> usize {
        match self {
            Self::Screens(seen) => seen.count(),
            Self::Capture(_) => 1,
        }
    }

    fn view(&self, number: usize) -> Option<View> {
        match self {
            Self::Screens(seen) => seen.view(number),
            Self::Capture(part) => part.as_slice().view(number),
        }
    }

    fn renderer(&self, number: usize) -> Option<&Renderer<'a, 4>> {
        match self {
            Self::Screens(seen) => seen.renderer(number),
            Self::Capture(part) => part.as_slice().renderer(number),
        }
    }
}

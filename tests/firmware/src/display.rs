//! The display: its screens, the eyes in front of them, and the settings of rendering.

use crate::say;
use glam::Vec3;
use heapless::Vec;
use shisen_core::frame::{CompactRenderer, FlatScreen, LevelOfDetail, Part, Pictures, View};
use shisen_core::gaze::{Gaze, HeadPose, LineOfSight, VisualField};
use shisen_tracker::link::display::{Order, Rendering};

/// Most screens.
pub const MOST_SCREENS: usize = 6;
/// Pixels a side of a tile.
pub const TILE: u32 = 16;

/// Pixels a side of the default screens.
const SIDE: u32 = 64;

/// Default angle that the gaze may move in a frame, radians: 5°. Beyond it the centre of the
/// retina sees pixels that were rendered for its surroundings.
const RESTART_ANGLE: f32 = 0.087_266_46;

/// The display's screens and settings.
pub struct Display {
    screens: Vec<FlatScreen, MOST_SCREENS>,
    /// Settings of rendering.
    pub rendering: Rendering,
    /// Number of orders obeyed; wraps.
    pub orders: u8,
    /// The requested dome master, if any.
    pub capture: Option<(u16, Vec3)>,
}

impl Display {
    /// Returns front, right and floor of a 3 m cube, rendered by the paper's method without a limit.
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

    /// Obeys an order; an invalid one changes nothing.
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
                // A valid screen: some eye can see it.
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
                    // With 0 steps a frame would never end.
                    slice: rendering.slice.max(1),
                    ..rendering
                };
            }
            Order::Capture { size, place } => self.capture = Some((size, place)),
        }
    }

    /// Returns the screens.
    pub fn screens(&self) -> &[FlatScreen] {
        &self.screens
    }

    /// Returns the positions of a head's eyes, if they see all screens.
    pub fn eyes(&self, head: &HeadPose) -> Option<[Vec3; 2]> {
        let aside = head.orientation * (Vec3::X * (0.5 * self.rendering.eye_distance));
        let eyes = [head.position - aside, head.position + aside];
        let sees = |screen: &FlatScreen| eyes.iter().all(|&eye| screen.view_from(eye).is_ok());
        self.screens.iter().all(sees).then_some(eyes)
    }

    /// Returns the screens as each eye sees them, along its own gaze.
    pub fn seen<'r, 'a>(
        &'r self,
        eyes: [Vec3; 2],
        renderers: &'r [CompactRenderer<'a>; 2],
    ) -> Seen<'r, 'a> {
        Seen {
            screens: &self.screens,
            eyes,
            count: 1 + usize::from(self.rendering.eye_distance != 0.0),
            renderers,
        }
    }
}

/// Returns the level of detail for an eye's gaze; `None` if the field of full detail is everything.
pub fn level_of_detail(eye: Vec3, forward: Vec3, up: Vec3, widen: f32) -> Option<LevelOfDetail> {
    let field = VisualField::PAPER.wider(widen)?;
    let sight = LineOfSight::new(eye, forward, up).ok()?;
    Some(LevelOfDetail::new(Gaze::new(sight, field)))
}

/// The screens as eyes see them: screen by screen, and eye by eye in each.
pub struct Seen<'r, 'a> {
    screens: &'r [FlatScreen],
    eyes: [Vec3; 2],
    /// Returns the number of eyes.
    count: usize,
    renderers: &'r [CompactRenderer<'a>; 2],
}

impl Seen<'_, '_> {
    /// Returns the screen and the eye of a picture.
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

    fn renderer(&self, number: usize) -> Option<&CompactRenderer<'a>> {
        self.renderers.get(self.place(number).1)
    }
}

/// The subject of a frame.
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

    fn renderer(&self, number: usize) -> Option<&CompactRenderer<'a>> {
        match self {
            Self::Screens(seen) => seen.renderer(number),
            Self::Capture(part) => part.as_slice().renderer(number),
        }
    }
}

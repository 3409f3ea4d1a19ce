//! A dashboard of the live loop: the walls as a net or as the viewer sees them, the gaze, the order
//! in which tiles are dealt steps, the budget, and the latency from the eye to the wall. It is
//! drawn into a [`Canvas`] from a [`Frame`], a [`Status`] and the chosen view alone.

mod canvas;
mod gauges;
mod picture;
mod place_map;

pub(crate) use canvas::{Canvas, Colour, Rect};
pub(crate) use gauges::Latency;
use place_map::{Coordinates, PlaceMap};

use crate::cave::Cave;
use crate::live::FrameRecord;
use crate::picture::Picture;
use crate::render::{self, Observer};
use crate::show::ShowError;
use crate::show::overview::viewer::ViewerCamera;
use crate::show::stereo::Stereo;
use glam::{DVec3, Vec3};
use picture::{Area, Codes, Ranks};
use shisen_core::frame::Tile;
use shisen_core::gaze::HeadPose;
use std::sync::Arc;

const BACKGROUND: Colour = 0x18_1818;
const TEXT: Colour = 0xE0_E0E0;
const NOTICE: Colour = 0xFF_D040;

const HEADER: u32 = 18;

/// The horizontal field of the viewer's eye, radians (100°).
const FIELD_OF_VIEW: f64 = 1.745_329_251_994_329_5;

const HELP: [&str; 2] = [
    "A B C D scene  L level of detail  F fill  V net or viewer  H levels  T order of tiles",
    "M mouse is the gaze (or hold a button)  Arrows fly  Home back  Space pause  S screenshot  Q end",
];

/// What a session is about.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct About {
    pub(crate) scene: String,
    pub(crate) lod: String,
    pub(crate) fill: String,
    pub(crate) hz: u32,
    pub(crate) budget: String,
}

/// A frame to draw.
#[derive(Debug, Clone, Default)]
pub(crate) struct Frame {
    pub(crate) about: Arc<About>,
    /// By screen, then eye.
    pub(crate) pictures: Vec<Picture>,
    pub(crate) eyes: Vec<Observer>,
    pub(crate) head: HeadPose,
    /// In the order in which they were dealt steps, each with the number of its picture.
    pub(crate) tiles: Vec<(usize, Tile)>,
    pub(crate) record: FrameRecord,
    /// The oldest first.
    pub(crate) latencies: Vec<Latency>,
}

/// How the walls are shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum ViewName {
    #[default]
    Net,
    Viewer,
}

/// The state of the window.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Status {
    pub(crate) mouse: bool,
    pub(crate) paused: bool,
    pub(crate) dropped: u64,
    pub(crate) message: Option<String>,
}

pub(crate) struct Dashboard<'c> {
    cave: &'c Cave,
    coordinates: Coordinates<'c>,
    net: PlaceMap,
    stereo: Stereo,
    codes: Codes,
    ranks: Ranks,
    areas: Vec<Area>,
    pub(crate) view: ViewName,
    pub(crate) levels: bool,
    pub(crate) tiles: bool,
}

impl<'c> Dashboard<'c> {
    /// The usual columns and rows.
    pub(crate) const SIZE: [u32; 2] = [960, 720];

    /// For the screens of a room.
    pub(crate) fn new(cave: &'c Cave, stereo: Stereo) -> Result<Self, ShowError> {
        let coordinates = Coordinates::new(cave)?;
        Ok(Self {
            cave,
            net: coordinates.net()?,
            coordinates,
            stereo,
            codes: Codes::new(),
            ranks: Ranks::default(),
            areas: Vec::new(),
            view: ViewName::Net,
            levels: false,
            tiles: false,
        })
    }

    /// Returns how often a frame is drawn: twice where its eyes take turns.
    pub(crate) fn turns(&self) -> usize {
        1 + usize::from(self.stereo == Stereo::Sequential)
    }

    /// Draws the message while there is no frame.
    pub(crate) fn wait(canvas: &mut Canvas, status: &Status) {
        canvas.clear(BACKGROUND);
        if let Some(message) = &status.message {
            canvas.write(8, 5, message, NOTICE);
        }
    }

    /// Draws a frame; `turn` counts up to [`turns`](Self::turns).
    pub(crate) fn draw(
        &mut self,
        canvas: &mut Canvas,
        frame: &Frame,
        status: &Status,
        turn: usize,
    ) -> Result<(), ShowError> {
        canvas.clear(BACKGROUND);
        let [width, height] = canvas.size();
        let rows = height.saturating_sub(HEADER + gauges::ROWS);
        let walls = Rect::new(0, HEADER, width, rows);
        self.lay_out(walls, frame, turn)?;
        if self.tiles {
            self.ranks.set(frame);
        }
        for area in &mut self.areas {
            area.look(self.cave, frame);
        }
        let over = picture::Overlay {
            levels: self.levels,
            ranks: self.tiles.then_some(&self.ranks),
        };
        picture::draw(canvas, &self.areas, frame, over, self.stereo, &self.codes);
        for area in &self.areas {
            if let Some((x, y)) = area.place_of(frame.forward()) {
                picture::mark(canvas, area.rect, x, y);
            }
        }
        header(canvas, frame, status);
        gauges::draw(canvas, frame, status.dropped);
        if self.levels {
            picture::legend(canvas, walls, &self.codes);
        }
        Ok(())
    }

    /// Returns the direction from the eye to what was last drawn at a place; `None` off the
    /// screens.
    pub(crate) fn direction(&self, x: u32, y: u32, frame: &Frame) -> Option<Vec3> {
        let area = self.areas.iter().find(|area| area.contains(x, y))?;
        area.direction(self.cave, frame, x, y)
    }

    fn lay_out(&mut self, walls: Rect, frame: &Frame, turn: usize) -> Result<(), ShowError> {
        let last = frame.eyes.len().saturating_sub(1);
        let (mut left, mut above) = (walls, walls);
        left.width /= 2;
        above.height /= 2;
        let (mut right, mut below) = (left, above);
        right.x += left.width;
        below.y += above.height;
        let places = match self.stereo {
            Stereo::Mono => vec![(walls, 0)],
            Stereo::Sequential => vec![(walls, turn)],
            Stereo::SideBySide => vec![(left, 0), (right, 1)],
            Stereo::TopBottom => vec![(above, 0), (below, 1)],
            Stereo::Anaglyph => vec![(walls, 0), (walls, 1)],
        };
        let mut areas = std::mem::take(&mut self.areas).into_iter();
        for (rect, eye) in places {
            let eye = eye.min(last);
            let area = match (self.view, areas.next()) {
                // A net does not change.
                (ViewName::Net, Some(area)) if area.is_net(rect, eye) => area,
                (ViewName::Net, _) => {
                    let net = self.net.fitted(rect.width, rect.height, BACKGROUND);
                    Area::new(rect, eye, net, true)
                }
                (ViewName::Viewer, _) => Area::new(rect, eye, self.seen(rect, eye, frame)?, false),
            };
            self.areas.push(area);
        }
        Ok(())
    }

    fn seen(&self, rect: Rect, eye: usize, frame: &Frame) -> Result<PlaceMap, ShowError> {
        let room_from_head = frame.head.orientation.as_dquat();
        let place = frame.eyes.get(eye).map_or(DVec3::ZERO, |eye| eye.place);
        let size = [rect.width, rect.height].map(|side| side.div_ceil(2).max(1));
        let (ahead, up) = (room_from_head * DVec3::NEG_Z, room_from_head * DVec3::Y);
        let Ok(camera) = ViewerCamera::new(place, ahead, up, FIELD_OF_VIEW, size) else {
            // A head without a finite place sees nothing.
            return Ok(self.net.fitted(0, 0, BACKGROUND));
        };
        let seen = self.coordinates.view(&camera)?;
        Ok(seen.fitted(rect.width, rect.height, BACKGROUND))
    }
}

impl Frame {
    fn forward(&self) -> Vec3 {
        self.record.forward.into()
    }

    fn view_of(&self, cave: &Cave, screen: usize, eye: usize) -> Option<shisen_core::frame::View> {
        let screen = cave.screens().nth(screen)?;
        render::view(screen, self.eyes.get(eye)?).ok()
    }
}

fn header(canvas: &mut Canvas, frame: &Frame, status: &Status) {
    let about = &frame.about;
    let gaze = if status.mouse {
        "mouse"
    } else {
        frame.record.state
    };
    let paused = if status.paused { "  PAUSED" } else { "" };
    let text = format!(
        "scene {}  detail {}  fill {}  {} Hz  budget {}  gaze {gaze}{paused}",
        about.scene, about.lod, about.fill, about.hz, about.budget
    );
    let end = canvas.write(8, 5, &text, TEXT);
    if let Some(message) = &status.message {
        canvas.write(end + 16, 5, message, NOTICE);
    }
}

#[cfg(test)]
mod tests;

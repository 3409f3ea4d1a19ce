//! Arguments of commands that show a scene to a viewer in a room.

use crate::cave::look::{Point, ViewDirection};
use crate::cave::{DEFAULT_INTERPUPILLARY_DISTANCE, Eye, Viewer, Wall};
use crate::cli::arguments::{WallsName, head_report, picture_size};
use crate::cli::prelude::*;
use crate::render::Observer;
use crate::show::overview::viewer::ViewerCamera;
use crate::show::stereo::Stereo;
use glam::{DVec3, Quat};
use shisen_core::gaze::HeadPose;

#[derive(Debug, Clone, Args)]
pub struct RoomArguments {
    /// three-wall (front, right and floor), cube, dome (a hemisphere of 2.5 m on the floor, whose
    /// centre is 1.5 m below the origin), or a TOML file of walls and domes
    #[arg(long, value_name = "NAME|FILE", default_value = "three-wall")]
    walls: WallsName,
    /// Pixels along each side of a wall or dome whose file does not say
    #[arg(long, value_name = "PIXELS", default_value_t = 256,
          value_parser = whole::<u32>(1..=Wall::MOST_PIXELS))]
    pub size: u32,
    /// One eye in the middle of the head, or two
    #[arg(long, value_name = "1|2", default_value_t = 2,
          value_parser = whole::<u8>(1..=2))]
    eyes: u8,
    /// Position of the head in the room, metres
    #[arg(
        long,
        value_name = "X,Y,Z",
        default_value = "0,0,0",
        allow_hyphen_values = true
    )]
    head: Point,
    /// Orientation of the head: an OSVR HDK report of 16 or 32 bytes in hexadecimal
    #[arg(long, value_name = "HEX", allow_hyphen_values = true, value_parser = head_report)]
    head_report: Option<Quat>,
    /// Where the viewer looks: front, floor, right, left, back, ceiling, YAW,PITCH in degrees
    /// (positive to the right and up), or a direction X,Y,Z. The head turns along unless
    /// --head-report says how it is turned [default: as --head-report says, or else front]
    #[arg(long, value_name = "DIRECTION", allow_hyphen_values = true)]
    pub look: Option<ViewDirection>,
    /// Distance between the pupils, metres
    #[arg(long, value_name = "METRES", default_value_t = DEFAULT_INTERPUPILLARY_DISTANCE,
          value_parser = within(0.0..=1.0, "metres from 0 to 1, such as 0.064"))]
    ipd: f64,
}

impl RoomArguments {
    pub fn cave(&self) -> Result<Cave, Failure> {
        self.walls.cave([self.size; 2])
    }

    /// Returns the file of `--walls`.
    pub fn walls_file(&self) -> Option<&Path> {
        match &self.walls {
            WallsName::File(path) => Some(path),
            WallsName::BuiltIn(_) | WallsName::Text(..) => None,
        }
    }

    /// Takes a text for that of the file.
    pub fn set_walls(&mut self, text: String) {
        if let WallsName::File(path) = &self.walls {
            self.walls = WallsName::Text(path.clone(), text);
        }
    }

    pub fn head(&self) -> HeadPose {
        self.head_towards(self.look)
    }

    /// Returns the head as `--head-report` has it, or else turned towards a direction about the
    /// midpoint between the eyes.
    pub fn head_towards(&self, look: Option<ViewDirection>) -> HeadPose {
        let turned = look.map(|look| look.orientation().as_quat());
        HeadPose {
            position: self.head.0.as_vec3(),
            orientation: self.head_report.or(turned).unwrap_or(Quat::IDENTITY),
        }
    }

    /// Returns a viewer with a head.
    pub const fn viewer(&self, pose: HeadPose) -> Viewer {
        Viewer {
            pose,
            interpupillary_distance: self.ipd,
        }
    }

    /// Returns the eyes and their positions in the room, metres.
    pub fn eyes(&self, pose: HeadPose) -> impl Iterator<Item = (Eye, DVec3)> + Clone + use<> {
        let viewer = self.viewer(pose);
        let which: &'static [Eye] = if self.eyes == 1 {
            &[Eye::Centre]
        } else {
            &Eye::STEREO
        };
        which.iter().map(move |&eye| (eye, viewer.eye(eye)))
    }

    /// Checks that the eyes of a head see all screens.
    pub fn check_eyes(&self, cave: &Cave, pose: HeadPose) -> Result<(), Failure> {
        for (_, place) in self.eyes(pose) {
            cave.check_eye(place)?;
        }
        Ok(())
    }

    /// Checks that there are two eyes if both are shown.
    pub fn check_stereo(&self, stereo: Stereo) -> Result<(), Failure> {
        if stereo != Stereo::Mono && self.eyes == 1 {
            return Err(misuse!(
                "--stereo {stereo} takes two eyes: leave --eyes 1 out"
            ));
        }
        Ok(())
    }

    /// Checks that not both a model's camera and something else say where the viewer looks.
    pub fn check_camera(&self, camera: Option<&str>) -> Result<(), Failure> {
        let other = match (&self.look, &self.head_report) {
            (Some(_), _) => "--look",
            (_, Some(_)) => "--head-report",
            _ => return Ok(()),
        };
        match camera {
            Some(name) => Err(misuse!(
                "--camera \"{name}\" says where the viewer looks, and so does {other}: give one of \
                 the two"
            )),
            None => Ok(()),
        }
    }

    /// Returns the viewer's directions forward and up. A measured head may be tilted; a viewer who
    /// looks along `--look` is upright.
    pub fn directions(&self, pose: HeadPose) -> (DVec3, DVec3) {
        match (self.look, self.head_report) {
            (None, Some(_)) => {
                let room_from_head = pose.orientation.as_dquat();
                (room_from_head * DVec3::NEG_Z, room_from_head * DVec3::Y)
            }
            (look, _) => look.unwrap_or(ViewDirection::FRONT).directions(),
        }
    }
}

/// Arguments of commands that write what the viewer sees of all screens.
#[derive(Debug, Clone, Copy, Args)]
pub struct ViewArguments {
    /// Columns and rows of viewer.png
    #[arg(long, value_name = "WxH", default_value = "1280x960", value_parser = picture_size)]
    view_size: [u32; 2],
    /// Horizontal field of view of viewer.png, degrees
    #[arg(long, value_name = "DEGREES", default_value_t = 90.0,
          value_parser = within(1.0..=179.0, "degrees from 1 to 179, such as 90"))]
    view_fov: f64,
}

impl ViewArguments {
    /// Returns the views of the eyes, for directions forward and up.
    pub fn cameras(
        &self,
        eyes: &[Observer],
        (forward, up): (DVec3, DVec3),
    ) -> Result<Vec<ViewerCamera>, Failure> {
        let (field_of_view, size) = (self.view_fov.to_radians(), self.view_size);
        let camera = |eye: &Observer| {
            ViewerCamera::new(eye.place, forward, up, field_of_view, size).or_fail()
        };
        eyes.iter().map(camera).collect()
    }
}

//! Arguments of commands that show a scene to a viewer in a room.

use crate::cave::look::{Point, ViewDirection};
use crate::cave::{Cave, DEFAULT_INTERPUPILLARY_DISTANCE, Eye, Viewer, Wall};
use crate::cli::arguments::{HeadReport, WallsName, interpupillary_distance, whole};
use crate::cli::output::failure::Failure;
use crate::show::stereo::Stereo;
use clap::Args;
use glam::DVec3;
use shisen_core::gaze::HeadPose;

/// The room, and who is in it.
#[derive(Debug, Clone, Args)]
pub struct RoomArguments {
    /// three-wall (front, right and floor), cube, dome (a hemisphere of 2.5 m
    /// over the floor, its centre 1.5 m under the origin), or a TOML file of
    /// walls and domes
    #[arg(long, value_name = "NAME|FILE", default_value = "three-wall",
          value_parser = WallsName::parser())]
    walls: WallsName,
    /// Pixels along each side of a wall or dome that does not say itself
    #[arg(long, value_name = "PIXELS", default_value_t = 256,
          value_parser = whole::<u32>(1..=Wall::MOST_PIXELS))]
    pub size: u32,
    /// One eye in the middle of the head, or two
    #[arg(long, value_name = "1|2", default_value_t = 2,
          value_parser = whole::<u8>(1..=2))]
    eyes: u8,
    /// Where the head is: metres, in the room
    #[arg(
        long,
        value_name = "X,Y,Z",
        default_value = "0,0,0",
        allow_hyphen_values = true
    )]
    head: Point,
    /// How the head is turned: an OSVR HDK report of 16 or 32 bytes, in
    /// hexadecimal
    #[arg(long, value_name = "HEX", allow_hyphen_values = true)]
    head_report: Option<HeadReport>,
    /// Where the viewer looks: front, floor, right, left, back, ceiling,
    /// YAW,PITCH in degrees (right and up are positive) or a direction X,Y,Z
    /// [default: as --head-report, or else front]
    #[arg(long, value_name = "DIRECTION", allow_hyphen_values = true)]
    look: Option<ViewDirection>,
    /// Between the pupils: metres
    #[arg(long, value_name = "METRES", default_value_t = DEFAULT_INTERPUPILLARY_DISTANCE,
          allow_hyphen_values = true, value_parser = interpupillary_distance)]
    ipd: f64,
}

impl RoomArguments {
    /// The room.
    ///
    /// # Errors
    /// A room that there is not, or a file that describes none.
    pub fn cave(&self) -> Result<Cave, Failure> {
        self.walls.cave([self.size; 2])
    }

    /// The head: metres, in the room.
    pub fn head(&self) -> HeadPose {
        let position = self.head.0.as_vec3();
        match self.head_report {
            Some(report) => report.pose_at(position),
            None => HeadPose {
                position,
                ..HeadPose::IDENTITY
            },
        }
    }

    /// The eyes and where they are: metres, in the room.
    pub fn eyes(&self, pose: HeadPose) -> impl Iterator<Item = (Eye, DVec3)> + Clone + use<> {
        let viewer = Viewer {
            pose,
            interpupillary_distance: self.ipd,
        };
        let which: &'static [Eye] = if self.eyes == 1 {
            &[Eye::Centre]
        } else {
            &Eye::STEREO
        };
        which.iter().map(move |&eye| (eye, viewer.eye(eye)))
    }

    /// Whether there are the eyes that a pair of pictures is of.
    ///
    /// # Errors
    /// Of usage, where there is one.
    pub fn check_stereo(&self, stereo: Stereo) -> Result<(), Failure> {
        if stereo != Stereo::Mono && self.eyes == 1 {
            return Err(Failure::usage(&format!(
                "--stereo {stereo} takes two eyes: leave --eyes 1 out"
            )));
        }
        Ok(())
    }

    /// Whether somebody said where the viewer looks.
    pub const fn says_where_to_look(&self) -> bool {
        self.look.is_some()
    }

    /// Where the viewer looks, and what is up then. A head that a tracker measured
    /// may be tilted; a direction that somebody gives is looked at upright.
    pub fn directions(&self, pose: HeadPose) -> (DVec3, DVec3) {
        match (self.look, self.head_report) {
            (None, Some(_)) => {
                let room_from_head = pose.orientation.as_dquat();
                (room_from_head * DVec3::NEG_Z, room_from_head * DVec3::Y)
            }
            (look, _) => {
                let basis = look.unwrap_or(ViewDirection::FRONT).basis();
                (basis.forward, basis.up)
            }
        }
    }
}

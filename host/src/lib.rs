//! Shisen on a computer: meshes and scenes in, CAVE walls out.
//!
//! The library behind the `shisen` command. It imports and bakes scenes, places walls and eyes,
//! gives tiles to threads and writes files. [`shisen_core`] computes the pixels, and
//! [`shisen_tracker`] finds out where the viewer looks.
//!
//! ```
//! use shisen::bake::{BakedScene, Layout};
//! use shisen::cave::{BuiltInCave, Cave, Eye, Viewer};
//! use shisen::scene::quadruped::quadruped;
//! use shisen::render::{self, Observer, Options};
//! use shisen::scene::builtin::{PaperScene, paper_scene};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let baked = BakedScene::new(&paper_scene(PaperScene::D, quadruped())?, None, Layout::Fast)?;
//! let room = Cave::built_in(BuiltInCave::ThreeWall, [16, 16])?;
//! let viewer = Viewer::default();
//! let eyes = Eye::STEREO.map(|eye| Observer::new(eye, viewer.eye(eye)));
//! let frame = render::cave(baked.scene(), &room, &eyes, &Options::default(), &|_, _| {})?;
//! assert_eq!(frame.pictures.len(), 6);
//! assert_eq!(frame.statistics.primary, 6 * 16 * 16);
//! # Ok(())
//! # }
//! ```
//!
//! The folder `examples` has more: a wall, a dome master, and a loop that follows a
//! tracker within a budget.
//!
//! # Architecture
//!
//! Data go one way, from the tracker to the walls:
//!
//! ```text
//!  bytes of a tracker        meshes, scene files           walls, domes, viewer
//!         │                          │                              │
//! ┌───────▼────────┐        ┌────────▼────────┐                     │
//! │ shisen-tracker │        │ import, scene   │ host                │
//! │ decoder        │        │ simplify, bake  │                     │
//! │ clock          │        └────────┬────────┘                     │
//! │ estimate       │                 │ bytes: file, flash           │
//! └───────┬────────┘        ┌────────▼────────┐                     │
//!         │ line of sight,  │ scene  checked  │ shisen-core         │
//!         │ head, how sure  │        once     │                     │
//!         │                 │ trace  rays     │             ┌───────▼───────┐
//!         └──────► gaze ────► frame  tiles    ◄──── View ───┤ cave, dome    │ host
//!                           └────────┬────────┘             └───────────────┘
//!                                    │ pixels, steps spent
//!                           ┌────────▼────────┐
//!                           │ render  threads │ host
//!                           │ live    budget  ├─────► PNG, EXR, window, other machines
//!                           └────────┬────────┘
//!                                    │ pictures of screens
//!                           ┌────────▼────────┐
//!                           │ projection      │ host
//!                           │ outputs refresh ├─────► monitors, projectors
//!                           └─────────────────┘
//! ```
//!
//! The core depends on neither of the others, the driver on the core for the types of the gaze (and
//! of the pixels that a display controller sends by `link`), and this crate on both. `core/capi` is
//! the core and the driver for C, and `tests/firmware` both on a Cortex-M7, in place of this crate.
//!
//! # The reasons
//!
//! - **A scene is bytes.** What takes memory and time (trees, polygon levels) is done once,
//!   here; the core checks the bytes once and borrows them, from a file or from flash. So
//!   it needs no allocator, and after the check nothing can be out of range.
//! - **Work is counted, time is not.** A step is a tree node visited or a primitive tested.
//!   A frame that is bounded in steps is the same on every machine, can be tested, and
//!   runs where there is no clock. [`live`] turns seconds into steps by a measured rate.
//! - **The same bits everywhere.** Lanes and threads compute the scalar formula; nothing
//!   depends on their number. So machines that share a frame never disagree at a seam, and
//!   a Cortex-M7 is tested against a desk.
//! - **Detail follows the gaze by a number.** A ray's level, 0 to 1, says how often it
//!   bounces and which version of a mesh it sees; versions stand side by side in the bytes,
//!   so choosing one costs a ray nothing.
//! - **Mirrors for dome masters are optics, not objects.** They turn pixels into rays, so
//!   they cast no shadow and are in no reflection.
//! - **The caller owns all memory** in the core and the driver: pixels, workspaces, the
//!   records of a tracker. What firmware needs is known before it runs.
//!
//! # Features
//!
//! | Feature | What it adds |
//! |---|---|
//! | `window`, by default | the window of `shisen run` and outputs on monitors, on Unix: X servers, and on Linux graphics cards |
//! | `cluster` | `live::Mpi`: walls on several machines; links a library of the system's for MPI |

/// Gives an enum its variants in order, and their names on command lines and in reports.
macro_rules! named {
    ($type:ident { $($variant:ident => $name:literal),+ $(,)? }) => {
        impl $type {
            /// All of them, in order.
            pub const ALL: [Self; [$($name),+].len()] = [$(Self::$variant),+];

            /// Returns the name on command lines and in reports.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)+
                }
            }
        }
    };
}

pub mod bake;
pub mod cave;
#[doc(hidden)]
pub mod cli;
pub mod dome;
pub mod files;
pub mod live;
pub mod outputs;
pub mod picture;
pub mod projection;
pub mod record;
pub mod render;
pub mod scene;
pub mod show;
pub mod tracker;

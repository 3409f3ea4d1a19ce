//! Baked scenes whose layout is known only when the program runs.

use super::blob::AlignedBytes;
use super::{BakeError, Baked, Progress};
use crate::bake::simplify::PolygonLevels;
use crate::scene::Scene;
use shisen_core::Simd;
use shisen_core::scene::format::Header;
use shisen_core::scene::{self as core, EffectSet, Records, SceneError};
use shisen_core::spectrum::Medium;
use std::io::{self, Read};
use zerocopy::FromBytes as _;

/// Evaluates an expression with the core's [`Scene`](shisen_core::scene::Scene) in an
/// [`AnyScene`](crate::bake::AnyScene). The expression is compiled for both layouts, so it can
/// call functions that are generic over the width of nodes.
///
/// ```
/// use shisen::bake::{BakedScene, Layout, lone_mesh};
/// use shisen::scene::quadruped::quadruped;
/// use shisen::with_scene;
///
/// # fn main() -> Result<(), shisen::bake::BakeError> {
/// let baked = BakedScene::new(&lone_mesh(quadruped()), None, Layout::Compact)?;
/// let bytes = with_scene!(baked.scene(), |scene| scene.byte_len());
/// assert_eq!(bytes as usize, baked.as_bytes().len());
/// # Ok(())
/// # }
/// ```
#[macro_export]
macro_rules! with_scene {
    ($any:expr, |$scene:ident| $value:expr) => {
        match $any {
            $crate::bake::AnyScene::Fast($scene) => $value,
            $crate::bake::AnyScene::Compact($scene) => $value,
        }
    };
}

/// Which of the two layouts a scene is baked in. Both give the same pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layout {
    /// Nodes of eight children, for processors with wide vectors.
    Fast,
    /// Nodes of four children, for microcontrollers.
    Compact,
}

named!(Layout { Fast => "fast", Compact => "compact" });

impl Layout {
    /// Returns the default number of polygon levels. Pixels see faces within 5 % of the range from
    /// the number that their level asks for; with more levels, blocks of pixels share a mesh more
    /// often and are traced together. The compact layout has fewer, to save bytes.
    pub const fn polygon_levels(self) -> u32 {
        match self {
            Self::Fast => 19,
            Self::Compact => 12,
        }
    }

    /// Returns the instruction set that traces scenes of this layout: `asked`, if it can.
    pub const fn simd(self, asked: Simd) -> Simd {
        match self {
            Self::Fast => asked,
            // Four lanes have the portable path only.
            Self::Compact => Simd::PORTABLE,
        }
    }
}

/// A baked scene of either layout.
#[derive(Debug, Clone, PartialEq)]
pub enum BakedScene {
    /// A scene in [`Layout::Fast`].
    Fast(Baked<8>),
    /// A scene in [`Layout::Compact`].
    Compact(Baked<4>),
}

/// A scene of either layout, as the core traces it.
#[derive(Debug, Clone, Copy)]
pub enum AnyScene<'a> {
    /// A scene in [`Layout::Fast`].
    Fast(core::FastScene<'a>),
    /// A scene in [`Layout::Compact`].
    Compact(core::CompactScene<'a>),
}

impl<'a> From<core::FastScene<'a>> for AnyScene<'a> {
    fn from(scene: core::FastScene<'a>) -> Self {
        Self::Fast(scene)
    }
}

impl<'a> From<core::CompactScene<'a>> for AnyScene<'a> {
    fn from(scene: core::CompactScene<'a>) -> Self {
        Self::Compact(scene)
    }
}

impl BakedScene {
    /// Bakes a scene, each mesh at several polygon levels if any are given. The same scene always
    /// gives the same bytes.
    ///
    /// # Errors
    /// As [`Baked::with_levels`].
    pub fn new(
        scene: &Scene,
        levels: Option<&PolygonLevels>,
        layout: Layout,
    ) -> Result<Self, BakeError> {
        Self::with_progress(scene, levels, layout, &|_, _| ())
    }

    /// As [`new`](Self::new); `progress` hears how far it is.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with_progress(
        scene: &Scene,
        levels: Option<&PolygonLevels>,
        layout: Layout,
        progress: &Progress<'_>,
    ) -> Result<Self, BakeError> {
        match layout {
            Layout::Fast => Baked::bake(scene, levels, progress).map(Self::Fast),
            Layout::Compact => Baked::bake(scene, levels, progress).map(Self::Compact),
        }
    }

    /// Takes the bytes of a scene file, aligning them.
    ///
    /// # Errors
    /// What the core finds wrong with them.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, SceneError> {
        match Baked::from_bytes(bytes) {
            Err(SceneError::Width { found: 4, .. }) => Baked::from_bytes(bytes).map(Self::Compact),
            fast => fast.map(Self::Fast),
        }
    }

    /// Reads as many bytes of a scene file into place.
    ///
    /// # Errors
    /// What the system says, and what the core finds wrong with them.
    pub(crate) fn read(from: &mut impl Read, length: usize) -> io::Result<Self> {
        let bytes = AlignedBytes::read(from, length)?;
        match Baked::from_aligned(bytes) {
            Err((bytes, SceneError::Width { found: 4, .. })) => {
                Baked::from_aligned(bytes).map(Self::Compact)
            }
            fast => fast.map(Self::Fast),
        }
        .map_err(|(_, fault)| io::Error::other(fault))
    }

    /// Returns the scene, to be traced.
    pub fn scene(&self) -> AnyScene<'_> {
        match self {
            Self::Fast(baked) => AnyScene::Fast(baked.scene()),
            Self::Compact(baked) => AnyScene::Compact(baked.scene()),
        }
    }

    /// Returns the layout it is in.
    pub const fn layout(&self) -> Layout {
        match self {
            Self::Fast(_) => Layout::Fast,
            Self::Compact(_) => Layout::Compact,
        }
    }

    /// Returns the bytes, as they go to a file or to flash.
    pub fn as_bytes(&self) -> &[u8] {
        match self {
            Self::Fast(baked) => baked.as_bytes(),
            Self::Compact(baked) => baked.as_bytes(),
        }
    }

    /// Returns the effects that it asks for.
    pub fn effects(&self) -> EffectSet {
        // The whole is checked already, and may be large.
        let header = Header::read_from_prefix(self.as_bytes());
        let bits = header.map_or(0, |(header, _)| header.effects);
        EffectSet::from_bits_truncate(bits)
    }

    /// Returns the records of the scene that ask for its effects.
    pub fn records(&self) -> Records<'_> {
        with_scene!(self.scene(), |scene| scene.records())
    }

    /// Returns the dispersive media of its materials.
    pub fn media(&self) -> &[Medium] {
        with_scene!(self.scene(), |scene| scene.media())
    }
}

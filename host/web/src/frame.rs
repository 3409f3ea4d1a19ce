//! The description of a frame: what decides its pixels, without the room and its viewer.
//!
//! It is words of four bytes, the lowest first, whole numbers or f32:
//!
//! | Words | Content |
//! |---|---|
//! | 1 | version, 2 |
//! | 1 | depth |
//! | 1 | samples of a pixel |
//! | 1 | effects' bits |
//! | 1 | what follows the gaze: 0 nothing, 1 the paper's levels, 2 these with half-ellipses, 3 acuity |
//! | 1 | f32 the level at which faces are cut off |
//! | 5 | f32 radii of the field: central, up, down, left, right; radians |
//! | 5 | f32 acuity: slope, least angle, how much wider, factor beyond, from where on |
//! | 4 | number of wavelengths, 0 where none is dispersed; f32 from, to, nanometres; of each sample |
//! | 1 | number of pictures |
//! | 27 each | 0 for a flat screen: f32 eye, first pixel, column step, row step, 3 each; 1 for a dome master: f32 place, right, top, back; columns, rows; f32 place, forward, right, up of the line of sight, 3 each, or right 0 where the axes follow from any forward and up |
//! | 1 | number of moved objects |
//! | 25 each | object; f64 of the columns of its map, the last its place |
//! | 1 | number of tiles that a budget cut off |
//! | 6 each | picture, x, y, width, height; its pixels that were done |

use alloc::vec;
use alloc::vec::Vec;
use glam::{DAffine3, Mat3, Vec3};
use shisen_core::Simd;
use shisen_core::frame::{
    Budget, CompactRenderer, DomePose, DomeProjection, LevelOfDetail, Outcome, Pixel, Renderer,
    Settings, Spectrum, Tile, TileJob, View, Workspace,
};
use shisen_core::gaze::{Acuity, Boundary, Gaze, LineOfSight, VisualField, VisualFieldLimits};
use shisen_core::scene::format::{Instance, Node};
use shisen_core::scene::{CompactScene, EffectSet, Poses};
use shisen_core::spectrum::{Matching, SpectralSample, SpectralTable, Wavelengths};
use zerocopy::FromZeros as _;

type Moved = Poses<'static, 'static, 4>;

/// A frame that is ready to be rendered.
pub(crate) struct Frame {
    pictures: Vec<(View, CompactRenderer<'static>)>,
    /// The gaze of each picture's levels.
    gazes: Vec<Option<Gaze>>,
    /// Its scene where something moves.
    moved: Option<Moved>,
    cuts: Vec<(u32, Tile, u32)>,
    /// The wavelengths, and what they are by.
    table: Option<(Wavelengths, SpectralTable<'static>)>,
}

/// The words that are not read yet.
struct Words<'a>(&'a [u8]);

impl Words<'_> {
    fn bytes(&mut self) -> Option<[u8; 4]> {
        let (bytes, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*bytes)
    }

    fn whole(&mut self) -> Option<u32> {
        self.bytes().map(u32::from_le_bytes)
    }

    fn double(&mut self) -> Option<f64> {
        let (bytes, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(f64::from_le_bytes(*bytes))
    }

    fn number(&mut self) -> Option<f32> {
        self.bytes().map(f32::from_le_bytes)
    }

    fn numbers<const N: usize>(&mut self) -> Option<[f32; N]> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = self.number()?;
        }
        Some(numbers)
    }

    fn vector(&mut self) -> Option<Vec3> {
        self.numbers().map(Vec3::from_array)
    }
}

type Table = (Wavelengths, SpectralTable<'static>);

/// Reads the wavelengths of dispersion; `known` are those of the frame before.
fn wavelengths(
    words: &mut Words<'_>,
    known: Option<Table>,
) -> Option<Option<(Wavelengths, SpectralTable<'static>, u8)>> {
    let count = words.whole()?;
    let range = words.numbers()?;
    let each = u8::try_from(words.whole()?).ok()?;
    if count == 0 {
        return Some(None);
    }
    let wavelengths = Wavelengths::new(count, range).ok()?;
    let known = known.filter(|(of, _)| *of == wavelengths);
    let (_, table) = known.or_else(|| {
        let phases = SpectralTable::COMB_PHASES;
        let samples = SpectralTable::samples(wavelengths, phases);
        // It stays as long as the instance.
        let samples = vec![SpectralSample::default(); samples].leak();
        let table = SpectralTable::new(wavelengths, phases, Matching::Wyman, samples);
        Some((wavelengths, table.ok()?))
    })?;
    Some(Some((wavelengths, table, each)))
}

/// Returns the rays of a flat screen, or of a dome master.
fn view(kind: u32, [first, second, third, fourth]: [Vec3; 4], size: [u32; 2]) -> Option<View> {
    if kind == 0 {
        return View::new(first, second, third, fourth, size).ok();
    }
    let pose = DomePose {
        position: first,
        room_from_capture: Mat3::from_cols(second, third, fourth),
    };
    let field_of_view = core::f32::consts::PI;
    View::dome(DomeProjection::Equidistant { field_of_view }, pose, size[0]).ok()
}

/// Detail that follows a line of sight.
enum Detail {
    None,
    Levels(VisualField),
    Acuity(Acuity),
}

impl Frame {
    /// Reads a frame of a scene; `None` for one that cannot be. `old` lends its memory.
    pub(crate) fn read(
        scene: CompactScene<'static>,
        bytes: &[u8],
        old: Option<Self>,
    ) -> Option<Self> {
        let mut words = Words(bytes);
        let (2, depth, samples) = (words.whole()?, words.whole()?, words.whole()?) else {
            return None;
        };
        let settings = Settings {
            depth: u8::try_from(depth).ok()?,
            samples: u16::try_from(samples).ok()?,
            ..Settings::default()
        };
        let effects = EffectSet::from_bits_truncate(words.whole()?);
        let follows = words.whole()?;
        let faces = words.number()?;
        let [central, up, down, left, right] = words.numbers()?;
        let limits = VisualFieldLimits {
            central,
            up,
            down,
            left,
            right,
        };
        let [slope, least, off, factor, from] = words.numbers()?;
        let detail = match follows {
            0 => Detail::None,
            1 => Detail::Levels(VisualField::new(limits, Boundary::Printed).ok()?),
            2 => Detail::Levels(VisualField::new(limits, Boundary::Ellipse).ok()?),
            3 => {
                let acuity = Acuity::new(slope, least).ok()?;
                Detail::Acuity(acuity.around(off).steeper_beyond(factor, from))
            }
            _ => return None,
        };
        let wanted = effects.intersection(scene.effects());
        let renderer = Renderer::smallest(scene, Simd::detect(), settings, wanted);
        let renderer = renderer.without(EffectSet::ALL.difference(wanted));
        let renderer = renderer.with_faces_of_level(faces);
        let (old, known) = old.map_or((None, None), |old| (old.moved, old.table));
        let table = wavelengths(&mut words, known)?;
        let renderer = match table {
            Some((_, table, each)) if scene.effects().intersects(EffectSet::DISPERSION) => {
                let spectrum = Spectrum::Comb { table, each };
                renderer.with_spectrum(spectrum).ok()?
            }
            _ => renderer,
        };
        let (mut pictures, mut gazes) = (Vec::new(), Vec::new());
        for _ in 0..words.whole()? {
            let kind = words.whole()?;
            let vectors = [
                words.vector()?,
                words.vector()?,
                words.vector()?,
                words.vector()?,
            ];
            let size = [words.whole()?, words.whole()?];
            let view = view(kind, vectors, size)?;
            let [place, forward] = [words.vector()?, words.vector()?];
            let [right, up] = [words.vector()?, words.vector()?];
            let sight = if right == Vec3::ZERO {
                LineOfSight::new(place, forward, up)
            } else {
                LineOfSight::from_axes(place, forward, right, up)
            };
            let mut of_levels = None;
            let renderer = match &detail {
                Detail::None => renderer,
                Detail::Levels(field) => {
                    let gaze = *of_levels.insert(Gaze::new(sight.ok()?, *field));
                    renderer.with_level_of_detail(LevelOfDetail::new(gaze))
                }
                Detail::Acuity(acuity) => renderer.with_foveation(sight.ok()?, *acuity),
            };
            gazes.push(of_levels);
            pictures.push((view, renderer));
        }
        let moved = move_objects(scene, &mut words, old)?;
        let mut cuts = Vec::new();
        for _ in 0..words.whole()? {
            let picture = words.whole()?;
            let tile = Tile {
                x: words.whole()?,
                y: words.whole()?,
                width: words.whole()?,
                height: words.whole()?,
            };
            cuts.push((picture, tile, words.whole()?));
        }
        Some(Self {
            pictures,
            gazes,
            moved,
            cuts,
            table: table.map(|(wavelengths, table, _)| (wavelengths, table)),
        })
    }

    /// Returns the rays and the renderer of a picture.
    pub(crate) fn picture(&self, number: u32) -> Option<(&View, CompactRenderer<'_>)> {
        let (view, renderer) = self.pictures.get(number as usize)?;
        let moved = self.moved.as_ref();
        Some((
            view,
            moved.map_or(*renderer, |moved| renderer.posed(moved.scene())),
        ))
    }

    /// Renders a tile of a picture within a budget, and gives up what that does not reach, or what
    /// the frame's own did not. Returns whether it was finished; `None` for no tile of a picture.
    pub(crate) fn render(
        &self,
        (picture, tile): (u32, Tile),
        pixels: &mut [Pixel],
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> Option<bool> {
        let (view, renderer) = self.picture(picture)?;
        let mut cuts = self.cuts.iter();
        let cut = cuts.find(|(of, other, _)| (*of, *other) == (picture, tile));
        let mut job = cut.map_or(TileJob::new(tile), |(_, _, kept)| TileJob::cut(tile, *kept));
        let outcome = job.render(&renderer, view, pixels, budget, workspace);
        let is_whole = outcome.ok()? == Outcome::Finished;
        if cut.is_some() || !is_whole {
            job.give_up(&renderer, view, pixels).ok()?;
        }
        Some(is_whole)
    }

    /// Returns the detail of a pixel: see [`detail`](crate::detail).
    pub(crate) fn detail(&self, picture: u32, x: u32, y: u32) -> f32 {
        let Some((view, renderer)) = self.pictures.get(picture as usize) else {
            return 1.0;
        };
        match self.gazes.get(picture as usize) {
            Some(Some(gaze)) => {
                let towards = view.direction(x as f32, y as f32);
                towards.and_then(|to| gaze.level(to)).unwrap_or(0.0)
            }
            _ => renderer.unit(view, x, y) as f32,
        }
    }
}

/// Moves objects of a scene; `None` inside where none moves.
fn move_objects(
    scene: CompactScene<'static>,
    words: &mut Words<'_>,
    old: Option<Moved>,
) -> Option<Option<Moved>> {
    let count = words.whole()?;
    if count == 0 {
        return Some(None);
    }
    let mut poses = match old {
        Some(poses) => poses,
        // It stays as long as the instance.
        None => {
            let top: Vec<Node<4>> = vec![Node::new_zeroed(); scene.top_nodes()];
            let own: Vec<Instance> = vec![Instance::new_zeroed(); scene.instances().len()];
            Poses::new(scene, top.leak(), own.leak()).ok()?
        }
    };
    for _ in 0..count {
        let object = words.whole()? as usize;
        let mut map = [0.0; 12];
        for number in &mut map {
            *number = words.double()?;
        }
        poses.set(object, &DAffine3::from_cols_array(&map)).ok()?;
    }
    poses.refit();
    Some(Some(poses))
}

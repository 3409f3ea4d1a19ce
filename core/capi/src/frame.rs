//! Frames: several screens, or a dome master, tile by tile within a budget.

use crate::dome::Dome;
use crate::memory::{exclusive, needed, room, shared, slice, slice_mut, write};
use crate::scene::{EFFECTS, Scene, WIDTH};
use crate::screen::Screen;
use crate::spectrum::{Spectrum, with_wavelengths};
use crate::status::{Status, settled};
use crate::tracker::Gaze;
use core::ffi::c_void;
use core::ptr::{null, null_mut};
use glam::Vec3;
use shisen_core::Simd;
use shisen_core::frame::{
    Budget, FrameJob, LevelOfDetail, MAX_DEPTH, MAX_SAMPLES, Mode, Pictures, Place, Progress,
    Renderer, Settings, View, Workspace,
};
use shisen_core::gaze::{LineOfSight, VisualField};

/// Bytes of memory for a frame's handle, without its pictures and tiles.
#[cfg(target_pointer_width = "32")]
pub const SHISEN_FRAME_SIZE: usize = 2712;
/// Bytes of memory for a frame's handle, without its pictures and tiles.
#[cfg(target_pointer_width = "64")]
pub const SHISEN_FRAME_SIZE: usize = 2896;
/// Bytes of memory for each picture of a frame's handle.
#[cfg(target_pointer_width = "32")]
pub const SHISEN_PICTURE_SIZE: usize = 128;
/// Bytes of memory for each picture of a frame's handle.
#[cfg(target_pointer_width = "64")]
pub const SHISEN_PICTURE_SIZE: usize = 128;
/// Bytes of memory for each tile of a frame's handle.
pub const SHISEN_TILE_SIZE: usize = 12;
/// Most pixels a side of a tile.
pub const SHISEN_LARGEST_TILE: u32 = 256;
/// A budget that no frame spends.
pub const SHISEN_UNLIMITED: u64 = u64::MAX;

const _: () = assert!(needed::<Frame>() <= SHISEN_FRAME_SIZE);
const _: () = assert!(size_of::<View>() <= SHISEN_PICTURE_SIZE);
const _: () = assert!(size_of::<Place>() <= SHISEN_TILE_SIZE);
// Pictures follow the frame, and tiles the pictures.
const _: () = assert!(SHISEN_FRAME_SIZE.is_multiple_of(align_of::<View>()));
const _: () = assert!(align_of::<View>() <= align_of::<Frame>());
const _: () = assert!(align_of::<Place>() <= align_of::<View>());
const _: () = assert!(FrameJob::LARGEST_TILE == SHISEN_LARGEST_TILE);
const _: () = assert!(size_of::<Pixel>() == size_of::<shisen_core::frame::Pixel>());
const _: () = assert!(align_of::<Pixel>() == align_of::<shisen_core::frame::Pixel>());

/// A frame on its way to being finished. It refers to its scene and spectrum,
/// and to itself: none of them may move.
pub struct Frame {
    job: FrameJob<'static>,
    workspace: Workspace,
    pictures: Shown,
}

/// The pictures of a frame, all of one eye.
struct Shown {
    renderer: Renderer<'static, WIDTH>,
    /// The views, which lie in the memory behind the frame.
    views: &'static [View],
}

impl Pictures<'static, WIDTH> for Shown {
    fn count(&self) -> usize {
        self.views.len()
    }

    fn view(&self, number: usize) -> Option<View> {
        self.views.get(number).copied()
    }

    fn renderer(&self, number: usize) -> Option<&Renderer<'static, WIDTH>> {
        (number < self.views.len()).then_some(&self.renderer)
    }
}

/// Quality and cost of a frame: see shisen_frame_settings_init.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct FrameSettings {
    /// Most reflections and refractions in a row, 0 to 16.
    pub depth: u32,
    /// Rays a pixel, 1 to 4,096.
    pub samples: u32,
    /// Pixels a side of a tile, 1 to 256.
    pub tile_side: u32,
    /// Whether the level of detail follows the gaze (1), or all is rendered in
    /// full detail (0).
    pub follow_gaze: u32,
    /// Steps that the whole frame may take: one for each node visited, one for each
    /// primitive tested. Pixels that the budget does not reach show the background.
    pub budget: u64,
    /// The wavelengths of dispersion. NULL: glass bends all wavelengths alike.
    pub spectrum: *const Spectrum,
}

/// A pixel: linear light with sRGB's primaries, 1 being white, premultiplied by
/// coverage.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct Pixel {
    /// Red.
    pub red: f32,
    /// Green.
    pub green: f32,
    /// Blue.
    pub blue: f32,
    /// Coverage: 0 where only a transparent background is seen, 1 where none is.
    pub alpha: f32,
}

/// A finished tile.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C)]
pub struct Tile {
    /// The index of its screen when the frame was begun; 0 for a dome master.
    pub picture: u32,
    /// Its first column.
    pub x: u32,
    /// Its first row.
    pub y: u32,
    /// Pixels in a row: the side of tiles, or less at the picture's border.
    pub columns: u32,
    /// Pixels in a column: the side of tiles, or less at the picture's border.
    pub rows: u32,
    /// Whether all its pixels were traced (1); if the budget did not last (0),
    /// some or all of them show the background.
    pub whole: u32,
}

/// Counts of what a frame has done so far.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct FrameCounts {
    /// Rays from the eye.
    pub primary_rays: u64,
    /// Rays reflected by mirrors and glass.
    pub reflected_rays: u64,
    /// Rays into and out of glass.
    pub refracted_rays: u64,
    /// Rays to lights.
    pub shadow_rays: u64,
    /// Nodes visited and primitives tested.
    pub steps: u64,
    /// Steps left of the frame's budget.
    pub budget_left: u64,
    /// Tiles handed over all of whose pixels were traced.
    pub tiles_whole: u32,
    /// Tiles handed over that the frame's budget did not finish.
    pub tiles_given_up: u32,
}

/// Returns how many tiles of `side`² pixels a picture of `columns` by `rows` pixels
/// has: the function for the macro SHISEN_TILES.
#[unsafe(no_mangle)]
pub extern "C" fn shisen_tiles(columns: u32, rows: u32, side: u32) -> usize {
    FrameJob::tiles_of(core::iter::once([columns, rows]), side)
}

/// Returns the bytes of memory for the handle of a frame with `pictures` pictures
/// and `tiles` tiles in all: the function for the macro SHISEN_FRAME_BYTES.
#[unsafe(no_mangle)]
pub extern "C" fn shisen_frame_size(pictures: usize, tiles: usize) -> usize {
    let pictures = pictures.saturating_mul(SHISEN_PICTURE_SIZE);
    let tiles = tiles.saturating_mul(SHISEN_TILE_SIZE);
    SHISEN_FRAME_SIZE
        .saturating_add(pictures)
        .saturating_add(tiles)
}

/// Writes the default settings: three bounces, one ray a pixel, tiles of 16 pixels, a
/// level of detail that follows the gaze, no limit.
///
/// # Safety
/// `settings` is NULL, misaligned, or points to memory for one FrameSettings.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn shisen_frame_settings_init(settings: *mut FrameSettings) -> Status {
    settled(|| {
        let usual = Settings::default();
        let usual = FrameSettings {
            depth: usual.depth.into(),
            samples: usual.samples.into(),
            tile_side: 16,
            follow_gaze: 1,
            budget: SHISEN_UNLIMITED,
            spectrum: null(),
        };
        // SAFETY: as promised above.
        unsafe { write(settings, usual) }
    })
}

/// Checks that a screen can be seen from `eye`: metres, in the room. A frame
/// cannot begin with a screen that fails this.
/// cbindgen:ptrs-as-arrays=[[eye;3]]
///
/// # Safety
/// `screen` is NULL, misaligned, or points to a screen; `eye` is NULL, misaligned,
/// or points to three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn shisen_screen_check(screen: *const Screen, eye: *const f32) -> Status {
    settled(|| {
        // SAFETY: as promised above.
        let (screen, eye) = unsafe { (shared(screen)?, place(eye)?) };
        screen.flat().view_from(eye)?;
        Ok(Status::Ok)
    })
}

/// Begins a frame of one eye's view of some screens. Its tiles go from the line
/// of sight outwards, on all screens together; without a gaze by screen, row and
/// column. This call sorts them, which takes time in proportion to their number
/// and counts against no budget.
///
/// `memory`, `memory_size`: for the handle, which needs SHISEN_FRAME_BYTES bytes
/// at a multiple of SHISEN_ALIGNMENT. The frame uses it until another is
/// begun in it; a frame may be abandoned at any time.
/// `screens`, `screen_count`: 1 to 65,535 of them; they are copied.
/// `eye`: metres, in the room.
/// `gaze`: that eye's gaze, of which the position is ignored. NULL if it is not
/// known: all is rendered in full detail.
/// `frame`: receives the handle; NULL after a failure.
/// cbindgen:ptrs-as-arrays=[[eye;3]]
///
/// # Safety
/// Each pointer is NULL, misaligned, or valid: `memory` for `memory_size` bytes,
/// `screens` for `screen_count` screens, `eye` for three numbers, the others for one
/// value. Nobody else uses that memory during the call. The scene's, the spectrum's
/// and the frame's memory neither moves nor changes while the frame is in use.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn shisen_frame_begin(
    memory: *mut c_void,
    memory_size: usize,
    scene: *const Scene,
    settings: *const FrameSettings,
    screens: *const Screen,
    screen_count: usize,
    eye: *const f32,
    gaze: *const Gaze,
    frame: *mut *mut Frame,
) -> Status {
    settled(|| {
        // SAFETY: as promised above.
        let (scene, settings, screens, eye) = unsafe {
            write(frame, null_mut())?;
            (
                shared(scene)?,
                shared(settings)?,
                slice(screens, screen_count)?,
                place(eye)?,
            )
        };
        // SAFETY: as promised above.
        let mut renderer = unsafe { renderer(scene, settings) }?;
        if !gaze.is_null() {
            // SAFETY: as promised above.
            let gaze = unsafe { shared(gaze) }?;
            let [forward, up] = [gaze.forward, gaze.up].map(Vec3::from_array);
            let sight = LineOfSight::new(eye, forward, up)?;
            if let (true, Some(field)) = (
                settings.follow_gaze != 0,
                VisualField::PAPER.wider(gaze.widen),
            ) {
                let gaze = shisen_core::gaze::Gaze::new(sight, field);
                renderer = renderer.with_level_of_detail(LevelOfDetail::new(gaze));
            }
        }
        let views = screens
            .iter()
            .map(|screen| Ok(screen.flat().view_from(eye)?));
        // SAFETY: as promised above.
        let handle = unsafe { begin(memory, memory_size, &renderer, settings, views) }?;
        // SAFETY: as promised above.
        unsafe { write(frame, handle) }
    })
}

/// Begins a frame that is one dome master, in full detail. Tiles go by row and
/// column. Parameters are those of shisen_frame_begin.
///
/// # Safety
/// The same as for shisen_frame_begin.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn shisen_frame_begin_dome(
    memory: *mut c_void,
    memory_size: usize,
    scene: *const Scene,
    settings: *const FrameSettings,
    dome: *const Dome,
    frame: *mut *mut Frame,
) -> Status {
    settled(|| {
        // SAFETY: as promised above.
        let (scene, settings, dome) = unsafe {
            write(frame, null_mut())?;
            (shared(scene)?, shared(settings)?, shared(dome)?)
        };
        // SAFETY: as promised above.
        let renderer = unsafe { renderer(scene, settings) }?;
        let views = core::iter::once_with(|| dome.view());
        // SAFETY: as promised above.
        let handle = unsafe { begin(memory, memory_size, &renderer, settings, views) }?;
        // SAFETY: as promised above.
        unsafe { write(frame, handle) }
    })
}

/// # Safety
/// `place` is NULL, misaligned, or points to three numbers.
unsafe fn place(place: *const f32) -> Result<Vec3, Status> {
    // SAFETY: as promised above.
    let place = unsafe { shared(place.cast::<[f32; 3]>()) }?;
    Ok(Vec3::from_array(*place))
}

/// # Safety
/// The settings' spectrum is null, misaligned, or one that was opened.
unsafe fn renderer(
    scene: &Scene,
    settings: &FrameSettings,
) -> Result<Renderer<'static, WIDTH>, Status> {
    let &FrameSettings { depth, samples, .. } = settings;
    if depth > MAX_DEPTH.into() || !(1..=u32::from(MAX_SAMPLES)).contains(&samples) {
        return Err(Status::FrameSettings);
    }
    let quality = Settings {
        depth: depth as u8,
        samples: samples as u16,
        mode: Mode::Single,
    };
    let renderer = Renderer::single::<EFFECTS>(scene.scene, Simd::PORTABLE, quality);
    if settings.spectrum.is_null() {
        return Ok(renderer);
    }
    // SAFETY: as promised above.
    let spectrum = unsafe { shared(settings.spectrum) }?;
    with_wavelengths(&renderer, spectrum)
}

/// Lays a frame out: the handle, its pictures, then the order of its tiles.
///
/// # Safety
/// `memory` is NULL, misaligned, or valid for `memory_size` bytes, and the frame's from now on.
unsafe fn begin(
    memory: *mut c_void,
    memory_size: usize,
    renderer: &Renderer<'static, WIDTH>,
    settings: &FrameSettings,
    views: impl ExactSizeIterator<Item = Result<View, Status>> + Clone,
) -> Result<*mut Frame, Status> {
    let count = views.len();
    if !(1..=usize::from(u16::MAX)).contains(&count) {
        return Err(Status::Pictures);
    }
    if !(1..=SHISEN_LARGEST_TILE).contains(&settings.tile_side) {
        return Err(Status::TileSize);
    }
    let mut tiles = 0usize;
    for view in views.clone() {
        let view = view?;
        let own = shisen_tiles(view.columns(), view.rows(), settings.tile_side);
        tiles = tiles.saturating_add(own);
    }
    let trailing = shisen_frame_size(count, tiles).saturating_sub(size_of::<Frame>());
    let handle = room::<Frame>(memory, memory_size, trailing)?;
    let shown = handle.wrapping_byte_add(SHISEN_FRAME_SIZE).cast::<View>();
    for (number, view) in views.enumerate() {
        // SAFETY: there is room.
        unsafe { shown.wrapping_add(number).write(view?) };
    }
    let places = shown.wrapping_add(count).cast::<Place>();
    for tile in 0..tiles {
        // SAFETY: there is room.
        unsafe { places.wrapping_add(tile).write(Place::default()) };
    }
    // SAFETY: they were just written, and are the frame's from now on.
    let (views, places) = unsafe { (slice(shown, count)?, slice_mut(places, tiles)?) };
    let pictures = Shown {
        renderer: *renderer,
        views,
    };
    let budget = Budget::steps(settings.budget);
    let job = FrameJob::new(&pictures, settings.tile_side, budget, places)?;
    // SAFETY: there is room.
    unsafe {
        (&raw mut (*handle).workspace).write(Workspace::new());
        (&raw mut (*handle).pictures).write(pictures);
        (&raw mut (*handle).job).write(job);
    }
    Ok(handle)
}

/// Renders until a tile is finished (SHISEN_STATUS_TILE: `tile` describes it), the
/// frame is finished (SHISEN_STATUS_FINISHED), or this call's budget is spent
/// (SHISEN_STATUS_BUDGET_SPENT: call again to go on). Tiles that the frame's
/// budget did not finish are handed over, too. A call takes at most its budget,
/// 16 steps of a block's test and the steps of one sample: its ray tree and, in tile
/// mode, a primary ray for each pixel of its block. The pixels do not depend on how
/// the frame was cut into calls.
///
/// `slice_budget`: steps that this call may take; 0 traces nothing.
/// `pixels`, `pixel_count`: room for a tile of `tile_side` squared pixels; a smaller
/// tile at a picture's border uses the first of them. The frame uses them until the
/// tile is finished, when they hold its rows, from the top, without gaps. They need
/// not be initialised.
///
/// # Safety
/// `frame` is NULL or a frame that was begun, used by nobody else during the call; `pixels`
/// is NULL, misaligned, or points to `pixel_count` pixels; `tile` is NULL,
/// misaligned, or points to memory for a tile.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn shisen_frame_render(
    frame: *mut Frame,
    slice_budget: u64,
    pixels: *mut Pixel,
    pixel_count: usize,
    tile: *mut Tile,
) -> Status {
    settled(|| {
        // SAFETY: as promised above; both kinds of pixels are four numbers.
        let (frame, pixels) = unsafe {
            write(tile, Tile::default())?;
            let pixels = slice_mut(pixels.cast::<shisen_core::frame::Pixel>(), pixel_count)?;
            (exclusive(frame)?, pixels)
        };
        let mut slice = Budget::steps(slice_budget);
        let Frame {
            job,
            workspace,
            pictures,
        } = frame;
        match job.render(pictures, pixels, &mut slice, workspace)? {
            Progress::BudgetSpent => Ok(Status::BudgetSpent),
            Progress::Finished => Ok(Status::Finished),
            Progress::Tile {
                part,
                tile: done,
                whole,
            } => {
                let done = Tile {
                    picture: part as u32,
                    x: done.x,
                    y: done.y,
                    columns: done.width,
                    rows: done.height,
                    whole: whole.into(),
                };
                // SAFETY: as promised above.
                unsafe { write(tile, done) }?;
                Ok(Status::Tile)
            }
        }
    })
}

/// Writes the counts of what a frame has done so far.
///
/// # Safety
/// `frame` is NULL or a frame that was begun; `counts` is NULL, misaligned, or
/// points to memory for one FrameCounts.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn shisen_frame_count(
    frame: *const Frame,
    counts: *mut FrameCounts,
) -> Status {
    settled(|| {
        // SAFETY: as promised above.
        let frame = unsafe { shared(frame) }?;
        let (statistics, tiles) = (&frame.workspace.statistics, frame.job.tiles());
        let found = FrameCounts {
            primary_rays: statistics.primary,
            reflected_rays: statistics.reflected,
            refracted_rays: statistics.refracted,
            shadow_rays: statistics.shadow,
            steps: statistics.steps,
            budget_left: frame.job.budget().left(),
            tiles_whole: tiles.whole,
            tiles_given_up: tiles.given_up,
        };
        // SAFETY: as promised above.
        unsafe { write(counts, found) }
    })
}

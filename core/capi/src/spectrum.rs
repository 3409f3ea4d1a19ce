//! The wavelengths of dispersion.

#[cfg(feature = "dispersion")]
use crate::memory::slice_mut;
use crate::memory::{needed, room, write};
use crate::scene::WIDTH;
use crate::status::{Status, settled};
use core::ffi::c_void;
use core::ptr::null_mut;
use shisen_core::frame::Renderer;
#[cfg(feature = "dispersion")]
use shisen_core::spectrum::Matching;
use shisen_core::spectrum::{SpectralSample, SpectralTable, Wavelengths};

/// Bytes of memory for a spectrum's handle, without its wavelengths.
pub const SHISEN_SPECTRUM_SIZE: usize = 32;
/// Bytes of memory for a wavelength of a spectrum's handle: `count` + 3 of them
/// are needed for each of the SHISEN_SPECTRUM_PHASES.
pub const SHISEN_WAVELENGTH_SIZE: usize = 16;
/// Offsets that the wavelengths are taken at.
pub const SHISEN_SPECTRUM_PHASES: u32 = 32;

/// Wavelengths that rays take in media that bend each of them their own way.
pub struct Spectrum {
    #[cfg(feature = "dispersion")]
    table: SpectralTable<'static>,
}

/// Returns the same renderer with these wavelengths.
#[cfg(feature = "dispersion")]
pub(crate) fn with_wavelengths<'a>(
    renderer: &Renderer<'a, WIDTH>,
    spectrum: &'a Spectrum,
) -> Result<Renderer<'a, WIDTH>, Status> {
    let spectrum = shisen_core::frame::Spectrum::Comb {
        table: spectrum.table,
        each: 1,
    };
    let renderer = renderer.with_spectrum(spectrum);
    renderer.map_err(|_| Status::WavelengthsOfMedium)
}

/// None: the feature is off.
#[cfg(not(feature = "dispersion"))]
pub(crate) fn with_wavelengths<'a>(
    _: &Renderer<'a, WIDTH>,
    _: &'a Spectrum,
) -> Result<Renderer<'a, WIDTH>, Status> {
    Err(Status::NotBuilt)
}

const _: () = assert!(needed::<Spectrum>() <= SHISEN_SPECTRUM_SIZE);
const _: () = assert!(size_of::<SpectralSample>() == SHISEN_WAVELENGTH_SIZE);
const _: () = assert!(SpectralTable::COMB_PHASES == SHISEN_SPECTRUM_PHASES);

/// Returns bytes of memory for the handle of a spectrum of `count` wavelengths.
#[unsafe(no_mangle)]
pub extern "C" fn shisen_spectrum_size(count: u32) -> usize {
    let samples = (count as usize).saturating_add(SpectralTable::BROAD);
    let samples = samples.saturating_mul(SHISEN_SPECTRUM_PHASES as usize);
    samples
        .saturating_mul(SHISEN_WAVELENGTH_SIZE)
        .saturating_add(SHISEN_SPECTRUM_SIZE)
}

/// Computes `count` wavelengths, 1 to 64, from `from_nm` to `to_nm`, which are
/// nanometres from 360 to 830, and their colours, for shisen_frame_settings. Six
/// wavelengths from 400 to 700 suffice for most scenes. Needs the cargo feature
/// `dispersion`.
///
/// `memory`, `memory_size`: shisen_spectrum_size(count) bytes at a multiple of
/// SHISEN_ALIGNMENT, which the spectrum uses for as long as a frame that was begun
/// with it is in use.
/// `spectrum`: receives the handle; NULL after a failure.
///
/// # Safety
/// Each pointer is NULL, misaligned, or valid: `memory` for `memory_size` bytes,
/// `spectrum` for one handle. Nobody else uses that memory during the call.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn shisen_spectrum_open(
    memory: *mut c_void,
    memory_size: usize,
    count: u32,
    from_nm: f32,
    to_nm: f32,
    spectrum: *mut *mut Spectrum,
) -> Status {
    settled(|| {
        // SAFETY: as promised above.
        unsafe { write(spectrum, null_mut()) }?;
        let wavelengths = Wavelengths::new(count, [from_nm, to_nm]);
        let wavelengths = wavelengths.map_err(|_| Status::Wavelengths)?;
        let trailing = shisen_spectrum_size(count).saturating_sub(size_of::<Spectrum>());
        let handle = room::<Spectrum>(memory, memory_size, trailing)?;
        // SAFETY: there is room.
        unsafe { open(handle, wavelengths) }?;
        // SAFETY: as promised above.
        unsafe { write(spectrum, handle) }
    })
}

/// # Safety
/// `handle` has memory for the handle and for the samples of the wavelengths.
#[cfg(feature = "dispersion")]
unsafe fn open(handle: *mut Spectrum, wavelengths: Wavelengths) -> Result<(), Status> {
    let samples = handle
        .wrapping_byte_add(SHISEN_SPECTRUM_SIZE)
        .cast::<SpectralSample>();
    let count = SpectralTable::samples(wavelengths, SHISEN_SPECTRUM_PHASES);
    for sample in 0..count {
        let sample = samples.wrapping_add(sample);
        // SAFETY: there is room.
        unsafe { sample.write(SpectralSample::default()) };
    }
    // SAFETY: they were just written, and are the spectrum's from now on.
    let samples = unsafe { slice_mut(samples, count) }?;
    let table = SpectralTable::new(
        wavelengths,
        SHISEN_SPECTRUM_PHASES,
        Matching::Wyman,
        samples,
    );
    let table = table.map_err(|_| Status::Wavelengths)?;
    // SAFETY: there is room.
    unsafe { handle.write(Spectrum { table }) };
    Ok(())
}

/// # Safety
/// None is needed: without the feature nothing is opened.
#[cfg(not(feature = "dispersion"))]
unsafe fn open(_: *mut Spectrum, _: Wavelengths) -> Result<(), Status> {
    Err(Status::NotBuilt)
}

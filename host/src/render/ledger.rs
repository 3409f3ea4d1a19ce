//! Counts the rays and steps of each effect in a frame.

use super::{Observer, Options, RenderError, pool, renderer, share_out, tiles, view};
use crate::bake::AnyScene;
use crate::cave::Cave;
use crate::with_scene;
use shisen_core::frame::{Ledger, Pixel, Statistics};
use shisen_core::scene::Scene;
use shisen_core::{Runs, Simd};
use std::sync::Mutex;

/// Counts of each effect in a frame, and of all its rays.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Account {
    /// Counts by effect.
    pub ledger: Ledger,
    /// Counts of all rays: those in the ledger, and the primary ones.
    pub statistics: Statistics,
    /// The number of pixels of all pictures.
    pub pixels: u64,
}

/// Traces the rays of [`cave`](super::cave), and counts what each effect does. Slower
/// than `cave`.
///
/// # Errors
/// Those of [`cave`](super::cave).
pub fn account(
    scene: AnyScene<'_>,
    cave: &Cave,
    eyes: &[Observer],
    options: &Options,
) -> Result<Account, RenderError> {
    with_scene!(scene, |scene| account_of(&scene, cave, eyes, options))
}

fn account_of<const W: usize>(
    scene: &Scene<'_, W>,
    cave: &Cave,
    eyes: &[Observer],
    options: &Options,
) -> Result<Account, RenderError>
where
    Simd: Runs<W>,
{
    let mut storage = Vec::new();
    let spectrum = options.dispersion.spectrum(&mut storage);
    let mut jobs = Vec::new();
    let mut pixels = 0;
    for pictured in cave.pictured() {
        for observer in eyes {
            let view = view(pictured, observer)?;
            let renderer = renderer(scene, observer, options, spectrum)?;
            pixels += u64::from(view.columns()) * u64::from(view.rows());
            jobs.extend(tiles(&view, options.tile).map(|tile| (view, renderer, tile)));
        }
    }
    let ledger = Mutex::new(Ledger::EMPTY);
    let statistics = share_out(&pool(options.threads)?, jobs.iter(), |workspace, job| {
        let (view, renderer, tile) = job;
        let mut own = Ledger::EMPTY;
        let mut pixels = vec![Pixel::default(); tile.width as usize * tile.height as usize];
        // Tiles of a view's own grid fit it.
        let outcome = renderer.account(view, *tile, &mut pixels, &mut own, workspace);
        debug_assert!(outcome.is_ok());
        if let Ok(mut all) = ledger.lock() {
            all.add(&own);
        }
    });
    Ok(Account {
        ledger: ledger.into_inner().unwrap_or(Ledger::EMPTY),
        statistics,
        pixels,
    })
}

//! What each effect does in a frame.

use super::{Observer, Options, RenderError, pool, renderer, tiles, view};
use crate::cave::Cave;
use shisen_core::frame::{Ledger, Pixel, Statistics, Workspace};
use shisen_core::scene::Scene;
use shisen_core::{Runs, Simd};
use std::sync::Mutex;

/// What each effect does in a frame, and what the frame takes without that:
/// ray by ray.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Account {
    /// By effect.
    pub ledger: Ledger,
    /// Of all rays: those that the ledger has, and the primary ones.
    pub statistics: Statistics,
    /// Of all pictures.
    pub pixels: u64,
}

/// Goes through what each eye sees on each wall and dome, and enters what each
/// effect does. Slower than [`cave`](super::cave), whose rays it traces.
///
/// # Errors
/// As [`cave`](super::cave).
pub fn account<const W: usize>(
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
    for screen in cave.screens() {
        for observer in eyes {
            let view = view(screen, observer)?;
            let renderer = renderer(scene, observer, options, spectrum)?;
            pixels += u64::from(view.columns()) * u64::from(view.rows());
            jobs.extend(tiles(&view, options.tile).map(|tile| (view, renderer, tile)));
        }
    }
    let next = Mutex::new(jobs.iter());
    let done = pool(options.threads)?.broadcast(|_| {
        let (mut ledger, mut workspace) = (Ledger::EMPTY, Workspace::new());
        let mut pixels = Vec::new();
        while let Some((view, renderer, tile)) = next.lock().ok().and_then(|mut next| next.next()) {
            pixels.resize(tile.width as usize * tile.height as usize, Pixel::default());
            // Tiles of a view's own grid fit it.
            let outcome = renderer.account(view, *tile, &mut pixels, &mut ledger, &mut workspace);
            debug_assert!(outcome.is_ok());
        }
        (ledger, workspace.statistics)
    });
    let mut account = Account {
        ledger: Ledger::EMPTY,
        statistics: Statistics::default(),
        pixels,
    };
    for (ledger, statistics) in &done {
        account.ledger.add(ledger);
        account.statistics.add(statistics);
    }
    Ok(account)
}

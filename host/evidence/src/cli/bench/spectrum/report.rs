//! What `shisen-evidence bench spectrum` prints.

use serde::Serialize;
use shisen::cli::output::counted;
use std::fmt;

/// What was measured.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    pub(super) threads: usize,
    pub(super) size: u32,
    pub(super) samples: u16,
    pub(super) repeat: u32,
    pub(super) glass_share: f64,
    pub(super) reference_seconds: f64,
    pub(super) rows: Vec<Row>,
    pub(super) same_error: Option<SameError>,
    pub(super) cost: Cost,
    pub(super) splits: Splits,
    pub(super) images: Vec<String>,
}

/// A number of wavelengths by a method.
#[derive(Debug, Serialize)]
pub(super) struct Row {
    pub(super) wavelengths: u32,
    pub(super) method: &'static str,
    pub(super) seconds: f64,
    pub(super) time_ratio: Option<f64>,
    pub(super) rays: u64,
    pub(super) rays_ratio: Option<f64>,
    pub(super) mean_difference: f64,
    pub(super) max_difference: f64,
    pub(super) mean_of_all: f64,
}

/// The comb that is as close to the reference as the paper's method.
#[derive(Debug, Serialize)]
pub(super) struct SameError {
    pub(super) wavelengths: u32,
    pub(super) each: u32,
    pub(super) samples: u16,
    pub(super) seconds: f64,
    pub(super) paper_seconds: f64,
    pub(super) mean_difference: f64,
    pub(super) speedup: f64,
}

/// What a comb costs where little glass is seen.
#[derive(Debug, Serialize)]
pub(super) struct Cost {
    pub(super) glass_share: f64,
    pub(super) samples: u16,
    pub(super) wavelengths: u32,
    pub(super) comb_seconds: f64,
    pub(super) plain_seconds: f64,
    pub(super) ratio: f64,
}

/// What splitting costs where glass fills the picture.
#[derive(Debug, Serialize)]
pub(super) struct Splits {
    pub(super) glass_share: f64,
    pub(super) plain_seconds: f64,
    pub(super) counts: Vec<Split>,
}

/// Into so many wavelengths.
#[derive(Debug, Serialize)]
pub(super) struct Split {
    pub(super) wavelengths: u32,
    pub(super) seconds: f64,
    pub(super) ratio: f64,
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "spheres, {size} × {size} pixels, {} rays a pixel, {}; {:.0} % of the pixels meet \
             glass",
            self.samples,
            counted(self.threads as u64, "thread"),
            1e2 * self.glass_share,
            size = self.size,
        )?;
        writeln!(
            f,
            "{:>11}  {:8}{:>10}{:>10}{:>10}{:>12}{:>8}",
            "wavelengths", "method", "seconds", "to one", "rays", "ΔE2000 mean", "max",
        )?;
        let ratio = |of: Option<f64>| of.map_or("-".to_owned(), |of| format!("{of:.3}"));
        for row in &self.rows {
            writeln!(
                f,
                "{:>11}  {:8}{:>10.3}{:>10}{:>10}{:>12.2}{:>8.1}",
                row.wavelengths,
                row.method,
                row.seconds,
                ratio(row.time_ratio),
                ratio(row.rays_ratio),
                row.mean_difference,
                row.max_difference,
            )?;
        }
        if let Some(one) = &self.same_error {
            writeln!(
                f,
                "a comb of which a ray takes {} of {} is as close as paper with {} rays a pixel \
                 (ΔE {:.2}), {:.2} times as fast",
                one.each, one.wavelengths, one.samples, one.mean_difference, one.speedup,
            )?;
        } else {
            writeln!(f, "no comb is as close as paper in the same time")?;
        }
        let Cost {
            glass_share,
            samples,
            wavelengths,
            ratio,
            ..
        } = &self.cost;
        writeln!(
            f,
            "where {:.0} % of the pixels meet glass, {samples} rays a pixel: {wavelengths} \
             wavelengths take {ratio:.3} of the time without dispersion",
            1e2 * glass_share,
        )?;
        write!(
            f,
            "where {:.0} % do, every ray split:",
            1e2 * self.splits.glass_share
        )?;
        for count in &self.splits.counts {
            write!(f, " ×{:.2} for {}", count.ratio, count.wavelengths)?;
        }
        Ok(())
    }
}

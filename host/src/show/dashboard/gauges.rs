//! The gauges of the budget and of the latency from the eye to the wall.

use super::canvas::{Canvas, Colour, Rect, mixed};
use super::{Frame, HELP, NOTICE, TEXT};
use crate::live::Quality;

pub(super) const ROWS: u32 = 96;

const STRIP: u32 = 40;

const GROOVE: Colour = 0x30_3030;
const SPENT: Colour = 0x50_C060;
const NEED: Colour = 0xC0_A030;
const LATE: Colour = 0xE0_4040;
const LINE: Colour = 0x80_8080;
const HINT: Colour = 0xA0_A0A0;

/// The latency of a frame from the eye's movement to the wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Latency {
    /// Milliseconds; `None` before the first sample.
    pub(crate) milliseconds: Option<f32>,
    pub(crate) late: bool,
}

pub(super) fn draw(canvas: &mut Canvas, frame: &Frame, dropped: u64) {
    let [width, height] = canvas.size();
    let top = height.saturating_sub(ROWS);
    let half = width / 2;
    let part = |x: u32| Rect::new(x + 8, top + 4, half.saturating_sub(16), STRIP + 14);
    budget(canvas, part(0), frame, dropped);
    strip(canvas, part(half), frame);
    for (line, y) in HELP.into_iter().zip([top + 68, top + 82]) {
        canvas.write(8, y, line, HINT);
    }
}

/// Draws a bar of the budget: what was spent is green, what more was needed is yellow.
fn budget(canvas: &mut Canvas, rect: Rect, frame: &Frame, dropped: u64) {
    let record = &frame.record;
    let groove = Rect::new(rect.x, rect.y + 14, rect.width, 14);
    canvas.fill(groove, GROOVE);
    let text = match record.budget_steps {
        Some(allowed) => {
            let columns = |steps: u64| {
                let part = steps as f64 / allowed.max(1) as f64;
                (part.min(1.0) * f64::from(rect.width) + 0.5) as u32
            };
            for (steps, colour) in [(record.need_steps, NEED), (record.steps, SPENT)] {
                let width = columns(steps);
                canvas.fill(Rect { width, ..groove }, colour);
            }
            format!("{} of {allowed} steps", record.steps)
        }
        None => format!("{} steps, without a limit", record.steps),
    };
    canvas.write(rect.x, rect.y, &text, TEXT);
    let best = record.rung == 0;
    let rungs = Quality::LADDER.len();
    let quality = format!("quality {} of {rungs}", record.rung + 1);
    let colour = if best { TEXT } else { NOTICE };
    let end = canvas.write(rect.x, rect.y + 34, &quality, colour);
    if record.unfinished_tiles > 0 {
        let (unfinished, tiles) = (record.unfinished_tiles, record.tiles);
        let text = format!("  {unfinished} of {tiles} tiles unfinished");
        canvas.write(end, rect.y + 34, &text, LATE);
    }
    let text = format!("frame {}, {dropped} not shown here", record.frame);
    canvas.write(rect.x, rect.y + 46, &text, HINT);
}

/// Draws the latency of each frame in a column, red if it was late, with lines at refreshes.
fn strip(canvas: &mut Canvas, rect: Rect, frame: &Frame) {
    let newest = frame.latencies.last().and_then(|one| one.milliseconds);
    let text = newest.map(|milliseconds| format!("motion to wall {milliseconds:.1} ms"));
    let text = text.unwrap_or_else(|| "motion to wall: no sample yet".to_owned());
    canvas.write(rect.x, rect.y, &text, TEXT);
    let ground = Rect::new(rect.x, rect.y + 14, rect.width, STRIP);
    canvas.fill(ground, GROOVE);
    let refresh = 1_000.0 / frame.about.hz.max(1) as f32;
    let shown = frame.latencies.len().min(rect.width as usize / 2);
    let latest = &frame.latencies[frame.latencies.len() - shown..];
    let most = latest.iter().filter_map(|one| one.milliseconds);
    // The scale is whole refreshes.
    let refreshes = (most.fold(0.0, f32::max) / refresh).ceil();
    let refreshes = refreshes.clamp(2.0, 1.0e6);
    let rows = |milliseconds: f32| {
        let part = milliseconds / (refreshes * refresh);
        (part.clamp(0.0, 1.0) * STRIP as f32 + 0.5) as u32
    };
    let start = rect.x + 2 * (rect.width / 2 - shown as u32);
    for (column, one) in (start..).step_by(2).zip(latest) {
        let Some(milliseconds) = one.milliseconds else {
            continue;
        };
        let height = rows(milliseconds);
        let bar = Rect::new(column, ground.y + STRIP - height, 2, height);
        canvas.fill(bar, if one.late { LATE } else { SPENT });
    }
    for line in 1..refreshes.min(8.0) as u32 {
        let y = ground.y + STRIP - rows(line as f32 * refresh);
        for x in (rect.x..rect.x + rect.width).step_by(4) {
            let under = canvas.pixel(x, y).unwrap_or(GROOVE);
            canvas.set(x, y, mixed(under, LINE, 0.7));
        }
    }
    let scale = format!("{:.0} ms", refreshes * refresh);
    let from = (rect.x + rect.width).saturating_sub(8 * scale.len() as u32);
    canvas.write(from, rect.y, &scale, HINT);
}

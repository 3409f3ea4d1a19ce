//! Patterns in an output's own pixels, without warp and blend.

use super::{OutputView, Refresh};
use crate::picture::glyph::{GLYPH, dots};
use crate::picture::srgb_from_linear;
use crate::show::dashboard::{Canvas, Colour, Rect};
use glam::DVec2;

const WHITE: Colour = 0xFF_FFFF;
const DIM: Colour = 0x40_4040;

/// Returns the grey of a code.
const fn grey(code: u8) -> Colour {
    code as u32 * 0x01_0101
}

/// Returns how many times as large letters are that are to be read from afar: whole dots.
fn magnified(canvas: &Canvas) -> u32 {
    let [columns, rows] = canvas.size();
    (columns.min(rows) / 300).max(1)
}

/// Writes text from a pixel on, each dot a square of `scale` pixels.
fn write(canvas: &mut Canvas, [x, y]: [u32; 2], scale: u32, text: &str, colour: Colour) {
    for (column, row) in dots(text) {
        let dot = Rect::new(x + column * scale, y + row * scale, scale, scale);
        canvas.fill(dot, colour);
    }
}

/// Writes text with its middle at a pixel, on a black board.
fn write_centred(canvas: &mut Canvas, [x, y]: [u32; 2], scale: u32, text: &str, colour: Colour) {
    let width = GLYPH * scale * text.chars().count() as u32;
    let height = GLYPH * scale;
    let [x, y] = [x.saturating_sub(width / 2), y.saturating_sub(height / 2)];
    let [left, top] = [x, y].map(|start| start.saturating_sub(scale));
    canvas.fill(
        Rect::new(left, top, width + 2 * scale, height + 2 * scale),
        0,
    );
    write(canvas, [x, y], scale, text, colour);
}

/// Sets each pixel of a rectangle.
fn shade(canvas: &mut Canvas, rect: Rect, colour: impl Fn([u32; 2]) -> Colour) {
    for y in rect.y..rect.y + rect.height {
        for x in rect.x..rect.x + rect.width {
            canvas.set(x, y, colour([x, y]));
        }
    }
}

fn title(output: &OutputView<'_>) -> String {
    format!("{} {}×{}", output.name, output.size[0], output.size[1])
}

pub(super) fn focus(output: &OutputView<'_>, _: Refresh) -> Canvas {
    const LETTERS: [&str; 3] = ["The quick brown", "fox jumps over", "0123456789 .,:;"];
    const SPOKES: f64 = 36.0;
    let [columns, rows] = output.size;
    let mut canvas = Canvas::new(columns, rows);
    let side = (columns.min(rows) / 6).max(1);
    let block = [2 * side.max(62), side.max(62)];
    let block = [block[0].min(columns), block[1].min(rows)];
    let [right, down] = [columns - block[0], rows - block[1]];
    let half = block[0] / 2;
    for [x, y] in [[0, 0], [right, 0], [0, down], [right, down]] {
        // The letters are beside the checkerboard, which is in the corner.
        let [checked, letters] = if x == 0 {
            [x, x + half + 2]
        } else {
            [x + half, x]
        };
        let rect = Rect::new(checked, y, half, block[1]);
        shade(
            &mut canvas,
            rect,
            |[x, y]| if (x + y) % 2 == 0 { WHITE } else { 0 },
        );
        for (line, text) in (0..).zip(LETTERS) {
            // Letters of one pixel a dot: what is small shows first what is not sharp.
            let text: String = text.chars().take((half / GLYPH) as usize).collect();
            canvas.write(letters, y + 4 + line * (GLYPH + 2), &text, WHITE);
        }
    }
    let middle = 0.5 * DVec2::new(f64::from(columns), f64::from(rows));
    let radius = 0.28 * f64::from(columns.min(rows));
    let from = (middle - radius).as_uvec2();
    let star = Rect::new(from.x, from.y, 2 * radius as u32 + 1, 2 * radius as u32 + 1);
    shade(&mut canvas, star, |[x, y]| {
        let from_middle = DVec2::new(f64::from(x), f64::from(y)) + 0.5 - middle;
        let spoke = from_middle.to_angle() / std::f64::consts::TAU * SPOKES;
        // From the edge of the nearest spoke, in pixels along the circle.
        let in_spoke = spoke.rem_euclid(1.0);
        let off = 0.25 - (in_spoke - 0.5).abs();
        let off = off * from_middle.length() * std::f64::consts::TAU / SPOKES;
        let inside = (radius - from_middle.length() + 0.5).clamp(0.0, 1.0);
        grey(srgb_from_linear(
            ((off + 0.5).clamp(0.0, 1.0) * inside) as f32,
        ))
    });
    let below = [columns / 2, (middle.y + radius) as u32 + 2 * GLYPH];
    write_centred(&mut canvas, below, 1, &title(output), WHITE);
    canvas
}

pub(super) fn convergence(output: &OutputView<'_>, _: Refresh) -> Canvas {
    const CELL: u32 = 32;
    let [columns, rows] = output.size;
    let mut canvas = Canvas::new(columns, rows);
    // Symmetric, so that lines run through the middle and near all edges.
    let is_line = |at: u32, count: u32| (at + CELL - (count / 2) % CELL).is_multiple_of(CELL);
    shade(&mut canvas, Rect::new(0, 0, columns, rows), |[x, y]| {
        if is_line(x, columns) || is_line(y, rows) {
            WHITE
        } else {
            0
        }
    });
    canvas
}

/// Draws a two-pixel border, red inside and green outside, and the same along each neighbour's
/// outline, the other way round: there a neighbour's border falls on it.
pub(super) fn border_pair(output: &OutputView<'_>, _: Refresh) -> Canvas {
    let [columns, rows] = output.size;
    let mut canvas = Canvas::new(columns, rows);
    let (red, green) = (0xFF_0000, 0x00_FF00);
    let middle = [columns / 2, rows / 2];
    let scale = magnified(&canvas);
    write_centred(&mut canvas, middle, scale, &title(output), DIM);
    for outline in output.neighbours {
        trace(&mut canvas, outline);
    }
    for (inset, colour) in [(0, green), (1, red)] {
        let [width, height] = [columns, rows].map(|side| side.saturating_sub(2 * inset));
        for rect in [
            Rect::new(inset, inset, width, 1),
            Rect::new(inset, rows.saturating_sub(1 + inset), width, 1),
            Rect::new(inset, inset, 1, height),
            Rect::new(columns.saturating_sub(1 + inset), inset, 1, height),
        ] {
            canvas.fill(rect, colour);
        }
    }
    canvas
}

/// Draws the outermost pixels inside an outline red and the next ones green.
fn trace(canvas: &mut Canvas, outline: &[DVec2]) {
    let ends = outline.iter().zip(outline.iter().cycle().skip(1));
    let area: f64 = ends.clone().map(|(from, to)| from.perp_dot(*to)).sum();
    let size = canvas.size().map(f64::from);
    for (&from, &to) in ends {
        let along = to - from;
        let length = along.length();
        let inwards = along.normalize_or_zero().perp() * area.signum();
        let [low, high] = [from.min(to) - 3.0, from.max(to) + 3.0];
        let low = low.max(DVec2::ZERO).as_uvec2();
        let high = high.clamp(DVec2::ZERO, size.into()).as_uvec2();
        for y in low.y..high.y {
            for x in low.x..high.x {
                let from_start = DVec2::new(f64::from(x), f64::from(y)) + 0.5 - from;
                let inside = from_start.dot(inwards);
                let place = from_start.dot(along) / length;
                if !(0.0..=length).contains(&place) {
                    continue;
                }
                // The part of a line from `start` to one pixel more that falls on this pixel.
                let part = |start: f64| (1.0 - (inside - start - 0.5).abs()).max(0.0) as f32;
                let [red, green] = [part(0.0), part(1.0)].map(srgb_from_linear);
                let before = canvas.pixel(x, y).unwrap_or_default().to_be_bytes();
                let codes = [0, red.max(before[1]), green.max(before[2]), before[3]];
                canvas.set(x, y, u32::from_be_bytes(codes));
            }
        }
    }
}

pub(super) fn coverage(output: &OutputView<'_>, _: Refresh) -> Canvas {
    const COLOURS: [Colour; 6] = [
        0xFF_0000, 0x00_FF00, 0x00_00FF, 0xFF_FF00, 0x00_FFFF, 0xFF_00FF,
    ];
    let [columns, rows] = output.size;
    let mut canvas = Canvas::new(columns, rows);
    canvas.clear(COLOURS[output.number % COLOURS.len()]);
    let scale = magnified(&canvas);
    let name = format!("{}: {}", output.number + 1, output.name);
    let lines = [name, format!("{columns}×{rows}")];
    for (line, text) in (0..).zip(&lines) {
        let place = [columns / 2, rows / 2 + line * 3 * GLYPH * scale];
        write_centred(&mut canvas, place, 2 * scale, text, WHITE);
    }
    canvas
}

/// The codes that a field of the pattern `gamma` may match, and the gamma of each.
pub(super) const GAMMAS: [(u8, &str); 6] = [
    (174, "1.8"),
    (180, "2.0"),
    (186, "2.2"),
    (188, "sRGB"),
    (191, "2.4"),
    (195, "2.6"),
];

/// Returns the field of a code in one of four rows, white, red, green and blue.
pub(super) fn gamma_field([columns, rows]: [u32; 2], column: u32, row: u32) -> Rect {
    let cell = [columns / GAMMAS.len() as u32, rows / 4];
    let [width, height] = [cell[0] / 2, cell[1] / 2];
    let x = column * cell[0] + cell[0] / 4;
    Rect::new(x, row * cell[1] + cell[1] / 8, width, height)
}

pub(super) fn gamma(output: &OutputView<'_>, _: Refresh) -> Canvas {
    const CHANNELS: [Colour; 4] = [WHITE, 0xFF_0000, 0x00_FF00, 0x00_00FF];
    let [columns, rows] = output.size;
    let mut canvas = Canvas::new(columns, rows);
    let band = (rows / 4).max(1);
    shade(&mut canvas, Rect::new(0, 0, columns, rows), |[_, y]| {
        let channel = CHANNELS[(y / band).min(3) as usize];
        if y % 2 == 1 { channel } else { 0 }
    });
    let scale = magnified(&canvas);
    for (row, channel) in (0..).zip(CHANNELS) {
        for (column, (code, gamma)) in (0..).zip(GAMMAS) {
            let field = gamma_field(output.size, column, row);
            canvas.fill(field, grey(code) & channel);
            let text = format!("{code} {gamma}");
            let below = [field.x + field.width / 2, field.y + field.height * 3 / 2];
            write_centred(&mut canvas, below, scale, &text, 0xC0_C0C0);
        }
    }
    canvas
}

pub(super) fn steps(output: &OutputView<'_>, _: Refresh) -> Canvas {
    const ACROSS: u32 = 16;
    let [columns, rows] = output.size;
    let mut canvas = Canvas::new(columns, rows);
    let scale = magnified(&canvas).min((columns / ACROSS / (4 * GLYPH)).max(1));
    for step in 0..2 * ACROSS {
        let (column, row) = (step % ACROSS, step / ACROSS);
        let code = ((step * 255 + ACROSS) / (2 * ACROSS - 1)).min(255) as u8;
        let edges = [column, column + 1].map(|edge| edge * columns / ACROSS);
        let tops = [row, row + 1].map(|edge| edge * rows / 2);
        let [width, height] = [edges[1] - edges[0], tops[1] - tops[0]];
        canvas.fill(Rect::new(edges[0], tops[0], width, height), grey(code));
        let ink = if code < 128 { grey(code / 2 + 96) } else { 0 };
        let text = code.to_string();
        let length = GLYPH * scale * text.len() as u32;
        let x = edges[0] + width.saturating_sub(length) / 2;
        write(&mut canvas, [x, tops[0] + height / 2], scale, &text, ink);
    }
    canvas
}

/// The side of the square of the pattern `latency`: pixels.
pub(super) const PATCH: u32 = 100;

pub(super) fn latency(output: &OutputView<'_>, refresh: Refresh) -> Canvas {
    let [columns, rows] = output.size;
    let mut canvas = Canvas::new(columns, rows);
    if refresh.is_event {
        let patch = Rect::new(0, rows.saturating_sub(PATCH), PATCH, PATCH);
        canvas.fill(patch, WHITE);
    }
    canvas
}

/// The refreshes in which the bar crosses a picture of any size.
pub(super) const CROSSING: u64 = 120;

pub(super) fn bar(output: &OutputView<'_>, refresh: Refresh) -> Canvas {
    let [columns, rows] = output.size;
    let mut canvas = Canvas::new(columns, rows);
    let edge = |number: u64| (number * u64::from(columns) / CROSSING) as u32;
    let number = refresh.msc % CROSSING;
    let (from, to) = (edge(number), edge(number + 1));
    canvas.fill(Rect::new(from, 0, (to - from).max(1), rows), WHITE);
    canvas
}

/// Draws the lowest eight bits of the count, the highest first, and the same in digits.
pub(super) fn counter(output: &OutputView<'_>, refresh: Refresh) -> Canvas {
    const BITS: u32 = 8;
    let [columns, rows] = output.size;
    let mut canvas = Canvas::new(columns, rows);
    let cell = (columns / BITS).min(rows / 2).max(1);
    let gap = (cell / 16).max(1);
    let left = (columns - (cell * BITS).min(columns)) / 2;
    let top = (rows / 2).saturating_sub(cell);
    for bit in 0..BITS {
        let is_set = (refresh.msc >> (BITS - 1 - bit)) & 1 == 1;
        let side = cell.saturating_sub(2 * gap);
        let square = Rect::new(left + bit * cell + gap, top + gap, side, side);
        canvas.fill(square, if is_set { WHITE } else { DIM });
        if !is_set {
            let inner = side.saturating_sub(2 * gap);
            canvas.fill(Rect::new(square.x + gap, square.y + gap, inner, inner), 0);
        }
    }
    let digits = format!("{}", refresh.msc % 256);
    let scale = (cell / 10).max(1);
    let below = [columns / 2, rows * 3 / 4];
    write_centred(&mut canvas, below, scale, &digits, WHITE);
    canvas
}

//! Patterns of wood, brick, metal and leaves, by formulas.

use crate::scene::environment::Radiance;
use crate::scene::texture::Image;
use std::sync::Arc;

const SIDE: u32 = 512;

/// Returns a number from 0 to 1 for a place of a grid.
fn noise(x: i64, y: i64) -> f64 {
    let mut bits = (x.wrapping_mul(0x9E37_79B9) ^ y.wrapping_mul(0x85EB_CA6B)) as u64;
    bits = (bits ^ bits >> 15).wrapping_mul(0x2C1B_3C6D_2545_F491);
    bits = (bits ^ bits >> 29).wrapping_mul(0x297A_2D39_94D0_49BB);
    (bits >> 40) as f64 / (1u64 << 24) as f64
}

/// Returns the same, smooth between the places of the grid, which repeats after `period`.
fn smooth(x: f64, y: f64, period: [i64; 2]) -> f64 {
    let (fx, fy) = (x - x.floor(), y - y.floor());
    let ease = |t: f64| t * t * (3.0 - 2.0 * t);
    let at = |dx: i64, dy: i64| {
        let place = |c: f64, d: i64, period: i64| (c.floor() as i64 + d).rem_euclid(period);
        noise(place(x, dx, period[0]), place(y, dy, period[1]))
    };
    let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
    let lower = mix(at(0, 0), at(1, 0), ease(fx));
    let upper = mix(at(0, 1), at(1, 1), ease(fx));
    mix(lower, upper, ease(fy))
}

/// Returns an image of a colour, sRGB from 0 to 1 with alpha, at each place from 0 to 1.
fn image([width, height]: [u32; 2], colour: impl Fn(f64, f64) -> [f64; 4]) -> Arc<Image> {
    let code = |channel: f64| (channel.clamp(0.0, 1.0) * 255.0).round() as u8;
    let texels: Vec<[u8; 4]> = (0..height)
        .flat_map(|row| (0..width).map(move |column| (row, column)))
        .map(|(row, column)| {
            let at = |place: u32, side: u32| (f64::from(place) + 0.5) / f64::from(side);
            colour(at(column, width), 1.0 - at(row, height)).map(code)
        })
        .collect();
    Arc::new(Image::with_alpha(width, height, &texels).expect("as many texels as it has"))
}

fn tinted(colour: [f64; 3], by: f64) -> [f64; 4] {
    let [red, green, blue] = colour.map(|channel| channel * by);
    [red, green, blue, 1.0]
}

/// Returns oak boards, two metres square.
pub(super) fn parquet() -> Arc<Image> {
    const ROWS: f64 = 16.0;
    image([SIDE, SIDE], |u, v| {
        let row = (v * ROWS).floor();
        let along = u * 2.0 + 0.37 * row;
        let board = (along.rem_euclid(2.0)).floor() as i64 + 2 * row as i64;
        let tone = 0.8 + 0.28 * noise(board, 7);
        let grain = smooth(u * 24.0 + 40.0 * noise(board, 3), v * 256.0, [64, 256]);
        let rings = smooth(u * 8.0, v * 64.0 + 9.0 * noise(board, 5), [8, 64]);
        let gap = |place: f64, width: f64| {
            let within = place - place.floor();
            within < width || within > 1.0 - width
        };
        let seam = if gap(v * ROWS, 0.035) || gap(along, 0.004) {
            0.45
        } else {
            1.0
        };
        let shade = tone * (0.86 + 0.2 * grain) * (0.9 + 0.16 * rings) * seam;
        tinted([0.72, 0.53, 0.36], shade)
    })
}

/// Returns courses of brick: ten rows of four.
pub(super) fn bricks() -> Arc<Image> {
    image([SIDE, SIDE], |u, v| {
        let row = (v * 10.0).floor();
        let along = u * 4.0 + 0.5 * (row % 2.0);
        let (x, y) = (along - along.floor(), v * 10.0 - row);
        let brick = (along.floor() as i64).rem_euclid(4) + 4 * row as i64;
        let speckle = smooth(u * 128.0, v * 128.0, [128, 128]);
        let joint = !(0.02..0.98).contains(&x) || !(0.06..0.94).contains(&y);
        if joint {
            return tinted([0.74, 0.71, 0.66], 0.88 + 0.12 * speckle);
        }
        let tone = 0.78 + 0.3 * noise(brick, 11);
        let warm = noise(brick, 13);
        let colour = [0.66, 0.36 + 0.08 * warm, 0.27 + 0.08 * warm];
        tinted(colour, tone * (0.86 + 0.2 * speckle))
    })
}

/// Returns the normals of the same bricks, whose faces stand out from the joints.
pub(super) fn joints() -> Arc<Image> {
    image([SIDE, SIDE], |u, v| {
        let row = (v * 10.0).floor();
        let along = u * 4.0 + 0.5 * (row % 2.0);
        let (x, y) = (along - along.floor(), v * 10.0 - row);
        // Down to the joint over a twentieth of a brick, and uneven.
        let edge = |place: f64, width: f64| {
            let towards = |place: f64| (1.0 - place / width).max(0.0);
            towards(1.0 - place) - towards(place)
        };
        let uneven = |by: f64| smooth(u * 96.0 + by, v * 96.0, [96, 96]) - 0.5;
        let x = 0.7 * edge(x, 0.045) + 0.25 * uneven(0.0);
        let y = 0.7 * edge(y, 0.11) + 0.25 * uneven(31.0);
        let length = (x * x + y * y + 1.0).sqrt();
        let code = |part: f64| 0.5 * (part / length + 1.0);
        [code(x), code(y), code(1.0), 1.0]
    })
}

/// Returns the roughness of steel that was brushed across, in the green channel.
pub(super) fn brushed() -> Arc<Image> {
    image([16, 256], |u, v| {
        let scratch = smooth(u * 2.0, v * 256.0, [2, 256]);
        [1.0, 0.45 + 0.55 * scratch, 1.0, 1.0]
    })
}

/// Returns a leaf from its stalk below to its tip above, on nothing.
pub(super) fn leaf() -> Arc<Image> {
    image([128, 256], |u, v| {
        let across = (2.0 * u - 1.0).abs();
        let wide = (std::f64::consts::PI * v.powf(0.75)).sin().max(0.0) * 0.95;
        let stalk = v < 0.2 && across < 0.05;
        let inside = across < wide || stalk;
        let vein = across < 0.03 || ((v * 14.0 - across * 3.0).rem_euclid(1.0) < 0.08);
        let tone = 0.7 + 0.3 * smooth(u * 16.0, v * 16.0, [16, 16]);
        let lit = if vein { 1.25 } else { 1.0 };
        let [red, green, blue, _] = tinted([0.24, 0.46, 0.17], tone * lit);
        [red, green, blue, f64::from(u8::from(inside))]
    })
}

/// Returns a sky with clouds above hills, all around.
pub(super) fn sky() -> Arc<Radiance> {
    const SIDES: [usize; 2] = [512, 256];
    let mix = |a: [f64; 3], b: [f64; 3], t: f64| [0, 1, 2].map(|c: usize| a[c] + (b[c] - a[c]) * t);
    let pixel = |place: usize| {
        let [u, v] = [place % SIDES[0], place / SIDES[0]];
        let turn = (u as f64 + 0.5) / SIDES[0] as f64;
        let height = 90.0 - 180.0 * (v as f64 + 0.5) / SIDES[1] as f64;
        // Octaves of the same noise, which goes round.
        let wave = |count: f64, y: f64| smooth(turn * count, y, [count as i64, 512]);
        let hills = 7.0 * wave(9.0, 3.0) + 2.5 * wave(31.0, 5.0) - 3.0;
        if height < hills {
            let near = (1.0 - (height + 25.0) / 32.0).clamp(0.0, 1.0);
            return mix([0.23, 0.32, 0.33], [0.12, 0.17, 0.05], near);
        }
        let sky = mix(
            [0.84, 0.88, 0.92],
            [0.24, 0.44, 0.82],
            (height / 55.0).clamp(0.0, 1.0).sqrt(),
        );
        // Clouds lie in a plane over the room.
        let (sin, cos) = height.to_radians().sin_cos();
        let (east, south) = (turn * std::f64::consts::TAU).sin_cos();
        let cover = |count: f64| {
            let [x, y] = [east, south].map(|axis| 512.0 + axis * count * cos / (sin + 0.12));
            smooth(x, y, [1024, 1024])
        };
        let cloud = 0.5 * cover(2.2) + 0.3 * cover(6.0) + 0.2 * cover(15.0);
        mix(
            sky,
            [1.0, 0.98, 0.95],
            ((cloud - 0.48) * 4.0).clamp(0.0, 1.0),
        )
    };
    let pixels = (0..SIDES[0] * SIDES[1]).map(|place| pixel(place).map(|c| c as f32));
    let image = Radiance::new(SIDES, pixels.collect());
    Arc::new(image.expect("as many pixels as it has"))
}

/// Returns the colour of a glaze, linear RGB, at a height from 0 to 1.
pub(super) fn glaze(height: f32) -> [f32; 3] {
    let mix = |a: [f32; 3], b: [f32; 3], t: f32| std::array::from_fn(|c| a[c] + (b[c] - a[c]) * t);
    let [earth, sea, sand] = [[0.32, 0.12, 0.06], [0.03, 0.22, 0.34], [0.85, 0.8, 0.66]];
    if height < 0.5 {
        mix(earth, sea, 2.0 * height)
    } else {
        mix(sea, sand, 2.0 * height - 1.0)
    }
}

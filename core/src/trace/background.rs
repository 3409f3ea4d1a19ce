//! What is seen past all objects: a gradient over the elevation.

use crate::numeric::{SQUARABLE, normalize};
use crate::scene::format::Background;
use crate::simd::Lanes;
use glam::Vec3;

/// The sine of a direction's elevation.
fn height(direction: Vec3) -> f32 {
    normalize(direction).map_or(0.0, |direction| direction.y)
}

/// Linear RGB along a direction.
pub(super) fn colour(background: &Background, direction: Vec3) -> Vec3 {
    let height = height(direction);
    let far = if height >= 0.0 {
        background.zenith
    } else {
        background.nadir
    };
    let horizon = Vec3::from_array(background.horizon);
    // Exactly the horizon's colour where all are equal.
    horizon + (Vec3::from_array(far) - horizon) * height.abs()
}

/// [`colour`] times the background's coverage in every lane, added to nothing;
/// `None` where a direction is too short or too long for [`normalize`] to take
/// it as it is.
#[inline(always)]
pub(crate) fn colours<L: Lanes<8>>(
    l: L,
    background: &Background,
    [x, y, z]: [L::F; 3],
) -> Option<[L::F; 3]> {
    let largest = l.max(l.abs(x), l.max(l.abs(y), l.abs(z)));
    let usable = l.and(
        l.le(l.splat(*SQUARABLE.start()), largest),
        l.le(largest, l.splat(*SQUARABLE.end())),
    );
    if l.bits(usable) != 0xff {
        return None;
    }
    let square = l.add(l.add(l.mul(x, x), l.mul(y, y)), l.mul(z, z));
    let height = l.div(y, l.sqrt(square));
    Some([
        channel(l, background, 0, height),
        channel(l, background, 1, height),
        channel(l, background, 2, height),
    ])
}

#[inline(always)]
fn channel<L: Lanes<8>>(l: L, background: &Background, channel: usize, height: L::F) -> L::F {
    let horizon = background.horizon[channel % 3];
    let up = l.splat(background.zenith[channel % 3] - horizon);
    let down = l.splat(background.nadir[channel % 3] - horizon);
    let slope = l.select(l.le(l.splat(0.0), height), up, down);
    let colour = l.add(l.splat(horizon), l.mul(slope, l.abs(height)));
    l.add(l.splat(0.0), l.mul(colour, l.splat(background.alpha)))
}

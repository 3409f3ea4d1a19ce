//! What is seen past all objects: a gradient over the elevation.

use crate::numeric::{SQUARABLE, map3, max, normalize};
use crate::scene::format::{Background, NO_TEXTURE};
use crate::simd::Lanes;
use glam::Vec3;

/// Returns linear RGB along a direction.
pub(super) fn colour(background: &Background, direction: Vec3) -> Vec3 {
    // The sine of the elevation.
    let height = normalize(direction).map_or(0.0, |direction| direction.y);
    let far = if height >= 0.0 {
        background.zenith
    } else {
        background.nadir
    };
    let horizon = Vec3::from_array(background.horizon);
    // Exactly the horizon's colour where all are equal.
    horizon + (Vec3::from_array(far) - horizon) * height.abs()
}

/// Returns the mean of [`colour`] over the lobe that a surface of a roughness, above 0, mirrors
/// around a direction, as if its heights were evenly spread around their mean: error ≤ 0.05 of the
/// differences between the horizon and both poles.
pub(super) fn blurred(background: &Background, direction: Vec3, roughness: f32) -> Vec3 {
    let height = normalize(direction).map_or(0.0, |direction| direction.y);
    let mean = height * (1.0 - 0.4 * roughness * roughness);
    let spread = 0.9 * roughness;
    // The means of how far heights are above zero, and below.
    let above = |mean: f32| {
        let (low, high) = (max(mean - spread, 0.0), max(mean + spread, 0.0));
        (high * high - low * low) / (4.0 * spread)
    };
    let [zenith, horizon, nadir] =
        [background.zenith, background.horizon, background.nadir].map(Vec3::from_array);
    horizon + (zenith - horizon) * above(mean) + (nadir - horizon) * above(-mean)
}

/// [`colour`] times the background's coverage, for eight directions at a time.
pub(crate) struct Colours<F> {
    horizon: [F; 3],
    /// From the horizon to the zenith, and to the nadir.
    slopes: [[F; 3]; 2],
    alpha: F,
    /// Range of the largest component of a direction that [`normalize`] does not scale.
    usable: [F; 2],
}

impl<F: Copy> Colours<F> {
    /// Loads the colours once for any number of directions; those of an image are never computed
    /// together.
    #[inline(always)]
    pub(crate) fn new<L: Lanes<8, F = F>>(l: L, background: &Background) -> Self {
        let horizon = Vec3::from_array(background.horizon);
        let up = Vec3::from_array(background.zenith) - horizon;
        let down = Vec3::from_array(background.nadir) - horizon;
        let usable = if background.image == NO_TEXTURE {
            [*SQUARABLE.start(), *SQUARABLE.end()]
        } else {
            [f32::INFINITY, 0.0]
        };
        Self {
            horizon: map3(background.horizon, |horizon| l.splat(horizon)),
            slopes: [
                map3(up.to_array(), |slope| l.splat(slope)),
                map3(down.to_array(), |slope| l.splat(slope)),
            ],
            alpha: l.splat(background.alpha),
            usable: usable.map(|bound| l.splat(bound)),
        }
    }

    /// Returns linear RGB; `None` where [`normalize`] would scale a direction, and of an image.
    #[inline(always)]
    pub(crate) fn along<L: Lanes<8, F = F>>(&self, l: L, [x, y, z]: [F; 3]) -> Option<[F; 3]> {
        let largest = l.max(l.abs(x), l.max(l.abs(y), l.abs(z)));
        let [least, most] = self.usable;
        let usable = l.and(l.le(least, largest), l.le(largest, most));
        if l.bits(usable) != 0xff {
            return None;
        }
        let square = l.add(l.add(l.mul(x, x), l.mul(y, y)), l.mul(z, z));
        let height = l.div(y, l.sqrt(square));
        let is_up = l.le(l.splat(0.0), height);
        let height = l.abs(height);
        Some([
            self.channel(l, 0, is_up, height),
            self.channel(l, 1, is_up, height),
            self.channel(l, 2, is_up, height),
        ])
    }

    /// Not a closure: one that is not inlined leaves the instruction set.
    #[inline(always)]
    fn channel<L: Lanes<8, F = F>>(&self, l: L, channel: usize, is_up: L::M, height: F) -> F {
        let [up, down] = &self.slopes;
        let slope = l.select(is_up, up[channel % 3], down[channel % 3]);
        let colour = l.add(self.horizon[channel % 3], l.mul(slope, height));
        l.add(l.splat(0.0), l.mul(colour, self.alpha))
    }
}

//! Microfacets: GGX (Walter et al. 2007) with Smith's height-correlated masking (Heitz 2014) and
//! Schlick's Fresnel term (1994), as glTF's materials have them.

use crate::numeric::{max, min, normalize, sqrt};
use crate::scene::format::ROUGH;
use glam::Vec3;

/// Least roughness that lights see: their highlight is then about as wide as a pixel of a CAVE's
/// wall.
const LEAST_ROUGHNESS: f32 = 0.08;

/// Roughness up to which one ray shows all that is mirrored.
const SMOOTH: f32 = 0.2;

/// How a point of a surface reflects the light that leaves along a ray.
#[derive(Clone, Copy)]
pub(super) struct Lobe {
    pub(super) roughness: f32,
    /// Cosine between the ray and the normal, above 0.
    cosine: f32,
    /// Share of light reflected head-on.
    f0: Vec3,
    /// Share of light reflected at grazing angles.
    f90: f32,
    /// Factor for the light that leaves after several bounces between microfacets (Turquin 2019).
    gain: Vec3,
    /// Share of light from everywhere that is reflected.
    pub(super) albedo: Vec3,
}

impl Lobe {
    pub(super) fn new(f0: Vec3, roughness: f32, cosine: f32) -> Self {
        let cosine = max(cosine, 1.0e-3);
        let [scale, bias] = albedo(cosine, roughness);
        // What reflects nothing head-on reflects nothing at all.
        let f90 = min(50.0 * f0.max_element(), 1.0);
        let gain = Vec3::ONE + f0 * (1.0 / (scale + bias) - 1.0);
        Self {
            roughness,
            cosine,
            f0,
            f90,
            gain,
            albedo: (f0 * scale + Vec3::splat(f90 * bias)) * gain,
        }
    }

    /// Returns the share of `albedo` that one ray shows; the blurred background shows the rest.
    pub(super) fn sharpness(&self) -> f32 {
        max(min((ROUGH - self.roughness) / (ROUGH - SMOOTH), 1.0), 0.0)
    }

    /// Returns the radiance sent back along a ray, of light from a unit direction whose irradiance
    /// head-on is π; the direction's cosine to the normal is given.
    pub(super) fn answer(&self, normal: Vec3, ray: Vec3, (unit, cosine): (Vec3, f32)) -> Vec3 {
        let Some(half) = normalize(unit - ray) else {
            return Vec3::ZERO;
        };
        let roughness = max(self.roughness, LEAST_ROUGHNESS);
        let alpha = roughness * roughness;
        let squared = alpha * alpha;
        let away = max(1.0 - unit.dot(half), 0.0);
        let away = away * (away * away) * (away * away);
        let fresnel = self.f0 + (Vec3::splat(self.f90) - self.f0) * away;
        // By the sine, since one less the cosine's square loses its digits in narrow lobes.
        let (across, along) = (normal.cross(half), alpha * normal.dot(half));
        let spread = across.dot(across) + along * along;
        let masked = |cosine: f32| sqrt(cosine * cosine * (1.0 - squared) + squared);
        let masking = cosine * masked(self.cosine) + self.cosine * masked(cosine);
        fresnel * self.gain * (0.5 * cosine * squared / (spread * spread * masking))
    }
}

/// Places along each side of [`ALBEDO`].
const PLACES: usize = 16;

/// Returns the two parts of the share of light from everywhere that microfacets reflect (Karis
/// 2013): the factor of the share reflected head-on, and that of the share at grazing angles.
/// From a roughness of 0.06 and a cosine of 0.04 on, errors are at most 0.025, and the sum is at most
/// 0.001 too small: no more light is reflected than there is.
fn albedo(cosine: f32, roughness: f32) -> [f32; 2] {
    let last = (PLACES - 1) as f32;
    let place = |share: f32| {
        let at = min(max(share, 0.0), 1.0) * last;
        let first = (at as usize).min(PLACES - 2);
        (first, at - first as f32)
    };
    let (column, right) = place(sqrt(cosine));
    let (row, down) = place(roughness);
    [0, 1].map(|part| {
        let at = |row: usize, column: usize| {
            f32::from(ALBEDO[row % PLACES][column % PLACES][part % 2]) / 255.0
        };
        let between = |row: usize| at(row, column) * (1.0 - right) + at(row, column + 1) * right;
        between(row) * (1.0 - down) + between(row + 1) * down
    })
}

/// The two parts, of 255: by rows of roughness 0 to 1 and columns of the cosine's square root 0
/// to 1.
#[rustfmt::skip]
static ALBEDO: [[[u8; 2]; PLACES]; PLACES] = [
    [[2, 235], [6, 248], [22, 233], [47, 208], [79, 176], [113, 142], [148, 107], [180, 75], [207, 48], [228, 27], [242, 13], [250, 5], [253, 2], [255, 0], [255, 0], [255, 0]],
    [[20, 224], [16, 211], [25, 221], [50, 205], [80, 175], [114, 141], [149, 106], [180, 75], [207, 48], [228, 27], [241, 14], [250, 5], [253, 2], [255, 0], [255, 0], [255, 0]],
    [[59, 193], [55, 188], [50, 178], [65, 175], [89, 161], [120, 134], [151, 103], [182, 73], [208, 47], [228, 27], [241, 14], [250, 5], [253, 2], [255, 0], [255, 0], [255, 0]],
    [[98, 155], [96, 153], [89, 146], [88, 139], [101, 130], [124, 115], [154, 93], [182, 69], [207, 45], [227, 27], [240, 14], [248, 6], [253, 2], [255, 0], [255, 0], [255, 0]],
    [[132, 122], [131, 121], [126, 116], [123, 109], [126, 101], [138, 91], [158, 76], [181, 59], [205, 41], [224, 25], [238, 13], [246, 6], [251, 2], [253, 0], [254, 0], [254, 0]],
    [[160, 94], [159, 93], [156, 90], [152, 85], [151, 78], [156, 69], [167, 59], [183, 47], [201, 34], [218, 22], [231, 13], [241, 6], [247, 2], [249, 1], [251, 0], [252, 0]],
    [[182, 72], [181, 72], [178, 69], [175, 65], [173, 59], [173, 52], [177, 45], [186, 36], [198, 27], [212, 18], [223, 11], [233, 5], [239, 2], [243, 1], [246, 0], [247, 0]],
    [[199, 56], [198, 55], [195, 53], [192, 49], [188, 45], [186, 40], [188, 33], [191, 27], [197, 21], [205, 14], [214, 9], [222, 5], [229, 2], [233, 1], [238, 0], [240, 0]],
    [[211, 43], [210, 43], [207, 41], [203, 38], [199, 34], [195, 30], [194, 25], [194, 20], [196, 15], [199, 11], [204, 7], [210, 4], [215, 2], [220, 1], [224, 0], [227, 0]],
    [[220, 34], [219, 33], [215, 32], [211, 29], [205, 26], [200, 23], [197, 19], [194, 15], [192, 12], [193, 8], [195, 5], [197, 3], [200, 2], [203, 1], [208, 0], [211, 0]],
    [[227, 27], [225, 27], [220, 25], [215, 23], [209, 20], [203, 17], [197, 14], [193, 11], [188, 9], [186, 6], [184, 4], [184, 2], [184, 1], [185, 1], [187, 0], [190, 0]],
    [[232, 22], [230, 22], [224, 20], [217, 18], [209, 16], [201, 14], [195, 11], [188, 9], [181, 7], [176, 5], [173, 3], [169, 2], [167, 1], [167, 0], [166, 0], [166, 0]],
    [[235, 18], [233, 18], [226, 17], [218, 15], [208, 13], [199, 11], [190, 9], [181, 7], [174, 5], [166, 4], [161, 2], [155, 1], [150, 1], [147, 0], [144, 0], [142, 0]],
    [[238, 16], [235, 15], [227, 14], [218, 12], [207, 10], [195, 9], [184, 7], [174, 5], [164, 4], [155, 3], [147, 2], [140, 1], [133, 1], [128, 0], [123, 0], [118, 0]],
    [[240, 13], [237, 13], [227, 12], [216, 10], [203, 9], [190, 7], [178, 5], [166, 4], [154, 3], [144, 2], [134, 1], [125, 1], [117, 0], [110, 0], [103, 0], [97, 0]],
    [[241, 12], [237, 12], [226, 10], [213, 9], [199, 7], [184, 6], [170, 4], [157, 3], [144, 2], [131, 2], [121, 1], [110, 1], [102, 0], [93, 0], [85, 0], [79, 0]],
];

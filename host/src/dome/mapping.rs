use super::mirror::Mirror;
use shisen_core::capture;
use std::f64::consts::FRAC_PI_2;

/// How a dome master's pixels become directions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mapping {
    /// The paper's: the picture is what the mirror shows of the screen.
    #[default]
    Mirror,
    /// Through the mirror, at the point that reflects in the exact direction of the pixel. Rays
    /// still start on the mirror.
    Exact,
    /// An ideal fisheye lens: no mirror, one viewpoint.
    True,
}

named!(Mapping { Mirror => "mirror", Exact => "exact", True => "true" });

impl Mapping {
    /// Returns the core's mapping; `None` without a mirror.
    pub const fn core(self) -> Option<capture::Mapping> {
        match self {
            Self::Mirror => Some(capture::Mapping::Screen),
            Self::Exact => Some(capture::Mapping::Exact),
            Self::True => None,
        }
    }

    /// θ, the angle to the zenith of what is seen far away at `r_d`, both radians, 0 to π/2.
    pub fn theta(self, mirror: &Mirror, r_d: f64) -> f64 {
        match self {
            Self::Mirror => mirror.theta(r_d),
            Self::Exact | Self::True => r_d,
        }
    }

    /// Returns the inverse of [`theta`](Self::theta).
    pub fn r_d(self, mirror: &Mirror, theta: f64) -> f64 {
        match self {
            Self::Mirror => mirror.r_d(theta),
            Self::Exact | Self::True => theta,
        }
    }

    /// [`theta`](Self::theta) as the core computes it; `None` outside 0 to π/2.
    pub fn single_theta(self, mirror: &capture::SpheroidMirror, r_d: f32) -> Option<f32> {
        let rho = (f64::from(r_d) / FRAC_PI_2) as f32;
        let direction = match self {
            Self::Mirror => return mirror.theta(r_d),
            Self::Exact => mirror.pixel(rho, 0.0, capture::Mapping::Exact)?.direction,
            Self::True => capture::fisheye_equidistant(rho, 0.0, std::f32::consts::PI)?,
        };
        // The angle of a single-precision ray, in double precision.
        Some(libm::atan2(f64::from(direction.x), -f64::from(direction.z)) as f32)
    }

    /// [`r_d`](Self::r_d) as the core computes it; `None` outside 0 to π/2.
    pub fn single_r_d(self, mirror: &capture::SpheroidMirror, theta: f32) -> Option<f32> {
        match self {
            Self::Mirror => mirror.r_d(theta),
            Self::Exact | Self::True => (0.0..=std::f32::consts::FRAC_PI_2)
                .contains(&theta)
                .then_some(theta),
        }
    }
}

//! Eight rays of a dome master.

use crate::shape::Ray;
use crate::trace::{RayDetail, RowRays};
use glam::Vec3;

pub(crate) struct RayRow {
    pub(super) origins: [[f32; 8]; 3],
    pub(crate) directions: [[f32; 8]; 3],
    /// A bit for each lane inside the rim.
    pub(crate) seen: u32,
}

impl RayRow {
    pub(crate) const EMPTY: Self = Self {
        origins: [[0.0; 8]; 3],
        directions: [[0.0; 8]; 3],
        seen: 0,
    };

    /// Returns whether each place is inside the rim, with a ray that can be traced.
    pub(crate) fn are_all(&self) -> bool {
        (0..8).all(|lane| self.ray(lane).is_some())
    }

    /// Returns the rays inside the rim that have a detail.
    #[inline]
    pub(crate) fn together(&self, detail: &[Option<RayDetail>; 8]) -> RowRays<'_> {
        let mut active = 0;
        for (lane, detail) in detail.iter().enumerate() {
            let is_traced = detail.is_some() && self.ray(lane).is_some();
            active |= u32::from(is_traced) << lane;
        }
        RowRays {
            origins: &self.origins,
            directions: &self.directions,
            active,
        }
    }

    /// Returns the ray of a lane; `None` outside the rim.
    #[inline(always)]
    pub(crate) fn ray(&self, lane: usize) -> Option<Ray> {
        let lane = lane % 8;
        let [x, y, z] = &self.origins;
        let origin = Vec3::new(x[lane], y[lane], z[lane]);
        let [x, y, z] = &self.directions;
        let direction = Vec3::new(x[lane], y[lane], z[lane]);
        if self.seen >> lane & 1 == 0 {
            return None;
        }
        Ray::new(origin, direction)
    }
}

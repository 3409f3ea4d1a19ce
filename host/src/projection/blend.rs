//! Blending: how the projectors of one screen share its light.
//!
//! A projector's weight at a place is its share eₖ / Σ e of all projectors that light the place, where
//! e = [S(2 min(u, 1 − u)) · S(2 min(v, 1 − v))]ᵖ, S(x) = x²(3 − 2x), at the point (u, v) of its
//! picture, and p its exponent. So weights add up to 1, are 1 where a projector is alone up to its
//! outer edge, and 0 with no slope at its edge inside another's picture. Where the outlines of two
//! pictures cross at the border of both, no weights are continuous: [`Blend::is_at_crossing`].

use super::map::{Map, is_inside};
use super::projector::Projector;
use crate::cave::RoomError;
use glam::DVec2;

/// The projectors that light one screen for the same eye.
#[derive(Debug)]
pub struct Blend<'a> {
    pub(super) members: Vec<Member<'a>>,
}

/// A projector and its light on the screen.
#[derive(Debug)]
pub(super) struct Member<'a> {
    pub(super) projector: &'a Projector,
    pub(super) map: Map<'a>,
    /// Its number in the room.
    pub(super) number: usize,
}

impl<'a> Blend<'a> {
    /// Share of a picture within which a place counts as at a crossing.
    pub const CROSSING: f64 = 0.02;
    /// Greatest light, of white's, that a place of files' own weights may have.
    const MOST_LIGHT: f64 = 1.1;

    pub(super) fn new(members: Vec<Member<'a>>) -> Result<Self, RoomError> {
        let blend = Self { members };
        blend.check_own_shares()?;
        Ok(blend)
    }

    /// Returns the projectors.
    pub fn projectors(&self) -> impl Iterator<Item = &'a Projector> {
        self.members.iter().map(|member| member.projector)
    }

    /// Returns a projector's factor on the screen's light at a point that lights a place, 0 to 1, and
    /// the light that its mesh's file adds.
    pub(super) fn share(&self, member: usize, at: DVec2, place: DVec2) -> [f64; 2] {
        let own = self.members[member].own_share(at);
        own.unwrap_or_else(|| [self.weight(member, at, place), 0.0])
    }

    fn weight(&self, member: usize, at: DVec2, place: DVec2) -> f64 {
        let others = self.members.iter().enumerate();
        let others = others.filter(|(number, _)| *number != member);
        let others = others
            .filter_map(|(_, other)| Some(presence(other.map.at(place)?, other.projector.blend)));
        let own = presence(at, self.members[member].projector.blend);
        let sum = own + others.sum::<f64>();
        if sum > 0.0 { own / sum } else { 1.0 }
    }

    /// Returns the light at a place when all projectors show black, as a share of white's.
    pub(super) fn black(&self, place: DVec2) -> f64 {
        let lit = self
            .members
            .iter()
            .filter(|member| member.projector.black > 0.0 && member.map.at(place).is_some());
        lit.map(|member| member.projector.black).sum()
    }

    /// Returns whether a place is within [`Self::CROSSING`] of two pictures' outlines, and not
    /// farther inside a third: where these cross, the light may not add up.
    pub fn is_at_crossing(&self, place: DVec2) -> bool {
        let depths = self.members.iter().filter_map(|member| {
            let at = member.map.at_or_beyond(place)?;
            Some(at.min(1.0 - at).min_element())
        });
        let (mut near, mut is_inside) = (0, false);
        for depth in depths {
            near += usize::from(depth.abs() <= Self::CROSSING);
            is_inside |= depth > Self::CROSSING;
        }
        near >= 2 && !is_inside
    }

    /// Refuses overlaps that files' own weights do not blend.
    fn check_own_shares(&self) -> Result<(), RoomError> {
        /// Points a side that are tried.
        const TRIED: u32 = 48;
        for (number, member) in self.members.iter().enumerate() {
            if !member.map.has_own_shares() {
                continue;
            }
            let along = |number: u32| (f64::from(number) + 0.5) / f64::from(TRIED);
            for point in (0..TRIED).flat_map(|y| (0..TRIED).map(move |x| [x, y])) {
                let at = DVec2::from(point.map(along));
                let Some(place) = member.map.place(at) else {
                    continue;
                };
                let mut light = member.own_share(at).map_or(0.0, |[factor, _]| factor);
                for other in self.members.iter().enumerate() {
                    let Some(at) = other.1.map.at(place).filter(|_| other.0 != number) else {
                        continue;
                    };
                    light += other.1.own_share(at).map_or(1.0, |[factor, _]| factor);
                    if light > Self::MOST_LIGHT {
                        return Err(RoomError::new(
                            "mesh",
                            format!(
                                "projectors \"{}\" and \"{}\" overlap without blending: their \
                                 meshes' weights give {light:.2} times the light at {:.3}, {:.3} \
                                 of screen \"{}\"",
                                member.projector.name,
                                other.1.projector.name,
                                place.x,
                                place.y,
                                member.map.screen().name()
                            ),
                            "export the meshes of all the screen's projectors with weights that add \
                             up to 1, or all without weights",
                        ));
                    }
                }
            }
        }
        Ok(())
    }
}

impl Member<'_> {
    /// Returns what the mesh's file gives: the factor on light, and the light that is added.
    pub(super) fn own_share(&self, at: DVec2) -> Option<[f64; 2]> {
        self.map
            .own_share(at, |code| self.projector.gamma[0].light(code))
    }
}

/// Returns how much a projector is at a point of its picture: 0 at the edges and outside, 1 in the
/// middle.
fn presence(at: DVec2, exponent: f64) -> f64 {
    if !is_inside(at) {
        return 0.0;
    }
    let depth = 2.0 * at.min(1.0 - at);
    let smooth = depth * depth * (3.0 - 2.0 * depth);
    let product = smooth.x * smooth.y;
    if exponent == 1.0 {
        return product;
    }
    libm::pow(product, exponent)
}

//! The problem at the door: units taken off.

use super::approximation::{Boundary, Error};
use super::ray::ScaledOverlap;
use crate::clock::Deadline;
use crate::error::{InputError, finite};
use crate::gap::{AnyGap, Gap};
use crate::overlap::{self, Units, least};
use crate::problem::EffectiveModulus;
use crate::solution::{Unsolved, Verdict};

/// The problem in units of its own.
pub(crate) struct Problem {
    pub overlap: ScaledOverlap,
    pub e_star: f64,
    /// How far from the origin the overlap may reach, in units of length.
    pub reach: f64,
    /// Centre and half sides of the rectangle that holds the overlap.
    pub middle: [f64; 2],
    pub half: [f64; 2],
    /// Whether that had to be searched: the gap may hold surprises.
    pub searched: bool,
}

impl Problem {
    /// Unit of depth: the overlap at the centre. Unit of length: a mean reach of the overlap.
    pub fn new(gap: impl Into<AnyGap>, modulus: EffectiveModulus, depth: f64) -> Result<Self, Error> {
        let gap = &gap.into();
        finite("depth", depth)?;
        let apart = || Unsolved::new(Verdict::NotApplicable, format!("the bodies do not touch at depth {depth}"));
        let found = overlap::Overlap::of(gap, depth)?.ok_or_else(apart)?;
        let (rect, searched) = (found.reach, !found.certain);
        let mut origin = gap.known().centre;
        if !(depth > gap.gap(origin[0], origin[1])) {
            origin = least(gap).0;
        }
        let unit = depth - gap.gap(origin[0], origin[1]);
        if !(unit > 0.0) {
            return Err(apart().into());
        }
        let [w, h] = rect.size();
        let length = 0.5 * w.sqrt() * h.sqrt();
        let far = rect.corners().iter().map(|c| (c[0] - origin[0]).hypot(c[1] - origin[1])).fold(0.0, f64::max);
        if !(unit.is_normal() && length.is_normal() && (unit * length).is_normal()) {
            return Err(InputError::new("depth", depth, "a depth at which force and contact can be represented").into());
        }
        let units = Units { origin, length, height: unit };
        Ok(Self {
            overlap: ScaledOverlap::new(gap, units, depth / unit),
            e_star: modulus.e_star(),
            reach: far / length,
            middle: units.inward(rect.centre()),
            half: rect.size().map(|side| 0.5 * side / length),
            searched,
        })
    }

    /// The same, whose evaluation stops at the deadline.
    pub fn before(mut self, deadline: Deadline) -> Self {
        self.overlap.deadline = deadline;
        self
    }

    /// 2E* length depth: the unit of P for D.
    pub fn force_unit(&self) -> f64 {
        2.0 * self.e_star * self.overlap.units.length * self.overlap.units.height
    }

    /// A boundary in the user's units.
    pub fn boundary(&self, centre: [f64; 2], outline: Vec<[f64; 2]>) -> Boundary {
        let length = self.overlap.units.length;
        Boundary {
            centre: self.overlap.units.outward(centre),
            outline: outline.into_iter().map(|[theta, a]| [theta, a * length]).collect(),
        }
    }
}

/// Rung of the ladder of radial rules to start from.
pub(crate) fn first_rule_level(tolerance: f64) -> usize {
    usize::from(tolerance < 3e-5)
}

pub(super) fn several_parts(angle: f64) -> Unsolved {
    Unsolved::new(
        Verdict::NotStarShaped,
        format!(
            "the bodies overlap again further out in the direction of {:.4} degrees: the contact may have several parts",
            angle.to_degrees().rem_euclid(360.0)
        ),
    )
}

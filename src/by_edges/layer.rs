//! A flat with flanks at a small depth: no grid resolves what the contact passes the flat by, and none needs to.
//!
//! Let the gap be the highest of several planes, one of them level at g0, F the polygon where that is the highest, and d the depth less
//! g0. Every other plane is g0 - h_i + a_i (x - c) with h_i > 0 for a point c inside of F, so {gap < g0 + s} lies within F enlarged
//! about c by the factor 1 + s/h, h the least of the h_i. P is the integral of the stiffness of the contact, which grows with the
//! contact, and K of an enlarged set is enlarged by as much:
//!
//! ```text
//! K(F) d <= P <= integral from 0 to d of K(F) (1 + s/h) ds = K(F) d (1 + d/(2 h)).
//! ```
//!
//! On the left the overlap is d on F alone (Barber 1974: more overlap, more force).

use super::Found;
use super::flat::{Flat, MOST_CORNERS};
use crate::edge_fitted::Limits;
use crate::gap::Gap;
use crate::numeric::geometry::{Rect, clip};
use crate::overlap::Overlap;
use crate::problem::{Contact, Settings};

/// A flat with flanks, small beside its flat as far as the contact goes.
pub(crate) struct Layer {
    flat: Flat,
    /// d/h.
    growth: f64,
}

/// The highest of several planes where one of them is level and lowest.
pub(crate) struct FlatTip {
    /// Corners of the flat about `middle`, counter-clockwise.
    pub face: Vec<[f64; 2]>,
    pub middle: [f64; 2],
    /// The height of the flat, and the depth below it.
    pub level: f64,
    pub depth: f64,
    /// The other planes about `middle`, less that height.
    pub flanks: Vec<[f64; 3]>,
    /// d/h.
    pub growth: f64,
    /// What rounding may change their heights by.
    pub rounding: f64,
}

/// The part of the tolerance that the growth of the contact may take: the stiffness of the flat is then cheap; and the most, where nothing
/// else comes as near.
const SHARE: f64 = 0.65;
const MOST_SHARE: f64 = 0.8;

impl FlatTip {
    /// `None` where the gap has no level plane below all others somewhere.
    pub fn of(overlap: &Overlap) -> Option<Self> {
        let planes = overlap.gap.planes().filter(|planes| planes.len() <= MOST_CORNERS)?;
        let level = level_of(&planes)?;
        let flanks: Vec<[f64; 3]> = planes.into_iter().filter(|p| p[0] != 0.0 || p[1] != 0.0).collect();
        let depth = overlap.depth - level;
        // The face is where all flanks are below it.
        let middle = overlap.reach.centre();
        let box_of_reach = overlap.reach.scaled(1.0 + 1e-6);
        let own = box_of_reach.corners().map(|[x, y]| [x - middle[0], y - middle[1]]);
        let below = |[a, b, c]: &[f64; 3]| [*a, *b, c - level + a * middle[0] + b * middle[1]];
        let relative: Vec<[f64; 3]> = flanks.iter().map(below).collect();
        let face = relative.iter().fold(own.to_vec(), |left, [a, b, c]| clip(&left, *a, *b, *c));
        if face.len() < 3 || touches(&face, &own) {
            return None;
        }
        let within = Rect::holding(face.iter().copied())?.centre();
        let height = |[a, b, c]: &[f64; 3]| -(a * within[0] + b * within[1] + c);
        let least = relative.iter().map(height).fold(f64::INFINITY, f64::min);
        // What cancels in a height.
        let size = |[a, b, c]: &[f64; 3]| {
            (a * within[0]).abs() + (b * within[1]).abs() + c.abs() + (a * middle[0]).abs() + (b * middle[1]).abs()
        };
        let rounding = 16.0 * f64::EPSILON * relative.iter().map(size).fold(level.abs(), f64::max);
        let growth = depth / (least - rounding);
        (growth > 0.0).then_some(Self { face, middle, level, depth, flanks: relative, growth, rounding })
    }
}

impl Layer {
    /// `None` where the growth alone takes too much of the tolerance.
    pub(super) fn of(tip: &FlatTip, tolerance: f64) -> Option<Self> {
        Self::up_to(tip, 4.0 * SHARE * tolerance)
    }

    /// The same where the growth leaves little for the flat itself.
    pub(super) fn at_most(tip: &FlatTip, tolerance: f64) -> Option<Self> {
        Self::up_to(tip, 4.0 * MOST_SHARE * tolerance)
    }

    /// The same where the contact passes the flat by at most `most` of its size.
    pub(super) fn up_to(tip: &FlatTip, most: f64) -> Option<Self> {
        let FlatTip { face, middle, level, growth, .. } = tip;
        if *growth > most {
            return None;
        }
        let flat = Flat::polygon(face, *middle, [1.0, 0.0], *level)?;
        Some(Self { flat, growth: *growth })
    }

    pub fn found(&self) -> String {
        format!(
            "a flat with flanks, which the contact passes by at most {:.1e} of its size: the force is that of the flat",
            self.growth
        )
    }

    /// Bounds of P/E*.
    pub(super) fn force(&self, depth: f64, limits: &Limits) -> Option<[f64; 2]> {
        let [low, high] = self.flat.punch(limits)?.stiffness.map(|k| k * (depth - self.flat.value));
        Some([low, high * (1.0 + 0.5 * self.growth * (1.0 + 8.0 * f64::EPSILON))])
    }

    pub(super) fn solve(&self, contact: &Contact, depth: f64, settings: &Settings, limits: &Limits) -> Option<Found> {
        let growth = self.growth * (1.0 + 4.0 * f64::EPSILON);
        // The growth alone takes a quarter of it.
        let limits = Limits { tolerance: (limits.tolerance - 0.26 * growth).max(0.05 * growth), ..*limits };
        let punch = self.flat.punch(&limits)?;
        let mut found =
            self.flat.state(contact, depth - self.flat.value, settings, punch, format!("the gap is {}", self.found()));
        found.force[1] *= 1.0 + 0.5 * growth;
        // U = integral of P.
        found.energy[1] *= 1.0 + growth / 3.0;
        // K of the contact is from K(F) to K(F) (1 + d/h), its area from that of F to (1 + d/h)^2 times as much.
        found.stiffness *= 1.0 + 0.5 * growth;
        found.stiffness_error = found.stiffness_error.map(|error| error + 0.5 * growth * (1.0 + error));
        found.area_error = found.area_error.map(|error| error + growth * (2.0 + growth));
        found.left_out = "the surface grid: bounds by the flat are as close as asked for";
        Some(found)
    }
}

/// The height of the highest level plane.
pub(super) fn level_of(planes: &[[f64; 3]]) -> Option<f64> {
    planes.iter().filter(|p| p[0] == 0.0 && p[1] == 0.0).map(|p| p[2]).reduce(f64::max)
}

/// Whether a corner of the polygon lies on the box that it was cut from.
fn touches(face: &[[f64; 2]], own: &[[f64; 2]; 4]) -> bool {
    let (low, high) = (own[0], own[2]);
    face.iter().any(|p| (0..2).any(|m| p[m] <= low[m] || p[m] >= high[m]))
}

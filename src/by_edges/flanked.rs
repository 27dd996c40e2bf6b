//! A flat with flanks at a depth at which the contact passes the flat by more than the tolerance, and by less than its size.

use super::Found;
use super::estimated::in_users_units;
use super::layer::FlatTip;
use crate::edge_fitted::{Bounded, Estimated, FlankedFlat, Limits, flanked, flanked_bounds};
use crate::numeric::geometry::{Rect, area, centroid, convex_hull, distance, meeting};
use crate::overlap::Units;
use crate::problem::{Contact, ErrorBar, Settings};

/// A convex polygon with a flank at each of its sides, in units of its own: lengths about its centroid, over half the longer side of its box;
/// heights over the depth.
pub(crate) struct FlankedTip {
    corners: Vec<[f64; 2]>,
    drift: Vec<[f64; 2]>,
    sides: Vec<[f64; 3]>,
    planes: Vec<[f64; 3]>,
    growth: f64,
    /// What rounding may change the planes by.
    rounding: f64,
    /// Whether every flank begins at a side of the flat.
    complete: bool,
    units: Units,
}

/// Growth of the contact over the size of the flat up to which cells are fitted to the flat.
const MOST_GROWTH: f64 = 0.32;

/// Unknowns of bounds: about a millisecond each.
const MOST_PROVED: usize = 700;

/// Sides of a flat.
const MOST_SIDES: usize = 12;

/// What a corner may be off by, over the size of the flat.
const CLOSE: f64 = 1e-9;

impl FlankedTip {
    /// `None` where there is no such flat, or the contact is not small beside it.
    pub(super) fn of(tip: &FlatTip) -> Option<Self> {
        let FlatTip { face, middle, depth, flanks, rounding, .. } = tip;
        let about = centroid(face);
        let [w, h] = Rect::holding(face.iter().copied())?.size();
        let length = 0.5 * w.max(h);
        let inward = |p: &[f64; 2]| [0, 1].map(|m| (p[m] - about[m]) / length);
        let corners = convex_hull(distinct(face.iter().map(inward).collect()));
        let planes: Vec<[f64; 3]> = flanks
            .iter()
            .map(|[a, b, c]| [a * length, b * length, c + a * about[0] + b * about[1]].map(|v| v / depth))
            .collect();
        // Of the flanks about the centroid: d/h.
        let growth = planes.iter().map(|[_, _, c]| -1.0 / c).fold(0.0, f64::max);
        let n = corners.len();
        if !((3..=MOST_SIDES).contains(&n) && planes.iter().all(|p| p[2] < 0.0) && growth <= MOST_GROWTH) {
            return None;
        }
        // The plane that begins at each side.
        let side = |k: usize| {
            let (p, q) = (corners[k], corners[(k + 1) % n]);
            let middle = [0, 1].map(|m| 0.5 * (p[m] + q[m]));
            let off = |[a, b, c]: &[f64; 3]| (a * middle[0] + b * middle[1] + c).abs() / a.hypot(*b);
            planes.iter().min_by(|p, q| off(p).total_cmp(&off(q))).filter(|plane| off(plane) <= CLOSE)
        };
        let sides: Vec<[f64; 3]> = (0..n).map(|k| side(k).copied()).collect::<Option<_>>()?;
        // A corner moves with both of its sides: a . v = 1.
        let drift = (0..n).map(|k| meeting([sides[(k + n - 1) % n], sides[k]].map(|[a, b, _]| [a, b, -1.0]))).collect();
        let units = Units { origin: [0, 1].map(|m| middle[m] + about[m]), length, height: *depth };
        Some(Self {
            corners,
            drift,
            sides,
            complete: planes.len() == n,
            planes,
            growth,
            rounding: rounding / depth,
            units,
        })
    }

    /// Whether the tolerance, relative, asks for no more cells than can be solved.
    pub(super) fn fits(&self, tolerance: f64) -> bool {
        self.flat(&|_| 0.0).fits(&Limits { tolerance, ..Limits::default() })
    }

    fn flat<'a>(&'a self, overlap: &'a dyn Fn([f64; 2]) -> f64) -> FlankedFlat<'a> {
        let Self { corners, drift, sides, planes, growth, rounding, complete, .. } = self;
        let (growth, rounding) = (*growth, *rounding);
        FlankedFlat { corners, drift, sides, planes, growth, rounding, symmetric: *complete, overlap }
    }

    pub fn found(&self) -> String {
        format!("a flat of {} sides with flanks, which the contact passes by a strip", self.corners.len())
    }

    /// Proved where that is asked for and comes as near as the tolerance, else estimated.
    pub(super) fn solve(&self, contact: &Contact, settings: &Settings, limits: &Limits) -> Option<Found> {
        let highest = |p: [f64; 2]| self.planes.iter().map(|[a, b, c]| a * p[0] + b * p[1] + c).fold(0.0, f64::max);
        let overlap = |p: [f64; 2]| 1.0 - highest(p);
        let flat = self.flat(&overlap);
        let few = Limits { unknowns: MOST_PROVED.min(limits.unknowns), ..*limits };
        let bounded = (settings.evidence == ErrorBar::Proof).then(|| flanked_bounds(&flat, &few)).flatten();
        if let Some(bounded) = bounded.filter(|bounded| bounded.width() <= limits.tolerance) {
            return self.proved(bounded, contact, settings);
        }
        self.found_from(flanked(&flat, limits)?, contact, settings)
    }

    fn found_from(&self, found: Estimated, contact: &Contact, settings: &Settings) -> Option<Found> {
        let (mut load, mut first) = (0.0, [0.0; 2]);
        for (corners, p) in &found.cells {
            let (own, at) = (p * area(corners), centroid(corners));
            load += own;
            first = [0, 1].map(|m| first[m] + own * at[m]);
        }
        let about = [centroid(&found.ends[0]), first.map(|x| x / load)];
        Some(Found {
            // Infinite along the edges of the flat.
            max: None,
            max_error: None,
            how: format!("the gap is {}", self.found()),
            left_out: "the surface grid: cells follow the edges of the flat",
            ..in_users_units(found, &self.units, about, contact, settings)?
        })
    }

    fn proved(&self, bounded: Bounded, contact: &Contact, settings: &Settings) -> Option<Found> {
        let middle = |[a, b]: [f64; 2]| 0.5 * (a + b);
        let half = |[a, b]: [f64; 2]| (b - a).abs() / (a + b);
        let error = bounded.width();
        let Bounded { bounds, stiffness, area, area_error, end, cells, unknowns } = bounded;
        let state = Estimated {
            force: middle(bounds.force),
            error,
            energy: middle(bounds.energy),
            stiffness: middle(stiffness),
            stiffness_error: half(stiffness) + error,
            stiffness_matrix: None,
            area,
            area_error,
            max_error: None,
            cells,
            ends: vec![end],
            unknowns,
        };
        let found = self.found_from(state, contact, settings)?;
        let unit = contact.modulus().e_star() * self.units.height * self.units.length;
        let [force, energy] = [bounds.force.map(|p| p * unit), bounds.energy.map(|u| u * unit * self.units.height)];
        Some(Found { force, energy, proved: true, ..found })
    }
}

/// Corners without those that coincide.
fn distinct(corners: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    let n = corners.len();
    (0..n).filter(|&k| !(distance(corners[k], corners[(k + 1) % n]) <= CLOSE)).map(|k| corners[k]).collect()
}

//! Overlaps that stay high nearly up to their sides in both directions: flats with rounded or sloping edges, beside sharp ones or not.

use super::Found;
use super::estimated::in_users_units;
use super::roller::{in_material, rectangle};
use super::strip::{Lines, interval, middle};
use crate::edge_fitted::{Boxed, Limits, OverlapBox, equidistributed};
use crate::gap::{AnyGap, Gap};
use crate::numeric::geometry::{Rect, centroid};
use crate::numeric::scalar::bisected;
use crate::overlap::{Overlap, Scaled, Units};
use crate::problem::{Contact, Settings};

/// The box in which the bodies overlap, in the units of the solve.
pub(crate) struct Plateau {
    gap: AnyGap,
    depth: f64,
    units: Units,
    /// That box.
    all: OverlapBox,
}

/// How far from the nearer of two sides the overlap is high, over half the box, at most: 0.37 of a paraboloid or across a cylinder, 0.2 of
/// |x|^4; and how far towards the corners of the box there is overlap at least: round ones are not along its lines.
const BOX: [f64; 2] = [0.22, 0.8];

/// The same of states on the way to a tilt, and between sharp edges where nothing else can be solved.
const ON_THE_WAY: [f64; 2] = [0.3, 0.6];
const BETWEEN_EDGES: [f64; 2] = [0.45, 0.6];

/// Lines across on which it is looked where the sides are.
const LINES: usize = 8;

/// Share of the overlap in the middle from which it counts as high, and halvings to where it is.
const HIGH: f64 = 0.6;
const HALVINGS: usize = 24;

impl Plateau {
    /// `None` where the overlap is no such box, or is not known to be nowhere else.
    /// `searched`: a tilt for a load is looked for, on states that may be less of a box on the way.
    pub fn of(overlap: &Overlap, searched: bool) -> Option<Self> {
        Self::within(overlap, if searched { ON_THE_WAY } else { BOX })
    }

    /// One that rises slowly between sharp edges, to be solved where nothing else can.
    pub fn between_edges(overlap: &Overlap) -> Option<Self> {
        overlap.known().ends.as_ref()?;
        Self::within(overlap, BETWEEN_EDGES)
    }

    fn within(overlap: &Overlap, [steep, corner]: [f64; 2]) -> Option<Self> {
        let known = overlap.known();
        // On a grid it is told cell by cell what samples leave open.
        let told = known.law.is_some() || known.quadratic.is_some() || known.crown.is_some();
        if !overlap.certain || told || overlap.gap.is_measured() {
            return None;
        }
        let Scaled { gap, depth, reach, units, .. } = overlap.scaled();
        let rect = match known.ends.as_deref() {
            Some(corners) => Some(rectangle(corners)?),
            None => None,
        };
        let (reach, material) = in_material(reach, rect.as_ref(), &units)?;
        let on_line = |m: usize, across: f64| {
            let value = |s: f64| if m == 0 { gap.gap(s, across) } else { gap.gap(across, s) };
            interval(value, depth, [reach.min[m], reach.max[m]], Some(middle([reach.min[m], reach.max[m]])))
        };
        let x = on_line(0, reach.centre()[1])?;
        let y = on_line(1, middle(x))?;
        // Sides need not be parallel to the axes: a tilt turns them.
        let beside = |m: usize, [a, b]: [f64; 2]| {
            let lines = (0..=LINES).filter_map(|k| on_line(m, a + (b - a) * k as f64 / LINES as f64));
            lines.reduce(|all, own| [all[0].min(own[0]), all[1].max(own[1])])
        };
        let (x, y) = (beside(0, y)?, beside(1, x)?);
        let rect = Rect { min: [x[0], y[0]], max: [x[1], y[1]] };
        let [w, h] = rect.size();
        let f = |x: f64, y: f64| depth - gap.gap(x, y);
        let [cx, cy] = rect.centre();
        if !(f(cx, cy) > 0.0) {
            return None;
        }
        let is_inside = |[i, j]: [f64; 2]| f(cx + i * 0.5 * corner * w, cy + j * 0.5 * corner * h) > 0.0;
        if ![[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]].into_iter().all(is_inside) {
            return None;
        }
        let enough = HIGH * f(cx, cy);
        let rise = [0, 1].map(|m| {
            let half = 0.5 * [w, h][m];
            let [from, to] = [rect.min[m], rect.max[m]];
            let low = |at: f64| (if m == 0 { f(at, cy) } else { f(cx, at) }) < enough;
            let distance = |end: f64, inward: f64| {
                let low = |s: f64| low(end + inward * s);
                if low(0.0) { bisected(low, [0.0, half], HALVINGS)[1] } else { 0.0 }
            };
            distance(from, 1.0).min(distance(to, -1.0))
        });
        if [0, 1].into_iter().any(|m| rise[m] > steep * 0.5 * [w, h][m]) {
            return None;
        }
        gap.bounds(&rect, [0.0; 2]).filter(|[_, high]| *high < f64::INFINITY)?;
        let lines = Lines(vec![x; 2]);
        let only = lines.hold_all(&gap, depth, reach, |own| {
            lines.hold([(own.min[1] - y[0]) / h, (own.max[1] - y[0]) / h], [own.min[0], own.max[0]])
        });
        if !only {
            return None;
        }
        let edges = [0, 1].map(|m| {
            [0, 1].map(|end| {
                material
                    .as_ref()
                    .is_some_and(|own| if end == 0 { own.min[m] == rect.min[m] } else { own.max[m] == rect.max[m] })
            })
        });
        let centre = units.inward(known.centre);
        let all = OverlapBox { rect, edges, rise, mirrors: known.mirrors, centre };
        Some(Self { gap, depth, units, all })
    }

    pub fn found(&self) -> String {
        "a flat whose edges are rounded or slope: the overlap stays high nearly up to its sides".to_owned()
    }

    pub(super) fn solve(&self, contact: &Contact, settings: &Settings, limits: &Limits) -> Option<Found> {
        let overlap = |[x, y]: [f64; 2]| self.depth - self.gap.gap(x, y);
        let Boxed { state, energy_error, singular } = equidistributed(&overlap, &self.all, limits)?;
        let middle = [centroid(&state.ends[0]), state.centre()];
        let found = in_users_units(state, &self.units, middle, contact, settings)?;
        let energy = 0.5 * (found.energy[0] + found.energy[1]);
        Some(Found {
            how: format!("the gap is {}", self.found()),
            left_out: "the surface grid: lines that lie where the pressure changes are enough",
            energy: [energy * (1.0 - energy_error), energy * (1.0 + energy_error)],
            max: found.max.filter(|_| !singular),
            ..found
        })
    }
}

//! Rollers with sharp ends: material in a rectangle, the contact from one side of it to the other.

use super::Found;
use super::estimated::in_users_units;
use super::strip::{Lines, interval, line_by_line, middle};
use crate::edge_fitted::{self, Limits, mirrors, roller};
use crate::gap::{AnyGap, Gap};
use crate::numeric::geometry::{Rect, area, centroid};
use crate::overlap::{Overlap, Scaled, Units};
use crate::problem::{Contact, Settings};

/// The strip in which the bodies overlap, in the units of the solve; u is measured across it and v along.
pub(crate) struct Roller {
    gap: AnyGap,
    depth: f64,
    units: Units,
    /// The direction that it runs along: 0 for x, 1 for y.
    along: usize,
    /// Where the material ends along and, at most, across.
    ends: [f64; 2],
    sides: [f64; 2],
    /// Which sides the bodies overlap up to, all along.
    full: [bool; 2],
    /// The middle across of the line in the middle.
    inside: f64,
    /// Mirrors in lines across (u) and along (v), and where these cross.
    mirrors: [bool; 2],
    centre: [f64; 2],
}

/// Relative difference of a rectangle with rounded corners from one.
const ROUNDING: f64 = 1e-12;

/// How far inside of an edge the gap is looked at, over the size of the rectangle: what that leaves out of a force is of its order.
const INSET: f64 = 1e-11;

/// Lines across between which the strip is taken to be straight.
const LINES: usize = 128;

/// A rectangle of x and y as one of u and v: turned by a quarter where the strip runs along x.
fn inward(along: usize, Rect { min, max }: &Rect) -> Rect {
    if along == 1 { Rect { min: *min, max: *max } } else { Rect { min: [-max[1], min[0]], max: [-min[1], max[0]] } }
}

impl Roller {
    /// `None` where the overlap is no such strip, or is not known to be nowhere else.
    pub fn of(overlap: &Overlap) -> Option<Self> {
        let known = overlap.known();
        let corners = known.ends.as_ref().filter(|corners| corners.len() == 4 && overlap.certain)?;
        let rect = Rect::holding(corners.iter().copied())?;
        let [w, h] = rect.size();
        if !((area(corners) / (w * h)).abs() >= 1.0 - ROUNDING) {
            return None;
        }
        let Scaled { gap, depth, reach, units, .. } = overlap.scaled();
        let material = units.rect_inward(&rect);
        let inset = INSET * material.longer_side();
        let material = Rect { min: material.min.map(|a| a + inset), max: material.max.map(|b| b - inset) };
        let reach = reach.intersection(&material)?;
        // All of it is material.
        gap.bounds(&reach, [0.0; 2]).filter(|[_, high]| *high < f64::INFINITY)?;
        let longer = usize::from(h >= w);
        [longer, 1 - longer].into_iter().find_map(|along| {
            let (ends, across) = ([material.min[along], material.max[along]], 1 - along);
            if !(reach.min[along] <= ends[0] && ends[1] <= reach.max[along]) {
                return None;
            }
            let inner = inward(along, &reach);
            let sides = [inner.min[0], inner.max[0]];
            let mirrors = [known.mirrors[across], known.mirrors[along]];
            let centre = inward(along, &Rect::around(units.inward(known.centre), [0.0; 2])).min;
            let gap = gap.clone();
            let strip = Self { gap, depth, units, along, ends, sides, full: [false; 2], inside: 0.0, mirrors, centre };
            strip.checked(&reach)
        })
    }

    fn outward(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        if self.along == 1 { [u, v] } else { [v, -u] }
    }

    /// Where the bodies overlap across, about `inside` if they do there.
    fn across(&self, v: f64, inside: Option<f64>) -> Option<[f64; 2]> {
        let gap = |u: f64| {
            let [x, y] = self.outward([u, v]);
            self.gap.gap(x, y)
        };
        interval(gap, self.depth, self.sides, inside)
    }

    /// With what its overlap does at the sides, the same all along, and nowhere else than in the strip.
    fn checked(self, reach: &Rect) -> Option<Self> {
        let at = |k: usize| self.ends[0] + (self.ends[1] - self.ends[0]) * k as f64 / LINES as f64;
        let lines = line_by_line(LINES, |k, inside| self.across(at(k), inside))?;
        let inside = middle(lines[LINES / 2]);
        let full = [0, 1].map(|m| lines.iter().all(|line| line[m] == self.sides[m]));
        let lines = Lines(lines);
        let share = |v: f64| (v - self.ends[0]) / (self.ends[1] - self.ends[0]);
        let only = lines.hold_all(&self.gap, self.depth, *reach, |own| {
            let Rect { min, max } = inward(self.along, own);
            lines.hold([share(min[1]), share(max[1])], [min[0], max[0]])
        });
        only.then_some(Self { full, inside, ..self })
    }

    pub fn found(&self) -> String {
        "a roller with sharp ends: it overlaps on a strip between two sides of a rectangle of material".to_owned()
    }

    pub(super) fn solve(&self, contact: &Contact, settings: &Settings, limits: &Limits) -> Option<Found> {
        let overlap = |p: [f64; 2]| {
            let [x, y] = self.outward(p);
            self.depth - self.gap.gap(x, y)
        };
        let group = mirrors(self.centre, self.mirrors);
        let across = |v: f64| self.across(v, Some(self.inside));
        let with = |moves: [bool; 2]| {
            let strip = edge_fitted::Roller { overlap: &across, ends: self.ends, moves, group: group.clone() };
            roller(&overlap, &strip, limits)
        };
        // The contact may end before the bodies cease to overlap.
        let moves = self.full.map(|full| !full);
        let found = with(moves).or_else(|| if moves == [true; 2] { None } else { with([true; 2]) })?;
        let found = found.in_axes(|p| self.outward(p));
        let middle = [centroid(&found.ends[0]), found.centre()];
        let found = in_users_units(found, &self.units, middle, contact, settings)?;
        Some(Found {
            how: format!("the gap is {}", self.found()),
            left_out: "the surface grid: rows of cells across the strip are enough",
            max: None,
            ..found
        })
    }
}

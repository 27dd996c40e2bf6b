//! Rollers with sharp or steep ends, straight or misaligned: material in a rectangle, the contact from one side of it to the other, or as far
//! as the bodies overlap where that ends the contact all but as an edge would, at one end at least.

use super::Found;
use super::estimated::in_users_units;
use super::strip::{Lines, interval, line_by_line, middle};
use crate::edge_fitted::{self, Limits, LineContact, line_contact, mirrors, roller};
use crate::gap::{AnyGap, Gap};
use crate::numeric::geometry::{Rect, area, centroid};
use crate::numeric::scalar::bisected;
use crate::overlap::{Overlap, Scaled, Units};
use crate::problem::{Contact, Settings};

/// The strip in which the bodies overlap, in the units of the solve; u is measured across it and v along.
#[derive(Clone)]
pub(crate) struct Roller {
    gap: AnyGap,
    depth: f64,
    units: Units,
    /// The direction that it runs along: 0 for x, 1 for y.
    along: usize,
    /// Whether there is material in a rectangle.
    in_rectangle: bool,
    /// Where the material ends, or the overlap does, along; where the material does at most across.
    ends: [f64; 2],
    sides: [f64; 2],
    /// Where the overlap ends along before the material does: how far from there the strip is taken to be as wide as further in; else 0.
    beside: f64,
    /// Whether those along are the ends of the material.
    edges: [bool; 2],
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

/// How far from an end of the overlap, over its length, and how wide it is there at least, over its width in the middle, where the end is
/// steep: an ellipse is a quarter as wide, and grids of 128 cells along see no more than twice that as smooth.
const BESIDE: f64 = 1.0 / 64.0;
const STEEP: f64 = 0.6;

/// How wide it is there at least where the other end alone is steep, a third less than where a strip ends in a parabola, as one that a tilt
/// lifts does; and how long such a strip is over its width.
const POINTED: f64 = 0.12;
const LONG: f64 = 3.0;

/// How far from a steep end, over the length, where the gap goes on beyond it: what takes longer to be wide a grid of 512 cells along
/// resolves, unless the gap rises without end, as a logarithm does.
const RESOLVED: f64 = 1.0 / 512.0;

/// Share of the width in the middle from which a line is about as wide.
const WIDE: f64 = 0.7;

/// What may overlap beyond the ends that were found, over the width in the middle.
const BEYOND: f64 = 0.025;

/// Halvings to the end of the overlap, and those that find it so nearly that the width beside it is off by less than the next line allows.
const HALVINGS: usize = 60;
const NEARLY: usize = 12;
const NEARLY_STEEP: f64 = 0.9 * STEEP;

/// A rectangle of x and y as one of u and v: turned by a quarter where the strip runs along x.
fn inward(along: usize, Rect { min, max }: &Rect) -> Rect {
    if along == 1 { Rect { min: *min, max: *max } } else { Rect { min: [-max[1], min[0]], max: [-min[1], max[0]] } }
}

/// The rectangle that these are the corners of, where they are.
pub(super) fn rectangle(corners: &[[f64; 2]]) -> Option<Rect> {
    let rect = Rect::holding(corners.iter().copied())?;
    let [w, h] = rect.size();
    (corners.len() == 4 && (area(corners) / (w * h)).abs() >= 1.0 - ROUNDING).then_some(rect)
}

/// What of a rectangle has material, which ends a little further out than it is looked at; and that, where there is one.
pub(super) fn in_material(reach: Rect, material: Option<&Rect>, units: &Units) -> Option<(Rect, Option<Rect>)> {
    let Some(rect) = material else { return Some((reach, None)) };
    let material = units.rect_inward(rect);
    let inset = INSET * material.longer_side();
    let material = Rect { min: material.min.map(|a| a + inset), max: material.max.map(|b| b - inset) };
    Some((reach.intersection(&material)?, Some(material)))
}

impl Roller {
    /// `None` where the overlap is no such strip, or is not known to be nowhere else.
    pub fn of(overlap: &Overlap) -> Option<Self> {
        let known = overlap.known();
        if !overlap.certain {
            return None;
        }
        let Scaled { gap, depth, reach, units, .. } = overlap.scaled();
        let rect = known.ends.as_deref().and_then(rectangle);
        let (reach, material) = in_material(reach, rect.as_ref(), &units)?;
        let all = material.as_ref().unwrap_or(&reach);
        let [w, h] = all.size();
        let longer = usize::from(h >= w);
        [longer, 1 - longer].into_iter().find_map(|along| {
            let (ends, across) = ([all.min[along], all.max[along]], 1 - along);
            let inner = inward(along, &reach);
            let sides = [inner.min[0], inner.max[0]];
            let mirrors = [known.mirrors[across], known.mirrors[along]];
            let centre = inward(along, &Rect::around(units.inward(known.centre), [0.0; 2])).min;
            let gap = gap.clone();
            let strip = Self {
                gap,
                depth,
                units,
                along,
                in_rectangle: material.is_some(),
                ends,
                sides,
                beside: 0.0,
                edges: [true; 2],
                full: [false; 2],
                inside: 0.0,
                mirrors,
                centre,
            };
            let whole = material.is_some() && reach.min[along] <= ends[0] && ends[1] <= reach.max[along];
            let whole = whole && ends.iter().all(|v| strip.across(*v, None).is_some());
            // Wide all along, or at least a little away from its ends.
            let checked = |strip: Option<Self>| strip?.checked(&reach);
            if whole {
                checked(Some(strip.clone())).or_else(|| checked(strip.widening()))
            } else {
                checked(strip.within(inner))
            }
        })
    }

    /// With the ends of the overlap in place of those of the material; `None` where they are not steep.
    fn within(mut self, reach: Rect) -> Option<Self> {
        let middle = 0.5 * (reach.min[1] + reach.max[1]);
        let [a, b] = self.across(middle, None)?;
        let inside = 0.5 * (a + b);
        let overlaps = |v: f64| self.across(v, None).is_some();
        let edges = self.ends.map(overlaps);
        // Where each end is, first nearly: most strips are not steep there, and that tells.
        let reached = [reach.min[1], reach.max[1]];
        let nearly = [0, 1].map(|m| match edges[m] {
            true => [self.ends[m]; 2],
            false if overlaps(reached[m]) => [reached[m]; 2],
            false => bisected(overlaps, [middle, reached[m]], NEARLY),
        });
        let ends = nearly.map(|[inside, _]| inside);
        Self { ends, ..self.clone() }.steep(NEARLY_STEEP)?;
        let ends = nearly.map(|[a, b]| if a == b { a } else { bisected(overlaps, [a, b], HALVINGS - NEARLY)[0] });
        // The last that overlaps may be the last of the material.
        let inset = INSET * (ends[1] - ends[0]);
        let ended = [(0, -inset), (1, inset)].map(|(m, out)| !edges[m] && !self.is_material([inside, ends[m] + out]));
        self.edges = [0, 1].map(|m| edges[m] || ended[m]);
        self.ends = [(0, inset), (1, -inset)].map(|(m, back)| if ended[m] { ends[m] + back } else { ends[m] });
        self.widening()
    }

    fn is_material(&self, p: [f64; 2]) -> bool {
        let [x, y] = self.outward(p);
        self.gap.gap(x, y).is_finite()
    }

    /// Taken to be as wide beside its ends as a little further in; `None` where that is much less than in the middle at both of them.
    fn widening(self) -> Option<Self> {
        self.steep(STEEP)
    }

    /// The same where it is as wide there as this share of the middle.
    fn steep(mut self, share: f64) -> Option<Self> {
        let [first, last] = self.ends;
        let [a, b] = self.across(middle(self.ends), None)?;
        self.beside = BESIDE * (last - first);
        let wide = |v: f64| self.across(v, None).map_or(0.0, |[c, d]| (d - c) / (b - a));
        let inside = a > self.sides[0] && b < self.sides[1];
        let steep = |end: f64, out: f64| {
            let ended = self.in_rectangle || !self.is_material([middle([a, b]), end + out * self.beside]);
            let near = if ended { self.beside } else { RESOLVED * (last - first) };
            wide(end - out * near) >= share
        };
        let wide_beside = || [first + self.beside, last - self.beside].into_iter().all(|v| wide(v) >= POINTED);
        let long = (last - first) / (b - a);
        let fits = match [steep(first, -1.0), steep(last, 1.0)] {
            [true, true] => long > 1.0,
            [false, false] => false,
            _ => long > LONG && wide_beside(),
        };
        (inside && fits).then_some(self)
    }

    /// Where the bodies overlap across; where they cease to along, as a little further in.
    fn widened(&self, v: f64, inside: Option<f64>) -> Option<[f64; 2]> {
        let [first, last] = self.ends;
        self.across(v.clamp(first + self.beside, last - self.beside), inside)
    }

    /// How far from the nearer of its ends, by that, the strip is about as wide as in the middle; 0 at an edge.
    fn rise(&self) -> f64 {
        let [first, last] = self.ends;
        let width = |v: f64| self.across(v, Some(self.inside)).map_or(0.0, |[a, b]| b - a);
        let enough = WIDE * width(middle(self.ends));
        let distance = |end: f64, inward: f64| {
            let narrow = |s: f64| width(end + inward * s) < enough;
            if narrow(0.0) { bisected(narrow, [0.0, 0.5 * (last - first)], 2 * NEARLY)[1] } else { 0.0 }
        };
        distance(first, 1.0).min(distance(last, -1.0))
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
        let lines = line_by_line(LINES, |k, inside| self.widened(at(k), inside))?;
        let inside = middle(lines[LINES / 2]);
        let full = [0, 1].map(|m| lines.iter().all(|line| line[m] == self.sides[m]));
        // Where the overlap ends by itself there is none beyond it, but for a small part of the strip.
        let [a, b] = lines[LINES / 2];
        let room = if self.beside > 0.0 { BEYOND * (b - a) } else { f64::INFINITY };
        let [first, last] = self.ends;
        // All of it is material.
        let Rect { min, max } =
            Rect::holding(lines.iter().flatten().flat_map(|u| self.ends.map(|v| self.outward([*u, v]))))?;
        self.gap.bounds(&Rect { min, max }, [0.0; 2]).filter(|[_, high]| *high < f64::INFINITY)?;
        let lines = Lines(lines);
        let share = |v: f64| (v - self.ends[0]) / (self.ends[1] - self.ends[0]);
        let only = lines.hold_all(&self.gap, self.depth, *reach, |own| {
            let Rect { min, max } = inward(self.along, own);
            min[1] > first - room
                && max[1] < last + room
                && lines.hold([share(min[1]), share(max[1])], [min[0], max[0]])
        });
        only.then_some(Self { full, inside, ..self })
    }

    pub fn found(&self) -> String {
        if self.beside > 0.0 {
            return "a roller with steep ends: it overlaps on a strip that stays wide up to its ends".to_owned();
        }
        "a roller with sharp ends: it overlaps on a strip between two sides of a rectangle of material".to_owned()
    }

    pub(super) fn solve(&self, contact: &Contact, settings: &Settings, limits: &Limits) -> Option<Found> {
        let overlap = |p: [f64; 2]| {
            let [x, y] = self.outward(p);
            self.depth - self.gap.gap(x, y)
        };
        let group = mirrors(self.centre, self.mirrors);
        let across = |v: f64| self.across(v, Some(self.inside));
        let by_rows = || {
            let steep = if self.beside > 0.0 { self.clone() } else { self.clone().widening()? };
            let across = |v: f64| steep.widened(v, Some(self.inside));
            let line = LineContact { overlap: &across, ends: self.ends, rise: steep.rise(), group: group.clone() };
            line_contact(&overlap, &line, limits)
        };
        let with = |moves: [bool; 2]| {
            let strip = edge_fitted::Roller { overlap: &across, ends: self.ends, moves, group: group.clone() };
            roller(&overlap, &strip, limits)
        };
        // The contact may end before the bodies cease to overlap.
        let moves = self.full.map(|full| !full);
        let sharp = || with(moves).or_else(|| if moves == [true; 2] { None } else { with([true; 2]) });
        // Where the material ends little is left of the overlap, or the contact ends before.
        let sharp = if self.beside > 0.0 { None } else { sharp() };
        let (found, reached) = sharp.map(|found| (found, [true; 2])).or_else(by_rows)?;
        // The pressure is infinite at an edge of the material that is in contact.
        let singular = (0..2).any(|m| self.edges[m] && reached[m]);
        let found = found.in_axes(|p| self.outward(p));
        let middle = [centroid(&found.ends[0]), found.centre()];
        let found = in_users_units(found, &self.units, middle, contact, settings)?;
        Some(Found {
            how: format!("the gap is {}", self.found()),
            left_out: "the surface grid: rows of cells across the strip are enough",
            max: found.max.filter(|_| !singular),
            ..found
        })
    }
}

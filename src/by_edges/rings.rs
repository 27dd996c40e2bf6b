//! A gap of revolution whose contact is rings: solved along one radius.

use std::f64::consts::{PI, TAU};

use super::{Found, field_grid};
use crate::edge_fitted::{Annular, Law, Limits, RadialBounds, RadialJet, Span, annular, resample_rings};
use crate::gap::{AnyGap, Axis, Gap};
use crate::numeric::geometry::Rect;
use crate::overlap::Overlap;
use crate::problem::{Contact, Settings};
use crate::solution::{Patch, Piece};

/// The overlap along a radius: lengths in units of the reach, heights in units of the deepest overlap.
pub(crate) struct Section {
    gap: AnyGap,
    depth: f64,
    /// Radii at which the slope may jump, rising.
    kinks: Vec<f64>,
    /// Just beyond each of them inside a span: rings end on one side of it.
    nodes: Vec<f64>,
    /// Radii between which there is material, rising.
    material: Vec<[f64; 2]>,
    /// Radii between which f may be positive, rising.
    spans: Vec<Span>,
    law: Law,
    /// The axis in the user's frame, and the units.
    at: [f64; 2],
    length: f64,
    height: f64,
}

/// How far inside of its ends material is taken to end: rounding on the way into the gap's own frame must not pass them.
const INSET: f64 = 1e-14;

/// Radius up to which cells around the contact may lie.
const FAR: f64 = 4.0;

/// Halvings of an interval on which the sign of f is not known.
const HALVINGS: u32 = 9;

/// A profile of more points is left to the grid.
const MOST_KINKS: usize = 64;

/// Rings at most.
const MOST_RINGS: usize = 800;

/// Those that a proof is worth where it is not asked for: some tenths of a second.
const WORTH: usize = 240;

/// Points between two kinks at which it is looked whether there is material: what they show can refuse, and proves nothing.
const LOOKS: usize = 64;

/// Parts of a span on which the slopes have to be enclosed.
const PIECES: usize = 16;

/// Distance of a kink from the end of a span, over its width, below which it is that end.
const APART: f64 = 1e-7;

/// Points of a circle of the boundary.
const CIRCLE: usize = 128;

impl Section {
    /// `None` where the gap cannot enclose its values along the radius, or does not tell where its material ends.
    pub fn of(overlap: &Overlap, axis: Axis) -> Option<Self> {
        if !overlap.certain {
            return None;
        }
        let sides = [overlap.reach.min, overlap.reach.max];
        let length = sides.into_iter().flat_map(|c| [0, 1].map(|m| (c[m] - axis.at[m]).abs())).fold(0.0, f64::max);
        let height = overlap.deepest;
        let gap = overlap.gap.scaled(axis.at, length, height);
        let mut kinks = Vec::new();
        overlap.gap.ray_kinks(axis.at, [1.0, 0.0], &mut kinks);
        kinks.iter_mut().for_each(|r| *r /= length);
        kinks.retain(|r| *r > 0.0 && *r < FAR);
        if kinks.len() > MOST_KINKS {
            return None;
        }
        kinks.sort_by(f64::total_cmp);
        kinks.dedup_by(|a, b| (*a - *b).abs() <= 4.0 * INSET * *a);
        let depth = overlap.depth / height;
        let floor = overlap.known().floor;
        let law = if floor > f64::NEG_INFINITY { Law::Depth((overlap.depth - floor) / height) } else { Law::Any };
        let (material, spans, nodes) = (Vec::new(), Vec::new(), Vec::new());
        let mut section = Self { gap, depth, kinks, nodes, material, spans, law, at: axis.at, length, height };
        section.find_material()?;
        section.find_spans()?;
        section.find_nodes();
        section.flat_law();
        (!section.spans.is_empty() && section.encloses_slopes()).then_some(section)
    }

    /// Whether slopes are enclosed everywhere that pressure may act: without that nothing is proved.
    fn encloses_slopes(&self) -> bool {
        self.spans.iter().all(|Span { radii: [a, b], .. }| {
            let at = |k: usize| if k == PIECES { *b } else { a + (b - a) * k as f64 / PIECES as f64 };
            (0..PIECES).all(|k| self.slopes([at(k), at(k + 1)]).is_some())
        })
    }

    /// What the force may change by, relative, with the place of the edges by the inset: to first order the inset over the width.
    fn rounding(&self) -> f64 {
        let edged = self.spans.iter().filter(|span| span.edges.contains(&true));
        edged.map(|Span { radii: [a, b], .. }| 8.0 * INSET * b / (b - a)).fold(0.0, f64::max)
    }

    /// From the radii at which the gap may jump; every stretch without material has to be enclosed as such.
    fn find_material(&mut self) -> Option<()> {
        let ends: Vec<f64> = std::iter::once(0.0).chain(self.kinks.iter().copied()).chain([FAR]).collect();
        let mut solid_before = false;
        for pair in ends.windows(2) {
            let inside = [pair[0] * (1.0 + INSET), pair[1] * (1.0 - INSET)];
            let at = |k: usize| inside[0] + (inside[1] - inside[0]) * (k as f64 + 0.5) / LOOKS as f64;
            let numbers = (0..LOOKS).filter(|&k| self.gap.gap(at(k), 0.0) < f64::INFINITY).count();
            // Material that ends where no kink is known: nothing is known of it.
            if numbers != 0 && numbers != LOOKS {
                return None;
            }
            let solid = numbers == LOOKS;
            if !solid && !self.bounds_of_gap(inside).is_some_and(|b| b[0] == f64::INFINITY) {
                return None;
            }
            match (solid, solid_before, self.material.last_mut()) {
                (true, true, Some(last)) => last[1] = inside[1],
                (true, ..) => self.material.push(inside),
                (false, ..) => {}
            }
            solid_before = solid;
        }
        Some(())
    }

    fn find_spans(&mut self) -> Option<()> {
        for [start, end] in self.material.clone() {
            let mut kept: Vec<[f64; 2]> = Vec::new();
            // Between kinks: bounds across one are wider than they need be.
            let cuts: Vec<f64> = std::iter::once(start)
                .chain(self.kinks.iter().copied().filter(|k| *k > start && *k < end.min(1.0)))
                .chain([end.min(1.0)])
                .collect();
            for pair in cuts.windows(2).filter(|pair| pair[0] < pair[1]) {
                let mut stack = vec![([pair[0], pair[1]], 0)];
                while let Some(([a, b], depth)) = stack.pop() {
                    let [low, high] = self.bounds_of_gap([a, b]).map(|g| [self.depth - g[1], self.depth - g[0]])?;
                    if high <= 0.0 {
                        continue;
                    }
                    if !(low > 0.0) && depth < HALVINGS {
                        let middle = 0.5 * (a + b);
                        // The lower half next.
                        stack.push(([middle, b], depth + 1));
                        stack.push(([a, middle], depth + 1));
                        continue;
                    }
                    if !(low > f64::NEG_INFINITY) {
                        return None;
                    }
                    match kept.last_mut() {
                        Some(last) if last[1] == a => last[1] = b,
                        _ => kept.push([a, b]),
                    }
                }
            }
            // The last radius may be the end of material, or that of the reach.
            let ends = end < FAR * (1.0 - 2.0 * INSET);
            let edges = |r: [f64; 2]| [start > 0.0 && r[0] == start, ends && r[1] == end];
            self.spans.extend(kept.into_iter().map(|radii| Span { radii, edges: edges(radii) }));
        }
        Some(())
    }

    fn find_nodes(&mut self) {
        let inside = |r: &f64| {
            let own = |Span { radii: [a, b], .. }: &Span| a + APART * (b - a) < *r && *r < b - APART * (b - a);
            self.spans.iter().any(own)
        };
        self.nodes = self.kinks.iter().map(|r| r * (1.0 + 2.0 * INSET)).filter(inside).collect();
    }

    /// f the same wherever there is material: P d = 2 U.
    fn flat_law(&mut self) {
        let level = |span: &Span| {
            let jet = self.jet(span.radii).filter(|j| j.slope == [0.0; 2] && j.curvature == [0.0; 2])?;
            (span.edges == [span.radii[0] > 0.0, true]).then_some(jet.value)
        };
        let Some(last) = self.spans.last() else { return };
        let first = self.value(last.radii[1]);
        let values: Option<Vec<[f64; 2]>> = self.spans.iter().map(level).collect();
        let level = values.is_some_and(|v| v.iter().all(|v| *v == [v[0]; 2]));
        if level && self.spans.iter().all(|span| self.value(span.radii[1]) == first) {
            self.law = Law::Flat;
        }
    }

    fn bounds_of_gap(&self, interval: [f64; 2]) -> Option<[f64; 2]> {
        self.gap.bounds(&along(interval), [0.0; 2])
    }

    /// The interval itself where there is material, else the end of the nearest material, from where f is continued as a constant.
    fn solid(&self, [a, b]: [f64; 2]) -> Solid {
        let rounding = 0.1 * INSET * b;
        if self.material.iter().any(|m| m[0] - rounding <= a && b <= m[1] + rounding) {
            return Solid::Inside;
        }
        let distance = |end: &f64| (end - a).abs().min((end - b).abs());
        let nearest = self.material.iter().flatten().copied().min_by(|p, q| distance(p).total_cmp(&distance(q)));
        Solid::Beyond(nearest.unwrap_or(0.0))
    }

    pub fn found(&self) -> String {
        let count = self.spans.len();
        let rings = if count == 1 { "one ring or disc".to_owned() } else { format!("{count} rings") };
        format!("a gap of revolution that overlaps on {rings}")
    }

    pub(super) fn solve(&self, contact: &Contact, settings: &Settings, limits: &Limits) -> Option<Found> {
        let worth = if settings.outputs.bracket { MOST_RINGS } else { WORTH };
        let limits = Limits { unknowns: MOST_RINGS, worth, ..*limits };
        let found = annular(self, &self.spans, self.law, &limits)?;
        let Annular { mut force, energy, stiffness, rings, unknowns, proved, errors, .. } = found;
        force = [force[0] * (1.0 - self.rounding()), force[1] * (1.0 + self.rounding())];
        if !(force[0] > 0.0 && force[1] < f64::INFINITY) {
            return None;
        }
        let (length, height, e_star) = (self.length, self.height, contact.modulus().e_star());
        let contact_rings = joined(&rings);
        let at_edge = |r: &f64| self.spans.iter().any(|s| (0..2).any(|k| s.edges[k] && s.radii[k] == *r));
        // Inside, a corner at which the gap bends upwards.
        let slope = |r: f64| self.gap.gradient(r, 0.0).map_or(f64::NAN, |g| g[0]);
        let corner = |r: &f64| slope(r * (1.0 + 2.0 * INSET)) - slope(r * (1.0 - 2.0 * INSET)) > BEND;
        let pressed = |r: &f64| contact_rings.iter().any(|[a, b]| a < r && r < b);
        let singular =
            contact_rings.iter().flatten().any(at_edge) || self.kinks.iter().any(|r| pressed(r) && corner(r));
        let unit_pressure = e_star * height / length;
        let ([x, y], reference) = (self.at, contact.gap().known().reference);
        let outer = contact_rings.last()?[1] * length;
        let (strongest, largest) = rings.iter().copied().max_by(|p, q| p.1.total_cmp(&q.1))?;
        let field = || {
            let rings: Vec<_> = rings.iter().map(|(r, p)| (r.map(|r| r * length), p * unit_pressure)).collect();
            resample_rings(&rings, self.at, field_grid(&Rect::around(self.at, [outer; 2])))
        };
        let unit_force = e_star * height * length;
        // Rings of revolution about one centre, each with what its cells carry.
        let piece = |[a, b]: &[f64; 2]| {
            let own = || rings.iter().filter(|(r, _)| a <= &r[0] && &r[1] <= b);
            let half = [b * length; 2];
            let extent = Rect::around(self.at, half);
            let highest = own().map(|(_, p)| *p).fold(0.0, f64::max);
            Piece {
                area: PI * (b - a) * (b + a) * length * length,
                force: own().map(|([a, b], p)| PI * (b - a) * (b + a) * p).sum::<f64>() * unit_force,
                centroid: self.at,
                extent: [extent.min, extent.max],
                max_pressure: (!singular).then_some(highest * unit_pressure),
            }
        };
        Some(Found {
            force: force.map(|p| p * unit_force),
            energy: energy.map(|u| u * unit_force * height),
            stiffness: stiffness * e_star * length,
            stiffness_error: errors.stiffness,
            area_error: errors.area,
            patch: Patch {
                area: contact_rings.iter().map(|[a, b]| PI * (b - a) * (b + a)).sum::<f64>() * length * length,
                centroid: Some(self.at),
                regions: contact_rings.len(),
                max_radius: outer + (x - reference[0]).hypot(y - reference[1]),
                boundary: Some(contact_rings.iter().flat_map(|ring| self.circles(ring)).collect()),
                pieces: contact_rings.iter().map(piece).collect(),
                semi_axes: None,
                angle: None,
            },
            centre: self.at,
            max: (!singular).then_some(largest * unit_pressure),
            max_error: errors.largest,
            at: [x + 0.5 * (strongest[0] + strongest[1]) * length, y],
            field: settings.outputs.pressure.then(field),
            unknowns,
            how: format!("the gap is {}", self.found()),
            left_out: "the surface grid: rings along one radius are enough",
            proved,
            tilting: None,
        })
    }

    /// The boundary of a ring: its outer circle counter-clockwise, its inner one clockwise.
    fn circles(&self, [a, b]: &[f64; 2]) -> Vec<Vec<[f64; 2]>> {
        let circle = |r: f64, sense: f64| {
            let point = |k: usize| {
                let (sin, cos) = (sense * TAU * k as f64 / CIRCLE as f64).sin_cos();
                [self.at[0] + r * self.length * cos, self.at[1] + r * self.length * sin]
            };
            (0..CIRCLE).map(point).collect()
        };
        let hole = (*a > 0.0).then(|| circle(*a, -1.0));
        std::iter::once(circle(*b, 1.0)).chain(hole).collect()
    }
}

/// Least change of the slope at a corner, where depth and size of the contact are 1.
const BEND: f64 = 1e-6;

/// Where an interval lies.
enum Solid {
    Inside,
    /// Beside the material that ends at this radius.
    Beyond(f64),
}

/// The interval of radii as a rectangle without height.
fn along([a, b]: [f64; 2]) -> Rect {
    Rect { min: [a, 0.0], max: [b, 0.0] }
}

/// Rings that lie side by side as one.
fn joined(rings: &[([f64; 2], f64)]) -> Vec<[f64; 2]> {
    let mut list: Vec<[f64; 2]> = Vec::new();
    for ([a, b], _) in rings {
        match list.last_mut() {
            Some(last) if last[1] == *a => last[1] = *b,
            _ => list.push([*a, *b]),
        }
    }
    list
}

impl RadialBounds for Section {
    fn value(&self, r: f64) -> f64 {
        let r = match self.solid([r, r]) {
            Solid::Inside => r,
            Solid::Beyond(end) => end,
        };
        self.depth - self.gap.gap(r, 0.0)
    }

    fn bounds(&self, interval: [f64; 2]) -> [f64; 2] {
        let interval = match self.solid(interval) {
            Solid::Inside => interval,
            Solid::Beyond(end) => [end; 2],
        };
        let unknown = [f64::NEG_INFINITY, f64::INFINITY];
        self.bounds_of_gap(interval)
            .map_or(unknown, |[low, high]| [(self.depth - high).next_down(), (self.depth - low).next_up()])
    }

    fn jet(&self, interval: [f64; 2]) -> Option<RadialJet> {
        match self.solid(interval) {
            Solid::Inside => {
                let taylor = self.gap.taylor(&along(interval))?;
                let value = [self.depth - taylor.value.hi, self.depth - taylor.value.lo];
                Some(RadialJet {
                    value: [value[0].next_down(), value[1].next_up()],
                    slope: [-taylor.gradient[0].hi, -taylor.gradient[0].lo],
                    curvature: [-taylor.hessian[0].hi, -taylor.hessian[0].lo],
                })
            }
            Solid::Beyond(_) => {
                let value = self.bounds(interval);
                value.iter().all(|v| v.is_finite()).then_some(RadialJet { value, slope: [0.0; 2], curvature: [0.0; 2] })
            }
        }
    }

    fn nodes(&self) -> &[f64] {
        &self.nodes
    }

    /// From both sides of a kink.
    fn slopes(&self, [a, b]: [f64; 2]) -> Option<[f64; 2]> {
        let inner = self.kinks.iter().copied().filter(|k| *k > a && *k < b);
        let cuts: Vec<f64> = std::iter::once(a).chain(inner).chain([b]).collect();
        let last = cuts.len() - 2;
        let mut all = [f64::INFINITY, f64::NEG_INFINITY];
        for (k, pair) in cuts.windows(2).enumerate() {
            let inset = |at_kink: bool, r: f64| if at_kink { INSET * r } else { 0.0 };
            let part = [pair[0] + inset(k > 0, pair[0]), pair[1] - inset(k < last, pair[1])];
            if !(part[0] < part[1]) {
                continue;
            }
            let slopes = match self.jet(part) {
                Some(jet) => {
                    let size = jet.curvature[0].abs().max(jet.curvature[1].abs());
                    // What the slope changes by over half of the part, and over what the inset leaves out.
                    let reach = size * (0.5 * (part[1] - part[0]) + 2.0 * INSET * b);
                    [(jet.slope[0] - reach).next_down(), (jet.slope[1] + reach).next_up()]
                }
                // At the axis, where the gap may have a tip.
                None => {
                    let [along, _] = self.gap.slopes(&along(part))?;
                    [-along.hi, -along.lo]
                }
            };
            all = [all[0].min(slopes[0]), all[1].max(slopes[1])];
        }
        (all[0] <= all[1]).then_some(all)
    }
}

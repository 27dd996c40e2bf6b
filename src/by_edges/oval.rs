//! Oval rings: contacts along one closed strip around a point at which the bodies do not overlap, the gap mirrored in two lines through it
//! or in none.

use std::f64::consts::FRAC_PI_2;

use super::Found;
use super::estimated::in_users_units;
use super::strip::{Lines, interval, line_by_line};
use crate::edge_fitted::{Limits, Quarters, oval};
use crate::gap::{AnyGap, Gap};
use crate::numeric::geometry::{Rect, area, centroid, farthest};
use crate::overlap::{Overlap, Scaled, Units};
use crate::problem::{Contact, Settings};

/// A strip in which the bodies overlap, in the units of the solve.
pub(crate) struct Strip {
    gap: AnyGap,
    depth: f64,
    units: Units,
    /// Where the mirrors cross; a point inside of the strip where there are none.
    centre: [f64; 2],
    /// Quarters that have to be solved: one with two mirrors.
    quarters: Quarters,
    /// The farthest that the overlap reaches.
    farthest: f64,
}

/// Rays of a quarter between which the strip is taken to be straight, at least and at most; as many as keep the distance from ray to ray a
/// small part of the width.
const RAYS: [usize; 2] = [256, 4096];

/// Rays of a quarter over the distance of the strip in its width.
const OF_SLENDERNESS: f64 = 8.0;

/// Strips wider than this share of their distance from the middle are left to a grid.
const WIDEST: f64 = 0.5;

impl Strip {
    /// `None` where the overlap is no such strip, or is not known to be nowhere else.
    pub fn of(overlap: &Overlap) -> Option<Self> {
        let known = overlap.known();
        if known.law.is_some() || !overlap.certain {
            return None;
        }
        // A tilt leaves the gap drawn about the same point.
        let (quarters, centre) = match known.mirrors {
            [true, true] => (Quarters::One, known.centre),
            _ => (Quarters::All, known.reference),
        };
        if !(overlap.gap.gap(centre[0], centre[1]) > overlap.depth) {
            return None;
        }
        let Scaled { gap, depth, reach, units, .. } = overlap.scaled();
        let centre = units.inward(centre);
        let farthest = farthest(&reach.corners(), centre);
        let strip = Self { gap, depth, units, centre, quarters, farthest };
        let last = quarters.angle();
        let at = |k: usize, rays: usize| last * k as f64 / rays as f64;
        let many = quarters.count();
        let looks: Option<Vec<[f64; 2]>> = (0..=8 * many).map(|k| strip.along(at(k, 8 * many), None)).collect();
        let slenderness = looks?.iter().map(|[a, b]| 0.5 * (a + b) / (b - a)).fold(0.0, f64::max);
        let count = ((OF_SLENDERNESS * slenderness) as usize / 8 * 8).clamp(RAYS[0], RAYS[1]) * many;
        let rays = line_by_line(count, |k, inside| strip.along(at(k, count), inside));
        let rays = rays.filter(|rays| rays.iter().all(|[a, b]| b - a < WIDEST * (a + b)))?;
        let smooth = rays.iter().enumerate().step_by(count / (8 * many)).all(|(k, [a, b])| {
            let at = strip.on_ray(at(k, count), 0.5 * (a + b));
            strip.gap.taylor(&Rect::around(at, [0.1 * (b - a); 2])).is_some()
        });
        (smooth && strip.nowhere_else(rays)).then_some(strip)
    }

    fn on_ray(&self, angle: f64, r: f64) -> [f64; 2] {
        let (sin, cos) = angle.sin_cos();
        [self.centre[0] + r * cos, self.centre[1] + r * sin]
    }

    /// Where along a ray the bodies overlap, if once: about `inside` if they do there.
    fn along(&self, angle: f64, inside: Option<f64>) -> Option<[f64; 2]> {
        let gap = |r: f64| {
            let [x, y] = self.on_ray(angle, r);
            self.gap.gap(x, y)
        };
        let outside = 1.001 * self.farthest;
        interval(gap, self.depth, [0.0, outside], inside).filter(|[a, b]| *a > 0.0 && *b < outside)
    }

    /// Whether the bodies overlap nowhere outside of the strip, with its room.
    fn nowhere_else(&self, rays: Vec<[f64; 2]>) -> bool {
        let rays = Lines(rays);
        let [cx, cy] = self.centre;
        // Quarters from the first on, and the signs of x and y there.
        let quarters = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]].into_iter().enumerate();
        quarters.take(self.quarters.count()).all(|(quarter, [sx, sy])| {
            let corner = [cx + sx * self.farthest, cy + sy * self.farthest];
            let in_strip = |own: &Rect| {
                // Seen from the first one.
                let seen = [own.min, own.max].map(|p| [sx * (p[0] - cx), sy * (p[1] - cy)]);
                let Some(Rect { min, max }) = Rect::holding(seen) else { return false };
                let (low, high) = (min[1].atan2(max[0]), max[1].atan2(min[0]));
                let begin = FRAC_PI_2 * quarter as f64;
                let angles = if quarter % 2 == 0 { [low, high] } else { [FRAC_PI_2 - high, FRAC_PI_2 - low] };
                let shares = angles.map(|angle| (begin + angle) / self.quarters.angle());
                rays.hold(shares, [min[0].hypot(min[1]), max[0].hypot(max[1])])
            };
            let all = Rect::holding([self.centre, corner]);
            all.is_some_and(|all| rays.hold_all(&self.gap, self.depth, all, in_strip))
        })
    }

    pub fn found(&self) -> String {
        match self.quarters {
            Quarters::One => {
                "mirrored in two lines, and overlaps along one closed strip around their crossing".to_owned()
            }
            Quarters::All => "drawn about a point, and overlaps along one closed strip around it".to_owned(),
        }
    }

    pub(super) fn solve(&self, contact: &Contact, settings: &Settings, limits: &Limits) -> Option<Found> {
        let overlap = |[x, y]: [f64; 2]| self.depth - self.gap.gap(x + self.centre[0], y + self.centre[1]);
        let found = oval(&overlap, &|angle| self.along(angle, None), self.quarters, limits)?;
        let middle = match self.quarters {
            Quarters::One => [[0.0; 2]; 2],
            Quarters::All => [centroid_of(&found.ends), found.centre()],
        };
        let units = Units { origin: self.units.outward(self.centre), ..self.units };
        Some(Found {
            how: format!("the gap is {}", self.found()),
            left_out: "the surface grid: cells along the strip are enough",
            ..in_users_units(found, &units, middle, contact, settings)?
        })
    }
}

/// Of all that closed lines hold, those around holes the other way round.
fn centroid_of(lines: &[Vec<[f64; 2]>]) -> [f64; 2] {
    let all: f64 = lines.iter().map(|line| area(line)).sum();
    let moment = |m: usize| lines.iter().map(|line| area(line) * centroid(line)[m]).sum::<f64>();
    [0, 1].map(|m| moment(m) / all)
}

//! Contacts that run from one straight end of the material to the other: rollers with sharp ends, on rows of cells ([`super::rows`])
//! graded to both.
//!
//! Across, the contact ends by itself or at an edge of the material, alike in all rows. Along, p ~ s^(-1/2) at the ends; a width of the
//! contact further in they are forgotten, and the length of the rows grows with the distance.

use super::Limits;
use super::estimated::Estimated;
use super::mesh::Point;
use super::rows::{self, Strip};
use super::symmetry::Isometry;

/// A strip in which bodies overlap: x across, y along.
pub(crate) struct Roller<'a> {
    /// Where they overlap across, by y.
    pub overlap: &'a dyn Fn(f64) -> Option<[f64; 2]>,
    /// Where the material ends.
    pub ends: [f64; 2],
    /// Which of both sides the contact ends at by itself; at the others the material does.
    pub moves: [bool; 2],
    /// Symmetries of strip and overlap.
    pub group: Vec<Isometry>,
}

/// Rows over the length of the overlap beside an end that are graded to it, for an error of 1e-3.
const AT_END: f64 = 4.0;

/// Cells across to each side, to begin with: to ends that move, and to those of the material.
const ACROSS: [usize; 2] = [3, 4];

/// The contact of an overlap `f` that is positive in the strip and nowhere else. `None` where no such contact is found, and once the time
/// is used up.
pub(crate) fn roller(f: &dyn Fn(Point) -> f64, roller: &Roller, limits: &Limits) -> Option<Estimated> {
    let width = |y: f64| (roller.overlap)(y).map(|[a, b]| b - a);
    let [first, last] = roller.ends;
    let strip = Ended { roller, grading: Grading::new(0.5 * (last - first), width(first)?.min(width(last)?), TO_EDGE) };
    let finer = (1e-3 / limits.tolerance).max(1.0).cbrt();
    let rows = 2 * (AT_END * finer * strip.grading.all).ceil() as usize;
    let half = ACROSS[usize::from(roller.moves != [true; 2])];
    rows::refined(f, &strip, (rows, half), limits)
}

/// m towards an edge.
pub(super) const TO_EDGE: f64 = 4.0;

/// Distances s from the end of a length L that rows are laid by, n(s) of them in units of those of the graded part, up to a:
///
/// ```text
/// n = (s/a)^(1/m) for s < a,     1 + ln(1 + 2 (s - a)/(m a))/2 beyond it, while ds/dn = m a + 2 (s - a) < c L.
/// ```
pub(super) struct Grading {
    /// L.
    length: f64,
    /// a.
    graded: f64,
    /// m.
    power: f64,
    /// s and n where ds/dn = c L.
    even: [f64; 2],
    /// n(L).
    pub all: f64,
}

/// c: rows in the middle of a long strip.
const LONGEST: f64 = 1.5;

impl Grading {
    pub fn new(length: f64, width: f64, power: f64) -> Self {
        let graded = width.min(length);
        let even = (graded + 0.5 * (LONGEST * length - power * graded)).clamp(graded, length);
        let growing = 1.0 + 0.5 * (1.0 + 2.0 * (even - graded) / (power * graded)).ln();
        let step = power * graded + 2.0 * (even - graded);
        Self { length, graded, power, even: [even, growing], all: growing + (length - even) / step }
    }

    /// Lines from one end to the other, 2 n cells graded to both.
    pub fn lines(&self, [first, last]: [f64; 2], n: usize) -> Vec<f64> {
        let distance = |k: usize| self.distance(k as f64 / n as f64);
        let (before, after) = ((0..=n).map(|k| first + distance(k)), (0..n).rev().map(|k| last - distance(k)));
        before.chain(after).collect()
    }

    /// s at a share of n(L).
    pub fn distance(&self, share: f64) -> f64 {
        let (n, a, m, [even, growing]) = (share * self.all, self.graded, self.power, self.even);
        if n <= 1.0 {
            a * n.powf(m)
        } else if n <= growing {
            a + 0.5 * m * a * (2.0 * (n - 1.0)).exp_m1()
        } else {
            let step = m * a + 2.0 * (even - a);
            (even + (n - growing) * step).min(self.length)
        }
    }
}

/// A roller with the rows that belong to it.
struct Ended<'a> {
    roller: &'a Roller<'a>,
    grading: Grading,
}

impl Ended<'_> {
    /// y at a share of the rows.
    fn along(&self, share: f64) -> f64 {
        let [first, last] = self.roller.ends;
        if share <= 0.5 {
            first + self.grading.distance(2.0 * share)
        } else {
            last - self.grading.distance(2.0 * (1.0 - share))
        }
    }

    fn station(&self, k: usize, rows: usize) -> f64 {
        self.along(k as f64 / rows as f64)
    }
}

impl Strip for Ended<'_> {
    fn overlap(&self, along: f64) -> Option<[f64; 2]> {
        (self.roller.overlap)(self.along(along))
    }

    fn moves(&self) -> [bool; 2] {
        self.roller.moves
    }

    fn all_rows(&self, rows: usize) -> usize {
        rows
    }

    fn is_closed(&self) -> bool {
        false
    }

    fn point(&self, line: usize, stations: &[[f64; 2]], share: f64) -> Point {
        [rows::between(stations[line], share), self.station(line, stations.len() - 1)]
    }

    fn group(&self) -> &[Isometry] {
        &self.roller.group
    }

    fn reaches(&self, along: f64) -> [f64; 2] {
        let ([first, last], y) = (self.roller.ends, self.along(along));
        [y - first, last - y]
    }

    fn length(&self, row: usize, rows: usize) -> f64 {
        let own = |k: usize| self.station(k + 1, rows) - self.station(k, rows);
        own(row) / own(rows / 2)
    }
}

#[cfg(test)]
mod tests {
    use super::super::flat::flat_stiffness;
    use super::super::outline::Outline;
    use super::super::symmetry::mirrors;
    use super::*;

    #[test]
    fn rows_reach_the_middle_and_grow_on_the_way() {
        let cases = [(1.0, 3.0, 4.0), (1.0, 0.9, 2.0), (1.0, 0.3, 4.0), (1.0, 1e-3, 2.5), (2.0, 0.01, 4.0)];
        for (length, width, power) in cases {
            let grading = Grading::new(length, width, power);
            let at: Vec<f64> = (0..=24).map(|k| grading.distance(f64::from(k) / 24.0)).collect();
            assert!(at[0] == 0.0 && (at[24] / length - 1.0).abs() < 1e-12, "{at:?}");
            let steps: Vec<f64> = at.windows(2).map(|p| p[1] - p[0]).collect();
            assert!(steps.windows(2).all(|s| s[1] > s[0] * (1.0 - 1e-9)), "{steps:?}");
        }
    }

    #[test]
    fn a_level_rectangle_is_a_flat_punch() {
        let overlap = |_: f64| Some([-0.25, 0.25]);
        let level =
            Roller { overlap: &overlap, ends: [-1.0, 1.0], moves: [false; 2], group: mirrors([0.0; 2], [true; 2]) };
        let found = roller(&|_| 1.0, &level, &Limits::default()).unwrap();
        let outline = Outline::polygon(&[[-0.25, -1.0], [0.25, -1.0], [0.25, 1.0], [-0.25, 1.0]]).unwrap();
        let [low, high] = flat_stiffness(&outline, &Limits { tolerance: 1e-4, ..Limits::default() }).unwrap().stiffness;
        let off = (low / found.force - 1.0).max(1.0 - high / found.force);
        assert!(found.error <= 1e-3 && off <= found.error, "{off} {}", found.error);
    }
}

//! Contacts that are strips: cells in rows across them, the ends of every row moved to where the contact ends.
//!
//! On any set A of cells the pressure with S p = f on A has the force P_A, which is the largest, and stationary, where A is the contact
//! (Barber 1974). Beside an end of A
//!
//! ```text
//! p = C s^(1/2) + K s^(-1/2) + ...,
//! ```
//!
//! and the end of the contact, where K vanishes, lies K > 0: further out, by 2 K/C to first order. The ends of every row of cells are
//! moved by that until it is small; what is left of it enters P_A squared. What cells across and along the strip leave is told by fewer
//! of them ([`super::estimated`]). An end at which the material ends stays there.

use super::Limits;
use super::estimated::{Estimated, Rest, Solved, Touching};
use super::mesh::{Mesh, Point};
use super::rectilinear::graded;
use super::symmetry::Isometry;

/// Grading of the cells towards ends that move: p is bounded there; and towards those of the material.
const EXPONENTS: [f64; 2] = [2.0, 4.0];

/// The contact as a share of the strip in which the bodies overlap, to begin with, where one of its ends is an edge: that of a paraboloid.
const FIRST: [f64; 2] = [0.15, 0.85];

/// The least and the largest of what a line contact is taken to have, to begin with.
const LINE: [f64; 2] = [0.2, 0.8];

/// Moves of the ends on one mesh, at most.
const MOVES: usize = 10;

/// Moves that are small enough, over half the width, for an error of 1e-3: they enter the force squared.
const CLOSE: f64 = 0.01;

/// Share of the width beside a moving end in which the pressure may be negative where the end is not yet where it should be.
const BESIDE_END: f64 = 0.05;

/// Moves with which a mesh is not settled, over those that are small enough: where the contact comes to a point at the end of a strip its
/// ends never rest, and what they leave is no square of a move.
const UNSETTLED: f64 = 1.5;

/// Width of a contact at an end of its strip, over that of the widest row, below which it may come to a point. Two rollers with logarithmic
/// ends of 1400 by lot were off by 1.02 and 1.1 times what was stated.
const NARROW: f64 = 0.5;

/// Rounds of more cells.
const ROUNDS: usize = 4;

/// Cells across of the finer of two meshes over those of the coarser, less 1.
const FINER: f64 = 0.5;

/// Order that the next round relies on, and share of the tolerance that each direction aims at.
const ORDER: f64 = 2.5;
const AIM: f64 = 0.35;

/// Unknowns of a round after the first, at most: each of its meshes is laid anew for every move of its ends.
const WORTH: usize = 1000;

/// Cells of a round over those of the one before, below which it is not worth its time where more of them were wanted.
pub(super) const LEAST_GROWTH: f64 = 1.2;

/// A strip in which bodies overlap, by stations along it: rows of cells lie between two of them.
pub(super) trait Strip {
    /// Where the bodies overlap across the strip, at a share of its length.
    fn overlap(&self, along: f64) -> Option<[f64; 2]>;

    /// Which of both ends the contact ends at by itself; the others are edges of the material.
    fn moves(&self) -> [bool; 2];

    /// Rows of cells where there are so many between the stations, mirrored ones included; those between the stations are the first.
    fn all_rows(&self, rows: usize) -> usize;

    /// Whether the last row ends where the first begins.
    fn is_closed(&self) -> bool;

    /// The point of a line between two rows, the `share` of the way from one end of the contact to the other.
    fn point(&self, line: usize, stations: &[[f64; 2]], share: f64) -> Point;

    /// Symmetries of strip and overlap: a group.
    fn group(&self) -> &[Isometry];

    /// How far a straight strip of as much displacement goes on to both sides.
    fn reaches(&self, along: f64) -> [f64; 2];

    /// The length of a row over that of the longest.
    fn length(&self, row: usize, rows: usize) -> f64;
}

/// Ends of the contact at the stations, as shares of the strip in which the bodies overlap.
#[derive(Debug, Clone)]
struct Ends(Vec<[f64; 2]>);

/// A solved mesh.
struct State {
    solved: Solved,
    /// Both ends of the contact at the stations.
    stations: Vec<[f64; 2]>,
    /// Moves of both ends of each row, over half the width.
    moves: Vec<[f64; 2]>,
    /// The largest, that of a short row by the root of what it is shorter by.
    off: f64,
    /// Whether there is no gap between both ends.
    pressed: bool,
}

/// The contact of an overlap `f` that is positive in the strip and nowhere else, beginning with so many rows and, to each moving end, cells
/// across. `None` where no such contact is found, and once the time is used up.
pub(super) fn refined(
    f: &dyn Fn(Point) -> f64,
    strip: &dyn Strip,
    counts: (usize, usize),
    limits: &Limits,
) -> Option<Estimated> {
    let (found, finest) = estimated(f, strip, counts, limits)?;
    found.with_tilts(&finest, Touching::All, limits)
}

/// The same with the finest mesh.
fn estimated(
    f: &dyn Fn(Point) -> f64,
    strip: &dyn Strip,
    (mut rows, mut half): (usize, usize),
    limits: &Limits,
) -> Option<(Estimated, Solved)> {
    let mut ends = Ends::first(strip, rows)?;
    let mut best: Option<(Estimated, Solved)> = None;
    let problem = Problem { f, strip, limits };
    let finer_than = |half: usize| half + 2.max((FINER * half as f64).ceil() as usize);
    let unknowns = |rows: usize, half: usize| strip.all_rows(rows) * 2 * finer_than(half) / strip.group().len();
    for _ in 0..ROUNDS {
        let finer = finer_than(half);
        if unknowns(rows, half) > limits.unknowns {
            return best;
        }
        // Fewer rows first: the ends come to rest on them.
        let fewer = (2 * rows).div_ceil(3);
        let mut own = ends.resampled(fewer);
        let Some(shorter) = problem.settled(&mut own, fewer, half) else { return best };
        ends = own.resampled(rows);
        let Some(coarse) = problem.settled(&mut ends, rows, half) else { return best };
        let Some(fine) = problem.settled(&mut ends, rows, finer) else { return best };
        let own = &fine.solved;
        let change = |of: fn(&Solved) -> f64| {
            (of(own) / of(&coarse.solved) - 1.0).abs() + (of(&coarse.solved) / of(&shorter.solved) - 1.0).abs()
        };
        // What cells along and across leave.
        let rest = |of: fn(&Solved) -> f64| {
            let along = Rest::new(of(&coarse.solved), of(&shorter.solved), rows as f64 / fewer as f64);
            [along, Rest::new(of(own), of(&coarse.solved), finer as f64 / half as f64)]
        };
        let (force, energy) = (rest(|s| s.force), rest(|s| s.energy));
        let left = [0, 1].map(|m| force[m].error.max(energy[m].error));
        let corrected = |rest: [Rest; 2]| 1.0 + rest[0].correction + rest[1].correction;
        let off = fine.off.max(coarse.off);
        let found = Estimated {
            force: own.force * corrected(force),
            error: left[0] + left[1] + 2.0 * off * off,
            energy: own.energy * corrected(energy),
            stiffness: own.stiffness,
            stiffness_error: change(|s| s.stiffness) + off,
            stiffness_matrix: None,
            area: own.area,
            area_error: change(|s| s.area) + 2.0 * off,
            max_error: Some(change(Solved::largest)),
            cells: own.cells_times(corrected(force), Touching::All),
            ends: problem.boundary(&fine.stations),
            unknowns: own.unknowns,
        };
        let done = found.error <= limits.tolerance;
        best = Some((found, fine.solved));
        if done {
            break;
        }
        let aim = AIM * limits.tolerance;
        let more = [wanted(rows, left[0], ORDER, aim), wanted(half, left[1], ORDER, aim)];
        // What is off by the ends alone falls with both.
        let mut more = if more == [rows, half] { [rows + rows / 4, half + 1] } else { more };
        // No more than are worth their time.
        let growth = |more: [usize; 2]| [more[0] as f64 / rows as f64, more[1] as f64 / half as f64];
        let most = limits.unknowns.min(WORTH);
        while unknowns(more[0], more[1]) > most && more != [rows, half] {
            let [along, across] = growth(more);
            more[usize::from(across > along)] -= 1;
        }
        if unknowns(more[0], more[1]) > most || growth(more)[0] * growth(more)[1] < LEAST_GROWTH {
            break;
        }
        ends = ends.resampled(more[0]);
        [rows, half] = more;
    }
    best
}

/// As many as `n` cells that leave this of the force have to become to leave `aim` where it falls with the `order` of them, twice as many at
/// most.
pub(super) fn wanted(n: usize, left: f64, order: f64, aim: f64) -> usize {
    let times = (left / aim).max(0.0).powf(1.0 / order).min(2.0);
    ((times * n as f64).ceil() as usize).max(n)
}

struct Problem<'a> {
    f: &'a dyn Fn(Point) -> f64,
    strip: &'a dyn Strip,
    limits: &'a Limits,
}

impl Problem<'_> {
    /// The mesh whose ends have come to rest, as far as they do.
    fn settled(&self, ends: &mut Ends, rows: usize, half: usize) -> Option<State> {
        let overlap: Option<Vec<[f64; 2]>> = (0..=rows).map(|k| self.strip.overlap(k as f64 / rows as f64)).collect();
        let overlap = overlap?;
        let mut state = self.solve(ends.within(&overlap), half)?;
        let close = CLOSE * (self.limits.tolerance / 1e-3).min(1.0).sqrt();
        for _ in 0..MOVES {
            if state.off <= close || self.is_narrow_at_an_end(&state.stations) {
                break;
            }
            ends.moved(&state.moves, self.strip.moves());
            state = self.solve(ends.within(&overlap), half)?;
        }
        let Solved { force, stiffness, .. } = state.solved;
        let settled = state.off < UNSETTLED * close && !self.is_narrow_at_an_end(&state.stations);
        (settled && force > 0.0 && stiffness > 0.0 && state.pressed).then_some(state)
    }

    /// Whether the contact of a strip that ends is narrow there: if it comes to a point there, or before, short rows hide how far.
    fn is_narrow_at_an_end(&self, stations: &[[f64; 2]]) -> bool {
        let width = |[a, b]: &[f64; 2]| b - a;
        let widest = stations.iter().map(width).fold(0.0, f64::max);
        let [first, .., last] = stations else { return false };
        !self.strip.is_closed() && width(first).min(width(last)) < NARROW * widest
    }

    /// Cells over all rows.
    fn mesh(&self, stations: &[[f64; 2]], shares: &[f64]) -> Mesh {
        let (lines, across) = (self.lines(stations), shares.len() - 1);
        let node = |line: usize| shares.iter().map(move |share| self.strip.point(line, stations, *share));
        let id = |line: usize, j: usize| (line % lines) * (across + 1) + j;
        let row = |k: usize| (0..across).map(move |j| [id(k, j), id(k, j + 1), id(k + 1, j + 1), id(k + 1, j)]);
        let rows = self.strip.all_rows(stations.len() - 1);
        Mesh::new((0..lines).flat_map(node).collect(), (0..rows).flat_map(row).collect(), Vec::new())
    }

    /// Where the contact ends: closed lines, contact on the left.
    fn boundary(&self, stations: &[[f64; 2]]) -> Vec<Vec<Point>> {
        let side = |share: f64| (0..self.lines(stations)).map(move |line| self.strip.point(line, stations, share));
        if self.strip.is_closed() {
            vec![side(1.0).collect(), side(0.0).rev().collect()]
        } else {
            vec![side(1.0).chain(side(0.0).rev()).collect()]
        }
    }

    /// Lines between the rows and at their ends.
    fn lines(&self, stations: &[[f64; 2]]) -> usize {
        self.strip.all_rows(stations.len() - 1) + usize::from(!self.strip.is_closed())
    }

    fn solve(&self, stations: Vec<[f64; 2]>, half: usize) -> Option<State> {
        let (rows, free) = (stations.len() - 1, self.strip.moves());
        let shares = shares(free, half);
        let across = shares.len() - 1;
        let mesh = self.mesh(&stations, &shares);
        let solved = Solved::new(mesh, self.strip.group(), self.f, Touching::All, self.limits)?;
        let pressure = &solved.pressure;
        let widths = [[shares[1], shares[2]], [1.0 - shares[across - 1], 1.0 - shares[across - 2]]];
        let moved = |k: usize| {
            let at = |j: usize| pressure[k * across + j];
            let last = [[at(0), at(1)], [at(across - 1), at(across - 2)]];
            [0, 1].map(|m| if free[m] { 2.0 * further(widths[m], last[m]) } else { 0.0 })
        };
        let moves: Vec<[f64; 2]> = (0..rows).map(moved).collect();
        let middle = |j: usize| 0.5 * (shares[j] + shares[j + 1]);
        let beside = |j: usize| (free[0] && middle(j) < BESIDE_END) || (free[1] && middle(j) > 1.0 - BESIDE_END);
        let pressed = (0..rows).all(|k| (0..across).all(|j| beside(j) || pressure[k * across + j] > 0.0));
        let off = (0..rows).map(|k| {
            let [a, b] = moves[k];
            a.abs().max(b.abs()) * self.strip.length(k, rows).sqrt()
        });
        Some(State { off: off.fold(0.0, f64::max), pressed, solved, stations, moves })
    }
}

/// Where cells begin and end across a strip.
fn shares(moves: [bool; 2], half: usize) -> Vec<f64> {
    let [left, right] = [0, 1].map(|m| graded(0.5, m as f64, half, EXPONENTS[usize::from(!moves[m])]));
    left.into_iter().rev().chain(right.into_iter().skip(1)).collect()
}

/// How near to the end of the overlap, as a share of it, a contact may end that ends by itself.
const NEAREST: f64 = 1e-6;

impl Ends {
    /// To begin with.
    fn first(strip: &dyn Strip, rows: usize) -> Option<Self> {
        let moves = strip.moves();
        let ends = |k: usize| {
            let along = k as f64 / rows as f64;
            let [a, b] = strip.overlap(along)?;
            if moves == [true; 2] {
                let share = width_of_line_contact(strip.reaches(along), 0.5 * (b - a));
                return Some([0.5 - 0.5 * share, 0.5 + 0.5 * share]);
            }
            Some([0, 1].map(|m| if moves[m] { FIRST[m] } else { m as f64 }))
        };
        (0..=rows).map(ends).collect::<Option<_>>().map(Self)
    }

    /// Those that move, by the mean of the rows on both sides of each station, which are mirrored at the first and the last.
    fn moved(&mut self, moves: &[[f64; 2]], free: [bool; 2]) {
        let rows = moves.len();
        for (k, [a, b]) in self.0.iter_mut().enumerate() {
            let mean = |m: usize| 0.5 * (moves[k.saturating_sub(1)][m] + moves[k.min(rows - 1)][m]);
            let half = 0.5 * (*b - *a);
            // Contact ends where the bodies overlap.
            if free[0] {
                *a = (*a - half * mean(0)).max(NEAREST);
            }
            if free[1] {
                *b = (*b + half * mean(1)).min(1.0 - NEAREST);
            }
        }
    }

    /// Where that is, by where the bodies overlap at the stations.
    fn within(&self, overlap: &[[f64; 2]]) -> Vec<[f64; 2]> {
        self.0.iter().zip(overlap).map(|(shares, ends)| shares.map(|share| between(*ends, share))).collect()
    }

    /// At other stations: shares vary slowly.
    fn resampled(&self, rows: usize) -> Self {
        let last = self.0.len() - 1;
        let at = |k: usize| {
            let t = k as f64 / rows as f64 * last as f64;
            let i = (t as usize).min(last - 1);
            [0, 1].map(|m| self.0[i][m] + (t - i as f64) * (self.0[i + 1][m] - self.0[i][m]))
        };
        Self((0..=rows).map(at).collect())
    }
}

/// The half width b of the contact of a cylinder over that of its overlap, w, at distances s and t from its ends. A line load that is a
/// semi-ellipse across displaces its middle as one on a line at distance c = b/(2 e^(1/2)) does, so that
///
/// ```text
/// w^2 = b^2 (asinh(s/c) + asinh(t/c))/2.
/// ```
pub(crate) fn width_of_line_contact([s, t]: [f64; 2], w: f64) -> f64 {
    let mut share: f64 = 0.5;
    for _ in 0..3 {
        let c = share * w / (2.0 * 0.5f64.exp());
        share = (0.5 * ((s / c).asinh() + (t / c).asinh())).powf(-0.5).clamp(LINE[0], LINE[1]);
    }
    share
}

/// The share of the way from one end to the other.
pub(super) fn between([a, b]: [f64; 2], share: f64) -> f64 {
    a + share * (b - a)
}

/// 2 K/C of p = C s^(1/2) + K s^(-1/2), from its means over [0, a] and [a, b]; in the unit of a and b.
pub(super) fn further([a, b]: [f64; 2], [p, q]: [f64; 2]) -> f64 {
    let root = |from: f64, to: f64| 2.0 / 3.0 * (to.powf(1.5) - from.powf(1.5)) / (to - from);
    let inverse = |from: f64, to: f64| 2.0 * (to.sqrt() - from.sqrt()) / (to - from);
    let (r0, i0, r1, i1) = (root(0.0, a), inverse(0.0, a), root(a, b), inverse(a, b));
    let det = r0 * i1 - r1 * i0;
    let (c, k) = ((p * i1 - q * i0) / det, (r0 * q - r1 * p) / det);
    if c > 0.0 { (2.0 * k / c).clamp(-FARTHEST, FARTHEST) } else { FARTHEST * k.signum() }
}

/// Of the width: what is far is not of first order.
const FARTHEST: f64 = 0.1;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_end_is_found_from_two_means() {
        // p = (s + e)^(1/2) about s = 0: the end lies e further. Its expansion in e fails within e of the end: an error of (e/a)^(1/2).
        let mean = |e: f64, a: f64, b: f64| 2.0 / 3.0 * ((b + e).powf(1.5) - (a + e).powf(1.5)) / (b - a);
        let found = |e: f64| further([0.3, 0.6], [mean(e, 0.0, 0.3), mean(e, 0.3, 0.6)]);
        for e in [0.02, 5e-3, 5e-4, 1e-4] {
            assert!((found(e) / e - 1.0).abs() < (e / 0.3_f64).sqrt(), "{} at {e}", found(e));
        }
        assert!(found(0.0).abs() < 1e-12);
    }
}

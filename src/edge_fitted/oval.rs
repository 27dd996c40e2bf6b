//! Contacts that are closed strips with two mirrors: oval rings, on cells that follow the strip.
//!
//! On any set A of cells the pressure with S p = f on A has the force P_A, which is the largest, and stationary, where A is the contact
//! (Barber 1974). Beside an end of A
//!
//! ```text
//! p = C s^(1/2) + K s^(-1/2) + ...,
//! ```
//!
//! and the end of the contact, where K vanishes, lies K > 0: further out, by 2 K/C to first order. Both ends of every row of cells are
//! moved by that until it is small; what is left of it enters P_A squared. What cells across and along the strip leave is told by fewer
//! of them.

use std::f64::consts::{FRAC_PI_2, PI};

use super::Limits;
use super::estimated::{Estimated, Solved, Touching};
use super::mesh::{Mesh, Point};
use super::rectilinear::graded_both;
use super::symmetry::Isometry;

/// Grading of the cells towards the ends of the strip: those move, and p is bounded there.
const EXPONENT: f64 = 3.0;

/// Share of the half width that a straight cell may leave the curved strip by.
const SAGITTA: f64 = 0.03;

/// The contact as a share of the strip in which the bodies overlap, to begin with.
const FIRST: [f64; 2] = [0.15, 0.85];

/// Moves of the ends on one mesh, at most.
const MOVES: usize = 10;

/// Moves that are small enough, over half the width: they enter the force squared.
const CLOSE: f64 = 0.01;

/// Rounds of more cells.
const ROUNDS: usize = 3;

/// Ends of the contact at the stations of a quarter, as shares of the strip in which the bodies overlap.
#[derive(Debug, Clone)]
struct Ends(Vec<[f64; 2]>);

/// A solved mesh.
struct State {
    solved: Solved,
    /// Moves of both ends of each row of a quarter, over half the width.
    moves: Vec<[f64; 2]>,
}

impl State {
    /// The largest move.
    fn off(&self) -> f64 {
        self.moves.iter().flatten().fold(0.0, |m: f64, v| m.max(v.abs()))
    }
}

/// The contact of an overlap (`f`, about the crossing of its mirrors x = 0 and y = 0) that is positive along every ray between the
/// distances that `strip` gives, and nowhere else. `None` where no such contact is found, and once the time is used up.
pub(crate) fn oval(
    f: &dyn Fn(Point) -> f64,
    strip: &dyn Fn(f64) -> Option<[f64; 2]>,
    limits: &Limits,
) -> Option<Estimated> {
    let slenderness = (0..=8)
        .map(|k| strip(FRAC_PI_2 * f64::from(k) / 8.0).map(|[a, b]| (a + b) / (0.7 * (b - a))))
        .try_fold(0.0, |m: f64, s| s.map(|s| m.max(s)))?;
    // What is straight instead of curved errs by the square.
    let sagitta = SAGITTA * (limits.tolerance / 1e-3).max(1.0).sqrt();
    let mut rows = (0.25 * PI * (0.5 * slenderness / sagitta).sqrt()).ceil().clamp(9.0, 120.0) as usize;
    let mut half = 3;
    let mut ends = Ends(vec![FIRST; rows + 1]);
    let mut best: Option<Estimated> = None;
    for _ in 0..ROUNDS {
        let problem = Problem { f, strip, limits };
        let solved = |ends: &mut Ends, rows: usize, half: usize| problem.settled(ends, rows, half);
        let finer = half + 2;
        if rows * 2 * finer > limits.unknowns {
            return best;
        }
        // Fewer rows first: the ends come to rest on them.
        let fewer = (2 * rows).div_ceil(3);
        let mut own = ends.resampled(fewer);
        let Some(shorter) = solved(&mut own, fewer, half) else { return best };
        ends = own.resampled(rows);
        let Some(coarse) = solved(&mut ends, rows, half) else { return best };
        let Some(fine) = solved(&mut ends, rows, finer) else { return best };
        let own = &fine.solved;
        let change = |of: fn(&Solved) -> f64| {
            let across = (of(own) / of(&coarse.solved) - 1.0).abs();
            let along = (of(&coarse.solved) / of(&shorter.solved) - 1.0).abs();
            across + along
        };
        let off = fine.off().max(coarse.off());
        let found = Estimated {
            force: own.force,
            error: change(|s| s.force) + 2.0 * off * off,
            energy: own.energy,
            stiffness: own.stiffness,
            stiffness_error: change(|s| s.stiffness) + off,
            area: own.area,
            area_error: change(|s| s.area) + 2.0 * off,
            cells: own.cells(Touching::All),
            ends: problem.boundary(&ends)?,
            unknowns: own.unknowns,
        };
        let done = found.error <= limits.tolerance;
        best = Some(found);
        if done {
            break;
        }
        let more = rows + rows / 2;
        ends = ends.resampled(more);
        (rows, half) = (more, half + 1);
    }
    best
}

struct Problem<'a> {
    f: &'a dyn Fn(Point) -> f64,
    strip: &'a dyn Fn(f64) -> Option<[f64; 2]>,
    limits: &'a Limits,
}

impl Problem<'_> {
    /// The mesh whose ends have come to rest, as far as they do.
    fn settled(&self, ends: &mut Ends, rows: usize, half: usize) -> Option<State> {
        let mut state = self.solve(ends, rows, half)?;
        for _ in 0..MOVES {
            if state.off() <= CLOSE {
                break;
            }
            ends.moved(&state.moves);
            state = self.solve(ends, rows, half)?;
        }
        let Solved { force, stiffness, .. } = state.solved;
        (force > 0.0 && stiffness > 0.0 && state.off() < 0.1).then_some(state)
    }

    /// Distances of both ends at the stations of a quarter.
    fn distances(&self, ends: &Ends) -> Option<Vec<[f64; 2]>> {
        let rows = ends.0.len() - 1;
        let at = |(k, shares): (usize, &[f64; 2])| {
            let [a, b] = (self.strip)(FRAC_PI_2 * k as f64 / rows as f64)?;
            Some(shares.map(|share| a + share * (b - a)))
        };
        ends.0.iter().enumerate().map(at).collect()
    }

    /// The outer end and the inner one, contact on their left.
    fn boundary(&self, ends: &Ends) -> Option<Vec<Vec<Point>>> {
        let quarter = self.distances(ends)?;
        let rows = quarter.len() - 1;
        let line = |m: usize| (0..4 * rows).map(|k| point(k, rows, |i| quarter[i][m])).collect::<Vec<_>>();
        Some(vec![line(1), line(0).into_iter().rev().collect()])
    }

    fn solve(&self, ends: &Ends, rows: usize, half: usize) -> Option<State> {
        let quarter = self.distances(ends)?;
        let shares = graded_both(0.0, 1.0, half, EXPONENT);
        let across = shares.len() - 1;
        let nodes: Vec<Point> = (0..4 * rows)
            .flat_map(|k| {
                let quarter = &quarter;
                shares.iter().map(move |s| point(k, rows, |i| quarter[i][0] + s * (quarter[i][1] - quarter[i][0])))
            })
            .collect();
        let id = |k: usize, j: usize| (k % (4 * rows)) * (across + 1) + j;
        let cells = (0..4 * rows)
            .flat_map(|k| (0..across).map(move |j| [id(k, j), id(k, j + 1), id(k + 1, j + 1), id(k + 1, j)]))
            .collect();
        let mesh = Mesh::new(nodes, cells, Vec::new());
        let solved = Solved::new(mesh, &mirrors(), self.f, Touching::All, self.limits)?;
        let pressure = &solved.pressure;
        let moves = (0..rows)
            .map(|k| {
                let at = |j: usize| pressure[k * across + j];
                let inner = further([shares[1], shares[2]], [at(0), at(1)]);
                let outer = further([shares[1], shares[2]], [at(across - 1), at(across - 2)]);
                [inner, outer].map(|share| 2.0 * share)
            })
            .collect();
        Some(State { solved, moves })
    }
}

impl Ends {
    /// Moved by the mean of the rows on both sides of each station, which are mirrored at the ends of the quarter.
    fn moved(&mut self, moves: &[[f64; 2]]) {
        let rows = moves.len();
        for (k, [a, b]) in self.0.iter_mut().enumerate() {
            let mean = |m: usize| 0.5 * (moves[k.saturating_sub(1)][m] + moves[k.min(rows - 1)][m]);
            let half = 0.5 * (*b - *a);
            // Contact ends where the bodies overlap.
            *a = (*a - half * mean(0)).max(1e-6);
            *b = (*b + half * mean(1)).min(1.0 - 1e-6);
        }
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

/// The point of station k of 4 rows, at the distance that a quarter has there; mirrored ones are mirrored exactly.
fn point(k: usize, rows: usize, distance: impl Fn(usize) -> f64) -> Point {
    let (i, sx, sy) = match k / rows {
        0 => (k, 1.0, 1.0),
        1 => (2 * rows - k, -1.0, 1.0),
        2 => (k - 2 * rows, -1.0, -1.0),
        _ => (4 * rows - k, 1.0, -1.0),
    };
    let (sin, cos) = match i {
        0 => (0.0, 1.0),
        i if i == rows => (1.0, 0.0),
        i => (FRAC_PI_2 * i as f64 / rows as f64).sin_cos(),
    };
    let r = distance(i);
    [sx * r * cos, sy * r * sin]
}

fn mirrors() -> [Isometry; 4] {
    [[1.0, 1.0], [-1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]]
        .map(|[a, b]| Isometry { centre: [0.0; 2], matrix: [[a, 0.0], [0.0, b]] })
}

#[cfg(test)]
mod tests {
    use super::super::annular::tests::Quadratic;
    use super::super::mesh::Bilinear;
    use super::super::{Law, Span, annular};
    use super::*;

    #[test]
    fn a_round_ring_is_that_of_concentric_rings() {
        // f = 1 - (r - 1)^2/w^2, by concentric rings that are proved.
        for w in [0.3, 0.02] {
            let f = move |[x, y]: Point| 1.0 - ((x.hypot(y) - 1.0) / w).powi(2);
            let found = oval(&f, &move |_| Some([1.0 - w, 1.0 + w]), &Limits::default()).unwrap();
            assert!(found.error <= 1e-3, "{found:?}");
            let c = 1.0 / (w * w);
            let span = Span { radii: [1.0 - w, 1.0 + w], edges: [false, false] };
            let rings =
                annular(&Quadratic([1.0 - c, 2.0 * c, -c]), &[span], Law::Depth(1.0), &Limits::default()).unwrap();
            assert!(rings.proved);
            let off = [rings.force[0] / found.force - 1.0, 1.0 - rings.force[1] / found.force];
            assert!(off.iter().all(|off| *off <= found.error), "{off:?}, {}", found.error);
            let off = rings.stiffness / found.stiffness - 1.0;
            assert!(off.abs() <= found.stiffness_error + 1e-3, "{off}, {}", found.stiffness_error);
            let area: f64 = found.cells.iter().map(|(c, _)| Bilinear::new(*c).area()).sum();
            assert!((area / found.area - 1.0).abs() < 1e-12);
        }
    }

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

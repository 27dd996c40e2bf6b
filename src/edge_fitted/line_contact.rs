//! Line contacts of finite length whose ends are steep: rollers with logarithmic or rounded ends, pressed until these all but end the
//! contact as an edge would.
//!
//! Rows of cells across the strip in which the bodies overlap are graded to both of its ends as those of a roller with sharp ends are
//! ([`super::roller`]), and which of their cells are in contact is found with the pressure: the corners of the contact are rounded by what
//! the graded rows are small beside; the less steep an end, the less they are graded. Across, p ~ s^(1/2) ends among equal cells. Energy and
//! force then fall with the second order of both (the discrete energy is a lower bound, and stationary), and what is left of them is told
//! by fewer cells along and across.

use super::Limits;
use super::directions::{self, Meshes};
use super::estimated::{Estimated, Solved, Touching};
use super::mesh::{Mesh, Point};
use super::near_contact::{BESIDE, Found, Laid};
use super::peak;
use super::roller::{Grading, TO_EDGE};
use super::rows::{between, further};
use super::symmetry::Isometry;
use crate::numeric::geometry::area;

/// A strip in which bodies overlap: x across, y along.
pub(crate) struct LineContact<'a> {
    /// Where they overlap across, by y; as wide as a little further in where the strip itself ends.
    pub overlap: &'a dyn Fn(f64) -> Option<[f64; 2]>,
    /// Where they overlap along.
    pub ends: [f64; 2],
    /// How far from an end the strip is wide.
    pub rise: f64,
    /// Symmetries of the overlap.
    pub group: Vec<Isometry>,
}

/// Rows over the length of the overlap beside an end that are graded to it, and cells across the contact, for an error of 1e-3.
const AT_END: f64 = 5.0;
const ACROSS: usize = 20;

/// The least m of the grading, and what it is more by than one with which the first row is as long as the strip takes to be wide.
const SMOOTH: f64 = 2.0;
const FIRST_ROW: f64 = 1.0;

/// Rows at least: on six one contact was off by 3.2 times what was stated.
const FEWEST: usize = 8;

/// How both grow with an error that is smaller.
const FINER: [f64; 2] = [0.38, 0.42];

/// Cells across all of the overlap that tell how much of it is in contact.
const LOOK: usize = 16;

/// With 1.0 four areas of 224 were off by up to 1.1 times what is stated.
const SAFE_AREA: f64 = 1.25;

/// Rounds of more cells.
const ROUNDS: usize = 4;

/// The stiffness of a strip grows with the logarithm of its width: of a cell across that counts as a whole, no more than this.
const OF_CELL: f64 = 0.25;

/// One mesh.
struct State {
    solved: Solved,
    found: Found,
    /// A cell in contact has no neighbour where the strip goes on.
    cut: bool,
    /// The ends of the contact across, as distances, in every row that is in contact; these rows have no others between them.
    ends: Vec<[f64; 2]>,
    /// The lines on both sides of the first and of the last of them.
    lines: Vec<f64>,
    area: f64,
    /// What the pressure is less by beside the largest one, over that: along and across, on the side where it is less so; and what it may
    /// grow by between that row and the end of the contact.
    drop: f64,
    /// At which ends of the strip there is contact, with a pressure that grows up to there.
    grows: [bool; 2],
    /// The cells across that are in contact in some row: the first, and one after the last.
    touched: [usize; 2],
}

/// The contact of an overlap `f` that is positive in the strip and nowhere else, and at which ends it reaches that of the strip with a
/// pressure that grows up to there. `None` where no such contact is found, and once the time is used up.
pub(crate) fn line_contact(
    f: &dyn Fn(Point) -> f64,
    line: &LineContact,
    limits: &Limits,
) -> Option<(Estimated, [bool; 2])> {
    let (found, finest) = estimated(f, line, limits)?;
    Some((found.with_tilts(&finest.solved, Touching::Some, limits)?, finest.grows))
}

/// The same with the finest mesh.
fn estimated(f: &dyn Fn(Point) -> f64, line: &LineContact, limits: &Limits) -> Option<(Estimated, State)> {
    let [first, last] = line.ends;
    let half = 0.5 * (last - first);
    let [a, b] = (line.overlap)(first + half)?;
    let strip = Strip { f, line, grading: Grading::new(half, b - a, power(line.rise / (b - a))), limits };
    let finer = FINER.map(|power| (1e-3 / limits.tolerance).max(1.0).powf(power));
    let rows_of = |finer: f64| ((AT_END * finer * strip.grading.all).ceil() as usize).max(FEWEST);
    let (mut across, found) = strip.around_contact(rows_of(1.0))?;
    let mut near = Some(found);
    let mut counts = [rows_of(finer[0]), (ACROSS as f64 * finer[1]).ceil() as usize];
    let mut best: Option<(Estimated, State)> = None;
    for _ in 0..ROUNDS {
        let solve = |[rows, cells]: [usize; 2], near: Option<&Found>| strip.solve(rows, cells, across, near);
        let Some(nearer) = solve(directions::less(counts), near.as_ref()) else { return best };
        let near_it = near.as_ref().map(|_| &nearer.found);
        let Some(fine) = solve(counts, near_it) else { return best };
        if fine.touched[0] == 0 || fine.touched[1] == counts[1] {
            // In contact up to the outermost cells: there may be more beside them.
            (across, near) = (strip.widened(across), None);
            continue;
        }
        let fewer = |k: usize| solve(directions::fewer(counts, k), near_it);
        let (Some(shorter), Some(coarse)) = (fewer(0), fewer(1)) else { return best };
        let meshes = Meshes { fine, nearer, fewer: [shorter, coarse] };
        if meshes.all().iter().any(|state| state.cut) {
            near = None;
            continue;
        }
        let told = meshes.told(|state| (&state.solved, state.area));
        let Meshes { fine, nearer, .. } = meshes;
        let own = &fine.solved;
        let cells = counts[1] as f64;
        let found = Estimated {
            force: own.force,
            error: told.left[0] + told.left[1],
            energy: own.energy,
            stiffness: own.stiffness,
            stiffness_error: told.stiffness + OF_CELL / cells,
            stiffness_matrix: None,
            area: fine.area,
            area_error: SAFE_AREA * (told.area + cells.powf(-1.5)),
            // What is less beside a peak may be next to nothing by where two rows lie.
            max_error: Some(told.largest + fine.drop.max(nearer.drop)),
            cells: own.cells(Touching::Some),
            ends: vec![fine.boundary()],
            unknowns: own.unknowns,
        };
        let done = found.error <= limits.tolerance;
        let next = directions::next(counts, told.left, own.unknowns, limits);
        near = Some(fine.found.clone());
        best = Some((found, fine));
        match next {
            Some(more) if !done => counts = more,
            _ => break,
        }
    }
    best
}

/// m of the grading to the ends of a strip, by how far from them it is wide over its width: the first row is a fifth of that.
pub(super) fn power(rise: f64) -> f64 {
    ((1.0 / rise).ln() / AT_END.ln() + FIRST_ROW).clamp(SMOOTH, TO_EDGE)
}

struct Strip<'a> {
    f: &'a dyn Fn(Point) -> f64,
    line: &'a LineContact<'a>,
    grading: Grading,
    limits: &'a Limits,
}

impl Strip<'_> {
    /// The shares of the overlap across between which some row is in contact, with room, from few cells.
    fn around_contact(&self, rows: usize) -> Option<([f64; 2], Found)> {
        let State { touched: [from, to], found, .. } = self.solve(rows, LOOK, [0.0, 1.0], None)?;
        let share = |n: f64| (n / LOOK as f64).clamp(0.0, 1.0);
        Some(([share(from as f64 - BESIDE), share(to as f64 + BESIDE)], found))
    }

    fn widened(&self, [a, b]: [f64; 2]) -> [f64; 2] {
        let more = BESIDE * (b - a) / LOOK as f64;
        [(a - more).max(0.0), (b + more).min(1.0)]
    }

    /// With 2 `rows` rows, graded to the ends, and so many equal cells between two shares of the overlap across, of those not far from
    /// where the contact was found.
    fn solve(&self, rows: usize, cells: usize, [from, to]: [f64; 2], near: Option<&Found>) -> Option<State> {
        let lines = self.grading.lines(self.line.ends, rows);
        let overlap: Option<Vec<[f64; 2]>> = lines.iter().map(|y| (self.line.overlap)(*y)).collect();
        let across = overlap?.into_iter().map(|ends| [between(ends, from), between(ends, to)]);
        let across: Vec<[f64; 2]> = across.collect();
        let point = |k: usize, j: usize| [between(across[k], j as f64 / cells as f64), lines[k]];
        let nodes = (0..lines.len()).flat_map(|k| (0..=cells).map(move |j| (k, j))).map(|(k, j)| point(k, j)).collect();
        let id = |k: usize, j: usize| k * (cells + 1) + j;
        let laid = Laid::new(&lines, cells, [from, to], near);
        let corners = |&[k, j]: &[usize; 2]| [id(k, j), id(k, j + 1), id(k + 1, j + 1), id(k + 1, j)];
        let mesh = Mesh::new(nodes, laid.all.iter().map(corners).collect(), Vec::new());
        let solved = Solved::new(mesh, &self.line.group, self.f, Touching::Some, self.limits)?;
        let (pressure, cut) = (laid.pressures(&solved.pressure), laid.is_cut(&solved.pressure));
        let pressures: Vec<&[f64]> = pressure.chunks_exact(cells).collect();
        let touches = |row: &&[f64]| row.iter().any(|p| *p > 0.0);
        let (first, last) = (pressures.iter().position(touches)?, pressures.iter().rposition(touches)?);
        let mut touched = [cells, 0];
        let share = |j: usize| between([from, to], j as f64 / cells as f64);
        let (mut ends, mut spans) = (Vec::new(), Vec::new());
        for (k, p) in pressures.iter().enumerate().take(last + 1).skip(first) {
            let (a, b) = (p.iter().position(|p| *p > 0.0)?, p.iter().rposition(|p| *p > 0.0)? + 1);
            touched = [touched[0].min(a), touched[1].max(b)];
            spans.push(([lines[k.saturating_sub(1)], lines[(k + 2).min(2 * rows)]], [share(a), share(b)]));
            let width = 1.0 / cells as f64;
            let more = |last: [f64; 2]| further([width, 2.0 * width], last);
            let more = if b - a > 1 { [more([p[a], p[a + 1]]), more([p[b - 1], p[b - 2]])] } else { [0.0; 2] };
            let middle = [0, 1].map(|m| 0.5 * (across[k][m] + across[k + 1][m]));
            ends.push([a as f64 * width - more[0], b as f64 * width + more[1]].map(|share| between(middle, share)));
        }
        let largest: Vec<f64> = pressures.iter().map(|row| row.iter().copied().fold(0.0, f64::max)).collect();
        let drop = peak::drop(&pressures) + peak::growth(&largest, &lines);
        let grows = [(0, 1), (2 * rows - 1, 2 * rows - 2)].map(|(end, beside)| largest[end] > largest[beside]);
        let found = Found { rows: spans, cell: (to - from) / cells as f64 };
        let lines = lines[first..=last + 1].to_vec();
        let mut state = State { solved, found, cut, ends, lines, area: 0.0, drop, grows, touched };
        state.area = area(&state.boundary());
        (state.solved.force > 0.0 && state.area > 0.0).then_some(state)
    }
}

impl State {
    /// Where the contact ends: a closed line, contact on the left.
    fn boundary(&self) -> Vec<Point> {
        let last = self.ends.len();
        // In the middle of every row, and at the lines that the first and the last one begin and end at.
        let y = |k: usize| 0.5 * (self.lines[k] + self.lines[k + 1]);
        let side = |m: usize| {
            let middle = (0..last).map(move |k| [self.ends[k][m], y(k)]);
            let ends = [[self.ends[0][m], self.lines[0]], [self.ends[last - 1][m], self.lines[last]]];
            std::iter::once(ends[0]).chain(middle).chain(std::iter::once(ends[1])).collect::<Vec<Point>>()
        };
        side(1).into_iter().chain(side(0).into_iter().rev()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::symmetry::mirrors;
    use super::*;

    /// Steep ends that are no material's: f = 1 - x^2 + A ln(1 - (y/L)^2), in the units of the solve.
    #[test]
    fn finer_cells_stay_within_the_stated_error() {
        for (length, rise) in [(3.0, 0.14), (10.0, 0.1), (40.0, 0.2)] {
            let f = |[x, y]: Point| 1.0 - x * x + rise * (1.0 - (y / length).powi(2)).ln();
            let end = length * (1.0 - (-1.0 / rise).exp()).sqrt();
            let overlap = |y: f64| {
                let y = y.clamp(0.5 - end, end - 0.5);
                let half = f([0.0, y]).max(0.0).sqrt();
                Some([-half, half])
            };
            let group = mirrors([0.0; 2], [true; 2]);
            let line = LineContact { overlap: &overlap, ends: [-end, end], rise: 0.0, group };
            let at = |tolerance: f64| line_contact(&f, &line, &Limits { tolerance, ..Limits::default() }).unwrap().0;
            let (coarse, fine) = (at(1e-3), at(1e-4));
            assert!(
                coarse.error <= 1e-3 && fine.error <= 1e-4,
                "{length} {rise} {} {} {}",
                coarse.error,
                fine.error,
                fine.unknowns
            );
            let off = |a: f64, b: f64| (a / b - 1.0).abs();
            assert!(off(coarse.force, fine.force) <= coarse.error + fine.error);
            assert!(off(coarse.energy, fine.energy) <= coarse.error + fine.error);
            assert!(off(coarse.stiffness, fine.stiffness) <= coarse.stiffness_error + fine.stiffness_error);
            assert!(off(coarse.area, fine.area) <= coarse.area_error + fine.area_error);
            let largest = |of: &Estimated| of.cells.iter().map(|(_, p)| *p).fold(0.0, f64::max);
            let stated = coarse.max_error.unwrap() + fine.max_error.unwrap();
            assert!(off(largest(&coarse), largest(&fine)) <= stated);
        }
    }
}

//! Contacts in a box, on lines in both directions that lie where the pressure needs them: flats with rounded or sloping edges, beside sharp
//! ones or not.
//!
//! What constant pressures on cells of length h leave of the energy is, along one direction,
//!
//! ```text
//! E ~ integral of h^3 G,     G(x) = integral over y of (dp/dx)^2,
//! ```
//!
//! the square of what they leave of the pressure in the norm of H^(-1/2). It is least, for so many lines, where their density is
//!
//! ```text
//! 1/h ~ G^(1/4)                                                                                                      (1)
//! ```
//!
//! (equidistribution, de Boor 1973): s^(-3/4) beside a sharp edge, which is the grading of the fourth power there, and many where a pressure
//! peaks beside a rounded one. Where no edge is sharp the contact ends among the cells, which leaves more than (1) counts, and the power is
//! 0.4. G is taken from a coarser mesh. Which cells are in contact is found with the pressure, and energy and force fall with the second
//! order of both numbers of lines; what is left of them is told by fewer ([`super::directions`]).

use std::rc::Rc;

use super::Limits;
use super::density::{Density, OnLines};
use super::directions::{self, Meshes};
use super::estimated::{Estimated, Solved, Touching};
use super::line_contact;
use super::mesh::{Mesh, Point};
use super::peak;
use super::region::{Region, regions};
use super::roller::{Grading, TO_EDGE};
use super::symmetry::mirrors;
use crate::numeric::geometry::Rect;

/// A box in which bodies overlap.
pub(crate) struct OverlapBox {
    /// They overlap nowhere else, but for little beside it.
    pub rect: Rect,
    /// The sides, of x and of y, at which the material ends with a sharp edge.
    pub edges: [[bool; 2]; 2],
    /// How far from the sides the overlap is about as large as in the middle, along x and y.
    pub rise: [f64; 2],
    /// Mirrors in lines x = c and y = c, and the point where they cross.
    pub mirrors: [bool; 2],
    pub centre: Point,
}

/// Cells over half the box in the mesh before any with (1).
const AT_FIRST_LOOK: usize = 6;

/// Cells in each direction of the first mesh with (1), for an error of 1e-3, and how they grow with an error that is smaller.
const FIRST: f64 = 20.0;
const FINER: f64 = 0.4;

/// Share of the unknowns that may be solved, in the first round.
const AT_FIRST: f64 = 0.6;

/// The power of (1), and that where no edge is sharp, or so nearly that the overlap rises within this of half the box: of 44 contacts by lot
/// the time is 4.5 s with 0.4, 5.2 with 0.35, 7.4 with (1).
const POWER: f64 = 0.25;
const WITHOUT_EDGES: f64 = 0.4;
const ALL_BUT_SHARP: f64 = 6e-4;

/// What the energy may err by over what cells change it by: it comes from below, and more slowly where the end of the contact is not
/// resolved. With 1.5, as for the force, two of 192 were off by up to 1.4 times what is stated.
const OF_ENERGY: f64 = 2.5;

/// How far beyond a side of the box it is looked whether the bodies overlap there, over the cell beside it.
const BEYOND: [f64; 2] = [1e-3, 1.0];

/// What mirrored lines may be off by, over the size of the box.
const ROUNDING: f64 = 1e-12;

/// Directions and ends of the box.
const SIDES: [(usize, usize); 4] = [(0, 0), (0, 1), (1, 0), (1, 1)];

/// Rounds of more cells.
const ROUNDS: usize = 4;

/// One mesh.
struct State {
    solved: Solved,
    on: OnLines,
    /// A cell in contact has a neighbour in which the bodies overlap and that was left out.
    cut: bool,
    area: f64,
    regions: Vec<Region>,
}

/// A contact in a box.
pub(crate) struct Boxed {
    pub state: Estimated,
    /// An estimate of the relative error of the stored energy.
    pub energy_error: f64,
    /// Whether the pressure grows up to an edge of the material.
    pub singular: bool,
}

/// The contact of an overlap `f` that is positive in a box and nowhere else. `None` where it is not one piece or passes the box, and once the
/// time is used up.
#[must_use]
pub(crate) fn equidistributed(f: &dyn Fn(Point) -> f64, all: &OverlapBox, limits: &Limits) -> Option<Boxed> {
    let problem = Problem { f, all, limits };
    let look = problem.solve(problem.first_lines(), None)?;
    let wanted = FIRST * (1e-3 / limits.tolerance).max(1.0).powf(FINER);
    let symmetries = all.mirrors.map(|mirrored| if mirrored { 2.0 } else { 1.0 });
    let most = (AT_FIRST * symmetries[0] * symmetries[1] * limits.unknowns as f64).sqrt();
    let n = wanted.min(most).ceil() as usize;
    // The lines of a coarse mesh are known nearly, those of a finer one more so.
    let mut found = Rc::new(problem.solve(problem.lines(&look, [n / 2; 2]), Some(&look))?);
    let mut counts = [n; 2];
    let mut best: Option<(Boxed, Rc<State>)> = None;
    for _ in 0..ROUNDS {
        let Some(meshes) = Meshes::of(counts, |counts| problem.solve(problem.lines(&found, counts), Some(&found)))
        else {
            break;
        };
        let told = meshes.told(|state| (&state.solved, state.area));
        let cut = meshes.all().iter().any(|state| state.cut || problem.is_at_end(state));
        let fine = Rc::new(meshes.fine);
        found = Rc::clone(&fine);
        if cut {
            continue;
        }
        let [region] = &fine.regions[..] else { return None };
        let area_error = 0.5 * problem.open(&fine) / fine.area + told.area;
        let (own, error) = (&fine.solved, told.left[0] + told.left[1]);
        let state = Estimated {
            force: own.force,
            error,
            energy: own.energy,
            stiffness: own.stiffness,
            // It follows the end of the contact, which is known to a cell.
            stiffness_error: error.max(told.stiffness).max(0.5 * area_error),
            stiffness_matrix: None,
            area: fine.area,
            area_error,
            max_error: Some(told.largest + problem.beside_peak(&fine)),
            cells: own.cells(Touching::Some),
            ends: region.boundary.clone(),
            unknowns: own.unknowns,
        };
        let next = directions::next(counts, told.left, own.unknowns, limits);
        let energy_error = error.max(OF_ENERGY * told.energy);
        best = Some((Boxed { state, energy_error, singular: problem.is_singular(&fine) }, fine));
        match next {
            Some(more) if error > limits.tolerance => counts = more,
            _ => break,
        }
    }
    let (found, finest) = best.filter(|(_, finest)| !problem.is_passed(finest))?;
    let state = found.state.with_tilts(&finest.solved, Touching::Some, limits)?;
    Some(Boxed { state, ..found })
}

struct Problem<'a> {
    f: &'a dyn Fn(Point) -> f64,
    all: &'a OverlapBox,
    limits: &'a Limits,
}

impl Problem<'_> {
    /// Lines graded to the sides of the box.
    fn first_lines(&self) -> [Vec<f64>; 2] {
        let Rect { min, max } = self.all.rect;
        [0, 1].map(|m| {
            let half = 0.5 * (max[m] - min[m]);
            let sharp = self.all.edges[m] != [false; 2];
            let power = if sharp { TO_EDGE } else { line_contact::power(self.all.rise[m] / half) };
            Grading::new(half, half, power).lines([min[m], max[m]], AT_FIRST_LOOK)
        })
    }

    /// So many cells in each direction by (1), where the contact was found and some beside it.
    fn lines(&self, found: &State, counts: [usize; 2]) -> [Vec<f64>; 2] {
        [0, 1].map(|m| {
            let all_but_sharp = self.all.rise[m] < ALL_BUT_SHARP * 0.5 * self.all.rect.size()[m];
            let power = if all_but_sharp { POWER } else { WITHOUT_EDGES };
            let density = Density::of(&found.on, m, self.all.edges[m].map(|edge| edge || all_but_sharp), power);
            if self.all.mirrors[m] {
                density.mirrored_lines(self.all.centre[m], counts[m])
            } else {
                density.lines(counts[m])
            }
        })
    }

    /// With cells between these lines wherever the bodies overlap, not far from where the contact was found.
    fn solve(&self, lines: [Vec<f64>; 2], found: Option<&State>) -> Option<State> {
        let [x, y] = &lines;
        let (nx, ny) = (x.len() - 1, y.len() - 1);
        let overlaps = |i: usize, j: usize| {
            let at = |v: &[f64], k: usize| [v[k], 0.5 * (v[k] + v[k + 1]), v[k + 1]];
            at(x, i).iter().any(|&x| at(y, j).iter().any(|&y| (self.f)([x, y]) > 0.0))
        };
        let is_near =
            |i: usize, j: usize| found.is_none_or(|found| found.on.is_near([x[i], x[i + 1]], [y[j], y[j + 1]]));
        // As symmetric as the box.
        let images = |i: usize, j: usize| {
            let columns = if self.all.mirrors[0] { vec![i, nx - 1 - i] } else { vec![i] };
            let rows = if self.all.mirrors[1] { vec![j, ny - 1 - j] } else { vec![j] };
            columns.into_iter().flat_map(move |i| rows.clone().into_iter().map(move |j| (i, j)))
        };
        let mut laid = Vec::new();
        let mut left_out = vec![false; nx * ny];
        for (j, i) in (0..ny).flat_map(|j| (0..nx).map(move |i| (j, i))) {
            if images(i, j).any(|(i, j)| overlaps(i, j)) {
                if images(i, j).any(|(i, j)| is_near(i, j)) { laid.push([i, j]) } else { left_out[j * nx + i] = true }
            }
        }
        let nodes = y.iter().flat_map(|&y| x.iter().map(move |&x| [x, y])).collect();
        let id = |i: usize, j: usize| j * (nx + 1) + i;
        let cells = laid.iter().map(|&[i, j]| [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)]).collect();
        let mesh = Mesh::new(nodes, cells, Vec::new());
        let group = mirrors(self.all.centre, self.all.mirrors);
        let solved = Solved::new(mesh, &group, self.f, Touching::Some, self.limits)?;
        let mut pressure = vec![0.0; nx * ny];
        laid.iter().zip(&solved.pressure).for_each(|(&[i, j], p)| pressure[j * nx + i] = *p);
        let cut = (0..nx * ny).any(|k| {
            let (i, j) = (k % nx, k / nx);
            let beside = [
                (i > 0).then(|| k - 1),
                (i + 1 < nx).then_some(k + 1),
                (j > 0).then(|| k - nx),
                (j + 1 < ny).then_some(k + nx),
            ];
            pressure[k] > 0.0 && beside.into_iter().flatten().any(|other| left_out[other])
        });
        let contact: Vec<bool> = solved.pressure.iter().map(|p| *p > 0.0).collect();
        let regions = regions(&solved.mesh, &contact, &solved.pressure, &|_| false);
        let area = regions.iter().map(|region| region.area).sum();
        (solved.force > 0.0).then_some(State { solved, on: OnLines { lines, pressure }, cut, area, regions })
    }

    /// Whether the last line along m, or the first, is an edge of the material.
    fn is_edge(&self, state: &State, m: usize, end: usize) -> bool {
        self.all.edges[m][end] && self.is_side(state, m, end)
    }

    /// Whether it is a side of the box.
    fn is_side(&self, state: &State, m: usize, end: usize) -> bool {
        let (lines, Rect { min, max }) = (&state.on.lines[m], &self.all.rect);
        let off = if end == 0 { lines[0] - min[m] } else { max[m] - lines[lines.len() - 1] };
        off.abs() <= ROUNDING * (max[m] - min[m])
    }

    /// Whether there is contact between the last lines, which are no sides of the box.
    fn is_at_end(&self, state: &State) -> bool {
        let n = state.on.cells();
        let at = |m: usize, end: usize| {
            let k = if end == 0 { 0 } else { n[m] - 1 };
            !self.is_side(state, m, end) && (0..n[1 - m]).any(|l| state.on.along(m, k, l) > 0.0)
        };
        SIDES.into_iter().any(|(m, end)| at(m, end))
    }

    /// Whether the pressure grows up to an edge of the material.
    fn is_singular(&self, state: &State) -> bool {
        let n = state.on.cells();
        let at = |m: usize, end: usize| {
            let [k, beside] = if end == 0 { [0, 1] } else { [n[m] - 1, n[m] - 2] };
            let grows = |l: usize| state.on.along(m, k, l) > state.on.along(m, beside, l);
            self.is_edge(state, m, end) && (0..n[1 - m]).any(grows)
        };
        SIDES.into_iter().any(|(m, end)| at(m, end))
    }

    /// Whether the bodies overlap beyond a cell in contact at a side of the box.
    fn is_passed(&self, state: &State) -> bool {
        let n = state.on.cells();
        let at = |m: usize, end: usize| {
            let (lines, across) = (&state.on.lines[m], &state.on.lines[1 - m]);
            let [k, side, inner] = if end == 0 { [0, 0, 1] } else { [n[m] - 1, n[m], n[m] - 1] };
            let beyond = |l: usize, share: f64| {
                let along = lines[side] + share * (lines[side] - lines[inner]);
                let middle = 0.5 * (across[l] + across[l + 1]);
                (self.f)(if m == 0 { [along, middle] } else { [middle, along] }) > 0.0
            };
            let passes = |l: usize| state.on.along(m, k, l) > 0.0 && BEYOND.iter().any(|share| beyond(l, *share));
            !self.all.edges[m][end] && self.is_side(state, m, end) && (0..n[1 - m]).any(passes)
        };
        SIDES.into_iter().any(|(m, end)| at(m, end))
    }

    /// What the largest pressure may be more by ([`super::peak`]).
    fn beside_peak(&self, state: &State) -> f64 {
        let n = state.on.cells();
        let rows: Vec<&[f64]> = state.on.pressure.chunks_exact(n[0]).collect();
        let growing = |m: usize| {
            let largest = (0..n[m]).map(|k| (0..n[1 - m]).map(|l| state.on.along(m, k, l)).fold(0.0, f64::max));
            let largest: Vec<f64> = std::iter::once(0.0).chain(largest).chain(std::iter::once(0.0)).collect();
            let (first, last) = (std::iter::once(self.all.rect.min[m]), std::iter::once(self.all.rect.max[m]));
            let lines: Vec<f64> = first.chain(state.on.lines[m].iter().copied()).chain(last).collect();
            peak::growth(&largest, &lines)
        };
        peak::drop(&rows) + growing(0) + growing(1)
    }

    /// The area of the cells in contact among which it ends: those beside one that is free, but for the edges of the material.
    fn open(&self, state: &State) -> f64 {
        let n = state.on.cells();
        let is_open = |m: usize, k: usize, l: usize| {
            let free = |k: usize| state.on.along(m, k, l) <= 0.0;
            let before = if k == 0 { !self.is_edge(state, m, 0) } else { free(k - 1) };
            let after = if k + 1 == n[m] { !self.is_edge(state, m, 1) } else { free(k + 1) };
            before || after
        };
        let size = |m: usize, k: usize| state.on.lines[m][k + 1] - state.on.lines[m][k];
        let cells = (0..n[1]).flat_map(|j| (0..n[0]).map(move |i| (i, j)));
        let open = cells.filter(|&(i, j)| state.on.at(i, j) > 0.0 && (is_open(0, i, j) || is_open(1, j, i)));
        open.map(|(i, j)| size(0, i) * size(1, j)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::super::flat::flat_stiffness;
    use super::super::outline::Outline;
    use super::*;

    fn boxed(half: [f64; 2], edges: [[bool; 2]; 2], rise: [f64; 2]) -> OverlapBox {
        let rect = Rect { min: half.map(|h| -h), max: half };
        OverlapBox { rect, edges, rise, mirrors: [true; 2], centre: [0.0; 2] }
    }

    #[test]
    fn a_level_rectangle_is_a_flat_punch() {
        let all = boxed([0.6, 1.0], [[true; 2]; 2], [0.0; 2]);
        let Boxed { state, energy_error, singular } = equidistributed(&|_| 1.0, &all, &Limits::default()).unwrap();
        let outline = Outline::polygon(&[[-0.6, -1.0], [0.6, -1.0], [0.6, 1.0], [-0.6, 1.0]]).unwrap();
        let [low, high] = flat_stiffness(&outline, &Limits { tolerance: 1e-4, ..Limits::default() }).unwrap().stiffness;
        let off = |value: f64| (low / value - 1.0).max(1.0 - high / value);
        assert!(singular && state.error <= 1e-3);
        assert!(off(state.force) <= state.error, "{} {}", state.force, state.error);
        assert!(off(2.0 * state.energy) <= energy_error && off(state.stiffness) <= state.stiffness_error);
        assert!((state.area / 2.4 - 1.0).abs() <= state.area_error + 1e-12);
    }

    /// f = d - max(0, |x| - a)^2/(2 R) - max(0, |y| - b)^2/(2 R).
    fn rounded(d: f64, r: f64, mirrors: bool, limits: &Limits) -> Boxed {
        let [a, b] = [0.9, 0.6];
        let f = |[x, y]: Point| {
            let past = |s: f64, a: f64| (s.abs() - a).max(0.0).powi(2) / (2.0 * r);
            d - past(x, a) - past(y, b)
        };
        let reach = (2.0 * r * d).sqrt();
        let all = boxed([a + reach, b + reach], [[false; 2]; 2], [0.4 * reach; 2]);
        equidistributed(&f, &OverlapBox { mirrors: [mirrors; 2], ..all }, limits).unwrap()
    }

    #[test]
    fn finer_lines_stay_within_the_stated_errors() {
        for r in [0.003, 0.03, 0.3] {
            let at = |tolerance: f64| rounded(1.0, r, true, &Limits { tolerance, ..Limits::default() });
            let (coarse, fine) = (at(1e-3), at(1e-4));
            assert!(coarse.state.error <= 1e-3 && fine.state.error <= 1e-4 && !coarse.singular);
            let within = |of: fn(&Boxed) -> [f64; 2]| {
                let ([a, e], [b, g]) = (of(&coarse), of(&fine));
                assert!((a / b - 1.0).abs() <= e + g, "{r}: {a} {b} {e} {g}");
            };
            within(|s| [s.state.force, s.state.error]);
            within(|s| [s.state.energy, s.energy_error]);
            within(|s| [s.state.stiffness, s.state.stiffness_error]);
            within(|s| [s.state.area, s.state.area_error]);
            let largest = |of: &Boxed| of.state.cells.iter().map(|(_, p)| *p).fold(0.0, f64::max);
            let stated = coarse.state.max_error.unwrap() + fine.state.max_error.unwrap();
            assert!((largest(&coarse) / largest(&fine) - 1.0).abs() <= stated, "{r}");
        }
    }

    #[test]
    fn force_and_stiffness_are_slopes_of_the_energy() {
        let limits = Limits { tolerance: 1e-4, ..Limits::default() };
        let [less, state, more] = [0.99, 1.0, 1.01].map(|d| rounded(d, 0.1, true, &limits).state);
        assert!(((more.energy - less.energy) / (0.02 * state.force) - 1.0).abs() < 1e-2);
        assert!(((more.force - less.force) / (0.02 * state.stiffness) - 1.0).abs() < 2e-2);
        // Nothing rests on the mirrors.
        let without = rounded(1.0, 0.1, false, &Limits::default()).state;
        assert!((without.force / state.force - 1.0).abs() <= without.error + state.error);
    }

    #[test]
    fn what_passes_the_box_is_no_answer() {
        let all = boxed([0.5, 0.5], [[false; 2]; 2], [0.5; 2]);
        assert!(equidistributed(&|_| 1.0, &all, &Limits::default()).is_none());
    }
}

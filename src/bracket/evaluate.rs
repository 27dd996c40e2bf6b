//! A look at every cell where a pressure can fail: roughly at first, then closely where it fails most.

use super::away::away;
use super::cell::{Cell, Jumps};
use super::gap_bounds::{GapBounds, ROUNDING, range};
use super::mirrors::Image;
use super::tables::{Squares, Tables};
use super::violation::{BoundInput, CellBounds, Part, Side, Violation};

/// How closely each cell is looked at: as a whole; in quarters; in the sub-squares of the lattice, with the jumps around it one by
/// one; in sub-squares of half that size.
pub(super) const WHOLE: u8 = 0;
pub(super) const QUARTERED: u8 = 1;

/// Most sub-squares of a cell that are divided, for either side.
const DIVIDED: usize = 6;

impl Violation {
    /// Suprema over every point of the cells. `None` when the gap proves no bounds.
    pub fn proved(input: &BoundInput, known: &mut GapBounds, closely: &mut [u8]) -> Option<Self> {
        let &BoundInput { problem, field, tables, q, mirrors, .. } = input;
        let (cells, nx) = (q.len(), problem.grid.shape[0]);
        let mut found = Self::empty(cells);
        let mut looked = vec![false; cells];
        let away = away(q, problem.grid.shape);
        for first in mirrors.firsts() {
            let mut parts = None;
            for image in mirrors.images(first) {
                let cell = image.cell;
                if q[cell] <= 0.0 {
                    // The lower side asks for nothing there.
                    if input.side == Side::Lower {
                        continue;
                    }
                    let f = known.supremum(problem, cell)?;
                    if f <= 0.0 || found.is_clear(input, cell, away[cell], f) {
                        continue;
                    }
                }
                looked[cell] = true;
                let parts = parts.get_or_insert_with(|| {
                    let inside = field.cell(first % nx, first / nx);
                    if closely[first] == WHOLE { Planes::whole(&inside) } else { Planes::quarters(&inside) }
                });
                found.note(cell, q[cell] > 0.0, &input.seen(parts, known, &image)?);
            }
        }
        for level in QUARTERED..=3 {
            let wide: Vec<bool> = closely.iter().map(|&k| k == WHOLE).collect();
            if level == QUARTERED && !wide.contains(&true) {
                continue;
            }
            found.add_worst(input, &looked, closely, level);
            for first in mirrors.firsts().filter(|&k| closely[k] == level && (level > QUARTERED || wide[k])) {
                let inside = field.cell(first % nx, first / nx);
                let quarters = (level == QUARTERED).then(|| Planes::quarters(&inside));
                let mut close = (level > QUARTERED).then(|| Close::new(&inside, tables));
                for image in mirrors.images(first).filter(|image| looked[image.cell]) {
                    let seen = match (&quarters, &mut close) {
                        (Some(planes), _) => input.seen(planes, known, &image)?,
                        (_, Some(close)) => input.squares(close, &image, level)?,
                        _ => continue,
                    };
                    found.narrow(image.cell, q[image.cell] > 0.0, &seen);
                }
            }
        }
        Some(found.unfold(&mirrors))
    }

    /// At the points of a lattice, with a bound of what is left out of the displacement there; in the worst cells their borders
    /// are included and nearly nothing is left out.
    pub fn sampled(input: &BoundInput, known: &mut GapBounds, closely: &mut [u8]) -> Self {
        let &BoundInput { problem, field, tables, q, mirrors, .. } = input;
        let (cells, nx) = (q.len(), problem.grid.shape[0]);
        let mut found = Self::empty(cells);
        let mut looked = vec![false; cells];
        let away = away(q, problem.grid.shape);
        for first in mirrors.firsts() {
            let mut parts = None;
            for image in mirrors.images(first) {
                let (cell, loaded) = (image.cell, q[image.cell] > 0.0);
                if !loaded && input.side == Side::Lower {
                    continue;
                }
                let f = known.lattice(problem, &image);
                let highest = f.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                if !loaded && (highest <= 0.0 || found.is_clear(input, cell, away[cell], highest)) {
                    continue;
                }
                looked[cell] = true;
                let (u, rest) = parts.get_or_insert_with(|| {
                    let inside = field.cell(first % nx, first / nx);
                    let (values, trend) = (inside.lattice(), inside.trend_on_lattice());
                    let u: [f64; 16] = std::array::from_fn(|k| values[k] + trend[k]);
                    (u, inside.left_out_beside_trend())
                });
                let mut seen = CellBounds::NOTHING;
                f.into_iter().zip(u).for_each(|(f, u)| point(&mut seen, loaded, f, [*u, *rest]));
                found.note(cell, loaded, &seen);
            }
        }
        // No quarters: nothing is bounded over squares.
        closely.iter_mut().for_each(|level| *level = (*level).max(QUARTERED));
        found.add_worst(input, &looked, closely, 2);
        let mut room = Vec::new();
        for first in mirrors.firsts().filter(|&k| closely[k] > QUARTERED) {
            let inside = field.cell(first % nx, first / nx);
            let jumps = inside.jumps();
            let values = inside.points(&jumps, &tables.points, &mut room);
            for image in mirrors.images(first).filter(|image| looked[image.cell]) {
                let (cell, loaded) = (image.cell, q[image.cell] > 0.0);
                let mut seen = CellBounds::NOTHING;
                for (u, at) in values.iter().zip(&tables.points.at) {
                    point(&mut seen, loaded, problem.overlap(cell, image.turn(*at)), [*u, jumps.far]);
                }
                found.note(cell, loaded, &seen);
            }
        }
        found.unfold(&mirrors)
    }

    /// Whether the cell is certainly covered: no load is nearer than D, so that u falls by D/(D + the diagonal) at most within
    /// it. Then the least displacement is noted.
    fn is_clear(&mut self, input: &BoundInput, cell: usize, away: u32, f: f64) -> bool {
        if away <= 1 {
            return false;
        }
        let (grid, field) = (&input.problem.grid, input.field);
        let [a, b] = grid.spacing;
        let (d, diagonal) = (f64::from(away - 1) * a.min(b), a.hypot(b));
        let u = field.at_centre(cell % grid.shape[0], cell / grid.shape[0]);
        let u = (u - field.rounding(u)) * d / (d + diagonal);
        if f < u {
            self.clear(cell, f, u);
        }
        f < u
    }
}

/// The displacement in a cell: planes over its quarters, or over the whole of it four times, and bounds of what leaves them.
struct Planes {
    whole: bool,
    planes: [[f64; 3]; 4],
    off: [[f64; 2]; 4],
}

impl Planes {
    fn whole(inside: &Cell) -> Self {
        let rest = inside.left_out_roughly() + inside.bend(0.5);
        Self { whole: true, planes: [inside.centre(); 4], off: [[-rest, rest]; 4] }
    }

    /// The trend of the jumps is taken out of what the polynomial leaves.
    fn quarters(inside: &Cell) -> Self {
        let rest = inside.left_out_beside_trend() + inside.bend(0.25);
        let off = inside.trend_in_quarters().map(|[low, high]| [low - rest, high + rest]);
        Self { whole: false, planes: inside.quarters(), off }
    }
}

/// The displacement in a cell with the jumps around it one by one: planes over the sub-squares of the lattice, and over quarters of
/// these where they were asked for.
struct Close<'a> {
    inside: &'a Cell<'a>,
    jumps: Jumps,
    coarse: Vec<[f64; 4]>,
    fine: Vec<Option<[f64; 4]>>,
}

impl<'a> Close<'a> {
    fn new(inside: &'a Cell<'a>, tables: &Tables) -> Self {
        let (jumps, mut coarse) = (inside.jumps(), Vec::new());
        inside.squares(&jumps, &tables.squares[0], &mut coarse);
        Self { inside, jumps, coarse, fine: vec![None; tables.squares[1].at.len()] }
    }

    fn fine(&mut self, k: usize, squares: &Squares) -> [f64; 4] {
        *self.fine[k].get_or_insert_with(|| self.inside.square(&self.jumps, squares, k))
    }
}

fn turned(image: &Image, [u, s, t]: [f64; 3]) -> [f64; 3] {
    let [s, t] = image.turn([s, t]);
    [u, s, t]
}

impl BoundInput<'_> {
    /// A cell, by the planes in the one that it is an image of.
    fn seen(&self, of: &Planes, known: &mut GapBounds, image: &Image) -> Option<CellBounds> {
        let mut seen = CellBounds::NOTHING;
        if of.whole {
            let plane = turned(image, of.planes[0]);
            let bounds = range(self.problem, image.cell, [0.0; 2], 0.5, [plane[1], plane[2]])?;
            seen.add(self.square(0.5, plane, of.off[0], bounds));
            return Some(seen);
        }
        let planes = std::array::from_fn(|k| turned(image, of.planes[image.quarter(k)]));
        let bounds = known.quarters(self.problem, image.cell, &planes)?;
        for (k, (plane, bounds)) in planes.into_iter().zip(bounds).enumerate() {
            seen.add(self.square(0.25, plane, of.off[image.quarter(k)], bounds));
        }
        Some(seen)
    }

    /// The sub-squares of the lattice; at the last level those that decide the suprema are looked at in quarters of their own.
    fn squares(&self, close: &mut Close, image: &Image, level: u8) -> Option<CellBounds> {
        let [coarse, fine] = &self.tables.squares;
        let part = |half: f64, at: [f64; 2], [u, s, t, rest]: [f64; 4]| {
            let plane = turned(image, [u, s, t]);
            let bounds = range(self.problem, image.cell, image.turn(at), half, [plane[1], plane[2]])?;
            Some(self.square(half, plane, [-rest, rest], bounds))
        };
        let parts = close.coarse.iter().zip(&coarse.at).map(|(plane, at)| part(coarse.half, *at, *plane));
        let mut parts = parts.collect::<Option<Vec<Part>>>()?;
        if level > 2 {
            let n = self.tables.per_cell;
            let mut open = vec![true; parts.len()];
            for side in [Side::Upper, Side::Lower].into_iter().filter(|&s| self.side == Side::Both || self.side == s) {
                // While the highest is one that was not divided yet.
                for _ in 0..DIVIDED {
                    let Some(k) = highest(&parts, side).filter(|k| open.get(*k) == Some(&true)) else { break };
                    open[k] = false;
                    let whole = parts[k];
                    for (a, b) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                        let child = (2 * (k / n) + b) * 2 * n + 2 * (k % n) + a;
                        let own = part(fine.half, fine.at[child], close.fine(child, fine))?;
                        parts.push(own.narrowed(&whole));
                    }
                    parts[k] = Part::NOTHING;
                }
            }
        }
        let mut seen = CellBounds::NOTHING;
        parts.into_iter().for_each(|part| seen.add(part));
        Some(seen)
    }

    /// A square of this half side over which u less its plane lies within `off`, and the gap and the slopes of that plane
    /// within `gap`.
    fn square(&self, half: f64, [u, s, t]: [f64; 3], off: [f64; 2], gap: [f64; 2]) -> Part {
        let depth = self.problem.depth;
        let hair = self.field.rounding(u) + ROUNDING * depth.abs().max(1.0);
        let [down, up] = [off[0] - hair, off[1] + hair];
        let slope = (s.abs() + t.abs()) * half;
        Part { r: [depth - u - gap[1] - up, depth - u - gap[0] - down], u: [u - slope + down, u + slope + up] }
    }
}

/// The part that decides a side.
fn highest(parts: &[Part], side: Side) -> Option<usize> {
    let height = |part: &Part| if side == Side::Lower { -part.r[0] } else { part.over() };
    parts.iter().map(height).enumerate().reduce(|a, b| if b.1 > a.1 { b } else { a }).map(|(k, _)| k)
}

fn point(seen: &mut CellBounds, loaded: bool, f: f64, [u, rest]: [f64; 2]) {
    if loaded || f > 0.0 {
        seen.add(Part { r: [f - u - rest, f - u + rest], u: [u - rest, u + rest] });
    }
}

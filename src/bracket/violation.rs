//! How far a pressure is from being admissible, cell by cell, as suprema over the whole cell.

use super::field::Field;
use super::frame::Frame;
use super::polynomial::QUARTERS;
use super::tables::Tables;
use crate::gap::Gap;
use crate::geometry::Rect;

/// Suprema over each cell, cells as in the grid. Where a cell has nothing to say a supremum is minus infinity.
pub(super) struct Violation {
    /// Of f - u over the part of the cell where f > 0.
    pub over: Vec<f64>,
    /// Of f/u over the same part.
    pub short: Vec<f64>,
    /// Of u - f over a loaded cell; infinite where a part of it has no material.
    pub under: Vec<f64>,
    /// Of u/f over a loaded cell; infinite where f <= 0 somewhere.
    pub long: Vec<f64>,
    /// Least displacement in the cell.
    pub least: Vec<f64>,
}

/// Rounding of f and of the last sums, relative to the depth.
const ROUNDING: f64 = 1e-13;

impl Violation {
    fn empty(cells: usize) -> Self {
        let none = vec![f64::NEG_INFINITY; cells];
        Self {
            over: none.clone(),
            short: none.clone(),
            under: none.clone(),
            long: none,
            least: vec![f64::INFINITY; cells],
        }
    }

    fn note(&mut self, cell: usize, loaded: bool, r: [f64; 2], u: [f64; 2]) {
        let ([r_low, r_high], [u_low, u_high]) = (r, u);
        self.least[cell] = self.least[cell].min(u_low);
        // f = r + u may be positive here.
        if r_high + u_high > 0.0 {
            self.over[cell] = self.over[cell].max(r_high);
            let by = if r_high > 0.0 { u_low } else { u_high };
            let ratio = if by > 0.0 { 1.0 + r_high / by } else { f64::INFINITY };
            self.short[cell] = self.short[cell].max(ratio);
        }
        if loaded {
            self.under[cell] = self.under[cell].max(-r_low);
            // inf f/u = 1 + inf r/u.
            let by = if r_low < 0.0 { u_low } else { u_high };
            let least = if by > 0.0 { 1.0 + r_low / by } else { f64::NEG_INFINITY };
            self.long[cell] = self.long[cell].max(if least > 0.0 { 1.0 / least } else { f64::INFINITY });
        }
    }

    /// Over the whole of every cell: each in quarters first, then the worst in sub-squares of the lattice. `None` when the
    /// gap proves no bounds.
    pub fn proved(subject: &Subject, closely: &mut [u8]) -> Option<Self> {
        let &Subject { frame, field, tables, q, side } = subject;
        let (grid, nx) = (&frame.grid, frame.grid.shape[0]);
        let mut found = Self::empty(grid.len());
        let mut left_out = vec![f64::NAN; grid.len()];
        let away = away(q, grid.shape);
        let look = Look { frame, field, half: 0.25 };
        for cell in 0..grid.len() {
            let (i, j) = (cell % nx, cell / nx);
            if q[cell] <= 0.0 {
                let f = frame.depth * (1.0 + ROUNDING) - frame.gap.range(&grid.cell(i, j), [0.0; 2])?[0];
                if f <= 0.0 || found.is_clear(&look, cell, away[cell], f) {
                    continue;
                }
            }
            let inside = field.cell(i, j);
            left_out[cell] = inside.left_out();
            let rest = left_out[cell] + inside.bend(look.half);
            for (at, [u, s, t]) in QUARTERS.into_iter().zip(inside.quarters()) {
                look.square(&mut found, cell, q[cell] > 0.0, at, [u, s, t, rest])?;
            }
        }
        for (level, squares) in (1..).zip(&tables.squares) {
            found.add_worst(q, &left_out, side, closely, level);
            let look = Look { half: squares.half, ..look };
            let mut room = Vec::new();
            for cell in (0..grid.len()).filter(|&k| closely[k] == level && !left_out[k].is_nan()) {
                let inside = field.cell(cell % nx, cell / nx);
                let jumps = inside.jumps(left_out[cell]);
                let before = found.take(cell);
                for (plane, at) in inside.squares(&jumps, squares, &mut room).iter().zip(&squares.at) {
                    look.square(&mut found, cell, q[cell] > 0.0, *at, *plane)?;
                }
                found.narrow(cell, before);
            }
        }
        Some(found)
    }

    /// At lattice points of the worst cells, borders included, and at the corners, the middles of the sides and the centre of the
    /// others, with a bound of what that leaves out of the displacement.
    pub fn sampled(subject: &Subject, closely: &mut [u8]) -> Self {
        let &Subject { frame, field, tables, q, side } = subject;
        let (grid, nx) = (&frame.grid, frame.grid.shape[0]);
        let mut found = Self::empty(grid.len());
        let mut left_out = vec![f64::NAN; grid.len()];
        let away = away(q, grid.shape);
        let look = Look { frame, field, half: 0.0 };
        let overlap = |cell: usize, at: [f64; 2]| {
            let [x, y] = look.place(cell, at);
            frame.depth - frame.gap.gap(x, y)
        };
        for cell in 0..grid.len() {
            let loaded = q[cell] > 0.0;
            let mut f = [0.0; 9];
            f.iter_mut().enumerate().for_each(|(k, f)| *f = overlap(cell, nine(k)));
            let highest = f.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            if !loaded && (highest <= 0.0 || found.is_clear(&look, cell, away[cell], highest)) {
                continue;
            }
            let inside = field.cell(cell % nx, cell / nx);
            left_out[cell] = inside.left_out();
            for (f, u) in f.into_iter().zip(inside.nine()) {
                found.point(cell, loaded, f, [u, left_out[cell]]);
            }
        }
        found.add_worst(q, &left_out, side, closely, 1);
        let mut room = Vec::new();
        for cell in (0..grid.len()).filter(|&k| closely[k] > 0 && !left_out[k].is_nan()) {
            let inside = field.cell(cell % nx, cell / nx);
            let jumps = inside.jumps(left_out[cell]);
            found.take(cell);
            let values = inside.points(&jumps, &tables.points, &mut room);
            for (u, at) in values.iter().zip(&tables.points.at) {
                found.point(cell, q[cell] > 0.0, overlap(cell, *at), [*u, jumps.far]);
            }
        }
        found
    }

    fn point(&mut self, cell: usize, loaded: bool, f: f64, [u, rest]: [f64; 2]) {
        if loaded || f > 0.0 {
            self.note(cell, loaded, [f - u - rest, f - u + rest], [u - rest, u + rest]);
        }
    }

    /// Whether the cell is certainly covered: no load is nearer than D, so that u falls by D/(D + the diagonal) at most within
    /// it. Then the least displacement is noted.
    fn is_clear(&mut self, look: &Look, cell: usize, away: u32, f: f64) -> bool {
        if away <= 1 {
            return false;
        }
        let nx = look.frame.grid.shape[0];
        let [a, b] = look.frame.grid.spacing;
        let (d, diagonal) = (f64::from(away - 1) * a.min(b), a.hypot(b));
        let u = look.field.centre(cell % nx, cell / nx);
        let u = (u - look.field.rounding(u)) * d / (d + diagonal);
        if f < u {
            (self.least[cell], self.short[cell]) = (u, f / u);
        }
        f < u
    }

    /// Adds the cells with the largest violations to those that are looked at closely: at first about as many as lie along the
    /// edge of the contact and its ridges, then some more. A cell that was corrected by what was seen closely must be seen
    /// so again: from further away it would seem to be violated still.
    fn add_worst(&self, q: &[f64], left_out: &[f64], side: Side, closely: &mut [u8], level: u8) {
        let height = |k: usize| match side {
            Side::Both => self.over[k].max(self.under[k]),
            Side::Upper => self.over[k],
            Side::Lower => self.under[k],
        };
        let first = !closely.contains(&level);
        let mut cells: Vec<(f64, usize)> = (0..q.len())
            .filter(|&k| !left_out[k].is_nan() && closely[k] + 1 == level)
            .map(|k| (height(k), k))
            .filter(|c| c.0 > 0.0)
            .collect();
        let loaded = q.iter().filter(|&&q| q > 0.0).count();
        let lines = LINES[usize::from(level) - 1] * if first { 1.0 } else { MORE };
        let most = (lines * (loaded as f64).sqrt()) as usize + 16;
        if most < cells.len() {
            cells.select_nth_unstable_by(most, |a, b| b.0.total_cmp(&a.0));
            cells.truncate(most);
        }
        cells.into_iter().for_each(|c| closely[c.1] = level);
    }

    /// Forgets a cell and says what was known.
    fn take(&mut self, k: usize) -> [f64; 5] {
        let known = [self.over[k], self.short[k], self.under[k], self.long[k], self.least[k]];
        (self.over[k], self.short[k], self.under[k], self.long[k]) =
            (f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY);
        self.least[k] = f64::INFINITY;
        known
    }

    /// The narrower of two bounds each.
    fn narrow(&mut self, k: usize, [over, short, under, long, least]: [f64; 5]) {
        self.over[k] = self.over[k].min(over);
        self.short[k] = self.short[k].min(short);
        self.under[k] = self.under[k].min(under);
        self.long[k] = self.long[k].min(long);
        self.least[k] = self.least[k].max(least);
    }
}

/// Cells looked at closely, and more closely, in roots of the number of loaded ones; and the share of that by which a
/// later look may add to them.
const LINES: [f64; 2] = [15.0, 5.0];
const MORE: f64 = 0.2;

/// The side of the bracket that a look is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    Both,
    Upper,
    Lower,
}

/// What is looked at, and how.
pub(super) struct Subject<'a> {
    pub frame: &'a Frame<'a>,
    pub field: &'a Field,
    pub tables: &'a Tables,
    pub q: &'a [f64],
    pub side: Side,
}

/// Corners, middles of sides and centre.
fn nine(k: usize) -> [f64; 2] {
    [0.5 * (k % 3) as f64 - 0.5, 0.5 * (k / 3) as f64 - 0.5]
}

/// A way to look at squares within cells.
struct Look<'a, 'f> {
    frame: &'a Frame<'f>,
    field: &'a Field,
    /// Half the side of a square, in sides of a cell.
    half: f64,
}

impl Look<'_, '_> {
    /// A point of a cell, in sides from its centre.
    fn place(&self, cell: usize, at: [f64; 2]) -> [f64; 2] {
        let grid = &self.frame.grid;
        let corner = [cell % grid.shape[0], cell / grid.shape[0]];
        [0, 1].map(|m| grid.origin[m] + (corner[m] as f64 + 0.5 + at[m]) * grid.spacing[m])
    }

    /// Notes a square about `at` over which the displacement leaves a plane by no more than `rest`.
    fn square(
        &self,
        found: &mut Violation,
        cell: usize,
        loaded: bool,
        at: [f64; 2],
        [u, s, t, rest]: [f64; 4],
    ) -> Option<()> {
        let spacing = self.frame.grid.spacing;
        let depth = self.frame.depth;
        let rest = rest + self.field.rounding(u) + ROUNDING * depth.abs().max(1.0);
        // A hair larger, so that the squares cover the cell however the sums are rounded.
        let square = Rect::around(self.place(cell, at), spacing.map(|h| h * self.half * (1.0 + 1e-9)));
        let [low, high] = self.frame.gap.range(&square, [-s / spacing[0], -t / spacing[1]])?;
        let varies = (s.abs() + t.abs()) * self.half + rest;
        let r = [depth - u - high - rest, depth - u - low + rest];
        found.note(cell, loaded, r, [u - varies, u + varies]);
        Some(())
    }
}

/// How many cells each cell is away from the nearest loaded one, along the longer of the two ways; a large number without load.
fn away(q: &[f64], [nx, ny]: [usize; 2]) -> Vec<u32> {
    let mut away: Vec<u32> = q.iter().map(|&q| if q > 0.0 { 0 } else { u32::from(u16::MAX) }).collect();
    let mut pass = |order: &mut dyn Iterator<Item = usize>, back: bool| {
        for k in order {
            let (i, j) = (k % nx, k / nx);
            let (behind_i, behind_j) = if back { (i + 1 < nx, j + 1 < ny) } else { (i > 0, j > 0) };
            let step = |di: bool, dj: bool, mirrored: bool| {
                let i = match (di, mirrored != back) {
                    (false, _) => i,
                    (true, false) => i.wrapping_sub(1),
                    (true, true) => i + 1,
                };
                let j = if !dj {
                    j
                } else if back {
                    j + 1
                } else {
                    j - 1
                };
                away.get(j * nx + i.min(nx - 1)).map_or(u32::MAX - 1, |a| a + 1)
            };
            let mut least = away[k];
            if behind_i {
                least = least.min(step(true, false, false));
            }
            if behind_j {
                least = least.min(step(false, true, false));
                if behind_i {
                    least = least.min(step(true, true, false));
                }
                if if back { i > 0 } else { i + 1 < nx } {
                    least = least.min(step(true, true, true));
                }
            }
            away[k] = least;
        }
    };
    pass(&mut (0..nx * ny), false);
    pass(&mut (0..nx * ny).rev(), true);
    away
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_away_from_the_load_along_the_longer_way() {
        let shape = [9, 7];
        let mut q = vec![0.0; 63];
        for loaded in [[2_usize, 1_usize], [8, 6], [0, 5]] {
            q[loaded[1] * 9 + loaded[0]] = 1.0;
        }
        for (k, found) in away(&q, shape).into_iter().enumerate() {
            let (i, j) = (k % 9, k / 9);
            let to = |a: usize, b: usize| i.abs_diff(a).max(j.abs_diff(b)) as u32;
            assert_eq!(found, to(2, 1).min(to(8, 6)).min(to(0, 5)), "{i} {j}");
        }
    }
}

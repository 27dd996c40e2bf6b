//! How far a pressure is from being admissible, cell by cell, as suprema over the whole cell.

use super::between::Between;
use super::displacement::Lattice;
use super::frame::Frame;
use super::kernel::RELATIVE_ERROR;
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
    /// Products with a shifted kernel.
    pub products: usize,
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
            products: 0,
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

    /// With the remainder between lattice points: sub-squares with their middle at (k + 1/2)/S of a cell. `None` when the gap
    /// proves no bounds.
    pub fn proved(frame: &Frame, lattice: &mut Lattice, q: &[f64], per_cell: usize) -> Option<Self> {
        let (grid, [nx, _]) = (&frame.grid, frame.grid.shape);
        let mut found = Self::empty(grid.len());
        let lowest: Vec<f64> = (0..grid.len())
            .map(|k| frame.gap.range(&grid.cell(k % nx, k / nx), [0.0; 2]).map(|r| r[0]))
            .collect::<Option<_>>()?;
        let mut wanted: Vec<bool> =
            (0..grid.len()).map(|k| q[k] > 0.0 || lowest[k] < frame.depth * (1.0 + ROUNDING)).collect();
        let between = Between::new(lattice, grid.spacing, grid.shape, per_cell, q);
        let spectrum = lattice.pressure(q);
        let half = grid.spacing.map(|h| 0.5 * h / per_cell as f64);
        let away = away(q, grid.shape);
        for k in 0..per_cell * per_cell {
            let sub = [k % per_cell, k / per_cell];
            let shift = sub.map(|s| (s as f64 + 0.5) / per_cell as f64);
            let layer = lattice.layer(&spectrum, shift, true);
            found.products += 3;
            let rounding = lattice.rounding(q) + ROUNDING * frame.depth.abs().max(1.0);
            for cell in 0..grid.len() {
                let (i, j) = (cell % nx, cell / nx);
                let point = j * (nx + 1) + i;
                if k == 0 && wanted[cell] && away[cell] > 1 {
                    // No load is nearer than D, so that u falls by D/(D + the diagonal) at most within the cell.
                    let [a, b] = grid.spacing;
                    let (d, diagonal) = (f64::from(away[cell] - 1) * a.min(b), a.hypot(b));
                    let u = (layer.u[point] * (1.0 - 4.0 * RELATIVE_ERROR) - rounding) * d / (d + diagonal);
                    let f = frame.depth - lowest[cell] + rounding;
                    if f < u {
                        (found.least[cell], found.short[cell]) = (u, f / u);
                        wanted[cell] = false;
                    }
                }
                if !wanted[cell] {
                    continue;
                }
                let (u, slope) = (layer.u[point], [layer.slopes[0][point], layer.slopes[1][point]]);
                let rest = between.remainder(q, [i, j], sub) * (1.0 + 1e-6) + rounding + 4.0 * RELATIVE_ERROR * u.abs();
                let centre = [0, 1].map(|m| grid.origin[m] + ([i, j][m] as f64 + shift[m]) * grid.spacing[m]);
                // A hair larger, so that the sub-squares cover the cell however the sums are rounded.
                let square = Rect::around(centre, half.map(|e| e * (1.0 + 1e-9)));
                let [low, high] = frame.gap.range(&square, slope.map(|s| -s))?;
                let varies = slope[0].abs() * half[0] + slope[1].abs() * half[1] + rest;
                let r = [frame.depth - u - high - rest, frame.depth - u - low + rest];
                found.note(cell, q[cell] > 0.0, r, [u - varies, u + varies]);
            }
        }
        Some(found)
    }

    /// At the points k/S of each cell, its border included.
    pub fn sampled(frame: &Frame, lattice: &mut Lattice, q: &[f64], per_cell: usize) -> Self {
        let (grid, [nx, ny]) = (&frame.grid, frame.grid.shape);
        let mut found = Self::empty(grid.len());
        let spectrum = lattice.pressure(q);
        for k in 0..per_cell * per_cell {
            let sub = [k % per_cell, k / per_cell];
            let shift = sub.map(|s| s as f64 / per_cell as f64);
            let layer = lattice.layer(&spectrum, shift, false);
            found.products += 1;
            // A point on a border belongs to the cells on both sides.
            let owners = |m: usize, i: usize| {
                let n = grid.shape[m];
                let first = if sub[m] == 0 { i.saturating_sub(1) } else { i };
                first..=i.min(n - 1)
            };
            for j in 0..=ny {
                for i in 0..=nx {
                    let (rows, columns) = (owners(1, j), owners(0, i));
                    let x = grid.origin[0] + (i as f64 + shift[0]) * grid.spacing[0];
                    let y = grid.origin[1] + (j as f64 + shift[1]) * grid.spacing[1];
                    let u = layer.u[j * (nx + 1) + i];
                    let f = frame.depth - frame.gap.gap(x, y);
                    for b in rows {
                        for a in columns.clone() {
                            let cell = b * nx + a;
                            if q[cell] > 0.0 || f > 0.0 {
                                found.note(cell, q[cell] > 0.0, [f - u; 2], [u; 2]);
                            }
                        }
                    }
                }
            }
        }
        found
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

//! What the displacement can do between lattice points: a bound of its distance from its tangent plane over a sub-square.
//!
//! With the middle cell i of a block of (2m + 1)^2 cells, the displacement is that of the uniform load p_i on the block
//! (smooth in the middle), of the jumps p_j - p_i in the block, and of the cells beyond it. The eight neighbours have
//! infinite slopes on the middle cell's border; their kernel falls with |x| and |y|, so that its range over a tile is known
//! from two corners. All others have second derivatives below those of [`kernel::curvature`].

use super::displacement::Lattice;
use super::kernel;

/// m: half the side of the block, in cells, less the half of the middle one.
const BLOCK: usize = 8;

/// Tiles along a sub-square for the range of a neighbour's kernel.
const TILES: usize = 16;

/// Bounds for one grid and one pressure, for all sub-squares of a lattice.
pub(super) struct Between {
    shape: [usize; 2],
    per_cell: usize,
    /// Per cell: half the squared half-diagonal times the second derivatives of jumps and far cells.
    smooth: Vec<f64>,
    /// Per sub-square of a cell: by a unit jump of each neighbour, 3 x 3, the middle unused.
    touching: Vec<[f64; 9]>,
    /// By a unit of uniform load on the block.
    uniform: f64,
}

impl Between {
    pub fn new(lattice: &Lattice, h: [f64; 2], shape: [usize; 2], per_cell: usize, p: &[f64]) -> Self {
        let half = h.map(|h| 0.5 * h / per_cell as f64);
        let half_square = 0.5 * (half[0] * half[0] + half[1] * half[1]);
        let spectrum = lattice.pressure(p);
        let far =
            lattice.convolve(&spectrum, |[i, j]| if i.max(j) <= BLOCK { 0.0 } else { kernel::curvature(h, [i, j]) });
        let jumps = jumps(h, shape, p);
        // A convolution of positive numbers: rounding can take it below, never by more than this.
        let rounding = 1e-12 * far.iter().copied().fold(0.0, f64::max);
        let smooth = far.iter().zip(&jumps).map(|(far, jump)| half_square * (far + rounding + jump)).collect();
        let touching =
            mirrored(per_cell, |sub| touching(h, half, sub.map(|s| (s as f64 + 0.5) / per_cell as f64 - 0.5)));
        Self { shape, per_cell, smooth, touching, uniform: uniform(h, half) }
    }

    /// Largest distance of the displacement from its tangent plane over sub-square `[s, t]` of cell (i, j).
    pub fn remainder(&self, p: &[f64], [i, j]: [usize; 2], [s, t]: [usize; 2]) -> f64 {
        let [nx, ny] = self.shape;
        let middle = p[j * nx + i];
        let unit = &self.touching[t * self.per_cell + s];
        let mut sum = self.smooth[j * nx + i] + middle * self.uniform;
        for (k, unit) in unit.iter().enumerate() {
            let (a, b) = (i + k % 3, j + k / 3);
            let inside = (1..=nx).contains(&a) && (1..=ny).contains(&b);
            let neighbour = if inside { p[(b - 1) * nx + a - 1] } else { 0.0 };
            sum += unit * (neighbour - middle).abs();
        }
        sum
    }
}

/// Per cell: sum of |p_j - p_i| times the curvature over the block without the nine cells in the middle.
fn jumps(h: [f64; 2], [nx, ny]: [usize; 2], p: &[f64]) -> Vec<f64> {
    let width = 2 * BLOCK + 1;
    let weights: Vec<f64> = (0..width * width)
        .map(|k| [(k % width).abs_diff(BLOCK), (k / width).abs_diff(BLOCK)])
        .map(|offset| if offset[0].max(offset[1]) <= 1 { 0.0 } else { kernel::curvature(h, offset) })
        .collect();
    // A frame of empty cells saves the test for the border.
    let padded_width = nx + 2 * BLOCK;
    let mut padded = vec![0.0; padded_width * (ny + 2 * BLOCK)];
    for (j, row) in p.chunks_exact(nx).enumerate() {
        padded[(j + BLOCK) * padded_width + BLOCK..][..nx].copy_from_slice(row);
    }
    (0..nx * ny)
        .map(|k| {
            let (i, j, middle) = (k % nx, k / nx, p[k]);
            let mut sum = 0.0;
            for (b, weights) in weights.chunks_exact(width).enumerate() {
                let row = &padded[(j + b) * padded_width + i..][..width];
                sum += row.iter().zip(weights).map(|(q, w)| w * (q - middle).abs()).sum::<f64>();
            }
            sum
        })
        .collect()
}

/// The distance from the tangent plane in the middle cell of a uniformly loaded block, per unit of load: u_xx is a sum of
/// four terms v/(u r) of one sign, u_xy of four terms 1/r of alternating sign.
fn uniform(h: [f64; 2], half: [f64; 2]) -> f64 {
    let [near, far] = [0.0, 1.0].map(|side| h.map(|h| (BLOCK as f64 + side) * h));
    let along = |m: usize| 4.0 * far[1 - m] / (near[m] * near[m].hypot(far[1 - m]));
    let across = 2.0 / near[0].hypot(near[1]) - 2.0 / far[0].hypot(far[1]);
    let [a, b] = half;
    0.5 * std::f64::consts::FRAC_1_PI * (along(0) * a * a + 2.0 * across * a * b + along(1) * b * b)
}

/// The values of all sub-squares from those with the lower indices: the others are their mirror images.
fn mirrored(per_cell: usize, values: impl Fn([usize; 2]) -> [f64; 9]) -> Vec<[f64; 9]> {
    let mut all = vec![[0.0; 9]; per_cell * per_cell];
    for t in 0..per_cell.div_ceil(2) {
        for s in 0..per_cell.div_ceil(2) {
            let unit = values([s, t]);
            for (t, down) in [(t, false), (per_cell - 1 - t, true)] {
                for (s, left) in [(s, false), (per_cell - 1 - s, true)] {
                    for (k, value) in unit.iter().enumerate() {
                        let i = if left { 2 - k % 3 } else { k % 3 };
                        let j = if down { 2 - k / 3 } else { k / 3 };
                        all[t * per_cell + s][3 * j + i] = *value;
                    }
                }
            }
        }
    }
    all
}

/// The distance from the tangent plane over the sub-square at `at` (cells from the middle of the cell), by unit pressure
/// on each of the eight neighbours: kernel over a tile between its values at the furthest and the nearest corner.
fn touching(h: [f64; 2], half: [f64; 2], at: [f64; 2]) -> [f64; 9] {
    let mut worst = [0.0_f64; 9];
    for (k, worst) in worst.iter_mut().enumerate() {
        if k == 4 {
            continue;
        }
        let centre = [(at[0] - (k % 3) as f64 + 1.0) * h[0], (at[1] - (k / 3) as f64 + 1.0) * h[1]];
        let [value, gx, gy] = kernel::displacement(h, centre[0], centre[1]);
        let tile = half.map(|e| 2.0 * e / TILES as f64);
        // Least and greatest |x| of tile number n.
        let span = |m: usize, n: usize| {
            let from = centre[m] - half[m] + n as f64 * tile[m];
            let ends = [from.abs(), (from + tile[m]).abs()];
            let least = if from < 0.0 && from + tile[m] > 0.0 { 0.0 } else { ends[0].min(ends[1]) };
            [least, ends[0].max(ends[1])]
        };
        for b in 0..TILES {
            for a in 0..TILES {
                let ([x0, x1], [y0, y1]) = (span(0, a), span(1, b));
                let high = kernel::displacement(h, x0, y0)[0];
                let low = kernel::displacement(h, x1, y1)[0];
                let dx = (a as f64 + 0.5) * tile[0] - half[0];
                let dy = (b as f64 + 0.5) * tile[1] - half[1];
                let plane = value + gx * dx + gy * dy;
                let half_plane = 0.5 * (gx.abs() * tile[0] + gy.abs() * tile[1]);
                *worst = worst.max(high - plane + half_plane).max(plane - low + half_plane);
            }
        }
    }
    worst
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_point_between_leaves_the_tangent_plane_by_more_than_the_remainder() {
        let (h, shape, per_cell) = ([0.05, 0.04], [24, 22], 4);
        let p: Vec<f64> = (0..shape[0] * shape[1])
            .map(|k| {
                let (x, y) = ((k % shape[0]) as f64 / 12.0 - 1.0, (k / shape[0]) as f64 / 11.0 - 1.0);
                let smooth = (0.8 - x * x - y * y).max(0.0).sqrt();
                smooth + if k == 300 { 0.7 } else { 0.0 }
            })
            .collect();
        let u = |x: f64, y: f64| {
            let mut sum = [0.0; 3];
            for (k, p) in p.iter().enumerate().filter(|(_, p)| **p > 0.0) {
                let at = [(k % shape[0]) as f64 + 0.5, (k / shape[0]) as f64 + 0.5];
                let value = kernel::displacement(h, x - at[0] * h[0], y - at[1] * h[1]);
                (0..3).for_each(|m| sum[m] += p * value[m]);
            }
            sum
        };
        let lattice = Lattice::new(h, shape);
        let between = Between::new(&lattice, h, shape, per_cell, &p);
        let mut closest = f64::INFINITY;
        for k in 0..60 {
            let cell = [(k * 7) % shape[0], (k * 5) % shape[1]];
            let cell = if k < 20 { [11 + k % 3, 11 + k / 10] } else { cell };
            let sub = [k % 4, (k / 4) % 4];
            let centre = [0, 1].map(|m| (cell[m] as f64 + (sub[m] as f64 + 0.5) / 4.0) * h[m]);
            let bound = between.remainder(&p, cell, sub);
            let [u0, gx, gy] = u(centre[0], centre[1]);
            for s in [-1.0, -0.5, 0.3, 1.0] {
                for t in [-1.0, 0.1, 1.0] {
                    let (dx, dy) = (s * h[0] / 8.0, t * h[1] / 8.0);
                    let off = (u(centre[0] + dx, centre[1] + dy)[0] - u0 - gx * dx - gy * dy).abs();
                    assert!(off <= bound, "{cell:?} {sub:?}: {off} {bound}");
                    closest = closest.min(bound / off.max(1e-9));
                }
            }
        }
        println!("least ratio of bound and distance {closest}");
    }
}

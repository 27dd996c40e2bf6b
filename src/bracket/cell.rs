//! Displacement within the cells of a grid, from that at their centres: the polynomial through these, and sums over the pressures
//! of the cells around.

use super::field::Field;
use super::polynomial::{NODES, Polynomial};
use super::tables::{Points, Squares, Weights};

/// Sums that are taken side by side.
const LANES: usize = 4;

/// The displacement in one cell.
pub(super) struct Cell<'a> {
    field: &'a Field,
    place: [usize; 2],
    /// Its pressure.
    middle: f64,
    /// Rise of the pressure from cell to cell, along x and y.
    trend: [f64; 2],
    polynomial: Polynomial,
}

/// The jumps of the pressure around a cell.
pub(super) struct Jumps {
    near: Vec<f64>,
    /// Bound of what the cells beyond the near block do.
    pub far: f64,
}

impl Field {
    /// What is known of the displacement in cell (i, j) without its details.
    pub fn cell(&self, i: usize, j: usize) -> Cell<'_> {
        let width = self.shape[0] + 2 * NODES;
        let polynomial = Polynomial::through(|a, b| self.wide[(j + b) * width + i + a]);
        let [bx, by] = self.tables.block;
        let row = self.shape[0] + 2 * bx;
        let k = (j + by) * row + i + bx;
        let p = &self.padded;
        let trend = [0.5 * (p[k + 1] - p[k - 1]), 0.5 * (p[k + row] - p[k - row])];
        Cell { field: self, place: [i, j], middle: p[k], trend, polynomial }
    }
}

impl Cell<'_> {
    /// Value and slopes per side of the polynomial at the centre.
    pub fn centre(&self) -> [f64; 3] {
        self.polynomial.at_centre()
    }

    /// The same at the middles of the quarters.
    pub fn quarters(&self) -> [[f64; 3]; 4] {
        self.polynomial.at_quarters()
    }

    /// Its values at the points of a lattice.
    pub fn lattice(&self) -> [f64; 16] {
        self.polynomial.at_lattice()
    }

    /// Largest distance of the polynomial from its tangent planes over squares of this half side.
    pub fn bend(&self, half: f64) -> f64 {
        self.polynomial.bend(half)
    }

    /// Bound of the distance of the displacement from the polynomial, anywhere in the cell, with few sums.
    pub fn left_out_roughly(&self) -> f64 {
        self.bound(&self.field.tables.rough, [0.0; 2])
    }

    /// The same with more of them.
    pub fn left_out(&self) -> f64 {
        self.bound(&self.field.tables.close, [0.0; 2])
    }

    /// The same for what the trend does not explain.
    pub fn left_out_beside_trend(&self) -> f64 {
        self.bound(&self.field.tables.close, self.trend)
    }

    /// Bounds of what the trend does over each quarter.
    pub fn trend_in_quarters(&self) -> [[f64; 2]; 4] {
        let [along, across] = &self.field.tables.trend.quarters;
        let times =
            |by: f64, [low, high]: [f64; 2]| if by < 0.0 { [by * high, by * low] } else { [by * low, by * high] };
        let [a, b] = self.trend.map(|t| t * self.field.scale);
        std::array::from_fn(|k| {
            let (x, y) = (times(a, along[k]), times(b, across[k]));
            [x[0] + y[0], x[1] + y[1]]
        })
    }

    /// What the trend does at the points of the lattice.
    pub fn trend_on_lattice(&self) -> [f64; 16] {
        let [along, across] = &self.field.tables.trend.lattice;
        let [a, b] = self.trend.map(|t| t * self.field.scale);
        std::array::from_fn(|k| a * along[k] + b * across[k])
    }

    /// Bound of what the jumps do, less a trend: those in the block of the weights one by one.
    fn bound(&self, weights: &Weights, [a, b]: [f64; 2]) -> f64 {
        let tables = &self.field.tables;
        let ([i, j], half) = (self.place, weights.half);
        let width = 2 * half[0] + 1;
        // Side by side: sums that do not wait for one another.
        let mut sums = [0.0; LANES];
        let lanes: [f64; LANES] = std::array::from_fn(|k| a * k as f64);
        let mut rise = self.middle - b * half[1] as f64 - a * half[0] as f64;
        for (row, weights) in self.field.rows(i, j, half).zip(weights.each.chunks_exact(width)) {
            let mut start = rise;
            let (chunks, weights_of) = (row.chunks_exact(LANES), weights.chunks_exact(LANES));
            let rest = (chunks.remainder(), weights_of.remainder());
            for (q, w) in chunks.zip(weights_of) {
                (0..LANES).for_each(|k| sums[k] += w[k] * (q[k] - start - lanes[k]).abs());
                start += a * LANES as f64;
            }
            for (k, (q, w)) in rest.0.iter().zip(rest.1).enumerate() {
                sums[k] += w * (q - start - lanes[k]).abs();
            }
            rise += b;
        }
        let jump = self.field.spread[j * self.field.shape[0] + i];
        let rest = weights.rest[0] * jump + weights.rest[1] * a.abs() + weights.rest[2] * b.abs();
        let sum = sums.iter().sum::<f64>() + rest + self.middle * tables.uniform + self.field.most * tables.beyond;
        self.field.scale * sum * (1.0 + 1e-9)
    }

    /// Jumps to the near cells, and what the others do.
    pub fn jumps(&self) -> Jumps {
        let tables = &self.field.tables;
        let [i, j] = self.place;
        let mut near = Vec::with_capacity((2 * tables.near[0] + 1) * (2 * tables.near[1] + 1));
        for row in self.field.rows(i, j, tables.near) {
            near.extend(row.iter().map(|q| q - self.middle));
        }
        // The uniform part counts by values, and by a bound beside them.
        Jumps { near, far: self.bound(&tables.far, [0.0; 2]) }
    }

    /// For each sub-square: value, slopes per side, and the largest distance from that plane over it.
    pub fn squares<'r>(&self, jumps: &Jumps, squares: &Squares, room: &'r mut Vec<[f64; 4]>) -> &'r [[f64; 4]] {
        room.clear();
        let beyond = jumps.far + self.polynomial.bend(squares.half);
        room.extend((0..squares.at.len()).map(|k| self.plane(jumps, squares, k, beyond)));
        room
    }

    /// The same for one of them.
    pub fn square(&self, jumps: &Jumps, squares: &Squares, k: usize) -> [f64; 4] {
        self.plane(jumps, squares, k, jumps.far + self.polynomial.bend(squares.half))
    }

    /// Value, slopes and rest over a sub-square from what the near cells do, and this much beyond them.
    fn plane(&self, jumps: &Jumps, squares: &Squares, k: usize, beyond: f64) -> [f64; 4] {
        let cells = jumps.near.len();
        let mut sums = [[0.0; 4]; LANES];
        let add = |sum: &mut [f64; 4], jump: f64, values: &[f64; 4]| {
            let by = [jump, jump, jump, jump.abs()];
            (0..4).for_each(|m| sum[m] += by[m] * values[m]);
        };
        let (near, values) =
            (jumps.near.chunks_exact(LANES), squares.values[k * cells..(k + 1) * cells].chunks_exact(LANES));
        let rest = near.remainder().iter().zip(values.remainder());
        for (near, values) in near.zip(values) {
            (0..LANES).for_each(|lane| add(&mut sums[lane], near[lane], &values[lane]));
        }
        rest.for_each(|(jump, values)| add(&mut sums[0], *jump, values));
        let of = squares.uniform[k];
        let sum: [f64; 4] =
            std::array::from_fn(|m| (sums[0][m] + sums[1][m]) + (sums[2][m] + sums[3][m]) + self.middle * of[m]);
        let scale = self.field.scale;
        let [p, x, y] = self.polynomial.at(squares.at[k]);
        let rest = scale * sum[3] * (1.0 + 1e-9) + beyond;
        [p + scale * sum[0], x + scale * sum[1], y + scale * sum[2], rest]
    }

    /// Values at points; they leave out no more than [`Jumps::far`].
    pub fn points<'r>(&self, jumps: &Jumps, points: &Points, room: &'r mut Vec<f64>) -> &'r [f64] {
        room.clear();
        room.extend(points.uniform.iter().map(|v| self.middle * v));
        for (jump, values) in jumps.near.iter().zip(points.values.chunks_exact(points.at.len())) {
            room.iter_mut().zip(values).for_each(|(sum, value)| *sum += jump * value);
        }
        for (sum, at) in room.iter_mut().zip(&points.at) {
            *sum = self.polynomial.at(*at)[0] + self.field.scale * *sum;
        }
        room
    }
}

#[cfg(test)]
mod tests {
    use super::super::field::Surroundings;
    use super::super::kernel;
    use super::super::polynomial::LATTICE;
    use super::*;
    use crate::grid::Grid;

    #[test]
    fn no_point_of_a_cell_leaves_its_bounds() {
        for (spacing, per_cell) in [([0.05, 0.05], 4), ([0.05, 0.03], 4), ([0.02, 0.03], 3)] {
            let grid = Grid { origin: [0.0; 2], spacing, shape: [24, 22] };
            let [nx, _] = grid.shape;
            let q: Vec<f64> = (0..grid.len())
                .map(|k| {
                    let (x, y) = ((k % nx) as f64 / 12.0 - 1.0, (k / nx) as f64 / 11.0 - 1.0);
                    let smooth = (0.8 - x * x - y * y).max(0.0).sqrt();
                    smooth + if k == 300 { 0.7 } else { 0.0 }
                })
                .collect();
            let u = |x: f64, y: f64| {
                let loaded = q.iter().enumerate().filter(|(_, q)| **q > 0.0);
                loaded
                    .map(|(k, q)| {
                        let c = grid.centre_of(k);
                        q * kernel::displacement(spacing, x - c[0], y - c[1])[0]
                    })
                    .sum::<f64>()
            };
            let mut around = Surroundings::new(&grid, per_cell);
            let field = Field::new(&mut around, &q);
            let tables = around.tables.clone();
            let mut closest = [f64::INFINITY; 2];
            for k in 0..40 {
                let [i, j] = [(k * 7) % 24, (k * 5) % 22];
                let [i, j] = if k < 20 { [11 + k % 3, 11 + k / 10] } else { [i, j] };
                let cell = field.cell(i, j);
                let left_out = cell.left_out();
                let jumps = cell.jumps();
                let place = |at: [f64; 2]| {
                    let c = grid.centre(i, j);
                    u(c[0] + at[0] * spacing[0], c[1] + at[1] * spacing[1])
                };
                let centre = place([0.0; 2]);
                assert!((field.at_centre(i, j) - centre).abs() <= field.rounding(centre));
                for at in [[0.5, 0.5], [-0.5, 0.2], [0.1, -0.33], [0.48, -0.5], [0.25, 0.25]] {
                    let off = (place(at) - cell.polynomial.at(at)[0]).abs();
                    assert!(off <= left_out, "{i} {j} {at:?}: {off} {left_out}");
                    closest[0] = closest[0].min(left_out / off);
                    assert!(off <= cell.left_out_roughly() && left_out <= cell.left_out_roughly() * (1.0 + 1e-9));
                    let rest = cell.left_out_beside_trend();
                    let quarter = usize::from(at[0] > 0.0) + 2 * usize::from(at[1] > 0.0);
                    let [low, high] = cell.trend_in_quarters()[quarter];
                    let off = place(at) - cell.polynomial.at(at)[0];
                    assert!(low - rest <= off && off <= high + rest, "{i} {j} {at:?}: {off} [{low}, {high}] {rest}");
                }
                for (k, value) in cell.lattice().into_iter().enumerate() {
                    let off = place([LATTICE[k % 4], LATTICE[k / 4]]) - value - cell.trend_on_lattice()[k];
                    assert!(off.abs() <= cell.left_out_beside_trend(), "{i} {j} {k}: {off}");
                }
                let mut room = Vec::new();
                let points = cell.points(&jumps, &tables.points, &mut room);
                for (value, at) in points.iter().zip(&tables.points.at).step_by(3) {
                    let off = (value - place(*at)).abs();
                    assert!(off <= jumps.far + field.rounding(*value), "{i} {j} {at:?}: {off} {}", jumps.far);
                    assert!(jumps.far <= left_out * (1.0 + 1e-6));
                }
                for squares in &tables.squares {
                    let (half, mut room) = (squares.half, Vec::new());
                    let planes = cell.squares(&jumps, squares, &mut room);
                    assert_eq!(planes[3], cell.square(&jumps, squares, 3));
                    for ([value, s, t, rest], middle) in planes.iter().zip(&squares.at).skip(k % 3).step_by(3) {
                        for (a, b) in [(1.0, 1.0), (-1.0, 0.3), (0.0, 0.0), (0.5, -1.0), (-1.0, 1.0)] {
                            let at = [middle[0] + a * half, middle[1] + b * half];
                            let off = (place(at) - value - half * (a * s + b * t)).abs();
                            assert!(off <= rest + field.rounding(*value), "{i} {j} {middle:?}: {off} {rest}");
                            closest[1] = closest[1].min(rest / off.max(1e-9));
                        }
                    }
                }
            }
            println!("least ratio of bound and distance: cell {}, sub-square {}", closest[0], closest[1]);
        }
    }
}

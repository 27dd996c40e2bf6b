//! The gap that is left to a contact by the loads of others, which have displaced the surface.

use std::f64::consts::PI;

use super::contact_loads::{ContactLoads, FULL, ORDERS, angle, at, polynomials};
use crate::gap::{AnyGap, Gap, Known, LeftOpen, Reach};
use crate::grid::Grid;
use crate::numeric::geometry::Rect;

/// The gap within a rectangle, widened by the displacement there under loads outside of it.
#[derive(Clone)]
pub(crate) struct DisplacedGap {
    gap: AnyGap,
    within: Rect,
    /// u = sum of c_ij T_i(x) T_j(y), x and y from -1 to 1 over the rectangle; no loads: order 0.
    coefficients: [[f64; FULL]; FULL],
    order: usize,
}

impl DisplacedGap {
    /// `gap` within the rectangle, displaced by the loads of other contacts: half of its longer side away for all digits.
    pub fn new<'a>(gap: AnyGap, within: Rect, others: impl IntoIterator<Item = &'a ContactLoads>) -> Self {
        // In sides of the rectangle squares stay within the range of numbers.
        let (centre, per) = (within.centre(), 1.0 / within.longer_side());
        let mut near: [Vec<[f64; 3]>; ORDERS.len()] = Default::default();
        for loads in others {
            let Some((level, loads)) = loads.seen_from(&within) else { continue };
            let scaled = |([a, b], q): &([f64; 2], f64)| [(a - centre[0]) * per, (b - centre[1]) * per, q * per / PI];
            near[level].extend(loads.iter().map(scaled));
        }
        let (mut coefficients, mut most) = ([[0.0; FULL]; FULL], 0);
        for (order, near) in ORDERS.into_iter().zip(&near).filter(|(_, near)| !near.is_empty()) {
            most = order;
            let displacement = |i: usize, j: usize| {
                let p = at(&within, [i, j].map(|k| angle(k, order).cos()));
                let [x, y] = [0, 1].map(|m| (p[m] - centre[m]) * per);
                near.iter().map(|[a, b, q]| q / ((x - a) * (x - a) + (y - b) * (y - b)).sqrt()).sum::<f64>()
            };
            let mut values = [[0.0; FULL]; FULL];
            for (i, row) in values.iter_mut().enumerate().take(order) {
                for (j, value) in row.iter_mut().enumerate().take(order) {
                    *value = displacement(i, j);
                }
            }
            // c_ij = (2 - d_i0)(2 - d_j0)/n^2 sum of u_kl cos(i t_k) cos(j t_l).
            let twice = |i: usize| if i == 0 { 1.0 } else { 2.0 };
            let weight = |i: usize, k: usize| twice(i) * (i as f64 * angle(k, order)).cos() / order as f64;
            let weights: [[f64; FULL]; FULL] = std::array::from_fn(|i| std::array::from_fn(|k| weight(i, k)));
            let along = |j: usize, row: &[f64; FULL]| (0..order).map(|l| weights[j][l] * row[l]).sum::<f64>();
            let rows: Vec<[f64; FULL]> = values.iter().map(|row| std::array::from_fn(|j| along(j, row))).collect();
            for (i, row) in coefficients.iter_mut().enumerate().take(order) {
                for (j, c) in row.iter_mut().enumerate().take(order) {
                    *c += (0..order).map(|k| weights[i][k] * rows[k][j]).sum::<f64>();
                }
            }
        }
        Self { gap, within, coefficients, order: most }
    }

    /// What the other loads have pushed the surface away by; outside of the rectangle, as on its border.
    pub fn displacement(&self, p: [f64; 2]) -> f64 {
        self.of(&self.polynomials(0, p[0]), &self.polynomials(1, p[1]))
    }

    /// The same as means over the cells of a grid, x fastest.
    pub fn displacements(&self, grid: &Grid) -> Vec<f64> {
        let [nx, ny] = grid.shape;
        if self.order == 0 {
            return vec![0.0; grid.len()];
        }
        let mean = |m: usize, k: usize| {
            let from = grid.origin[m] + k as f64 * grid.spacing[m];
            self.mean_polynomials(m, [from, from + grid.spacing[m]])
        };
        let along: Vec<[f64; FULL]> = (0..nx).map(|i| mean(0, i)).collect();
        let mut values = Vec::with_capacity(grid.len());
        for j in 0..ny {
            let inner = self.inner(&mean(1, j));
            values.extend(along.iter().map(|t| dot(&inner[..self.order], t)));
        }
        values
    }

    /// sum of c_ij a_i b_j.
    fn of(&self, a: &[f64; FULL], b: &[f64; FULL]) -> f64 {
        dot(&self.inner(b)[..self.order], a)
    }

    /// sum over j of c_ij b_j.
    fn inner(&self, b: &[f64; FULL]) -> [f64; FULL] {
        let mut sums = [0.0; FULL];
        for (sum, row) in sums.iter_mut().zip(&self.coefficients).take(self.order) {
            *sum = dot(&row[..self.order], b);
        }
        sums
    }

    /// T_0, T_1, ... at a coordinate.
    fn polynomials(&self, m: usize, x: f64) -> [f64; FULL] {
        polynomials((2.0 * (x - self.within.centre()[m]) / self.within.size()[m]).clamp(-1.0, 1.0))
    }

    /// Their means from one coordinate to another, by Gauss's two points: the displacement is far smoother than a cell.
    fn mean_polynomials(&self, m: usize, [from, to]: [f64; 2]) -> [f64; FULL] {
        let (middle, g) = (0.5 * (from + to), 0.5 * (to - from) / 3f64.sqrt());
        let [a, b] = [middle - g, middle + g].map(|x| self.polynomials(m, x));
        std::array::from_fn(|i| 0.5 * (a[i] + b[i]))
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

impl Gap for DisplacedGap {
    fn end_of_data(&self, x: f64, y: f64) -> Option<crate::gap::DataEdge> {
        self.gap.end_of_data(x, y)
    }

    fn gap(&self, x: f64, y: f64) -> f64 {
        self.gap.gap(x, y) + self.displacement([x, y])
    }

    fn describe(&self) -> Known {
        let own = self.gap.known();
        let centre = if self.within.contains(own.centre) { own.centre } else { self.within.centre() };
        // The loads push the surface away: the gap is nowhere less than without them.
        Known { centre, reference: own.reference, tips: own.tips.clone(), floor: own.floor, ..Known::nothing() }
    }

    fn reach(&self, _depth: f64) -> Reach {
        Reach::Within(self.within)
    }

    fn is_measured(&self) -> bool {
        self.gap.is_measured()
    }

    fn sampling_error(&self, rect: &Rect) -> f64 {
        self.gap.sampling_error(rect)
    }

    fn left_open(&self, places: &[Rect]) -> Vec<LeftOpen> {
        self.gap.left_open(places)
    }

    fn mean(&self, cell: &Rect) -> f64 {
        if self.order == 0 {
            return self.gap.mean(cell);
        }
        let [along, across] = [0, 1].map(|m| self.mean_polynomials(m, [cell.min[m], cell.max[m]]));
        self.gap.mean(cell) + self.of(&along, &across)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid_method::contact_loads::PointLoads;

    #[test]
    fn the_displacement_of_a_load_half_a_side_away_has_eight_digits() {
        let within = Rect { min: [-1.0, 2.0], max: [3.0, 5.0] };
        let loads = [([-3.0, 2.5], 0.7), ([9.0, 8.0], 2.0), ([1.0, -1.0], 0.3)];
        let flat = AnyGap::new(|_: f64, _: f64| 0.25);
        let each = loads.map(|load| ContactLoads::new(vec![load]));
        let displaced = DisplacedGap::new(flat, within, &each);
        for [x, y] in [[-1.0, 2.0], [0.3, 3.1], [3.0, 2.0], [-0.99, 4.2]] {
            let exact = loads.iter().map(|([a, b], q)| q / f64::hypot(x - a, y - b)).sum::<f64>() / PI;
            assert!((displaced.gap(x, y) - 0.25 - exact).abs() < 1e-8 * exact, "{x} {y}");
        }
        let cell = Rect { min: [0.0, 3.0], max: [0.05, 3.05] };
        let middle = displaced.gap(0.025, 3.025);
        assert!((displaced.mean(&cell) - middle).abs() < 1e-4 * middle);
        let grid = Grid::over(&within, [7, 5]);
        let all = displaced.displacements(&grid);
        for (k, u) in all.iter().enumerate() {
            let mean = displaced.mean(&grid.cell(k % 7, k / 7)) - 0.25;
            assert!((u - mean).abs() < 1e-12 * mean, "{k}: {u} {mean}");
        }
    }

    #[test]
    fn far_loads_are_few_and_displace_the_same() {
        let side = |n: usize| (0..n).map(move |k| -1.0 + (2.0 * k as f64 + 1.0) / n as f64);
        let loads: PointLoads = side(20).flat_map(|x| side(20).map(move |y| ([x, y], 1.0 + x - 0.3 * y * y))).collect();
        let each = [ContactLoads::new(loads.clone())];
        let flat = AnyGap::new(|_: f64, _: f64| 0.0);
        let mut orders = Vec::new();
        for apart in [4.0, 6.0, 12.0, 30.0, 1000.0] {
            for turn in [0.0, 0.4, 0.785] {
                let centre = [apart * f64::cos(turn), apart * f64::sin(turn)];
                let displaced = DisplacedGap::new(flat.clone(), Rect::around(centre, [0.8, 1.0]), &each);
                for corner in [[0.8, 1.0], [-0.8, 1.0], [-0.8, -1.0], [0.1, -0.3]] {
                    let p = [centre[0] + corner[0], centre[1] + corner[1]];
                    let exact = loads.iter().map(|([a, b], q)| q / f64::hypot(p[0] - a, p[1] - b)).sum::<f64>() / PI;
                    let off = displaced.displacement(p) / exact - 1.0;
                    assert!(off.abs() < 1e-9, "{apart} {turn} {corner:?}: {off:e}");
                }
                orders.push(displaced.order);
            }
        }
        assert!(orders.is_sorted_by(|a, b| a >= b) && orders[orders.len() - 1] == ORDERS[0], "{orders:?}");
    }
}

//! The gap that is left to a contact by the loads of others, which have displaced the surface.

use std::f64::consts::PI;

use crate::gap::{AnyGap, Gap, Known, Reach};
use crate::numeric::geometry::Rect;

/// Chebyshev points along a side: enough for ten digits of the displacement by loads half a side away.
const POINTS: usize = 16;

/// Nodes along a side that the loads of one contact are gathered on: their displacement half a side away keeps nine digits, and four a tenth
/// of a side away.
const NODES: usize = 16;

/// The same loads on the Chebyshev nodes of a box around them: for a function f that is smooth over it, sum of q f(p) is that of its
/// interpolant, sum of f(node) sum of q l_node(p). Fewer loads than nodes stay as they are.
pub(crate) fn gathered(loads: Vec<([f64; 2], f64)>) -> Vec<([f64; 2], f64)> {
    let holding = Rect::holding(loads.iter().map(|load| load.0));
    let Some(rect) = holding.filter(|r| loads.len() > NODES * NODES && r.size().iter().all(|s| *s > 0.0)) else {
        return loads;
    };
    let node = |k: usize| (PI * (k as f64 + 0.5) / NODES as f64).cos();
    // l_k(x) = (1 + 2 sum of T_i(x_k) T_i(x))/n.
    let at_nodes: [[f64; NODES]; NODES] = std::array::from_fn(|k| polynomials(node(k)));
    let lagrange = |x: f64| -> [f64; NODES] {
        let t: [f64; NODES] = polynomials(x);
        std::array::from_fn(|k| (1.0 + 2.0 * (1..NODES).map(|i| at_nodes[k][i] * t[i]).sum::<f64>()) / NODES as f64)
    };
    let (centre, size) = (rect.centre(), rect.size());
    let mut sums = [[0.0; NODES]; NODES];
    for (p, q) in &loads {
        let [along, across] = [0, 1].map(|m| lagrange(2.0 * (p[m] - centre[m]) / size[m]));
        for (row, a) in sums.iter_mut().zip(along) {
            for (sum, b) in row.iter_mut().zip(across) {
                *sum += q * a * b;
            }
        }
    }
    let each = |k: usize| (at(&rect, [node(k / NODES), node(k % NODES)]), sums[k / NODES][k % NODES]);
    (0..NODES * NODES).map(each).collect()
}

/// The gap within a rectangle, widened by the displacement there under loads outside of it.
#[derive(Clone)]
pub(crate) struct DisplacedGap {
    gap: AnyGap,
    within: Rect,
    /// u = sum of c_ij T_i(x) T_j(y), x and y from -1 to 1 over the rectangle; no loads: empty.
    coefficients: Vec<[f64; POINTS]>,
}

impl DisplacedGap {
    /// `gap` within the rectangle, displaced point loads (where, force/E*) outside of it: half of its longer side for all digits.
    pub fn new(gap: AnyGap, within: Rect, loads: &[([f64; 2], f64)]) -> Self {
        if loads.is_empty() {
            return Self { gap, within, coefficients: Vec::new() };
        }
        let angle = |k: usize| PI * (k as f64 + 0.5) / POINTS as f64;
        // In sides of the rectangle squares stay within the range of numbers.
        let (centre, size) = (within.centre(), within.size());
        let per = 1.0 / size[0].max(size[1]);
        let near: Vec<[f64; 3]> =
            loads.iter().map(|([a, b], q)| [(a - centre[0]) * per, (b - centre[1]) * per, q * per / PI]).collect();
        let displacement = |i: usize, j: usize| {
            let p = at(&within, [angle(i).cos(), angle(j).cos()]);
            let [x, y] = [0, 1].map(|m| (p[m] - centre[m]) * per);
            near.iter().map(|[a, b, q]| q / ((x - a) * (x - a) + (y - b) * (y - b)).sqrt()).sum::<f64>()
        };
        let mut values = [[0.0; POINTS]; POINTS];
        for (i, row) in values.iter_mut().enumerate() {
            for (j, value) in row.iter_mut().enumerate() {
                *value = displacement(i, j);
            }
        }
        // c_ij = (2 - d_i0)(2 - d_j0)/n^2 sum of u_kl cos(i t_k) cos(j t_l).
        let weight = |i: usize, k: usize| if i == 0 { 1.0 } else { 2.0 } * (i as f64 * angle(k)).cos() / POINTS as f64;
        let along = |j: usize, row: &[f64; POINTS]| (0..POINTS).map(|l| weight(j, l) * row[l]).sum::<f64>();
        let rows: Vec<[f64; POINTS]> = values.iter().map(|row| std::array::from_fn(|j| along(j, row))).collect();
        let coefficient = |i: usize, j: usize| (0..POINTS).map(|k| weight(i, k) * rows[k][j]).sum::<f64>();
        let coefficients = (0..POINTS).map(|i| std::array::from_fn(|j| coefficient(i, j))).collect();
        Self { gap, within, coefficients }
    }

    /// What the other loads have pushed the surface away by; outside of the rectangle, as on its border.
    pub fn displacement(&self, p: [f64; 2]) -> f64 {
        if self.coefficients.is_empty() {
            return 0.0;
        }
        let (centre, size) = (self.within.centre(), self.within.size());
        let [x, y] = [0, 1].map(|m| (2.0 * (p[m] - centre[m]) / size[m]).clamp(-1.0, 1.0));
        let (left, right): ([f64; POINTS], [f64; POINTS]) = (polynomials(x), polynomials(y));
        let inner = |row: &[f64; POINTS]| row.iter().zip(&right).map(|(c, t)| c * t).sum::<f64>();
        self.coefficients.iter().zip(&left).map(|(row, t)| t * inner(row)).sum()
    }
}

/// The point of the rectangle with these coordinates from -1 to 1.
fn at(rect: &Rect, x: [f64; 2]) -> [f64; 2] {
    let (centre, size) = (rect.centre(), rect.size());
    [0, 1].map(|m| centre[m] + 0.5 * size[m] * x[m])
}

/// T_0(x), T_1(x), ...
fn polynomials<const N: usize>(x: f64) -> [f64; N] {
    let (mut next, mut after) = (1.0, x);
    std::array::from_fn(|_| {
        let t = next;
        (next, after) = (after, 2.0 * x * after - next);
        t
    })
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

    fn mean(&self, cell: &Rect) -> f64 {
        // Gauss's two points a side: the displacement is far smoother than a cell.
        let g = 1.0 / 3f64.sqrt();
        let points = [[-g, -g], [-g, g], [g, -g], [g, g]];
        let u = points.map(|x| self.displacement(at(cell, x))).iter().sum::<f64>() / 4.0;
        self.gap.mean(cell) + u
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gathered_loads_displace_as_the_loads_do() {
        let mut state = 7_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let loads: Vec<_> = (0..400).map(|_| ([2.0 * random() - 1.0, random()], random())).collect();
        let few = gathered(loads.clone());
        assert_eq!(few.len(), NODES * NODES);
        let sum =
            |loads: &[([f64; 2], f64)], f: &dyn Fn([f64; 2]) -> f64| loads.iter().map(|(p, q)| q * f(*p)).sum::<f64>();
        for f in [|_: [f64; 2]| 1.0, |p: [f64; 2]| p[0], |p: [f64; 2]| p[1]] {
            assert!((sum(&few, &f) - sum(&loads, &f)).abs() < 1e-10);
        }
        for ([x, y], digits) in [([1.2, 0.5], 1e-4), ([2.2, 0.5], 1e-8), ([5.0, 0.0], 1e-9), ([-1.0, -3.0], 1e-9)] {
            let displacement = |p: [f64; 2]| 1.0 / (p[0] - x).hypot(p[1] - y);
            let (a, b) = (sum(&few, &displacement), sum(&loads, &displacement));
            assert!((a / b - 1.0).abs() < digits, "{x} {y}: {a} {b}");
        }
    }

    #[test]
    fn the_displacement_of_a_load_half_a_side_away_has_eight_digits() {
        let within = Rect { min: [-1.0, 2.0], max: [3.0, 5.0] };
        let loads = [([-3.0, 2.5], 0.7), ([9.0, 8.0], 2.0), ([1.0, -1.0], 0.3)];
        let flat = AnyGap::new(|_: f64, _: f64| 0.25);
        let displaced = DisplacedGap::new(flat, within, &loads);
        for [x, y] in [[-1.0, 2.0], [0.3, 3.1], [3.0, 2.0], [-0.99, 4.2]] {
            let exact = loads.iter().map(|([a, b], q)| q / f64::hypot(x - a, y - b)).sum::<f64>() / PI;
            assert!((displaced.gap(x, y) - 0.25 - exact).abs() < 1e-8 * exact, "{x} {y}");
        }
        let cell = Rect { min: [0.0, 3.0], max: [0.05, 3.05] };
        let middle = displaced.gap(0.025, 3.025);
        assert!((displaced.mean(&cell) - middle).abs() < 1e-4 * middle);
    }
}

//! The gap that is left to a contact by the loads of others, which have displaced the surface.

use std::f64::consts::{PI, SQRT_2};

use crate::gap::{AnyGap, Gap, Known, Reach};
use crate::numeric::geometry::{Rect, distance};

/// Loads at points: where, and the force divided by E*.
pub(crate) type PointLoads = Vec<([f64; 2], f64)>;

/// Nodes along a side of the polynomials that stand for loads, and for what they displace elsewhere.
const ORDERS: [usize; 5] = [4, 6, 8, 12, FULL];

/// The most of them: half a side away the displacement keeps nine digits, and four a tenth of a side away.
const FULL: usize = 16;

/// Relative error of a displacement at which an order is enough.
const DIGITS: f64 = 1e-10;

/// Which of the orders has the fewest nodes for 1/r between these boxes. The interpolant of order n of a function that is analytic
/// within the ellipse of Bernstein of the parameter rho is off by about rho^-n.
fn level_between(a: &Rect, b: &Rect) -> usize {
    let apart = distance(a.centre(), b.centre());
    let half = |of: &Rect| 0.5 * of.longer_side();
    // The nearest singularity, in halves of a side from the centre; a box is at most sqrt 2 times its half side wide.
    let nearest = |of: &Rect, other: &Rect| (apart - half(of) - SQRT_2 * half(other)) / half(of);
    let z = nearest(a, b).min(nearest(b, a));
    let full = ORDERS.len() - 1;
    if z.is_nan() || z <= 1.0 {
        return full;
    }
    let rho = z + (z * z - 1.0).sqrt();
    ORDERS.iter().position(|n| rho.powi(-(*n as i32)) <= DIGITS).unwrap_or(full)
}

/// The loads of one contact, as few as their displacement at a distance asks for.
#[derive(Clone, Default)]
pub(crate) struct ContactLoads {
    around: Option<Rect>,
    /// By orders.
    gathered: [PointLoads; ORDERS.len()],
}

impl ContactLoads {
    /// Those of the cells of a grid.
    pub fn new(loads: PointLoads) -> Self {
        let around = Rect::holding(loads.iter().map(|load| load.0));
        let full = gathered(loads, around.as_ref(), FULL);
        let gathered = ORDERS.map(|n| if n < FULL { gathered(full.clone(), around.as_ref(), n) } else { full.clone() });
        Self { around, gathered }
    }

    /// As many as it takes nearby.
    pub fn iter(&self) -> impl Iterator<Item = &([f64; 2], f64)> {
        self.gathered[ORDERS.len() - 1].iter()
    }

    pub fn total(&self) -> f64 {
        self.iter().map(|load| load.1).sum()
    }
}

/// The same loads on the Chebyshev nodes of the box around them: for a function f that is smooth over it, sum of q f(p) is that of its
/// interpolant, sum of f(node) sum of q l_node(p). Fewer loads than nodes stay as they are.
fn gathered(loads: PointLoads, around: Option<&Rect>, order: usize) -> PointLoads {
    let Some(rect) = around.filter(|r| loads.len() > order * order && r.size().iter().all(|s| *s > 0.0)) else {
        return loads;
    };
    // l_k(x) = (1 + 2 sum of T_i(x_k) T_i(x))/n.
    let at_nodes: Vec<[f64; FULL]> = (0..order).map(|k| polynomials(angle(k, order).cos())).collect();
    let lagrange = |x: f64| -> [f64; FULL] {
        let t: [f64; FULL] = polynomials(x);
        let at = |node: &[f64; FULL]| (1.0 + 2.0 * (1..order).map(|i| node[i] * t[i]).sum::<f64>()) / order as f64;
        std::array::from_fn(|k| at_nodes.get(k).map_or(0.0, at))
    };
    let (centre, size) = (rect.centre(), rect.size());
    let mut sums = [[0.0; FULL]; FULL];
    for (p, q) in &loads {
        let [along, across] = [0, 1].map(|m| lagrange(2.0 * (p[m] - centre[m]) / size[m]));
        for (row, a) in sums.iter_mut().zip(along).take(order) {
            for (sum, b) in row.iter_mut().zip(across) {
                *sum += q * a * b;
            }
        }
    }
    let node = |k: usize| angle(k, order).cos();
    let each = |k: usize| (at(rect, [node(k / order), node(k % order)]), sums[k / order][k % order]);
    (0..order * order).map(each).collect()
}

/// The angle whose cosine is the k-th of n Chebyshev nodes.
fn angle(k: usize, n: usize) -> f64 {
    PI * (k as f64 + 0.5) / n as f64
}

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
            let Some(around) = &loads.around else { continue };
            let k = level_between(&within, around);
            let scaled = |([a, b], q): &([f64; 2], f64)| [(a - centre[0]) * per, (b - centre[1]) * per, q * per / PI];
            near[k].extend(loads.gathered[k].iter().map(scaled));
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
        if self.order == 0 {
            return 0.0;
        }
        let (centre, size) = (self.within.centre(), self.within.size());
        let [x, y] = [0, 1].map(|m| (2.0 * (p[m] - centre[m]) / size[m]).clamp(-1.0, 1.0));
        let (left, right): ([f64; FULL], [f64; FULL]) = (polynomials(x), polynomials(y));
        let inner = |row: &[f64; FULL]| row[..self.order].iter().zip(&right).map(|(c, t)| c * t).sum::<f64>();
        self.coefficients[..self.order].iter().zip(&left).map(|(row, t)| t * inner(row)).sum()
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
        let few: PointLoads = ContactLoads::new(loads.clone()).iter().copied().collect();
        assert_eq!(few.len(), FULL * FULL);
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
        let each = loads.map(|load| ContactLoads::new(vec![load]));
        let displaced = DisplacedGap::new(flat, within, &each);
        for [x, y] in [[-1.0, 2.0], [0.3, 3.1], [3.0, 2.0], [-0.99, 4.2]] {
            let exact = loads.iter().map(|([a, b], q)| q / f64::hypot(x - a, y - b)).sum::<f64>() / PI;
            assert!((displaced.gap(x, y) - 0.25 - exact).abs() < 1e-8 * exact, "{x} {y}");
        }
        let cell = Rect { min: [0.0, 3.0], max: [0.05, 3.05] };
        let middle = displaced.gap(0.025, 3.025);
        assert!((displaced.mean(&cell) - middle).abs() < 1e-4 * middle);
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

//! The loads of one contact, as few as their displacement at a distance asks for.

use std::f64::consts::{PI, SQRT_2};

use crate::numeric::geometry::{Rect, distance};

/// Loads at points: where, and the force divided by E*.
pub(crate) type PointLoads = Vec<([f64; 2], f64)>;

/// Nodes along a side of the polynomials that stand for loads, and for what they displace elsewhere.
pub(super) const ORDERS: [usize; 5] = [4, 6, 8, 12, FULL];

/// The most of them: half a side away the displacement keeps nine digits, and four a tenth of a side away.
pub(super) const FULL: usize = 16;

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

    /// As many as their displacement within a rectangle asks for, and which of the orders they have; `None` without loads.
    pub fn seen_from(&self, within: &Rect) -> Option<(usize, &PointLoads)> {
        let level = level_between(within, self.around.as_ref()?);
        Some((level, &self.gathered[level]))
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
    let (centre, size) = (rect.centre(), rect.size());
    let place = |p: [f64; 2], m: usize| 2.0 * (p[m] - centre[m]) / size[m];
    // Moments sum of q T_i(x) T_j(y), row by row of a grid: those along a row first.
    let mut moments = [[0.0; FULL]; FULL];
    for row in loads.chunk_by(|a, b| a.0[1] == b.0[1]) {
        let mut along = [0.0; FULL];
        for (p, q) in row {
            let t: [f64; FULL] = polynomials(place(*p, 0));
            along.iter_mut().zip(t).for_each(|(sum, t)| *sum += q * t);
        }
        let across: [f64; FULL] = polynomials(place(row[0].0, 1));
        for (sums, a) in moments.iter_mut().zip(along).take(order) {
            sums.iter_mut().zip(across).for_each(|(sum, b)| *sum += a * b);
        }
    }
    // l_k(x) = (1 + 2 sum of T_i(x_k) T_i(x))/n.
    let weights: [[f64; FULL]; FULL] = std::array::from_fn(|k| {
        let t: [f64; FULL] = polynomials(angle(k, order).cos());
        std::array::from_fn(|i| t[i] * if i == 0 { 1.0 } else { 2.0 } / order as f64)
    });
    let half: [[f64; FULL]; FULL] =
        std::array::from_fn(|i| std::array::from_fn(|l| (0..order).map(|j| weights[l][j] * moments[i][j]).sum()));
    let load = |k: usize, l: usize| (0..order).map(|i| weights[k][i] * half[i][l]).sum::<f64>();
    let node = |k: usize| angle(k, order).cos();
    let each = |k: usize| (at(rect, [node(k % order), node(k / order)]), load(k % order, k / order));
    (0..order * order).map(each).collect()
}

/// The angle whose cosine is the k-th of n Chebyshev nodes.
pub(super) fn angle(k: usize, n: usize) -> f64 {
    PI * (k as f64 + 0.5) / n as f64
}

/// The point of the rectangle with these coordinates from -1 to 1.
pub(super) fn at(rect: &Rect, x: [f64; 2]) -> [f64; 2] {
    let (centre, size) = (rect.centre(), rect.size());
    [0, 1].map(|m| centre[m] + 0.5 * size[m] * x[m])
}

/// T_0(x), T_1(x), ...
pub(super) fn polynomials<const N: usize>(x: f64) -> [f64; N] {
    let (mut next, mut after) = (1.0, x);
    std::array::from_fn(|_| {
        let t = next;
        (next, after) = (after, 2.0 * x * after - next);
        t
    })
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
}

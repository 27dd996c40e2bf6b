//! Bounds of the derivatives of many near edges over a subcell that none of them touches (`interpolation` has the inequalities), in vectors.

use super::compliance::Around;
use super::gauss::{B, NODES};
use super::interpolation::{CHOICES, Errors, KAPPA, ROUNDING};
use super::mesh::Point;
use super::subcell::{Hull, NearEdge};

/// Edges are filled up to a multiple of this.
const LANES: usize = 8;

/// Where no edge is: far enough for every bound to vanish, and near enough for its powers.
const NOWHERE: f64 = 1e40;

/// Distances below this count as this: an edge without strength adds nothing.
const LEAST: f64 = 1e-40;

/// Near edges, number by number.
#[derive(Debug, Clone)]
pub(crate) struct EdgeLanes<const K: usize> {
    /// x and y of the first end, of the second one, of the direction; the length.
    geometry: [Vec<f64>; 7],
    /// Without their signs.
    strength: [Vec<f64>; K],
}

impl<const K: usize> EdgeLanes<K> {
    pub fn of(near: &[NearEdge<K>]) -> Self {
        let all = near.len().next_multiple_of(LANES);
        let filled = |f: &dyn Fn(&NearEdge<K>) -> f64, rest: f64| -> Vec<f64> {
            let mut out: Vec<f64> = near.iter().map(f).collect();
            out.resize(all, rest);
            out
        };
        Self {
            geometry: [
                filled(&|e| e.ends[0][0], NOWHERE),
                filled(&|e| e.ends[0][1], NOWHERE),
                filled(&|e| e.ends[1][0], NOWHERE),
                filled(&|e| e.ends[1][1], NOWHERE),
                filled(&|e| e.direction[0], 1.0),
                filled(&|e| e.direction[1], 0.0),
                filled(&|e| e.length, 1.0),
            ],
            strength: std::array::from_fn(|k| filled(&|e| e.strength[k].abs(), 0.0)),
        }
    }
}

/// A subcell as edges see it.
pub(crate) struct Seen<'a> {
    pub hull: &'a Hull,
    pub corners: &'a [Point; 4],
    /// Vectors along s and along t at both ends of the other direction, over the half lengths.
    pub along: [[Point; 2]; 2],
    pub half: [f64; 2],
    /// No Gauss point lies closer to an edge.
    pub inset: f64,
    pub extent: f64,
}

/// Adds the bounds of all edges but those with an index in `except`.
pub(crate) fn add<const K: usize>(edges: &EdgeLanes<K>, except: &[usize], seen: &Seen, out: &mut [Errors; K]) {
    let arch = pulp::Arch::new();
    if except.is_empty() {
        arch.dispatch(Add { edges, strength: &edges.strength, seen, out });
    } else {
        let mut strength = edges.strength.clone();
        strength.iter_mut().for_each(|all| except.iter().for_each(|&index| all[index] = 0.0));
        arch.dispatch(Add { edges, strength: &strength, seen, out });
    }
}

struct Add<'a, const K: usize> {
    edges: &'a EdgeLanes<K>,
    strength: &'a [Vec<f64>; K],
    seen: &'a Seen<'a>,
    out: &'a mut [Errors; K],
}

/// Arithmetic on vectors: closures would not be compiled for the machine that they run on.
#[derive(Clone, Copy)]
struct Vectors<S: pulp::Simd>(S);

impl<S: pulp::Simd> Vectors<S> {
    #[inline(always)]
    fn of(self, x: f64) -> S::f64s {
        self.0.splat_f64s(x)
    }

    #[inline(always)]
    fn times(self, a: S::f64s, b: S::f64s) -> S::f64s {
        self.0.mul_f64s(a, b)
    }

    #[inline(always)]
    fn less(self, a: S::f64s, b: S::f64s) -> S::f64s {
        self.0.sub_f64s(a, b)
    }

    #[inline(always)]
    fn larger(self, a: S::f64s, b: S::f64s) -> S::f64s {
        self.0.max_f64s(a, b)
    }

    #[inline(always)]
    fn smaller(self, a: S::f64s, b: S::f64s) -> S::f64s {
        self.0.min_f64s(a, b)
    }

    /// v . (x, y).
    #[inline(always)]
    fn dot(self, v: Point, x: S::f64s, y: S::f64s) -> S::f64s {
        self.0.mul_add_f64s(self.of(v[0]), x, self.times(self.of(v[1]), y))
    }

    /// |v x (x, y)|.
    #[inline(always)]
    fn turned(self, v: Point, x: S::f64s, y: S::f64s) -> S::f64s {
        self.0.abs_f64s(self.less(self.times(self.of(v[1]), x), self.times(self.of(v[0]), y)))
    }

    /// By how much |x| is larger than h.
    #[inline(always)]
    fn outside(self, x: S::f64s, h: f64) -> S::f64s {
        self.larger(self.less(self.0.abs_f64s(x), self.of(h)), self.of(0.0))
    }

    /// By how much the interval between a and b lies outside of that from -h to h.
    #[inline(always)]
    fn apart(self, a: S::f64s, b: S::f64s, h: f64) -> S::f64s {
        let (low, high) = (self.smaller(a, b), self.0.neg_f64s(self.larger(a, b)));
        self.larger(self.less(self.larger(low, high), self.of(h)), self.of(0.0))
    }

    /// No more than the length of (x, y), x and y >= 0.
    #[inline(always)]
    fn length(self, x: S::f64s, y: S::f64s) -> S::f64s {
        let mean = self.times(self.of(std::f64::consts::FRAC_1_SQRT_2), self.0.add_f64s(x, y));
        self.larger(self.larger(x, y), mean)
    }
}

impl<const K: usize> pulp::WithSimd for Add<'_, K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        let Self { edges, strength, seen, out } = self;
        let Seen { hull, corners, along, half, inset, extent } = *seen;
        let Around { centre, axis, half: box_half, .. } = hull.around;
        let across = [-axis[1], axis[0]];
        let v = Vectors(simd);
        let (zero, one, infinite) = (v.of(0.0), v.of(1.0), v.of(f64::INFINITY));
        let [x0, y0, x1, y1, tx, ty, lengths] = &edges.geometry;
        let (x0, y0) = (S::as_simd_f64s(x0).0, S::as_simd_f64s(y0).0);
        let (x1, y1) = (S::as_simd_f64s(x1).0, S::as_simd_f64s(y1).0);
        let (tx, ty, lengths) = (S::as_simd_f64s(tx).0, S::as_simd_f64s(ty).0, S::as_simd_f64s(lengths).0);
        let mut slope = [[[zero; CHOICES]; 2]; K];
        let mut value = [[[zero; CHOICES]; 2]; K];
        let mut fixed = [zero; K];
        for n in 0..x0.len() {
            let (tx, ty, length) = (tx[n], ty[n], lengths[n]);
            // Distances of the ends, and of the edge, by lines that separate it.
            let (dx0, dy0) = (v.less(x0[n], v.of(centre[0])), v.less(y0[n], v.of(centre[1])));
            let (dx1, dy1) = (v.less(x1[n], v.of(centre[0])), v.less(y1[n], v.of(centre[1])));
            let (u0, w0) = (v.dot(axis, dx0, dy0), v.dot(across, dx0, dy0));
            let (u1, w1) = (v.dot(axis, dx1, dy1), v.dot(across, dx1, dy1));
            let mut r0 = v.length(v.outside(u0, box_half[0]), v.outside(w0, box_half[1]));
            let mut r1 = v.length(v.outside(u1, box_half[0]), v.outside(w1, box_half[1]));
            let mut delta = v.length(v.apart(u0, u1, box_half[0]), v.apart(w0, w1, box_half[1]));
            for (normal, c) in &hull.sides {
                let off0 = v.less(v.dot(*normal, x0[n], y0[n]), v.of(*c));
                let off1 = v.less(v.dot(*normal, x1[n], y1[n]), v.of(*c));
                (r0, r1) = (v.larger(r0, off0), v.larger(r1, off1));
                delta = v.larger(delta, v.smaller(off0, off1));
            }
            // Signed distances and abscissae of the corners.
            let (mut low, mut high) = (infinite, simd.neg_f64s(infinite));
            let (mut first, mut last) = (low, high);
            for c in corners {
                let (dx, dy) = (v.less(v.of(c[0]), x0[n]), v.less(v.of(c[1]), y0[n]));
                let d = v.less(v.times(tx, dy), v.times(ty, dx));
                let a = simd.mul_add_f64s(tx, dx, v.times(ty, dy));
                (low, high) = (v.smaller(low, d), v.larger(high, d));
                (first, last) = (v.smaller(first, a), v.larger(last, a));
            }
            let line = v.larger(v.larger(low, simd.neg_f64s(high)), zero);
            delta = v.larger(delta, line);
            let least = v.of(LEAST);
            let (i0, i1) = (simd.div_f64s(one, v.larger(r0, least)), simd.div_f64s(one, v.larger(r1, least)));
            let (i2, i3) = (simd.div_f64s(one, v.larger(delta, least)), simd.div_f64s(one, v.larger(line, least)));
            let beside = simd.or_m64s(simd.greater_than_f64s(first, length), simd.less_than_f64s(last, zero));
            let on_line = simd.equal_f64s(line, zero);
            let long = v.times(length, i2);
            let (mut lean, mut logarithmic) = ([zero; 2], [zero; 2]);
            for k in 0..2 {
                lean[k] = v.larger(v.turned(along[k][0], tx, ty), v.turned(along[k][1], tx, ty));
                let inside = simd.select_f64s_m64s(on_line, i3, v.times(lean[k], i3));
                logarithmic[k] = simd.select_f64s_m64s(beside, zero, inside);
            }
            // Over h^m.
            let (mut e0, mut e1, mut e2) = (i0, i1, i2);
            let mut lines = logarithmic;
            let mut before = [zero; 2];
            for m in 1..=NODES[1] {
                if m > 1 {
                    (e0, e1, e2) = (v.times(e0, i0), v.times(e1, i1), v.times(e2, i2));
                    lines = [v.times(lines[0], logarithmic[0]), v.times(lines[1], logarithmic[1])];
                }
                let ends = v.times(v.of(B[m]), simd.add_f64s(e0, e1));
                let plain = v.times(e2, v.smaller(long, v.of(2.0 * B[m])));
                for k in 0..2 {
                    let term = v.smaller(simd.mul_add_f64s(v.of(2.0 / m as f64), lines[k], ends), plain);
                    if m >= NODES[0] {
                        let i = m - NODES[0];
                        let bent = v.times(lean[k], before[k]);
                        for j in 0..K {
                            let c = S::as_simd_f64s(&strength[j]).0[n];
                            slope[j][k][i] = simd.mul_add_f64s(c, term, slope[j][k][i]);
                            value[j][k][i] = simd.mul_add_f64s(c, bent, value[j][k][i]);
                        }
                    }
                    before[k] = term;
                }
            }
            let rounding = v.smaller(v.times(v.of(extent), i2), v.of(extent / inset));
            let rounding = simd.add_f64s(v.of(60.0), rounding);
            for j in 0..K {
                fixed[j] = simd.mul_add_f64s(S::as_simd_f64s(&strength[j]).0[n], rounding, fixed[j]);
            }
        }
        for j in 0..K {
            for k in 0..2 {
                for i in 0..CHOICES {
                    let m = i + NODES[0];
                    let power = KAPPA[m] * half[k].powi(m as i32);
                    out[j].slope[k][i] += power * simd.reduce_sum_f64s(slope[j][k][i]);
                    out[j].value[k][i] += power / m as f64 * simd.reduce_sum_f64s(value[j][k][i]);
                }
            }
            out[j].fixed[0] += ROUNDING * simd.reduce_sum_f64s(fixed[j]);
        }
    }
}

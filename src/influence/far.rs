//! Cells that are far in one direction or in both: Gauss rules and the series of 1/r.
//!
//! The coefficient is h_x h_y / pi times the mean of 1/r under a weight: the box |s| < h/2 of the loaded cell
//! (collocation) or the hat 1 - |s|/h of a pair of cells (Galerkin), in each direction.
//! Seen from a distance d, a direction of step h needs a Gauss rule of n points with error about (h/2d)^(2n).

use crate::grid::Kernel;

/// Distance, in steps, from which a direction is integrated by a Gauss rule.
pub(super) const GAUSS: f64 = 4.0;

/// Distance, in longest steps, from which the series to h^10 holds.
pub(super) const SERIES: f64 = 12.0;

/// Distance, in longest steps, from which the series to h^4 holds.
const SHORT_SERIES: f64 = 256.0;

/// Order of the series: terms to (h/r)^(2 ORDER).
const ORDER: usize = 5;

/// Nodes and weights for s > 0 of the even rules on the box |s| < 1/2, from `data/reference/influence.py rules`.
const BOX: [&[(f64, f64)]; 4] = [
    &[(0.288_675_134_594_812_9, 0.5)],
    &[(0.169_990_521_792_428_13, 0.326_072_577_431_273_07), (0.430_568_155_797_026_3, 0.173_927_422_568_726_93)],
    &[
        (0.119_309_593_041_598_45, 0.233_956_967_286_345_52),
        (0.330_604_693_233_132_26, 0.180_380_786_524_069_3),
        (0.466_234_757_101_576, 0.085_662_246_189_585_17),
    ],
    &[
        (0.091_717_321_247_824_9, 0.181_341_891_689_181),
        (0.262_766_204_958_164_5, 0.156_853_322_938_943_64),
        (0.398_333_238_706_813_4, 0.111_190_517_226_687_24),
        (0.480_144_928_248_768_1, 0.050_614_268_145_188_13),
    ],
];

/// The same for the hat 1 - |s|.
const HAT: [&[(f64, f64)]; 4] = [
    &[(0.408_248_290_463_863, 0.5)],
    &[(0.262_229_842_652_747_96, 0.401_133_695_420_124_37), (0.750_925_143_304_447_4, 0.098_866_304_579_875_63)],
    &[
        (0.194_263_676_775_038_9, 0.323_022_204_639_417_8),
        (0.576_614_808_248_487_3, 0.147_481_233_705_272_85),
        (0.865_738_294_978_819_1, 0.029_496_561_655_309_35),
    ],
    &[
        (0.154_629_080_840_261_13, 0.268_613_731_611_040_4),
        (0.464_700_844_889_638_97, 0.157_584_233_713_380_4),
        (0.730_126_110_448_886_2, 0.062_272_586_069_543_36),
        (0.916_498_601_781_823_4, 0.011_529_448_606_035_85),
    ],
];

/// The rule for a distance of `d` steps, at least [`GAUSS`]: (h/2d)^(2n) stays below 4e-15.
fn rule(kernel: Kernel, d: f64) -> &'static [(f64, f64)] {
    let rules = match kernel {
        Kernel::Galerkin => &HAT,
        Kernel::Collocation => &BOX,
    };
    match d {
        _ if d >= 2048.0 => rules[0],
        _ if d >= 32.0 => rules[1],
        _ if d >= 8.0 => rules[2],
        _ => rules[3],
    }
}

/// Far in both directions: tensor Gauss rule. Not divided by pi.
pub(super) fn both(kernel: Kernel, h: [f64; 2], at: [f64; 2]) -> f64 {
    let r = at[0].hypot(at[1]);
    let (rule_x, rule_y) = (rule(kernel, r / h[0]), rule(kernel, r / h[1]));
    let mut mean = 0.0;
    for &(s, v) in rule_x {
        let (left, right) = ((at[0] - s * h[0]).powi(2), (at[0] + s * h[0]).powi(2));
        for &(t, w) in rule_y {
            let (down, up) = ((at[1] - t * h[1]).powi(2), (at[1] + t * h[1]).powi(2));
            mean += v
                * w
                * (1.0 / (left + down).sqrt()
                    + 1.0 / (right + down).sqrt()
                    + 1.0 / (left + up).sqrt()
                    + 1.0 / (right + up).sqrt());
        }
    }
    mean * h[0] * h[1]
}

/// Near along x, where the step is the longer one, and far along y: closed form of the line integral, Gauss across.
/// `offset` along x in steps, not negative; `d`: distance to the nearest singular line, in steps of y. Not divided by pi.
pub(super) fn across(kernel: Kernel, h: [f64; 2], offset: [i64; 2], d: f64) -> f64 {
    let (i, y) = (offset[0] as f64, offset[1] as f64 * h[1]);
    let line = |y: f64| match kernel {
        Kernel::Galerkin => hat_line(h[0], i, y) / h[0],
        Kernel::Collocation => box_line(h[0], i, y),
    };
    let mean: f64 = rule(kernel, d).iter().map(|&(t, w)| w * (line(y - t * h[1]) + line(y + t * h[1]))).sum();
    mean * h[1]
}

/// Integral of 1/r over a step `h` at `i` steps: difference of asinh(x/|y|), for i > 0 as the logarithm of a quotient.
fn box_line(h: f64, i: f64, y: f64) -> f64 {
    if i == 0.0 {
        return 2.0 * (0.5 * h / y.abs()).asinh();
    }
    let (near, far) = ((i - 0.5) * h, (i + 0.5) * h);
    ((far + far.hypot(y)) / (near + near.hypot(y))).ln()
}

/// Integral of (h - |s|)/r: second difference of g = x asinh(x/|y|) - r. For i > 0 the part of g linear in x is
/// left out: g = x ln((x + r)/h) - r, which stays finite on y = 0.
fn hat_line(h: f64, i: f64, y: f64) -> f64 {
    if i == 0.0 {
        return 2.0 * (h * (h / y.abs()).asinh() - h * h / (h.hypot(y) + y.abs()));
    }
    let g = |steps: f64| {
        let (x, r) = (steps * h, (steps * h).hypot(y));
        if steps == 0.0 { -r } else { x * ((x + r) / h).ln() - r }
    };
    g(i + 1.0) - 2.0 * g(i) + g(i - 1.0)
}

/// The mean of 1/r far from the cell as a series, 1/r (1 + sum over k of P_k(x^2/r^2)/r^(2k)).
#[derive(Debug, Clone)]
pub(super) struct Series {
    area: f64,
    /// P_1 to P_ORDER; degree k in x^2/r^2, lowest first.
    terms: [[f64; ORDER + 1]; ORDER],
}

impl Series {
    /// P_k = sum over a + b = k of m_a m_b h_x^2a h_y^2b D_ab with the moments m of the weight and
    /// D_ab = r^(2k+1) d^2k (1/r) / dx^2a dy^2b.
    pub(super) fn new(kernel: Kernel, h: [f64; 2]) -> Self {
        let moment = |a: usize| {
            let a = a as i32;
            let factorial = |n: i32| (1..=n).map(f64::from).product::<f64>();
            match kernel {
                Kernel::Galerkin => 2.0 / factorial(2 * a + 2),
                Kernel::Collocation => 0.25_f64.powi(a) / factorial(2 * a + 1),
            }
        };
        let mut terms = [[0.0; ORDER + 1]; ORDER];
        for (k, term) in (1..).zip(terms.iter_mut()) {
            for a in 0..=k {
                let b = k - a;
                let weight = moment(a) * moment(b) * h[0].powi(2 * a as i32) * h[1].powi(2 * b as i32);
                for (t, d) in term.iter_mut().zip(derivative(a, b)) {
                    *t += weight * d;
                }
            }
        }
        Self { area: h[0] * h[1], terms }
    }

    /// At least [`SERIES`] longest steps away. Not divided by pi.
    #[inline]
    pub(super) fn value(&self, x: f64, y: f64) -> f64 {
        self.to_order::<ORDER>(x, y)
    }

    /// Every offset of a row x = 0, h_x, ... from column `first` on.
    pub(super) fn row(&self, h: [f64; 2], y: f64, first: usize, row: &mut [f64], scale: f64) {
        let longest = h[0].max(h[1]);
        let far = SHORT_SERIES * longest;
        let short = if y >= far { 0 } else { ((far * far - y * y).sqrt() / h[0]).ceil() as usize };
        for (i, value) in row.iter_mut().enumerate().take(short).skip(first) {
            *value = scale * self.to_order::<ORDER>(i as f64 * h[0], y);
        }
        for (i, value) in row.iter_mut().enumerate().skip(short.max(first)) {
            *value = scale * self.to_order::<2>(i as f64 * h[0], y);
        }
    }

    #[inline]
    fn to_order<const K: usize>(&self, x: f64, y: f64) -> f64 {
        let x2 = x * x;
        let q = 1.0 / (x2 + y * y);
        let u = x2 * q;
        let mut sum = 0.0;
        for k in (0..K).rev() {
            let mut p = 0.0;
            for c in (0..=k + 1).rev() {
                p = p * u + self.terms[k][c];
            }
            sum = (sum + p) * q;
        }
        self.area * q.sqrt() * (1.0 + sum)
    }
}

/// r^(2k+1) d^2k (1/r) / dx^2a dy^2b, k = a + b, as a polynomial in u = x^2/r^2.
///
/// With 1/r differentiated n times equal to Q(x, y)/r^(2n+1), the next derivative has Q_x r^2 - (2n + 1) x Q.
fn derivative(a: usize, b: usize) -> [f64; ORDER + 1] {
    // q[i]: coefficient of x^i y^(n-i).
    let mut q = vec![1.0];
    for n in 0..2 * (a + b) {
        let mut next = vec![0.0; n + 2];
        for (i, &c) in q.iter().enumerate() {
            let (i_, j_, m) = (i as f64, (n - i) as f64, (2 * n + 1) as f64);
            if n < 2 * a {
                // x-derivative of x^i y^j: i x^(i-1) y^j (x^2 + y^2) - m x^(i+1) y^j.
                next[i + 1] += c * (i_ - m);
                if i > 0 {
                    next[i - 1] += c * i_;
                }
            } else {
                next[i] += c * (j_ - m);
                if n > i {
                    next[i + 2] += c * j_;
                }
            }
        }
        q = next;
    }
    // Only even powers are left: x^2i y^2(k-i) / r^2k = u^i (1 - u)^(k-i).
    let k = a + b;
    let mut polynomial = [0.0; ORDER + 1];
    for i in 0..=k {
        let mut binomial = 1.0;
        for l in 0..=k - i {
            polynomial[i + l] += q[2 * i] * binomial;
            binomial *= -((k - i - l) as f64) / (l + 1) as f64;
        }
    }
    polynomial
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_obey_the_laplace_like_law_of_the_plane() {
        // d^2/dy^2 (1/r) = (2 y^2 - x^2)/r^5 = (2 - 3u)/r^3.
        assert_eq!(derivative(0, 1)[..2], [2.0, -3.0]);
        assert_eq!(derivative(1, 0)[..2], [-1.0, 3.0]);
        // d^4/dx^4 (1/r) = 4! P_4(x/r)/r^5.
        let u: f64 = 0.3;
        let value: f64 = derivative(2, 0).iter().enumerate().map(|(k, c)| c * u.powi(k as i32)).sum();
        assert!((value - 3.0 * (35.0 * u * u - 30.0 * u + 3.0)).abs() < 1e-12);
    }

    #[test]
    fn rules_integrate_one() {
        for rule in BOX.iter().chain(&HAT) {
            assert!((2.0 * rule.iter().map(|(_, w)| w).sum::<f64>() - 1.0).abs() < 1e-15);
        }
    }
}

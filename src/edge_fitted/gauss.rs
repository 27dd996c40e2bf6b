//! Gauss-Legendre rules, interpolation between their nodes, and rules for integrands with ln t and ln^2 t.

use std::sync::OnceLock;

use crate::numeric::quadrature::GaussLegendre;

/// The most nodes of a rule.
pub(crate) const MOST: usize = 12;

/// Nodes on [-1, 1] and weights of the Gauss-Legendre rule with `n` nodes (1 <= n <= 12).
pub(crate) fn legendre(n: usize) -> &'static (Vec<f64>, Vec<f64>) {
    static RULES: OnceLock<Vec<(Vec<f64>, Vec<f64>)>> = OnceLock::new();
    &RULES.get_or_init(|| (0..=MOST).map(|n| GaussLegendre::new(n).nodes().iter().copied().unzip()).collect())
        [n.min(MOST)]
}

/// The values at `x` of the Lagrange polynomials of `nodes`.
pub(crate) fn lagrange(nodes: &[f64], x: f64) -> Vec<f64> {
    (0..nodes.len())
        .map(|i| (0..nodes.len()).filter(|&j| j != i).map(|j| (x - nodes[j]) / (nodes[i] - nodes[j])).product())
        .collect()
}

/// kappa_m: the root mean square over [-1, 1] of the monic Legendre polynomial of degree m. |g - I g|, in the same mean
/// and for interpolation at the m Gauss nodes, is at most kappa_m sup |g^(m)|/m!.
pub(crate) fn kappa(m: usize) -> f64 {
    let mut lead = 1.0;
    // 2^m (m!)^2/(2m)! = prod 2k/(m + k).
    for k in 1..=m {
        lead *= 2.0 * k as f64 / (m + k) as f64;
    }
    lead / ((2 * m + 1) as f64).sqrt()
}

/// The largest value on [-1, 1] of the monic Legendre polynomial of degree m over its root mean square: both ends have it.
pub(crate) fn monic_size(m: usize) -> f64 {
    ((2 * m + 1) as f64).sqrt()
}

/// What 2 to 5 Gauss nodes may raise values by in their interpolant, rounded up (a test repeats it).
pub(crate) const LEBESGUE: [f64; 4] = [1.7321, 2.3334, 2.8552, 3.3223];

/// A bound of the root mean square over [0, 1] of t ln t less its interpolant at `m` Gauss nodes, 2 <= m <= 5: computed to
/// six digits (a test repeats it), rounded up.
pub(crate) fn logarithm_error(m: usize) -> f64 {
    [0.099_2, 0.025_9, 0.010_75, 0.005_54][m - 2]
}

/// B_m = int_0^inf (1 + x^2)^(-(m+1)/2) dx for m = 1 .. 9: B_(m+2) = B_m m/(m + 1).
pub(crate) const B: [f64; 10] = [
    f64::INFINITY,
    std::f64::consts::FRAC_PI_2,
    1.0,
    std::f64::consts::FRAC_PI_4,
    2.0 / 3.0,
    3.0 * std::f64::consts::PI / 16.0,
    8.0 / 15.0,
    15.0 * std::f64::consts::PI / 96.0,
    16.0 / 35.0,
    105.0 * std::f64::consts::PI / 768.0,
];

/// The quadrature of one direction of a subcell: fields are known at `m` Gauss nodes; squares of their interpolants, with
/// polynomial weights and with a logarithm added where the subcell touches an edge, are summed at other points.
#[derive(Debug)]
pub(crate) struct Rule {
    /// Its points, [`LANES`] at a time; the last one is repeated without weight.
    pub lanes: Vec<RulePoints>,
    /// An end touches.
    pub logarithmic: bool,
}

/// Points of a rule that are summed together.
pub(crate) const LANES: usize = 4;

/// Some points of a rule.
#[derive(Debug)]
pub(crate) struct RulePoints {
    /// On [-1, 1].
    pub points: [f64; LANES],
    /// Their weights.
    pub weights: [f64; LANES],
    /// ln t at the points, t = (1 + x)/2 or (1 - x)/2 from the end that touches; zero where none does.
    pub logarithm: [f64; LANES],
    /// The Lagrange polynomial of every node; zero beyond the m nodes.
    pub lagrange: [[f64; LANES]; NODES[1]],
}

/// Which end of a direction lies on an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Touch {
    /// Neither.
    None,
    /// The end at -1.
    Low,
    /// The end at +1.
    High,
}

/// The fewest and the most interpolation nodes of a direction.
pub(crate) const NODES: [usize; 2] = [2, 5];

/// What the sums of a logarithmic rule may be short of the integral of the square of (polynomial + c ln t) times a
/// non-negative polynomial weight: a test compares the two quadratic forms by closed moments.
pub(crate) const LOGARITHMIC_SLACK: f64 = 1e-3;

/// The rule for `m` nodes; exact for the squares of the interpolants times weights of degree 3 (times one more factor of
/// degree 1 squared), within [`LOGARITHMIC_SLACK`] where an end touches.
pub(crate) fn rule(m: usize, touch: Touch) -> &'static Rule {
    static RULES: OnceLock<Vec<Rule>> = OnceLock::new();
    let all = RULES.get_or_init(|| {
        let mut all = Vec::new();
        for m in NODES[0]..=NODES[1] {
            for touch in [Touch::None, Touch::Low, Touch::High] {
                all.push(make_rule(m, touch));
            }
        }
        all
    });
    let side = match touch {
        Touch::None => 0,
        Touch::Low => 1,
        Touch::High => 2,
    };
    &all[3 * (m - NODES[0]) + side]
}

fn make_rule(m: usize, touch: Touch) -> Rule {
    let nodes = &legendre(m).0;
    let mut parts = Vec::new();
    if touch == Touch::None {
        let (x, w) = legendre(m + 3);
        parts.extend(x.iter().zip(w).map(|(&x, &w)| (0.5 * (1.0 + x), 0.5 * w)));
    } else {
        // t in [0, 1/16] as 1/16 tau^4, then [1/16, 1/4] and [1/4, 1].
        let (x, w) = legendre(8);
        for (x, w) in x.iter().zip(w) {
            let tau = 0.5 * (1.0 + x);
            parts.push((tau.powi(4) / 16.0, 0.5 * w * 4.0 * tau.powi(3) / 16.0));
        }
        for (a, b, n) in [(1.0 / 16.0, 0.25, 6), (0.25, 1.0, m + 4)] {
            let (x, w) = legendre(n);
            parts.extend(x.iter().zip(w).map(|(&x, &w)| (a + 0.5 * (b - a) * (1.0 + x), 0.5 * (b - a) * w)));
        }
    }
    let sign = if touch == Touch::High { -1.0 } else { 1.0 };
    let lanes = parts.chunks(LANES).map(|parts| {
        let mut some = RulePoints {
            points: [0.0; LANES],
            weights: [0.0; LANES],
            logarithm: [0.0; LANES],
            lagrange: [[0.0; LANES]; 5],
        };
        for l in 0..LANES {
            let (t, weight) = parts.get(l).copied().unwrap_or((parts[parts.len() - 1].0, 0.0));
            let x = sign * (2.0 * t - 1.0);
            some.points[l] = x;
            some.weights[l] = 2.0 * weight;
            some.logarithm[l] = if touch == Touch::None { 0.0 } else { t.ln() };
            for (row, value) in some.lagrange.iter_mut().zip(lagrange(nodes, x)) {
                row[l] = value;
            }
        }
        some
    });
    Rule { lanes: lanes.collect(), logarithmic: touch != Touch::None }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gauss_integrates_polynomials() {
        for n in 1..=MOST {
            let (x, w) = legendre(n);
            for k in 0..2 * n {
                let sum: f64 = x.iter().zip(w).map(|(x, w)| w * x.powi(k as i32)).sum();
                let exact = if k % 2 == 0 { 2.0 / (k + 1) as f64 } else { 0.0 };
                assert!((sum - exact).abs() < 1e-14, "{n} {k}");
            }
        }
    }

    #[test]
    fn interpolation_error_is_within_kappa() {
        for m in 1..=6 {
            let nodes = &legendre(m).0;
            let (x, w) = legendre(12);
            // The extremal function x^m: the bound is reached.
            let mean: f64 = x
                .iter()
                .zip(w)
                .map(|(&x, w)| {
                    let value: f64 = lagrange(nodes, x).iter().zip(nodes).map(|(l, n)| l * n.powi(m as i32)).sum();
                    0.5 * w * (x.powi(m as i32) - value).powi(2)
                })
                .sum();
            assert!((mean.sqrt() / kappa(m) - 1.0).abs() < 1e-10, "{m}");
        }
    }

    #[test]
    fn logarithm_errors() {
        for m in 2..=5 {
            let nodes = &legendre(m).0;
            let (x, w) = legendre(12);
            let (mut mean, mut supremum) = (0.0, 0.0_f64);
            for k in 0..60 {
                let (a, b) = (if k == 59 { 0.0 } else { 0.7f64.powi(k + 1) }, 0.7f64.powi(k));
                for (x, w) in x.iter().zip(w) {
                    let t = a + 0.5 * (b - a) * (1.0 + x);
                    let basis = lagrange(nodes, 2.0 * t - 1.0);
                    let value: f64 =
                        basis.iter().zip(nodes).map(|(l, n)| l * 0.5 * (1.0 + n) * (0.5 * (1.0 + n)).ln()).sum();
                    mean += 0.5 * (b - a) * w * (t * t.ln() - value).powi(2);
                    supremum = supremum.max((t * t.ln() - value).abs());
                }
            }
            // What `residual_norm` takes as the ratio of supremum and mean square.
            assert!(supremum < 10.0 * logarithm_error(m));
            let exact = mean.sqrt();
            assert!(exact <= logarithm_error(m) && logarithm_error(m) < 1.02 * exact, "{m} {exact}");
        }
    }

    /// Whether factor * q - e is positive definite, by elimination.
    fn dominated(e: &[Vec<f64>], q: &[Vec<f64>], factor: f64) -> bool {
        let n = e.len();
        let mut a: Vec<Vec<f64>> = (0..n).map(|i| (0..n).map(|j| factor * q[i][j] - e[i][j]).collect()).collect();
        for k in 0..n {
            if a[k][k] <= 0.0 {
                return false;
            }
            for i in k + 1..n {
                let l = a[i][k] / a[k][k];
                for j in k..n {
                    let pivot = a[k][j];
                    a[i][j] -= l * pivot;
                }
            }
        }
        true
    }

    #[test]
    fn logarithmic_rules_dominate_the_integral() {
        // Basis: 1, t, ..., t^m, ln t, t ln t (a linear factor of the fade is included); weights (1-t)^a t^b, a + b = 3.
        for m in NODES[0]..=NODES[1] {
            let rule = rule(m, Touch::Low);
            let moment = |k: usize, l: usize| -> f64 {
                // int t^k ln^l t = (-1)^l l!/(k+1)^(l+1).
                let sign = if l.is_multiple_of(2) { 1.0 } else { -1.0 };
                let factorial: usize = (1..=l).product();
                sign * factorial as f64 / ((k + 1) as f64).powi(l as i32 + 1)
            };
            let basis: Vec<(usize, usize)> = (0..=m.max(3)).map(|k| (k, 0)).chain([(0, 1), (1, 1)]).collect();
            for b in 0..=3_usize {
                let a = 3 - b;
                let binomial = |i: usize| -> f64 {
                    let sign = if i.is_multiple_of(2) { 1.0 } else { -1.0 };
                    sign * (0..i).map(|k| (a - k) as f64 / (k + 1) as f64).product::<f64>()
                };
                let exact: Vec<Vec<f64>> = basis
                    .iter()
                    .map(|p| {
                        basis
                            .iter()
                            .map(|q| (0..=a).map(|i| binomial(i) * moment(p.0 + q.0 + b + i, p.1 + q.1)).sum())
                            .collect()
                    })
                    .collect();
                let points = rule.lanes.iter().flat_map(|some| (0..LANES).map(move |l| (some, l)));
                let sum = |p: &(usize, usize), q: &(usize, usize)| -> f64 {
                    let product = |(some, l): (&RulePoints, usize)| {
                        let (t, log) = (0.5 * (1.0 + some.points[l]), some.logarithm[l]);
                        let weight = 0.5 * some.weights[l] * (1.0 - t).powi(a as i32) * t.powi(b as i32);
                        weight * t.powi((p.0 + q.0) as i32) * log.powi((p.1 + q.1) as i32)
                    };
                    points.clone().map(product).sum()
                };
                let sums: Vec<Vec<f64>> = basis.iter().map(|p| basis.iter().map(|q| sum(p, q)).collect()).collect();
                assert!(dominated(&exact, &sums, 1.0 + LOGARITHMIC_SLACK), "m {m} weight {a} {b}");
            }
        }
    }
}

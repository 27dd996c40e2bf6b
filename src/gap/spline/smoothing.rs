//! Smoothing splines: the curve of least curvature whose mean square distance from the measured values is that of the noise.
//!
//! C. H. Reinsch, *Numer. Math.* 10 (1967) 177, equations (4) and (8): minimise the integral of f''^2 under sum (f(x_i) - z_i)^2 <= n s^2.
//! In the form of P. J. Green & B. W. Silverman, *Nonparametric Regression* (1994), section 2.3: (R + a Q^T Q) g = Q^T z, f = z - a Q g.
//! Maps are smoothed along rows, then columns, by one parameter (tensor product). What is left of the noise is that of Silverman's
//! equivalent kernel (*Ann. Statist.* 12 (1984) 898, equation (2.6)): its square has the integral 3/(8 sqrt 2), in units of a^(1/4).

use crate::numeric::scalar::bisected;

/// Integral of the square of the equivalent kernel.
const KERNEL: f64 = 0.265_165_042_944_955_3;

/// Range of the smoothing parameter, in steps to the third.
const PARAMETERS: [f64; 2] = [1e-8, 1e14];

/// Halvings of its logarithm: far below what the noise is known to.
const HALVINGS: usize = 60;

/// Smoothed values.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::gap) struct Smoothed {
    pub values: Vec<f64>,
    /// How far each may be from the true one: twice the standard deviation of what is left of the noise, and what smoothing them
    /// once more changes.
    pub uncertainty: Vec<f64>,
}

/// The factors of R + a Q^T Q for one row of knots.
struct Smoother {
    steps: Vec<f64>,
    parameter: f64,
    /// D, and the two bands of L.
    diagonal: Vec<f64>,
    bands: [Vec<f64>; 2],
}

impl Smoother {
    /// Knots in units of the mean step.
    fn new(steps: &[f64], parameter: f64) -> Self {
        let m = steps.len().saturating_sub(1);
        let q = |k: usize| {
            let (a, b) = (1.0 / steps[k], 1.0 / steps[k + 1]);
            [a, -a - b, b]
        };
        let (mut diagonal, mut bands) = (Vec::with_capacity(m), [Vec::with_capacity(m), Vec::with_capacity(m)]);
        for k in 0..m {
            let own = q(k);
            let dot = |other: usize| {
                let (them, shift) = (q(other), other - k);
                (shift..3).map(|n| own[n] * them[n - shift]).sum::<f64>()
            };
            let a = (steps[k] + steps[k + 1]) / 3.0 + parameter * dot(k);
            let b = if k + 1 < m { steps[k + 1] / 6.0 + parameter * dot(k + 1) } else { 0.0 };
            let c = if k + 2 < m { parameter * dot(k + 2) } else { 0.0 };
            // L D L^T of a matrix of five bands.
            let mut pivot = a;
            let mut first = b;
            if k >= 1 {
                let (d, l): (f64, f64) = (diagonal[k - 1], bands[0][k - 1]);
                pivot -= l * l * d;
                first -= l * bands[1][k - 1] * d;
            }
            if k >= 2 {
                let (d, l): (f64, f64) = (diagonal[k - 2], bands[1][k - 2]);
                pivot -= l * l * d;
            }
            diagonal.push(pivot);
            bands[0].push(first / pivot);
            bands[1].push(c / pivot);
        }
        Self { steps: steps.to_vec(), parameter, diagonal, bands }
    }

    /// Smooths the values at places `first`, `first + stride`, ...
    fn smooth(&self, values: &mut [f64], first: usize, stride: usize) {
        let m = self.diagonal.len();
        let at = |k: usize| first + k * stride;
        let mut g: Vec<f64> = (0..m)
            .map(|k| {
                let rise = |k: usize| (values[at(k + 1)] - values[at(k)]) / self.steps[k];
                rise(k + 1) - rise(k)
            })
            .collect();
        for k in 0..m {
            if k >= 1 {
                g[k] -= self.bands[0][k - 1] * g[k - 1];
            }
            if k >= 2 {
                g[k] -= self.bands[1][k - 2] * g[k - 2];
            }
        }
        for k in (0..m).rev() {
            g[k] /= self.diagonal[k];
            if k + 1 < m {
                g[k] -= self.bands[0][k] * g[k + 1];
            }
            if k + 2 < m {
                g[k] -= self.bands[1][k] * g[k + 2];
            }
        }
        for (k, g) in g.iter().enumerate() {
            let (a, b) = (1.0 / self.steps[k], 1.0 / self.steps[k + 1]);
            for (n, q) in [a, -a - b, b].into_iter().enumerate() {
                values[at(k + n)] -= self.parameter * q * g;
            }
        }
    }
}

/// The parameter at which the mean square change of the values is s^2, and the values.
fn by_noise(values: &[f64], s: f64, smooth: impl Fn(f64, &mut [f64])) -> (f64, Vec<f64>) {
    let at = |parameter: f64| {
        let mut smoothed = values.to_vec();
        smooth(parameter, &mut smoothed);
        smoothed
    };
    let change = |smoothed: &[f64]| {
        let seen = values.iter().zip(smoothed).filter(|(z, _)| z.is_finite());
        let (sum, count) = seen.fold((0.0, 0.0), |(sum, n), (z, f)| (sum + (z - f).powi(2), n + 1.0));
        (sum / f64::max(count, 1.0)).sqrt()
    };
    let ends = PARAMETERS.map(f64::ln);
    let most = at(ends[1].exp());
    if change(&most) <= s {
        return (ends[1].exp(), most);
    }
    let parameter = bisected(|p| change(&at(p.exp())) <= s, ends, HALVINGS)[0].exp();
    (parameter, at(parameter))
}

/// Values and uncertainty from the smoothed values; `left`: what is left of the variance.
fn with_uncertainty(values: Vec<f64>, s: f64, left: f64, again: impl Fn(&mut [f64])) -> Smoothed {
    let mut twice = values.clone();
    again(&mut twice);
    let spread = 2.0 * s * left.min(1.0).sqrt();
    let uncertainty = values.iter().zip(&twice).map(|(z, f)| spread + (z - f).abs()).collect();
    Smoothed { values, uncertainty }
}

/// Smoothed values at rising knots; `s` > 0 is the standard deviation of the noise.
pub(in crate::gap) fn smoothed(knots: &[f64], values: &[f64], s: f64) -> Smoothed {
    let mean = (knots[knots.len() - 1] - knots[0]) / (knots.len() - 1) as f64;
    let steps: Vec<f64> = knots.windows(2).map(|w| (w[1] - w[0]) / mean).collect();
    let smooth = |parameter: f64, values: &mut [f64]| Smoother::new(&steps, parameter).smooth(values, 0, 1);
    let (parameter, values) = by_noise(values, s, smooth);
    with_uncertainty(values, s, KERNEL / parameter.powf(0.25), |values| smooth(parameter, values))
}

/// The same on a regular grid, x fastest, steps of `spacing`. Across holes (not finite) rows and columns are smoothed part by part.
pub(in crate::gap) fn smoothed_grid(values: &[f64], shape: [usize; 2], spacing: [f64; 2], s: f64) -> Smoothed {
    let mean = (spacing[0] * spacing[1]).sqrt();
    let smooth = |parameter: f64, values: &mut [f64]| {
        for m in 0..2 {
            let (n, stride) = (shape[m], if m == 0 { 1 } else { shape[0] });
            let step = spacing[m] / mean;
            let whole = Smoother::new(&vec![step; n - 1], parameter);
            for line in 0..shape[1 - m] {
                let first = line * if m == 0 { shape[0] } else { 1 };
                for [from, to] in runs(|k| values[first + k * stride].is_finite(), n) {
                    if to - from == n {
                        whole.smooth(values, first, stride);
                    } else if to - from > 2 {
                        Smoother::new(&vec![step; to - from - 1], parameter).smooth(
                            values,
                            first + from * stride,
                            stride,
                        );
                    }
                }
            }
        }
    };
    let (parameter, values) = by_noise(values, s, smooth);
    let left = KERNEL / parameter.powf(0.25);
    // A step of the mean may be longer or shorter than those along the sides; their product is the same.
    with_uncertainty(values, s, left * left, |values| smooth(parameter, values))
}

/// Runs of places that hold, as [first, beyond the last].
pub(in crate::gap) fn runs(holds: impl Fn(usize) -> bool, n: usize) -> Vec<[usize; 2]> {
    let mut found: Vec<[usize; 2]> = Vec::new();
    for k in (0..n).filter(|&k| holds(k)) {
        match found.last_mut().filter(|run| run[1] == k) {
            Some(run) => run[1] = k + 1,
            None => found.push([k, k + 1]),
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Noise of standard deviation 1, from an even sequence through the quantiles of a sum of twelve.
    fn noise(k: usize) -> f64 {
        let part = |m: usize| {
            let v = ((12 * k + m) as f64 * 12.9898).sin() * 43_758.545_3;
            v - v.floor()
        };
        (0..12).map(part).sum::<f64>() - 6.0
    }

    #[test]
    fn a_line_is_left_as_it_is_and_the_change_is_that_of_the_noise() {
        let knots: Vec<f64> = (0..400).map(|k| 0.01 * f64::from(k) + 0.002 * f64::from(k % 3)).collect();
        let line: Vec<f64> = knots.iter().map(|x| 3.0 - 2.0 * x).collect();
        let same = smoothed(&knots, &line, 0.1);
        assert!(same.values.iter().zip(&line).all(|(a, b)| (a - b).abs() < 1e-6));
        let s = 0.05;
        let truth: Vec<f64> = knots.iter().map(|x| (2.0 * x).sin()).collect();
        let noisy: Vec<f64> = truth.iter().enumerate().map(|(k, z)| z + s * noise(k)).collect();
        let Smoothed { values, uncertainty } = smoothed(&knots, &noisy, s);
        let rms =
            |a: &[f64], b: &[f64]| (a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / a.len() as f64).sqrt();
        assert!((rms(&values, &noisy) - s).abs() < 1e-6 * s);
        assert!(rms(&values, &truth) < 0.35 * s, "{}", rms(&values, &truth));
        let within = values.iter().zip(&truth).zip(&uncertainty).filter(|((a, b), d)| (*a - *b).abs() <= **d).count();
        assert!(within > 340, "{within} of 400 within what they may be off by");
    }

    #[test]
    fn a_map_keeps_its_planes_and_its_holes() {
        let shape = [40, 30];
        let truth = |k: usize| 0.2 * (k % 40) as f64 - 0.1 * (k / 40) as f64;
        let values: Vec<f64> =
            (0..1200).map(|k| if k % 40 == 7 && k / 40 > 20 { f64::NAN } else { truth(k) + 0.3 * noise(k) }).collect();
        let Smoothed { values: found, .. } = smoothed_grid(&values, shape, [1.0, 1.0], 0.3);
        let mut sum = 0.0;
        for k in 0..1200 {
            assert_eq!(found[k].is_nan(), values[k].is_nan());
            sum += if found[k].is_nan() { 0.0 } else { (found[k] - truth(k)).powi(2) };
        }
        assert!((sum / 1200.0).sqrt() < 0.1, "{}", (sum / 1200.0).sqrt());
    }

    #[test]
    fn runs_are_told_apart() {
        let holds = [true, true, false, true, false, false, true];
        assert_eq!(runs(|k| holds[k], 7), [[0, 2], [3, 4], [6, 7]]);
    }
}

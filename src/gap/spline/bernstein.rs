//! Polynomials by their Bernstein coefficients: a polynomial of degree n on [0, 1] lies between the least and the greatest of its n + 1
//! coefficients, and those of a part follow by convex means (Farin, *Curves and Surfaces for CAGD*, 5th ed. 2002, sections 3.4 and 5.1).

/// What rounding may do to a coefficient of a part, as a share of the largest coefficient: at most six convex means, each of three
/// roundings, along either side.
pub(in crate::gap) const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Coefficients of a bicubic polynomial on the unit square: rows along the second variable, columns along the first.
pub(in crate::gap) type Net = [[f64; 4]; 4];

/// The cubic with these values and slopes (a unit of the variable) at 0 and 1.
pub(in crate::gap) fn cubic([z0, z1]: [f64; 2], [m0, m1]: [f64; 2]) -> [f64; 4] {
    [z0, z0 + m0 / 3.0, z1 - m1 / 3.0, z1]
}

/// The blossom: the value of the polar form at n arguments (Farin, section 4.1).
fn blossom<const N: usize>(mut b: [f64; N], at: impl Fn(usize) -> f64) -> f64 {
    for level in 1..N {
        let t = at(level - 1);
        for k in 0..N - level {
            b[k] = b[k] * (1.0 - t) + b[k + 1] * t;
        }
    }
    b[0]
}

/// The value at a point.
pub(in crate::gap) fn value<const N: usize>(b: &[f64; N], t: f64) -> f64 {
    blossom(*b, |_| t)
}

/// The coefficients on the part [u, v].
pub(in crate::gap) fn part<const N: usize>(b: &[f64; N], [u, v]: [f64; 2]) -> [f64; N] {
    if u == 0.0 && v == 1.0 {
        return *b;
    }
    std::array::from_fn(|k| blossom(*b, |n| if n < k { v } else { u }))
}

/// The derivative of a cubic.
pub(in crate::gap) fn slope(b: &[f64; 4]) -> [f64; 3] {
    std::array::from_fn(|k| 3.0 * (b[k + 1] - b[k]))
}

/// The second derivative of a cubic.
pub(in crate::gap) fn curvature(b: &[f64; 4]) -> [f64; 2] {
    std::array::from_fn(|k| 6.0 * ((b[k + 2] - b[k + 1]) - (b[k + 1] - b[k])))
}

/// The least and the greatest of some numbers.
pub(in crate::gap) fn range<'a>(values: impl IntoIterator<Item = &'a f64>) -> [f64; 2] {
    values.into_iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], &v| [a.min(v), b.max(v)])
}

/// The greatest magnitude.
pub(in crate::gap) fn largest<'a>(values: impl IntoIterator<Item = &'a f64>) -> f64 {
    values.into_iter().fold(0.0, |m, v| f64::max(m, v.abs()))
}

/// First variable for second.
pub(in crate::gap) fn transposed(net: &Net) -> Net {
    std::array::from_fn(|j| std::array::from_fn(|i| net[i][j]))
}

/// The coefficients on a part of the square.
pub(in crate::gap) fn part_of_net(net: &Net, s: [f64; 2], t: [f64; 2]) -> Net {
    let along = transposed(&net.map(|row| part(&row, s)));
    transposed(&along.map(|column| part(&column, t)))
}

/// The value of a bicubic at a point.
pub(in crate::gap) fn value_of_net(net: &Net, [s, t]: [f64; 2]) -> f64 {
    value(&net.map(|row| value(&row, s)), t)
}

/// d/ds of a bicubic at a point.
pub(in crate::gap) fn slope_of_net(net: &Net, [s, t]: [f64; 2]) -> f64 {
    value(&net.map(|row| value(&slope(&row), s)), t)
}

/// d2/ds2 over a part of the square: least and greatest coefficient.
pub(in crate::gap) fn curvature_of_net(net: &Net, s: [f64; 2], t: [f64; 2]) -> [f64; 2] {
    let bent = net.map(|row| part(&curvature(&row), s));
    let columns: [[f64; 4]; 2] = std::array::from_fn(|i| std::array::from_fn(|j| bent[j][i]));
    range(columns.map(|column| part(&column, t)).as_flattened())
}

/// d2/ds dt over a part of the square: least and greatest coefficient.
pub(in crate::gap) fn twist_of_net(net: &Net, s: [f64; 2], t: [f64; 2]) -> [f64; 2] {
    let along = net.map(|row| part(&slope(&row), s));
    let columns: [[f64; 4]; 3] = std::array::from_fn(|i| std::array::from_fn(|j| along[j][i]));
    range(columns.map(|column| part(&slope(&column), t)).as_flattened())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_has_the_values_of_the_whole() {
        let b = cubic([1.0, -2.0], [4.0, 3.0]);
        let (u, v) = (0.2, 0.9);
        let p = part(&b, [u, v]);
        for k in 0..=10 {
            let t = f64::from(k) / 10.0;
            assert!((value(&p, t) - value(&b, u + (v - u) * t)).abs() < 1e-14);
        }
        assert!((value(&slope(&b), 0.0) - 4.0).abs() < 1e-14 && (value(&slope(&b), 1.0) - 3.0).abs() < 1e-14);
        let h = 1e-4;
        let second = (value(&b, 0.3 + h) - 2.0 * value(&b, 0.3) + value(&b, 0.3 - h)) / (h * h);
        assert!((value(&curvature(&b), 0.3) - second).abs() < 1e-6);
    }

    #[test]
    fn derivatives_of_a_net_are_those_of_its_polynomial() {
        // s^3 t^2 + 2 s t^3: its coefficients by blossoms along either side.
        let f = |s: f64, t: f64| s * s * s * t * t + 2.0 * s * t * t * t;
        let powers: [[f64; 4]; 4] =
            [[1.0; 4], [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0], [0.0, 0.0, 1.0 / 3.0, 1.0], [0.0, 0.0, 0.0, 1.0]];
        let net: Net = std::array::from_fn(|j| {
            std::array::from_fn(|i| powers[3][i] * powers[2][j] + 2.0 * powers[1][i] * powers[3][j])
        });
        let (s, t) = ([0.3, 0.6], [0.1, 0.8]);
        let [low, high] = range(part_of_net(&net, s, t).as_flattened());
        let [bent, twisted] = [curvature_of_net(&net, s, t), twist_of_net(&net, s, t)];
        for k in 0..100 {
            let [a, b] = [s[0] + 0.3 * f64::from(k % 10) / 9.0, t[0] + 0.7 * f64::from(k / 10) / 9.0];
            assert!((value_of_net(&net, [a, b]) - f(a, b)).abs() < 1e-14);
            assert!((slope_of_net(&net, [a, b]) - (3.0 * a * a * b * b + 2.0 * b * b * b)).abs() < 1e-13);
            assert!(low <= f(a, b) + 1e-14 && f(a, b) <= high + 1e-14);
            let (ss, st) = (6.0 * a * b * b, 6.0 * a * a * b + 6.0 * b * b);
            assert!(bent[0] <= ss + 1e-13 && ss <= bent[1] + 1e-13, "{bent:?} {ss}");
            assert!(twisted[0] <= st + 1e-13 && st <= twisted[1] + 1e-13, "{twisted:?} {st}");
        }
    }
}

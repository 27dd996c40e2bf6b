//! Polygons that are symmetric, or have all sides along two perpendicular lines, but for the rounding of their coordinates: the nearest
//! one that is exactly so.
//!
//! Isometries g of a group that take corner i to about corner g(i) leave the mean of g^-1 p_g(i) over the group exactly symmetric.

use super::mesh::{Point, cross, dot, minus, norm};
use crate::numeric::geometry::centroid;

/// A polygon, counter-clockwise and without corners on the line of their neighbours, with every corner moved by no more than `most` to
/// where it is symmetric and has its sides along two perpendicular lines, as far as that is possible.
pub(super) fn regular(corners: &[Point], most: f64) -> Vec<Point> {
    let near = |q: &[Point]| corners.iter().zip(q).all(|(a, b)| norm(minus(*a, *b)) <= most);
    let symmetric = symmetric(corners, most).filter(|q| near(q)).unwrap_or_else(|| corners.to_vec());
    squared(&symmetric, most).filter(|q| near(q)).unwrap_or(symmetric)
}

/// The mean over all rotations and mirrors about the centroid that map the corners to each other to within `most`.
fn symmetric(corners: &[Point], most: f64) -> Option<Vec<Point>> {
    let n = corners.len();
    let c = centroid(corners);
    let v: Vec<Point> = corners.iter().map(|p| minus(*p, c)).collect();
    // v as complex numbers: a rotation takes v to z v, a mirror to z conj(v).
    let times = |[a, b]: Point, [x, y]: Point| [a * x - b * y, a * y + b * x];
    let conjugate = |[x, y]: Point| [x, -y];
    // What takes every w to the v that belongs to it best, where all come near.
    let fitted = |w: &dyn Fn(usize) -> Point, to: &dyn Fn(usize) -> usize| {
        let sum = (0..n).fold([0.0; 2], |sum: Point, i| {
            let z = times(v[to(i)], conjugate(w(i)));
            [sum[0] + z[0], sum[1] + z[1]]
        });
        let z = sum.map(|s| s / norm(sum));
        (0..n).all(|i| norm(minus(times(z, w(i)), v[to(i)])) <= 2.0 * most).then_some(z)
    };
    let same_size = |k: usize| (norm(v[0]) - norm(v[k])).abs() <= 2.0 * most;
    let turned = |k: &usize| same_size(*k) && fitted(&|i| v[i], &|i| (i + k) % n).is_some();
    let shift = (1..n).filter(|k| n.is_multiple_of(*k)).find(turned).unwrap_or(n);
    let mirror = (0..n).filter(|k| same_size(*k)).find_map(|k| {
        let z = fitted(&|i| conjugate(v[i]), &|i| (n + k - i) % n)?;
        Some((k, z))
    });
    let order = n / shift;
    let elements = order * if mirror.is_some() { 2 } else { 1 };
    if elements == 1 {
        return None;
    }
    let mean = |i: usize| {
        let mut sum = [0.0; 2];
        let mut add = |[x, y]: Point| sum = [sum[0] + x, sum[1] + y];
        for j in 0..order {
            let (sin, cos) = (std::f64::consts::TAU * j as f64 / order as f64).sin_cos();
            let back = |p: Point| times([cos, -sin], p);
            add(back(v[(i + j * shift) % n]));
            if let Some((k, z)) = mirror {
                // The mirror, then the turn, back: a mirror is its own inverse.
                add(times(z, conjugate(back(v[(n + k - i + j * shift) % n]))));
            }
        }
        [0, 1].map(|m| c[m] + sum[m] / elements as f64)
    };
    Some((0..n).map(mean).collect())
}

/// The corners on lines along two perpendicular directions, one line for those within `most` of each other.
fn squared(corners: &[Point], most: f64) -> Option<Vec<Point>> {
    let n = corners.len();
    let sides: Vec<Point> = (0..n).map(|i| minus(corners[(i + 1) % n], corners[i])).collect();
    // Four times the angle is the same for all sides: their mean, weighted with the squares of the lengths.
    let square = |[x, y]: Point| [x * x - y * y, 2.0 * x * y];
    let sum = sides.iter().fold([0.0; 2], |sum: Point, s| {
        let length = norm(*s);
        let z = square(square(s.map(|c| c / length)));
        [0, 1].map(|m| sum[m] + length * length * z[m])
    });
    let (sin, cos) = (0.25 * sum[1].atan2(sum[0])).sin_cos();
    let e = [cos, sin];
    let along: Vec<bool> = sides.iter().map(|s| dot(*s, e).abs() > cross(*s, e).abs()).collect();
    let straight = |(s, along): (&Point, &bool)| (if *along { cross(e, *s) } else { dot(*s, e) }).abs() <= 2.0 * most;
    if !sides.iter().zip(&along).all(straight) || (0..n).any(|i| along[i] == along[(i + 1) % n]) {
        return None;
    }
    let turned: Vec<Point> = corners.iter().map(|p| [dot(e, *p), cross(e, *p)]).collect();
    let lines = [0, 1].map(|m| {
        let mut sorted: Vec<f64> = turned.iter().map(|p| p[m]).collect();
        sorted.sort_by(f64::total_cmp);
        let near = sorted.chunk_by(|a, b| b - a <= most);
        near.map(|own| own.iter().sum::<f64>() / own.len() as f64).collect::<Vec<_>>()
    });
    let nearest = |m: usize, at: f64| lines[m].iter().copied().min_by(|a, b| (a - at).abs().total_cmp(&(b - at).abs()));
    let back = |p: &Point| {
        let [x, y] = [nearest(0, p[0])?, nearest(1, p[1])?];
        Some([cos * x - sin * y, sin * x + cos * y])
    };
    turned.iter().map(back).collect()
}

#[cfg(test)]
mod tests {
    use super::super::polygon::{cleaned, rectilinear_frame, symmetries};
    use super::*;

    /// To so many decimals.
    fn rounded(corners: &[Point], decimals: i32) -> Vec<Point> {
        let unit = 10.0_f64.powi(decimals);
        cleaned(&corners.iter().map(|p| p.map(|c| (c * unit).round() / unit)).collect::<Vec<_>>())
    }

    fn turned(corners: &[Point], angle: f64) -> Vec<Point> {
        let (s, c) = angle.sin_cos();
        corners.iter().map(|[x, y]| [0.123_456_7 + c * x - s * y, s * x + c * y - 0.2]).collect()
    }

    #[test]
    fn rounded_polygons_are_what_they_were() {
        let gon = |n: usize, inner: f64| -> Vec<Point> {
            let corner = |k: usize| {
                let (s, c) = (std::f64::consts::TAU * k as f64 / n as f64).sin_cos();
                let r = if k.is_multiple_of(2) { 1.0 } else { inner };
                [r * c, r * s]
            };
            (0..n).map(corner).collect()
        };
        let rectangle = vec![[-1.0, -0.4], [1.0, -0.4], [1.0, 0.4], [-1.0, 0.4]];
        let ell = vec![[-1.0, -1.0], [1.0, -1.0], [1.0, 0.2], [0.2, 0.2], [0.2, 1.0], [-1.0, 1.0]];
        let kite = vec![[0.0, -1.0], [0.7, 0.3], [0.0, 0.8], [-0.7, 0.3]];
        let pinwheel = gon(16, 0.6).into_iter().enumerate().map(|(k, p)| p.map(|c| [1.0, 0.7, 0.9, 1.0][k % 4] * c));
        let cases: [(Vec<Point>, usize, bool); 7] = [
            (gon(67, 1.0), 134, false),
            (gon(10, 0.4), 10, false),
            (gon(3, 1.0), 6, false),
            (rectangle, 4, true),
            (ell, 2, true),
            (kite, 2, false),
            (pinwheel.collect(), 4, false),
        ];
        for (corners, order, square) in cases {
            let given = rounded(&turned(&corners, 0.3), 6);
            assert!(symmetries(&given).len() < order);
            let found = regular(&given, 3e-6);
            let moved = given.iter().zip(&found).map(|(a, b)| norm(minus(*a, *b))).fold(0.0, f64::max);
            assert_eq!(symmetries(&found).len(), order, "{} corners", corners.len());
            assert_eq!(rectilinear_frame(&found).is_some(), square, "{} corners", corners.len());
            assert!(moved > 0.0 && moved < 3e-6, "{moved}");
        }
    }

    #[test]
    fn others_stay_as_they_are() {
        let triangle = vec![[0.0, 0.0], [1.0, 0.1], [0.3, 0.7]];
        assert_eq!(regular(&triangle, 1e-5), triangle);
        let nearly_square = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.001]];
        assert_eq!(regular(&nearly_square, 1e-5), nearly_square);
    }
}

//! Exact integral of 1/|x - y| over two convex cells.
//!
//! grad_x . grad_y |x - y| = -1/|x - y| in the plane, so by the divergence theorem in x and in y
//!
//! ```text
//! int_A int_B 1/|x - y| = - sum over sides e of A, f of B of (n_e . n_f) int_e int_f |x - y| ds dt.
//! ```
//!
//! Parallel sides: second difference of K(v) = r^3/6 + h^2/2 (v asinh(v/h) - r). Others: |x - y| is homogeneous of degree
//! one in the coordinates s, t from the point where the lines meet, so int int = 1/3 of the boundary terms s I_f, t I_e, with
//! I_f(x) = int_f |x - y| dt = (t r + d^2 asinh(t/d))/2. Rectangles along the axes: the 16 values of
//! G(u, v) = u^2 v/2 asinh(v/u) + u v^2/2 asinh(u/v) - r^3/6, with u^3/6 and v^3/6 added, which no fourth difference sees and
//! which removes the cancellation of slender cells.

use super::mesh::{Point, cross, dot, minus, norm};

/// An integral and a bound of its rounding error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Integral {
    pub value: f64,
    pub error: f64,
}

/// Rounding of the sums below over the sum of the magnitudes: at most 40 roundings pass from a coordinate to a term.
const ROUNDING: f64 = 40.0 * f64::EPSILON;

/// G(u, v) + u^3/6 + v^3/6 for u, v >= 0.
fn corner(u: f64, v: f64) -> f64 {
    let (large, small) = (u.max(v), u.min(v));
    if large == 0.0 {
        return 0.0;
    }
    let r = u.hypot(v);
    let mut sum = (small * small * small - small * small * (r * r + r * large + large * large) / (r + large)) / 6.0;
    if small > 0.0 {
        sum += 0.5 * u * v * (u * (v / u).asinh() + v * (u / v).asinh());
    }
    sum
}

/// Two rectangles along the axes, given by their opposite corners.
pub(crate) fn rectangles(a: [Point; 2], b: [Point; 2]) -> Integral {
    let (mut value, mut size) = (0.0, 0.0);
    for (i, p) in a.iter().enumerate() {
        for (k, q) in b.iter().enumerate() {
            let sx = if i == k { 1.0 } else { -1.0 };
            for (j, s) in a.iter().enumerate() {
                for (l, t) in b.iter().enumerate() {
                    let sy = if j == l { 1.0 } else { -1.0 };
                    let term = corner((p[0] - q[0]).abs(), (s[1] - t[1]).abs());
                    value += sx * sy * term;
                    size += term.abs();
                }
            }
        }
    }
    Integral { value, error: ROUNDING * size }
}

/// int_f |x - y| dt over a side, for x at these distances from its ends.
fn distances(x: Point, side: &Side, [r1, r2]: [f64; 2]) -> f64 {
    let from = minus(side.from, x);
    let t1 = dot(from, side.along);
    let t2 = t1 + side.length;
    let d = cross(side.along, from).abs();
    let mut sum = t2 * r2 - t1 * r1;
    if d > 0.0 {
        // asinh(t2/d) - asinh(t1/d) as one logarithm.
        let (b1, b2) = (r1 + t1.abs(), r2 + t2.abs());
        let ratio = match (t1 >= 0.0, t2 >= 0.0) {
            (true, _) => b2 / b1,
            (false, true) => b1 * b2 / (d * d),
            (false, false) => b1 / b2,
        };
        // At an end of the segment the ratio is 0/0 by rounding, and d^2 ln is nothing.
        if ratio > 0.0 && ratio.is_finite() {
            sum += d * d * ratio.ln();
        }
    }
    0.5 * sum
}

/// K(v), even in v. Beside r^3 the last digits of the logarithm are nothing.
fn parallel(v: f64, h: f64) -> f64 {
    let (v, r) = (v.abs(), (v * v + h * h).sqrt());
    let log = if h > 0.0 { v * ((v + r) / h).ln() - r } else { 0.0 };
    r * r * r / 6.0 + 0.5 * h * h * log
}

/// Lines that meet at a smaller angle are taken as parallel: the terms from their meeting point would cancel to more than
/// the angle changes.
const PARALLEL: f64 = 1e-7;

/// Most corners of a cell.
const CORNERS: usize = 4;

/// A side of a cell.
#[derive(Debug, Clone, Copy)]
struct Side {
    from: Point,
    /// Of length 1.
    along: Point,
    length: f64,
}

/// The sides of a cell one after the other, but for those without length, and how many there are.
fn sides(corners: &[Point]) -> ([Side; CORNERS], usize) {
    let mut sides = [Side { from: [0.0; 2], along: [0.0; 2], length: 0.0 }; CORNERS];
    let mut count = 0;
    for (i, &from) in corners.iter().enumerate() {
        let v = minus(corners[(i + 1) % corners.len()], from);
        let length = norm(v);
        if length > 0.0 {
            sides[count] = Side { from, along: v.map(|c| c / length), length };
            count += 1;
        }
    }
    (sides, count)
}

/// int_e int_f |x - y| ds dt of parallel sides, and a size such that its error is at most ROUNDING times it.
fn parallel_sides(e: &Side, f: &Side, sine: f64) -> (f64, f64) {
    let sign = dot(e.along, f.along).signum();
    let middle = minus([0, 1].map(|m| f.from[m] + 0.5 * f.length * f.along[m]), e.from);
    let h = cross(e.along, middle).abs();
    let across = minus(f.from, e.from);
    let (t0, t1) = (dot(e.along, across), dot(e.along, across) + sign * f.length);
    let (t0, t1) = (t0.min(t1), t0.max(t1));
    let terms = [parallel(e.length - t0, h), -parallel(e.length - t1, h), -parallel(-t0, h), parallel(-t1, h)];
    // Turning f about its middle by the angle moves its points by half its length times the angle at most.
    let turned = 0.5 * sine.abs() * f.length * f.length * e.length / ROUNDING;
    (terms.iter().sum(), terms.iter().map(|t| t.abs()).sum::<f64>() + turned)
}

/// A number that is found once; NaN before.
fn kept(number: &mut f64, find: impl FnOnce() -> f64) -> f64 {
    if number.is_nan() {
        *number = find();
    }
    *number
}

/// Two convex cells of at most [`CORNERS`] corners, counter-clockwise; sides without length are left out.
///
/// A corner and a side have one I, which the two sides that meet in the corner share.
pub(crate) fn polygons(a: &[Point], b: &[Point]) -> Integral {
    let ((sa, na), (sb, nb)) = (sides(a), sides(b));
    let mut between = [[0.0; CORNERS]; CORNERS];
    for (row, e) in between.iter_mut().zip(&sa[..na]) {
        for (r, f) in row.iter_mut().zip(&sb[..nb]) {
            *r = norm(minus(e.from, f.from));
        }
    }
    // I of corner i of a along side k of b, and of corner k of b along side i of a, where they are asked for.
    let (mut along_b, mut along_a) = ([[f64::NAN; CORNERS]; CORNERS], [[f64::NAN; CORNERS]; CORNERS]);
    let (mut value, mut size) = (0.0, 0.0);
    for (i, e) in sa[..na].iter().enumerate() {
        let next_i = (i + 1) % na;
        for (k, f) in sb[..nb].iter().enumerate() {
            let next_k = (k + 1) % nb;
            let cosine = dot(e.along, f.along);
            if cosine.abs() < 1e-15 {
                continue;
            }
            let sine = cross(e.along, f.along);
            let (term, magnitude) = if sine.abs() < PARALLEL {
                parallel_sides(e, f, sine)
            } else {
                let mut of_a = |i: usize| {
                    let ends = [between[i][k], between[i][next_k]];
                    kept(&mut along_b[i][k], || distances(sa[i].from, f, ends))
                };
                let mut of_b = |k: usize| {
                    let ends = [between[i][k], between[next_i][k]];
                    kept(&mut along_a[k][i], || distances(sb[k].from, e, ends))
                };
                // The lines meet at e(0) + s v = f(0) + t w.
                let across = minus(f.from, e.from);
                let (s, t) = (cross(across, f.along) / sine, cross(across, e.along) / sine);
                let terms = [(e.length - s) * of_a(next_i), s * of_a(i), (f.length - t) * of_b(next_k), t * of_b(k)];
                (terms.iter().sum::<f64>() / 3.0, terms.iter().map(|t| t.abs()).sum::<f64>() / 3.0)
            };
            value -= cosine * term;
            size += cosine.abs() * magnitude;
        }
    }
    Integral { value, error: ROUNDING * size }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unit_square_on_itself() {
        // int int 1/r over the unit square: 4 [ln(1 + sqrt 2) - (sqrt 2 - 1)/3].
        let exact = 4.0 * ((1.0 + 2f64.sqrt()).ln() - (2f64.sqrt() - 1.0) / 3.0);
        let unit = [[0.0, 0.0], [1.0, 1.0]];
        assert!((rectangles(unit, unit).value - exact).abs() < 1e-14);
        let poly = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        assert!((polygons(&poly, &poly).value - exact).abs() < 1e-13);
        // Turned by 0.3 about a corner.
        let (s, c) = 0.3f64.sin_cos();
        let turned = poly.map(|p| [c * p[0] - s * p[1], s * p[0] + c * p[1]]);
        assert!((polygons(&turned, &turned).value - exact).abs() < 1e-13);
    }

    #[test]
    fn polygons_agree_with_rectangles_and_split() {
        let boxes = |x: [f64; 2], y: [f64; 2]| [[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]];
        let cases = [([0.0, 1.0], [0.0, 1e-4]), ([1.0, 1.4], [0.0, 0.2]), ([-3.0, -2.0], [0.5, 0.7])];
        let own = ([0.2, 0.9], [1e-4, 3e-4]);
        for (x, y) in cases {
            let exact = rectangles([[x[0], y[0]], [x[1], y[1]]], [[own.0[0], own.1[0]], [own.0[1], own.1[1]]]);
            let other = polygons(&boxes(x, y), &boxes(own.0, own.1));
            assert!((exact.value - other.value).abs() <= exact.error + other.error, "{exact:?} {other:?}");
            assert!(exact.error < 1e-6 * exact.value);
        }
        // A quadrilateral and the two triangles of its diagonal, against a third cell.
        let quad = [[0.0, 0.0], [2.0, 0.3], [1.7, 1.9], [-0.2, 1.1]];
        let third = [[1.7, 1.9], [2.0, 0.3], [3.0, 1.0]];
        let whole = polygons(&quad, &third).value;
        let parts =
            polygons(&[quad[0], quad[1], quad[2]], &third).value + polygons(&[quad[0], quad[2], quad[3]], &third).value;
        assert!((whole - parts).abs() < 1e-13);
    }
}

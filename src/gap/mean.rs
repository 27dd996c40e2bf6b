//! Mean of a gap over a cell: of the highest of some planes, and by quadrature where no closed form is known.

use crate::numeric::geometry::{Rect, area, centroid, clip};

/// With more planes than this quadrature is quicker where they meet.
pub(super) const MOST_PLANES: usize = 24;

/// Of the highest of these planes, exactly.
pub(super) fn of_planes(planes: &[[f64; 3]], cell: &Rect) -> f64 {
    let ([x, y], [w, h]) = (cell.centre(), cell.size());
    let middle = |p: &[f64; 3]| p[0] * x + p[1] * y + p[2];
    let mut top = (f64::NEG_INFINITY, &[0.0; 3]);
    for p in planes {
        let height = middle(p);
        if height > top.0 {
            top = (height, p);
        }
    }
    // What rises above the highest in the middle anywhere in the cell.
    let (height, top) = top;
    let rises = |p: &[f64; 3]| {
        let variation = 0.5 * ((p[0] - top[0]).abs() * w + (p[1] - top[1]).abs() * h);
        middle(p) + variation > height && p != top
    };
    let mut rising = planes.iter().filter(|p| rises(p));
    let Some(first) = rising.next() else { return height };
    let volume = |over: &[f64; 3], polygon: &[[f64; 2]], under: &[f64; 3]| {
        if polygon.len() < 3 {
            return 0.0;
        }
        let [cx, cy] = centroid(polygon);
        area(polygon)
            * ((over[0] - under[0]) * (cx - x) + (over[1] - under[1]) * (cy - y) + middle(over) - middle(under))
    };
    let above = |p: &[f64; 3], q: &[f64; 3], polygon: &[[f64; 2]]| clip(polygon, q[0] - p[0], q[1] - p[1], q[2] - p[2]);
    if rising.next().is_none() {
        // One ridge: what the second adds where it is the higher one.
        let piece = above(first, top, &cell.corners());
        return height + volume(first, &piece, top) / (w * h);
    }
    let rising: Vec<&[f64; 3]> = planes.iter().filter(|p| rises(p)).collect();
    let added = |k: usize| {
        let others = rising.iter().filter(|&&q| q != rising[k]);
        let own = above(rising[k], top, &cell.corners());
        let piece = others.fold(own, |polygon, q| above(rising[k], q, &polygon));
        volume(rising[k], &piece, top)
    };
    // Equal planes share a region: count the first of them only.
    let distinct = (0..rising.len()).filter(|&k| !rising[..k].contains(&rising[k]));
    height + distinct.map(added).sum::<f64>() / (w * h)
}

/// Bounds of the same: what rounding may do to heights and volumes.
pub(super) fn of_planes_enclosed(planes: &[[f64; 3]], cell: &Rect) -> [f64; 2] {
    let ([x, y], [w, h]) = (cell.centre(), cell.size());
    let size = |p: &[f64; 3]| (p[0] * x).abs() + (p[1] * y).abs() + p[2].abs() + p[0].abs() * w + p[1].abs() * h;
    let largest = planes.iter().map(size).fold(0.0, f64::max);
    let (mean, rounding) = (of_planes(planes, cell), 64.0 * f64::EPSILON * largest);
    [mean - rounding, mean + rounding]
}

/// Abscissae (half interval) and weights of the 3-point Gauss-Legendre rule on [-1, 1].
const NODES: [(f64, f64); 3] =
    [(-0.774_596_669_241_483_4, 5.0 / 18.0), (0.0, 8.0 / 18.0), (0.774_596_669_241_483_4, 5.0 / 18.0)];

/// Halvings of a cell that a kink runs through: the error of its mean falls at least fourfold with each.
const DEEPEST: u32 = 4;

/// Two rules that agree to this share of the variation in the cell are taken as exact.
const AGREEMENT: f64 = 1e-7;

/// Values at some points, written to as many places.
pub(super) type Values<'a> = dyn Fn(&[[f64; 2]], &mut [f64]) + 'a;

/// Tensor 3-point Gauss, halved where it disagrees with itself (kinks, edges). Exact to degree 5.
pub(super) fn by_quadrature(g: impl Fn(f64, f64) -> f64, cell: &Rect) -> f64 {
    by_values(&|points, to| points.iter().zip(to).for_each(|(p, to)| *to = g(p[0], p[1])), cell)
}

/// The same from values at several points at once.
pub(super) fn by_values(g: &Values, cell: &Rect) -> f64 {
    let (mean, low, high) = gauss(g, cell);
    if !mean.is_finite() {
        return f64::INFINITY;
    }
    // Material must reach into the corners; a cell that was fitted to an edge may miss it by rounding.
    let mut corners = [0.0; 4];
    g(&cell.scaled(1.0 - 1e-9).corners(), &mut corners);
    if !corners.iter().all(|g| g.is_finite()) {
        return f64::INFINITY;
    }
    refine(g, cell, mean, AGREEMENT * (high - low), DEEPEST)
}

fn refine(g: &Values, cell: &Rect, whole: f64, tolerance: f64, deeper: u32) -> f64 {
    let [x, y] = cell.centre();
    let quarters = [
        Rect { min: cell.min, max: [x, y] },
        Rect { min: [x, cell.min[1]], max: [cell.max[0], y] },
        Rect { min: [cell.min[0], y], max: [x, cell.max[1]] },
        Rect { min: [x, y], max: cell.max },
    ];
    let means = quarters.map(|quarter| gauss(g, &quarter).0);
    let halved = 0.25 * means.iter().sum::<f64>();
    if deeper == 0 || !halved.is_finite() || (halved - whole).abs() <= tolerance {
        return halved;
    }
    let refined = |k: usize| refine(g, &quarters[k], means[k], tolerance, deeper - 1);
    0.25 * (refined(0) + refined(1) + refined(2) + refined(3))
}

/// Mean, least and greatest value of the rule.
fn gauss(g: &Values, cell: &Rect) -> (f64, f64, f64) {
    let ([x, y], [w, h]) = (cell.centre(), cell.size());
    let mut values = [0.0; 9];
    let points = std::array::from_fn::<_, 9, _>(|k| [x + 0.5 * w * NODES[k / 3].0, y + 0.5 * h * NODES[k % 3].0]);
    g(&points, &mut values);
    let (mut mean, mut low, mut high) = (0.0, f64::INFINITY, f64::NEG_INFINITY);
    for (k, value) in values.into_iter().enumerate() {
        mean += NODES[k / 3].1 * NODES[k % 3].1 * value;
        low = value.min(low);
        high = value.max(high);
    }
    (mean, low, high)
}

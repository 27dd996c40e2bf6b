//! Mean of a gap over a cell: of the highest of some planes, and by quadrature where no closed form is known.

use super::ridges::face_polygon;
use crate::geometry::{Rect, area, centroid};

/// With more planes than this quadrature is quicker where they meet.
const MOST_PLANES: usize = 24;

/// Of the highest of these planes, exactly unless very many meet in the cell; `highest` finds it at a point.
pub(super) fn of_planes<'a>(
    planes: &[[f64; 3]],
    highest: impl Fn(f64, f64) -> &'a [f64; 3] + Copy,
    cell: &Rect,
) -> f64 {
    let height = |p: &[f64; 3], x: f64, y: f64| p[0] * x + p[1] * y + p[2];
    let gap = |x: f64, y: f64| height(highest(x, y), x, y);
    // The region of one plane is convex: highest at the corners, highest throughout.
    let [x, y] = cell.centre();
    let top = highest(x, y);
    if cell.corners().iter().all(|c| gap(c[0], c[1]) <= height(top, c[0], c[1])) {
        return height(top, x, y);
    }
    if planes.len() > MOST_PLANES {
        return by_quadrature(gap, cell);
    }
    let volume = |k: usize| {
        let piece = face_polygon(planes, k, cell);
        if piece.len() < 3 {
            return 0.0;
        }
        let [x, y] = centroid(&piece);
        area(&piece) * height(&planes[k], x, y)
    };
    let [w, h] = cell.size();
    // Equal planes share a region: count the first of them only.
    (0..planes.len()).filter(|&k| !planes[..k].contains(&planes[k])).map(volume).sum::<f64>() / (w * h)
}

/// Abscissae (half interval) and weights of the 3-point Gauss-Legendre rule on [-1, 1].
const NODES: [(f64, f64); 3] =
    [(-0.774_596_669_241_483_4, 5.0 / 18.0), (0.0, 8.0 / 18.0), (0.774_596_669_241_483_4, 5.0 / 18.0)];

/// Halvings of a cell that a kink runs through: the error of its mean falls at least fourfold with each.
const DEEPEST: u32 = 4;

/// Two rules that agree to this share of the variation in the cell are taken as exact.
const AGREEMENT: f64 = 1e-7;

/// Tensor 3-point Gauss, halved where it disagrees with itself (kinks, edges). Exact to degree 5.
pub(super) fn by_quadrature(g: impl Fn(f64, f64) -> f64 + Copy, cell: &Rect) -> f64 {
    let (mean, low, high) = gauss(g, cell);
    // Material must reach into the corners; a cell that was fitted to an edge may miss it by rounding.
    let complete = cell.scaled(1.0 - 1e-9).corners().iter().all(|c| g(c[0], c[1]).is_finite());
    if !(mean.is_finite() && complete) {
        return f64::INFINITY;
    }
    refine(g, cell, mean, AGREEMENT * (high - low), DEEPEST)
}

fn refine(g: impl Fn(f64, f64) -> f64 + Copy, cell: &Rect, whole: f64, tolerance: f64, deeper: u32) -> f64 {
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

fn gauss(g: impl Fn(f64, f64) -> f64, cell: &Rect) -> (f64, f64, f64) {
    let [x, y] = cell.centre();
    let [w, h] = cell.size();
    let (mut mean, mut low, mut high) = (0.0, f64::INFINITY, f64::NEG_INFINITY);
    for (s, u) in NODES {
        for (t, v) in NODES {
            let value = g(x + 0.5 * w * s, y + 0.5 * h * t);
            mean += u * v * value;
            low = value.min(low);
            high = value.max(high);
        }
    }
    (mean, low, high)
}

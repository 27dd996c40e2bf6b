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
const DEEPEST: u32 = 3;

/// Two rules that agree to this share of the variation in the cell are taken as exact.
const AGREEMENT: f64 = 1e-7;

/// Where the polynomial through the nodes is as near as this in the corners, which lie outside of them, over the variation in the cell, the
/// gap is smooth there: what the corners show is of the third degree, what the rule leaves out of the sixth.
const SMOOTH: f64 = 1e-4;

/// Where it is farther off than this, a kink may lie between the corners and all nodes, those of quarters too: that these agree shows nothing.
const HIDDEN: f64 = 5e-3;

/// Values at some points, written to as many places.
pub(super) type Values<'a> = dyn Fn(&[[f64; 2]], &mut [f64]) + 'a;

/// Tensor 3-point Gauss, halved where it disagrees with itself (kinks, edges). Exact to degree 5.
pub(super) fn by_quadrature(g: impl Fn(f64, f64) -> f64, cell: &Rect) -> f64 {
    by_values(&|points, to| points.iter().zip(to).for_each(|(p, to)| *to = g(p[0], p[1])), cell)
}

/// The same from values at several points at once.
pub(super) fn by_values(g: &Values, cell: &Rect) -> f64 {
    let nodes = at_nodes(g, cell);
    let mean = by_rule(&nodes);
    if !mean.is_finite() {
        return f64::INFINITY;
    }
    // Material must reach into the corners; a cell that was fitted to an edge may miss it by rounding.
    let mut corners = [0.0; 4];
    g(&cell.scaled(1.0 - 1e-9).corners(), &mut corners);
    if !corners.iter().all(|g| g.is_finite()) {
        return f64::INFINITY;
    }
    let low = nodes.iter().copied().fold(f64::INFINITY, f64::min);
    let high = nodes.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let off = at_corners(&nodes).iter().zip(&corners).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    if off <= SMOOTH * (high - low) {
        return mean;
    }
    let whole = if off <= HIDDEN * (high - low) { mean } else { f64::NAN };
    refine(g, cell, whole, AGREEMENT * (high - low), DEEPEST)
}

/// The mean by quarters, and by theirs where they do not agree with `whole`.
fn refine(g: &Values, cell: &Rect, whole: f64, tolerance: f64, deeper: u32) -> f64 {
    let [x, y] = cell.centre();
    let quarters = [
        Rect { min: cell.min, max: [x, y] },
        Rect { min: [x, cell.min[1]], max: [cell.max[0], y] },
        Rect { min: [cell.min[0], y], max: [x, cell.max[1]] },
        Rect { min: [x, y], max: cell.max },
    ];
    let means = quarters.map(|quarter| by_rule(&at_nodes(g, &quarter)));
    let halved = 0.25 * means.iter().sum::<f64>();
    if deeper == 0 || !halved.is_finite() || (halved - whole).abs() <= tolerance {
        return halved;
    }
    let refined = |k: usize| refine(g, &quarters[k], means[k], tolerance, deeper - 1);
    0.25 * (refined(0) + refined(1) + refined(2) + refined(3))
}

/// Values at the nodes of the rule, y fastest.
fn at_nodes(g: &Values, cell: &Rect) -> [f64; 9] {
    let ([x, y], [w, h]) = (cell.centre(), cell.size());
    let mut values = [0.0; 9];
    let points = std::array::from_fn::<_, 9, _>(|k| [x + 0.5 * w * NODES[k / 3].0, y + 0.5 * h * NODES[k % 3].0]);
    g(&points, &mut values);
    values
}

/// The mean by the rule.
fn by_rule(values: &[f64; 9]) -> f64 {
    values.iter().enumerate().map(|(k, value)| NODES[k / 3].1 * NODES[k % 3].1 * value).sum()
}

/// What the polynomial through the values at the nodes is in the corners, in their order.
fn at_corners(values: &[f64; 9]) -> [f64; 4] {
    // Lagrange's polynomials of the nodes -a, 0, a at 1: (1 - a)/(2 a^2), 1 - 1/a^2, (1 + a)/(2 a^2), a^2 = 3/5.
    let a = NODES[2].0;
    let [near, middle, far] = [(5.0 / 6.0) * (1.0 - a), -2.0 / 3.0, (5.0 / 6.0) * (1.0 + a)];
    let along = |at: f64| if at > 0.0 { [near, middle, far] } else { [far, middle, near] };
    [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| {
        let (x, y) = (along(x), along(y));
        values.iter().enumerate().map(|(k, value)| x[k / 3] * y[k % 3] * value).sum()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const CELL: Rect = Rect { min: [0.3, -0.2], max: [0.7, 0.4] };

    #[test]
    fn corners_follow_from_the_nodes_to_second_degree() {
        let g = |x: f64, y: f64| (1.0 + 2.0 * x - x * x) * (3.0 - y + 0.5 * y * y);
        let values = at_nodes(&|points, to| points.iter().zip(to).for_each(|(p, to)| *to = g(p[0], p[1])), &CELL);
        for (found, [x, y]) in at_corners(&values).into_iter().zip(CELL.corners()) {
            assert!((found - g(x, y)).abs() < 1e-14, "{found} {}", g(x, y));
        }
    }

    #[test]
    fn smooth_cells_take_few_values_and_kinks_many() {
        let counted = |g: &dyn Fn(f64, f64) -> f64| {
            let count = std::cell::Cell::new(0);
            let mean = by_quadrature(
                |x, y| {
                    count.set(count.get() + 1);
                    g(x, y)
                },
                &CELL,
            );
            (mean, count.get())
        };
        let (mean, count) = counted(&|x, y| (0.01 * x).exp() + 0.1 * y * y);
        let exact = (0.007_f64.exp() - 0.003_f64.exp()) / (0.01 * 0.4) + 0.1 * (0.4f64.powi(3) + 0.2f64.powi(3)) / 1.8;
        assert!(count == 13 && (mean - exact).abs() < 1e-14, "{count} {mean} {exact}");
        // A kink anywhere, shallow or not, also beside all nodes.
        for k in 0..200 {
            let (at, steep) = (0.3 + 0.4 * f64::from(k % 20) / 20.0, 10f64.powi(-(k / 20) / 2));
            let (mean, count) = counted(&|x, y| x + y + steep * (x - at).max(0.0));
            let exact = 0.5 + 0.1 + steep * (0.7 - at).powi(2) / 0.8;
            assert!((mean - exact).abs() < 1e-4 * (1.0 + steep), "{at} {steep}: {mean} {exact} {count}");
        }
    }
}

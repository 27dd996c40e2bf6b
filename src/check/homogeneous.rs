//! Homogeneity by samples: g(c + s v) = s^k g(c + v) with c the centre of the gap.

use crate::gap::Gap;
use crate::grid::Grid;

/// Sampled points.
const POINTS: i32 = 40;

/// Beyond the grid as well: a region may end where the grid does.
const AROUND: f64 = 1.6;

/// Relative error of the law at a sampled point.
const CLOSE: f64 = 1e-8;

/// Whether the law holds with this k at points spread over the grid and around it; with k infinite, whether g is 0 wherever there is
/// material.
pub(super) fn is_homogeneous(gap: &dyn Gap, k: f64, grid: &Grid) -> bool {
    let [cx, cy] = gap.centre();
    let size = grid.extent().size();
    (1..=POINTS).all(|n| {
        let v = [0.7549, 0.5698].map(|step: f64| ((step * f64::from(n)).fract() - 0.5) * AROUND);
        let at = |s: f64| gap.gap(cx + s * v[0] * size[0], cy + s * v[1] * size[1]);
        let whole = at(1.0);
        if k == f64::INFINITY {
            return whole == 0.0 || whole == f64::INFINITY;
        }
        whole.is_finite() && [0.5, 0.13].iter().all(|s| (at(*s) - whole * s.powf(k)).abs() <= CLOSE * whole.abs())
    })
}

#[cfg(feature = "scene")]
/// k of a gap that is zero at its centre and follows the law; `None` where it does not. Infinite for a flat.
pub(super) fn degree(gap: &dyn Gap, grid: &Grid) -> Option<f64> {
    let [cx, cy] = gap.centre();
    let size = grid.extent().size();
    if gap.gap(cx, cy) != 0.0 {
        return None;
    }
    let at = |s: f64| gap.gap(cx + s * 0.31 * size[0], cy + s * 0.23 * size[1]);
    let (whole, half) = (at(1.0), at(0.5));
    let k = if whole == 0.0 || whole == f64::INFINITY { f64::INFINITY } else { (whole / half).log2() };
    // Powers are mostly whole or simple: rounding off what the logarithm left.
    let k = [1.0, 2.0, 3.0, 4.0].into_iter().find(|simple| (k - simple).abs() < 1e-9).unwrap_or(k);
    (k > 0.0 && is_homogeneous(gap, k, grid)).then_some(k)
}

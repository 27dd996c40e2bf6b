//! Homogeneity by samples: g(c + s v) = s^k g(c + v) with c the centre of the gap.

#[cfg(feature = "scene")]
use crate::gap::Degree;
use crate::gap::{AnyGap, Gap};
use crate::grid::Grid;

/// Sampled points.
const POINTS: i32 = 40;

/// Beyond the grid as well: a region may end where the grid does.
const AROUND: f64 = 1.6;

/// Relative error of the law at a sampled point.
const CLOSE: f64 = 1e-8;

/// Whether the law holds with this k at points spread over the grid and around it; with k infinite, whether g is 0 wherever there is
/// material.
pub(super) fn is_homogeneous(gap: &AnyGap, k: f64, grid: &Grid) -> bool {
    let [cx, cy] = gap.known().centre;
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
/// k of a gap that is zero at its centre and known by construction to be homogeneous about it, where samples agree. Infinite for a
/// flat.
pub(super) fn degree(gap: &AnyGap, grid: &Grid) -> Option<f64> {
    let k = match gap.known().law.filter(|law| law.lowest == 0.0)?.degree {
        Degree::Power(k) => k,
        Degree::Flat => f64::INFINITY,
    };
    is_homogeneous(gap, k, grid).then_some(k)
}

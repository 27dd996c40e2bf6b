//! Flat punches: K = P/d from the bracket of the energy, P d = 2 U.

use std::borrow::Cow;

use super::Limits;
use super::discrete::{Discretisation, Stiffness};
use super::estimated::Rest;
use super::first_mesh::{COARSE, first, usually_enough};
use super::mesh::Point;
use super::outline::{FINE, Fitted, Outline};
use super::tilted_mesh::FINEST;

/// The stiffness of a flat punch, E* = 1, and what it took.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FlatStiffness {
    /// Bounds of K = P/d: the intersection over all meshes.
    pub stiffness: [f64; 2],
    /// Corners, counter-clockwise, in the outline's axes, and pressure at depth 1 of the cells of the last mesh.
    pub cells: Vec<([Point; 4], f64)>,
    /// Unknowns of the last mesh.
    pub unknowns: usize,
}

impl FlatStiffness {
    /// Half the width of the bounds, relative.
    pub fn width(&self) -> f64 {
        let [low, high] = self.stiffness;
        (high - low) / (high + low)
    }
}

/// Share of the tolerance that the next mesh is to meet: one that just misses it costs as much as the one that has to follow.
pub(super) const AIM: f64 = 0.9;

/// Share of the tolerance that the place of the edges may take.
const OF_EDGES: f64 = 0.1;

/// Share of a width that pair integrals may leave open where a finer mesh is still worth it.
const MOST_OPEN: f64 = 0.5;

/// The polygon that is meant, as far as the coordinates tell it.
fn regular<'a>(outline: &'a Outline, limits: &Limits) -> Cow<'a, Outline> {
    outline.regular(OF_EDGES * limits.tolerance).map_or(Cow::Borrowed(outline), Cow::Owned)
}

/// Bounds of K on meshes of rising n until the half width is within the tolerance. The width falls as n^-3 (see
/// `Outline`), so the next n follows from the width; at least one more cell each time. `None` where the outline has no mesh
/// that can be solved on, and where the time ends before the first one is.
#[must_use]
pub(crate) fn flat_stiffness(outline: &Outline, limits: &Limits) -> Option<FlatStiffness> {
    let outline = &regular(outline, limits);
    let mut n = first(outline, limits);
    let mut best: Option<FlatStiffness> = None;
    let mut before = limits.deadline.remaining();
    loop {
        let fitted = outline.mesh(n)?;
        if fitted.mesh.loaded > limits.cells {
            return best;
        }
        let Some(d) = Discretisation::new(fitted.mesh.clone(), &fitted.group, limits.means()) else { return best };
        let unknowns = d.orbits.loaded;
        let Some(Stiffness { bounds, open, pressure }) = d.stiffness() else { return best };
        let outside = outline.displaced();
        let mut stiffness = [bounds[0] * (1.0 - outside), bounds[1] * (1.0 + outside)];
        if let Some(b) = &best {
            stiffness = [stiffness[0].max(b.stiffness[0]), stiffness[1].min(b.stiffness[1])];
        }
        let found = FlatStiffness { stiffness, cells: cells(&fitted, &pressure), unknowns };
        let width = found.width();
        // With thinner cells pair integrals leave more.
        let met = width <= limits.tolerance || open > MOST_OPEN * width;
        best = Some(found);
        let factor = (width / (AIM * limits.tolerance)).cbrt();
        let next = ((n as f64 * factor).ceil() as usize).max(n + 1).min(2 * n);
        // Unknowns grow as n^2, time at least so.
        let growth = (next * next) as f64 / (n * n) as f64;
        let left = limits.deadline.remaining();
        if met || unknowns as f64 * growth > limits.unknowns as f64 || (before - left) * growth > left {
            return best;
        }
        (n, before) = (next, left);
    }
}

/// Of n, the mesh that tells what a finer one leaves.
const BEFORE: f64 = 0.6;

/// The least n that is told from another one.
const LEAST: usize = 4;

/// Of the correction, what its error is taken to be besides: coarse meshes are not where the order is reached.
const UNSURE: f64 = 0.5;

/// The error that is told over half of the width of a proof, on the same mesh.
const TOLD: f64 = 1.4;

/// K without a proof: from below on meshes of rising n, each with what it leaves told by one before it (`Rest`), until that is within the
/// tolerance. `None` as of [`flat_stiffness`].
#[must_use]
pub(crate) fn estimated_stiffness(outline: &Outline, limits: &Limits) -> Option<FlatStiffness> {
    let outline = &regular(outline, limits);
    let whole = if outline.is_graded_everywhere() { f64::INFINITY } else { 0.5 * FINE * outline.extent() };
    let on = |n: usize| {
        let fitted = outline.mesh_within(n, whole / n as f64).filter(|fitted| fitted.mesh.loaded <= limits.cells)?;
        let d = Discretisation::within(fitted.mesh.clone(), &fitted.group, limits.unknowns, limits.means())?;
        let below = d.stiffness_below()?;
        let k = below.stiffness + 0.5 * below.open;
        Some((k, below.half_open(), cells(&fitted, &below.pressure), d.orbits.loaded))
    };
    let wanted = usually_enough(outline, limits.tolerance / TOLD);
    let mut n = (wanted.min(FINEST as f64) as usize).max(LEAST);
    let coarser = ((BEFORE * n as f64) as usize).max(COARSE);
    let (k, open, ..) = on(coarser)?;
    let mut before = (coarser, k, open);
    let mut best: Option<FlatStiffness> = None;
    loop {
        let Some((k, open, cells, unknowns)) = on(n) else { return best };
        let rest = Rest::new(k, before.1, n as f64 / before.0 as f64);
        let value = k * (1.0 + rest.correction);
        let error = rest.error + UNSURE * rest.correction.abs() + open + before.2 + outline.displaced();
        let found = FlatStiffness { stiffness: [value * (1.0 - error), value * (1.0 + error)], cells, unknowns };
        if best.as_ref().is_none_or(|best| found.width() < best.width()) {
            best = Some(found);
        }
        let finer = n as f64 * (error / (AIM * limits.tolerance)).cbrt();
        if error > limits.tolerance && open <= MOST_OPEN * error && n < FINEST && finer.is_finite() {
            before = (n, k, open);
            n = (finer.ceil() as usize).clamp(n + 1, 2 * n).min(FINEST);
        } else {
            return best;
        }
    }
}

/// The cells of a mesh in the axes of the outline.
fn cells(fitted: &Fitted, pressure: &[f64]) -> Vec<([Point; 4], f64)> {
    let corners = |cell| fitted.mesh.corners(cell).map(|p| fitted.to_outline(p));
    pressure.iter().enumerate().map(|(cell, p)| (corners(cell), *p)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn regular(sides: usize) -> Vec<[f64; 2]> {
        let radius = 0.5 / (std::f64::consts::PI / sides as f64).sin();
        (0..sides)
            .map(|k| {
                let (s, c) = (std::f64::consts::TAU * k as f64 / sides as f64 + 0.3).sin_cos();
                [radius * c, radius * s]
            })
            .collect()
    }

    fn rectangle(a: f64, b: f64) -> Vec<[f64; 2]> {
        vec![[0.0, 0.0], [a, 0.0], [a, b], [0.0, b]]
    }

    /// Values of graded Galerkin on other meshes with Richardson extrapolation, good to about 2e-6 of themselves (1e-5 for
    /// the shapes with re-entrant corners).
    #[test]
    fn known_stiffnesses() {
        let star: Vec<[f64; 2]> = (0..10)
            .map(|k| {
                let (s, c) = (std::f64::consts::TAU * k as f64 / 10.0).sin_cos();
                let r = if k % 2 == 0 { 1.0 } else { 0.381_966_011_25 };
                [r * c, r * s]
            })
            .collect();
        let ell = vec![[-1.0, -1.0], [1.0, -1.0], [1.0, 0.0], [0.0, 0.0], [0.0, 1.0], [-1.0, 1.0]];
        let t = 1.0 / 6.0;
        let plus = vec![
            [-t, -0.5],
            [t, -0.5],
            [t, -t],
            [0.5, -t],
            [0.5, t],
            [t, t],
            [t, 0.5],
            [-t, 0.5],
            [-t, t],
            [-0.5, t],
            [-0.5, -t],
            [-t, -t],
        ];
        let cases = [
            (regular(3), 0.788_116, 3e-6),
            (regular(4), 1.152_298, 1e-6),
            (regular(5), 1.495_049, 3e-6),
            (regular(6), 1.829_117, 3e-6),
            (regular(8), 2.485_263, 3e-6),
            (rectangle(2.0, 1.0), 1.671_071, 3e-6),
            (rectangle(5.0, 1.0), 2.937_718, 3e-6),
            (rectangle(10.0, 1.0), 4.720_007, 3e-6),
            (vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], 0.866_42, 3e-5),
            (ell, 2.071_13, 3e-5),
            (plus, 0.905_159, 1e-5),
            (star, 1.386_23, 1e-5),
        ];
        for (corners, exact, known) in cases {
            let outline = Outline::polygon(&corners).unwrap();
            let k = flat_stiffness(&outline, &Limits::default()).unwrap();
            assert!(k.stiffness[1] - k.stiffness[0] <= 1e-3 * (k.stiffness[0] + k.stiffness[1]));
            assert!(k.stiffness[0] < exact * (1.0 + known) && k.stiffness[1] > exact * (1.0 - known));
            for tolerance in [1e-2, 1e-3, 2e-4] {
                let told = estimated_stiffness(&outline, &Limits { tolerance, ..Limits::default() }).unwrap().stiffness;
                assert!(told[1] - told[0] <= tolerance * (told[0] + told[1]), "{corners:?} {told:?}");
                assert!(told[0] < exact * (1.0 + known) && told[1] > exact * (1.0 - known), "{corners:?} {told:?}");
            }
        }
    }

    /// Thin cells with nearly parallel sides, whose pair integrals cancel: what these leave open is in both bounds and in the estimate.
    #[test]
    fn nearly_parallel_sides() {
        // K of 2 x 0.51, and how much a wedge along a short side adds: from brackets of exact rectangles, good to 2e-4.
        let (a, b, exact) = (2.0, 0.51, 1.280_5);
        for wedge in [1e-3, 1e-4, 1e-5, 1e-8] {
            let outline = Outline::polygon(&[[0.0, 0.0], [a, 0.0], [a + wedge, b], [0.0, b]]).unwrap();
            // The punch is between two rectangles.
            let known = [exact * (1.0 - 2e-4), exact * (1.0 + wedge / a + 2e-4)];
            for tolerance in [1e-3, 2e-4] {
                let limits = Limits { tolerance, ..Limits::default() };
                for found in [flat_stiffness(&outline, &limits), estimated_stiffness(&outline, &limits)] {
                    let [low, high] = found.unwrap().stiffness;
                    assert!(low < known[1] && high > known[0], "{wedge} {tolerance} {low} {high}");
                }
            }
        }
    }

    /// A regular polygon with rounded coordinates is solved as one, and its bounds hold the others' too.
    #[test]
    fn rounded_coordinates() {
        let rounded = |unit: f64| regular(12).iter().map(|p| p.map(|c| (c * unit).round() / unit)).collect::<Vec<_>>();
        let on =
            |corners: &[[f64; 2]]| flat_stiffness(&Outline::polygon(corners).unwrap(), &Limits::default()).unwrap();
        let [exact, fine, coarse] = [regular(12), rounded(1e7), rounded(1e2)].map(|corners| on(&corners));
        assert_eq!(exact.unknowns, fine.unknowns);
        assert!(coarse.unknowns > 2 * exact.unknowns);
        assert!(fine.stiffness[0] < exact.stiffness[1] && fine.stiffness[1] > exact.stiffness[0]);
        assert!((coarse.stiffness[0] / exact.stiffness[0] - 1.0).abs() < 0.01);
    }
}

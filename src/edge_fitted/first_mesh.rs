//! How fine the first mesh of a level flat is: by its shape, or by what a coarse mesh leaves.

use super::Limits;
use super::discrete::Discretisation;
use super::flat::AIM;
use super::outline::{COARSEST, Outline};
use super::tilted_mesh::FINEST;

/// The n that half a width of 1e-3 takes by c (perimeter^2/(4 pi area))^p: slender ones take more. A mesh too many costs less than one that
/// just misses the tolerance. Of 27 triangles by lot all meet it at once and none with a cell too many; of 53 other convex polygons, 40 that
/// are not, and 60 along two lines nine of ten, a third of them with one too many.
const OF_TRIANGLE: [f64; 2] = [6.3, 0.13];
const OF_REGULAR: [f64; 2] = [5.7, 0.0];
/// From 1 : 1 to 1 : 200; beyond about 1 : 10 the rest of the sum is that of the long sides alone.
const OF_RECTANGLE: [f64; 2] = [5.5, 0.27];
const LONG: f64 = 4.0;
const OF_RECTILINEAR: [f64; 2] = [5.0, 0.15];
const OF_CONVEX: [f64; 2] = [6.4, 0.25];
const OF_OTHERS: [f64; 2] = [5.1, 0.2];
const FEW_CORNERS: usize = 8;

/// That n, where the shape of an outline tells it.
fn of_shape(outline: &Outline) -> Option<f64> {
    let (corners, slender) = (outline.corners().len(), outline.slenderness());
    let ([c, p], slender) = match (corners, outline.is_rectilinear()) {
        (3, _) => (OF_TRIANGLE, slender),
        _ if outline.is_regular() => (OF_REGULAR, slender),
        (4, true) => (OF_RECTANGLE, slender.min(LONG)),
        (..=FEW_CORNERS, true) => (OF_RECTILINEAR, slender),
        (_, false) if outline.is_convex() => (OF_CONVEX, slender),
        (..=FEW_CORNERS, false) => (OF_OTHERS, slender),
        _ => return None,
    };
    Some(c * slender.powf(p))
}

/// The n that mostly meets a tolerance.
pub(super) fn usually_enough(outline: &Outline, tolerance: f64) -> f64 {
    by_shape(outline, tolerance).unwrap_or_else(|| by_corners(outline, tolerance))
}

fn by_shape(outline: &Outline, tolerance: f64) -> Option<f64> {
    of_shape(outline).map(|n| (n * (1e-3 / tolerance).cbrt()).ceil())
}

fn by_corners(outline: &Outline, tolerance: f64) -> f64 {
    (0.5 * usual_width(outline) / (AIM * tolerance)).cbrt().round()
}

/// Twice the half width times n^3, as it chooses the first mesh, no more: the wider the fewer corners there are.
pub(super) fn usual_width(outline: &Outline) -> f64 {
    (0.08 + 1.6 / outline.corners().len() as f64).min(0.4)
}

/// Corners of outlines whose width differs from the usual one by more than a coarse mesh costs: stars.
const UNUSUAL: std::ops::RangeInclusive<usize> = 9..=20;

/// The n of that mesh, how much of its half width times n^3 a finer one has, and of n what it may be short of.
pub(super) const COARSE: usize = 2;
const GROWN: f64 = 1.4;
const SHORT_OF: f64 = 0.02;

/// The n that is enough by the width of a coarse mesh.
fn seen_enough(outline: &Outline, limits: &Limits) -> Option<f64> {
    let fitted = outline.mesh(COARSE)?;
    let [low, high] = Discretisation::new(fitted.mesh, &fitted.group, limits.means())?.stiffness()?.bounds;
    let width = (high - low) / (high + low);
    Some((COARSE as f64 * (GROWN * width / limits.tolerance).cbrt() - SHORT_OF).ceil())
}

/// CPU seconds below which the coarsest mesh comes first, so that there is an answer at all.
const SHORT: f64 = 2.0;

/// The n of the first mesh: the coarsest where time is short, and no finer than what may be solved on.
pub(super) fn first(outline: &Outline, limits: &Limits) -> usize {
    if limits.deadline.remaining() < SHORT {
        return COARSEST;
    }
    let fits = |n: &usize| outline.mesh(*n).is_some_and(|fitted| fitted.is_within(limits, 1));
    let seen = || if UNUSUAL.contains(&outline.corners().len()) { seen_enough(outline, limits) } else { None };
    let wanted = by_shape(outline, limits.tolerance).or_else(seen);
    let wanted = wanted.unwrap_or_else(|| by_corners(outline, limits.tolerance)).min(FINEST as f64) as usize;
    (COARSEST..=wanted).rev().find(fits).unwrap_or(COARSEST)
}

//! Hertz inside an edge: where the contact ends before the material does, what is cut off beyond it bears nothing.
//!
//! The pressure of the form without an end leaves no penetration anywhere, so none where there is material: it is that of the form with one.

use super::Ellipse;
use crate::gap::Crown;
use crate::numeric::geometry::{distance_to_segment, minus, norm};

/// Room between the contact and the edge, over the size of the contact.
const ROOM: f64 = 1e-9;

/// Roundings of a point that is turned and moved.
const ROUNDINGS: f64 = 16.0 * f64::EPSILON;

/// Whether the material goes all the way round the contact, rounding counted.
pub(super) fn holds(crown: &Crown, patch: &Ellipse) -> bool {
    let Crown { outline, at, turn, .. } = crown;
    let (sin, cos) = turn.sin_cos();
    let [a, b] = patch.semi_axes;
    let outward = |[u, v]: [f64; 2]| [at[0] + cos * u - sin * v, at[1] + sin * u + cos * v];
    let inward = |p: [f64; 2]| {
        let [x, y] = minus(p, *at);
        [cos * x + sin * y, cos * y - sin * x]
    };
    if !outline.contains(inward(patch.centre)) {
        return false;
    }
    if let Some([outer_a, outer_b]) = outline.semi_axes() {
        // The edge as the unit circle: the contact lies in a disc about its centre there.
        let unit = |[u, v]: [f64; 2]| [u / outer_a, v / outer_b];
        let (sine, cosine) = (patch.orientation - turn).sin_cos();
        let axes = [unit([a * cosine, a * sine]), unit([-b * sine, b * cosine])];
        let largest = largest_singular_value(axes);
        let rounding = ROUNDINGS * (norm(*at) + norm(patch.centre)) / outer_a.min(outer_b);
        return norm(unit(inward(patch.centre))) + largest * (1.0 + ROOM) + rounding <= 1.0;
    }
    // The contact as the unit circle: every side of the edge passes it.
    let unit = |p: [f64; 2]| {
        let [u, v] = patch.local(p);
        [u / a, v / b]
    };
    let corners: Vec<[f64; 2]> = outline.corners().iter().map(|c| outward(*c)).collect();
    (0..corners.len()).all(|k| {
        let [p, q] = [corners[k], corners[(k + 1) % corners.len()]];
        let rounding = ROUNDINGS * (norm(p).max(norm(q)) + norm(patch.centre)) / b;
        distance_to_segment([0.0; 2], unit(p), unit(q)) >= 1.0 + ROOM + rounding
    })
}

/// Of a matrix by its columns.
fn largest_singular_value([[a, c], [b, d]]: [[f64; 2]; 2]) -> f64 {
    0.5 * ((a + d).hypot(c - b) + (a - d).hypot(b + c))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gap::{Outline, Quadratic};

    fn crown(outline: Outline, at: [f64; 2], turn: f64) -> Crown {
        let form = Quadratic { about: [0.0; 2], value: 0.0, gradient: [0.0; 2], hessian: [1.0, 0.0, 1.0] };
        Crown { outline, at, turn, form }
    }

    /// By its boundary, point by point.
    fn holds_points(crown: &Crown, patch: &Ellipse) -> bool {
        let (sin, cos) = crown.turn.sin_cos();
        patch.boundary(20_000).into_iter().all(|p| {
            let [x, y] = minus(p, crown.at);
            crown.outline.contains([cos * x + sin * y, cos * y - sin * x])
        })
    }

    #[test]
    fn it_holds_what_its_points_lie_in() {
        let mut state = 7_u64;
        let mut next = |low: f64, high: f64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            low + (high - low) * ((state >> 11) as f64 / (1_u64 << 53) as f64)
        };
        let (mut held, mut seen) = (0, 0);
        for k in 0..300 {
            let outline = if k % 3 == 0 {
                Outline::ellipse([1.0, next(0.3, 1.0)]).unwrap()
            } else {
                let n = 3 + k % 5;
                let corner = |i: usize| {
                    let angle = std::f64::consts::TAU * i as f64 / n as f64;
                    [angle.cos(), 0.8 * angle.sin()]
                };
                Outline::polygon(&(0..n).map(corner).collect::<Vec<_>>()).unwrap()
            };
            let crown = crown(outline, [next(-3.0, 3.0), next(-3.0, 3.0)], next(-3.0, 3.0));
            let a = next(0.1, 0.9);
            let patch = Ellipse {
                centre: [crown.at[0] + next(-0.2, 0.2), crown.at[1] + next(-0.2, 0.2)],
                semi_axes: [a, a * next(0.1, 1.0)],
                orientation: next(-3.0, 3.0),
            };
            let (says, is) = (holds(&crown, &patch), holds_points(&crown, &patch));
            assert!(is || !says, "{crown:?} {patch:?}");
            // In a polygon no more room is asked for than there is.
            assert!(says == is || crown.outline.semi_axes().is_some(), "{crown:?} {patch:?}");
            held += usize::from(says);
            seen += usize::from(is);
        }
        assert!(held > 40 && seen < 260, "{held} {seen}");
    }
}

//! Flat punches.

use super::{Axis, Degree, Face, Gap, Generatrix, Growth, Known, Law, Material, Outline, Reach, Taylor};
use crate::numeric::Interval;
use crate::numeric::geometry::Rect;

/// Gap zero inside an outline, no material outside: a flat punch with a sharp edge.
///
/// ```
/// use contact_patch::gap::{Flat, Gap, Outline};
/// let punch = Flat::new(Outline::disc(1e-3)?);
/// assert_eq!(punch.gap(0.5e-3, 0.0), 0.0);
/// assert_eq!(punch.gap(1.5e-3, 0.0), f64::INFINITY);
/// # Ok::<(), contact_patch::InputError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Flat {
    outline: Outline,
    centre: [f64; 2],
}

impl Flat {
    /// The flat punch of this plan-form.
    #[must_use]
    pub fn new(outline: Outline) -> Self {
        let centre = outline.inner_point();
        Self { outline, centre }
    }

    /// The plan-form.
    #[must_use]
    pub fn outline(&self) -> &Outline {
        &self.outline
    }
}

impl Gap for Flat {
    fn gap(&self, x: f64, y: f64) -> f64 {
        if self.outline.contains([x, y]) { 0.0 } else { f64::INFINITY }
    }

    fn gradient(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        self.outline.contains([x, y]).then_some([0.0; 2])
    }

    fn describe(&self) -> Known {
        let round = self.outline.semi_axes();
        let disc = round.is_some_and(|[a, b]| a == b);
        Known {
            centre: self.centre,
            floor: 0.0,
            law: Some(Law { degree: Degree::Flat, lowest: 0.0 }),
            axis: disc.then_some(Axis { at: [0.0; 2], generatrix: Generatrix::General }),
            face: Some(Face { outline: self.outline.clone(), at: [0.0; 2], turn: 0.0, value: 0.0, slope: [0.0; 2] }),
            material: Material::Within(self.outline.bounds()),
            // A disc or an ellipse about its centre.
            mirrors: [round.is_some(); 2],
            ends: round.is_none().then(|| self.outline.corners().into()),
            drawn_along: self.outline.longest_side(),
            ..Known::nothing()
        }
    }

    fn reach(&self, depth: f64) -> Reach {
        if depth > 0.0 { Reach::Within(self.outline.bounds()) } else { Reach::Nowhere }
    }

    fn bounds(&self, rect: &Rect, slope: [f64; 2]) -> Option<[f64; 2]> {
        let [w, h] = rect.size();
        let half = (0.5 * (slope[0].abs() * w + slope[1].abs() * h)).next_up();
        let high = if self.outline.covers(rect) { half } else { f64::INFINITY };
        // Seen as far as its box: a part of the rectangle without material does no harm to a lower bound.
        let low = if self.outline.misses(rect) { f64::INFINITY } else { -half };
        Some([low, high])
    }

    fn taylor(&self, rect: &Rect) -> Option<Taylor> {
        let level = Taylor { value: Interval::ZERO, gradient: [Interval::ZERO; 2], hessian: [Interval::ZERO; 3] };
        self.outline.covers(rect).then_some(level)
    }

    fn mean_bounds(&self, rect: &Rect) -> Option<[f64; 2]> {
        Some(if self.outline.covers(rect) {
            [0.0; 2]
        } else {
            [if self.outline.misses(rect) { f64::INFINITY } else { 0.0 }, f64::INFINITY]
        })
    }

    fn growth(&self, _: Interval, from: f64) -> Option<Growth> {
        Growth::ended(&self.outline.bounds(), from)
    }

    fn mean(&self, cell: &Rect) -> f64 {
        if self.outline.covers(cell) { 0.0 } else { f64::INFINITY }
    }

    fn ray_kinks(&self, from: [f64; 2], direction: [f64; 2], kinks: &mut Vec<f64>) {
        self.outline.crossings(from, direction, kinks);
    }

    fn kink_directions(&self, from: [f64; 2], angles: &mut Vec<f64>) {
        self.outline.corner_directions(from, angles);
    }
}

//! A gap moved, turned, or seen in other units.

use nalgebra::{Rotation2, Vector2};

use super::{Gap, Reach, Ridges, mean};
use crate::error::{InputError, finite};
use crate::geometry::Rect;

/// A gap put at a point and turned about it: its value at x is the kind's own gap at R(-rotation)(x - at).
#[derive(Debug, Clone)]
pub struct Placed<G> {
    inner: G,
    at: Vector2<f64>,
    turn: Rotation2<f64>,
    /// The planes whose highest it is, turned but not moved, where they are few.
    turned: Option<Vec<[f64; 3]>>,
}

impl<G: Gap> Placed<G> {
    /// `inner` with its origin at `at`, turned counter-clockwise by `rotation` (radians).
    ///
    /// # Errors
    /// Names `at` or `rotate` when not finite.
    pub fn new(inner: G, at: [f64; 2], rotation: f64) -> Result<Self, InputError> {
        finite("at[0]", at[0])?;
        finite("at[1]", at[1])?;
        let turn = quarter_exact(finite("rotate", rotation)?);
        let few = inner.planes().filter(|planes| planes.len() <= mean::MOST_PLANES);
        let turned = few.map(|planes| {
            let slopes = planes.iter().map(|p| (turn * Vector2::new(p[0], p[1]), p[2]));
            slopes.map(|(s, offset)| [s.x, s.y, offset]).collect()
        });
        Ok(Self { inner, at: at.into(), turn, turned })
    }

    fn inward(&self, p: [f64; 2]) -> [f64; 2] {
        (self.turn.inverse() * (Vector2::from(p) - self.at)).into()
    }

    fn placed(&self, reach: Reach) -> Reach {
        match reach {
            Reach::Within(rect) => {
                Rect::holding(rect.corners().map(|c| self.outward(c))).map_or(Reach::Nowhere, Reach::Within)
            }
            other => other,
        }
    }

    fn outward(&self, p: [f64; 2]) -> [f64; 2] {
        (self.turn * Vector2::from(p) + self.at).into()
    }
}

/// A rotation whose sine and cosine are exact at multiples of 90 degrees, so that symmetry survives.
fn quarter_exact(angle: f64) -> Rotation2<f64> {
    let quarters = angle / std::f64::consts::FRAC_PI_2;
    if (quarters - quarters.round()).abs() > 1e-14 * quarters.abs().max(1.0) {
        return Rotation2::new(angle);
    }
    let (sin, cos) = [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)][quarters.round().rem_euclid(4.0) as usize % 4];
    Rotation2::from_matrix_unchecked(nalgebra::Matrix2::new(cos, -sin, sin, cos))
}

impl<G: Gap> Gap for Placed<G> {
    fn gap(&self, x: f64, y: f64) -> f64 {
        let [x, y] = self.inward([x, y]);
        self.inner.gap(x, y)
    }

    fn gradient(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        let [x, y] = self.inward([x, y]);
        self.inner.gradient(x, y).map(|g| (self.turn * Vector2::from(g)).into())
    }

    fn range(&self, rect: &Rect, slope: [f64; 2]) -> Option<[f64; 2]> {
        let slope = self.turn.inverse() * Vector2::from(slope);
        // The turned rectangle lies within the upright one around its corners, which has the same centre.
        let held = Rect::holding(rect.corners().map(|c| self.inward(c)))?;
        self.inner.range(&held, slope.into())
    }

    fn homogeneous(&self) -> Option<f64> {
        self.inner.homogeneous()
    }

    fn mirrors(&self) -> [bool; 2] {
        let [along, across] = self.inner.mirrors();
        match (self.turn.matrix()[(1, 0)] == 0.0, self.turn.matrix()[(0, 0)] == 0.0) {
            (true, _) => [along, across],
            (_, true) => [across, along],
            _ => [false; 2],
        }
    }

    fn reach(&self, depth: f64) -> Reach {
        self.placed(self.inner.reach(depth))
    }

    fn certain_reach(&self, depth: f64) -> Reach {
        self.placed(self.inner.certain_reach(depth))
    }

    fn pieces(&self, depth: f64) -> Option<Vec<Rect>> {
        let turned = |rect: Rect| Rect::holding(rect.corners().map(|c| self.outward(c)));
        self.inner.pieces(depth).map(|pieces| pieces.into_iter().filter_map(turned).collect())
    }

    fn mean(&self, cell: &Rect) -> f64 {
        // Quarter turns take rectangles to rectangles.
        if self.turn.matrix().iter().any(|&entry| entry == 0.0) {
            let corners = [self.inward(cell.min), self.inward(cell.max)];
            return Rect::holding(corners).map_or(f64::INFINITY, |cell| self.inner.mean(&cell));
        }
        if let Some(planes) = &self.turned {
            let from = |p: [f64; 2]| [p[0] - self.at.x, p[1] - self.at.y];
            return mean::of_planes(planes, &Rect { min: from(cell.min), max: from(cell.max) });
        }
        mean::by_quadrature(|x, y| self.gap(x, y), cell)
    }

    fn ray_kinks(&self, from: [f64; 2], direction: [f64; 2], kinks: &mut Vec<f64>) {
        let direction = self.turn.inverse() * Vector2::from(direction);
        self.inner.ray_kinks(self.inward(from), direction.into(), kinks);
    }

    fn kink_directions(&self, from: [f64; 2], angles: &mut Vec<f64>) {
        let known = angles.len();
        self.inner.kink_directions(self.inward(from), angles);
        angles[known..].iter_mut().for_each(|a| *a += self.turn.angle());
    }

    fn ridges(&self) -> Option<Ridges> {
        let turned = |v: [f64; 2]| (self.turn * Vector2::from(v)).into();
        self.inner.ridges().map(|ridges| ridges.seen(|p| self.outward(p), turned, turned))
    }

    fn centre(&self) -> [f64; 2] {
        self.outward(self.inner.centre())
    }

    fn tips(&self) -> Vec<[f64; 2]> {
        self.inner.tips().into_iter().map(|tip| self.outward(tip)).collect()
    }

    fn reference(&self) -> [f64; 2] {
        self.outward(self.inner.reference())
    }
}

/// A gap in the units of the solvers: its value at xi is g(origin + length xi)/depth.
///
/// Everything behind the door (E* = 1, depth = 1, a length of the contact = 1) sees the gap through this.
#[derive(Clone, Copy)]
pub struct Scaled<'a> {
    /// The gap in the user's units.
    pub gap: &'a dyn Gap,
    /// Where xi = 0 lies.
    pub origin: [f64; 2],
    /// The unit of length along the surface.
    pub length: f64,
    /// The unit of length along the normal.
    pub depth: f64,
}

impl Scaled<'_> {
    /// The point xi in the user's units.
    #[must_use]
    pub fn outward(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.origin[0] + self.length * x, self.origin[1] + self.length * y]
    }

    fn scaled(&self, reach: Reach) -> Reach {
        match reach {
            Reach::Within(r) => Reach::Within(Rect { min: self.inward(r.min), max: self.inward(r.max) }),
            other => other,
        }
    }

    /// A point of the user's in units of length from the origin.
    #[must_use]
    pub fn inward(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [(x - self.origin[0]) / self.length, (y - self.origin[1]) / self.length]
    }
}

impl Gap for Scaled<'_> {
    fn gap(&self, x: f64, y: f64) -> f64 {
        let [x, y] = self.outward([x, y]);
        self.gap.gap(x, y) / self.depth
    }

    fn gradient(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        let [x, y] = self.outward([x, y]);
        self.gap.gradient(x, y).map(|g| g.map(|g| g / self.depth * self.length))
    }

    fn range(&self, rect: &Rect, slope: [f64; 2]) -> Option<[f64; 2]> {
        let outward = Rect { min: self.outward(rect.min), max: self.outward(rect.max) };
        let bounds = self.gap.range(&outward, slope.map(|s| s * self.depth / self.length))?;
        Some(bounds.map(|b| b / self.depth))
    }

    fn homogeneous(&self) -> Option<f64> {
        self.gap.homogeneous()
    }

    fn mirrors(&self) -> [bool; 2] {
        self.gap.mirrors()
    }

    fn reach(&self, depth: f64) -> Reach {
        self.scaled(self.gap.reach(depth * self.depth))
    }

    fn certain_reach(&self, depth: f64) -> Reach {
        self.scaled(self.gap.certain_reach(depth * self.depth))
    }

    fn mean(&self, cell: &Rect) -> f64 {
        self.gap.mean(&Rect { min: self.outward(cell.min), max: self.outward(cell.max) }) / self.depth
    }

    fn ray_kinks(&self, from: [f64; 2], direction: [f64; 2], kinks: &mut Vec<f64>) {
        let known = kinks.len();
        self.gap.ray_kinks(self.outward(from), direction, kinks);
        kinks[known..].iter_mut().for_each(|r| *r /= self.length);
    }

    fn kink_directions(&self, from: [f64; 2], angles: &mut Vec<f64>) {
        self.gap.kink_directions(self.outward(from), angles);
    }

    fn ridges(&self) -> Option<Ridges> {
        let steeper = |jump: [f64; 2]| jump.map(|s| s / self.depth * self.length);
        self.gap.ridges().map(|ridges| ridges.seen(|p| self.inward(p), |v| v, steeper))
    }

    fn centre(&self) -> [f64; 2] {
        self.inward(self.gap.centre())
    }

    fn tips(&self) -> Vec<[f64; 2]> {
        self.gap.tips().into_iter().map(|tip| self.inward(tip)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gap::Polyhedron;

    #[test]
    fn means_of_turned_planes_are_exact() {
        let wedge = Polyhedron::new(vec![[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]).unwrap();
        let eighth = std::f64::consts::FRAC_PI_4;
        // |x'| over a square whose diagonal lies along the ridge: a third of the height over it.
        let diagonal = Placed::new(wedge, [0.0; 2], eighth).unwrap();
        let square = Rect::around([0.0; 2], [1.0; 2]);
        assert!((diagonal.mean(&square) - 2f64.sqrt() / 3.0).abs() < 1e-15);
    }

    #[test]
    fn the_mean_of_turned_planes_is_that_of_their_values() {
        let planes = vec![[1.0, 0.3, 0.0], [-0.5, 0.8, -0.1], [-0.7, -1.1, 0.05], [1.0, 0.3, 0.0], [0.1, 0.0, 0.2]];
        let at = [0.3, -0.2];
        let gap = Placed::new(Polyhedron::new(planes).unwrap(), at, 0.7).unwrap();
        for k in 0..60 {
            let centre = [at[0] + (1.3 * k as f64).sin(), at[1] + (0.7 * k as f64).cos()];
            let cell = Rect::around(centre, [0.05 * (1 + k % 9) as f64, 0.07]);
            // The midpoint rule on many points: exact away from ridges, 1e-5 across them.
            let n = 200;
            let lattice = crate::grid::Grid::over(&cell, [n; 2]);
            let sum: f64 = (0..n * n).map(|m| lattice.centre_of(m)).map(|[x, y]| gap.gap(x, y)).sum();
            let mean = sum / (n * n) as f64;
            assert!((gap.mean(&cell) - mean).abs() < 1e-5, "{k}: {} {mean}", gap.mean(&cell));
        }
        // Far away no digit is lost.
        let far = Placed::new(Polyhedron::pyramid(3, 0.8).unwrap(), [1e6, -3e6], 0.7).unwrap();
        let near = Placed::new(Polyhedron::pyramid(3, 0.8).unwrap(), [0.0; 2], 0.7).unwrap();
        let cell = |x: f64, y: f64| Rect::around([x, y], [0.25, 0.5]);
        assert!((far.mean(&cell(1e6, -3e6)) - near.mean(&cell(0.0, 0.0))).abs() < 1e-9);
    }
}

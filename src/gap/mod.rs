//! The initial gap g(x, y) of the undeformed bodies at zero depth: what every method starts from.
//!
//! [`Gap`] is the open set (any closure is a gap); the types of this module are the kinds that have a name.
//! With depth d the undeformed bodies overlap by f = d - g, the paper's f.

mod analytic;
mod beside;
mod combine;
mod descent;
mod flat;
#[cfg(feature = "formula")]
mod formula;
mod height_map;
mod islands;
mod mean;
mod outline;
mod placed;
mod polyhedron;
mod range;
mod revolved;
mod ridges;
mod search;
mod tilted;
mod tips;

pub use analytic::{Cone, Paraboloid, Power, Sphere};
pub(crate) use beside::Beside;
pub use combine::{Minimum, Sum};
pub(crate) use descent::least;
pub use flat::Flat;
#[cfg(feature = "formula")]
pub use formula::Formula;
pub use height_map::{HeightMap, Heights, MapFormat, Surface, Zero};
pub(crate) use islands::islands;
pub use outline::Outline;
pub use placed::{Placed, Scaled};
pub use polyhedron::Polyhedron;
pub use revolved::Revolved;
pub use ridges::{Ridge, Ridges};
pub use search::extent;
pub use tilted::Tilted;
pub(crate) use tips::{around_tips, enough};

use std::sync::Arc;

use crate::geometry::Rect;

/// Where a gap can be less than a given depth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reach {
    /// Only inside this rectangle.
    Within(Rect),
    /// Nowhere.
    Nowhere,
    /// Without limit in some direction.
    Unbounded,
    /// The gap cannot tell; it has to be searched.
    Unknown,
}

/// An initial gap. Only [`Gap::gap`] has to be given; the rest is what a method can use when it is known.
///
/// A closure `|x, y| ...` is a gap. Where one body has no material the gap is `f64::INFINITY`; NaN is not allowed.
/// The gap may be negative (its zero is the user's choice of reference).
pub trait Gap: Send + Sync {
    /// The gap at (x, y), in units of length.
    fn gap(&self, x: f64, y: f64) -> f64;

    /// (dg/dx, dg/dy) where it is known; at a kink, that of one of the sides.
    fn gradient(&self, _x: f64, _y: f64) -> Option<[f64; 2]> {
        None
    }

    /// Where the gap is less than `depth`. The rectangle may be larger than need be, never smaller.
    fn reach(&self, _depth: f64) -> Reach {
        Reach::Unknown
    }

    /// As [`Gap::reach`], without anything that was searched or sampled: [`Reach::Unknown`] where nothing is certain.
    ///
    /// A gap whose `reach` looks at values must give its own; a proof rests on it.
    fn certain_reach(&self, depth: f64) -> Reach {
        self.reach(depth)
    }

    /// Rectangles that together hold all of {g < depth}: one around each separate piece, as far as the gap can tell them
    /// apart. They may overlap. `None` when there is no end to it.
    fn pieces(&self, depth: f64) -> Option<Vec<Rect>> {
        match self.reach(depth) {
            Reach::Within(rect) => Some(vec![rect]),
            Reach::Nowhere => Some(Vec::new()),
            Reach::Unbounded => None,
            Reach::Unknown => search::pieces(&|x, y| self.gap(x, y), depth, self.centre()),
        }
    }

    /// k when g(c + s v) = s^k g(c + v) for every s > 0 with c = [`Gap::centre`], by construction; infinite for a flat with a
    /// sharp edge, whose force grows with the depth itself. A proof rests on it.
    fn homogeneous(&self) -> Option<f64> {
        None
    }

    /// Mean of the gap over a rectangle. Infinite where any part has no material.
    fn mean(&self, cell: &Rect) -> f64 {
        mean::by_quadrature(|x, y| self.gap(x, y), cell)
    }

    /// Bounds of g(x) - slope . (x - c) over a rectangle with centre c: nowhere less than the first, nowhere more than the
    /// second (infinite where any part has no material). `None` when the gap cannot prove any.
    ///
    /// The bounds hold up to the rounding of [`Gap::gap`] itself. They may be wider than need be; the closer they are,
    /// the narrower a proved bracket of the force ([`crate::bracket`]).
    fn range(&self, _rect: &Rect, _slope: [f64; 2]) -> Option<[f64; 2]> {
        None
    }

    /// Whether the gap is its own image in the line x = c, and in y = c, through [`Gap::centre`], by construction. A proof
    /// rests on it.
    fn mirrors(&self) -> [bool; 2] {
        [false; 2]
    }

    /// Appends the distances r > 0 at which the gap along the ray `from + r direction` has a kink
    /// (a jump of its slope). `direction` is a unit vector. Order does not matter.
    fn ray_kinks(&self, _from: [f64; 2], _direction: [f64; 2], _kinks: &mut Vec<f64>) {}

    /// Appends the angles theta at which the gap, seen from `from`, is not smooth as a function of theta
    /// for fixed small r: the ridges and valleys that meet there, and the corners further out.
    fn kink_directions(&self, _from: [f64; 2], _angles: &mut Vec<f64>) {}

    /// All ridges of a gap that is the highest of several planes; `None` for any other. With them the integrals over an
    /// ellipse have a closed form ([`crate::ritz`]).
    fn ridges(&self) -> Option<Ridges> {
        None
    }

    /// The planes `[slope_x, slope_y, offset]` whose highest the gap is everywhere; `None` where the gap does not tell.
    fn planes(&self) -> Option<&[[f64; 3]]> {
        None
    }

    /// A point to start looking from; the apex, where there is one.
    fn centre(&self) -> [f64; 2] {
        [0.0, 0.0]
    }

    /// Points about which the gap, or a part of it, is drawn: where a narrow part would stand out that no even sampling meets.
    fn tips(&self) -> Vec<[f64; 2]> {
        vec![self.centre()]
    }

    /// The point that the gap was drawn about: where its own origin lies.
    fn reference(&self) -> [f64; 2] {
        [0.0, 0.0]
    }
}

/// A gap behind a shared pointer, so that gaps of different kinds can stand side by side.
#[derive(Clone)]
pub struct AnyGap(Arc<dyn Gap>);

impl AnyGap {
    /// Any gap, its kind forgotten.
    pub fn new(gap: impl Gap + 'static) -> Self {
        Self(Arc::new(gap))
    }
}

impl std::fmt::Debug for AnyGap {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("AnyGap")
    }
}

impl std::ops::Deref for AnyGap {
    type Target = dyn Gap;

    fn deref(&self) -> &Self::Target {
        &*self.0
    }
}

impl Gap for AnyGap {
    fn gap(&self, x: f64, y: f64) -> f64 {
        self.0.gap(x, y)
    }

    fn gradient(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        self.0.gradient(x, y)
    }

    fn reach(&self, depth: f64) -> Reach {
        self.0.reach(depth)
    }

    fn certain_reach(&self, depth: f64) -> Reach {
        self.0.certain_reach(depth)
    }

    fn pieces(&self, depth: f64) -> Option<Vec<Rect>> {
        self.0.pieces(depth)
    }

    fn homogeneous(&self) -> Option<f64> {
        self.0.homogeneous()
    }

    fn mean(&self, cell: &Rect) -> f64 {
        self.0.mean(cell)
    }

    fn range(&self, rect: &Rect, slope: [f64; 2]) -> Option<[f64; 2]> {
        self.0.range(rect, slope)
    }

    fn mirrors(&self) -> [bool; 2] {
        self.0.mirrors()
    }

    fn ray_kinks(&self, from: [f64; 2], direction: [f64; 2], kinks: &mut Vec<f64>) {
        self.0.ray_kinks(from, direction, kinks);
    }

    fn kink_directions(&self, from: [f64; 2], angles: &mut Vec<f64>) {
        self.0.kink_directions(from, angles);
    }

    fn ridges(&self) -> Option<Ridges> {
        self.0.ridges()
    }

    fn planes(&self) -> Option<&[[f64; 3]]> {
        self.0.planes()
    }

    fn centre(&self) -> [f64; 2] {
        self.0.centre()
    }

    fn tips(&self) -> Vec<[f64; 2]> {
        self.0.tips()
    }

    fn reference(&self) -> [f64; 2] {
        self.0.reference()
    }
}

impl<F: Fn(f64, f64) -> f64 + Send + Sync> Gap for F {
    fn gap(&self, x: f64, y: f64) -> f64 {
        self(x, y)
    }
}

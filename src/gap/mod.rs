//! The initial gap g(x, y) of the undeformed bodies at zero depth: what every method starts from.
//!
//! [`Gap`] is the open set (any closure is a gap); the types of this module are the kinds that have a name.
//! With depth d the undeformed bodies overlap by f = d - g, the paper's f.
//!
//! A gap says what is *known* of it: what follows from the way it is written ([`Known`], [`Gap::reach`], [`Gap::bounds`] and the other
//! methods with a default that knows nothing). It never searches or samples; [`crate::overlap`] does, and marks what it found.

mod any;
mod cone;
mod declared;
pub(crate) mod enclosure;
mod envelope;
mod extremes;
mod fan;
mod flat;
#[cfg(feature = "formula")]
mod formula;
mod growth;
mod height_map;
mod known;
pub(crate) mod lattice;
mod left_open;
mod mean;
mod minimum;
mod of_parts;
mod outline;
mod paraboloid;
mod polyhedron;
mod power;
mod profile;
mod radial;
mod range;
mod revolved;
mod ridges;
mod rounded_tip;
mod sphere;
mod spline;
mod spline_map;
mod sum;
mod taylor;
mod transform;

pub use any::AnyGap;
pub use cone::Cone;
pub use declared::Declared;
pub use flat::Flat;
#[cfg(feature = "formula")]
pub use formula::Formula;
pub use growth::Growth;
pub use height_map::{HeightMap, Heights, MapFormat, Surface, Zero};
pub use known::{Axis, Crown, Degree, Face, Generatrix, Known, Law, Material, Quadratic};
pub use left_open::LeftOpen;
pub use minimum::Minimum;
pub use outline::Outline;
pub use paraboloid::Paraboloid;
pub use polyhedron::Polyhedron;
pub use power::Power;
pub use profile::{Along, Interpolation, Line, LineFormat, Profile};
pub use revolved::Revolved;
pub use ridges::{Ridge, Ridges};
pub use rounded_tip::RoundedTip;
pub use sphere::Sphere;
pub use spline_map::SplineMap;
pub use sum::Sum;
pub(crate) use taylor::half_sides;
pub use taylor::{Cubic, Taylor};

use std::sync::Arc;

use crate::error::InputError;
use crate::grid::Grid;
use crate::numeric::Interval;
use crate::numeric::geometry::Rect;

/// Where a gap is less than a given depth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reach {
    /// Only inside this rectangle.
    Within(Rect),
    /// Nowhere.
    Nowhere,
    /// Without limit: at every point of a ray.
    Unbounded {
        /// Where the ray begins.
        from: [f64; 2],
        /// Its angle, radians from x.
        along: f64,
    },
    /// Not known.
    Unknown,
}

/// An edge of what is known of a surface, which need not be an end of the body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DataEdge {
    /// The outermost nodes of a height map.
    Map,
    /// A hole of a height map: a node without a value.
    Hole,
    /// The border of the region of a formula.
    Region,
}

impl DataEdge {
    /// The word in results.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Map => "map",
            Self::Hole => "hole",
            Self::Region => "region",
        }
    }
}

/// An initial gap. Only [`Gap::gap`] has to be given; the rest is what a method can use when it is known.
///
/// A closure `|x, y| ...` is a gap. Where one body has no material the gap is `f64::INFINITY`. NaN stands for a value that cannot be
/// told (an overflow); it proves nothing. The gap may be negative (its zero is the user's choice of reference).
///
/// | method | used for |
/// |---|---|
/// | `describe`, `reach`, `components` | which method applies, the grid, closed forms, similarity |
/// | `bounds`, `taylor`, `mean_bounds`, `growth` | proofs; the same through sums and minima |
/// | `gradient`, `mean` | accuracy and speed of grids |
/// | `ray_kinks`, `kink_directions`, `ridges`, `planes` | the approximate methods |
///
/// Everything that an implementation claims has to hold everywhere: proofs rest on it. The defaults claim nothing.
pub trait Gap: Send + Sync {
    /// The gap at (x, y), in units of length.
    fn gap(&self, x: f64, y: f64) -> f64;

    /// The gap at several points: `to[k]` at `points[k]`.
    fn gaps(&self, points: &[[f64; 2]], to: &mut [f64]) {
        one_by_one(self, points, to);
    }

    /// (dg/dx, dg/dy) where it is known; at a kink, that of one of the sides.
    fn gradient(&self, _x: f64, _y: f64) -> Option<[f64; 2]> {
        None
    }

    /// What is known at no depth in particular.
    fn describe(&self) -> Known {
        Known::nothing()
    }

    /// Where the gap is less than `depth`. The rectangle may be larger than need be, never smaller.
    fn reach(&self, _depth: f64) -> Reach {
        Reach::Unknown
    }

    /// Rectangles that together hold all of {g < depth}: one around each separate piece, as far as the gap can tell them
    /// apart. They may overlap. `None` when that is not known.
    fn components(&self, depth: f64) -> Option<Vec<Rect>> {
        match self.reach(depth) {
            Reach::Within(rect) => Some(vec![rect]),
            Reach::Nowhere => Some(Vec::new()),
            Reach::Unbounded { .. } | Reach::Unknown => None,
        }
    }

    /// Mean of the gap over a rectangle. Infinite where any part has no material.
    fn mean(&self, cell: &Rect) -> f64 {
        mean::by_values(&|points, to| self.gaps(points, to), cell)
    }

    /// Bounds of g(x) - slope . (x - c) over a rectangle with centre c: nowhere less than the first, nowhere more than the
    /// second (infinite where any part has no material). `None` when the gap cannot prove any. The closer they are,
    /// the narrower a proved bracket of the force ([`crate::bracket`]).
    fn bounds(&self, _rect: &Rect, _slope: [f64; 2]) -> Option<[f64; 2]> {
        None
    }

    /// Value and slopes in the middle of a rectangle and second derivatives over it, enclosed. `None` where the gap is not
    /// smooth there, ends there, or cannot prove it.
    fn taylor(&self, _rect: &Rect) -> Option<Taylor> {
        None
    }

    /// The same with second derivatives in the middle and third ones over the rectangle. `None` where they are not known.
    fn cubic(&self, _rect: &Rect) -> Option<Cubic> {
        None
    }

    /// Bounds of dg/dx and dg/dy wherever in a rectangle they exist. `None` where the gap may jump or end there, or cannot prove any.
    fn slopes(&self, rect: &Rect) -> Option<[Interval; 2]> {
        self.taylor(rect).map(|taylor| taylor.slopes(rect.size()))
    }

    /// Bounds of the mean over a rectangle.
    fn mean_bounds(&self, rect: &Rect) -> Option<[f64; 2]> {
        enclosure::mean(self, rect)
    }

    /// Bounds along the rays from the origin whose angles lie in `sector`, from a distance on.
    fn growth(&self, _sector: Interval, _from: f64) -> Option<Growth> {
        None
    }

    /// Whether parts of the gap are measured, so that its samples leave something open ([`Gap::sampling_error`]).
    fn is_measured(&self) -> bool {
        false
    }

    /// How far the gap may be, over a rectangle, from the surface that was measured: what lies between its samples, and what is left
    /// of their noise. An estimate from the samples alone; 0 where the gap is given by construction.
    fn sampling_error(&self, _rect: &Rect) -> f64 {
        0.0
    }

    /// The same at each of several places, on the mean over it.
    fn left_open(&self, places: &[Rect]) -> Vec<LeftOpen> {
        vec![LeftOpen::default(); places.len()]
    }

    /// The same gap inside a rectangle, simpler where only some of its parts matter there; outside, anything.
    fn restricted(&self, _rect: &Rect) -> Option<AnyGap> {
        None
    }

    /// Whether [`Gap::restricted`] may find a simpler gap in a smaller rectangle.
    fn is_composed(&self) -> bool {
        false
    }

    /// The gaps whose sum it is, when it is one of several.
    fn addends(&self) -> Option<Vec<AnyGap>> {
        None
    }

    /// The terms whose sum it is, as it is written: those of a sum, those of a formula.
    fn terms(&self) -> Option<Vec<AnyGap>> {
        self.addends()
    }

    /// The gaps whose least it is, when it is one of several tips.
    fn alternatives(&self) -> Option<Vec<AnyGap>> {
        None
    }

    /// The same gap with material everywhere, where more is known of that and all that it overlaps at this depth lies where there is
    /// material: the end of the material then bears nothing and is never met. For certain.
    fn without_end(&self, _depth: f64) -> Option<AnyGap> {
        None
    }

    /// Appends the distances r > 0 at which the gap along the ray `from + r direction` has a kink
    /// (a jump of its slope). `direction` is a unit vector. Order does not matter.
    fn ray_kinks(&self, _from: [f64; 2], _direction: [f64; 2], _kinks: &mut Vec<f64>) {}

    /// Appends the angles theta at which the gap, seen from `from`, is not smooth as a function of theta
    /// for fixed small r: the ridges and valleys that meet there, and the corners further out.
    fn kink_directions(&self, _from: [f64; 2], _angles: &mut Vec<f64>) {}

    /// All ridges of a gap that is the highest of several planes; `None` for any other. With them the integrals over an
    /// ellipse have a closed form ([`crate::approximate::ritz`]).
    fn ridges(&self) -> Option<Ridges> {
        None
    }

    /// Which end of measured or declared data leaves the gap without a value at a point; `None` where it has one, and where the
    /// material itself ends (the edge of a flat punch).
    fn end_of_data(&self, _x: f64, _y: f64) -> Option<DataEdge> {
        None
    }

    /// Cells around the nodes of the height map that the gap is made from: the centre of each is a node.
    fn nodes(&self) -> Option<Grid> {
        None
    }

    /// The planes `[slope_x, slope_y, offset]` whose highest the gap is everywhere; `None` where the gap does not tell.
    fn planes(&self) -> Option<Vec<[f64; 3]>> {
        None
    }

    /// The gap behind a shared pointer.
    fn into_any(self) -> AnyGap
    where
        Self: Sized + 'static,
    {
        AnyGap::of(Arc::new(self))
    }
}

/// The gap at several points, each by itself.
fn one_by_one(gap: &(impl Gap + ?Sized), points: &[[f64; 2]], to: &mut [f64]) {
    points.iter().zip(to).for_each(|(p, to)| *to = gap.gap(p[0], p[1]));
}

/// Any gap, put somewhere else or tilted.
pub trait Place: Gap + Clone + 'static {
    /// With its origin at `at` and turned about it, counter-clockwise, by `rotation` (radians): the value at x is the gap's own at
    /// R(-rotation)(x - at).
    ///
    /// # Errors
    /// Names `at` or `rotate` when not finite.
    fn placed(&self, at: [f64; 2], rotation: f64) -> Result<AnyGap, InputError> {
        AnyGap::from(self).placed(at, rotation)
    }

    /// Under a body tilted by (ax, ay), radians, small: with depth d the overlap is d + ax x + ay y - g.
    fn tilted(&self, tilt: [f64; 2]) -> AnyGap {
        AnyGap::from(self).tilted(tilt)
    }
}

impl<G: Gap + Clone + 'static> Place for G {}

impl<F: Fn(f64, f64) -> f64 + Send + Sync> Gap for F {
    fn gap(&self, x: f64, y: f64) -> f64 {
        self(x, y)
    }
}

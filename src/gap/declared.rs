//! A closure with what its author knows about it.

use super::{Axis, Degree, Gap, Generatrix, Growth, Known, Law, Material, Outline, Reach};
use crate::numeric::Interval;
use crate::numeric::geometry::Rect;

type Slopes = Box<dyn Fn(f64, f64) -> [f64; 2] + Send + Sync>;

/// A gap given by a function, with facts that its author vouches for: closed forms, scaling and proofs rest on them.
///
/// A closure alone is a gap, too; nothing is then known of it but its values.
///
/// ```
/// use contact_patch::gap::{Declared, Degree, Gap, Outline};
/// // Homogeneous of degree 3 about the origin, and nowhere below 0.
/// let gap = Declared::new(|x: f64, y: f64| x.abs().powi(3) + 2.0 * y.abs().powi(3)).homogeneous(3.0).floor(0.0);
/// assert_eq!(gap.describe().degree(), Some(Degree::Power(3.0)));
/// // Cut off by an edge: no similarity any more.
/// let cut = gap.within(Outline::disc(1.0)?);
/// assert_eq!(cut.describe().degree(), None);
/// # Ok::<(), contact_patch::InputError>(())
/// ```
pub struct Declared<F> {
    value: F,
    slopes: Option<Slopes>,
    outline: Option<Outline>,
    known: Known,
}

impl<F: Fn(f64, f64) -> f64 + Send + Sync> Declared<F> {
    /// The gap with these values, everywhere.
    #[must_use]
    pub fn new(value: F) -> Self {
        Self { value, slopes: None, outline: None, known: Known { material: Material::Everywhere, ..Known::nothing() } }
    }

    /// Its slopes (dg/dx, dg/dy).
    #[must_use]
    pub fn slopes(self, slopes: impl Fn(f64, f64) -> [f64; 2] + Send + Sync + 'static) -> Self {
        Self { slopes: Some(Box::new(slopes)), ..self }
    }

    /// The point about which it is drawn. To be said before what refers to it.
    #[must_use]
    pub fn apex(mut self, point: [f64; 2]) -> Self {
        self.known.centre = point;
        self
    }

    /// It is nowhere less than this.
    #[must_use]
    pub fn floor(mut self, floor: f64) -> Self {
        self.known.floor = floor;
        self
    }

    /// g(c + s v) - g(c) = s^degree (g(c + v) - g(c)) about the apex c.
    #[must_use]
    pub fn homogeneous(mut self, degree: f64) -> Self {
        let [x, y] = self.known.centre;
        self.known.law = Some(Law { degree: Degree::Power(degree), lowest: (self.value)(x, y) });
        self
    }

    /// It depends on the distance from the apex alone.
    #[must_use]
    pub fn of_revolution(mut self) -> Self {
        self.known.axis = Some(Axis { at: self.known.centre, generatrix: Generatrix::General });
        self
    }

    /// It is its own image in the lines x = c (the first) and y = c through the apex.
    #[must_use]
    pub fn mirrored(mut self, in_lines: [bool; 2]) -> Self {
        self.known.mirrors = in_lines;
        self
    }

    /// No material outside of this outline.
    #[must_use]
    pub fn within(mut self, outline: Outline) -> Self {
        let own = self.known.centre;
        let centre = if outline.contains(own) { own } else { outline.inner_point() };
        let disc = outline.semi_axes().is_some_and(|[a, b]| a == b);
        self.known = Known {
            law: None,
            axis: self.known.axis.filter(|axis| disc && axis.at == [0.0; 2]),
            mirrors: outline.mirrors_of(&self.known, centre),
            recurs_along: None,
            material: Material::Within(outline.bounds()),
            centre,
            ..self.known
        };
        self.outline = Some(outline);
        self
    }

    fn is_outside(&self, point: [f64; 2]) -> bool {
        self.outline.as_ref().is_some_and(|outline| !outline.contains(point))
    }
}

impl<F: Fn(f64, f64) -> f64 + Send + Sync> Gap for Declared<F> {
    fn gap(&self, x: f64, y: f64) -> f64 {
        if self.is_outside([x, y]) { f64::INFINITY } else { (self.value)(x, y) }
    }

    fn gradient(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        self.slopes.as_ref().filter(|_| !self.is_outside([x, y])).map(|slopes| slopes(x, y))
    }

    fn describe(&self) -> Known {
        self.known.clone()
    }

    fn reach(&self, depth: f64) -> Reach {
        match (&self.outline, depth <= self.known.floor) {
            (_, true) => Reach::Nowhere,
            (Some(outline), _) => Reach::Within(outline.bounds()),
            _ => Reach::Unknown,
        }
    }

    fn growth(&self, _: Interval, from: f64) -> Option<Growth> {
        Growth::ended(&self.outline.as_ref()?.bounds(), from)
    }

    fn mean(&self, cell: &Rect) -> f64 {
        if self.outline.as_ref().is_some_and(|outline| !outline.covers(cell)) {
            return f64::INFINITY;
        }
        super::mean::by_quadrature(|x, y| (self.value)(x, y), cell)
    }

    fn ray_kinks(&self, from: [f64; 2], direction: [f64; 2], kinks: &mut Vec<f64>) {
        if let Some(outline) = &self.outline {
            outline.crossings(from, direction, kinks);
        }
    }

    fn kink_directions(&self, from: [f64; 2], angles: &mut Vec<f64>) {
        if let Some(outline) = &self.outline {
            outline.corner_directions(from, angles);
        }
    }
}

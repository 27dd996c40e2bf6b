//! Gaps written as formulas.

mod advice;
mod as_gap;
mod far;
mod functions;
mod kinks;
mod lanes;
mod parse;
mod planes;
mod smooth;
mod structure;
mod tape;

use std::sync::OnceLock;

use super::{
    Axis, Crown, Degree, Gap, Generatrix, Known, Law, Material, Outline, Polyhedron, Reach, enclosure, growth, sum,
};
use crate::error::InputError;
use crate::numeric::Interval;
use crate::numeric::derivatives::Jet;
use crate::numeric::geometry::Rect;
use functions::{Number, Two};
use lanes::{LANES, Lanes};
use smooth::{Enclosed, Smooth};
use structure::Tree;
use tape::Tape;

const R: usize = 2;
const THETA: usize = 3;

/// A gap written as a formula in x, y, r = sqrt(x^2 + y^2) and theta = atan2(y, x) (radians).
///
/// - Operators by falling precedence: `^` or `**` (from the right: 2^3^2 = 2^9; -x^2 = -(x^2)), sign, `*` `/`, `+` `-`.
///   A product needs its `*`.
/// - Functions: abs, sign, sqrt, cbrt, exp, ln (also log), log10, log2, sin, cos, tan, asin, acos, atan, sinh, cosh,
///   tanh, floor, ceil, atan2(y, x), hypot(a, b), pow(a, b), and min and max of two or more.
/// - Constants: pi, e. Numbers: `2`, `0.5`, `.5`, `1e-3`.
///
/// Where the value is not a finite number (the root of a negative number, a division by zero) there is no material.
///
/// ```
/// use contact_patch::gap::{Formula, Gap};
/// let gap = Formula::new("x^2/2 + 0.1*abs(y)^3")?;
/// assert_eq!(gap.gap(1.0, -2.0), 0.5 + 0.1 * 8.0);
/// assert_eq!(gap.gradient(1.0, -2.0), Some([1.0, -0.30000000000000004 * 4.0]));
/// let error = Formula::new("x^2/2 + 0.1*abs(y^3").unwrap_err();
/// assert!(error.to_string().contains("column 20"), "{error}");
/// # Ok::<(), contact_patch::InputError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Formula {
    expression: String,
    tape: Tape,
    smooth: Smooth,
    region: Option<Outline>,
    polyhedron: Option<Polyhedron>,
    known: Known,
    /// The reach at a depth of 1 above the lowest point of a formula with a law and without a region.
    unit_reach: OnceLock<Reach>,
    /// Radii of kinks about the axis, where there is one.
    rings: OnceLock<Vec<f64>>,
    /// The same without its region, where more is known of that.
    endless: OnceLock<Option<Box<Self>>>,
}

impl Formula {
    /// The gap with this formula, everywhere.
    ///
    /// # Errors
    /// Names `expression`, with the column of what cannot be read or is not known. At most 4000 characters and 48
    /// operands that wait for one another; no value anywhere is an error too.
    pub fn new(expression: &str) -> Result<Self, InputError> {
        Self::build(expression, parse::parse(expression)?, None)
    }

    /// The same with material only inside `region`.
    ///
    /// # Errors
    /// As [`Formula::new`].
    pub fn within(expression: &str, region: Outline) -> Result<Self, InputError> {
        Self::build(expression, parse::parse(expression)?, Some(region))
    }

    fn build(expression: &str, tape: Tape, region: Option<Outline>) -> Result<Self, InputError> {
        let (tree, smooth) = (Tree::new(&tape), Smooth::of(&tape));
        let polyhedron = if region.is_none() { planes::polyhedron(&tape) } else { None };
        let known = Known::nothing();
        let (unit_reach, rings, endless) = (OnceLock::new(), OnceLock::new(), OnceLock::new());
        let expression_of = expression.to_owned();
        let mut formula =
            Self { expression: expression_of, tape, smooth, region, polyhedron, known, unit_reach, rings, endless };
        formula.known = match &formula.polyhedron {
            Some(polyhedron) => polyhedron.describe(),
            None => formula.read(&tree),
        };
        let place = formula.region.as_ref().map_or_else(everywhere, Outline::bounds);
        let values = formula.values(&place);
        if values.is_empty() || values.lo == f64::INFINITY || values.hi == f64::NEG_INFINITY {
            let allowed = "a formula with a finite value somewhere in its region";
            return Err(InputError::new("expression", expression, allowed));
        }
        Ok(formula)
    }

    /// What the tree tells.
    fn read(&self, tree: &Tree) -> Known {
        let about = tree.about();
        let quadratic = tree.quadratic();
        let axis = tree.generatrix().map(|generatrix| Axis { at: about, generatrix });
        let law = tree.law();
        let place = self.region.as_ref().map_or_else(everywhere, Outline::bounds);
        let values = self.values(&place);
        let mut known = Known {
            centre: about,
            floor: values.lo,
            law,
            quadratic,
            axis,
            material: Material::Everywhere,
            mirrors: tree.mirrors(),
            recurs_along: tree.recurs_along(),
            ..Known::nothing()
        };
        if let Some(lowest) = quadratic.and_then(|q| q.lowest()) {
            // A form that curves upwards is symmetric and homogeneous about its lowest point.
            if lowest != known.centre {
                let straight = quadratic.is_some_and(|q| q.hessian[1] == 0.0);
                known = Known { centre: lowest, mirrors: [straight; 2], law: quadratic.and_then(sum::law_of), ..known };
                known.axis = known.axis.filter(|axis| axis.at == lowest);
            }
        }
        known.floor = known.floor.max(quadratic.map_or(f64::NEG_INFINITY, |q| q.floor()));
        match &self.region {
            Some(region) => self.cut(known, region),
            None => known,
        }
    }

    /// What is left of it inside a region: no law but that of a flat, no form that holds everywhere.
    fn cut(&self, known: Known, region: &Outline) -> Known {
        let round = region.semi_axes();
        let disc = round.is_some_and(|[a, b]| a == b);
        let crown = known.quadratic.map(|form| Crown { outline: region.clone(), at: [0.0; 2], turn: 0.0, form });
        let face = crown.as_ref().and_then(Crown::face);
        let level = face.as_ref().filter(|face| face.slope == [0.0; 2]);
        let inside = region.contains(known.centre);
        let at = |[x, y]: [f64; 2]| self.value(x, y);
        let keeps = inside && level.is_none() && at(known.centre) <= at(region.inner_point());
        let centre = if keeps { known.centre } else { region.inner_point() };
        Known {
            centre,
            law: level.map(|face| Law { degree: Degree::Flat, lowest: face.value }),
            quadratic: None,
            axis: known
                .axis
                .filter(|axis| disc && axis.at == [0.0; 2])
                .map(|axis| Axis { generatrix: Generatrix::General, ..axis }),
            material: Material::Within(region.bounds()),
            mirrors: region.mirrors_of(&known, centre),
            recurs_along: None,
            face,
            crown: crown.filter(|crown| crown.form.hessian != [0.0; 3]),
            ends: (round.is_none()).then(|| region.corners().into()),
            drawn_along: region.longest_side(),
            ..known
        }
    }

    /// Bounds of the values over a rectangle, of the formula alone.
    fn values(&self, rect: &Rect) -> Interval {
        let [x, y] = [0, 1].map(|m| Interval::new(rect.min[m], rect.max[m]));
        let r = if self.tape.uses(R) { x.hypot(y) } else { Interval::ZERO };
        let theta = if self.tape.uses(THETA) { y.atan2(x) } else { Interval::ZERO };
        // A value that is not finite is none: minus infinity, too, is where there is no material.
        self.tape.run([x, y, r, theta])
    }

    /// Bounds of the gap over a rectangle, the region counted.
    fn range(&self, rect: &Rect) -> [f64; 2] {
        let (inside, covered) = match &self.region {
            Some(region) => (rect.intersection(&region.bounds()), region.covers(rect)),
            None => (Some(*rect), true),
        };
        let missed = self.region.as_ref().is_some_and(|region| region.misses(rect));
        let Some(inside) = inside.filter(|_| !missed) else { return [f64::INFINITY; 2] };
        let values = self.values(&inside);
        if values.is_empty() {
            return [f64::INFINITY; 2];
        }
        [values.lo, if covered && values.defined { values.hi } else { f64::INFINITY }]
    }

    fn searched_reach(&self, depth: f64) -> Reach {
        let outer = match &self.region {
            Some(region) => Reach::Within(region.bounds()),
            None => {
                let mirrors = [0, 1].map(|m| self.known.mirrors[m] && self.known.centre[m] == 0.0);
                growth::reach(|sector, from| self.growth(sector, from), depth, mirrors)
            }
        };
        match outer {
            Reach::Within(rect) => {
                let mirrors = (self.known.centre, self.known.mirrors);
                let enough = if self.gains_by_taylor(&rect) { depth } else { f64::NEG_INFINITY };
                enclosure::tightened(&|rect| self.lower(rect, enough), depth, &rect, mirrors)
            }
            other => other,
        }
    }

    /// Whether values that occur several times in the formula make the simple bound too wide: looked at in a few places.
    fn gains_by_taylor(&self, outer: &Rect) -> bool {
        let [w, h] = outer.size();
        [0.3, 0.45, 0.6, 0.85].into_iter().any(|t| {
            let c = [outer.min[0] + t * w, outer.min[1] + (1.1 - t) * h];
            let rect = Rect::around(c, [w / 64.0, h / 64.0]);
            let [low, high] = self.range(&rect);
            let closer = self.taylor(&rect).map_or(low, |taylor| taylor.bounds(rect.size(), [0.0; 2])[0]);
            closer - low > 0.1 * (high - low)
        })
    }

    /// A lower bound over a rectangle; the closer one where the simple one is not above `enough`.
    fn lower(&self, rect: &Rect, enough: f64) -> f64 {
        let low = self.range(rect)[0];
        if low >= enough {
            return low;
        }
        match self.taylor(rect) {
            Some(taylor) => low.max(taylor.bounds(rect.size(), [0.0; 2])[0]),
            None => low,
        }
    }

    /// The formula as given.
    #[must_use]
    pub fn expression(&self) -> &str {
        &self.expression
    }

    /// The formulas that it is the least of, where more is known of each of them than of all together: it is a `min` of several, all of which
    /// have a value everywhere, and no law, axis or planes of the whole are known.
    ///
    /// ```
    /// use contact_patch::gap::{Formula, Gap};
    /// let tips = Formula::new("min((x - 1)^2 + y^2, (x + 1)^2 + y^2 + 0.1)")?.parts();
    /// assert_eq!(tips.unwrap()[1].describe().centre, [-1.0, 0.0]);
    /// # Ok::<(), contact_patch::InputError>(())
    /// ```
    #[must_use]
    pub fn parts(&self) -> Option<Vec<Self>> {
        let Known { law, axis, .. } = &self.known;
        if self.region.is_some() || self.polyhedron.is_some() || law.is_some() || axis.is_some() {
            return None;
        }
        let parts = self.tape.minima();
        // Where one of them has no value the whole has none.
        let one = |tape: Tape| {
            let part = Self::build(&self.expression, tape, None).ok()?;
            part.values(&everywhere()).defined.then_some(part)
        };
        if parts.len() > 1 { parts.into_iter().map(one).collect() } else { None }
    }

    /// Where there is material, if that was said.
    #[must_use]
    pub fn region(&self) -> Option<&Outline> {
        self.region.as_ref()
    }

    /// Without its region, where that leaves a law, a form, an axis or planes to be known.
    fn endless(&self) -> Option<&Self> {
        let find = || {
            let whole = Self::build(&self.expression, self.tape.clone(), None).ok()?;
            (whole.known.is_telling() || whole.polyhedron.is_some()).then(|| Box::new(whole))
        };
        self.region.as_ref()?;
        self.endless.get_or_init(find).as_deref()
    }

    /// The same gap as planes, when the formula is a convex one made of planes (sums, multiples, max and abs of linear
    /// terms) and has no region.
    #[must_use]
    pub fn polyhedron(&self) -> Option<&Polyhedron> {
        self.polyhedron.as_ref()
    }

    fn value(&self, x: f64, y: f64) -> f64 {
        let r = if self.tape.uses(R) { x.hypot(y) } else { 0.0 };
        let theta = if self.tape.uses(THETA) { y.atan2(x) } else { 0.0 };
        let value = self.tape.run([x, y, r, theta]);
        if value.is_finite() {
            return value;
        }
        // No value at all, or one that the numbers could not hold on the way.
        if self.values(&Rect { min: [x, y], max: [x, y] }).is_empty() || !self.tape.overflows([x, y, r, theta]) {
            f64::INFINITY
        } else {
            f64::NAN
        }
    }

    /// The formula at several points; inside its region.
    fn values_at(&self, points: &[[f64; 2]], to: &mut [f64]) {
        for (points, to) in points.chunks(LANES).zip(to.chunks_mut(LANES)) {
            // Places beyond the last point repeat it.
            let along = |m: usize| Lanes(std::array::from_fn(|k| points[k.min(points.len() - 1)][m]));
            let Lanes(values) = self.tape.run(self.variables(along(0), along(1)));
            for ((p, to), value) in points.iter().zip(to).zip(values) {
                *to = if value.is_finite() { value } else { self.value(p[0], p[1]) };
            }
        }
    }

    fn jet(&self, rect: &Rect) -> Option<Jet<Interval>> {
        let sides = [0, 1].map(|m| Interval::new(rect.min[m], rect.max[m]));
        let one = |m: usize| Jet {
            value: sides[m],
            gradient: [0, 1].map(|k| Interval::point(f64::from(u8::from(k == m)))),
            hessian: [Interval::ZERO; 3],
        };
        Some(self.enclosed(one(0), one(1)))
    }

    /// With its derivatives, from x and y over a rectangle.
    fn enclosed<T: Enclosed>(&self, x: T, y: T) -> T {
        let r = if self.smooth.uses(R) { x.two(y, Two::Hypot) } else { T::constant(0.0) };
        let theta = if self.smooth.uses(THETA) { y.two(x, Two::Atan2) } else { T::constant(0.0) };
        self.smooth.run([x, y], [x, y, r, theta])
    }

    /// x, y, r and theta from x and y.
    fn variables<T: Number>(&self, x: T, y: T) -> [T; 4] {
        let r = if self.tape.uses(R) { x.two(y, Two::Hypot) } else { T::constant(0.0) };
        let theta = if self.tape.uses(THETA) { y.two(x, Two::Atan2) } else { T::constant(0.0) };
        [x, y, r, theta]
    }
}

/// The whole plane.
fn everywhere() -> Rect {
    Rect { min: [f64::NEG_INFINITY; 2], max: [f64::INFINITY; 2] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gradient_is_that_of_the_formula() {
        for text in [
            "x^2/2 + 0.1*abs(y)^3",
            "r^1.7*(1 + 0.2*cos(3*theta))",
            "max(x, y, -x - y)*tan(0.3) + exp(x)*sqrt(4 + y)",
            "hypot(x, 2*y) + atan2(y, x)/7 + min(x, y)^2 - log10(3 + x)*cbrt(y)",
            "cosh(x) - tanh(y)*sinh(x*y) + asin(x/9) - acos(y/9) + atan(x) + log2(5+x)",
            "2^x + x^y",
        ] {
            let gap = Formula::within(text, Outline::disc(3.0).unwrap()).unwrap();
            for [x, y] in [[0.7, 1.1], [1.3, 0.2], [0.4, -1.9], [2.1, 0.9]] {
                let Some(g) = gap.gradient(x, y) else { continue };
                let h = 1e-5;
                let differences = [
                    (gap.gap(x + h, y) - gap.gap(x - h, y)) / (2.0 * h),
                    (gap.gap(x, y + h) - gap.gap(x, y - h)) / (2.0 * h),
                ];
                for m in 0..2 {
                    assert!(
                        (g[m] - differences[m]).abs() < 1e-8 * (1.0 + g[m].abs()),
                        "{text} {x} {y}: {g:?} {differences:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_minimum_is_the_least_of_its_parts() {
        for (text, count) in [
            ("min((x - 1)^2 + y^2, (x + 1)^2 + y^2 + 0.1)", 2),
            ("min(0.3*hypot(x - 1, y), r^2 + 0.1, max(x, -x, y + 0.2, -y))", 3),
            ("min(min(exp(x) + y^2, sqrt(abs(x)) + y^2), 2 + sin(x)*y^2, x^4 + y)", 4),
            ("min(min(exp(x) + y^2, sqrt(x) + y^2), x^4 + y)", 0),
            // A law, an axis, or no minimum at its top.
            ("min(abs(x), abs(y))", 0),
            ("min(r^2, 0.1 + r)", 0),
            ("0.1 + min(x^2 + y^2, 1 + x)", 0),
            ("max(x, -x, min(y, 1))", 0),
        ] {
            let formula = Formula::new(text).unwrap();
            let parts = formula.parts();
            assert_eq!(parts.as_ref().map_or(0, Vec::len), count, "{text}");
            for k in 0..50 {
                let (x, y) = (2.0 * (1.7 * f64::from(k)).sin(), 2.0 * (0.9 * f64::from(k)).cos());
                let least = |parts: &Vec<Formula>| parts.iter().map(|p| p.gap(x, y)).fold(f64::INFINITY, f64::min);
                assert_eq!(formula.gap(x, y), parts.as_ref().map_or(formula.gap(x, y), least), "{text} at {x}, {y}");
            }
        }
        assert!(Formula::within("min(x^2 + y, y^2)", Outline::disc(1.0).unwrap()).unwrap().parts().is_none());
    }

    #[test]
    fn no_number_no_material() {
        let lens = Formula::new("1 - sqrt(1 - x^2 - y^2)").unwrap();
        assert_eq!(lens.gap(2.0, 0.0), f64::INFINITY);
        assert_eq!(lens.gradient(2.0, 0.0), None);
        assert_eq!(lens.mean(&Rect::around([1.0, 0.0], [0.5; 2])), f64::INFINITY);
        // Each side is found to a 32nd of an extent both sides of which were found to a quarter of it.
        let Reach::Within(r) = lens.reach(5.0) else { panic!("bounded") };
        assert!(r.max[0] >= 1.0 && r.max[0] < 1.0 + 4.01 / 32.0, "{r:?}");
        assert!(Formula::new("sqrt(-1 - x^2)").is_err());
        assert!(Formula::new("1/0").is_err());
        let bore = Formula::new("0*sqrt(r - 0.3)").unwrap();
        let around = Rect { min: [0.0, -0.1], max: [1.0, 0.1] };
        assert_eq!(bore.bounds(&around, [0.0; 2]).map(|b| b[1]), Some(f64::INFINITY));
        assert!(bore.taylor(&around).is_none() && bore.slopes(&around).is_none());
        let hole = Formula::new("max(sqrt(x^2 - 1), 0)").unwrap();
        assert_eq!(hole.gap(0.5, 0.0), f64::INFINITY);
    }

    #[test]
    fn planes_are_recognised_and_the_apex_found() {
        let three = Formula::new("tan(pi/4)*max(x, -x/2 + sqrt(3)/2*y, -x/2 - y*sqrt(3)/2)").unwrap();
        let punch = Polyhedron::pyramid(3, 0.25 * std::f64::consts::PI).unwrap();
        let cell = Rect { min: [-0.3, -0.2], max: [0.5, 0.7] };
        assert!((three.mean(&cell) - punch.mean(&cell)).abs() < 1e-15);
        assert!(three.polyhedron().is_some());
        let diamond = Formula::new("abs(x - 1) + 2*abs(y)").unwrap();
        assert_eq!(diamond.polyhedron().map(|p| p.planes().len()), Some(4));
        assert!((diamond.describe().centre[0] - 1.0).abs() < 1e-12);
        assert!(Formula::new("-abs(x) + 3*abs(y)").unwrap().polyhedron().is_none());
        assert!(Formula::new("max(x, y^2)").unwrap().polyhedron().is_none());
        let bowl = Formula::new("(x-1)^2 + 4*(y+2)^2 + x*y/10").unwrap();
        let [x, y] = bowl.describe().centre;
        let g = bowl.gradient(x, y).unwrap();
        assert!(g[0].hypot(g[1]) < 1e-13, "{g:?}");
        assert_eq!(Formula::new("x^2 + y^2").unwrap().describe().centre, [0.0; 2]);
    }
}

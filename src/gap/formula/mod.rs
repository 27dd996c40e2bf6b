//! Gaps written as formulas.

mod parse;
mod planes;
mod tape;

use super::descent::lowest;
use super::search::{pieces, search};
use super::{Gap, Outline, Polyhedron, Reach, mean};
use crate::error::InputError;
use crate::geometry::Rect;
use tape::{Dual, Tape};

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
    region: Option<Outline>,
    polyhedron: Option<Polyhedron>,
    centre: [f64; 2],
}

impl Formula {
    /// The gap with this formula, everywhere.
    ///
    /// # Errors
    /// Names `expression`, with the column of what cannot be read or is not known. At most 4000 characters and 48
    /// operands that wait for one another; no value anywhere that was looked is an error too.
    pub fn new(expression: &str) -> Result<Self, InputError> {
        Self::build(expression, None)
    }

    /// The same with material only inside `region`.
    ///
    /// # Errors
    /// As [`Formula::new`].
    pub fn within(expression: &str, region: Outline) -> Result<Self, InputError> {
        Self::build(expression, Some(region))
    }

    fn build(expression: &str, region: Option<Outline>) -> Result<Self, InputError> {
        let tape = parse::parse(expression)?;
        let start = region.as_ref().map_or([0.0; 2], Outline::inner_point);
        let polyhedron = if region.is_none() { planes::polyhedron(&tape) } else { None };
        let mut formula = Self { expression: expression.to_owned(), tape, region, polyhedron, centre: start };
        formula.centre = match &formula.polyhedron {
            Some(polyhedron) => polyhedron.centre(),
            None => lowest(&formula, start),
        };
        let [x, y] = formula.centre;
        if !formula.gap(x, y).is_finite() {
            let allowed = "a formula with a finite value somewhere around the origin or the middle of its region";
            return Err(InputError::new("expression", expression, allowed));
        }
        Ok(formula)
    }

    /// The formula as given.
    #[must_use]
    pub fn expression(&self) -> &str {
        &self.expression
    }

    /// Where there is material, if that was said.
    #[must_use]
    pub fn region(&self) -> Option<&Outline> {
        self.region.as_ref()
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
        if value.is_finite() { value } else { f64::INFINITY }
    }
}

impl Gap for Formula {
    fn gap(&self, x: f64, y: f64) -> f64 {
        match &self.region {
            Some(region) if !region.contains([x, y]) => f64::INFINITY,
            _ => self.value(x, y),
        }
    }

    fn gradient(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        if self.region.as_ref().is_some_and(|region| !region.contains([x, y])) {
            return None;
        }
        let r = if self.tape.uses(R) || self.tape.uses(THETA) { x.hypot(y) } else { 0.0 };
        let theta = if self.tape.uses(THETA) { y.atan2(x) } else { 0.0 };
        // At the origin the side towards +x.
        let [cos, sin] = if r > 0.0 { [x / r, y / r] } else { [1.0, 0.0] };
        let Dual { value, gradient } = self.tape.run([
            Dual { value: x, gradient: [1.0, 0.0] },
            Dual { value: y, gradient: [0.0, 1.0] },
            Dual { value: r, gradient: [cos, sin] },
            Dual { value: theta, gradient: [-sin / r, cos / r] },
        ]);
        (value.is_finite() && gradient.iter().all(|g| g.is_finite())).then_some(gradient)
    }

    fn reach(&self, depth: f64) -> Reach {
        if let Some(polyhedron) = &self.polyhedron {
            return polyhedron.reach(depth);
        }
        let found = search(&|x, y| self.gap(x, y), depth, self.centre);
        let Some(region) = &self.region else { return found };
        match found {
            Reach::Within(rect) => rect.intersection(&region.bounds()).map_or(Reach::Nowhere, Reach::Within),
            Reach::Nowhere => Reach::Nowhere,
            _ => Reach::Within(region.bounds()),
        }
    }

    fn pieces(&self, depth: f64) -> Option<Vec<Rect>> {
        if let Some(polyhedron) = &self.polyhedron {
            return polyhedron.pieces(depth);
        }
        let found = pieces(&|x, y| self.gap(x, y), depth, self.centre);
        let Some(bounds) = self.region.as_ref().map(Outline::bounds) else { return found };
        found.map_or(Some(vec![bounds]), |found| Some(found.iter().filter_map(|p| p.intersection(&bounds)).collect()))
    }

    fn mean(&self, cell: &Rect) -> f64 {
        match (&self.polyhedron, &self.region) {
            (Some(polyhedron), _) => polyhedron.mean(cell),
            (None, Some(region)) if !region.covers(cell) => f64::INFINITY,
            _ => mean::by_quadrature(|x, y| self.value(x, y), cell),
        }
    }

    fn range(&self, rect: &Rect, slope: [f64; 2]) -> Option<[f64; 2]> {
        self.polyhedron.as_ref()?.range(rect, slope)
    }

    fn planes(&self) -> Option<&[[f64; 3]]> {
        self.polyhedron.as_ref().and_then(Gap::planes)
    }

    fn ray_kinks(&self, from: [f64; 2], direction: [f64; 2], kinks: &mut Vec<f64>) {
        if let Some(polyhedron) = &self.polyhedron {
            polyhedron.ray_kinks(from, direction, kinks);
        }
        if let Some(region) = &self.region {
            region.crossings(from, direction, kinks);
        }
    }

    fn kink_directions(&self, from: [f64; 2], angles: &mut Vec<f64>) {
        if let Some(polyhedron) = &self.polyhedron {
            polyhedron.kink_directions(from, angles);
        }
        if let Some(region) = &self.region {
            region.corner_directions(from, angles);
        }
    }

    fn centre(&self) -> [f64; 2] {
        self.centre
    }
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
    fn no_number_no_material() {
        let lens = Formula::new("1 - sqrt(1 - x^2 - y^2)").unwrap();
        assert_eq!(lens.gap(2.0, 0.0), f64::INFINITY);
        assert_eq!(lens.gradient(2.0, 0.0), None);
        assert_eq!(lens.mean(&Rect::around([1.0, 0.0], [0.5; 2])), f64::INFINITY);
        assert!(matches!(lens.reach(5.0), Reach::Within(r) if r.max[0] >= 1.0 && r.max[0] < 1.01));
        assert!(Formula::new("sqrt(-1 - x^2)").is_err());
        assert!(Formula::new("1/0").is_err());
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
        assert!((diamond.centre()[0] - 1.0).abs() < 1e-12);
        assert!(Formula::new("-abs(x) + 3*abs(y)").unwrap().polyhedron().is_none());
        assert!(Formula::new("max(x, y^2)").unwrap().polyhedron().is_none());
        let bowl = Formula::new("(x-1)^2 + 4*(y+2)^2 + x*y/10").unwrap();
        let g = bowl.gradient(bowl.centre()[0], bowl.centre()[1]).unwrap();
        assert!(g[0].hypot(g[1]) < 1e-13, "{g:?}");
        assert_eq!(Formula::new("x^2 + y^2").unwrap().centre(), [0.0; 2]);
    }
}

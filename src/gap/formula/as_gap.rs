//! What a formula is as a gap.

use super::{Formula, R, THETA, far, kinks};
use crate::gap::{
    AnyGap, Cubic, DataEdge, Degree, Gap, Growth, Known, Law, Quadratic, Reach, Ridges, Taylor, enclosure, mean, radial,
};
use crate::numeric::Interval;
use crate::numeric::derivatives::{Cube, Dual, Jet};
use crate::numeric::geometry::Rect;

/// How much larger than what overlaps the rectangle is that must have material all over, so that rounding does not count.
const BEYOND: f64 = 1.0 + 1e-6;

impl Gap for Formula {
    fn gap(&self, x: f64, y: f64) -> f64 {
        match &self.region {
            Some(region) if !region.contains([x, y]) => f64::INFINITY,
            _ => self.value(x, y),
        }
    }

    fn gaps(&self, points: &[[f64; 2]], to: &mut [f64]) {
        match &self.region {
            Some(_) => crate::gap::one_by_one(self, points, to),
            None => self.values_at(points, to),
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
        (value.is_finite() && gradient.iter().all(|g: &f64| g.is_finite())).then_some(gradient)
    }

    fn describe(&self) -> Known {
        self.known.clone()
    }

    fn reach(&self, depth: f64) -> Reach {
        if let Some(polyhedron) = &self.polyhedron {
            return polyhedron.reach(depth);
        }
        if let Some(reach) = self.known.quadratic.and_then(|q: Quadratic| q.reach(depth)) {
            return reach;
        }
        if depth <= self.known.floor {
            return Reach::Nowhere;
        }
        // Similar at every depth: found once.
        if let (Some(Law { degree: Degree::Power(k), lowest }), None) = (self.known.law, &self.region)
            && self.known.floor >= lowest
        {
            let unit = self.unit_reach.get_or_init(|| self.searched_reach(lowest + 1.0));
            if let Reach::Within(rect) = unit {
                let longer = (depth - lowest).powf(1.0 / k) * (1.0 + 16.0 * f64::EPSILON / k.min(1.0));
                let c = self.known.centre;
                let moved = |p: [f64; 2]| [0, 1].map(|m| c[m] + longer * (p[m] - c[m]));
                let rect = Rect { min: moved(rect.min), max: moved(rect.max) };
                if rect.size().iter().all(|s| *s > 0.0 && s.is_finite()) {
                    return Reach::Within(rect);
                }
            }
            if let Reach::Unbounded { along, .. } = unit {
                // Along every ray from the centre the gap grows by one power: not at all, or falling, on this one.
                return Reach::Unbounded { from: self.known.centre, along: *along };
            }
        }
        self.searched_reach(depth)
    }

    fn components(&self, depth: f64) -> Option<Vec<Rect>> {
        match self.reach(depth) {
            Reach::Within(rect) if self.polyhedron.is_some() || self.known.quadratic.is_some() => Some(vec![rect]),
            Reach::Within(rect) => {
                let lower = |rect: &Rect| self.lower(rect, depth);
                let parts = enclosure::components(&lower, depth, &rect).into_iter();
                let tight =
                    parts.filter_map(|part| match enclosure::tightened(&lower, depth, &part, ([0.0; 2], [false; 2])) {
                        Reach::Within(rect) => Some(rect),
                        _ => None,
                    });
                Some(tight.collect())
            }
            Reach::Nowhere => Some(Vec::new()),
            _ => None,
        }
    }

    fn mean(&self, cell: &Rect) -> f64 {
        match (&self.polyhedron, &self.region) {
            (Some(polyhedron), _) => polyhedron.mean(cell),
            (None, Some(region)) if !region.covers(cell) => f64::INFINITY,
            _ => match &self.known.quadratic {
                Some(q) => {
                    let ([w, h], here) = (cell.size(), q.about(cell.centre()));
                    here.value + (here.hessian[0] * w * w + here.hessian[2] * h * h) / 24.0
                }
                None => mean::by_values(&|points, to| self.values_at(points, to), cell),
            },
        }
    }

    fn bounds(&self, rect: &Rect, slope: [f64; 2]) -> Option<[f64; 2]> {
        if let Some(polyhedron) = &self.polyhedron {
            return polyhedron.bounds(rect, slope);
        }
        let [low, high] = self.range(rect);
        if low == f64::INFINITY {
            return Some([low; 2]);
        }
        let [w, h] = rect.size();
        let half = (0.5 * (slope[0].abs() * w + slope[1].abs() * h)).next_up();
        let [mut low, mut high] = [low - half, high + half];
        if let Some(taylor) = self.taylor(rect) {
            let [a, b] = taylor.bounds([w, h], slope);
            (low, high) = (low.max(a), high.min(b));
        }
        Some([low, high])
    }

    fn taylor(&self, rect: &Rect) -> Option<Taylor> {
        if let Some(polyhedron) = &self.polyhedron {
            return polyhedron.taylor(rect);
        }
        if self.region.as_ref().is_some_and(|region| !region.covers(rect)) {
            return None;
        }
        // Where a part of the rectangle has no value there is no material.
        let Jet { value, hessian, .. } = self.jet(rect)?;
        if !value.defined {
            return None;
        }
        let c = rect.centre().map(Interval::point);
        let one =
            |m: usize| Dual { value: c[m], gradient: [0, 1].map(|k| Interval::point(f64::from(u8::from(k == m)))) };
        let Dual { value, gradient } = self.enclosed(one(0), one(1));
        Taylor { value, gradient, hessian }.finite()
    }

    fn cubic(&self, rect: &Rect) -> Option<Cubic> {
        if let Some(polyhedron) = &self.polyhedron {
            return polyhedron.cubic(rect);
        }
        if self.region.as_ref().is_some_and(|region| !region.covers(rect)) {
            return None;
        }
        let at = |m: usize, value: Interval| Jet {
            value,
            gradient: [0, 1].map(|k| Interval::point(f64::from(u8::from(k == m)))),
            hessian: [Interval::ZERO; 3],
        };
        let sides = radial::sides(rect);
        let over = |m: usize| Cube { jet: at(m, sides[m]), third: [Interval::ZERO; 4] };
        let Cube { jet: Jet { value, .. }, third } = self.enclosed(over(0), over(1));
        if !value.defined {
            return None;
        }
        let c = rect.centre().map(Interval::point);
        let Jet { value, gradient, hessian } = self.enclosed(at(0, c[0]), at(1, c[1]));
        Cubic { middle: Taylor { value, gradient, hessian }, third }.finite()
    }

    fn slopes(&self, rect: &Rect) -> Option<[Interval; 2]> {
        if let Some(polyhedron) = &self.polyhedron {
            return polyhedron.slopes(rect);
        }
        if self.region.as_ref().is_some_and(|region| !region.covers(rect)) {
            return None;
        }
        let sides = radial::sides(rect);
        let one =
            |m: usize| Dual { value: sides[m], gradient: [0, 1].map(|k| Interval::point(f64::from(u8::from(k == m)))) };
        let Dual { value, gradient } = self.enclosed(one(0), one(1));
        let finite = |i: &Interval| i.defined && i.lo.is_finite() && i.hi.is_finite();
        (finite(&value) && gradient.iter().all(finite)).then_some(gradient)
    }

    fn mean_bounds(&self, rect: &Rect) -> Option<[f64; 2]> {
        match &self.polyhedron {
            Some(polyhedron) => polyhedron.mean_bounds(rect),
            None => enclosure::mean(self, rect),
        }
    }

    fn terms(&self) -> Option<Vec<AnyGap>> {
        if self.region.is_some() || self.polyhedron.is_some() {
            return None;
        }
        let terms = self
            .tape
            .terms()
            .into_iter()
            .map(|tape| Some(AnyGap::from(&Self::build(&self.expression, tape, None).ok()?)));
        terms.collect::<Option<Vec<_>>>().filter(|terms| terms.len() > 1)
    }

    fn growth(&self, sector: Interval, from: f64) -> Option<Growth> {
        match (&self.polyhedron, &self.region) {
            (Some(polyhedron), _) => polyhedron.growth(sector, from),
            (None, None) => far::growth(&self.tape, sector, from),
            (None, Some(region)) => Growth::ended(&region.bounds(), from),
        }
    }

    fn without_end(&self, depth: f64) -> Option<AnyGap> {
        let (region, whole) = (self.region.as_ref()?, self.endless()?);
        match whole.reach(depth) {
            Reach::Within(rect) if region.covers(&rect.scaled(BEYOND)) => Some(whole.clone().into_any()),
            _ => None,
        }
    }

    fn restricted(&self, rect: &Rect) -> Option<AnyGap> {
        self.polyhedron.as_ref().and_then(|polyhedron| polyhedron.restricted(rect))
    }

    fn is_composed(&self) -> bool {
        self.polyhedron.as_ref().is_some_and(Gap::is_composed)
    }

    fn planes(&self) -> Option<Vec<[f64; 3]>> {
        self.polyhedron.as_ref().and_then(Gap::planes)
    }

    fn end_of_data(&self, x: f64, y: f64) -> Option<DataEdge> {
        let outside = self.region.as_ref().is_some_and(|region| !region.contains([x, y]));
        outside.then_some(DataEdge::Region)
    }

    fn ray_kinks(&self, from: [f64; 2], direction: [f64; 2], kinks: &mut Vec<f64>) {
        if let Some(polyhedron) = &self.polyhedron {
            polyhedron.ray_kinks(from, direction, kinks);
        }
        if let Some(region) = &self.region {
            region.crossings(from, direction, kinks);
        }
        if let (Some(axis), None) = (self.known.axis, &self.polyhedron) {
            let [x, y] = [from[0] - axis.at[0], from[1] - axis.at[1]];
            // |v + t e| = R.
            let (along, square) = (x * direction[0] + y * direction[1], x * x + y * y);
            for radius in self.rings.get_or_init(|| kinks::radii(&self.tape, axis.at)) {
                let root = (along * along - square + radius * radius).max(0.0).sqrt();
                kinks.extend([-along - root, -along + root].into_iter().filter(|&t| t > 0.0 && root > 0.0));
            }
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

    fn ridges(&self) -> Option<Ridges> {
        self.polyhedron.as_ref().and_then(Gap::ridges)
    }
}

//! A gap far away from the origin: how it grows along every ray of a sector.
//!
//! For r >= `from` and every direction of the sector, g lies in the sum over the terms of r^k [lo, hi]. With it a gap proves that it lies
//! above a depth everywhere outside a disc, or below it however far out.

use super::Reach;
use crate::numeric::Interval;
use crate::numeric::geometry::Rect;

/// Terms that are kept apart; more of them share the largest degree.
const MOST_TERMS: usize = 6;

/// Bounds of a gap along the rays of a sector.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Growth {
    terms: [(f64, Interval); MOST_TERMS],
    count: usize,
    from: f64,
}

impl Growth {
    /// The same value everywhere.
    #[must_use]
    pub fn constant(value: f64) -> Self {
        Self::power(0.0, Interval::point(value), 0.0)
    }

    /// r^k times a number of the interval, for r >= `from`.
    #[must_use]
    pub fn power(k: f64, coefficient: Interval, from: f64) -> Self {
        let mut terms = [(0.0, Interval::ZERO); MOST_TERMS];
        terms[0] = (k, coefficient);
        Self { terms, count: 1, from }
    }

    /// No material farther out than a rectangle; `None` where that is not beyond `from`.
    #[must_use]
    pub fn ended(material: &Rect, from: f64) -> Option<Self> {
        let farthest = material.corners().map(|[x, y]| x.hypot(y)).into_iter().fold(0.0, f64::max);
        (from > farthest * (1.0 + 1e-12)).then(|| Self::power(0.0, Interval::EMPTY, from))
    }

    /// Whether there is no material.
    pub(crate) fn is_ended(&self) -> bool {
        self.range().is_empty()
    }

    fn terms(&self) -> &[(f64, Interval)] {
        &self.terms[..self.count]
    }

    /// The value, when it is one number.
    #[cfg(feature = "formula")]
    pub(crate) fn is_number(&self) -> Option<f64> {
        match self.terms() {
            [(0.0, c)] if c.lo == c.hi => Some(c.lo),
            _ => None,
        }
    }

    /// r in units of its own: r -> stretch r, for a stretch within the interval.
    #[must_use]
    pub fn stretched(mut self, stretch: Interval, from: f64) -> Self {
        self.from = from;
        self.terms[..self.count].iter_mut().for_each(|t| t.1 = t.1 * stretch.powf(Interval::point(t.0)));
        self
    }

    /// The largest degree.
    fn top(&self) -> f64 {
        self.terms().iter().map(|t| t.0).fold(f64::NEG_INFINITY, f64::max)
    }

    fn with(&mut self, (k, c): (f64, Interval)) {
        if let Some(term) = self.terms[..self.count].iter_mut().find(|t| t.0 == k) {
            term.1 = term.1 + c;
        } else if self.count < MOST_TERMS {
            self.terms[self.count] = (k, c);
            self.count += 1;
        } else {
            let top = self.top().max(k);
            let sum = self.as_power(top) + Self::power(k, c, self.from).as_power(top);
            *self = Self::power(top, sum, self.from);
        }
    }

    /// The coefficient of r^k when everything is written as a multiple of it.
    fn as_power(&self, k: f64) -> Interval {
        let factor = |degree: f64| {
            if degree == k {
                Interval::point(1.0)
            } else {
                let at_start = Interval::point(self.from).powf(Interval::point(degree - k));
                if degree < k {
                    Interval::new(0.0, at_start.hi)
                } else {
                    Interval::new(at_start.lo.max(0.0), f64::INFINITY)
                }
            }
        };
        self.terms().iter().map(|&(degree, c)| c * factor(degree)).fold(Interval::ZERO, |sum, c| sum + c)
    }

    /// One term of the largest degree that says as much as it can.
    fn leading(&self) -> (f64, Interval) {
        let top = self.top();
        (top, self.as_power(top))
    }

    /// Bounds of the value for all r >= from.
    #[must_use]
    pub fn range(&self) -> Interval {
        // As a multiple of each power in turn: all of these hold.
        let as_multiple = |k: f64| {
            let start = Interval::point(self.from).powf(Interval::point(k));
            let along_the_ray = match k {
                0.0 => Interval::point(1.0),
                k if k > 0.0 => Interval::new(start.lo.max(0.0), f64::INFINITY),
                _ => Interval::new(0.0, start.hi),
            };
            let c = self.as_power(k);
            Interval { defined: c.defined, ..c * along_the_ray }
        };
        let multiples = self.terms().iter().map(|t| as_multiple(t.0));
        let range = multiples.reduce(Interval::intersection).unwrap_or(Interval::ZERO);
        // Terms that all rise from a known start are no less than there.
        if !self.terms().iter().all(|&(k, c)| k == 0.0 || (k > 0.0 && c.lo >= 0.0)) {
            return range;
        }
        let at_start = |&(k, c): &(f64, Interval)| c * Interval::point(self.from).powf(Interval::point(k));
        let sum = self.terms().iter().map(at_start).fold(Interval::ZERO, |sum, c| sum + c);
        Interval { lo: sum.lo.max(range.lo), ..range }
    }

    /// Times a number.
    #[must_use]
    pub fn times(mut self, factor: Interval) -> Self {
        self.terms[..self.count].iter_mut().for_each(|t| t.1 = t.1 * factor);
        self
    }

    /// The sum of both.
    #[must_use]
    pub fn plus(mut self, other: &Self) -> Self {
        self.from = self.from.max(other.from);
        other.terms().iter().for_each(|&term| self.with(term));
        self
    }

    /// The product of both.
    #[must_use]
    pub fn product(&self, other: &Self) -> Self {
        let from = self.from.max(other.from);
        let mut all: Option<Self> = None;
        for &(k, c) in self.terms() {
            for &(m, d) in other.terms() {
                match &mut all {
                    Some(all) => all.with((k + m, c * d)),
                    None => all = Some(Self::power(k + m, c * d, from)),
                }
            }
        }
        all.unwrap_or(Self::constant(0.0))
    }

    /// Both as multiples of one power: that of the slower one.
    fn alike(&self, other: &Self) -> (f64, Interval, Interval) {
        let k = self.top().min(other.top());
        (k, self.as_power(k), other.as_power(k))
    }

    /// The lesser of both.
    #[must_use]
    pub fn lesser(&self, other: &Self) -> Self {
        if let Some([lesser, _]) = self.in_order(other) {
            return lesser;
        }
        let (k, a, b) = self.alike(other);
        Self::power(k, a.min(b), self.from.max(other.from))
    }

    /// The greater of both.
    #[must_use]
    pub fn greater(&self, other: &Self) -> Self {
        if let Some([_, greater]) = self.in_order(other) {
            return greater;
        }
        let (k, a, b) = self.alike(other);
        Self::power(k, a.max(b), self.from.max(other.from))
    }

    /// The lesser and the greater where one is so all along: it keeps all of its terms.
    fn in_order(&self, other: &Self) -> Option<[Self; 2]> {
        let rise = other.plus(&self.times(Interval::point(-1.0)));
        let from = rise.from;
        let [a, b] = [self, other].map(|own| Self { from, ..*own });
        match rise.range() {
            rise if !rise.defined || rise.is_empty() => None,
            rise if rise.lo >= 0.0 => Some([a, b]),
            rise if rise.hi <= 0.0 => Some([b, a]),
            _ => None,
        }
    }

    /// A function of the value that is not a power.
    #[cfg(feature = "formula")]
    pub(crate) fn map(&self, f: impl Fn(Interval) -> Interval) -> Self {
        Self::power(0.0, f(self.range()), self.from)
    }

    /// The quotient of both.
    #[must_use]
    pub fn quotient(&self, other: &Self) -> Self {
        let (k, c) = other.leading();
        self.product(&Self::power(-k, Interval::point(1.0) / c, other.from))
    }

    /// The n-th power, n whole.
    #[must_use]
    pub fn whole(&self, n: i32) -> Self {
        match n {
            0 => Self::constant(1.0),
            _ if self.count == 1 => {
                let (k, c) = self.terms[0];
                Self::power(k * f64::from(n), c.powi(n), self.from)
            }
            1..=4 => (1..n).fold(*self, |power, _| power.product(self)),
            _ => {
                let (k, c) = self.leading();
                Self::power(k * f64::from(n), c.powi(n), self.from)
            }
        }
    }

    /// Any power of what is not negative.
    #[must_use]
    pub fn powf(&self, exponent: f64) -> Self {
        let (k, c) = self.leading();
        Self::power(k * exponent, c.powf(Interval::point(exponent)), self.from)
    }

    /// |a|.
    #[must_use]
    pub fn abs(&self) -> Self {
        let range = self.range();
        if range.lo >= 0.0 {
            return *self;
        }
        let (k, c) = self.leading();
        Self::power(k, c.abs(), self.from)
    }

    /// The cube root.
    #[must_use]
    pub fn cbrt(&self) -> Self {
        let (k, c) = self.leading();
        Self::power(k / 3.0, c.cbrt(), self.from)
    }

    /// The length of the vector with these two components.
    #[must_use]
    pub fn hypot(&self, other: &Self) -> Self {
        let k = self.top().max(other.top());
        Self::power(k, self.as_power(k).hypot(other.as_power(k)), self.from.max(other.from))
    }

    /// The angle of the vector (other, self).
    #[must_use]
    pub fn atan2(&self, other: &Self) -> Self {
        let k = self.top().max(other.top());
        let angle = self.as_power(k).atan2(other.as_power(k));
        Self::power(0.0, angle, self.from.max(other.from))
    }
}

/// Narrowest sector that is looked at, as a part of a turn.
const NARROWEST: f64 = 1.0 / 512.0;

/// The sectors of a whole turn that are looked at first.
const FIRST: usize = 8;

/// The exponents of 2 between which the radius of a disc is looked for.
const EXPONENTS: [i32; 2] = [-1020, 1020];

/// Where a gap with this growth (sector, start -> bounds about the origin) is less than a depth: inside a disc about the origin, or
/// without limit along some ray. `mirrors`: whether it is its own image in x = 0 and in y = 0.
pub(super) fn reach(growth: impl Fn(Interval, f64) -> Option<Growth>, depth: f64, mirrors: [bool; 2]) -> Reach {
    let turn = std::f64::consts::TAU;
    // Parts of a turn from -1/2 to 1/2 that stand for all.
    let needed = match mirrors {
        [true, true] => [0.0, 0.25],
        [true, false] => [-0.25, 0.25],
        [false, true] => [0.0, 0.5],
        _ => [-0.5, 0.5],
    };
    let first = ((needed[1] - needed[0]) * FIRST as f64) as usize;
    let at = |k: usize| needed[0] + k as f64 / FIRST as f64;
    // Where the gap is not known to be at least the depth beyond a radius; the sector that failed last is tried first.
    let mut failed: Option<[f64; 2]> = None;
    let mut holds = |from: f64| {
        let above = |[a, b]: [f64; 2]| {
            let sector = Interval::new((turn * a).next_down(), (turn * b).next_up());
            growth(sector, from).is_some_and(|growth| growth.range().lo >= depth)
        };
        if failed.is_some_and(|sector| !above(sector)) {
            return false;
        }
        let mut open: Vec<[f64; 2]> = (0..first).map(|k| [at(k), at(k + 1)]).collect();
        while let Some([a, b]) = open.pop() {
            if above([a, b]) {
                continue;
            }
            if b - a <= NARROWEST {
                failed = Some([a, b]);
                return false;
            }
            let middle = 0.5 * (a + b);
            open.extend([[a, middle], [middle, b]]);
        }
        true
    };
    let radius = |exponent: i32| f64::from(exponent).exp2();
    if !holds(radius(EXPONENTS[1])) {
        return escape(growth, depth).unwrap_or(Reach::Unknown);
    }
    let beyond = radius(least_exponent(EXPONENTS, |exponent| holds(radius(exponent))));
    Reach::Within(Rect::around([0.0; 2], [beyond; 2]))
}

/// A direction along which the gap stays below the depth beyond some radius.
fn escape(growth: impl Fn(Interval, f64) -> Option<Growth>, depth: f64) -> Option<Reach> {
    let sectors = (1.0 / NARROWEST) as usize;
    let below = |k: usize, from: f64| {
        let angle = std::f64::consts::TAU * ((k as f64 + 0.5) / sectors as f64 - 0.5);
        let ray = Interval::new(angle, angle);
        growth(ray, from)
            .is_some_and(|g| {
                let range = g.range();
                range.defined && range.hi < depth
            })
            .then_some(angle)
    };
    let at_last = f64::from(EXPONENTS[1] / 2).exp2();
    let k = (0..sectors).find(|&k| below(k, at_last).is_some())?;
    let angle = below(k, at_last)?;
    let holds = |exponent: i32| below(k, f64::from(exponent).exp2()).is_some();
    let beyond = f64::from(least_exponent([EXPONENTS[0], EXPONENTS[1] / 2], holds)).exp2();
    Some(Reach::Unbounded { from: [beyond * angle.cos(), beyond * angle.sin()], along: angle })
}

/// The least exponent above `low` from which on a condition holds that holds at `high`.
fn least_exponent([mut low, mut high]: [i32; 2], mut holds: impl FnMut(i32) -> bool) -> i32 {
    while high - low > 1 {
        let middle = low.midpoint(high);
        *if holds(middle) { &mut high } else { &mut low } = middle;
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;

    /// c r^1.5 + (a cos^2 + b sin^2 + e cos sin) r^2.
    fn mixed(c: f64, a: f64, b: f64, e: f64) -> impl Fn(Interval, f64) -> Option<Growth> {
        move |sector, from| {
            let (cos, sin) = (sector.cos(), sector.sin());
            let form =
                Interval::point(a) * cos.powi(2) + Interval::point(b) * sin.powi(2) + Interval::point(e) * (cos * sin);
            let slow = Interval::point(c) * cos.abs().powf(Interval::point(1.5));
            Some(Growth::power(2.0, form, from).plus(&Growth::power(1.5, slow, from)))
        }
    }

    #[test]
    fn a_gap_that_rises_at_last_has_a_disc() {
        let Reach::Within(rect) = reach(mixed(-1.0, 1.0, 2.0, 0.3), 1.0, [false; 2]) else { panic!("bounded") };
        assert!(rect.max[0] >= 1.0 && rect.max[0] <= 8.0, "{rect:?}");
        let Reach::Within(rect) = reach(mixed(0.0, 1.0, 1.0, 0.0), 1e-200, [true; 2]) else { panic!("bounded") };
        assert!(rect.max[0] >= 1e-100 && rect.max[0] <= 4e-100, "{rect:?}");
    }

    #[test]
    fn a_gap_that_falls_again_is_known_to_have_no_end() {
        // |x|^1.5 + 2 y^2 + 0.3 x y: below any depth beyond |x| = 7900 or so, along y = -0.075 x.
        let Reach::Unbounded { from, along } = reach(mixed(1.0, 0.0, 2.0, 0.3), 0.01, [false; 2]) else {
            panic!("unbounded")
        };
        let beyond = from[0].hypot(from[1]);
        assert!(along.tan() < 0.0 && along.tan() > -0.15 && beyond > 1e3 && beyond < 1e6, "{along} {beyond}");
    }

    #[test]
    fn the_greater_keeps_its_terms() {
        // max(0, r - 1) + x/2: above 1 beyond r = 4. Of two that cross on every ray the bounds of both hold.
        let worn = |sector: Interval, from: f64| {
            let slope = Growth::power(1.0, Interval::point(1.0), from).plus(&Growth::constant(-1.0));
            let tilt = Growth::power(1.0, sector.cos() * Interval::point(0.5), from);
            Some(Growth::constant(0.0).greater(&slope).plus(&tilt))
        };
        let Reach::Within(rect) = reach(worn, 1.0, [false; 2]) else { panic!("bounded") };
        assert!(rect.max[0] >= 4.0 && rect.max[0] <= 8.0, "{rect:?}");
        let (line, level) = (Growth::power(1.0, Interval::point(1.0), 0.5), Growth::constant(1.0));
        assert_eq!([line.greater(&level).range().lo, line.lesser(&level).range().lo], [1.0, 0.5]);
        let ended = Growth::power(0.0, Interval::EMPTY, 0.5);
        assert!(level.greater(&ended).is_ended() || level.greater(&ended).range().lo == f64::INFINITY);
    }

    #[test]
    fn a_quotient_keeps_its_limit() {
        // r^2/(1 + r^2) < 1.
        let growth = |_: Interval, from: f64| {
            let square = Growth::power(2.0, Interval::point(1.0), from);
            Some(square.quotient(&square.plus(&Growth::constant(1.0))))
        };
        assert!(matches!(reach(growth, 1.2, [true; 2]), Reach::Unbounded { .. }));
        let Reach::Within(rect) = reach(growth, 0.5, [false; 2]) else { panic!("bounded") };
        assert!(rect.max[0] >= 1.0 && rect.max[0] <= 2.0, "{rect:?}");
    }
}

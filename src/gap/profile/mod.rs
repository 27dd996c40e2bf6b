//! Measured profiles: gaps given by one line across a body, extruded or rolled along it.

mod line;
mod table;

pub use line::Line;
pub use table::LineFormat;

use super::height_map::{Surface, Zero};
use super::left_open::{BESIDE, COARSER, FURTHER, MARGIN, Rising, tip};
use super::spline::{Ends, PiecewiseCubic};
use super::{DataEdge, Gap, Growth, Known, LeftOpen, Reach, Taylor};
use crate::error::{InputError, positive};
use crate::numeric::Interval;
use crate::numeric::geometry::Rect;

/// The axis along which a profile is extruded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Along {
    /// The profile is measured along y: g(x, y) = z(y) + x^2/(2 R).
    X,
    /// The profile is measured along x: g(x, y) = z(x) + y^2/(2 R).
    Y,
}

/// What lies between measured values.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Interpolation {
    /// A cubic spline: what a smooth body is met by to fourth order in the spacing.
    #[default]
    Cubic,
    /// Straight from value to value: the facets are the surface.
    Linear,
}

/// A gap given along a line across the body: a wheel's or a rail's profile, a roller, the flank of a tooth.
///
/// Along the body it is straight, or curved with a rolling radius (to second order: x^2/(2 R)). Alone, without a radius, it is a line
/// contact and has no end. Beyond the ends of the line there is no material.
///
/// ```
/// use contact_patch::gap::{Along, Gap, Interpolation, Line, Profile, Surface, Zero};
/// // A crown of radius 0.3 across a wheel that rolls with radius 0.46.
/// let crown = (0..=40).map(|k| f64::from(k - 20) * 1e-3).map(|y| [y, y * y / 0.6]).collect();
/// let wheel = Profile::new(&Line::new(crown)?, Along::X, Surface::Upper, Zero::FirstTouch, Interpolation::Cubic)?;
/// let wheel = wheel.rolling(0.46)?;
/// assert!((wheel.gap(1e-3, 2e-3) - (1e-6 / 0.92 + 4e-6 / 0.6)).abs() < 1e-18);
/// # Ok::<(), contact_patch::InputError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    heights: PiecewiseCubic,
    /// The coordinate that the profile is measured along: 0 for x, 1 for y.
    across: usize,
    radius: Option<f64>,
    lowest: f64,
    floor: f64,
    /// How far each measured height may be from the true one.
    uncertainty: Vec<f64>,
    /// Where depths are counted from.
    zero: Zero,
}

/// Coordinates beyond this have squares beyond the range of numbers.
const LARGEST: f64 = 1e150;

impl Profile {
    /// The gap of a measured line against a plane.
    ///
    /// # Errors
    /// Those of the line are found when it is made; none are left here but numbers that overflow.
    pub fn new(
        line: &Line,
        along: Along,
        surface: Surface,
        zero: Zero,
        interpolation: Interpolation,
    ) -> Result<Self, InputError> {
        let sign = if surface == Surface::Upper { 1.0 } else { -1.0 };
        // What cannot be seen from the other body is not part of the gap.
        let points = line.facing(sign)?;
        let largest = |m: usize| points.iter().fold(0.0_f64, |most, p| most.max(p.0[m].abs()));
        let size = largest(1);
        if !(largest(0).max(size) < LARGEST) {
            let given = format!("coordinates beyond {LARGEST:e}");
            return Err(InputError::new("points", given, "units in which lengths are closer to 1"));
        }
        let knots: Vec<f64> = points.iter().map(|p| p.0[0]).collect();
        let values: Vec<f64> = points.iter().map(|p| sign * p.0[1]).collect();
        let uncertainty = points.iter().map(|p| p.1).collect();
        let heights = match interpolation {
            Interpolation::Linear => PiecewiseCubic::straight(knots, &values),
            Interpolation::Cubic => {
                let ends = if line.is_smoothed() { Ends::Natural } else { Ends::NotAKnot };
                PiecewiseCubic::spline(knots, &values, ends)
            }
        };
        let (lowest, value, bound) = heights.least();
        let (heights, floor) = match zero {
            Zero::FirstTouch => (heights.raised(-value), bound - value),
            Zero::AsIs => (heights, bound),
        };
        let floor = floor - 4.0 * f64::EPSILON * size;
        let across = if along == Along::X { 1 } else { 0 };
        Ok(Self { heights, across, radius: None, lowest, floor, uncertainty, zero })
    }

    /// The same body rolled: along the axis it is curved with this radius.
    ///
    /// # Errors
    /// Names `radius` when it is not a finite number greater than zero.
    pub fn rolling(mut self, radius: f64) -> Result<Self, InputError> {
        self.radius = Some(positive("radius", radius)?);
        Ok(self)
    }

    /// First and last coordinate of the line.
    #[must_use]
    pub fn ends(&self) -> [f64; 2] {
        self.heights.ends()
    }

    fn along(&self) -> usize {
        1 - self.across
    }

    fn side(rect: &Rect, m: usize) -> [f64; 2] {
        [rect.min[m], rect.max[m]]
    }

    /// Curvature along the axis.
    fn bend(&self) -> Interval {
        self.radius.map_or(Interval::ZERO, |radius| Interval::point(1.0) / Interval::point(radius))
    }

    /// The rolled part over a rectangle, as a Taylor form without its profile.
    fn rolled(&self, rect: &Rect) -> Taylor {
        let c = Interval::point(rect.centre()[self.along()]);
        let bend = self.bend();
        let (mut gradient, mut hessian) = ([Interval::ZERO; 2], [Interval::ZERO; 3]);
        gradient[self.along()] = bend * c;
        hessian[2 * self.along()] = bend;
        Taylor { value: Interval::point(0.5) * bend * c.powi(2), gradient, hessian }
    }

    /// A rectangle from an interval across and half a length along.
    fn rect(&self, across: [f64; 2], half: f64) -> Rect {
        let mut rect = Rect { min: [-half; 2], max: [half; 2] };
        (rect.min[self.across], rect.max[self.across]) = (across[0], across[1]);
        rect
    }

    /// Half the length over which the rolled body stays below a depth, where its profile is at least `low`.
    fn half_length(&self, depth: f64, low: f64) -> Option<f64> {
        self.radius.map(|radius| (2.0 * radius * (depth - low).max(0.0)).sqrt() * (1.0 + 1e-14))
    }

    /// The heights against splines through every n-th of them, laid on the knots [from, to), begun at the first of them and `later`: the
    /// greatest differences at those of [first, end).
    fn missed(&self, [from, to]: [usize; 2], inner: [usize; 2], [every, later]: [usize; 2]) -> Option<Vec<f64>> {
        let whole = self.missed_from(from, to, inner, every)?;
        let Some(other) = self.missed_from(from + later, to, inner, every) else { return Some(whole) };
        Some(whole.iter().zip(other).map(|(a, b)| a.max(b)).collect())
    }

    fn missed_from(&self, from: usize, to: usize, [first, end]: [usize; 2], every: usize) -> Option<Vec<f64>> {
        let knots = self.heights.knots();
        let places: Vec<usize> = (from..to).step_by(every).collect();
        let coarse: Vec<f64> = places.iter().map(|&k| knots[k]).collect();
        if coarse.len() < 4 {
            return None;
        }
        let values: Vec<f64> = coarse.iter().map(|&q| self.heights.value(q)).collect();
        let last = places[places.len() - 1];
        let spline = PiecewiseCubic::spline(coarse, &values, Ends::NotAKnot);
        let off = |k: usize| {
            if (from..=last).contains(&k) { spline.value(knots[k]) - self.heights.value(knots[k]) } else { 0.0 }
        };
        Some((first..end).map(|k| off(k).abs()).collect())
    }

    /// The knots [first, end) that hold an interval.
    fn holding(&self, [a, b]: [f64; 2]) -> [usize; 2] {
        let knots = self.heights.knots();
        let first = knots.partition_point(|&q| q < a).saturating_sub(1);
        let end = (knots.partition_point(|&q| q <= b) + 1).min(knots.len());
        [first.min(end), end]
    }

    /// What splines through every second and every fourth knot miss at those of [first, end).
    fn missed_by_coarser(&self, [first, end]: [usize; 2]) -> [Option<Vec<f64>>; 2] {
        let around = [first.saturating_sub(MARGIN), (end + MARGIN).min(self.heights.knots().len())];
        COARSER.map(|every| self.missed(around, [first, end], every))
    }

    /// What the samples leave open of the heights.
    fn open_between(&self, places: &[Rect]) -> Vec<LeftOpen> {
        let Some(all) = places.iter().copied().reduce(|a, b| a.union(&b)) else { return Vec::new() };
        let all = self.holding(Self::side(&all, self.across));
        let coarser = self.heights.is_smooth().then(|| self.missed_by_coarser(all));
        let one = |place: &Rect| {
            let side = Self::side(place, self.across);
            let [first, end] = self.holding(side);
            if first == end {
                return LeftOpen::default();
            }
            let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
            let noise = mean(&self.uncertainty[first..end]);
            let Some(coarser) = &coarser else { return LeftOpen { noise, ..LeftOpen::default() } };
            let within = |off: &Vec<f64>| mean(&off[first - all[0]..end - all[0]]);
            let [second, fourth] = [&coarser[0], &coarser[1]].map(|off| off.as_ref().map(within));
            LeftOpen::of(noise, second, fourth, || self.variation(side))
        };
        places.iter().map(one).collect()
    }

    /// What they leave open of where the profile first touches, where depths are counted from there.
    fn open_at_zero(&self) -> LeftOpen {
        if self.zero == Zero::AsIs {
            return LeftOpen::default();
        }
        let mut at = [0.0; 2];
        at[self.across] = self.lowest;
        let open = self.open_between(&[Rect { min: at, max: at }])[0];
        open.of_least(self.heights.knots().iter().map(|q| self.heights.value(*q)), self.tip())
    }

    /// How much lower than the spline a tip may be between the samples around the lowest place.
    fn tip(&self) -> f64 {
        let smoothed = self.uncertainty.iter().any(|off| *off > 0.0);
        let [first, end] = self.holding([self.lowest; 2]);
        let knots = self.heights.knots();
        let rising = |k: usize| {
            let [a, b] = [knots[k], knots[k + 1]];
            let slope = (self.heights.value(b) - self.heights.value(a)) / (b - a);
            Rising { slope: slope.abs(), away: if 0.5 * (a + b) < self.lowest { -slope } else { slope } }
        };
        let steps = |far: usize| first.saturating_sub(far)..(end - 1 + far).min(knots.len() - 1);
        let (own, near) = (steps(0), steps(BESIDE));
        let beside: Vec<Rising> = near.clone().filter(|k| !own.contains(k)).map(rising).collect();
        let further: Vec<Rising> = steps(FURTHER).filter(|k| !near.contains(k)).map(rising).collect();
        let points: Vec<_> = knots[near.start..=near.end].iter().map(|&q| ([q, 0.0], self.heights.value(q))).collect();
        tip(&Rect { min: [knots[first], 0.0], max: [knots[end - 1], 0.0] }, &points, &beside, &further, smoothed)
    }

    /// By how much the heights vary over an interval.
    fn variation(&self, across: [f64; 2]) -> f64 {
        let [low, high] = self.heights.bounds(across, 0.0);
        if high.is_finite() { high - low } else { 0.0 }
    }
}

impl Gap for Profile {
    fn gap(&self, x: f64, y: f64) -> f64 {
        let at = [x, y];
        let t = at[self.along()];
        self.heights.value(at[self.across]) + self.radius.map_or(0.0, |radius| 0.5 * t * (t / radius))
    }

    fn end_of_data(&self, x: f64, y: f64) -> Option<DataEdge> {
        (self.gap(x, y) == f64::INFINITY).then_some(DataEdge::Map)
    }

    fn gradient(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        let at = [x, y];
        let mut gradient = [0.0; 2];
        gradient[self.across] = self.heights.slope(at[self.across])?;
        gradient[self.along()] = self.radius.map_or(0.0, |radius| at[self.along()] / radius);
        Some(gradient)
    }

    fn describe(&self) -> Known {
        let (mut centre, mut mirrors) = ([0.0; 2], [false; 2]);
        centre[self.across] = self.lowest;
        mirrors[self.along()] = true;
        Known { centre, floor: self.floor, mirrors, ..Known::nothing() }
    }

    fn reach(&self, depth: f64) -> Reach {
        let below = self.heights.below(depth);
        let (Some(first), Some(last)) = (below.first(), below.last()) else { return Reach::Nowhere };
        if depth <= self.floor {
            return Reach::Nowhere;
        }
        let Some(half) = self.half_length(depth, self.floor) else {
            let mut from = [0.0; 2];
            from[self.across] = self.lowest;
            if !(self.heights.value(self.lowest) < depth) {
                return Reach::Unknown;
            }
            let along = self.along() as f64 * std::f64::consts::FRAC_PI_2;
            return Reach::Unbounded { from, along };
        };
        Reach::Within(self.rect([first[0], last[1]], half))
    }

    fn components(&self, depth: f64) -> Option<Vec<Rect>> {
        let half = |across: [f64; 2]| self.half_length(depth, self.heights.bounds(across, 0.0)[0].max(self.floor));
        self.heights.below(depth).into_iter().map(|across| half(across).map(|half| self.rect(across, half))).collect()
    }

    fn mean(&self, cell: &Rect) -> f64 {
        let (c, w) = (cell.centre()[self.along()], cell.size()[self.along()]);
        let rolled = self.radius.map_or(0.0, |radius| 0.5 * (c * (c / radius) + w * (w / radius) / 12.0));
        self.heights.mean(Self::side(cell, self.across))[0] + rolled
    }

    fn bounds(&self, rect: &Rect, slope: [f64; 2]) -> Option<[f64; 2]> {
        let [low, high] = self.heights.bounds(Self::side(rect, self.across), slope[self.across]);
        if low == f64::INFINITY {
            return Some([low, low]);
        }
        let mut along = [0.0; 2];
        along[self.along()] = slope[self.along()];
        let [a, b] = self.rolled(rect).bounds(rect.size(), along);
        let sum = Interval::new(low, high) + Interval::new(a, b);
        Some([sum.lo, sum.hi])
    }

    fn taylor(&self, rect: &Rect) -> Option<Taylor> {
        let curvature = self.heights.curvatures(Self::side(rect, self.across))?;
        let [value, slope] = self.heights.enclosed(rect.centre()[self.across])?;
        let (mut gradient, mut hessian) = ([Interval::ZERO; 2], [Interval::ZERO; 3]);
        gradient[self.across] = slope;
        hessian[2 * self.across] = curvature;
        Taylor { value, gradient, hessian }.plus(&self.rolled(rect)).finite()
    }

    fn slopes(&self, rect: &Rect) -> Option<[Interval; 2]> {
        let mut slopes = [Interval::ZERO; 2];
        slopes[self.across] = self.heights.slopes(Self::side(rect, self.across))?;
        let [a, b] = Self::side(rect, self.along());
        slopes[self.along()] = self.bend() * Interval::new(a, b);
        Some(slopes)
    }

    fn mean_bounds(&self, rect: &Rect) -> Option<[f64; 2]> {
        let [mean, room] = self.heights.mean(Self::side(rect, self.across));
        if !mean.is_finite() {
            return Some([self.bounds(rect, [0.0; 2])?[0], f64::INFINITY]);
        }
        let (c, w) = (Interval::point(rect.centre()[self.along()]), Interval::point(rect.size()[self.along()]));
        let square = c.powi(2) + w.powi(2) / Interval::point(12.0);
        let sum = Interval::new(mean - room, mean + room) + Interval::point(0.5) * self.bend() * square;
        Some([sum.lo, sum.hi])
    }

    fn growth(&self, sector: Interval, from: f64) -> Option<Growth> {
        // Across the body the line ends; along it, there may be no more than the least height, or no material.
        let across = if self.across == 0 { sector.cos() } else { sector.sin() };
        let [first, last] = self.ends();
        let least = if across.has_zero() { 0.0 } else { across.abs().lo };
        let ended = from * least > first.abs().max(last.abs()) * (1.0 + 1e-12);
        if ended {
            return Some(Growth::power(0.0, Interval::EMPTY, from));
        }
        let heights = Growth::power(0.0, Interval::new(self.floor, f64::INFINITY), from);
        let along = if self.across == 0 { sector.sin() } else { sector.cos() };
        let half = Interval::point(0.5) * self.bend() * along.powi(2);
        Some(heights.plus(&Growth::power(2.0, half, from)))
    }

    fn is_measured(&self) -> bool {
        true
    }

    fn sampling_error(&self, rect: &Rect) -> f64 {
        let side = Self::side(rect, self.across);
        let held = self.holding(side);
        let largest = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
        let noise = largest(&self.uncertainty[held[0]..held[1]]);
        if !self.heights.is_smooth() {
            return noise + self.open_at_zero().size();
        }
        let [second, fourth] = self.missed_by_coarser(held).map(|off| off.map(|off| largest(&off)));
        LeftOpen::of(noise, second, fourth, || self.variation(side)).size() + self.open_at_zero().size()
    }

    fn left_open(&self, places: &[Rect]) -> Vec<LeftOpen> {
        let of_zero = self.open_at_zero();
        self.open_between(places).into_iter().map(|open| open + of_zero).collect()
    }

    fn ray_kinks(&self, from: [f64; 2], direction: [f64; 2], kinks: &mut Vec<f64>) {
        let (q, d) = (from[self.across], direction[self.across]);
        if d == 0.0 {
            return;
        }
        let ends = self.ends();
        let knots = if self.heights.is_smooth() { ends.as_slice() } else { self.heights.knots() };
        kinks.extend(knots.iter().map(|knot| (knot - q) / d).filter(|r| *r > 0.0 && r.is_finite()));
    }

    fn kink_directions(&self, from: [f64; 2], angles: &mut Vec<f64>) {
        // On a kink: along it.
        let on_knot = |knot: &f64| (knot - from[self.across]).abs() <= 4.0 * f64::EPSILON * knot.abs();
        if !self.heights.is_smooth() && self.heights.knots().iter().any(on_knot) {
            let along = self.along() as f64 * std::f64::consts::FRAC_PI_2;
            angles.extend([along, along + std::f64::consts::PI]);
        }
    }
}

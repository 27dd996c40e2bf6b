//! The overlap of a gap, f = depth - g, enclosed by what the gap knows of itself.

use super::overlap::{Interval, Jet, OverlapBounds};
use crate::clock::Deadline;
use crate::gap::{AnyGap, Cubic, Gap, Material, Reach, Taylor};
use crate::numeric;
use crate::numeric::geometry::Rect;
use crate::overlap::Scaled;

/// f = depth - g of any gap.
#[derive(Debug, Clone)]
pub struct GapOverlap<'a> {
    gap: &'a AnyGap,
    depth: f64,
    reach: Option<Rect>,
    /// Share of the depth to which means of the gap are found.
    open: f64,
    /// From then on they are left as they are.
    deadline: Deadline,
}

/// Share of the depth to which means of the gap are found unless said.
const OPEN: f64 = 1e-6;

/// No mean is known closer than that.
const ROUNDING: f64 = 1e-13;

/// Times that a cell is quartered for that.
const HALVINGS: u32 = 4;

/// What no bound is known of.
const UNKNOWN: Interval = [f64::NEG_INFINITY, f64::INFINITY];

impl<'a> GapOverlap<'a> {
    /// At a depth, in the units of the gap (E* = 1).
    #[must_use]
    pub fn new(gap: &'a AnyGap, depth: f64) -> Self {
        let reach = match gap.reach(depth) {
            Reach::Within(rect) => Some(rect),
            Reach::Nowhere | Reach::Unbounded { .. } | Reach::Unknown => None,
        };
        Self { gap, depth, reach, open: OPEN, deadline: Deadline::NEVER }
    }

    /// With means to this share of the depth while there is time: wider ones are bounds as well.
    pub(crate) fn of(scaled: &'a Scaled, open: f64, deadline: Deadline) -> Self {
        // Units move the sides by rounding.
        let reach = scaled.certain.then(|| scaled.reach.scaled(1.0 + 1e-12));
        Self { gap: &scaled.gap, depth: scaled.depth, reach, open: open.max(ROUNDING), deadline }
    }

    /// Whether it is known where the overlap ends.
    pub(super) fn is_certain(&self) -> bool {
        self.reach.is_some()
    }

    /// Bounds of the mean of the gap; of that of its quarters where they are too far apart.
    fn mean_of_gap(&self, rect: &Rect, deeper: u32) -> [f64; 2] {
        let [low, high] = self.gap.mean_bounds(rect).unwrap_or(UNKNOWN);
        let open = high - low;
        if deeper == 0 || open <= self.open * self.depth.abs() || low == f64::INFINITY {
            return [low, high];
        }
        // Once a cell.
        if deeper == HALVINGS && self.deadline.has_passed() {
            return [low, high];
        }
        let c = rect.centre();
        let quarters = [
            Rect { min: rect.min, max: c },
            Rect { min: [c[0], rect.min[1]], max: [rect.max[0], c[1]] },
            Rect { min: [rect.min[0], c[1]], max: [c[0], rect.max[1]] },
            Rect { min: c, max: rect.max },
        ];
        // Areas of quarters differ by rounding.
        let [a, b] = quarters.iter().fold([0.0; 2], |[a, b], quarter| {
            let [low, high] = self.mean_of_gap(quarter, deeper - 1);
            [a + 0.25 * low, b + 0.25 * high]
        });
        let rounding = 1e-14 * (a.abs() + b.abs() + self.depth.abs());
        [low.max(a - rounding), high.min(b + rounding)]
    }

    /// The overlap of a part of the gap at the same depth.
    pub(super) fn of_part<'b>(&self, gap: &'b AnyGap) -> GapOverlap<'b> {
        GapOverlap { gap, depth: self.depth, reach: None, open: self.open, deadline: self.deadline }
    }

    pub(super) fn depth(&self) -> f64 {
        self.depth
    }

    /// The gap itself.
    pub(super) fn gap(&self) -> &'a AnyGap {
        self.gap
    }

    /// Whether a mean between these ends is known as closely as is asked for.
    pub(super) fn is_close(&self, [low, high]: Interval) -> bool {
        high - low <= self.open * self.depth.abs()
    }

    /// The overlap over a rectangle from the gap there.
    pub(super) fn jet_of(&self, taylor: &Taylor) -> Jet {
        Jet {
            value: self.below_depth([taylor.value.lo, taylor.value.hi]),
            gradient: taylor.gradient.map(negative),
            hessian: taylor.hessian.map(negative),
            third: [[0.0; 2]; 4],
        }
    }

    /// The same to third order.
    pub(super) fn jet_of_cubic(&self, cubic: &Cubic) -> Jet {
        Jet { third: cubic.third.map(negative), ..self.jet_of(&cubic.middle) }
    }

    /// f from bounds of the gap.
    pub(super) fn below_depth(&self, [low, high]: [f64; 2]) -> Interval {
        let f = |g: f64, outward: fn(f64) -> f64| if g.is_finite() { outward(self.depth - g) } else { -g };
        [f(high, f64::next_down), f(low, f64::next_up)]
    }
}

fn negative(i: numeric::Interval) -> Interval {
    [-i.hi, -i.lo]
}

impl OverlapBounds for GapOverlap<'_> {
    fn bounds(&self, rect: &Rect, slope: [f64; 2]) -> Interval {
        self.gap.bounds(rect, slope.map(|s| -s)).map_or(UNKNOWN, |g| self.below_depth(g))
    }

    fn slopes(&self, rect: &Rect) -> [Interval; 2] {
        self.gap.slopes(rect).map_or([UNKNOWN; 2], |slopes| slopes.map(negative))
    }

    fn jet(&self, rect: &Rect) -> Option<Jet> {
        self.gap.taylor(rect).map(|taylor| self.jet_of(&taylor))
    }

    fn mean(&self, rect: &Rect) -> Interval {
        self.below_depth(self.mean_of_gap(rect, HALVINGS))
    }

    fn ends(&self) -> bool {
        self.gap.known().material != Material::Everywhere
    }

    fn material(&self, rect: &Rect) -> bool {
        self.gap.bounds(rect, [0.0; 2]).is_none_or(|[low, _]| low < f64::INFINITY)
    }

    fn reach(&self) -> Option<Rect> {
        self.reach
    }

    fn has_time(&self) -> bool {
        !self.deadline.has_passed()
    }

    fn mirrors(&self) -> [Option<f64>; 2] {
        let known = self.gap.known();
        [0, 1].map(|m| known.mirrors[m].then_some(known.centre[m]))
    }
}

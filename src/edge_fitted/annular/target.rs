//! The overlap on an interval of radii: a polynomial of second degree and bounds of what it leaves out.

use super::overlap::RadialBounds;

/// f on an interval: a polynomial of second degree and what it leaves out.
pub(crate) struct RadialTarget {
    middle: f64,
    value: f64,
    pub slope: f64,
    curvature: f64,
    pub value_slack: f64,
    pub slope_slack: f64,
    pub sampled: bool,
}

impl RadialTarget {
    pub fn new(overlap: Option<&dyn RadialBounds>, interval: [f64; 2]) -> Self {
        let middle = 0.5 * (interval[0] + interval[1]);
        let h = 0.5 * (interval[1] - interval[0]);
        let constant =
            Self { middle, value: 1.0, slope: 0.0, curvature: 0.0, value_slack: 0.0, slope_slack: 0.0, sampled: false };
        let Some(f) = overlap else { return constant };
        let mid = |v: [f64; 2]| 0.5 * (v[0] + v[1]);
        let spread = |v: [f64; 2]| 0.5 * (v[1] - v[0]);
        if let Some(jet) = f.jet(interval) {
            return Self {
                value: mid(jet.value),
                slope: mid(jet.slope),
                curvature: mid(jet.curvature),
                value_slack: spread(jet.value) + spread(jet.slope) * h + 0.5 * spread(jet.curvature) * h * h,
                slope_slack: spread(jet.slope) + spread(jet.curvature) * h,
                ..constant
            };
        }
        let bounds = f.bounds(interval);
        let (slopes, sampled) = match f.slopes(interval) {
            Some(s) => (s, false),
            None => {
                let slope = (f.value(interval[1]) - f.value(interval[0])) / (2.0 * h);
                let reach = (bounds[1] - bounds[0]) / h;
                ([slope - reach, slope + reach], true)
            }
        };
        let slope = mid(slopes);
        Self {
            value: mid(bounds),
            slope,
            value_slack: spread(bounds) + slope.abs() * h,
            slope_slack: spread(slopes),
            sampled,
            ..constant
        }
    }

    pub fn at(&self, r: f64) -> [f64; 2] {
        let d = r - self.middle;
        [self.value + d * (self.slope + 0.5 * d * self.curvature), self.slope + d * self.curvature]
    }
}

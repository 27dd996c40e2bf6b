//! The overlap of an axisymmetric gap along a radius.

/// Value and slope in the middle of an interval, curvature over it: every entry an interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RadialJet {
    /// f in the middle.
    pub value: [f64; 2],
    /// f' in the middle.
    pub slope: [f64; 2],
    /// f'' over the interval.
    pub curvature: [f64; 2],
}

/// Enclosures of f(r) = depth - gap(r). All bounds are certain.
pub(crate) trait RadialBounds {
    /// f at r.
    fn value(&self, r: f64) -> f64;
    /// Bounds of f over [a, b].
    fn bounds(&self, interval: [f64; 2]) -> [f64; 2];
    /// Second order; None where f has a kink or an end in the interval.
    fn jet(&self, interval: [f64; 2]) -> Option<RadialJet>;
    /// Radii beside which pressure may vary steeply: rings begin and end there.
    fn nodes(&self) -> &[f64] {
        &[]
    }
    /// Bounds of f' over [a, b], kinks included. None: not known.
    fn slopes(&self, interval: [f64; 2]) -> Option<[f64; 2]> {
        let jet = self.jet(interval)?;
        let reach = 0.5 * (interval[1] - interval[0]) * jet.curvature[0].abs().max(jet.curvature[1].abs());
        Some([(jet.slope[0] - reach).next_down(), (jet.slope[1] + reach).next_up()])
    }
}

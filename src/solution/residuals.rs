//! How well the conditions of contact are met.

/// How far a pressure is from a solution, recomputed from the pressure alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Residuals {
    /// Largest p |u - f|, relative to the largest pressure times the largest overlap.
    pub complementarity: f64,
    /// Largest tensile pressure, relative to the largest pressure.
    pub tension: f64,
    /// Largest f - u, also outside the candidate cells, relative to the largest overlap.
    pub penetration: f64,
}

impl Residuals {
    /// The largest of the three.
    #[must_use]
    pub fn worst(&self) -> f64 {
        self.complementarity.max(self.tension).max(self.penetration)
    }
}

//! What can be wrong with the input.

use std::fmt::Display;

/// A value that the problem cannot be built from: where it stands, what it is, what is allowed.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{path}: {given} is not allowed here; {allowed}")]
pub struct InputError {
    /// Place of the value, as a path into the scene: `gap.radii[0]`.
    pub path: String,
    /// The value as it was given.
    pub given: String,
    /// What is allowed in its place.
    pub allowed: String,
}

/// Digits of a number that anybody reads.
const LONG: usize = 30;

impl InputError {
    /// An error at `path` about the value `given`.
    pub fn new(path: impl Into<String>, given: impl Display, allowed: impl Into<String>) -> Self {
        let given = given.to_string();
        // A number of hundreds of digits is one for its magnitude alone.
        let long = given.parse::<f64>().ok().filter(|v| given.len() > LONG && v.is_finite());
        let given = long.map_or(given, |v| format!("{v:e}"));
        Self { path: path.into(), given, allowed: allowed.into() }
    }

    /// The same error seen from outside: `radii[0]` within `gap` is `gap.radii[0]`.
    #[must_use]
    pub fn within(mut self, outer: &str) -> Self {
        self.path = match self.path.chars().next() {
            None => outer.to_owned(),
            Some('[') => format!("{outer}{}", self.path),
            Some(_) => format!("{outer}.{}", self.path),
        };
        self
    }
}

/// A finite number, or an error at `path`.
pub(crate) fn finite(path: &str, value: f64) -> Result<f64, InputError> {
    if value.is_finite() { Ok(value) } else { Err(InputError::new(path, value, "a finite number")) }
}

/// A finite number greater than zero, or an error at `path`.
pub(crate) fn positive(path: &str, value: f64) -> Result<f64, InputError> {
    if value.is_finite() && value > 0.0 {
        Ok(value)
    } else {
        Err(InputError::new(path, value, "a finite number greater than 0"))
    }
}

//! States by a formula or an approximate method: what they rest on is applied again, and the field of a formula is checked by the
//! displacement of its cells.

use super::result::State;
use super::state::{ROUNDING, matrix};
use super::{Verification, close, formula};
use crate::bracket;
use crate::error::InputError;
use crate::gap::AnyGap;
use crate::problem::{Load, Loading, Method, Outputs, Settings};
use crate::scene::{Json, Scene};
use crate::solution::Solution;
use crate::solve::solve;

/// Share by which the value of a cell may differ from what the displacement of its neighbours asks for.
const UNEXPLAINED: f64 = 0.05;

/// Relative difference of an approximate method from itself under another tolerance.
const APPROXIMATE: f64 = 1e-5;

impl State<'_> {
    pub(super) fn applied_again(
        &self,
        scene: &Scene,
        gap: &AnyGap,
        found: &mut Verification,
    ) -> Result<(), InputError> {
        let method = match (self.origin.as_str(), self.method.as_str()) {
            ("closed_form", "closed_form") => Method::ClosedForm,
            ("approximate", "ritz") => Method::Ritz,
            ("approximate", "fabrikant") => Method::Fabrikant,
            ("edge_fitted", "edge_fitted") => Method::EdgeFitted,
            (origin, method) => {
                found.require(false, format!("the origin {origin} is that of the method {method}"));
                return Ok(());
            }
        };
        let fitted = method == Method::EdgeFitted;
        let cells = self.field.as_ref().map(|field| field.grid.shape[0].max(field.grid.shape[1])).filter(|_| !fitted);
        let has = |path: &str| self.reader.get(path).map(|value| value.is_some());
        let outputs = Outputs {
            pressure: self.field.is_some(),
            patch: has("patch.boundary")?,
            energy: has("energy")?,
            ..Outputs::default()
        };
        let load = match self.tilt {
            [0.0, 0.0] => Load::Depth(self.depth),
            tilt => Load::Tilted { depth: self.depth, tilt },
        };
        // The tolerance is that of the scene, and the verdict of no concern.
        let settings = Settings { method, cells, outputs, ..scene.settings };
        let answer = solve(&scene.contact.under(Loading::Single(load)), &settings).pop();
        let own = answer.and_then(|answer| answer.map_or_else(|e| e.best.map(|best| *best), Some));
        let Some(own) = own else {
            found.require(false, format!("{} answers this scene", method.name()));
            return Ok(());
        };
        let share = match method {
            Method::ClosedForm => ROUNDING,
            // The same cells for the same tolerance; else both err by what they state.
            Method::EdgeFitted if close(own.force, self.force, ROUNDING) => ROUNDING,
            Method::EdgeFitted => self.error().unwrap_or(0.0) + own.force_error.unwrap_or(0.0),
            _ => APPROXIMATE,
        };
        self.agrees_with(&own, share, found)?;
        if fitted {
            self.holds_bracket_of(&own, found);
        } else if let Some(field) = &self.field {
            let modulus = scene.contact.modulus();
            let (worst, at) = formula::unexplained(gap, modulus, self.depth, field);
            found.require(
                worst <= UNEXPLAINED,
                format!(
                    "every value away from edges fits the displacement of its neighbours: worst {worst:.1e} at {at:?}, \
                     {UNEXPLAINED:.0e} allowed"
                ),
            );
            let [low, high] = formula::window(gap, modulus, self.depth, field);
            found.require(
                low <= self.force && self.force <= high,
                format!(
                    "force {:e}: the field carries {:e} and allows for [{low:e}, {high:e}]",
                    self.force,
                    field.force()
                ),
            );
        } else if method != Method::ClosedForm && self.bracket.is_none() {
            let own = bracket::approximate(gap, scene.contact.modulus(), self.depth);
            let holds = own.as_ref().is_ok_and(|own| own.upper() >= self.force * (1.0 - APPROXIMATE));
            found.require(holds, "the force is no more than that of a simpler gap which lies below");
        }
        Ok(())
    }

    /// The bracket that is claimed holds the one that was found again.
    fn holds_bracket_of(&self, own: &Solution, found: &mut Verification) {
        let (Some(claimed), Some(own)) = (&self.bracket, &own.bracket) else { return };
        let (lower, upper) = (own.lower(), own.upper());
        found.require(
            claimed.lower <= lower * (1.0 + ROUNDING) && upper * (1.0 - ROUNDING) <= claimed.upper,
            format!(
                "the bracket [{:e}, {:e}] holds the one of the same cells, [{lower:e}, {upper:e}]",
                claimed.lower, claimed.upper
            ),
        );
    }

    /// Every number is that of the method, applied again.
    fn agrees_with(&self, own: &Solution, share: f64, found: &mut Verification) -> Result<(), InputError> {
        let reader = &self.reader;
        let mut numbers: Vec<(&str, Option<f64>)> = vec![
            ("depth", Some(own.depth)),
            ("force", Some(own.force)),
            ("stiffness", Some(own.stiffness)),
            ("energy", own.energy),
            ("patch.area", Some(own.patch.area)),
            ("patch.regions", Some(own.patch.regions as f64)),
            ("patch.max_radius", Some(own.patch.max_radius)),
            ("pressure.max", own.pressure.max),
        ];
        // Under a tilt of its own the state was balanced at these very tilts.
        numbers.retain(|(path, _)| reader.get(path).is_ok_and(|value| value.is_some()));
        for (path, value) in numbers {
            let said = reader.need(path)?;
            let holds = value.is_some_and(|value| close(said, value, share));
            found.require(holds, format!("{path} {said:e} is that of {}", self.method));
            reader.use_up(path);
        }
        reader.use_up("tilt");
        let length = own.patch.max_radius;
        for (path, value, size) in [
            ("patch.centroid", own.patch.centroid, length),
            ("pressure.at", own.pressure.at, length),
            ("moment", own.moment, own.force * length),
        ] {
            if let Some(said) = reader.pair(path)? {
                let near =
                    |value: [f64; 2]| (0..2).all(|m| (said[m] - value[m]).abs() <= share * (size + value[m].abs()));
                found.require(value.is_some_and(near), format!("{path} {said:?} is that of {}", self.method));
                reader.use_up(path);
            }
        }
        if let Some(error) = self.error() {
            let least = own.force_error.unwrap_or(f64::INFINITY);
            found.require(
                error >= least * (1.0 - ROUNDING),
                format!("the stated error {error:.1e} is no less than that of {}, {least:.1e}", self.method),
            );
            reader.use_up("force_error");
            reader.use_up("depth_error");
        }
        self.pieces_are(&own.patch.pieces, share, share * length, found)?;
        if let (Some(said), Some(axes)) = (reader.pair("patch.semi_axes")?, own.patch.semi_axes) {
            let holds = (0..2).all(|m| close(said[m], axes[m], share));
            found.require(holds, format!("the semi-axes {said:?} are those of {}", self.method));
            reader.use_up("patch.semi_axes");
        }
        if let (Some(said), Some(angle)) = (reader.number("patch.angle")?, own.patch.angle) {
            let holds = (said.to_radians() - angle).abs() <= share.max(1e-9);
            found.require(holds, format!("the angle {said} degrees is that of {}", self.method));
            reader.use_up("patch.angle");
        }
        for (path, value) in [
            ("stiffness_error", own.stiffness_error),
            ("energy_error", own.energy_error),
            ("area_error", own.area_error),
            ("pressure.max_error", own.pressure.max_error),
        ] {
            if let (Some(said), Some(least)) = (reader.number(path)?, value) {
                let holds = said >= least * (1.0 - ROUNDING) && said < 1.0;
                found.require(holds, format!("{path} {said:.1e} is no less than that of {}, {least:.1e}", self.method));
                reader.use_up(path);
            }
        }
        if let (Some(said), Some(own)) = (reader.get("validity")?, own.validity) {
            let mut holds = true;
            for (key, value) in [
                ("slope", Some(own.slope)),
                ("size_over_radius", own.size_over_radius),
                ("pressure_over_modulus", Some(own.pressure_over_modulus)),
            ] {
                if let Some(Json::Number(n)) = said.get(key) {
                    let near = |value: f64| n.as_f64().is_some_and(|said| close(said, value, share.max(1e-6)));
                    holds &= value.is_some_and(near);
                }
            }
            found.require(holds, "what is small against 1 is that of the state found again");
            reader.use_up("validity");
        }
        if let Some(rows) = reader.get("stiffness_matrix")? {
            let size = |i: usize, j: usize| own.stiffness * length.powi(i32::from(i > 0) + i32::from(j > 0));
            let near = |said: [[f64; 3]; 3], own: [[f64; 3]; 3]| {
                (0..9)
                    .map(|n| (n / 3, n % 3))
                    .all(|(i, j)| (said[i][j] - own[i][j]).abs() <= 1e-6 * (size(i, j) + own[i][j].abs()))
            };
            match (matrix(rows), own.stiffness_matrix) {
                (Some(said), Some(own)) => {
                    found.require(near(said, own), format!("the stiffness matrix is that of {}", self.method));
                    reader.use_up("stiffness_matrix");
                }
                (None, _) => found.require(false, "the stiffness matrix has three rows of three numbers"),
                // Computed for a punch that is free to tilt alone.
                (Some(_), None) => {}
            }
        }
        if let (Some(said), Some(own)) = (reader.get("patch.boundary")?, &own.patch.boundary) {
            let holds = boundary_distance(said, own).is_some_and(|off| off <= share.max(1e-6) * length);
            found.require(holds, format!("the boundary is that of {}", self.method));
            reader.use_up("patch.boundary");
        }
        if let (Some(said), Some(own)) = (&self.field, &own.pressure.field) {
            let ([a, b], highest) = ([said, own].map(|f| f.grid), own.values.iter().copied().fold(0.0, f64::max));
            let same = a.shape == b.shape
                && (0..2).all(|m| {
                    let size = b.spacing[m] * b.shape[m] as f64;
                    close(a.spacing[m], b.spacing[m], ROUNDING) && (a.origin[m] - b.origin[m]).abs() <= ROUNDING * size
                });
            let each = said.values.len() == own.values.len()
                && said.values.iter().zip(&own.values).all(|(p, q)| (p - q).abs() <= 1e-6 * highest);
            found.require(same && each, format!("the pressure field is that of {}", self.method));
            reader.use_up("pressure.field");
            if reader.get("grid")?.is_some() {
                self.grid_is_that_of(a, found)?;
            }
        }
        Ok(())
    }
}

/// Largest distance between the points of two lists of closed lines; `None` where they have other numbers of points.
pub(super) fn boundary_distance(said: &Json, own: &[Vec<[f64; 2]>]) -> Option<f64> {
    let Json::Array(loops) = said else { return None };
    if loops.len() != own.len() {
        return None;
    }
    let mut farthest = 0.0_f64;
    for (said, own) in loops.iter().zip(own) {
        let Json::Array(points) = said else { return None };
        if points.len() != own.len() {
            return None;
        }
        for (said, own) in points.iter().zip(own) {
            let Json::Array(pair) = said else { return None };
            let [Json::Number(x), Json::Number(y)] = pair.as_slice() else { return None };
            let off = (x.as_f64()? - own[0]).hypot(y.as_f64()? - own[1]);
            if !(off <= farthest) {
                farthest = off;
            }
        }
    }
    Some(farthest)
}

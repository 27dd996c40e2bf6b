//! What a result says of its own numbers: pieces that add up, errors that follow from one another, what is small where the theory holds.

use super::result::State;
use super::state::ROUNDING;
use super::{Verification, close};
use crate::error::InputError;
use crate::scene::{Json, Scene};
use crate::solution::Piece;

impl State<'_> {
    /// The pieces carry the force together and have the area.
    pub(super) fn pieces_add_up(&self, found: &mut Verification) -> Result<(), InputError> {
        let Some(Json::Array(pieces)) = self.reader.get("patch.pieces")? else { return Ok(()) };
        // An approximate method has them with its boundary.
        let without = self.origin == "approximate" && self.reader.get("patch.boundary")?.is_none();
        for (key, all) in [("force", self.force), ("area", self.area)] {
            let parts: Option<Vec<f64>> = pieces
                .iter()
                .map(|piece| if let Some(Json::Number(n)) = piece.get(key) { n.as_f64() } else { None })
                .collect();
            let sum = parts.map(|parts| parts.iter().sum::<f64>());
            found.require(
                sum.is_some_and(|sum| close(sum, all, ROUNDING)) || (pieces.is_empty() && (all == 0.0 || without)),
                format!("the {key} of all {} pieces is {all:e}", pieces.len()),
            );
        }
        Ok(())
    }

    /// Pieces of their own, in the order of the result: each number to the accuracy of the caller, forces and pressures to `share`,
    /// areas and places to `off`, a length.
    pub(super) fn pieces_are(
        &self,
        own: &[Piece],
        share: f64,
        off: f64,
        found: &mut Verification,
    ) -> Result<(), InputError> {
        let Some(Json::Array(said)) = self.reader.get("patch.pieces")? else { return Ok(()) };
        let number = |piece: &Json, key: &str| match piece.get(key) {
            Some(Json::Number(n)) => n.as_f64(),
            _ => None,
        };
        let pair = |value: Option<&Json>| match value {
            Some(Json::Array(items)) => {
                let both = items.iter().map(|v| if let Json::Number(n) = v { n.as_f64() } else { None });
                <[f64; 2]>::try_from(both.collect::<Option<Vec<_>>>()?).ok()
            }
            _ => None,
        };
        let near = |said: Option<[f64; 2]>, own: [f64; 2]| {
            said.is_some_and(|said| (0..2).all(|m| (said[m] - own[m]).abs() <= off + share * own[m].abs()))
        };
        let is = |said: &Json, own: &Piece| {
            let around = 4.0 * off * own.area.sqrt() + share * own.area;
            let corner = |k: usize| match said.get("extent") {
                Some(Json::Array(corners)) => pair(corners.get(k)),
                _ => None,
            };
            number(said, "force").is_some_and(|force| close(force, own.force, share))
                && number(said, "area").is_some_and(|area| (area - own.area).abs() <= around)
                && near(pair(said.get("centroid")), own.centroid)
                && (0..2).all(|k| near(corner(k), own.extent[k]))
                && match (number(said, "max_pressure"), own.max_pressure) {
                    (Some(said), Some(own)) => close(said, own, share),
                    (None, _) => true,
                    (Some(_), None) => false,
                }
        };
        let holds = said.len() == own.len() && said.iter().zip(own).all(|(said, own)| is(said, own));
        found.require(holds, format!("the {} pieces are those found again", said.len()));
        self.reader.use_up("patch.pieces");
        Ok(())
    }

    /// What else is small where the theory holds.
    pub(super) fn validity_is(&self, scene: &Scene, found: &mut Verification) -> Result<(), InputError> {
        if let Some(said) = self.reader.number("validity.pressure_over_modulus")? {
            let own = self.force / self.area / scene.contact.modulus().e_star();
            let what = format!("the mean pressure over E*, {said:e}, follows from force and area");
            found.require(close(said, own, ROUNDING), what);
            self.reader.use_up("validity.pressure_over_modulus");
        }
        Ok(())
    }

    /// Errors that follow from that of the force, or under a force from that of the depth, where the gap is homogeneous: no less.
    pub(super) fn errors_follow(&self, lowest: f64, found: &mut Verification) -> Result<(), InputError> {
        let Some(least) = (match self.depth_error {
            Some(error) if error != 0.0 => Some(error * (self.depth / (self.depth - lowest)).abs()),
            _ => self.force_error,
        }) else {
            return Ok(());
        };
        for path in ["stiffness_error", "energy_error"] {
            if let Some(said) = self.reader.number(path)? {
                found.require(
                    said >= least * (1.0 - ROUNDING) && said < 1.0,
                    format!("{path} {said:.1e} is no less than {least:.1e}, which it follows from"),
                );
                self.reader.use_up(path);
            }
        }
        Ok(())
    }
}

//! What a result says of its own numbers: pieces that add up, errors that follow from one another, what is small where the theory holds.

use super::result::{State, key};
use super::state::ROUNDING;
use super::{Verification, close};
use crate::result;
use crate::scene::Scene;
use crate::solution::Piece;

impl State<'_> {
    /// The pieces carry the force together and have the area.
    pub(super) fn pieces_add_up(&self, found: &mut Verification) {
        let Some(pieces) = self.get(key!(patch.pieces)) else { return };
        // An approximate method has them with its boundary.
        let without = self.origin == "approximate" && self.get(key!(patch.boundary)).is_none();
        let sum = |of: fn(&result::Piece) -> f64| pieces.iter().map(of).sum::<f64>();
        for (key, sum, all) in [("force", sum(|p| p.force), self.force), ("area", sum(|p| p.area), self.area)] {
            found.require(
                close(sum, all, ROUNDING) || (pieces.is_empty() && (all == 0.0 || without)),
                format!("the {key} of all {} pieces is {all:e}", pieces.len()),
            );
        }
    }

    /// Pieces of their own, the strongest first: each number to the accuracy of the caller, forces and pressures to `share`, areas and places
    /// to `off`, a length. Which of several that carry as much comes first is for the last digit to say.
    pub(super) fn pieces_are(&self, own: &[Piece], share: f64, off: f64, found: &mut Verification) {
        let Some(said) = self.get(key!(patch.pieces)) else { return };
        let near =
            |said: [f64; 2], own: [f64; 2]| (0..2).all(|m| (said[m] - own[m]).abs() <= off + share * own[m].abs());
        let is = |said: &result::Piece, own: &Piece| {
            let around = 4.0 * off * own.area.sqrt() + share * own.area;
            close(said.force, own.force, share)
                && (said.area - own.area).abs() <= around
                && near(said.centroid, own.centroid)
                && (0..2).all(|k| near(said.extent[k], own.extent[k]))
                && said.max_pressure.is_none_or(|said| own.max_pressure.is_some_and(|own| close(said, own, share)))
        };
        let mut left: Vec<&Piece> = own.iter().collect();
        let mut again = |said: &result::Piece| {
            let found = left.iter().position(|own| is(said, own)).map(|k| left.remove(k));
            found.is_some()
        };
        let falling = said.windows(2).all(|pair| pair[1].force <= pair[0].force * (1.0 + share));
        let holds = said.len() == own.len() && falling && said.iter().all(&mut again);
        found.require(holds, format!("the {} pieces are those found again", said.len()));
        self.use_up(key!(patch.pieces));
    }

    /// What else is small where the theory holds.
    pub(super) fn validity_is(&self, scene: &Scene, found: &mut Verification) {
        if let Some(said) = self.get(key!(validity.pressure_over_modulus)) {
            let own = self.force / self.area / scene.contact.modulus().e_star();
            let what = format!("the mean pressure over E*, {said:e}, follows from force and area");
            found.require(close(said, own, ROUNDING), what);
            self.use_up(key!(validity.pressure_over_modulus));
        }
    }

    /// Errors that follow from that of the force, or under a force from that of the depth, where the gap is homogeneous: no less.
    pub(super) fn errors_follow(&self, lowest: f64, found: &mut Verification) {
        let Some(least) = (match self.depth_error {
            Some(error) if error != 0.0 => Some(error * (self.depth / (self.depth - lowest)).abs()),
            _ => self.force_error,
        }) else {
            return;
        };
        for key in [key!(stiffness_error), key!(energy_error)] {
            if let Some(said) = self.get(key) {
                found.require(
                    said >= least * (1.0 - ROUNDING) && said < 1.0,
                    format!("{} {said:.1e} is no less than {least:.1e}, which it follows from", key.path),
                );
                self.use_up(key);
            }
        }
    }
}

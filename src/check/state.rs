//! The check of one state of a result.

use super::bounds::sound;
use super::result::{Bounds, Proof, State, key};
use super::scaled::ScaledField;
use super::{Claim, Shared, Verification, bounds, close, energy};
use crate::bracket::{self, DepthBracket};
use crate::error::InputError;
use crate::gap::{AnyGap, Gap};
use crate::grid::Pressure;
use crate::overlap::{least, touching};
use crate::problem::Load;
use crate::result;
use crate::scene::Scene;

/// Relative difference of two numbers that are written from the same ones.
pub(super) const ROUNDING: f64 = 1e-9;

impl State<'_> {
    /// Checks the state against the scene and the load that it is said to answer.
    ///
    /// # Errors
    /// Names the path of what is missing or has another type.
    pub fn check(&self, scene: &Scene, load: Load) -> Result<Verification, InputError> {
        self.check_among(scene, load, &Shared::default())
    }

    /// The same for one of several states of one scene: `shared` keeps what they share.
    ///
    /// # Errors
    /// As [`Self::check`].
    pub fn check_among(&self, scene: &Scene, load: Load, shared: &Shared) -> Result<Verification, InputError> {
        let mut found = Verification::default();
        let whole = scene.contact.tilted_gap(self.tilt);
        // Without what the bodies do not reach at this depth.
        let gap = touching(&whole, self.depth);
        self.as_loaded(load, &mut found);
        self.error_is_allowed(scene, load, &mut found);
        if let Some(field) = &self.field {
            found.require(sound(field), "the pressure is finite and nowhere tensile");
        }
        match self.origin.as_str() {
            "no_contact" => self.apart(&whole, &mut found),
            "one_grid" | "many_grids" if !self.is_turned() => self.on_grid(scene, &gap, load, shared, &mut found)?,
            "closed_form" | "approximate" | "edge_fitted" | "one_grid" | "many_grids" | "separate_contacts" => {
                self.applied_again(scene, &gap, load, shared, &mut found);
            }
            other => {
                let known =
                    "closed_form, approximate, one_grid, many_grids, separate_contacts, edge_fitted or no_contact";
                return Err(InputError::new("origin.kind", format!("\"{other}\""), known));
            }
        }
        self.relations(&mut found);
        self.evidence(load, &mut found);
        if let Some(claimed) = &self.bracket {
            let under_force = matches!(load, Load::Force(_));
            self.bracketed(claimed, &gap, scene, load, &mut found);
            if under_force {
                self.depth_bracketed(claimed, &whole, &mut found);
            }
        }
        found.unchecked = self.unused();
        Ok(found)
    }

    /// Whether its bounds are found again, by solving it as a whole or, where a formula comes without their fields, by the same grids.
    pub(super) fn is_bounded_again(&self) -> bool {
        let by_fields = |b: &Bounds| !b.needs_no_field() && !b.is_of_energy();
        let has_field = |p: &Option<Proof>| p.as_ref().is_some_and(|p| p.pressure.is_some());
        let lacking = |b: &Bounds| by_fields(b) && !(has_field(&b.above) && has_field(&b.below));
        match self.origin.as_str() {
            "edge_fitted" | "separate_contacts" => true,
            "closed_form" | "approximate" => self.bracket.as_ref().is_some_and(lacking),
            _ => self.is_turned(),
        }
    }

    /// Whether it was solved along axes other than the user's: the field is a mean of that of turned cells, and shows nothing by itself.
    pub(super) fn is_turned(&self) -> bool {
        self.said.origin.one().is_some_and(|origin| origin.turned.is_some())
    }

    /// What the error is said to be: one of the words for it, and what goes with that.
    fn evidence(&self, load: Load, found: &mut Verification) {
        match self.said.evidence.one().map(AsRef::as_ref) {
            Some("exact") => {
                let formula = matches!(self.origin.as_str(), "closed_form" | "no_contact");
                found.require(formula, format!("only a formula is exact, and {} is none", self.origin));
            }
            Some(word @ ("proved" | "sampled")) => {
                let within = |value: f64, error: Option<f64>, [lower, upper]: [f64; 2]| {
                    let room = error.unwrap_or(0.0) * value.abs() * (1.0 + ROUNDING);
                    upper - value <= room && value - lower <= room
                };
                let said = self.said.bracket.one();
                let (what, evidence, holds) = if matches!(load, Load::Depth(_) | Load::Tilted { .. }) {
                    let own = |b: &Bounds| within(self.force, self.force_error, [b.lower, b.upper]);
                    ("force", said.map(|said| &said.evidence), self.bracket.as_ref().is_some_and(own))
                } else {
                    let said = said.and_then(|said| said.depth.as_ref());
                    let bounds = said.and_then(|depth| depth.lower.zip(depth.upper));
                    let own = |(lower, upper)| within(self.depth, self.depth_error, [lower, upper]);
                    ("depth", said.map(|depth| &depth.evidence), bounds.is_some_and(own))
                };
                found.require(
                    holds && evidence.is_some_and(|own| own == word),
                    format!("the error is {word}: so is a bracket of the {what}, within the stated error"),
                );
            }
            Some("estimated") | None => {}
            Some(other) => found
                .require(false, format!("an error is exact, proved, sampled or estimated; it is said to be {other}")),
        }
        if let Some(said) = self.said.bracket.one() {
            let sides = [&said.below, &said.above].into_iter().flatten().map(|side| side.evidence.as_ref());
            for word in sides.chain([said.evidence.as_ref()]) {
                let known = matches!(word, "proved" | "sampled");
                found.require(known, format!("a bracket is proved or sampled; it is said to be {word}"));
            }
            let proved = |side: &Option<result::Side>| side.as_ref().is_some_and(|side| side.evidence == "proved");
            let both = proved(&said.below) && proved(&said.above);
            let own = &said.evidence;
            found.require((own == "proved") == both, format!("a bracket is proved where both sides are: {own}"));
        }
    }

    /// What was prescribed comes back as it was given.
    fn as_loaded(&self, load: Load, found: &mut Verification) {
        let same = |a: f64, b: f64| close(a, b, 1e-12);
        let (holds, what) = match load {
            Load::Depth(depth) => (same(self.depth, depth) && self.tilt == [0.0; 2], "depth"),
            Load::Tilted { depth, tilt } => (same(self.depth, depth) && self.tilt == tilt, "depth and tilt"),
            Load::Force(force) => (same(self.force, force) && self.tilt == [0.0; 2], "force"),
            Load::ForceMoment { force, moment } => {
                let given = self.get(key!(moment));
                (same(self.force, force) && (force == 0.0 || given == Some(moment)), "force and moments")
            }
        };
        found.require(
            holds,
            format!("the {what} are those of the loading: depth {:e}, force {:e}", self.depth, self.force),
        );
        match load {
            Load::Depth(_) | Load::Tilted { .. } => self.use_up(key!(depth)),
            Load::Force(_) | Load::ForceMoment { .. } => self.use_up(key!(force)),
        }
        if !matches!(load, Load::ForceMoment { .. }) {
            self.use_up(key!(tilt));
        }
    }

    /// The relative error of the force at the depth of the state: under a force that of the depth, by the stiffness.
    pub(super) fn error(&self) -> Option<f64> {
        match self.depth_error {
            Some(error) if error != 0.0 => {
                let stiffness = self.get(key!(stiffness))?;
                Some(error * (self.depth * stiffness / self.force).abs())
            }
            _ => self.force_error,
        }
    }

    /// A solved state states an error below 1, one that its scene asked for, and none of what was prescribed.
    fn error_is_allowed(&self, scene: &Scene, load: Load, found: &mut Verification) {
        let prescribed = match load {
            Load::Depth(_) | Load::Tilted { .. } => key!(depth_error),
            Load::Force(_) | Load::ForceMoment { .. } => key!(force_error),
        };
        if let Some(error) = self.get(prescribed) {
            found.require(error == 0.0, format!("{} {error:e} is 0: that was prescribed", prescribed.path));
            self.use_up(prescribed);
        }
        let Some(error) = self.error() else { return };
        found.require((0.0..1.0).contains(&error), format!("the stated error {error:e} is from 0 to 1"));
        if error > scene.settings.tolerance {
            found.checked.push(format!(
                "the stated error {error:.1e} is larger than the tolerance of the scene, {:.1e}: solved with another one (--tolerance)",
                scene.settings.tolerance
            ));
        }
    }

    /// Nothing touches, and every number says so.
    fn apart(&self, gap: &AnyGap, found: &mut Verification) {
        let overlap = |[x, y]: [f64; 2]| gap.gap(x, y) < self.depth;
        found.require(
            !overlap(gap.known().centre) && !overlap(least(gap).0),
            "no force: the undeformed bodies do not overlap",
        );
        for key in [
            key!(force),
            key!(force_error),
            key!(depth_error),
            key!(stiffness_error),
            key!(energy_error),
            key!(area_error),
            key!(pressure.max_error),
            key!(stiffness),
            key!(energy),
            key!(patch.area),
            key!(patch.regions as f64),
            key!(patch.max_radius),
            key!(pressure.max),
        ] {
            if let Some(value) = self.get(key) {
                found.require(value == 0.0, format!("{} {value:e} is 0 without contact", key.path));
                self.use_up(key);
            }
        }
        if let Some(moment) = self.get(key!(moment)) {
            found.require(moment.iter().all(|m| *m == 0.0), "the moments are 0 without contact");
            self.use_up(key!(moment));
        }
        if let Some(rows) = self.get(key!(stiffness_matrix)) {
            found.require(rows.iter().flatten().all(|k| *k == 0.0), "the stiffness matrix is 0 without contact");
            self.use_up(key!(stiffness_matrix));
        }
        self.use_up(key!(depth));
    }

    /// Numbers that follow from others.
    fn relations(&self, found: &mut Verification) {
        if let Some(mean) = self.get(key!(pressure.mean)) {
            found.require(
                close(mean * self.area, self.force, ROUNDING),
                format!("mean pressure {mean:e} times area {:e} is the force", self.area),
            );
            self.use_up(key!(pressure.mean));
        }
        if let (Some(centre), Some(moment)) = (self.get(key!(centre_of_pressure)), self.get(key!(moment))) {
            let holds = close(centre[0] * self.force, -moment[1], ROUNDING)
                && close(centre[1] * self.force, moment[0], ROUNDING);
            found.require(
                holds,
                format!("the centre of pressure {centre:?} is where the force has the moments {moment:?}"),
            );
            self.use_up(key!(centre_of_pressure));
        }
        if self.get(key!(pressure.singular)).is_some() {
            let none = self.get(key!(pressure.max)).is_none();
            found.require(none, "a pressure that is infinite has no largest value");
        }
        self.pieces_add_up(found)
    }

    /// The bracket follows from its pressures, and the force lies in it but for its own error.
    fn bracketed(&self, claimed: &Bounds, gap: &AnyGap, scene: &Scene, load: Load, found: &mut Verification) {
        let force_driven = !matches!(load, Load::Depth(_) | Load::Tilted { .. });
        let error = self.error().unwrap_or(0.0);
        let room = error * self.force + if force_driven { 0.01 * self.force } else { 0.0 };
        found.require(
            self.origin == "approximate" || (claimed.lower - room <= self.force && self.force <= claimed.upper + room),
            format!("the force {:e} lies in the bracket, but for its own error", self.force),
        );
        let checked = if self.is_bounded_again() {
            // With the other numbers, by the same cells or grids.
            Verification::default()
        } else if claimed.is_of_energy() {
            let own = claimed.above.as_ref().and_then(|above| above.pressure.as_ref());
            claimed.by_energy(gap, scene, self.depth, own.or(self.field.as_ref()))
        } else {
            claimed.check(gap, scene, self.depth)
        };
        if claimed.needs_no_field() || checked.accepted() {
            self.use_all(|said| {
                let Some(bracket) = said.bracket.one_mut() else { return };
                (bracket.lower, bracket.upper) = (None, None);
                for side in [&mut bracket.below, &mut bracket.above].into_iter().flatten() {
                    (side.discs, side.level, side.degree, side.field) = (None, None, None, None);
                }
            });
        }
        found.join(checked);
    }

    /// The bounds of the depth follow from those of the force.
    fn depth_bracketed(&self, claimed: &Bounds, gap: &AnyGap, found: &mut Verification) {
        let Some(result::DepthBracket { lower: Some(lower), upper, .. }) = self.get(key!(bracket.depth)) else {
            return;
        };
        let [own, above] = DepthBracket::bounds(gap, self.depth, self.force, [claimed.lower, claimed.upper]);
        let same = match upper {
            Some(upper) => close(upper, above, ROUNDING),
            None => !above.is_finite(),
        };
        found.require(
            same && close(lower, own, ROUNDING),
            format!("the bounds of the depth, {lower:e} and {upper:?}, follow from those of the force"),
        );
        self.use_up(key!(bracket.depth));
    }
}

impl Bounds {
    /// Whether the theorems on both sides do without a pressure field.
    pub(super) fn needs_no_field(&self) -> bool {
        let without = |p: &Option<Proof>| {
            p.as_ref().is_some_and(|p| matches!(p.theorem.as_str(), "ellipse" | "fabrikant" | "comparison"))
        };
        without(&self.above) && without(&self.below)
    }

    pub(super) fn is_of_energy(&self) -> bool {
        let energy = |p: &Option<Proof>| p.as_ref().is_some_and(|p| p.theorem == "energy");
        energy(&self.above) && energy(&self.below)
    }

    /// Bounds by the energy of the pressure of the solution, worked out again from that.
    fn by_energy(&self, gap: &AnyGap, scene: &Scene, depth: f64, field: Option<&Pressure>) -> Verification {
        let mut found = Verification::default();
        let scaled = field.and_then(|field| ScaledField::of(gap, scene.contact.modulus(), depth, field));
        let holds =
            |[lower, upper]: [f64; 2]| self.lower <= lower * (1.0 + ROUNDING) && self.upper >= upper * (1.0 - ROUNDING);
        let own = scaled.and_then(|scaled| scaled.force_bounds(holds));
        found.require(
            own.is_some_and(holds),
            format!("the bracket [{:e}, {:e}]: the energy of the field proves {own:?}", self.lower, self.upper),
        );
        if let Some([below, above]) = field.and_then(|field| energy::ends(gap, scene.contact.modulus(), depth, field)) {
            found.require(
                self.lower <= below && self.upper >= above,
                format!(
                    "the bracket [{:e}, {:e}] is no narrower than sums show: [{below:e}, {above:e}]",
                    self.lower, self.upper
                ),
            );
        }
        found
    }

    fn check(&self, gap: &AnyGap, scene: &Scene, depth: f64) -> Verification {
        let modulus = scene.contact.modulus();
        if self.needs_no_field() {
            return self.check_again(gap, scene, depth);
        }
        let pressures = (self.above.as_ref(), self.below.as_ref());
        if let (Some(above), Some(below)) = pressures
            && let (Some(q), Some(m)) = (&above.pressure, &below.pressure)
        {
            let upper = Claim { force: self.upper, repair: above.repair, proved: above.proved, pressure: q };
            let lower = Claim { force: self.lower, repair: below.repair, proved: below.proved, pressure: m };
            return bounds(gap, modulus, depth, &upper, &lower);
        }
        let mut found = Verification::default();
        let what = format!("the bracket [{:e}, {:e}] comes with the fields that prove it", self.lower, self.upper);
        found.require(false, what);
        found
    }

    /// A bracket without fields: its theorems are applied again.
    fn check_again(&self, gap: &AnyGap, scene: &Scene, depth: f64) -> Verification {
        let mut found = Verification::default();
        let own = bracket::approximate(gap, scene.contact.modulus(), depth);
        let holds = own.as_ref().is_ok_and(|own| {
            self.lower <= self.upper
                && close(self.lower, own.lower(), ROUNDING)
                && close(self.upper, own.upper(), ROUNDING)
        });
        found.require(holds, format!("the bracket [{:e}, {:e}] follows from its theorems", self.lower, self.upper));
        found
    }
}

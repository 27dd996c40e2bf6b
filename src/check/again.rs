//! States that no field shows by itself - by a formula, an approximate method, fitted or turned cells, a limit of grids: what they rest on is
//! applied again, and the field of a formula is checked by the displacement of its cells.

use std::sync::{Mutex, PoisonError};

use super::result::{Key, Proof, State, key};
use super::state::ROUNDING;
use super::{Verification, close, formula};
use crate::bracket::{self, DepthBracket, Evidence, Side};
use crate::gap::AnyGap;
use crate::grid_method::REPEATABLE;
use crate::loading::shared::Layers;
use crate::problem::{ErrorBar, Load, Loading, Method, Outputs, Settings};
use crate::result;
use crate::scene::Scene;
use crate::solution::{Origin, Solution};
use crate::solve::States;

/// Share by which the value of a cell may differ from what the displacement of its neighbours asks for.
const UNEXPLAINED: f64 = 0.05;

/// Relative difference of an approximate method from itself under another tolerance.
const APPROXIMATE: f64 = 1e-5;

/// Share of a bracket by which its ends may lie off those that other cells of the same fineness prove.
const ABOUT: f64 = 5e-3;

/// What errors of the size of the rounding are themselves rounded by.
const LAST_DIGITS: f64 = 4.0 * f64::EPSILON;

/// Of the error at a depth, the least share that is left of it under a force, which determines what grows with the depth less steeply.
const UNDER_FORCE: f64 = 0.5;

/// What the last, linear step of depth and tilts leaves of the energy, relative.
const LAST_STEP: f64 = 1e-7;

/// What the states of one result share where they are solved again.
#[derive(Default)]
pub struct Shared(Mutex<Vec<(Settings, Layers)>>);

impl Shared {
    /// For the loading of the scene, with these settings.
    fn layers(&self, settings: &Settings) -> Layers {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, known)) = all.iter().find(|(own, _)| own == settings) {
            return known.clone();
        }
        let own = Layers::default();
        all.push((*settings, own.clone()));
        own
    }
}

impl State<'_> {
    pub(super) fn applied_again(
        &self,
        scene: &Scene,
        gap: &AnyGap,
        load: Load,
        shared: &Shared,
        found: &mut Verification,
    ) {
        let method = match (self.origin.as_str(), self.method.as_str()) {
            ("closed_form", "closed_form") => Method::ClosedForm,
            ("approximate", "ritz") => Method::Ritz,
            ("approximate", "fabrikant") => Method::Fabrikant,
            ("edge_fitted", "edge_fitted") => Method::EdgeFitted,
            ("one_grid" | "many_grids" | "separate_contacts", "fft") => Method::Fft,
            ("one_grid" | "many_grids" | "separate_contacts", "qp") => Method::Qp,
            (origin, method) => {
                found.require(false, format!("the origin {origin} is that of the method {method}"));
                return;
            }
        };
        // The same cells, solved again.
        let by_cells = matches!(method, Method::EdgeFitted | Method::Fft | Method::Qp);
        let bounded_again = by_cells || self.is_bounded_again();
        let cells = self.field.as_ref().map(|field| field.grid.shape[0].max(field.grid.shape[1])).filter(|_| !by_cells);
        let outputs = Outputs {
            pressure: self.field.is_some(),
            patch: self.get(key!(patch.boundary)).is_some(),
            energy: self.get(key!(energy)).is_some(),
            bracket: bounded_again && scene.settings.outputs.bracket,
            gap: by_cells && self.get(key!(gap.field)).is_some(),
            ..Outputs::default()
        };
        // The cells depend on what was given, and on the list that it is of.
        let load = match (load, self.tilt) {
            _ if by_cells => load,
            (_, [0.0, 0.0]) => Load::Depth(self.depth),
            (_, tilt) => Load::Tilted { depth: self.depth, tilt },
        };
        let alone = (!by_cells).then(|| scene.contact.under(Loading::Single(load)));
        let contact = alone.as_ref().unwrap_or(&scene.contact);
        // The tolerance is that of the scene, and the verdict of no concern.
        let with = |method: Method, cells: Option<usize>, evidence: ErrorBar| {
            let settings = Settings { method, cells, outputs, evidence, ..scene.settings };
            let answer = States::of(contact, &settings, shared.layers(&settings)).under(load);
            answer.map_or_else(|e| e.best.map(|best| *best), Some)
        };
        let by = |method: Method, cells: Option<usize>| with(method, cells, scene.settings.evidence);
        let said = self.said.cost.one().map(|cost| cost.unknowns);
        let on_other_cells = |own: &Solution| said.is_some_and(|unknowns| unknowns != own.cost.unknowns);
        // Cells are chosen as the scene says, unless another method was asked for.
        let chosen = by_cells.then(|| by(scene.settings.method, scene.settings.cells)).flatten();
        let of_kind = chosen.filter(|own| own.origin.kind() == self.origin);
        // Without a proof, where that was not asked for when it was solved.
        let estimated = self.said.evidence.one().is_some_and(|word| word == "estimated");
        let estimate = || {
            let own = with(scene.settings.method, scene.settings.cells, ErrorBar::Estimate)?;
            (own.origin.kind() == self.origin && !on_other_cells(&own)).then_some(own)
        };
        let is_bounded = |own: &Solution| own.bracket.is_some() || own.depth_bracket.is_some();
        let is_same = |own: &Solution| {
            !on_other_cells(own)
                && close(self.depth, own.depth, ROUNDING)
                && close(self.force, own.force, ROUNDING)
                && is_bounded(own) == self.bracket.is_some()
        };
        let of_kind = match of_kind {
            Some(own) if is_same(&own) => Some(own),
            other if by_cells && estimated => estimate().or(other),
            other => other,
        };
        let Some(own) = of_kind.or_else(|| by(method, if by_cells { scene.settings.cells } else { cells })) else {
            found.require(false, format!("{} answers this scene", method.name()));
            return;
        };
        // The same cells for the same tolerance; else both err by what they state.
        let other_cells = by_cells && on_other_cells(&own);
        let share = match method {
            Method::ClosedForm => ROUNDING,
            _ if other_cells => self.error().unwrap_or(0.0) + error_at_depth(&own).unwrap_or(0.0),
            _ if by_cells => ROUNDING,
            _ => APPROXIMATE,
        };
        self.agrees_with(&own, share, other_cells, found);
        if bounded_again {
            self.holds_bracket_of(&own, other_cells, found);
        }
        self.holds_pairs_of(&own, other_cells, found);
        if by_cells {
            self.origin_is_that_of(&own, other_cells, found);
            if let Some(residuals) = own.residuals {
                self.residuals(&residuals, "those found again", found);
            }
            if let Load::ForceMoment { .. } = load {
                self.is_tilted_as(&own, share, found);
            }
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
    }

    /// Found in the same way, on as many grids, along the same axes.
    fn origin_is_that_of(&self, own: &Solution, other_cells: bool, found: &mut Verification) {
        let (grids, count) = match own.origin {
            Origin::ManyGrids { grids } => (Some(grids), None),
            Origin::SeparateContacts { count } => (None, Some(count)),
            _ => (None, None),
        };
        let turned = match (self.get(key!(origin.turned)), own.turned) {
            (Some(said), Some(own)) => (said - own.to_degrees()).abs() <= 1e-9,
            (said, own) => said.is_none() && own.is_none(),
        };
        let as_many = self.get(key!(origin.grids)) == grids && self.get(key!(origin.count)) == count;
        found.require(
            own.origin.kind() == self.origin && turned && (as_many || other_cells),
            format!("the origin {} is that of the state found again", self.origin),
        );
        self.use_all(|said| {
            if let Some(origin) = said.origin.one_mut() {
                (origin.grids, origin.count, origin.turned) = (None, None, None);
            }
        });
    }

    /// The bracket that is claimed holds the one that was found again, or, on other cells, lies about it.
    fn holds_bracket_of(&self, own: &Solution, other_cells: bool, found: &mut Verification) {
        let Some(claimed) = &self.bracket else { return };
        let Some(own) = &own.bracket else {
            return found.require(false, format!("there is a bracket of {}", self.method));
        };
        let proved_again = |claimed: &Option<Proof>, own: &Side| {
            claimed.as_ref().is_none_or(|claimed| !claimed.proved || own.evidence() == Evidence::Proved)
        };
        found.require(
            proved_again(&claimed.below, own.lower_side()) && proved_again(&claimed.above, own.upper_side()),
            "what is said to be proved of the bracket was proved again",
        );
        let (lower, upper) = (own.lower(), own.upper());
        let room = if other_cells { ABOUT * (upper - lower) } else { 0.0 };
        found.require(
            claimed.lower <= lower * (1.0 + ROUNDING) + room && upper * (1.0 - ROUNDING) - room <= claimed.upper,
            format!(
                "the bracket [{:e}, {:e}] holds the one that was found again, [{lower:e}, {upper:e}]",
                claimed.lower, claimed.upper
            ),
        );
    }

    /// So do those of moments and tilts.
    fn holds_pairs_of(&self, own: &Solution, other_cells: bool, found: &mut Verification) {
        let share = match (other_cells, self.origin.as_str()) {
            (true, _) => ABOUT,
            (_, "edge_fitted") => 0.0,
            // Both are wider than they were found.
            _ => REPEATABLE,
        };
        for (key, own) in [(key!(bracket.moment), own.moment_bracket), (key!(bracket.tilt), own.tilt_bracket)] {
            let Key { path, remove, .. } = key;
            let Some(claimed) = self.get(key) else { continue };
            let own = own.map(|own| [0, 1].map(|m| [own.lower()[m], own.upper()[m]]));
            let room = |[low, high]: [f64; 2]| share * (high - low) + ROUNDING * low.abs().max(high.abs());
            found.require(
                own.is_some_and(|own| claimed.holds(own, room)),
                format!("{} holds the one that was found again, {own:?}", claimed.told(path)),
            );
            self.use_all(remove);
        }
    }

    /// The tilts of a punch that is free to, over the size of its patch, and the bounds of its depth.
    fn is_tilted_as(&self, own: &Solution, share: f64, found: &mut Verification) {
        let size = self.area.sqrt();
        let off = [0, 1].map(|m| (self.tilt[m] - own.tilt[m]).abs() * size);
        let least = share * (self.depth.abs() + size * self.tilt[0].hypot(self.tilt[1]));
        found.require(off[0].max(off[1]) <= least, format!("the tilt {:?} is that of {}", self.tilt, self.method));
        let Some(result::DepthBracket { lower: Some(lower), upper, .. }) = self.get(key!(bracket.depth)) else {
            return;
        };
        let own = own.depth_bracket.as_ref().and_then(DepthBracket::ends);
        let holds = own.zip(upper).is_some_and(|([low, high], upper)| {
            let room = ROUNDING * low.abs().max(high.abs());
            lower <= low + room && high - room <= upper
        });
        found.require(
            holds,
            format!("the bounds of the depth, {lower:e} and {upper:?}, hold those that were found again, {own:?}"),
        );
        self.use_up(key!(bracket.depth));
    }

    /// Every number is that of the method, applied again.
    fn agrees_with(&self, own: &Solution, share: f64, other_cells: bool, found: &mut Verification) {
        let both_err = |key: Key<f64>, error: Option<f64>| {
            let both = if other_cells { self.get(key).unwrap_or(0.0) + error.unwrap_or(0.0) } else { 0.0 };
            share.max(both)
        };
        let stepped = if self.tilt == [0.0; 2] { 0.0 } else { LAST_STEP };
        let of_energy = both_err(key!(energy_error), own.energy_error).max(stepped);
        let of_stiffness = both_err(key!(stiffness_error), own.stiffness_error);
        let of_area = both_err(key!(area_error), own.area_error);
        let numbers: [(Key<f64>, Option<f64>, f64); 8] = [
            (key!(depth), Some(own.depth), share),
            (key!(force), Some(own.force), share),
            (key!(stiffness), Some(own.stiffness), of_stiffness),
            (key!(energy), own.energy, of_energy),
            (key!(patch.area), Some(own.patch.area), of_area),
            (key!(patch.regions as f64), Some(own.patch.regions as f64), share),
            (key!(patch.max_radius), Some(own.patch.max_radius), share),
            (key!(pressure.max), own.pressure.max, share),
        ];
        for (key, value, share) in numbers {
            let Some(said) = self.get(key) else { continue };
            let holds = value.is_some_and(|value| close(said, value, share));
            found.require(holds, format!("{} {said:e} is that of {}", key.path, self.method));
            self.use_up(key);
        }
        // Under a tilt of its own the state was balanced at these very tilts.
        self.use_up(key!(tilt));
        let length = own.patch.max_radius;
        let places: [(Key<[f64; 2]>, _, _); 3] = [
            (key!(patch.centroid), own.patch.centroid, length),
            (key!(pressure.at), own.pressure.at, length),
            (key!(moment), own.moment, own.force * length),
        ];
        for (key, value, size) in places {
            if let Some(said) = self.get(key) {
                let near =
                    |value: [f64; 2]| (0..2).all(|m| (said[m] - value[m]).abs() <= share * (size + value[m].abs()));
                found.require(value.is_some_and(near), format!("{} {said:?} is that of {}", key.path, self.method));
                self.use_up(key);
            }
        }
        if let Some(error) = self.error() {
            let least = error_at_depth(own).unwrap_or(f64::INFINITY);
            found.require(
                error >= least * (1.0 - ROUNDING) - LAST_DIGITS,
                format!("the stated error {error:.1e} is no less than that of {}, {least:.1e}", self.method),
            );
            self.use_up(key!(force_error));
            self.use_up(key!(depth_error));
        }
        self.pieces_are(&own.patch.pieces, share, share * length, found);
        if let (Some(said), Some(axes)) = (self.get(key!(patch.semi_axes)), own.patch.semi_axes) {
            let holds = (0..2).all(|m| close(said[m], axes[m], share));
            found.require(holds, format!("the semi-axes {said:?} are those of {}", self.method));
            self.use_up(key!(patch.semi_axes));
        }
        if let (Some(said), Some(angle)) = (self.get(key!(patch.angle)), own.patch.angle) {
            let holds = (said.to_radians() - angle).abs() <= share.max(1e-9);
            found.require(holds, format!("the angle {said} degrees is that of {}", self.method));
            self.use_up(key!(patch.angle));
        }
        let under_force = self.get(key!(force_error)) == Some(0.0);
        let left = if under_force { UNDER_FORCE } else { 1.0 - ROUNDING };
        let errors: [(Key<f64>, _); 4] = [
            (key!(stiffness_error), own.stiffness_error),
            (key!(energy_error), own.energy_error),
            (key!(area_error), own.area_error),
            (key!(pressure.max_error), own.pressure.max_error),
        ];
        for (key, value) in errors {
            if let (Some(said), Some(least)) = (self.get(key), value) {
                let holds = said >= least * left - LAST_DIGITS && said < 1.0;
                let what = format!("{} {said:.1e} is no less than that of {}, {least:.1e}", key.path, self.method);
                found.require(holds, what);
                self.use_up(key);
            }
        }
        if let (Some(said), Some(own)) = (self.get(key!(validity)), own.validity) {
            let near = |said: Option<f64>, own: Option<f64>| {
                said.is_none_or(|said| own.is_some_and(|own| close(said, own, share.max(1e-6))))
            };
            let holds = near(said.slope, Some(own.slope))
                && near(said.size_over_radius, own.size_over_radius)
                && near(said.pressure_over_modulus, Some(own.pressure_over_modulus));
            found.require(holds, "what is small against 1 is that of the state found again");
            self.use_up(key!(validity));
        }
        if let Some(said) = self.get(key!(stiffness_matrix)) {
            let size = |i: usize, j: usize| own.stiffness * length.powi(i32::from(i > 0) + i32::from(j > 0));
            let near = |said: [[f64; 3]; 3], own: [[f64; 3]; 3]| {
                (0..9)
                    .map(|n| (n / 3, n % 3))
                    .all(|(i, j)| (said[i][j] - own[i][j]).abs() <= 1e-6 * (size(i, j) + own[i][j].abs()))
            };
            // Computed for a punch that is free to tilt alone.
            if let Some(own) = own.stiffness_matrix {
                found.require(near(said, own), format!("the stiffness matrix is that of {}", self.method));
                self.use_up(key!(stiffness_matrix));
            }
        }
        if let (Some(said), Some(own)) = (self.get(key!(patch.boundary)), &own.patch.boundary) {
            let holds = boundary_distance(&said, own).is_some_and(|off| off <= share.max(1e-6) * length);
            found.require(holds, format!("the boundary is that of {}", self.method));
            self.use_up(key!(patch.boundary));
        }
        if let (Some(said), Some(field)) = (&self.field, &own.pressure.field) {
            let ([a, b], highest) = ([said, field].map(|f| f.grid), field.values.iter().copied().fold(0.0, f64::max));
            let same = a.shape == b.shape
                && (0..2).all(|m| {
                    let size = b.spacing[m] * b.shape[m] as f64;
                    close(a.spacing[m], b.spacing[m], ROUNDING) && (a.origin[m] - b.origin[m]).abs() <= ROUNDING * size
                });
            let each = said.values.len() == field.values.len()
                && said.values.iter().zip(&field.values).all(|(p, q)| (p - q).abs() <= 1e-6 * highest);
            found.require(same && each, format!("the pressure field is that of {}", self.method));
            self.use_up(key!(pressure.field));
            // Fitted cells are drawn on a grid; turned ones are not that of the field.
            let of_turned = own.grid.filter(|_| self.origin != "edge_fitted");
            self.grid_is_that_of(of_turned.unwrap_or(a), found);
        }
    }
}

/// The relative error of the force at the depth of a state: under a force that of the depth, by the stiffness.
fn error_at_depth(own: &Solution) -> Option<f64> {
    match own.depth_error {
        Some(error) if error != 0.0 => Some(error * (own.depth * own.stiffness / own.force).abs()),
        _ => own.force_error,
    }
}

/// Largest distance between the points of two lists of closed lines; `None` where they have other numbers of points.
pub(super) fn boundary_distance(said: &[Vec<[f64; 2]>], own: &[Vec<[f64; 2]>]) -> Option<f64> {
    if !said.iter().map(Vec::len).eq(own.iter().map(Vec::len)) {
        return None;
    }
    let points = said.iter().flatten().zip(own.iter().flatten());
    Some(points.map(|(said, own)| (said[0] - own[0]).hypot(said[1] - own[1])).fold(0.0, f64::max))
}

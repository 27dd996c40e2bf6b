//! The states of one contact at many depths, each as exact as the curve needs it.

use super::Sample;
use crate::acceptance::sampled;
use crate::gap::Law;
use crate::grid_method;
use crate::grid_method::dimensional::dimensional;
use crate::grid_method::refinement;
use crate::grid_method::{misses_a_contact, takes_several_grids};
use crate::loading::{respond, without_grid};
use crate::overlap::Overlap;
use crate::problem::{Contact, Method, Outputs, Settings};
use crate::solution::{Solution, Unsolved, Verdict};
use crate::threads::each;

/// Cells along the longer side of the finest grid of one state, or half of them where twice as many are enough. Where they are
/// not, the error of that state says so and the curve is no better.
const FINE: usize = 512;

/// States by depth below first touch.
pub(super) struct Family<'a> {
    contact: &'a Contact,
    settings: Settings,
    /// Relative error that the force of a state on several grids may have if it must.
    tolerance: f64,
    first_touch: f64,
    deepest: f64,
    /// A state of a homogeneous gap and its law.
    similar: Option<(Solution, Law)>,
    solves: usize,
}

impl<'a> Family<'a> {
    /// States with forces good to `wanted`, or to what the finest grid gives.
    pub fn new(contact: &'a Contact, settings: &Settings, wanted: f64, first_touch: f64, deepest: f64) -> Self {
        let tolerance = settings.tolerance;
        let settings = Settings {
            outputs: Outputs { energy: true, ..Outputs::default() },
            tolerance: wanted.min(tolerance).max(SHARPEST),
            ..*settings
        };
        Self { contact, settings, tolerance, first_touch, deepest, similar: None, solves: 0 }
    }

    pub fn solves(&self) -> usize {
        self.solves
    }

    /// The states at overlaps, on as many threads as the settings allow; the deepest has to be asked for first. The answer does
    /// not depend on the number of threads.
    pub fn at(&mut self, overlaps: &[f64]) -> Result<Vec<Sample>, Unsolved> {
        if let Some((state, law)) = &self.similar {
            let centre = self.contact.gap().known().centre;
            let at = |s: &f64| sample(self.contact, &state.at_other_depth(self.first_touch + s, centre, law));
            return Ok(overlaps.iter().map(at).collect());
        }
        self.solves += overlaps.len();
        let threads = self.settings.threads.max(1);
        let own = Settings { threads: (threads / overlaps.len().max(1)).max(1), ..self.settings };
        let states = each(overlaps, threads, |&s| self.pressed(s, &own))?;
        if let ([s], [state]) = (overlaps, states.as_slice())
            && *s == self.deepest
        {
            self.similar = self.contact.gap().known().law.map(|law| (state.clone(), law));
        }
        // The curve is known no better than the worst of them: the next ones need not be.
        let worst = states.iter().filter_map(|state| state.force_error).fold(0.0, f64::max);
        self.settings.tolerance = self.settings.tolerance.max((OF_WORST * worst).min(self.tolerance));
        Ok(states.iter().map(|state| sample(self.contact, state)).collect())
    }

    /// The state at overlap `s`.
    fn pressed(&self, s: f64, settings: &Settings) -> Result<Solution, Unsolved> {
        settings.deadline.check()?;
        let depth = self.first_touch + s;
        let deadline = settings.deadline.or_after(settings.seconds, self.settings.threads);
        let state = self.solved(depth, &Settings { deadline, ..*settings })?;
        if state.force > 0.0 && state.stiffness > 0.0 {
            return Ok(state);
        }
        let reason = format!("no force at depth {depth:e}, {s:e} below first touch");
        Err(Unsolved::new(Verdict::NotApplicable, reason))
    }

    fn solved(&self, depth: f64, settings: &Settings) -> Result<Solution, Unsolved> {
        match settings.method {
            Method::Qp | Method::Fft => self.on_grid(depth, settings),
            Method::Auto if settings.cells.is_some() => self.on_grid(depth, settings),
            Method::Auto => match self.without_grid(depth, settings) {
                Some(answered) => answered,
                None => self.on_grid(depth, settings),
            },
            _ => respond(self.contact, depth, [0.0; 2], settings, false),
        }
    }

    /// The state without a grid, to what is wanted, or as near to it as can be had; `None` where it takes a grid.
    fn without_grid(&self, depth: f64, settings: &Settings) -> Option<Result<Solution, Unsolved>> {
        let mut tolerance = settings.tolerance;
        loop {
            let settings = Settings { tolerance, ..*settings };
            match without_grid(self.contact, self.contact.gap(), depth, [0.0; 2], &settings, false) {
                None => {}
                Some(Err(short)) if short.verdict == Verdict::ToleranceNotReached => {
                    let near = |state: &Solution| state.force_error.is_some_and(|error| error <= self.tolerance);
                    if let Some(state) = short.best.filter(|state| near(state)) {
                        return Some(Ok(*state));
                    }
                }
                answered => return answered,
            }
            if tolerance >= self.tolerance {
                return None;
            }
            tolerance = (LOOSER * tolerance).min(self.tolerance);
        }
    }

    fn on_grid(&self, depth: f64, settings: &Settings) -> Result<Solution, Unsolved> {
        // No finer than it can be had.
        let loose = Settings { tolerance: self.tolerance, ..*settings };
        let on_several = || {
            respond(self.contact, depth, [0.0; 2], settings, false)
                .or_else(|_| respond(self.contact, depth, [0.0; 2], &loose, false))
                .or_else(Unsolved::accept_best)
        };
        let apart = || Unsolved::new(Verdict::NotApplicable, format!("no contact at depth {depth:e}"));
        let overlap = Overlap::of(self.contact.gap(), depth)?.ok_or_else(apart)?;
        if takes_several_grids(&overlap, settings) {
            return on_several();
        }
        let method = grid_method::method(settings);
        let scaled = overlap.scaled();
        let law = self.contact.gap().known().law;
        let mut found = refinement::as_far_as(FINE, &scaled, settings, method, law)?;
        let short = found.error / found.force / settings.tolerance;
        // Twice as many cells take a half to three quarters of the error away.
        if settings.cells.is_none() && (1.0..4.0).contains(&short) {
            found = refinement::as_far_as(2 * FINE, &scaled, settings, method, law)?;
        }
        if misses_a_contact(&overlap, settings, &scaled, &found) {
            return on_several();
        }
        let state = dimensional(self.contact, &scaled, &found, law, depth, [0.0; 2], settings)?;
        if settings.cells.is_some() || found.error <= self.tolerance * found.force {
            return Ok(state);
        }
        // As a single state is solved: on as many cells as it takes.
        let other = respond(self.contact, depth, [0.0; 2], &loose, false).or_else(Unsolved::accept_best);
        let error = |state: &Solution| state.force_error.unwrap_or(f64::INFINITY);
        Ok(other.ok().filter(|other| error(other) < error(&state)).unwrap_or(state))
    }
}

/// Share of the error of the worst state that others may have.
const OF_WORST: f64 = 0.5;

/// Steps in which a tolerance becomes looser.
const LOOSER: f64 = 3.0;

/// Least relative error that is asked of a grid for a curve.
const SHARPEST: f64 = 1e-6;

fn sample(contact: &Contact, state: &Solution) -> Sample {
    let centre = state.moment.map(|[mx, my]| [-my / state.force, mx / state.force]);
    Sample {
        depth: state.depth,
        force: state.force,
        force_error: state.force_error,
        stiffness: state.stiffness,
        area: state.patch.area,
        max_pressure: state.pressure.max,
        max_pressure_error: state.pressure.max_error,
        singular: state.pressure.singular,
        stiffness_error: state.stiffness_error,
        area_error: state.area_error,
        energy_error: state.energy_error,
        centre: centre.filter(|c| c.iter().all(|c| c.is_finite())),
        semi_axes: state.patch.semi_axes,
        energy: state.energy,
        map_error: sampled::share(contact, state),
    }
}

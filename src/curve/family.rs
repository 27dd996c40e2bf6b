//! The states of one contact at many depths, each as exact as the curve needs it.

use super::Sample;
use crate::gap::Law;
use crate::grid_method::dimensional::dimensional;
use crate::grid_method::on_several_grids;
use crate::grid_method::refinement;
use crate::loading::{respond, without_grid};
use crate::overlap::Overlap;
use crate::problem::{Contact, Method, Outputs, Settings};
use crate::solution::{Solution, Unsolved, Verdict};

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

    /// The state at overlap `s`; the deepest has to be asked for first.
    pub fn at(&mut self, s: f64) -> Result<Sample, Unsolved> {
        let depth = self.first_touch + s;
        if let Some((state, law)) = &self.similar {
            return Ok(sample(&state.at_other_depth(depth, self.contact.gap().known().centre, law)));
        }
        self.solves += 1;
        let state = self.solved(depth)?;
        if !(state.force > 0.0 && state.stiffness > 0.0) {
            let reason = format!("no force at depth {depth:e}, {s:e} below first touch");
            return Err(Unsolved::new(Verdict::NotApplicable, reason));
        }
        if s == self.deepest {
            self.similar = self.contact.gap().known().law.map(|law| (state.clone(), law));
        }
        Ok(sample(&state))
    }

    fn solved(&self, depth: f64) -> Result<Solution, Unsolved> {
        let settings = &self.settings;
        match settings.method {
            Method::Qp | Method::Fft => self.on_grid(depth),
            Method::Auto if settings.cells.is_some() => self.on_grid(depth),
            Method::Auto => match without_grid(self.contact, self.contact.gap(), depth, [0.0; 2], settings, false) {
                None => self.on_grid(depth),
                Some(Err(short)) if short.verdict == Verdict::ToleranceNotReached => self.on_grid(depth),
                Some(answered) => answered,
            },
            _ => respond(self.contact, depth, [0.0; 2], settings, false),
        }
    }

    fn on_grid(&self, depth: f64) -> Result<Solution, Unsolved> {
        if on_several_grids(self.contact, depth, &self.settings) {
            // No finer than it can be had.
            let loose = Settings { tolerance: self.tolerance, ..self.settings };
            return respond(self.contact, depth, [0.0; 2], &self.settings, false)
                .or_else(|_| respond(self.contact, depth, [0.0; 2], &loose, false));
        }
        let method = if self.settings.method == Method::Qp { Method::Qp } else { Method::Fft };
        let apart = || Unsolved::new(Verdict::NotApplicable, format!("no contact at depth {depth:e}"));
        let scaled = Overlap::of(self.contact.gap(), depth)?.ok_or_else(apart)?.scaled();
        let law = self.contact.gap().known().law;
        let mut found = refinement::as_far_as(FINE, &scaled, &self.settings, method, law)?;
        let short = found.error / found.force / self.settings.tolerance;
        // Twice as many cells take a half to three quarters of the error away.
        if self.settings.cells.is_none() && (1.0..4.0).contains(&short) {
            found = refinement::as_far_as(2 * FINE, &scaled, &self.settings, method, law)?;
        }
        dimensional(self.contact, &scaled, &found, law, depth, [0.0; 2], &self.settings)
    }
}

/// Least relative error that is asked of a grid for a curve.
const SHARPEST: f64 = 1e-6;

fn sample(state: &Solution) -> Sample {
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
        energy: state.energy,
    }
}

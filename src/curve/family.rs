//! The states of one contact at many depths, as consistent with one another as the method allows.

use std::collections::BTreeMap;

use super::Sample;
use crate::by_grid::dimensional;
use crate::contact::Contact;
use crate::domain::Door;
use crate::error::{Unsolved, Verdict};
use crate::exact;
use crate::gap::{Reach, extent};
use crate::homogeneity;
use crate::settings::{Method, Outputs, Settings};
use crate::solution::Solution;
use crate::solve::respond;

/// Range of depths that share a grid. On one grid the discrete force is convex in the depth and its slope the exact
/// stiffness; from one grid to the next it jumps by the error of the solver. Over this range a contact grows about
/// threefold (smooth) to eightfold (conical).
const SHARE: f64 = 8.0;

/// Where a contact was found on its grid.
struct Frame<'a> {
    door: Door<'a>,
    window: crate::geometry::Rect,
    cells: usize,
    /// Relative error of the force where the grid was chosen.
    error: f64,
}

/// States by depth below first touch.
pub(super) struct Family<'a> {
    contact: &'a Contact,
    settings: Settings,
    first_touch: f64,
    deepest: f64,
    frames: BTreeMap<i32, Frame<'a>>,
    /// A state of a homogeneous gap and 1/k.
    similar: Option<(Solution, f64)>,
    solves: usize,
}

impl<'a> Family<'a> {
    pub fn new(contact: &'a Contact, settings: &Settings, first_touch: f64, deepest: f64) -> Self {
        let settings = Settings { outputs: Outputs::default(), ..*settings };
        Self { contact, settings, first_touch, deepest, frames: BTreeMap::new(), similar: None, solves: 0 }
    }

    pub fn solves(&self) -> usize {
        self.solves
    }

    /// The state at overlap `s`; the deepest has to be asked for first.
    pub fn at(&mut self, s: f64) -> Result<Sample, Unsolved> {
        let depth = self.first_touch + s;
        if let Some((state, inverse_degree)) = &self.similar {
            return Ok(sample(&state.at_other_depth(depth, self.contact.gap().centre(), *inverse_degree)));
        }
        self.solves += 1;
        let by_formula = match self.settings.method {
            Method::Qp | Method::Fft => None,
            Method::Auto if self.settings.cells.is_some() => None,
            Method::Auto => {
                let formula = Settings { method: Method::ClosedForm, ..self.settings };
                match respond(self.contact, depth, [0.0; 2], &formula, false) {
                    Err(e) if e.verdict == Verdict::NoClosedForm => None,
                    answered => Some(answered?),
                }
            }
            _ => Some(respond(self.contact, depth, [0.0; 2], &self.settings, false)?),
        };
        let state = match by_formula {
            Some(state) => state,
            None => self.on_grid(s)?,
        };
        if !(state.force > 0.0 && state.stiffness > 0.0) {
            let reason = format!("no force at depth {depth:e}, {s:e} below first touch");
            return Err(Unsolved::new(Verdict::NotApplicable, reason));
        }
        if s == self.deepest
            && self.first_touch == 0.0
            && let Reach::Within(reach) = extent(self.contact.gap(), depth)
        {
            let degree = homogeneity::degree(self.contact.gap(), &reach);
            self.similar = degree.map(|k| (state.clone(), k.inverse()));
        }
        Ok(sample(&state))
    }

    fn on_grid(&mut self, s: f64) -> Result<Solution, Unsolved> {
        let method = if self.settings.method == Method::Qp { Method::Qp } else { Method::Fft };
        let level = ((self.deepest / s).ln() / SHARE.ln()).floor() as i32;
        let depth = self.first_touch + s;
        if !self.frames.contains_key(&level) {
            let top = self.first_touch + self.deepest * SHARE.powi(-level);
            let apart = || Unsolved::new(Verdict::NotApplicable, format!("no contact at depth {top:e}"));
            let door = Door::enter(self.contact.gap(), top)?.ok_or_else(apart)?;
            let degree = match extent(self.contact.gap(), top) {
                Reach::Within(reach) => homogeneity::degree(self.contact.gap(), &reach),
                _ => None,
            };
            let found = exact::refined(&door, &self.settings, method, degree)?;
            let grid = found.state.problem.grid;
            let frame = Frame {
                door,
                window: grid.extent(),
                cells: grid.shape[0].max(grid.shape[1]),
                error: found.error / found.force,
            };
            self.frames.insert(level, frame);
            if depth == top {
                return dimensional(self.contact, &door, &found, degree, depth, [0.0; 2], &self.settings);
            }
            self.solves += 1;
        }
        let frame = &self.frames[&level];
        let door = Door { depth: depth / frame.door.gap.depth, ..frame.door };
        let mut window = frame.window;
        let state = exact::at_resolution(&door, &mut window, frame.cells, &self.settings, method)?;
        let force = state.force();
        let found = exact::Refined { force, error: frame.error * force, state };
        dimensional(self.contact, &door, &found, None, depth, [0.0; 2], &self.settings)
    }
}

fn sample(state: &Solution) -> Sample {
    let centre = state.moment.map(|[mx, my]| [-my / state.force, mx / state.force]);
    Sample {
        depth: state.depth,
        force: state.force,
        stiffness: state.stiffness,
        area: state.patch.area,
        max_pressure: state.pressure.max,
        centre: centre.filter(|c| c.iter().all(|c| c.is_finite())),
        energy: state.energy,
    }
}

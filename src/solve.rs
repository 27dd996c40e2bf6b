//! One call for every method and every loading.

use crate::acceptance::sampled::with_samples;
use crate::acceptance::{accepted, within_memory};
use crate::acceptance::{remarks::remarks, stated};
use crate::bracket::refined::with_bracket;
use crate::by_edges;
use crate::clock::Stopwatch;
use crate::gap::{Gap, Reach};
use crate::loading::axes::Axes;
use crate::loading::engine::{Engine, close};
use crate::loading::equilibrium;
use crate::loading::respond;
use crate::loading::shared::{Layers, Shared, Similar};
use crate::loading::tilting;
use crate::overlap::{Overlap, least};
use crate::problem::{Contact, ErrorBar, Load, Method, Outputs, Settings};
use crate::solution::{Solution, Unsolved, Verdict};

/// Solves every state of the loading, in order.
///
/// ```
/// use contact_patch::{Contact, EffectiveModulus, Loading, Settings, gap::Cone, solve};
/// let modulus = EffectiveModulus::from_e_star(1.0)?;
/// let contact = Contact::new(modulus, Cone::with_slope(1.0)?, Loading::depth(1.0))?;
/// let solution = solve(&contact, &Settings::default()).remove(0)?;
/// // Love 1939: P = 2 E* d^2/(pi tan(alpha)).
/// assert!((solution.force - 2.0 / std::f64::consts::PI).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn solve(contact: &Contact, settings: &Settings) -> Vec<Result<Solution, Unsolved>> {
    let (mut states, mut held) = (States::of(contact, settings, Layers::default()), 0);
    contact.loading().loads().iter().map(|&load| within_memory(states.under(load), &mut held)).collect()
}

/// The states of one loading: what they share is found once.
pub(crate) struct States<'a> {
    contact: &'a Contact,
    settings: Settings,
    /// The axes along which it is solved, where these are others than the user's, and contact and settings in them.
    turned: Option<(Axes, Contact, Settings)>,
    shared: Shared,
    /// Along the user's axes, where it is solved along others.
    as_given: Shared,
}

impl<'a> States<'a> {
    /// `layers`: what holds the states of this loading, contact and settings, as far as it is known.
    pub fn of(contact: &'a Contact, settings: &Settings, layers: Layers) -> Self {
        let turned = Axes::of(contact, settings);
        let turned = turned.map(|axes| (axes, axes.inward(contact), Axes::settings_inward(settings)));
        Self { contact, settings: *settings, turned, shared: Shared::with(layers), as_given: Shared::default() }
    }

    /// The state under one of the loads of the contact.
    pub fn under(&mut self, load: Load) -> Result<Solution, Unsolved> {
        let Some((axes, turned, own)) = &self.turned else {
            return at(self.contact, load, &self.settings, &mut self.shared);
        };
        match at(turned, axes.load_inward(load), own, &mut self.shared) {
            // A closed form has axes of its own.
            Ok(state) if state.method == Method::ClosedForm => {
                at(self.contact, load, &self.settings, &mut self.as_given)
            }
            answer => axes.outward(answer, load, &self.settings),
        }
    }
}

fn at(contact: &Contact, load: Load, settings: &Settings, shared: &mut Shared) -> Result<Solution, Unsolved> {
    // A limit of the caller's own may be used up by the states before.
    settings.deadline.check()?;
    let started = Stopwatch::start();
    let deadline = settings.deadline.or_after(settings.seconds, settings.threads);
    // Nothing takes longer than a limit of the caller's own.
    let may_extend = deadline != settings.deadline;
    let settings = &Settings { deadline, ..*settings };
    let answer = under(contact, load, settings, shared).map_err(|short| match short.verdict {
        Verdict::TimeLimit if short.best.is_none() && may_extend => estimated(contact, load, settings, short),
        _ => short,
    });
    let answer = match answer {
        Ok(solution) if settings.outputs.bracket => with_bracket(contact, load, solution, settings),
        answer => answer,
    };
    let answer = with_samples(contact, load, settings, answer);
    let mut answer = accepted(contact, load, settings, answer);
    if let Some(state) = answer.as_mut().map_or_else(|e| e.best.as_deref_mut(), Some) {
        stated::errors(contact, load, state);
        remarks(contact, state);
        state.cost.seconds = started.seconds();
    }
    answer
}

/// Answers one load.
fn under(contact: &Contact, load: Load, settings: &Settings, shared: &mut Shared) -> Result<Solution, Unsolved> {
    match load {
        Load::Depth(depth) => at_depth(contact, depth, settings, shared),
        Load::Tilted { depth, tilt } => respond(contact, depth, tilt, settings, true),
        Load::Force(force) => at_force(contact, force, settings, shared),
        Load::ForceMoment { force, moment } => {
            by_edges::balanced(contact, force, moment, settings).unwrap_or_else(|| {
                at_force(contact, force, settings, &mut Shared::default())
                    .or_else(Unsolved::accept_best)
                    .and_then(|upright| tilting::under_moment(contact, upright, force, moment, settings))
            })
        }
    }
}

/// Tolerance of an estimate that stands for nothing at all.
const ROUGH: f64 = 1e-2;

/// What it may take, over the time that was allowed, and CPU seconds at least and at most.
const MORE: f64 = 0.5;
const MORE_SECONDS: [f64; 2] = [0.05, 5.0];

/// An estimate, where the time was used up before there was any number: most of it goes into a proof.
fn estimated(contact: &Contact, load: Load, settings: &Settings, short: Unsolved) -> Unsolved {
    let seconds = (MORE * settings.seconds).clamp(MORE_SECONDS[0], MORE_SECONDS[1]);
    let rough = Settings {
        evidence: ErrorBar::Estimate,
        tolerance: settings.tolerance.max(ROUGH),
        deadline: settings.deadline.extended(seconds, settings.threads),
        outputs: Outputs { bracket: false, ..settings.outputs },
        ..*settings
    };
    let best = under(contact, load, &rough, &mut Shared::default())
        .map_or_else(|rough| rough.best, |state| Some(Box::new(state)));
    Unsolved { best, ..short }
}

fn at_depth(contact: &Contact, depth: f64, settings: &Settings, shared: &mut Shared) -> Result<Solution, Unsolved> {
    if let Some(all) = shared.similar.as_ref().filter(|all| depth > all.law.lowest) {
        return all.answer(all.at(contact.gap(), depth));
    }
    if let Some(held) = shared.layers(contact, settings).and_then(|layers| layers.at(contact, depth, settings)) {
        return Ok(held);
    }
    let answer = respond(contact, depth, [0.0; 2], settings, false);
    // One state alone serves no other.
    let several = contact.loading().loads().len() > 1;
    if let Some(law) = contact.gap().known().law.filter(|_| several) {
        shared.similar = Similar::of(answer.clone(), law).ok().filter(Similar::has_all_digits);
    }
    answer
}

fn at_force(contact: &Contact, force: f64, settings: &Settings, shared: &mut Shared) -> Result<Solution, Unsolved> {
    let gap = contact.gap();
    let (_, least) = least(gap);
    if force < 0.0 {
        return Err(Unsolved::new(
            Verdict::NoEquilibrium,
            format!("the force {force:e} pulls; a contact can only push"),
        ));
    }
    if force == 0.0 {
        return Ok(Solution::apart(settings.method, least, [0.0; 2]));
    }
    let scaled = |all: &Similar| {
        let mut state = all.at(gap, all.depth_for(force));
        // What rounding leaves of the force is that of its bounds and its pieces, too.
        let rounding = force / state.force;
        state.scale_bracket(rounding);
        state.patch.pieces.iter_mut().for_each(|piece| piece.force *= rounding);
        Solution { force, ..state }
    };
    if let Some(all) = &shared.similar {
        return all.answer(scaled(all));
    }
    // A line contact has no end, however little it is pressed.
    let size = (force / contact.modulus().e_star()).sqrt();
    let endless = |share: &f64| matches!(gap.reach(least + share * size), Reach::Unbounded { .. });
    if [1.0, 1e-6, 1e-12].iter().all(endless) {
        Overlap::of(gap, least + size)?;
    }
    let guess = equilibrium::overlap_of_size(gap, contact.modulus().e_star(), force, settings.deadline);
    // The law of a homogeneous gap is exact: one state serves every force.
    if let Some(law) = gap.known().law {
        let from = |depth: f64| Similar::of(respond(contact, depth, [0.0; 2], settings, false), law);
        let mut all = from(law.lowest + guess)?;
        if all.state.force > 0.0 && !all.has_all_digits() {
            all = from(all.depth_for(force))?;
        }
        if all.state.force > 0.0 {
            let state = scaled(&all);
            return shared.similar.insert(all).answer(state);
        }
    }
    let mut engine = Engine::new(contact, settings, false);
    engine.layers = shared.layers(contact, settings);
    let state = equilibrium::under_force(
        &mut engine,
        force,
        least,
        guess,
        |method| close(settings, method),
        settings.tolerance,
    )?;
    Ok(engine.proved(state))
}

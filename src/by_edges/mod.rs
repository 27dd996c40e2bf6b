//! A state of contact by cells fitted to the edges of the material ([`crate::edge_fitted`]), in the user's units.
//!
//! | known of the gap | what is solved | force |
//! |---|---|---|
//! | a level face in a polygon, nothing outside | the flat punch | E* K d, the bracket of K |
//! | a tilted face in a polygon | the cells that stay in contact | the bracket of its own, where it touches everywhere |
//! | a tilted face in an ellipse that lifts off | the cells that stay in contact | an estimate |
//! | the highest of several planes, one of them level | the flat punch under that one | E* K d to E* K d (1 + s/2): see [`layer`] |
//! | the same, where the contact passes it by more | the flat and a strip of its flanks | the bracket of its own, else an estimate |
//! | an axis, bounds along the radius | rings | the bracket of the force, else an estimate |
//! | two mirrors, one closed strip around them | cells along the strip | an estimate |
//! | material in a rectangle, a strip from one side to the other | rows of cells across it | an estimate |
//! | a strip with a steep end, of the material or of the overlap alone | cells graded to both, those in contact | an estimate |
//! | a box that is filled nearly up to its sides | lines in both directions where the pressure changes, those in contact | an estimate |
//! | a polynomial of second degree in a polygon or an ellipse, up to its edge | the cells that stay in contact | an estimate |

mod crowned;
mod estimated;
mod flanked;
mod flat;
mod layer;
mod layer_states;
mod oval;
mod plateau;
mod rings;
mod roller;
mod strip;
mod tilted;

pub(crate) use layer_states::LayerStates;

use crate::edge_fitted::Limits;
use crate::gap::{AnyGap, Gap, Law};
use crate::grid::{Grid, Kernel, Pressure, shape};
use crate::numeric::geometry::Rect;
use crate::overlap::Overlap;
use crate::problem::{Contact, ErrorBar, Load, Method, Settings};
use crate::solution::{
    Cost, DepthBracket, ForceBracket, Origin, PairBracket, Patch, Piece, PressureSummary, Singular, Solution,
    TouchesEdge, Unsolved, Validity, Verdict,
};
use crate::threads::with;

/// What the cells are fitted to.
pub(crate) enum Route {
    Flat(flat::Flat),
    Tilted(tilted::Tilting),
    Layer(layer::Layer),
    Flanked { tip: flanked::FlankedTip, tolerance: f64, flat: layer::FlatTip },
    Rings(rings::Section),
    Oval(oval::Strip),
    Plateau(Box<plateau::Plateau>),
    Roller { roller: Box<roller::Roller>, otherwise: Option<Box<Self>> },
    Crowned(crowned::Crowning),
}

/// A state in the user's units.
struct Found {
    /// Proved bounds of the force.
    force: [f64; 2],
    /// Proved bounds of the stored energy.
    energy: [f64; 2],
    /// dP/dd and its relative error, as far as it is known.
    stiffness: f64,
    stiffness_error: Option<f64>,
    /// Relative error of the area of the patch, as far as it is known.
    area_error: Option<f64>,
    /// With its boundary.
    patch: Patch,
    /// Where the resultant of the computed pressure acts.
    centre: [f64; 2],
    /// The largest pressure, `None` where the exact one is infinite, and its relative error, as far as it is known.
    max: Option<f64>,
    max_error: Option<f64>,
    /// Where the largest computed pressure is.
    at: [f64; 2],
    field: Option<Pressure>,
    unknowns: usize,
    /// How the force was found, in words.
    how: String,
    /// What that made unnecessary, in words.
    left_out: &'static str,
    /// Whether the bounds are proved; estimates else.
    proved: bool,
    /// Moments (Mx, My) about the user's origin and the stiffness against depth and tilts, where the pressure is not symmetric.
    tilting: Option<Moments>,
}

impl Found {
    /// Half the width of the bounds of the force, relative.
    fn error(&self) -> f64 {
        let [low, high] = self.force;
        (high - low) / (high + low)
    }
}

/// What a tilted punch has beside the others.
struct Moments {
    /// Where they are known nearer than by the force at its centre.
    moment: Option<[f64; 2]>,
    /// Proved.
    bounds: Option<PairBracket>,
    matrix: [[f64; 3]; 3],
}

impl Route {
    /// The way in which this overlap is solved, where there is one that can meet the tolerance.
    pub fn of(overlap: &Overlap, settings: &Settings, with_matrix: bool) -> Option<Self> {
        let known = overlap.known();
        if let Some(face) = &known.face {
            if with_matrix || face.slope != [0.0; 2] {
                return tilted::Tilting::of(face).map(Self::Tilted);
            }
            return flat::Flat::of(face).map(Self::Flat);
        }
        // Of those below, flats with flanks and rings do not tell what tilts them.
        if let Some(tip) = layer::FlatTip::of(overlap).filter(|_| !with_matrix) {
            let flanked = flanked::FlankedTip::of(&tip);
            let mut tolerance = settings.tolerance;
            loop {
                if let Some(layer) = layer::Layer::of(&tip, tolerance) {
                    return Some(Self::Layer(layer));
                } else if flanked.as_ref().is_some_and(|flanked| flanked.fits(tolerance)) {
                    return flanked.map(|flanked| Self::Flanked { tip: flanked, tolerance, flat: tip });
                } else if let Some(layer) = layer::Layer::at_most(&tip, tolerance) {
                    return Some(Self::Layer(layer));
                } else if tip.growth > BLURRED || tolerance >= ROUGHEST {
                    break;
                }
                // As near as can be had, where no grid comes nearer.
                tolerance = (LOOSER * tolerance).max(FINEST);
            }
        }
        match known.axis.filter(|_| !with_matrix) {
            Some(axis) => rings::Section::of(overlap, axis).map(Self::Rings),
            None => {
                if let Some(plateau) = plateau::Plateau::of(overlap, with_matrix) {
                    return Some(Self::Plateau(Box::new(plateau)));
                }
                let roller = roller::Roller::of(overlap).map(Box::new);
                let crowned = crowned::Crowning::of(overlap).map(Self::Crowned);
                let between = || plateau::Plateau::between_edges(overlap).map(Box::new).map(Self::Plateau);
                match roller {
                    Some(roller) => Some(Self::Roller { roller, otherwise: crowned.or_else(between).map(Box::new) }),
                    None => crowned.or_else(|| oval::Strip::of(overlap).map(Self::Oval)).or_else(between),
                }
            }
        }
    }

    /// What was recognised, in words.
    pub fn found(&self) -> String {
        match self {
            Self::Flat(flat) => flat.found(),
            Self::Tilted(tilting) => tilting.found(),
            Self::Layer(layer) => layer.found(),
            Self::Flanked { tip, .. } => tip.found(),
            Self::Rings(section) => section.found(),
            Self::Oval(strip) => strip.found(),
            Self::Plateau(plateau) => plateau.found(),
            Self::Roller { roller, .. } => roller.found(),
            Self::Crowned(crowning) => crowning.found(),
        }
    }

    /// How the cells lie and what shows the error of the force, in words.
    pub fn evidence(&self) -> &'static str {
        match self {
            Self::Flat(_) => {
                "cells graded to the edges of the material, and the force is proved, or estimated where no proof is asked for"
            }
            Self::Tilted(_) => {
                "cells graded to the edges of the material, and the force is proved if it touches everywhere, else estimated"
            }
            Self::Layer(_) => "cells graded to the edges of the flat, whose stiffness bounds the force from both sides",
            Self::Flanked { .. } => {
                "cells graded to the edges of the flat and to the contact beyond it, and the force is proved, else estimated"
            }
            Self::Rings(_) => "rings about the axis, and the force is proved, else estimated",
            Self::Oval(_) => "cells along the closed strip, and the error is estimated",
            Self::Plateau(_) => "lines that lie where the pressure changes, and the error is estimated",
            Self::Roller { .. } => "cells graded to both ends, and the error is estimated",
            Self::Crowned(_) => "cells graded to the edges of the material, and the error is estimated",
        }
    }

    fn solve(&self, contact: &Contact, depth: f64, settings: &Settings, tilts: bool) -> Option<Found> {
        // Nothing of these takes long enough for more than one.
        let threads = if matches!(self, Self::Layer(_) | Self::Rings(_)) { 1 } else { settings.threads };
        let limits = Limits { tilts, ..limits(settings, threads) };
        with(threads, || self.solve_within(&limits, contact, depth, settings))
    }

    fn solve_within(&self, limits: &Limits, contact: &Contact, depth: f64, settings: &Settings) -> Option<Found> {
        match self {
            Self::Flat(flat) => flat.solve(contact, depth, settings, limits),
            Self::Tilted(tilting) => tilting.at(contact, depth, settings, limits),
            Self::Layer(layer) => layer.solve(contact, depth, settings, limits),
            Self::Flanked { tip, tolerance, flat } => {
                let by_bounds = || layer::Layer::up_to(flat, BELOW_CELLS)?.solve(contact, depth, settings, limits);
                let nearest = Limits { tolerance: limits.tolerance.max(*tolerance), ..*limits };
                tip.solve(contact, settings, &nearest).or_else(by_bounds)
            }
            Self::Rings(section) => section.solve(contact, settings, limits),
            Self::Oval(strip) => strip.solve(contact, settings, limits),
            Self::Plateau(plateau) => plateau.solve(contact, settings, limits),
            Self::Roller { roller, otherwise } => {
                let otherwise = || otherwise.as_ref()?.solve_within(limits, contact, depth, settings);
                let found = roller.solve(contact, settings, limits);
                let enough = found.as_ref().is_some_and(|found| found.error() <= limits.tolerance);
                if enough { found } else { otherwise().or(found) }
            }
            Self::Crowned(crowning) => crowning.solve(contact, settings, limits),
        }
    }
}

fn limits(settings: &Settings, threads: usize) -> Limits {
    let proof = settings.evidence == ErrorBar::Proof || settings.outputs.bracket;
    Limits { tolerance: settings.tolerance, deadline: settings.deadline, threads, proof, ..Limits::default() }
}

/// Growth of the contact over the size of its flat that no grid resolves.
const BELOW_CELLS: f64 = 4e-3;

/// The same up to which fitted cells come nearer than the finest grid: 2e-5 against 2e-4 at 0.03, 2e-5 against 2e-6 at 0.3.
const BLURRED: f64 = 0.05;

/// Tolerances that fitted cells do not meet anywhere, and that they meet there, and steps from one to the other.
const FINEST: f64 = 1e-8;
const ROUGHEST: f64 = 1e-3;
const LOOSER: f64 = 1.5;

/// Size of the contact beside its flat, over that of the flat, up to which [`force_bounds`] are worth their cost.
const THIN: f64 = 0.3;

/// Error of the flat's stiffness in [`force_bounds`].
const FLAT_ERROR: f64 = 1e-3;

/// Unknowns for it: no more than cost little beside a grid.
const FEW: usize = 400;

/// Bounds of P/E* by the flat that a gap is known to have, where the contact passes it by little: some hundredths of a second.
pub(crate) fn force_bounds(overlap: &Overlap, settings: &Settings) -> Option<[f64; 2]> {
    let (tolerance, deadline) = (FLAT_ERROR, settings.deadline);
    let limits = Limits { tolerance, unknowns: FEW, cells: 4 * FEW, deadline, ..Limits::default() };
    if let Some(face) = &overlap.known().face {
        let flat = flat::Flat::of(face)?;
        let depth = overlap.depth - flat.value;
        return Some(flat.punch(&limits)?.stiffness.map(|k| k * depth));
    }
    layer::Layer::up_to(&layer::FlatTip::of(overlap)?, THIN)?.force(overlap.depth, &limits)
}

/// Whether the settings leave the choice of cells to the program and ask for nothing that only a grid gives.
pub(crate) fn chosen_by(settings: &Settings) -> bool {
    settings.cells.is_none() && !settings.outputs.gap && settings.kernel == Kernel::Galerkin
}

/// Whether fitted cells are prescribed, or left to the program to choose.
pub(crate) fn is_asked_for(settings: &Settings) -> bool {
    match settings.method {
        Method::Auto => chosen_by(settings),
        method => method == Method::EdgeFitted,
    }
}

/// The state at the overlap of the contact's gap under this tilt; `with_matrix`: its stiffness against tilts too. `None` where nothing is
/// known that cells can be fitted to.
///
/// # Errors
/// `ToleranceNotReached` with the state.
pub(crate) fn solution(
    contact: &Contact,
    overlap: &Overlap,
    tilt: [f64; 2],
    settings: &Settings,
    with_matrix: bool,
) -> Option<Result<Solution, Unsolved>> {
    let depth = overlap.depth;
    let found = Route::of(overlap, settings, with_matrix)?.solve(contact, depth, settings, with_matrix)?;
    let mut state = in_users_units(contact, &overlap.gap, found, (depth, tilt), settings);
    if let Some(law) = overlap.known().law.filter(|_| !with_matrix) {
        by_similarity(&mut state, &law);
    }
    Some(judged(state, settings))
}

/// Stiffness and energy of a homogeneous gap follow from the force: those of the cells err by more.
fn by_similarity(state: &mut Solution, law: &Law) {
    let overlap = state.depth - law.lowest;
    state.stiffness = law.stiffness(state.force, overlap);
    state.energy = Some(law.energy(state.force, overlap));
    (state.stiffness_error, state.energy_error) = (state.force_error, state.force_error);
}

/// Whether a flat ellipse lifts off under this load: what its formula, which is for a level one, does not reach.
pub(crate) fn lifts_off(gap: &AnyGap, load: Load) -> bool {
    let Load::ForceMoment { force, moment } = load else { return false };
    let ellipse = gap.known().face.as_ref().filter(|face| force > 0.0 && face.outline.semi_axes().is_some());
    ellipse.and_then(tilted::Tilting::of).is_some_and(|tilting| !tilting.is_core(force, moment))
}

/// The state under a force and moments (Mx, My) about the origin; `None` where the gap is no face in a polygon.
///
/// # Errors
/// `NoEquilibrium` where the line of action passes outside of all material; `ToleranceNotReached` with the state.
pub(crate) fn balanced(
    contact: &Contact,
    force: f64,
    moment: [f64; 2],
    settings: &Settings,
) -> Option<Result<Solution, Unsolved>> {
    let face = contact.gap().known().face.as_ref().filter(|_| is_asked_for(settings) && force > 0.0)?;
    if let Err(outside) = tilted::balances(face, force, moment) {
        return Some(Err(outside));
    }
    let tilting = tilted::Tilting::of(face)?;
    let limits = limits(settings, settings.threads);
    let free = with(limits.threads, || tilting.under(contact, force, moment, settings, &limits))?;
    let gap = contact.tilted_gap(free.tilt);
    let mut state = in_users_units(contact, &gap, free.found, (free.depth, free.tilt), settings);
    (state.force, state.moment) = (force, Some(moment));
    state.depth_bracket = free.bounds.map(DepthBracket::proved);
    state.tilt_bracket = free.bounds_of_tilt;
    Some(judged(state, settings))
}

/// The state where its error is within the tolerance.
fn judged(state: Solution, settings: &Settings) -> Result<Solution, Unsolved> {
    let error = state.force_error.unwrap_or(f64::INFINITY);
    if error <= settings.tolerance {
        return Ok(state);
    }
    let why = "more cells than can be solved densely, or more time than is left";
    Err(Unsolved::short_of(settings.tolerance, error, why).with_best(state))
}

/// The verdict where this method is prescribed and does not apply.
pub(crate) fn not_applicable() -> Unsolved {
    let reason = "the gap is not known to be a flat polygon or ellipse, planes with a level one among them, of revolution, upright, an oval ring, a roller with sharp or steep ends, a flat with rounded or sloping edges, or a polynomial of second degree in an outline whose edge it reaches";
    Unsolved::new(Verdict::NotApplicable, reason)
}

fn in_users_units(
    contact: &Contact,
    gap: &AnyGap,
    found: Found,
    (depth, tilt): (f64, [f64; 2]),
    settings: &Settings,
) -> Solution {
    let outputs = settings.outputs;
    let [low, high] = found.force;
    let (force, force_error) = (0.5 * (low + high), found.error());
    let mut left_out = vec![found.left_out.to_owned()];
    if !outputs.patch {
        left_out.push("the boundary as a polyline".to_owned());
    }
    if !outputs.pressure {
        left_out.push("the pressure field".to_owned());
    }
    let [x, y] = found.centre;
    let mut patch = found.patch;
    let boundary = patch.boundary.clone().unwrap_or_default();
    let validity = Validity::of(contact, &boundary, patch.area, force);
    let touches_edge = touches_edge(gap, &boundary);
    let extent = Rect::holding(boundary.iter().flatten().copied()).map(|rect| [rect.min, rect.max]);
    let piece =
        |extent| Some(Piece { area: patch.area, force, centroid: patch.centroid?, extent, max_pressure: found.max });
    if patch.pieces.is_empty() {
        patch.pieces = extent.and_then(piece).into_iter().collect();
    } else {
        // Of the computed force; the stated one is the middle of its bounds.
        let computed: f64 = patch.pieces.iter().map(|piece| piece.force).sum();
        patch.pieces.iter_mut().for_each(|piece| piece.force *= force / computed);
        patch.pieces.sort_by(|a, b| b.force.total_cmp(&a.force));
    }
    patch.boundary = patch.boundary.filter(|_| outputs.patch);
    Solution {
        method: Method::EdgeFitted,
        origin: Origin::EdgeFitted,
        turned: None,
        grid: found.field.as_ref().map(|field| field.grid),
        depth,
        tilt,
        force,
        force_error: Some(force_error),
        depth_error: Some(0.0),
        map_error: None,
        samples: None,
        stiffness_error: found.stiffness_error,
        // Beyond the range of numbers bounds are none.
        energy_error: Some((found.energy[1] - found.energy[0]) / (found.energy[1] + found.energy[0]))
            .filter(|error| *error >= 0.0),
        area_error: found.area_error,
        bracket: found.proved.then(|| ForceBracket::of_energy(found.force)),
        depth_bracket: None,
        moment_bracket: found.tilting.as_ref().and_then(|tilting| tilting.bounds),
        tilt_bracket: None,
        stiffness: found.stiffness,
        stiffness_matrix: found.tilting.as_ref().map(|tilting| tilting.matrix),
        moment: Some(found.tilting.and_then(|tilting| tilting.moment).unwrap_or([force * y, -force * x])),
        energy: Some(0.5 * (found.energy[0] + found.energy[1])),
        pressure: PressureSummary {
            max: found.max,
            max_error: found.max_error.filter(|_| found.max.is_some()),
            singular: found.max.is_none().then_some(Singular::Edge),
            mean: Some(force / patch.area),
            at: Some(found.at),
            field: found.field,
            gap: None,
        },
        patch,
        residuals: None,
        touches_edge,
        validity,
        cost: Cost { unknowns: found.unknowns, ..Cost::default() },
        left_out,
        remarks: vec![found.how],
    }
}

/// Cells along the longer side of a field.
const FIELD_CELLS: usize = 64;

/// The grid of a field over a rectangle.
fn field_grid(rect: &Rect) -> Grid {
    Grid::over(rect, shape(rect, FIELD_CELLS))
}

/// The edge of data that a boundary runs along, seen a hair outside of it.
fn touches_edge(gap: &AnyGap, boundary: &[Vec<[f64; 2]>]) -> Option<TouchesEdge> {
    let looks = boundary.iter().flat_map(|line| (0..line.len()).map(move |k| (line[k], line[(k + 1) % line.len()])));
    let outside = |([ax, ay], [bx, by]): ([f64; 2], [f64; 2])| {
        // Contact is on the left.
        let off = 1e-6;
        [0.5 * (ax + bx) + off * (by - ay), 0.5 * (ay + by) - off * (bx - ax)]
    };
    // Corners of what stands for an ellipse lie outside of it, the middles of its chords do not.
    let corners = boundary.iter().flatten().copied();
    let edge = looks.map(outside).chain(corners).find_map(|[x, y]| gap.end_of_data(x, y))?;
    Some(TouchesEdge { edge, share: None })
}

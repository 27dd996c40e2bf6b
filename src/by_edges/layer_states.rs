//! States of one flat with flanks at several small depths: the flat and one deep state hold all of them.
//!
//! Let s be the depth less the height of the flat F. P is the integral of the stiffness K of the contact, which grows with the contact, and
//! this with s. So P is convex, P/s rises, and for a state at s1 and all s <= s1
//!
//! ```text
//! K(F) s <= P(s) <= P(s1) s/s1,    K(F) <= K(s) <= K(s1),    K(s) (s1 - s) <= P(s1) - P(s).
//! ```
//!
//! The contact ends as close to the flat as the square of what the overlap reaches beyond it (the flat's pressure rises as r^(-1/2) there):
//! P(s1)/(K(F) s1) - 1 is about 0.2 to 0.35 (s1/h)^2, so that s1 may be far deeper than the bounds of [`super::layer`] alone reach.

use std::f64::consts::PI;

use super::flanked::FlankedTip;
use super::flat::{Flat, Punch};
use super::layer::{FlatTip, level_of};
use super::{in_users_units, is_asked_for, judged, limits};
use crate::edge_fitted::Limits;
use crate::gap::Gap;
use crate::numeric::geometry::area;
use crate::overlap::Overlap;
use crate::problem::{Contact, Load, Outputs, Settings};
use crate::solution::Solution;

/// What holds the states at small depths.
pub(crate) struct LayerStates {
    flat: Flat,
    /// Bounds of K(F), and its pressure.
    punch: Punch,
    /// h.
    height: f64,
    /// A deep state.
    deepest: Option<Deepest>,
}

/// From above: E* = 1, lengths are the user's.
struct Deepest {
    overlap: f64,
    force: f64,
    stiffness: f64,
    /// Its area over that of the flat.
    area: f64,
    proved: bool,
}

/// The part of the tolerance that the flat's stiffness and the deep state may take, each on both sides.
const SHARE: f64 = 0.35;

/// P(s1)/(K(F) s1) - 1 over (s1/h)^2, for the first deep state, and what is left to it of the tolerance on both sides.
const RISE: f64 = 0.34;
const LEFT: f64 = 2.0 - 4.0 * SHARE;

/// Deep states to look for, each where the one before would have lain low enough, and a little above.
const TRIES: usize = 3;
const LESS: f64 = 0.9;

/// A small overlap, over the largest height of a plane at the origin: any has the same flat.
const SMALL: f64 = 1e-3;

impl LayerStates {
    /// `None` where the gap has no flat with flanks, where no cells are asked for, and where fewer than two states lie near enough.
    pub fn of(contact: &Contact, settings: &Settings) -> Option<Self> {
        let loads = contact.loading().loads();
        if !is_asked_for(settings) || loads.len() < 2 {
            return None;
        }
        let planes = contact.gap().planes()?;
        let level = level_of(&planes)?;
        let size = planes.iter().map(|p| (p[2] - level).abs()).fold(0.0, f64::max);
        let tip = FlatTip::of(&Overlap::of(contact.gap(), level + SMALL * size).ok()??)?;
        let height = tip.depth / tip.growth;
        // Roughly, under a force: of all flats of an area the disc is the softest.
        let softest = 2.0 * contact.modulus().e_star() * (area(&tip.face) / PI).sqrt();
        let overlap = |load: &Load| match *load {
            Load::Depth(depth) => Some(depth - level),
            Load::Force(force) => Some(force / softest),
            Load::Tilted { .. } | Load::ForceMoment { .. } => None,
        };
        let overlaps: Vec<f64> = loads.iter().filter_map(overlap).filter(|overlap| *overlap > 0.0).collect();
        let up_to = |most: f64| overlaps.iter().copied().filter(move |overlap| *overlap <= most);
        let mut most = height * (LEFT * settings.tolerance / RISE).sqrt();
        if up_to(most).count() < 2 {
            return None;
        }
        let flat = Flat::polygon(&tip.face, tip.middle, [1.0, 0.0], tip.level)?;
        let limits = Limits { tolerance: SHARE * settings.tolerance, ..limits(settings, 1) };
        let punch = flat.punch(&limits)?;
        let mut states = Self { flat, punch, height, deepest: None };
        for _ in 0..TRIES {
            let overlap = up_to(most).fold(0.0, f64::max);
            if overlap <= 0.0 || states.held(overlap, settings.tolerance).is_some() {
                break;
            }
            let Some(deepest) = states.solved(contact, overlap, settings, &limits) else { break };
            let rise = deepest.force / (overlap * states.punch.stiffness[0]) - 1.0;
            states.deepest = Some(deepest);
            most = LESS * overlap * (LEFT * settings.tolerance / (rise - 4.0 * SHARE * settings.tolerance)).sqrt();
        }
        Some(states)
    }

    /// The state at an overlap, by cells that follow its flanks.
    fn solved(&self, contact: &Contact, overlap: f64, settings: &Settings, limits: &Limits) -> Option<Deepest> {
        let quiet = Settings { outputs: Outputs::default(), ..*settings };
        let tip = FlatTip::of(&Overlap::of(contact.gap(), self.flat.value + overlap).ok()??)?;
        let found = FlankedTip::of(&tip)?.solve(contact, &quiet, limits)?;
        let e_star = contact.modulus().e_star();
        Some(Deepest {
            overlap,
            force: found.force[1] / e_star,
            stiffness: found.stiffness * (1.0 + found.stiffness_error?) / e_star,
            area: found.patch.area * (1.0 + found.area_error?) / area(&self.flat.corners),
            proved: found.proved,
        })
    }

    /// Upper bounds of P/(E* s), of K/E* and of the area over that of the flat, where the first is near enough.
    fn held(&self, overlap: f64, tolerance: f64) -> Option<Above> {
        let [low, high] = self.punch.stiffness;
        let growth = overlap / self.height * (1.0 + 8.0 * f64::EPSILON);
        // As for a layer.
        let mut above = Above {
            secant: high * (1.0 + 0.5 * growth),
            stiffness: high * (1.0 + growth),
            area: (1.0 + growth).powi(2),
            proved: true,
        };
        let near = |secant: f64| secant - low <= tolerance * (secant + low);
        let reaches = |deep: &&Deepest| overlap <= deep.overlap && (deep.proved || !near(above.secant));
        if let Some(deep) = self.deepest.as_ref().filter(reaches) {
            let chord = (deep.force - low * overlap) / (deep.overlap - overlap);
            let secant = deep.force / deep.overlap;
            above.proved = deep.proved || secant >= above.secant;
            above.secant = above.secant.min(secant);
            above.stiffness = above.stiffness.min(deep.stiffness).min(if chord > 0.0 { chord } else { f64::INFINITY });
            above.area = above.area.min(deep.area);
        }
        near(above.secant).then_some(above)
    }

    /// The state at this depth; `None` where it lies too deep.
    pub fn at(&self, contact: &Contact, depth: f64, settings: &Settings) -> Option<Solution> {
        let overlap = depth - self.flat.value;
        let above = self.held(overlap, settings.tolerance).filter(|_| overlap > 0.0)?;
        let how = format!(
            "the gap is a flat with flanks, which the contact passes by at most {:.1e} of its size: the force is that of the flat",
            above.area - 1.0
        );
        let mut found = self.flat.state(contact, overlap, settings, self.punch.clone(), how);
        let ([low, _], e_star) = (self.punch.stiffness, contact.modulus().e_star());
        found.force = [low, above.secant].map(|k| e_star * k * overlap);
        found.energy = found.force.map(|p| 0.5 * p * overlap);
        found.stiffness = 0.5 * e_star * (low + above.stiffness);
        found.stiffness_error = Some((above.stiffness - low) / (above.stiffness + low));
        found.area_error = found.area_error.map(|error| error + above.area - 1.0);
        found.left_out = "another solve: the flat and one deeper state of the list hold this one";
        found.proved = above.proved;
        let gap = contact.gap();
        judged(in_users_units(contact, gap, found, (depth, [0.0; 2]), settings), settings).ok()
    }
}

/// What a state lies below.
struct Above {
    secant: f64,
    stiffness: f64,
    area: f64,
    proved: bool,
}

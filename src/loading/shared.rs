//! What the states of a list share: a law of similarity, or a flat and one deep state.

use std::sync::{Arc, OnceLock};

use crate::by_edges::LayerStates;
use crate::gap::{AnyGap, Law};
use crate::problem::{Contact, Settings};
use crate::solution::{Solution, Unsolved};

/// What earlier states of a list leave to later ones.
#[derive(Default)]
pub(crate) struct Shared {
    pub similar: Option<Similar>,
    layers: Layers,
}

/// What holds the states of small depths, if anything does: looked for once.
#[derive(Clone, Default)]
pub(crate) struct Layers(Arc<OnceLock<Option<LayerStates>>>);

impl Shared {
    /// From what was looked for before, for the same loading of the same contact with the same settings.
    pub fn with(layers: Layers) -> Self {
        Self { similar: None, layers }
    }

    /// What holds the states of small depths, if anything does.
    pub fn layers(&self, contact: &Contact, settings: &Settings) -> Option<&LayerStates> {
        self.layers.0.get_or_init(|| LayerStates::of(contact, settings)).as_ref()
    }
}

/// A solved state of a homogeneous gap, from which every other follows.
pub(crate) struct Similar {
    pub state: Solution,
    pub law: Law,
    /// What it lacks, as every other does.
    short: Option<Unsolved>,
}

impl Similar {
    /// A solved state, or one that only its error keeps from it.
    pub fn of(answer: Result<Solution, Unsolved>, law: Law) -> Result<Self, Unsolved> {
        match answer {
            Ok(state) => Ok(Self { state, law, short: None }),
            Err(e) => {
                let short = Unsolved { best: None, ..e.clone() };
                e.accept_best().map(|state| Self { state, law, short: Some(short) })
            }
        }
    }

    /// Whether others may follow from it: numbers near the end of the range have lost digits.
    pub fn has_all_digits(&self) -> bool {
        let whole = |x: f64| (f64::MIN_POSITIVE / f64::EPSILON..=f64::MAX).contains(&x);
        let s = &self.state;
        [s.force, s.stiffness, s.patch.area].into_iter().chain(s.energy).all(whole)
    }

    /// A state that follows from this one, with what it lacks.
    pub fn answer(&self, state: Solution) -> Result<Solution, Unsolved> {
        match &self.short {
            None => Ok(state),
            Some(short) => Err(short.clone().with_best(state)),
        }
    }

    /// The depth at which the force is this.
    pub fn depth_for(&self, force: f64) -> f64 {
        let overlap = self.state.depth - self.law.lowest;
        self.law.lowest + overlap * (force / self.state.force).powf(1.0 / (1.0 + self.law.degree.inverse()))
    }

    /// The state at this depth.
    pub fn at(&self, gap: &AnyGap, depth: f64) -> Solution {
        let mut state = self.state.at_other_depth(depth, gap.known().centre, &self.law);
        state.left_out.push(format!(
            "another solve: the gap is homogeneous, and the state at depth {:e} serves all",
            self.state.depth
        ));
        state
    }
}

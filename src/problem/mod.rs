//! The checked problem: a gap, an effective modulus and a loading. It exists only when it is valid.

mod material;
mod settings;

pub use material::{Body, EffectiveModulus};
pub use settings::{BoundaryFamily, ErrorBar, Method, Outputs, Settings};

use crate::error::{InputError, finite};
use crate::gap::{AnyGap, Gap};

/// One state of loading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Load {
    /// Approach of the bodies, from zero gap at the reference point. Negative: no contact.
    Depth(f64),
    /// Normal force on a punch that moves without tilting.
    Force(f64),
    /// Approach and tilt (radians, small): f = depth + ax x + ay y - gap.
    Tilted {
        /// Approach at the origin.
        depth: f64,
        /// (ax, ay).
        tilt: [f64; 2],
    },
    /// Force and moments about the origin on a punch free to tilt: Mx = force y, My = -force x.
    ForceMoment {
        /// Normal force.
        force: f64,
        /// (Mx, My).
        moment: [f64; 2],
    },
}

/// How the bodies are loaded: one state, or several.
#[derive(Debug, Clone, PartialEq)]
pub enum Loading {
    /// One state.
    Single(Load),
    /// Several states, answered in order.
    Steps(Vec<Load>),
}

impl Loading {
    /// One depth.
    #[must_use]
    pub fn depth(depth: f64) -> Self {
        Self::Single(Load::Depth(depth))
    }

    /// One force.
    #[must_use]
    pub fn force(force: f64) -> Self {
        Self::Single(Load::Force(force))
    }

    /// A force whose line of action meets the surface at `through`, on a punch free to tilt.
    #[must_use]
    pub fn force_through(force: f64, through: [f64; 2]) -> Self {
        Self::Single(Load::ForceMoment { force, moment: [force * through[1], -force * through[0]] })
    }

    /// `steps` equal steps of depth up to `to`; 0 is left out.
    #[must_use]
    pub fn depth_range(to: f64, steps: usize) -> Self {
        Self::Steps((1..=steps).map(|k| Load::Depth(to * (k as f64 / steps as f64))).collect())
    }

    /// The states, one or many.
    #[must_use]
    pub fn loads(&self) -> &[Load] {
        match self {
            Self::Single(load) => std::slice::from_ref(load),
            Self::Steps(loads) => loads,
        }
    }
}

/// Two bodies, the gap between them, and a loading.
///
/// ```
/// use contact_patch::{Body, Contact, EffectiveModulus, Loading, gap::Polyhedron};
/// let modulus = EffectiveModulus::of_pair(Body::elastic(2.1e11, 0.3)?, Body::RIGID)?;
/// let punch = Polyhedron::pyramid(3, 45f64.to_radians())?;
/// let contact = Contact::new(modulus, punch, Loading::depth(1e-6))?;
/// // Any closure is a gap.
/// let dented = Contact::new(modulus, |x: f64, y: f64| x * x + y.abs().powi(3), Loading::force(10.0))?;
/// # Ok::<(), contact_patch::InputError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Contact {
    modulus: EffectiveModulus,
    gap: AnyGap,
    loading: Loading,
}

impl Contact {
    /// A problem, checked.
    ///
    /// # Errors
    /// Names `loading` when a number in it is not finite or the list is empty.
    pub fn new(modulus: EffectiveModulus, gap: impl Gap + 'static, loading: Loading) -> Result<Self, InputError> {
        if loading.loads().is_empty() {
            return Err(InputError::new("loading", "an empty list", "at least one depth or force"));
        }
        for load in loading.loads() {
            match *load {
                Load::Depth(depth) => finite("loading.depth", depth)?,
                Load::Force(force) => finite("loading.force", force)?,
                Load::Tilted { depth, tilt: [ax, ay] } => {
                    finite("loading.tilt[0]", ax)?;
                    finite("loading.tilt[1]", ay)?;
                    finite("loading.depth", depth)?
                }
                Load::ForceMoment { force, moment: [mx, my] } => {
                    finite("loading.moment[0]", mx)?;
                    finite("loading.moment[1]", my)?;
                    finite("loading.force", force)?
                }
            };
        }
        let gap = AnyGap::new(gap);
        let [x, y] = gap.known().centre;
        if gap.gap(x, y).is_nan() {
            return Err(InputError::new(
                "gap",
                format!("NaN at ({x}, {y})"),
                "a number, or infinity where there is no material",
            ));
        }
        Ok(Self { modulus, gap, loading })
    }

    /// The same bodies under another loading, known to be valid.
    pub(crate) fn under(&self, loading: Loading) -> Self {
        Self { loading, ..self.clone() }
    }

    /// Bodies of the same material with another gap and loading, known to be valid.
    pub(crate) fn of_gap(&self, gap: AnyGap, loading: Loading) -> Self {
        Self { modulus: self.modulus, gap, loading }
    }

    /// E* of the pair.
    #[must_use]
    pub fn modulus(&self) -> EffectiveModulus {
        self.modulus
    }

    /// The initial gap.
    #[must_use]
    pub fn gap(&self) -> &AnyGap {
        &self.gap
    }

    /// The gap under a tilt (ax, ay) of the body.
    pub(crate) fn tilted_gap(&self, tilt: [f64; 2]) -> AnyGap {
        self.gap.tilted(tilt)
    }

    /// How the bodies are loaded.
    #[must_use]
    pub fn loading(&self) -> &Loading {
        &self.loading
    }
}

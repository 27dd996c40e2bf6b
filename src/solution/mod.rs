//! The answer: force, stiffness, patch and pressure of one state of loading, in the user's units.

mod bounds;
mod patch;
mod pressure;
mod residuals;
mod unsolved;

use crate::gap::Law;
use crate::grid::Grid;
use crate::problem::{Load, Method};

pub(crate) use bounds::ROUNDED;
pub use bounds::{BracketCost, DepthBracket, Evidence, ForceBracket, PairBracket, Repair, Side, Theorem};
pub use patch::{Patch, Piece, TouchesEdge};
pub use pressure::{PressureSummary, Singular};
pub use residuals::Residuals;
pub(crate) use unsolved::rounded_up;
pub use unsolved::{Unsolved, Verdict};

/// How the force of a state was found: what a checker needs to know to judge it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Origin {
    /// The bodies do not touch.
    NoContact,
    /// A formula. The pressure field is the formula's at the centres of cells.
    ClosedForm,
    /// An approximate method: the best ellipse, or Fabrikant's pressure.
    Approximate,
    /// The solution of one grid: the force is the sum of the field.
    OneGrid,
    /// The limit of several grids, of which the field is the finest.
    ManyGrids {
        /// How many.
        grids: usize,
    },
    /// Contacts far apart, each on grids of its own; the field is a mean of theirs.
    SeparateContacts {
        /// How many.
        count: usize,
    },
    /// Cells graded towards the edges of the material.
    EdgeFitted,
}

impl Origin {
    /// The word that stands in a result.
    #[must_use]
    pub fn kind(self) -> &'static str {
        match self {
            Self::NoContact => "no_contact",
            Self::ClosedForm => "closed_form",
            Self::Approximate => "approximate",
            Self::OneGrid => "one_grid",
            Self::ManyGrids { .. } => "many_grids",
            Self::SeparateContacts { .. } => "separate_contacts",
            Self::EdgeFitted => "edge_fitted",
        }
    }
}

/// A state of contact: solved, or the best that an [`crate::Unsolved`] has to show.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// What ran (never [`Method::Auto`]).
    pub method: Method,
    /// How the force was found.
    pub origin: Origin,
    /// Angle from the user's axes to those along which it was solved, radians counter-clockwise; `None` where they are the same. The
    /// pressure field is then a mean, over upright cells, of that of turned ones.
    pub turned: Option<f64>,
    /// The finest grid; `None` for methods without one.
    pub grid: Option<Grid>,
    /// Approach of the bodies at the origin.
    pub depth: f64,
    /// Tilts (ax, ay), radians; zero unless the loading says otherwise.
    pub tilt: [f64; 2],
    /// Normal force.
    pub force: f64,
    /// Relative error of the force, of the kind that [`Solution::evidence`] says; `None` when nothing is known of it. 0 where the
    /// force was prescribed: then the error is that of the depth.
    pub force_error: Option<f64>,
    /// Relative error of the depth; 0 where that was prescribed, `None` when nothing is known of it.
    pub depth_error: Option<f64>,
    /// The part of the error that the samples of a measured gap leave open, relative to the force: an estimate from coarser samples. `None`
    /// for gaps that are no measurements.
    pub map_error: Option<f64>,
    /// The same on the cells of the grid, where there is one.
    pub(crate) samples: Option<Samples>,
    /// Relative error of the stiffness; `None` when nothing is known of it.
    pub stiffness_error: Option<f64>,
    /// Relative error of the stored energy; `None` when nothing is known of it.
    pub energy_error: Option<f64>,
    /// Relative error of the area of the patch; `None` when nothing is known of it.
    pub area_error: Option<f64>,
    /// Bounds of the force with their evidence: where they make the error, and when asked for.
    pub bracket: Option<ForceBracket>,
    /// Bounds of the depth under a prescribed force, with the bracket.
    pub depth_bracket: Option<DepthBracket>,
    /// Proved bounds of the moment at a prescribed tilt: of a face in a polygon that touches everywhere, and on grids, of gaps that are no
    /// measurements, where a bracket is asked for.
    pub moment_bracket: Option<PairBracket>,
    /// Proved bounds of the tilts under a force and moments: of a face in a polygon that touches everywhere.
    pub tilt_bracket: Option<PairBracket>,
    /// dP/dd.
    pub stiffness: f64,
    /// Second derivatives of the stored energy by (depth, ax, ay); `None` when the method cannot give them.
    pub stiffness_matrix: Option<[[f64; 3]; 3]>,
    /// Moments (Mx, My) about the origin, Mx = integral of p y, My = -integral of p x; `None` when the method cannot give them.
    pub moment: Option<[f64; 2]>,
    /// Stored energy: the work of the force from first touch to here.
    pub energy: Option<f64>,
    /// The contact patch.
    pub patch: Patch,
    /// The contact pressure.
    pub pressure: PressureSummary,
    /// Residuals recomputed from the pressure; `None` for methods without a grid.
    pub residuals: Option<Residuals>,
    /// The edge of measured or declared data that the patch meets, if any.
    pub touches_edge: Option<TouchesEdge>,
    /// How far the state is from what small-strain half-space theory assumes; `None` without contact.
    pub validity: Option<Validity>,
    /// What it took.
    pub cost: Cost,
    /// What this scene did not need, in words.
    pub left_out: Vec<String>,
    /// What the user should know about how the answer came about, in words.
    pub remarks: Vec<String>,
}

/// What the samples of a measured gap leave open.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Samples {
    /// Of the gap, at most, where the bodies may touch.
    pub off: f64,
    /// Of the force.
    pub force: f64,
    /// Of the stored energy.
    pub work: f64,
}

/// What the stated error of a force is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ForceEvidence {
    /// Rounding: the force is from a formula, or there is no contact.
    Exact,
    /// The force lies in a proved bracket, and so does everything within the stated error of it.
    Proved,
    /// As proved, by a supremum that was sampled.
    Sampled,
    /// An estimate.
    Estimated,
}

impl ForceEvidence {
    /// The word in results.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Proved => "proved",
            Self::Sampled => "sampled",
            Self::Estimated => "estimated",
        }
    }
}

impl Solution {
    /// The error of what was not prescribed: of the depth under a force, else of the force.
    #[must_use]
    pub fn error(&self) -> Option<f64> {
        if self.depth_error == Some(0.0) { self.force_error } else { self.depth_error }
    }

    /// Its depth, and its tilt where it has one, as a load: the same state, whatever it was found under.
    pub(crate) fn load(&self) -> Load {
        match self.tilt {
            [0.0, 0.0] => Load::Depth(self.depth),
            tilt => Load::Tilted { depth: self.depth, tilt },
        }
    }

    /// What that error is: that of a bracket, where it covers it.
    #[must_use]
    pub fn evidence(&self) -> ForceEvidence {
        if matches!(self.origin, Origin::ClosedForm | Origin::NoContact) {
            return ForceEvidence::Exact;
        }
        let Some(error) = self.error() else { return ForceEvidence::Estimated };
        let (value, bounds) = if self.depth_error == Some(0.0) {
            (self.force, self.bracket.as_ref().map(|b| ([b.lower(), b.upper()], b.evidence())))
        } else {
            let bounds = self.depth_bracket.as_ref();
            (self.depth, bounds.and_then(|b| Some((b.ends()?, b.evidence()))))
        };
        let Some(([lower, upper], evidence)) = bounds else { return ForceEvidence::Estimated };
        let room = error * value.abs() * (1.0 + 1e-9);
        let covers = upper - value <= room && value - lower <= room;
        match evidence {
            Evidence::Proved if covers => ForceEvidence::Proved,
            Evidence::Sampled { .. } if covers => ForceEvidence::Sampled,
            _ => ForceEvidence::Estimated,
        }
    }

    /// With proved bounds of the force at its depth: they are its error where that is small enough, and else show what it misses at least.
    pub(crate) fn held_by(mut self, [lower, upper]: [f64; 2], tolerance: f64) -> Self {
        let error = (upper - self.force).max(self.force - lower) / self.force * (1.0 + ROUNDED);
        if error <= tolerance {
            self.force_error = Some(error);
            self.bracket = Some(ForceBracket::of_energy([lower, upper]));
        } else {
            let shown = (lower - self.force).max(self.force - upper) / self.force;
            self.force_error = self.force_error.map(|own| own.max(shown));
        }
        self
    }

    /// The bracket for forces larger by this factor; the errors that follow from it have its rounding.
    pub(crate) fn scale_bracket(&mut self, factor: f64) {
        self.bracket = self.bracket.as_ref().and_then(|bracket| bracket.at_other_depth(factor));
        if self.bracket.is_some() {
            let errors = [&mut self.force_error, &mut self.stiffness_error, &mut self.energy_error];
            errors.into_iter().flatten().for_each(|error| *error += 3.0 * ROUNDED);
        }
    }

    /// The bodies do not touch.
    pub(crate) fn apart(method: Method, depth: f64, tilt: [f64; 2]) -> Self {
        Self {
            method,
            origin: Origin::NoContact,
            turned: None,
            grid: None,
            depth,
            tilt,
            force: 0.0,
            force_error: Some(0.0),
            depth_error: Some(0.0),
            map_error: None,
            samples: None,
            stiffness_error: Some(0.0),
            energy_error: Some(0.0),
            area_error: Some(0.0),
            bracket: None,
            depth_bracket: None,
            moment_bracket: None,
            tilt_bracket: None,
            stiffness: 0.0,
            stiffness_matrix: Some([[0.0; 3]; 3]),
            moment: Some([0.0; 2]),
            energy: Some(0.0),
            patch: Patch::default(),
            pressure: PressureSummary { max: Some(0.0), max_error: Some(0.0), ..PressureSummary::default() },
            residuals: None,
            touches_edge: None,
            validity: None,
            cost: Cost::default(),
            left_out: vec!["everything: the bodies do not touch at this depth".to_owned()],
            remarks: Vec::new(),
        }
    }

    /// The state at another depth of a gap that is homogeneous about `centre`: with depths counted from its lowest point, lengths
    /// grow as (d2/d1)^(1/k) about the centre, forces as (d2/d1)^(1 + 1/k).
    #[must_use]
    pub fn at_other_depth(&self, depth: f64, centre: [f64; 2], law: &Law) -> Self {
        let deeper = (depth - law.lowest) / (self.depth - law.lowest);
        let longer = deeper.powf(law.degree.inverse());
        let place = |p: [f64; 2]| [0, 1].map(|m| centre[m] + longer * (p[m] - centre[m]));
        let (stronger, harder) = (deeper * longer, deeper / longer);
        let mut other = self.clone();
        other.depth = depth;
        other.force *= stronger;
        other.scale_bracket(stronger);
        (other.depth_bracket, other.moment_bracket, other.tilt_bracket) = (None, None, None);
        other.samples = None;
        other.stiffness *= longer;
        other.energy = self.energy.map(|u| u * deeper * stronger);
        // About the centre the rows scale one by one; the matrix is about the origin.
        other.stiffness_matrix = self.stiffness_matrix.filter(|_| centre == [0.0; 2]).map(|matrix| {
            let unit = [1.0, longer, longer];
            [0, 1, 2].map(|i| [0, 1, 2].map(|j| matrix[i][j] * longer * unit[i] * unit[j]))
        });
        other.moment = self.moment.map(|[mx, my]| {
            let [x, y] = place([-my / self.force, mx / self.force]);
            [other.force * y, -other.force * x]
        });
        let patch = &mut other.patch;
        patch.area *= longer * longer;
        patch.max_radius *= longer;
        patch.centroid = patch.centroid.map(place);
        patch.boundary.iter_mut().flatten().flatten().for_each(|p| *p = place(*p));
        patch.semi_axes = patch.semi_axes.map(|axes| axes.map(|a| a * longer));
        for piece in &mut patch.pieces {
            piece.area *= longer * longer;
            piece.force *= stronger;
            piece.centroid = place(piece.centroid);
            piece.extent = piece.extent.map(place);
            piece.max_pressure = piece.max_pressure.map(|p| p * harder);
        }
        if let Some(validity) = &mut other.validity {
            // Slopes grow as heights over lengths; so do pressures over the modulus.
            validity.slope *= harder;
            validity.pressure_over_modulus *= harder;
            validity.size_over_radius = validity.size_over_radius.map(|s| s * longer);
        }
        let moved = |grid: &mut Grid| {
            grid.origin = place(grid.origin);
            grid.spacing = grid.spacing.map(|h| h * longer);
        };
        other.grid.iter_mut().for_each(moved);
        let pressure = &mut other.pressure;
        pressure.max = pressure.max.map(|p| p * harder);
        pressure.mean = pressure.mean.map(|p| p * harder);
        pressure.at = pressure.at.map(place);
        if let Some((grid, values)) = &mut pressure.gap {
            moved(grid);
            values.iter_mut().for_each(|g| *g *= deeper);
        }
        if let Some(field) = &mut pressure.field {
            moved(&mut field.grid);
            field.values.iter_mut().for_each(|p| *p *= harder);
        }
        other
    }
}

/// How far a state is from what small-strain half-space theory assumes: all three small against 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Validity {
    /// Largest slope of the gap found in the patch, with nothing of tilts.
    pub slope: f64,
    /// Radius of the disc with the area of the patch over the radius of curvature (the geometric mean of both), where one is known.
    pub size_over_radius: Option<f64>,
    /// Mean pressure over E*.
    pub pressure_over_modulus: f64,
}

/// What a solution took.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Cost {
    /// Wall-clock seconds.
    pub seconds: f64,
    /// Unknowns of the largest system.
    pub unknowns: usize,
    /// Iterations, all levels.
    pub iterations: usize,
    /// Products with the compliance operator, all levels.
    pub operator_products: usize,
    /// States that were solved to balance a load; 0 where the depth was given.
    pub steps: usize,
}

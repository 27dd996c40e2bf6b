//! What the caller asks for: method, resolution, and which outputs are worth computing.

use crate::clock::{DEFAULT_SECONDS, Deadline};
use crate::grid::Kernel;

/// The methods.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
pub enum Method {
    /// The cheapest method that reaches the tolerance.
    #[default]
    Auto,
    /// A formula, where one is known.
    ClosedForm,
    /// The best ellipse (paper, section 2.2): a rigorous lower bound of the force.
    Ritz,
    /// Fabrikant's flat punch and the boundary of largest force (paper, sections 2.3 and 3).
    Fabrikant,
    /// The quadratic programme on a grid, solved by Clarabel and polished.
    Qp,
    /// The same programme by conjugate gradients and fast Fourier transforms.
    Fft,
    /// Cells graded to the edges of the material, solved densely, with proved bounds of the force.
    EdgeFitted,
}

impl Method {
    /// Whether it is one of the approximate methods, which have no pressure field.
    #[cfg(feature = "cli")]
    pub(crate) fn is_approximate(self) -> bool {
        matches!(self, Self::Ritz | Self::Fabrikant)
    }

    /// The name in scenes and results.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::ClosedForm => "closed_form",
            Self::Ritz => "ritz",
            Self::Fabrikant => "fabrikant",
            Self::Qp => "qp",
            Self::Fft => "fft",
            Self::EdgeFitted => "edge_fitted",
        }
    }
}

/// Families of boundaries for [`Method::Fabrikant`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum BoundaryFamily {
    /// Equation (15): stationary among all boundaries.
    #[default]
    Stationary,
    /// Ellipses.
    Ellipse,
    /// Circles.
    Circle,
    /// The contour of the gap at the present depth, scaled.
    PlanForm,
    /// Fourier series of this order for a(theta).
    Fourier(usize),
    /// Stationary; where there is no such boundary, the best family that has a maximum; else the ellipse.
    Auto,
}

/// What to compute besides force, stiffness and patch size.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Outputs {
    /// The boundary of the patch as polylines.
    pub patch: bool,
    /// The pressure field.
    pub pressure: bool,
    /// The gap after loading, on the same grid.
    pub gap: bool,
    /// A bracket around the force.
    pub bracket: bool,
    /// Force against depth up to the given load.
    pub curve: bool,
    /// Stored energy and moments where they cost more solves: by the approximate methods, for a gap that is not homogeneous.
    pub energy: bool,
}

/// What the stated error of the force is to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ErrorBar {
    /// Half the width of a proved bracket, wherever a theorem reaches ([`crate::energy`]); else an estimate.
    #[default]
    Proof,
    /// An estimate from several grids: cheapest, for inner loops.
    Estimate,
}

/// How to solve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Which method.
    pub method: Method,
    /// Cells along the longer side; `None`: as many as the tolerance asks for.
    pub cells: Option<usize>,
    /// Whether the cells are those around the nodes of the height map ([`crate::Gap::nodes`]); then `cells` is their number along the
    /// longer side of the map.
    pub nodes: bool,
    /// Means over cells or values at their centres.
    pub kernel: Kernel,
    /// Relative error of the force that is good enough, in (0, 1).
    pub tolerance: f64,
    /// Whether the error of the force is to be proved.
    pub evidence: ErrorBar,
    /// Boundaries that [`Method::Fabrikant`] may choose from.
    pub boundary: BoundaryFamily,
    /// What to compute besides.
    pub outputs: Outputs,
    /// Threads that the fft method, on grids of 2^16 cells and more, and cells fitted to edges may use; no number depends on them.
    pub threads: usize,
    /// CPU seconds that one state of loading may take; 0: no limit.
    pub seconds: f64,
    /// When the state at hand has to stop: set from `seconds` by [`crate::solve`] at the start of each state.
    pub deadline: Deadline,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            method: Method::Auto,
            cells: None,
            nodes: false,
            kernel: Kernel::Galerkin,
            tolerance: 1e-3,
            evidence: ErrorBar::default(),
            boundary: BoundaryFamily::Stationary,
            outputs: Outputs::default(),
            threads: 1,
            seconds: DEFAULT_SECONDS,
            deadline: Deadline::NEVER,
        }
    }
}

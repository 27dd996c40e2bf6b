//! The approximate method of Barber & Billings (1990): the contact region maximises the force P(A), and P(A) follows by
//! reciprocity from Fabrikant's pressure under a flat punch of plan-form A (equations 9 to 15).
//!
//! | equation | file |
//! |---|---|
//! | (10), (11) flat punch of any star-shaped plan-form | `flat_punch.rs` |
//! | (12) P(A) of any boundary, inner integral along a ray | `force.rs`, `ray.rs` |
//! | (15) stationary boundary | `stationary.rs` |
//! | (17)-(19), (25) regular polyhedra in closed form | `polyhedron.rs` |
//! | families of boundaries | `family.rs` |
//! | section 2.2, Rayleigh-Ritz ellipse | `ritz.rs`, beside this folder |
//!
//! The pressure p itself is not available from this method, and so neither is the line of action of the force:
//! reciprocity gives the total force only. Results are estimates, neither upper nor lower bounds, except for ellipses
//! ([`Approximation::lower_bound`]).

// Comparisons are written so that NaN takes the branch of failure.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

mod family;
mod flat_punch;
mod force;
mod polyhedron;
mod ray;
mod sectors;
mod star;
mod stationary;

pub use family::Family;
pub use flat_punch::FlatPunch;
pub use force::{Force, force};
pub use polyhedron::RegularPolyhedron;
pub(crate) use ray::{DIFFERENCE_STEP, Overlap, RadialRule};
pub(crate) use sectors::{Sectors, Spoke, THIRD};

use crate::error::{InputError, Unsolved, Verdict, finite};
use crate::gap::{Gap, Reach, Scaled};
use crate::material::EffectiveModulus;
use star::{Star, radius_in};

/// What can go wrong: the input, or the method.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// The problem cannot be built from this value.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The method has no answer, and says why.
    #[error(transparent)]
    Unsolved(#[from] Unsolved),
}

impl Error {
    /// The verdict, when it is one.
    #[must_use]
    pub fn verdict(&self) -> Option<Verdict> {
        match self {
            Self::Input(_) => None,
            Self::Unsolved(unsolved) => Some(unsolved.verdict),
        }
    }
}

/// How finely the approximate methods compute.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Relative error allowed in the quadrature of the force. Not the error of the method, which is of the order of a
    /// per cent: default 1e-9.
    pub tolerance: f64,
    /// Most rays of the quadrature over the angle; when they do not suffice, the error reached is reported all the same.
    pub most_rays: usize,
    /// Equally spaced points of the boundary computed besides those of the quadrature; 0 saves their time.
    pub boundary_points: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self { tolerance: 1e-9, most_rays: 4_000, boundary_points: 180 }
    }
}

impl Settings {
    /// The default with this tolerance, and no boundary points besides those of the quadrature.
    #[must_use]
    pub fn with_tolerance(tolerance: f64) -> Self {
        Self { tolerance, boundary_points: 0, ..Self::default() }
    }

    pub(crate) fn checked(&self) -> Result<Self, InputError> {
        if self.tolerance > 0.0 && self.tolerance < 1.0 {
            Ok(Self { tolerance: self.tolerance.max(1e-14), ..*self })
        } else {
            Err(InputError::new("tolerance", self.tolerance, "a number greater than 0 and less than 1"))
        }
    }
}

/// A boundary r = a(theta) about a centre.
#[derive(Debug, Clone, PartialEq)]
pub struct Boundary {
    /// The centre, units of length.
    pub centre: [f64; 2],
    /// (theta, a), theta in radians, ascending in [0, 2 pi); a in units of length.
    pub outline: Vec<[f64; 2]>,
}

impl Boundary {
    /// a(theta), theta in radians: exact at the points of the outline, on their chords in between.
    #[must_use]
    pub fn radius(&self, theta: f64) -> f64 {
        radius_in(&self.outline, theta)
    }

    /// The boundary as a polyline, counter-clockwise, not closed.
    #[must_use]
    pub fn polyline(&self) -> Vec<[f64; 2]> {
        let point = |&[theta, a]: &[f64; 2]| {
            let (sin, cos) = theta.sin_cos();
            [self.centre[0] + a * cos, self.centre[1] + a * sin]
        };
        self.outline.iter().map(point).collect()
    }
}

/// A rigorous lower bound of the force, from the exact flat-punch pressure of an ellipse. Only the Ritz method makes it.
///
/// Rigorous but for rounding and for the quadrature of the gap, whose error estimate is taken off.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct LowerBound(pub(crate) f64);

impl LowerBound {
    /// The bound, units of force.
    #[must_use]
    pub fn force(self) -> f64 {
        self.0
    }
}

/// What the approximate method found.
#[derive(Debug, Clone, PartialEq)]
pub struct Approximation {
    /// What ran.
    pub family: Family,
    /// Why it ran, when the choice was left to [`auto`]; empty otherwise.
    pub why: String,
    /// P, units of force.
    pub force: f64,
    /// dP/dd, force per length: the flat punch of this plan-form, 4 E* A/L (for an ellipse, the exact one).
    ///
    /// P(A) is stationary, so dP/dd is its derivative at fixed A. It is exact where the centre does not move with the
    /// depth; where the centroid wanders, the force depends on it to first order and this is an estimate
    /// (8e-4 low for one unsymmetric five-faced punch).
    pub stiffness: f64,
    /// D = P/(2E*), units of length squared (equation 15).
    pub d: f64,
    /// Largest G_aa over the boundary, units of length (the second variation); negative at a strict local maximum.
    /// For a family, the largest eigenvalue of its second variation, scaled likewise. `None` where no part is free.
    pub second_variation: Option<f64>,
    /// Largest |G_a - D|/D over the free boundary: how well equation (15) holds. For a family, of its own equations.
    pub residual: f64,
    /// Room left before the stationary boundary ceases to exist: least top of G_a over D, less 1; with its direction
    /// (radians). `None` for families.
    pub margin: Option<(f64, f64)>,
    /// The boundary.
    pub boundary: Boundary,
    /// Area A of the region.
    pub area: f64,
    /// Centroid of the region.
    pub centroid: [f64; 2],
    /// Estimated relative error of the force by quadrature: over the angle, and along the rays.
    pub quadrature_error: [f64; 2],
    /// Rays of the quadrature.
    pub rays: usize,
    /// Layouts of rays, and moves of the centre, that it took.
    pub iterations: usize,
    /// A rigorous lower bound, where there is one (ellipses).
    pub lower_bound: Option<LowerBound>,
}

/// The problem at the door: units taken off.
pub(crate) struct Problem<'a> {
    pub overlap: Overlap<'a>,
    pub e_star: f64,
    /// How far from the origin the overlap may reach, in units of length.
    pub reach: f64,
    /// Whether that had to be searched: the gap may hold surprises.
    pub searched: bool,
}

impl<'a> Problem<'a> {
    /// Unit of depth: the overlap at the centre. Unit of length: a mean reach of the overlap.
    pub fn new(gap: &'a dyn Gap, modulus: EffectiveModulus, depth: f64) -> Result<Self, Error> {
        finite("depth", depth)?;
        let apart = || Unsolved::new(Verdict::NotApplicable, format!("the bodies do not touch at depth {depth}"));
        let unbounded = || Unsolved::new(Verdict::Unbounded, "the gap stays below the depth as far as one looks");
        let reach = gap.reach(depth);
        let rect = match reach {
            Reach::Nowhere => return Err(apart().into()),
            Reach::Unbounded => return Err(unbounded().into()),
            Reach::Within(rect) => Some(rect),
            Reach::Unknown => None,
        };
        let mut origin = gap.centre();
        if !(depth > gap.gap(origin[0], origin[1])) {
            let step = rect.map_or(1.0, |r| 0.25 * r.size()[0].max(r.size()[1]));
            origin = lowest(gap, rect.map_or(origin, |r| r.centre()), step, depth).ok_or_else(apart)?;
        }
        let from_centre = (origin[0] - gap.centre()[0]).hypot(origin[1] - gap.centre()[1]);
        let unit = depth - gap.gap(origin[0], origin[1]);
        let (length, far) = match rect {
            Some(rect) => {
                let [w, h] = rect.size();
                let far = rect.corners().iter().map(|c| (c[0] - origin[0]).hypot(c[1] - origin[1])).fold(0.0, f64::max);
                (0.5 * w.sqrt() * h.sqrt(), far)
            }
            None => search_reach(gap, origin, depth)
                .map(|(mean, far)| (mean, 4.0 * far + 2.0 * from_centre))
                .ok_or_else(unbounded)?,
        };
        if !(unit.is_normal() && length.is_normal() && (unit * length).is_normal()) {
            return Err(InputError::new("depth", depth, "a depth at which force and contact can be represented").into());
        }
        let scaled = Scaled { gap, origin, length, depth: unit };
        Ok(Self {
            overlap: Overlap::new(scaled, depth / unit),
            e_star: modulus.e_star(),
            reach: far / length,
            searched: rect.is_none(),
        })
    }

    /// 2E* length depth: the unit of P for D.
    pub fn force_unit(&self) -> f64 {
        2.0 * self.e_star * self.overlap.gap.length * self.overlap.gap.depth
    }

    /// A boundary in the user's units.
    pub fn boundary(&self, centre: [f64; 2], outline: Vec<[f64; 2]>) -> Boundary {
        let length = self.overlap.gap.length;
        Boundary {
            centre: self.overlap.gap.outward(centre),
            outline: outline.into_iter().map(|[theta, a]| [theta, a * length]).collect(),
        }
    }
}

/// A point where the gap is less than `depth`, by a compass search from `from`.
fn lowest(gap: &dyn Gap, from: [f64; 2], step: f64, depth: f64) -> Option<[f64; 2]> {
    let (mut at, mut step, mut value) = (from, step, gap.gap(from[0], from[1]));
    for _ in 0..4000 {
        let around =
            [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0], [0.7, 0.7], [-0.7, 0.7], [-0.7, -0.7], [0.7, -0.7]]
                .map(|e: [f64; 2]| [at[0] + step * e[0], at[1] + step * e[1]]);
        let best = around.into_iter().map(|p| (gap.gap(p[0], p[1]), p)).min_by(|a, b| a.0.total_cmp(&b.0))?;
        if best.0 < value {
            (value, at) = best;
            step *= 1.5;
        } else {
            step *= 0.5;
        }
        if step < 1e-12 * (at[0].hypot(at[1]) + f64::MIN_POSITIVE) || step == 0.0 {
            break;
        }
    }
    (value < depth).then_some(at)
}

/// (mean reach, reach) of the overlap about `origin`, for a gap that does not know it: the radius at which the gap has
/// passed the depth in half of 16 directions, and in all. `None` when it never does in one of them.
fn search_reach(gap: &dyn Gap, origin: [f64; 2], depth: f64) -> Option<(f64, f64)> {
    let passed = |r: f64| {
        (0..16)
            .filter(|&k| {
                let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / 16.0).sin_cos();
                gap.gap(origin[0] + r * cos, origin[1] + r * sin) > depth
            })
            .count()
    };
    let mut r = 1.0;
    while passed(r) >= 8 {
        r *= 0.5;
        if r < 1e-90 {
            return None;
        }
    }
    while passed(r) < 8 {
        r *= 2.0;
        if r > 1e90 {
            return None;
        }
    }
    let (mean, mut far) = (r, r);
    while passed(far) < 16 {
        far *= 2.0;
        if far > 1e12 * mean {
            return None;
        }
    }
    Some((mean, far))
}

/// The stationary boundary, equation (15).
///
/// ```
/// use contact_patch::{EffectiveModulus, fabrikant, gap::Polyhedron};
/// let punch = Polyhedron::pyramid(3, 45f64.to_radians())?;
/// let modulus = EffectiveModulus::from_e_star(0.5)?; // mu/(1 - nu) = E*/2: force in the paper's group is P/(2 E*) * 4
/// let found = fabrikant::stationary(&punch, modulus, 1.0, &fabrikant::Settings::default())?;
/// assert!((found.force / 0.25 - 1.6960382).abs() < 1e-7); // (1 - nu) P tan(alpha)/(mu d^2), equation (20)
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// `NoStationaryBoundary` when D lies above the hump of G_a in some direction (elongated contacts), `NotStarShaped` when
/// the contact is in several parts, `Unbounded`, `IterationLimit`; an input error for a depth that is not finite.
pub fn stationary(
    gap: &dyn Gap,
    modulus: EffectiveModulus,
    depth: f64,
    settings: &Settings,
) -> Result<Approximation, Error> {
    let settings = settings.checked()?;
    let problem = Problem::new(gap, modulus, depth)?;
    let tolerance: f64 = settings.tolerance;
    let residual_allowed = (10.0 * tolerance).max(1e-13);
    let mut star = Star::about(&problem.overlap, [0.0; 2], 0.5, first_rung(tolerance));
    let mut iterations = 0;
    let (found, errors) = loop {
        let (found, moves) = star.centre((0.1 * tolerance).max(1e-13), |star| star.settle(residual_allowed))?;
        iterations += 1 + moves;
        let errors = star.errors(found.d);
        let lacking = found.tightest.1 < -10.0 * (errors[0] + errors[1]).max(1e-12);
        let done = errors[0] + errors[1] <= tolerance || iterations > 60;
        if lacking || done || !star.refine(errors, tolerance, found.d, settings.most_rays) {
            break (found, errors);
        }
    };
    let (angle, margin) = star.tightest(found.d);
    // A ray on which G_a = D holds has its root: only what exceeds the residual tells.
    if margin < -(2.0 * found.residual).max(1e-10) {
        return Err(no_boundary(angle, margin).into());
    }
    if let Some(angle) = star.second_part(problem.reach, problem.searched) {
        return Err(several_parts(angle).into());
    }
    let unit = problem.force_unit();
    let length = problem.overlap.gap.length;
    let free = |r: &&star::Ray| !(r.at_edge() && r.along.g_a >= found.d);
    let second = star.rays.iter().filter(free).map(|r| r.along.g_aa).reduce(f64::max);
    let (off, area) = star.centroid_and_area();
    let centroid = problem.overlap.gap.outward([star.centre[0] + off[0], star.centre[1] + off[1]]);
    let perimeter = star.sum(|r| r.a);
    let rays = star.rays.len();
    let centre = star.centre;
    let outline = star.trace(settings.boundary_points, found.d);
    Ok(Approximation {
        family: Family::Stationary,
        why: String::new(),
        force: unit * found.d,
        stiffness: 4.0 * modulus.e_star() * length * (area / perimeter),
        d: length * problem.overlap.gap.depth * found.d,
        second_variation: second.map(|s| s * problem.overlap.gap.depth),
        residual: found.residual,
        margin: Some((angle, margin)),
        boundary: problem.boundary(centre, outline),
        area: area * length * length,
        centroid,
        quadrature_error: errors,
        rays,
        iterations,
        lower_bound: None,
    })
}

/// Rung of the ladder of radial rules to start from.
pub(crate) fn first_rung(tolerance: f64) -> usize {
    usize::from(tolerance < 3e-5)
}

fn no_boundary(angle: f64, margin: f64) -> Unsolved {
    Unsolved::new(
        Verdict::NoStationaryBoundary,
        format!(
            "in the direction of {:.4} degrees G_a (equation 15) never exceeds D: its top is {:.4} % below",
            angle.to_degrees(),
            -100.0 * margin
        ),
    )
}

fn several_parts(angle: f64) -> Unsolved {
    Unsolved::new(
        Verdict::NotStarShaped,
        format!(
            "the bodies overlap again further out in the direction of {:.4} degrees: the contact may have several parts",
            angle.to_degrees()
        ),
    )
}

/// The boundary asked for: equation (15), or the best of a family.
///
/// # Errors
/// As [`stationary`]; `NoMaximum` when the force has no verified interior maximum within the family.
pub fn solve(
    gap: &dyn Gap,
    modulus: EffectiveModulus,
    depth: f64,
    family: Family,
    settings: &Settings,
) -> Result<Approximation, Error> {
    match family {
        Family::Stationary => stationary(gap, modulus, depth, settings),
        Family::Circle => crate::ritz::circle(gap, modulus, depth, settings),
        Family::Ellipse => crate::ritz::ellipse(gap, modulus, depth, settings),
        Family::Fourier(_) | Family::PlanForm => family::best(gap, modulus, depth, family, settings),
    }
}

/// The depth at which the force of `family` is `force`, and what was found there: Newton's method on log P over log d with
/// the stiffness that comes with every solve, one step and a check for a homogeneous gap.
///
/// ```
/// use contact_patch::{EffectiveModulus, fabrikant, gap::Cone};
/// let (cone, modulus) = (Cone::with_slope(1.0)?, EffectiveModulus::from_e_star(1.0)?);
/// let settings = fabrikant::Settings::default();
/// let (depth, _) = fabrikant::at_force(&cone, modulus, 4.0, fabrikant::Family::Stationary, &settings)?;
/// assert!((depth - (2.0 * std::f64::consts::PI).sqrt()).abs() < 1e-9); // P = 2 E* d^2/(pi tan(alpha))
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`solve`] at the depths tried; an input error for a force that is not greater than zero; `IterationLimit`.
pub fn at_force(
    gap: &dyn Gap,
    modulus: EffectiveModulus,
    force: f64,
    family: Family,
    settings: &Settings,
) -> Result<(f64, Approximation), Error> {
    let force = crate::error::positive("force", force)?;
    let allowed = settings.checked()?.tolerance.max(1e-13);
    // Depth over the gap at the centre, the reference from which the force grows.
    let [x, y] = gap.centre();
    let lowest = gap.gap(x, y);
    if !lowest.is_finite() {
        return Err(InputError::new("gap", lowest, "a finite gap at its centre").into());
    }
    let mut above = 1.0;
    for _ in 0..100 {
        let found = solve(gap, modulus, lowest + above, family, settings)?;
        if (found.force / force - 1.0).abs() <= allowed {
            return Ok((lowest + above, found));
        }
        // P ~ d^s locally, s = d P'/P (1 for a flat punch; kept sane where the estimate is poor).
        let slope = (above * found.stiffness / found.force).clamp(1.0, 12.0);
        above *= (force / found.force).powf(1.0 / slope);
    }
    Err(Unsolved::new(Verdict::IterationLimit, format!("no depth found for the force {force}")).into())
}

/// An approximate answer whenever there is one: the stationary boundary; else the first of Fourier series of order 4 and
/// 2 that has a verified maximum above the ellipse's lower bound; else the Ritz ellipse.
///
/// The result names what ran in `family` and the reasons in `why`.
///
/// ```
/// use contact_patch::{EffectiveModulus, fabrikant, gap::Paraboloid};
/// let modulus = EffectiveModulus::from_e_star(1.0)?;
/// let railway = Paraboloid::new([1000.0, 1.0])?;
/// let found = fabrikant::auto(&railway, modulus, 1e-3, &fabrikant::Settings::default())?;
/// assert!(found.family != fabrikant::Family::Stationary && !found.why.is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// When all of them fail, that of the ellipse; at once for bad input and for contacts in several parts.
pub fn auto(gap: &dyn Gap, modulus: EffectiveModulus, depth: f64, settings: &Settings) -> Result<Approximation, Error> {
    let refused = match stationary(gap, modulus, depth, settings) {
        Ok(found) => {
            return Ok(Approximation { why: "equation (15) has a stationary boundary".to_owned(), ..found });
        }
        Err(Error::Unsolved(unsolved))
            if !matches!(unsolved.verdict, Verdict::Unbounded | Verdict::NotStarShaped | Verdict::NotApplicable) =>
        {
            unsolved
        }
        Err(other) => return Err(other),
    };
    let ellipse = solve(gap, modulus, depth, Family::Ellipse, settings)?;
    let mut why = format!("no stationary boundary ({})", refused.reason);
    for order in [4, 2] {
        match solve(gap, modulus, depth, Family::Fourier(order), settings) {
            Ok(found) if found.force >= ellipse.force => {
                why += &format!("; the Fourier series of order {order} has a maximum, above the best ellipse");
                return Ok(Approximation { why, ..found });
            }
            Ok(_) => {
                why += &format!("; the Fourier series of order {order} stays below the best ellipse, a lower bound")
            }
            Err(error) => why += &format!("; Fourier series of order {order}: {error}"),
        }
    }
    why += "; hence the Ritz ellipse, a lower bound";
    Ok(Approximation { why, ..ellipse })
}

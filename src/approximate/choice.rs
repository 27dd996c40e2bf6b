//! Which boundary: the one asked for, the one for a force, or the best that there is.

use super::fabrikant::{Approximation, Error, Family, Settings, best, stationary};
use super::ritz;
use crate::error::InputError;
use crate::gap::{AnyGap, Gap, Paraboloid};
use crate::problem::EffectiveModulus;
use crate::solution::{Unsolved, Verdict};

/// The boundary asked for: equation (15), or the best of a family.
///
/// # Errors
/// As [`stationary`]; `NoMaximum` when the force has no verified interior maximum within the family; `TimeLimit`.
pub fn solve(
    gap: impl Into<AnyGap>,
    modulus: EffectiveModulus,
    depth: f64,
    family: Family,
    settings: &Settings,
) -> Result<Approximation, Error> {
    let gap = &gap.into();
    let found = match family {
        Family::Stationary => stationary(gap, modulus, depth, settings),
        Family::Circle => ritz::circle(gap, modulus, depth, settings),
        Family::Ellipse => ritz::ellipse(gap, modulus, depth, settings),
        Family::Fourier(_) | Family::PlanForm => best(gap, modulus, depth, family, settings),
    };
    // Cut short, it fails for one reason or another.
    found.map_err(|e| settings.deadline.check().map_or_else(|out_of_time| Unsolved::from(out_of_time).into(), |()| e))
}

/// The depth at which the force of `family` is `force`, and what was found there: Newton's method on log P over log d with
/// the stiffness that comes with every solve, one step and a check for a homogeneous gap.
///
/// ```
/// use contact_patch::{EffectiveModulus, approximate, fabrikant, gap::Cone};
/// let (cone, modulus) = (Cone::with_slope(1.0)?, EffectiveModulus::from_e_star(1.0)?);
/// let settings = fabrikant::Settings::default();
/// let (depth, _) = approximate::at_force(&cone, modulus, 4.0, fabrikant::Family::Stationary, &settings)?;
/// assert!((depth - (2.0 * std::f64::consts::PI).sqrt()).abs() < 1e-9); // P = 2 E* d^2/(pi tan(alpha))
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`solve`] at the depths tried; an input error for a force that is not greater than zero; `IterationLimit`.
pub fn at_force(
    gap: impl Into<AnyGap>,
    modulus: EffectiveModulus,
    force: f64,
    family: Family,
    settings: &Settings,
) -> Result<(f64, Approximation), Error> {
    let gap = &gap.into();
    let force = crate::error::positive("force", force)?;
    let allowed = settings.checked()?.tolerance.max(1e-13);
    // Depth over the gap at the centre, the reference from which the force grows.
    let [x, y] = gap.known().centre;
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

/// An approximate answer whenever there is one: the stationary boundary; else a Fourier series of order 4 or 2 that has a
/// verified maximum and whose gain over the best ellipse is more than its own error; else the Ritz ellipse.
///
/// Equation (10) is exact for ellipses, so that a series and the ellipse differ only in what the series gains by leaving
/// ellipses, and part of that gain is error: slender contacts tempt equation (12) away from ellipses even where the ellipse
/// is exact. How much, is known: it is the gain of the same series over Hertz's force for the paraboloid whose contact has
/// the axes of the best ellipse. A gain of more than four times that counts: of sixteen gaps against the fft method, two have a
/// series and no stationary boundary, and on both a gain below that was false.
///
/// The result names what ran in `family` and the reasons in `why`.
///
/// ```
/// use contact_patch::{EffectiveModulus, approximate, fabrikant, gap::Paraboloid};
/// let modulus = EffectiveModulus::from_e_star(1.0)?;
/// let railway = Paraboloid::new([1000.0, 1.0])?;
/// let found = approximate::auto(&railway, modulus, 1e-3, &fabrikant::Settings::default())?;
/// assert!(found.family == fabrikant::Family::Ellipse && !found.why.is_empty()); // Hertz's, and exact
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// When all of them fail, that of the ellipse; at once for bad input and for contacts in several parts.
pub fn auto(
    gap: impl Into<AnyGap>,
    modulus: EffectiveModulus,
    depth: f64,
    settings: &Settings,
) -> Result<Approximation, Error> {
    let gap = &gap.into();
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
    for order in ORDERS {
        let series = format!("; the Fourier series of order {order}");
        let gain = match solve(gap, modulus, depth, Family::Fourier(order), settings) {
            Ok(found) => (found.force / ellipse.force - 1.0, found),
            Err(error) => {
                why += &format!("{series}: {error}");
                continue;
            }
        };
        let (gain, found) = gain;
        if gain < 0.0 {
            why += &format!("{series} stays below the best ellipse, a lower bound");
            continue;
        }
        match gain_over_hertz(ellipse.axis_ratio(), order, settings) {
            Some(error) if gain > BELIEVED * error.abs() => {
                why += &format!(
                    "{series} gains {gain:.1e} over the best ellipse, where Hertz's problem makes it {error:.1e} wrong"
                );
                return Ok(Approximation { why, ..found });
            }
            Some(error) => {
                why += &format!(
                    "{series} gains {gain:.1e} over the best ellipse, but Hertz's problem makes it {error:.1e} wrong"
                );
            }
            None => why += &format!("{series} has no maximum for Hertz's problem with the best ellipse"),
        }
    }
    why += "; hence the Ritz ellipse, a lower bound";
    Ok(Approximation { why, ..ellipse })
}

/// How many times its own error for Hertz's problem a series has to gain.
const BELIEVED: f64 = 4.0;

/// Orders of the Fourier series that are tried, the better one first.
const ORDERS: [usize; 2] = [4, 2];

/// The relative error of a Fourier series for the paraboloid whose contact ellipse has this ratio of axes (at most 1).
fn gain_over_hertz(ratio: f64, order: usize, settings: &Settings) -> Option<f64> {
    let paraboloid = Paraboloid::new([1.0 / ritz::curvature_ratio(ratio), 1.0]).ok()?;
    let modulus = EffectiveModulus::from_e_star(1.0).ok()?;
    let settings = Settings { tolerance: settings.tolerance.max(1e-6), boundary_points: 0, ..*settings };
    let by = |family| solve(&paraboloid, modulus, 1.0, family, &settings).ok();
    Some(by(Family::Fourier(order))?.force / by(Family::Ellipse)?.force - 1.0)
}

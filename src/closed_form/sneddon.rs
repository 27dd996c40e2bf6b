//! Any gap of revolution whose contact is a disc, by quadrature (Sneddon 1965).
//!
//! ```text
//! D(s) = s int_0^{pi/2} g'(s sin t) dt,          d = D(a) (d > D(a) only at a sharp rim),
//! M(a) = a^2 int_0^{pi/2} sin^2 t g'(a sin t) dt = int_0^a (D(a) - D) ds,   P = 2 E* [M(a) + a (d - D(a))]
//! ```
//!
//! At fixed d the force is stationary in a, so that an error of a enters P squared.
//!
//! The contact is a disc when D grows up to a (then p >= 0) and stays above d beyond (then the gap outside is open):
//! h(r) = (2/pi) int_a^r (D(s) - d)/sqrt(r^2 - s^2) ds. Where this is not so, p and h are looked at themselves. All
//! three are sampled, so a wave of the generatrix shorter than a hundredth of the contact can pass unseen.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32};

use super::ClosedForm;
use super::disc_contact::DiscContact;
use super::generatrix::{Generatrix, Profile};
use crate::clock::Deadline;
use crate::error::InputError;
use crate::numeric::scalar::root;
use crate::problem::EffectiveModulus;
use crate::solution::{Unsolved, Verdict};

/// A gap of revolution, given by its slope g'(r) or by the gap itself.
#[derive(Debug, Clone)]
pub struct Sneddon {
    e_star: f64,
    generatrix: Arc<Generatrix>,
}

/// Radii at which a crossing is looked for.
const LOOKS: usize = 96;

/// Most kinks: the time grows with their square, to a third of a second.
const MOST_KINKS: usize = 200;

impl Sneddon {
    /// The gap with slope g'(r), r > 0. `kinks` are the radii at which the slope is not smooth; `radius` is where the
    /// body ends (infinity: it does not). g' may be singular at r = 0 like r^s, s > -1.
    ///
    /// ```
    /// use contact_patch::{EffectiveModulus, closed_form::Sneddon};
    /// let modulus = EffectiveModulus::from_e_star(1.0)?;
    /// // A cone with its tip cut off at r = 1.
    /// let cut = Sneddon::new(modulus, |r| if r < 1.0 { 0.0 } else { 1.0 }, &[1.0], f64::INFINITY)?;
    /// let contact = cut.at_depth(2.0943951023931955)?;
    /// assert!((contact.force / 5.9208410123552683 - 1.0).abs() < 1e-11);
    /// // A ring: the middle does not touch.
    /// let ring = Sneddon::new(modulus, |r| 8.0 * r * (r * r - 1.0), &[], f64::INFINITY)?;
    /// assert!(ring.at_depth(0.1).is_err());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// Names a kink that is not a finite number greater than zero, or the radius when it is not greater than zero; `kinks` when
    /// there are more than 200.
    pub fn new(
        modulus: EffectiveModulus,
        slope: impl Fn(f64) -> f64 + Send + Sync + 'static,
        kinks: &[f64],
        radius: f64,
    ) -> Result<Self, InputError> {
        Self::from_profile(modulus, Box::new(slope), true, kinks, radius)
    }

    /// The same from the gap g(r) itself. Its slope is integrated by parts away; about two digits are lost to
    /// cancellation (force about 1e-12 for a smooth gap).
    ///
    /// ```
    /// use contact_patch::{EffectiveModulus, closed_form::Sneddon};
    /// let modulus = EffectiveModulus::from_e_star(1.0)?;
    /// let quartic = Sneddon::of_gap(modulus, |r| r.powi(4), &[], f64::INFINITY)?.at_depth(1.0)?;
    /// assert!((quartic.force / 1.2520676640586299 - 1.0).abs() < 1e-11);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`Sneddon::new`].
    pub fn of_gap(
        modulus: EffectiveModulus,
        gap: impl Fn(f64) -> f64 + Send + Sync + 'static,
        kinks: &[f64],
        radius: f64,
    ) -> Result<Self, InputError> {
        Self::from_profile(modulus, Box::new(gap), false, kinks, radius)
    }

    /// The same, which gives up at the deadline: what is asked for later is NaN or an error, and a pressure that is not finite is
    /// none.
    #[must_use]
    pub fn before(self, deadline: Deadline) -> Self {
        self.with(|generatrix| generatrix.deadline = deadline)
    }

    /// The same where the undeformed bodies are known not to overlap beyond this radius: the slope is looked at no farther than that asks
    /// for, and may be beyond the range of numbers there.
    pub(crate) fn overlapping_within(self, radius: f64) -> Self {
        self.with(|generatrix| generatrix.overlap = radius)
    }

    /// Changes what no contact shares yet.
    fn with(mut self, change: impl FnOnce(&mut Generatrix)) -> Self {
        if let Some(generatrix) = Arc::get_mut(&mut self.generatrix) {
            change(generatrix);
        }
        self
    }

    fn from_profile(
        modulus: EffectiveModulus,
        profile: Profile,
        by_slope: bool,
        kinks: &[f64],
        radius: f64,
    ) -> Result<Self, InputError> {
        for (k, &kink) in kinks.iter().enumerate() {
            crate::error::positive(&format!("kinks[{k}]"), kink)?;
        }
        if radius.is_nan() || radius <= 0.0 {
            return Err(InputError::new("radius", radius, "a number greater than 0, or infinity"));
        }
        let mut kinks: Vec<f64> = kinks.iter().copied().filter(|&b| b < radius).collect();
        kinks.sort_by(f64::total_cmp);
        kinks.dedup();
        if kinks.len() > MOST_KINKS {
            return Err(InputError::new("kinks", format!("{} corners", kinks.len()), format!("at most {MOST_KINKS}")));
        }
        let generatrix = Arc::new(Generatrix {
            profile,
            by_slope,
            kinks,
            radius,
            overlap: f64::INFINITY,
            deadline: Deadline::NEVER,
            integrals: AtomicU32::new(0),
            is_late: AtomicBool::new(false),
        });
        Ok(Self { e_star: modulus.e_star(), generatrix })
    }

    /// The contact at depth d > 0, counted from where the point r = 0 touches.
    ///
    /// # Errors
    /// `NoClosedForm` when the contact is not a disc, `Unbounded` when it has no end, `NotApplicable` when the depth is
    /// not a finite number greater than zero or the slope is not finite.
    pub fn at_depth(&self, depth: f64) -> Result<ClosedForm, Unsolved> {
        checked("depth", depth)?;
        let g = &self.generatrix;
        self.solve(|a| g.abel(a).value - depth, |_, _| depth)
    }

    /// The contact under the force P > 0.
    ///
    /// # Errors
    /// As [`Sneddon::at_depth`].
    pub fn at_force(&self, force: f64) -> Result<ClosedForm, Unsolved> {
        checked("force", force)?;
        let (g, half) = (&self.generatrix, 0.5 * force / self.e_star);
        let solution = self.solve(|a| g.moment(a).value - half, |a, rim| (half - g.moment(a).value) / a + rim)?;
        Ok(ClosedForm { force, ..solution })
    }

    /// `excess(a)` is negative while the contact is larger than a; `depth(a, D(a))` is that of the contact a.
    fn solve(
        &self,
        mut excess: impl FnMut(f64) -> f64,
        depth: impl Fn(f64, f64) -> f64,
    ) -> Result<ClosedForm, Unsolved> {
        let g = &self.generatrix;
        let mut refused = None;
        for a in contacts(g, &mut excess)? {
            let at_rim = g.abel(a);
            let d = depth(a, at_rim.value);
            let moment = g.moment(a);
            let excess = if a < g.radius { (d - at_rim.value).max(0.0) } else { d - at_rim.value };
            let force = 2.0 * self.e_star * (moment.value + a * (d - at_rim.value));
            if !(d.is_finite() && d > 0.0 && force.is_finite() && force > 0.0) {
                continue;
            }
            let contact = DiscContact::new(Arc::clone(g), a, d, if a < g.radius { 0.0 } else { excess });
            if let Err(reason) = contact.is_disc() {
                refused = Some(reason);
                continue;
            }
            let error = (2.0 * self.e_star * (moment.error + a * at_rim.error) / force).max(super::ROUNDING);
            return Ok(ClosedForm { error, ..ClosedForm::disc(self.e_star, force, d, a, contact) });
        }
        let reason = refused.unwrap_or_else(|| "no disc about the axis carries this load".to_owned());
        Err(Unsolved::new(Verdict::NoClosedForm, reason))
    }
}

fn checked(name: &str, value: f64) -> Result<f64, Unsolved> {
    crate::error::positive(name, value).map_err(|e| Unsolved::new(Verdict::NotApplicable, e.to_string()))
}

/// Radii at which `excess` changes from negative to positive, and the rim where it never does: the candidates.
fn contacts(g: &Generatrix, excess: &mut impl FnMut(f64) -> f64) -> Result<Vec<f64>, Unsolved> {
    let not_finite = |r: f64| {
        let reason = format!("the generatrix is not a finite number somewhere within radius {r:e}");
        Unsolved::new(Verdict::NotApplicable, reason)
    };
    let mut look = |r: f64| match excess(r) {
        e if e.is_finite() => Ok(e),
        // Past a vertical wall D is infinite: as good as any large number.
        e if e == f64::INFINITY => Ok(f64::MAX),
        _ => Err(not_finite(r)),
    };
    // A radius beyond the contact, then one within, then both closer than a factor of two.
    let start = if g.radius.is_finite() { g.radius } else { g.kinks.last().copied().unwrap_or(1.0) };
    let mut high = start;
    if look(high)? <= 0.0 {
        if g.radius.is_finite() {
            return Ok(vec![g.radius]);
        }
        let mut factor = 2.0;
        while look(high)? <= 0.0 {
            let within = high < g.overlap && g.overlap < high * factor;
            high = if within { g.overlap } else { high * factor };
            factor = (factor * factor).min(1e6);
            if high > 1e200 {
                let reason = "the gap does not grow enough to end the contact";
                return Err(Unsolved::new(Verdict::Unbounded, reason));
            }
        }
    }
    let mut low = 0.5 * high;
    let mut factor = 2.0;
    while look(low)? > 0.0 {
        high = low;
        low /= factor;
        factor = (factor * factor).min(1e6);
        if low < 1e-200 {
            return Err(Unsolved::new(Verdict::NoClosedForm, "the contact does not begin at the axis"));
        }
    }
    while high > 2.0 * low {
        // Of products near the end of the range of numbers nothing would be left.
        let middle = low.sqrt() * high.sqrt();
        if !(low < middle && middle < high) {
            break;
        }
        if look(middle)? > 0.0 { high = middle } else { low = middle }
    }
    // Every crossing between an eighth and eight times this one: more than one only if the contact was a ring once.
    let first = root(|a| look(a).unwrap_or(f64::NAN), low, high).map_or(high, |found| found.at);
    let mut all = vec![first];
    let end = (8.0 * first).min(g.radius);
    let mut before = (0.125 * first, look(0.125 * first)?);
    for k in 1..=LOOKS {
        let r = 0.125 * first * (end / (0.125 * first)).powf(k as f64 / LOOKS as f64);
        let Ok(here) = look(r.min(g.radius)).map(|excess| (r, excess)) else {
            // Nothing is known that far out.
            break;
        };
        if before.1 < 0.0 && here.1 > 0.0 && !(before.0 <= first && first <= here.0) {
            let found = root(|a| look(a).unwrap_or(f64::NAN), before.0, here.0);
            all.extend(found.map(|found| found.at));
        }
        before = here;
    }
    if before.1 <= 0.0 && g.radius <= 8.0 * first {
        all.push(g.radius);
    }
    Ok(all)
}

//! A gap under a load: where the undeformed bodies overlap, found once for a state and handed to every method.
//!
//! `Overlap` asks the gap first; what follows from its construction is *certain*. Only where the gap cannot tell (a closure) is it
//! searched, and then marked as sampled: good enough to choose a grid, never enough for a number, an error or a proof.

mod components;
mod descent;
mod search;
mod units;

use std::sync::OnceLock;

use crate::gap::{AnyGap, Degree, Gap, Known, Minimum, Reach, enclosure, lattice};
use crate::grid::Grid;
use crate::numeric::geometry::Rect;
use crate::solution::{Unsolved, Verdict};
pub(crate) use descent::least;
pub(crate) use units::{Scaled, Units};

/// {f > 0} of a gap at a depth, f = depth - gap.
#[derive(Debug)]
pub(crate) struct Overlap {
    /// The gap, tilted where the body is.
    pub gap: AnyGap,
    /// The depth.
    pub depth: f64,
    /// A rectangle that holds {f > 0}.
    pub reach: Rect,
    /// Whether that follows from the construction of the gap.
    pub certain: bool,
    /// f at the deepest point that is known or was seen; the unit of heights.
    pub deepest: f64,
    components: OnceLock<Vec<Rect>>,
    known_components: OnceLock<Option<Vec<Rect>>>,
    filled: OnceLock<bool>,
}

/// The gap without those of several tips that do not reach so deep, and without an end of the material beyond all that overlaps: all that is
/// asked there is a displacement above f, which is negative.
pub(crate) fn touching(gap: &AnyGap, depth: f64) -> AnyGap {
    let endless = |gap: &AnyGap| gap.without_end(depth).unwrap_or_else(|| gap.clone());
    let Some(parts) = gap.alternatives() else { return endless(gap) };
    let kept: Vec<&AnyGap> = parts.iter().filter(|part| part.reach(depth) != Reach::Nowhere).collect();
    match Minimum::of_kept(&kept, parts.len()) {
        Some(one) if kept.len() == 1 => endless(&one),
        several => several.unwrap_or_else(|| gap.clone()),
    }
}

/// Whether [`touching`] is the same gap at both depths.
pub(crate) fn touches_alike(gap: &AnyGap, depths: [f64; 2]) -> bool {
    let ends_alike = |gap: &AnyGap| {
        let [a, b] = depths.map(|depth| gap.without_end(depth).is_some());
        a == b
    };
    let Some(parts) = gap.alternatives() else { return ends_alike(gap) };
    parts.iter().all(|part| {
        let [a, b] = depths.map(|depth| part.reach(depth) != Reach::Nowhere);
        a == b && ends_alike(part)
    })
}

/// Points a side at which the deepest overlap is looked for.
const LOOKS: usize = 33;

/// Points a side at which it is looked at whether {f > 0} fills its box.
const FILLING: usize = 32;

/// What fills this share of its box is one component.
const FULL: f64 = 0.3;

impl Overlap {
    /// The overlap of a gap at a depth; `None` when the bodies do not touch.
    ///
    /// # Errors
    /// `Unbounded` when the overlap has no end, with the direction in which it has none.
    pub fn of(gap: &AnyGap, depth: f64) -> Result<Option<Self>, Unsolved> {
        let gap = &touching(gap, depth);
        let certain = gap.reach(depth);
        let found = known_or_searched(certain, gap, depth);
        let reach = match found {
            Reach::Within(rect) => rect,
            Reach::Nowhere => return Ok(None),
            Reach::Unbounded { from, along } if certain != Reach::Unknown => return Err(endless(depth, from, along)),
            Reach::Unbounded { along, .. } if gap.known().recurs_along.is_some() => return Err(row(depth, along)),
            _ => {
                let reason = format!(
                    "the gap stays below the depth {depth:e} however far it was followed: the contact has no end"
                );
                return Err(Unsolved::new(Verdict::Unbounded, reason).with_hint(ENDED));
            }
        };
        let certain = certain != Reach::Unknown;
        let [w, h] = reach.size();
        if !(w.max(h) > 0.0) {
            return Ok(None);
        }
        let deepest = depth - lowest(gap, depth, &reach);
        // No point of the lattice overlaps: find one that does, or prove that there is none.
        let deepest = if deepest > 0.0 {
            deepest
        } else {
            match enclosure::least(gap, &reach, 0.0, depth) {
                Some(found) if found.value < depth => depth - found.value,
                Some(found) if found.bound >= depth => return Ok(None),
                None => return Ok(None),
                Some(_) => {
                    let reason = format!("whether the bodies touch at depth {depth:e} is not to be told from rounding");
                    return Err(Unsolved::new(Verdict::NotApplicable, reason));
                }
            }
        };
        Ok(Some(Self {
            gap: gap.clone(),
            depth,
            reach,
            certain,
            deepest,
            components: OnceLock::new(),
            known_components: OnceLock::new(),
            filled: OnceLock::new(),
        }))
    }

    /// What is known of the gap at no depth in particular.
    pub fn known(&self) -> &Known {
        self.gap.known()
    }

    /// Rectangles around the parts of {f > 0} that lie at least half the side of either from one another, a needle a tenth; one when there
    /// is but one.
    pub fn components(&self) -> &[Rect] {
        self.components.get_or_init(|| {
            if self.is_connected() {
                return vec![self.reach];
            }
            let known = || self.known_components().map(<[Rect]>::to_vec);
            let seen = || search::pieces(&|x, y| self.gap.gap(x, y), self.depth, self.known().centre);
            let pieces = if self.fills_its_box() { None } else { known().or_else(seen) };
            let pieces = pieces.map(|pieces| components::merged(pieces, components::APART));
            pieces.filter(|pieces| !pieces.is_empty()).unwrap_or_else(|| vec![self.reach])
        })
    }

    /// Whether {f > 0} is known to be one piece, or rings about one axis: by a law it is a star about the centre, and ellipses are convex.
    fn is_connected(&self) -> bool {
        let known = self.known();
        let shrinks = known.law.is_some_and(|law| matches!(law.degree, Degree::Power(_)));
        shrinks || known.quadratic.is_some() || known.axis.is_some()
    }

    /// Whether so much of the rectangle around {f > 0} is filled that it is taken to be one component.
    pub fn fills_its_box(&self) -> bool {
        *self.filled.get_or_init(|| {
            let lattice = Grid::over(&self.reach, [FILLING; 2]);
            let enough = (FULL * lattice.len() as f64) as usize;
            lattice::values(&self.gap, &lattice).iter().filter(|&&g| g < self.depth).count() > enough
        })
    }

    /// What follows from the construction of the gap, which may cost much.
    fn known_components(&self) -> Option<&[Rect]> {
        self.known_components.get_or_init(|| self.gap.components(self.depth)).as_deref()
    }

    /// The components that are known to lie at least a tenth of the longer side of either from one another; `None` where that is one.
    pub fn closer_components(&self) -> Option<Vec<Rect>> {
        let known = self.known_components()?.to_vec();
        Some(components::merged(known, components::NEAR)).filter(|pieces| pieces.len() > 1)
    }

    /// Whether a component is so small that the cells of one grid over all of them may miss it.
    pub fn has_needles(&self) -> bool {
        let all = self.reach.longer_side();
        self.components().iter().any(|piece| components::is_needle(piece, all))
    }
}

/// Where a gap is less than a depth: what follows from its construction, or where it cannot tell, what a search finds; never
/// [`Reach::Unknown`].
///
/// ```
/// use contact_patch::{gap::Reach, overlap::extent};
/// let ball = |x: f64, y: f64| 0.5 * ((x - 3.0).powi(2) + y * y);
/// let Reach::Within(rect) = extent(&ball, 1e-6) else { panic!("bounded") };
/// assert!((rect.min[0] - (3.0 - 2e-6f64.sqrt())).abs() < 1e-5);
/// assert!(matches!(extent(&|x: f64, _: f64| x * x, 1.0), Reach::Unbounded { .. }));
/// ```
#[must_use]
pub fn extent(gap: impl Into<AnyGap>, depth: f64) -> Reach {
    reach_of(&gap.into(), depth)
}

pub(crate) fn reach_of(gap: &AnyGap, depth: f64) -> Reach {
    known_or_searched(gap.reach(depth), gap, depth)
}

fn known_or_searched(known: Reach, gap: &AnyGap, depth: f64) -> Reach {
    let (values, centre) = (|x: f64, y: f64| gap.gap(x, y), gap.known().centre);
    match (known, gap.known().recurs_along) {
        (Reach::Unknown, Some(along)) => match search::first_seed(&values, depth, centre) {
            Some(from) => Reach::Unbounded { from, along },
            None => Reach::Nowhere,
        },
        (Reach::Unknown, None) => search::search(&values, depth, centre),
        (known, _) => known,
    }
}

fn endless(depth: f64, [x, y]: [f64; 2], along: f64) -> Unsolved {
    let degrees = along.to_degrees();
    let reason = format!(
        "at depth {depth:e} the undeformed bodies overlap without end along the ray from ({x:.3e}, {y:.3e}) in the direction of {degrees:.1} degrees: \
         the contact is as long as one looks, and so is its force. So it is with line contacts: cylinders, wedges of two faces, \
         extruded profiles"
    );
    Unsolved::new(Verdict::Unbounded, reason).with_hint(ENDED)
}

/// A row of waves that overlap.
fn row(depth: f64, along: f64) -> Unsolved {
    let degrees = along.to_degrees();
    let reason = format!(
        "at depth {depth:e} the undeformed bodies overlap again and again, without end, in the direction of {degrees:.1} degrees: the gap is made of \
         waves there, a row of contacts as long as one looks, and so is its force"
    );
    Unsolved::new(Verdict::Unbounded, reason).with_hint(ENDED)
}

/// What gives a contact without an end one.
const ENDED: &str = "give it an end: a curvature along the line (a second radius of a paraboloid, \"radius\" of a profile), a \"region\" of a \
                     formula, or a \"sum\" with a body that ends (a cylinder of length L is a \"formula\" with a \"region\")";

/// The least gap: that of the centre where it is known to be the lowest point, else the least on a lattice over the reach.
fn lowest(gap: &AnyGap, depth: f64, reach: &Rect) -> f64 {
    let known = gap.known();
    let [x, y] = known.centre;
    let low = gap.gap(x, y);
    if low - known.floor <= 1e-9 * (depth - low) {
        return low;
    }
    let lattice = lattice::values(gap, &Grid::over(reach, [LOOKS; 2]));
    let tips = known.tips.iter().filter(|&&tip| reach.contains(tip)).take(LOOKS).map(|[x, y]| gap.gap(*x, *y));
    lattice.into_iter().chain(tips).filter(|g| !g.is_nan()).fold(low, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gap::{Minimum, Paraboloid, Place, Sphere, Sum};

    fn tips(at: &[[f64; 2]]) -> AnyGap {
        let tip = |&p: &[f64; 2]| Paraboloid::new([0.5, 0.5]).unwrap().placed(p, 0.0).unwrap();
        AnyGap::new(Minimum::new(at.iter().map(tip).collect()).unwrap())
    }

    fn count(gap: &AnyGap, depth: f64) -> usize {
        Overlap::of(gap, depth).unwrap().unwrap().components().len()
    }

    #[test]
    fn tips_are_told_apart_from_two_radii_to_a_million() {
        for far in [4.0, 30.0, 1e6] {
            let gap = tips(&[[0.0, 0.0], [far, 0.0], [0.0, far]]);
            assert_eq!(count(&gap, 1.0), 3, "{far}");
            // Inside a sum nothing is lost.
            let ball = AnyGap::new(Sphere::new(1e9 * far).unwrap());
            let sum = AnyGap::new(Sum::new(vec![gap.clone(), ball]).unwrap());
            assert_eq!(count(&sum, 1.0), 3, "{far} in a sum");
            let own = gap.clone();
            let formula = AnyGap::new(move |x: f64, y: f64| own.gap(x, y));
            assert!(far > 1e3 || count(&formula, 1.0) == 3, "{far} by its values");
        }
        assert_eq!(count(&tips(&[[0.0, 0.0], [2.5, 0.0]]), 1.0), 1);
    }

    #[test]
    fn one_slender_contact_is_one() {
        let turned = Paraboloid::new([1e4, 1.0]).unwrap().placed([3.0, 1.0], 0.7).unwrap();
        assert_eq!(count(&turned, 1.0), 1);
    }

    #[test]
    fn a_searched_reach_is_not_certain() {
        let gap = AnyGap::new(|x: f64, y: f64| x * x + y * y);
        assert!(!Overlap::of(&gap, 1.0).unwrap().unwrap().certain);
        let named = AnyGap::new(Paraboloid::new([0.5; 2]).unwrap());
        assert!(Overlap::of(&named, 1.0).unwrap().unwrap().certain);
    }
}

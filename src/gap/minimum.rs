//! A punch with several tips: the least of several gaps.

use super::left_open::joined;
use super::of_parts::{common_axis, common_mirrors, drawn_along, tips_of};
use super::{AnyGap, Cubic, Gap, Generatrix, Growth, Known, LeftOpen, Material, Reach, Taylor, enclosure};
use crate::error::InputError;
use crate::numeric::Interval;
use crate::numeric::geometry::Rect;
use crate::numeric::scalar::bisected;

/// More parts than this are refused.
const MOST_PARTS: usize = 100_000;

/// Where parts lie further away than this, it is not looked at where another becomes the least: a thousand times as far is a number still.
const FARTHEST: f64 = 1e300;

/// Parts that lie closer together count as being in one place.
const NEAREST: f64 = 1e-290;

/// The least of several gaps: a punch with several tips.
///
/// ```
/// use contact_patch::gap::{Gap, Minimum, Place, Sphere};
/// let tip = |x: f64| Sphere::new(1e-3)?.placed([x, 0.0], 0.0);
/// let punch = Minimum::new(vec![tip(-5e-4)?, tip(5e-4)?])?;
/// assert_eq!(punch.gap(-5e-4, 0.0), 0.0);
/// assert_eq!(punch.gap(5e-4, 0.0), 0.0);
/// # Ok::<(), contact_patch::InputError>(())
/// ```
#[derive(Clone)]
pub struct Minimum {
    /// None of them a minimum itself.
    parts: Vec<AnyGap>,
    known: Known,
}

impl Minimum {
    /// The least of these gaps.
    ///
    /// # Errors
    /// Names `of` when there are none, or more than 100 000.
    pub fn new(parts: Vec<AnyGap>) -> Result<Self, InputError> {
        if parts.is_empty() {
            return Err(InputError::new("of", "an empty list", "at least one gap"));
        }
        let mut flat = Vec::with_capacity(parts.len());
        for part in parts {
            match part.alternatives() {
                Some(inner) => flat.extend(inner),
                None => flat.push(part),
            }
        }
        if flat.len() > MOST_PARTS {
            let given = format!("{} gaps", flat.len());
            return Err(InputError::new("of", given, format!("at most {MOST_PARTS} gaps, nested ones counted")));
        }
        let known = known_of(&flat);
        Ok(Self { parts: flat, known })
    }

    /// The least of those that are kept of so many parts, where that is simpler: one alone, or at most half of them.
    pub(crate) fn of_kept(kept: &[&AnyGap], parts: usize) -> Option<AnyGap> {
        match kept {
            [one] => Some((*one).clone()),
            several if 2 * several.len() <= parts => {
                Self::new(several.iter().map(|&part| part.clone()).collect()).ok().map(AnyGap::new)
            }
            _ => None,
        }
    }

    /// The gaps of which the least counts; those of a minimum among them are named one by one.
    #[must_use]
    pub fn parts(&self) -> &[AnyGap] {
        &self.parts
    }

    /// Index of the least part; the first of equals.
    fn least(&self, [x, y]: [f64; 2]) -> usize {
        let mut least = (0, f64::INFINITY);
        for (k, part) in self.parts.iter().enumerate() {
            let value = part.gap(x, y);
            if value < least.1 {
                least = (k, value);
            }
        }
        least.0
    }

    /// The parts that can be the least somewhere in a rectangle: those that are not above another one all over it.
    fn candidates(&self, rect: &Rect) -> Vec<&AnyGap> {
        let bounds: Vec<Option<[f64; 2]>> = self.parts.iter().map(|part| part.bounds(rect, [0.0; 2])).collect();
        let highest = bounds.iter().flatten().map(|b| b[1]).fold(f64::INFINITY, f64::min);
        let mut kept: Vec<&AnyGap> = Vec::new();
        for (part, bounds) in self.parts.iter().zip(&bounds) {
            // Of two that are the same throughout the first is enough.
            if bounds.is_none_or(|b| b[0] <= highest) {
                kept.push(part);
            }
        }
        kept
    }
}

/// What follows from the parts.
fn known_of(parts: &[AnyGap]) -> Known {
    if let [one] = parts {
        return one.known().clone();
    }
    let all = || parts.iter().map(AnyGap::known);
    let value = |known: &Known| {
        let [x, y] = known.centre;
        parts.iter().map(|part| part.gap(x, y)).fold(f64::INFINITY, f64::min)
    };
    // Many tips: each its own value is enough to choose one to start from.
    let own = |part: &AnyGap| part.gap(part.known().centre[0], part.known().centre[1]);
    let lowest = if parts.len() <= 64 {
        all().min_by(|a, b| value(a).total_cmp(&value(b)))
    } else {
        parts.iter().min_by(|a, b| own(a).total_cmp(&own(b))).map(AnyGap::known)
    };
    let centre = lowest.map_or([0.0; 2], |known| known.centre);
    let common = all().all(|k| k.centre == centre);
    let law = all().map(|k| k.law).reduce(|a, b| a.zip(b).filter(|(a, b)| a == b).map(|(a, _)| a)).flatten();
    let material = all().map(|k| k.material).reduce(|a, b| match (a, b) {
        (Material::Within(a), Material::Within(b)) => Material::Within(a.union(&b)),
        (Material::Everywhere, Material::Everywhere) => Material::Everywhere,
        // Where one ends and another does not, the gap jumps.
        _ => Material::Unknown,
    });
    Known {
        centre,
        reference: [0.0; 2],
        tips: parts.iter().flat_map(tips_of).collect(),
        floor: all().map(|k| k.floor).fold(f64::INFINITY, f64::min),
        law: law.filter(|law| common && law.degree.inverse() > 0.0),
        quadratic: None,
        axis: common_axis(parts, &mut |_, _| Generatrix::General),
        face: None,
        crown: None,
        material: material.unwrap_or(Material::Unknown),
        mirrors: common_mirrors(parts, centre),
        recurs_along: None,
        ends: None,
        drawn_along: drawn_along(parts),
    }
}

#[warn(clippy::missing_trait_methods)]
impl Gap for Minimum {
    fn gap(&self, x: f64, y: f64) -> f64 {
        let least = |low: f64, value: f64| if value.is_nan() || low.is_nan() { f64::NAN } else { low.min(value) };
        self.parts.iter().map(|part| part.gap(x, y)).fold(f64::INFINITY, least)
    }

    fn gaps(&self, points: &[[f64; 2]], to: &mut [f64]) {
        super::one_by_one(self, points, to);
    }

    fn gradient(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        self.parts[self.least([x, y])].gradient(x, y)
    }

    fn describe(&self) -> Known {
        self.known.clone()
    }

    fn reach(&self, depth: f64) -> Reach {
        let mut all = Reach::Nowhere;
        for part in &self.parts {
            all = match (all, part.reach(depth)) {
                (unbounded @ Reach::Unbounded { .. }, _) | (_, unbounded @ Reach::Unbounded { .. }) => {
                    return unbounded;
                }
                (Reach::Within(a), Reach::Within(b)) => Reach::Within(a.union(&b)),
                (known, Reach::Nowhere) => known,
                (Reach::Nowhere, first) => first,
                _ => Reach::Unknown,
            };
        }
        all
    }

    fn components(&self, depth: f64) -> Option<Vec<Rect>> {
        let pieces: Option<Vec<Vec<Rect>>> = self.parts.iter().map(|part| part.components(depth)).collect();
        pieces.map(|pieces| pieces.into_iter().flatten().collect())
    }

    fn mean(&self, cell: &Rect) -> f64 {
        match self.candidates(cell).as_slice() {
            [one] => one.mean(cell),
            several => super::mean::by_quadrature(
                |x, y| several.iter().map(|part| part.gap(x, y)).fold(f64::INFINITY, f64::min),
                cell,
            ),
        }
    }

    fn bounds(&self, rect: &Rect, slope: [f64; 2]) -> Option<[f64; 2]> {
        self.parts.iter().try_fold([f64::INFINITY; 2], |[low, high], part| {
            part.bounds(rect, slope).map(|[a, b]| [low.min(a), high.min(b)])
        })
    }

    fn taylor(&self, rect: &Rect) -> Option<Taylor> {
        match self.candidates(rect).as_slice() {
            [one] => one.taylor(rect),
            _ => None,
        }
    }

    fn cubic(&self, rect: &Rect) -> Option<Cubic> {
        match self.candidates(rect).as_slice() {
            [one] => one.cubic(rect),
            _ => None,
        }
    }

    fn slopes(&self, rect: &Rect) -> Option<[Interval; 2]> {
        let mut parts = self.candidates(rect).into_iter().map(|part| part.slopes(rect));
        let first = parts.next()??;
        parts.try_fold(first, |all, part| part.map(|part| [all[0].union(part[0]), all[1].union(part[1])]))
    }

    fn mean_bounds(&self, rect: &Rect) -> Option<[f64; 2]> {
        match self.candidates(rect).as_slice() {
            [one] => one.mean_bounds(rect),
            _ => enclosure::mean(self, rect),
        }
    }

    fn growth(&self, sector: Interval, from: f64) -> Option<Growth> {
        let parts: Option<Vec<Growth>> = self.parts.iter().map(|part| part.growth(sector, from)).collect();
        let parts = parts?;
        // Where a part has no material the others count.
        let lasting = parts.iter().filter(|part| !part.is_ended()).copied().reduce(|a, b| a.lesser(&b));
        lasting.or_else(|| parts.first().copied())
    }

    fn is_measured(&self) -> bool {
        self.parts.iter().any(Gap::is_measured)
    }

    fn sampling_error(&self, rect: &Rect) -> f64 {
        self.parts.iter().map(|part| part.sampling_error(rect)).fold(0.0, f64::max)
    }

    fn left_open(&self, places: &[Rect]) -> Vec<LeftOpen> {
        joined(&self.parts, places, LeftOpen::larger)
    }

    fn restricted(&self, rect: &Rect) -> Option<AnyGap> {
        let kept = self.candidates(rect);
        match kept.as_slice() {
            [one] => Some(one.restricted(rect).unwrap_or_else(|| (*one).clone())),
            several => Self::of_kept(several, self.parts.len()),
        }
    }

    fn is_composed(&self) -> bool {
        true
    }

    fn addends(&self) -> Option<Vec<AnyGap>> {
        None
    }

    fn terms(&self) -> Option<Vec<AnyGap>> {
        None
    }

    fn without_end(&self, _depth: f64) -> Option<AnyGap> {
        None
    }

    fn alternatives(&self) -> Option<Vec<AnyGap>> {
        Some(self.parts.clone())
    }

    fn ray_kinks(&self, from: [f64; 2], direction: [f64; 2], kinks: &mut Vec<f64>) {
        self.parts.iter().for_each(|part| part.ray_kinks(from, direction, kinks));
        // Where another part becomes the least: sampled evenly as far as the parts lie and in magnitudes beyond.
        let at = |r: f64| [from[0] + r * direction[0], from[1] + r * direction[1]];
        let distance = |part: &AnyGap| (part.known().centre[0] - from[0]).hypot(part.known().centre[1] - from[1]);
        let far = self.parts.iter().map(distance).fold(0.0, f64::max).min(FARTHEST);
        // Parts of it would be below the range of numbers.
        let far = if far < NEAREST { 0.0 } else { far };
        let (unit, decades) = if far > 0.0 { (far, 9) } else { (1.0, 24) };
        let (step, last) = (10f64.powf(1.0 / 12.0), unit * 1e3);
        let (mut power, mut even) = (last * 10f64.powi(-decades), 1.0);
        // The place before, and the least part there.
        let mut last_seen: Option<(f64, usize)> = None;
        while power <= 1.0001 * last {
            // Both sequences in one, ascending.
            let next = if even <= 96.0 { (even / 48.0 * far).min(power) } else { power };
            if next == power {
                power *= step;
            } else {
                even += 1.0;
            }
            let least = self.least(at(next));
            let seen = last_seen.replace((next, least)).filter(|seen| seen.1 != least);
            let Some((place, before)) = seen else { continue };
            kinks.push(bisected(|r| self.least(at(r)) == before, [place, next], 60)[1]);
        }
    }

    fn kink_directions(&self, from: [f64; 2], angles: &mut Vec<f64>) {
        self.parts.iter().for_each(|part| part.kink_directions(from, angles));
        // On the line where two parts meet: along it, both ways.
        let first = &self.parts[self.least(from)];
        let low = first.gap(from[0], from[1]);
        for part in &self.parts {
            let level = part.gap(from[0], from[1]) <= low + 1e-12 * low.abs();
            let (Some(a), Some(b)) = (first.gradient(from[0], from[1]), part.gradient(from[0], from[1])) else {
                continue;
            };
            let across = [b[0] - a[0], b[1] - a[1]];
            if level && across != [0.0; 2] {
                angles.push(across[0].atan2(-across[1]));
                angles.push((-across[0]).atan2(across[1]));
            }
        }
    }

    fn ridges(&self) -> Option<super::Ridges> {
        None
    }

    fn end_of_data(&self, x: f64, y: f64) -> Option<super::DataEdge> {
        let none = |part: &AnyGap| part.gap(x, y) == f64::INFINITY;
        if self.parts.iter().all(none) { self.parts.iter().find_map(|part| part.end_of_data(x, y)) } else { None }
    }

    fn nodes(&self) -> Option<crate::grid::Grid> {
        self.parts.iter().find_map(Gap::nodes)
    }

    fn planes(&self) -> Option<Vec<[f64; 3]>> {
        None
    }

    fn into_any(self) -> AnyGap {
        // The least of one gap is that gap.
        match <[AnyGap; 1]>::try_from(self.parts) {
            Ok([one]) => one,
            Err(parts) => AnyGap::of(std::sync::Arc::new(Self { parts, known: self.known })),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gap::{Paraboloid, Place};

    #[test]
    fn two_tips_meet_half_way() {
        let tip = |x: f64| Paraboloid::new([1.0; 2]).unwrap().placed([x, 0.0], 0.0).unwrap();
        let tips = Minimum::new(vec![tip(-1.0), tip(3.0)]).unwrap();
        let mut kinks = Vec::new();
        tips.ray_kinks([-1.0, 0.0], [1.0, 0.0], &mut kinks);
        assert_eq!(kinks.len(), 1);
        assert!((kinks[0] - 2.0).abs() < 1e-12, "{kinks:?}");
        assert!(
            matches!(tips.reach(0.02), Reach::Within(r) if (r.min[0] + 1.2).abs() < 1e-12 && (r.max[0] - 3.2).abs() < 1e-12)
        );
        let mut angles = Vec::new();
        tips.kink_directions([1.0, 0.0], &mut angles);
        assert!(angles.iter().any(|a| (a - 0.5 * std::f64::consts::PI).abs() < 1e-12), "{angles:?}");
    }

    #[test]
    fn nested_minima_are_one() {
        let tip = |x: f64| Paraboloid::new([1.0; 2]).unwrap().placed([x, 0.0], 0.0).unwrap();
        let mut nested = AnyGap::new(Minimum::new(vec![tip(0.0), tip(1.0)]).unwrap());
        for k in 2..60 {
            let moved = nested.placed([1.0, 0.0], 0.3).unwrap();
            nested = AnyGap::new(Minimum::new(vec![moved, tip(f64::from(k))]).unwrap());
        }
        assert_eq!(nested.alternatives().map(|parts| parts.len()), Some(60));
        assert_eq!(nested.known().floor, 0.0);
        assert!(Minimum::new(Vec::new()).is_err());
    }
}

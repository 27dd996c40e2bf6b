//! Two curved bodies: the sum of several gaps.

use super::left_open::joined;
use super::of_parts::{common_axis, common_mirrors, drawn_along, tips_of};
use super::{
    AnyGap, Crown, Cubic, Degree, Face, Gap, Generatrix, Growth, Known, Law, LeftOpen, Material, Quadratic, Reach,
    Taylor, enclosure, growth,
};
use crate::error::InputError;
use crate::numeric::Interval;
use crate::numeric::geometry::Rect;

/// The sum of several gaps: two curved bodies, each turned its own way, against each other.
///
/// ```
/// use contact_patch::gap::{AnyGap, Gap, Paraboloid, Place, Sum};
/// // Two cylinders of radii 0.02 and 0.05 with axes at right angles.
/// let one = Paraboloid::new([0.02, f64::INFINITY])?;
/// let other = Paraboloid::new([0.05, f64::INFINITY])?.placed([0.0, 0.0], 90f64.to_radians())?;
/// let crossed = Sum::new(vec![AnyGap::new(one), other])?;
/// assert_eq!(crossed.gap(1e-3, 2e-3), Paraboloid::new([0.02, 0.05])?.gap(1e-3, 2e-3));
/// # Ok::<(), contact_patch::InputError>(())
/// ```
#[derive(Clone)]
pub struct Sum {
    parts: Vec<AnyGap>,
    known: Known,
}

impl Sum {
    /// The sum of these gaps.
    ///
    /// # Errors
    /// Names `of` when there are none.
    pub fn new(parts: Vec<AnyGap>) -> Result<Self, InputError> {
        if parts.is_empty() {
            return Err(InputError::new("of", "an empty list", "at least one gap"));
        }
        let known = known_of(&parts);
        Ok(Self { parts, known })
    }

    /// The gaps that are added.
    #[must_use]
    pub fn parts(&self) -> &[AnyGap] {
        &self.parts
    }

    /// What a part is less than where the sum is less than the depth, by the least values of the others; `None` where these have none.
    fn left_of(&self, depth: f64, of: usize) -> Option<f64> {
        let others = self.parts.iter().enumerate().filter(|(k, _)| *k != of);
        let sum = others.map(|(_, part)| Interval::new(part.known().floor, part.known().floor));
        let floor = sum.fold(Interval::ZERO, |sum, floor| sum + floor).lo;
        (floor > f64::NEG_INFINITY).then(|| (depth - floor).next_up())
    }

    /// A rectangle that holds {g < depth}, from what the parts know: each is less than the depth less the least values of the
    /// others, and ends where its material does.
    fn held(&self, depth: f64) -> Reach {
        let mut held: Option<Rect> = None;
        let mut cut = |rect: Rect| {
            held = Some(held.map_or(Some(rect), |held| held.intersection(&rect))?);
            Some(())
        };
        for (k, part) in self.parts.iter().enumerate() {
            if let Material::Within(rect) = part.known().material
                && cut(rect).is_none()
            {
                return Reach::Nowhere;
            }
            let Some(left) = self.left_of(depth, k) else { continue };
            match part.reach(left) {
                Reach::Nowhere => return Reach::Nowhere,
                Reach::Within(rect) if cut(rect).is_none() => return Reach::Nowhere,
                _ => {}
            }
        }
        held.map_or(Reach::Unknown, Reach::Within)
    }

    fn lower(&self, rect: &Rect) -> f64 {
        self.bounds(rect, [0.0; 2]).map_or(f64::NEG_INFINITY, |b| b[0])
    }

    fn has_bounds(&self, rect: &Rect) -> bool {
        self.parts.iter().all(|part| part.bounds(rect, [0.0; 2]).is_some())
    }
}

/// What follows from the parts.
fn known_of(parts: &[AnyGap]) -> Known {
    if let [one] = parts {
        return one.known().clone();
    }
    let all = || parts.iter().map(AnyGap::known);
    let quadratic =
        all().map(|k| k.quadratic).reduce(|a, b| a.zip(b).map(|(a, b): (Quadratic, _)| a.plus(&b))).flatten();
    let value = |p: [f64; 2]| parts.iter().map(|part| part.gap(p[0], p[1])).sum::<f64>();
    let lowest_of = || all().map(|k| k.centre).min_by(|&a, &b| value(a).total_cmp(&value(b)));
    let centre = quadratic.and_then(|q| q.lowest()).or_else(lowest_of).unwrap_or_default();
    let common = all().all(|k| k.centre == centre);
    let law = all().map(|k| k.law).reduce(|a, b| {
        let (a, b) = a.zip(b)?;
        (a.degree == b.degree).then_some(Law { lowest: a.lowest + b.lowest, ..a })
    });
    // Flat punches together are one only where they cover the same.
    let law = law.flatten().filter(|law| common && law.degree.inverse() > 0.0);
    let crown = crown_of(parts);
    let face = crown.as_ref().and_then(Crown::face);
    let level = face.as_ref().filter(|face| face.slope == [0.0; 2]);
    let law = law.or_else(|| level.map(|face| Law { degree: Degree::Flat, lowest: face.value }));
    let material = all().map(|k| k.material).reduce(|a, b| match (a, b) {
        (Material::Within(a), Material::Within(b)) => {
            Material::Within(a.intersection(&b).unwrap_or(Rect { min: a.min, max: a.min }))
        }
        (Material::Within(a), _) | (_, Material::Within(a)) => Material::Within(a),
        (Material::Everywhere, Material::Everywhere) => Material::Everywhere,
        _ => Material::Unknown,
    });
    let floors = all().map(|k| Interval::new(k.floor, k.floor)).fold(Interval::ZERO, |sum, floor| sum + floor);
    let floor = quadratic.map_or(f64::NEG_INFINITY, |q| q.floor()).max(floors.lo);
    Known {
        centre,
        reference: [0.0; 2],
        tips: parts.iter().flat_map(tips_of).collect(),
        floor,
        law: law.or_else(|| quadratic.and_then(law_of)),
        quadratic,
        axis: common_axis(parts, &mut Generatrix::plus),
        face,
        crown: crown.filter(|crown| crown.form.hessian != [0.0; 3]),
        material: material.unwrap_or(Material::Unknown),
        mirrors: common_mirrors(parts, centre),
        recurs_along: None,
        ends: all().find_map(|k| k.ends.clone()),
        drawn_along: drawn_along(parts),
    }
}

/// One part with a sharp edge, and forms that hold everywhere.
fn crown_of(parts: &[AnyGap]) -> Option<Crown> {
    let sharp = |part: &AnyGap| {
        let known = part.known();
        known.crown.clone().or_else(|| known.face.as_ref().map(Face::crown))
    };
    let mut found = parts.iter().enumerate().filter_map(|(k, part)| sharp(part).map(|crown| (k, crown)));
    let (own, crown) = found.next().filter(|_| found.next().is_none())?;
    let others = parts.iter().enumerate().filter(|(k, _)| *k != own);
    let form = others.map(|(_, part)| part.known().quadratic).try_fold(crown.form, |sum, q| Some(sum.plus(&q?)))?;
    Some(Crown { form, ..crown })
}

/// A quadratic form that curves upwards is homogeneous about its lowest point.
pub(super) fn law_of(quadratic: Quadratic) -> Option<Law> {
    let lowest = quadratic.about(quadratic.lowest()?).value;
    Some(Law { degree: Degree::Power(2.0), lowest })
}

#[warn(clippy::missing_trait_methods)]
impl Gap for Sum {
    fn gap(&self, x: f64, y: f64) -> f64 {
        let sum: f64 = self.parts.iter().map(|part| part.gap(x, y)).sum();
        // One part without material is enough; minus infinity is no gap.
        if sum.is_nan() && self.parts.iter().any(|part| part.gap(x, y) == f64::INFINITY) { f64::INFINITY } else { sum }
    }

    fn gaps(&self, points: &[[f64; 2]], to: &mut [f64]) {
        super::one_by_one(self, points, to);
    }

    fn gradient(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        self.parts.iter().try_fold([0.0; 2], |sum, part| part.gradient(x, y).map(|g| [sum[0] + g[0], sum[1] + g[1]]))
    }

    fn describe(&self) -> Known {
        self.known.clone()
    }

    fn reach(&self, depth: f64) -> Reach {
        if let Some(reach) = self.known.quadratic.and_then(|q| q.reach(depth)) {
            return reach;
        }
        if depth <= self.known.floor {
            return Reach::Nowhere;
        }
        let outer = match self.held(depth) {
            Reach::Unknown => {
                let mirrors = [0, 1].map(|m| self.known.mirrors[m] && self.known.centre[m] == 0.0);
                growth::reach(|sector, from| self.growth(sector, from), depth, mirrors)
            }
            held => held,
        };
        match outer {
            Reach::Within(rect) if self.has_bounds(&rect) => {
                let mirrors = (self.known.centre, self.known.mirrors);
                enclosure::tightened(&|r| self.lower(r), depth, &rect, mirrors)
            }
            other => other,
        }
    }

    fn components(&self, depth: f64) -> Option<Vec<Rect>> {
        let Reach::Within(all) = self.reach(depth) else {
            return (self.reach(depth) == Reach::Nowhere).then(Vec::new);
        };
        // Every piece lies in a piece of each part, at the depth that the others leave to it.
        let mut found = vec![all];
        for (k, part) in self.parts.iter().enumerate() {
            let Some(own) = self.left_of(depth, k).and_then(|left| part.components(left)) else { continue };
            if found.len() * own.len() <= MOST_PAIRS {
                found = found.iter().flat_map(|a| own.iter().filter_map(|b| a.intersection(b))).collect();
            }
        }
        if !self.has_bounds(&all) {
            return Some(found);
        }
        let lower = |rect: &Rect| self.lower(rect);
        let parts = found.iter().flat_map(|rect| enclosure::components(&lower, depth, rect));
        let tight = parts.filter_map(|rect| match enclosure::tightened(&lower, depth, &rect, ([0.0; 2], [false; 2])) {
            Reach::Within(rect) => Some(rect),
            _ => None,
        });
        Some(tight.collect())
    }

    fn mean(&self, cell: &Rect) -> f64 {
        let sum: f64 = self.parts.iter().map(|part| part.mean(cell)).sum();
        if sum.is_nan() { f64::INFINITY } else { sum }
    }

    fn bounds(&self, rect: &Rect, slope: [f64; 2]) -> Option<[f64; 2]> {
        // Each part less its own slope in the middle; what is left of the slope goes to the first.
        let [x, y] = rect.centre();
        let own: Vec<[f64; 2]> = self.parts.iter().map(|part| part.gradient(x, y).unwrap_or_default()).collect();
        let finite = own.iter().flatten().all(|s| s.is_finite());
        let mut bounds = Interval::ZERO;
        for (k, part) in self.parts.iter().enumerate() {
            let mut share = if finite { own[k] } else { [0.0; 2] };
            if k == 0 {
                for m in 0..2 {
                    let others: f64 = if finite { own[1..].iter().map(|s| s[m]).sum() } else { 0.0 };
                    share[m] = slope[m] - others;
                }
            }
            let [low, high] = part.bounds(rect, share)?;
            if low == f64::INFINITY {
                return Some([f64::INFINITY; 2]);
            }
            bounds = bounds + Interval::new(low, high);
        }
        // The shares add up to the slope but for rounding.
        let [w, h] = rect.size();
        let size = own.iter().flatten().chain(&slope).fold(0.0_f64, |m, s| m.max(s.abs()));
        let off = 4.0 * f64::EPSILON * self.parts.len() as f64 * if finite { size } else { 0.0 } * (w + h);
        let [mut low, mut high] = [bounds.lo - off, bounds.hi + off];
        if let Some(taylor) = self.taylor(rect) {
            let [a, b] = taylor.bounds([w, h], slope);
            (low, high) = (low.max(a), high.min(b));
        }
        Some([low, if high.is_nan() { f64::INFINITY } else { high }])
    }

    fn taylor(&self, rect: &Rect) -> Option<Taylor> {
        let mut parts = self.parts.iter().map(|part| part.taylor(rect));
        let first = parts.next()??;
        parts.try_fold(first, |sum, part| part.map(|part| sum.plus(&part)))?.finite()
    }

    fn cubic(&self, rect: &Rect) -> Option<Cubic> {
        let mut parts = self.parts.iter().map(|part| part.cubic(rect));
        let first = parts.next()??;
        parts.try_fold(first, |sum, part| part.map(|part| sum.plus(&part)))?.finite()
    }

    fn slopes(&self, rect: &Rect) -> Option<[Interval; 2]> {
        self.parts.iter().try_fold([Interval::ZERO; 2], |sum, part| {
            part.slopes(rect).map(|slopes| [sum[0] + slopes[0], sum[1] + slopes[1]])
        })
    }

    fn mean_bounds(&self, rect: &Rect) -> Option<[f64; 2]> {
        let sum = self.parts.iter().try_fold(Interval::ZERO, |sum, part| {
            part.mean_bounds(rect).map(|[low, high]| sum + Interval::new(low, high))
        })?;
        Some([sum.lo, sum.hi])
    }

    fn growth(&self, sector: Interval, from: f64) -> Option<Growth> {
        let mut parts = self.parts.iter().map(|part| part.growth(sector, from));
        let first = parts.next()??;
        parts.try_fold(first, |sum, part| part.map(|part| sum.plus(&part)))
    }

    fn is_measured(&self) -> bool {
        self.parts.iter().any(Gap::is_measured)
    }

    fn sampling_error(&self, rect: &Rect) -> f64 {
        self.parts.iter().map(|part| part.sampling_error(rect)).sum()
    }

    fn left_open(&self, places: &[Rect]) -> Vec<LeftOpen> {
        joined(&self.parts, places, |a, b| a + b)
    }

    fn restricted(&self, rect: &Rect) -> Option<AnyGap> {
        let simpler: Vec<Option<AnyGap>> = self.parts.iter().map(|part| part.restricted(rect)).collect();
        if simpler.iter().all(Option::is_none) {
            return None;
        }
        let parts = simpler.into_iter().zip(&self.parts).map(|(simpler, part)| simpler.unwrap_or_else(|| part.clone()));
        Self::new(parts.collect()).ok().map(AnyGap::new)
    }

    fn is_composed(&self) -> bool {
        self.parts.iter().any(Gap::is_composed)
    }

    fn addends(&self) -> Option<Vec<AnyGap>> {
        Some(self.parts.clone())
    }

    fn terms(&self) -> Option<Vec<AnyGap>> {
        self.addends()
    }

    fn alternatives(&self) -> Option<Vec<AnyGap>> {
        None
    }

    fn without_end(&self, depth: f64) -> Option<AnyGap> {
        let whole: Vec<Option<AnyGap>> =
            (0..self.parts.len()).map(|k| self.parts[k].without_end(self.left_of(depth, k)?)).collect();
        if whole.iter().all(Option::is_none) {
            return None;
        }
        let parts = whole.into_iter().zip(&self.parts).map(|(whole, part)| whole.unwrap_or_else(|| part.clone()));
        let sum = Self::new(parts.collect()).ok()?;
        sum.known.is_telling().then(|| AnyGap::new(sum))
    }

    fn ray_kinks(&self, from: [f64; 2], direction: [f64; 2], kinks: &mut Vec<f64>) {
        self.parts.iter().for_each(|part| part.ray_kinks(from, direction, kinks));
    }

    fn kink_directions(&self, from: [f64; 2], angles: &mut Vec<f64>) {
        self.parts.iter().for_each(|part| part.kink_directions(from, angles));
    }

    fn ridges(&self) -> Option<super::Ridges> {
        None
    }

    fn end_of_data(&self, x: f64, y: f64) -> Option<super::DataEdge> {
        self.parts.iter().find_map(|part| part.end_of_data(x, y))
    }

    fn nodes(&self) -> Option<crate::grid::Grid> {
        self.parts.iter().find_map(Gap::nodes)
    }

    fn planes(&self) -> Option<Vec<[f64; 3]>> {
        None
    }

    fn into_any(self) -> AnyGap {
        // The sum of one gap is that gap.
        match <[AnyGap; 1]>::try_from(self.parts) {
            Ok([one]) => one,
            Err(parts) => AnyGap::of(std::sync::Arc::new(Self { parts, known: self.known })),
        }
    }
}

/// Pairs of pieces of two parts that are looked at.
const MOST_PAIRS: usize = 4096;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gap::{Paraboloid, Place, Polyhedron};

    fn cylinder(radius: f64, turn: f64) -> AnyGap {
        Paraboloid::new([radius, f64::INFINITY]).unwrap().placed([0.0; 2], turn).unwrap()
    }

    #[test]
    fn crossed_cylinders_reach_as_far_as_their_paraboloid() {
        for turn in [90f64, 30.0, 1.0] {
            let crossed = Sum::new(vec![cylinder(0.02, 0.0), cylinder(0.05, turn.to_radians())]).unwrap();
            let centre = crossed.describe().centre;
            assert!(centre[0].hypot(centre[1]) < 1e-15);
            let Reach::Within(rect) = crossed.reach(1e-6) else { panic!("{turn}: {:?}", crossed.reach(1e-6)) };
            // Largest x and y on x^T B x = 2 d with B = sum of n n^T/R.
            let (s, c) = turn.to_radians().sin_cos();
            let (xx, xy, yy) = (1.0 / 0.02 + c * c / 0.05, s * c / 0.05, s * s / 0.05);
            let det = xx * yy - xy * xy;
            let half = [yy, xx].map(|b| (2e-6 * b / det).sqrt());
            for m in 0..2 {
                assert!(rect.max[m] >= half[m] && rect.max[m] < 1.01 * half[m], "{turn}: {rect:?} {half:?}");
                assert!(-rect.min[m] >= half[m] && -rect.min[m] < 1.01 * half[m]);
            }
        }
        let parallel = Sum::new(vec![cylinder(0.02, 0.0), cylinder(0.05, 0.0)]).unwrap();
        assert!(matches!(parallel.reach(1e-6), Reach::Unbounded { .. } | Reach::Unknown), "{:?}", parallel.reach(1e-6));
        assert_eq!(parallel.reach(0.0), Reach::Nowhere);
    }

    #[test]
    fn a_sum_with_a_polyhedron_keeps_its_proved_bounds() {
        let wedge = AnyGap::new(Polyhedron::pyramid(2, 0.3).unwrap());
        let sum = Sum::new(vec![wedge, cylinder(1.0, 90f64.to_radians())]).unwrap();
        let Reach::Within(rect) = sum.reach(0.1) else { panic!("bounded") };
        // A side is found to a 32nd of the extent.
        for (found, exact) in rect.max.into_iter().zip([0.1 / 0.3f64.tan(), 0.2f64.sqrt()]) {
            assert!(found >= exact && found <= exact * (1.0 + 2.2 / 32.0), "{rect:?}");
        }
        assert!(Sum::new(Vec::new()).is_err());
    }
}

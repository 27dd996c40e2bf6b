//! Gaps made of others: two curved bodies, several tips.

use super::descent::lowest;
use super::search::{extent, pieces as search_pieces, search};
use super::{AnyGap, Gap, Reach};
use crate::error::InputError;
use crate::geometry::Rect;

fn some(parts: Vec<AnyGap>) -> Result<Vec<AnyGap>, InputError> {
    if parts.is_empty() {
        return Err(InputError::new("of", "an empty list", "at least one gap"));
    }
    Ok(parts)
}

/// The sum of several gaps: two curved bodies, each turned its own way, against each other.
///
/// ```
/// use contact_patch::gap::{AnyGap, Gap, Paraboloid, Placed, Sum};
/// // Two cylinders of radii 0.02 and 0.05 with axes at right angles.
/// let one = Paraboloid::new([0.02, f64::INFINITY])?;
/// let other = Placed::new(Paraboloid::new([0.05, f64::INFINITY])?, [0.0, 0.0], 90f64.to_radians())?;
/// let crossed = Sum::new(vec![AnyGap::new(one), AnyGap::new(other)])?;
/// assert_eq!(crossed.gap(1e-3, 2e-3), Paraboloid::new([0.02, 0.05])?.gap(1e-3, 2e-3));
/// # Ok::<(), contact_patch::InputError>(())
/// ```
#[derive(Clone)]
pub struct Sum {
    parts: Vec<AnyGap>,
    centre: [f64; 2],
    /// A lower bound of each part, where the part can prove one.
    lows: Vec<Option<f64>>,
}

impl Sum {
    /// The sum of these gaps.
    ///
    /// # Errors
    /// Names `of` when there are none.
    pub fn new(parts: Vec<AnyGap>) -> Result<Self, InputError> {
        let parts = some(parts)?;
        let lows = parts.iter().map(least).collect();
        let mut sum = Self { parts, centre: [0.0; 2], lows };
        let value = |p: [f64; 2]| sum.gap(p[0], p[1]);
        let starts = sum.parts.iter().map(|part| part.centre());
        let start = starts.min_by(|&a, &b| value(a).total_cmp(&value(b))).unwrap_or_default();
        let common = sum.parts.iter().zip(&sum.lows).all(|(part, low)| part.centre() == start && low.is_some());
        sum.centre = if common { start } else { lowest(&sum, start) };
        Ok(sum)
    }

    /// The gaps that are added.
    #[must_use]
    pub fn parts(&self) -> &[AnyGap] {
        &self.parts
    }

    /// Where the sum can be less than `depth`, from what the parts can prove: each part is less than the depth less the
    /// least values of the others.
    fn proved(&self, depth: f64) -> Reach {
        let mut held: Option<Rect> = None;
        for (k, part) in self.parts.iter().enumerate() {
            let others = self.lows.iter().enumerate().filter(|(m, _)| *m != k).map(|(_, low)| *low);
            let Some(others) = others.sum::<Option<f64>>() else { continue };
            match part.certain_reach(depth - others) {
                Reach::Nowhere => return Reach::Nowhere,
                Reach::Within(rect) => {
                    held = match held.map_or(Some(rect), |held| held.intersection(&rect)) {
                        None => return Reach::Nowhere,
                        both => both,
                    };
                }
                Reach::Unbounded | Reach::Unknown => {}
            }
        }
        held.map_or(Reach::Unknown, Reach::Within)
    }
}

/// The least value of a gap if it lies at its centre and the gap can tell; a little less where rounding hides it.
fn least(part: &AnyGap) -> Option<f64> {
    let [x, y] = part.centre();
    let low = part.gap(x, y);
    [low, low - 1e-9 * low.abs()].into_iter().find(|&v| v.is_finite() && part.certain_reach(v) == Reach::Nowhere)
}

/// The mirrors through this point that all parts have.
fn common_mirrors(parts: &[AnyGap], centre: [f64; 2]) -> [bool; 2] {
    parts.iter().fold([true; 2], |all, part| {
        let (own, at) = (part.mirrors(), part.centre());
        [0, 1].map(|m| all[m] && own[m] && at[m] == centre[m])
    })
}

impl Gap for Sum {
    fn gap(&self, x: f64, y: f64) -> f64 {
        let sum: f64 = self.parts.iter().map(|part| part.gap(x, y)).sum();
        if sum.is_nan() { f64::INFINITY } else { sum }
    }

    fn gradient(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        self.parts.iter().try_fold([0.0; 2], |sum, part| part.gradient(x, y).map(|g| [sum[0] + g[0], sum[1] + g[1]]))
    }

    fn range(&self, rect: &Rect, slope: [f64; 2]) -> Option<[f64; 2]> {
        // Each part less its own slope in the middle; what is left of the slope goes to the first.
        let [x, y] = rect.centre();
        let own: Vec<[f64; 2]> = self.parts.iter().map(|part| part.gradient(x, y).unwrap_or_default()).collect();
        let finite = own.iter().flatten().all(|s| s.is_finite());
        let mut bounds = [0.0; 2];
        for (k, part) in self.parts.iter().enumerate() {
            let mut share = if finite { own[k] } else { [0.0; 2] };
            if k == 0 {
                for m in 0..2 {
                    let others: f64 = if finite { own[1..].iter().map(|s| s[m]).sum() } else { 0.0 };
                    share[m] = slope[m] - others;
                }
            }
            let [low, high] = part.range(rect, share)?;
            bounds = [bounds[0] + low, bounds[1] + high];
        }
        Some(bounds.map(|b| if b.is_nan() { f64::INFINITY } else { b }))
    }

    fn mirrors(&self) -> [bool; 2] {
        common_mirrors(&self.parts, self.centre())
    }

    fn reach(&self, depth: f64) -> Reach {
        let proved = self.proved(depth);
        if proved == Reach::Nowhere {
            return proved;
        }
        match (search(&|x, y| self.gap(x, y), depth, self.centre), proved) {
            (Reach::Within(found), Reach::Within(held)) => Reach::Within(found.intersection(&held).unwrap_or(held)),
            (Reach::Unbounded, Reach::Within(held)) => Reach::Within(held),
            (found, _) => found,
        }
    }

    fn pieces(&self, depth: f64) -> Option<Vec<Rect>> {
        match self.reach(depth) {
            Reach::Within(all) => {
                let found = search_pieces(&|x, y| self.gap(x, y), depth, self.centre)?;
                Some(found.iter().filter_map(|piece| piece.intersection(&all)).collect())
            }
            Reach::Nowhere => Some(Vec::new()),
            Reach::Unbounded | Reach::Unknown => None,
        }
    }

    fn certain_reach(&self, depth: f64) -> Reach {
        self.proved(depth)
    }

    fn mean(&self, cell: &Rect) -> f64 {
        let sum: f64 = self.parts.iter().map(|part| part.mean(cell)).sum();
        if sum.is_nan() { f64::INFINITY } else { sum }
    }

    fn ray_kinks(&self, from: [f64; 2], direction: [f64; 2], kinks: &mut Vec<f64>) {
        self.parts.iter().for_each(|part| part.ray_kinks(from, direction, kinks));
    }

    fn kink_directions(&self, from: [f64; 2], angles: &mut Vec<f64>) {
        self.parts.iter().for_each(|part| part.kink_directions(from, angles));
    }

    fn centre(&self) -> [f64; 2] {
        self.centre
    }

    fn tips(&self) -> Vec<[f64; 2]> {
        self.parts.iter().flat_map(|part| part.tips()).collect()
    }
}

/// The least of several gaps: a punch with several tips.
///
/// ```
/// use contact_patch::gap::{AnyGap, Gap, Minimum, Placed, Sphere};
/// let tip = |x: f64| Placed::new(Sphere::new(1e-3)?, [x, 0.0], 0.0).map(AnyGap::new);
/// let punch = Minimum::new(vec![tip(-5e-4)?, tip(5e-4)?])?;
/// assert_eq!(punch.gap(-5e-4, 0.0), 0.0);
/// assert_eq!(punch.gap(5e-4, 0.0), 0.0);
/// # Ok::<(), contact_patch::InputError>(())
/// ```
#[derive(Clone)]
pub struct Minimum {
    parts: Vec<AnyGap>,
}

impl Minimum {
    /// The least of these gaps.
    ///
    /// # Errors
    /// Names `of` when there are none.
    pub fn new(parts: Vec<AnyGap>) -> Result<Self, InputError> {
        Ok(Self { parts: some(parts)? })
    }

    /// The gaps of which the least counts.
    #[must_use]
    pub fn parts(&self) -> &[AnyGap] {
        &self.parts
    }

    /// What holds the reaches of all parts.
    fn all(&self, reach: impl Fn(&dyn Gap) -> Reach) -> Reach {
        let mut all = Reach::Nowhere;
        for part in &self.parts {
            all = match (all, reach(&**part)) {
                (Reach::Within(a), Reach::Within(b)) => Reach::Within(a.union(&b)),
                (known, Reach::Nowhere) => known,
                (Reach::Nowhere, first) => first,
                (_, other) => return other,
            };
        }
        all
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
}

impl Gap for Minimum {
    fn gap(&self, x: f64, y: f64) -> f64 {
        self.parts.iter().map(|part| part.gap(x, y)).fold(f64::INFINITY, f64::min)
    }

    fn gradient(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        self.parts[self.least([x, y])].gradient(x, y)
    }

    fn range(&self, rect: &Rect, slope: [f64; 2]) -> Option<[f64; 2]> {
        self.parts.iter().try_fold([f64::INFINITY; 2], |[low, high], part| {
            part.range(rect, slope).map(|[a, b]| [low.min(a), high.min(b)])
        })
    }

    fn mirrors(&self) -> [bool; 2] {
        common_mirrors(&self.parts, self.centre())
    }

    fn reach(&self, depth: f64) -> Reach {
        self.all(|part| extent(part, depth))
    }

    fn pieces(&self, depth: f64) -> Option<Vec<Rect>> {
        let pieces: Option<Vec<Vec<Rect>>> = self.parts.iter().map(|part| part.pieces(depth)).collect();
        pieces.map(|pieces| pieces.into_iter().flatten().collect())
    }

    fn certain_reach(&self, depth: f64) -> Reach {
        self.all(|part| part.certain_reach(depth))
    }

    fn mean(&self, cell: &Rect) -> f64 {
        // Where one part is the least at a 5 x 5 lattice, corners included, it is taken to be so throughout.
        let [w, h] = cell.size();
        let lattice = (0..25).map(|k| [0.25 * f64::from(k % 5), 0.25 * f64::from(k / 5)]);
        let mut least = lattice.map(|[s, t]| self.least([cell.min[0] + s * w, cell.min[1] + t * h]));
        let first = least.next().unwrap_or_default();
        if least.all(|k| k == first) {
            let mean = self.parts[first].mean(cell);
            if mean.is_finite() {
                return mean;
            }
        }
        super::mean::by_quadrature(|x, y| self.gap(x, y), cell)
    }

    fn ray_kinks(&self, from: [f64; 2], direction: [f64; 2], kinks: &mut Vec<f64>) {
        self.parts.iter().for_each(|part| part.ray_kinks(from, direction, kinks));
        // Where another part becomes the least: sampled evenly as far as the parts lie and in magnitudes beyond.
        let at = |r: f64| [from[0] + r * direction[0], from[1] + r * direction[1]];
        let distance = |part: &AnyGap| (part.centre()[0] - from[0]).hypot(part.centre()[1] - from[1]);
        let far = self.parts.iter().map(distance).fold(0.0, f64::max);
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
            let mut b = next;
            let least = self.least(at(b));
            let Some((mut a, before)) = last_seen.replace((b, least)).filter(|seen| seen.1 != least) else { continue };
            for _ in 0..60 {
                let middle = 0.5 * (a + b);
                *if self.least(at(middle)) == before { &mut a } else { &mut b } = middle;
            }
            kinks.push(b);
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

    fn centre(&self) -> [f64; 2] {
        let value = |part: &AnyGap| part.gap(part.centre()[0], part.centre()[1]);
        let lowest = self.parts.iter().min_by(|a, b| value(a).total_cmp(&value(b)));
        lowest.map_or([0.0; 2], |part| part.centre())
    }

    fn tips(&self) -> Vec<[f64; 2]> {
        self.parts.iter().flat_map(|part| part.tips()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gap::{Paraboloid, Placed, Polyhedron};

    fn cylinder(radius: f64, turn: f64) -> AnyGap {
        AnyGap::new(Placed::new(Paraboloid::new([radius, f64::INFINITY]).unwrap(), [0.0; 2], turn).unwrap())
    }

    #[test]
    fn crossed_cylinders_reach_as_far_as_their_paraboloid() {
        for turn in [90f64, 30.0, 1.0] {
            let crossed = Sum::new(vec![cylinder(0.02, 0.0), cylinder(0.05, turn.to_radians())]).unwrap();
            assert_eq!(crossed.centre(), [0.0; 2]);
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
        assert_eq!(parallel.reach(1e-6), Reach::Unbounded);
        assert_eq!(parallel.reach(0.0), Reach::Nowhere);
    }

    #[test]
    fn two_tips_meet_half_way() {
        let tip = |x: f64| AnyGap::new(Placed::new(Paraboloid::new([1.0; 2]).unwrap(), [x, 0.0], 0.0).unwrap());
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
    fn a_sum_with_a_polyhedron_keeps_its_proved_bounds() {
        let wedge = AnyGap::new(Polyhedron::pyramid(2, 0.3).unwrap());
        let sum = Sum::new(vec![wedge, cylinder(1.0, 90f64.to_radians())]).unwrap();
        let Reach::Within(rect) = sum.reach(0.1) else { panic!("bounded") };
        assert!(
            (rect.max[0] - 0.1 / 0.3f64.tan()).abs() < 1e-3 && (rect.max[1] - 0.2f64.sqrt()).abs() < 1e-3,
            "{rect:?}"
        );
        assert!(Sum::new(Vec::new()).is_err() && Minimum::new(Vec::new()).is_err());
    }
}

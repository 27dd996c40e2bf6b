//! Bodies of revolution given by points of their generatrix.

use super::outline::circle_crossings;
use super::radial::{self, Profile, distances};
use super::{Axis, Gap, Generatrix, Growth, Known, Material, Reach, Taylor, range};
use crate::error::{InputError, finite};
use crate::numeric::Interval;
use crate::numeric::geometry::Rect;

/// g(r) straight between the points (r, z) of a table: the profile of a tip, a turned punch, a worn bearing.
///
/// Straight lines are what the table says and no more: a table of corners (a flat-ended cone needs three points) is
/// met exactly, and a dense table of a smooth profile to second order in its steps. Outside the table, that is beyond
/// the last radius and within the first one when that is not zero (a ring), there is no material.
///
/// ```
/// use contact_patch::gap::{Gap, Revolved};
/// let blunt_cone = Revolved::new(vec![[0.0, 0.0], [1e-3, 0.0], [3e-3, 1e-3]])?;
/// assert_eq!(blunt_cone.gap(0.0, 2e-3), 0.5e-3);
/// assert_eq!(blunt_cone.kinks(), [1e-3]);
/// # Ok::<(), contact_patch::InputError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Revolved {
    points: Vec<[f64; 2]>,
    kinks: Vec<f64>,
}

impl Revolved {
    /// The generatrix through these points `[r, z]`, at least two, r rising from r >= 0; z is the gap.
    ///
    /// # Errors
    /// Names the point that is not finite, has a negative radius or does not lie further out than the one before it.
    pub fn new(points: Vec<[f64; 2]>) -> Result<Self, InputError> {
        if points.len() < 2 {
            let given = format!("{} points", points.len());
            return Err(InputError::new("points", given, "at least two points [r, z]"));
        }
        for (k, &[r, z]) in points.iter().enumerate() {
            finite(&format!("points[{k}][0]"), r)?;
            finite(&format!("points[{k}][1]"), z)?;
            let least = if k == 0 { 0.0 } else { points[k - 1][0].next_up() };
            if r < least {
                let allowed = if k == 0 { "a radius of at least 0" } else { "a radius greater than the one before it" };
                return Err(InputError::new(format!("points[{k}][0]"), r, allowed));
            }
            if k > 0 {
                let slope = (z - points[k - 1][1]) / (r - points[k - 1][0]);
                finite(&format!("points[{k}][1]"), slope)
                    .map_err(|e| InputError { given: format!("{z}, a step of infinite slope"), ..e })?;
            }
        }
        let mut revolved = Self { points, kinks: Vec::new() };
        let bends = |k: &usize| revolved.slope_of(*k) != revolved.slope_of(k - 1);
        revolved.kinks = (1..revolved.points.len() - 1).filter(bends).map(|k| revolved.points[k][0]).collect();
        Ok(revolved)
    }

    /// The points, as given.
    #[must_use]
    pub fn points(&self) -> &[[f64; 2]] {
        &self.points
    }

    /// g(r); infinite outside the table.
    #[must_use]
    pub fn height(&self, r: f64) -> f64 {
        match self.segment(r) {
            Some(k) => {
                let ([r0, z0], [r1, z1]) = (self.points[k], self.points[k + 1]);
                let t = (r - r0) / (r1 - r0);
                z0 * (1.0 - t) + z1 * t
            }
            None => f64::INFINITY,
        }
    }

    /// g'(r), at a kink that of the outer side; `None` outside the table.
    #[must_use]
    pub fn slope(&self, r: f64) -> Option<f64> {
        self.segment(r).map(|k| self.slope_of(k))
    }

    /// Radii, rising, at which the slope jumps. The two ends of the table are not among them.
    #[must_use]
    pub fn kinks(&self) -> &[f64] {
        &self.kinks
    }

    fn slope_of(&self, k: usize) -> f64 {
        let ([r0, z0], [r1, z1]) = (self.points[k], self.points[k + 1]);
        (z1 - z0) / (r1 - r0)
    }

    /// The segment from point k to k + 1 that holds r.
    fn segment(&self, r: f64) -> Option<usize> {
        let (first, last) = (self.points[0][0], self.points[self.points.len() - 1][0]);
        (first <= r && r <= last)
            .then(|| self.points.partition_point(|p| p[0] <= r).clamp(1, self.points.len() - 1) - 1)
    }
}

impl Gap for Revolved {
    fn gap(&self, x: f64, y: f64) -> f64 {
        self.height(x.hypot(y))
    }

    fn gradient(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        let r = x.hypot(y);
        let slope = self.slope(r)?;
        Some(if r > 0.0 { [slope * (x / r), slope * (y / r)] } else { [slope, 0.0] })
    }

    fn describe(&self) -> Known {
        let [first, last] = [self.points[0], self.points[self.points.len() - 1]];
        let lowest = self.points.iter().copied().min_by(|a, b| a[1].total_cmp(&b[1])).unwrap_or(first);
        // A ring has no material on its axis; any point of its lowest circle will do.
        let on_axis = first[0] == 0.0 && first[1] <= lowest[1];
        let around = Rect::around([0.0; 2], [last[0]; 2]);
        Known {
            centre: if on_axis { [0.0; 2] } else { [lowest[0], 0.0] },
            floor: lowest[1],
            axis: Some(Axis { at: [0.0; 2], generatrix: Generatrix::General }),
            material: Material::Within(around),
            mirrors: [on_axis, true],
            ..Known::nothing()
        }
    }

    fn reach(&self, depth: f64) -> Reach {
        // The outermost segment that dips below the depth, and where it leaves it.
        let dips = |k: &usize| self.points[*k][1].min(self.points[k + 1][1]) < depth;
        let Some(k) = (0..self.points.len() - 1).rev().find(dips) else { return Reach::Nowhere };
        let ([r0, z0], [r1, z1]) = (self.points[k], self.points[k + 1]);
        let radius = if z1 <= depth { r1 } else { (r0 + (r1 - r0) * ((depth - z0) / (z1 - z0))).next_up().min(r1) };
        Reach::Within(Rect::around([0.0; 2], [radius; 2]))
    }

    fn bounds(&self, rect: &Rect, slope: [f64; 2]) -> Option<[f64; 2]> {
        let [low, high] = range::of_segments(&self.points, rect, slope);
        match self.taylor(rect).map(|t| t.bounds(rect.size(), slope)) {
            Some([a, b]) => Some([low.max(a), high.min(b)]),
            None => Some([low, high]),
        }
    }

    fn taylor(&self, rect: &Rect) -> Option<Taylor> {
        let r = distances(rect);
        let k = self.segment(r.lo)?;
        let [[r0, z0], [r1, z1]] = [self.points[k], self.points[k + 1]];
        if !(r.lo >= r0 && r.hi <= r1) {
            return None;
        }
        let level = z0 == z1;
        let [r0, z0, r1, z1] = [r0, z0, r1, z1].map(Interval::point);
        let slope = (z1 - z0) / (r1 - r0);
        radial::taylor(rect, |r| Profile {
            value: z0 + slope * (r - r0),
            // Level at the axis, too.
            slope_over_r: if level { Interval::ZERO } else { slope / r },
            curvature: Interval::ZERO,
        })
    }

    fn slopes(&self, rect: &Rect) -> Option<[Interval; 2]> {
        let r = distances(rect);
        let (first, last) = (self.points[0], self.points[self.points.len() - 1]);
        if !(r.lo >= first[0] && r.hi <= last[0]) {
            return None;
        }
        let over = self.points.windows(2).filter(|w| w[0][0] <= r.hi && w[1][0] >= r.lo);
        let slope = over.map(|w| {
            let [[r0, z0], [r1, z1]] = [w[0], w[1]].map(|p| p.map(Interval::point));
            (z1 - z0) / (r1 - r0)
        });
        radial::slopes(rect, slope.reduce(Interval::union)?)
    }

    fn growth(&self, _: Interval, from: f64) -> Option<Growth> {
        Growth::ended(&Rect::around([0.0; 2], [self.points[self.points.len() - 1][0]; 2]), from)
    }

    fn mean(&self, cell: &Rect) -> f64 {
        let furthest = cell.corners().iter().map(|c| c[0].hypot(c[1])).fold(0.0, f64::max);
        let nearest = [0, 1].map(|m| 0.0_f64.max(cell.min[m]).min(cell.max[m]));
        // As at the edge of a flat punch, rounding must not cost a cell its material.
        let [w, h] = cell.size();
        let rounding = 1e-9 * w.hypot(h);
        let (first, last) = (self.points[0][0], self.points[self.points.len() - 1][0]);
        if furthest > last + rounding || nearest[0].hypot(nearest[1]) < first - rounding {
            return f64::INFINITY;
        }
        super::mean::by_quadrature(|x, y| self.height(x.hypot(y).clamp(first, last)), cell)
    }

    fn ray_kinks(&self, from: [f64; 2], direction: [f64; 2], kinks: &mut Vec<f64>) {
        let ends = [self.points[0][0], self.points[self.points.len() - 1][0]];
        for &radius in self.kinks.iter().chain(&ends).filter(|&&radius| radius > 0.0) {
            let crossings = circle_crossings(from.map(|v| v / radius), direction.map(|v| v / radius));
            kinks.extend(crossings.into_iter().flatten().filter(|&r| r > 0.0));
        }
        // Over the apex.
        let along = -(from[0] * direction[0] + from[1] * direction[1]);
        let aside = (from[0] * direction[1] - from[1] * direction[0]).abs();
        if along > 0.0 && aside <= 1e-12 * along {
            kinks.push(along);
        }
    }

    fn kink_directions(&self, from: [f64; 2], angles: &mut Vec<f64>) {
        if from != [0.0; 2] {
            angles.push((-from[1]).atan2(-from[0]));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_table_is_a_cone() {
        let table = Revolved::new((0..=10).map(|k| [0.25 * f64::from(k), 0.125 * f64::from(k)]).collect()).unwrap();
        assert!(table.kinks().is_empty());
        assert_eq!(table.gap(1.2, -0.9), 0.75);
        let Reach::Within(rect) = table.reach(0.5) else { panic!("bounded") };
        assert!(rect.max[0] >= 1.0 && rect.max[0] < 1.0 + 1e-15);
        assert_eq!(table.reach(5.0), Reach::Within(Rect::around([0.0; 2], [2.5; 2])));
        assert_eq!(table.reach(0.0), Reach::Nowhere);
    }

    #[test]
    fn no_material_inside_a_ring_and_beyond_the_table() {
        let ring = Revolved::new(vec![[1.0, 0.5], [2.0, 0.0], [3.0, 1.0]]).unwrap();
        assert_eq!(ring.gap(0.5, 0.0), f64::INFINITY);
        assert_eq!(ring.gap(3.1, 0.0), f64::INFINITY);
        assert_eq!(ring.gap(0.0, -3.0), 1.0);
        assert_eq!(ring.mean(&Rect::around([0.0; 2], [1.5; 2])), f64::INFINITY);
        let [x, y] = ring.describe().centre;
        assert_eq!(ring.gap(x, y), 0.0);
        let mut kinks = Vec::new();
        ring.ray_kinks([0.0; 2], [0.6, 0.8], &mut kinks);
        kinks.sort_by(f64::total_cmp);
        assert_eq!(kinks.len(), 3);
        assert!(kinks.iter().zip([1.0, 2.0, 3.0]).all(|(a, b)| (a - b).abs() < 1e-14));
    }

    #[test]
    fn a_bad_point_is_named() {
        let path = |points: &[[f64; 2]]| Revolved::new(points.to_vec()).unwrap_err().path;
        assert_eq!(path(&[[0.0, 0.0]]), "points");
        assert_eq!(path(&[[-1.0, 0.0], [1.0, 0.0]]), "points[0][0]");
        assert_eq!(path(&[[0.0, 0.0], [1.0, 1.0], [1.0, 2.0]]), "points[2][0]");
        assert_eq!(path(&[[0.0, 0.0], [1.0, f64::NAN]]), "points[1][1]");
        assert_eq!(path(&[[0.0, -1e308], [1e-300, 1e308]]), "points[1][1]");
    }
}

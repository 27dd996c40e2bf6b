//! What a gap is, whatever it was written as: a quadratic form, a gap of revolution, a flat ellipse.
//!
//! Detection is numerical: a model is made from a few values and then tested at points that had no part in it. A gap that
//! stays within e of its model wherever either is less than twice the depth has a force between P(d - e) and
//! P(d + e) of the model, since P grows with the overlap; so a model that is close enough may stand for the gap.

use nalgebra::{Matrix2, Matrix3, SymmetricEigen, Vector2, Vector3};

use crate::gap::{Gap, around_tips, enough, islands};
use crate::geometry::Rect;

/// Distance from the model, relative to the largest overlap, at which a gap is still taken for it.
const CLOSE: f64 = 1e-10;

/// Points at which a model of a gap is tested that knows its own shape; more where its values are all that is known.
const TESTS: usize = 512;

/// What a gap was recognised as.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Recognised {
    /// g = lowest + a u^2/2 + b v^2/2 with curvatures a, b, in axes through `centre`, u turned by `rotation`
    /// (radians) from x; the curvatures are positive and the first is the smaller one.
    Quadratic {
        /// Point of the least gap.
        centre: [f64; 2],
        /// Least gap.
        lowest: f64,
        /// Principal curvatures, ascending.
        curvatures: [f64; 2],
        /// Direction of the first principal axis.
        rotation: f64,
    },
    /// g depends on the distance from `centre` alone.
    Revolution {
        /// The axis.
        centre: [f64; 2],
    },
    /// g is a plane within an ellipse (level unless the punch is tilted), and there is no material outside.
    FlatEllipse {
        /// Centre.
        centre: [f64; 2],
        /// The gap there.
        lowest: f64,
        /// (dg/dx, dg/dy).
        slope: [f64; 2],
        /// Semi-axes, the longer first.
        semi_axes: [f64; 2],
        /// Direction of the longer axis, radians.
        rotation: f64,
    },
    /// None of these.
    General,
}

/// Recognises a gap whose {g < depth} lies in `reach`.
///
/// ```
/// use contact_patch::gap::{Reach, extent};
/// use contact_patch::recognise::{Recognised, recognise};
/// let gap = |x: f64, y: f64| (x - 1.0).powi(2) + x * y + 3.0 * y * y;
/// let Reach::Within(reach) = extent(&gap, 0.5) else { panic!("bounded") };
/// assert!(matches!(recognise(&gap, 0.5, &reach), Recognised::Quadratic { .. }));
/// ```
#[must_use]
pub fn recognise(gap: &dyn Gap, depth: f64, reach: &Rect) -> Recognised {
    // A tip far from the others would escape all tests below.
    if islands(gap, depth, reach).len() > 1 {
        return Recognised::General;
    }
    let look = Look { gap, depth, reach, tests: enough(gap, depth, TESTS), tips: around_tips(gap, reach) };
    look.quadratic().or_else(|| look.flat_ellipse()).or_else(|| look.revolution()).unwrap_or(Recognised::General)
}

/// The n-th point of a sequence that fills the unit square evenly and lies on none of its lines (Roberts 2018).
fn spread(n: usize) -> [f64; 2] {
    let n = n as f64 + 1.0;
    [(0.754_877_666_246_692_7 * n).fract(), (0.569_840_290_998_053_2 * n).fract()]
}

/// A gap that is looked at.
struct Look<'a> {
    gap: &'a dyn Gap,
    depth: f64,
    reach: &'a Rect,
    /// Points at which a model is tested, spread evenly.
    tests: usize,
    /// Points around tips, where it is tested besides.
    tips: Vec<[f64; 2]>,
}

impl Look<'_> {
    fn quadratic(&self) -> Option<Recognised> {
        let Self { gap, depth, reach, .. } = *self;
        let ([x, y], [w, h]) = (reach.centre(), reach.size());
        let (s, t) = (0.4 * w, 0.4 * h);
        let value = |i: f64, j: f64| gap.gap(x + i * s, y + j * t);
        let middle = value(0.0, 0.0);
        let (east, west, north, south) = (value(1.0, 0.0), value(-1.0, 0.0), value(0.0, 1.0), value(0.0, -1.0));
        // In units of s and t: g = middle + b.v + v'Q v/2.
        let qxx = east + west - 2.0 * middle;
        let qyy = north + south - 2.0 * middle;
        let qxy = 0.25 * (value(1.0, 1.0) - value(-1.0, 1.0) - value(1.0, -1.0) + value(-1.0, -1.0));
        let b = Vector2::new(0.5 * (east - west), 0.5 * (north - south));
        let q = Matrix2::new(qxx, qxy, qxy, qyy);
        if !q.iter().chain(b.iter()).all(|v| v.is_finite()) {
            return None;
        }
        let lowest_at = -q.cholesky()?.solve(&b);
        let lowest = middle + 0.5 * b.dot(&lowest_at);
        let centre = [x + s * lowest_at[0], y + t * lowest_at[1]];
        let overlap = depth - lowest;
        if overlap <= 0.0 {
            return None;
        }
        // Principal axes of the curvature in true lengths.
        let hessian = Matrix2::new(qxx / s / s, qxy / s / t, qxy / s / t, qyy / t / t);
        let eigen = SymmetricEigen::new(hessian);
        let (small, large) = if eigen.eigenvalues[0] <= eigen.eigenvalues[1] { (0, 1) } else { (1, 0) };
        // The determinant is shared by both curvatures: nothing is lost of the smaller one.
        let large_curvature = eigen.eigenvalues[large];
        let small_curvature = (qxx * qyy - qxy * qxy) / (s * t).powi(2) / large_curvature;
        if !(small_curvature > 0.0 && large_curvature.is_finite()) {
            return None;
        }
        let axis = eigen.eigenvectors.column(small);
        let model = |p: [f64; 2]| {
            let v = Vector2::new((p[0] - centre[0]) / s, (p[1] - centre[1]) / t);
            lowest + 0.5 * v.dot(&(q * v))
        };
        // Inside twice the ellipse of overlap, in its own axes; and all over the box, where nothing else may come near.
        let (u, v) = (axis.into_owned(), Vector2::new(-axis[1], axis[0]));
        let (a, c) = ((4.0 * overlap / small_curvature).sqrt(), (4.0 * overlap / large_curvature).sqrt());
        let allowed = CLOSE * overlap + 16.0 * f64::EPSILON * (qxx + qyy).abs();
        let same = |p: [f64; 2]| (gap.gap(p[0], p[1]) - model(p)).abs() <= allowed;
        let apart = |p: [f64; 2]| model(p) > lowest + 2.0 * overlap && gap.gap(p[0], p[1]) >= depth;
        for n in 0..self.tests {
            let [r, turn] = spread(n);
            let (sin, cos) = (std::f64::consts::TAU * turn).sin_cos();
            let p = Vector2::from(centre) + u * (a * r.sqrt() * cos) + v * (c * r.sqrt() * sin);
            let q = [reach.min[0] + w * r, reach.min[1] + h * turn];
            if !same(p.into()) || !(model(q) <= lowest + 2.0 * overlap || apart(q)) {
                return None;
            }
        }
        if !self.tips.iter().all(|&p| same(p) || apart(p)) {
            return None;
        }
        let curvatures = [small_curvature.min(large_curvature), large_curvature];
        Some(Recognised::Quadratic { centre, lowest, curvatures, rotation: axis[1].atan2(axis[0]) })
    }

    fn revolution(&self) -> Option<Recognised> {
        let [w, h] = self.reach.size();
        if (w - h).abs() > 1e-6 * w {
            // The box of a disc is square, unless it was searched for: the gap's own centre is then the only hope.
            return self.revolution_about(self.gap.centre());
        }
        self.revolution_about(self.gap.centre()).or_else(|| self.revolution_about(self.reach.centre()))
    }

    fn revolution_about(&self, centre: [f64; 2]) -> Option<Recognised> {
        let Self { gap, depth, reach, .. } = *self;
        let farthest =
            reach.corners().map(|[x, y]| (x - centre[0]).hypot(y - centre[1])).into_iter().fold(0.0, f64::max);
        let profile = |r: f64, angle: f64| gap.gap(centre[0] + r * angle.cos(), centre[1] + r * angle.sin());
        let lowest = (0..TESTS).map(|n| profile(farthest * spread(n)[0], 0.0)).fold(profile(0.0, 0.0), f64::min);
        let overlap = depth - lowest;
        if overlap <= 0.0 {
            return None;
        }
        let same = |r: f64, here: f64| {
            let reference = profile(r, 0.0);
            let both_out = here > depth + overlap && reference > depth + overlap;
            here == reference || both_out || (here - reference).abs() <= CLOSE * overlap
        };
        for n in 0..self.tests {
            let [s, turn] = spread(n);
            // Half of the points near the axis, where a small contact would be.
            let r = farthest * if n % 2 == 0 { s } else { s * s * s };
            if !same(r, profile(r, std::f64::consts::TAU * turn)) {
                return None;
            }
        }
        let round = self.tips.iter().all(|&[x, y]| same((x - centre[0]).hypot(y - centre[1]), gap.gap(x, y)));
        round.then_some(Recognised::Revolution { centre })
    }

    fn flat_ellipse(&self) -> Option<Recognised> {
        let Self { gap, depth, reach, .. } = *self;
        let centre = reach.centre();
        let [w, h] = reach.size();
        let lowest = gap.gap(centre[0], centre[1]);
        if !(lowest < depth) {
            return None;
        }
        let allowed = CLOSE * (depth - lowest);
        // Where the material ends along a direction given in units of the half box.
        let rim = |angle: f64| -> Option<Vector2<f64>> {
            let direction = Vector2::new(0.5 * w * angle.cos(), 0.5 * h * angle.sin());
            let solid = |s: f64| gap.gap(centre[0] + s * direction[0], centre[1] + s * direction[1]) < f64::INFINITY;
            let (mut inside, mut outside) = (0.0, 2.0);
            if solid(outside) || !solid(1e-3) {
                return None;
            }
            while outside - inside > 4.0 * f64::EPSILON {
                let middle = 0.5 * (inside + outside);
                if middle <= inside || middle >= outside {
                    break;
                }
                if solid(middle) { inside = middle } else { outside = middle }
            }
            Some(direction * outside)
        };
        // The slope from two points half way to the rim.
        let slope_along = |angle: f64, axis: usize| -> Option<f64> {
            let v = rim(angle)? * 0.5;
            let (ahead, behind) =
                (gap.gap(centre[0] + v[0], centre[1] + v[1]), gap.gap(centre[0] - v[0], centre[1] - v[1]));
            Some(0.5 * (ahead - behind) / v[axis]).filter(|s| s.is_finite())
        };
        let slope = [slope_along(0.0, 0)?, slope_along(0.5 * std::f64::consts::PI, 1)?];
        // x'M x = 1 through three rims, tested on the others.
        let rims: Vec<Vector2<f64>> = (0..24).map(|k| rim(0.1 + 0.77 * f64::from(k))).collect::<Option<_>>()?;
        let scaled = |p: &Vector2<f64>| Vector2::new(p[0] / w, p[1] / h);
        let row = |p: &Vector2<f64>| {
            let p = scaled(p);
            [p[0] * p[0], 2.0 * p[0] * p[1], p[1] * p[1]]
        };
        let rows: Vec<[f64; 3]> = [0, 2, 4].iter().map(|&k| row(&rims[k])).collect();
        let m = Matrix3::from_fn(|i, j| rows[i][j]).lu().solve(&Vector3::new(1.0, 1.0, 1.0))?;
        let off = |p: &Vector2<f64>| (Vector3::from(row(p)).dot(&m) - 1.0).abs();
        if rims.iter().any(|p| !(off(p) < 1e-9)) {
            return None;
        }
        let even = (0..self.tests).map(|n| {
            let [s, t] = spread(n);
            Vector2::new((s - 0.5) * w, (t - 0.5) * h)
        });
        let at_tips = self.tips.iter().map(|p| Vector2::new(p[0] - centre[0], p[1] - centre[1]));
        for p in even.chain(at_tips) {
            let inside = Vector3::from(row(&p)).dot(&m);
            let g = gap.gap(centre[0] + p[0], centre[1] + p[1]);
            let plane = lowest + slope[0] * p[0] + slope[1] * p[1];
            let off_plane = !((g - plane).abs() <= allowed);
            if (inside < 1.0 - 1e-9 && off_plane) || (inside > 1.0 + 1e-9 && g != f64::INFINITY) {
                return None;
            }
        }
        let form = Matrix2::new(m[0] / w / w, m[1] / w / h, m[1] / w / h, m[2] / h / h);
        let eigen = SymmetricEigen::new(form);
        let (long, short) = if eigen.eigenvalues[0] <= eigen.eigenvalues[1] { (0, 1) } else { (1, 0) };
        if !(eigen.eigenvalues[long] > 0.0) {
            return None;
        }
        let axis = eigen.eigenvectors.column(long);
        Some(Recognised::FlatEllipse {
            centre,
            lowest,
            slope,
            semi_axes: [eigen.eigenvalues[long].sqrt().recip(), eigen.eigenvalues[short].sqrt().recip()],
            rotation: axis[1].atan2(axis[0]),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gap::{Cone, Paraboloid, Place, Polyhedron, Reach, Sphere};

    fn of(gap: &dyn Gap, depth: f64) -> Recognised {
        let Reach::Within(reach) = gap.reach(depth) else { panic!("bounded") };
        recognise(gap, depth, &reach)
    }

    #[test]
    fn a_narrow_part_of_a_wide_gap_is_seen() {
        use crate::gap::{AnyGap, Minimum};
        let tip =
            |steep: f64, at: [f64; 2]| Cone::with_slope(steep).unwrap().placed(at, 0.0).unwrap();
        let wide: [AnyGap; 2] =
            [AnyGap::new(Sphere::new(6.6).unwrap()), AnyGap::new(Paraboloid::new([6.6, 6.6]).unwrap())];
        for wide in wide {
            for (steep, at) in [(1.4, [-1.52, 0.24]), (40.0, [-1.5, 0.3]), (300.0, [0.2, 0.7])] {
                let gap = Minimum::new(vec![tip(steep, at), wide.clone()]).unwrap();
                assert_eq!(of(&gap, 0.2356), Recognised::General);
                assert!(crate::homogeneity::degree(&gap, &Rect { min: [-1.8; 2], max: [1.8; 2] }).is_none());
            }
        }
    }

    #[test]
    fn a_turned_and_moved_paraboloid_is_a_quadratic() {
        for ratio in [1.0, 3.0, 1e4] {
            let gap = Paraboloid::new([0.5 * ratio, 0.5]).unwrap().placed([1.3, -0.4], 0.6).unwrap();
            let Recognised::Quadratic { centre, lowest, curvatures, rotation } = of(&gap, 0.1) else {
                panic!("ratio {ratio}: {:?}", of(&gap, 0.1))
            };
            assert!((centre[0] - 1.3).abs() < 1e-9 * ratio && (centre[1] + 0.4).abs() < 1e-9 * ratio, "{centre:?}");
            assert!(lowest.abs() < 1e-12 * ratio);
            assert!(
                (curvatures[1] - 2.0).abs() < 1e-10 && (curvatures[0] * ratio - 2.0).abs() < 1e-10 * ratio,
                "{curvatures:?}"
            );
            assert!(ratio == 1.0 || (rotation.tan() - 0.6f64.tan()).abs() < 1e-8);
        }
    }

    #[test]
    fn cones_and_spheres_are_of_revolution_and_pyramids_are_not() {
        let at = |gap: Cone| gap.placed([7.0, 2.0], 0.0).unwrap();
        let Recognised::Revolution { centre } = of(&at(Cone::new(0.2).unwrap()), 1.0) else { panic!("a cone") };
        assert_eq!(centre, [7.0, 2.0]);
        assert!(matches!(of(&Sphere::new(2.0).unwrap(), 0.5), Recognised::Revolution { .. }));
        assert_eq!(of(&Polyhedron::pyramid(1000, 0.2).unwrap(), 0.5), Recognised::General);
        assert_eq!(of(&Polyhedron::pyramid(4, 0.2).unwrap(), 0.5), Recognised::General);
    }

    #[test]
    fn a_small_quartic_term_is_not_overlooked() {
        let gap = |x: f64, y: f64| x * x + y * y + 1e-6 * x.powi(4);
        let reach = Rect::around([0.0; 2], [1.0; 2]);
        assert_eq!(recognise(&gap, 1.0, &reach), Recognised::General);
    }

    #[test]
    fn a_flat_ellipse_is_found_from_its_rim() {
        let (sin, cos) = 0.4f64.sin_cos();
        let gap = move |x: f64, y: f64| {
            let (u, v) = (cos * (x - 1.0) + sin * y, cos * y - sin * (x - 1.0));
            if (u / 3.0).powi(2) + (v / 0.5).powi(2) <= 1.0 { 0.0 } else { f64::INFINITY }
        };
        let half = [(9.0 * cos * cos + 0.25 * sin * sin).sqrt(), (9.0 * sin * sin + 0.25 * cos * cos).sqrt()];
        let found = recognise(&gap, 1.0, &Rect::around([1.0, 0.0], half));
        let Recognised::FlatEllipse { semi_axes, rotation, .. } = found else { panic!("{found:?}") };
        assert!((semi_axes[0] - 3.0).abs() < 1e-7 && (semi_axes[1] - 0.5).abs() < 1e-8, "{semi_axes:?}");
        assert!((rotation.tan() - 0.4f64.tan()).abs() < 1e-8);
    }
}

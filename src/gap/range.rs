//! Bounds of a gap less a plane over a rectangle: what a proof has to know between the points where the gap was looked at.

use super::Gap;
use super::radial::distances;
use crate::numeric::Interval;
use crate::numeric::geometry::Rect;

/// The highest of some planes.
pub(super) fn of_planes(planes: &[[f64; 3]], rect: &Rect, slope: [f64; 2]) -> [f64; 2] {
    let (c, [w, h]) = (rect.centre(), rect.size());
    // A plane over the rectangle: its value in the middle, half its variation, and what rounding may have done to them.
    let plane = |p: &[f64; 3]| {
        let half = 0.5 * ((p[0] - slope[0]).abs() * w + (p[1] - slope[1]).abs() * h);
        let terms = [p[0] * c[0], p[1] * c[1], p[2]];
        let rounding = 4.0 * f64::EPSILON * (terms.iter().map(|t| t.abs()).sum::<f64>() + half);
        (terms.iter().sum::<f64>(), half + rounding)
    };
    let mut bounds = [f64::NEG_INFINITY; 2];
    // The three highest in the middle, highest first.
    let mut top: [Option<(f64, &[f64; 3])>; 3] = [None; 3];
    for p in planes {
        let (middle, half) = plane(p);
        bounds = [bounds[0].max(middle - half), bounds[1].max(middle + half)];
        let mut carried = Some((middle, p));
        for place in &mut top {
            if carried.is_some_and(|c| place.is_none_or(|t| c.0 > t.0)) {
                std::mem::swap(place, &mut carried);
            }
        }
    }
    // Across ridges and at corners: the highest plane is nowhere below any mean of planes.
    let top: Vec<&[f64; 3]> = top.into_iter().flatten().map(|t| t.1).collect();
    let mut mean = |weights: [f64; 3]| {
        let mut p = [0.0; 3];
        for (w, q) in weights.iter().zip(&top) {
            (0..3).for_each(|m| p[m] += w * q[m]);
        }
        let (middle, half) = plane(&p);
        // The weights add up to 1 but for rounding.
        bounds[0] = bounds[0].max(middle - half - 4.0 * f64::EPSILON * (middle.abs() + half));
    };
    if top.len() >= 2 {
        [0.25, 0.5, 0.75].into_iter().for_each(|t| mean([t, 1.0 - t, 0.0]));
    }
    if top.len() == 3 {
        let third = 1.0 / 3.0;
        for weights in [[third, third, 1.0 - 2.0 * third], [0.5, 0.25, 0.25], [0.25, 0.5, 0.25], [0.25, 0.25, 0.5]] {
            mean(weights);
        }
    }
    bounds
}

/// The planes that can be the highest somewhere in a rectangle.
pub(super) fn highest_somewhere(planes: &[[f64; 3]], rect: &Rect) -> Vec<[f64; 3]> {
    let over = |p: &[f64; 3]| of_planes(std::slice::from_ref(p), rect, [0.0; 2]);
    let floor = planes.iter().map(|p| over(p)[0]).fold(f64::NEG_INFINITY, f64::max);
    planes.iter().filter(|p| over(p)[1] >= floor).copied().collect()
}

/// A generatrix straight between the points `[r, z]`, no material outside.
///
/// Over the segments that the rectangle meets, g lies between z0 + s (r - r0) with the least and the greatest slope s;
/// r itself is convex, bounded by corners and tangents.
pub(super) fn of_segments(points: &[[f64; 2]], rect: &Rect, slope: [f64; 2]) -> [f64; 2] {
    let Interval { lo: near, hi: far, .. } = distances(rect);
    let (first, last) = (points[0][0], points[points.len() - 1][0]);
    if near > last || far < first {
        return [f64::INFINITY; 2];
    }
    let from = points.partition_point(|p| p[0] <= near).clamp(1, points.len() - 1) - 1;
    let to = points.partition_point(|p| p[0] < far).clamp(1, points.len() - 1);
    let mut bounds = [f64::INFINITY, f64::NEG_INFINITY];
    if to - from == 1 {
        // One segment: g = z0 + s (r - r0).
        let [[r0, z0], [r1, z1]] = [points[from], points[to]];
        let s = (z1 - z0) / (r1 - r0);
        let radius = crate::gap::Cone::with_slope(1.0).ok().filter(|_| s != 0.0);
        let r = radius.and_then(|radius| radius.bounds(rect, slope.map(|v| v / s)));
        let ends = r.map(|r| r.map(|r| z0 + s * (r - r0)));
        bounds = match ends {
            Some([a, b]) => [a.min(b), a.max(b)],
            None => {
                let [w, h] = rect.size();
                let half = 0.5 * (slope[0].abs() * w + slope[1].abs() * h);
                [z0 - half, z0 + half]
            }
        };
    } else {
        for pair in points[from..=to].windows(2) {
            let cut = |r: f64| {
                let r = r.clamp(pair[0][0], pair[1][0]);
                pair[0][1] + (pair[1][1] - pair[0][1]) * ((r - pair[0][0]) / (pair[1][0] - pair[0][0]))
            };
            let ends = [cut(near), cut(far)];
            bounds = [bounds[0].min(ends[0].min(ends[1])), bounds[1].max(ends[0].max(ends[1]))];
        }
        let [w, h] = rect.size();
        let half = 0.5 * (slope[0].abs() * w + slope[1].abs() * h);
        bounds = [bounds[0] - half, bounds[1] + half];
    }
    // Rounding of heights between the points.
    let size = points[from..=to].iter().fold(0.0_f64, |m, p| m.max(p[1].abs()));
    let rounding = 16.0 * f64::EPSILON * (size + bounds[0].abs() + bounds[1].abs());
    bounds = [bounds[0] - rounding, bounds[1] + rounding];
    if far > last || near < first {
        bounds[1] = f64::INFINITY;
    }
    bounds
}

#[cfg(test)]
mod tests {
    use crate::gap::Sum;
    use crate::gap::{AnyGap, Cone, Flat, Gap, Minimum, Outline, Paraboloid, Polyhedron, Power, Revolved, Sphere};
    use crate::numeric::geometry::Rect;

    fn kinds() -> Vec<AnyGap> {
        let all = |g: AnyGap| [g.clone().placed([0.1, -0.2], 0.7).map(AnyGap::new).unwrap(), g];
        let cone = AnyGap::new(Cone::with_slope(0.7).unwrap());
        let bowl = AnyGap::new(Paraboloid::new([0.6, 2.0]).unwrap());
        let triangle = [[-0.5, -0.4], [0.6, -0.3], [0.0, 0.5]];
        let mut gaps = Vec::new();
        for gap in [
            cone.clone(),
            bowl.clone(),
            AnyGap::new(Sphere::new(0.8).unwrap()),
            AnyGap::new(Power::new(1.3, 0.6).unwrap()),
            AnyGap::new(Power::new(1.3, 3.2).unwrap()),
            AnyGap::new(Polyhedron::pyramid(3, 0.6).unwrap()),
            AnyGap::new(Polyhedron::truncated_pyramid(5, 0.6, 0.2).unwrap()),
            AnyGap::new(Flat::new(Outline::polygon(&triangle).unwrap())),
            AnyGap::new(Flat::new(Outline::ellipse([0.5, 0.3]).unwrap())),
            AnyGap::new(Revolved::new(vec![[0.0, 0.1], [0.2, 0.1], [0.3, 0.05], [0.8, 1.0]]).unwrap()),
            AnyGap::new(Sum::new(vec![cone.clone(), bowl.clone()]).unwrap()),
            AnyGap::new(Minimum::new(vec![cone.clone(), bowl.clone()]).unwrap()),
            bowl.tilted([0.1, -0.3]),
        ] {
            gaps.extend(all(gap));
        }
        gaps
    }

    #[test]
    fn no_point_of_any_kind_lies_outside_its_range() {
        for (n, gap) in kinds().into_iter().enumerate() {
            for k in 0..400 {
                let f = |m: f64| (m * (k + 1) as f64).fract() - 0.5;
                let c = [1.4 * f(0.754_877_666), 1.4 * f(0.569_840_291)];
                let rect = Rect::around(c, [0.3 * (f(0.819) + 0.51).powi(3), 0.3 * (f(0.671) + 0.51).powi(3)]);
                let slope = [2.0 * f(0.55), 2.0 * f(0.34)];
                let [low, high] = gap.bounds(&rect, slope).expect("an analytic kind");
                for i in 0..=8 {
                    for j in 0..=8 {
                        let x = rect.min[0] + rect.size()[0] * i as f64 / 8.0;
                        let y = rect.min[1] + rect.size()[1] * j as f64 / 8.0;
                        let value = gap.gap(x, y) - slope[0] * (x - c[0]) - slope[1] * (y - c[1]);
                        assert!(
                            low <= value + 1e-12 && value <= high + 1e-12,
                            "kind {n}: {low} {value} {high} {rect:?}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn a_kind_is_its_own_image_in_the_mirrors_that_it_names() {
        let placed = |gap: AnyGap, turn: f64| gap.placed([0.1, -0.2], turn).unwrap();
        let quarter = std::f64::consts::FRAC_PI_2;
        let three = AnyGap::new(Polyhedron::pyramid(3, 0.6).unwrap());
        let six = AnyGap::new(Polyhedron::truncated_pyramid(6, 0.6, 0.2).unwrap());
        let mut gaps = kinds();
        gaps.extend([0.0, quarter, 2.0 * quarter].map(|turn| placed(three.clone(), turn)));
        gaps.extend([placed(six.clone(), quarter), six]);
        gaps.push(placed(three, -quarter).tilted([0.0, 0.3]));
        let mut named = 0;
        for (n, gap) in gaps.into_iter().enumerate() {
            let (c, mirrors) = (gap.known().centre, gap.known().mirrors);
            for axis in (0..2).filter(|&axis| mirrors[axis]) {
                named += 1;
                for k in 0..200 {
                    let f = |m: f64| (m * (k + 1) as f64).fract() - 0.5;
                    let off = [1.4 * f(0.754_877_666), 1.4 * f(0.569_840_291)];
                    let image = [0, 1].map(|m| if m == axis { -off[m] } else { off[m] });
                    let [value, other] = [off, image].map(|o| gap.gap(c[0] + o[0], c[1] + o[1]));
                    let same = value == other || (value - other).abs() < 1e-13;
                    assert!(same, "kind {n}, axis {axis}: {value} {other}");
                }
            }
        }
        assert_eq!(named, 36);
    }

    #[test]
    fn ranges_close_with_the_square_of_the_rectangle_where_the_gap_is_smooth() {
        let c = [0.31, 0.17];
        for gap in kinds().into_iter().filter(|g| g.gap(c[0], c[1]).is_finite()) {
            let Some(slope) = gap.gradient(c[0], c[1]) else { continue };
            let e = 1e-4;
            let [low, high] = gap.bounds(&Rect::around(c, [e; 2]), slope).expect("an analytic kind");
            let first_order = e * (0.3 + slope[0].abs() + slope[1].abs());
            // Power laws below 1 and turned kinks are bounded to first order only.
            assert!(high - low < 6.0 * first_order, "{low} {high}");
        }
    }
}

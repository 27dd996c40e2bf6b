//! Descent to a low point of a gap. What it finds is sampled: a start, a unit of depth, the depth of first touch as far as is seen.

use crate::gap::{AnyGap, Face, Gap, Reach, enclosure};
use crate::numeric::geometry::Rect;

/// The point at this angle and distance.
pub(super) fn along(p: [f64; 2], angle: f64, r: f64) -> [f64; 2] {
    let (sin, cos) = angle.sin_cos();
    [p[0] + r * cos, p[1] + r * sin]
}

/// Turned off the axes and off one another's multiples, so that no symmetric edge lies on a ray.
pub(super) fn spread(count: usize) -> impl Iterator<Item = f64> {
    (0..count).map(move |k| std::f64::consts::TAU * (k as f64 + 0.137) / count as f64)
}

/// Distances that double (`step` = 1) over all magnitudes which still move the point.
pub(super) fn magnitudes(from: [f64; 2], step: usize) -> impl Iterator<Item = f64> {
    let least = (from[0].abs().max(from[1].abs()) * 1e-15).max(1e-305).log2().ceil() as i32;
    (least..1020).step_by(step).map(|k| f64::from(k).exp2())
}

/// The lowest place that can be slid to from `start`, which stays where it is when nothing around is lower.
///
/// Where gradients are known the last digits come from Newton's method on them.
pub(super) fn lowest(gap: &dyn Gap, start: [f64; 2]) -> [f64; 2] {
    let value = |p: [f64; 2]| gap.gap(p[0], p[1]);
    let mut best = (value(start), start, 0.0);
    for angle in spread(8) {
        for r in magnitudes(start, 2) {
            let p = along(start, angle, r);
            let there = value(p);
            if there < best.0 || (best.0.is_nan() && there.is_finite()) {
                best = (there, p, r);
            }
        }
    }
    let r = best.2;
    if r == 0.0 || !best.0.is_finite() {
        return start;
    }
    let (mut p, mut low) = descend(&|x, y| gap.gap(x, y), best.1, 0.5 * r, f64::NEG_INFINITY);
    if !(low.is_finite() && p.iter().all(|v| v.is_finite())) {
        return start;
    }
    for _ in 0..4 {
        let Some(better) = newton_step(gap, p, 1e-5 * r) else { break };
        // Values near the bottom differ by rounding only.
        let as_low = value(better) <= low + 1e-14 * low.abs() + 1e-12 * (best.0 - low);
        if !as_low {
            break;
        }
        (p, low) = (better, low.min(value(better)));
    }
    // Back onto the axes through the start, if that costs nothing.
    for m in 0..2 {
        let mut snapped = p;
        snapped[m] = start[m];
        if (p[m] - start[m]).abs() < 1e-6 * r && value(snapped) <= value(p) {
            p = snapped;
        }
    }
    p
}

/// The lowest point that a descent from the lowest of the gap's own points reaches, and the gap there: the depth of first touch. Where the
/// gap has bounds over rectangles, nothing else is lower by more than rounding, or a descent from there goes on.
pub(crate) fn least(gap: &AnyGap) -> ([f64; 2], f64) {
    gap.first_touch(searched)
}

fn searched(gap: &AnyGap) -> ([f64; 2], f64) {
    let known = gap.known();
    let value = |p: [f64; 2]| gap.gap(p[0], p[1]);
    let centre = known.centre;
    // Known to be the lowest.
    let own = value(centre);
    if own <= known.floor || known.law.is_some_and(|law| law.lowest == own && known.floor > f64::NEG_INFINITY) {
        return (centre, own);
    }
    if let Some((at, low)) = known.face.as_ref().map(Face::lowest) {
        // A hair inside the edge, where the point itself is rounded out of the material.
        let inside = [0, 1].map(|m| at[m] + HAIR * (centre[m] - at[m]));
        if let Some(at) = [at, inside].into_iter().find(|at| value(*at).is_finite()) {
            return (at, low);
        }
    }
    let hole = !own.is_finite();
    let others = known.tips.iter().copied().chain(hole.then(|| somewhere(gap)).flatten()).map(|tip| (tip, value(tip)));
    let lower = |a: &([f64; 2], f64), b: &([f64; 2], f64)| a.1.total_cmp(&b.1);
    let start = std::iter::once((centre, own)).chain(others).filter(|tip| tip.1.is_finite()).min_by(lower);
    let start = start.unwrap_or((centre, own));
    if start.1 <= known.floor {
        return start;
    }
    let mut best = lowest(gap, start.0);
    for _ in 0..MOST_BASINS {
        let here = value(best);
        let height = here.abs().max(own - here);
        let lower = here - if height.is_finite() { (CLOSE * height).max(rounding(gap, best)) } else { 0.0 };
        if lower <= known.floor {
            break;
        }
        let Reach::Within(rect) = gap.reach(lower) else { break };
        match enclosure::lower_than(gap, &rect, lower, best) {
            Some(found) if found.value < lower => best = lowest(gap, found.at),
            _ => break,
        }
    }
    (best, value(best))
}

/// What a value is known to no better than.
fn rounding(gap: &AnyGap, at: [f64; 2]) -> f64 {
    let [low, high] = gap.bounds(&Rect { min: at, max: at }, [0.0; 2]).unwrap_or([0.0; 2]);
    if (high - low).is_finite() { 4.0 * (high - low) } else { 0.0 }
}

/// How far from the edge of a flat its lowest point may be said to be, over the distance from its centre.
const HAIR: f64 = 1e-12;

/// Descents, each from a place that is lower than the one before reached.
const MOST_BASINS: usize = 16;

/// What a lower place has to be lower by, over the height that is known of the gap.
const CLOSE: f64 = 1e-9;

/// A point of the material, where the centre lies in a hole of it.
fn somewhere(gap: &AnyGap) -> Option<[f64; 2]> {
    let Reach::Within(material) = gap.reach(f64::INFINITY) else { return None };
    let finite = material.corners().iter().flatten().all(|x| x.is_finite());
    let found = finite.then(|| enclosure::least(gap, &material, 0.0, f64::INFINITY)).flatten()?;
    found.value.is_finite().then_some(found.at)
}

/// p less (second derivatives)^-1 gradient, the second derivatives by differences over `h`.
fn newton_step(gap: &dyn Gap, p: [f64; 2], h: f64) -> Option<[f64; 2]> {
    let [x, y] = p;
    let [gx, gy] = gap.gradient(x, y)?;
    let (east, west) = (gap.gradient(x + h, y)?, gap.gradient(x - h, y)?);
    let (north, south) = (gap.gradient(x, y + h)?, gap.gradient(x, y - h)?);
    let xx = (east[0] - west[0]) / (2.0 * h);
    let yy = (north[1] - south[1]) / (2.0 * h);
    let xy = (east[1] - west[1] + north[0] - south[0]) / (4.0 * h);
    let det = xx * yy - xy * xy;
    let step = [(yy * gx - xy * gy) / det, (xx * gy - xy * gx) / det];
    (det > 0.0 && step.iter().all(|s| s.is_finite() && s.abs() <= 1e3 * h)).then(|| [x - step[0], y - step[1]])
}

/// Slides down from `start` (Nelder & Mead 1965, three starts with ever smaller first steps) until below `enough` or
/// at a lowest place. Follows valleys of any slenderness.
pub(super) fn descend(gap: &dyn Fn(f64, f64) -> f64, start: [f64; 2], size: f64, enough: f64) -> ([f64; 2], f64) {
    let value = |p: [f64; 2]| {
        let v = gap(p[0], p[1]);
        if v.is_nan() { f64::INFINITY } else { v }
    };
    let mut best = (start, value(start));
    for (restart, size) in [size, 0.03 * size, 1e-3 * size].into_iter().enumerate() {
        let turned = 0.4 + 1.9 * restart as f64;
        let mut simplex =
            [best.0, along(best.0, turned, size), along(best.0, turned + 1.6, size)].map(|p| (p, value(p)));
        for _ in 0..400 {
            simplex.sort_by(|a, b| a.1.total_cmp(&b.1));
            let [low, mid, high] = simplex;
            let flat = simplex.iter().all(|s| (0..2).all(|m| (s.0[m] - low.0[m]).abs() <= 1e-15 * low.0[m].abs()));
            if low.1 < enough || flat {
                break;
            }
            let middle = [0, 1].map(|m| 0.5 * (low.0[m] + mid.0[m]));
            let moved = |t: f64| {
                let p = [0, 1].map(|m| middle[m] + t * (high.0[m] - middle[m]));
                (p, value(p))
            };
            let reflected = moved(-1.0);
            simplex[2] = if reflected.1 < low.1 {
                let further = moved(-2.0);
                if further.1 < reflected.1 { further } else { reflected }
            } else if reflected.1 < mid.1 {
                reflected
            } else {
                let nearer = if reflected.1 < high.1 { moved(-0.5) } else { moved(0.5) };
                if nearer.1 < high.1.min(reflected.1) {
                    nearer
                } else {
                    for s in &mut simplex[1..] {
                        let p = [0, 1].map(|m| 0.5 * (s.0[m] + low.0[m]));
                        *s = (p, value(p));
                    }
                    continue;
                }
            };
        }
        best = simplex.into_iter().fold(best, |a, b| if b.1 < a.1 { b } else { a });
        if best.1 < enough {
            break;
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gap::{Paraboloid, Place};

    #[test]
    fn lowest_place_of_a_tilted_bowl_to_the_last_digits() {
        let bowl = Paraboloid::new([1.0, 300.0]).unwrap().placed([0.3, -2.0], 0.4).unwrap();
        let [x, y] = lowest(&bowl, [0.0; 2]);
        assert!((x - 0.3).abs() < 1e-12 && (y + 2.0).abs() < 1e-12, "{x} {y}");
        assert_eq!(lowest(&Paraboloid::new([1.0, 2.0]).unwrap(), [0.0; 2]), [0.0; 2]);
        assert_eq!(lowest(&|x: f64, _: f64| -x, [0.5; 2]), [0.5; 2]);
        let dent = |x: f64, y: f64| (x - 1.0).abs() + 3.0 * (y + 2.0).abs();
        let [x, y] = lowest(&dent, [0.0; 2]);
        assert!((x - 1.0).abs() < 1e-9 && (y + 2.0).abs() < 1e-9, "{x} {y}");
    }
}

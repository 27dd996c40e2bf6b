//! The upper envelope of planes: where it is lowest, how steeply it rises, and where it lies below a height.

use crate::numeric::Interval;
use crate::numeric::geometry::{Rect, centroid, clip, convex_hull, cross, meeting};

/// The lowest point of the highest of some planes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Lowest {
    /// A bound below the height of all of it; minus infinity when it falls without end.
    pub floor: f64,
    /// Where it is lowest, to rounding; the middle of the flat if it is lowest on one.
    pub point: [f64; 2],
    /// Three planes that no point lies lower on, where they close around it.
    three: Option<Three>,
}

/// Changes of a plane on the way to the lowest point: each leads higher, so that there are few.
const MOST_CHANGES: usize = 10_000;

/// Least weight of three planes that bound from all sides.
const CLOSED: f64 = 1e-6;

/// Relative rounding of heights.
const ROUNDING: f64 = 1e-13;

impl Lowest {
    /// A tip or a flat of height 0 at the origin.
    pub const AT_ORIGIN: Self = Self { floor: 0.0, point: [0.0; 2], three: None };

    /// Of planes with their [`least_rise`].
    pub fn of(planes: &[[f64; 3]], rise: f64, level_direction: Option<f64>) -> Self {
        if level_direction.is_none() { Self::of_rising(planes, rise) } else { Self::of_level(planes) }
    }

    /// Of planes that rise along every ray from anywhere, by at least `rise` a unit of length.
    ///
    /// For any weights w >= 0 of sum 1 with sum w s = 0 (s the slopes), max (s x + c) >= sum w (s x + c) = sum w c for all x: the lowest height
    /// is the largest such sum, which three planes with the origin in the triangle of their slopes have. As in the dual simplex method, the
    /// plane that is the highest where the three meet takes the place of one of them, until that is none other.
    fn of_rising(planes: &[[f64; 3]], rise: f64) -> Self {
        let found = Three::around_origin(planes).map(|mut three| {
            for _ in 0..MOST_CHANGES {
                match three.with_highest(planes) {
                    Some(next) => three = next,
                    None => break,
                }
            }
            three
        });
        let Some(three) = found else { return Self::guess(planes) };
        let point = three.meeting();
        let floor = three.floor().unwrap_or_else(|| height(planes, point) - rounding(planes, point));
        let tip = Self { floor, point, three: Some(three) };
        match level(planes) {
            // On the flat, which bounds all from below.
            Some(level) if level >= floor => {
                let flat = tip.below(planes, rise, level + ROUNDING * level.abs()).1;
                let middle = if flat.len() >= 3 { centroid(&flat) } else { point };
                let point = if middle.iter().all(|x| x.is_finite()) { middle } else { point };
                Self { floor: level, point, ..tip }
            }
            _ => tip,
        }
    }

    /// Of planes that do not rise in some direction.
    fn of_level(planes: &[[f64; 3]]) -> Self {
        lowest_on_line(planes).map_or_else(
            || Self { floor: f64::NEG_INFINITY, ..Self::AT_ORIGIN },
            |(low, point)| Self { floor: low - rounding(planes, point), point, three: None },
        )
    }

    /// Of planes of which nothing is known.
    fn guess(planes: &[[f64; 3]]) -> Self {
        Self { floor: level(planes).unwrap_or(f64::NEG_INFINITY), ..Self::AT_ORIGIN }
    }

    /// What lies below a height where the planes rise by at least `rise` a unit of length in every direction: a rectangle that holds it, and
    /// its corners to rounding.
    pub fn below(&self, planes: &[[f64; 3]], rise: f64, level: f64) -> (Rect, Vec<[f64; 2]>) {
        let heights = planes.iter().fold(level.abs(), |m, p| m.max(p[2].abs()));
        let mut window = self.three.and_then(|three| three.below(level)).unwrap_or_else(|| {
            let lowest = planes.iter().map(|p| at(p, self.point)).fold(f64::INFINITY, f64::min);
            Rect::around(self.point, [1.001 * (level - lowest) / rise; 2])
        });
        loop {
            let mut region = window.corners().to_vec();
            for [a, b, c] in planes.iter().filter(|p| p[0] != 0.0 || p[1] != 0.0) {
                if !region.is_empty() {
                    // In units of the plane, so that nothing overflows.
                    let size = a.abs().max(b.abs());
                    region = clip(&region, a / size, b / size, (c - level) / size);
                }
            }
            // Only rounding can have emptied it.
            let Some(rect) = Rect::holding(region.iter().copied()) else { return (window, region) };
            // Rounding of the corners: of coordinates, and of heights over the least slope.
            let size = window.corners().into_iter().flatten().fold(0.0_f64, |m, v| m.max(v.abs()));
            let margin = 1e-14 * size + 1e-14 * heights / rise;
            let [w, h] = rect.size();
            let rect = Rect::around(rect.centre(), [0.5 * w + margin, 0.5 * h + margin]);
            // A window that was far too large cost digits.
            let shrunk = rect.longer_side() < 1e-3 * window.size()[0];
            window = rect;
            if !shrunk {
                return (rect, region);
            }
        }
    }
}

/// The height of one plane.
fn at(plane: &[f64; 3], [x, y]: [f64; 2]) -> f64 {
    plane[0] * x + plane[1] * y + plane[2]
}

/// The size of the terms that make it up.
fn size(plane: &[f64; 3], [x, y]: [f64; 2]) -> f64 {
    (plane[0] * x).abs() + (plane[1] * y).abs() + plane[2].abs()
}

fn height(planes: &[[f64; 3]], point: [f64; 2]) -> f64 {
    planes.iter().map(|p| at(p, point)).fold(f64::NEG_INFINITY, f64::max)
}

/// What rounding leaves of it.
fn rounding(planes: &[[f64; 3]], point: [f64; 2]) -> f64 {
    ROUNDING * planes.iter().map(|p| size(p, point)).fold(0.0, f64::max)
}

/// Height of the highest level plane.
fn level(planes: &[[f64; 3]]) -> Option<f64> {
    planes.iter().filter(|p| p[0] == 0.0 && p[1] == 0.0).map(|p| p[2]).reduce(f64::max)
}

/// Three planes whose slopes hold the origin between them, counter-clockwise.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Three([[f64; 3]; 3]);

impl Three {
    /// Three of the outermost slopes.
    fn around_origin(planes: &[[f64; 3]]) -> Option<Self> {
        let hull = convex_hull(planes.iter().map(|p| [p[0], p[1]]).collect());
        // Of those of one slope the highest.
        let of = |s: [f64; 2]| {
            let same = planes.iter().filter(|p| p[0] == s[0] && p[1] == s[1]);
            same.copied().max_by(|a, b| a[2].total_cmp(&b[2]))
        };
        let fan = (1..hull.len().max(2) - 1).map(|k| [hull[0], hull[k], hull[k + 1]]);
        fan.filter_map(|[a, b, c]| Some(Self([of(a)?, of(b)?, of(c)?]))).find(Self::holds_origin)
    }

    /// Weights of the three, up to a common factor: the areas of the triangles that each two make with the origin, by directions so that
    /// nothing overflows.
    fn weights(&self) -> [f64; 3] {
        let Self(p) = self;
        let size = p.map(|p| p[0].hypot(p[1]));
        let unit = [0, 1, 2].map(|k| [p[k][0] / size[k], p[k][1] / size[k]]);
        let least = size.into_iter().fold(f64::INFINITY, f64::min);
        [0, 1, 2].map(|k| cross(unit[(k + 1) % 3], unit[(k + 2) % 3]) * (least / size[k]))
    }

    fn holds_origin(&self) -> bool {
        let weights = self.weights();
        weights.iter().all(|w| *w >= 0.0) && weights.iter().sum::<f64>() > 0.0
    }

    /// Where the three are of one height.
    fn meeting(&self) -> [f64; 2] {
        let Self(mut p) = *self;
        // Differences to the least steep one lose the fewest digits.
        p.sort_by(|a, b| a[0].hypot(a[1]).total_cmp(&b[0].hypot(b[1])));
        meeting([1, 2].map(|k| [0, 1, 2].map(|m| p[k][m] - p[0][m])))
    }

    /// A rectangle around what lies below a height on all three; `None` where they do not close well.
    fn below(&self, level: f64) -> Option<Rect> {
        let weights = self.weights();
        let sum: f64 = weights.iter().sum();
        if weights.iter().any(|w| *w < CLOSED * sum) {
            return None;
        }
        let Self(three) = self;
        let corners = [0, 1, 2].map(|k| meeting([three[k], three[(k + 1) % 3]].map(|[a, b, c]| [a, b, c - level])));
        let size = corners.iter().flatten().fold(0.0_f64, |m, x| m.max(x.abs()));
        let held = Rect::holding(corners)?;
        let [w, h] = held.size();
        let margin = 1e-3 * (w + h) + 1e-9 * size;
        let around = Rect::around(held.centre(), [0.5 * w + margin, 0.5 * h + margin]);
        around.size().iter().all(|s| s.is_finite()).then_some(around)
    }

    /// The same with the plane that is highest above their meeting; `None` where there is none.
    fn with_highest(&self, planes: &[[f64; 3]]) -> Option<Self> {
        let Self(three) = self;
        let point = self.meeting();
        let weights = self.weights();
        let sum: f64 = weights.iter().sum();
        let own: f64 = three.iter().zip(weights).map(|(p, w)| p[2] * w).sum::<f64>() / sum;
        let above = |p: &&[f64; 3]| {
            at(p, point) - own > ROUNDING * (size(p, point) + own.abs()) && !(p[0] == 0.0 && p[1] == 0.0)
        };
        let next = planes.iter().filter(above).max_by(|a, b| at(a, point).total_cmp(&at(b, point)))?;
        let with = |k: usize| {
            let mut all = *three;
            all[k] = *next;
            Self(all)
        };
        // The one of which the least weight is the largest.
        let least = |three: &Self| three.weights().into_iter().fold(f64::INFINITY, f64::min);
        (0..3).map(with).filter(Self::holds_origin).max_by(|a, b| least(a).total_cmp(&least(b)))
    }

    /// A bound below the envelope, for all rounding; `None` where the origin lies on the border of the triangle as far as can be seen.
    fn floor(&self) -> Option<f64> {
        let Self(three) = self;
        let [a, b, c] = three.map(|p| p.map(Interval::point));
        let area = |p: [Interval; 3], q: [Interval; 3]| p[0] * q[1] - p[1] * q[0];
        let weights = [area(b, c), area(c, a), area(a, b)];
        let sum = weights[0] + weights[1] + weights[2];
        let holds = weights.iter().all(|w| w.lo >= 0.0) && sum.lo > 0.0;
        let mean = (weights[0] * a[2] + weights[1] * b[2] + weights[2] * c[2]) / sum;
        (holds && mean.lo.is_finite()).then_some(mean.lo)
    }
}

/// The least height of the highest of some planes whose slopes all lie on one line through the origin, and a point where it is so;
/// `None` when they fall without end, or for other planes.
fn lowest_on_line(planes: &[[f64; 3]]) -> Option<(f64, [f64; 2])> {
    let steepest = planes.iter().max_by(|a, b| a[0].hypot(a[1]).total_cmp(&b[0].hypot(b[1])))?;
    let length = steepest[0].hypot(steepest[1]);
    let level = planes.iter().filter(|p| p[0] == 0.0 && p[1] == 0.0).map(|p| p[2]).fold(f64::NEG_INFINITY, f64::max);
    if length == 0.0 {
        return Some((level, [0.0; 2]));
    }
    let u = [steepest[0] / length, steepest[1] / length];
    let on_line = |p: &[f64; 3]| (p[0] * u[1] - p[1] * u[0]).abs() <= 1e-14 * p[0].hypot(p[1]);
    if !planes.iter().all(on_line) {
        // A level plane holds all from below.
        return (level > f64::NEG_INFINITY).then_some((level, [0.0; 2]));
    }
    let slope = |p: &[f64; 3]| p[0] * u[0] + p[1] * u[1];
    let (falling, rising): (Vec<_>, Vec<_>) = planes.iter().filter(|p| slope(p) != 0.0).partition(|p| slope(p) < 0.0);
    // Two lines of opposite slope meet no higher than the envelope anywhere; the highest such place is its lowest point.
    let meet = |p: &[f64; 3], q: &[f64; 3]| (p[2] * slope(q) - q[2] * slope(p)) / (slope(q) - slope(p));
    let mut best: Option<(f64, f64)> = None;
    for p in &falling {
        for q in &rising {
            let height = meet(p, q);
            if best.is_none_or(|b| height > b.0) {
                best = Some((height, (height - p[2]) / slope(p)));
            }
        }
    }
    match best {
        Some((height, t)) if height >= level => Some((height, u.map(|u| u * t))),
        _ if level > f64::NEG_INFINITY => {
            // Somewhere on the level part: between the lines that bound it.
            let below = |p: &[f64; 3]| (level - p[2]) / slope(p);
            let from = falling.iter().map(&below).fold(f64::NEG_INFINITY, f64::max);
            let to = rising.iter().map(below).fold(f64::INFINITY, f64::min);
            let t = match (from.is_finite(), to.is_finite()) {
                (true, true) => 0.5 * (from + to),
                (true, false) => from,
                (false, true) => to,
                _ => 0.0,
            };
            Some((level, u.map(|u| u * t)))
        }
        _ => None,
    }
}

/// Least slope of the highest of these planes along any ray far out, and the angle of a direction in which it does not rise.
pub(super) fn least_rise(planes: &[[f64; 3]]) -> (f64, Option<f64>) {
    // The rise along a direction is that of the plane which is steepest there. It is least half-way between two neighbours of the
    // convex hull of the slopes; a direction that no plane rises in exists when the hull does not hold the origin.
    let slopes: Vec<[f64; 2]> = planes.iter().map(|p| [p[0], p[1]]).collect();
    let hull = convex_hull(slopes);
    let n = hull.len();
    let mut least = f64::INFINITY;
    if n < 3 {
        // Slopes on a line: across it nothing rises.
        let (a, b) = (hull[0], hull[n - 1]);
        let along = if a == b { [-a[0], -a[1]] } else { [a[1] - b[1], b[0] - a[0]] };
        let sense = if along[0] * a[0] + along[1] * a[1] > 0.0 { -1.0 } else { 1.0 };
        return (0.0, Some((sense * along[1]).atan2(sense * along[0])));
    }
    for k in 0..n {
        // Along the outward normal of a side of the hull both of its ends rise by the same: that of the less steep one is the better known.
        let (a, b) = (hull[k], hull[(k + 1) % n]);
        let (mild, steep) = if a[0].hypot(a[1]) <= b[0].hypot(b[1]) { (a, b) } else { (b, a) };
        let normal = [b[1] - a[1], a[0] - b[0]];
        let length = normal[0].hypot(normal[1]);
        let rise = (normal[0] * mild[0] + normal[1] * mild[1]) / length;
        // Its rounding, and that of the normal.
        let rounding = 1e-15 * mild[0].hypot(mild[1]) * (steep[0].hypot(steep[1]) / length).max(1.0);
        if !(rise > rounding) {
            return (0.0, Some(normal[1].atan2(normal[0])));
        }
        least = least.min(rise);
    }
    (least, None)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Walls of any steepness leave the lowest point where it is.
    #[test]
    fn lowest_beside_steep_walls() {
        let tip = [[0.84, -0.51, 0.19], [-1.0, -1.0, 0.0086], [1e-160, 1.1, -0.07], [4.0, 0.68, 0.25]];
        let (rise, level) = least_rise(&tip);
        assert_eq!(level, None);
        let alone = Lowest::of(&tip, rise, level);
        assert!((alone.floor - height(&tip, alone.point)).abs() < 1e-14);
        for wall in [1e3, 1e9, 1e30, 1e160] {
            let mut all = tip.to_vec();
            all.push([wall, 1.2, 0.3]);
            let (rise, level) = least_rise(&all);
            assert_eq!(level, None);
            let walled = Lowest::of(&all, rise, level);
            // The tip lies beyond the wall's foot, where x < 0.
            assert!(alone.point[0] < 0.0 && (walled.floor - alone.floor).abs() < 1e-14, "{walled:?} {alone:?}");
            let (rect, _) = walled.below(&all, rise, alone.floor + 1e-3);
            assert!(rect.size()[0] < 0.1 && rect.contains(alone.point), "{rect:?}");
        }
    }

    /// No point lies below the floor, and the lowest point no higher than any other.
    #[test]
    fn no_point_lies_below_the_floor() {
        let mut seed = 1u64;
        let mut draw = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1u64 << 53) as f64 * 2.0 - 1.0
        };
        let mut rising = 0;
        for _ in 0..300 {
            let n = 3 + (4.0 * (draw() + 1.0)) as usize;
            let planes: Vec<[f64; 3]> =
                (0..n).map(|_| [draw(), draw(), 0.3 * draw()].map(|v| v * 10f64.powf(4.0 * v))).collect();
            let (rise, level) = least_rise(&planes);
            if level.is_some() {
                continue;
            }
            rising += 1;
            let lowest = Lowest::of(&planes, rise, level);
            let least = height(&planes, lowest.point);
            assert!(
                lowest.floor <= least + 1e-12 && least - lowest.floor < 1e-9 * (1.0 + least.abs()),
                "{lowest:?} {least}"
            );
            for _ in 0..200 {
                let size = 10f64.powf(3.0 * draw());
                let near = [lowest.point[0] + size * draw(), lowest.point[1] + size * draw()];
                assert!(height(&planes, near) >= lowest.floor, "{planes:?}");
            }
        }
        assert!(rising > 50, "{rising}");
    }

    #[test]
    fn a_flat_is_lowest_in_its_middle() {
        let planes = [[1.0, 0.0, -1.0], [-1.0, 0.0, -3.0], [0.0, 1.0, -1.0], [0.0, -1.0, -1.0], [0.0, 0.0, 0.5]];
        let (rise, level) = least_rise(&planes);
        assert_eq!(level, None);
        let lowest = Lowest::of(&planes, rise, level);
        assert!(
            lowest.floor == 0.5 && (lowest.point[0] + 1.0).abs() < 1e-9 && lowest.point[1].abs() < 1e-9,
            "{lowest:?}"
        );
    }
}

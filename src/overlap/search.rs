//! A search for the place where a gap is less than a depth, when nothing but its values is known. What it finds is sampled: it may
//! choose the grid, and proves nothing.

use std::cell::Cell;

use super::descent::{along, descend, magnitudes, spread};
use crate::gap::Reach;
use crate::numeric::geometry::Rect;
use crate::numeric::scalar::{bisected, golden};

/// A ray that stays inside for so many times the shortest one is taken to have no end.
const LONGEST: f64 = 1e12;

/// A seed whose rays are so unequal in length lies at an edge.
const AT_EDGE: f64 = 1e6;

/// How often a seed at an edge is moved away from it.
const RECENTRINGS: usize = 4;

/// Rays from a seed, before the peaks between them are refined.
const RAYS: usize = 48;

/// Dips along the rays that are followed down to their lowest place.
const HOLLOWS: usize = 12;

/// Points a side at which the border of the rectangle found is probed.
const PROBES: usize = 48;

/// Pieces of contact that are followed one by one; more of them share a rectangle that is grown as a whole.
const MOST_SEEDS: usize = 40;

/// Values of the gap that go into following pieces one by one, and their tips.
const MOST_LOOKS: usize = 400_000;

/// What the rectangle found is enlarged by, relative to its sides: rays and refined peaks are good to about 1e-6.
const MARGIN: f64 = 1e-3;

/// A peak whose value is not known before.
const NONE: (f64, f64) = (f64::NAN, f64::NEG_INFINITY);

/// Where `gap` is less than `depth`, starting from `centre`; never [`Reach::Unknown`].
///
/// The search needs no scale and no first guess but the centre: it follows rays over all magnitudes of f64,
/// slides down to the lowest place if it meets none, follows the tips of slender contacts (up to 1e6 : 1, at any
/// angle), and probes the border of the rectangle until nothing passes through it. It samples: of several separate
/// contacts it finds those that are seen under about a tenth of a radian from the centre or from one another, and those
/// in a hollow that wide. A value that is NaN (an overflow) counts as below the depth: it ends nothing.
pub(super) fn search(gap: &dyn Fn(f64, f64) -> f64, depth: f64, centre: [f64; 2]) -> Reach {
    let looks = Cell::new(0);
    let gap = &counted(gap, &looks);
    let inside = |p: [f64; 2]| !(gap(p[0], p[1]) >= depth);
    let endless = |from: [f64; 2]| Reach::Unbounded { from, along: 0.0 };
    let Some(seed) = first_seed(gap, depth, centre) else { return Reach::Nowhere };
    let Some(mut rect) = piece(&inside, seed, &looks) else { return endless(seed) };
    for _ in 1..MOST_SEEDS {
        if looks.get() > MOST_LOOKS {
            break;
        }
        let Some(next) = seed_outside(gap, depth, centre, seed, &rect) else { return Reach::Within(rect) };
        match piece(&inside, next, &looks) {
            Some(more) if !within(&more, &rect) => rect = rect.union(&more),
            Some(_) => rect = rect.scaled(2.0),
            None => return endless(next),
        }
    }
    // Very many pieces, or one of a shape that rays do not follow: grow until the border is clear.
    for _ in 0..LONGEST.log2() as usize {
        if border_seed(gap, depth, &rect).is_none() {
            return Reach::Within(rect);
        }
        rect = rect.scaled(2.0);
    }
    endless(seed)
}

/// Rectangles around the separate places where `gap` is less than `depth`, as far as a search and a lattice over all of them
/// see; `None` without an end.
pub(super) fn pieces(gap: &dyn Fn(f64, f64) -> f64, depth: f64, centre: [f64; 2]) -> Option<Vec<Rect>> {
    let looks = Cell::new(0);
    let gap = &counted(gap, &looks);
    let inside = |p: [f64; 2]| !(gap(p[0], p[1]) >= depth);
    let Some(seed) = first_seed(gap, depth, centre) else { return Some(Vec::new()) };
    let mut found = vec![piece(&inside, seed, &looks)?];
    while found.len() < MOST_SEEDS && looks.get() <= MOST_LOOKS {
        let all = found.iter().copied().reduce(|a, b| a.union(&b))?;
        let lattice = (0..LATTICE * LATTICE).map(|k| {
            let t = [k % LATTICE, k / LATTICE].map(|i| (i as f64 + 0.5) / LATTICE as f64);
            [0, 1].map(|m| all.min[m] + t[m] * all.size()[m])
        });
        // One piece has nothing between its parts.
        let between = || lattice.clone().find(|&p| inside(p) && !found.iter().any(|rect| rect.contains(p)));
        let next = seed_outside(gap, depth, centre, seed, &all).or_else(|| (found.len() > 1).then(between).flatten());
        let Some(next) = next else { return Some(found) };
        let more = piece(&inside, next, &looks)?;
        // Rays do not follow its shape.
        if !more.contains(next) {
            break;
        }
        found.push(more);
    }
    match search(gap, depth, centre) {
        Reach::Within(rect) => Some(vec![rect]),
        _ => None,
    }
}

/// The gap, with a count of the times that it was asked for.
fn counted<'a>(gap: &'a dyn Fn(f64, f64) -> f64, looks: &'a Cell<usize>) -> impl Fn(f64, f64) -> f64 + 'a {
    move |x, y| {
        looks.set(looks.get() + 1);
        gap(x, y)
    }
}

/// Points a side at which the rectangle around several pieces is looked at for more of them.
const LATTICE: usize = 256;

fn within(inner: &Rect, outer: &Rect) -> bool {
    outer.contains(inner.min) && outer.contains(inner.max)
}

/// A point inside: the centre, or one seen from it, or the lowest place that can be slid to.
pub(super) fn first_seed(gap: &dyn Fn(f64, f64) -> f64, depth: f64, centre: [f64; 2]) -> Option<[f64; 2]> {
    let mut best = (gap(centre[0], centre[1]), centre, 0.0);
    if best.0 < depth {
        return Some(centre);
    }
    for (directions, step) in [(8, 2), (64, 1)] {
        for angle in spread(directions) {
            for r in magnitudes(centre, step) {
                let p = along(centre, angle, r);
                let value = gap(p[0], p[1]);
                if value < depth {
                    return Some(p);
                }
                if value < best.0 || best.0.is_nan() {
                    best = (value, p, r);
                }
            }
        }
        if best.2 > 0.0 && best.0.is_finite() {
            let (p, value) = descend(gap, best.1, 0.5 * best.2, depth);
            if value < depth {
                return Some(p);
            }
        }
    }
    None
}

/// A point inside that the rectangle does not hold: on its border, or further out as seen from the centre.
fn seed_outside(
    gap: &dyn Fn(f64, f64) -> f64,
    depth: f64,
    centre: [f64; 2],
    seed: [f64; 2],
    rect: &Rect,
) -> Option<[f64; 2]> {
    if let Some(p) = border_seed(gap, depth, rect) {
        return Some(p);
    }
    let [w, h] = rect.size();
    let outside = |p: &[f64; 2]| !rect.contains(*p) && gap(p[0], p[1]) < depth;
    let mut hollows: Vec<(f64, [f64; 2], f64)> = Vec::new();
    for from in [seed, centre] {
        for angle in spread(RAYS) {
            let near = 0.3 * w.min(h);
            let place = |k: i32| along(from, angle, near * (0.25 * f64::from(k)).exp2());
            let mut before = [f64::NEG_INFINITY; 2];
            for k in 0..96 {
                let p = place(k);
                let value = gap(p[0], p[1]);
                if value < depth && !rect.contains(p) {
                    return Some(p);
                }
                if before[1] < before[0] && before[1] < value && !rect.contains(place(k - 1)) {
                    hollows.push((before[1], place(k - 1), near * (0.25 * f64::from(k - 1)).exp2()));
                }
                before = [before[1], value];
            }
        }
    }
    // A ray that misses a tip still dips beside it.
    hollows.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (_, p, r) in hollows.into_iter().take(HOLLOWS) {
        let (p, value) = descend(gap, p, 0.1 * r, depth);
        if value < depth && !rect.contains(p) {
            return Some(p);
        }
    }
    // The neighbourhood, evenly.
    let wide = Rect::around(rect.centre(), [2.0 * w, 2.0 * h]);
    (0..PROBES * PROBES)
        .map(|k| {
            let t = [k % PROBES, k / PROBES].map(|i| (i as f64 + 0.5) / PROBES as f64);
            [wide.min[0] + t[0] * 4.0 * w, wide.min[1] + t[1] * 4.0 * h]
        })
        .find(outside)
}

/// A point inside on the border of the rectangle, the lowest places between the probes included.
fn border_seed(gap: &dyn Fn(f64, f64) -> f64, depth: f64, rect: &Rect) -> Option<[f64; 2]> {
    let corners = rect.corners();
    for k in 0..4 {
        let (a, b) = (corners[k], corners[(k + 1) % 4]);
        let at = |t: f64| [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];
        let value = |t: f64| {
            let [x, y] = at(t);
            gap(x, y)
        };
        let values: Vec<f64> = (0..=PROBES).map(|i| value(i as f64 / PROBES as f64)).collect();
        for i in 0..=PROBES {
            if values[i] < depth {
                return Some(at(i as f64 / PROBES as f64));
            }
            let (before, after) = (values[i.saturating_sub(1)], values[(i + 1).min(PROBES)]);
            if values[i] <= before && values[i] <= after && (values[i] < before || values[i] < after) {
                let cell = [i.saturating_sub(1), (i + 1).min(PROBES)].map(|i| i as f64 / PROBES as f64);
                let t = golden(|t| -value(t), cell, 40, NONE).at;
                if value(t) < depth {
                    return Some(at(t));
                }
            }
        }
    }
    None
}

/// The rectangle around the piece of contact that holds `seed`, as far as rays from it see; `None` without an end.
fn piece(inside: &dyn Fn([f64; 2]) -> bool, seed: [f64; 2], looks: &Cell<usize>) -> Option<Rect> {
    // The nearest edge sets the scale: seen from a point just inside of it that would be its distance from the edge.
    let mut seed = seed;
    let mut nearest = f64::INFINITY;
    for _ in 0..RECENTRINGS {
        let exits = first_exits(inside, seed);
        nearest = exits.iter().map(|exit| exit.1).fold(f64::INFINITY, f64::min);
        let &(angle, farthest) = exits.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
        // The last of the distances, which grow four times from one to the next, that was inside.
        let middle = along(seed, angle, 0.25 * farthest);
        if farthest <= AT_EDGE * nearest || !inside(middle) {
            break;
        }
        seed = middle;
    }
    let exit = |angle: f64| leave(|r| inside(along(seed, angle, r)), nearest);
    let radii: Vec<(f64, f64)> = spread(RAYS).map(|angle| (angle, exit(angle))).collect();
    let shortest = radii.iter().map(|r| r.1).fold(f64::INFINITY, f64::min).max(f64::MIN_POSITIVE);
    let step = std::f64::consts::TAU / RAYS as f64;
    let mut rect = Rect { min: seed, max: seed };
    // The tips: peaks of the radius itself, and of how far it reaches along either axis.
    let reaches: [&dyn Fn(f64, f64) -> f64; 5] =
        [&|_, r| r, &|a, r| r * a.cos(), &|a, r| r * a.sin(), &|a, r| -r * a.cos(), &|a, r| -r * a.sin()];
    for &(angle, r) in &radii {
        rect = rect.union(&Rect { min: along(seed, angle, r), max: along(seed, angle, r) });
    }
    for reach in reaches {
        for k in 0..RAYS {
            let value = |k: usize| reach(radii[k % RAYS].0, radii[k % RAYS].1);
            if !(value(k) > 0.0 && value(k) >= value(k + RAYS - 1) && value(k) >= value(k + 1)) {
                continue;
            }
            // As round as a circle here: the margin covers what lies between the rays.
            let round = value(k) - value(k + 1).min(value(k + RAYS - 1)) <= 1e-4 * value(k);
            if round || looks.get() > MOST_LOOKS {
                continue;
            }
            let middle = radii[k].0;
            let angle = golden(|a| reach(a, exit(a)), [middle - step, middle + step], 60, NONE).at;
            let r = exit(angle);
            if r > LONGEST * shortest || !r.is_finite() {
                return None;
            }
            let tip = along(seed, angle, r);
            rect = rect.union(&Rect { min: tip, max: tip });
        }
    }
    let [w, h] = rect.size();
    // A margin along each side, and never a rectangle without inside.
    let slack = |side: f64, other: f64| MARGIN * side + 1e-9 * other;
    let grown = Rect::around(rect.centre(), [0.5 * w + slack(w, h), 0.5 * h + slack(h, w)]);
    Some(grown)
}

/// The first place outside along a few rays over all magnitudes, where there is one: angle and distance.
fn first_exits(inside: &dyn Fn([f64; 2]) -> bool, from: [f64; 2]) -> Vec<(f64, f64)> {
    let moves = |r: f64| along(from, 0.1, r) != from;
    let exit = |angle: f64| magnitudes(from, 2).filter(|&r| moves(r)).find(|&r| !inside(along(from, angle, r)));
    spread(7).filter_map(|angle| exit(angle).map(|r| (angle, r))).collect()
}

/// The distance at which a ray leaves, to 1e-7: doubled or halved from `guess`, then bisected.
fn leave(inside: impl Fn(f64) -> bool, guess: f64) -> f64 {
    let (mut within, mut beyond) = (0.0, guess);
    if inside(guess) {
        while inside(beyond) {
            within = beyond;
            beyond *= 2.0;
            // Beyond the range of numbers nothing grows any more.
            if !(beyond > within && beyond < f64::INFINITY && beyond <= 4.0 * LONGEST * guess) {
                return f64::INFINITY;
            }
        }
    } else {
        for _ in 0..60 {
            within = 0.5 * beyond;
            if inside(within) {
                break;
            }
            beyond = within;
        }
    }
    bisected(inside, [within, beyond], 24)[1]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tilted ellipse with semi-axes a, b about c: exact half sides of its bounding box.
    fn ellipse(a: f64, b: f64, turn: f64) -> [f64; 2] {
        let (sin, cos) = turn.sin_cos();
        [(a * cos).hypot(b * sin), (a * sin).hypot(b * cos)]
    }

    /// The origin lies on the edge of the overlap: the first place inside that is seen from it is 1e-16 away.
    #[test]
    fn a_search_that_starts_at_an_edge() {
        let gap = |x: f64, y: f64| ((x - 1.0).powi(2) + y * y).min(0.3 + (x + 1.5).powi(2) + y * y);
        for depth in [1.0 - 1e-12, 1.0, 1.0 + 1e-12] {
            let Reach::Within(found) = search(&gap, depth, [0.0; 2]) else { panic!("without an end at {depth}") };
            let exact = Rect { min: [-1.5 - 0.7f64.sqrt(), -1.0], max: [2.0, 1.0] };
            let room = exact.scaled(1.01);
            assert!(within(&exact, &found) && within(&found, &room), "{found:?} at {depth}");
        }
    }

    #[test]
    fn bounding_box_of_slender_turned_ellipses_anywhere_at_any_scale() {
        for scale in [1e-280, 1e-9, 1.0, 1e120] {
            for ratio in [1.0, 30.0, 1e4, 1e6] {
                for (k, turn) in [0.0, 0.3, 0.5, 1.1, 2.9].into_iter().enumerate() {
                    for offset in [0.0, 2.7] {
                        let (sin, cos) = f64::sin_cos(turn);
                        let c = [offset * (k as f64 - 1.0), -offset];
                        let gap = |x: f64, y: f64| {
                            let (x, y) = (x / scale - c[0], y / scale - c[1]);
                            (x * cos + y * sin).powi(2) + ((y * cos - x * sin) * ratio).powi(2) - 1.0
                        };
                        let half = ellipse(1.0, 1.0 / ratio, turn).map(|h| h * scale);
                        let exact = Rect::around(c.map(|c| c * scale), half);
                        let Reach::Within(found) = search(&gap, 0.0, [0.0; 2]) else {
                            panic!("{scale} {ratio} {turn} {offset}: {:?}", search(&gap, 0.0, [0.0; 2]))
                        };
                        // Inside the margin, and not much larger than need be.
                        assert!(within(&exact, &found), "{scale} {ratio} {turn} {offset}: {found:?} {exact:?}");
                        let excess = [0, 1].map(|m| found.size()[m] / exact.size()[m]);
                        assert!(excess.iter().all(|&e| e < 2.1), "{scale} {ratio} {turn} {offset}: {excess:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_ray_ends_at_the_end_of_numbers() {
        for guess in [1e-320, 1.0, 1e299, 1e308, 0.0] {
            assert_eq!(leave(|_| true, guess), f64::INFINITY, "{guess}");
        }
        let found = leave(|r| r < 1e300, 1e299);
        assert!((found / 1e300 - 1.0).abs() < 1e-6);
    }

    #[test]
    fn strips_have_no_end_and_high_ground_no_inside() {
        for turn in [0.0f64, 0.2, 1.0, 2.3] {
            let strip = |x: f64, y: f64| (x * turn.cos() + y * turn.sin() - 0.3).powi(2);
            assert!(matches!(search(&strip, 1e-6, [0.0; 2]), Reach::Unbounded { .. }));
            assert_eq!(search(&strip, -1e-6, [0.0; 2]), Reach::Nowhere);
        }
        assert!(matches!(search(&|_, _| 0.0, 1.0, [0.0; 2]), Reach::Unbounded { .. }));
        assert_eq!(search(&|_, _| f64::NAN, 1.0, [0.0; 2]), Reach::Nowhere);
        assert_eq!(search(&|_, _| f64::INFINITY, 1.0, [0.0; 2]), Reach::Nowhere);
        assert!(matches!(search(&|x, y| -x * x - y * y, 1.0, [0.0; 2]), Reach::Unbounded { .. }));
    }

    #[test]
    fn separate_tips_and_re_entrant_contacts_are_all_held() {
        let tips = |x: f64, y: f64| {
            let one = |cx: f64, cy: f64, r: f64| 0.5 * ((x - cx).powi(2) + (y - cy).powi(2)) / r;
            one(-1.0, 0.0, 1.0).min(one(4.0, 3.0, 0.5)).min(one(0.0, -6.0, 2.0))
        };
        let Reach::Within(found) = search(&tips, 0.1, [0.0; 2]) else { panic!("bounded") };
        let exact =
            Rect { min: [-1.0 - 0.2f64.sqrt(), -6.0 - 0.4f64.sqrt()], max: [4.0 + 0.1f64.sqrt(), 3.0 + 0.1f64.sqrt()] };
        assert!(within(&exact, &found) && found.size()[0] < 2.5 * exact.size()[0], "{found:?}");
        // A thousandth of a radian wide, in a hollow that is not.
        let far = |x: f64, y: f64| ((x - 50.0).powi(2) + y * y).min((x + 50.0).powi(2) + (y - 9.0).powi(2));
        let Reach::Within(found) = search(&far, 2.5e-3, [0.0; 2]) else { panic!("bounded") };
        assert!(within(&Rect { min: [-50.05, -0.05], max: [50.05, 9.05] }, &found), "{found:?}");
        assert_eq!(pieces(&far, 2.5e-3, [0.0; 2]).unwrap().len(), 2);
        // Three quarters of a ring: the seed sees a part of it only.
        let hook = |x: f64, y: f64| if x > 0.0 && y > 0.0 { 1.0 } else { (x.hypot(y) - 1.0).abs() };
        let Reach::Within(found) = search(&hook, 0.05, [0.0; 2]) else { panic!("bounded") };
        assert!(within(&Rect { min: [-1.05, -1.05], max: [1.05, 1.05] }, &found), "{found:?}");
    }
}

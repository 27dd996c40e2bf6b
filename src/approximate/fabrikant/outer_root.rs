//! The outer root of G_a = D on one ray, past any kinks.
//!
//! Between kinks G_a is smooth; just past a kink where the gap turns upwards it falls like the square root of the
//! distance, and the sharper the kink, the closer to it the root lies: at the kink itself, to all digits of a, when the
//! punch is blunt and the depth small. In t, with a = k sqrt(1 + t^2) (see [`RadialPosition`]), nothing is lost and G_a is smooth. The
//! bracket is therefore kept in places, not in a (in a alone, polyhedra of 5, 36 and 40 irregular faces have no answer): first the
//! kinks decide on which piece the root lies, then Newton's method and halving work in the coordinate of that piece.

use super::radial::{RadialPosition, beyond};
use super::ray_fan::{CHECKED, Ray, RayFan};
use crate::numeric::scalar::maximum;

/// Evaluations on one ray before giving up: more than halving takes.
const MOST_EVALUATIONS: usize = 300;
/// Places evaluated beyond a root, each further out by a factor.
const SCAN: usize = 160;
const SCAN_STEP: f64 = 1.25;
/// Places on a ray among which the largest G_a is searched.
const PLACES: u32 = 32;
/// Where no sign change holds the bracket open, it is closed when so narrow (in t): a top at the kink.
const NARROWEST: f64 = 1e-10;

/// One end of the bracket, with what was found there.
#[derive(Clone, Copy)]
struct End {
    position: RadialPosition,
    g_a: f64,
}

impl End {
    /// The piece that begins or goes on outwards from here, and the coordinate on it: a on the first, t on the others.
    fn outwards(&self, kinks: &[f64]) -> (usize, f64) {
        match kinks.get(self.position.inner) {
            Some(&kink) if self.position.a >= kink => (self.position.inner + 1, 0.0),
            _ => (self.position.inner, coordinate(&self.position)),
        }
    }
}

fn coordinate(position: &RadialPosition) -> f64 {
    if position.inner == 0 { position.a } else { position.tan }
}

/// The place on this piece with this coordinate, at most the kink at its end.
fn place(kinks: &[f64], piece: usize, u: f64) -> RadialPosition {
    let position = match piece {
        0 => RadialPosition { a: u, inner: 0, tan: 0.0 },
        _ => RadialPosition::beyond(kinks, piece - 1, u),
    };
    match kinks.get(piece) {
        Some(&end) if !(position.a < end) => at_kink(kinks, piece),
        _ => position,
    }
}

/// The inner side of this kink.
fn at_kink(kinks: &[f64], kink: usize) -> RadialPosition {
    let a = kinks[kink];
    let tan = if kink == 0 { 0.0 } else { beyond(a, kinks[kink - 1]) / kinks[kink - 1] };
    RadialPosition { a, inner: kink, tan }
}

impl RayFan<'_> {
    /// The ray moved to an outer root of G_a = D, relative to `within`; or to the largest G_a, and `stuck`, when D
    /// lies above it; or to the edge of the material.
    pub(crate) fn outer_root(&self, ray: Ray, d: f64, within: f64) -> Ray {
        let found = self.root_nearby(ray, d, within);
        if !found.stuck || found.at_edge() || self.overlap.deadline.has_passed() {
            return found;
        }
        // A kink makes a local maximum of G_a; the largest may be another. (Without it, irregular polyhedra have no answer.)
        let local_maximum = self.local_maximum(&found);
        if local_maximum.along.g_a < d {
            Ray { stuck: true, ..local_maximum }
        } else {
            self.root_nearby(local_maximum, d, within)
        }
    }

    /// The ray moved to where G_a is largest. The search ends where the overlap has ended and G_a is negative.
    fn local_maximum(&self, ray: &Ray) -> Ray {
        let line = self.line(ray);
        let at = |position: RadialPosition| self.measure(Ray { a: position.a, position, ..*ray });
        let end = self.end_of_search(ray);
        let share = end.a / f64::from(PLACES);
        let evenly = (1..=PLACES).map(|k| RadialPosition::at(line.kinks, share * f64::from(k)));
        let at_kinks = (0..line.kinks.len()).map(|kink| at_kink(line.kinks, kink));
        let higher = |best: Ray, next: Ray| if next.along.g_a > best.along.g_a { next } else { best };
        let rough = evenly.chain(at_kinks.filter(|position| position.a < end.a)).map(at).fold(*ray, higher);
        let nearby = maximum(|a| at(RadialPosition::at(line.kinks, a)).along.g_a, rough.a - share, rough.a + share, 2);
        higher(rough, at(RadialPosition::at(line.kinks, nearby.at)))
    }

    /// The place on the ray at which a search may end: the overlap has ended, and G_a is negative.
    fn end_of_search(&self, ray: &Ray) -> Ray {
        let mut beyond = *ray;
        for _ in 0..SCAN {
            let ended = beyond.along.g_a < 0.0 && self.overlap.at(self.line(&beyond).at(beyond.a)) < 0.0;
            if ended || beyond.at_edge() {
                break;
            }
            beyond.a *= SCAN_STEP;
            beyond = self.measure(beyond);
        }
        beyond
    }

    /// Moves rays to another root of theirs where that gains more. Returns whether any ray has moved. (Without it the force of a blunt
    /// four-faced pyramid is 4e-3 off.)
    pub(crate) fn take_better_roots(&mut self, d: f64) -> bool {
        let mut moved = false;
        for k in 0..self.rays.len() {
            if let Some(other_root) = self.other_root(&self.rays[k], d) {
                self.rays[k] = other_root;
                moved = true;
            }
        }
        moved
    }

    /// Another root on the ray, where that gains more: G - D a is what the boundary maximises on each ray, and at a kink it may
    /// have a maximum besides the one beyond.
    pub(crate) fn other_root(&self, ray: &Ray, d: f64) -> Option<Ray> {
        if self.line(ray).kinks.is_empty() || ray.at_edge() {
            return None;
        }
        let gain = |r: &Ray| if r.stuck { f64::NEG_INFINITY } else { r.along.g - d * r.a };
        let mut best = *ray;
        for other_root in self.other_roots(ray, d, 1e-12).into_iter().flatten() {
            if gain(&other_root) > gain(&best) + 1e-12 * d * ray.a {
                best = other_root;
            }
        }
        (best.a != ray.a).then_some(best)
    }

    /// The next root further out, if there is one, and the one behind the outermost kink at which G_a exceeds D.
    fn other_roots(&self, ray: &Ray, d: f64, within: f64) -> [Option<Ray>; 2] {
        let settled = |from: Ray| Some(self.root_nearby(from, d, within)).filter(|r| !r.stuck);
        let mut beyond = *ray;
        let outer = (0..SCAN).find_map(|_| {
            beyond.a *= SCAN_STEP;
            beyond = self.measure(beyond);
            let beyond_overlap = || self.overlap.at(self.line(&beyond).at(beyond.a)) < 0.0;
            let ended = beyond.along.g_a < 0.0 && beyond_overlap();
            (beyond.along.g_a >= d || ended || beyond.at_edge()).then_some(beyond)
        });
        let kinks = self.line(ray).kinks;
        let inner = (0..ray.position.inner).rev().find_map(|kink| {
            let position = at_kink(kinks, kink);
            let there = self.measure(Ray { a: position.a, position, ..*ray });
            (there.along.g_a >= d).then_some(there)
        });
        [outer.filter(|r| r.along.g_a >= d).and_then(settled), inner.and_then(settled)]
    }

    fn root_nearby(&self, ray: Ray, d: f64, within: f64) -> Ray {
        let kinks = self.line(&ray).kinks;
        let mut ray = self.measure(ray);
        ray.stuck = false;
        // A point belongs to the outer side of the root when G_a is below D and falling.
        let mut lo = End { position: RadialPosition::default(), g_a: 0.0 };
        let mut hi: Option<End> = None;
        for evaluation in 1..=MOST_EVALUATIONS {
            if evaluation % CHECKED == 0 && self.overlap.deadline.has_passed() {
                break;
            }
            let along = ray.along;
            let here = End { position: ray.position, g_a: along.g_a };
            if ray.at_edge() && along.g_a >= d {
                return ray;
            }
            let falling = along.g_aa < 0.0;
            if falling && (along.g_a - d).abs() <= within.max(1e-15) * d {
                return ray;
            }
            if falling && along.g_a < d {
                hi = Some(here);
            } else if ray.at_edge() {
                ray.stuck = true;
                return ray;
            } else {
                lo = here;
            }
            // Newton's step in the coordinate of the piece.
            let t = ray.position.tan;
            let rate = if ray.position.inner == 0 { along.g_aa } else { along.g_aa * ray.a * t / (1.0 + t * t) };
            let newton = coordinate(&ray.position) - (along.g_a - d) / rate;
            let (piece, from) = lo.outwards(kinks);
            let next = match hi {
                None => {
                    let double = match piece {
                        0 => 2.0 * ray.a.max(f64::MIN_POSITIVE),
                        _ if from == 0.0 => 0.3,
                        _ => (3.0 + 4.0 * from * from).sqrt(),
                    };
                    let step = if falling && piece == ray.position.inner && newton > from {
                        newton.min(double)
                    } else {
                        double
                    };
                    place(kinks, piece, step)
                }
                Some(hi) if hi.position.inner > piece => at_kink(kinks, (piece + hi.position.inner - 1) / 2),
                Some(hi) => {
                    let to = coordinate(&hi.position);
                    let open = lo.g_a >= d;
                    if to - from <= 4.0 * f64::EPSILON * to
                        || (!open && piece > 0 && to - from <= NARROWEST * (1.0 + to))
                    {
                        // The bracket has closed on a maximum (smooth, or at a kink) that is too low.
                        ray.stuck = along.g_a < d * (1.0 - 1e-9);
                        return ray;
                    }
                    let chord = from + (to - from) * (lo.g_a - d) / (lo.g_a - hi.g_a);
                    let inside = |u: f64| u > from && u < to;
                    let u = if falling && piece == ray.position.inner && inside(newton) {
                        newton
                    } else if open && from == 0.0 && inside(chord) && chord < 0.5 * to {
                        chord
                    } else if from == 0.0 && to > 2.0 && piece > 0 {
                        to.sqrt()
                    } else if to > 4.0 * from && from > 0.0 {
                        (from * to).sqrt()
                    } else {
                        0.5 * (from + to)
                    };
                    place(kinks, piece, u)
                }
            };
            if next == ray.position {
                ray.stuck = along.g_a < d * (1.0 - 1e-9);
                return ray;
            }
            (ray.a, ray.position) = (next.a, next);
            ray = self.measure(ray);
        }
        ray
    }

    /// The highest G_a at the kinks below this place and in between: the largest is no lower. Found among a few
    /// places, and more closely when they lie within a twentieth of D.
    pub(crate) fn highest_seen(&self, ray: &Ray, d: f64) -> f64 {
        const BETWEEN: f64 = 16.0;
        let line = self.line(ray);
        let g_a = |position: &RadialPosition| line.along(self.overlap, self.f0, position, self.rule()).g_a;
        let between = |share: f64| g_a(&RadialPosition::at(line.kinks, ray.a * share));
        let at_kinks =
            (0..ray.position.inner).map(|kink| g_a(&at_kink(line.kinks, kink))).fold(ray.along.g_a, f64::max);
        let (mut at, mut highest) = (1.0, ray.along.g_a);
        for k in 1..16 {
            let share = f64::from(k) / BETWEEN;
            let there = between(share);
            if there > highest {
                (at, highest) = (share, there);
            }
        }
        if highest.max(at_kinks) < 1.05 * d {
            let (low, high) = (at - 1.0 / BETWEEN, (at + 1.0 / BETWEEN).min(1.0));
            highest = highest.max(maximum(between, low, high, 2).value);
        }
        highest.max(at_kinks)
    }
}

//! The ridges of a polyhedral gap: the stretches of straight line on which two of its planes meet.

use crate::numeric::geometry::{Rect, clip, distance};

/// One ridge.
#[derive(Debug, Clone, PartialEq)]
pub struct Ridge {
    /// A point on it: its first corner where it has one.
    pub point: [f64; 2],
    /// A unit vector along it.
    pub direction: [f64; 2],
    /// The corners at its two ends, in the sense of `direction`, as places in [`Ridges::corners`]; `None` where it has no end.
    pub ends: [Option<usize>; 2],
    /// Slope of the gap on the one side less that on the other, from which it points: across the ridge.
    pub jump: [f64; 2],
}

/// All ridges of a gap that is the highest of several planes (and so convex).
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Ridges {
    /// Where ridges end: every corner once.
    pub corners: Vec<[f64; 2]>,
    /// The ridges.
    pub all: Vec<Ridge>,
}

/// Corners closer together than this share of the window are one, and ridges so short are none.
const SAME: f64 = 1e-12;

impl Ridges {
    /// The ridges of the highest of these planes, whose corners all lie well within `window`.
    pub(super) fn of(planes: &[[f64; 3]], window: &Rect) -> Self {
        let mut planes = planes.to_vec();
        planes.sort_by(|a, b| a.iter().zip(b).fold(std::cmp::Ordering::Equal, |o, (x, y)| o.then(x.total_cmp(y))));
        planes.dedup();
        let same = SAME * window.size()[0];
        let mut ridges = Self::default();
        let mut face = Face::default();
        for k in 0..planes.len() {
            face.cut(&planes, k, window);
            let n = face.corners.len();
            for i in 0..n {
                // Each ridge once, from the face of lower number.
                let Some(other) = face.beyond[i].filter(|&other| other > k) else { continue };
                let (p, q) = (face.corners[i], face.corners[(i + 1) % n]);
                if distance(q, p) <= same {
                    continue;
                }
                let ended = [face.beyond[(i + n - 1) % n].is_some(), face.beyond[(i + 1) % n].is_some()];
                let jump = [planes[other][0] - planes[k][0], planes[other][1] - planes[k][1]];
                ridges.add([p, q], ended, jump, same);
            }
        }
        ridges
    }

    fn add(&mut self, [p, q]: [[f64; 2]; 2], ended: [bool; 2], jump: [f64; 2], same: f64) {
        // Across the jump, towards the second end.
        let length = jump[0].hypot(jump[1]);
        let across = [-jump[1] / length, jump[0] / length];
        let sense = (across[0] * (q[0] - p[0]) + across[1] * (q[1] - p[1])).signum();
        let mut corner = |at: [f64; 2]| {
            let near = |c: &[f64; 2]| (c[0] - at[0]).abs().max((c[1] - at[1]).abs()) <= same;
            self.corners.iter().position(near).unwrap_or_else(|| {
                self.corners.push(at);
                self.corners.len() - 1
            })
        };
        let ends = [ended[0].then(|| corner(p)), ended[1].then(|| corner(q))];
        let point = ends[0].or(ends[1]).map_or(p, |k| self.corners[k]);
        self.all.push(Ridge { point, direction: across.map(|a| sense * a), ends, jump });
    }

    /// The ridges of a fan of `faces` planes of slope `slope` like those of a regular pyramid, cut off by a level flat of
    /// inradius `flat` (0: pointed).
    pub(super) fn of_fan(faces: usize, slope: f64, flat: f64) -> Self {
        // In halves of a face.
        let unit = |k: usize| unit(k, 2 * faces);
        let half = std::f64::consts::PI / faces as f64;
        let mut ridges = Self::default();
        let normal = |k: usize| {
            let (sin, cos) = unit(2 * (k % faces));
            [slope * cos, slope * sin]
        };
        if flat > 0.0 {
            let radius = flat / half.cos();
            ridges.corners = (0..faces)
                .map(|k| {
                    let (sin, cos) = unit(2 * k + 1);
                    [radius * cos, radius * sin]
                })
                .collect();
        } else {
            ridges.corners.push([0.0; 2]);
        }
        for k in 0..faces {
            let (sin, cos) = unit(2 * k + 1);
            let (here, next) = (normal(k), normal(k + 1));
            let corner = if flat > 0.0 { k } else { 0 };
            ridges.all.push(Ridge {
                point: ridges.corners[corner],
                direction: [cos, sin],
                ends: [Some(corner), None],
                jump: [next[0] - here[0], next[1] - here[1]],
            });
            if flat > 0.0 {
                // The edge of the flat below face k, from the corner before to this one.
                let (sin, cos) = unit(2 * k);
                let before = (k + faces - 1) % faces;
                ridges.all.push(Ridge {
                    point: ridges.corners[before],
                    direction: [-sin, cos],
                    ends: [Some(before), Some(k)],
                    jump: here,
                });
            }
        }
        ridges
    }

    /// The same seen otherwise: points, directions and jumps each by a map of their own.
    pub(super) fn seen(
        mut self,
        point: impl Fn([f64; 2]) -> [f64; 2],
        direction: impl Fn([f64; 2]) -> [f64; 2],
        jump: impl Fn([f64; 2]) -> [f64; 2],
    ) -> Self {
        self.corners.iter_mut().for_each(|c| *c = point(*c));
        for ridge in &mut self.all {
            ridge.point = point(ridge.point);
            ridge.direction = direction(ridge.direction);
            ridge.jump = jump(ridge.jump);
        }
        self
    }
}

/// The polygon over which one plane is the highest: corners, and what lies beyond the side that leaves each of them
/// (`None`: the window).
#[derive(Default)]
struct Face {
    corners: Vec<[f64; 2]>,
    beyond: Vec<Option<usize>>,
    spare: (Vec<[f64; 2]>, Vec<Option<usize>>),
}

impl Face {
    fn cut(&mut self, planes: &[[f64; 3]], own: usize, window: &Rect) {
        self.corners.clear();
        self.corners.extend(window.corners());
        self.beyond.clear();
        self.beyond.extend([None; 4]);
        let [a, b, c] = planes[own];
        for (m, p) in planes.iter().enumerate().filter(|&(m, _)| m != own) {
            self.clip([p[0] - a, p[1] - b, p[2] - c], m);
            if self.corners.is_empty() {
                return;
            }
        }
    }

    /// Keeps what lies where a x + b y + c <= 0, the new side labelled.
    fn clip(&mut self, [a, b, c]: [f64; 3], label: usize) {
        let side = |p: &[f64; 2]| a * p[0] + b * p[1] + c;
        if self.corners.iter().all(|p| side(p) <= 0.0) {
            return;
        }
        let (corners, beyond) = &mut self.spare;
        corners.clear();
        beyond.clear();
        let n = self.corners.len();
        for (k, p) in self.corners.iter().enumerate() {
            let q = &self.corners[(k + 1) % n];
            let (sp, sq) = (side(p), side(q));
            if sp <= 0.0 {
                corners.push(*p);
                beyond.push(if sp == 0.0 && sq > 0.0 { Some(label) } else { self.beyond[k] });
            }
            if (sp < 0.0 && sq > 0.0) || (sp > 0.0 && sq < 0.0) {
                let t = sp / (sp - sq);
                corners.push([p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])]);
                beyond.push(if sp < 0.0 { Some(label) } else { self.beyond[k] });
            }
        }
        std::mem::swap(&mut self.corners, corners);
        std::mem::swap(&mut self.beyond, beyond);
    }
}

/// sin and cos of 2 pi k/n, exact on the axes and exactly mirrored.
pub(super) fn unit(k: usize, n: usize) -> (f64, f64) {
    // Reduce to the first octant in whole numbers: 8k/n in [0, 8).
    let octant = 8 * k / n;
    let angle = |numerator: i64| std::f64::consts::TAU * numerator as f64 / (8 * n as i64) as f64;
    let (k8, n8) = (8 * k as i64, n as i64);
    match octant {
        0 => angle(k8).sin_cos(),
        1 => swap(angle(2 * n8 - k8).sin_cos()),
        2 => {
            let (s, c) = swap(angle(k8 - 2 * n8).sin_cos());
            (s, -c)
        }
        3 => {
            let (s, c) = angle(4 * n8 - k8).sin_cos();
            (s, -c)
        }
        4 => {
            let (s, c) = angle(k8 - 4 * n8).sin_cos();
            (-s, -c)
        }
        5 => {
            let (s, c) = swap(angle(6 * n8 - k8).sin_cos());
            (-s, -c)
        }
        6 => {
            let (s, c) = swap(angle(k8 - 6 * n8).sin_cos());
            (-s, c)
        }
        _ => {
            let (s, c) = angle(8 * n8 - k8).sin_cos();
            (-s, c)
        }
    }
}

fn swap((a, b): (f64, f64)) -> (f64, f64) {
    (b, a)
}

/// Corners of the region where plane `k` is the highest, cut to `window`.
fn face_polygon(planes: &[[f64; 3]], k: usize, window: &Rect) -> Vec<[f64; 2]> {
    let own = planes[k];
    let mut polygon = window.corners().to_vec();
    for (m, other) in planes.iter().enumerate() {
        if polygon.is_empty() {
            break;
        }
        if m == k || other == &own {
            continue;
        }
        let [a, b, c] = [other[0] - own[0], other[1] - own[1], other[2] - own[2]];
        polygon = clip(&polygon, a, b, c);
    }
    polygon
}

/// A window that holds every corner of the surface with room to spare, from the planes alone.
pub(super) fn corner_window(planes: &[[f64; 3]]) -> Rect {
    let slopes = planes.iter().map(|p| p[0].hypot(p[1])).filter(|s| *s > 0.0);
    let mildest = slopes.reduce(f64::min).unwrap_or(0.0);
    let spread = planes.iter().map(|p| p[2].abs()).fold(0.0, f64::max);
    let scale = if spread > 0.0 && mildest > 0.0 { spread / mildest } else { 1.0 };
    let wide = Rect::around([0.0; 2], [1e6 * scale; 2]);
    // Second pass: the corners found in the wide window set the size of a snug one, where nothing cancels.
    match Rect::holding(corners_within(planes, &wide)) {
        Some(found) => {
            let half = 2.0 * found.longer_side().max(scale);
            Rect::around(found.centre(), [half; 2])
        }
        None => Rect::around([0.0; 2], [4.0 * scale; 2]),
    }
}

/// Corners of the surface strictly inside the window.
fn corners_within(planes: &[[f64; 3]], window: &Rect) -> Vec<[f64; 2]> {
    let inner = window.scaled(1.0 - 1e-9);
    (0..planes.len()).flat_map(|k| face_polygon(planes, k, window)).filter(|&p| inner.contains(p)).collect()
}

#[cfg(test)]
mod tests {
    use crate::gap::{Gap, Polyhedron};
    use crate::numeric::geometry::distance;

    /// The jump of the gradient across every ridge, and every corner on three of them at least.
    #[test]
    fn ridges_are_where_the_gradient_jumps() {
        let planes =
            vec![[1.0, 0.0, 0.0], [0.4, 0.8, 0.1], [-0.7, 0.6, 0.0], [-0.8, -0.5, 0.05], [0.3, -1.1, 0.0], [0.0; 3]];
        let gaps = [
            Polyhedron::new(planes).unwrap(),
            Polyhedron::pyramid(7, 0.6).unwrap(),
            Polyhedron::pyramid(2, 0.6).unwrap(),
            Polyhedron::truncated_pyramid(5, 0.6, 0.3).unwrap(),
        ];
        for gap in &gaps {
            let ridges = gap.ridges().unwrap();
            assert!(!ridges.all.is_empty());
            for ridge in &ridges.all {
                let place = |k: usize| {
                    let [x, y] = ridges.corners[k];
                    (x - ridge.point[0]) * ridge.direction[0] + (y - ridge.point[1]) * ridge.direction[1]
                };
                let (from, to) = match ridge.ends.map(|end| end.map(place)) {
                    [Some(a), Some(b)] => (a, b),
                    [Some(a), None] => (a, a + 1.0),
                    [None, Some(b)] => (b - 1.0, b),
                    [None, None] => (-1.0, 1.0),
                };
                assert!(to > from, "{ridge:?}");
                for share in [0.1, 0.5, 0.9] {
                    let r = from + share * (to - from);
                    let length = ridge.jump[0].hypot(ridge.jump[1]);
                    let slope = |side: f64| {
                        let at = [0, 1]
                            .map(|m| ridge.point[m] + r * ridge.direction[m] + side * 1e-9 * ridge.jump[m] / length);
                        gap.gradient(at[0], at[1]).unwrap()
                    };
                    let (a, b) = (slope(-1.0), slope(1.0));
                    for m in 0..2 {
                        assert!((b[m] - a[m] - ridge.jump[m]).abs() < 1e-14, "{ridge:?}");
                    }
                }
            }
            for k in 0..ridges.corners.len() {
                let at = ridges.all.iter().filter(|r| r.ends.contains(&Some(k))).count();
                assert!(at >= 3 || ridges.all.len() == 2, "{at}");
            }
        }
    }

    #[test]
    fn a_fan_is_found_by_either_way() {
        for (faces, flat) in [(3, 0.5), (4, 1.0), (12, 0.2)] {
            let fan = Polyhedron::truncated_pyramid(faces, 0.7, flat).unwrap();
            let [a, b] = [fan.ridges(), Polyhedron::new(fan.planes().to_vec()).unwrap().ridges()].map(Option::unwrap);
            assert_eq!((a.corners.len(), a.all.len()), (b.corners.len(), b.all.len()));
            for c in &a.corners {
                assert!(b.corners.iter().any(|d| distance(*d, *c) < 1e-14));
            }
        }
    }
}

//! Polygons: orientation, convexity, symmetries, and the cut into convex pieces.

use super::mesh::{Point, cross, dot, minus, norm};
use super::symmetry::Isometry;
use crate::numeric::geometry::{area, centroid};

/// What counts as rounding in the direction of a side and in the place of a corner, over the size of the polygon.
pub(crate) const STRAIGHT: f64 = 1e-13;

/// A closed line without the points that lie on the line of their neighbours.
pub(crate) fn straightened(mut p: Vec<Point>) -> Vec<Point> {
    let n = p.len();
    let bent = |i: usize| {
        let (u, v) = (minus(p[i], p[(i + n - 1) % n]), minus(p[(i + 1) % n], p[i]));
        cross(u, v).abs() > 1e-9 * norm(u) * norm(v) || dot(u, v) < 0.0
    };
    let keep: Vec<bool> = (0..n).map(bent).collect();
    let mut kept = keep.into_iter();
    p.retain(|_| kept.next().unwrap_or(true));
    p
}

/// Counter-clockwise, without corners that lie on the line of their neighbours or coincide.
pub(crate) fn cleaned(corners: &[Point]) -> Vec<Point> {
    let mut p = corners.to_vec();
    if area(&p) < 0.0 {
        p.reverse();
    }
    loop {
        let n = p.len();
        let flat = (0..n).find(|&i| {
            let (a, b, c) = (p[(i + n - 1) % n], p[i], p[(i + 1) % n]);
            let (u, v) = (minus(b, a), minus(c, b));
            norm(u) == 0.0 || (cross(u, v).abs() <= STRAIGHT * norm(u) * norm(v) && dot(u, v) > 0.0)
        });
        match flat {
            Some(i) if n > 3 => {
                p.remove(i);
            }
            _ => return p,
        }
    }
}

/// Whether all corners turn left.
#[cfg(test)]
fn is_convex(p: &[Point]) -> bool {
    let n = p.len();
    (0..n).all(|i| cross(minus(p[(i + 1) % n], p[i]), minus(p[(i + 2) % n], p[(i + 1) % n])) > 0.0)
}

/// The rotation (cosine, sine of the angle) that lays all sides along the axes, if there is one: by the longest side.
pub(crate) fn rectilinear_frame(p: &[Point]) -> Option<Point> {
    let n = p.len();
    let sides: Vec<Point> = (0..n).map(|i| minus(p[(i + 1) % n], p[i])).collect();
    let longest = sides.iter().copied().max_by(|a, b| norm(*a).total_cmp(&norm(*b)))?;
    let e = longest.map(|c| c / norm(longest));
    let size = norm(longest);
    sides.iter().all(|s| dot(*s, e).abs().min(cross(*s, e).abs()) <= STRAIGHT * size).then_some(e)
}

/// The rotations and mirrors about the centroid that map the corners to each other.
pub(crate) fn symmetries(p: &[Point]) -> Vec<Isometry> {
    with_images(p).into_iter().map(|(isometry, _)| isometry).collect()
}

/// The same, with the corner that each takes every corner to.
fn with_images(p: &[Point]) -> Vec<(Isometry, Vec<usize>)> {
    let n = p.len();
    let c = centroid(p);
    let size = p.iter().map(|q| norm(minus(*q, c))).fold(0.0, f64::max);
    let close = |a: Point, b: Point| norm(minus(a, b)) <= 1e-12 * size;
    let mut group = Vec::new();
    let v: Vec<Point> = p.iter().map(|q| minus(*q, c)).collect();
    for k in 0..n {
        // Corner 0 to corner k, in the same or in the reverse order.
        let scale = dot(v[0], v[0]);
        if (dot(v[k], v[k]) - scale).abs() > 1e-12 * size * size || scale == 0.0 {
            continue;
        }
        let exact = |x: f64| if (x - x.round()).abs() < 1e-14 { x.round() } else { x };
        let (cos, sin) = (exact(dot(v[0], v[k]) / scale), exact(cross(v[0], v[k]) / scale));
        // The mirror that takes v0 to vk: conjugate of v0, turned.
        let (x, y) = (
            exact((v[0][0] * v[k][0] - v[0][1] * v[k][1]) / scale),
            exact((v[0][0] * v[k][1] + v[0][1] * v[k][0]) / scale),
        );
        let turned = ([[cos, -sin], [sin, cos]], (0..n).map(|i| (i + k) % n).collect::<Vec<_>>());
        let mirrored = ([[x, y], [y, -x]], (0..n).map(|i| (n + k - i) % n).collect());
        for (matrix, images) in [turned, mirrored] {
            let isometry = Isometry { centre: c, matrix };
            if (0..n).all(|i| close(isometry.apply(p[i]), p[images[i]])) {
                group.push((isometry, images));
            }
        }
    }
    group
}

/// Whether the open segment between corners i and j runs inside a simple polygon.
fn diagonal(p: &[Point], i: usize, j: usize) -> bool {
    let n = p.len();
    let (a, b) = (p[i], p[j]);
    let inside = |at: usize, to: Point| {
        let (before, here, after) = (p[(at + n - 1) % n], p[at], p[(at + 1) % n]);
        let left = |u: Point, v: Point| cross(u, v) > 0.0;
        let (u, v, w) = (minus(after, here), minus(to, here), minus(before, here));
        if left(u, w) {
            left(u, v) && left(v, w)
        } else {
            !(left(w, v) && left(v, u)) && cross(u, v) != 0.0 && cross(v, w) != 0.0
        }
    };
    if !inside(i, b) || !inside(j, a) {
        return false;
    }
    (0..n).all(|k| {
        let l = (k + 1) % n;
        if k == i || k == j || l == i || l == j {
            return true;
        }
        let (c, d) = (p[k], p[l]);
        let side = |u: Point, v: Point, w: Point| cross(minus(v, u), minus(w, u));
        !(side(a, b, c) * side(a, b, d) <= 0.0 && side(c, d, a) * side(c, d, b) <= 0.0)
    })
}

/// Cuts of a simple polygon into convex pieces by diagonals, each piece a list of corners counter-clockwise, the best first: cells of pieces
/// that the symmetries of the polygon map to each other are solved once for all of them.
pub(crate) fn convex_cuts(p: &[Point]) -> Vec<Vec<Vec<Point>>> {
    let images: Vec<Vec<usize>> = with_images(p).into_iter().map(|(_, images)| images).collect();
    let unmoved = [(0..p.len()).collect()];
    let (alike, any) = (convex_pieces(p, &images), convex_pieces(p, &unmoved));
    alike.filter(|alike| any.as_ref() != Some(alike)).into_iter().chain(any).collect()
}

/// Convex pieces: cut at the first re-entrant corner of each by the diagonal that leaves the fattest parts, together with its images under
/// these maps of the corners, which form a group; and again.
fn convex_pieces(p: &[Point], images: &[Vec<usize>]) -> Option<Vec<Vec<Point>>> {
    let mut pieces = vec![(0..p.len()).collect::<Vec<_>>()];
    let places = |piece: &[usize]| piece.iter().map(|&k| p[k]).collect::<Vec<_>>();
    let orbit = |[i, j]: [usize; 2]| images.iter().map(move |image| [image[i], image[j]]);
    // Diagonals cross where their ends alternate.
    let cross_one_another = |cut: [usize; 2]| {
        let [a, b] = [cut[0].min(cut[1]), cut[0].max(cut[1])];
        let between = |k: usize| a < k && k < b;
        orbit(cut).any(|[c, d]| {
            let apart = ![a, b].contains(&c) && ![a, b].contains(&d);
            apart && between(c) != between(d)
        })
    };
    while let Some((own, corner)) =
        pieces.iter().enumerate().find_map(|(k, piece)| Some((k, reentrant(&places(piece))?)))
    {
        let piece = &pieces[own];
        let allowed = |j: usize| !cross_one_another([piece[corner], piece[j]]);
        let end = best_diagonal(&places(piece), corner, allowed)?;
        for cut in orbit([piece[corner], piece[end]]).collect::<Vec<_>>() {
            let ends = pieces.iter().enumerate().find_map(|(k, piece)| {
                let [i, j] = cut.map(|end| piece.iter().position(|&c| c == end));
                let (i, j) = (i?.min(j?), i?.max(j?));
                // Two images may be the same diagonal.
                (j - i > 1 && j - i + 1 < piece.len()).then_some((k, i, j))
            });
            if let Some((k, i, j)) = ends {
                let whole = pieces.remove(k);
                pieces.push(whole[i..=j].to_vec());
                pieces.push(whole[j..].iter().chain(&whole[..=i]).copied().collect());
            }
        }
    }
    Some(pieces.iter().map(|piece| places(piece)).collect())
}

/// The first corner that does not turn left.
fn reentrant(p: &[Point]) -> Option<usize> {
    let n = p.len();
    let turn = |i: usize| cross(minus(p[i], p[(i + n - 1) % n]), minus(p[(i + 1) % n], p[i]));
    (0..n).find(|&i| turn(i) <= 0.0)
}

/// The diagonal from corner i that meets the corner's bisector best and is short: both parts should be convex at the corner.
fn best_diagonal(p: &[Point], i: usize, allowed: impl Fn(usize) -> bool) -> Option<usize> {
    let n = p.len();
    let before = minus(p[i], p[(i + n - 1) % n]);
    let after = minus(p[(i + 1) % n], p[i]);
    let candidates = (0..n).filter(|&j| j != i && (j + 1) % n != i && (i + 1) % n != j && diagonal(p, i, j));
    candidates.filter(|&j| allowed(j)).max_by(|&a, &b| {
        let score = |j: usize| {
            let v = minus(p[j], p[i]);
            let open = (cross(before, v) / (norm(before) * norm(v))).min(cross(after, v) / (norm(v) * norm(after)));
            // Convex at the corner on both sides, then the shorter one.
            (if open >= -1e-12 { 1.0 } else { open }) / norm(v).powf(if open >= -1e-12 { 1.0 } else { 0.0 })
        };
        score(a).total_cmp(&score(b))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_cover_the_polygon() {
        let star: Vec<Point> = (0..10)
            .map(|k| {
                let (s, c) = (std::f64::consts::TAU * k as f64 / 10.0).sin_cos();
                let r = if k % 2 == 0 { 1.0 } else { 0.382 };
                [r * c, r * s]
            })
            .collect();
        let ell = vec![[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        for p in [&star, &ell] {
            for pieces in convex_cuts(p) {
                let covered: f64 = pieces.iter().map(|q| area(q)).sum();
                assert!((covered - area(p)).abs() < 1e-12);
                assert!(pieces.iter().all(|q| is_convex(&cleaned(q))));
            }
        }
        // A pentagon and five triangles, all alike.
        let sides = |k: usize| convex_cuts(&star)[0].iter().filter(|q| q.len() == k).count();
        assert_eq!([sides(3), sides(4), sides(5)], [5, 0, 1]);
        assert_eq!(symmetries(&star).len(), 10);
        assert_eq!(symmetries(&ell).len(), 2);
        assert!(rectilinear_frame(&ell).is_some() && rectilinear_frame(&star).is_none());
    }
}

//! Meshes of an ellipse: square-like cells in the middle, rings around them, graded to the edge.
//!
//! The edge is made of chords of equal eccentric angle, moved outwards so that they hold the area of the ellipse: the stiffness of the
//! polygon then differs from that of the ellipse as the inverse cube of the number of chords (regular ones of 6, 8: 5.7e-3, 2.3e-3).

use std::f64::consts::{FRAC_PI_4, SQRT_2, TAU};

use super::mesh::{Mesh, Point};
use super::rectilinear::{graded, split};

/// Size of the middle, over that of the ellipse.
const MIDDLE: f64 = 0.5;

/// How much of a disc the middle is, and how much of a square: angles of its cells at the corners.
const ROUND: f64 = 0.5;

/// Chords of the coarsest edge, a quarter of them.
const FEWEST: usize = 6;

/// Corners of a polygon that holds the area of the ellipse with these semi-axes, counter-clockwise from the first diagonal on.
pub(crate) fn chords(semi_axes: Point, count: usize) -> Vec<Point> {
    let step = TAU / count as f64;
    let out = (step / step.sin()).sqrt();
    let at = |k: usize| (k as f64 * step - 3.0 * FRAC_PI_4).sin_cos();
    (0..count).map(at).map(|(sin, cos)| [semi_axes[0] * out * cos, semi_axes[1] * out * sin]).collect()
}

/// `n` cells across the rings, graded to the edge with the exponent `beta`, none longer than about `most`. There is no strip beyond the
/// edge: nothing is proved on chords.
pub(crate) fn mesh(semi_axes: Point, n: usize, beta: f64, most: f64) -> Mesh {
    let longer = semi_axes[0].max(semi_axes[1]);
    let m = FEWEST.max((0.25 * TAU * longer / most).ceil() as usize).max(n);
    let edge = chords(semi_axes, 4 * m);
    // The middle, row by row: lines of equal angle on its sides.
    let line: Vec<f64> = (0..=m).map(|k| (FRAC_PI_4 * (2.0 * k as f64 / m as f64 - 1.0)).tan()).collect();
    let inner = |i: usize, j: usize| -> Point {
        let (u, v) = (line[i], line[j]);
        let blend = |w: f64, other: f64| (1.0 - ROUND) * w / SQRT_2 + ROUND * w * (1.0 - 0.5 * other * other).sqrt();
        [semi_axes[0] * MIDDLE * blend(u, v), semi_axes[1] * MIDDLE * blend(v, u)]
    };
    // Its nodes along its side, counter-clockwise from the corner that the chords begin at.
    let side: Vec<[usize; 2]> = (0..m)
        .map(|k| [k, 0])
        .chain((0..m).map(|k| [m, k]))
        .chain((0..m).map(|k| [m - k, m]))
        .chain((0..m).map(|k| [0, m - k]))
        .collect();
    let across = split(&graded(0.0, 1.0, n, beta), most / (longer * (1.0 - MIDDLE)));
    let rings = across.len() - 1;
    let first = (m + 1) * (m + 1);
    let mut nodes: Vec<Point> = (0..first).map(|k| inner(k % (m + 1), k / (m + 1))).collect();
    for share in &across[1..] {
        nodes.extend(side.iter().zip(&edge).map(|([i, j], end)| {
            let from = inner(*i, *j);
            [0, 1].map(|c| if *share == 1.0 { end[c] } else { from[c] + share * (end[c] - from[c]) })
        }));
    }
    let node = |ring: usize, k: usize| {
        let k = k % (4 * m);
        if ring == 0 { side[k][1] * (m + 1) + side[k][0] } else { first + (ring - 1) * 4 * m + k }
    };
    let middle = (0..m).flat_map(|j| (0..m).map(move |i| [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]]));
    let mut cells: Vec<[usize; 4]> = middle.map(|cell| cell.map(|[i, j]| j * (m + 1) + i)).collect();
    for ring in 0..rings {
        cells.extend((0..4 * m).map(|k| [node(ring, k), node(ring + 1, k), node(ring + 1, k + 1), node(ring, k + 1)]));
    }
    Mesh::new(nodes, cells, Vec::new())
}

#[cfg(test)]
mod tests {
    use super::super::mesh::Bilinear;
    use super::*;

    #[test]
    fn cells_are_convex_and_hold_the_area() {
        for (semi_axes, n, most) in [([1.0, 1.0], 4, 0.4), ([1.0, 0.3], 7, 0.15), ([0.2, 1.0], 12, 0.05)] {
            let mesh = mesh(semi_axes, n, 4.0, most);
            let mut area = 0.0;
            for cell in 0..mesh.loaded {
                let map = Bilinear::new(mesh.corners(cell));
                assert!([-1.0, 1.0].iter().all(|s| [-1.0, 1.0].iter().all(|t| map.jacobian(*s, *t) > 0.0)));
                area += map.area();
            }
            let exact = std::f64::consts::PI * semi_axes[0] * semi_axes[1];
            assert!((area / exact - 1.0).abs() < 1e-12, "{area} {exact}");
        }
    }
}

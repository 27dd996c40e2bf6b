//! Bounds of what interpolation of displacement and slope on a subcell leaves out.
//!
//! On a line of direction s through the subcell (half length h) and for a kernel 1/r, |d^k/ds^k 1/r| <= k!/r^(k+1): 1/r is
//! harmonic in space and Legendre polynomials are at most 1. Interpolation at m Gauss nodes errs by at most
//! kappa_m h^m sup |d^m|/m! in the mean square (`gauss::kappa`); tensor interpolation by the sum over both directions,
//! since the second acts on a polynomial that the Gauss sum squares exactly. For an edge, L = int ds/r:
//!
//! ```text
//! |d^m L|/m! <= min( length/delta^(m+1), 2 B_m/delta^m ),                      delta = distance of edge and subcell,
//! |d^m L|/m! <= B_m (1/r1^m + 1/r2^m) + (2/m) (|s . n|/d)^m,                   r1, r2 from its ends, d from its line,
//! ```
//!
//! the second because L = ln(r1 + |a1|) + ln(r2 + |a2|) - 2 ln d between the ends, where ln(r + |a|) is the potential of a
//! half line that leads away, and has no third term beyond them. On a subcell that touches the edge, ln d = ln t + ln d(1):
//! ln t is kept aside and only the slope of d(1) along the side remains. u of an edge is d L/pi, with
//!
//! ```text
//! grad (d L) = n L + v1/r1 - v2/r2,                                            v: x less an end of it, turned by a right angle.
//! ```
//!
//! The last two terms vanish in the sum over all edges at a node, so that d^m u = d^(m-1) of (s . n) L there; a single edge that is
//! taken as far keeps them: s . v is constant along s, |d^(m-1) s . v/r| <= (m-1)! |s . v|/r^m.

use super::edge_lanes::{self, EdgeLanes, Seen};
use super::far::Far;
use super::gauss::{B, NODES, Touch, logarithm_error};
use super::mesh::{dot, minus, norm};
use super::subcell::{Fan, Hull, NearEdge, NodeLogarithm, Subcell, corner_coordinates};

/// Numbers of nodes that are compared.
pub(crate) const CHOICES: usize = NODES[1] - NODES[0] + 1;

/// Bounds for one pressure, mean squares over the subcell.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Errors {
    /// Of the slope: direction, number of nodes less two.
    pub slope: [[f64; CHOICES]; 2],
    /// Of the displacement.
    pub value: [[f64; CHOICES]; 2],
    /// Of slope and displacement, from logarithms at a node, and from rounding.
    pub fixed: [f64; 2],
}

impl Errors {
    pub const ZERO: Self = Self { slope: [[0.0; CHOICES]; 2], value: [[0.0; CHOICES]; 2], fixed: [0.0; 2] };
}

/// The least distance of points from a line, given their signed distances; zero where it passes between them.
pub(crate) fn distance_from_line(d: &[f64; 4]) -> f64 {
    let low = d.iter().copied().fold(f64::INFINITY, f64::min);
    let high = d.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    low.max(-high).max(0.0)
}

/// What a subcell takes off before it interpolates: by near edge, the logarithm at its node.
pub(crate) type NodeLogarithms = Vec<(usize, NodeLogarithm)>;

/// Sixteen units of rounding: what a coordinate difference and a logarithm of it lose.
pub(crate) const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// The bounds of all pressures on a subcell.
pub(crate) fn errors<const K: usize>(
    subcell: &Subcell,
    near: &[NearEdge<K>],
    lanes: &EdgeLanes<K>,
    far: &[Far; K],
    extent: f64,
) -> ([Errors; K], NodeLogarithms) {
    let hull = Hull::new(&subcell.map);
    let corners = subcell.map.corners();
    let half = subcell.half();
    let map = &subcell.map;
    let touches = [subcell.touch(0), subcell.touch(1)];
    let node = subcell.node();
    let fan = Fan::new(subcell);
    let mut out = [Errors::ZERO; K];
    let mut logarithms: NodeLogarithms = Vec::new();
    let mut spreads: Vec<f64> = Vec::new();
    // Edges that the subcell touches, or that end at its node.
    let special = |e: &NearEdge<K>| {
        touches.iter().any(|touch| touch.1 == Some(e.edge)) || node.is_some_and(|n| e.nodes.contains(&n))
    };
    let apart = touches == [(Touch::None, None); 2] && node.is_none();
    let specials: Vec<usize> =
        if apart { Vec::new() } else { (0..near.len()).filter(|&index| special(&near[index])).collect() };
    let seen = Seen {
        hull: &hull,
        corners: &corners,
        along: [
            [map.ds(-1.0), map.ds(1.0)].map(|v| v.map(|c| c / half[0])),
            [map.dt(-1.0), map.dt(1.0)].map(|v| v.map(|c| c / half[1])),
        ],
        half,
        inset: 0.04 * half[0].min(half[1]),
        extent,
    };
    edge_lanes::add(lanes, &specials, &seen, &mut out);
    for &index in &specials {
        let e = &near[index];
        let normal = e.normal();
        let touched = (0..2).find(|&k| touches[k].1 == Some(e.edge));
        let ending = node.and_then(|n| e.nodes.iter().position(|&m| m == n));
        let (d, _) = corner_coordinates(&corners, e);
        let reach = d.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let r = [0, 1].map(|k| if ending == Some(k) { f64::INFINITY } else { hull.distance(e.ends[k]) });
        // Slope of the distance along s and t, and the distance of the far corners from a touched edge.
        let lean = [
            dot(map.ds(-1.0), normal).abs().max(dot(map.ds(1.0), normal).abs()),
            dot(map.dt(-1.0), normal).abs().max(dot(map.dt(1.0), normal).abs()),
        ];
        for k in 0..2 {
            // |d^m L| h^m/m! for m = 1 .. 5.
            let h = half[k];
            let logarithmic = match touched {
                Some(across) if across == k => 0.0,
                Some(across) => {
                    // Distances of the two far corners, over which ln d(1) varies.
                    let far_corners = match (across, touches[across].0) {
                        (0, Touch::Low) => [1, 2],
                        (0, _) => [0, 3],
                        (_, Touch::Low) => [3, 2],
                        _ => [0, 1],
                    };
                    let (p, q) = (d[far_corners[0]].abs(), d[far_corners[1]].abs());
                    0.5 * (p - q).abs() / p.min(q)
                }
                None => 0.0,
            };
            let mut terms = [0.0; NODES[1] + 1];
            let (q1, q2) = (h / r[0], h / r[1]);
            let (mut p1, mut p2, mut p3) = (1.0, 1.0, 1.0);
            for (m, term) in terms.iter_mut().enumerate().skip(1) {
                p1 *= q1;
                p2 *= q2;
                p3 *= logarithmic;
                *term = B[m] * (p1 + p2) + 2.0 / m as f64 * p3;
            }
            for (errors, c) in out.iter_mut().zip(e.strength) {
                let c = c.abs();
                for i in 0..CHOICES {
                    let m = i + NODES[0];
                    let kappa = KAPPA[m];
                    errors.slope[k][i] += c * kappa * terms[m];
                    errors.value[k][i] += c * if touched == Some(k) {
                        kappa * (reach * terms[m] + lean[k] * terms[m - 1]) + 2.0 * reach * logarithm_error(m)
                    } else {
                        if lean[k] > 0.0 { kappa / m as f64 * lean[k] * terms[m - 1] } else { 0.0 }
                    };
                }
            }
        }
        if let (Some(end), Some(fan)) = (ending, &fan) {
            let direction = if end == 0 { e.direction } else { e.direction.map(|c| -c) };
            let (logarithm, spread) = fan.logarithm(direction, touched.is_some());
            logarithms.push((index, logarithm));
            spreads.push(spread);
        }
        // Rounding of the coordinates against the distance of the nearest Gauss point: no edge crosses the subcell, and
        // they lie deeper inside it than 0.04 of its thickness.
        let closest = seen.inset;
        for (errors, c) in out.iter_mut().zip(e.strength) {
            errors.fixed[0] += ROUNDING * c.abs() * (60.0 + extent / closest);
        }
    }
    if let Some(fan) = &fan {
        let before: [f64; K] = std::array::from_fn(|k| out[k].fixed[0]);
        pair_logarithms(near, fan, &mut logarithms, &spreads, &mut out);
        // In u each logarithm is multiplied by the distance from its edge.
        let reach = corners.iter().map(|c| norm(minus(*c, fan.node()))).fold(0.0, f64::max);
        for (errors, before) in out.iter_mut().zip(before) {
            errors.fixed[1] += reach * (errors.fixed[0] - before);
        }
    }
    for (errors, far) in out.iter_mut().zip(far) {
        errors.fixed[0] += 100.0 * ROUNDING * far.strength + far.block[0];
        errors.fixed[1] += 100.0 * ROUNDING * extent * far.strength + far.block[1];
        for (k, h) in half.iter().enumerate() {
            let mut power = *h;
            for i in 0..CHOICES {
                power *= h;
                errors.slope[k][i] += KAPPA[i + NODES[0]] * power * far.slope[k][i];
                errors.value[k][i] += KAPPA[i + NODES[0]] * power * far.value[k][i];
            }
        }
    }
    (out, logarithms)
}

/// kappa_m for m up to 5 (a test compares).
pub(crate) const KAPPA: [f64; 6] = [
    1.0,
    0.577_350_269_189_625_8,
    0.298_142_396_999_971_96,
    0.151_185_789_203_690_95,
    0.076_190_476_190_476_2,
    0.038_287_154_867_017_6,
];

/// The errors of the logarithms at a node. Those of an edge under a side and of the edge that continues it are nearly the
/// same function: they share a constant, and only the difference of the strengths counts.
fn pair_logarithms<const K: usize>(
    near: &[NearEdge<K>],
    fan: &Fan,
    logarithms: &mut NodeLogarithms,
    spreads: &[f64],
    out: &mut [Errors; K],
) {
    let mut done = vec![false; logarithms.len()];
    for i in 0..logarithms.len() {
        if !logarithms[i].1.own {
            continue;
        }
        let partner = (0..logarithms.len())
            .filter(|&j| {
                !done[j] && !logarithms[j].1.own && dot(logarithms[i].1.direction, logarithms[j].1.direction) < -0.9
            })
            .map(|j| (j, fan.difference(logarithms[i].1.direction, logarithms[j].1.direction)))
            .min_by(|a, b| a.1.total_cmp(&b.1));
        let Some((j, difference)) = partner else { continue };
        if !(difference < spreads[i]) {
            continue;
        }
        (done[i], done[j]) = (true, true);
        // psi_j = -ln(rho - a_j) is close to -psi_i.
        logarithms[j].1.constant = -logarithms[i].1.constant;
        let (e, f) = (&near[logarithms[i].0], &near[logarithms[j].0]);
        for (k, errors) in out.iter_mut().enumerate() {
            let v = e.normal().map(|n| n * e.strength[k]);
            let w = f.normal().map(|n| n * f.strength[k]);
            errors.fixed[0] += norm(minus(v, w)) * spreads[i] + norm(w) * difference;
        }
    }
    for (i, (index, _)) in logarithms.iter().enumerate() {
        if !done[i] {
            for (errors, c) in out.iter_mut().zip(near[*index].strength) {
                errors.fixed[0] += c.abs() * spreads[i];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::edge_fitted::gauss::kappa;

    #[test]
    fn kappas() {
        for m in 1..6 {
            assert!((KAPPA[m] / kappa(m) - 1.0).abs() < 1e-14, "{m} {}", kappa(m));
        }
    }
}

//! An upper bound of a(w, w) for w = f - S p on the cells in contact, continued and faded beyond them.
//!
//! With Phi = w(x) exp(-z/l(x)), l > 0 Lipschitz, in the half-space's Dirichlet principle (E* = 1):
//!
//! ```text
//! a(w, w) <= 1/4 int [ l |grad w|^2 + w grad w . grad l + w^2 (1 + |grad l|^2/2)/l ] dx.                              (2)
//! ```
//!
//! l = c l0 with l0 bilinear in every cell, so the right side is (c alpha + beta/c)/4. alpha and beta are sums over subcells of
//! the squares of interpolants, plus what interpolation leaves out (`interpolation`), joined by the triangle inequality:
//! (2) is the square of a norm of the pair (w, grad w).

use super::bilinear::{bilinear, restrict};
use super::fade::{Fade, Panel};
use super::gauss::{NODES, Touch, legendre, rule};
use super::group::{Group, Sources, groups};
use super::integrand::{Integrand, Sums};
use super::interpolation::{CHOICES, Errors, NodeLogarithms, errors};
use super::line_potential::{BATCH, Field, Lines, Points, Scratch};
use super::mesh::{Bilinear, Mesh, Point, cross, dot, minus, norm};
use super::subcell::{Fan, Subcell};
use super::surroundings::{Surroundings, add_block};
use super::symmetry::Orbits;
use crate::clock::Deadline;

/// How much of the slope's size in a cell interpolation may leave out.
const SHARE: f64 = 0.1;
/// Halvings of a cell's side at most.
const DEPTH: u32 = 40;
/// Subcells of a panel at most: a hundred times what those of a star come to. Beyond them nothing is proved.
const SUBCELLS: usize = 1 << 16;

/// A pressure, and the displacement value + slope . x that it is meant to make.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Target<'a> {
    /// Of the loaded cells; zero without contact.
    pub pressure: &'a [f64],
    pub value: f64,
    pub slope: Point,
}

impl<'a> Target<'a> {
    /// A level punch at depth 1.
    pub fn level(pressure: &'a [f64]) -> Self {
        Self { pressure, value: 1.0, slope: [0.0; 2] }
    }
}

/// The sums of (2) for pressures on the cells in `contact`, w = f - S p there, over one cell of each orbit; `None` once the
/// time is used up, and where a panel has no end of subcells.
pub(crate) fn norms<const K: usize>(
    mesh: &Mesh,
    lines: &Lines,
    orbits: &Orbits,
    decay: &[f64],
    contact: &[bool],
    targets: [Target; K],
    deadline: Deadline,
) -> Option<[Sums; K]> {
    let mut norms: [Sums; K] = std::array::from_fn(|_| Sums::default());
    let pressures = targets.map(|target| target.pressure);
    let strengths: Vec<Vec<f64>> = pressures.iter().map(|p| Lines::strengths(mesh, p)).collect();
    let strengths: [&[f64]; K] = std::array::from_fn(|k| strengths[k].as_slice());
    let fade = Fade::new(mesh, contact);
    let sources = Sources::new(mesh, lines, pressures, strengths);
    let mut work = Work { scratch: Scratch::default(), points: Points::EMPTY, pending: Vec::new() };
    let mut panels: Vec<Vec<Panel>> = (0..mesh.cells.len()).map(|_| Vec::new()).collect();
    for &cell in &orbits.representatives {
        panels[cell] = fade.panels(mesh, cell, strengths);
    }
    let cells: Vec<usize> = orbits.representatives.iter().copied().filter(|&c| !panels[c].is_empty()).collect();
    for cells in groups(mesh, cells).iter().filter(|cells| !cells.is_empty()) {
        let group = Group::new(&sources, cells, &mut work.scratch);
        for &cell in cells {
            if deadline.has_passed() {
                return None;
            }
            let context =
                Context { lines, decay: mesh.cells[cell].map(|n| decay[n]), extent: mesh.extent(), strengths, targets };
            let surroundings = Surroundings::new(&sources, &group, cell, &mut work.scratch);
            let mut own: [Sums; K] = std::array::from_fn(|_| Sums::default());
            for panel in &panels[cell] {
                if !subdivide(&context, &surroundings, panel, &mut own, &mut work) {
                    return None;
                }
            }
            context.flush(&surroundings, &mut own, &mut work);
            let size = orbits.size[orbits.orbit[cell]] as f64;
            for (norm, own) in norms.iter_mut().zip(own) {
                norm.add(size, &own);
            }
        }
    }
    Some(norms)
}

/// A subcell in four parts, none of which has two opposite sides or two corners of it.
fn quarters(whole: &Subcell) -> [Subcell; 4] {
    let halves = [[-1.0, 0.0], [0.0, 1.0]];
    [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(i, j)| {
        let ([a, b], [c, d]): ([f64; 2], [f64; 2]) = (halves[i], halves[j]);
        whole.part(0, a, b).part(1, c, d)
    })
}

/// One cell and what is asked for it.
struct Context<'a, const K: usize> {
    lines: &'a Lines,
    /// l0 at the corners.
    decay: [f64; 4],
    extent: f64,
    strengths: [&'a [f64]; K],
    targets: [Target<'a>; K],
}

/// An accepted subcell that waits for its fields.
struct Pending<const K: usize> {
    subcell: Subcell,
    chi: [f64; 4],
    count: [usize; 2],
    errors: [[f64; 2]; K],
    logarithms: NodeLogarithms,
    first: usize,
}

/// Buffers.
struct Work<const K: usize> {
    scratch: Scratch,
    points: Points,
    pending: Vec<Pending<K>>,
}

/// Cuts a panel until interpolation leaves out little enough; false where that takes too many subcells.
fn subdivide<const K: usize>(
    context: &Context<K>,
    surroundings: &Surroundings<K>,
    panel: &Panel,
    own: &mut [Sums; K],
    work: &mut Work<K>,
) -> bool {
    let whole = panel.subcell;
    let area = whole.map.area();
    // No subcell may touch an edge, or have a node, at both ends.
    let mut stack: Vec<(Subcell, u32)> = quarters(&whole).into_iter().map(|part| (part, 0)).collect();
    let mut count = 0;
    while let Some((subcell, depth)) = stack.pop() {
        count += 1;
        if count > SUBCELLS {
            return false;
        }
        let (errors, logarithms) = errors(&subcell, &surroundings.near, &surroundings.far, context.extent);
        let decay = context.decay_at(&subcell);
        let allowance = 0.5 * SHARE * (area / subcell.map.area()).powf(0.25);
        // The left-out slope, with the value's part, over the allowed one: per direction and number of nodes.
        let excess = |direction: usize, i: usize| {
            (0..K)
                .map(|k| {
                    let e = &errors[k];
                    let size = e.slope[direction][i] + e.value[direction][i] / decay;
                    size / (allowance * surroundings.scale[k].max(1e-300))
                })
                .fold(0.0, f64::max)
        };
        let fixed = (0..K)
            .map(|k| {
                (errors[k].fixed[0] + errors[k].fixed[1] / decay)
                    / (2.0 * allowance * surroundings.scale[k].max(1e-300))
            })
            .fold(0.0, f64::max);
        let choose = |direction: usize| (0..CHOICES).find(|&i| excess(direction, i) <= 1.0);
        let choice = [choose(0), choose(1)];
        let small = depth >= DEPTH;
        if let ([Some(i), Some(j)], true) = (choice, fixed <= 1.0 || small || logarithms.is_empty()) {
            context.accept(surroundings, subcell, panel, [i, j], &errors, logarithms, own, work);
        } else if small {
            let best = |d: usize| choice[d].unwrap_or(CHOICES - 1);
            context.accept(surroundings, subcell, panel, [best(0), best(1)], &errors, logarithms, own, work);
        } else {
            let half = subcell.half();
            let both = choice[0].is_some() && choice[1].is_some();
            let direction =
                if both { usize::from(half[1] > half[0]) } else { usize::from(excess(1, 2) > excess(0, 2)) };
            stack.push((subcell.part(direction, -1.0, 0.0), depth + 1));
            stack.push((subcell.part(direction, 0.0, 1.0), depth + 1));
        }
    }
    true
}

impl<const K: usize> Context<'_, K> {
    /// l0 in the middle of a subcell.
    fn decay_at(&self, subcell: &Subcell) -> f64 {
        let [s, t] = subcell.range.map(|r| 0.5 * (r[0] + r[1]));
        bilinear(&self.decay, s, t)
    }

    #[allow(clippy::too_many_arguments)]
    fn accept(
        &self,
        surroundings: &Surroundings<K>,
        subcell: Subcell,
        panel: &Panel,
        choice: [usize; 2],
        errors: &[Errors; K],
        logarithms: NodeLogarithms,
        own: &mut [Sums; K],
        work: &mut Work<K>,
    ) {
        let count = choice.map(|i| i + NODES[0]);
        let size = count[0] * count[1];
        if work.points.len + size > BATCH {
            self.flush(surroundings, own, work);
        }
        let first = work.points.len;
        let (x, y) = (&legendre(count[0]).0, &legendre(count[1]).0);
        for t in y {
            for s in x {
                work.points.push(subcell.map.at(*s, *t));
            }
        }
        let errors = std::array::from_fn(|k| {
            let e = &errors[k];
            [
                e.slope[0][choice[0]] + e.slope[1][choice[1]] + e.fixed[0],
                e.value[0][choice[0]] + e.value[1][choice[1]] + e.fixed[1],
            ]
        });
        // chi on the subcell, whose range is in the cell, from the panel's corners.
        let relative = [0, 1].map(|k| {
            let [a, b] = panel.subcell.range[k];
            subcell.range[k].map(|x| (2.0 * x - a - b) / (b - a))
        });
        let chi = restrict(&panel.chi, &relative);
        work.pending.push(Pending { subcell, chi, count, errors, logarithms, first });
    }

    /// Evaluates the fields of all pending subcells and adds their shares.
    fn flush(&self, surroundings: &Surroundings<K>, own: &mut [Sums; K], work: &mut Work<K>) {
        if work.points.len == 0 {
            return;
        }
        let strengths = std::array::from_fn(|k| surroundings.strengths[k].as_slice());
        let mut fields = surroundings.lines.fields(strengths, &work.points, &mut work.scratch);
        for pending in &work.pending {
            add_block(&pending.subcell, pending.count, pending.first, surroundings, &mut fields);
        }
        for pending in &work.pending {
            for k in 0..K {
                self.add(k, pending, &fields[k], &work.points, surroundings, &mut own[k]);
            }
        }
        work.points.len = 0;
        work.pending.clear();
    }

    /// Adds the share of one subcell to the sums of pressure `k`.
    fn add(
        &self,
        k: usize,
        pending: &Pending<K>,
        field: &Field,
        points: &Points,
        surroundings: &Surroundings<K>,
        own: &mut Sums,
    ) {
        let chi = &pending.chi;
        if *chi == [0.0; 4] {
            return;
        }
        let subcell = &pending.subcell;
        let map = &subcell.map;
        let [m, n] = pending.count;
        let touches = [subcell.touch(0), subcell.touch(1)];
        let rules = [rule(m, touches[0].0), rule(n, touches[1].0)];
        let jumps =
            touches.map(|(_, e)| e.map_or([0.0; 2], |e| self.lines.normal(e).map(|c| 2.0 * c * self.strengths[k][e])));
        // Displacement and slope at the nodes, less the singular parts: grad u contains -2 c n ln t of a touched edge.
        let mut nodal = [[0.0; 25]; 3];
        let (x, y) = (&legendre(m).0, &legendre(n).0);
        let fan = if pending.logarithms.is_empty() { None } else { Fan::new(subcell) };
        for (j, t) in y.iter().enumerate() {
            for (i, s) in x.iter().enumerate() {
                let p = pending.first + j * m + i;
                let mut value = [field.u[p], field.slope[0][p], field.slope[1][p]];
                for (d, (coordinate, jump)) in [(*s, jumps[0]), (*t, jumps[1])].into_iter().enumerate() {
                    let log = match touches[d].0 {
                        Touch::None => continue,
                        Touch::Low => (0.5 * (1.0 + coordinate)).ln(),
                        Touch::High => (0.5 * (1.0 - coordinate)).ln(),
                    };
                    value[1] += jump[0] * log;
                    value[2] += jump[1] * log;
                }
                if let Some(fan) = &fan {
                    let v = minus([points.x[p], points.y[p]], fan.node());
                    for (index, logarithm) in &pending.logarithms {
                        let e = &surroundings.near[*index];
                        let psi = logarithm.value(v) * e.strength[k];
                        let normal = e.normal();
                        value[0] -= psi * dot(v, normal);
                        value[1] -= psi * normal[0];
                        value[2] -= psi * normal[1];
                    }
                }
                for (array, v) in nodal.iter_mut().zip(value) {
                    array[j * m + i] = v;
                }
            }
        }
        let decay = restrict(&self.decay, &subcell.range);
        let Target { value, slope, .. } = self.targets[k];
        let shape = Integrand {
            overlap: map.corners().map(|p| value + dot(slope, p)),
            slope,
            map,
            decay,
            rules,
            count: pending.count,
            nodal: &nodal,
            jumps,
            left_out: pending.errors[k],
        };
        own.add(1.0, &shape.sums(chi));
    }
}

/// l0 at the nodes: (h_s^-2 + h_t^-2)^(-1/2) of the thinnest cells that meet there.
pub(crate) fn decay_lengths(mesh: &Mesh) -> Vec<f64> {
    let mut l = vec![f64::INFINITY; mesh.nodes.len()];
    for (cell, nodes) in mesh.cells.iter().enumerate() {
        let map = Bilinear::new(mesh.corners(cell));
        let [u, v] = map.along;
        let area = cross(u, v).abs();
        // Distances between opposite sides.
        let (hs, ht) = (2.0 * area / norm(v), 2.0 * area / norm(u));
        for &n in nodes {
            l[n] = l[n].min((hs.powi(-2) + ht.powi(-2)).powf(-0.5));
        }
    }
    l
}

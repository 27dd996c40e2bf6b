//! Subcells of one cell on which displacement and slope are interpolated and squared (`residual_norm`), and signs are shown (`beyond`).

use super::beyond::{largest, range};
use super::bilinear::{bilinear, restrict};
use super::fade::Panel;
use super::gauss::{NODES, Touch, legendre, rule};
use super::integrand::{Integrand, Interpolant, Sums};
use super::interpolation::{CHOICES, Errors, NodeLogarithms, errors};
use super::line_potential::{BATCH, Field, Lines, Points, Scratch};
use super::mesh::{dot, minus};
use super::subcell::{Fan, Subcell};
use super::surroundings::Surroundings;

/// How much of the slope's size in a cell interpolation may leave out, where all cells are in contact, and where not: there a width takes 5
/// to 10 % less time with the first than with the second, here it costs about the same with half or twice as much, and misses more often.
const SHARE: [f64; 2] = [0.1, 0.06];
/// Halvings of a cell's side at most.
const DEPTH: u32 = 40;
/// Subcells of a panel at most: a hundred times what those of a star come to. Beyond them nothing is proved.
const SUBCELLS: usize = 1 << 16;
/// Where only signs count: nodes of a direction, less two.
const SIGNS: usize = 2;
/// Halvings until both continuations are counted.
const UNDECIDED: u32 = 6;
/// Halvings until a sign that has to be shown is given up.
const GIVEN_UP: u32 = 24;

/// Pairs of residuals at most.
pub(crate) const PAIRS: usize = 3;

/// What subcells add to.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shares<const K: usize> {
    /// Of every residual, faded from the cells in contact and from the wider set.
    pub own: [[Sums; 2]; K],
    /// Of pairs of residuals, added up, faded from the cells in contact; what interpolation leaves out of them is not told.
    pub joint: [Sums; PAIRS],
}

impl<const K: usize> Shares<K> {
    pub fn zero() -> Self {
        Self { own: [[Sums::default(); 2]; K], joint: [Sums::default(); PAIRS] }
    }

    /// Adds `size` times others.
    pub fn add(&mut self, size: f64, other: &Self) {
        let all = self.own.iter_mut().flatten().chain(&mut self.joint);
        all.zip(other.own.iter().flatten().chain(&other.joint)).for_each(|(sums, other)| sums.add(size, other));
    }
}

/// One cell and what is asked for it.
pub(crate) struct Context<'a, const K: usize> {
    pub lines: &'a Lines,
    /// l0 at the corners.
    pub decay: [f64; 4],
    /// The same of what is faded by the wider factor, and of no residual.
    pub wider: [f64; 4],
    pub extent: f64,
    /// What may be left out, over [`SHARE`].
    pub allowance: f64,
    pub strengths: [&'a [f64]; K],
    /// Residuals of which the sums are asked for, too.
    pub pairs: &'a [[usize; 2]],
    /// f as value + slope . x, and what is left out of its slope and its value.
    pub overlap: [([f64; 3], [f64; 2]); K],
    /// Of `beyond`.
    pub tau: Option<f64>,
    pub surroundings: Surroundings<K>,
}

/// An accepted subcell that waits for its fields.
struct Pending<const K: usize> {
    subcell: Subcell,
    depth: u32,
    chi: [[f64; 4]; 2],
    material: bool,
    count: [usize; 2],
    errors: [[f64; 2]; K],
    /// What the displacement leaves out at most, along both directions and besides; infinite where it is singular.
    at_most: [[f64; 3]; K],
    logarithms: NodeLogarithms,
    first: usize,
}

/// Buffers.
pub(crate) struct Work<const K: usize> {
    pub scratch: Scratch,
    points: Points,
    pending: Vec<Pending<K>>,
}

impl<const K: usize> Default for Work<K> {
    fn default() -> Self {
        Self { scratch: Scratch::default(), points: Points::EMPTY, pending: Vec::new() }
    }
}

impl<const K: usize> Work<K> {
    fn has_room(&self, choice: [usize; 2]) -> bool {
        self.points.len + (choice[0] + NODES[0]) * (choice[1] + NODES[0]) <= BATCH
    }
}

/// Parts of a panel that are left, and how often they were halved.
type Stack = Vec<(Subcell, u32)>;

impl<const K: usize> Context<'_, K> {
    /// Cuts a panel until interpolation leaves out little enough, and signs are shown; `None` where that takes too many subcells.
    pub fn subdivide(&self, panel: &Panel, own: &mut Shares<K>, work: &mut Work<K>) -> Option<()> {
        let whole = panel.subcell;
        let area = whole.map.area();
        let share = SHARE[usize::from(self.tau.is_some())];
        let surroundings = &self.surroundings;
        // No subcell may touch an edge, or have a node, at both ends.
        let mut stack: Stack = whole.quarters().into_iter().map(|part| (part, 0)).collect();
        let mut count = 0;
        while let Some((subcell, depth)) = stack.pop() {
            count += 1;
            if count > SUBCELLS {
                return None;
            }
            let (errors, logarithms) =
                errors(&subcell, &surroundings.near, &surroundings.lanes, &surroundings.far, self.extent);
            let decay = self.decay_at(&subcell);
            let allowance = 0.5 * share * self.allowance * (area / subcell.map.area()).powf(0.25);
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
            let small = depth >= DEPTH;
            // Where nothing is summed only signs count, and show whether the subcell is small enough.
            let choice = if panel.chi == [[0.0; 4]; 2] { [Some(SIGNS); 2] } else { [choose(0), choose(1)] };
            if small || (choice.iter().all(Option::is_some) && (fixed <= 1.0 || logarithms.is_empty())) {
                let choice = choice.map(|choice| choice.unwrap_or(CHOICES - 1));
                if !work.has_room(choice) {
                    self.flush(own, work, &mut stack)?;
                }
                self.accept((subcell, depth), panel, choice, &errors, logarithms, work);
            } else {
                let half = subcell.half();
                let both = choice[0].is_some() && choice[1].is_some();
                let direction =
                    if both { usize::from(half[1] > half[0]) } else { usize::from(excess(1, 2) > excess(0, 2)) };
                stack.extend(subcell.halves(direction).map(|half| (half, depth + 1)));
            }
            if stack.is_empty() && self.tau.is_some() && panel.chi[0] != [1.0; 4] {
                self.flush(own, work, &mut stack)?;
            }
        }
        Some(())
    }

    /// l0 in the middle of a subcell.
    fn decay_at(&self, subcell: &Subcell) -> f64 {
        let [s, t] = subcell.range.map(|r| 0.5 * (r[0] + r[1]));
        bilinear(&self.decay, s, t)
    }

    fn accept(
        &self,
        (subcell, depth): (Subcell, u32),
        panel: &Panel,
        choice: [usize; 2],
        errors: &[Errors; K],
        logarithms: NodeLogarithms,
        work: &mut Work<K>,
    ) {
        let count = choice.map(|i| i + NODES[0]);
        let first = work.points.len;
        let (x, y) = (&legendre(count[0]).0, &legendre(count[1]).0);
        for t in y {
            for s in x {
                work.points.push(subcell.map.at(*s, *t));
            }
        }
        let singular = subcell.sides.iter().any(Option::is_some) || !logarithms.is_empty();
        let at_most = std::array::from_fn(|k| {
            let [s, t, rest] = largest(&errors[k], choice);
            if singular { [f64::INFINITY; 3] } else { [s, t, rest + self.overlap[k].1[1]] }
        });
        let errors = std::array::from_fn(|k| {
            let (e, [slope, value]) = (&errors[k], self.overlap[k].1);
            [
                e.slope[0][choice[0]] + e.slope[1][choice[1]] + e.fixed[0] + slope,
                e.value[0][choice[0]] + e.value[1][choice[1]] + e.fixed[1] + value,
            ]
        });
        // chi on the subcell, whose range is in the cell, from the panel's corners.
        let relative = [0, 1].map(|k| {
            let [a, b] = panel.subcell.range[k];
            subcell.range[k].map(|x| (2.0 * x - a - b) / (b - a))
        });
        let chi = panel.chi.map(|chi| restrict(&chi, &relative));
        let material = panel.material;
        work.pending.push(Pending { subcell, depth, chi, material, count, errors, at_most, logarithms, first });
    }

    /// Evaluates the fields of all pending subcells and adds their shares; those that are too large for what has to be shown go back on the
    /// stack. `None` where a sign is given up.
    pub fn flush(&self, own: &mut Shares<K>, work: &mut Work<K>, stack: &mut Stack) -> Option<()> {
        if work.points.len == 0 {
            return Some(());
        }
        let surroundings = &self.surroundings;
        let strengths = std::array::from_fn(|k| surroundings.strengths[k].as_slice());
        let mut fields = surroundings.lines.fields(strengths, &work.points, &mut work.scratch);
        for pending in &work.pending {
            surroundings.block.add_on(&pending.subcell, pending.count, pending.first, &mut fields);
        }
        for pending in &work.pending {
            let [of_contact, of_wider] = pending.chi;
            let weights = match self.tau {
                // Faded alike everywhere.
                None => [[true, false]; K],
                _ if of_contact == of_wider && of_contact == [1.0; 4] => [[true; 2]; K],
                Some(tau) => match self.continued(tau, pending, &fields, &work.points) {
                    Continued::Known(signs) => std::array::from_fn(|k| if k == 0 { signs } else { [true; 2] }),
                    Continued::Larger(_) if pending.depth >= GIVEN_UP => return None,
                    Continued::Larger(direction) => {
                        stack.extend(pending.subcell.halves(direction).map(|half| (half, pending.depth + 1)));
                        continue;
                    }
                },
            };
            let shapes: [Option<Interpolant>; K] = std::array::from_fn(|k| {
                let chi = [0, 1].map(|q| if weights[k][q] { pending.chi[q] } else { [0.0; 4] });
                let shape = (chi != [[0.0; 4]; 2]).then(|| self.interpolant(k, pending, &fields[k], &work.points))?;
                self.add(k, pending, &shape, chi, &mut own.own[k]);
                Some(shape)
            });
            for (joint, [i, j]) in own.joint.iter_mut().zip(self.pairs) {
                if let (Some(a), Some(b)) = (&shapes[*i], &shapes[*j]) {
                    let both = a.plus(b);
                    joint.add(1.0, &self.integrand(pending, &both, &self.decay, [0.0; 2]).sums(&of_contact));
                }
            }
        }
        work.points.len = 0;
        work.pending.clear();
        Some(())
    }

    /// What `beyond` asks for on a subcell without contact.
    fn continued(&self, tau: f64, pending: &Pending<K>, fields: &[Field; K], points: &Points) -> Continued {
        let Pending { subcell, depth, chi: [of_contact, of_wider], material, count, at_most, first, .. } = pending;
        let places = *first..first + count[0] * count[1];
        let residual = |k: usize| -> Vec<f64> {
            let ([c, a, b], _) = self.overlap[k];
            places.clone().map(|i| c + a * points.x[i] + b * points.y[i] - fields[k].u[i]).collect()
        };
        let r = residual(0);
        let off = |k: usize| at_most[k].iter().sum::<f64>();
        let [low, high] = range(&r, *count, off(0));
        let direction = || {
            let sides = [0, 1].map(|k| subcell.touch(k).1.is_some());
            if sides[0] != sides[1] {
                return usize::from(sides[1]);
            }
            // Where it varies most.
            let [m, n] = *count;
            let along = |i: usize, j: usize, step: usize| (r[j * m + i + step] - r[j * m + i]).abs();
            let most = [
                (0..n).flat_map(|j| (0..m - 1).map(move |i| along(i, j, 1))).fold(0.0, f64::max),
                (0..n - 1).flat_map(|j| (0..m).map(move |i| along(i, j, m))).fold(0.0, f64::max),
            ];
            let open = |k: usize| tau * (most[k] + at_most[0][k]) + at_most[1][k];
            usize::from(open(1) > open(0))
        };
        if *material && *of_wider != [1.0; 4] {
            let close = || {
                let v = residual(1);
                // v (1 - chi') <= most v, with 1 - chi' >= 0, where v >= 0.
                let most = 1.0 - of_wider.iter().fold(1.0, |a: f64, b| a.min(*b));
                let both: Vec<f64> = v.iter().zip(&r).map(|(v, r)| most * v + tau * r).collect();
                range(&v, *count, off(1))[1] <= 0.0 || range(&both, *count, most * off(1) + tau * off(0))[1] <= 0.0
            };
            return if high <= 0.0 && close() {
                Continued::Known([true, false])
            } else {
                Continued::Larger(direction())
            };
        }
        match (low >= 0.0, high <= 0.0) {
            (true, _) => Continued::Known([false, true]),
            (_, true) => Continued::Known([true, false]),
            _ if *depth >= UNDECIDED || of_contact == of_wider => Continued::Known([true; 2]),
            _ => Continued::Larger(direction()),
        }
    }

    /// Displacement and slope of pressure `k` at the nodes of a subcell, less their singular parts: grad u contains -2 c n ln t of a touched
    /// edge.
    fn interpolant(&self, k: usize, pending: &Pending<K>, field: &Field, points: &Points) -> Interpolant {
        let Pending { subcell, count: [m, n], logarithms, first, .. } = pending;
        let touches = [subcell.touch(0), subcell.touch(1)];
        let jumps =
            touches.map(|(_, e)| e.map_or([0.0; 2], |e| self.lines.normal(e).map(|c| 2.0 * c * self.strengths[k][e])));
        let mut nodal = [[0.0; 25]; 3];
        let (x, y) = (&legendre(*m).0, &legendre(*n).0);
        let fan = if logarithms.is_empty() { None } else { Fan::new(subcell) };
        for (j, t) in y.iter().enumerate() {
            for (i, s) in x.iter().enumerate() {
                let p = first + j * m + i;
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
                    for (index, logarithm) in logarithms {
                        let e = &self.surroundings.near[*index];
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
        let ([value, a, b], _) = self.overlap[k];
        let slope = [a, b];
        Interpolant { overlap: subcell.map.corners().map(|p| value + dot(slope, p)), slope, nodal, jumps }
    }

    fn integrand<'a>(
        &self,
        Pending { subcell, count, .. }: &'a Pending<K>,
        interpolant: &'a Interpolant,
        decay: &[f64; 4],
        left_out: [f64; 2],
    ) -> Integrand<'a> {
        let rules = [0, 1].map(|k| rule(count[k], subcell.touch(k).0));
        Integrand {
            map: &subcell.map,
            interpolant,
            decay: restrict(decay, &subcell.range),
            rules,
            count: *count,
            left_out,
        }
    }

    /// Adds the share of one subcell to the sums of pressure `k`, for both factors.
    fn add(&self, k: usize, pending: &Pending<K>, shape: &Interpolant, chi: [[f64; 4]; 2], own: &mut [Sums; 2]) {
        let with = |decay: &[f64; 4]| self.integrand(pending, shape, decay, pending.errors[k]);
        let first = with(&self.decay).sums(&chi[0]);
        own[0].add(1.0, &first);
        let wider = if k == 0 { &self.decay } else { &self.wider };
        if chi[1] == chi[0] && *wider == self.decay {
            own[1].add(1.0, &first);
        } else if chi[1] != [0.0; 4] {
            own[1].add(1.0, &with(wider).sums(&chi[1]));
        }
    }
}

/// How w goes on over a subcell.
enum Continued {
    /// By chi r, by chi' r.
    Known([bool; 2]),
    /// The subcell is too large to tell, along this direction.
    Larger(usize),
}

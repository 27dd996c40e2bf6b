//! Force and moment over depth and one tilt: what a crowned roller, a wheel or a misaligned bearing is to a multibody code.
//!
//! The stored energy is tabulated, and force and moment are its exact derivatives at every depth and tilt: a body that rocks on the
//! table neither gains nor loses energy. With t(a) the depth of first touch at tilt a, and s = d - t(a) the overlap, ln U is nearly a
//! straight line in ln s: bicubic Hermite pieces of ln U over (ln s, a) with the exact slopes
//!
//!   d ln U/d ln s = P s/U,   d ln U/da = (M + P t')/U,   t' = -(lever arm of first touch),
//!
//! and their cross derivative by the stiffness of the patch. Nodes are added between nodes until force and moment of new states
//! are met.

use crate::error::{InputError, finite, positive};
use crate::numeric::cubic::Cubic;
use crate::overlap::least;
use crate::problem::{Contact, Load, Loading, Outputs, Settings};
use crate::solution::{Unsolved, Verdict};
use crate::solve::solve;
use crate::threads::each;

/// Intervals of overlap and of tilt that a table begins with.
const FIRST: [usize; 2] = [3, 2];

/// Most states of one table.
const MOST: usize = 600;

/// Share of a miss between two nodes that is left when a node is put there: 1/16 where the energy is smooth.
const LEFT: f64 = 0.2;

/// What [`TiltTable::new`] is asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TiltRange {
    /// Smallest and largest overlap below first touch, 0 < from < to; shallower states follow the power law there.
    pub overlap: [f64; 2],
    /// Smallest and largest tilt, radians.
    pub tilt: [f64; 2],
    /// Direction in which the tilt lifts the body, radians from x: at 0 the overlap grows by tilt times x.
    pub direction: f64,
    /// Error of the force, relative, and of the moment, over force and size of the patch, that is good enough.
    pub accuracy: f64,
}

/// What the table says at a depth and a tilt.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TiltedForce {
    /// Normal force.
    pub force: f64,
    /// Moment that works on the tilt: the integral of pressure times lever arm along the direction.
    pub moment: f64,
    /// Derivatives of force and moment by depth and tilt; symmetric.
    pub stiffness: [[f64; 2]; 2],
    /// Stored energy.
    pub energy: f64,
}

/// Force and moment over depth and tilt.
///
/// ```
/// use contact_patch::{Contact, EffectiveModulus, Loading, Settings, gap::Paraboloid};
/// use contact_patch::curve::{TiltRange, TiltTable};
/// // A crowned roller: a tilt about y moves the contact along x, to x = 10 a.
/// let roller = Contact::new(EffectiveModulus::from_e_star(1.0)?, Paraboloid::new([10.0, 1.0])?, Loading::depth(0.01))?;
/// let range = TiltRange { overlap: [1e-3, 1e-2], tilt: [0.0, 0.01], direction: 0.0, accuracy: 1e-3 };
/// let table = TiltTable::new(&roller, &Settings::default(), range)?;
/// let upright = table.at(5e-3, 0.0).unwrap();
/// let tilted = table.at(5e-3, 0.006).unwrap();
/// assert!(tilted.force > upright.force && (tilted.moment / tilted.force / 0.06 - 1.0).abs() < 1e-2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct TiltTable {
    /// ln of the overlaps.
    logs: Vec<f64>,
    tilts: Vec<f64>,
    /// Depth of first touch and its slope, at each tilt.
    touch: Vec<[f64; 2]>,
    /// ln U, by ln s, by tilt, by both; tilt by tilt.
    nodes: Vec<[f64; 4]>,
    error: f64,
    solves: usize,
}

/// A solved state.
#[derive(Debug, Clone, Copy)]
struct Node {
    log: f64,
    touch: [f64; 2],
    force: f64,
    moment: f64,
    energy: f64,
    /// dP/dd, dP/da.
    stiffness: [f64; 2],
    /// Half the side of the patch along the direction.
    size: f64,
    error: f64,
}

impl Node {
    fn of_table(&self) -> [f64; 4] {
        let Self { log, touch: [_, rise], force, moment, energy, stiffness: [k, across], .. } = *self;
        let s = log.exp();
        // By the tilt at one overlap.
        let by_tilt = moment + force * rise;
        let cross = s * ((across + k * rise) / energy - force * by_tilt / (energy * energy));
        [energy.ln(), force * s / energy, by_tilt / energy, cross]
    }
}

/// States of one contact at overlaps and tilts.
struct States<'a> {
    contact: &'a Contact,
    settings: Settings,
    direction: [f64; 2],
    threads: usize,
}

impl States<'_> {
    /// Depth of first touch at a tilt, and its slope.
    fn touch(&self, tilt: f64) -> [f64; 2] {
        let [x, y] = self.direction;
        let (at, depth) = least(&self.contact.gap().tilted([tilt * x, tilt * y]));
        [depth, -(at[0] * x + at[1] * y)]
    }

    fn at(&self, places: &[[f64; 2]]) -> Result<Vec<Node>, Unsolved> {
        each(places, self.threads, |&[log, tilt]| self.node(log, tilt))
    }

    fn node(&self, log: f64, tilt: f64) -> Result<Node, Unsolved> {
        let [ex, ey] = self.direction;
        let touch = self.touch(tilt);
        let load = Load::Tilted { depth: touch[0] + log.exp(), tilt: [tilt * ex, tilt * ey] };
        let state = solve(&self.contact.under(Loading::Single(load)), &self.settings)
            .remove(0)
            .or_else(Unsolved::accept_best)?;
        let lacking = || {
            let reason =
                format!("no energy, moment and stiffness at overlap {:e}, tilt {tilt:e} by this method", log.exp());
            Unsolved::new(Verdict::NotApplicable, reason)
        };
        let (energy, [mx, my], k) = (
            state.energy.ok_or_else(lacking)?,
            state.moment.ok_or_else(lacking)?,
            state.stiffness_matrix.ok_or_else(lacking)?,
        );
        if !(state.force > 0.0 && energy > 0.0) {
            return Err(lacking());
        }
        let size = (state.patch.area / std::f64::consts::PI).sqrt();
        let size =
            state.patch.extent().map_or(size, |[a, b]| 0.5 * ((b[0] - a[0]) * ex.abs() + (b[1] - a[1]) * ey.abs()));
        Ok(Node {
            log,
            touch,
            force: state.force,
            moment: -my * ex + mx * ey,
            energy,
            stiffness: [k[0][0], k[0][1] * ex + k[0][2] * ey],
            size,
            error: state.force_error.unwrap_or(0.0),
        })
    }
}

impl TiltTable {
    /// The table of a contact; its loading is not used.
    ///
    /// # Errors
    /// `NotApplicable` when a range is none, and where the method gives no energy, moment or stiffness; what stops a solve at some place.
    pub fn new(contact: &Contact, settings: &Settings, range: TiltRange) -> Result<Self, Unsolved> {
        range.checked().map_err(|e| Unsolved::new(Verdict::NotApplicable, e.to_string()))?;
        let TiltRange { overlap: [from, to], tilt: [low, high], direction, accuracy } = range;
        let (sine, cosine) = direction.sin_cos();
        let own = Settings {
            outputs: Outputs { energy: true, ..Outputs::default() },
            tolerance: (0.4 * accuracy).min(settings.tolerance).max(1e-6),
            threads: 1,
            ..*settings
        };
        let states = States { contact, settings: own, direction: [cosine, sine], threads: settings.threads.max(1) };
        let spread =
            |a: f64, b: f64, n: usize| (0..=n).map(|k| a + (b - a) * (k as f64 / n as f64)).collect::<Vec<f64>>();
        let (mut logs, mut tilts) = (spread(from.ln(), to.ln(), FIRST[0]), spread(low, high, FIRST[1]));
        let places: Vec<[f64; 2]> = tilts.iter().flat_map(|&a| logs.iter().map(move |&x| [x, a])).collect();
        let mut nodes = states.at(&places)?;
        let mut left = [f64::INFINITY; 2];
        loop {
            let table = Self::of(&logs, &tilts, &nodes, 0.0);
            // What is open in either direction: along overlaps first.
            let Some(axis) = (0..2).find(|&axis| LEFT * left[axis] > 0.25 * accuracy) else {
                let own = nodes.iter().map(|n| n.error).fold(0.0, f64::max);
                let error = own + LEFT * (left[0] + left[1]);
                return Ok(Self { error, ..table });
            };
            let between = |of: &[f64]| of.windows(2).map(|w| 0.5 * (w[0] + w[1])).collect::<Vec<f64>>();
            let (new_logs, new_tilts) =
                if axis == 0 { (between(&logs), tilts.clone()) } else { (logs.clone(), between(&tilts)) };
            let places: Vec<[f64; 2]> = new_tilts.iter().flat_map(|&a| new_logs.iter().map(move |&x| [x, a])).collect();
            if nodes.len() + places.len() > MOST {
                let own = nodes.iter().map(|n| n.error).fold(0.0, f64::max);
                let known = |miss: f64| if miss.is_finite() { LEFT * miss } else { 1.0 };
                return Ok(Self { error: own + known(left[0]) + known(left[1]), ..table });
            }
            let found = states.at(&places)?;
            left[axis] = places.iter().zip(&found).map(|(&[_, a], node)| table.miss(a, node)).fold(0.0, f64::max);
            nodes = if axis == 0 {
                let rows = nodes.chunks(logs.len()).zip(found.chunks(new_logs.len()));
                rows.flat_map(|(old, new)| woven(old, new)).collect()
            } else {
                let (old, new): (Vec<_>, Vec<_>) =
                    (nodes.chunks(logs.len()).collect(), found.chunks(logs.len()).collect());
                woven(&old, &new).into_iter().flatten().copied().collect()
            };
            if axis == 0 {
                logs = woven(&logs, &new_logs);
            } else {
                tilts = woven(&tilts, &new_tilts);
            }
        }
    }

    fn of(logs: &[f64], tilts: &[f64], nodes: &[Node], error: f64) -> Self {
        Self {
            logs: logs.to_vec(),
            tilts: tilts.to_vec(),
            touch: nodes.chunks(logs.len()).map(|row| row[0].touch).collect(),
            nodes: nodes.iter().map(Node::of_table).collect(),
            error,
            solves: nodes.len(),
        }
    }

    /// How far off the table is at a state: of the force, and of the moment over force and size.
    fn miss(&self, tilt: f64, node: &Node) -> f64 {
        // At the overlap of the state: its touch is exact, that of the table is not.
        self.at(node.touch[0] + node.log.exp(), tilt).map_or(1.0, |found| {
            let moment = (found.moment - node.moment).abs() / (node.force * node.size);
            (found.force / node.force - 1.0).abs().max(moment)
        })
    }

    /// Force, moment and stiffness at a depth and a tilt: zero before first touch, power laws of the overlap beyond the range of
    /// overlaps; `None` beyond the range of tilts.
    #[must_use]
    pub fn at(&self, depth: f64, tilt: f64) -> Option<TiltedForce> {
        let (low, high) = (*self.tilts.first()?, *self.tilts.last()?);
        if !(depth.is_finite() && tilt >= low && tilt <= high) {
            return None;
        }
        let j = self.tilts.partition_point(|&a| a < tilt).clamp(1, self.tilts.len() - 1) - 1;
        let width = self.tilts[j + 1] - self.tilts[j];
        let v = Cubic { t: (tilt - self.tilts[j]) / width, h: width };
        let touched = |n: usize| v.value(n, self.touch[j], self.touch[j + 1]);
        let [touch, rise, bend] = [touched(0), touched(1), touched(2)];
        let s = depth - touch;
        if s <= 0.0 {
            return Some(TiltedForce::default());
        }
        let (first, last) = (self.logs[0], self.logs[self.logs.len() - 1]);
        let log = s.ln().clamp(first, last);
        let beyond = s.ln() - log;
        let i = self.logs.partition_point(|&x| x < log).clamp(1, self.logs.len() - 1) - 1;
        let length = self.logs[i + 1] - self.logs[i];
        let u = Cubic { t: (log - self.logs[i]) / length, h: length };
        let node = |i: usize, j: usize| self.nodes[j * self.logs.len() + i];
        // m-th derivative by ln s, n-th by the tilt.
        let w = |m: usize, n: usize| {
            let along = |i: usize| {
                let (a, b) = (node(i, j), node(i, j + 1));
                [v.value(n, [a[0], a[2]], [b[0], b[2]]), v.value(n, [a[1], a[3]], [b[1], b[3]])]
            };
            u.value(m, along(i), along(i + 1))
        };
        // Beyond the overlaps ln U goes on along its tangent.
        let steep = [w(1, 0), w(1, 1), w(1, 2)];
        let [value, by_a, by_aa] = [0, 1, 2].map(|n| w(0, n) + steep[n] * beyond);
        let (by_x, by_xa) = (steep[0], steep[1]);
        let by_xx = if beyond == 0.0 { w(2, 0) } else { 0.0 };
        let energy = value.exp();
        let force = energy * by_x / s;
        let moment = energy * by_a - force * rise;
        let k = energy / (s * s) * (by_xx + by_x * by_x - by_x);
        let mixed = energy / s * (by_xa + by_x * by_a);
        let across = mixed - k * rise;
        let own = energy * (by_aa + by_a * by_a) - rise * mixed - across * rise - force * bend;
        Some(TiltedForce { force, moment, stiffness: [[k, across], [across, own]], energy })
    }

    /// Estimate of the largest error within the range: of the force, relative, and of the moment, over force and half the side of the patch.
    #[must_use]
    pub fn error(&self) -> f64 {
        self.error
    }

    /// States that were solved.
    #[must_use]
    pub fn solves(&self) -> usize {
        self.solves
    }

    /// Overlaps and tilts of the nodes.
    #[must_use]
    pub fn nodes(&self) -> [Vec<f64>; 2] {
        [self.logs.iter().map(|x| x.exp()).collect(), self.tilts.clone()]
    }
}

/// One of the old, one of the new between, and so on.
fn woven<T: Copy>(old: &[T], new: &[T]) -> Vec<T> {
    let mut all = Vec::with_capacity(old.len() + new.len());
    for (k, &item) in old.iter().enumerate() {
        all.push(item);
        all.extend(new.get(k).copied());
    }
    all
}

impl TiltRange {
    fn checked(&self) -> Result<(), InputError> {
        positive("overlap[0]", self.overlap[0])?;
        positive("overlap[1]", self.overlap[1])?;
        finite("tilt[0]", self.tilt[0])?;
        finite("tilt[1]", self.tilt[1])?;
        finite("direction", self.direction)?;
        positive("accuracy", self.accuracy)?;
        if self.overlap[0] >= self.overlap[1] {
            return Err(InputError::new("overlap[0]", self.overlap[0], "less than the largest"));
        }
        if self.tilt[0] >= self.tilt[1] {
            return Err(InputError::new("tilt[0]", self.tilt[0], "less than the largest"));
        }
        Ok(())
    }
}

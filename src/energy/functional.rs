//! Bounds of a linear functional of the exact pressure, its force or a moment, from one pressure.
//!
//! p is the exact pressure, p_h >= 0 the one at hand, u_h = S p_h, r = f - u_h, X = <S p - f, p_h> >= 0; in the energy norm
//! |p - p_h|^2 = 2 (U - U_low - X), U - U_low <= gamma. T = eta - mu f - W . grad f is what dilations and translations leave of eta
//! ([`super::virial`]; T = eta where nothing is known of them). With any function m on the cells under pressure, and T - S m for rho,
//!
//!   <eta, p> = (2 mu - beta) U + <T, p_h> + <r, m> + <S p - f, m> + <rho, p - p_h>.
//!
//! For - tau' p_h <= m <= tau p_h the fourth term lies between -tau' X and tau X, and the last is at most |p - p_h| sqrt(a_m), a_m a bound
//! of a(w, w) for w = rho on A', all that is under p or p_h. X and |p - p_h|^2/2 together are at most gamma:
//!
//!   <eta, p> <= (2 mu - beta) U_low + <T, p_h> + <r, m> + max(2 mu - beta, 0) gamma + B(tau),                             (5)
//!   B(tau) = sqrt(2 gamma a_m) if tau <= sqrt(a_m/(2 gamma)), else tau gamma + a_m/(2 tau),
//!
//! and likewise from below with tau'. (The pressure m_A of a flat punch on the cells A under p_h alone gives P >= <f, m_A> (Barber 1974):
//! with tau = 0 that is (5) from below.)
//!
//! **a_m.** Let M be the solution of S M = T on all cells of A', nearly. rho = (T - S M) + S (M - m); what is in brackets changes its
//! sign within each cell, and S (M - m) is known everywhere. With w the one, continued beyond A', plus the other
//!
//!   a(w, w) <= a(v, v) + 2 <M - m, T - S M> + <M - m, S (M - m)>,   v = T - S M on A',                                   (8)
//!
//! where the second term is what the solver has left. The same M bounds the force of a flat punch on A':
//! K(A') <= 2 <1, M> - <M, S M> + a(v, v) for T = 1.
//!
//! A' follows from domination: u_h less the most by which it lies above f under p_h is nowhere more than S p
//! ([`super::residual::Residual::may_touch`]). M and m come from solves on the cells in contact ([`crate::matrix_free::growth`]); poor ones
//! widen the bounds, no more.

use super::bracket::evened;
use super::extension::Extension;
use super::faded::faded;
use super::field::{COEFFICIENTS, Field};
use super::overlap::{Interval, OverlapBounds};
use super::parts::Parts;
use super::pressed::Pressed;
use super::residual::{Halves, Quarter, Residual};
use super::virial::{Target, Virial};
use crate::discrete::Discrete;
use crate::grid::{Grid, Kernel};
use crate::matrix_free::{self, growth};
use crate::numeric::geometry::Rect;

/// How well m is solved: its residual counts by its square in a_m.
const FLAT: f64 = 1e-4;

/// The same where it was cut to tau p_h.
const CUT: f64 = 3e-3;

/// a_m over the energy of M, per share of the contact that may touch besides, for T = 1 and for what is left of it: chooses tau, where the
/// bound is flat, and proves nothing.
pub(super) const RING: [f64; 2] = [0.65, 2.0];

/// Size of T over that of eta from which on m is needed.
const LITTLE: f64 = 0.005;

/// What a few products change a bound by.
const ROUNDING: f64 = 1e-13;

/// A part of the cells of a grid, or some more around it.
#[derive(Clone, Copy)]
pub(super) struct Cut {
    /// Its first cell, in the other grid.
    first: [isize; 2],
    shape: [usize; 2],
}

impl Cut {
    /// Around the cells under pressure and others, with one more on every side; in the middle where there are mirrors.
    pub fn around(field: &Field, others: &[Quarter], halves: Halves) -> Self {
        let [nx, ny] = field.grid.shape;
        let (mut low, mut high) = ([isize::MAX; 2], [isize::MIN; 2]);
        let mut hold = |at: [isize; 2]| {
            for m in 0..2 {
                let image = if halves[m] { field.grid.shape[m] as isize - 1 - at[m] } else { at[m] };
                low[m] = low[m].min(at[m]).min(image);
                high[m] = high[m].max(at[m]).max(image);
            }
        };
        for j in 0..ny as isize {
            let row = &field.pressures(0, j)[..nx];
            let loaded = |p: &f64| *p != 0.0;
            if let (Some(from), Some(to)) = (row.iter().position(loaded), row.iter().rposition(loaded)) {
                hold([from as isize, j]);
                hold([to as isize, j]);
            }
        }
        others.iter().for_each(|(i, j, _)| hold([*i, *j]));
        let first = low.map(|n| n - 1);
        Self { first, shape: [0, 1].map(|m| (high[m] + 2 - first[m]) as usize) }
    }

    fn grid(&self, of: &Grid) -> Grid {
        let at = |m: usize| of.origin[m] + self.first[m] as f64 * of.spacing[m];
        Grid { origin: [at(0), at(1)], spacing: of.spacing, shape: self.shape }
    }

    /// Where a cell of the other grid is among its cells.
    fn place(&self, [i, j]: [isize; 2]) -> usize {
        ((j - self.first[1]) as usize) * self.shape[0] + (i - self.first[0]) as usize
    }

    /// The cells of the other grid that its cells are, one after the other.
    fn cells(self) -> impl Iterator<Item = [isize; 2]> {
        let ([nx, ny], [i, j]) = (self.shape, self.first);
        (0..nx * ny).map(move |k| [(k % nx) as isize + i, (k / nx) as isize + j])
    }
}

/// A pressure with its residual, and the part of its grid that functionals are solved on.
pub(super) struct Contact<'a> {
    pub residual: &'a Residual<'a>,
    pub parts: &'a Parts<'a>,
    pub pressed: &'a Pressed,
    /// Bounds of the means of f in the cells under pressure.
    pub means: Vec<Interval>,
    pub cut: Cut,
    /// <f, p_h> - <p_h, S p_h>/2, and by how much it may be more.
    pub below: f64,
    pub open: f64,
    pub gamma: f64,
    /// What may touch besides, and over what is under pressure.
    pub touch: &'a [Quarter],
    pub ring: f64,
}

/// M on all cells that may touch, its displacement, and a(v, v).
struct Whole {
    pressure: Vec<f64>,
    field: Field,
    energy: f64,
}

/// m, a_m, and the largest m/p_h and -m/p_h.
struct Part {
    m: Vec<f64>,
    energy: f64,
    tau: [f64; 2],
}

impl Contact<'_> {
    fn field(&self) -> &Field {
        self.residual.field
    }

    /// Bounds of <eta, p>. `above_least`: the depth above what the gap is nowhere less than; `enough`: a distance that need not be made
    /// smaller.
    pub fn bounds(&self, virial: &Virial, above_least: f64, enough: f64) -> Option<[f64; 2]> {
        let target = Target { virial, parts: self.parts };
        let alone = self.without_punch(&target);
        if alone.is_some_and(|[low, high]| high - low <= enough) {
            return alone;
        }
        let by_punch = self.with_punch(&target, above_least);
        [alone, by_punch].into_iter().flatten().reduce(|a, b| [a[0].max(b[0]), a[1].min(b[1])])
    }

    /// (5) with m from solves, and what else a flat punch tells of a force.
    fn with_punch(&self, target: &Target, above_least: f64) -> Option<[f64; 2]> {
        let virial = target.virial;
        let p: Vec<f64> = self.cut.cells().map(|[i, j]| self.field().pressure(i, j)).collect();
        let rates = self.rates(target);
        let whole = self.whole(target, &rates)?;
        let part = self.part(target, &p, &rates, &whole)?;
        let [low, high] = self.by_energy(virial, self.work(&part.m), part.energy, part.tau)?;
        if !virial.is_plain() || virial.eta != [1.0, 0.0, 0.0] {
            return Some([low, high]);
        }
        // P is convex in the depth and 0 up to the least gap.
        let by_depth = 2.0 * self.below / above_least * (1.0 - ROUNDING);
        Some([low.max(by_depth), high.min(above_least * self.stiffness(&whole) * (1.0 + ROUNDING))])
    }

    /// T in the middle of the cells that may touch, nearly; 0 in others.
    fn rates(&self, target: &Target) -> Vec<f64> {
        let rate = |cell: [isize; 2]| target.virial.nearly(&self.image_of(cell), target.parts);
        self.cut.cells().zip(self.touching()).map(|(cell, touches)| if touches { rate(cell) } else { 0.0 }).collect()
    }

    /// Which cells of the cut are or may be under pressure.
    fn touching(&self) -> Vec<bool> {
        let mut touching: Vec<bool> = self.cut.cells().map(|[i, j]| self.field().pressure(i, j) > 0.0).collect();
        let shape = self.field().grid.shape.map(|n| n as isize);
        for &(i, j, _) in self.touch {
            for image in 0..4 {
                if (0..2).all(|m| image >> m & 1 == 0 || self.residual.halves[m]) {
                    let at = |m: usize, n: isize| if image >> m & 1 == 1 { shape[m] - 1 - n } else { n };
                    touching[self.cut.place([at(0, i), at(1, j)])] = true;
                }
            }
        }
        touching
    }

    /// <r, m>, from below and from above.
    fn work(&self, m: &[f64]) -> [f64; 2] {
        let field = self.field();
        let (mut work, mut size, mut loads) = ([0.0; 2], 0.0, 0.0);
        for (m, [i, j]) in m.iter().zip(self.cut.cells()).filter(|(m, _)| **m != 0.0) {
            let f = self.means[j as usize * field.grid.shape[0] + i as usize];
            let u = field.displacements(i, j)[0] * field.scale;
            let ends = f.map(|f| m * (f - u));
            work[0] += ends[0].min(ends[1]);
            work[1] += ends[0].max(ends[1]);
            size += m.abs() * (f[0].abs().max(f[1].abs()) + u.abs());
            loads += m.abs();
        }
        let terms = f64::EPSILON * (m.len() + 8) as f64;
        let off = size * (terms + 2.0 * COEFFICIENTS) + loads * field.rounding * field.scale;
        let area = field.grid.cell_area() * (1.0 + ROUNDING);
        [area * (work[0] - off), area * (work[1] + off)]
    }

    /// S m = rates where `cells` are positive, nearly; m = 0 elsewhere.
    fn grown(&self, cells: &[f64], rates: &[f64], tolerance: f64) -> Option<Vec<f64>> {
        let grid = self.cut.grid(&self.field().grid);
        let problem = Discrete { grid, kernel: Kernel::Galerkin, overlap: vec![1.0; grid.len()] };
        let settings = matrix_free::Settings { tolerance, ..matrix_free::Settings::default() };
        let grown = growth(&problem, cells, rates, &settings).ok()?;
        Some(evened(&grown, grid.shape, self.residual.halves))
    }

    fn field_of(&self, pressure: &[f64]) -> Option<Field> {
        let field = Field::new(&self.cut.grid(&self.field().grid), pressure)?;
        Some(field.part_of(self.field(), self.cut.first))
    }

    fn whole(&self, target: &Target, rates: &[f64]) -> Option<Whole> {
        let touching = self.touching();
        let cells: Vec<f64> = touching.iter().map(|touches| f64::from(u8::from(*touches))).collect();
        let pressure = self.grown(&cells, rates, FLAT)?;
        let field = self.field_of(&pressure)?;
        let [nx, _] = self.cut.shape;
        let set = Extension::of_cells(self.cut.shape, |i, j| touching[j * nx + i]);
        if set.reaches_border() {
            return None;
        }
        let energy = Residual { field: &field, overlap: target, halves: self.residual.halves }.norms(&set).energy();
        energy.is_finite().then_some(Whole { pressure, field, energy })
    }

    /// m between -tau p_h and tau p_h, as close to M as may be.
    fn part(&self, target: &Target, p: &[f64], rates: &[f64], whole: &Whole) -> Option<Part> {
        let area = self.field().grid.cell_area();
        let energy = whole.pressure.iter().zip(rates).map(|(m, t)| m * t).sum::<f64>() * area;
        let loaded = p.iter().filter(|p| **p > 0.0).count() as f64;
        let tau = (RING[usize::from(!target.virial.is_plain())] * (self.ring + 1.0 / loaded.sqrt()) * energy
            / (2.0 * self.gamma))
            .sqrt();
        let cut = |m: &[f64]| -> Vec<f64> { m.iter().zip(p).map(|(m, p)| m.clamp(-tau * p, tau * p)).collect() };
        let mut m = cut(&whole.pressure);
        // What was cut off is made good by the cells that are not.
        let kept: Vec<f64> = m.iter().zip(p).map(|(m, p)| f64::from(u8::from(m.abs() < tau * p))).collect();
        let field = self.field_of(&m)?;
        let left: Vec<f64> = rates.iter().zip(displacements(&field)).map(|(t, u)| t - u).collect();
        let more = self.grown(&kept, &left, CUT)?;
        m = cut(&m.iter().zip(&more).map(|(m, more)| m + more).collect::<Vec<f64>>());
        // (8).
        let rest: Vec<f64> = whole.pressure.iter().zip(&m).map(|(all, m)| all - m).collect();
        let field = self.field_of(&rest)?;
        let (mut sum, mut size, mut loads) = (0.0, 0.0, 0.0);
        let cells = rest.iter().zip(self.cut.cells()).zip(displacements(&field).zip(displacements(&whole.field)));
        for ((q, cell), (own, all)) in cells.filter(|((q, _), _)| **q != 0.0) {
            let [low, high] = target.mean(&self.image_of(cell)).map(|t| q * (t - all));
            let left = low.max(high);
            sum += 2.0 * left + q * own;
            size += 2.0 * left.abs() + q.abs() * (own.abs() + all.abs());
            loads += q.abs();
        }
        let [own, all] = [&field, &whole.field].map(|field| field.rounding * field.scale);
        let off = size * (f64::EPSILON * (rest.len() + 8) as f64 + 2.0 * COEFFICIENTS) + loads * (own + 2.0 * all);
        let energy = whole.energy + area * (sum + off).max(0.0) * (1.0 + ROUNDING);
        let largest = |sign: f64| {
            let shares = m.iter().zip(p).filter(|(_, p)| **p > 0.0).map(|(m, p)| sign * m / p);
            shares.fold(0.0, f64::max) * (1.0 + ROUNDING)
        };
        let tau = [largest(1.0), largest(-1.0)];
        energy.is_finite().then_some(Part { m, energy, tau })
    }

    /// The rectangle of a cell, or of its image that was looked at.
    fn image_of(&self, cell: [isize; 2]) -> Rect {
        let at = |m: usize| {
            let (n, count) = (cell[m], self.field().grid.shape[m] as isize);
            if self.residual.halves[m] { n.max(count - 1 - n) } else { n }
        };
        self.residual.rect(at(0), at(1))
    }

    /// (5) with m = 0, where T is small enough for that.
    fn without_punch(&self, target: &Target) -> Option<[f64; 2]> {
        if target.virial.is_plain() || target.virial.left > LITTLE {
            return None;
        }
        self.by_energy(target.virial, [0.0; 2], faded(self.residual, target, self.touch)?, [0.0; 2])
    }

    /// (5), from both sides; `work`: bounds of <r, m>.
    fn by_energy(&self, virial: &Virial, work: [f64; 2], a_m: f64, tau: [f64; 2]) -> Option<[f64; 2]> {
        let gamma = self.gamma;
        let missed = |tau: f64| {
            let best = (a_m / (2.0 * gamma)).sqrt();
            if tau <= best { (2.0 * gamma * a_m).sqrt() } else { tau * gamma + a_m / (2.0 * tau) }
        };
        let own = virial.work(self.pressed, self.parts)?;
        let per = virial.per_energy();
        let ends = [self.below, self.below + self.open].map(|u| per * u);
        let low = ends[0].min(ends[1]) + work[0] + own[0] + per.min(0.0) * gamma - missed(tau[1]);
        let high = ends[0].max(ends[1]) + work[1] + own[1] + per.max(0.0) * gamma + missed(tau[0]);
        let sizes = [ends[0], ends[1], work[0], work[1], own[0], own[1], missed(tau[0]), missed(tau[1])];
        let rounding = ROUNDING * sizes.iter().map(|v| v.abs()).sum::<f64>();
        Some([low - rounding, high + rounding])
    }

    /// K(A') <= 2 <1, M> - <M, S M> + a(v, v), the stiffness of a flat punch on all that may be under pressure.
    fn stiffness(&self, Whole { pressure, field, energy }: &Whole) -> f64 {
        let (mut punch, mut size, mut loads) = (0.0, 0.0, 0.0);
        for (m, u) in pressure.iter().zip(displacements(field)).filter(|(m, _)| **m != 0.0) {
            punch += m * (2.0 - u);
            size += m.abs() * (2.0 + u.abs());
            loads += m.abs();
        }
        let terms = f64::EPSILON * (pressure.len() + 8) as f64;
        let off = size * (terms + 2.0 * COEFFICIENTS) + loads * field.rounding * field.scale;
        self.field().grid.cell_area() * (punch + off) * (1.0 + ROUNDING) + energy
    }
}

/// Means of the displacement in all cells.
fn displacements(field: &Field) -> impl Iterator<Item = f64> + '_ {
    let [nx, ny] = field.grid.shape;
    (0..nx * ny).map(move |k| field.displacements((k % nx) as isize, (k / nx) as isize)[0] * field.scale)
}

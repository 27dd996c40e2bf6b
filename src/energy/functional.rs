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
//! and likewise from below with tau'. For eta = 1 and T = 1 the pressure of the flat punch on the cells A under pressure is a bound by
//! itself: P >= <f, m_A> (Barber 1974), S m_A = 1 on A, so that with <u_h, m_A> = P_h and m_A - m = S^-1 (1 - S m) on A
//!
//!   P >= P_h + <r, m> - sqrt(a_r a_m),   w = r and w = 1 - S m on A.                                                     (4)
//!
//! A' follows from domination: u_h less the most by which it lies above f under p_h is nowhere more than S p
//! ([`super::residual::Residual::may_touch`]). m comes from a solve on the cells in contact ([`crate::matrix_free::growth`]); a poor one
//! widens the bounds, no more.

use super::bracket::evened;
use super::extension::Extension;
use super::faded::faded;
use super::field::{COEFFICIENTS, Field};
use super::overlap::Interval;
use super::residual::{Halves, Quarter, Residual, loaded};
use super::virial::{Target, Virial};
use crate::discrete::Discrete;
use crate::grid::{Grid, Kernel};
use crate::matrix_free::{self, growth};

/// How well m is solved: its residual counts by its square in a_m.
const FLAT: f64 = 1e-4;

/// The same where it was cut to tau p_h.
const CUT: f64 = 3e-3;

/// a_m over the energy of m, per share of the contact that may touch besides: chooses tau, where the bound is flat, and proves nothing.
pub(super) const RING: f64 = 2.5;

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

    /// The cells of the other grid that its cells are, one after the other.
    fn cells(self) -> impl Iterator<Item = [isize; 2]> {
        let ([nx, ny], [i, j]) = (self.shape, self.first);
        (0..nx * ny).map(move |k| [(k % nx) as isize + i, (k / nx) as isize + j])
    }
}

/// A pressure with its residual, and the part of its grid that functionals are solved on.
pub(super) struct Contact<'a> {
    pub residual: &'a Residual<'a>,
    /// Bounds of the means of f in the cells under pressure.
    pub means: Vec<Interval>,
    pub cut: Cut,
    /// a(w, w) with w = r under pressure.
    pub of_residual: f64,
    /// <f, p_h> - <p_h, S p_h>/2, and by how much it may be more.
    pub below: f64,
    pub open: f64,
    pub gamma: f64,
    /// What may touch besides, and over what is under pressure.
    pub touch: &'a [Quarter],
    pub ring: f64,
}

/// m, its displacement, and a_m.
struct Punch {
    m: Vec<f64>,
    field: Field,
    energy: f64,
    /// Largest m/p_h and -m/p_h.
    tau: [f64; 2],
}

impl Contact<'_> {
    fn field(&self) -> &Field {
        self.residual.field
    }

    /// Bounds of <eta, p>; of a force, with (4) and the flat punch, where T = 1. `above_least`: the depth above what the gap is nowhere
    /// less than; `enough`: a distance that need not be made smaller.
    pub fn bounds(&self, virial: &Virial, above_least: f64, enough: f64) -> Option<[f64; 2]> {
        let target = Target { virial, overlap: self.residual.overlap };
        let alone = self.without_punch(&target, enough);
        if alone.is_some_and(|[low, high]| high - low <= enough) {
            return alone;
        }
        let whole = self.solved(&target)?;
        let punch = self.punch(&target, &whole)?;
        let Punch { m, energy, tau, .. } = &punch;
        let [low, high] = self.by_energy(virial, self.work(m), *energy, *tau)?;
        if !virial.is_plain() || virial.eta != [1.0, 0.0, 0.0] {
            return Some([low, high]);
        }
        let by_punch = self.by_flat_punch(&target, &whole)?;
        // P is convex in the depth and 0 up to the least gap.
        let by_depth = 2.0 * self.below / above_least * (1.0 - ROUNDING);
        Some([low.max(by_punch).max(by_depth), high.min(above_least * self.stiffness(&punch) * (1.0 + ROUNDING))])
    }

    /// Pressures on the cells of the cut.
    fn pressure(&self) -> Vec<f64> {
        self.cut.cells().map(|[i, j]| self.field().pressure(i, j)).collect()
    }

    /// S m = T on the cells under pressure, nearly.
    fn solved(&self, target: &Target) -> Option<Vec<f64>> {
        let pressure = self.pressure();
        let rates: Vec<f64> = self.rates(target, &pressure);
        self.grown(&pressure, &rates, FLAT)
    }

    /// T in the middle of the cells under pressure, nearly.
    fn rates(&self, target: &Target, pressure: &[f64]) -> Vec<f64> {
        let [nx, ny] = self.field().grid.shape.map(|n| n as isize);
        // Where there are mirrors that of the image which was looked at already.
        let worked_out =
            |n: isize, m: usize, shape: isize| if self.residual.halves[m] { n.max(shape - 1 - n) } else { n };
        let rect = |[i, j]: [isize; 2]| self.residual.rect(worked_out(i, 0, nx), worked_out(j, 1, ny));
        let cells = self.cut.cells().zip(pressure);
        cells.map(|(cell, p)| if *p > 0.0 { target.virial.nearly(&rect(cell), target.overlap) } else { 0.0 }).collect()
    }

    /// <r, m>, from below and from above.
    fn work(&self, m: &[f64]) -> [f64; 2] {
        let field = self.field();
        let (mut work, mut size, mut loads) = ([0.0; 2], 0.0, 0.0);
        for (m, [i, j]) in m.iter().zip(self.cut.cells()).filter(|(m, _)| **m != 0.0) {
            if field.pressure(i, j) == 0.0 {
                continue;
            }
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

    /// The displacement by m, and a bound of a(w, w) for w = T - S m on the cells under pressure and on quarters besides.
    fn missed(&self, target: &Target, m: &[f64], besides: &[Quarter]) -> Option<(Field, f64)> {
        let grid = self.cut.grid(&self.field().grid);
        let field = Field::new(&grid, m)?;
        let (halves, first) = (self.residual.halves, self.cut.first);
        let loaded = |i: usize, j: usize| self.field().pressure(i as isize + first[0], j as isize + first[1]) > 0.0;
        let mut set = Extension::of_cells(self.cut.shape, loaded);
        besides.iter().for_each(|(i, j, q)| set.cover(i - first[0], j - first[1], *q, halves));
        if set.reaches_border() {
            return None;
        }
        let energy = Residual { field: &field, overlap: target, halves }.norms(&set).energy();
        energy.is_finite().then_some((field, energy))
    }

    /// m between -tau p_h and tau p_h, made from the solution of S m = T.
    fn punch(&self, target: &Target, whole: &[f64]) -> Option<Punch> {
        let p = self.pressure();
        let rates = self.rates(target, &p);
        let area = self.field().grid.cell_area();
        let energy = whole.iter().zip(&rates).map(|(m, t)| m * t).sum::<f64>() * area;
        let loaded = p.iter().filter(|p| **p > 0.0).count() as f64;
        let tau = (RING * (self.ring + 1.0 / loaded.sqrt()) * energy / (2.0 * self.gamma)).sqrt();
        let cut = |m: &[f64]| -> Vec<f64> { m.iter().zip(&p).map(|(m, p)| m.clamp(-tau * p, tau * p)).collect() };
        let mut m = cut(whole);
        // What was cut off is made good by the cells that are not.
        let kept: Vec<f64> =
            whole.iter().zip(&p).map(|(m, p)| if *p > 0.0 && m.abs() < tau * p { 1.0 } else { 0.0 }).collect();
        if kept.iter().zip(&p).any(|(kept, p)| *kept == 0.0 && *p > 0.0) {
            let field = Field::new(&self.cut.grid(&self.field().grid), &m)?;
            let [nx, _] = self.cut.shape;
            let u = |k: usize| field.displacements((k % nx) as isize, (k / nx) as isize)[0] * field.scale;
            let left: Vec<f64> = rates.iter().enumerate().map(|(k, t)| t - u(k)).collect();
            let more = self.grown(&kept, &left, CUT)?;
            m = cut(&m.iter().zip(&more).map(|(m, more)| m + more).collect::<Vec<f64>>());
        }
        let (field, energy) = self.missed(target, &m, self.touch)?;
        let largest = |sign: f64| {
            let shares = m.iter().zip(&p).filter(|(_, p)| **p > 0.0).map(|(m, p)| sign * m / p);
            shares.fold(0.0, f64::max) * (1.0 + ROUNDING)
        };
        let tau = [largest(1.0), largest(-1.0)];
        Some(Punch { m, field, energy, tau })
    }

    /// (5) with m = 0, where T is small enough for that.
    fn without_punch(&self, target: &Target, enough: f64) -> Option<[f64; 2]> {
        let size = target.virial.left * target.virial.eta_on(self.residual);
        if target.virial.is_plain() || 2.0 * size * (2.0 * self.gamma * self.disc()).sqrt() > enough {
            return None;
        }
        self.by_energy(target.virial, [0.0; 2], faded(self.residual, target, self.touch)?, [0.0; 2])
    }

    /// Force of a flat punch of the area under pressure, nearly.
    pub fn disc(&self) -> f64 {
        2.0 * (loaded(self.residual).map(|(i, j, _)| self.residual.images(i, j)).sum::<f64>()
            * self.field().grid.cell_area()
            / std::f64::consts::PI)
            .sqrt()
    }

    /// (5), from both sides; `work`: bounds of <r, m>.
    fn by_energy(&self, virial: &Virial, work: [f64; 2], a_m: f64, tau: [f64; 2]) -> Option<[f64; 2]> {
        let gamma = self.gamma;
        let missed = |tau: f64| {
            let best = (a_m / (2.0 * gamma)).sqrt();
            if tau <= best { (2.0 * gamma * a_m).sqrt() } else { tau * gamma + a_m / (2.0 * tau) }
        };
        let own = virial.work(self.residual)?;
        let per = virial.per_energy();
        let ends = [self.below, self.below + self.open].map(|u| per * u);
        let low = ends[0].min(ends[1]) + work[0] + own[0] + per.min(0.0) * gamma - missed(tau[1]);
        let high = ends[0].max(ends[1]) + work[1] + own[1] + per.max(0.0) * gamma + missed(tau[0]);
        let sizes = [ends[0], ends[1], work[0], work[1], own[0], own[1], missed(tau[0]), missed(tau[1])];
        let rounding = ROUNDING * sizes.iter().map(|v| v.abs()).sum::<f64>();
        Some([low - rounding, high + rounding])
    }

    /// (4).
    fn by_flat_punch(&self, target: &Target, whole: &[f64]) -> Option<f64> {
        let (_, of_flat) = self.missed(target, whole, &[])?;
        let force = target.virial.work(self.residual)?[0] + self.work(whole)[0];
        Some(force * (1.0 - ROUNDING) - (self.of_residual * of_flat).sqrt() * (1.0 + ROUNDING))
    }

    /// K(A') <= 2 <1, m> - <m, S m> + a(w, w), the stiffness of a flat punch on all that may be under pressure.
    fn stiffness(&self, Punch { m, field, energy, .. }: &Punch) -> f64 {
        let [nx, _] = self.cut.shape;
        let (mut punch, mut size) = (0.0, 0.0);
        for (k, m) in m.iter().enumerate().filter(|(_, m)| **m != 0.0) {
            let u = field.displacements((k % nx) as isize, (k / nx) as isize)[0] * field.scale;
            punch += m * (2.0 - u);
            size += m.abs() * (2.0 + u.abs() + field.rounding * field.scale);
        }
        let off = size * (f64::EPSILON * (m.len() + 8) as f64 + 2.0 * COEFFICIENTS)
            + m.iter().map(|m| m.abs()).sum::<f64>() * field.rounding * field.scale;
        self.field().grid.cell_area() * (punch + off) * (1.0 + ROUNDING) + energy
    }
}

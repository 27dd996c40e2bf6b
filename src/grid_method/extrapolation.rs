//! The limit of values computed on ever finer grids, and how far off it may be.

use nalgebra::DMatrix;

/// A value and an estimate (not a bound) of its error, absolute.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// Estimate of its error.
    pub error: f64,
}

/// How fast the energies of a contact converge, by what its patch ends in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Ends {
    /// Sharp edges of the material: steps fall by 2 from grid to grid.
    Edges,
    /// Corners, where planes meet: by 4.1.
    Corners,
    /// A tip r^k, k < 1: a share (1/N)^(1 + k) of the load is on the cell of the tip, over which the gap varies by (1/N)^k. By 2^(1 + 2 k),
    /// once that is what is left.
    Tip(f64),
    /// Not known. Smooth and conical contacts: by 7.2.
    Unknown,
}

/// Share of the last step that is left of an energy, and half the range of that share.
///
/// `examples/estimate_factors.rs` draws contacts along and against the grid, of aspects to 200 and exponents to 8, regular and irregular
/// pyramids, on grids of which the coarsest has 10 to 18 cells, and prints what is left; these are what it prints, with room. On two
/// coarse grids steps still vary with how the cells lie.
#[derive(Clone, Copy)]
struct Left {
    share: f64,
    spread: f64,
}

/// First order: as much as the last step is left on two grids; on more, as a geometric series has it, times these.
const AT_EDGES: [Left; 2] = [Left { share: 1.0, spread: 0.5 }, Left { share: 1.0, spread: 0.15 }];

/// Second order, on two, on three and on more grids.
const AT_CORNERS: [Left; 3] =
    [Left { share: 0.37, spread: 0.22 }, Left { share: 0.315, spread: 0.14 }, Left { share: 0.315, spread: 0.12 }];

/// Steps at corners that fall by less than this may have any share to go: more for each unit that is missing.
const SLOW_AT_CORNERS: [f64; 2] = [3.0, 0.06];

/// A step at corners that is smaller than the one before by more than this is so by chance: more is left for each unit.
const SMALL_AT_CORNERS: [f64; 2] = [4.5, 0.09];

/// Third order or not known: on two grids; on more, where all of what a step adds may be missing; and once steps fall alike.
const ELSEWHERE: [Left; 3] =
    [Left { share: 0.22, spread: 0.17 }, Left { share: 0.21, spread: 0.21 }, Left { share: 0.17, spread: 0.07 }];

/// At tips, what is left of a geometric series of the theory may be more or less by this share of it: 0.977 to 1 of it on three grids.
const AT_TIPS: f64 = 0.1;

/// Steps that fall by no more than this times what they do at a tip are those of the tip.
const OF_TIP: f64 = 1.2;

/// By what steps fall on smooth contacts.
const SMOOTH: std::ops::Range<f64> = 5.5..11.0;

/// Share of the step before the last that is left of a force at least, however small the last one: at the order 1.5.
const AFTER_TWO: f64 = 0.2;

/// Steps that fall by less show no order.
const LEAST_RATIO: f64 = 1.5;

/// The limit of grid energies (cell means), which converge smoothly from one side, the cells doubling: a share of the last step is left.
///
/// Forces must not be extrapolated like this: the contact is a whole number of cells and the force jitters with it.
#[must_use]
pub fn of_energies(coarse_to_fine: &[f64], ends: Ends) -> Option<Estimate> {
    let last = *coarse_to_fine.last()?;
    let steps: Vec<f64> = coarse_to_fine.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let (step, before) = match *steps {
        [] => return None,
        [step] => (step, None),
        [.., before, step] => (step, Some(before)),
    };
    let ratio = before.map(|before| before / step);
    if ratio.is_some_and(|ratio| !(ratio > LEAST_RATIO)) {
        // No order to be seen: keep the last value, its error the last step.
        return Some(Estimate { value: last, error: step.abs().max(0.25 * before.unwrap_or(0.0).abs()) });
    }
    let settled = steps.len() >= 3 && steps[steps.len() - 3..].windows(2).all(|s| SMOOTH.contains(&(s[0] / s[1])));
    let Left { share, spread } = match (ends, ratio) {
        (Ends::Edges, None) => AT_EDGES[0],
        (Ends::Edges, Some(ratio)) => {
            let Left { share, spread } = AT_EDGES[1];
            Left { share: share / (ratio - 1.0), spread: spread / (ratio - 1.0) }
        }
        (Ends::Corners, None) => AT_CORNERS[0],
        (Ends::Corners, Some(ratio)) => {
            let Left { share, spread } = AT_CORNERS[if steps.len() == 2 { 1 } else { 2 }];
            let by_chance = SMALL_AT_CORNERS[1] * (ratio - SMALL_AT_CORNERS[0]).max(0.0);
            let slow = SLOW_AT_CORNERS[1] * (SLOW_AT_CORNERS[0] - ratio).max(0.0);
            Left { share: share + by_chance, spread: spread + by_chance + slow }
        }
        (Ends::Tip(degree), ratio) => at_tip(degree, ratio),
        (Ends::Unknown, None) => ELSEWHERE[0],
        (Ends::Unknown, Some(_)) => ELSEWHERE[if settled { 2 } else { 1 }],
    };
    // A step that is small by luck counts as the one before would have it.
    let size = match ends {
        Ends::Corners | Ends::Tip(_) => step.abs(),
        _ => step.abs().max(before.unwrap_or(0.0).abs() / SMOOTH.end),
    };
    Some(Estimate { value: last + share * step, error: spread * size })
}

fn at_tip(degree: f64, ratio: Option<f64>) -> Left {
    let series = |ratio: f64| Left { share: 1.0 / (ratio - 1.0), spread: AT_TIPS / (ratio - 1.0) };
    let of_tip = (1.0 + 2.0 * degree).exp2();
    if ratio.is_some_and(|ratio| ratio < (OF_TIP * of_tip).min(SMOOTH.start)) {
        return series(of_tip);
    }
    // The tip, or the end of the contact.
    let both = [series(of_tip), ELSEWHERE[usize::from(ratio.is_some())]];
    let low = both.iter().map(|left| left.share - left.spread).fold(f64::INFINITY, f64::min);
    let high = both.iter().map(|left| left.share + left.spread).fold(f64::NEG_INFINITY, f64::max);
    Left { share: 0.5 * (low + high), spread: 0.5 * (high - low) }
}

/// The last of a sequence of forces, with the error that its last steps suggest.
#[must_use]
pub fn of_forces(coarse_to_fine: &[f64]) -> Option<Estimate> {
    match *coarse_to_fine {
        [.., a, b, c] => {
            let (first, second) = ((b - a).abs(), (c - b).abs());
            // First order: what is left is as much as the last step. Faster: a third of it, but never trust one small step, nor an order that is
            // seen once.
            let before = match *coarse_to_fine {
                [.., z, a, b, _] => (a - z).abs() / (b - a).abs(),
                _ => f64::INFINITY,
            };
            let ratio = (first / second).min(before).clamp(2.0, 4.0);
            Some(Estimate { value: c, error: (second / (ratio - 1.0)).max(AFTER_TWO * first) })
        }
        [a, b] => Some(Estimate { value: b, error: (b - a).abs() }),
        _ => None,
    }
}

/// What is left of forces that are known to converge with the first power of the cells, as at sharp edges: as much as the last
/// step, or half the one before. A step that is smaller than that is so by where the edges fall between the cells.
#[must_use]
pub fn left_by_first_order(coarse_to_fine: &[f64]) -> f64 {
    let steps = coarse_to_fine.windows(2).rev().map(|pair| (pair[1] - pair[0]).abs());
    steps.take(2).zip([1.0, 0.5]).map(|(step, share)| share * step).fold(0.0, f64::max)
}

/// v0 + c h + l A through values on many grids of spacing h that leave out an area A of what they should cover, at h = A = 0:
/// for errors of first order that jump with where the edges of a punch fall between cells. Where the values bend, with b h ln h: a narrow
/// contact along an edge has such a term.
#[derive(Debug, Clone, PartialEq)]
pub struct Intercept {
    /// (spacing, area left out) of each grid.
    grids: Vec<[f64; 2]>,
    /// By all grids, and by the finer half alone.
    all: Fit<3>,
    finer: Fit<3>,
    bent: Fit<4>,
}

/// A fit by least squares of the first N of v0, c, l, b, deviations in proportion to the spacing.
#[derive(Debug, Clone, PartialEq)]
struct Fit<const N: usize> {
    /// Takes values over their spacings to these.
    solver: DMatrix<f64>,
    rank: usize,
}

/// Singular values below this share of the largest are none: the area left out may follow the spacing, or be zero.
const SINGULAR: f64 = 1e-7;

/// What v0, c, l and b are multiplied by, the spacing in units of `unit`.
fn columns([h, lost]: [f64; 2], unit: f64) -> [f64; 4] {
    [1.0, h, lost, h * (h / unit).ln()]
}

/// The mean spacing of grids.
fn mean_spacing(grids: &[[f64; 2]]) -> f64 {
    grids.iter().map(|g| g[0]).sum::<f64>() / grids.len() as f64
}

impl<const N: usize> Fit<N> {
    fn new(grids: &[[f64; 2]]) -> Option<Self> {
        let mean = mean_spacing(grids);
        let rows: Vec<[f64; 4]> = grids.iter().map(|g| columns(*g, mean)).collect();
        // In units of their means, so that the columns are of one size.
        let unit: [f64; N] =
            std::array::from_fn(|n| rows.iter().map(|row| row[n].abs()).sum::<f64>() / rows.len() as f64);
        let unit = unit.map(|u| if u > 0.0 { u } else { 1.0 });
        let matrix = DMatrix::from_fn(grids.len(), N, |k, n| rows[k][n] / unit[n] * mean / grids[k][0]);
        let svd = matrix.svd(true, true);
        let cut = SINGULAR * svd.singular_values.max();
        let rank = svd.rank(cut);
        let mut solver = svd.pseudo_inverse(cut).ok()? * mean;
        for (n, unit) in unit.into_iter().enumerate() {
            solver.row_mut(n).unscale_mut(unit);
        }
        Some(Self { solver, rank })
    }

    fn of(&self, grids: &[[f64; 2]], values: &[f64]) -> [f64; N] {
        let scaled =
            |n: usize| grids.iter().zip(values).enumerate().map(|(k, (g, v))| self.solver[(n, k)] * v / g[0]).sum();
        std::array::from_fn(scaled)
    }

    /// v0, the standard deviation of it, and the sum of the squares of what the fit leaves.
    fn intercept(&self, grids: &[[f64; 2]], values: &[f64]) -> (f64, f64, f64) {
        let (found, mean) = (self.of(grids, values), mean_spacing(grids));
        let fitted = |g: [f64; 2]| found.iter().zip(columns(g, mean)).map(|(c, column)| c * column).sum::<f64>();
        // Jumps grow with the cells.
        let squares = grids.iter().zip(values).map(|(g, v)| ((v - fitted(*g)) / g[0]).powi(2)).sum::<f64>();
        let variance = squares / (values.len() - self.rank) as f64;
        (found[0], (variance * self.solver.row(0).norm_squared()).sqrt(), squares)
    }
}

/// By how many standard deviations b has to differ from 0 to be one, with so many degrees of freedom: Student's quantile of 99.5 % is 2.9 with
/// 17 of them, 5.8 with 3.
fn shown_by(freedoms: f64) -> f64 {
    2.4 + 10.0 / freedoms
}

/// Share of what a bend changes the limit by that its form leaves open: h^1.5 in place of h ln h would be 0.4 to 0.5 of it off.
const OF_BEND: f64 = 0.75;

/// What is left over what the finer half shows of a bend h ln h: 1.17 is seen on 87 rollers with sharp ends.
const OF_FINER: f64 = 1.4;

/// What is left of a line over what jumps and bends together show of it: without it one of 27 states of practitioners' scenes with sharp edges was
/// off in one of force, energy, stiffness and area, by up to 1.5 times.
const OF_LINE: f64 = 1.4;

impl Intercept {
    /// Values that it takes.
    pub const LEAST: usize = 7;

    /// For values on grids with these (spacing, area left out), the spacing falling. `None` when they are fewer than
    /// [`Self::LEAST`].
    #[must_use]
    pub fn new(grids: &[[f64; 2]]) -> Option<Self> {
        if grids.len() < Self::LEAST {
            return None;
        }
        let finer = &grids[Self::coarser(grids.len())..];
        Some(Self { grids: grids.to_vec(), all: Fit::new(grids)?, finer: Fit::new(finer)?, bent: Fit::new(grids)? })
    }

    /// Grids that the finer half does without; four are left, to tell three unknowns.
    fn coarser(grids: usize) -> usize {
        (grids / 2).min(grids - 4)
    }

    /// The limit of the values. Its error: `OF_LINE` times one and a half of what Student's distribution allows in 99.5 % of cases, or what
    /// the finer half alone would change, whichever is more. Where nothing is left out there are no jumps, only a bend: it
    /// falls with the spacing, and the finer half shows as much of it as its spacings are finer.
    #[must_use]
    pub fn of(&self, values: &[f64]) -> Estimate {
        // Student's quantile is 5.6 with 4 degrees of freedom, 3.6 with 10; half as much again, for jumps are not normal.
        let times = |freedoms: f64| 4.2 + 16.0 / freedoms;
        let freedoms = |rank: usize| (values.len() - rank) as f64;
        let (v0, deviation, squares) = self.all.intercept(&self.grids, values);
        if self.all.rank == 3 {
            let (bent, deviation, left) = self.bent.intercept(&self.grids, values);
            let own = freedoms(self.bent.rank);
            if self.bent.rank == 4 && squares - left > shown_by(own).powi(2) * left / own {
                let error = OF_LINE * (times(own) * deviation).max(OF_BEND * (bent - v0).abs());
                return Estimate { value: bent, error };
            }
        }
        let coarser = Self::coarser(values.len());
        let finer = self.finer.of(&self.grids[coarser..], &values[coarser..])[0];
        let shown = if self.all.rank < 3 {
            (1.0 - mean_spacing(&self.grids[coarser..]) / mean_spacing(&self.grids)) / OF_FINER
        } else {
            1.0
        };
        let error = OF_LINE * (times(freedoms(self.all.rank)) * deviation).max((finer - v0).abs() / shown);
        Estimate { value: v0, error }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clean_powers_lie_within_the_error() {
        for (order, ends) in [(1.0, Ends::Edges), (2.0, Ends::Corners), (2.0, Ends::Unknown), (2.85, Ends::Unknown)] {
            let sequence: Vec<f64> = (0..6).map(|n| 7.0 - 0.3 * (-order * f64::from(n)).exp2()).collect();
            for grids in 2..=6 {
                let limit = of_energies(&sequence[..grids], ends).unwrap();
                assert!((limit.value - 7.0).abs() <= limit.error, "order {order}, {grids} grids: {limit:?}");
                // Nor more modest than the last step is long.
                let step = sequence[grids - 1] - sequence[grids - 2];
                assert!(limit.error <= 0.5 * step, "order {order}, {grids} grids: {limit:?}");
            }
        }
        let edges: Vec<f64> = (0..3).map(|n| 7.0 - 0.3 / f64::from(1 << n)).collect();
        assert!((of_energies(&edges, Ends::Edges).unwrap().value - 7.0).abs() < 1e-13);
    }

    #[test]
    fn noise_is_not_extrapolated() {
        let limit = of_energies(&[1.0, 1.1, 1.05], Ends::Unknown).unwrap();
        assert_eq!(limit.value, 1.05);
        assert!(limit.error >= 0.05);
    }

    #[test]
    fn a_line_is_met_exactly_and_jumps_about_it_are_told() {
        let spacing = |k: i32| 0.03 * 0.84f64.powi(k);
        let value = |[h, lost]: &[f64; 2]| 2.0 - 3.0 * h - 1.5 * lost;
        // Nothing left out; an area in proportion to the spacing; one that jumps.
        let areas: [fn(i32, f64) -> f64; 3] = [|_, _| 0.0, |_, h| 4.0 * h, |k, h| h * (2.0 + f64::from(k * k % 7))];
        for area in areas {
            let grids: Vec<[f64; 2]> = (0..12).map(|k| [spacing(k), area(k, spacing(k))]).collect();
            let line = Intercept::new(&grids).unwrap();
            let straight = line.of(&grids.iter().map(value).collect::<Vec<_>>());
            assert!((straight.value - 2.0).abs() < 1e-12 && straight.error < 1e-11, "{straight:?}");
            // Jumps of a third of the step, of either sign; a bend.
            for turn in 0..20 {
                let jump = |k: usize| (7.3 * k as f64 + 0.9 * f64::from(turn)).sin();
                let bent = |(k, g): (usize, &[f64; 2])| value(g) + g[0] * jump(k) + 5.0 * g[0] * g[0];
                let estimate = line.of(&grids.iter().enumerate().map(bent).collect::<Vec<_>>());
                assert!((estimate.value - 2.0).abs() < estimate.error && estimate.error < 0.06, "{estimate:?}");
            }
            assert!(Intercept::new(&grids[..6]).is_none());
        }
    }

    #[test]
    fn a_bend_is_told() {
        // As dished punches have it on 32 to 1025 cells, with jumps of a tenth of what is left out.
        let grids: Vec<[f64; 2]> = (0..21)
            .map(|k| {
                let h = 0.0625 * (-0.25 * f64::from(k)).exp2();
                [h, h * (4.0 + 0.3 * f64::from(k * k % 7))]
            })
            .collect();
        let line = Intercept::new(&grids).unwrap();
        for (bend, power) in [(0.5, 1.0), (-0.5, 1.0), (2.0, 1.5), (-2.0, 1.5)] {
            for turn in 0..20 {
                let jump = |k: usize| 0.05 * (7.3 * k as f64 + 0.9 * f64::from(turn)).sin();
                let term = |h: f64| if power == 1.0 { bend * h * h.ln() } else { bend * h.powf(power) };
                let value = |(k, [h, lost]): (usize, &[f64; 2])| 2.0 - 3.0 * h - 0.3 * lost + term(*h) + h * jump(k);
                let estimate = line.of(&grids.iter().enumerate().map(value).collect::<Vec<_>>());
                let off = (estimate.value - 2.0).abs();
                assert!(off < estimate.error && estimate.error < 0.01, "{bend} h^{power}, turn {turn}: {estimate:?}");
            }
        }
    }
}

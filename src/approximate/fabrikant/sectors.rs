//! Quadrature over the angle: where the rays lie, and the error that their sums leave.
//!
//! A gap that is smooth all round gets equally spaced rays (the trapezoid rule converges faster than any power for
//! periodic functions). A gap with ridges gets Gauss-Kronrod rules on the sectors between them, halved where needed.

use std::f64::consts::TAU;

/// One ray of the rule: its angle, its weight, and its weight in the coarser rule nested in it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct QuadratureNode {
    pub angle: f64,
    pub fine: f64,
    pub coarse: f64,
}

/// Widest sector that starts as one panel, for stationary boundaries. That of a three-faced punch all but has a kink in
/// the middle of each face: halves of its sectors reach 1e-6 at once.
pub(crate) const SIXTH: f64 = TAU / 6.0 * (1.0 + 1e-9);
/// The same for boundaries without such kinks (ellipses).
pub(crate) const THIRD: f64 = TAU / 3.0 * (1.0 + 1e-9);

/// Equally spaced rays beyond which the gap is taken to have ridges that it does not name.
const MOST_EQUAL: usize = 128;

/// Panels whose error is so many times what is allowed are quartered at once.
const MUCH: f64 = 1e3;

/// Sectors beyond which each is so narrow that seven rays do the work of fifteen.
const MANY: usize = 48;

#[derive(Debug, Clone)]
enum Layout {
    /// Equally spaced rays.
    Equal(usize),
    /// Parts of sectors: (sector, from, to) as fractions of the sector.
    Panels(Vec<(usize, f64, f64)>),
}

/// The rule over [0, 2 pi).
#[derive(Debug, Clone)]
pub(crate) struct Sectors {
    /// The rule of a panel.
    rule: &'static [[f64; 3]],
    ends: Vec<f64>,
    widest: f64,
    /// What is integrated repeats itself so many times in a whole turn: the rays of one period serve for all.
    turns: usize,
    layout: Layout,
}

impl Sectors {
    /// Sectors between these directions (any order, any turn), none wider than `widest` at the start.
    pub fn between(directions: &[f64], widest: f64) -> Self {
        Self::repeated(directions, widest, 1)
    }

    /// The same for what repeats itself `turns` times in a whole turn.
    pub fn repeated(directions: &[f64], widest: f64, turns: usize) -> Self {
        let ends = sector_ends(directions, widest, TAU / turns as f64);
        let layout = match ends.len() {
            0 => Layout::Equal((16 / turns).max(2)),
            n => Layout::Panels((0..n).map(|k| (k, 0.0, 1.0)).collect()),
        };
        Self { rule: if turns * ends.len() > MANY { &SEVEN } else { &FIFTEEN }, ends, widest, turns, layout }
    }

    /// The angle after which the rays repeat themselves.
    pub fn period(&self) -> f64 {
        TAU / self.turns as f64
    }

    /// How many times they do in a whole turn.
    pub fn turns(&self) -> usize {
        self.turns
    }

    /// Equally spaced rays whatever the gap: cheap, for a first look.
    pub fn equal(rays: usize) -> Self {
        Self { rule: &FIFTEEN, ends: Vec::new(), widest: SIXTH, turns: 1, layout: Layout::Equal(rays) }
    }

    /// The same panels when the ridges have moved a little; as fine as before at every angle when their number has changed.
    pub fn move_to(&mut self, directions: &[f64]) {
        let mut fresh = Self::repeated(directions, self.widest, self.turns);
        if directions.is_empty() {
            return;
        }
        if fresh.ends.len() == self.ends.len() {
            self.ends = fresh.ends;
            return;
        }
        if !self.ends.is_empty() {
            fresh.narrow_as(self);
        }
        *self = fresh;
    }

    /// Halves panels until none is wider than that of `other` around its middle.
    fn narrow_as(&mut self, other: &Self) {
        let (Layout::Panels(panels), Layout::Panels(others)) = (&mut self.layout, &other.layout) else { return };
        let period = TAU / self.turns as f64;
        let span = |ends: &[f64], (k, from, to): (usize, f64, f64)| {
            let width = ends.get(k + 1).copied().unwrap_or(ends[0] + period) - ends[k];
            [ends[k] + from * width, (to - from) * width]
        };
        let others: Vec<[f64; 2]> = others.iter().map(|&panel| span(&other.ends, panel)).collect();
        let width_at = |angle: f64| {
            let turned = |from: f64| (angle - from).rem_euclid(period);
            others.iter().find(|p| turned(p[0]) <= p[1]).map_or(period, |p| p[1])
        };
        let mut open: Vec<_> = panels.drain(..).rev().collect();
        while let Some((k, from, to)) = open.pop() {
            let [start, width] = span(&self.ends, (k, from, to));
            if width > 1.5 * width_at(start + 0.5 * width) {
                let middle = 0.5 * (from + to);
                open.extend([(k, middle, to), (k, from, middle)]);
            } else {
                panels.push((k, from, to));
            }
        }
    }

    /// The rays of one period, panel by panel, into `nodes`; their weights count all periods.
    pub fn nodes(&self, nodes: &mut Vec<QuadratureNode>) {
        nodes.clear();
        let (turns, period) = (self.turns as f64, self.period());
        match &self.layout {
            Layout::Equal(n) => nodes.extend((0..*n).map(|k| {
                let fine = TAU / *n as f64;
                QuadratureNode {
                    angle: period / *n as f64 * k as f64,
                    fine,
                    coarse: if k % 2 == 0 { 2.0 * fine } else { 0.0 },
                }
            })),
            Layout::Panels(panels) => {
                for &(k, from, to) in panels {
                    let width = (self.ends.get(k + 1).copied().unwrap_or(self.ends[0] + period)) - self.ends[k];
                    let (middle, half) = (self.ends[k] + 0.5 * (from + to) * width, 0.5 * (to - from) * width);
                    nodes.extend(self.rule.iter().map(|[x, fine, coarse]| QuadratureNode {
                        angle: middle + half * x,
                        fine: turns * half * fine,
                        coarse: turns * half * coarse,
                    }));
                }
            }
        }
    }

    /// Error estimate of the sum of `values` (one a node).
    pub fn error(&self, nodes: &[QuadratureNode], values: &[f64]) -> f64 {
        match &self.layout {
            Layout::Equal(_) => difference(nodes, values).abs(),
            Layout::Panels(panels) => (0..panels.len()).map(|p| panel_error(p, self.rule.len(), nodes, values)).sum(),
        }
    }

    /// Refines where the error estimate is largest, so that it may fall to `allowed`. False when nothing can be refined
    /// within `most_rays`.
    pub fn refine(&mut self, nodes: &[QuadratureNode], values: &[f64], allowed: f64, most_rays: usize) -> bool {
        let period = self.period();
        match &mut self.layout {
            Layout::Equal(n) if 2 * *n <= MOST_EQUAL => *n *= 2,
            Layout::Equal(_) => {
                self.ends = (0..8).map(|k| period * f64::from(k) / 8.0).collect();
                self.layout = Layout::Panels((0..8).map(|k| (k, 0.0, 1.0)).collect());
            }
            Layout::Panels(panels) => {
                let (share, per_panel) = (allowed / panels.len() as f64, self.rule.len());
                let mut split = Vec::with_capacity(2 * panels.len());
                for (p, &(k, from, to)) in panels.iter().enumerate() {
                    let error = panel_error(p, per_panel, nodes, values);
                    if error > MUCH * share {
                        let at = |m: f64| from + 0.25 * m * (to - from);
                        split.extend([0.0, 1.0, 2.0, 3.0].map(|m| (k, at(m), at(m + 1.0))));
                    } else if error > share {
                        let middle = 0.5 * (from + to);
                        split.extend([(k, from, middle), (k, middle, to)]);
                    } else {
                        split.push((k, from, to));
                    }
                }
                if split.len() == panels.len() || split.len() * per_panel > most_rays.max(panels.len() * per_panel) {
                    return false;
                }
                *panels = split;
            }
        }
        true
    }
}

/// Fine less coarse sum.
fn difference(nodes: &[QuadratureNode], values: &[f64]) -> f64 {
    nodes.iter().zip(values).map(|(s, v)| (s.fine - s.coarse) * v).sum()
}

/// Error of one panel, as in QUADPACK: the difference of the two rules, sharpened where it is already small.
fn panel_error(panel: usize, per_panel: usize, nodes: &[QuadratureNode], values: &[f64]) -> f64 {
    let range = panel * per_panel..(panel + 1) * per_panel;
    let (nodes, values) = (&nodes[range.clone()], &values[range]);
    let width: f64 = nodes.iter().map(|s| s.fine).sum();
    let mean = nodes.iter().zip(values).map(|(s, v)| s.fine * v).sum::<f64>() / width;
    let spread: f64 = nodes.iter().zip(values).map(|(s, v)| s.fine * (v - mean).abs()).sum();
    let raw = difference(nodes, values).abs();
    if spread > 0.0 { spread * (200.0 * raw / spread).powf(1.5).min(1.0) } else { raw }
}

/// Sector ends in [0, period), ascending, no sector wider than `widest`; none when nothing is known.
fn sector_ends(directions: &[f64], widest: f64, period: f64) -> Vec<f64> {
    let mut ends: Vec<f64> = directions.iter().filter(|a| a.is_finite()).map(|a| a.rem_euclid(period)).collect();
    ends.sort_by(f64::total_cmp);
    ends.dedup_by(|b, a| *b - *a < 1e-10);
    while ends.len() > 1 && ends[0] + period - ends[ends.len() - 1] < 1e-10 {
        ends.pop();
    }
    let mut cut = Vec::with_capacity(ends.len());
    for (k, &from) in ends.iter().enumerate() {
        let to = ends.get(k + 1).copied().unwrap_or(ends[0] + period);
        let pieces = ((to - from) / widest).ceil().max(1.0);
        cut.extend((0..pieces as usize).map(|m| from + (to - from) * m as f64 / pieces));
    }
    cut
}

/// The 7-15 point Gauss-Kronrod rule on [-1, 1] as (node, Kronrod weight, Gauss weight), ascending (QUADPACK, dqk15).
static FIFTEEN: [[f64; 3]; 15] = mirrored([
    [0.991_455_371_120_812_6, 0.022_935_322_010_529_225, 0.0],
    [0.949_107_912_342_758_5, 0.063_092_092_629_978_55, 0.129_484_966_168_869_7],
    [0.864_864_423_359_769_1, 0.104_790_010_322_250_18, 0.0],
    [0.741_531_185_599_394_4, 0.140_653_259_715_525_92, 0.279_705_391_489_276_66],
    [0.586_087_235_467_691_1, 0.169_004_726_639_267_9, 0.0],
    [0.405_845_151_377_397_2, 0.190_350_578_064_785_4, 0.381_830_050_505_118_9],
    [0.207_784_955_007_898_47, 0.204_432_940_075_298_9, 0.0],
    [0.0, 0.209_482_141_084_727_83, 0.417_959_183_673_469_4],
]);

/// The 3-7 point rule.
static SEVEN: [[f64; 3]; 7] = mirrored([
    [0.960_491_268_708_020_3, 0.104_656_226_026_467_27, 0.0],
    [0.774_596_669_241_483_4, 0.268_488_089_868_333_44, 0.555_555_555_555_555_6],
    [0.434_243_749_346_802_56, 0.401_397_414_775_962_2, 0.0],
    [0.0, 0.450_916_538_658_474_14, 0.888_888_888_888_888_8],
]);

/// A rule on [-1, 1] from its nodes greater than zero, descending, and zero.
const fn mirrored<const HALF: usize, const ALL: usize>(half: [[f64; 3]; HALF]) -> [[f64; 3]; ALL] {
    let mut all = [[0.0; 3]; ALL];
    let mut k = 0;
    while k < HALF {
        let [x, fine, coarse] = half[k];
        all[k] = [-x, fine, coarse];
        all[ALL - 1 - k] = half[k];
        k += 1;
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rules_integrate_polynomials() {
        for (rule, fine, coarse) in [(&FIFTEEN[..], 22, 13), (&SEVEN[..], 10, 5)] {
            for power in 0..=fine {
                let exact = if power % 2 == 0 { 2.0 / f64::from(power + 1) } else { 0.0 };
                let sum = |k: usize| rule.iter().map(|node| node[k] * node[0].powi(power)).sum::<f64>();
                assert!((sum(1) - exact).abs() < 1e-15, "{power}");
                assert!(power > coarse || (sum(2) - exact).abs() < 1e-15, "{power}");
            }
        }
    }

    #[test]
    fn a_ridge_that_nobody_told_about_is_found() {
        let mut sectors = Sectors::between(&[], SIXTH);
        let (mut nodes, mut error) = (Vec::new(), 1.0);
        for _ in 0..40 {
            sectors.nodes(&mut nodes);
            let values: Vec<f64> = nodes.iter().map(|s| (s.angle - 1.0).cos().abs()).collect();
            error = sectors.error(&nodes, &values);
            if error < 1e-10 {
                let sum: f64 = nodes.iter().zip(&values).map(|(s, v)| s.fine * v).sum();
                assert!((sum - 4.0).abs() < 1e-10);
                return;
            }
            sectors.refine(&nodes, &values, 1e-10, 10_000);
        }
        panic!("error {error}");
    }

    #[test]
    fn sectors_wrap_round() {
        let ends = sector_ends(&[0.1, -0.1, 0.1 + TAU, 2.0], SIXTH, TAU);
        assert!(ends.windows(2).all(|w| w[1] > w[0] && w[1] - w[0] <= SIXTH));
        let mut nodes = Vec::new();
        Sectors::between(&[0.1, -0.1], SIXTH).nodes(&mut nodes);
        assert!((nodes.iter().map(|s| s.fine).sum::<f64>() - TAU).abs() < 1e-14);
    }
}

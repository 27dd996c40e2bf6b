//! Rules along a ray, and places on it.

use std::f64::consts::FRAC_PI_2;
use std::sync::OnceLock;

use crate::numeric::quadrature::GaussLegendre;

/// Nodes of each level, and the power with which they crowd towards t = 0.
const LEVELS: [(usize, i32); 7] = [(4, 1), (8, 1), (16, 1), (32, 4), (64, 4), (128, 4), (256, 4)];

/// One node of the rule in t on [0, pi/2].
#[derive(Clone, Copy)]
pub(crate) struct RadialNode {
    pub sin: f64,
    pub cos: f64,
    pub weight: f64,
}

/// A rule in t. The finer ones crowd towards t = 0, for gaps whose slope is infinite or jumps there.
pub(crate) struct RadialRule {
    /// Nodes on the whole of [0, pi/2].
    pub whole: Vec<RadialNode>,
    /// The same on [0, 1], crowding at 0: the first piece of a split ray.
    first: Vec<[f64; 2]>,
    /// Gauss-Legendre on [0, 1]: the other pieces.
    plain: Vec<[f64; 2]>,
}

impl RadialRule {
    /// The rule of this level, from coarse to fine; each serves as the check of the one before. `None` beyond the finest.
    pub fn level(level: usize) -> Option<&'static Self> {
        static RULES: [OnceLock<RadialRule>; LEVELS.len()] = [const { OnceLock::new() }; LEVELS.len()];
        let &(nodes, crowding) = LEVELS.get(level)?;
        Some(RULES[level].get_or_init(|| Self::new(nodes, crowding)))
    }

    /// The finest rule.
    pub fn finest() -> &'static Self {
        Self::level(LEVELS.len() - 1).expect("there are levels")
    }

    /// Whether there is a finer rule than this level that leaves another one to check it by.
    pub fn can_refine(level: usize) -> bool {
        level + 2 < LEVELS.len()
    }

    fn new(nodes: usize, crowding: i32) -> Self {
        let rule = GaussLegendre::new(nodes);
        let plain: Vec<[f64; 2]> = rule.nodes().iter().map(|(x, w)| [0.5 * (1.0 + x), 0.5 * w]).collect();
        let first: Vec<[f64; 2]> =
            plain.iter().map(|&[x, w]| [x.powi(crowding), w * f64::from(crowding) * x.powi(crowding - 1)]).collect();
        let whole = first
            .iter()
            .map(|&[x, w]| {
                let (sin, cos) = (FRAC_PI_2 * x).sin_cos();
                RadialNode { sin, cos, weight: FRAC_PI_2 * w }
            })
            .collect();
        Self { whole, first, plain }
    }

    /// Calls `visit` at every node of [0, pi/2] split where sin t is one of `kinks`/a (ascending).
    pub fn visit(&self, kinks: &[f64], a: f64, mut visit: impl FnMut(RadialNode)) {
        let position = RadialPosition::at(kinks, a);
        self.visit_pieces(kinks, &position, |_, node| visit(node));
    }

    /// Calls `visit` with the piece (the number of kinks below it) and the node. Angles are counted from the end of the
    /// ray, phi = pi/2 - t, so that a piece however thin keeps its digits.
    pub fn visit_pieces(&self, kinks: &[f64], position: &RadialPosition, mut visit: impl FnMut(usize, RadialNode)) {
        if position.inner == 0 {
            self.whole.iter().for_each(|&node| visit(0, node));
            return;
        }
        let mut from = position.phi_of(kinks, 0);
        let to = FRAC_PI_2 - from;
        for &[x, w] in &self.first {
            let (sin, cos) = (to * x).sin_cos();
            visit(0, RadialNode { sin, cos, weight: to * w });
        }
        for piece in 1..=position.inner {
            let to = if piece < position.inner { position.phi_of(kinks, piece) } else { 0.0 };
            for &[x, w] in &self.plain {
                let (cos, sin) = (from - (from - to) * x).sin_cos();
                visit(piece, RadialNode { sin, cos, weight: (from - to) * w });
            }
            from = to;
        }
    }
}

/// A place on a ray: r = a, beyond the first `inner` kinks. Just past a kink k, where G_a falls with infinite slope
/// (G_a(k) - G_a(a) ~ the jump of the slope times sqrt(a - k)), a itself has too few digits: there the place is t with
/// a = k sqrt(1 + t^2), in which G_a is smooth, and which far beyond the kink has all the digits of a again.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct RadialPosition {
    pub a: f64,
    /// How many kinks lie below a; a itself may be the next one, and then belongs to the inner side.
    pub inner: usize,
    /// tan phi, k = a cos phi, for the last of these; 0 when there is none.
    pub tan: f64,
}

impl RadialPosition {
    pub fn at(kinks: &[f64], a: f64) -> Self {
        let inner = kinks.partition_point(|&k| k < a);
        let tan = match inner {
            0 => 0.0,
            n => beyond(a, kinks[n - 1]) / kinks[n - 1],
        };
        Self { a, inner, tan }
    }

    /// The place with this t beyond kink number `kink`.
    pub fn beyond(kinks: &[f64], kink: usize, tan: f64) -> Self {
        Self { a: kinks[kink] * tan.hypot(1.0), inner: kink + 1, tan }
    }

    /// acos(k/a) of kink number `kink`, one of the inner ones.
    pub fn phi_of(&self, kinks: &[f64], kink: usize) -> f64 {
        let last = self.inner - 1;
        if kink == last {
            return self.tan.atan();
        }
        (kinks[last] * self.tan).hypot(beyond(kinks[last], kinks[kink])).atan2(kinks[kink])
    }
}

/// sqrt(a^2 - k^2).
pub(super) fn beyond(a: f64, k: f64) -> f64 {
    ((a - k) * (1.0 + k / a)).sqrt() * a.sqrt()
}

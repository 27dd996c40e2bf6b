//! What the bounds have to know of the overlap f = depth + tilt . x - gap: enclosures over rectangles.

use crate::numeric::geometry::Rect;

/// An interval: least and greatest.
pub type Interval = [f64; 2];

/// Enclosures of the overlap f = depth + tilt . x - gap, E* = 1. Every bound is certain, rounding included.
///
/// Where a body ends, f is continued beyond its end by any function that the other answers describe; what there is no material
/// of need not lie below the displacement ([`OverlapBounds::material`]).
pub trait OverlapBounds {
    /// Bounds of f(x) - slope . (x - c) over a rectangle with centre c.
    fn bounds(&self, rect: &Rect, slope: [f64; 2]) -> Interval;

    /// Bounds of df/dx and df/dy over a rectangle, wherever they exist. Infinite where f jumps.
    fn slopes(&self, rect: &Rect) -> [Interval; 2];

    /// Taylor's formula about the centre of a rectangle, valid in all of it; `None` where f has a kink in it.
    fn jet(&self, rect: &Rect) -> Option<Jet>;

    /// f and its gradient in the middle of a rectangle that f is known to be smooth in: nearly, no bound.
    fn nearly(&self, rect: &Rect) -> Option<(f64, [f64; 2])> {
        self.jet(rect).map(|jet| jet.nearly())
    }

    /// Bounds of the mean of f over a rectangle.
    fn mean(&self, rect: &Rect) -> Interval;

    /// Whether there may be a rectangle without material: false is certain.
    fn ends(&self) -> bool {
        true
    }

    /// Whether there may be material in a rectangle: false is certain.
    fn material(&self, _rect: &Rect) -> bool {
        true
    }

    /// Whether a displacement has to lie above f where there is material.
    fn binds(&self) -> bool {
        true
    }

    /// Whether f is worth a closer look in parts of a rectangle that it is smooth in.
    fn is_worth_parts(&self) -> bool {
        true
    }

    /// A rectangle outside which f <= 0 or no material is, for certain; `None` where no end is known.
    fn reach(&self) -> Option<Rect>;

    /// Whether there is time for more; once there is none, nothing more is shown.
    fn has_time(&self) -> bool {
        true
    }

    /// The lines x = c and y = c in which f is its own image, for certain.
    fn mirrors(&self) -> [Option<f64>; 2] {
        [None; 2]
    }
}

/// Taylor's formula over a rectangle with centre c: for each point c + x of it there are members of the intervals with
///
///   f = value + gradient . x + x . hessian x/2 + third[x, x, x]/6,
///   grad f = gradient + hessian x + third[x, x]/2
///
/// (not the same members in both lines). A kind that knows no third derivative gives the Hessian over the whole rectangle and zeros;
/// one that does gives the Hessian at the centre and the third derivatives over the rectangle: then what is left unknown is of
/// the fourth order in its sides.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Jet {
    /// f at the centre.
    pub value: Interval,
    /// (f_x, f_y) at the centre.
    pub gradient: [Interval; 2],
    /// (f_xx, f_xy, f_yy).
    pub hessian: [Interval; 3],
    /// (f_xxx, f_xxy, f_xyy, f_yyy).
    pub third: [Interval; 4],
}

impl Jet {
    /// Value and gradient at the centre, nearly.
    pub(super) fn nearly(&self) -> (f64, [f64; 2]) {
        (middle(self.value), self.gradient.map(middle))
    }
}

/// The middles of a jet, and what it leaves open.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Taylor {
    /// 1, x, y, x^2, xy, y^2, x^3, x^2 y, x y^2, y^3, the factorials divided out.
    pub terms: [f64; 10],
    /// Root mean square over the rectangle of what is left of f, and of its gradient.
    pub rest: [f64; 2],
    /// Suprema of the same.
    pub most: [f64; 2],
    /// Largest second derivatives, (|f_xx|, |f_yy|), over the rectangle.
    pub bend: [f64; 2],
}

fn middle([low, high]: Interval) -> f64 {
    0.5 * (low + high)
}

fn half([low, high]: Interval) -> f64 {
    // The middle is rounded: no further from either end than this.
    0.5 * (high - low) + f64::EPSILON * (low.abs() + high.abs())
}

/// 1/sqrt(2k + 1).
const ROOTS: [f64; 3] = [0.577_350_269_189_625_8, 0.447_213_595_499_958, 0.377_964_473_009_227_3];

impl Taylor {
    /// Of a jet over a rectangle of half sides `a`, `b`.
    pub fn of(jet: &Jet, [a, b]: [f64; 2]) -> Self {
        let (v, g, h, t) =
            (middle(jet.value), jet.gradient.map(middle), jet.hessian.map(middle), jet.third.map(middle));
        let terms = [v, g[0], g[1], 0.5 * h[0], h[1], 0.5 * h[2], t[0] / 6.0, 0.5 * t[1], 0.5 * t[2], t[3] / 6.0];
        let (dv, dg, dh, dt) = (half(jet.value), jet.gradient.map(half), jet.hessian.map(half), jet.third.map(half));
        // Over the rectangle suprema of |x|^k are a^k, root mean squares a^k/sqrt(2k + 1).
        let of = |x: [f64; 3], y: [f64; 3]| {
            let cubic = dt[0] * x[2] + 3.0 * (dt[1] * x[1] * y[0] + dt[2] * x[0] * y[1]) + dt[3] * y[2];
            let value = dv
                + dg[0] * x[0]
                + dg[1] * y[0]
                + 0.5 * (dh[0] * x[1] + dh[2] * y[1])
                + dh[1] * x[0] * y[0]
                + cubic / 6.0;
            let along = dg[0] + dh[0] * x[0] + dh[1] * y[0];
            let along = along + 0.5 * (dt[0] * x[1] + dt[2] * y[1]) + dt[1] * x[0] * y[0];
            let across = dg[1] + dh[1] * x[0] + dh[2] * y[0];
            let across = across + 0.5 * (dt[1] * x[1] + dt[3] * y[1]) + dt[2] * x[0] * y[0];
            [value, (along * along + across * across).sqrt()]
        };
        let powers = |a: f64| [a, a * a, a * a * a];
        let means = |[x, y, z]: [f64; 3]| [ROOTS[0] * x, ROOTS[1] * y, ROOTS[2] * z];
        let (x, y) = (powers(a), powers(b));
        let most = |[low, high]: Interval| low.abs().max(high.abs());
        let bend = [
            most(jet.hessian[0]) + a * most(jet.third[0]) + b * most(jet.third[1]),
            most(jet.hessian[2]) + a * most(jet.third[2]) + b * most(jet.third[3]),
        ];
        Self { terms, rest: of(means(x), means(y)), most: of(x, y), bend }
    }

    /// The same polynomial about a point at (x, y) from its own.
    pub fn moved(&self, [x, y]: [f64; 2]) -> Self {
        let t = &self.terms;
        let [value, along, across] = self.at([x, y]);
        let terms = [
            value,
            along,
            across,
            t[3] + 3.0 * x * t[6] + y * t[7],
            t[4] + 2.0 * (x * t[7] + y * t[8]),
            t[5] + 3.0 * y * t[9] + x * t[8],
            t[6],
            t[7],
            t[8],
            t[9],
        ];
        Self { terms, ..*self }
    }

    /// Value and gradient at (x, y) from the centre.
    #[inline(always)]
    pub fn at(&self, [x, y]: [f64; 2]) -> [f64; 3] {
        let t = &self.terms;
        let value = t[0]
            + x * (t[1] + x * (t[3] + x * t[6] + y * t[7]) + y * t[4])
            + y * (t[2] + y * (t[5] + y * t[9] + x * t[8]));
        let along = t[1] + x * (2.0 * t[3] + 3.0 * x * t[6] + 2.0 * y * t[7]) + y * (t[4] + y * t[8]);
        let across = t[2] + y * (2.0 * t[5] + 3.0 * y * t[9] + 2.0 * x * t[8]) + x * (t[4] + x * t[7]);
        [value, along, across]
    }
}

/// An overlap raised by a constant.
pub(super) struct Raised<'a> {
    /// The overlap.
    pub overlap: &'a dyn OverlapBounds,
    /// The constant, not negative.
    pub by: f64,
}

impl Raised<'_> {
    fn raised(&self, [low, high]: Interval) -> Interval {
        [(low + self.by).next_down(), (high + self.by).next_up()]
    }
}

impl OverlapBounds for Raised<'_> {
    fn bounds(&self, rect: &Rect, slope: [f64; 2]) -> Interval {
        self.raised(self.overlap.bounds(rect, slope))
    }

    fn slopes(&self, rect: &Rect) -> [Interval; 2] {
        self.overlap.slopes(rect)
    }

    fn jet(&self, rect: &Rect) -> Option<Jet> {
        self.overlap.jet(rect).map(|jet| Jet { value: self.raised(jet.value), ..jet })
    }

    fn mean(&self, rect: &Rect) -> Interval {
        self.raised(self.overlap.mean(rect))
    }

    fn ends(&self) -> bool {
        self.overlap.ends()
    }

    fn material(&self, rect: &Rect) -> bool {
        self.overlap.material(rect)
    }

    /// Of the overlap itself: where that is not positive there is no contact, raised or not.
    fn reach(&self) -> Option<Rect> {
        self.overlap.reach()
    }
}

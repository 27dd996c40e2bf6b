//! A formula as it is enclosed with its derivatives: powers of |u| and of r are taken as a whole.
//!
//! |u|^p has p |u|^(p-1) sign u and p (p - 1) |u|^(p-2), and r^p has p r^(p-2) x and p r^(p-2) (1 + (p - 2) x^2/r^2): bounded and continuous
//! for p > 2 where |u| and r themselves are not smooth. One function after the other would lose that, and that the root of a sum of
//! squares, hypot(a, b), is no steeper than a and b.

use super::R;
use super::functions::{Number, One, Two};
use super::tape::{Op, Tape};
use crate::numeric::Interval;
use crate::numeric::derivatives::{Chain, Cube, Dual, Jet, OfOne};
use crate::numeric::real::Real;

/// One operation.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Step {
    Plain(Op),
    /// |u|^p.
    Absolute(f64),
    /// r^p; takes nothing from the stack.
    Radial(f64),
}

/// A formula in x and y.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Smooth(Vec<Step>);

/// Least power that has second derivatives everywhere.
const LEAST: f64 = 2.0;

impl Smooth {
    pub fn of(tape: &Tape) -> Self {
        let mut steps: Vec<Step> = Vec::new();
        for &op in tape.ops() {
            if let Some(length) = (op == Op::One(One::Sqrt)).then(|| root(&steps)).flatten() {
                steps.truncate(start(&steps));
                steps.extend(length);
                steps.extend((steps.last() != Some(&HYPOT)).then_some(Step::Plain(Op::One(One::Abs))));
                continue;
            }
            let exponent = match (op, steps.last()) {
                (Op::Whole(n), _) => Some((f64::from(n), 0)),
                (Op::Two(Two::Power), Some(Step::Plain(Op::Constant(p)))) => Some((*p, 1)),
                _ => None,
            };
            let Some((p, constants)) = exponent else {
                steps.push(Step::Plain(op));
                continue;
            };
            let base = &steps[..steps.len() - constants];
            let (taken, step) = if p >= LEAST && base.ends_with(&[Step::Plain(Op::One(One::Abs))]) {
                (1, Step::Absolute(p))
            } else if let Some((taken, times)) = distance(base).filter(|(_, times)| times * p >= LEAST) {
                (taken, Step::Radial(times * p))
            } else {
                steps.push(Step::Plain(op));
                continue;
            };
            steps.truncate(base.len() - taken);
            steps.push(step);
        }
        Self(steps)
    }

    /// With its derivatives over a rectangle, from x and y there.
    pub fn run<T: Enclosed>(&self, [x, y]: [T; 2], variables: [T; 4]) -> T {
        let mut stack: Vec<T> = Vec::with_capacity(8);
        let nothing = T::constant(f64::NAN);
        for step in &self.0 {
            let value = match *step {
                Step::Plain(Op::Constant(c)) => T::constant(c),
                Step::Plain(Op::Variable(k)) => variables[k],
                Step::Plain(Op::Whole(n)) => stack.pop().unwrap_or(nothing).whole(n),
                Step::Plain(Op::One(f)) => stack.pop().unwrap_or(nothing).one(f),
                Step::Plain(Op::Two(f)) => {
                    let b = stack.pop().unwrap_or(nothing);
                    stack.pop().unwrap_or(nothing).two(b, f)
                }
                Step::Absolute(p) => stack.pop().unwrap_or(nothing).absolute(p),
                Step::Radial(p) => T::radial([x, y], p),
            };
            stack.push(value);
        }
        stack.pop().unwrap_or(nothing)
    }

    /// Whether r or theta are used by themselves.
    pub fn uses(&self, variable: usize) -> bool {
        self.0.contains(&Step::Plain(Op::Variable(variable)))
    }
}

const HYPOT: Step = Step::Plain(Op::Two(Two::Hypot));

/// Where the operand begins that the last step ends.
fn start(steps: &[Step]) -> usize {
    let mut wanted = 1;
    for (k, step) in steps.iter().enumerate().rev() {
        match step {
            Step::Plain(Op::Constant(_) | Op::Variable(_)) | Step::Radial(_) => wanted -= 1,
            Step::Plain(Op::Whole(_) | Op::One(_)) | Step::Absolute(_) => {}
            Step::Plain(Op::Two(_)) => wanted += 1,
        }
        if wanted == 0 {
            return k;
        }
    }
    0
}

/// What the operand at the end is the square of: of a power, of a multiple of one, of hypot(a, b) where it is a^2 + b^2.
fn root(steps: &[Step]) -> Option<Vec<Step>> {
    let (last, before) = steps.split_last()?;
    let times = |of: Option<Vec<Step>>, factor: f64, by: Two| {
        let constant = [Op::Constant(factor), Op::One(One::Sqrt), Op::Two(by)].map(Step::Plain);
        of.filter(|_| factor > 0.0).map(|of| [of, constant.to_vec()].concat())
    };
    let operand = &before[start(before)..];
    match *last {
        Step::Plain(Op::Whole(n)) if n > 0 && n % 2 == 0 => {
            let half = (n > 2).then_some(Step::Plain(Op::Whole(n / 2)));
            Some(operand.iter().copied().chain(half).collect())
        }
        Step::Absolute(2.0) => Some(operand.to_vec()),
        Step::Plain(Op::Two(f)) => {
            let first = &before[..before.len() - operand.len()];
            let first = &first[start(first)..];
            match (f, first, operand) {
                (Two::Add, a, b) => Some([root(a)?, root(b)?, vec![HYPOT]].concat()),
                (Two::Multiply, a, b) if a == b => Some(a.to_vec()),
                (Two::Multiply | Two::Divide, a, &[Step::Plain(Op::Constant(c))]) => times(root(a), c, f),
                (Two::Multiply, &[Step::Plain(Op::Constant(c))], b) => times(root(b), c, f),
                // c u u, from the left.
                (
                    Two::Multiply,
                    &[Step::Plain(Op::Constant(c)), ref of @ .., Step::Plain(Op::Two(Two::Multiply))],
                    b,
                ) if of == b => times(Some(b.to_vec()), c, f),
                _ => None,
            }
        }
        _ => None,
    }
}

/// How many steps at the end make a power of the distance from the origin, and which: r, hypot(x, y) (sqrt(x^2 + y^2) is one by then),
/// x^2 + y^2.
fn distance(steps: &[Step]) -> Option<(usize, f64)> {
    let [x, y] = [0, 1].map(|k| Step::Plain(Op::Variable(k)));
    let two = Step::Plain(Op::Whole(2));
    let add = Step::Plain(Op::Two(Two::Add));
    let ways: [(&[Step], f64); 3] =
        [(&[Step::Plain(Op::Variable(R))], 1.0), (&[x, y, HYPOT], 1.0), (&[x, two, y, two, add], 2.0)];
    ways.into_iter().find(|(way, _)| steps.ends_with(way)).map(|(way, times)| (way.len(), times))
}

/// What such a formula is run on.
pub(super) trait Enclosed: Number {
    /// |u|^p, p >= 2.
    fn absolute(self, p: f64) -> Self;
    /// r^p, p >= 2, from x and y themselves.
    fn radial(at: [Self; 2], p: f64) -> Self;
}

fn power(base: Interval, p: f64) -> Interval {
    base.powf(Interval::point(p))
}

/// Even powers of r are polynomials.
fn even<T: Number>([x, y]: [T; 2], p: f64) -> Option<T> {
    (p % 2.0 == 0.0 && p <= 16.0).then(|| x.whole(2).two(y.whole(2), Two::Add).whole((0.5 * p) as i32))
}

/// |v|^q sign v: it grows.
fn signed(v: Interval, q: f64) -> Interval {
    let at = |v: f64| {
        let size = power(Interval::point(v.abs()), q);
        if v < 0.0 { -size } else { size }
    };
    Interval { lo: at(v.lo).lo, hi: at(v.hi).hi, defined: v.defined }
}

/// |v|^p.
struct Absolute(Interval, f64);

impl Absolute {
    /// |v|^p.
    fn value(&self) -> Interval {
        power(self.0.abs(), self.1)
    }
}

impl OfOne<Interval> for Absolute {
    fn slope(&self) -> Interval {
        let &Self(v, p) = self;
        Interval::point(p) * signed(v, p - 1.0)
    }

    fn curvature(&self) -> Interval {
        let &Self(v, p) = self;
        Interval::point(p) * Interval::point(p - 1.0) * power(v.abs(), p - 2.0)
    }

    fn third(&self) -> Interval {
        let &Self(v, p) = self;
        match p {
            2.0 => Interval::ZERO,
            // |v|^(p - 3) has no bound there.
            _ if v.has_zero() && p < 3.0 => Interval::UNKNOWN,
            _ => {
                let sign = if v.has_zero() { Interval::new(-1.0, 1.0) } else { v.sign() };
                let c = Interval::point(p) * Interval::point(p - 1.0) * Interval::point(p - 2.0);
                c * power(v.abs(), p - 3.0) * sign
            }
        }
    }
}

/// r^p, its slopes, and p r^(p-2) with the bounds of x^2/r^2, x y/r^2 and y^2/r^2.
fn radial([x, y]: [Interval; 2], p: f64) -> (Interval, [Interval; 2], Interval, [Interval; 3]) {
    let r = x.hypot(y);
    let factor = Interval::point(p) * power(r, p - 2.0);
    let square = r.powi(2);
    let share = |of: Interval, low: f64, high: f64| of.quotient_within(square, Interval::new(low, high));
    let shares = [share(x.powi(2), 0.0, 1.0), share(x * y, -0.5, 0.5), share(y.powi(2), 0.0, 1.0)];
    (power(r, p), [factor * x, factor * y], factor, shares)
}

impl Enclosed for Dual<Interval> {
    fn absolute(self, p: f64) -> Self {
        let f = Absolute(self.value, p);
        self.chain(f.value(), &f)
    }

    fn radial(at: [Self; 2], p: f64) -> Self {
        even(at, p).unwrap_or_else(|| {
            let (value, gradient, ..) = radial(at.map(|v| v.value), p);
            Self { value, gradient }
        })
    }
}

impl Enclosed for Jet<Interval> {
    fn absolute(self, p: f64) -> Self {
        let f = Absolute(self.value, p);
        self.chain(f.value(), &f)
    }

    fn radial(at: [Self; 2], p: f64) -> Self {
        if let Some(even) = even(at, p) {
            return even;
        }
        let (value, gradient, factor, [xx, xy, yy]) = radial(at.map(|v| v.value), p);
        let (one, more) = (Interval::point(1.0), Interval::point(p - 2.0));
        Self {
            value,
            gradient,
            hessian: [factor * (one + more * xx), factor * (more * xy), factor * (one + more * yy)],
        }
    }
}

impl Enclosed for Cube<Interval> {
    fn absolute(self, p: f64) -> Self {
        let f = Absolute(self.jet.value, p);
        self.chain(f.value(), &f)
    }

    /// Third derivatives: p (p - 2) r^(p-3) (3 n_x + (p - 4) n_x^3), p (p - 2) r^(p-3) (n_y + (p - 4) n_x^2 n_y) and so on, n = (x, y)/r.
    fn radial(at: [Self; 2], p: f64) -> Self {
        if let Some(even) = even(at, p) {
            return even;
        }
        let [x, y] = at.map(|v| v.jet.value);
        let r = x.hypot(y);
        let [nx, ny] = [x, y].map(|v| v.share_of(r));
        let (c, three) = (Interval::point(p - 4.0), Interval::point(3.0));
        let factor = Interval::point(p) * Interval::point(p - 2.0) * power(r, p - 3.0);
        let third = [
            factor * nx * (three + c * nx.powi(2)),
            factor * ny * (Interval::point(1.0) + c * nx.powi(2)),
            factor * nx * (Interval::point(1.0) + c * ny.powi(2)),
            factor * ny * (three + c * ny.powi(2)),
        ];
        Self { jet: Jet::radial(at.map(|v| v.jet), p), third }
    }
}

#[cfg(test)]
mod tests {
    use crate::gap::{Formula, Gap};
    use crate::numeric::Interval;
    use crate::numeric::geometry::Rect;

    /// Centres and half sides: about the origin, with it, away from it.
    const RECTANGLES: [([f64; 2], [f64; 2]); 3] =
        [([0.0; 2], [0.1, 0.07]), ([0.05, -0.03], [0.06, 0.05]), ([0.4, 0.3], [0.02, 0.03])];

    /// 20 x 20 points of a rectangle.
    fn points(c: [f64; 2], half: [f64; 2]) -> impl Iterator<Item = [f64; 2]> {
        (0..400).map(move |k| {
            let at = |m: usize, n: usize| c[m] + half[m] * ((n as f64 + 0.5) / 10.0 - 1.0);
            [at(0, k % 20), at(1, k / 20)]
        })
    }

    #[test]
    fn second_derivatives_hold_where_a_distance_or_a_size_is_zero() {
        for text in [
            "abs(x)^3 + 0.4*y^2",
            "abs(x - 0.02)^2.5 + abs(y)^4",
            "r^2 + r^3",
            "hypot(x, y)^2.2 + x*y",
            "sqrt(x^2 + y^2)^5",
            "(x^2 + y^2)^1.5 + x^2",
        ] {
            let gap = Formula::new(text).unwrap();
            for (c, half) in RECTANGLES {
                let rect = Rect::around(c, half);
                let taylor = gap.taylor(&rect).unwrap_or_else(|| panic!("{text} at {c:?}"));
                let slopes = taylor.slopes(rect.size());
                let [low, high] = taylor.bounds(rect.size(), [0.0; 2]);
                for [x, y] in points(c, half) {
                    let g = gap.gap(x, y);
                    assert!(low <= g && g <= high, "{text} at {x} {y}");
                    let h = 1e-4;
                    let second = [
                        (gap.gap(x + h, y) - 2.0 * g + gap.gap(x - h, y)) / (h * h),
                        (gap.gap(x + h, y + h) - gap.gap(x + h, y - h) - gap.gap(x - h, y + h) + gap.gap(x - h, y - h))
                            / (4.0 * h * h),
                        (gap.gap(x, y + h) - 2.0 * g + gap.gap(x, y - h)) / (h * h),
                    ];
                    // What differences make of a derivative that is continuous only.
                    let room = 0.03 * (1.0 + taylor.hessian.map(Interval::magnitude).into_iter().fold(0.0, f64::max));
                    for (d, bounds) in second.into_iter().zip(taylor.hessian) {
                        assert!(bounds.lo - room <= d && d <= bounds.hi + room, "{text} at {x} {y}: {d} {bounds:?}");
                    }
                    let own = gap.gradient(x, y).unwrap();
                    (0..2).for_each(|m| assert!(slopes[m].lo <= own[m] && own[m] <= slopes[m].hi, "{text} at {x} {y}"));
                }
            }
        }
    }

    #[test]
    fn roots_of_sums_of_squares_are_no_steeper_than_what_is_squared() {
        for text in [
            "0.5*hypot(x, 2*y)",
            "sqrt(x^2 + 4*y^2)",
            "sqrt(x^2/9 + abs(y)^2) + x^2",
            "sqrt(2*x*x + (x - y)^4 + y^2)",
            "0.1*sqrt(3*(x + y)^2)",
        ] {
            let gap = Formula::new(text).unwrap();
            for (c, half) in RECTANGLES {
                let rect = Rect::around(c, half);
                let slopes = gap.slopes(&rect).unwrap_or_else(|| panic!("{text} at {c:?}"));
                let [low, high] = gap.bounds(&rect, [0.0; 2]).unwrap();
                assert!(slopes.into_iter().all(|s| s.magnitude() < 2.5), "{text}: {slopes:?}");
                for [x, y] in points(c, half) {
                    assert!(low <= gap.gap(x, y) && gap.gap(x, y) <= high, "{text} at {x} {y}");
                    let Some(own) = gap.gradient(x, y) else { continue };
                    (0..2).for_each(|m| assert!(slopes[m].lo <= own[m] && own[m] <= slopes[m].hi, "{text} at {x} {y}"));
                }
            }
        }
    }
}

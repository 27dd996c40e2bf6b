//! Recognises formulas that are convex and made of planes.

use super::functions::{One, Two};
use super::tape::{Op, Tape};
use crate::gap::Polyhedron;

/// More planes than this are left to quadrature.
const MOST_PLANES: usize = 256;

/// max over planes of (a x + b y + c): what each step of the formula is, as long as it is convex.
type Planes = Vec<[f64; 3]>;

/// The polyhedron that the formula describes, if it does.
///
/// Sums, positive multiples, max and abs keep a convex function of planes; a linear one may also be negated.
pub(super) fn polyhedron(tape: &Tape) -> Option<Polyhedron> {
    let mut stack: Vec<Planes> = Vec::new();
    for &op in tape.ops() {
        let result = match op {
            Op::Constant(c) => vec![[0.0, 0.0, c]],
            Op::Variable(0) => vec![[1.0, 0.0, 0.0]],
            Op::Variable(1) => vec![[0.0, 1.0, 0.0]],
            Op::One(f) => {
                let a = stack.pop()?;
                match f {
                    One::Negate => negated(&a)?,
                    One::Abs => {
                        let minus = negated(&a)?;
                        [a, minus].concat()
                    }
                    _ => return None,
                }
            }
            Op::Two(f) => {
                let (b, a) = (stack.pop()?, stack.pop()?);
                match f {
                    Two::Add => sum(&a, &b),
                    Two::Subtract => sum(&a, &negated(&b)?),
                    Two::Max => [a, b].concat(),
                    Two::Multiply => match (constant(&a), constant(&b)) {
                        (Some(c), _) => multiple(&b, c)?,
                        (_, Some(c)) => multiple(&a, c)?,
                        _ => return None,
                    },
                    Two::Divide => {
                        let c = constant(&b)?;
                        let divided = |p: &[f64; 3]| p.map(|v| v / c.abs());
                        let a: Planes = a.iter().map(divided).collect();
                        if c > 0.0 { a } else { negated(&a)? }
                    }
                    _ => return None,
                }
            }
            Op::Variable(_) | Op::Whole(_) => return None,
        };
        if result.len() > MOST_PLANES {
            return None;
        }
        stack.push(result);
    }
    let mut planes: Planes = Vec::new();
    for plane in stack.pop()? {
        if !planes.contains(&plane) {
            planes.push(plane);
        }
    }
    // One plane has no lowest place; its formula is served as any other.
    if planes.len() < 2 { None } else { Polyhedron::new(planes).ok() }
}

fn constant(planes: &[[f64; 3]]) -> Option<f64> {
    match planes {
        &[[0.0, 0.0, c]] => Some(c),
        _ => None,
    }
}

fn negated(planes: &[[f64; 3]]) -> Option<Planes> {
    match planes {
        &[plane] => Some(vec![plane.map(|v| -v)]),
        _ => None,
    }
}

fn multiple(planes: &[[f64; 3]], c: f64) -> Option<Planes> {
    let scaled = planes.iter().map(|p| p.map(|v| v * c.abs())).collect::<Planes>();
    if c >= 0.0 { Some(scaled) } else { negated(&scaled) }
}

fn sum(a: &[[f64; 3]], b: &[[f64; 3]]) -> Planes {
    if a.len() * b.len() > MOST_PLANES {
        // Too many; the caller gives up on the length.
        return vec![[0.0; 3]; MOST_PLANES + 1];
    }
    a.iter().flat_map(|p| b.iter().map(move |q| [p[0] + q[0], p[1] + q[1], p[2] + q[2]])).collect()
}

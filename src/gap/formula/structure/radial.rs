//! Whether a formula depends on the distance from the origin alone.

use super::Node;
use super::polynomial::Polynomial;
use crate::gap::formula::R;
use crate::gap::formula::functions::Two;

/// A node as a polynomial, and whether its value depends on the distance alone.
#[derive(Debug, Clone)]
pub(super) struct Radial {
    polynomial: Option<Polynomial>,
    pub radial: bool,
}

/// The rule of a node; `None` where neither is known: nothing above can depend on the distance alone then.
pub(super) fn radial(node: Node, of: &[Radial]) -> Option<Radial> {
    let operands: Option<Vec<&Polynomial>> = match node {
        Node::Constant(_) | Node::Variable(_) => Some(Vec::new()),
        Node::Whole(a, _) | Node::One(_, a) => of[a].polynomial.as_ref().map(|p| vec![p]),
        Node::Two(_, a, b) => of[a].polynomial.as_ref().zip(of[b].polynomial.as_ref()).map(|(p, q)| vec![p, q]),
    };
    // The rule for polynomials looks operands up by their place.
    let renamed = match node {
        Node::Whole(_, n) => Node::Whole(0, n),
        Node::One(f, _) => Node::One(f, 0),
        Node::Two(f, ..) => Node::Two(f, 0, 1),
        leaf => leaf,
    };
    let polynomial =
        operands.and_then(|p| Polynomial::of(renamed, &p.into_iter().cloned().collect::<Vec<_>>(), [0.0; 2]));
    let own = match node {
        Node::Constant(_) | Node::Variable(R) => true,
        Node::Variable(_) => false,
        Node::Whole(a, _) | Node::One(_, a) => of[a].radial,
        Node::Two(f, a, b) => {
            let is = |p: &Option<Polynomial>, i, j| p.as_ref().is_some_and(|p| p.degree() == 1 && p.at(i, j) != 0.0);
            let length = f == Two::Hypot && length(&of[a].polynomial, &of[b].polynomial, &is);
            (of[a].radial && of[b].radial) || length
        }
    };
    let radial = own || polynomial.as_ref().is_some_and(Polynomial::is_radial);
    (radial || polynomial.is_some()).then_some(Radial { polynomial, radial })
}

/// Whether hypot of the two is a multiple of the distance: c x and +-c y.
fn length(
    a: &Option<Polynomial>,
    b: &Option<Polynomial>,
    is: &dyn Fn(&Option<Polynomial>, usize, usize) -> bool,
) -> bool {
    let (Some(p), Some(q)) = (a, b) else { return false };
    let alone = |p: &Polynomial, i, j| p.at(0, 0) == 0.0 && p.at(j, i) == 0.0 && p.at(i, j) != 0.0;
    let (along, across) = if is(a, 1, 0) { (p.at(1, 0), q.at(0, 1)) } else { (p.at(0, 1), q.at(1, 0)) };
    let each = (alone(p, 1, 0) && alone(q, 0, 1)) || (alone(p, 0, 1) && alone(q, 1, 0));
    each && along.abs() == across.abs()
}

//! What is known of a gap of several parts, a sum or a minimum, from what is known of each.

use super::{AnyGap, Axis, Generatrix};

/// The tips of a part, or the point that it is drawn about.
pub(super) fn tips_of(part: &AnyGap) -> Vec<[f64; 2]> {
    let known = part.known();
    if known.tips.is_empty() { vec![known.centre] } else { known.tips.clone() }
}

/// The mirrors through this point that all parts have.
pub(super) fn common_mirrors(parts: &[AnyGap], centre: [f64; 2]) -> [bool; 2] {
    parts
        .iter()
        .map(AnyGap::known)
        .fold([true; 2], |all, known| [0, 1].map(|m| all[m] && known.mirrors[m] && known.centre[m] == centre[m]))
}

/// The axes that a gap of several parts is drawn along: those of a part with straight edges, else of the first that has a direction.
pub(super) fn drawn_along(parts: &[AnyGap]) -> f64 {
    let all = || parts.iter().map(AnyGap::known);
    let ended = all().find(|known| known.ends.is_some());
    ended.or_else(|| all().find(|known| known.axis.is_none())).map_or(0.0, |known| known.drawn_along)
}

/// The axis that all parts share, and what becomes of their generatrices.
pub(super) fn common_axis(
    parts: &[AnyGap],
    together: &mut dyn FnMut(&Generatrix, &Generatrix) -> Generatrix,
) -> Option<Axis> {
    let axes = parts.iter().map(|part| part.known().axis);
    axes.reduce(|a, b| {
        let (a, b) = a.zip(b)?;
        (a.at == b.at).then(|| Axis { at: a.at, generatrix: together(&a.generatrix, &b.generatrix) })
    })
    .flatten()
}

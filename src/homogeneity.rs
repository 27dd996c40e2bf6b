//! Homogeneous gaps: g(c + s v) = s^k g(c + v). Then P ~ d^(1 + 1/k), area ~ d^(2/k), all contacts similar: one solve
//! serves every depth and every force.

use crate::gap::{Gap, around_tips, enough};
use crate::geometry::Rect;

/// Share by which a gap may miss the law and still be taken as homogeneous.
const EXACT: f64 = 1e-10;

/// Factors at which the law is tested; not powers of one another.
const FACTORS: [f64; 4] = [0.5, 0.31, 0.083, 0.0127];

/// Points at which it is tested.
const POINTS: usize = 48;

/// The degree k of a gap that is homogeneous about its centre, tested at points of the box around {g < depth}. A flat
/// punch has no degree: see [`Degree::Flat`].
#[must_use]
pub fn degree(gap: &dyn Gap, within: &Rect) -> Option<Degree> {
    let [cx, cy] = gap.centre();
    if gap.gap(cx, cy) != 0.0 {
        return None;
    }
    let size = within.size();
    let at = |v: [f64; 2], s: f64| gap.gap(cx + s * v[0], cy + s * v[1]);
    let (mut k, mut material, mut zeros) = (None, 0, 0);
    // A depth that the box around it belongs to does not matter here, only whether the gap knows its reach at all.
    let even = (1..=enough(gap, 0.0, POINTS)).map(|n| {
        // A plastic-number sequence (Roberts 2018): spread evenly, on no axis and no ridge.
        [
            ((0.5 + 0.754_877_666_246_692_7 * n as f64).fract() - 0.5) * size[0] + within.centre()[0],
            ((0.5 + 0.569_840_290_998_053_2 * n as f64).fract() - 0.5) * size[1] + within.centre()[1],
        ]
    });
    // Close to the centre rounding of its place would count.
    let tips = around_tips(gap, within);
    let near = 1e-3 * size[0].max(size[1]);
    let tips = tips.into_iter().filter(|p| (p[0] - cx).hypot(p[1] - cy) > near);
    let mut points = 0;
    for p in even.chain(tips) {
        points += 1;
        let v = [p[0] - cx, p[1] - cy];
        let whole = at(v, 1.0);
        if whole == f64::INFINITY {
            continue;
        }
        material += 1;
        if whole == 0.0 {
            zeros += 1;
            continue;
        }
        for s in FACTORS {
            let part = at(v, s);
            let here = (part / whole).ln() / s.ln();
            let known: f64 = *k.get_or_insert(here);
            if !(part > 0.0 && whole > 0.0 && known > 0.0) || (part - whole * s.powf(known)).abs() > EXACT * part {
                return None;
            }
        }
    }
    match k {
        Some(k) if zeros == 0 && material == points => {
            Some(Degree::Power(if (k - k.round()).abs() < 1e-9 { k.round() } else { k }))
        }
        None if material > 0 && ends_at_once(gap, within) => Some(Degree::Flat),
        _ => None,
    }
}

/// Whether the material ends where the flat does, along rays from the centre: a flat with flanks is not homogeneous, however narrow
/// they are at the present depth.
fn ends_at_once(gap: &dyn Gap, within: &Rect) -> bool {
    let [cx, cy] = gap.centre();
    let far = within.corners().map(|[x, y]| (x - cx).hypot(y - cy)).into_iter().fold(0.0, f64::max);
    (0..RAYS).all(|k| {
        let (sin, cos) = (0.1 + std::f64::consts::TAU * f64::from(k) / f64::from(RAYS)).sin_cos();
        let at = |r: f64| gap.gap(cx + r * cos, cy + r * sin);
        let (mut flat, mut beyond) = (0.0, 1.001 * far);
        if at(beyond) == 0.0 {
            return false;
        }
        for _ in 0..60 {
            let middle = 0.5 * (flat + beyond);
            if at(middle) == 0.0 { flat = middle } else { beyond = middle }
        }
        at(beyond) == f64::INFINITY
    })
}

/// Rays along which the rim of a flat is looked at.
const RAYS: u32 = 16;

/// Whether a gap of degree 1 is made of planes: nearly everywhere a straight line across a ray lies on it.
#[must_use]
pub fn is_of_planes(gap: &dyn Gap, within: &Rect) -> bool {
    let ([cx, cy], size) = (gap.centre(), within.size());
    let r = 0.1 * size[0].min(size[1]);
    let straight = |k: u32| {
        let (sin, cos) = (0.1 + std::f64::consts::TAU * f64::from(k) / f64::from(STRAIGHT)).sin_cos();
        let at = |t: f64| gap.gap(cx + r * (cos - t * sin), cy + r * (sin + t * cos));
        let middle = at(0.0);
        (at(1e-2) - 2.0 * middle + at(-1e-2)).abs() <= 1e-9 * middle.abs()
    };
    // The others may meet a ridge.
    4 * (0..STRAIGHT).filter(|&k| straight(k)).count() as u32 >= 3 * STRAIGHT
}

/// Rays on which straightness is looked at.
const STRAIGHT: u32 = 64;

/// The degree of a homogeneous gap.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Degree {
    /// g(s v) = s^k g(v).
    Power(f64),
    /// Zero inside a fixed plan-form, no material outside: the limit of k without end.
    Flat,
}

impl Degree {
    /// 1/k.
    #[must_use]
    pub fn inverse(self) -> f64 {
        match self {
            Self::Power(k) => 1.0 / k,
            Self::Flat => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gap::{Cone, Paraboloid, Polyhedron, Power, Sphere};

    #[test]
    fn degrees_of_the_named_kinds() {
        let unit = Rect::around([0.0; 2], [1.0; 2]);
        let of = |gap: &dyn Gap| degree(gap, &unit);
        assert_eq!(of(&Cone::new(0.3).unwrap()), Some(Degree::Power(1.0)));
        assert_eq!(of(&Paraboloid::new([1.0, 7.0]).unwrap()), Some(Degree::Power(2.0)));
        assert_eq!(of(&Polyhedron::pyramid(5, 0.2).unwrap()), Some(Degree::Power(1.0)));
        assert!(matches!(of(&Power::new(2.0, 2.7).unwrap()), Some(Degree::Power(k)) if (k - 2.7).abs() < 1e-12));
        assert_eq!(of(&Sphere::new(10.0).unwrap()), None);
        assert_eq!(of(&Polyhedron::truncated_pyramid(4, 0.2, 0.1).unwrap()), None);
        assert_eq!(of(&|x: f64, y: f64| if x.hypot(y) < 0.5 { 0.0 } else { f64::INFINITY }), Some(Degree::Flat));
        assert_eq!(of(&|x: f64, y: f64| (x * x + y * y) * (1.0 + 1e-8 * x)), None);
        // A flat with flanks that are narrow at this depth.
        let blunt = Polyhedron::truncated_pyramid(4, 0.4, 0.5).unwrap();
        assert_eq!(degree(&blunt, &Rect::around([0.0; 2], [0.502; 2])), None);
    }
}

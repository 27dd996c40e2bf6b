//! The kinks along rays about one centre, for a gap made of many planes: ridges in the order of their directions.
//!
//! Seen from the centre every ridge spans an interval of angles, and a ray crosses it if its own angle lies within. A table
//! over the angle holds the ridges of each direction, so that a ray looks only at those that it may meet, not at all planes.

use std::f64::consts::{PI, TAU};

use super::ray::ScaledOverlap;
use crate::gap::{Gap, Ridge, Ridges};

/// Fewer ridges than this are tried one by one; the table saves an eighth of the time at 40 planes, half at 300.
const MANY: usize = 32;
/// Entries of the table beyond which it is not worth its memory: a centre among very many ridges.
const MOST_ENTRIES: usize = 4_000_000;

/// The ridges around one centre.
pub(super) struct Facets {
    centre: [f64; 2],
    ridges: Ridges,
    /// First angle and width of the interval that each ridge spans.
    spans: Vec<[f64; 2]>,
    /// Where the entries of each direction begin, and the entries.
    begins: Vec<u32>,
    entries: Vec<u32>,
    /// Directions of the ridges that run through the centre, ascending, and the gradient beyond each; one alone where there are none.
    around: Vec<(f64, [f64; 2])>,
}

impl Facets {
    /// `None` where the gap is not made of many planes. Ridges closer to the centre than `at_centre` run through it.
    pub fn about(overlap: &ScaledOverlap, centre: [f64; 2], at_centre: f64) -> Option<Self> {
        let ridges = overlap.gap.ridges().filter(|r| overlap.has_planes() && r.all.len() >= MANY)?;
        let mut through = Vec::new();
        let spans: Vec<[f64; 2]> =
            ridges.all.iter().map(|ridge| span(ridge, &ridges, centre, at_centre, &mut through)).collect();
        let cells = spans.len();
        let cell = |angle: f64| (angle / TAU * cells as f64) as usize;
        let mut lists = vec![Vec::new(); cells];
        let mut held = 0;
        for (k, &[start, width]) in spans.iter().enumerate().filter(|(_, s)| s[1] > 0.0) {
            for c in cell(start)..=cell(start + width) {
                lists[c % cells].push(k as u32);
                held += 1;
            }
            if held > MOST_ENTRIES {
                return None;
            }
        }
        let mut begins = vec![0];
        begins.extend(lists.iter().scan(0, |sum, list| {
            *sum += list.len() as u32;
            Some(*sum)
        }));
        let mut facets = Self { centre, ridges, spans, begins, entries: lists.concat(), around: vec![(0.0, [0.0; 2])] };
        through.sort_by(f64::total_cmp);
        through.dedup();
        let mut met = Vec::new();
        if let Some(&first) = through.first() {
            facets.around = (0..through.len())
                .map(|k| {
                    let from = through[k];
                    let to = through.get(k + 1).copied().unwrap_or(first + TAU);
                    let (sin, cos) = (0.5 * (from + to)).sin_cos();
                    met.clear();
                    facets.meet([cos, sin], &mut met);
                    let r = 0.5 * met.iter().map(|m| m.0).fold(2.0, f64::min);
                    (from, overlap.slope([centre[0] + r * cos, centre[1] + r * sin], 0.0))
                })
                .collect();
        } else {
            facets.around = vec![(0.0, overlap.slope(centre, 0.0))];
        }
        Some(facets)
    }

    /// Appends (distance, jump of the slope) of every ridge that a ray meets, in no order.
    fn meet(&self, [ex, ey]: [f64; 2], met: &mut Vec<(f64, f64)>) {
        let angle = ey.atan2(ex).rem_euclid(TAU);
        let cell = ((angle / TAU * self.spans.len() as f64) as usize).min(self.spans.len() - 1);
        for &k in &self.entries[self.begins[cell] as usize..self.begins[cell + 1] as usize] {
            let [start, width] = self.spans[k as usize];
            if (angle - start).rem_euclid(TAU) >= width {
                continue;
            }
            let Ridge { point, direction: [dx, dy], jump, .. } = &self.ridges.all[k as usize];
            let r = ((point[0] - self.centre[0]) * dy - (point[1] - self.centre[1]) * dx) / (ex * dy - ey * dx);
            if r > 0.0 && r.is_finite() {
                met.push((r, (jump[0] * ex + jump[1] * ey).abs()));
            }
        }
    }

    /// Appends kinks and jumps of the slope along a ray, ascending, and returns the slope on the first piece. Kinks nearer than
    /// `at_centre` count as lying at the centre.
    pub fn read(
        &self,
        direction: [f64; 2],
        at_centre: f64,
        met: &mut Vec<(f64, f64)>,
        kinks: &mut Vec<f64>,
        jumps: &mut Vec<f64>,
    ) -> f64 {
        met.clear();
        self.meet(direction, met);
        met.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let angle = direction[1].atan2(direction[0]).rem_euclid(TAU);
        let sector = self.around.partition_point(|a| a.0 <= angle);
        let (_, [gx, gy]) = self.around[(sector + self.around.len() - 1) % self.around.len()];
        let mut slope = gx * direction[0] + gy * direction[1];
        for &(r, jump) in met.iter() {
            if r < at_centre {
                slope += jump;
            } else {
                kinks.push(r);
                jumps.push(jump);
            }
        }
        slope
    }
}

/// First angle and width of the interval that a ridge spans, seen from `centre`; width 0, and its directions to `through`, when
/// it runs through the centre.
fn span(ridge: &Ridge, ridges: &Ridges, centre: [f64; 2], at_centre: f64, through: &mut Vec<f64>) -> [f64; 2] {
    let [dx, dy] = ridge.direction;
    let [x, y] = [0, 1].map(|m| ridge.point[m] - centre[m]);
    let aside = x * dy - y * dx;
    let angle = |[x, y]: [f64; 2]| y.atan2(x).rem_euclid(TAU);
    let seen = |end: Option<usize>| end.map(|k| [0, 1].map(|m| ridges.corners[k][m] - centre[m]));
    let ends = ridge.ends.map(seen);
    let along = |[x, y]: [f64; 2]| x * dx + y * dy;
    if aside.abs() <= at_centre {
        let [low, high] = ends;
        // Those of its two directions on which it goes on from the centre; none where the centre is not on it.
        let reaches_back = low.is_none_or(|p| along(p) < -at_centre);
        let reaches_on = high.is_none_or(|p| along(p) > at_centre);
        let on_it = low.is_none_or(|p| along(p) <= at_centre) && high.is_none_or(|p| along(p) >= -at_centre);
        if on_it && reaches_on {
            through.push(angle([dx, dy]));
        }
        if on_it && reaches_back {
            through.push(angle([-dx, -dy]));
        }
        return [0.0; 2];
    }
    let [back, on] = [ends[0].unwrap_or([-dx, -dy]), ends[1].unwrap_or([dx, dy])].map(angle);
    let (start, end) = if aside > 0.0 { (back, on) } else { (on, back) };
    let width = (end - start).rem_euclid(TAU);
    // A hair's breadth may come out as a whole turn.
    [start, if width <= PI * (1.0 + 1e-12) { width } else { 0.0 }]
}

#[cfg(test)]
mod tests {
    use super::super::ray::RayLine;
    use super::*;
    use crate::gap::Polyhedron;

    /// Kinks, jumps and slopes are those of the gap itself, from centres on a corner, on a ridge, and off both.
    #[test]
    fn rays_meet_what_the_gap_tells() {
        let planes: Vec<[f64; 3]> = (0..60)
            .map(|k| (f64::from(k), 1.0 + 0.3 * f64::from(k % 3)))
            .map(|(k, s)| [s * (0.1047 * k).cos(), s * (0.1047 * k).sin(), 0.4 * (s - 1.0) - 0.05 * (1.3 * k).sin()])
            .collect();
        let fan = Polyhedron::new(Polyhedron::pyramid(50, 0.7).unwrap().planes().to_vec()).unwrap();
        let gaps = [Polyhedron::new(planes).unwrap(), fan, Polyhedron::truncated_pyramid(40, 0.7, 0.3).unwrap()];
        for gap in &gaps {
            let overlap = ScaledOverlap::unscaled(gap);
            let ridges = gap.ridges().unwrap();
            let on_ridge = [0, 1].map(|m| ridges.all[0].point[m] + 1e-3 * ridges.all[0].direction[m]);
            for centre in [[0.013, -0.021], [0.3, 0.4], ridges.corners[0], on_ridge] {
                let facets = Facets::about(&overlap, centre, 1e-13).unwrap();
                for k in 0..97 {
                    let (sin, cos) = (0.01 + TAU * f64::from(k) / 97.0).sin_cos();
                    let (mut kinks, mut jumps, mut met) = (Vec::new(), Vec::new(), Vec::new());
                    let slope = facets.read([cos, sin], 1e-13, &mut met, &mut kinks, &mut jumps);
                    let mut told = Vec::new();
                    gap.ray_kinks(centre, [cos, sin], &mut told);
                    told.sort_by(f64::total_cmp);
                    told.retain(|&r| r >= 1e-13);
                    assert_eq!(told.len(), kinks.len(), "{centre:?} {k}: {told:?} {kinks:?}");
                    assert!(told.iter().zip(&kinks).all(|(a, b)| (a - b).abs() < 1e-10 * (1.0 + a)));
                    let line = RayLine { centre, direction: [cos, sin], kinks: &told, planes: None };
                    let mut expected = Vec::new();
                    assert!((line.read_planes(&overlap, &mut expected) - slope).abs() < 1e-12, "{centre:?} {k}");
                    assert!(expected.iter().zip(&jumps).all(|(a, b)| (a - b).abs() < 1e-12), "{centre:?} {k}");
                }
            }
        }
    }
}

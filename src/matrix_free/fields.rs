//! What conjugate gradients on a face work with, in single precision, and the passes over it.
//!
//! A pass goes piece by piece: what it leaves of one is in the cache for the next operation, sums are taken in one order whatever the
//! number of threads, and threads share the pieces.

use std::ops::Range;

use super::convolution::Convolution;
use super::level::{Level, State};
use super::operator::Scratch;
use super::region::Region;

/// Cells that a pass works on together.
pub(super) const PIECE: usize = 4096;

/// Sums and largest numbers done side by side.
const LANES: usize = 16;

/// The compliance between the cells of a box in single precision, and nearly its inverse.
#[derive(Debug)]
pub(super) struct Near {
    pub(super) single: Convolution<f32>,
    pub(super) preconditioner: Convolution<f32>,
}

/// Fields over the cells of a box.
pub(super) struct Fields {
    width: usize,
    /// Pressure, in double precision throughout.
    pub(super) p: Vec<f64>,
    /// Overlap, for its sign; zero counts as no overlap.
    pub(super) f: Vec<f32>,
    /// f - A p.
    pub(super) r: Vec<f32>,
    /// The preconditioned residual.
    pub(super) z: Vec<f32>,
    /// The direction of the step, and A times it.
    pub(super) d: Vec<f32>,
    pub(super) ad: Vec<f32>,
    /// The residual on the face.
    pub(super) w: Vec<f32>,
    /// 1 on the face and 0 elsewhere.
    pub(super) face: Vec<f32>,
    /// Under a load: nearly the pressure of a flat punch on a face before.
    pub(super) flat: Vec<f32>,
}

impl Fields {
    /// Of zeros.
    pub(super) fn new([width, height]: [usize; 2]) -> Self {
        let n = width * height;
        let [f, r, z, d, ad, w, face] = [(); 7].map(|()| vec![0.0; n]);
        Self { width, p: vec![0.0; n], f, r, z, d, ad, w, face, flat: Vec::new() }
    }

    /// For the region of a grid, its overlap and pressure taken from there.
    pub(super) fn of(level: &Level, region: &Region, state: &State, scratch: &Scratch) -> Self {
        let mut fields = Self::new(region.shape());
        let (width, columns) = (level.shape[0], fields.width);
        let rows = fields.f.chunks_exact_mut(columns).zip(region.of(level.f, width));
        let rows = rows.zip(fields.p.chunks_exact_mut(columns).zip(region.of(&state.p, width)));
        scratch.each(
            rows,
            #[inline(always)]
            |((f, overlap), (p, pressure))| {
                f.iter_mut().zip(overlap).for_each(|(to, from)| *to = *from as f32);
                p.copy_from_slice(pressure);
            },
        );
        fields
    }

    /// Takes pressure and residual from the grid again.
    pub(super) fn restart(&mut self, level: &Level, region: &Region, state: &State, scratch: &Scratch) {
        let width = level.shape[0];
        let rows = self.p.chunks_exact_mut(self.width).zip(region.of(&state.p, width));
        let rows = rows.zip(self.r.chunks_exact_mut(self.width).zip(region.of(&state.r, width)));
        scratch.each(
            rows,
            #[inline(always)]
            |((p, pressure), (r, residual))| {
                p.copy_from_slice(pressure);
                r.iter_mut().zip(residual).for_each(|(to, from)| *to = *from as f32);
            },
        );
    }

    pub(super) fn shape(&self) -> [usize; 2] {
        [self.width, self.p.len() / self.width]
    }

    fn cells(&self, rows: &Range<usize>) -> Range<usize> {
        rows.start * self.width..rows.end * self.width
    }

    /// w = r on the face. Returns the largest of it.
    pub(super) fn mask(&mut self, rows: &Range<usize>, scratch: &Scratch) -> f32 {
        let cells = self.cells(rows);
        let pieces = self.w[cells.clone()].chunks_mut(PIECE).zip(self.face[cells.clone()].chunks(PIECE));
        let largest = scratch.each(
            pieces.zip(self.r[cells].chunks(PIECE)),
            #[inline(always)]
            |((w, m), r)| masked(w, m, r),
        );
        largest.into_iter().fold(0.0, f32::max)
    }

    /// z, nearly the solution on the face for w. Returns z . ad.
    pub(super) fn solve_nearly(&mut self, near: &Near, rows: &Range<usize>, scratch: &mut Scratch) -> f64 {
        near.preconditioner.product(&self.w, rows.clone(), &mut self.z, rows.clone(), scratch);
        let cells = self.cells(rows);
        let pieces = self.z[cells.clone()].chunks_mut(PIECE).zip(self.face[cells.clone()].chunks(PIECE));
        let sums = scratch.each(
            pieces.zip(self.ad[cells].chunks(PIECE)),
            #[inline(always)]
            |((z, m), ad)| {
                z.iter_mut().zip(m).for_each(|(z, m)| *z *= m);
                dot(z, ad)
            },
        );
        sums.into_iter().sum()
    }

    /// flat, nearly the pressure of a flat punch on the face.
    pub(super) fn find_flat(&mut self, near: &Near, rows: &Range<usize>, scratch: &mut Scratch) {
        self.flat.resize(self.face.len(), 0.0);
        near.preconditioner.product(&self.face, rows.clone(), &mut self.flat, rows.clone(), scratch);
    }

    /// Sets flat to zero outside the face. Returns its sum and flat . r.
    pub(super) fn mask_flat(&mut self, rows: &Range<usize>, scratch: &Scratch) -> [f64; 2] {
        let cells = self.cells(rows);
        let pieces = self.flat[cells.clone()].chunks_mut(PIECE).zip(self.face[cells.clone()].chunks(PIECE));
        let sums = scratch.each(
            pieces.zip(self.r[cells].chunks(PIECE)),
            #[inline(always)]
            |((flat, m), r)| {
                flat.iter_mut().zip(m).for_each(|(flat, m)| *flat *= m);
                [sum(flat), dot(flat, r)]
            },
        );
        added(sums)
    }

    /// d = z + beta d on the face. Returns the sum of it.
    pub(super) fn turn(&mut self, beta: f32, rows: &Range<usize>, scratch: &Scratch) -> f64 {
        let cells = self.cells(rows);
        let pieces = self.d[cells.clone()].chunks_mut(PIECE).zip(self.z[cells.clone()].chunks(PIECE));
        let sums = scratch.each(
            pieces.zip(self.face[cells].chunks(PIECE)),
            #[inline(always)]
            |((d, z), m)| {
                for ((d, z), m) in d.iter_mut().zip(z).zip(m) {
                    *d = z + beta * m * *d;
                }
                sum(d)
            },
        );
        sums.into_iter().sum()
    }

    /// d = step z on the face, and what takes the pressure to zero elsewhere. Returns the sums of it and of p.
    pub(super) fn turn_out(&mut self, step: f32, rows: &Range<usize>, scratch: &Scratch) -> [f64; 2] {
        let cells = self.cells(rows);
        let pieces = self.d[cells.clone()].chunks_mut(PIECE).zip(self.z[cells.clone()].chunks(PIECE));
        let pieces = pieces.zip(self.face[cells.clone()].chunks(PIECE)).zip(self.p[cells].chunks(PIECE));
        added(scratch.each(
            pieces,
            #[inline(always)]
            |(((d, z), m), p)| {
                for (((d, z), m), p) in d.iter_mut().zip(z).zip(m).zip(p) {
                    *d = if *m > 0.0 { step * z } else { -*p as f32 };
                }
                [sum(d), p.iter().sum()]
            },
        ))
    }

    /// d += share flat.
    pub(super) fn share_out(&mut self, share: f32, rows: &Range<usize>, scratch: &Scratch) {
        let cells = self.cells(rows);
        let pieces = self.d[cells.clone()].chunks_mut(PIECE).zip(self.flat[cells].chunks(PIECE));
        scratch.each(
            pieces,
            #[inline(always)]
            |(d, flat)| d.iter_mut().zip(flat).for_each(|(d, flat)| *d += share * flat),
        );
    }

    /// ad = A d everywhere. Returns d . r and d . ad, and flat . ad under a load.
    pub(super) fn displace(&mut self, near: &Near, rows: &Range<usize>, scratch: &mut Scratch) -> [f64; 3] {
        let height = self.d.len() / self.width;
        near.single.product(&self.d, rows.clone(), &mut self.ad, 0..height, scratch);
        let cells = self.cells(rows);
        let pieces = self.d[cells.clone()].chunks(PIECE).zip(self.r[cells.clone()].chunks(PIECE));
        let pieces = pieces.zip(self.ad[cells.clone()].chunks(PIECE));
        let [dr, dad] = added(scratch.each(
            pieces,
            #[inline(always)]
            |((d, r), ad)| [dot(d, r), dot(d, ad)],
        ));
        if self.flat.is_empty() {
            return [dr, dad, 0.0];
        }
        let pieces = self.flat[cells.clone()].chunks(PIECE).zip(self.ad[cells].chunks(PIECE));
        [
            dr,
            dad,
            scratch
                .each(
                    pieces,
                    #[inline(always)]
                    |(flat, ad)| dot(flat, ad),
                )
                .into_iter()
                .sum(),
        ]
    }

    /// p += alpha d, zero outside the face if `clear`, and r follows, larger by `deeper` everywhere. Returns the largest of it on the
    /// face, where w is it.
    pub(super) fn advance(
        &mut self,
        [alpha, deeper]: [f64; 2],
        clear: bool,
        rows: &Range<usize>,
        scratch: &Scratch,
    ) -> f32 {
        let cells = self.cells(rows);
        let pieces = self.p[cells.clone()].chunks_mut(PIECE).zip(self.d[cells.clone()].chunks(PIECE));
        let pieces = pieces.zip(self.face[cells.clone()].chunks(PIECE));
        let (a, by) = (alpha as f32, deeper as f32);
        let follow = |r: &mut [f32], ad: &[f32]| r.iter_mut().zip(ad).for_each(|(r, ad)| *r += by - a * ad);
        // Outside these rows nothing but the residual is there.
        for rows in [0..cells.start, cells.end..self.r.len()] {
            follow(&mut self.r[rows.clone()], &self.ad[rows]);
        }
        let pieces = pieces.zip(self.r[cells.clone()].chunks_mut(PIECE).zip(self.ad[cells.clone()].chunks(PIECE)));
        let largest = scratch.each(
            pieces.zip(self.w[cells].chunks_mut(PIECE)),
            #[inline(always)]
            |((((p, d), m), (r, ad)), w)| {
                p.iter_mut().zip(d).for_each(|(p, d)| *p += alpha * f64::from(*d));
                if clear {
                    // p - p, to the last bit.
                    p.iter_mut().zip(m).for_each(|(p, m)| *p *= f64::from(*m));
                }
                follow(r, ad);
                masked(w, m, r)
            },
        );
        largest.into_iter().fold(0.0, f32::max)
    }

    /// r is larger by as much everywhere.
    pub(super) fn deepen(&mut self, by: f64, scratch: &Scratch) {
        scratch.each(
            self.r.chunks_mut(PIECE),
            #[inline(always)]
            |r| r.iter_mut().for_each(|r| *r += by as f32),
        );
    }

    /// The new face: cells under pressure stay, others that overlap enter where pressure and residual are positive together, the
    /// residual worth it. `deeper`: what the overlap is larger by.
    pub(super) fn look(&mut self, deeper: f64, worth: f32, scratch: &Scratch) -> Look {
        let pieces = self.face.chunks_mut(PIECE).zip(self.p.chunks(PIECE));
        let pieces = pieces.zip(self.r.chunks(PIECE).zip(self.f.chunks(PIECE)));
        let deeper = deeper as f32;
        let looks = scratch.each(
            pieces.enumerate(),
            #[inline(always)]
            |(piece, ((face, p), (r, f)))| {
                let mut lanes = Lanes::default();
                let ((faces, rest), (ps, rest_p)) = (face.as_chunks_mut::<LANES>(), p.as_chunks::<LANES>());
                let ((rs, rest_r), (fs, rest_f)) = (r.as_chunks::<LANES>(), f.as_chunks::<LANES>());
                for (((face, p), r), f) in faces.iter_mut().zip(ps).zip(rs).zip(fs) {
                    lanes.look(face, p, r, f, [deeper, worth]);
                }
                lanes.look(rest, rest_p, rest_r, rest_f, [deeper, worth]);
                let (mut look, leaving) = lanes.together();
                if leaving {
                    let cells = face.iter().zip(p).enumerate().filter(|(_, (m, p))| **m == 0.0 && **p != 0.0);
                    look.leaving.extend(cells.map(|(k, _)| piece * PIECE + k));
                }
                look
            },
        );
        looks.into_iter().fold(Look::default(), |mut all, look| {
            all.add(look);
            all
        })
    }
}

/// What [`Fields::look`] has seen.
#[derive(Debug, Default)]
pub(super) struct Look {
    /// How far the state is from a solution; on the face alone.
    pub(super) worst: f32,
    pub(super) here: f32,
    /// How many cells joined or left the face, and are on it.
    pub(super) changed: usize,
    pub(super) inside: usize,
    /// Cells off it that carry pressure still.
    pub(super) leaving: Vec<usize>,
}

impl Look {
    fn add(&mut self, mut other: Self) {
        self.worst = larger(self.worst, other.worst);
        self.here = larger(self.here, other.here);
        self.changed += other.changed;
        self.inside += other.inside;
        self.leaving.append(&mut other.leaving);
    }
}

/// The same of cells side by side.
#[derive(Default)]
struct Lanes {
    sizes: [[f32; LANES]; 2],
    counts: [[u32; LANES]; 3],
}

impl Lanes {
    #[inline(always)]
    fn look(&mut self, face: &mut [f32], p: &[f64], r: &[f32], f: &[f32], [deeper, worth]: [f32; 2]) {
        let Self { sizes: [worst, here], counts: [changed, inside, leaving] } = self;
        let sizes = worst.iter_mut().zip(here);
        let counts = changed.iter_mut().zip(inside).zip(leaving);
        let cells = face.iter_mut().zip(p).zip(r.iter().zip(f));
        for ((((m, p), (r, f)), (worst, here)), ((changed, inside), leaving)) in cells.zip(sizes).zip(counts) {
            let (p, on) = (*p as f32, *m > 0.0);
            let pressed = p > 0.0;
            let enters = (p + r > 0.0) & (pressed | (*r > worth));
            let is = (f + deeper > 0.0) & ((on & pressed) | (!on & enters));
            let size = r.abs();
            let off = if is { size } else { larger(*r, p.abs()) };
            *worst = larger(off, *worst);
            *here = larger(if is { size } else { 0.0 }, *here);
            *changed += u32::from(is != on);
            *inside += u32::from(is);
            *leaving += u32::from(!is & (p != 0.0));
            *m = if is { 1.0 } else { 0.0 };
        }
    }

    /// And whether cells leave, which are not listed yet.
    fn together(&self) -> (Look, bool) {
        let [worst, here] = self.sizes.map(|sizes| sizes.into_iter().fold(0.0, larger));
        let [changed, inside, leaving] = self.counts.map(|counts| counts.into_iter().sum::<u32>() as usize);
        (Look { worst, here, changed, inside, leaving: Vec::new() }, leaving > 0)
    }
}

/// The first where neither is larger.
#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if b > a { b } else { a }
}

fn added<const N: usize>(sums: Vec<[f64; N]>) -> [f64; N] {
    sums.into_iter().fold([0.0; N], |mut all, sums| {
        all.iter_mut().zip(sums).for_each(|(all, sum)| *all += sum);
        all
    })
}

/// w = m r. Returns the largest |w|.
#[inline(always)]
fn masked(w: &mut [f32], m: &[f32], r: &[f32]) -> f32 {
    let mut most = [0.0_f32; LANES];
    let ((ws, w), (ms, m), (rs, r)) = (w.as_chunks_mut::<LANES>(), m.as_chunks::<LANES>(), r.as_chunks::<LANES>());
    let each = |most: &mut f32, w: &mut f32, m: f32, r: f32| {
        *w = m * r;
        *most = larger(*most, w.abs());
    };
    for ((w, m), r) in ws.iter_mut().zip(ms).zip(rs) {
        for (((most, w), m), r) in most.iter_mut().zip(w).zip(m).zip(r) {
            each(most, w, *m, *r);
        }
    }
    for (((most, w), m), r) in most.iter_mut().zip(w).zip(m).zip(r) {
        each(most, w, *m, *r);
    }
    most.iter().fold(0.0, |a, b| a.max(*b))
}

/// a . b: short sums side by side in single precision, summed in double.
#[inline(always)]
fn dot(a: &[f32], b: &[f32]) -> f64 {
    let piece = |a: &[f32], b: &[f32]| {
        let mut sums = [0.0_f32; LANES];
        let ((many, a), (others, b)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
        for (a, b) in many.iter().zip(others) {
            sums.iter_mut().zip(a).zip(b).for_each(|((sum, a), b)| *sum += a * b);
        }
        sums.iter_mut().zip(a).zip(b).for_each(|((sum, a), b)| *sum += a * b);
        sums.iter().map(|s| f64::from(*s)).sum::<f64>()
    };
    a.chunks(512).zip(b.chunks(512)).map(|(a, b)| piece(a, b)).sum()
}

/// Of all numbers, as [`dot`].
#[inline(always)]
fn sum(numbers: &[f32]) -> f64 {
    let piece = |numbers: &[f32]| {
        let mut sums = [0.0_f32; LANES];
        let (many, rest) = numbers.as_chunks::<LANES>();
        many.iter().for_each(|many| sums.iter_mut().zip(many).for_each(|(sum, number)| *sum += number));
        sums.iter_mut().zip(rest).for_each(|(sum, number)| *sum += number);
        sums.iter().map(|s| f64::from(*s)).sum::<f64>()
    };
    numbers.chunks(512).map(piece).sum()
}

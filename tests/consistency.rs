//! Facts about a gap that are false, told to the program by its caller: what comes of them breaks a law that every contact obeys, and is
//! not called solved.

use contact_patch::gap::{AnyGap, Declared, Known, Minimum, Paraboloid, Place, Reach};
use contact_patch::geometry::Rect;
use contact_patch::{
    Contact, EffectiveModulus, ErrorBar, Gap, Loading, Origin, Settings, Solution, Unsolved, Verdict, solve,
};

fn answer(gap: AnyGap, depth: f64, settings: &Settings) -> Result<Solution, Unsolved> {
    let contact = Contact::new(EffectiveModulus::from_e_star(1.0).unwrap(), gap, Loading::depth(depth)).unwrap();
    solve(&contact, settings).remove(0)
}

fn assert_stopped(answer: Result<Solution, Unsolved>) {
    match answer {
        Ok(state) => panic!("solved: {:e}, stated {:?}", state.force, state.force_error),
        Err(unsolved) => assert_eq!(unsolved.verdict, Verdict::Inconsistent, "{unsolved:?}"),
    }
}

/// g inside a rectangle, no material outside.
fn clipped(g: fn(f64) -> f64, half: [f64; 2]) -> impl Fn(f64, f64) -> f64 + Clone + Send + Sync + 'static {
    move |x: f64, y: f64| if x.abs() <= half[0] && y.abs() <= half[1] { g(x) } else { f64::INFINITY }
}

#[test]
fn a_law_of_similarity_that_an_edge_cuts() {
    let parabola = |x: f64| 0.5 * x * x;
    for (g, degree, depth) in [(parabola as fn(f64) -> f64, 2.0, 1e-3), (f64::abs, 1.0, 1e-2)] {
        let g = clipped(g, [0.5, 1.0]);
        for evidence in [ErrorBar::Proof, ErrorBar::Estimate] {
            let settings = Settings { evidence, ..Settings::default() };
            // Nothing told, nothing broken.
            let honest = answer(Declared::new(g.clone()).into_any(), depth, &settings);
            assert!(honest.as_ref().map_or_else(|e| e.best.is_some(), |_| true), "{honest:?}");
            assert_stopped(answer(Declared::new(g.clone()).homogeneous(degree).into_any(), depth, &settings));
        }
    }
}

/// A gap that vouches for an end of its overlap.
#[derive(Clone)]
struct Told<G> {
    gap: G,
    end: Rect,
    pieces: Option<Vec<Rect>>,
    /// A value that the gap is nowhere below in a rectangle.
    lower: fn(&Rect) -> Option<f64>,
}

impl<G: Fn(f64, f64) -> f64 + Send + Sync> Gap for Told<G> {
    fn gap(&self, x: f64, y: f64) -> f64 {
        (self.gap)(x, y)
    }

    fn describe(&self) -> Known {
        Known { floor: 0.0, ..Known::nothing() }
    }

    fn reach(&self, _depth: f64) -> Reach {
        Reach::Within(self.end)
    }

    fn bounds(&self, rect: &Rect, slope: [f64; 2]) -> Option<[f64; 2]> {
        (self.lower)(rect).filter(|_| slope == [0.0; 2]).map(|lower| [lower, f64::INFINITY])
    }

    fn components(&self, _depth: f64) -> Option<Vec<Rect>> {
        self.pieces.clone()
    }
}

#[test]
fn an_overflow_that_is_taken_for_the_end_of_the_material() {
    let ceiling = |x: f64, y: f64| (x * x + y * y) / (1.0 + (x * x + y * y));
    // Numbers at the first are beyond their range, too: no answer in any case.
    let end = Rect::around([0.0; 2], [1e154; 2]);
    assert!(
        answer(Told { gap: ceiling, end, pieces: None, lower: |_| None }.into_any(), 1.2, &Settings::default())
            .is_err()
    );
    for half in [1e10, 30.0] {
        let end = Rect::around([0.0; 2], [half; 2]);
        assert_stopped(answer(
            Told { gap: ceiling, end, pieces: None, lower: |_| None }.into_any(),
            1.2,
            &Settings::default(),
        ));
    }
}

const TIPS: [[f64; 2]; 6] = [[0.0, 0.0], [30.0, 4.0], [-20.0, 25.0], [8.0, -31.0], [-33.0, -12.0], [25.0, 30.0]];

fn tips(x: f64, y: f64) -> f64 {
    TIPS.iter().map(|[a, b]| 0.5 * ((x - a).powi(2) + (y - b).powi(2))).fold(f64::INFINITY, f64::min)
}

fn lowest_tip(rect: &Rect) -> Option<f64> {
    let nearest = |m: usize, c: f64| c.clamp(rect.min[m], rect.max[m]) - c;
    TIPS.iter().map(|&[a, b]| 0.5 * (nearest(0, a).powi(2) + nearest(1, b).powi(2))).reduce(f64::min)
}

#[test]
fn tips_that_were_lost() {
    let all: Vec<Rect> = TIPS.iter().map(|&p| Rect::around(p, [1.5; 2])).collect();
    let hull = |pieces: &[Rect]| pieces.iter().copied().reduce(|a, b| a.union(&b)).unwrap();
    let told = |pieces: &[Rect]| {
        Told { gap: tips, end: hull(pieces), pieces: Some(pieces.to_vec()), lower: lowest_tip }.into_any()
    };
    let six = answer(told(&all), 0.5, &Settings::default()).unwrap();
    assert!(six.patch.regions == 6);
    assert_stopped(answer(told(&all[..3]), 0.5, &Settings::default()));
}

#[test]
fn tips_beside_one_another_are_not_taken_for_lost_ones() {
    let places = || (0..9).map(|k| [4.5 * f64::from(k % 3), 4.5 * f64::from(k / 3)]);
    let ball = Paraboloid::new([1.0, 1.0]).unwrap();
    let balls = Minimum::new(places().map(|at| ball.placed(at, 0.0).unwrap()).collect()).unwrap();
    let state = answer(balls.into_any(), 0.5, &Settings::default()).unwrap();
    assert_eq!(state.origin, Origin::SeparateContacts { count: 9 });
    // One ball alone carries more than a ninth: each takes depth from the others.
    let alone = answer(ball.into_any(), 0.5, &Settings::default()).unwrap();
    assert!(state.force < 9.0 * alone.force && state.force > 5.0 * alone.force);
    assert_eq!(state.patch.regions, 9);
}

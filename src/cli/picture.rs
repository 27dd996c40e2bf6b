//! The picture of `contact-patch solve`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::error::InputError;
use crate::overlap::least;
use crate::plot::{self, Format, Outline, Section};
use crate::problem::{Contact, Load, Loading};
use crate::report;
use crate::report::error_by_cells::error_by_cells;
use crate::report::pictured::pictured;
use crate::scene::Scene;
use crate::solution::Solution;
use crate::units::UnitLabels;

#[derive(Args)]
pub(super) struct Picture {
    /// Draw the pressure and the boundary of the patch; of several states, force against depth
    #[arg(long, value_name = "FILE.svg|.png")]
    pub plot: Option<PathBuf>,
    /// What to draw
    #[arg(long, value_enum, value_name = "KIND", requires = "plot")]
    plot_kind: Option<PlotKind>,
}

/// Pictures of a state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum PlotKind {
    /// The pressure over the patch
    Pressure,
    /// The pressure as a surface
    Surface,
    /// The gap that is left around the patch
    Gap,
    /// Both bodies and the pressure along a line
    Section,
    /// Where the error sits: the share of each cell in the proved bounds of the energy
    Error,
    /// The boundary of the patch
    Patch,
    /// The separate regions of the patch, with their share of the force
    Pieces,
    /// Force against depth: the states, and the law between them
    Curve,
}

impl Picture {
    /// The format of the picture, where there is to be one; asks the scene for what it shows.
    ///
    /// # Errors
    /// Names `--plot` when its format is not known, `--plot-kind` when the scene cannot have it.
    pub fn asked_of(&self, scene: &mut Scene) -> Result<Option<Format>, InputError> {
        let format = self.plot.as_deref().map(Format::of).transpose().map_err(|e| e.within("--plot"))?;
        if format.is_some() {
            self.ask(scene)?;
        }
        Ok(format)
    }

    /// What is drawn of this scene.
    fn kind(&self, scene: &Scene) -> PlotKind {
        let single = matches!(scene.contact.loading(), Loading::Single(_));
        self.plot_kind.unwrap_or(if single { PlotKind::Pressure } else { PlotKind::Curve })
    }

    fn ask(&self, scene: &mut Scene) -> Result<(), InputError> {
        let kind = self.kind(scene);
        if kind == PlotKind::Curve {
            return Ok(());
        }
        let refused = |given: &str, allowed: &str| Err(InputError::new("--plot-kind", given, allowed));
        if matches!(scene.contact.loading(), Loading::Steps(_)) {
            return refused("a picture of one state for a list of loads", "curve, or one state of loading");
        }
        let of_field =
            matches!(kind, PlotKind::Surface | PlotKind::Gap | PlotKind::Section | PlotKind::Error | PlotKind::Pieces);
        if scene.settings.method.is_approximate() && of_field {
            return refused(scene.settings.method.name(), "a method with a pressure field: closed_form, qp or fft");
        }
        let outputs = &mut scene.settings.outputs;
        outputs.patch = true;
        outputs.pressure |= kind != PlotKind::Patch;
        Ok(())
    }

    /// The picture of one state, or the force of several; nothing when none was solved or the bodies do not touch.
    pub fn draw(&self, scene: &Scene, steps: &[report::Step], format: Format) -> Result<Option<Vec<u8>>, plot::Error> {
        let title = scene.name.as_deref().unwrap_or("");
        let units = &scene.units.clone().unwrap_or_else(UnitLabels::kinds);
        let solution = steps.last().and_then(report::numbers);
        let picture = match (self.kind(scene), solution) {
            (PlotKind::Curve, _) => {
                let of = |s: &Solution| [s.depth, s.force, s.stiffness];
                let states: Vec<[f64; 3]> = steps.iter().filter_map(report::numbers).map(of).collect();
                let loads = scene.contact.loading().loads();
                let upright = loads.iter().all(|load| matches!(load, Load::Depth(_) | Load::Force(_)));
                let touch = upright.then(|| least(scene.contact.gap()).1);
                plot::states_in(units, title, &states, touch.filter(|t| t.is_finite()), format)
            }
            (_, None) => return Ok(None),
            (PlotKind::Patch, Some(s)) => {
                let loops = s.patch.boundary.clone().unwrap_or_default();
                plot::outlines_in(units, title, &[Outline { label: "patch".to_owned(), loops }], format)
            }
            (PlotKind::Pieces, Some(s)) => plot::outlines_in(units, title, &pieces(s), format),
            (kind, Some(s)) => {
                let gap = kind == PlotKind::Gap;
                // Without a grid to draw from, what the answer itself has.
                let on_grid =
                    (!s.method.is_approximate()).then(|| pictured(&scene.contact, s, &scene.settings, gap).ok());
                let drawn = on_grid.flatten().unwrap_or_else(|| s.clone());
                of_field(&scene.contact, &drawn, kind, (units, title, format))
            }
        };
        match picture {
            Err(plot::Error::Empty(_)) => Ok(None),
            drawn => drawn.map(Some),
        }
    }
}

/// A picture of the fields of a state.
fn of_field(
    contact: &Contact,
    drawn: &Solution,
    kind: PlotKind,
    (units, title, format): (&UnitLabels, &str, Format),
) -> Result<Vec<u8>, plot::Error> {
    match kind {
        PlotKind::Surface => plot::surface_in(units, title, drawn, format),
        PlotKind::Gap => plot::gap_map_in(units, title, drawn, format),
        PlotKind::Section => {
            let section = Section::through(contact, drawn).ok_or(plot::Error::Empty("there is no field"))?;
            plot::section_in(units, title, &section, format)
        }
        PlotKind::Error => {
            let why = "no bounds of the energy by cells are known for this contact: another --plot-kind";
            let shares = error_by_cells(contact, drawn).ok_or_else(|| plot::Error::Drawing(why.to_owned()))?;
            let boundary = drawn.patch.boundary.as_deref().unwrap_or_default();
            plot::error_map_in(units, title, boundary, &shares, format)
        }
        _ => plot::pressure_map_in(units, title, drawn, format),
    }
}

/// Pieces that a picture tells apart; the rest has one colour.
const PIECES: usize = 5;

/// The boundary by pieces: every loop belongs to the smallest piece that it lies in.
fn pieces(solution: &Solution) -> Vec<Outline> {
    let pieces = &solution.patch.pieces;
    let share = |force: f64| format!("{:.3} % of the force", 100.0 * force / solution.force);
    let mut outlines: Vec<Outline> = pieces
        .iter()
        .take(PIECES)
        .enumerate()
        .map(|(k, piece)| Outline { label: format!("piece {}: {}", k + 1, share(piece.force)), loops: Vec::new() })
        .collect();
    if pieces.len() > PIECES {
        let rest = pieces[PIECES..].iter().map(|piece| piece.force).sum();
        outlines.push(Outline { label: format!("{} more: {}", pieces.len() - PIECES, share(rest)), loops: Vec::new() });
    }
    for points in solution.patch.boundary.iter().flatten() {
        let count = points.len().max(1) as f64;
        let middle = [0, 1].map(|m| points.iter().map(|p| p[m]).sum::<f64>() / count);
        // How far the middle lies outside, then how large the piece is.
        let fit = |[low, high]: [[f64; 2]; 2]| {
            let outside: f64 = (0..2).map(|m| (low[m] - middle[m]).max(middle[m] - high[m]).max(0.0)).sum();
            (outside, (high[0] - low[0]) * (high[1] - low[1]))
        };
        let fits = pieces.iter().enumerate().map(|(k, piece)| (fit(piece.extent), k));
        let nearest = fits.min_by(|p, q| p.0.0.total_cmp(&q.0.0).then(p.0.1.total_cmp(&q.0.1)));
        let of = nearest.map_or(0, |(_, k)| k.min(PIECES));
        if let Some(outline) = outlines.get_mut(of) {
            outline.loops.push(points.clone());
        }
    }
    outlines
}

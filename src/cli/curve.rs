//! `contact-patch curve`

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, ValueEnum};

use super::outputs::outputs;
use super::{Failure, Overrides, inputs, scene};
use crate::curve::Curve;
use crate::error::InputError;
use crate::overlap::least;
use crate::plot;
use crate::problem::Load;
use crate::scene::Scene;
use crate::solution::Unsolved;
use crate::units::UnitLabels;

/// Steps in a file that asks for none.
const STEPS: usize = 200;

/// Most steps in a file.
const MOST_STEPS: usize = 1_000_000;

/// Force, stiffness and patch area over a range of depths: the non-linear spring
///
/// The range ends at the largest depth of the scene's loading, or at the depth of its largest force.
#[derive(Args)]
pub(super) struct CurveCommand {
    /// Scene file; - reads standard input
    #[arg(value_name = "SCENE")]
    scene: PathBuf,
    #[command(flatten)]
    overrides: Overrides,
    /// Relative error of interpolation that is good enough
    #[arg(long, value_name = "E", default_value_t = 1e-4, allow_negative_numbers = true)]
    accuracy: f64,
    /// Equal steps of depth in the file
    #[arg(long, value_name = "N", default_value_t = STEPS)]
    steps: usize,
    /// What to write
    #[arg(long, value_enum, value_name = "FORMAT", default_value_t = Format::Csv)]
    format: Format,
    /// Where to write
    #[arg(short, long, value_name = "FILE", default_value = "-")]
    output: PathBuf,
    /// Draw force against depth, with the states that were solved
    #[arg(long, value_name = "FILE.svg|.png")]
    plot: Option<PathBuf>,
    /// Name in the C header, number of the Adams spline is 1
    #[arg(long, value_name = "NAME", default_value = "contact")]
    name: String,
}

/// Forms of a curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Comma-separated values
    Csv,
    /// Knots, solved states, power law, error
    Json,
    /// Two columns, depth and force
    Text,
    /// SPLINE statement of an Adams data set
    Adams,
    /// C header with table and evaluator
    C,
}

impl CurveCommand {
    pub(super) fn run(&self) -> Result<ExitCode, Failure> {
        let mut scene = scene(&self.scene)?;
        let wrong = |e: &InputError| Failure::wrong("arguments", e);
        self.overrides.apply(&mut scene.settings).map_err(|e| wrong(&e))?;
        if !(2..=MOST_STEPS).contains(&self.steps) {
            let allowed = format!("a whole number from 2 to {MOST_STEPS}");
            return Err(wrong(&InputError::new("--steps", self.steps, allowed)));
        }
        if !(self.accuracy > 0.0 && self.accuracy < 1.0) {
            let allowed = "a number greater than 0 and less than 1";
            return Err(wrong(&InputError::new("--accuracy", self.accuracy, allowed)));
        }
        let format = self.plot.as_deref().map(plot::Format::of).transpose().map_err(|e| wrong(&e.within("--plot")))?;
        let options = [("--output", Some(self.output.as_path())), ("--plot", self.plot.as_deref())];
        let [table, picture] = outputs(options, &inputs(&self.scene, &scene))?;
        let curve = match self.curve(&scene).map_err(|e| Failure::wrong("scene", &e))? {
            Ok(curve) => curve,
            Err(unsolved) => {
                eprintln!("{unsolved}");
                return Ok(ExitCode::from(1));
            }
        };
        if curve.interpolation_error() > self.accuracy {
            // A closed stderr does not make the curve worse.
            let said = curve.interpolation_error();
            let _ = writeln!(
                std::io::stderr().lock(),
                "note: estimated error of the force {said:.1e}, more than the accuracy asked for, {:.1e}",
                self.accuracy
            );
        }
        let text = match self.format {
            Format::Csv => curve.csv_in(scene.units.as_ref(), self.steps),
            Format::Json => curve.json(),
            Format::Text => curve.two_columns(self.steps),
            Format::Adams => curve.adams_in(scene.units.as_ref(), self.steps, 1),
            Format::C => curve.c_header_in(scene.units.as_ref(), &self.name),
        };
        if let (Some((path, target)), Some(format)) = (picture, format) {
            let units = scene.units.clone().unwrap_or_else(UnitLabels::kinds);
            let bytes = plot::curve_in(&units, scene.name.as_deref().unwrap_or(""), &curve, format)
                .map_err(|e| Failure::Message(format!("{}: {e}", path.display())))?;
            target.write(|to| to.write_all(&bytes)).map_err(|e| Failure::unwritable(path, &e))?;
        }
        if let Some((path, target)) = table {
            target.write(|to| to.write_all(text.as_bytes())).map_err(|e| Failure::unwritable(path, &e))?;
        }
        Ok(ExitCode::SUCCESS)
    }

    /// The curve up to the largest load of the scene.
    fn curve(&self, scene: &Scene) -> Result<Result<Curve, Unsolved>, InputError> {
        let mut deepest = f64::NEG_INFINITY;
        let mut strongest = 0.0f64;
        for load in scene.contact.loading().loads() {
            match *load {
                Load::Depth(depth) => deepest = deepest.max(depth),
                Load::Force(force) => strongest = strongest.max(force),
                Load::Tilted { .. } | Load::ForceMoment { .. } => {
                    return Err(InputError::new(
                        "loading",
                        "a tilt or a moment",
                        "depths or forces of a punch that does not tilt",
                    ));
                }
            }
        }
        if strongest > 0.0 {
            let contact = scene.contact.under(crate::problem::Loading::force(strongest));
            match crate::solve(&contact, &scene.settings).remove(0).or_else(Unsolved::accept_best) {
                Ok(solution) => deepest = deepest.max(solution.depth),
                Err(unsolved) => return Ok(Err(unsolved)),
            }
        }
        if !(deepest > least(scene.contact.gap()).1) {
            return Err(InputError::new("loading", deepest, "a depth beyond first touch or a force greater than 0"));
        }
        Ok(Curve::up_to(&scene.contact, &scene.settings, deepest, self.accuracy))
    }
}

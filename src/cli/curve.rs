//! `contact-patch curve`

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, ValueEnum};

use super::outputs::outputs;
use super::voice::Voice;
use super::{Failure, Threads, fmu, inputs, scene};
use crate::curve::{About, Beyond, Curve};
use crate::error::InputError;
use crate::plot;
use crate::problem::Settings;
use crate::scene::{Scene, SolveOptions};
use crate::solution::Unsolved;
use crate::units::UnitLabels;

/// Steps in a file that asks for none.
const STEPS: usize = 200;

/// Most steps in a file.
const MOST_STEPS: usize = 1_000_000;

/// Force, stiffness and patch area over a range of depths: the non-linear spring
///
/// The range ends at the largest depth of the scene's loading, or at the depth of its largest force. A line on standard error says how
/// many states were solved and how good the curve is.
#[derive(Args)]
pub(super) struct CurveCommand {
    /// Scene file; - reads standard input
    #[arg(value_name = "SCENE")]
    scene: PathBuf,
    #[command(flatten)]
    options: SolveOptions,
    /// Relative error of the force that is good enough between the states; that of the stiffness is about ten times as large
    #[arg(long, value_name = "E", default_value_t = 1e-4, allow_negative_numbers = true)]
    accuracy: f64,
    /// Smallest depth at which a state is solved; unless said, that at a two-hundredth of the range, and for a measured gap none where
    /// the force is that of its noise. Shallower forces follow the power law there
    #[arg(long, value_name = "DEPTH", allow_negative_numbers = true)]
    from: Option<f64>,
    /// What the curve says beyond its largest depth (C header, FMU)
    #[arg(long, value_enum, value_name = "LAW", default_value_t = BeyondName::Power)]
    beyond: BeyondName,
    #[command(flatten)]
    threads: Threads,
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
    /// Name in the C header and of the FMU; number of the Adams spline is 1
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
    /// Functional mock-up unit, FMI 2.0: model exchange and co-simulation, with sources, and with a binary where a C compiler (CC, else
    /// cc) is found
    Fmu,
}

/// Continuations beyond the largest depth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum BeyondName {
    /// The power law that continues force and stiffness
    Power,
    /// The tangent: the stiffness stays
    Tangent,
    /// Nothing: NaN
    Refuse,
}

impl From<BeyondName> for Beyond {
    fn from(name: BeyondName) -> Self {
        match name {
            BeyondName::Power => Self::Power,
            BeyondName::Tangent => Self::Tangent,
            BeyondName::Refuse => Self::Refuse,
        }
    }
}

impl CurveCommand {
    pub(super) fn run(&self, voice: Voice) -> Result<ExitCode, Failure> {
        let mut scene = scene(&self.scene)?;
        let wrong = |e: &InputError| Failure::wrong("arguments", e);
        self.options.apply("--", &mut scene.settings).map_err(|e| wrong(&e))?;
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
        let threads = self.threads.checked()?;
        let settings = Settings { threads, ..scene.settings };
        let place = |e: &InputError| if e.path == "--from" { "arguments" } else { "scene" };
        let curve = match self.curve(&scene, &settings, voice).map_err(|e| Failure::wrong(place(&e), &e))? {
            Ok(curve) => curve,
            Err(unsolved) => {
                eprintln!("{unsolved}");
                return Ok(ExitCode::from(1));
            }
        };
        let curve = curve.continued(self.beyond.into());
        voice.remark(&self.summary(&curve));
        let about = About { scene: scene.name.as_deref(), units: scene.units.as_ref() };
        let text = match self.format {
            Format::Csv => curve.csv_in(scene.units.as_ref(), self.steps),
            Format::Json => voice.json_text(curve.json_about(about))?,
            Format::Text => curve.two_columns(self.steps),
            Format::Adams => curve.adams_in(scene.units.as_ref(), self.steps, 1),
            Format::C => curve.c_header_about(about, &self.name),
            Format::Fmu => String::new(),
        };
        let bytes = if self.format == Format::Fmu { self.unit(&curve, about, voice)? } else { text.into_bytes() };
        if let (Some((path, target)), Some(format)) = (picture, format) {
            let units = scene.units.clone().unwrap_or_else(UnitLabels::kinds);
            let drawn = plot::curve_in(&units, scene.name.as_deref().unwrap_or(""), &curve, format)
                .map_err(|e| Failure::Message(format!("{}: {e}", path.display())))?;
            target.write(|to| to.write_all(&drawn)).map_err(|e| Failure::unwritable(path, &e))?;
        }
        if let Some((path, target)) = table {
            target.write(|to| to.write_all(&bytes)).map_err(|e| Failure::unwritable(path, &e))?;
        }
        Ok(ExitCode::SUCCESS)
    }

    /// The functional mock-up unit; without a compiler its sources alone, and a line that says so.
    fn unit(&self, curve: &Curve, about: About, voice: Voice) -> Result<Vec<u8>, Failure> {
        let built = fmu::built(&curve.fmu_sources(about, &self.name));
        if let Err(why) = &built {
            voice.remark(&format!("note: the unit has sources and no binary: {why}"));
        }
        curve
            .fmu(about, &self.name, built.as_ref().ok().map(fmu::Built::binary))
            .map_err(|e| Failure::Message(format!("the unit cannot be packed: {e}")))
    }

    /// One line: states, accuracy reached, power law.
    fn summary(&self, curve: &Curve) -> String {
        let law = curve.power_law();
        let states = match curve.solves() {
            1 => "1 state".to_owned(),
            n => format!("{n} states"),
        };
        let (force, stiffness) = (curve.interpolation_error(), curve.stiffness_error());
        let missed = if force > self.accuracy {
            format!(", {:.1} times the accuracy asked for", force / self.accuracy)
        } else {
            String::new()
        };
        let map = curve.map_error().map_or(String::new(), |open| {
            format!("; the samples of the gap leave another {open:.1e} of the force open")
        });
        let first = curve.samples().first().map_or(0.0, |s| s.depth);
        format!(
            "{states} solved from depth {first:.3e} to {:.3e}; estimated error of the force {force:.1e}{missed}, of the stiffness \
             {stiffness:.1e}{map}; force = {:.4e} overlap^{:.4} to {:.1e}",
            curve.deepest(),
            law.coefficient,
            law.exponent,
            law.error
        )
    }

    /// The curve up to the largest load of the scene.
    fn curve(&self, scene: &Scene, settings: &Settings, voice: Voice) -> Result<Result<Curve, Unsolved>, InputError> {
        let range = match Curve::range_of(&scene.contact, settings, self.from, self.accuracy) {
            Ok(Ok(range)) => range,
            Ok(Err(unsolved)) => return Ok(Err(unsolved)),
            Err(e) if e.path == "from" => return Err(InputError { path: "--from".to_owned(), ..e }),
            Err(e) => return Err(e),
        };
        let mut progress = voice.progress("the first states");
        let mut told = |states: usize, open: Option<f64>| match open {
            None => progress.say(&format!("states so far: {states}")),
            Some(open) => {
                progress.say(&format!("{states} states, error between them {open:.1e} of {:.1e}", self.accuracy))
            }
        };
        Ok(Curve::watched(&scene.contact, settings, range, &mut told))
    }
}

//! `contact-patch solve`

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;

use super::outputs::outputs;
use super::{Failure, Overrides, checked_threads, inputs, scene};
use crate::error::InputError;
use crate::plot::{self, Format};
use crate::problem::{Loading, Method};
use crate::report::write::Target;
use crate::report::{self, npy};
use crate::scene::Scene;
use crate::units::UnitLabels;

/// Solve a scene and print a short table
#[derive(Args)]
pub(super) struct Solve {
    /// Scene file; - reads standard input
    #[arg(value_name = "SCENE")]
    scene: PathBuf,
    #[command(flatten)]
    overrides: Overrides,
    /// Write the result as JSON; - prints it alone
    #[arg(short = 'o', long, visible_alias = "output", value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write a line a state of loading as CSV; - prints it alone
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Write the separate regions of the patch as CSV, a line a region: area, force, centroid, extent, largest pressure
    #[arg(long, value_name = "FILE.csv")]
    patches: Option<PathBuf>,
    /// Write the pressure field as NumPy array, [j, i] = cell (i, j); the JSON then names the file, unless "pressure" is in
    /// "output"
    #[arg(long, value_name = "FILE.npy")]
    field: Option<PathBuf>,
    /// Write the fields of pressure and gap for ParaView (VTK image data)
    #[arg(long, value_name = "FILE.vti")]
    vti: Option<PathBuf>,
    /// Bracket the force from below and above
    #[arg(long)]
    bracket: bool,
    /// Draw the pressure and the boundary of the patch; of several states, force against depth
    #[arg(long, value_name = "FILE.svg|.png")]
    plot: Option<PathBuf>,
    /// Threads to use; by default all cores
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
}

impl Solve {
    pub(super) fn run(&self) -> Result<ExitCode, Failure> {
        let mut scene = scene(&self.scene)?;
        let wrong = |e: &InputError| Failure::wrong("arguments", e);
        self.overrides.apply(&mut scene.settings).map_err(|e| wrong(&e))?;
        scene.settings.threads = checked_threads("--threads", self.threads)?;
        scene.settings.outputs.bracket |= self.bracket;
        // A field that is only asked for as an array is not written out as text too.
        let apart =
            self.field.as_deref().filter(|_| !scene.settings.outputs.pressure).map(|path| self.beside_json(path));
        let asked = scene.settings.outputs;
        for (option, _) in [("--field", &self.field), ("--vti", &self.vti)].iter().filter(|(_, file)| file.is_some()) {
            if matches!(scene.contact.loading(), Loading::Steps(_)) {
                let given = "a file for a list of loads";
                return Err(wrong(&InputError::new(*option, given, "one state of loading")));
            }
            if matches!(scene.settings.method, Method::Ritz | Method::Fabrikant) {
                let allowed = "a method with a pressure field: closed_form, qp or fft";
                return Err(wrong(&InputError::new(*option, scene.settings.method.name(), allowed)));
            }
            scene.settings.outputs.pressure = true;
            scene.settings.outputs.gap |= self.vti.is_some();
        }
        let format = self.plot.as_deref().map(Format::of).transpose().map_err(|e| wrong(&e.within("--plot")))?;
        if format.is_some() && matches!(scene.contact.loading(), Loading::Single(_)) {
            scene.settings.outputs.pressure = true;
            scene.settings.outputs.patch = true;
        }
        let [json, csv, field, vti, picture, patches] = outputs(
            [
                ("--json", self.json.as_deref()),
                ("--csv", self.csv.as_deref()),
                ("--field", self.field.as_deref()),
                ("--vti", self.vti.as_deref()),
                ("--plot", self.plot.as_deref()),
                ("--patches", self.patches.as_deref()),
            ],
            &inputs(&self.scene, &scene),
        )?;
        let mut steps = crate::solve(&scene.contact, &scene.settings);
        if let (Some((path, target)), Some(format)) = (picture, format) {
            draw(&scene, &steps, path, &target, format)?;
        }
        if let Some((path, target)) = vti {
            // Without contact there is no field.
            if let Some(solution) = steps.first().and_then(report::numbers).filter(|s| s.pressure.field.is_some()) {
                write(path, &target, |to| report::vti_of(to, solution).map(|_| ()))?;
            }
        }
        // What was computed for a file alone is not part of the result.
        let states = steps.iter_mut().filter_map(|step| match step {
            Ok(solution) => Some(solution),
            Err(unsolved) => unsolved.best.as_deref_mut(),
        });
        for solution in states {
            if !asked.patch {
                solution.patch.boundary = None;
            }
            if !asked.gap {
                solution.pressure.gap = None;
            }
            if !asked.pressure && self.field.is_none() {
                solution.pressure.field = None;
            }
        }
        if let Some((path, target)) = json {
            let outcome = report::json(&scene, &steps);
            let outcome = if let Some(file) = &apart { outcome.with_field_in(file) } else { outcome };
            write(path, &target, |to| {
                serde_json::to_writer(&mut *to, &outcome)?;
                to.write_all(b"\n")
            })?;
        }
        if let Some((path, target)) = csv {
            write(path, &target, |to| to.write_all(report::csv_in(scene.units.as_ref(), &steps).as_bytes()))?;
        }
        if let Some((path, target)) = patches {
            write(path, &target, |to| to.write_all(report::pieces_csv(scene.units.as_ref(), &steps).as_bytes()))?;
        }
        if let Some((path, target)) = field {
            // Without a state the verdict says why there is no field; without contact there is none.
            let field = steps.first().and_then(report::numbers).and_then(|s| s.pressure.field.as_ref());
            if let Some(field) = field {
                write(path, &target, |to| npy::write(to, field.grid.shape, &field.values))?;
            }
        }
        if ![&self.json, &self.csv, &self.patches].into_iter().flatten().any(|p| p.as_os_str() == "-") {
            Target::Stdout.write(|to| to.write_all(report::table(&scene, &steps).as_bytes()))?;
        }
        Ok(if steps.iter().all(Result::is_ok) { ExitCode::SUCCESS } else { ExitCode::from(1) })
    }

    /// What the JSON calls a file: its name when both stand in one directory.
    fn beside_json(&self, path: &Path) -> String {
        let together = self.json.as_deref().is_some_and(|json| json.parent() == path.parent());
        let name = path.file_name().filter(|_| together).map(PathBuf::from);
        let whole = || std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        name.unwrap_or_else(whole).display().to_string()
    }
}

/// The pressure of one state, or the force of several; nothing when none was solved or the bodies do not touch.
fn draw(scene: &Scene, steps: &[report::Step], path: &Path, target: &Target, format: Format) -> Result<(), Failure> {
    let title = scene.name.as_deref().unwrap_or("");
    let units = scene.units.clone().unwrap_or_else(UnitLabels::kinds);
    let picture = match (scene.contact.loading(), steps) {
        (Loading::Single(_), [step]) => match report::numbers(step) {
            Some(solution) => plot::pressure_map_in(&units, title, solution, format),
            None => return Ok(()),
        },
        _ => {
            let points: Vec<[f64; 2]> = steps.iter().filter_map(report::numbers).map(|s| [s.depth, s.force]).collect();
            plot::force_depth_in(&units, title, &points, &points, format)
        }
    };
    match picture {
        Ok(bytes) => write(path, target, |to| to.write_all(&bytes)),
        Err(plot::Error::Empty(_)) => Ok(()),
        Err(e) => Err(Failure::Message(format!("{}: {e}", path.display()))),
    }
}

fn write(
    path: &Path,
    target: &Target,
    fill: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> Result<(), Failure> {
    target.write(fill).map_err(|e| Failure::unwritable(path, &e))
}

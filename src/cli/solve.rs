//! `contact-patch solve`

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;

use super::outputs::outputs;
use super::picture::Picture;
use super::voice::Voice;
use super::{Failure, Threads, inputs, scene};
use crate::error::InputError;
use crate::problem::Loading;
use crate::report::write::Target;
use crate::report::{self, npy};
use crate::scene::SolveOptions;

/// Solve scenes and print a short table of each
#[derive(Args)]
pub(super) struct Solve {
    /// Scene files; - reads standard input. Of several the results are JSON lines, in order
    #[arg(value_name = "SCENE", required = true)]
    scenes: Vec<PathBuf>,
    #[command(flatten)]
    options: SolveOptions,
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
    #[command(flatten)]
    picture: Picture,
    #[command(flatten)]
    threads: Threads,
}

impl Solve {
    pub(super) fn run(&self, voice: Voice) -> Result<ExitCode, Failure> {
        match &self.scenes[..] {
            [scene] => self.one(scene, voice),
            scenes => self.several(scenes, voice),
        }
    }

    /// Every scene is read before the first is solved.
    fn several(&self, paths: &[PathBuf], voice: Voice) -> Result<ExitCode, Failure> {
        let wrong = |e: &InputError| Failure::wrong("arguments", e);
        let single = [
            ("--csv", &self.csv),
            ("--patches", &self.patches),
            ("--field", &self.field),
            ("--vti", &self.vti),
            ("--plot", &self.picture.plot),
        ];
        if let Some((option, _)) = single.iter().find(|(_, file)| file.is_some()) {
            return Err(wrong(&InputError::new(*option, format!("{} scenes", paths.len()), "one scene")));
        }
        if paths.iter().filter(|path| path.as_os_str() == "-").count() > 1 {
            return Err(wrong(&InputError::new("SCENE", "standard input twice", "once")));
        }
        let mut scenes = Vec::new();
        let mut read = Vec::new();
        for path in paths {
            let mut scene = scene(path)?;
            self.options.apply("--", &mut scene.settings).map_err(|e| wrong(&e))?;
            scene.settings.threads = self.threads.checked()?;
            scene.settings.outputs.bracket |= self.bracket;
            read.extend(inputs(path, &scene));
            scenes.push(scene);
        }
        let [json] = outputs([("--json", self.json.as_deref())], &read)?;
        let tables = self.json.as_deref().is_none_or(|path| path.as_os_str() != "-");
        let mut lines = Vec::new();
        let mut solved = true;
        for (k, scene) in scenes.iter().enumerate() {
            let what = scene.name.clone().unwrap_or_else(|| paths[k].display().to_string());
            let progress = voice.progress(&format!("{} of {}: {what}", k + 1, scenes.len()));
            let steps = crate::solve(&scene.contact, &scene.settings);
            drop(progress);
            solved &= steps.iter().all(Result::is_ok);
            if json.is_some() {
                voice.json(&mut lines, &report::json(scene, &steps))?;
            }
            if tables {
                let gap = if k == 0 { "" } else { "\n" };
                voice.table(&format!("{gap}{}", report::table(scene, &steps)), k == 0 && scene.name.is_some())?;
            }
        }
        if let Some((path, target)) = json {
            write(path, &target, |to| to.write_all(&lines))?;
        }
        Ok(if solved { ExitCode::SUCCESS } else { ExitCode::from(1) })
    }

    fn one(&self, path: &Path, voice: Voice) -> Result<ExitCode, Failure> {
        let mut scene = scene(path)?;
        let wrong = |e: &InputError| Failure::wrong("arguments", e);
        self.options.apply("--", &mut scene.settings).map_err(|e| wrong(&e))?;
        scene.settings.threads = self.threads.checked()?;
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
            if scene.settings.method.is_approximate() {
                let allowed = "a method with a pressure field: closed_form, qp or fft";
                return Err(wrong(&InputError::new(*option, scene.settings.method.name(), allowed)));
            }
            scene.settings.outputs.pressure = true;
            scene.settings.outputs.gap |= self.vti.is_some();
        }
        let format = self.picture.asked_of(&mut scene).map_err(|e| wrong(&e))?;
        let [json, csv, field, vti, picture, patches] = outputs(
            [
                ("--json", self.json.as_deref()),
                ("--csv", self.csv.as_deref()),
                ("--field", self.field.as_deref()),
                ("--vti", self.vti.as_deref()),
                ("--plot", self.picture.plot.as_deref()),
                ("--patches", self.patches.as_deref()),
            ],
            &inputs(path, &scene),
        )?;
        let progress = voice.progress(scene.name.as_deref().unwrap_or("solving"));
        let mut steps = crate::solve(&scene.contact, &scene.settings);
        drop(progress);
        if let (Some((path, target)), Some(format)) = (picture, format) {
            let drawn = self.picture.draw(&scene, &steps, format);
            let drawn = drawn.map_err(|e| Failure::Message(format!("{}: {e}", path.display())))?;
            drawn.map_or(Ok(()), |bytes| write(path, &target, |to| to.write_all(&bytes)))?;
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
            write(path, &target, |to| voice.json(to, &outcome))?;
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
            voice.table(&report::table(&scene, &steps), scene.name.is_some())?;
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

fn write(
    path: &Path,
    target: &Target,
    fill: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> Result<(), Failure> {
    target.write(fill).map_err(|e| Failure::unwritable(path, &e))
}

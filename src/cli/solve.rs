//! `contact-patch solve`

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, ValueEnum};

use super::outputs::outputs;
use super::voice::Voice;
use super::{Failure, Overrides, Threads, inputs, scene};
use crate::error::InputError;
use crate::overlap::least;
use crate::plot::{self, Format, Outline, Section};
use crate::problem::{Contact, Load, Loading};
use crate::report::error_by_cells::error_by_cells;
use crate::report::pictured::pictured;
use crate::report::write::Target;
use crate::report::{self, npy};
use crate::scene::Scene;
use crate::solution::Solution;
use crate::units::UnitLabels;

/// Solve scenes and print a short table of each
#[derive(Args)]
pub(super) struct Solve {
    /// Scene files; - reads standard input. Of several the results are JSON lines, in order
    #[arg(value_name = "SCENE", required = true)]
    scenes: Vec<PathBuf>,
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
    /// What to draw
    #[arg(long, value_enum, value_name = "KIND", requires = "plot")]
    plot_kind: Option<PlotKind>,
    #[command(flatten)]
    threads: Threads,
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
            ("--plot", &self.plot),
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
            self.overrides.apply(&mut scene.settings).map_err(|e| wrong(&e))?;
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
        self.overrides.apply(&mut scene.settings).map_err(|e| wrong(&e))?;
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
        let format = self.plot.as_deref().map(Format::of).transpose().map_err(|e| wrong(&e.within("--plot")))?;
        if format.is_some() {
            self.ask_for_picture(&mut scene).map_err(|e| wrong(&e))?;
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
            &inputs(path, &scene),
        )?;
        let progress = voice.progress(scene.name.as_deref().unwrap_or("solving"));
        let mut steps = crate::solve(&scene.contact, &scene.settings);
        drop(progress);
        if let (Some((path, target)), Some(format)) = (picture, format) {
            draw(&scene, &steps, self.kind(&scene), path, &target, format)?;
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

    /// What is drawn of this scene.
    fn kind(&self, scene: &Scene) -> PlotKind {
        let single = matches!(scene.contact.loading(), Loading::Single(_));
        self.plot_kind.unwrap_or(if single { PlotKind::Pressure } else { PlotKind::Curve })
    }

    /// Asks for what the picture shows.
    ///
    /// # Errors
    /// Names `--plot-kind` when the scene cannot have it.
    fn ask_for_picture(&self, scene: &mut Scene) -> Result<(), InputError> {
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

    /// What the JSON calls a file: its name when both stand in one directory.
    fn beside_json(&self, path: &Path) -> String {
        let together = self.json.as_deref().is_some_and(|json| json.parent() == path.parent());
        let name = path.file_name().filter(|_| together).map(PathBuf::from);
        let whole = || std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        name.unwrap_or_else(whole).display().to_string()
    }
}

/// The picture of one state, or the force of several; nothing when none was solved or the bodies do not touch.
fn draw(
    scene: &Scene,
    steps: &[report::Step],
    kind: PlotKind,
    path: &Path,
    target: &Target,
    format: Format,
) -> Result<(), Failure> {
    let title = scene.name.as_deref().unwrap_or("");
    let units = &scene.units.clone().unwrap_or_else(UnitLabels::kinds);
    let solution = steps.last().and_then(report::numbers);
    let picture = match (kind, solution) {
        (PlotKind::Curve, _) => {
            let of = |s: &Solution| [s.depth, s.force, s.stiffness];
            let states: Vec<[f64; 3]> = steps.iter().filter_map(report::numbers).map(of).collect();
            let loads = scene.contact.loading().loads();
            let upright = loads.iter().all(|load| matches!(load, Load::Depth(_) | Load::Force(_)));
            let touch = upright.then(|| least(scene.contact.gap()).1);
            plot::states_in(units, title, &states, touch.filter(|t| t.is_finite()), format)
        }
        (_, None) => return Ok(()),
        (PlotKind::Patch, Some(s)) => {
            let loops = s.patch.boundary.clone().unwrap_or_default();
            plot::outlines_in(units, title, &[Outline { label: "patch".to_owned(), loops }], format)
        }
        (PlotKind::Pieces, Some(s)) => plot::outlines_in(units, title, &pieces(s), format),
        (kind, Some(s)) => {
            let gap = kind == PlotKind::Gap;
            // Without a grid to draw from, what the answer itself has.
            let on_grid = (!s.method.is_approximate()).then(|| pictured(&scene.contact, s, &scene.settings, gap).ok());
            let drawn = on_grid.flatten().unwrap_or_else(|| s.clone());
            of_field(&scene.contact, &drawn, kind, (units, title, format))
        }
    };
    match picture {
        Ok(bytes) => write(path, target, |to| to.write_all(&bytes)),
        Err(plot::Error::Empty(_)) => Ok(()),
        Err(e) => Err(Failure::Message(format!("{}: {e}", path.display()))),
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

fn write(
    path: &Path,
    target: &Target,
    fill: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> Result<(), Failure> {
    target.write(fill).map_err(|e| Failure::unwritable(path, &e))
}

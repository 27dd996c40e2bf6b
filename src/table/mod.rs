//! Many scenes that differ in a few numbers: one template, a table of what stands at some of its places, a table of answers.
//!
//! Only the parts of the scene that a column changes are read again for a row. A row never stops the others: what it lacks is NaN,
//! and its verdict says why.

mod pointer;
mod quantity;

use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use crate::clock::{Deadline, Interrupt};
use crate::error::InputError;
use crate::problem::{Loading, Settings};
use crate::report::Step;
use crate::scene::{self, Given, Json, Parts, Scene, quoted};
use pointer::Pointer;
use quantity::Quantity;

/// The verdict of a row that is not a scene.
pub const WRONG_SCENE: &str = "wrong_scene";

/// The verdict of a row that stopped the solver: a fault of it, to be reported.
pub const FAULT: &str = "fault";

/// The verdict of a row that was not read, because the work was interrupted.
pub const INTERRUPTED: &str = "interrupted";

/// Rows that a thread takes at a time: few enough that a slow row holds up none but its own.
const ROWS: usize = 16;

/// What a column puts into the template, one value a row.
#[derive(Debug, Clone, Copy)]
pub enum Column<'a> {
    /// Numbers.
    Numbers(&'a [f64]),
    /// Any values: words, true and false, lists.
    Values(&'a [Json]),
}

impl Column<'_> {
    fn len(&self) -> usize {
        match self {
            Self::Numbers(numbers) => numbers.len(),
            Self::Values(values) => values.len(),
        }
    }

    /// The value of a row, put where it belongs.
    ///
    /// # Errors
    /// When a number is not finite.
    fn put(&self, row: usize, to: &mut Json) -> Result<(), InputError> {
        *to = match self {
            Self::Values(values) => values[row].clone(),
            Self::Numbers(numbers) => match serde_json::Number::from_f64(numbers[row]) {
                Some(number) => Json::Number(number),
                None => return Err(InputError::new("", numbers[row], "a finite number")),
            },
        };
        Ok(())
    }
}

/// A scene with places that a table fills, and what is wanted of each answer.
///
/// ```
/// use contact_patch::table::{Column, Template};
/// let template = Template::new(
///     br#"{"effective_modulus": 1.0, "gap": {"kind": "sphere", "radius": 1.0}, "loading": {}}"#,
///     &["/loading/depth"], &["force", "patch.area"])?;
/// let answers = template.solve(&[Column::Numbers(&[-1.0, 0.01, f64::NAN])], 2, None)?;
/// assert_eq!(answers.verdicts, ["solved", "solved", "wrong_scene"]);
/// assert_eq!(answers.numbers[0][0], 0.0);
/// assert!(answers.numbers[0][1] > 0.0 && answers.numbers[0][2].is_nan());
/// # Ok::<(), contact_patch::InputError>(())
/// ```
pub struct Template {
    document: Json,
    pointers: Vec<Pointer>,
    quantities: Vec<Quantity>,
    given: Given,
    adjust: Box<Adjust>,
}

/// A change of the settings of every row.
type Adjust = dyn Fn(&mut Settings) -> Result<(), InputError> + Send + Sync;

/// A table of answers, a row a row.
#[derive(Debug, Clone, Default)]
pub struct Answers {
    /// Numbers, one list an output; NaN where there is none. Words have a list of NaN.
    pub numbers: Vec<Vec<f64>>,
    /// Words, one list an output; empty lists for outputs that are numbers.
    pub words: Vec<Vec<Option<String>>>,
    /// `solved`, or what is wrong in one word.
    pub verdicts: Vec<&'static str>,
}

impl Template {
    /// A scene as JSON, with the places of the columns (JSON pointers; a last key need not be there yet) and the outputs
    /// (places in the result: `force`, `patch.area`, `moment[0]`, `method`, `reason`).
    ///
    /// # Errors
    /// As [`Scene::from_json`] for text that is not JSON; names `column` or `outputs` when there is no such place.
    pub fn new(text: &[u8], columns: &[&str], outputs: &[&str]) -> Result<Self, InputError> {
        let mut document = scene::document(text)?;
        let pointers = columns.iter().map(|column| Pointer::parse(column)).collect::<Result<Vec<_>, _>>()?;
        for (k, pointer) in pointers.iter().enumerate() {
            if pointers[..k].contains(pointer) {
                return Err(InputError::new("column", quoted(columns[k]), "each place once"));
            }
            pointer.place(&mut document)?;
        }
        let quantities = outputs.iter().map(|output| Quantity::parse(output)).collect::<Result<_, _>>()?;
        Ok(Self { document, pointers, quantities, given: Given::default(), adjust: Box::new(|_| Ok(())) })
    }

    /// The same with heights and gaps that a program holds, and the directory of files.
    #[must_use]
    pub fn with(self, given: Given) -> Self {
        Self { given, ..self }
    }

    /// The same with files looked for in this directory.
    #[must_use]
    pub fn in_directory(self, directory: impl Into<PathBuf>) -> Self {
        Self { given: self.given.directory(directory), ..self }
    }

    /// The same with the settings of every row changed by this; what it refuses is refused of the row.
    #[must_use]
    pub fn adjusted(self, adjust: impl Fn(&mut Settings) -> Result<(), InputError> + Send + Sync + 'static) -> Self {
        Self { adjust: Box::new(adjust), ..self }
    }

    /// Whether each output is a word, not a number.
    #[must_use]
    pub fn words(&self) -> Vec<bool> {
        self.quantities.iter().map(Quantity::is_word).collect()
    }

    /// Answers every row on `threads` threads; the answers do not depend on how many. Once the interrupt is set, rows that are left
    /// have the verdict `interrupted`.
    ///
    /// # Errors
    /// When there are not as many columns as places, when columns differ in length, and when the scene of the first row is wrong at a
    /// place that no column fills: the template is.
    pub fn solve(
        &self,
        columns: &[Column],
        threads: usize,
        interrupt: Option<&Interrupt>,
    ) -> Result<Answers, InputError> {
        if columns.len() != self.pointers.len() {
            let given = format!("{} columns", columns.len());
            return Err(InputError::new("columns", given, format!("{}, one a place", self.pointers.len())));
        }
        let rows = columns.first().map_or(0, Column::len);
        if let Some(k) = columns.iter().position(|column| column.len() != rows) {
            let given = format!("{} rows", columns[k].len());
            return Err(InputError::new(format!("columns[{k}]"), given, format!("{rows} rows, as the first")));
        }
        if rows > 0 {
            self.check(columns)?;
        }
        let mut answers = Answers {
            numbers: vec![vec![f64::NAN; rows]; self.quantities.len()],
            words: self.words().into_iter().map(|word| if word { vec![None; rows] } else { Vec::new() }).collect(),
            verdicts: vec![INTERRUPTED; rows],
        };
        let slices = Mutex::new(Slices::of(&mut answers));
        let next = || slices.lock().unwrap_or_else(PoisonError::into_inner).next();
        let work = || {
            let mut row = Row { template: self, scene: None, parts: self.parts() };
            while let Some(slice) = next() {
                row.answer(columns, slice, interrupt);
            }
        };
        std::thread::scope(|scope| {
            for _ in 1..threads.min(rows.div_ceil(ROWS)) {
                scope.spawn(work);
            }
            work();
        });
        Ok(answers)
    }

    fn parts(&self) -> Parts {
        self.pointers.iter().map(Pointer::part).fold(Parts::default(), |a, b| Parts {
            gap: a.gap || b.gap,
            loading: a.loading || b.loading,
            others: a.others || b.others,
        })
    }

    /// # Errors
    /// The first row's, where it is not one of a column.
    fn check(&self, columns: &[Column]) -> Result<(), InputError> {
        let mut row = Row { template: self, scene: None, parts: self.parts() };
        let Err(error) = row.read(columns, 0) else { return Ok(()) };
        let of_a_column = self.pointers.iter().any(|pointer| {
            let path = pointer.path(&self.document);
            error.path.starts_with(&path) || path.starts_with(&error.path)
        });
        if of_a_column { Ok(()) } else { Err(error) }
    }
}

/// The parts of the answers that one thread fills at a time.
struct Slices<'a> {
    row: usize,
    numbers: Vec<std::slice::ChunksMut<'a, f64>>,
    words: Vec<std::slice::ChunksMut<'a, Option<String>>>,
    verdicts: std::slice::ChunksMut<'a, &'static str>,
}

/// Some rows of the answers.
struct Slice<'a> {
    from: usize,
    numbers: Vec<&'a mut [f64]>,
    words: Vec<&'a mut [Option<String>]>,
    verdicts: &'a mut [&'static str],
}

impl<'a> Slices<'a> {
    fn of(answers: &'a mut Answers) -> Self {
        Self {
            row: 0,
            numbers: answers.numbers.iter_mut().map(|column| column.chunks_mut(ROWS)).collect(),
            words: answers.words.iter_mut().map(|column| column.chunks_mut(ROWS)).collect(),
            verdicts: answers.verdicts.chunks_mut(ROWS),
        }
    }
}

impl<'a> Iterator for Slices<'a> {
    type Item = Slice<'a>;

    fn next(&mut self) -> Option<Slice<'a>> {
        let verdicts = self.verdicts.next()?;
        let from = self.row;
        self.row += verdicts.len();
        let numbers = self.numbers.iter_mut().map(|column| column.next().unwrap_or_default()).collect();
        let words = self.words.iter_mut().map(|column| column.next().unwrap_or_default()).collect();
        Some(Slice { from, numbers, words, verdicts })
    }
}

/// The scene of the row at hand.
struct Row<'a> {
    template: &'a Template,
    /// That of the last row that was one.
    scene: Option<Scene>,
    parts: Parts,
}

impl Row<'_> {
    fn answer(&mut self, columns: &[Column], mut slice: Slice, interrupt: Option<&Interrupt>) {
        let mut found = vec![f64::NAN; self.template.quantities.len()];
        for k in 0..slice.verdicts.len() {
            if interrupt.is_some_and(Interrupt::is_set) {
                return;
            }
            found.fill(f64::NAN);
            // A fault in one row must not take the others with it.
            let answered = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
                self.one(columns, slice.from + k, interrupt, &mut found)
            }));
            let (verdict, words) = answered.unwrap_or_else(|_| {
                self.scene = None;
                (FAULT, self.words_without("this row stopped the solver: please report it"))
            });
            slice.verdicts[k] = verdict;
            for (column, number) in slice.numbers.iter_mut().zip(&found) {
                column[k] = *number;
            }
            for (column, word) in slice.words.iter_mut().zip(words).filter(|(column, _)| !column.is_empty()) {
                column[k] = word;
            }
        }
    }

    /// Verdict and words of one row; its numbers in `found`.
    fn one(
        &mut self,
        columns: &[Column],
        row: usize,
        interrupt: Option<&Interrupt>,
        found: &mut [f64],
    ) -> (&'static str, Vec<Option<String>>) {
        let quantities = &self.template.quantities;
        let scene = match self.read(columns, row) {
            Ok(scene) => scene,
            Err(error) => return (WRONG_SCENE, self.words_without(&error.to_string())),
        };
        let deadline = interrupt.map_or(Deadline::NEVER, |interrupt| scene.settings.deadline.unless(interrupt));
        let settings = Settings { deadline, ..scene.settings };
        let step: Step = crate::solve(&scene.contact, &settings).remove(0);
        let verdict = match &step {
            _ if interrupt.is_some_and(Interrupt::is_set) => return (INTERRUPTED, vec![None; quantities.len()]),
            Ok(_) => "solved",
            Err(unsolved) => unsolved.verdict.word(),
        };
        quantity::numbers(quantities, scene, &step, found);
        (verdict, quantities.iter().map(|quantity| quantity.word(&step)).collect())
    }

    /// The words of a row that has no answer.
    fn words_without(&self, reason: &str) -> Vec<Option<String>> {
        self.template.quantities.iter().map(|quantity| quantity.word_without(reason)).collect()
    }

    /// The scene of a row.
    fn read(&mut self, columns: &[Column], row: usize) -> Result<&Scene, InputError> {
        let Template { pointers, given, document, adjust, .. } = self.template;
        let fill = |document: &mut Json| {
            columns.iter().zip(pointers).try_for_each(|(column, pointer)| {
                let wrong = |e: InputError| InputError { path: pointer.path(&self.template.document), ..e };
                column.put(row, pointer.place(document)?).map_err(wrong)
            })
        };
        let scene = match self.scene.take() {
            Some(mut scene) => {
                let read = fill(&mut scene.document).and_then(|()| scene.read_again(self.parts, given));
                // What is wrong with this row is nothing to the next.
                let scene = self.scene.insert(scene);
                read?;
                scene
            }
            None => {
                let mut whole = document.clone();
                fill(&mut whole)?;
                self.scene.insert(Scene::from_document(whole, given.place(), Some(given))?)
            }
        };
        if let Loading::Steps(steps) = scene.contact.loading() {
            return Err(InputError::new("loading", format!("{} loads", steps.len()), "one load a row"));
        }
        adjust(&mut scene.settings)?;
        Ok(scene)
    }
}

//! `contact-patch batch --table`: one template, a row of a CSV file a scene.
//!
//! Rows are read, answered and written block by block: memory holds one block.

use std::fs::File;
use std::io::{self, BufReader, Read, Write};
use std::path::{Path, PathBuf};

use clap::Args;

use super::Failure;
use crate::error::InputError;
use crate::files;
use crate::problem::Settings;
use crate::scene::{Given, Json, LONGEST};
use crate::table::{Answers, Column, Template};

/// Rows that are held at a time.
const BLOCK: usize = 4096;

/// What is written of each answer unless said.
const OUTPUTS: &str = "depth,force,force_error,stiffness,patch.area,pressure.max";

/// Options of a batch that is a table.
#[derive(Args)]
pub(super) struct TableOptions {
    /// Solve a row of this CSV file a scene; columns named by JSON pointers (/loading/depth) fill places of the template, others are
    /// carried along; - is standard input
    #[arg(long, value_name = "FILE.csv", requires = "template")]
    table: Option<PathBuf>,
    /// The scene whose places a table fills
    #[arg(long, value_name = "SCENE", requires = "table")]
    template: Option<PathBuf>,
    /// What to write of each answer, by its place in the result: force, patch.area, moment[0], method, reason
    #[arg(long, value_name = "NAMES", value_delimiter = ',', default_value = OUTPUTS, requires = "table")]
    outputs: Vec<String>,
}

impl TableOptions {
    /// The files of a batch that is a table: rows and template.
    pub fn files(&self) -> Option<[&Path; 2]> {
        Some([self.table.as_deref()?, self.template.as_deref()?])
    }

    /// Answers every row of the table; whether all were solved.
    ///
    /// # Errors
    /// When a file cannot be read or written, when the template is wrong, and when a row has another number of cells than the header.
    pub fn answer(
        &self,
        [table, template]: [&Path; 2],
        root: Option<&Path>,
        adjust: impl Fn(&mut Settings) -> Result<(), InputError> + Send + Sync + 'static,
        threads: usize,
        to: &mut dyn Write,
    ) -> Result<bool, Failure> {
        let of_template = |e: &InputError| Failure::wrong(template.display(), e);
        let text = files::read(template, LONGEST).map_err(|e| of_template(&e))?;
        let from: Box<dyn Read> = match table.as_os_str().to_str() {
            Some("-") => Box::new(io::stdin()),
            _ => Box::new(File::open(table).map_err(|e| unread(table, &e))?),
        };
        let mut reader = csv::ReaderBuilder::new().from_reader(BufReader::with_capacity(1 << 16, from));
        let header = reader.headers().map_err(|e| unread(table, &e))?.clone();
        let places: Vec<usize> = (0..header.len()).filter(|&k| header[k].trim().starts_with('/')).collect();
        if places.is_empty() {
            let allowed = "a header with a JSON pointer into the template, such as /loading/depth";
            return Err(Failure::wrong(
                table.display(),
                &InputError::new("header", "no column for the template", allowed),
            ));
        }
        let names: Vec<&str> = places.iter().map(|&k| header[k].trim()).collect();
        let outputs: Vec<&str> = self.outputs.iter().map(|name| name.trim()).collect();
        if let Some(name) = outputs.iter().find(|name| header.iter().any(|known| known == **name)) {
            let error = InputError::new("--outputs", name, "a name that is not that of a column");
            return Err(Failure::wrong("arguments", &error));
        }
        let given = match root {
            Some(root) => Given::default().root(root),
            None => Given::default().directory(template.parent().unwrap_or(Path::new(""))),
        };
        let template = Template::new(&text, &names, &outputs).map_err(|e| of_template(&e))?;
        let template = template.with(given).adjusted(adjust);
        let mut writer = csv::WriterBuilder::new().from_writer(to);
        writer.write_record(header.iter().chain(outputs).chain(["verdict"])).map_err(unwritten)?;
        let (mut all_solved, mut rows) = (true, reader.into_records());
        loop {
            let block = rows.by_ref().take(BLOCK).collect::<Result<Vec<_>, _>>().map_err(|e| unread(table, &e))?;
            if block.is_empty() {
                return Ok(all_solved);
            }
            let cells: Vec<Vec<Json>> =
                places.iter().map(|&k| block.iter().map(|row| value(&row[k])).collect()).collect();
            let columns: Vec<Column> = cells.iter().map(|column| Column::Values(column)).collect();
            let answers = template.solve(&columns, threads, None).map_err(|e| of_template(&e))?;
            all_solved &= answers.verdicts.iter().all(|verdict| *verdict == "solved");
            for (k, row) in block.iter().enumerate() {
                writer.write_record(row.iter().map(str::to_owned).chain(answer(&answers, k))).map_err(unwritten)?;
            }
            writer.flush()?;
        }
    }
}

/// The cells of one answer: shortest digits that read back the same; nothing for what there is not.
fn answer(answers: &Answers, row: usize) -> impl Iterator<Item = String> {
    let cell = move |(numbers, words): (&Vec<f64>, &Vec<Option<String>>)| match words.get(row) {
        Some(word) => word.clone().unwrap_or_default(),
        None if numbers[row].is_nan() => String::new(),
        None => format!("{:e}", numbers[row]),
    };
    let cells = answers.numbers.iter().zip(&answers.words).map(cell);
    cells.chain([answers.verdicts[row].to_owned()])
}

/// What a cell says: nothing, a number, true or false, or a word.
fn value(cell: &str) -> Json {
    match cell.trim() {
        "" => Json::Null,
        "true" => Json::Bool(true),
        "false" => Json::Bool(false),
        word => match word.parse().ok().and_then(serde_json::Number::from_f64) {
            Some(number) => Json::Number(number),
            None => Json::String(word.to_owned()),
        },
    }
}

fn unread(file: &Path, error: &dyn std::fmt::Display) -> Failure {
    Failure::Message(format!("{}: cannot be read: {error}", file.display()))
}

fn unwritten(error: csv::Error) -> Failure {
    match error.into_kind() {
        csv::ErrorKind::Io(error) => error.into(),
        other => Failure::Message(format!("the table cannot be written: {other:?}")),
    }
}

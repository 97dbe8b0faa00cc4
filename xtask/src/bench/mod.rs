//! `cargo xtask bench`: what the core costs, counted in executed instructions.
//!
//! The benchmarks are a firmware image of their own. In the emulator one nanosecond of virtual time is one instruction,
//! so a count is exact and the same on every PC. The image checks every answer for its content and prints its tables:
//! `# heading`, then one row per workload, `name<TAB>count`. It is built as the firmware is. How exact the pulses are is
//! measured on the host, on a model of the timers; waits, stacks and shares with the image of the board on a model of its chip. The figures are compared with the committed ones of `docs/benchmarks.md`.

mod board;
mod data_sheets;
mod exactness;
mod image;
mod table;

use std::fs;
use std::process::ExitCode;

use anyhow::{Context, Result};

use crate::firmware::Image;
use crate::size::{Size, Sizes};
use crate::words::say;
use crate::{budget, place, size};
use table::{Row, Table};

/// The committed figures.
const DOCUMENT: &str = "docs/benchmarks.md";

/// Crates that take less flash than this, in bytes, are one row: single functions of the core library come and go.
const SMALL: u64 = 100;

/// A figure that moved by no more than this is the same, in percent.
const TOLERANCE: u64 = 2;

/// A size that moved by no more than this is the same, in bytes: small crates come along with a function or without.
const SLACK: u64 = 64;

/// What to do with the figures.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Write the new figures to docs/benchmarks.md
    #[arg(long)]
    update: bool,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    let mut tables = image::count()?;
    tables.extend(exactness::measure()?);
    tables.extend(board::measure()?);
    tables.push(basic_device()?);
    let whole = size::of(Image::Whole)?;
    tables.push(sizes(&whole));
    tables.push(budget(&whole)?);
    tables.push(data_sheets::dictionaries()?);
    tables.push(data_sheets::hooks()?);
    tables.push(data_sheets::generator()?);

    let file = place::root().join(DOCUMENT);
    let mut document =
        fs::read_to_string(&file).with_context(|| format!("reading {}", file.display()))?;
    let mut changed = 0;
    for now in &tables {
        let columns = now.rows.first().map_or(0, |row| row.figures.len());
        let committed = table::read(&document, &now.heading, columns)?;
        if arguments.update {
            document = table::write(&document, now)?;
        }
        let (lines, count) = compare(&now.rows, &committed, now.slack);
        say!("{:<66} {:>16} {:>16}", now.heading, "now", "committed")?;
        for line in lines {
            say!("{line}")?;
        }
        say!("")?;
        changed += count;
    }

    if arguments.update {
        fs::write(&file, document).with_context(|| format!("writing {}", file.display()))?;
        say!("{DOCUMENT} is up to date")?;
        return Ok(ExitCode::SUCCESS);
    }
    if changed > 0 {
        say!(
            "{changed} rows differ from {DOCUMENT} by more than {TOLERANCE} %; `cargo xtask bench --update` takes them over"
        )?;
        return Ok(ExitCode::FAILURE);
    }
    say!("as in {DOCUMENT}")?;
    Ok(ExitCode::SUCCESS)
}

/// What the core takes in a device with what other open stacks have by default.
fn basic_device() -> Result<Table> {
    let sizes = size::of(Image::BasicDevice)?;
    let for_size = size::of(Image::BasicDeviceForSize)?;
    Ok(Table {
        heading: "Flash of a basic device".to_owned(),
        rows: vec![
            Row::new(
                "canopen, with what CANopenNode has by default",
                &[sizes.flash_of("canopen")],
            ),
            Row::new("the whole image, dictionary included", &[sizes.total.flash]),
            Row::new("canopen, for least size", &[for_size.flash_of("canopen")]),
            Row::new("the whole image, for least size", &[for_size.total.flash]),
        ],
        slack: SLACK,
    })
}

/// The sizes of the board's image: the crates worth a row, the others in one, and the total.
fn sizes(whole: &Sizes) -> Table {
    let mut rows: Vec<Row> = Vec::new();
    let mut others = [0; 2];
    for (name, Size { flash, ram }) in &whole.crates {
        if flash + ram >= SMALL {
            rows.push(Row::new(name, &[*flash, *ram]));
        } else {
            others[0] += flash;
            others[1] += ram;
        }
    }
    rows.push(Row::new("others", &others));
    rows.push(Row::new("total", &[whole.total.flash, whole.total.ram]));
    Table {
        heading: "Flash and RAM".to_owned(),
        rows,
        slack: SLACK,
    }
}

/// What the drive may weigh.
fn budget(whole: &Sizes) -> Result<Table> {
    let figures = budget::figures(whole)?;
    Ok(Table {
        heading: "Budget".to_owned(),
        rows: figures
            .iter()
            .map(|(name, figure)| Row::new(name, &[*figure]))
            .collect(),
        slack: SLACK,
    })
}

/// The figures beside the committed ones, line by line, and how many rows changed, came or went.
fn compare(now: &[Row], committed: &[Row], slack: u64) -> (Vec<String>, usize) {
    let mut lines = Vec::new();
    let mut changed = 0;
    for row in now {
        let before = committed.iter().find(|before| before.name == row.name);
        let same = before.is_some_and(|before| alike(&row.figures, &before.figures, slack));
        changed += usize::from(!same);
        let before = before.map_or_else(|| "-".to_owned(), figures);
        let mark = if same { "" } else { "  changed" };
        lines.push(format!(
            "{:<66} {:>16} {before:>16}{mark}",
            row.name,
            figures(row)
        ));
    }
    for gone in committed
        .iter()
        .filter(|before| now.iter().all(|row| row.name != before.name))
    {
        changed += 1;
        lines.push(format!(
            "{:<66} {:>16} {:>16}  gone",
            gone.name,
            "-",
            figures(gone)
        ));
    }
    (lines, changed)
}

fn figures(row: &Row) -> String {
    let figures: Vec<_> = row.figures.iter().map(u64::to_string).collect();
    figures.join(" ")
}

fn alike(now: &[u64], before: &[u64], slack: u64) -> bool {
    let within = |(now, before): (&u64, &u64)| {
        let difference = now.abs_diff(*before);
        difference <= slack || difference * 100 <= before * TOLERANCE
    };
    now.len() == before.len() && now.iter().zip(before).all(within)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_percent_either_way_are_no_change() {
        assert!(alike(&[1020], &[1000], 0) && alike(&[980], &[1000], 0) && alike(&[0], &[0], 0));
        assert!(!alike(&[1021], &[1000], 0) && !alike(&[979], &[1000], 0) && !alike(&[1], &[0], 0));
    }

    #[test]
    fn a_few_bytes_are_no_change_of_a_size() {
        assert!(alike(&[164, 0], &[100, 0], SLACK));
        assert!(!alike(&[165, 0], &[100, 0], SLACK));
    }

    #[test]
    fn changed_new_and_missing_rows_are_counted() {
        let committed = [
            Row::new("same", &[100]),
            Row::new("worse", &[100]),
            Row::new("gone", &[5]),
        ];
        let now = [
            Row::new("same", &[101]),
            Row::new("worse", &[110]),
            Row::new("new", &[7]),
        ];
        let (lines, changed) = compare(&now, &committed, 0);
        assert_eq!(changed, 3);
        let ends: Vec<_> = lines
            .iter()
            .map(|line| line.split_whitespace().collect::<Vec<_>>().join(" "))
            .collect();
        assert_eq!(
            ends,
            [
                "same 101 100",
                "worse 110 100 changed",
                "new 7 - changed",
                "gone - 5 gone"
            ]
        );
        assert_eq!(compare(&committed, &committed, 0).1, 0);
    }
}

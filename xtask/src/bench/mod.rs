//! `cargo xtask bench`: what the core costs, counted in executed instructions.
//!
//! The benchmarks are a firmware image of their own. In the emulator one nanosecond of virtual time is one instruction,
//! so a count is exact and the same on every PC. The image checks every answer for its content and prints one row per
//! workload, `name<TAB>count`. The figures are compared with the committed ones of `docs/benchmarks.md`.

mod table;

use std::fs;
use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

use anyhow::{Context, Result, bail, ensure};

use crate::firmware::Image;
use crate::words::{say, tell};
use crate::{emulator, place, process, setup, size};
use table::Row;

/// The committed figures.
const DOCUMENT: &str = "docs/benchmarks.md";
const INSTRUCTIONS: &str = "## Instructions";
const SIZES: &str = "## Flash and RAM";

/// Crates that take less flash than this, in bytes, are one row: single functions of the core library come and go.
const SMALL: u64 = 100;

/// A figure that moved by no more than this is the same, in percent.
const TOLERANCE: u64 = 2;

/// A size that moved by no more than this is the same, in bytes: small crates come along with a function or without.
const SLACK: u64 = 64;

/// The emulator needs a second or two; what takes longer hangs.
const PATIENCE: Duration = Duration::from_secs(300);

/// What to do with the figures.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Write the new figures to docs/benchmarks.md
    #[arg(long)]
    update: bool,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    let instructions = count()?;
    let sizes = sizes()?;

    let file = place::root().join(DOCUMENT);
    let document =
        fs::read_to_string(&file).with_context(|| format!("reading {}", file.display()))?;
    let mut changed = 0;
    for (unit, heading, now, slack) in [
        ("instructions", INSTRUCTIONS, &instructions, 0),
        ("bytes", SIZES, &sizes, SLACK),
    ] {
        let columns = now.first().map_or(0, |row| row.figures.len());
        let committed = table::read(&document, heading, columns)?;
        let (lines, count) = compare(now, &committed, slack);
        say!("{unit:<44} {:>10} {:>10}", "now", "committed")?;
        for line in lines {
            say!("{line}")?;
        }
        say!("")?;
        changed += count;
    }

    if arguments.update {
        let document = table::write(&document, INSTRUCTIONS, &instructions)?;
        let document = table::write(&document, SIZES, &sizes)?;
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

/// Builds the benchmarks and runs them in the emulator.
fn count() -> Result<Vec<Row>> {
    let qemu = setup::emulator()?;
    setup::rust_target()?;
    let image = Image::Bench.build()?;
    let rows = run_image(&qemu, &image)?;
    ensure!(!rows.is_empty(), "the benchmarks printed no row");
    Ok(rows)
}

fn run_image(qemu: &Path, image: &Path) -> Result<Vec<Row>> {
    let mut command = emulator::counting(qemu, image);
    let mut child = command
        .stdout(std::process::Stdio::piped())
        .spawn()
        .context("starting QEMU")?;
    let output = child.stdout.take().context("QEMU has no output")?;
    let reader = std::thread::spawn(move || {
        let mut rows = Vec::new();
        process::each_line(output, |line| match parse(line) {
            Some(row) => rows.push(row),
            None => tell!("{line}"),
        });
        rows
    });
    let deadline = std::time::Instant::now() + PATIENCE;
    let status = loop {
        if let Some(status) = child.try_wait().context("waiting for QEMU")? {
            break status;
        }
        if std::time::Instant::now() > deadline {
            child.kill().context("stopping QEMU")?;
            child.wait().context("waiting for QEMU")?;
            bail!("the benchmarks have not ended for {} s", PATIENCE.as_secs());
        }
        std::thread::sleep(Duration::from_millis(20));
    };
    let rows = reader.join().ok().context("reading the rows")?;
    ensure!(status.success(), "the benchmarks failed: {status}");
    Ok(rows)
}

fn parse(line: &str) -> Option<Row> {
    let (name, count) = line.split_once('\t')?;
    Some(Row {
        name: name.trim().to_owned(),
        figures: vec![count.trim().parse().ok()?],
    })
}

/// The sizes of the board's image: the crates worth a row, the others in one, and the total.
fn sizes() -> Result<Vec<Row>> {
    let sizes = size::board()?;
    let row = |name: &str, size: size::Size| Row {
        name: name.to_owned(),
        figures: vec![size.flash, size.ram],
    };
    let (large, small): (Vec<_>, Vec<_>) = sizes
        .crates
        .iter()
        .partition(|(_, size)| size.flash + size.ram >= SMALL);
    let mut rows: Vec<_> = large.iter().map(|(name, size)| row(name, *size)).collect();
    let others = small
        .iter()
        .fold(size::Size::default(), |sum, (_, size)| size::Size {
            flash: sum.flash + size.flash,
            ram: sum.ram + size.ram,
        });
    rows.push(row("others", others));
    rows.push(row("total", sizes.total));
    Ok(rows)
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
            "{:<44} {:>10} {before:>10}{mark}",
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
            "{:<44} {:>10} {:>10}  gone",
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

    fn row(name: &str, figure: u64) -> Row {
        Row {
            name: name.to_owned(),
            figures: vec![figure],
        }
    }

    #[test]
    fn a_row_is_a_name_a_tab_and_a_count() {
        assert_eq!(
            parse("SDO upload, expedited\t412"),
            Some(row("SDO upload, expedited", 412))
        );
        assert_eq!(parse("a word from the firmware"), None);
        assert_eq!(parse("name\tnumber"), None);
    }

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
        let committed = [row("same", 100), row("worse", 100), row("gone", 5)];
        let now = [row("same", 101), row("worse", 110), row("new", 7)];
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

//! The image of the benchmarks: built, run in the emulator, and what it prints.

use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};

use super::table::{Row, Table};
use crate::firmware::{Image, Optimised};
use crate::words::tell;
use crate::{emulator, process, setup};

/// The emulator needs a second or two; what takes longer hangs.
const PATIENCE: Duration = Duration::from_secs(300);

/// Builds the benchmarks for speed and for size and runs them in the emulator. Each row gets both counts.
pub fn count() -> Result<Vec<Table>> {
    let qemu = setup::emulator()?;
    setup::rust_target()?;
    let fast = run(&qemu, &Image::Bench.build_as(Optimised::ForSpeed)?)?;
    let small = run(&qemu, &Image::Bench.build_as(Optimised::ForSize)?)?;
    join(fast, small)
}

/// The rows of both runs side by side. A row with several counts has those of the build for speed alone.
fn join(mut fast: Vec<Table>, small: Vec<Table>) -> Result<Vec<Table>> {
    ensure!(
        fast.iter().any(|table| !table.rows.is_empty()),
        "the benchmarks printed no row"
    );
    let names = |tables: &[Table]| -> Vec<(String, String)> {
        let rows = tables
            .iter()
            .flat_map(|table| table.rows.iter().map(move |row| (table, row)));
        rows.map(|(table, row)| (table.heading.clone(), row.name.clone()))
            .collect()
    };
    ensure!(
        names(&fast) == names(&small),
        "the two builds printed different rows"
    );
    let twins = small.into_iter().flat_map(|table| table.rows);
    let rows = fast.iter_mut().flat_map(|table| &mut table.rows);
    for (row, twin) in rows.zip(twins) {
        if row.figures.len() == 1 {
            row.figures.extend(twin.figures);
        }
    }
    Ok(fast)
}

fn run(qemu: &Path, image: &Path) -> Result<Vec<Table>> {
    let mut command = emulator::counting(qemu, image);
    let mut child = command
        .stdout(Stdio::piped())
        .spawn()
        .context("starting QEMU")?;
    let output = child.stdout.take().context("QEMU has no output")?;
    let reader = std::thread::spawn(move || {
        let mut tables = Vec::new();
        process::each_line(output, |line| {
            if !take(line, &mut tables) {
                tell!("{line}");
            }
        });
        tables
    });
    let deadline = Instant::now() + PATIENCE;
    let status = loop {
        if let Some(status) = child.try_wait().context("waiting for QEMU")? {
            break status;
        }
        if Instant::now() > deadline {
            child.kill().context("stopping QEMU")?;
            child.wait().context("waiting for QEMU")?;
            bail!("the benchmarks have not ended for {} s", PATIENCE.as_secs());
        }
        std::thread::sleep(Duration::from_millis(20));
    };
    let tables = reader.join().ok().context("reading the rows")?;
    ensure!(status.success(), "the benchmarks failed: {status}");
    Ok(tables)
}

/// Puts a line into the tables; whether it belongs there.
pub(super) fn take(line: &str, tables: &mut Vec<Table>) -> bool {
    if let Some(heading) = line.strip_prefix("# ") {
        tables.push(Table {
            heading: heading.trim().to_owned(),
            rows: Vec::new(),
            slack: 0,
        });
        return true;
    }
    let row = line.split_once('\t').and_then(|(name, counts)| {
        let counts: Result<Vec<_>, _> = counts
            .split('\t')
            .map(|count| count.trim().parse())
            .collect();
        Some(Row::new(name.trim(), &counts.ok()?))
    });
    match (row, tables.last_mut()) {
        (Some(row), Some(table)) => {
            table.rows.push(row);
            true
        }
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tables(lines: &[&str]) -> Vec<Table> {
        let mut tables = Vec::new();
        for line in lines {
            assert!(take(line, &mut tables), "{line}");
        }
        tables
    }

    #[test]
    fn a_row_is_a_name_a_tab_and_a_count() {
        let mut tables = tables(&["# Instructions", "SDO upload, expedited\t412"]);
        assert_eq!(tables[0].rows, [Row::new("SDO upload, expedited", &[412])]);
        assert!(!take("a word from the firmware", &mut tables));
        assert!(take("profile position\t2300\t2000\t9000", &mut tables));
        assert_eq!(tables[0].rows[1].figures, [2300, 2000, 9000]);
        assert!(!take("name\tnumber", &mut tables));
        assert!(!take("name\t1\t", &mut tables));
        assert!(!take("no table yet\t1", &mut Vec::new()));
    }

    #[test]
    fn both_builds_stand_side_by_side() {
        let fast = tables(&["# One", "a\t1", "# Two", "b\t2"]);
        let small = tables(&["# One", "a\t10", "# Two", "b\t20"]);
        let joined = join(fast, small.clone()).unwrap();
        assert_eq!(joined[0].rows, [Row::new("a", &[1, 10])]);
        assert_eq!(joined[1].rows, [Row::new("b", &[2, 20])]);
        let several = tables(&["# One", "a\t1\t2"]);
        assert_eq!(join(several.clone(), several.clone()).unwrap(), several);
        assert!(join(tables(&["# One", "b\t1"]), small).is_err());
        assert!(join(Vec::new(), Vec::new()).is_err());
    }
}

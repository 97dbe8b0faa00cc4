//! The image of the benchmarks: built, run in the emulator, and what it prints.

use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};

use super::table::{Row, Table};
use crate::firmware::Image;
use crate::words::tell;
use crate::{emulator, process, setup};

/// The emulator needs a second or two; what takes longer hangs.
const PATIENCE: Duration = Duration::from_secs(300);

/// Builds the benchmarks as the firmware is built, and runs them in the emulator.
pub fn count() -> Result<Vec<Table>> {
    let qemu = setup::emulator()?;
    setup::rust_target()?;
    let tables = run(&qemu, &Image::Bench.build()?)?;
    ensure!(
        tables.iter().any(|table| !table.rows.is_empty()),
        "the benchmarks printed no row"
    );
    Ok(tables)
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
}

//! Writes the cases of `fuzz/cases` as the bytes that fuzzing begins with, into the folder `<folder>/<target>` of each target.
//!
//! A case is a list of frames in the notation of the tests, one on a line; `+10` are ten milliseconds, `-` lies between two
//! cases.

use std::path::Path;
use std::process::ExitCode;
use std::{env, fs, io};

use canopen::Duration;
use tests::any_drive;
use tests::notation::frame;
use tests::watched::{Step, encode};

fn main() -> ExitCode {
    let mut arguments = env::args_os().skip(1);
    let (Some(folder), None) = (arguments.next(), arguments.next()) else {
        eprintln!("Usage: fuzz_seeds <FOLDER>");
        return ExitCode::from(2);
    };
    match write(Path::new(&folder)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("fuzz_seeds: {}: {error}", folder.display());
            ExitCode::from(2)
        }
    }
}

fn write(folder: &Path) -> io::Result<()> {
    for (target, encode, cases) in [
        (
            "node",
            steps as fn(&[&str]) -> Vec<u8>,
            include_str!("../../../fuzz/cases/node.txt"),
        ),
        ("sdo", requests, include_str!("../../../fuzz/cases/sdo.txt")),
        (
            "lss",
            lss_requests,
            include_str!("../../../fuzz/cases/lss.txt"),
        ),
        (
            "drive",
            drive,
            include_str!("../../../fuzz/cases/drive.txt"),
        ),
    ] {
        let folder = folder.join(target);
        fs::create_dir_all(&folder)?;
        for (number, case) in cases.split("\n-\n").enumerate() {
            let lines: Vec<&str> = case
                .lines()
                .map(|line| line.split('#').next().unwrap_or_default().trim())
                .filter(|line| !line.is_empty())
                .collect();
            fs::write(folder.join(format!("case-{}", number + 1)), encode(&lines))?;
        }
    }
    // Data sheets are what they are.
    let folder = folder.join("data_sheet");
    fs::create_dir_all(&folder)?;
    let cases = include_str!("../../../fuzz/cases/data_sheet.txt");
    for (number, case) in cases.split("\n-\n").enumerate() {
        fs::write(folder.join(format!("case-{}", number + 1)), case)?;
    }
    Ok(())
}

/// The bytes for the whole node: after each step the bus takes what is there.
fn steps(lines: &[&str]) -> Vec<u8> {
    let step = |line: &&str| {
        let step = match milliseconds(line) {
            Some(span) => Step::Pass(Duration::millis(span)),
            None => Step::Frame(frame(line)),
        };
        [step, Step::Transmit(63)]
    };
    encode(&lines.iter().flat_map(step).collect::<Vec<_>>())
}

/// The bytes for the SDO servers: a record of nine bytes for each request.
fn requests(lines: &[&str]) -> Vec<u8> {
    records(lines, 40)
}

/// The bytes for the LSS slave: one that tells whether it has a node-ID, then nine for each request.
fn lss_requests(lines: &[&str]) -> Vec<u8> {
    let mut bytes = vec![0];
    bytes.extend(records(lines, 20));
    bytes
}

/// The bytes for the whole drive, which is stopped by a reset alone.
fn drive(lines: &[&str]) -> Vec<u8> {
    let step = |line: &&str| match milliseconds(line) {
        Some(span) => Err(Duration::millis(span)),
        None => Ok(frame(line)),
    };
    any_drive::encode(1, lines.iter().map(step))
}

/// A byte with the pause before in units of so many milliseconds, then the eight of the request.
fn records(lines: &[&str], unit: u64) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut pause = 0;
    for line in lines {
        if let Some(span) = milliseconds(line) {
            pause = span.div_ceil(unit).min(31) as u8;
            continue;
        }
        let frame = frame(line);
        let is_other = matches!(frame.standard_id(), Some(0x000 | 0x680));
        bytes.push(u8::from(is_other) | pause << 2);
        bytes.extend(frame.bytes());
        pause = 0;
    }
    bytes
}

fn milliseconds(line: &str) -> Option<u64> {
    line.strip_prefix('+')?.parse().ok()
}

//! The command line as a person or a script meets it: one-line errors, exit codes, readers that leave.

use std::fs;
use std::io::pipe;
use std::process::{Command, Output};

fn xtask(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_xtask"));
    command.args(arguments);
    command
}

/// Every step is left out again: nothing but the summary is printed, and nothing passed.
const NOTHING: [&str; 5] = ["test", "--only", "host", "--skip", "host"];

fn error_line(output: &Output) -> &str {
    let text = str::from_utf8(&output.stderr).unwrap();
    let line = text.strip_prefix("xtask: ").expect(text);
    assert_eq!(text.lines().count(), 1, "{text}");
    assert!(!text.contains("error"), "{text}");
    line.trim_end()
}

/// One line on standard error, nothing else, and exit code 2.
fn assert_refused(arguments: &[&str], words: &str) {
    let output = xtask(arguments).output().unwrap();
    assert_eq!(error_line(&output), words);
    assert_eq!(output.status.code(), Some(2));
    assert!(output.stdout.is_empty());
}

#[test]
fn mistakes_are_one_line_and_exit_code_2() {
    assert_refused(&[], "Usage: cargo xtask <COMMAND>");
    assert_refused(&["sail"], "unrecognized subcommand 'sail'");
    assert_refused(
        &["qemu", "--slcan", "127.0.0.1"],
        "cannot serve SLCAN on 127.0.0.1: invalid socket address",
    );
    assert_refused(
        &["qemu", "--slcan", "127.0.0.1:70000"],
        "cannot serve SLCAN on 127.0.0.1:70000: invalid port value",
    );
}

#[test]
fn files_that_are_something_else_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let notes = folder.path().join("notes.txt");
    fs::write(&notes, "important").unwrap();
    let notes = notes.to_str().unwrap();
    let qemu = |option| ["qemu", "--slcan", "127.0.0.1:2402", option, notes];
    assert_refused(
        &qemu("--store"),
        &format!("cannot use the store {notes}: not a folder"),
    );
    assert_refused(
        &qemu("--image"),
        &format!("cannot use the image {notes}: no ELF program for a 32-bit Arm"),
    );
    assert_eq!(fs::read_to_string(notes).unwrap(), "important");
}

#[test]
fn help_is_no_mistake() {
    for arguments in [&["--help"][..], &["qemu", "--help"], &["--version"]] {
        let output = xtask(arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(0));
        assert!(output.stderr.is_empty() && !output.stdout.is_empty());
    }
}

#[test]
fn a_reader_may_leave() {
    let closed = || {
        let (reader, writer) = pipe().unwrap();
        drop(reader);
        writer
    };
    let output = xtask(&NOTHING).stdout(closed()).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(output.stderr.is_empty(), "{output:?}");
    let output = xtask(&["--help"]).stdout(closed()).output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert!(output.stderr.is_empty(), "{output:?}");
    let status = xtask(&["sail"]).stderr(closed()).status().unwrap();
    assert_eq!(status.code(), Some(2));
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_a_failure() {
    let full = fs::File::options().write(true).open("/dev/full").unwrap();
    let output = xtask(&NOTHING).stdout(full).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(
        error_line(&output),
        "cannot write to the standard output: no space left on device"
    );
}

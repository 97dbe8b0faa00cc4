//! The command line as a person or a script meets it.

use std::process::{Command, Output};

fn od_gen(arguments: &[&str]) -> Output {
    let folder = env!("CARGO_MANIFEST_DIR");
    Command::new(env!("CARGO_BIN_EXE_od-gen"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap()
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

#[test]
fn a_correct_data_sheet_is_printed_as_rust() {
    let output = od_gen(&["rust", "tests/data/small.eds"]);
    assert_eq!(output.status.code(), Some(0));
    assert!(text(&output.stdout).contains("pub struct Dictionary"));
    assert!(!text(&output.stdout).contains("cia402"));
    assert_eq!(text(&output.stderr), "");
}

#[test]
fn the_drive_objects_come_when_asked_for() {
    let output = od_gen(&["rust", "--cia402", "../eds/axis402.eds"]);
    assert_eq!(output.status.code(), Some(0));
    assert!(text(&output.stdout).contains("impl ::cia402::Objects for Dictionary"));
}

#[test]
fn findings_go_to_standard_error_with_exit_code_1() {
    let output = od_gen(&["rust", "tests/data/broken.eds"]);
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(text(&output.stdout), "");
    let lines: Vec<&str> = text(&output.stderr).lines().collect();
    assert!(lines.len() > 5);
    assert!(
        lines
            .iter()
            .all(
                |line| line.starts_with("tests/data/broken.eds:") && line.contains(": error[")
                    || line.contains(": warning[")
            )
    );
}

#[test]
fn a_wrong_command_line_or_file_is_one_line_with_exit_code_2() {
    for (arguments, expected) in [
        (&[][..], "error: a command is missing, see --help"),
        (
            &["rust"],
            "error: the following required arguments were not provided: <FILE>",
        ),
        (&["ruby"], "error: unrecognized subcommand 'ruby'"),
        (
            &["rust", "--fast", "x.eds"],
            "error: unexpected argument '--fast' found",
        ),
        (
            &["rust", "no-such.eds"],
            "no-such.eds: error: No such file or directory",
        ),
    ] {
        let output = od_gen(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert_eq!(text(&output.stderr).trim_end(), expected);
        assert_eq!(text(&output.stdout), "");
    }
}

#[test]
fn a_reader_of_the_errors_that_goes_away_changes_nothing() {
    for (file, code) in [("tests/data/broken.eds", 1), ("no-such.eds", 2)] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let status = Command::new(env!("CARGO_BIN_EXE_od-gen"))
            .args(["rust", file])
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .stderr(writer)
            .status()
            .unwrap();
        assert_eq!(status.code(), Some(code), "{file}");
    }
}

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
fn the_identity_is_set_by_options() {
    let rust = |more: &[&str]| od_gen(&[&["rust", "../eds/axis402.eds"][..], more].concat());
    let stated = rust(&[]);
    let identity = [
        "--identity",
        "product_code=0xBEEF",
        "--identity",
        "serial_number=7",
    ];
    let set = rust(&identity);
    assert_eq!(set.status.code(), Some(0), "{}", text(&set.stderr));
    let (stated, set) = (text(&stated.stdout), text(&set.stdout));
    assert!(!stated.contains("0xBEEF") && !stated.contains("48879"));
    assert!(set.contains("0xBEEF") || set.contains("48879"), "{set}");
    for (wrong, why) in [
        ("colour=1", "write it as NAME=NUMBER"),
        ("product_code=ten", "`ten` is not a number of 32 bits"),
    ] {
        let refused = rust(&["--identity", wrong]);
        assert_eq!(refused.status.code(), Some(2));
        assert!(text(&refused.stderr).contains(why), "{refused:?}");
    }
}

#[test]
fn findings_go_to_standard_error_with_exit_code_1() {
    let output = od_gen(&["rust", "tests/data/broken.eds"]);
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(text(&output.stdout), "");
    let shown = text(&output.stderr);
    assert!(shown.contains("error[list-count]: SupportedObjects is 4, but 3 are listed"));
    assert!(!shown.contains('\u{1b}'), "no colours in a file");
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
            &["fmt", "tests/data/sensor.xdd"],
            "tests/data/sensor.xdd: error: this is XML: only EDS and DCF files have a canonical form",
        ),
        (
            &["fmt", "pump.toml"],
            "pump.toml: error: this is a recipe: only EDS and DCF files have a canonical form",
        ),
        (
            &["dcf", "x.eds", "--node-id", "128"],
            "error: invalid value '128' for '--node-id <NODE_ID>': 128 is not in 1..=127",
        ),
        (
            &["rules", "pdo-gab"],
            "error: there is no rule `pdo-gab`: did you mean `pdo-gap`?",
        ),
        (&["check", "src"], "src: error: Is a directory"),
        (
            &[
                "doc",
                "tests/data/small.eds",
                "--output",
                "no-such/page.html",
            ],
            "no-such/page.html: error: No such file or directory",
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

/// A pipe that nobody writes to kept it waiting for ever. What the shell pipes in is read.
#[cfg(unix)]
#[test]
fn what_is_no_file_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe");
    let made = Command::new("mkfifo").arg(&pipe).status().unwrap();
    assert!(made.success());
    for file in [pipe.to_str().unwrap(), "/dev/zero"] {
        for command in ["check", "doc", "dump", "rust", "fmt"] {
            let output = od_gen(&[command, file]);
            let expected = format!("{file}: error: it is no file\n");
            assert_eq!(text(&output.stderr), expected, "{command}");
            assert_eq!(output.status.code(), Some(2), "{command}");
        }
    }
    let piped = Command::new(env!("CARGO_BIN_EXE_od-gen"))
        .args(["check", "/dev/stdin"])
        .stdin(std::fs::File::open("tests/data/small.eds").unwrap())
        .output()
        .unwrap();
    assert_eq!(piped.status.code(), Some(0), "{piped:?}");
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

#[test]
fn our_own_data_sheets_are_in_canonical_form() {
    for name in [
        "eds/axis402",
        "eds/compact",
        "products/lmd/lmd",
        "products/nanotec/nanotec",
        "products/s200/s200",
        "products/tc1/tc1",
        "tests/eds/test-device",
        "tests/eds/multiplexed-device",
    ] {
        let output = od_gen(&["fmt", "--check", &format!("../{name}.eds")]);
        assert!(output.status.success(), "{name}: {output:?}");
    }
}

#[test]
fn check_says_nothing_about_a_correct_data_sheet() {
    let output = od_gen(&["check", "../eds/axis402.eds", "--deny-warnings"]);
    assert_eq!(output.status.code(), Some(0));
    assert_eq!((text(&output.stdout), text(&output.stderr)), ("", ""));
}

#[test]
fn check_shows_each_finding_with_its_line() {
    let output = od_gen(&["check", "tests/data/broken.eds"]);
    assert_eq!(output.status.code(), Some(1));
    insta::assert_snapshot!(text(&output.stdout));
}

#[test]
fn check_is_one_line_a_finding_when_asked() {
    let output = od_gen(&["check", "--format", "short", "tests/data/broken.eds"]);
    assert_eq!(output.status.code(), Some(1));
    let lines: Vec<&str> = text(&output.stdout).lines().collect();
    assert!(lines.len() > 10);
    assert!(
        lines
            .iter()
            .all(|line| line.starts_with("tests/data/broken.eds:"))
    );
}

#[test]
fn check_speaks_json() {
    let output = od_gen(&[
        "check",
        "--format",
        "json",
        "tests/data/broken.eds",
        "../eds/axis402.eds",
    ]);
    assert_eq!(output.status.code(), Some(1));
    let files: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(files[0]["file"], "tests/data/broken.eds");
    assert_eq!(files[0]["findings"][0]["rule"], "unknown-key");
    assert_eq!(files[0]["findings"][0]["line"], 4);
    assert_eq!(files[1]["findings"], serde_json::json!([]));
    assert!(files[1]["silenced"][0]["reason"].is_string());
}

#[test]
fn check_looks_at_the_bindings_beside_a_data_sheet_too() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("foreign.eds");
    std::fs::write(&file, include_str!("data/foreign.eds")).unwrap();
    let bindings = folder.path().join("foreign.bind.toml");
    let right = include_str!("data/foreign.bind.toml");
    let wrong = right.replace("profile_velocity", "speed");
    let file = file.to_str().unwrap();
    let check = |text: &str| {
        std::fs::write(&bindings, text).unwrap();
        let output = od_gen(&["check", "--format", "json", file]);
        let files: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        (output.status.code(), files)
    };
    let (code, files) = check(right);
    assert_eq!((code, files.as_array().unwrap().len()), (Some(0), 2));
    let (code, files) = check(&wrong);
    assert_eq!(code, Some(1));
    assert_eq!(files[1]["file"], bindings.to_str().unwrap());
    assert_eq!(files[1]["findings"][0]["rule"], "binding-parameter");
    let allowed =
        format!("# od-gen: allow binding-parameter, unbound-object because of a test\n\n{wrong}");
    let (code, files) = check(&allowed);
    assert_eq!(code, Some(0), "{files}");
    assert_eq!(files[1]["silenced"][0]["reason"], "of a test");
}

#[test]
fn a_warning_is_an_error_when_asked() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("warning.eds");
    let sheet = include_str!("data/small.eds").replace("BaudRate_125=1\nBaudRate_1000=1\n", "");
    std::fs::write(&file, sheet).unwrap();
    let file = file.to_str().unwrap();
    assert_eq!(od_gen(&["check", file]).status.code(), Some(0));
    assert_eq!(
        od_gen(&["check", file, "--deny-warnings"]).status.code(),
        Some(1)
    );
}

#[test]
fn diff_ends_like_diff() {
    let (small, drive) = ("tests/data/small.eds", "tests/data/drive.eds");
    let same = od_gen(&["diff", small, small]);
    assert_eq!((same.status.code(), text(&same.stdout)), (Some(0), ""));
    let other = od_gen(&["diff", small, drive]);
    assert_eq!(other.status.code(), Some(1));
    assert!(text(&other.stdout).contains("+ 6040h Control word: VAR UNSIGNED16 rww\n"));
    let broken = od_gen(&["diff", small, "tests/data/broken.eds"]);
    assert_eq!(
        broken.status.code(),
        Some(1),
        "what could be read is compared"
    );
    assert!(
        text(&broken.stderr).ends_with("which `od-gen check` shows; what could be read is used\n")
    );
    assert_eq!(text(&broken.stderr).lines().count(), 1);
    let unread = od_gen(&["diff", small, "Cargo.toml"]);
    assert_eq!((unread.status.code(), text(&unread.stdout)), (Some(2), ""));
    let json = od_gen(&["diff", "--format", "json", small, drive]);
    let differences: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!(differences[0]["place"], "[DeviceInfo]");
    assert_eq!(differences[0]["breaks"], false);
}

#[test]
fn fmt_changes_a_file_once() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("spelled.eds");
    let sheet = include_str!("data/small.eds").replace("AccessType=const", "accesstype = CONST");
    std::fs::write(&file, &sheet).unwrap();
    let name = file.to_str().unwrap();
    let asked = od_gen(&["fmt", "--check", name]);
    assert_eq!(asked.status.code(), Some(1));
    assert_eq!(text(&asked.stdout), format!("{name}\n"));
    assert_eq!(std::fs::read_to_string(&file).unwrap(), sheet, "only asked");
    assert_eq!(od_gen(&["fmt", name]).status.code(), Some(0));
    let once = std::fs::read_to_string(&file).unwrap();
    assert!(once.contains("AccessType=const"));
    assert_eq!(od_gen(&["fmt", "--check", name]).status.code(), Some(0));
    assert_eq!(
        od_gen(&["diff", name, "tests/data/small.eds"])
            .status
            .code(),
        Some(0)
    );
}

#[test]
fn rules_are_listed_and_explained() {
    let all = od_gen(&["rules"]);
    assert_eq!(all.status.code(), Some(0));
    let listed = text(&all.stdout)
        .lines()
        .filter(|line| line.starts_with("  "))
        .count();
    assert!(listed >= 50, "{listed}");
    let one = od_gen(&["rules", "mode-object"]);
    insta::assert_snapshot!(text(&one.stdout));
    let json = od_gen(&["rules", "--format", "json"]);
    let rules: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!(rules.as_array().unwrap().len(), listed);
}

#[test]
fn doc_goes_where_it_is_sent() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("page.html");
    let name = file.to_str().unwrap();
    let output = od_gen(&["doc", "../eds/axis402.eds", "--output", name]);
    assert_eq!((output.status.code(), text(&output.stdout)), (Some(0), ""));
    assert!(
        std::fs::read_to_string(&file)
            .unwrap()
            .starts_with("<!DOCTYPE html>")
    );
    let markdown = od_gen(&["doc", "--format", "markdown", "../eds/axis402.eds"]);
    assert!(text(&markdown.stdout).starts_with("# Axis402 generic drive\n"));
}

#[test]
fn dcf_configures_a_device() {
    let folder = tempfile::tempdir().unwrap();
    let (values, made) = (
        folder.path().join("pump.values"),
        folder.path().join("pump.dcf"),
    );
    std::fs::write(&values, "; of the pump\n6081=2000\n").unwrap();
    let (values, made) = (values.to_str().unwrap(), made.to_str().unwrap());
    let sheet = "../eds/axis402.eds";
    let set = ["--set", "6083=5000", "--set", "1017=500"];
    let arguments = [
        "dcf",
        sheet,
        "--node-id",
        "5",
        "--values",
        values,
        "--output",
        made,
    ];
    let output = od_gen(&[&arguments[..], &set[..]].concat());
    assert_eq!((output.status.code(), text(&output.stderr)), (Some(0), ""));
    let checked = od_gen(&["check", made, "--deny-warnings"]);
    assert_eq!(checked.status.code(), Some(0), "{}", text(&checked.stdout));
    let different = od_gen(&["diff", sheet, made]);
    insta::assert_snapshot!(text(&different.stdout));
}

#[test]
fn dcf_refuses_what_the_device_would_refuse() {
    let sheet = "../eds/axis402.eds";
    for (set, expected) in [
        (
            "6041=1",
            "error[configured-read-only]: 6041h:0 is ro: it cannot be configured",
        ),
        (
            "7FFF=1",
            "error[value-of-nothing]: there is no 7FFFh:0 in the data sheet",
        ),
        (
            "1800:1=0x80",
            "error[cob-id-used-twice]: 1800h:1 is the same identifier as 1005h",
        ),
    ] {
        let output = od_gen(&["dcf", sheet, "--node-id", "5", "--set", set]);
        assert_eq!(
            (output.status.code(), text(&output.stdout)),
            (Some(1), ""),
            "{set}"
        );
        assert!(
            text(&output.stderr).contains(expected),
            "{}",
            text(&output.stderr)
        );
    }
}

#[test]
fn dcf_is_made_of_xml_too() {
    let output = od_gen(&[
        "dcf",
        "tests/data/sensor.xdd",
        "--node-id",
        "7",
        "--set",
        "2000=50",
    ]);
    assert_eq!((output.status.code(), text(&output.stderr)), (Some(0), ""));
    let made = text(&output.stdout);
    assert!(made.contains("[DeviceComissioning]\nNodeID=7\n"));
    assert!(made.contains("ParameterValue=50\n"));
    // What the XDD silences for a whole object, the DCF silences in each section.
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("sensor.dcf");
    std::fs::write(&file, made).unwrap();
    let checked = od_gen(&["check", "--deny-warnings", file.to_str().unwrap()]);
    assert_eq!(checked.status.code(), Some(0), "{}", text(&checked.stdout));
}

#[test]
fn dcf_of_a_dcf_keeps_what_it_is_not_told() {
    let every = "tests/data/every.dcf";
    let output = od_gen(&["dcf", every]);
    assert_eq!((output.status.code(), text(&output.stderr)), (Some(0), ""));
    let made = text(&output.stdout);
    let kept = "NodeID=17\nNodeName=Mixer\nBaudrate=500\nNetNumber=3\nNetworkName=Kitchen\nCANopenManager=0\nLSS_SerialNumber=0x0000004D\n";
    assert!(made.contains(kept), "{made}");
    let arguments = ["--node-id", "6", "--name", "Pump", "--manager"];
    let output = od_gen(&[&["dcf", every][..], &arguments].concat());
    let made = text(&output.stdout);
    let changed = "NodeID=6\nNodeName=Pump\nBaudrate=500\nNetNumber=3\nNetworkName=Kitchen\nCANopenManager=1\nLSS_SerialNumber=0x0000004D\n";
    assert!(made.contains(changed), "{made}");
}

#[test]
fn dcf_refuses_what_would_be_read_as_something_else() {
    for (arguments, expected) in [
        (["--set", "2007=a ;b"], "2007h DefaultValue"),
        (["--name", "Pump ;2"], "NodeName: Pump ;2 -> Pump"),
        (["--network-name", "a\n[1000]"], "more than one line"),
        (["--set", "2007=a\n2000=0"], "more than one line"),
    ] {
        let sheet = ["dcf", "tests/data/small.eds", "--node-id", "5"];
        let output = od_gen(&[&sheet[..], &arguments].concat());
        let found = (output.status.code(), text(&output.stdout));
        assert_eq!(found, (Some(2), ""), "{arguments:?}");
        let expected = expected.replace("DefaultValue", "ParameterValue: a ;b -> a");
        assert!(
            text(&output.stderr).contains(&expected),
            "{}",
            text(&output.stderr)
        );
    }
}

#[test]
fn a_file_that_cannot_be_read_hides_no_other() {
    let both = ["no-such.eds", "tests/data/broken.eds"];
    let output = od_gen(&[&["check", "--format", "json"], &both[..]].concat());
    assert_eq!(output.status.code(), Some(2));
    let refusal = "no-such.eds: error: No such file or directory\n";
    assert_eq!(text(&output.stderr), refusal);
    let files: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(files[0]["file"], "tests/data/broken.eds");
    let short = od_gen(&[&["check", "--format", "short"], &both[..]].concat());
    assert_eq!(short.status.code(), Some(2));
    assert!(text(&short.stdout).starts_with("tests/data/broken.eds:"));

    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("spelled.eds");
    let sheet = include_str!("data/small.eds").replace("AccessType=const", "accesstype = CONST");
    std::fs::write(&file, &sheet).unwrap();
    let output = od_gen(&["fmt", "no-such.eds", file.to_str().unwrap()]);
    assert_eq!(
        (output.status.code(), text(&output.stderr)),
        (Some(2), refusal)
    );
    assert!(
        std::fs::read_to_string(&file)
            .unwrap()
            .contains("AccessType=const")
    );
}

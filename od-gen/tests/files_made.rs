//! The commands that make files of data sheets: networks, conversions, recipes; and how a file comes about, or does not.

use std::process::{Command, Output};

fn od_gen(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_od-gen"))
        .args(arguments)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap()
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

#[test]
fn a_network_becomes_files() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().to_str().unwrap();
    let machine = "tests/data/network/machine.toml";
    let checked = od_gen(&["network", machine, "--check", "--output", output]);
    assert_eq!(checked.status.code(), Some(0), "{checked:?}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    let made = od_gen(&["network", machine, "--output", output]);
    assert_eq!((made.status.code(), text(&made.stderr)), (Some(0), ""));
    assert_eq!(made.stdout, checked.stdout);
    assert!(text(&made.stdout).contains("at 500 kbit/s: "));
    let mut names: Vec<_> = std::fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    let expected = "axis_x.bin axis_x.dcf axis_y.bin axis_y.dcf io.bin io.dcf master.dcf";
    assert_eq!(names.join(" "), expected);
    let file = folder.path().join("wrong.toml");
    std::fs::write(&file, "[network]\nbit_rate = 500\n[[node]]\nname = 1\n").unwrap();
    let wrong = od_gen(&["network", file.to_str().unwrap()]);
    assert_eq!(wrong.status.code(), Some(1));
    assert!(text(&wrong.stderr).contains("wrong.toml:4:8"));
    let missing = od_gen(&["network", "no-such.toml"]);
    assert_eq!(missing.status.code(), Some(2));
}

#[test]
fn a_data_sheet_is_converted_there_and_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (xdd, eds, dcf) = (path("a.xdd"), path("a.eds"), path("a.dcf"));
    let there = od_gen(&["convert", "../eds/axis402.eds", &xdd]);
    assert_eq!(there.status.code(), Some(0), "{there:?}");
    let shown = text(&there.stderr);
    // RevisionNumber and Comments.
    assert_eq!(shown.lines().count(), 2, "{shown}");
    assert!(
        shown.contains("a.xdd: warning: this format does not say: ~ [DeviceInfo] RevisionNumber")
    );
    let checked = od_gen(&["check", &xdd, "--deny-warnings"]);
    assert_eq!(checked.status.code(), Some(0), "{checked:?}");
    let back = od_gen(&["convert", &xdd, &eds]);
    assert_eq!((back.status.code(), text(&back.stderr)), (Some(0), ""));
    let differences = od_gen(&["diff", "../eds/axis402.eds", &eds]);
    assert_eq!(
        text(&differences.stdout).lines().count(),
        2,
        "{differences:?}"
    );
    for (arguments, expected) in [
        (
            [&xdd, &dcf],
            "a.xdd: error: it is for no node: `od-gen dcf --node-id` makes it for one",
        ),
        (
            [&xdd, &path("a.txt")],
            "a.txt: error: the extension is not .eds, .dcf, .xdd or .xdc",
        ),
    ] {
        let refused = od_gen(&["convert", arguments[0], arguments[1]]);
        assert_eq!(refused.status.code(), Some(2));
        assert!(
            text(&refused.stderr).trim_end().ends_with(expected),
            "{refused:?}"
        );
    }
}

#[test]
fn a_recipe_stands_wherever_a_data_sheet_does() {
    let folder = tempfile::tempdir().unwrap();
    let eds = std::fs::canonicalize("../eds/axis402.eds").unwrap();
    let recipe = format!(
        "[base]\neds = {eds:?}\nremove = [\"20D0h-20D3h\"]\n\n[[part]]\neds = \"part.eds\"\n\n\
         [identity]\nproduct_code = \"$PUMP_CODE\"\n"
    );
    std::fs::write(folder.path().join("pump.toml"), recipe).unwrap();
    let part = "[2FF0]\nParameterName=Flow\nDataType=0x0006\nAccessType=rw\nDefaultValue=70\n";
    std::fs::write(folder.path().join("part.eds"), part).unwrap();
    let run = |arguments: &[&str], code: &str| {
        Command::new(env!("CARGO_BIN_EXE_od-gen"))
            .args(arguments)
            .current_dir(folder.path())
            .env("PUMP_CODE", code)
            .output()
            .unwrap()
    };
    for (arguments, expected) in [
        (&["check", "pump.toml", "--deny-warnings"][..], ""),
        (&["rust", "pump.toml"], "2FF0"),
        (&["doc", "pump.toml", "--format", "markdown"], "Flow"),
        (&["dump", "pump.toml"], "\"Flow\""),
        (
            &["dcf", "pump.toml", "--node-id", "4"],
            "ProductNumber=0x00000777",
        ),
    ] {
        let output = run(arguments, "0x777");
        assert_eq!(
            output.status.code(),
            Some(0),
            "{arguments:?} {}",
            text(&output.stderr)
        );
        assert!(text(&output.stdout).contains(expected), "{arguments:?}");
    }
    let differs = run(&["diff", eds.to_str().unwrap(), "pump.toml"], "0x777");
    assert!(
        text(&differs.stdout).contains("+ 2FF0h Flow"),
        "{differs:?}"
    );
    let wrong = run(&["check", "--format", "short", "pump.toml"], "many");
    assert_eq!(wrong.status.code(), Some(1));
    assert!(
        text(&wrong.stdout).starts_with("pump.toml:9:16: error["),
        "{wrong:?}"
    );
    std::fs::write(folder.path().join("part.eds"), part.replace("70", "70000")).unwrap();
    let wrong = run(&["check", "pump.toml"], "5");
    assert!(text(&wrong.stdout).contains("part.eds:5:14"), "{wrong:?}");
    let wrong = run(&["check", "--format", "json", "pump.toml"], "5");
    assert!(
        text(&wrong.stdout).contains("\"file\": \"part.eds\""),
        "{wrong:?}"
    );
}

#[cfg(unix)]
#[test]
fn who_reads_a_file_while_it_is_written_reads_all_of_it() {
    use std::io::Read;
    use std::os::unix::fs::PermissionsExt;

    let folder = tempfile::tempdir().unwrap();
    let (file, link) = (
        folder.path().join("spelled.eds"),
        folder.path().join("link.eds"),
    );
    let sheet = include_str!("data/small.eds").replace("AccessType=const", "accesstype = CONST");
    std::fs::write(&file, &sheet).unwrap();
    std::fs::set_permissions(&file, std::fs::Permissions::from_mode(0o640)).unwrap();
    std::os::unix::fs::symlink(&file, &link).unwrap();
    let mut reader = std::fs::File::open(&file).unwrap();
    assert_eq!(
        od_gen(&["fmt", link.to_str().unwrap()]).status.code(),
        Some(0)
    );
    let mut before = String::new();
    reader.read_to_string(&mut before).unwrap();
    assert_eq!(before, sheet);
    assert!(
        std::fs::read_to_string(&file)
            .unwrap()
            .contains("AccessType=const")
    );
    let mode = std::fs::metadata(&file).unwrap().permissions().mode();
    assert_eq!(mode & 0o777, 0o640);
    assert!(std::fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(
        std::fs::read_dir(folder.path()).unwrap().count(),
        2,
        "nothing is left"
    );
}

/// A command of the shell with `od-gen` in the place of `OD`.
#[cfg(unix)]
fn shell(command: &str) -> Output {
    Command::new("sh")
        .args(["-c", &command.replace("OD", env!("CARGO_BIN_EXE_od-gen"))])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap()
}

#[cfg(unix)]
#[test]
fn an_output_that_is_closed_is_exit_code_2() {
    for arguments in [
        "rust tests/data/small.eds",
        "doc tests/data/small.eds",
        "dump tests/data/small.eds",
        "diff tests/data/small.eds tests/data/types.eds",
        "dcf tests/data/small.eds --node-id 5",
        "bindings ../eds/axis402.eds",
        "check --format json tests/data/broken.eds",
        "network tests/data/network/machine.toml --check",
        "rules",
        "rules not-listed",
        "--help",
        "check --help",
        "--version",
    ] {
        let output = shell(&format!("OD {arguments} >&-"));
        let told = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments}: {told}");
        let last = told.lines().last();
        assert_eq!(
            last,
            Some("error: standard output is closed"),
            "{arguments}"
        );
        let output = shell(&format!("OD {arguments} >/dev/null"));
        assert_ne!(output.status.code(), Some(2), "{arguments}");
    }
    // Nothing to say is said without an output.
    let output = shell("OD check --deny-warnings ../eds/axis402.eds >&-");
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
}

#[cfg(unix)]
#[test]
fn a_limit_for_files_is_an_error_of_the_write() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("old.html"), "before").unwrap();
    for (arguments, file) in [
        ("doc ../eds/axis402.eds", "new.html"),
        ("doc ../eds/axis402.eds", "old.html"),
        ("rust ../eds/axis402.eds", "new.rs"),
    ] {
        let path = folder.join(file);
        let output = shell(&format!(
            "ulimit -f 8; OD {arguments} -o {}",
            path.display()
        ));
        assert_eq!(output.status.code(), Some(2), "{output:?}");
        assert!(text(&output.stderr).ends_with(": error: File too large\n"));
        // All or nothing.
        let left = std::fs::read_to_string(&path).ok();
        assert_eq!(left.as_deref(), (file == "old.html").then_some("before"));
    }
}

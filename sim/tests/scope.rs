//! The program `sim scope`: a process, an SLCAN adapter in between, a drive in real time. Nothing here depends on how long anything
//! takes: the drive stands, and the trigger is an order.

mod served;

use std::process::{Command, ExitCode, Output};

use sim::drive::Setup;

use served::Served;

fn scope(served: &Served, arguments: &[&str]) -> Output {
    let address = served.address.to_string();
    let mut command = Command::new(env!("CARGO_BIN_EXE_sim"));
    command.args([
        "scope",
        "--slcan",
        &address,
        "--node",
        "4",
        "--timeout",
        "20000",
    ]);
    command.args(arguments).output().unwrap()
}

fn error(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

#[test]
fn a_recording_goes_to_files_and_to_programs() {
    let served = Served::start(Setup::with_node_id(1, 4));
    let folder = tempfile::tempdir().unwrap();
    let (csv, svg) = (
        folder.path().join("scope.csv"),
        folder.path().join("scope.svg"),
    );
    let (csv, svg) = (csv.to_str().unwrap(), svg.to_str().unwrap());
    let channels = ["--channels", "6041,position actual value,6061"];
    let amounts = ["--samples", "40", "--pre", "25%", "--divider", "2"];
    let files = ["--json", "--csv", csv, "--plot", svg];
    let output = scope(&served, &[&channels[..], &amounts, &files].concat());
    assert_eq!(output.status.code(), Some(0), "{}", error(&output));

    let told: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(told["node"], 4);
    assert_eq!(
        (&told["samples"], &told["trigger_index"]),
        (&40.into(), &10.into())
    );
    assert_eq!(
        (&told["tick_ns"], &told["period_s"]),
        (&1_000_000.into(), &0.002.into())
    );
    assert_eq!(told["time_s"].as_array().unwrap().len(), 40);
    assert_eq!(told["channels"][1]["object"], "6064h:00");
    assert_eq!(
        told["channels"][1]["name"],
        "6064h:00 Position actual value"
    );
    assert_eq!(
        told["channels"][2]["values"],
        serde_json::json!(vec![1; 40])
    );

    let table = std::fs::read_to_string(csv).unwrap();
    let mut lines = table.lines();
    let head = "time_s,\"6041h:00 Statusword\",\"6064h:00 Position actual value\",\"6061h:00 Modes of operation display\"";
    assert_eq!(lines.next(), Some(head));
    assert_eq!(lines.clone().count(), 40);
    assert!(lines.all(|line| line.ends_with(",0,1")), "{table}");
    let picture = std::fs::read_to_string(svg).unwrap();
    assert!(picture.starts_with("<svg") && picture.contains("6064h:00 Position actual value"));
}

#[test]
fn a_recording_is_drawn_for_people() {
    let served = Served::start(Setup::with_node_id(1, 4));
    let output = scope(&served, &["--channels", "6041", "--samples", "30"]);
    assert_eq!(output.status.code(), Some(0), "{}", error(&output));
    let told = String::from_utf8(output.stdout).unwrap();
    assert!(
        told.starts_with("node 4: 30 samples, one every 1 ms, from 0"),
        "{told}"
    );
    assert!(told.contains("6041h:00 Statusword, 592 to 592"), "{told}");
}

#[test]
fn mistakes_are_one_line_and_an_exit_code() {
    let served = Served::start(Setup::with_node_id(1, 4));
    let refused = |arguments: &[&str], part: &str, code: i32| {
        let output = scope(&served, arguments);
        let error = error(&output);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {error}");
        assert_eq!(error.lines().count(), 1, "{arguments:?}: {error}");
        assert!(
            error.starts_with("sim: ") && error.contains(part),
            "{arguments:?}: {error}"
        );
        assert!(output.stdout.is_empty(), "{arguments:?}");
    };
    refused(
        &["--channels", "flux capacitor"],
        "there is no object `flux capacitor`",
        2,
    );
    refused(
        &["--channels", "1018:4"],
        "refuses 20D1h:01 with 06040041h",
        1,
    );
    refused(
        &["--channels", "1,2,3,4,5,6,7,8,9"],
        "a scope has 8 channels, and not 9",
        2,
    );
    refused(&["--trigger", "soon"], "`soon` is no trigger", 2);
    refused(
        &["--samples", "60000", "--channels", "6064"],
        "60000 samples are too many: 5120 samples of these channels fit",
        2,
    );
    refused(&["--trigger", "6064>abc"], "`abc` in `6064>abc`", 2);
    refused(&["--pre", "100%"], "a number of samples, or 0% to 99%", 2);
    refused(&["--divider", "0"], "0", 2);
    refused(
        &["--samples", "5", "--pre", "5"],
        "--pre must be below the samples, which are 5",
        2,
    );
    refused(
        &["--samples", "5", "--csv", "/no/such/folder/a.csv"],
        "cannot write /no/such/folder/a.csv",
        2,
    );
}

#[test]
fn a_second_server_is_given_identifiers_and_used() {
    let served = Served::start(Setup::with_node_id(1, 4));
    let small = [
        "--sdo-server",
        "2",
        "--channels",
        "6041",
        "--samples",
        "30",
        "--json",
    ];
    let output = scope(&served, &small);
    assert_eq!(output.status.code(), Some(1));
    assert!(
        error(&output).contains("SDO server 2 has no identifiers"),
        "{}",
        error(&output)
    );
    let address = served.address.to_string();
    for (object, identifier) in [("1201:1", "0x680"), ("1201:2", "0x681")] {
        let words = ["axis402", "od", "write", "4", object, identifier, "--slcan"];
        let words = words.into_iter().chain([address.as_str()]);
        assert_eq!(
            master::axis402::run(words.map(Into::into)),
            ExitCode::SUCCESS
        );
    }
    let output = scope(&served, &small);
    assert_eq!(output.status.code(), Some(0), "{}", error(&output));
}

#[test]
fn without_a_bus_there_is_nothing_to_ask() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_sim"));
    let output = command.args(["scope", "--node", "4"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(
        error(&output).starts_with("sim: a bus is missing"),
        "{}",
        error(&output)
    );
}

//! The program itself: a process, an SLCAN adapter in between, a drive in real time. Nothing here depends on how long anything takes.

use std::net::SocketAddr;
use std::process::{Command, Output};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread::{self, JoinHandle};

use master::bus::live::{Incoming, LiveBus};
use sim::Axis402;
use sim::drive::Setup;
use sim::serve::Server;

/// A drive behind an SLCAN adapter on a free port; it ends with the test.
pub struct Served {
    pub address: SocketAddr,
    stopper: SyncSender<Incoming>,
    server: Option<JoinHandle<Result<(), String>>>,
}

impl Served {
    pub fn start(setup: Setup) -> Self {
        let mut bus = LiveBus::new();
        let address = bus.serve_slcan("127.0.0.1:0").unwrap().address();
        let stopper = bus.stopper();
        let (booted, has_booted) = sync_channel(1);
        let server = thread::spawn(move || {
            let mut server = Server::new(bus, Box::new(Axis402::new(setup)), false);
            server.turn();
            booted.send(()).unwrap();
            server.run()
        });
        has_booted.recv().unwrap();
        Self {
            address,
            stopper,
            server: Some(server),
        }
    }

    fn run(&self, arguments: &[&str]) -> Output {
        let address = self.address.to_string();
        run(&[&["--slcan", &address], arguments].concat())
    }

    /// The output of a command that succeeds.
    pub fn told(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {error}");
        String::from_utf8(output.stdout).unwrap()
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        self.stopper.send(Incoming::Stop).unwrap();
        let result = self.server.take().map(JoinHandle::join);
        if !thread::panicking() {
            assert_eq!(result.unwrap().unwrap(), Ok(()));
        }
    }
}

pub fn run(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_axis402"));
    command.args(arguments).output().unwrap()
}

/// One line on standard error that holds `part`, nothing else, and this exit code.
pub fn assert_refused(arguments: &[&str], part: &str, code: i32) {
    let output = run(arguments);
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {error}");
    assert_eq!(error.lines().count(), 1, "{arguments:?}: {error}");
    assert!(
        error.starts_with("axis402: ") && error.contains(part),
        "{arguments:?}: {error}"
    );
    assert!(output.stdout.is_empty(), "{arguments:?}");
}

#[test]
fn a_drive_is_put_into_service() {
    let served = Served::start(Setup::unconfigured(0xC0FFEE));
    // The machine may be busy: the steps are long, and what matters is what is found.
    let told = served.told(&["lss", "number", "--first", "4", "--step", "60"]);
    assert!(
        told.starts_with("node 4: vendor 00000000h, product 00000402h"),
        "{told}"
    );
    let told = served.told(&["scan"]);
    assert!(
        told.contains("00C0FFEE  Axis402 CiA 402 drive\n1 node\n"),
        "{told}"
    );
    served.told(&["od", "write", "4", "profile acceleration", "50000"]);
    assert_eq!(served.told(&["od", "read", "-b", "4", "6083h"]), "50000\n");
    assert_eq!(
        served.told(&["save", "4"]),
        "node 4 has saved its parameters\n"
    );
    served.told(&["nmt", "start", "4"]);
    let told = served.told(&["monitor", "4", "-n", "1"]);
    assert!(told.ends_with("TPDO 1: switch on disabled\n"), "{told}");

    let folder = tempfile::tempdir().unwrap();
    let name = folder.path().join("name");
    let name = name.to_str().unwrap();
    served.told(&["od", "read", "4", "1008", "-o", name]);
    assert_eq!(
        std::fs::read(name).unwrap(),
        b"Axis402 CiA 402 drive".as_slice()
    );
    std::fs::write(name, 777u32.to_le_bytes()).unwrap();
    served.told(&["od", "write", "4", "6084", "--file", name]);
    assert_eq!(served.told(&["od", "read", "-b", "4", "6084"]), "777\n");

    let told = served.told(&["lss", "bitrate", "500"]);
    assert_eq!(told, "at 500 kbit/s 1 of 1 nodes answer\n");
    let told = served.told(&["--bitrate", "500", "lss", "bitrate", "1000"]);
    assert_eq!(told, "at 1000 kbit/s 1 of 1 nodes answer\n");

    let file = folder.path().join("drive.dcf");
    let file = file.to_str().unwrap();
    served.told(&["od", "dump", "4", "-o", file]);
    served.told(&["od", "write", "4", "6083", "1"]);
    assert!(
        served
            .told(&["od", "load", "4", file])
            .starts_with("1 values written, ")
    );
    assert_eq!(served.told(&["od", "read", "-b", "4", "6083"]), "50000\n");
}

#[test]
fn a_refusal_is_one_line_and_exit_code_1() {
    let served = Served::start(Setup::with_node_id(1, 4));
    let address = served.address.to_string();
    let with = |rest: &[&'static str]| {
        let arguments: Vec<String> = ["--slcan", &address]
            .iter()
            .chain(rest)
            .map(|word| (*word).to_owned())
            .collect();
        arguments
    };
    let refused = |rest: &[&'static str], part: &str, code: i32| {
        let arguments = with(rest);
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        assert_refused(&arguments, part, code);
    };
    refused(
        &["od", "write", "4", "1000", "1"],
        "06010002h: attempt to write a read-only object",
        1,
    );
    refused(
        &["od", "read", "5", "1000", "--timeout", "50"],
        "node 5 does not answer",
        1,
    );
    refused(
        &["od", "read", "4", "flux capacitor"],
        "there is no object `flux capacitor`",
        2,
    );
    refused(
        &["od", "read", "4", "1000", "--eds", "/no/such.eds"],
        "cannot read /no/such.eds: no such file",
        2,
    );
    refused(
        &[
            "od",
            "load",
            "4",
            concat!(env!("CARGO_MANIFEST_DIR"), "/../eds/axis402.eds"),
        ],
        "is no DCF",
        2,
    );
    refused(
        &[
            "od",
            "load",
            "4",
            concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml"),
        ],
        "is no data sheet",
        2,
    );
}

/// Both read 1008h and other strings in segments, from one server.
#[test]
fn two_dumps_at_once_both_end_well() {
    let served = Served::start(Setup::with_node_id(1, 4));
    let both = [(); 2].map(|()| {
        Command::new(env!("CARGO_BIN_EXE_axis402"))
            .args(["--slcan", &served.address.to_string()])
            .args(["od", "dump", "4"])
            .stdout(std::process::Stdio::piped())
            .stderr(std::process::Stdio::piped())
            .spawn()
            .unwrap()
    });
    let [first, second] = both.map(|dump| thread::spawn(|| dump.wait_with_output().unwrap()));
    let lines = |output: Output| {
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(0), "{error}");
        output.stdout.iter().filter(|byte| **byte == b'\n').count()
    };
    let (first, second) = (lines(first.join().unwrap()), lines(second.join().unwrap()));
    assert_eq!(first, second);
}

#[cfg(target_os = "linux")]
#[test]
fn an_output_that_is_full_is_exit_code_2() {
    let served = Served::start(Setup::with_node_id(1, 4));
    let full = std::fs::File::options().write(true).open("/dev/full");
    let output = Command::new(env!("CARGO_BIN_EXE_axis402"))
        .args(["--slcan", &served.address.to_string()])
        .args(["od", "read", "4", "1000"])
        .stdout(full.unwrap())
        .output()
        .unwrap();
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert_eq!(
        error,
        "axis402: cannot write the output: no space left on device\n"
    );
}

#[cfg(unix)]
#[test]
fn an_output_that_is_closed_is_exit_code_2() {
    let served = Served::start(Setup::with_node_id(1, 4));
    for arguments in [
        "scan",
        "lss find",
        "od read 4 1000",
        "od dump 4",
        "od --help",
        "--version",
    ] {
        let command = format!(
            "exec {} --slcan {} {arguments} >&-",
            env!("CARGO_BIN_EXE_axis402"),
            served.address
        );
        let output = Command::new("sh").args(["-c", &command]).output().unwrap();
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments}: {error}");
        assert_eq!(
            error.lines().last(),
            Some("axis402: cannot write the output: standard output is closed"),
            "{arguments}"
        );
    }
}

#[test]
fn mistakes_are_one_line_and_exit_code_2() {
    let bus = ["--slcan", "127.0.0.1:1"];
    let with = |rest: &[&'static str]| [&bus[..], rest].concat();
    assert_refused(&["scan"], "a bus is missing", 2);
    assert_refused(&["dance"], "dance", 2);
    assert_refused(
        &with(&["scan"]),
        "cannot use the SLCAN adapter 127.0.0.1:1",
        2,
    );
    assert_refused(
        &["--slcan", "/dev/no-such-port", "scan"],
        "no such file or directory",
        2,
    );
    assert_refused(&["--socketcan", "no-such-can0", "scan"], "no-such-can0", 2);
    assert_refused(&with(&["scan", "--socketcan", "can0"]), "--socketcan", 2);
    assert_refused(&with(&["scan", "--bitrate", "123"]), "1000, 800", 2);
    assert_refused(
        &with(&["od", "read", "128", "1000"]),
        "a node-ID is 1 to 127",
        2,
    );
    assert_refused(&with(&["od", "read", "4"]), "OBJECT", 2);
    assert_refused(&with(&["od", "write", "4", "6083"]), "VALUE", 2);
    assert_refused(
        &with(&["od", "write", "4", "6083", "1", "--file", "x"]),
        "--file",
        2,
    );
    assert_refused(
        &with(&["od", "read", "4", "1000", "--type", "u9"]),
        "no type",
        2,
    );
    assert_refused(&with(&["lss", "set"]), "--node-id", 2);
    assert_refused(
        &with(&["lss", "set", "--node-id", "4", "--identity", "1:2:3"]),
        "four hexadecimal",
        2,
    );
    assert_refused(&with(&["lss", "bitrate", "100"]), "1000, 800", 2);
}

#[test]
fn help_is_no_mistake() {
    for arguments in [
        &["--help"][..],
        &["lss", "number", "--help"],
        &["--version"],
    ] {
        assert_eq!(run(arguments).status.code(), Some(0));
    }
}

#[test]
fn a_panel_that_is_not_installed_is_told() {
    // Nothing lies beside a program that is alone in its folder.
    let folder = tempfile::tempdir().unwrap();
    let alone = folder.path().join("axis402");
    std::fs::copy(env!("CARGO_BIN_EXE_axis402"), &alone).unwrap();
    let run = |arguments: &[&str]| {
        let mut command = Command::new(&alone);
        command.args(arguments).env("PATH", "").env_remove("CARGO");
        let output = command.output().unwrap();
        (
            output.status.code(),
            String::from_utf8(output.stderr).unwrap(),
        )
    };
    let missing = "axis402: axis402-panel is not installed: cargo install --path panel\n";
    let told = run(&["panel", "--slcan", "127.0.0.1:2402"]);
    assert_eq!(told, (Some(2), missing.to_owned()));
    let (code, told) = run(&["--slcan", "127.0.0.1:2402", "panel"]);
    assert_eq!(code, Some(2));
    assert!(told.contains("`panel` stands before its options"), "{told}");
}

//! The command line as a person or a script meets it: output, one-line errors, exit codes.

use std::io::{BufRead, BufReader, Read};
use std::net::TcpListener;
use std::process::{Child, Command, Output, Stdio};

fn sim() -> Command {
    Command::new(env!("CARGO_BIN_EXE_sim"))
}

fn run(arguments: &[&str]) -> Output {
    sim().args(arguments).output().unwrap()
}

/// One line on standard error that holds `part`, nothing else, and exit code 2.
fn assert_refused(arguments: &[&str], part: &str) {
    let output = run(arguments);
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
    assert_eq!(error.lines().count(), 1, "{arguments:?}: {error}");
    assert!(error.contains(part), "{arguments:?}: {error}");
    assert!(output.stdout.is_empty(), "{arguments:?}");
}

#[test]
fn mistakes_are_one_line_and_exit_code_2() {
    let serve = |rest: &[&'static str]| [&["serve", "--slcan", "127.0.0.1:0"], rest].concat();
    let no_bus = "a bus is missing: --slcan ADDRESS:PORT or --socketcan INTERFACE";
    assert_refused(&["serve"], no_bus);
    assert_refused(&["serve", "--node-id", "4"], no_bus);
    assert_refused(&["dance"], "dance");
    assert_refused(&["demo", "--node-id", "128"], "128");
    assert_refused(&["serve", "--slcan", "127.0.0.1:99999"], "127.0.0.1:99999");
    assert_refused(&["serve", "--slcan", "nonsense"], "nonsense");
    assert_refused(&["serve", "--slcan", "127.0.0.1"], "127.0.0.1");
    assert_refused(&serve(&["--node-id", "0"]), "--node-id");
    assert_refused(&serve(&["--node-id", "four"]), "four");
    assert_refused(
        &serve(&["--node-id", "4", "--unconfigured"]),
        "--unconfigured",
    );
    assert_refused(&serve(&["--bitrate", "100"]), "1000, 800");
    assert_refused(&serve(&["--serial", "0xGG"]), "0xGG");
    assert_refused(&serve(&["--switches", "100"]), "two hexadecimal digits");
    assert_refused(&serve(&["--switches", "GG"]), "two hexadecimal digits");
    assert_refused(
        &serve(&["--store", "/no/such/folder/drive.bin"]),
        "cannot use the store /no/such/folder/drive.bin: no such file or directory\n",
    );
}

#[test]
fn a_mistake_in_an_axis_is_one_line_with_its_place() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("axis.toml");
    std::fs::write(&path, "start = 1\nspeed = 5\n").unwrap();
    let path = path.to_str().unwrap();
    let serve = |plant| ["serve", "--slcan", "127.0.0.1:0", "--plant", plant];
    assert_refused(&serve(path), "axis.toml:2: unknown field `speed`");
    assert_refused(&serve("/dev/zero"), "it is no file");
    assert_refused(
        &serve("/no/such/axis.toml"),
        "cannot read /no/such/axis.toml: no such file or directory\n",
    );
}

#[test]
fn a_busy_port_is_one_line_and_exit_code_2() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    assert_refused(&["serve", "--slcan", &address], &address);
}

#[test]
fn a_missing_interface_is_one_line_and_exit_code_2() {
    assert_refused(&["serve", "--socketcan", "no-such-can0"], "no-such-can0");
}

#[test]
fn a_file_that_is_no_store_is_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("notes.txt");
    std::fs::write(&path, "important").unwrap();
    let file = path.to_str().unwrap();
    assert_refused(
        &["serve", "--slcan", "127.0.0.1:0", "--store", file],
        "not a parameter store",
    );
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "important");
}

#[cfg(unix)]
#[test]
fn what_is_no_file_is_no_store() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe");
    let made = Command::new("mkfifo").arg(&pipe).status().unwrap();
    assert!(made.success());
    for path in [pipe.to_str().unwrap(), "/dev/zero"] {
        assert_refused(
            &["serve", "--slcan", "127.0.0.1:0", "--store", path],
            "not a parameter store: it is no file",
        );
    }
}

#[test]
fn without_a_command_it_is_the_demonstration() {
    let (bare, named) = (run(&[]), run(&["demo"]));
    assert_eq!(bare.status.code(), Some(0));
    assert_eq!(bare.stdout, named.stdout);
    let text = String::from_utf8(bare.stdout).unwrap();
    assert!(text.contains("boot-up of node 4"), "{text}");
    assert!(text.contains("What to try next"), "{text}");
}

#[test]
fn the_demonstration_writes_its_picture() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("move.svg");
    let output = run(&["demo", "--plot", path.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0));
    assert!(std::fs::read_to_string(&path).unwrap().contains("Velocity"));
}

#[test]
fn a_picture_that_cannot_be_written_is_an_error() {
    let output = run(&["demo", "--plot", "/no/such/folder/move.svg"]);
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(
        String::from_utf8(output.stderr).unwrap(),
        "sim: cannot write the picture /no/such/folder/move.svg: no such file or directory\n"
    );
}

#[cfg(target_os = "linux")]
#[test]
fn output_that_cannot_be_written_is_an_error() {
    let full = std::fs::File::options()
        .write(true)
        .open("/dev/full")
        .unwrap();
    let output = sim().stdout(full).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(
        String::from_utf8(output.stderr).unwrap(),
        "sim: cannot write the output: no space left on device\n"
    );
}

#[cfg(unix)]
#[test]
fn output_that_is_closed_is_an_error() {
    for arguments in [
        "demo",
        "plan --distance 100 --velocity 100 --acceleration 100",
        "--version",
        "serve --help",
    ] {
        let command = format!("exec {} {arguments} >&-", env!("CARGO_BIN_EXE_sim"));
        let output = Command::new("sh").args(["-c", &command]).output().unwrap();
        let told = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments}: {told}");
        assert!(told.ends_with(": standard output is closed\n"), "{told}");
        assert_eq!(told.lines().count(), 1);
    }
}

#[test]
fn help_is_no_mistake() {
    for arguments in [&["--help"][..], &["serve", "--help"], &["--version"]] {
        assert_eq!(run(arguments).status.code(), Some(0));
    }
}

/// A server that is killed at the end, whatever happens.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl Running {
    /// Starts a server and waits until it is ready; returns it with the lines before `ready`.
    fn start(arguments: &[&str]) -> (Self, Vec<String>) {
        let child = sim()
            .args(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut running = Self(child);
        let output = BufReader::new(running.0.stdout.take().unwrap());
        let mut before = Vec::new();
        for line in output.lines() {
            let line = line.unwrap();
            if line == "ready" {
                return (running, before);
            }
            before.push(line);
        }
        let mut error = String::new();
        running
            .0
            .stderr
            .take()
            .unwrap()
            .read_to_string(&mut error)
            .unwrap();
        panic!("the server ended: {error}");
    }
}

#[cfg(unix)]
#[test]
fn a_server_runs_until_it_is_stopped() {
    for signal in ["-INT", "-TERM"] {
        let (mut running, before) =
            Running::start(&["serve", "--slcan", "127.0.0.1:0", "--node-id", "4"]);
        assert!(before[0].starts_with("SLCAN on 127.0.0.1:"), "{before:?}");
        // That of the shell: a bare Debian has no program of that name.
        let kill = Command::new("sh")
            .args(["-c", &format!("kill {signal} {}", running.0.id())])
            .status()
            .unwrap();
        assert!(kill.success());
        assert_eq!(running.0.wait().unwrap().code(), Some(0));
    }
}

#[test]
fn who_listens_beyond_this_computer_is_told_so() {
    let first_line_of_errors = |address| {
        let arguments = ["serve", "--slcan", address, "--node-id", "4"];
        let (mut running, _) = Running::start(&arguments);
        let errors = running.0.stderr.take().unwrap();
        drop(running);
        BufReader::new(errors).lines().next().transpose().unwrap()
    };
    let told = first_line_of_errors("0.0.0.0:0").unwrap();
    assert!(told.contains("open to the network"), "{told}");
    assert_eq!(first_line_of_errors("127.0.0.1:0"), None);
}

#[test]
fn a_store_serves_one_drive_at_a_time() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("drive.bin");
    let arguments = [
        "serve",
        "--slcan",
        "127.0.0.1:0",
        "--store",
        path.to_str().unwrap(),
    ];
    let (_running, _) = Running::start(&arguments);
    assert_refused(&arguments, "another drive uses it");
}

#[test]
fn a_factory_reset_forgets_the_settings_before_the_drive_starts() {
    use canopen::{BitRate, BitTiming, Configuration, NodeId};

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("drive.bin");
    let configured = Configuration {
        node_id: NodeId::new(9).unwrap(),
        bit_timing: BitTiming::Fixed(BitRate::Kbit125),
    };
    let store = || sim::flash::Flash::in_file(&path).unwrap().into_store();
    store().save(&configured).unwrap();
    let file = path.to_str().unwrap();
    let arguments = ["serve", "--slcan", "127.0.0.1:0", "--store", file];
    drop(Running::start(&arguments));
    assert_eq!(store().load(), Ok(Some(configured)));
    drop(Running::start(
        &[&arguments[..], &["--factory-reset"]].concat(),
    ));
    assert_eq!(store().load(), Ok(Some(Configuration::default())));
}

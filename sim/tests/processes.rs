//! Servers as processes of their own: clients that come and go, more of them than the computer has files for, and stores that are
//! damaged, foreign, or on a full disk.
#![cfg(target_os = "linux")]

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

/// The longest wait for something that must come; nothing waits so long unless a test fails.
const PATIENCE: Duration = Duration::from_secs(20);

/// A server of its own process; it ends with the test.
struct Server {
    process: Child,
    address: String,
}

impl Server {
    /// A drive of node-ID 4, in a process that may have so many files.
    fn start(files: u32) -> Self {
        Self::limited(&format!("-n {files}"), "--node-id 4")
    }

    /// A drive in a process with a limit of the shell.
    fn limited(limit: &str, arguments: &str) -> Self {
        let command = format!(
            "ulimit {limit}; exec {} serve --slcan 127.0.0.1:0 {arguments}",
            env!("CARGO_BIN_EXE_sim")
        );
        let mut process = Command::new("sh")
            .args(["-c", &command])
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(process.stdout.take().unwrap()).lines();
        let greeting = lines.next().unwrap().unwrap();
        let address = greeting.strip_prefix("SLCAN on ").unwrap().to_owned();
        assert_eq!(lines.next().unwrap().unwrap(), "ready");
        Self { process, address }
    }

    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(&self.address).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream
    }

    /// A client that has opened its channel, and so is served.
    fn client(&self) -> TcpStream {
        let mut stream = self.connect();
        open_channel(&mut stream);
        stream
    }

    /// The first line on standard error.
    fn told(&mut self) -> String {
        let mut told = String::new();
        BufReader::new(self.process.stderr.take().unwrap())
            .read_line(&mut told)
            .unwrap();
        told
    }

    /// How many entries a folder of the process has.
    fn count(&self, what: &str) -> usize {
        let folder = format!("/proc/{}/{what}", self.process.id());
        fs::read_dir(folder).unwrap().count()
    }

    /// Memory in use, in kilobytes.
    fn memory(&self) -> u64 {
        let status = fs::read_to_string(format!("/proc/{}/status", self.process.id())).unwrap();
        let line = status.lines().find(|line| line.starts_with("VmRSS:"));
        let number = line.unwrap().split_whitespace().nth(1);
        number.unwrap().parse().unwrap()
    }

    /// Waits until it is so.
    fn settles(&self, what: impl Fn(&Self) -> bool) -> bool {
        let end = Instant::now() + PATIENCE;
        while !what(self) {
            if Instant::now() > end {
                return false;
            }
            thread::sleep(Duration::from_millis(2));
        }
        true
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

fn open_channel(stream: &mut TcpStream) {
    stream.write_all(b"S8\rO\r").unwrap();
    let mut replies = [0; 2];
    stream.read_exact(&mut replies).unwrap();
    assert_eq!(replies, *b"\r\r");
}

#[test]
fn two_thousand_clients_come_and_go_and_leave_nothing_behind() {
    let server = Server::start(256);
    let (files, threads) = (server.count("fd"), server.count("task"));
    let turn = || {
        drop(server.client());
        // Some close without a word.
        drop(server.connect());
    };
    (0..50).for_each(|_| turn());
    assert!(server.settles(|server| server.count("task") == threads));
    let memory = server.memory();
    (50..1_000).for_each(|_| turn());
    assert!(server.settles(|server| server.count("task") == threads));
    assert!(server.settles(|server| server.count("fd") == files));
    let grown = server.memory().saturating_sub(memory);
    assert!(grown < 4_096, "{grown} kB");
}

#[test]
fn who_finds_no_room_is_served_when_others_have_left() {
    let mut server = Server::start(32);
    let mut clients: Vec<TcpStream> = (0..32).map(|_| server.connect()).collect();
    let mut told = String::new();
    BufReader::new(server.process.stderr.take().unwrap())
        .read_line(&mut told)
        .unwrap();
    assert_eq!(told, "cannot serve another client: too many open files\n");
    let mut last = clients.pop().unwrap();
    drop(clients);
    open_channel(&mut last);
}

/// Sends a request and waits for the answer that begins so.
fn ask(stream: &mut TcpStream, request: &str, answer: &str) -> String {
    stream.write_all(format!("{request}\r").as_bytes()).unwrap();
    let mut line = String::new();
    loop {
        let mut byte = [0];
        stream.read_exact(&mut byte).unwrap();
        match byte {
            [b'\r'] if line.starts_with(answer) => return line,
            [b'\r'] => line.clear(),
            [byte] => line.push(char::from(byte)),
        }
    }
}

fn save(stream: &mut TcpStream) -> String {
    ask(stream, "t60482310100173617665", "t58")
}

/// 6083h, profile acceleration.
const READ_ACCELERATION: &str = "t60484083600000000000";
const WRITE_ACCELERATION: &str = "t6048238360003F420F00";

#[test]
fn a_file_with_something_else_is_told_and_kept() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("picture.raw");
    let picture: Vec<u8> = (0..32_768_u32).map(|n| (n * n % 251) as u8).collect();
    fs::write(&path, &picture).unwrap();
    let arguments = format!("--node-id 4 --store {}", path.display());
    let mut server = Server::limited("-n 64", &arguments);
    let mut client = server.client();
    // The emergency may have gone before the client came: 1003h keeps it.
    let lost = ask(&mut client, "t60484003100100000000", "t584843031001");
    assert!(lost.starts_with("t5848430310011063"), "{lost}");
    let refused = save(&mut client);
    assert_eq!(refused, "t58488010100100000606");
    let told = server.told();
    assert!(
        told.contains("holds something else than parameters"),
        "{told}"
    );
    drop(server);
    assert_eq!(fs::read(&path).unwrap(), picture);
}

#[test]
fn a_store_whose_newest_records_were_overwritten_is_told_until_the_next_save() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("drive.bin");
    let arguments = format!("--node-id 4 --store {}", path.display());
    let mut client = {
        let server = Server::limited("-n 64", &arguments);
        let mut client = server.client();
        ask(&mut client, WRITE_ACCELERATION, "t58486083");
        assert_eq!(&save(&mut client)[..7], "t584860");
        drop(server);
        client
    };
    assert_eq!(client.read(&mut [0]).unwrap_or(0), 0);
    let mut bytes = fs::read(&path).unwrap();
    let end = bytes.iter().rposition(|byte| *byte != 0xFF).unwrap();
    bytes[end - 40..=end].fill(0x5A);
    fs::write(&path, bytes).unwrap();
    let mut server = Server::limited("-n 64", &arguments);
    let mut client = server.client();
    let lost = ask(&mut client, "t60484003100100000000", "t584843031001");
    assert!(lost.starts_with("t5848430310011063"), "{lost}");
    let told = server.told();
    assert!(told.contains("is damaged"), "{told}");
    assert_eq!(&save(&mut client)[..7], "t584860");
    drop(server);
    let server = Server::limited("-n 64", &arguments);
    let none = ask(&mut server.client(), "t60484003100000000000", "t5848");
    assert_eq!(none, "t58484F03100000000000");
}

#[test]
fn a_save_without_room_leaves_what_was_there() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("drive.bin");
    let arguments = format!("--node-id 4 --store {}", path.display());
    let acceleration = |client: &mut TcpStream| ask(client, READ_ACCELERATION, "t5848438360");
    // Not even a new file.
    let mut refused = Command::new("sh");
    let command = format!(
        "ulimit -f 8; exec {} serve --slcan 127.0.0.1:0 {arguments}",
        env!("CARGO_BIN_EXE_sim")
    );
    let refused = refused.args(["-c", &command]).output().unwrap();
    assert_eq!(refused.status.code(), Some(2), "{refused:?}");
    let told = String::from_utf8(refused.stderr).unwrap();
    assert!(told.contains("file too large"), "{told}");
    let saved = {
        let server = Server::limited("-n 64", &arguments);
        let mut client = server.client();
        ask(&mut client, WRITE_ACCELERATION, "t58486083");
        assert_eq!(&save(&mut client)[..7], "t584860");
        acceleration(&mut client)
    };
    {
        // It is written from the front: what it holds already is beyond the limit.
        let server = Server::limited("-f 0", &arguments);
        let mut client = server.client();
        ask(
            &mut client,
            &WRITE_ACCELERATION.replace("3F", "11"),
            "t58486083",
        );
        assert_ne!(acceleration(&mut client), saved);
        assert_eq!(save(&mut client), "t58488010100100000606");
    }
    let server = Server::limited("-n 64", &arguments);
    assert_eq!(acceleration(&mut server.client()), saved);
}

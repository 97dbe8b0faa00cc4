//! Clients that come and go, and more of them than the computer has files for.
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
    /// A drive, in a process that may have so many files.
    fn start(files: u32) -> Self {
        let command = format!(
            "ulimit -n {files}; exec {} serve --slcan 127.0.0.1:0 --node-id 4",
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

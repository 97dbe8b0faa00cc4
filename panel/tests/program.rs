//! The program itself, as `axis402 panel` runs it: how it starts and ends, and who may talk to it. No browser.

use std::io::{BufRead, BufReader, Read};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

use serde_json::{Value, json};
use tungstenite::client::IntoClientRequest;
use tungstenite::http::StatusCode;
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Error, Message, WebSocket, connect};

/// Only a program that hangs takes so long.
const PATIENCE: Duration = Duration::from_secs(60);

fn program(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_axis402-panel"));
    command.args(arguments).stdin(Stdio::null());
    command
}

fn run(arguments: &[&str]) -> Output {
    program(arguments).output().unwrap()
}

/// A panel that runs; it ends with the test.
struct Panel {
    process: Child,
    address: SocketAddr,
    greeting: Vec<String>,
}

impl Panel {
    fn start(arguments: &[&str]) -> Self {
        let mut process = program(arguments).stdout(Stdio::piped()).spawn().unwrap();
        let output = BufReader::new(process.stdout.take().unwrap());
        let lines = output.lines().map(Result::unwrap);
        let greeting: Vec<String> = lines.take_while(|line| line != "ready").collect();
        let told = greeting
            .last()
            .unwrap()
            .strip_prefix("panel on http://")
            .unwrap();
        let address = told.split('/').next().unwrap().parse().unwrap();
        Self {
            process,
            address,
            greeting,
        }
    }

    fn with_virtual_drive(arguments: &[&str]) -> Self {
        Self::start(&[&["--virtual", "--listen", "127.0.0.1:0"], arguments].concat())
    }

    /// Opens a window as a page with this origin would.
    fn open_as(&self, origin: &str, query: &str) -> Result<Window, Error> {
        let url = format!("ws://{}/ws{query}", self.address);
        let mut request = url.into_client_request()?;
        request
            .headers_mut()
            .insert("Origin", origin.parse().unwrap());
        let (socket, _) = connect(request)?;
        if let MaybeTlsStream::Plain(stream) = socket.get_ref() {
            stream.set_read_timeout(Some(PATIENCE)).unwrap();
        }
        Ok(Window { socket, last: 0 })
    }

    fn open(&self) -> Window {
        self.open_as(&format!("http://{}", self.address), "")
            .unwrap()
    }

    fn signal(&mut self, signal: &str) -> Option<i32> {
        let id = self.process.id().to_string();
        assert!(
            Command::new("kill")
                .args([signal, &id])
                .status()
                .unwrap()
                .success()
        );
        self.process.wait().unwrap().code()
    }
}

impl Drop for Panel {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// A window without a browser.
struct Window {
    socket: WebSocket<MaybeTlsStream<TcpStream>>,
    last: u64,
}

impl Window {
    /// The next message that is this.
    fn next(&mut self, is: &str) -> Value {
        loop {
            if let Message::Text(text) = self.socket.read().unwrap() {
                let event: Value = serde_json::from_str(&text).unwrap();
                if event["is"] == is {
                    return event;
                }
            }
        }
    }

    /// The first state for which this is so.
    fn wait_until(&mut self, is: impl Fn(&Value) -> bool) -> Value {
        loop {
            let state = self.next("state");
            if is(&state) {
                return state;
            }
        }
    }

    /// Orders something; returns what came of it.
    fn order(&mut self, mut order: Value) -> Result<Value, String> {
        self.last += 1;
        order["id"] = self.last.into();
        self.socket.send(Message::text(order.to_string())).unwrap();
        loop {
            let reply = self.next("reply");
            if reply["id"] == self.last {
                return match reply.get("error") {
                    Some(why) => Err(why.as_str().unwrap().to_owned()),
                    None => Ok(reply["done"].clone()),
                };
            }
        }
    }

    fn done(&mut self, order: Value) -> Value {
        self.order(order.clone())
            .unwrap_or_else(|why| panic!("{order}: {why}"))
    }
}

#[test]
fn what_cannot_be_is_one_line_and_exit_code_2() {
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let busy = taken.local_addr().unwrap().to_string();
    let cases: [(&[&str], &str); 8] = [
        (&["--virtual", "--listen", &busy], "address already in use"),
        (
            &["--slcan", "/dev/no-such-port", "--listen", "127.0.0.1:0"],
            "cannot use the SLCAN adapter",
        ),
        (
            &["--socketcan", "no-such-can", "--listen", "127.0.0.1:0"],
            "cannot open the CAN interface",
        ),
        (&["--listen", "127.0.0.1:0"], "a bus is missing"),
        (
            &[
                "--virtual",
                "--plant",
                "no-such-file.toml",
                "--listen",
                "127.0.0.1:0",
            ],
            "no such file",
        ),
        (
            &["--virtual", "--axis", "nothing", "--listen", "127.0.0.1:0"],
            "invalid value 'nothing' for '--axis <NAME>'",
        ),
        (
            &["--axis", "servo_100w", "--listen", "127.0.0.1:0"],
            "--virtual",
        ),
        (
            &[
                "--virtual",
                "--eds",
                "no-such-file.eds",
                "--listen",
                "127.0.0.1:0",
            ],
            "no such file",
        ),
    ];
    for (arguments, expected) in cases {
        let output = run(arguments);
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        assert!(
            error.starts_with("axis402 panel: ") && error.contains(expected),
            "{error}"
        );
        assert_eq!(error.lines().count(), 1, "{error}");
        assert!(output.stdout.is_empty());
    }
}

#[test]
fn it_is_ready_when_it_says_so_and_ends_when_it_is_told() {
    let mut panel = Panel::with_virtual_drive(&[]);
    assert!(panel.greeting[0].starts_with("virtual drive, SLCAN on 127.0.0.1:"));
    let mut window = panel.open();
    assert_eq!(window.next("hello")["read_only"], false);
    window.wait_until(|state| state["bus"]["title"] == "virtual drive");
    assert_eq!(panel.signal("-INT"), Some(0));
    // The window hears of it.
    let end = loop {
        match window.socket.read() {
            Ok(Message::Close(_)) | Err(_) => break true,
            Ok(_) => {}
        }
    };
    assert!(end);
}

#[test]
fn the_virtual_drive_has_a_servo_that_needs_no_data_sheet() {
    let panel = Panel::with_virtual_drive(&["--axis", "servo_100w"]);
    let mut window = panel.open();
    window.done(json!({"do": "number", "first": 4, "store": false}));
    window.done(json!({"do": "choose", "node": 4}));
    window.wait_until(|state| state["drive"]["can_tune"] == true);
    let dictionary = window.done(json!({"do": "dictionary", "node": 4}));
    assert_eq!(dictionary["title"], "servo.eds");
    assert_eq!(window.done(json!({"do": "tuned"}))["node"], 4);
}

#[test]
fn from_a_drive_without_a_node_id_to_a_finished_move() {
    let panel = Panel::with_virtual_drive(&[]);
    let mut window = panel.open();
    window.done(json!({"do": "scan"}));
    let state = window.wait_until(|state| state["bus"]["unnumbered"] == true);
    assert_eq!(state["nodes"], json!([]));
    let told = window.done(json!({"do": "number", "first": 4, "store": true}));
    assert_eq!(told, "1 device has a node-ID now");
    window.done(json!({"do": "choose", "node": 4}));
    window.wait_until(|state| state["drive"]["state"] == "switch_on_disabled");
    window.done(json!({"do": "enable"}));
    window.done(json!({"do": "move", "target": 2_000, "relative": false, "velocity": 5_000}));
    let state = window.wait_until(|state| state["drive"]["position"] == 2_000);
    assert_eq!(state["drive"]["guard"], "on");
    let why = window.order(json!({"do": "write", "node": 4, "object": "6007", "value": "9"}));
    assert_eq!(
        why.unwrap_err(),
        "6007h:00 Abort connection option code: 9 is above 3"
    );
}

#[test]
fn a_lost_window_ends_its_jog_and_a_closed_panel_stops() {
    let panel = Panel::with_virtual_drive(&[]);
    let mut window = panel.open();
    window.done(json!({"do": "number", "first": 4, "store": false}));
    window.done(json!({"do": "choose", "node": 4}));
    window.done(json!({"do": "enable"}));
    let mut watcher = panel.open();
    let why = watcher.order(json!({"do": "jog", "velocity": 1_000}));
    assert_eq!(
        why.unwrap_err(),
        "another window has control: take it first"
    );
    window.done(json!({"do": "jog", "velocity": 1_000}));
    drop(window);
    let state = watcher.wait_until(|state| state["drive"]["jogging"] == false);
    assert_eq!(state["drive"]["state"], "operation_enabled");
    watcher.wait_until(|state| state["drive"]["velocity"] == 0);
    // Any window may stop.
    watcher.done(json!({"do": "stop"}));
    watcher.wait_until(|state| state["drive"]["state"] == "switch_on_disabled");
    watcher.done(json!({"do": "take"}));
    watcher.done(json!({"do": "enable"}));
    drop(watcher);
    let mut last = panel.open();
    last.wait_until(|state| state["drive"]["state"] == "switch_on_disabled");
    let guard = last.done(json!({"do": "read", "node": 4, "object": "1016:1"}));
    assert_eq!(guard, "0");
}

#[test]
fn a_window_that_answers_nothing_is_closed() {
    let panel = Panel::with_virtual_drive(&[]);
    // It reads nothing, so it answers no ping: its cable may be out.
    let _silent = panel.open();
    let mut watcher = panel.open();
    let first = watcher.next("writer");
    assert!(first["window"].is_number(), "{first}");
    let second = watcher.next("writer");
    assert!(second["window"].is_null(), "{second}");
}

#[test]
fn only_its_own_pages_are_heard() {
    let panel = Panel::with_virtual_drive(&["--read-only"]);
    let status = |result: Result<Window, Error>| match result {
        Err(Error::Http(response)) => response.status(),
        Err(other) => panic!("{other}"),
        Ok(_) => StatusCode::SWITCHING_PROTOCOLS,
    };
    assert_eq!(
        status(panel.open_as("http://evil.example", "")),
        StatusCode::FORBIDDEN
    );
    assert_eq!(status(panel.open_as("null", "")), StatusCode::FORBIDDEN);
    let mut window = panel.open();
    assert_eq!(window.next("hello")["read_only"], true);
    window.done(json!({"do": "scan"}));
    let why = window.order(json!({"do": "number", "first": 4, "store": true}));
    assert_eq!(
        why.unwrap_err(),
        "the panel was started with --read-only: nothing is written"
    );
}

#[test]
fn beyond_this_computer_a_token_is_needed() {
    let panel = Panel::start(&["--virtual", "--listen", "0.0.0.0:0"]);
    let token = panel
        .greeting
        .last()
        .unwrap()
        .split("?token=")
        .nth(1)
        .unwrap();
    let address = SocketAddr::from(([127, 0, 0, 1], panel.address.port()));
    let own = format!("http://{address}");
    let panel_here = |query: &str| {
        let url = format!("ws://{address}/ws{query}");
        let mut request = url.into_client_request().unwrap();
        request.headers_mut().insert("Origin", own.parse().unwrap());
        connect(request).map(|_| ())
    };
    for query in ["", "?token=", "?token=00000000000000000000000000000000"] {
        let refused = panel_here(query);
        assert!(
            matches!(&refused, Err(Error::Http(response)) if response.status() == StatusCode::UNAUTHORIZED),
            "{refused:?}"
        );
    }
    panel_here(&format!("?token={token}")).unwrap();
}

#[test]
fn the_page_is_served_with_a_policy_that_loads_nothing_from_elsewhere() {
    let panel = Panel::with_virtual_drive(&[]);
    let fetch = |path: &str| {
        use std::io::Write;
        let mut stream = TcpStream::connect(panel.address).unwrap();
        let request = format!(
            "GET {path} HTTP/1.1\r\nHost: {}\r\nConnection: close\r\n\r\n",
            panel.address
        );
        stream.write_all(request.as_bytes()).unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        answer
    };
    let page = fetch("/");
    assert!(
        page.starts_with("HTTP/1.1 200") && page.contains("<!doctype html>"),
        "{page}"
    );
    assert!(
        page.contains("content-security-policy: default-src 'none'; script-src 'self'"),
        "{page}"
    );
    assert!(fetch("/app.js").contains("content-type: text/javascript"));
    assert!(fetch("/../Cargo.toml").starts_with("HTTP/1.1 404"));
}

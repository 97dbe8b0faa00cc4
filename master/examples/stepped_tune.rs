//! `axis402 tune` in the time of a drive that is another program: `tests/machine/tuner.py` lets it
//! measure the motor of the modelled board.
//!
//! It writes lines: `t6048400010000000`, a frame as an SLCAN adapter takes it, and `@120000`, which
//! asks for time to pass up to that microsecond, or to the first frame. To that it is answered with
//! the frames and the time: `t5848430010000000`, `@100250`. Its last line is `= {...}`, what was
//! found, or `! why not`. `stepped_tune NODE [--write]` measures the motor and records no frequency
//! response.

use std::io::{self, BufRead, Write};
use std::process::ExitCode;

use canopen::{BitRate, Frame, Instant};
use master::axis402::{Console, Node, Problem, Tuning, tune};
use master::{Inbox, Line, LineDown, Master};
use slcan::{Command, Decoder, encode};

/// The lines of this program.
#[derive(Debug)]
struct Stepped {
    now: Instant,
    inbox: Inbox,
}

impl Stepped {
    /// Time passes. Returns whether a frame has come.
    fn pass(&mut self, end: Instant) -> io::Result<bool> {
        println!("@{}", end.ticks());
        io::stdout().flush()?;
        let mut frames = Vec::new();
        for line in io::stdin().lock().lines() {
            let line = line?;
            if let Some(time) = line.strip_prefix('@') {
                let ticks = time.parse().map_err(io::Error::other)?;
                self.now = Instant::from_ticks(ticks);
                let came = !frames.is_empty();
                for frame in frames {
                    self.inbox.put(self.now, frame);
                }
                return Ok(came);
            }
            frames.push(frame(&line).ok_or_else(|| io::Error::other(line))?);
        }
        Err(io::ErrorKind::UnexpectedEof.into())
    }
}

fn frame(line: &str) -> Option<Frame> {
    let mut decoder = Decoder::new();
    let mut commands = (line.bytes().chain(*b"\r")).filter_map(|byte| decoder.push(byte));
    match commands.next() {
        Some(Command::Frame(frame)) => Some(frame),
        _ => None,
    }
}

impl Line for Stepped {
    fn now(&self) -> Instant {
        self.now
    }

    fn send(&mut self, frame: Frame) {
        println!("{}", String::from_utf8_lossy(&encode(&frame)).trim_end());
    }

    fn inbox(&mut self) -> &mut Inbox {
        &mut self.inbox
    }

    fn step(&mut self, end: Instant) -> Result<bool, LineDown> {
        self.pass(end).map_err(|error| LineDown(error.to_string()))
    }

    fn set_bit_rate(&mut self, _: BitRate) -> Result<bool, LineDown> {
        Ok(false)
    }
}

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let Some(id) = arguments.next().and_then(|id| id.parse().ok()) else {
        eprintln!("Usage: stepped_tune NODE [--write]");
        return ExitCode::from(2);
    };
    let wanted = Tuning {
        is_short: true,
        json: true,
        writes: arguments.next().is_some(),
        ..Tuning::default()
    };
    let (mut output, mut progress) = (Vec::new(), io::stderr());
    let mut console = Console::new(&mut output, &mut progress, false);
    let line = Stepped {
        now: Instant::from_ticks(0),
        inbox: Inbox::default(),
    };
    let mut master = Master::on(line);
    let result = Node::meet(&mut master, id, None)
        .and_then(|node| tune(&mut master, &node, &wanted, &mut console));
    drop(console);
    match result {
        Ok(()) => println!("= {}", String::from_utf8_lossy(&output).trim_end()),
        Err(problem) => println!("! {}", Problem::line(&problem).unwrap_or_default()),
    }
    ExitCode::SUCCESS
}

//! A measurement from beginning to end: power, work, and everything as it was.

use canopen::Duration;

use super::motor::{self, number, result};
use super::{Found, Host, Motor, Point, Stage, Wanted, response, write};
use crate::Failure;
use crate::axis402::{Node, Problem};
use crate::data_sheet::Address;
use crate::scope::{self, Before, Channel, Progress, Recording, Request, Trigger};
use crate::trace;

const fn order(sub: u8) -> Address {
    Address::new(0x20C0, sub)
}

const MODE: Address = Address::new(0x6060, 0);
const CONTROLWORD: Address = Address::new(0x6040, 0);
const STATUSWORD: Address = Address::new(0x6041, 0);
const TARGET: Address = Address::new(0x607A, 0);

/// The values of 20C0h:1.
const END: u8 = 0;
const MEASURE: u8 = 1;
const EXCITE: u8 = 2;

/// The values of 20C1h:1 that end it.
const DONE: u32 = 6;
const FAILED: u32 = 7;

/// The value of 20C1h:2 that has a fault beside it.
const POWER_OFF: u32 = 1;

/// How often the drive is asked how far it is.
const PAUSE: Duration = Duration::from_ticks(50_000);

/// How long a measurement may take.
const LONGEST: Duration = Duration::from_ticks(60_000_000);

/// How long a change of the state may take.
const SOON: Duration = Duration::from_ticks(3_000_000);

/// What the scope records for the response: 6074h and 6063h.
const CHANNELS: [u32; 2] = [0x6074_0010, 0x6063_0020];

/// What it records for a step: 6062h and 6064h.
const STEP_CHANNELS: [u32; 2] = [0x6062_0020, 0x6064_0020];

/// What a step changes beside the position.
const STEP: [Address; 4] = [
    Address::new(0x6081, 0),
    Address::new(0x6083, 0),
    Address::new(0x6084, 0),
    TARGET,
];

/// What of the scope is set up: 20D0h:3 to 6, 20D1h:1 to 8.
const SCOPE: [Address; 12] = [
    Address::new(0x20D0, 3),
    Address::new(0x20D0, 4),
    Address::new(0x20D0, 5),
    Address::new(0x20D0, 6),
    Address::new(0x20D1, 1),
    Address::new(0x20D1, 2),
    Address::new(0x20D1, 3),
    Address::new(0x20D1, 4),
    Address::new(0x20D1, 5),
    Address::new(0x20D1, 6),
    Address::new(0x20D1, 7),
    Address::new(0x20D1, 8),
];

pub(super) struct Bench<'a, H> {
    host: &'a mut H,
    node: &'a Node,
    /// What is put back, in its order.
    before: Vec<(Address, Vec<u8>)>,
    records: bool,
}

impl<'a, H: Host> Bench<'a, H> {
    pub(super) fn new(host: &'a mut H, node: &'a Node) -> Self {
        Self {
            host,
            node,
            before: Vec::new(),
            records: false,
        }
    }

    pub(super) fn run(mut self, wanted: &Wanted) -> Result<Found, Problem> {
        let state = match self.upload(result(1)) {
            Ok(bytes) => number(&bytes),
            Err(Failure::Abort { .. }) => {
                return Err(self.failed("it has no motor that it could measure: 20C1h is missing"));
            }
            Err(failure) => return Err(Problem::with_node(self.node.id, failure)),
        };
        if (1..DONE).contains(&state) {
            return Err(self.failed("it is being measured already"));
        }
        if motor::has_power(self.value(STATUSWORD)?) {
            return Err(self.failed("its power stage is on: another master may be moving it"));
        }
        self.keep(&[MODE, order(2), order(4)])?;
        let outcome = self.work(wanted);
        self.host.conclude();
        // A motor that may still have power is told of before anything else.
        let refused = self.conclude()?;
        let found = outcome?;
        refused.map_or(Ok(found), Err)
    }

    /// Whatever became of it, the motor has no power, and the rest is as it was. One value that is refused does not keep the others from it; the first is returned.
    fn conclude(&mut self) -> Result<Option<Problem>, Problem> {
        let mut first = None;
        let mut has_power = true;
        let ends = [
            (order(1), [END].to_vec()),
            (CONTROLWORD, [0x06, 0].to_vec()),
        ];
        let before = std::mem::take(&mut self.before);
        let mut stops = std::mem::take(&mut self.records);
        for (address, bytes) in ends.into_iter().chain(before) {
            if stops && address == SCOPE[0] {
                // A recorder that is at work cannot be set up.
                stops = false;
                let stopped = scope::disarm(self.host.master(), self.node);
                first = first.or(stopped.err());
            }
            match self.node.download(self.host.master(), address, &bytes) {
                Ok(()) => has_power &= address != CONTROLWORD,
                Err(failure @ Failure::Abort { .. }) => {
                    first = first.or(Some(Problem::with_node(self.node.id, failure)));
                }
                Err(failure) => {
                    let line = Problem::with_node(self.node.id, failure).line();
                    let line = line.unwrap_or_else(|| format!("node {}", self.node.id));
                    let what = if has_power {
                        "its motor may still have power"
                    } else {
                        "its motor has no power, but not all is as it was"
                    };
                    return Err(Problem::Failed(format!("{line}: {what}")));
                }
            }
        }
        Ok(first)
    }

    /// These are put back at the end.
    fn keep(&mut self, addresses: &[Address]) -> Result<(), Problem> {
        for &address in addresses {
            if !self.before.iter().any(|(kept, _)| *kept == address) {
                let bytes = self.bytes(address)?;
                self.before.push((address, bytes));
            }
        }
        Ok(())
    }

    fn work(&mut self, wanted: &Wanted) -> Result<Found, Problem> {
        if let Some(current) = wanted.current {
            self.write(order(2), &current.to_le_bytes())?;
        }
        if let Some(bandwidth) = wanted.bandwidth {
            self.write(order(4), &bandwidth.to_le_bytes())?;
        }
        let mut found = Found::default();
        self.enable()?;
        if wanted.motor {
            self.order(MEASURE)?;
            self.wait_for_result()?;
            let motor = Motor::read(|address| self.value(address))?;
            if wanted.writes {
                self.write(CONTROLWORD, &[0x06, 0])?;
                self.comes_to(0x21)?;
                write(self.host, self.node, &motor)?;
                found.is_written = true;
                self.enable()?;
            }
            found.motor = Some(motor);
        }
        if wanted.response {
            found.response = self.respond()?;
        }
        if wanted.step {
            found.step = self.step()?;
        }
        Ok(found)
    }

    fn order(&mut self, command: u8) -> Result<(), Problem> {
        self.write(order(1), &[command])?;
        // The drive looks once in a control tick; until then the last result stands.
        self.host.pause(Duration::from_ticks(5_000))
    }

    fn wait_for_result(&mut self) -> Result<(), Problem> {
        let end = self.host.master().now() + LONGEST;
        loop {
            self.host.pause(PAUSE)?;
            match self.value(result(1))? {
                DONE => return Ok(()),
                FAILED => {
                    let why = self.value(result(2))?;
                    let what = match why {
                        POWER_OFF => format!("the power stage went off by {}", self.fault()?),
                        other => reason(other),
                    };
                    return Err(self.failed(&what));
                }
                0 => return Err(self.failed("it knows of no measurement: has it started anew?")),
                3 => self.host.at(Stage::Field),
                4 => self.host.at(Stage::Strokes),
                _ => self.host.at(Stage::Winding),
            }
            if self.host.master().now() >= end {
                return Err(self.failed("the measurement does not end"));
            }
        }
    }

    /// The frequency response: the scope records while the drive adds a sine to the torque.
    fn respond(&mut self) -> Result<Vec<Point>, Problem> {
        self.host.at(Stage::Response);
        let time = self.value(order(8))?;
        // A little more than the sine takes, as it begins a little later.
        let [torque, position] =
            self.recorded(CHANNELS, time + 200, |bench| bench.order(EXCITE))?;
        let rated = f64::from(self.value(Address::new(0x6076, 0))?) * 1e-3;
        let radian = std::f64::consts::TAU / self.turn()?;
        let first = f64::from(self.value(order(6))?) * 0.1;
        let last = f64::from(self.value(order(7))?) * 0.1;
        // Whatever the data sheet knows of them, both have signs.
        let newton_metres = |value: &i64| f64::from(*value as i16) * 1e-3 * rated;
        let radians = |value: &i64| f64::from(*value as i32) * radian;
        let torque: Vec<f64> = torque.values.iter().map(newton_metres).collect();
        let angle: Vec<f64> = position.values.iter().map(radians).collect();
        Ok(response(&torque, &angle, self.period()?, (first, last)))
    }

    /// A move so short and so quick that it is a step to the loops.
    fn step(&mut self) -> Result<Vec<(f64, i32, i32)>, Problem> {
        self.host.at(Stage::Step);
        self.keep(&STEP)?;
        let way = (self.turn()? / 100.0).max(1.0) as i32;
        // There in some 8 ms.
        let quick = (f64::from(way) * 6e4) as u32;
        let target = self.value(Address::new(0x6064, 0))?.cast_signed();
        for address in [Address::new(0x6083, 0), Address::new(0x6084, 0)] {
            self.write(address, &quick.to_le_bytes())?;
        }
        let fast = (f64::from(way) * 2e3) as u32;
        self.write(Address::new(0x6081, 0), &fast.to_le_bytes())?;
        let target = target.wrapping_add(way);
        let [demand, actual] = self.recorded(STEP_CHANNELS, 250, |bench| {
            bench.write(TARGET, &target.to_le_bytes())?;
            bench.write(CONTROLWORD, &[0x3F, 0])?;
            bench.write(CONTROLWORD, &[0x0F, 0])
        })?;
        let period = self.period()?;
        let begin = actual.values.first().map_or(0, |value| *value as i32);
        let from = |value: &i64| (*value as i32).wrapping_sub(begin);
        let positions = demand
            .values
            .iter()
            .map(from)
            .zip(actual.values.iter().map(from));
        let samples = positions.enumerate();
        let all: Vec<_> = samples
            .map(|(n, (demand, actual))| (n as f64 * period, demand, actual))
            .collect();
        // From a little before the step on.
        let moved = all.iter().position(|(_, demand, _)| *demand != 0);
        let first = moved.unwrap_or(0).saturating_sub(5);
        let shown = all.iter().skip(first).take(60);
        let start = all.get(first).map_or(0.0, |(time, _, _)| *time);
        Ok(shown
            .map(|(time, demand, actual)| (time - start, *demand, *actual))
            .collect())
    }

    /// Increments of a turn.
    fn turn(&mut self) -> Result<f64, Problem> {
        let counts = f64::from(self.value(Address::new(0x608F, 1))?.max(1));
        let turns = f64::from(self.value(Address::new(0x608F, 2))?.max(1));
        Ok(counts / turns)
    }

    /// The control tick, in s.
    fn period(&mut self) -> Result<f64, Problem> {
        Ok(f64::from(self.value(Address::new(0x20D0, 9))?.max(1)) * 1e-9)
    }

    /// Two values for so many ms while something happens.
    fn recorded(
        &mut self,
        channels: [u32; 2],
        time: u32,
        happen: impl FnOnce(&mut Self) -> Result<(), Problem>,
    ) -> Result<[Channel; 2], Problem> {
        self.keep(&SCOPE)?;
        self.records = true;
        let recording = self.record(channels, time, happen)?;
        let channels = <[Channel; 2]>::try_from(recording.channels);
        channels.map_err(|_| self.failed("the scope has not recorded what it was told to"))
    }

    fn record(
        &mut self,
        channels: [u32; 2],
        time: u32,
        happen: impl FnOnce(&mut Self) -> Result<(), Problem>,
    ) -> Result<Recording, Problem> {
        let samples = (f64::from(time) * 1e-3 / self.period()?).min(f64::from(u16::MAX)) as u16;
        let bytes: u32 = channels.iter().map(|mapping| (mapping & 0xFF) / 8).sum();
        let memory = self.value(Address::new(0x20D0, 8))? / bytes;
        let request = Request {
            channels: Some(channels.to_vec()),
            divider: Some(1),
            samples: Some(samples.min(u16::try_from(memory).unwrap_or(u16::MAX))),
            before: Some(Before::Samples(0)),
            trigger: Trigger::Now,
            patience: LONGEST,
        };
        let mut armed = scope::arm(self.host.master(), self.node, &request)?;
        armed.progress(self.host.master(), self.node)?;
        happen(self)?;
        let end = self.host.master().now() + LONGEST;
        while armed.progress(self.host.master(), self.node)? != Progress::Full {
            if self.host.master().now() >= end {
                return Err(self.failed("the recording is not done"));
            }
            self.host.pause(PAUSE)?;
        }
        scope::fetch(self.host.master(), self.node)
    }

    /// Profile position, in operation enabled.
    fn enable(&mut self) -> Result<(), Problem> {
        self.host.at(Stage::Enabling);
        self.write(MODE, &[1])?;
        for (controlword, state) in [(0x06, 0x21), (0x07, 0x23), (0x0F, 0x27)] {
            self.write(CONTROLWORD, &[controlword, 0])?;
            self.comes_to(state)?;
        }
        Ok(())
    }

    fn comes_to(&mut self, state: u32) -> Result<(), Problem> {
        let end = self.host.master().now() + SOON;
        loop {
            let statusword = self.value(STATUSWORD)?;
            if statusword & 0x6F == state {
                return Ok(());
            }
            if statusword & 0x4F == 0x08 {
                let fault = self.fault()?;
                return Err(self.failed(&format!("it has {fault}")));
            }
            if self.host.master().now() >= end {
                let [is, wanted] = [statusword, state].map(|word| trace::statusword(word as u16));
                return Err(self.failed(&format!("6041h is {is}, and does not come to {wanted}")));
            }
            self.host.pause(Duration::from_ticks(10_000))?;
        }
    }

    /// 603Fh in words.
    fn fault(&mut self) -> Result<String, Problem> {
        let code = self.value(Address::new(0x603F, 0))? as u16;
        let words = trace::error_words(code).unwrap_or("of its maker");
        Ok(format!("fault {code:04X}h, {words}"))
    }

    fn failed(&self, what: &str) -> Problem {
        Problem::Failed(format!("node {}: {what}", self.node.id))
    }

    fn upload(&mut self, address: Address) -> Result<Vec<u8>, Failure> {
        self.node.upload(self.host.master(), address)
    }

    fn bytes(&mut self, address: Address) -> Result<Vec<u8>, Problem> {
        let bytes = self.upload(address);
        bytes.map_err(|failure| Problem::with_node(self.node.id, failure))
    }

    fn value(&mut self, address: Address) -> Result<u32, Problem> {
        Ok(number(&self.bytes(address)?))
    }

    fn write(&mut self, address: Address, bytes: &[u8]) -> Result<(), Problem> {
        let written = self.node.download(self.host.master(), address, bytes);
        written.map_err(|failure| Problem::with_node(self.node.id, failure))
    }
}

/// 20C1h:2 in words.
fn reason(failure: u32) -> String {
    let what = match failure {
        2 => "no current flows, or the winding is none",
        3 => {
            "the encoder does not see that the rotor turns: is it held or too heavy, is the encoder connected?"
        }
        4 => {
            "the way of the encoder is no whole number of pole pairs, or fewer than 20 counts for each: is its resolution right?"
        }
        5 => "the current does not move the rotor: is it held, or too heavy?",
        6 => "the rotor has gone further than it may: does something drive it, or is it too heavy?",
        7 => "somebody else has ended the measurement",
        8 => "the drive cannot do that now",
        other => return format!("the measurement failed with {other}"),
    };
    what.to_owned()
}

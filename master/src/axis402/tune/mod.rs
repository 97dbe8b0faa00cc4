//! `axis402 tune`: a drive with a servo measures its motor; gains for its loops; its frequency response through the scope.
//!
//! It speaks to any drive with the objects 20C0h to 20C2h (`docs/servo.md`). The motor moves. What is found is written only where that is asked for; everything that is
//! changed for the measurement is put back.

mod report;
mod response;

use std::path::PathBuf;

use canopen::Duration;
use serde::Serialize;

use super::{Console, Node, Problem};
use crate::data_sheet::Address;
use crate::scope::{
    Armed, Before, Channel, Progress, Recording, Request, Trigger, arm, disarm, fetch,
};
use crate::{Failure, Line, Master};

use report::{draw, draw_step, reason, tell};
pub use response::{Point, response};

/// What is wanted.
#[derive(Clone, Debug, Default)]
pub struct Tuning {
    /// The current of the measurement, in thousandths of the rated one; what the drive has without it.
    pub current: Option<u16>,
    /// The bandwidth of the velocity loop in 1/s; what the drive thinks fit without it.
    pub bandwidth: Option<u16>,
    /// No frequency response.
    pub is_short: bool,
    /// Write what was found.
    pub writes: bool,
    /// Draw the frequency response there.
    pub plot: Option<PathBuf>,
    /// Move by a hundredth of a turn at once, and draw that there.
    pub step: Option<PathBuf>,
    /// One object for programs.
    pub json: bool,
}

/// What was found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Found {
    /// In Ω.
    pub resistance: f64,
    /// In H.
    pub inductance_along: f64,
    /// In H.
    pub inductance_across: f64,
    /// In V·s.
    pub flux: f64,
    /// Electrical turns in one of the motor.
    pub pole_pairs: u32,
    /// 1 or −1: which way the encoder counts.
    pub direction: i8,
    /// The electrical angle where the encoder is at 0, in degrees.
    pub angle: f64,
    /// Of all that turns, in kg·m².
    pub inertia: f64,
    /// In N·m.
    pub friction: f64,
    /// 60F9h:1 and 2 and 60FBh:1, in 1/s.
    pub gains: [u32; 3],
    /// What the speed makes of a torque.
    pub response: Vec<Point>,
    /// The position over time in s, as wanted and as it was, in increments from where it began; empty unless a drawing was asked for.
    pub step: Vec<(f64, i32, i32)>,
    /// It was written to the drive.
    pub is_written: bool,
}

const fn order(sub: u8) -> Address {
    Address::new(0x20C0, sub)
}

const fn result(sub: u8) -> Address {
    Address::new(0x20C1, sub)
}

const MODE: Address = Address::new(0x6060, 0);
const CONTROLWORD: Address = Address::new(0x6040, 0);
const STATUSWORD: Address = Address::new(0x6041, 0);

/// The values of 20C0h:1.
const END: u32 = 0;
const MEASURE: u32 = 1;
const EXCITE: u32 = 2;

/// The values of 20C1h:1 that end it.
const DONE: u32 = 6;
const FAILED: u32 = 7;

/// 20C2h, 60F9h, 60FBh from 20C1h, each with its length.
const WRITTEN: [(Address, u8, usize); 9] = [
    (Address::new(0x20C2, 1), 3, 4),
    (Address::new(0x20C2, 2), 4, 4),
    (Address::new(0x20C2, 3), 5, 4),
    (Address::new(0x20C2, 4), 6, 4),
    (Address::new(0x20C2, 5), 10, 4),
    (Address::new(0x20C2, 6), 11, 4),
    (Address::new(0x60F9, 1), 12, 2),
    (Address::new(0x60F9, 2), 13, 2),
    (Address::new(0x60FB, 1), 14, 2),
];

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

/// What a step changes beside the position, and is put back.
const STEP: [Address; 4] = [
    Address::new(0x6081, 0),
    Address::new(0x6083, 0),
    Address::new(0x6084, 0),
    Address::new(0x607A, 0),
];

/// The objects of the scope that are put back, each with its length.
const SCOPE: [(Address, usize); 12] = [
    (Address::new(0x20D0, 3), 1),
    (Address::new(0x20D0, 4), 2),
    (Address::new(0x20D0, 5), 2),
    (Address::new(0x20D0, 6), 2),
    (Address::new(0x20D1, 1), 4),
    (Address::new(0x20D1, 2), 4),
    (Address::new(0x20D1, 3), 4),
    (Address::new(0x20D1, 4), 4),
    (Address::new(0x20D1, 5), 4),
    (Address::new(0x20D1, 6), 4),
    (Address::new(0x20D1, 7), 4),
    (Address::new(0x20D1, 8), 4),
];

/// Measures, and tells what was found.
///
/// # Errors
/// [`Problem::Failed`] if the drive cannot do it, is in operation already, or does not succeed; [`Problem::Usage`] if a file cannot be written.
pub fn tune<L: Line>(
    master: &mut Master<L>,
    node: &Node,
    wanted: &Tuning,
    console: &mut Console<'_>,
) -> Result<(), Problem> {
    let mut bench = Bench { master, node };
    let found = bench.run(wanted, console)?;
    if let Some(path) = &wanted.plot {
        draw(&found.response, path)?;
    }
    if let Some(path) = &wanted.step {
        draw_step(&found.step, path)?;
    }
    if wanted.json {
        let text =
            serde_json::to_string(&found).map_err(|error| Problem::Failed(error.to_string()))?;
        return console.say(&text);
    }
    tell(node.id, &found, console)
}

struct Bench<'a, L: Line> {
    master: &'a mut Master<L>,
    node: &'a Node,
}

impl<L: Line> Bench<'_, L> {
    fn run(&mut self, wanted: &Tuning, console: &mut Console<'_>) -> Result<Found, Problem> {
        let mode = self.bytes(MODE)?;
        let state = match self.number(result(1)) {
            Ok(state) => state,
            Err(Failure::Abort { .. }) => {
                return Err(self.failed("it has no motor that it could measure: 20C1h is missing"));
            }
            Err(failure) => return Err(Problem::with_node(self.node.id, failure)),
        };
        if (1..DONE).contains(&state) {
            return Err(self.failed("it is being measured already"));
        }
        if self.statusword()? & 0x4F == 0x07 || self.statusword()? & 0x6F == 0x23 {
            return Err(self.failed("its power stage is on: another master may be moving it"));
        }
        let before = [order(2), order(4)].map(|address| (address, self.bytes(address)));
        let outcome = self.measured(wanted, console);
        // Whatever became of it, the motor has no power, and the rest is as it was.
        let ended = self.write(order(1), &[END as u8]);
        let off = self.write(CONTROLWORD, &[0x06, 0]);
        for (address, bytes) in before {
            self.write(address, &bytes?)?;
        }
        self.write(MODE, &mode)?;
        let found = outcome?;
        ended.and(off)?;
        Ok(found)
    }

    fn measured(&mut self, wanted: &Tuning, console: &mut Console<'_>) -> Result<Found, Problem> {
        if let Some(current) = wanted.current {
            self.write(order(2), &current.to_le_bytes())?;
        }
        if let Some(bandwidth) = wanted.bandwidth {
            self.write(order(4), &bandwidth.to_le_bytes())?;
        }
        self.enable()?;
        console.remark(&format!(
            "node {}: the motor is measured, and moves by itself",
            self.node.id
        ));
        self.order(MEASURE)?;
        self.wait_for_result(console)?;
        let mut found = self.read_result()?;
        if wanted.writes {
            // The data of the motor are taken over while the power stage is off.
            self.write(CONTROLWORD, &[0x06, 0])?;
            self.comes_to(0x6F, 0x21)?;
            for (address, from, length) in WRITTEN {
                let value = self.value(result(from))?.to_le_bytes();
                self.write(address, value.get(..length).unwrap_or_default())?;
            }
            found.is_written = true;
            self.enable()?;
        }
        if !wanted.is_short {
            found.response = self.respond()?;
        }
        if wanted.step.is_some() {
            found.step = self.step()?;
        }
        Ok(found)
    }

    fn read_result(&mut self) -> Result<Found, Problem> {
        let mut number = |sub| self.value(result(sub)).map(f64::from);
        let winding = [number(3)?, number(4)?, number(5)?, number(6)?];
        let (angle, inertia, friction) = (number(9)?, number(10)?, number(11)?);
        let direction = self.value(result(8))?;
        Ok(Found {
            resistance: winding[0] * 1e-6,
            inductance_along: winding[1] * 1e-9,
            inductance_across: winding[2] * 1e-9,
            flux: winding[3] * 1e-9,
            pole_pairs: self.value(result(7))?,
            direction: if direction == 1 { 1 } else { -1 },
            angle: angle * 360.0 / 65_536.0,
            inertia: inertia * 1e-9,
            friction: friction * 1e-6,
            gains: [
                self.value(result(12))?,
                self.value(result(13))?,
                self.value(result(14))?,
            ],
            response: Vec::new(),
            step: Vec::new(),
            is_written: false,
        })
    }

    fn order(&mut self, command: u32) -> Result<(), Problem> {
        self.write(order(1), &[command as u8])?;
        // The drive looks once in a control tick; until then the last result stands.
        Ok(self.master.wait(Duration::from_ticks(5_000))?)
    }

    fn wait_for_result(&mut self, console: &mut Console<'_>) -> Result<(), Problem> {
        let end = self.master.now() + LONGEST;
        loop {
            self.master.wait(PAUSE)?;
            match self.value(result(1))? {
                DONE => return Ok(()),
                FAILED => {
                    let why = self.value(result(2))?;
                    let fault = self.value(Address::new(0x603F, 0))?;
                    return Err(self.failed(&reason(why, fault)));
                }
                state => console.progress("measuring", state, DONE),
            }
            if self.master.now() >= end {
                return Err(self.failed("the measurement does not end"));
            }
        }
    }

    /// The frequency response: the scope records while the drive adds a sine to the torque.
    fn respond(&mut self) -> Result<Vec<Point>, Problem> {
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
        let turn = self.turn()?;
        let before = STEP.map(|address| (address, self.bytes(address)));
        let stepped = self.stepped(turn);
        for (address, bytes) in before {
            self.write(address, &bytes?)?;
        }
        let [demand, actual] = stepped?;
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

    fn stepped(&mut self, turn: f64) -> Result<[Channel; 2], Problem> {
        let way = (turn / 100.0).max(1.0) as i32;
        // There in some 8 ms.
        let quick = (f64::from(way) * 6e4) as u32;
        let target = self.value(Address::new(0x6064, 0))?.cast_signed();
        for address in [Address::new(0x6083, 0), Address::new(0x6084, 0)] {
            self.write(address, &quick.to_le_bytes())?;
        }
        let fast = (f64::from(way) * 2e3) as u32;
        self.write(Address::new(0x6081, 0), &fast.to_le_bytes())?;
        let target = target.wrapping_add(way);
        self.recorded(STEP_CHANNELS, 250, |bench| {
            bench.write(Address::new(0x607A, 0), &target.to_le_bytes())?;
            bench.write(CONTROLWORD, &[0x3F, 0])?;
            bench.write(CONTROLWORD, &[0x0F, 0])
        })
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

    /// Two values for so many ms while something happens. The scope is left as it was.
    fn recorded(
        &mut self,
        channels: [u32; 2],
        time: u32,
        happen: impl FnOnce(&mut Self) -> Result<(), Problem>,
    ) -> Result<[Channel; 2], Problem> {
        let before = SCOPE.map(|(address, length)| (address, length, self.bytes(address)));
        let recorded = self.record(channels, time, happen);
        let stopped = disarm(self.master, self.node);
        for (address, length, bytes) in before {
            let bytes = bytes?;
            self.write(address, bytes.get(..length).unwrap_or_default())?;
        }
        let recording = recorded?;
        stopped?;
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
        let mut armed: Armed = arm(self.master, self.node, &request)?;
        armed.progress(self.master, self.node)?;
        happen(self)?;
        let end = self.master.now() + LONGEST;
        while armed.progress(self.master, self.node)? != Progress::Full {
            if self.master.now() >= end {
                return Err(self.failed("the recording is not done"));
            }
            self.master.wait(PAUSE)?;
        }
        fetch(self.master, self.node)
    }

    /// Profile position, in operation enabled.
    fn enable(&mut self) -> Result<(), Problem> {
        self.write(MODE, &[1])?;
        for (controlword, mask, state) in
            [(0x06, 0x6F, 0x21), (0x07, 0x6F, 0x23), (0x0F, 0x6F, 0x27)]
        {
            self.write(CONTROLWORD, &[controlword, 0])?;
            self.comes_to(mask, state)?;
        }
        Ok(())
    }

    fn comes_to(&mut self, mask: u32, state: u32) -> Result<(), Problem> {
        let end = self.master.now() + SOON;
        loop {
            let statusword = self.statusword()?;
            if statusword & mask == state {
                return Ok(());
            }
            if self.master.now() >= end {
                return Err(self.failed(&format!(
                    "6041h is {statusword:04X}h, and does not come to {state:02X}h"
                )));
            }
            self.master.wait(Duration::from_ticks(10_000))?;
        }
    }

    fn statusword(&mut self) -> Result<u32, Problem> {
        self.value(STATUSWORD)
    }

    fn failed(&self, what: &str) -> Problem {
        Problem::Failed(format!("node {}: {what}", self.node.id))
    }

    fn bytes(&mut self, address: Address) -> Result<Vec<u8>, Problem> {
        let bytes = self.node.upload(self.master, address);
        bytes.map_err(|failure| Problem::with_node(self.node.id, failure))
    }

    fn number(&mut self, address: Address) -> Result<u32, Failure> {
        let bytes = self.node.upload(self.master, address)?;
        let number = bytes
            .iter()
            .rev()
            .fold(0_u64, |number, byte| number << 8 | u64::from(*byte));
        Ok(u32::try_from(number).unwrap_or(u32::MAX))
    }

    fn value(&mut self, address: Address) -> Result<u32, Problem> {
        let number = self.number(address);
        number.map_err(|failure| Problem::with_node(self.node.id, failure))
    }

    fn write(&mut self, address: Address, bytes: &[u8]) -> Result<(), Problem> {
        let written = self.node.download(self.master, address, bytes);
        written.map_err(|failure| Problem::with_node(self.node.id, failure))
    }
}

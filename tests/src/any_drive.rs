//! The whole virtual drive under any frames, any settings and any time: nothing panics, no pulse leaves without current, and whatever has
//! happened, it can be brought to rest.
//!
//! What happens is read from bytes, which a fuzzer changes; where there are no more, all are 0.

use canopen::od::{self, Dictionary as _};
use canopen::{ControllerState, Duration, Frame, Instant};
use embedded_can::{Frame as _, Id, StandardId};
use master::bus::Station;
use sim::Axis402;
use sim::dictionary::Dictionary;
use sim::drive::Setup;

const NODE: u8 = 4;

/// The longest stop that the drive makes on its own, in milliseconds (20A1h), and how long its brake takes to close.
const LONGEST_STOP: (u16, u8) = (0x20A1, 0);
const BRAKE_ENGAGE: (u16, u8) = (0x2040, 2);

/// What is around a stop: control ticks, the boot.
const SLACK: Duration = Duration::from_ticks(10_000);

/// Longer stops are not waited for.
const PATIENCE: Duration = Duration::from_ticks(4_000_000);

/// How much time passes in a sequence at most.
const TIME: Duration = Duration::from_ticks(3_000_000);

/// Frames that it has waiting at most: more is a queue that never ends.
const MOST_FRAMES: usize = 400;

/// How often it may want to be called in a row before time passes.
const MOST_CALLS: usize = 64;

/// Lets happen what these bytes say, then stops the drive.
///
/// # Panics
/// If it does what it must not do.
pub fn check(bytes: &[u8]) {
    let mut bytes = bytes.iter().copied();
    let end = bytes.next().unwrap_or_default();
    let mut bench = Bench::booted();
    while bench.now.ticks() < TIME.ticks()
        && let Some(kind) = bytes.next()
    {
        bench.step(kind, || bytes.next().unwrap_or_default());
    }
    bench.comes_to_rest(end);
}

/// The bytes of these frames and pauses, behind which the drive is stopped in one way or another (0 to 2).
pub fn encode(end: u8, steps: impl IntoIterator<Item = Result<Frame, Duration>>) -> Vec<u8> {
    let mut bytes = vec![end];
    for step in steps {
        match step {
            Ok(frame) => {
                let id = frame.standard_id().unwrap_or_default();
                bytes.push(FRAME);
                bytes.extend(id.to_le_bytes());
                bytes.push(frame.length());
                bytes.extend(frame.payload());
            }
            Err(pause) => {
                bytes.push(PASS);
                let units = u16::try_from(pause.ticks() / 2).unwrap_or(u16::MAX);
                bytes.extend(units.to_le_bytes());
            }
        }
    }
    bytes
}

/// The kinds of steps, by the low three bits of their first byte; the others are writes of an object.
const FRAME: u8 = 0;
const PASS: u8 = 1;
const COMMAND: u8 = 2;
const NMT: u8 = 3;
const WORLD: u8 = 4;

struct Bench {
    drive: Axis402,
    now: Instant,
}

impl Bench {
    fn booted() -> Self {
        let mut bench = Self {
            drive: Axis402::new(Setup::with_node_id(1, NODE)),
            now: Instant::from_ticks(0),
        };
        bench.pass(Duration::millis(2));
        assert!(bench.has_booted());
        bench
    }

    fn step(&mut self, kind: u8, mut next: impl FnMut() -> u8) {
        match kind & 7 {
            FRAME => {
                let id = u16::from_le_bytes([next(), next()]) & 0x7FF;
                let length = usize::from(next() & 0x0F).min(8);
                let mut data = [0; 8];
                data[..length].fill_with(next);
                self.receive(id, &data[..length]);
            }
            // In twos of microseconds, up to an eighth of a second.
            PASS => {
                let units = u64::from(u16::from_le_bytes([next(), next()]));
                self.pass(Duration::from_ticks(2 * units));
            }
            COMMAND => {
                let words = [
                    0x00, 0x02, 0x06, 0x07, 0x0F, 0x1F, 0x3F, 0x5F, 0x7F, 0x10F, 0x80, 0x8F,
                ];
                let word: u16 = words[usize::from(next()) % words.len()];
                self.receive(0x200 + u16::from(NODE), &word.to_le_bytes());
            }
            NMT => {
                let commands = [0x01, 0x02, 0x80, 0x81, 0x82];
                self.receive(0, &[commands[usize::from(next()) % commands.len()], NODE]);
            }
            WORLD => self.world(next(), next()),
            _ => {
                // Most objects of a drive have small indices among those of their kind, and most values are small.
                let entries = Dictionary::TABLE.entries;
                let number = usize::from(u16::from_le_bytes([next(), next()]));
                let entry = &entries[number % entries.len()];
                let bits = u32::from(next()) % 33;
                let value = u32::from_le_bytes([next(), next(), next(), next()]);
                let value = value & u32::MAX.checked_shr(32 - bits).unwrap_or(0);
                let size = entry.size().clamp(1, 4) as u8;
                let command = 0x23 | (4 - size) << 2;
                let ([low, high], [a, b, c, d]) = (entry.index.to_le_bytes(), value.to_le_bytes());
                let request = [command, low, high, entry.sub, a, b, c, d];
                self.receive(0x600 + u16::from(NODE), &request);
            }
        }
    }

    /// What is around the drive.
    fn world(&mut self, what: u8, value: u8) {
        let plant = self.drive.plant_mut();
        match what % 8 {
            0 => plant.supply = value & 1 != 0,
            1 => plant.supply_voltage = u32::from(value) * 500,
            2 => plant.temperature = i16::from(value) * 5,
            3 => plant.analogue = u16::from(value) << 4,
            4 => plant.fault = [None, Some(0x2310), Some(0x9000)][usize::from(value) % 3],
            5 => plant.warning = (value & 1 != 0).then_some(0x4210),
            6 => plant.displace(i64::from(value) - 128),
            _ => {
                let state = [ControllerState::BusOff, ControllerState::ErrorActive];
                let state = state[usize::from(value & 1)];
                self.drive.controller_changed(state, self.now);
            }
        }
    }

    /// A frame comes. Nobody gives the node another node-ID or bit rate, or silences it for two minutes: neither LSS nor 5FF0h to 5FF3h.
    fn receive(&mut self, id: u16, data: &[u8]) {
        if id == 0x7E5 && matches!(data, [0x11 | 0x15, ..])
            || matches!(data, [_, 0xF0..=0xF3, 0x5F, ..])
        {
            return;
        }
        let id = Id::from(StandardId::new(id).expect("an identifier"));
        let frame = Frame::new(id, data).expect("a frame");
        self.drive.receive(&frame, self.now);
        self.pass(Duration::from_ticks(100));
    }

    /// Lets time pass.
    fn pass(&mut self, span: Duration) {
        let end = self.now + span;
        let mut deadline = self.poll();
        while self.now < end {
            let before = self.off();
            self.now = deadline.min(end);
            deadline = self.poll();
            if let (Some(before), Some(after)) = (before, self.off()) {
                assert_eq!(before, after, "pulses without current");
            }
        }
    }

    /// Returns when it wants to be called again, which lies ahead.
    fn poll(&mut self) -> Instant {
        let mut deadlines = (0..MOST_CALLS).map(|_| self.drive.poll(self.now));
        let ahead = deadlines.find(|deadline| *deadline > self.now);
        ahead.unwrap_or_else(|| panic!("no deadline ahead of {:?}", self.now))
    }

    /// Where the motor is, if there is no current in it.
    fn off(&self) -> Option<i64> {
        let plant = self.drive.plant();
        (!plant.is_energised()).then(|| plant.pulses().position())
    }

    /// Whether there is a boot-up message among the frames that wait.
    fn has_booted(&mut self) -> bool {
        let mut has_booted = false;
        for _ in 0..MOST_FRAMES {
            let Some(frame) = self.drive.transmit() else {
                return has_booted;
            };
            let id = 0x700 + u16::from(NODE);
            has_booted |= frame.standard_id() == Some(id) && frame.payload() == [0];
        }
        panic!("{MOST_FRAMES} frames and no end");
    }

    fn milliseconds(&self, (index, sub): (u16, u8)) -> Duration {
        let dictionary = self.drive.device().node().dictionary();
        let value = od::read_u16(dictionary, index, sub).expect("an object of the drive");
        Duration::millis(value.into())
    }

    /// After "disable voltage" and a reset (`end` is 0), a reset alone, or two, there is no pulse, and the drive boots in time.
    fn comes_to_rest(&mut self, end: u8) {
        self.drive
            .controller_changed(ControllerState::ErrorActive, self.now);
        let engage = self.milliseconds(BRAKE_ENGAGE);
        let longest = self.milliseconds(LONGEST_STOP);
        let bound = if end % 3 == 1 && longest < PATIENCE {
            longest + engage + SLACK
        } else {
            engage + SLACK
        };
        if end.is_multiple_of(3) {
            self.receive(0, &[0x01, NODE]);
            let disable_voltage = [0x2B, 0x40, 0x60, 0, 0, 0, 0, 0];
            self.receive(0x600 + u16::from(NODE), &disable_voltage);
        }
        self.has_booted();
        let resets = if bound > SLACK + engage { 1 } else { 2 };
        for _ in 0..resets {
            self.receive(0, &[0x81, NODE]);
        }
        let begin = self.now;
        while !self.has_booted() {
            let after = self.now - begin;
            assert!(after < bound, "no boot-up after {after:?}");
            self.pass(Duration::millis(1));
        }
        assert!(self.off().is_some(), "current in the motor behind a reset");
        self.pass(Duration::millis(20));
    }
}

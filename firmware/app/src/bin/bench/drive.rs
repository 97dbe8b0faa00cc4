//! The drive: its control tick in each mode, and how long it locks.

use core::hint::black_box;

use canopen::{BitRate, Duration, Instant, NodeId, Settings};
use cia402::units::Ratio;
use cia402::{Device, Drive, DriveConfig, Exchange, Inputs, Share};
use motion::{AxisConfig, Clock, DriverTiming, PulseSink, Record, Ticks};

use crate::{columns, count, heading, row};

mod modes;

mod dictionary {
    include!(concat!(env!("OUT_DIR"), "/dictionary.rs"));
}

use dictionary::Dictionary;

const HZ: u32 = 84_000_000;
const TICK: Duration = Duration::millis(1);
/// As on the board.
const REFILLS: u32 = 4;
/// Ticks of the step timer from one refill to the next.
const TIME_SLICE: u32 = HZ / 1_000 / REFILLS;

/// A motor that follows at once.
#[derive(Default)]
pub struct Motor {
    pending: Ticks,
    position: i64,
}

impl PulseSink for Motor {
    fn push(&mut self, record: Record) -> Result<(), Record> {
        self.pending += record.ticks();
        self.position += i64::from(record.steps());
        Ok(())
    }

    fn pending(&self) -> Ticks {
        self.pending
    }

    fn free(&self) -> usize {
        64
    }
}

/// An exchange that can count how long it is locked.
pub struct Timed {
    exchange: Exchange,
    is_timed: bool,
    /// Most instructions in one lock.
    longest: u32,
}

impl Share for Timed {
    fn lock<R>(&mut self, f: impl FnOnce(&mut Exchange) -> R) -> R {
        if !self.is_timed {
            return f(&mut self.exchange);
        }
        let (cost, result) = count(|| alone(&mut self.exchange, f));
        self.longest = self.longest.max(cost);
        result
    }
}

/// What happens under the lock. A function of its own, or the compiler moves some of it out of what is counted.
#[inline(never)]
fn alone<R>(exchange: &mut Exchange, f: impl FnOnce(&mut Exchange) -> R) -> R {
    f(exchange)
}

/// The drive with what is around it.
pub struct Bench {
    pub device: Device<Dictionary>,
    drive: Drive,
    pub exchange: Timed,
    motor: Motor,
    pub now: Instant,
    /// From here on the home switch, input 3, is active.
    home: i64,
    /// Most instructions in one control tick.
    worst: u32,
}

#[inline(never)]
fn tick(drive: &mut Drive, now: Instant, levels: u8, motor: &mut Motor, exchange: &mut Timed) {
    let mut inputs = Inputs {
        supply: true,
        position: motor.position,
        warning: None,
        fault: None,
        ..Inputs::default()
    };
    inputs.digital.levels = levels;
    drive.tick(now, &inputs, motor, exchange);
}

impl Bench {
    /// A millisecond: refills, then a control tick, whose instructions it gives, then the node task.
    fn millisecond(&mut self) -> u32 {
        let count = self.tick(self.now + TICK);
        self.device.poll(self.now, &mut self.exchange);
        while self.device.transmit().is_some() {}
        count
    }

    /// The refills of a millisecond, and the control tick at its end, `now`, whose instructions it gives.
    pub fn tick(&mut self, now: Instant) -> u32 {
        self.now = now;
        for _ in 0..REFILLS {
            self.motor.pending = self.motor.pending.saturating_sub(TIME_SLICE.into());
            self.drive.refill(&mut self.motor);
        }
        let levels = u8::from(self.motor.position >= self.home) << 2;
        let (count, ()) = count(|| {
            tick(
                &mut self.drive,
                self.now,
                levels,
                &mut self.motor,
                &mut self.exchange,
            );
        });
        self.worst = self.worst.max(count);
        count
    }
}

/// The workloads of the drive that are rows of the large table.
pub fn run() {
    let longest = modes::ALL
        .iter()
        .map(|mode| modes::drive(mode, true).longest);
    row(
        "drive: longest lock of the exchange",
        longest.max().unwrap_or(0),
    );
    conversions();
}

/// What a control tick costs in each mode.
pub fn ticks() {
    heading("Control tick");
    for mode in &modes::ALL {
        let cost = modes::drive(mode, false);
        columns(mode.name, &[cost.moving, cost.at_rest, cost.worst]);
    }
}

/// What it takes to convert a position.
fn conversions() {
    // 3200 steps a revolution, a gear of 17:3, 360.00 degrees.
    let ratio = black_box(Ratio::of([3_200, 17], [3, 36_000]).unwrap());
    for (name, ratio, position) in [
        ("units: a position, 1:1", Ratio::ONE, 1_234_567),
        ("units: a position, 68:135", ratio, 1_234_567),
        ("units: a position of 33 bits, 68:135", ratio, 8_589_934_591),
    ] {
        let (cost, units) = count(|| convert(black_box(ratio), black_box(position)));
        assert_eq!(ratio.to_increments(units), position);
        row(name, cost);
    }
}

#[inline(never)]
fn convert(ratio: Ratio, increments: i64) -> i64 {
    ratio.to_units(increments)
}

impl Bench {
    /// A drive that has just got power.
    // Out of line, so that it is made where it stays: the stack has no room for it twice.
    #[inline(never)]
    pub fn new(is_timed: bool) -> Self {
        let settings = Settings {
            node_id: NodeId::new(10).unwrap(),
            bit_rate: BitRate::Kbit1000,
        };
        let config = DriveConfig {
            axis: AxisConfig {
                clock: Clock::new(HZ).unwrap(),
                time_slice: TIME_SLICE,
                timing: DriverTiming {
                    pulse_high: 210,
                    pulse_low: 210,
                    direction_setup: 420,
                    direction_hold: 420,
                },
            },
            tick: TICK,
            refills: REFILLS,
        };
        let mut bench = Self {
            device: Device::new(Dictionary::new(), settings, 1),
            drive: Drive::new(config),
            exchange: Timed {
                exchange: Exchange::new(),
                is_timed,
                longest: 0,
            },
            motor: Motor::default(),
            now: Instant::from_ticks(0),
            home: i64::MAX,
            worst: 0,
        };
        bench.device.power_on(bench.now, &mut bench.exchange);
        bench.millisecond();
        bench
    }
}

//! The drive: a control tick at rest and one in motion.

use core::hint::black_box;

use canopen::{BitRate, Duration, Frame, Instant, NodeId, Settings};
use cia402::units::Ratio;
use cia402::{Device, Drive, DriveConfig, Exchange, Inputs, Share};
use motion::{AxisConfig, Clock, DriverTiming, PulseSink, Record, Ticks};

use crate::{count, row};

mod dictionary {
    include!(concat!(env!("OUT_DIR"), "/dictionary.rs"));
}

use dictionary::Dictionary;

const HZ: u32 = 84_000_000;
const TICK: Duration = Duration::millis(1);

/// A motor that follows at once.
#[derive(Default)]
struct Motor {
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
struct Timed {
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

struct Bench {
    device: Device<Dictionary>,
    drive: Drive,
    exchange: Timed,
    motor: Motor,
    now: Instant,
}

#[inline(never)]
fn tick(drive: &mut Drive, now: Instant, motor: &mut Motor, exchange: &mut Timed) {
    let inputs = Inputs {
        supply: true,
        position: motor.position,
        warning: None,
        fault: None,
        ..Inputs::default()
    };
    drive.tick(now, &inputs, motor, exchange);
}

impl Bench {
    /// A millisecond: the node task, then a control tick, whose instructions it gives.
    fn millisecond(&mut self) -> u32 {
        self.now += TICK;
        self.motor.pending = self.motor.pending.saturating_sub((HZ / 1_000).into());
        let (count, ()) = count(|| {
            tick(
                &mut self.drive,
                self.now,
                &mut self.motor,
                &mut self.exchange,
            );
        });
        self.device.poll(self.now, &mut self.exchange);
        while self.device.transmit().is_some() {}
        count
    }

    fn download(&mut self, index: u16, size: u8, value: i32) {
        self.download_to(index, 0, size, value);
    }

    fn download_to(&mut self, index: u16, sub: u8, size: u8, value: i32) {
        let [low, high] = index.to_le_bytes();
        let [a, b, c, d] = value.to_le_bytes();
        let request = [0x23 | (4 - size) << 2, low, high, sub, a, b, c, d];
        self.device.receive(
            &Frame::data_frame(0x60A, &request),
            self.now,
            &mut self.exchange,
        );
        let answer = self.device.transmit().unwrap();
        assert_eq!(answer.payload()[0], 0x60);
        self.millisecond();
        self.millisecond();
    }

    fn statusword(&self) -> u16 {
        self.device.node().dictionary().statusword()
    }
}

/// All workloads of the drive.
pub fn run() {
    let (at_rest, cruising, _) = drive_there(1, false);
    row("drive: control tick, enabled, at rest", at_rest);
    row("drive: control tick, cruising at 20 kHz", cruising);
    let (at_rest, cruising, _) = drive_there(3, false);
    row(
        "drive: control tick, at rest, a unit is 1/3 of a step",
        at_rest,
    );
    row(
        "drive: control tick, cruising, a unit is 1/3 of a step",
        cruising,
    );
    let (_, _, longest) = drive_there(1, true);
    row("drive: longest lock of the exchange", longest);
    conversions();
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

/// Enables the drive and moves it by 20,000 steps, in so many units to a step. What a control tick costs at rest and cruising,
/// and the longest lock if locks are timed.
#[inline(never)]
fn drive_there(units: i32, is_timed: bool) -> (u32, u32, u32) {
    let settings = Settings {
        node_id: NodeId::new(10).unwrap(),
        bit_rate: BitRate::Kbit1000,
    };
    let config = DriveConfig {
        axis: AxisConfig {
            clock: Clock::new(HZ).unwrap(),
            segment: HZ / 1_000,
            timing: DriverTiming {
                pulse_high: 210,
                pulse_low: 210,
                direction_setup: 420,
                direction_hold: 420,
            },
        },
        tick: TICK,
        refills: 1,
    };
    let mut bench = Bench {
        device: Device::new(Dictionary::new(), settings, 1),
        drive: Drive::new(config),
        exchange: Timed {
            exchange: Exchange::new(),
            is_timed,
            longest: 0,
        },
        motor: Motor::default(),
        now: Instant::from_ticks(0),
    };
    bench.device.power_on(bench.now, &mut bench.exchange);
    bench.millisecond();
    bench.download(0x6060, 1, 1);
    bench.download_to(0x6092, 1, 4, 3_200 * units);
    for controlword in [0x06, 0x07, 0x0F] {
        bench.download(0x6040, 2, controlword);
    }
    assert_eq!(bench.statusword() & 0x6F, 0x27, "operation enabled");
    for _ in 0..100 {
        bench.millisecond();
    }
    let at_rest = bench.millisecond();

    bench.download(0x607A, 4, 20_000 * units);
    bench.download(0x6081, 4, 20_000 * units);
    bench.download(0x6040, 2, 0x1F);
    for _ in 0..500 {
        bench.millisecond();
    }
    let cruising = bench.millisecond();
    while bench.motor.pending > 0 {
        bench.millisecond();
    }
    assert_eq!(bench.motor.position, 20_000);
    (at_rest, cruising, bench.exchange.longest)
}

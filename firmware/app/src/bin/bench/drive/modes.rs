//! Each mode of operation: what a control tick costs at rest, in motion at 20,000 steps/s, and at its worst.

use canopen::Frame;

use super::Bench;

/// Where steps/s become 20,000, in steps in a millisecond.
const PACE: i32 = 20;
/// Steps/s of the motion.
const SPEED: i32 = PACE * 1_000;

/// A mode in which the drive moves.
pub struct Mode {
    pub name: &'static str,
    /// 6060h.
    code: i32,
    /// Units in a step.
    units: i32,
    /// The controlword in motion.
    controlword: i32,
    /// What a master does in each millisecond of the motion, the first of which is 0. It lasts for [`MOTION`].
    command: fn(&mut Bench, &Mode, i32),
}

/// What the control ticks of a mode have cost.
pub struct Cost {
    pub at_rest: u32,
    pub moving: u32,
    /// The worst case since operation was enabled, with the start and the end of the motion.
    pub worst: u32,
    /// Most instructions in one lock.
    pub longest: u32,
}

/// How long a motion lasts, its end not counted, and when it is looked at, in milliseconds.
const MOTION: i32 = 800;
const LOOK: i32 = 500;

/// Every mode.
pub const ALL: [Mode; 9] = [
    Mode::new("profile position", 1, 0x0F, go_to),
    Mode {
        units: 3,
        ..Mode::new("profile position, a unit is 1/3 of a step", 1, 0x0F, go_to)
    },
    Mode::new("velocity (vl)", 2, 0x7F, |bench, _, time| {
        // 6048h and 6049h are 100,000 units a second.
        once(bench, time, 0x6042, 2, SPEED);
    }),
    Mode::new("profile velocity", 3, 0x0F, |bench, _, time| {
        once(bench, time, 0x60FF, 4, SPEED);
    }),
    Mode::new("homing", 6, 0x1F, |bench, _, time| {
        if time == 0 {
            bench.home = bench.motor.position + 10_000;
        }
    }),
    Mode::new("interpolated position", 7, 0x1F, |bench, mode, time| {
        bench.write(0x60C1, 1, 4, distance(time) * mode.units);
        bench.sync();
    }),
    Mode::new("cyclic synchronous position", 8, 0x0F, follow),
    Mode {
        units: 3,
        ..Mode::new(
            "cyclic synchronous position, a unit is 1/3 of a step",
            8,
            0x0F,
            follow,
        )
    },
    Mode::new("cyclic synchronous velocity", 9, 0x0F, |bench, _, time| {
        bench.write(0x60FF, 0, 4, pace(time) * 1_000);
        bench.sync();
    }),
];

impl Mode {
    const fn new(
        name: &'static str,
        code: i32,
        controlword: i32,
        command: fn(&mut Bench, &Mode, i32),
    ) -> Self {
        Self {
            name,
            code,
            units: 1,
            controlword,
            command,
        }
    }
}

/// A target 20,000 steps away, at the beginning.
fn go_to(bench: &mut Bench, mode: &Mode, time: i32) {
    if time == 0 {
        bench.write(0x607A, 0, 4, 20_000 * mode.units);
        bench.write(0x6040, 0, 2, 0x1F);
    }
}

/// A target in each millisecond, by RPDO 3, and SYNC.
fn follow(bench: &mut Bench, mode: &Mode, time: i32) {
    let [c0, c1, ..] = mode.controlword.to_le_bytes();
    let [t0, t1, t2, t3] = (distance(time) * mode.units).to_le_bytes();
    bench.receive(0x40A, &[c0, c1, t0, t1, t2, t3]);
    bench.sync();
}

/// Writes a velocity in the first millisecond, and 0 in the last one.
fn once(bench: &mut Bench, time: i32, index: u16, size: u8, value: i32) {
    if time == 0 {
        bench.write(index, 0, size, value);
    }
    if time == MOTION - 1 {
        bench.write(index, 0, size, 0);
    }
}

/// Steps in the millisecond that begins at `time`: 100,000 steps/s² up and down.
fn pace(time: i32) -> i32 {
    (time / 10).min((MOTION - 1 - time) / 10).clamp(0, PACE)
}

/// Steps until `time`.
fn distance(time: i32) -> i32 {
    (0..=time).map(pace).sum()
}

impl Bench {
    fn receive(&mut self, identifier: u16, payload: &[u8]) {
        let frame = Frame::data_frame(identifier, payload);
        self.device.receive(&frame, self.now, &mut self.exchange);
    }

    fn sync(&mut self) {
        self.receive(0x080, &[]);
    }

    /// Writes an object. No time passes.
    fn write(&mut self, index: u16, sub: u8, size: u8, value: i32) {
        let [low, high] = index.to_le_bytes();
        let [a, b, c, d] = value.to_le_bytes();
        let request = [0x23 | (4 - size) << 2, low, high, sub, a, b, c, d];
        self.receive(0x60A, &request);
        // The answer may stand behind the TPDO of a SYNC.
        let mut answers = core::iter::from_fn(|| self.device.transmit());
        assert!(answers.any(|answer| answer.payload().first() == Some(&0x60)));
    }

    /// Writes an object and lets the control tick see it.
    fn set(&mut self, index: u16, sub: u8, size: u8, value: i32) {
        self.write(index, sub, size, value);
        self.millisecond();
        self.millisecond();
    }

    /// A millisecond of a mode: what the master does, and the control tick.
    fn pass(&mut self, mode: &Mode, time: i32) -> u32 {
        (mode.command)(self, mode, time);
        let cost = self.millisecond();
        while self.device.transmit().is_some() {}
        cost
    }

    fn statusword(&self) -> u16 {
        self.device.node().dictionary().statusword()
    }
}

/// Enables the drive in a mode and moves it; with the locks timed, or the control ticks.
#[inline(never)]
pub fn drive(mode: &Mode, is_timed: bool) -> Cost {
    let mut bench = Bench::new(is_timed);
    let units = mode.units;
    for (index, sub, size, value) in [
        (0x6060, 0, 1, mode.code),
        (0x6092, 1, 4, 3_200 * units),
        (0x6081, 0, 4, SPEED * units),
        (0x6083, 0, 4, 100_000 * units),
        (0x6084, 0, 4, 100_000 * units),
        // To the home switch, in positive direction.
        (0x6098, 0, 1, 19),
        (0x6099, 1, 4, SPEED),
        // A cyclic mode stays where it is.
        (0x60C2, 1, 1, 1),
    ] {
        bench.set(index, sub, size, value);
    }
    bench.receive(0x000, &[1, 10]);
    for controlword in [0x06, 0x07, 0x0F] {
        bench.set(0x6040, 0, 2, controlword);
    }
    assert_eq!(bench.statusword() & 0x6F, 0x27, "operation enabled");
    bench.worst = 0;
    let is_cyclic = mode.code >= 7;
    let mut at_rest = 0;
    for _ in 0..100 {
        if is_cyclic {
            (mode.command)(&mut bench, mode, 0);
        }
        at_rest = bench.millisecond();
        while bench.device.transmit().is_some() {}
    }

    bench.set(0x6040, 0, 2, mode.controlword);
    let begin = bench.motor.position;
    let mut moving = 0;
    for time in 0..MOTION {
        let before = bench.motor.position;
        let cost = bench.pass(mode, time);
        if time == LOOK {
            moving = cost;
            assert_eq!(
                bench.motor.position - before,
                i64::from(PACE),
                "{}",
                mode.name
            );
        }
    }
    assert!(bench.motor.position > begin);
    // Homing goes back to the edge of its switch slowly.
    let mut still = 0;
    while still < 50 {
        let before = bench.motor.position;
        bench.millisecond();
        while bench.device.transmit().is_some() {}
        still = if bench.motor.position == before {
            still + 1
        } else {
            0
        };
    }
    Cost {
        at_rest,
        moving,
        worst: bench.worst,
        longest: bench.exchange.longest,
    }
}

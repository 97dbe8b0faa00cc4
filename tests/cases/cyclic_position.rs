//! Cyclic synchronous position (mode 8): set-points at SYNC, in virtual time, with jitter and with frames that are lost.

use canopen::{Duration, Frame};
use tests::DriveBench;
use tests::drive::{FAULT, INTERNAL_LIMIT, OPERATION_ENABLED, State};

/// Statusword bit 12: the drive follows the command value.
const FOLLOWS: u16 = 1 << 12;

/// A master with a cycle: in each, a set-point by RPDO 3 (synchronous), then SYNC; it keeps what TPDO 4 (synchronous) says of the position.
struct Master {
    drive: DriveBench,
    /// In microseconds.
    cycle: u64,
    /// When the next SYNC is due.
    next: u64,
    controlword: u16,
    /// 6064h as it was sent for each SYNC.
    shown: Vec<i32>,
    /// What was commanded.
    commanded: Vec<i32>,
    random: u64,
}

impl Master {
    /// A drive in operation enabled, mode 8, that has heard nothing of SYNC.
    fn new(mode: i8, cycle: u64) -> Self {
        let mut drive = DriveBench::started(4);
        drive.write_u8(0x6060, 0, mode.cast_unsigned());
        let (value, power) = match cycle {
            1_000 => (1, -3),
            2_000 => (2, -3),
            2_500 => (250, -5),
            4_000 => (4, -3),
            _ => (10, -3),
        };
        drive.write_u8(0x60C2, 1, value);
        drive.write_u8(0x60C2, 2, i8::cast_unsigned(power));
        // RPDO 3 and TPDO 4 are synchronous.
        drive.write_u8(0x1402, 2, 1);
        drive.write_u8(0x1803, 2, 1);
        drive.enable();
        let next = drive.now().ticks() + cycle;
        Self {
            drive,
            cycle,
            next,
            controlword: 0x0F,
            shown: Vec::new(),
            commanded: Vec::new(),
            random: 1,
        }
    }

    /// A number of −120 ..= 120.
    fn jitter(&mut self) -> i64 {
        self.random = self
            .random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        i64::try_from((self.random >> 33) % 241).unwrap() - 120
    }

    /// SYNC, so many microseconds off its time.
    fn sync(&mut self, off: i64) {
        let at = self.next.wrapping_add_signed(off);
        let now = self.drive.now().ticks();
        self.drive.run_micros(at.saturating_sub(now));
        self.drive.send("080 [0]");
        self.next += self.cycle;
        while let Some(frame) = self.drive.next(Duration::micros(0)) {
            self.hear(&frame);
        }
        // The answer takes its time on the bus.
        self.drive.run_micros(300);
        while let Some(frame) = self.drive.next(Duration::micros(0)) {
            self.hear(&frame);
        }
    }

    fn hear(&mut self, frame: &Frame) {
        if frame.standard_id() == Some(0x484)
            && let [a, b, c, d, ..] = *frame.bytes()
        {
            self.shown.push(i32::from_le_bytes([a, b, c, d]));
        }
    }

    /// The set-point of this cycle.
    fn set_point(&mut self, target: i32) {
        let mut data = [0; 6];
        data[..2].copy_from_slice(&self.controlword.to_le_bytes());
        data[2..].copy_from_slice(&target.to_le_bytes());
        self.drive.send_frame(Frame::data_frame(0x404, &data));
    }

    /// A whole cycle.
    fn cycle(&mut self, target: i32, off: i64) {
        self.set_point(target);
        self.commanded.push(target);
        self.sync(off);
    }

    /// A whole cycle without jitter, with where the motor is.
    fn steps(&mut self, targets: impl IntoIterator<Item = i32>) {
        for target in targets {
            self.cycle(target, 0);
        }
    }

    /// From cycle `first` on 6064h was, at each SYNC, the set-point of so many cycles before.
    #[track_caller]
    fn is_exact(&self, first: usize) {
        let behind = latency(self.cycle);
        let shown = self.shown.get(first + behind..).unwrap_or_default();
        let commanded = self.commanded.get(first..).unwrap_or_default();
        assert!(shown.len() > 100);
        for (k, (shown, commanded)) in shown.iter().zip(commanded).enumerate() {
            assert_eq!(shown, commanded, "{} us, cycle {}", self.cycle, first + k);
        }
    }

    fn has(&mut self, bits: u16) -> bool {
        self.drive.statusword() & bits == bits
    }
}

/// After how many cycles the motor is at a set-point.
fn latency(cycle: u64) -> usize {
    match cycle {
        1_000 => 4,
        2_000 | 2_500 => 3,
        _ => 2,
    }
}

/// A motion to and fro: `most` increments in a cycle at its fastest.
fn to_and_fro(most: i32) -> impl Iterator<Item = i32> {
    (0..400).scan(0, move |target, k| {
        let way = match k % 200 {
            up @ 0..50 => most * up / 50,
            50..100 => most,
            down => most - most * (down - 100) / 50,
        };
        *target += way;
        Some(*target)
    })
}

#[test]
fn m63_at_each_sync_the_motor_is_at_a_set_point_exactly() {
    for cycle in [1_000, 2_000, 4_000, 10_000] {
        let mut master = Master::new(8, cycle);
        for _ in 0..100 {
            let off = master.jitter();
            master.cycle(0, off);
        }
        // A step takes longer than the control tick is off its moment.
        for target in to_and_fro(i32::try_from(cycle / 50).unwrap()) {
            let off = master.jitter();
            master.cycle(target, off);
        }
        master.is_exact(100);
        assert!(master.has(FOLLOWS));
        assert!(!master.has(INTERNAL_LIMIT));
    }
}

#[test]
fn m63_without_jitter_it_is_exact_at_any_speed() {
    let mut master = Master::new(8, 1_000);
    master.steps([0; 300]);
    master.steps(to_and_fro(150));
    master.is_exact(300);
}

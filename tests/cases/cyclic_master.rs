//! A master of the cyclic modes: a set-point and SYNC in each cycle, with jitter, in virtual time.

use canopen::{Duration, Frame};
use tests::DriveBench;

/// Statusword bit 12: the drive follows the command value.
pub(crate) const FOLLOWS: u16 = 1 << 12;

/// A master with a cycle: in each, a set-point by RPDO 3 (synchronous), then SYNC; it keeps what TPDO 4 (synchronous) says of the position.
pub(crate) struct Master {
    pub(crate) drive: DriveBench,
    /// In microseconds.
    cycle: u64,
    /// When the next SYNC is due.
    pub(crate) next: u64,
    pub(crate) controlword: u16,
    /// 6064h as it was sent for each SYNC.
    pub(crate) shown: Vec<i32>,
    /// What was commanded.
    pub(crate) commanded: Vec<i32>,
    random: u64,
}

impl Master {
    /// A drive in operation enabled, mode 8, that has heard nothing of SYNC.
    pub(crate) fn new(mode: i8, cycle: u64) -> Self {
        Self::of(DriveBench::started(4), mode, cycle)
    }

    /// The same with a drive in switch on disabled.
    pub(crate) fn of(mut drive: DriveBench, mode: i8, cycle: u64) -> Self {
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
        Self::on(drive, cycle)
    }

    /// A master of a drive that is set up.
    pub(crate) fn on(drive: DriveBench, cycle: u64) -> Self {
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

    /// From the next SYNC on they come in this period.
    pub(crate) fn change_cycle(&mut self, cycle: u64) {
        self.next = self.next - self.cycle + cycle;
        self.cycle = cycle;
    }

    /// The next SYNC comes in so many microseconds.
    pub(crate) fn next_in(&mut self, micros: u64) {
        self.next = self.drive.now().ticks() + micros;
    }

    /// From SYNC to SYNC, in microseconds.
    pub(crate) fn cycle_time(&self) -> u64 {
        self.cycle
    }

    /// A number of −120 ..= 120.
    pub(crate) fn jitter(&mut self) -> i64 {
        self.random = self
            .random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        i64::try_from((self.random >> 33) % 241).unwrap() - 120
    }

    /// SYNC, so many microseconds off its time.
    pub(crate) fn sync(&mut self, off: i64) {
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

    pub(crate) fn hear(&mut self, frame: &Frame) {
        if frame.standard_id() == Some(0x484)
            && let [a, b, c, d, ..] = *frame.bytes()
        {
            self.shown.push(i32::from_le_bytes([a, b, c, d]));
        }
    }

    /// The set-point of this cycle.
    pub(crate) fn set_point(&mut self, target: i32) {
        let mut data = [0; 6];
        data[..2].copy_from_slice(&self.controlword.to_le_bytes());
        data[2..].copy_from_slice(&target.to_le_bytes());
        self.drive.send_frame(Frame::data_frame(0x404, &data));
    }

    /// A whole cycle.
    pub(crate) fn cycle(&mut self, target: i32, off: i64) {
        self.set_point(target);
        self.commanded.push(target);
        self.sync(off);
    }

    /// A whole cycle without jitter, with where the motor is.
    pub(crate) fn steps(&mut self, targets: impl IntoIterator<Item = i32>) {
        for target in targets {
            self.cycle(target, 0);
        }
    }

    /// From cycle `first` on 6064h was, at each SYNC, the set-point of so many cycles before.
    #[track_caller]
    pub(crate) fn is_exact(&self, first: usize) {
        self.is_exact_after(first, latency(self.cycle));
    }

    /// The same with so many cycles in between.
    #[track_caller]
    pub(crate) fn is_exact_after(&self, first: usize, behind: usize) {
        let shown = self.shown.get(first + behind..).unwrap_or_default();
        let commanded = self.commanded.get(first..).unwrap_or_default();
        assert!(shown.len() > 100);
        for (k, (shown, commanded)) in shown.iter().zip(commanded).enumerate() {
            assert_eq!(shown, commanded, "{} us, cycle {}", self.cycle, first + k);
        }
    }

    pub(crate) fn has(&mut self, bits: u16) -> bool {
        self.drive.statusword() & bits == bits
    }
}

/// The greatest change of 6064h's distance from one cycle to the next.
pub(crate) fn hardest(shown: &[i32]) -> i32 {
    let bend = |three: &[i32]| (three[2] - 2 * three[1] + three[0]).abs();
    shown.windows(3).map(bend).max().unwrap()
}

/// An expedited SDO download of 32 bits.
pub(crate) fn expedited(index: u16, value: i32) -> [u8; 8] {
    let [low, high] = index.to_le_bytes();
    let [a, b, c, d] = value.to_le_bytes();
    [0x23, low, high, 0, a, b, c, d]
}

/// An expedited SDO download of 32 bits to a sub-index.
pub(crate) fn expedited_sub(index: u16, sub: u8, value: i32) -> [u8; 8] {
    let mut data = expedited(index, value);
    data[3] = sub;
    data
}

/// After how many cycles the motor is at a set-point.
pub(crate) fn latency(cycle: u64) -> usize {
    if cycle < 1_500 { 3 } else { 2 }
}

//! The hybrid motor technology of the closed loop models: a stepper whose field never leads the rotor by more than its bound, and the torque mode.
//!
//! What the manual leaves open: a blocked rotor is one that is slower than [`SLOW`] while its lead or its torque is at its bound; make-up
//! velocities are microsteps/s; while hMT is
//! off the motor is moved by pulses, whether its encoder is looked at or not. A correction move makes up what was lost as soon as the
//! demand is at rest.

use canopen::od::Dictionary;
use cia402::behaviour::{number, put_number};
use cia402::loops::{LoopReport, MAY_BE_THERE, ServoSettings, StepperSettings};

/// Objects of our own: the fastest that the motor may turn.
const FASTEST: u16 = 0x5F0A;

/// Microsteps/s: ten turns a minute.
const SLOW: i32 = 51_200 * 10 / 60;

/// Microsteps in a full step.
const MICROSTEPS: i64 = 256;

/// 2742h.
const HAS_FAILED: i64 = 1 << 0;
const IS_LOCKED: i64 = 1 << 3;
const INTERVENES: i64 = 1 << 4;
const IS_ALIGNED: i64 = 1 << 7;

/// 2031h.
const HAS_ENCODER: i64 = 1 << 3;

const TORQUE: i64 = 4;

/// See the module.
#[derive(Debug, Default)]
pub(super) struct Hmt {
    /// The motor is moved by its current: loops have told something.
    is_there: bool,
    is_limited: bool,
    /// Milliseconds since the rotor stands though it is pulled, and since the motor stands.
    locked: u32,
    stands: u32,
    is_locked: bool,
    /// 606Ch in parts of 2⁸, and as it is shown.
    filtered: i64,
    velocity: Option<i64>,
    /// Milliseconds since the encoder is looked at.
    seen: u32,
    /// What the counter of positions has beyond the encoder.
    shift: i64,
    position: Option<i64>,
}

impl Hmt {
    fn is_enabled<D: Dictionary>(&self, dictionary: &D) -> bool {
        self.is_there() && number(dictionary, 0x2701, 0) == 0x80
    }

    /// Whether the motor is moved by its current.
    pub(super) const fn is_there(&self) -> bool {
        MAY_BE_THERE && self.is_there
    }

    /// The loops tell, and are set up.
    pub(super) fn loops<D: Dictionary>(
        &mut self,
        dictionary: &mut D,
        report: &LoopReport,
        settings: &mut ServoSettings,
    ) {
        self.is_there = true;
        let is_enabled = self.is_enabled(dictionary);
        self.is_limited = report.is_limited && report.is_on;
        let intervenes = is_enabled && self.is_limited && report.lead > 100;
        let status = IS_ALIGNED
            | if self.is_locked {
                IS_LOCKED | HAS_FAILED
            } else {
                0
            }
            | if intervenes { INTERVENES } else { 0 };
        put_number(dictionary, 0x2742, 0, status);
        let passed = status & number(dictionary, 0x2743, 0);
        put_number(dictionary, 0x2741, 0, passed);
        // What is blocked is told here.
        settings.blocked = (0, 10);
        settings.stepper = self.stepper(dictionary, is_enabled);
    }

    fn stepper<D: Dictionary>(&self, dictionary: &D, is_enabled: bool) -> StepperSettings {
        let configuration = number(dictionary, 0x2702, 0);
        let corrects = number(dictionary, 0x2221, 1) != 0;
        let mode = match (is_enabled, configuration & 3) {
            (false, _) if corrects => 2,
            (false, _) => 1,
            (true, 0 | 1) => 4,
            (true, _) => 3,
        };
        // Microsteps/s: 2.5 MHz, or one in (x + 2) · 50 ns.
        let made_up = match configuration & 3 {
            3 => 20_000_000 / (number(dictionary, 0x2703, 0) + 2).max(1),
            _ => 2_500_000,
        };
        let (run, hold) = (number(dictionary, 0x2204, 0), number(dictionary, 0x2205, 0));
        let share = (hold * 1_000 / run.max(1)).clamp(50, 1_000);
        let delay = number(dictionary, 0x2036, 0);
        let rests = delay != 0 && i64::from(self.stands) >= delay;
        // The current goes with the load, or it is the one of its two that is due.
        let is_variable = is_enabled && configuration & 0x80 != 0;
        let (current, at_rest) = match (is_variable, rests) {
            (true, _) => (run * 10, share),
            (false, false) => (run * 10, 1_000),
            (false, true) => ((hold * 10).max(1), 1_000),
        };
        let word = |number: i64| u16::try_from(number).unwrap_or(u16::MAX);
        StepperSettings {
            mode,
            bound: 110 + 20 * word(configuration >> 5 & 3),
            speed: word((made_up / MICROSTEPS).max(1)),
            current: word(current.max(20)),
            at_rest: word(at_rest),
            fall: 20,
            is_at_once: true,
        }
    }

    /// A tick has passed.
    pub(super) fn tick<D: Dictionary>(
        &mut self,
        dictionary: &mut D,
        (is_enabled, is_moving): (bool, bool),
        (velocity, encoder, demand): (i32, i32, i32),
    ) {
        self.filter(dictionary, velocity);
        if !self.is_there() {
            return;
        }
        self.stands = if is_moving {
            0
        } else {
            self.stands.saturating_add(1)
        };
        let is_pulled = is_enabled && self.is_enabled(dictionary) && self.is_limited;
        let stands = is_pulled && velocity.saturating_abs() < SLOW;
        self.locked = if stands {
            self.locked.saturating_add(1)
        } else {
            0
        };
        let patience = number(dictionary, 0x2710, 0);
        self.is_locked |= patience != 0 && i64::from(self.locked) >= patience;
        self.count(dictionary, encoder.into(), demand.into());
    }

    /// 6064h is what was commanded, or the encoder once it is looked at for long enough.
    fn count<D: Dictionary>(&mut self, dictionary: &D, encoder: i64, demand: i64) {
        let options = number(dictionary, 0x2031, 0);
        if options & HAS_ENCODER == 0 && !self.is_enabled(dictionary) {
            self.seen = 0;
            self.position = Some(demand);
            return;
        }
        let delay = number(dictionary, 0x2037, 0);
        if self.seen == 0 && options >> 4 & 3 == 2 {
            // The counter is the master: the encoder takes what it has.
            self.shift = demand - encoder;
        } else if self.seen == 0 {
            self.shift = 0;
        }
        self.seen = self.seen.saturating_add(1);
        self.position = Some(if i64::from(self.seen) > delay {
            encoder + self.shift
        } else {
            demand
        });
    }

    /// 2708h: 606Ch comes to a new velocity in so many ms.
    fn filter<D: Dictionary>(&mut self, dictionary: &D, velocity: i32) {
        let is_torque = number(dictionary, 0x6061, 0) == TORQUE;
        let time = match number(dictionary, 0x2708, 0) {
            0 if is_torque && self.is_there() => 256,
            1 => 64,
            2 => 128,
            3 => 196,
            4 => 256,
            8 => 16,
            9 => 24,
            10 => 32,
            _ => 1,
        };
        let actual = i64::from(velocity) << 8;
        self.filtered += (actual - self.filtered) / time;
        if time == 1 {
            self.filtered = actual;
        }
        self.velocity = (time != 1).then_some(self.filtered >> 8);
    }

    /// What the drive shows anew is shown as it is here.
    pub(super) fn show<D: Dictionary>(&self, dictionary: &mut D) {
        if let Some(velocity) = self.velocity {
            put_number(dictionary, 0x606C, 0, velocity);
        }
        if let Some(position) = self.position.filter(|_| self.is_there()) {
            put_number(dictionary, 0x6064, 0, position);
        }
    }

    /// 2704h, while a torque is held. Returns whether it is another one.
    pub(super) fn limit<D: Dictionary>(&self, dictionary: &mut D) -> bool {
        let fastest = match number(dictionary, 0x6060, 0) {
            TORQUE if MAY_BE_THERE => 12_000_000 / (number(dictionary, 0x2704, 0) + 2).max(1),
            _ => u32::MAX.into(),
        };
        let is_new = number(dictionary, FASTEST, 0) != fastest;
        put_number(dictionary, FASTEST, 0, fastest);
        is_new
    }

    /// 2740h.
    pub(super) fn clear<D: Dictionary>(&mut self, dictionary: &mut D) {
        if number(dictionary, 0x2740, 0) == 4 {
            self.is_locked = false;
            self.locked = 0;
        }
    }

    /// Whether the bridge is to be off: 2711h.
    pub(super) fn bars<D: Dictionary>(&self, dictionary: &D) -> bool {
        self.is_there() && self.is_locked && number(dictionary, 0x2711, 0) >= 2
    }
}

//! The closed loop of the Nanotec: when it is on, its gains, load angle and currents, and the test runs that find the magnet.
//!
//! What the manual leaves open: velocity mode has the speed controller, all else the position controller; gains are in proportion to those
//! that the axis has, which the defaults of 2002h stand for; the amplitude of a phase is the current that percents
//! are of, 7.5 A; a peak current is borne for the time of 2004h:14 in ms; the index was seen when the motor has gone a turn; without the
//! loop the motor is a supervised stepper, and a
//! correction travel makes up what was lost. The digits of 2004h:12 are sectors by the table of type 1, and the default is the order of the axis.

use canopen::od::Dictionary;
use cia402::behaviour::{number, put_number};
use cia402::loops::{LoopReport, Request, ServoSettings, StepperSettings};

/// Objects of our own: what thousandths are of, in mA and mNm, and how many of them there may be.
const RATED_CURRENT: u16 = 0x5F08;
const RATED_TORQUE: u16 = 0x5F09;
const MOST_CURRENT: u16 = 0x5F0A;
pub(super) const WINDOW: u16 = 0x5F0B;

/// mA of a percent.
const PERCENT: i64 = 75;

/// A quarter of an electrical turn: the load angle that gives the most torque.
const QUARTER: i64 = 16_384;

/// Ticks before a test run.
const SETTLES: u8 = 50;

/// The words of the Hall sensors in the sectors 0 to 5, by the table of type 1: H1 is bit 0.
const HALL_SECTORS: [u8; 6] = [3, 1, 4, 2, 6, 5];

const VELOCITY: i64 = 2;
const HOMING: i64 = 6;
const TEST_RUN: i64 = -1;
const SHORT_RUN: i64 = -2;

/// See the module.
#[derive(Debug, Default)]
pub(super) struct ClosedLoop {
    /// Loops move the motor.
    is_there: bool,
    is_on: bool,
    /// The pole pairs with which it has got power.
    pole_pairs: Option<i64>,
    /// The encoder between these counts since the power came.
    seen: Option<(i64, i64)>,
    is_found: bool,
    is_aligned: bool,
    cascades: bool,
    /// A lost position is being made up.
    corrects: bool,
    /// What was asked of the motor, and what is to be asked.
    run: i64,
    request: Option<Request>,
    /// Ticks until it is asked: the current of a stepper is to be gone.
    wait: u8,
    /// ms of peak current that were used.
    peak: i64,
    is_moving: bool,
    error: i64,
    /// The rated current of the motor, in mA.
    rated: i64,
}

impl ClosedLoop {
    /// The drive has published what it does.
    pub(super) fn tick(&mut self, is_moving: bool, error: i32) {
        (self.is_moving, self.error) = (is_moving, error.unsigned_abs().into());
    }

    /// 6060h was written.
    pub(super) fn choose<D: Dictionary>(&mut self, dictionary: &D) {
        let mode = number(dictionary, 0x6060, 0);
        let distance = match mode {
            TEST_RUN => 500,
            SHORT_RUN => 100,
            _ => 0,
        };
        let run = if distance == 0 { 0 } else { mode };
        if run != self.run {
            self.request = Some(match distance {
                0 => Request::End,
                _ => Request::Motor {
                    current: 800,
                    distance,
                    bandwidth: 0,
                },
            });
        }
        self.run = run;
        self.wait = SETTLES;
    }

    /// The test run that was chosen in place of a mode.
    pub(super) fn run(&self) -> Option<i64> {
        (self.run != 0).then_some(self.run)
    }

    /// The loops tell, and are set up.
    pub(super) fn loops<D: Dictionary>(
        &mut self,
        dictionary: &mut D,
        report: &LoopReport,
        settings: &mut ServoSettings,
    ) -> Option<Request> {
        self.is_there = true;
        self.rated = report.rated_current.into();
        self.look_for_index(report);
        self.take_result(dictionary, report);
        self.switch(dictionary);
        self.show(dictionary, report);
        let pairs = number(dictionary, 0x2006, 0);
        let pairs = *self.pole_pairs.get_or_insert(pairs);
        // A motor without brushes has the pole pairs of the axis.
        let is_stepper = number(dictionary, 0x2004, 7) == 0;
        settings.pole_pairs = if is_stepper { word(pairs) } else { 0 };
        settings.offset = word(number(dictionary, 0x200B, 0));
        settings.is_turned = number(dictionary, 0x200D, 0) == 1;
        settings.hall = hall_order(number(dictionary, 0x2004, 12)).unwrap_or_default();
        settings.lead = lead(dictionary, report);
        settings.gains = self.gains(dictionary, report);
        (settings.share, settings.learning) = current_gains(dictionary, report);
        settings.stepper = self.stepper(dictionary);
        self.wait = self.wait.saturating_sub(1);
        if self.wait > 0 {
            return None;
        }
        self.request.take()
    }

    fn look_for_index(&mut self, report: &LoopReport) {
        let (low, high) = self.seen.unwrap_or((report.counts, report.counts));
        let seen = (low.min(report.counts), high.max(report.counts));
        self.seen = Some(seen);
        self.is_found |= seen.1 - seen.0 >= i64::from(report.counts_of_turn);
    }

    /// A test run is over.
    fn take_result<D: Dictionary>(&mut self, dictionary: &mut D, report: &LoopReport) {
        if self.run == 0 || self.request.is_some() || !report.found.has_ended() || self.is_aligned {
            return;
        }
        if report.found.failure == 0 {
            let offset = report.found.angle.wrapping_sub(report.zero);
            put_number(dictionary, 0x200B, 0, offset.into());
            self.is_aligned = true;
            if self.run == TEST_RUN {
                for sub in 1..=7 {
                    put_number(dictionary, 0x200C, sub, QUARTER);
                }
            }
        }
    }

    /// 2001h.
    fn switch<D: Dictionary>(&mut self, dictionary: &D) {
        let encoder = number(dictionary, 0x2011, 0);
        let has_index = encoder == 3 || encoder == 1 && self.is_found;
        self.is_on = match number(dictionary, 0x2001, 0) {
            _ if number(dictionary, 0x2004, 7) != 0 => true,
            _ if encoder == 0 => false,
            1 => self.is_on || (has_index && !self.is_moving),
            2 => self.is_on || has_index,
            3 => self.is_on || self.is_aligned,
            _ => false,
        };
    }

    fn show<D: Dictionary>(&mut self, dictionary: &mut D, report: &LoopReport) {
        put_number(dictionary, 0x200A, 0, i64::from(self.is_on));
        // 8192 is 1000/min.
        let speed = i64::from(report.speed).abs() * 8_192 / 1_000_000;
        self.cascades = if self.cascades {
            speed >= number(dictionary, 0x2004, 10)
        } else {
            speed >= number(dictionary, 0x2004, 9)
        };
        put_number(dictionary, 0x2004, 11, i64::from(self.cascades));
    }

    /// How near the target is reached: without the loop it is where the motor stands.
    pub(super) fn window<D: Dictionary>(&self, dictionary: &D) -> i64 {
        if self.is_there && !self.is_on {
            u32::MAX.into()
        } else {
            number(dictionary, 0x6067, 0)
        }
    }

    /// What thousandths of current and torque are of, and how many there may be. Returns whether that is new.
    pub(super) fn limit<D: Dictionary>(&mut self, dictionary: &mut D, report: &LoopReport) -> bool {
        let whole = number(dictionary, 0x2004, 1).max(1);
        let block = number(dictionary, 0x2004, 4);
        let peak = number(dictionary, 0x2004, 13);
        let is_homing = number(dictionary, 0x6061, 0) == HOMING
            && matches!(number(dictionary, 0x6098, 0), -3 | -2);
        let milliamperes = whole * PERCENT;
        let flows = i64::from(report.current.1).abs();
        let has_peak = number(dictionary, 0x2004, 7) != 0 && peak > whole;
        let time = number(dictionary, 0x2004, 14);
        let is_above = flows > milliamperes + milliamperes / 50;
        self.peak = if is_above {
            self.peak + 1
        } else if flows < milliamperes * 9 / 10 {
            (self.peak - 1).max(0)
        } else {
            self.peak
        };
        let most = match (is_homing && block != 0, has_peak && self.peak < time) {
            (true, _) => block,
            (false, true) => peak,
            (false, false) => whole,
        };
        let torque = milliamperes * i64::from(report.torque_constant) / 1_000_000;
        let mut is_new = false;
        for (index, value) in [
            (RATED_CURRENT, milliamperes),
            (RATED_TORQUE, torque.max(1)),
            (WINDOW, self.window(dictionary)),
            (MOST_CURRENT, (most * 1_000 / whole).min(0xFFFF)),
        ] {
            is_new |= number(dictionary, index, 0) != value;
            put_number(dictionary, index, 0, value);
        }
        is_new
    }

    /// Speed, integral and position: 2002h, or its cascade.
    fn gains<D: Dictionary>(&self, dictionary: &D, report: &LoopReport) -> [u16; 3] {
        let gain = |sub: u8| {
            let power = number(dictionary, 0x2002, sub + 1).clamp(0, 16);
            number(dictionary, 0x2002, sub) << 16 >> power
        };
        // Numerators of the gains, and those of the defaults, in parts of 2¹⁶.
        let [own_velocity, own_integral, own_position] = report.own_gains;
        let of = |own: u16, (gain, whole): (i64, i64)| {
            word((i64::from(own) * gain / whole).clamp(1, 10_000))
        };
        let is_by_speed =
            number(dictionary, 0x6061, 0) == VELOCITY && number(dictionary, 0x200F, 0) == 0;
        let (velocity, integral, position) = match (self.cascades, is_by_speed) {
            (true, _) => (
                (gain(13), 50 << 16),
                (gain(15), 2 << 16),
                (gain(19), 2 << 16),
            ),
            (false, true) => ((gain(1), 2 << 16), (gain(3), 1 << 10), (0, 1)),
            // What a position controller differentiates is what acts on a velocity.
            (false, false) => (
                (gain(11), 300 << 16),
                (gain(9), 2 << 16),
                (gain(7), 100 << 16),
            ),
        };
        [
            of(own_velocity, velocity),
            of(own_integral, integral),
            if is_by_speed {
                1
            } else {
                of(own_position, position)
            },
        ]
    }

    fn stepper<D: Dictionary>(&mut self, dictionary: &D) -> StepperSettings {
        let tolerance = number(dictionary, 0x2004, 6);
        let corrects = number(dictionary, 0x2011, 0) != 0 && self.error > tolerance;
        self.corrects = corrects || self.corrects && self.error > 2;
        let (run, rest) = (number(dictionary, 0x2004, 1), number(dictionary, 0x2004, 2));
        let block = number(dictionary, 0x2004, 4);
        let is_homing = number(dictionary, 0x6061, 0) == HOMING
            && matches!(number(dictionary, 0x6098, 0), -3 | -2);
        let run = if is_homing && block != 0 { block } else { run };
        StepperSettings {
            mode: match (self.is_on || self.run != 0, self.corrects) {
                (true, _) => 0,
                (false, true) => 2,
                (false, false) => 1,
            },
            bound: 150,
            speed: 1_000,
            current: word(run * PERCENT * 1_000 / self.rated.max(1)),
            at_rest: word((rest * 1_000 / run.max(1)).clamp(50, 1_000)),
            fall: word(number(dictionary, 0x2004, 3).max(1)),
            is_at_once: true,
        }
    }
}

/// The words of the Hall sensors in their order, from six sectors as hexadecimal digits, the highest first; each sector comes once.
pub(super) fn hall_order(digits: i64) -> Option<[u8; 6]> {
    // The default lists them against the direction of the axis, from its fifth word on.
    let words = [4, 8, 12, 16, 20, 0].map(|shift| {
        let sector = usize::try_from(digits >> shift & 0xF).ok()?;
        HALL_SECTORS.get(sector).copied()
    });
    let mut order = [0; 6];
    let mut seen = 0_u8;
    for (place, word) in order.iter_mut().zip(words) {
        *place = word?;
        seen |= 1 << *place;
    }
    (seen == 0b0111_1110 && digits >> 24 == 0).then_some(order)
}

fn word(number: i64) -> u16 {
    u16::try_from(number).unwrap_or(u16::MAX)
}

/// KP and KI of 200Eh at the present speed: ten of each are what the axis has, and each 1000/min adds a tenth of their scale.
fn current_gains<D: Dictionary>(dictionary: &D, report: &LoopReport) -> (u16, u16) {
    let speed = i64::from(report.speed).abs() / 1_000;
    let of = |sub: u8, own: u16, most: i64| {
        let added = number(dictionary, 0x200E, sub + 1).saturating_mul(speed) / 10_000;
        let gain = number(dictionary, 0x200E, sub) + added;
        word((i64::from(own) * gain / 10).clamp(1, most))
    };
    (
        of(2, report.own_share, 990),
        of(5, report.own_learning, 490),
    )
}

/// How much more than a quarter of an electrical turn the current leads: 200Ch at the present speed, even between its points.
fn lead<D: Dictionary>(dictionary: &D, report: &LoopReport) -> i16 {
    let spacing = number(dictionary, 0x2004, 8).max(1);
    let speed = i64::from(report.speed).abs() * 8_192 / 1_000_000;
    let place = (speed / spacing).min(5);
    let rest = (speed - place * spacing).min(spacing);
    let sub = u8::try_from(place).unwrap_or(0) + 1;
    let (from, to) = (
        number(dictionary, 0x200C, sub),
        number(dictionary, 0x200C, sub + 1),
    );
    let angle = from + (to - from) * rest / spacing - QUARTER;
    let angle = i16::try_from(angle).unwrap_or(0);
    // Against the torque where that is negative.
    if report.current.1 < 0 { -angle } else { angle }
}

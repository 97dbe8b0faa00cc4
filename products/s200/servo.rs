//! The motor of the S200 and its loops: current set-points, limits of the current, motor data, gains, monitors.
//!
//! The manual gives no units. Chosen here: currents are the amplitude of a phase in mA; ML µH, MKT mN·m/A, DPoles poles, MPHASE,
//! CommOffset, MTANGLP and MVANGLF electrical
//! degrees, MVANGLB and VCOMM 1/min; the motor of the axis has number 1, and 0 is one whose data are written; ITMode 1 makes a fault of
//! spent I²t; CommMode 0 goes by the sensors of the axis, 1 by the encoder alone, so that the magnet is looked for; KVP and KPP 1/s, KVI Hz, KVFF, KTFF and MLGQ thousandths, MLGC, MLGP and MLGD thousandths of that, I2TLIM percent; ISCALE1 mA
//! at 10 V. Of motor data, gains and EncIn1Lines 0 is what the axis has.

use canopen::cia301::sdo::AbortCode;
use canopen::od::{Dictionary, Entry};
use cia402::behaviour::{number, put_number};
use cia402::commands::Commands;
use cia402::loops::{LoopReport, Request, ServoSettings};

const TORQUE: i64 = 4;
const DIGITAL_CURRENT: i64 = -126;
const ANALOGUE_CURRENT: i64 = -125;

/// DPRILIMIT.
const DPR_LIMIT: u16 = 0x3658;

/// Our own: the greatest positive and negative torque, in thousandths.
const LIMITS: u16 = 0x5105;

/// Our own: ICMDVLIM, which the text interface alone has, and the fastest that the motor may turn, both in 1/min.
const SPEEDS: u16 = 0x510C;

/// The current of 1000 thousandths, in mA, as the binding has it.
const RATED: i64 = 4_000;

/// F25: commutation. F15: I²t.
const COMMUTATION: u16 = 0x7122;
const OVERLOAD: u16 = 0x8331;

/// The only motor that the drive knows by a number, and its name, four letters with the lowest byte first.
const KNOWN_MOTOR: i64 = 1;
const NAME: i64 = 0x3030_314D;

/// A synchronous motor that turns.
const SYNCHRONOUS: i64 = 1;

/// So many ticks a motor runs against its current before its commutation is wrong.
const RUNS_AWAY: u8 = 5;

/// 2000h: n01. 1002h: feed-forward off.
const HOT: i64 = 1 << 0;
const NOTHING_AHEAD: i64 = 1 << 22;

/// The states of three Hall signals in an electrical turn.
const HALL: [i64; 6] = [1, 3, 2, 6, 4, 5];

/// See the module.
#[derive(Debug, Default)]
pub(super) struct Servo {
    /// mA that the modes of current ask for.
    wanted: i64,
    request: Option<Request>,
    is_tuning: bool,
    /// The speed of the last tick, and for how many the motor has run against its current.
    speed: i32,
    runs_away: u8,
    has_run_away: bool,
    is_spent: bool,
    /// MNUMBER was written.
    is_chosen: bool,
    /// What there is beside the words of the drive: of 2000h and 1002h.
    pub(super) beside: (i64, i64),
}

impl Servo {
    pub(super) fn check(entry: &Entry, value: i64) -> Result<(), AbortCode> {
        let is_known = match (entry.index, entry.sub) {
            (0x3599, 1) => (0..=KNOWN_MOTOR).contains(&value),
            (0x35A6, 1) => (0..=SYNCHRONOUS).contains(&value),
            (0x362C | 0x38F8 | 0x3900 | 0x3B7F, 1) => (0..=1).contains(&value),
            _ => true,
        };
        is_known.then_some(()).ok_or(AbortCode::InvalidValue)
    }

    pub(super) fn written<D: Dictionary>(&mut self, dictionary: &mut D, entry: &Entry) -> bool {
        match (entry.index, entry.sub) {
            // CTUNE.
            (0x351E, 1) => {
                self.request = Some(Request::Motor {
                    current: 800,
                    distance: 500,
                    bandwidth: 0,
                });
                self.is_tuning = true;
            }
            // T.
            (0x360E, 1) => self.wanted = number(dictionary, 0x360E, 1),
            (0x356E | 0x38F3 | 0x38F4 | 0x362C | DPR_LIMIT, 1) => self.limit(dictionary),
            (0x3599, 1) => self.is_chosen = true,
            // A reset of errors, or another mode, begins anew.
            (0x6040, _) => {
                self.has_run_away = false;
                self.is_spent = false;
                return false;
            }
            (0x6060, _) => {
                self.wanted = 0;
                Self::limit_speed(dictionary);
            }
            // MSPEED is another name of it.
            (0x35A3, 1) => {
                let max = number(dictionary, 0x35A3, 1);
                put_number(dictionary, 0x6080, 0, max);
                Self::limit_speed(dictionary);
            }
            (0x6080 | SPEEDS | 0x35B4, _) => Self::limit_speed(dictionary),
            _ => return false,
        }
        true
    }

    /// IPEAK in both directions, ILmtPlus and ILmtMinus in one.
    pub(super) fn limit<D: Dictionary>(&mut self, dictionary: &mut D) {
        let peak = number(dictionary, 0x356E, 1);
        // DILIM: that of the dual-port RAM counts.
        let ram = match number(dictionary, 0x362C, 1) {
            0 => 0,
            _ => number(dictionary, DPR_LIMIT, 1),
        };
        for (sub, own) in [(1, 0x38F3), (2, 0x38F4)] {
            let own = number(dictionary, own, 1).saturating_abs();
            let least = [peak, own, ram]
                .into_iter()
                .filter(|limit| *limit > 0)
                .min();
            let share = least.map_or(0xFFFF, |limit| (limit * 1_000 / RATED).min(0xFFFF));
            put_number(dictionary, LIMITS, sub, share);
        }
    }

    /// 6080h, and in the modes of torque and current ICMDVLIM; a limit of 0 is none.
    pub(super) fn limit_speed<D: Dictionary>(dictionary: &mut D) {
        let own = number(dictionary, SPEEDS, 1);
        let mode = number(dictionary, 0x6060, 0);
        let has_own = own > 0 && matches!(mode, TORQUE | DIGITAL_CURRENT | ANALOGUE_CURRENT);
        let max = number(dictionary, 0x6080, 0);
        put_number(dictionary, 0x35A3, 1, max);
        let max = if has_own { max.min(own) } else { max };
        put_number(dictionary, SPEEDS, 2, max);
    }

    /// The analogue input asks for a current. Returns whether it is another one.
    pub(super) fn tick<D: Dictionary>(&mut self, dictionary: &D) -> bool {
        if number(dictionary, 0x6060, 0) != ANALOGUE_CURRENT {
            return false;
        }
        let voltage = number(dictionary, 0x3509, 1);
        let scale = number(dictionary, 0x3571, 1);
        let wanted = voltage.saturating_mul(scale) / 10_000;
        core::mem::replace(&mut self.wanted, wanted) != wanted
    }

    pub(super) fn command<D: Dictionary>(&self, dictionary: &D, commands: &mut Commands) {
        let own = number(dictionary, 0x6060, 0);
        if matches!(own, DIGITAL_CURRENT | ANALOGUE_CURRENT) {
            let share = (self.wanted.saturating_mul(1_000) / RATED).clamp(-32_000, 32_000);
            commands.target_torque = i16::try_from(share).unwrap_or(0);
        }
        if let Some(fault) = self.fault() {
            commands.fault.get_or_insert(fault);
        }
    }

    /// The loops tell, and are set up. Returns what is to be measured.
    pub(super) fn loops<D: Dictionary>(
        &mut self,
        dictionary: &mut D,
        report: &LoopReport,
        settings: &mut ServoSettings,
    ) -> Option<Request> {
        self.show(dictionary, report);
        let has_bound = number(dictionary, 0x3B7F, 1) == 1;
        self.is_spent |= has_bound && report.heat >= 990 && report.is_on;
        self.look_for_commutation(dictionary, report);
        let of = |index: u16| number(dictionary, index, 1);
        let pairs = of(0x38F9) / 2;
        settings.pole_pairs = word(pairs);
        let pairs = if pairs == 0 {
            report.pole_pairs.into()
        } else {
            pairs
        };
        let inductance = long(of(0x3577).saturating_mul(1_000));
        // Torque of an ampere is 3/2 pole pairs times the flux.
        let flux = of(0x3593).saturating_mul(2_000_000) / (3 * pairs).max(1);
        settings.motor = [0, inductance, inductance, long(flux), 0, 0];
        settings.offset = turned(of(0x359C) + of(0x38FD)).cast_unsigned();
        settings.is_searched = of(0x38F8) == 1;
        // Four counts of a line.
        settings.encoder = long(of(0x38FA).saturating_mul(4));
        settings.lead = lead(dictionary, report);
        // It knows no blocked rotor.
        settings.blocked = (0, 10);
        // To brake with a wrong commutation would be to drive.
        settings.is_barred = self.has_run_away || number(dictionary, 0x3900, 1) == 0;
        let corner = of(0x38F2).saturating_mul(6_283) / 1_000;
        settings.gains = [of(0x38F1), corner, of(0x3901)].map(word);
        settings.ahead = (word(of(0x3902)), word(of(0x3903)));
        let own = of(0x3598).saturating_mul(report.own_share.into()) / 1_000;
        let share = |thousandths: i64| word((own * thousandths / 1_000).clamp(1, 990));
        settings.share = share(adapted(dictionary, report));
        settings.share_along = share(of(0x3596));
        self.take_result(dictionary, report);
        self.request.take()
    }

    fn show<D: Dictionary>(&mut self, dictionary: &mut D, report: &LoopReport) {
        let (along, across) = report.current;
        let (along, across) = (i64::from(along), i64::from(across));
        let square = (along * along + across * across).cast_unsigned();
        let size = i64::from(square.isqrt() as u32);
        // I, IQ, ID, and the same of the base unit.
        for (index, value) in [
            (0x3558, if across < 0 { -size } else { size }),
            (0x3570, across),
            (0x355D, along),
            (0x3B89, across),
            (0x3B8A, along),
            // ESPEED.
            (0x3675, report.max_speed.into()),
        ] {
            put_number(dictionary, index, 1, value);
        }
        let sector = (usize::from(report.angle) * HALL.len()) >> 16;
        put_number(
            dictionary,
            0x38FC,
            1,
            HALL.get(sector).copied().unwrap_or(0),
        );
        let bound = number(dictionary, 0x355A, 1);
        let is_hot = bound > 0 && i64::from(report.heat) >= bound * 10;
        let has_nothing = number(dictionary, 0x3902, 1) == 0 && number(dictionary, 0x3903, 1) == 0;
        self.beside = (
            i64::from(is_hot) * HOT,
            i64::from(has_nothing) * NOTHING_AHEAD,
        );
    }

    /// MNUMBER: the data of a motor that the drive knows. Returns whether they were taken.
    pub(super) fn take_motor<D: Dictionary>(
        &mut self,
        dictionary: &mut D,
        report: &LoopReport,
    ) -> bool {
        if !core::mem::take(&mut self.is_chosen) || number(dictionary, 0x3599, 1) != KNOWN_MOTOR {
            return false;
        }
        let [_, _, across, ..] = report.own_motor.map(i64::from);
        for (index, value) in [
            (0x35A6, SYNCHRONOUS),
            (0x38F0, NAME),
            (0x3577, across / 1_000),
            (
                0x3593,
                (i64::from(report.own_torque_constant) + 500) / 1_000,
            ),
            (0x358E, report.rated_current.into()),
            (0x358F, report.peak_current.into()),
            (0x38F9, i64::from(report.own_pole_pairs) * 2),
            (0x3900, 1),
        ] {
            put_number(dictionary, index, 1, value);
        }
        put_number(dictionary, 0x6080, 0, report.max_speed.into());
        Self::limit_speed(dictionary);
        true
    }

    /// VCOMM: the motor runs against its current, and ever faster.
    fn look_for_commutation<D: Dictionary>(&mut self, dictionary: &D, report: &LoopReport) {
        let bound = number(dictionary, 0x365A, 1).saturating_mul(1_000);
        let before = core::mem::replace(&mut self.speed, report.speed);
        let is_against = i64::from(report.current.1) * i64::from(report.speed) < 0;
        let is_faster = report.speed.unsigned_abs() >= before.unsigned_abs();
        let is_fast = bound > 0 && i64::from(report.speed).abs() > bound;
        self.runs_away = match report.is_on && is_against && is_faster && is_fast {
            true => self.runs_away.saturating_add(1),
            false => self.runs_away.saturating_sub(1),
        };
        self.has_run_away |= self.runs_away >= RUNS_AWAY;
    }

    /// What is to be raised.
    pub(super) fn fault(&self) -> Option<u16> {
        match (self.has_run_away, self.is_spent) {
            (true, _) => Some(COMMUTATION),
            (false, true) => Some(OVERLOAD),
            (false, false) => None,
        }
    }

    /// CTUNE is over.
    fn take_result<D: Dictionary>(&mut self, dictionary: &mut D, report: &LoopReport) {
        let found = &report.found;
        if !self.is_tuning || self.request.is_some() || !found.has_ended() {
            return;
        }
        self.is_tuning = false;
        if found.failure == 0 {
            let [_, _, across, flux] = found.winding.map(i64::from);
            put_number(dictionary, 0x3577, 1, (across + 500) / 1_000);
            let constant = flux * 3 * i64::from(found.pole_pairs) / 2_000_000;
            put_number(dictionary, 0x3593, 1, constant);
        }
    }
}

/// What the gain across the magnet is by the current: MLGC at the rated one, MLGP at the peak.
fn adapted<D: Dictionary>(dictionary: &D, report: &LoopReport) -> i64 {
    let current = i64::from(report.current.1).abs();
    let rated = i64::from(report.rated_current).max(1);
    let peak = i64::from(report.peak_current).max(rated + 1);
    let of = |index: u16| number(dictionary, index, 1);
    if current < rated {
        1_000 + (of(0x3595) - 1_000) * current / rated
    } else {
        let above = (current - rated).min(peak - rated);
        let more = (of(0x3597) - of(0x3595)) * above;
        of(0x3595) + more.checked_div(peak - rated).unwrap_or(0)
    }
}

fn word(number: i64) -> u16 {
    u16::try_from(number.max(0)).unwrap_or(u16::MAX)
}

fn long(number: i64) -> u32 {
    u32::try_from(number.max(0)).unwrap_or(u32::MAX)
}

/// Degrees as turns of 2¹⁶.
fn turned(degrees: i64) -> i16 {
    // A turn more or less is nothing.
    (degrees % 360 * 65_536 / 360) as i16
}

/// MTANGLP at the peak current, MVANGLF at the greatest speed, from MVANGLB on.
fn lead<D: Dictionary>(dictionary: &D, report: &LoopReport) -> i16 {
    let of = |index: u16| number(dictionary, index, 1);
    let peak = of(0x358F).max(1);
    let current = i64::from(report.current.1);
    let by_current = of(0x35A5).saturating_mul(current.clamp(-peak, peak)) / peak;
    let (begin, end) = (of(0x35A7), of(0x35A3));
    let speed = i64::from(report.speed) / 1_000;
    let above = (speed.abs() - begin).clamp(0, (end - begin).max(1));
    let by_speed = of(0x35A8).saturating_mul(above * speed.signum()) / (end - begin).max(1);
    turned((by_current + by_speed).clamp(-60, 60))
}

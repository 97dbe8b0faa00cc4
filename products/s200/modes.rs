//! The maker's modes (80h digital velocity, 81h analogue velocity, 88h motion tasks), jog, limits of speed, and parameters that are another way to say
//! what an object of CiA 402 says (OPMODE, NREF and DREF).
//!
//! The manual gives no units. Those of its series: VLIM, VLIMP, VLIMN, VOSPD and VSCALE1 are 1/min, VSCALE1 at 10 V; PVMAX, PVMAXP, PVMAXN and VJOG
//! are velocity units as 6081h; ANDB is mV. A limit of 0 is none. Chosen: CmdSrc 1 gives the velocity of
//! mode 80h to the analogue input; EXTLATCH 1 latches at the zero pulse.

use canopen::cia301::sdo::AbortCode;
use canopen::od::{Dictionary, Entry};
use cia402::Command;
use cia402::behaviour::{Requests, number, put_number};
use cia402::behaviour::{SignedSpeed, Speed};
use cia402::commands::Commands;
use cia402::units::Units;

use super::Seen;

pub(super) const DIGITAL_VELOCITY: i64 = -128;
const ANALOGUE_VELOCITY: i64 = -127;
pub(super) const GEARING: i64 = -124;
const DIGITAL_CURRENT: i64 = -126;
const ANALOGUE_CURRENT: i64 = -125;
const MOTION_TASK: i64 = -120;

/// ACCR and DECR, for jog.
const RAMPS: [u16; 2] = [0x3502, 0x3524];

/// NREF and DREF of each homing method.
const METHODS: [(i64, i64, i64); 15] = [
    (-3, 7, 0),
    (-2, 6, 0),
    (1, 2, 0),
    (2, 2, 1),
    (8, 1, 1),
    (12, 1, 0),
    (17, 4, 0),
    (18, 4, 1),
    (24, 3, 1),
    (28, 3, 0),
    (33, 5, 0),
    (34, 5, 1),
    (35, 0, 0),
    (-1, 5, 2),
    (0, 0, 0),
];

/// Jog, and what the analogue input asks for.
#[derive(Debug, Default)]
pub(super) struct Modes {
    jog: Jog,
    /// 1/min.
    analogue: i64,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Jog {
    #[default]
    None,
    Runs,
    /// It slows down, for so many ticks.
    Stops(u8),
}

/// The mode that the master has chosen.
pub(super) fn chosen<D: Dictionary>(dictionary: &D) -> i64 {
    number(dictionary, 0x6060, 0)
}

/// The analogue input gives the velocity: its own mode, or CmdSrc 1 in that of a digital velocity.
fn is_analogue<D: Dictionary>(dictionary: &D) -> bool {
    match chosen(dictionary) {
        ANALOGUE_VELOCITY => true,
        DIGITAL_VELOCITY => number(dictionary, 0x3B43, 1) == 1,
        _ => false,
    }
}

pub(super) fn check<D: Dictionary>(
    dictionary: &D,
    entry: &Entry,
    value: i64,
) -> Result<(), AbortCode> {
    let is_known = match (entry.index, entry.sub) {
        (0x35B4, 1) => [0, 1, 2, 3, 4, 8].contains(&value),
        (0x35CF, 1) => (0..=1).contains(&value),
        (0x35AD, 1) => METHODS.iter().any(|(_, kind, _)| *kind == value),
        (0x352C, 1) => {
            let kind = number(dictionary, 0x35AD, 1);
            let has_one_way = [0, 6, 7].contains(&kind);
            has_one_way || METHODS.contains(&(method(kind, value), kind, value))
        }
        _ => true,
    };
    is_known.then_some(()).ok_or(AbortCode::InvalidValue)
}

/// The method of NREF and DREF.
fn method(kind: i64, direction: i64) -> i64 {
    let of_kind = || METHODS.iter().filter(|(_, own, _)| *own == kind);
    let exact = of_kind().find(|(_, _, own)| *own == direction);
    exact.or_else(|| of_kind().next()).map_or(0, |row| row.0)
}

/// Behind power-on: with a position mode among what is stored the drive comes up in homing mode. Returns whether it was.
pub(super) fn begin<D: Dictionary>(dictionary: &mut D) -> bool {
    let is_position = matches!(chosen(dictionary), 1 | MOTION_TASK);
    if is_position {
        put_number(dictionary, 0x6060, 0, 6);
    }
    show_method(dictionary);
    is_position
}

fn show_method<D: Dictionary>(dictionary: &mut D) {
    let own = number(dictionary, 0x6098, 0);
    if let Some((_, kind, direction)) = METHODS.iter().find(|(method, ..)| *method == own) {
        put_number(dictionary, 0x35AD, 1, *kind);
        put_number(dictionary, 0x352C, 1, *direction);
    }
}

impl Modes {
    pub(super) fn written<D: Dictionary>(
        &mut self,
        dictionary: &mut D,
        entry: &Entry,
        seen: &Seen,
        requests: &mut Requests,
    ) {
        let value = number(dictionary, entry.index, entry.sub);
        match (entry.index, entry.sub) {
            (0x35B4, 1) => put_number(dictionary, 0x6060, 0, DIGITAL_VELOCITY + value),
            (0x6060, _) if value < 0 => {
                put_number(dictionary, 0x35B4, 1, value - DIGITAL_VELOCITY);
            }
            (0x35AD | 0x352C, 1) => {
                let kind = number(dictionary, 0x35AD, 1);
                let direction = number(dictionary, 0x352C, 1);
                put_number(dictionary, 0x6098, 0, method(kind, direction));
            }
            (0x6098, _) => show_method(dictionary),
            (0x3591, 1) => self.jog = Jog::Runs,
            (0x35CF | 0x3637 | 0x3638, 1) => show_range(dictionary),
            (0x3B43, 1) => {}
            (0x6040, _) if seen.is_enabled && self.jog == Jog::Runs => self.stop(),
            _ => return,
        }
        requests.configuration = true;
    }

    /// STOP, or a controlword.
    pub(super) fn stop(&mut self) {
        if self.jog == Jog::Runs {
            self.jog = Jog::Stops(0);
        }
    }

    pub(super) fn is_jogging(&self) -> bool {
        self.jog != Jog::None
    }

    /// A tick has passed. Returns whether the commands are others now.
    pub(super) fn tick<D: Dictionary>(&mut self, dictionary: &D, seen: &Seen) -> bool {
        let before = (self.jog, self.analogue);
        match self.jog {
            Jog::None => {}
            _ if !seen.is_enabled => self.jog = Jog::None,
            Jog::Runs => {}
            Jog::Stops(ticks) if ticks < 3 => self.jog = Jog::Stops(ticks + 1),
            Jog::Stops(_) if !seen.is_moving => self.jog = Jog::None,
            Jog::Stops(_) => {}
        }
        if is_analogue(dictionary) {
            let voltage = number(dictionary, 0x3509, 1);
            let is_dead = voltage.abs() <= number(dictionary, 0x3508, 1);
            let factor = number(dictionary, 0x3626, 1).max(1);
            let scale = number(dictionary, 0x3629, 1).saturating_mul(factor);
            self.analogue = if is_dead {
                0
            } else {
                voltage.saturating_mul(scale) / 10_000
            };
        }
        before != (self.jog, self.analogue)
    }

    /// 6061h shows the maker's modes by their own numbers, and what a command does beside them does not show.
    pub(super) fn show<D: Dictionary>(&self, dictionary: &mut D, seen: &Seen, is_task: bool) {
        let own = chosen(dictionary);
        let stands_for = match own {
            MOTION_TASK => 1,
            DIGITAL_VELOCITY | ANALOGUE_VELOCITY | GEARING => 3,
            DIGITAL_CURRENT | ANALOGUE_CURRENT => 4,
            mode => mode,
        };
        let is_aside = is_task || self.jog != Jog::None;
        if is_aside || i64::from(seen.mode) == stands_for {
            put_number(dictionary, 0x6061, 0, own);
        }
    }

    pub(super) fn command<D: Dictionary>(
        &self,
        dictionary: &D,
        units: &Units,
        seen: &Seen,
        commands: &mut Commands,
    ) {
        if is_analogue(dictionary) {
            commands.target_velocity = per_minute(self.analogue, units);
        }
        if self.jog == Jog::None || !seen.is_enabled {
            return;
        }
        commands.mode = 3;
        let speed = match self.jog {
            Jog::Runs => number(dictionary, 0x3621, 1),
            _ => 0,
        };
        commands.target_velocity = units.velocity(i32::try_from(speed).unwrap_or(0));
        let ramps = RAMPS.map(|index| u32::try_from(number(dictionary, index, 1)).unwrap_or(0));
        let [up, down] = ramps.map(|ramp| (ramp != 0).then(|| units.acceleration(ramp)));
        commands.profile_acceleration = up.unwrap_or(commands.profile_acceleration);
        commands.profile_deceleration = down.unwrap_or(commands.profile_deceleration);
    }
}

/// Turns per minute as a velocity.
pub(super) fn per_minute(turns: i64, units: &Units) -> SignedSpeed {
    let amount = u32::try_from(turns.unsigned_abs()).unwrap_or(u32::MAX);
    units.motor_speed(amount).signed(turns < 0)
}

/// EXTLATCH 1: the zero pulse is what both latches keep positions at.
pub(super) fn latch<D: Dictionary>(dictionary: &D, commands: &mut Commands) {
    const ZERO_PULSE: u16 = 0x0404;
    if number(dictionary, 0x3681, 1) == 1 {
        commands.touch_probe_function |= ZERO_PULSE;
    }
}

/// VLIM, VLIMP and VLIMN in a velocity mode, PVMAX, PVMAXP and PVMAXN under position control.
pub(super) fn limit<D: Dictionary>(
    dictionary: &D,
    units: &Units,
    seen: &Seen,
    commands: &mut Commands,
) {
    let limit = |index, is_user: bool| {
        let number = u32::try_from(number(dictionary, index, 1)).unwrap_or(0);
        (number != 0).then(|| {
            if is_user {
                units.speed(number)
            } else {
                units.motor_speed(number)
            }
        })
    };
    let least = |speed: Speed, limits: [Option<Speed>; 2]| {
        limits.into_iter().flatten().fold(speed, Ord::min)
    };
    match commands.mode {
        1 => {
            let target = i64::from(commands.target_position);
            let is_relative = commands.controlword & cia402::controlword::RELATIVE != 0;
            let from = if is_relative { 0 } else { seen.position.into() };
            let own = if target < from { 0x35D9 } else { 0x35DB };
            let limits = [limit(0x35D8, true), limit(own, true)];
            commands.profile_velocity = least(commands.profile_velocity, limits);
        }
        3 | -128 | -127 => {
            let velocity = commands.target_velocity;
            let is_negative = velocity.bits() < 0;
            let own = if is_negative { 0x3623 } else { 0x3622 };
            let limits = [limit(0x358C, false), limit(own, false)];
            let speed = least(velocity.unsigned_abs(), limits);
            // ESPEED.
            let speed = least(speed, [limit(0x3675, false), None]);
            commands.target_velocity = speed.signed(is_negative);
        }
        _ => {}
    }
}

/// POSCNFG 1 is a modulo axis, from SRND to ERND: what the drive reads as 607Bh is an object of our own. Elsewhere both ends are the same.
fn show_range<D: Dictionary>(dictionary: &mut D) {
    let is_modulo = number(dictionary, 0x35CF, 1) == 1;
    for (sub, end) in [(1, 0x3637), (2, 0x3638)] {
        let position = if is_modulo {
            number(dictionary, end, 1)
        } else {
            0
        };
        // The end is the start again.
        let position = position - i64::from(is_modulo && sub == 2);
        put_number(dictionary, 0x5103, sub, position);
    }
}

/// DECDIS: with STOPMODE 1 the ramp of a drive that is disabled.
pub(super) fn disable<D: Dictionary>(dictionary: &D, units: &Units, commands: &mut Commands) {
    let ramp = u32::try_from(number(dictionary, 0x3523, 1)).unwrap_or(0);
    if ramp != 0 && Command::decode(commands.controlword) == Some(Command::Shutdown) {
        commands.profile_deceleration = units.acceleration(ramp);
    }
}

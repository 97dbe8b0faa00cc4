//! Electronic gearing, mode 84h: the motor follows the external encoder.
//!
//! GEARI counts of the encoder, each EXTMUL times, are GEARO turns of the motor. The manual gives no values of GEARMODE and EXTPOS; those of its
//! series: GEARMODE 0 and 3 are an encoder with two signals, 1 and 4 are pulses with a direction, which one counter of the board takes in; EXTPOS 1 is
//! that counter, 0 no external position, with which nothing is followed.
//!
//! The motor is coupled while operation is enabled, bit 13 of the controlword is 0 and the virtual input 20 is on, which it is where nobody
//! writes it. IN20MODE says how: 42 and 0 by ramp, 43 with what was missed and IN20TRIG units more, 51 while the encoder goes
//! IN20TRIG counts. ACCR and DECR are the ramps; 0 leaves those of 6083h and 6084h.

use canopen::cia301::sdo::AbortCode;
use canopen::od::{Dictionary, Entry};
use cia402::behaviour::{SignedSpeed, number, put_number};
use cia402::commands::Commands;
use cia402::controlword::HALT;
use cia402::gearing::{Follower, Ramps, Ratio, Scheme};
use cia402::units::Units;

use super::Seen;
use super::limits::keep_same;
use super::modes::GEARING;

/// Counts of a turn of the motor.
const TURN: i64 = 65_536;
/// Controlword: the motor is decoupled.
const STOPS: u16 = 1 << 13;
/// Statusword: the motor is synchronised.
const SYNCHRONISED: u16 = 1 << 10;
/// Statusword: bits that mean nothing in this mode.
const NOTHING: u16 = 0x3000;

/// Objects that are the same number.
const PAIRS: [[(u16, u8); 2]; 3] = [
    [(0x2040, 1), (0x353E, 1)],
    [(0x2040, 2), (0x3540, 1)],
    [(0x20B0, 0), (0x3724, 1)],
];

/// The motor and its master.
#[derive(Debug, Default)]
pub(super) struct Gearing {
    follower: Follower,
    velocity: SignedSpeed,
    ramps: Option<Ramps>,
    /// IN20TRIG in increments, for IN20MODE 43.
    offset: i32,
    /// What the motor does, in increments/s.
    speed: i32,
}

pub(super) fn check(entry: &Entry, value: i64) -> Result<(), AbortCode> {
    let is_known = match (entry.index, entry.sub) {
        (0x2040 | 0x353E, 1) => value != 0,
        (0x353F, 1) => [0, 1, 3, 4].contains(&value),
        (0x3539 | 0x3722, 1) => (0..=1).contains(&value),
        (0x3723, 1) => [0, 42, 43, 51].contains(&value),
        _ => true,
    };
    is_known.then_some(()).ok_or(AbortCode::InvalidValue)
}

pub(super) fn written<D: Dictionary>(dictionary: &mut D, entry: &Entry) {
    keep_same(dictionary, entry, &PAIRS);
    if entry.index == 0x609A {
        let ramp = number(dictionary, 0x609A, 0);
        for index in [0x3502, 0x3524] {
            put_number(dictionary, index, 1, ramp);
        }
    }
}

impl Gearing {
    /// A tick has passed, so many microseconds behind the one before. Returns whether the commands are others now.
    pub(super) fn tick<D: Dictionary>(
        &mut self,
        dictionary: &mut D,
        seen: &Seen,
        elapsed: u32,
    ) -> bool {
        let factor = number(dictionary, 0x3538, 1);
        let counter = i64::from(seen.counter).wrapping_mul(factor) as i32;
        put_number(dictionary, 0x35C9, 1, counter.into());
        let is_chosen = number(dictionary, 0x6060, 0) == GEARING;
        if !is_chosen || !seen.is_enabled {
            self.follower.forget();
        } else {
            self.choose(dictionary);
        }
        let ramps = self.ramps.unwrap_or(Ramps {
            couple: 1,
            decouple: 1,
        });
        self.velocity = self.follower.tick(counter, seen.internal, elapsed, &ramps);
        is_chosen
    }

    fn choose<D: Dictionary>(&mut self, dictionary: &D) {
        let (input, output) = (number(dictionary, 0x2040, 1), number(dictionary, 0x2040, 2));
        if let Some(ratio) = Ratio::new(output.saturating_mul(TURN), input) {
            self.follower.set_ratio(ratio);
        }
        let is_wanted = number(dictionary, 0x6040, 0) & i64::from(STOPS | HALT) == 0
            && number(dictionary, 0x3722, 1) != 0
            && number(dictionary, 0x3539, 1) != 0;
        if !is_wanted {
            self.follower.decouple();
        } else if !self.follower.is_coupled() && self.ramps.is_some() {
            let travel = number(dictionary, 0x3724, 1);
            let scheme = match number(dictionary, 0x3723, 1) {
                43 => Scheme::CatchUp(self.offset),
                51 => Scheme::Travel(u32::try_from(travel.unsigned_abs()).unwrap_or(u32::MAX)),
                _ => Scheme::Ramp,
            };
            self.follower.couple(scheme, self.speed);
        }
    }

    /// The statusword: bit 10 is whether the motor is synchronised.
    pub(super) fn show<D: Dictionary>(&self, dictionary: &mut D, seen: &Seen) {
        if number(dictionary, 0x6061, 0) == GEARING {
            let is_there = self.follower.is_synchronised();
            let word = seen.statusword & !(SYNCHRONISED | NOTHING);
            let word = word | if is_there { SYNCHRONISED } else { 0 };
            put_number(dictionary, 0x6041, 0, word.into());
        }
    }

    pub(super) fn command<D: Dictionary>(
        &mut self,
        dictionary: &D,
        units: &Units,
        seen: &Seen,
        commands: &mut Commands,
    ) {
        if number(dictionary, 0x6060, 0) != GEARING {
            self.ramps = None;
            return;
        }
        let ramp = |index, otherwise| match u32::try_from(number(dictionary, index, 1)) {
            Ok(ramp) if ramp != 0 => units.acceleration(ramp),
            _ => otherwise,
        };
        self.ramps = Some(Ramps {
            couple: ramp(0x3502, commands.profile_acceleration),
            decouple: ramp(0x3524, commands.profile_deceleration),
        });
        let offset = units.position(number(dictionary, 0x3724, 1));
        self.offset = i32::try_from(offset).unwrap_or(0);
        self.speed = seen.speed;
        commands.target_velocity = self.velocity;
        if self.follower.is_at_work() {
            // It has made the ramps itself.
            commands.profile_acceleration = u32::MAX;
            commands.profile_deceleration = u32::MAX;
        }
    }
}

//! Commands among the parameters (S, MH, SETREF, CLRFAULT), the command engine 4000h, and bit 11 of the controlword.

use canopen::cia301::nmt::NmtState;
use canopen::cia301::sdo::AbortCode;
use canopen::od::{Dictionary, Entry};
use canopen::{Duration, Instant};
use cia402::behaviour::{Requests, number, put_number};
use cia402::commands::Commands;
use cia402::controlword::{FAULT_RESET, NEW_SET_POINT};

use super::Seen;
use super::tasks::{CONTROL, FLASH, LAST};

/// "prom" as it travels.
const PROM: i64 = 0x6D6F_7270;
/// Bit 11 of the controlword resets errors of category 2: these.
const RESET_CATEGORY_2: u16 = 1 << 11;
const CATEGORY_2: [u16; 5] = [0x8130, 0x8611, 0x8612, 0xFF06, 0xFF11];
/// How long a cold start waits, so that the master gets its answer.
const ANSWER_TIME: Duration = Duration::from_ticks(20_000);

/// Homing that a command has begun.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Homing {
    #[default]
    None,
    /// It waits for its mode.
    Ordered,
    /// It goes on, for so many ticks.
    Begun(u8),
}

/// What was ordered and is not done.
#[derive(Debug, Default)]
pub(super) struct Orders {
    /// The controlword that was written last.
    word: u16,
    /// S: the drive is disabled until the controlword is written anew.
    is_disabled: bool,
    resets: bool,
    homing: Homing,
    /// The method to go back to behind SETREF.
    method: Option<i64>,
    cold_start: Option<Instant>,
    /// The command engine is busy.
    is_busy: bool,
}

impl Orders {
    pub(super) fn check<D: Dictionary>(
        &self,
        dictionary: &D,
        entry: &Entry,
        value: i64,
        seen: &Seen,
    ) -> Result<(), AbortCode> {
        let flash = 1..=i64::from(FLASH);
        let all = 0..=i64::from(LAST);
        match (entry.index, entry.sub) {
            (0x4000, 2..) if seen.is_storing || self.cold_start.is_some() => {
                Err(AbortCode::CommandBusy)
            }
            (0x4000, 2) if value > flash.clone().last().unwrap_or(0) => {
                Err(AbortCode::ValueTooHigh)
            }
            // Nothing is stored while the motor has power.
            (0x4000, 2..=6) if seen.has_power => Err(AbortCode::DeviceState),
            (0x2082, _) => {
                let (from, to) = (value & 0xFFFF, value >> 16 & 0xFFFF);
                if !all.contains(&from) || !all.contains(&to) {
                    Err(AbortCode::InvalidValue)
                } else if flash.contains(&to) && seen.has_power {
                    Err(AbortCode::DeviceState)
                } else {
                    Ok(())
                }
            }
            (0x2083, _) if value != PROM => Err(AbortCode::InvalidValue),
            (0x2083, _) if seen.has_power || seen.state != NmtState::PreOperational => {
                Err(AbortCode::DeviceState)
            }
            (0x35B9, 1) if value & !CONTROL != 0 => Err(AbortCode::InvalidValue),
            (0x35BC | 0x3642 | 0x365B | 0x36D2, 1) if !all.contains(&value) => {
                Err(AbortCode::InvalidValue)
            }
            (0x35B7 | 0x35BA | 0x35BD, 1) if !(0..=0xFFFF).contains(&value) => {
                Err(AbortCode::InvalidValue)
            }
            // MOVE, MH, MJOG and SETREF need a motor that is on.
            (0x3642 | 0x358D | 0x3591 | 0x35F0, 1) if !seen.is_enabled => {
                Err(AbortCode::DeviceState)
            }
            _ => {
                let _ = dictionary;
                Ok(())
            }
        }
    }

    pub(super) fn written<D: Dictionary>(
        &mut self,
        dictionary: &mut D,
        entry: &Entry,
        seen: &Seen,
        requests: &mut Requests,
    ) {
        match (entry.index, entry.sub) {
            (0x35EA, 1) => self.is_disabled = true,
            (0x3518, 1) => self.resets = true,
            (0x358D, 1) => self.homing = Homing::Ordered,
            (0x35F0, 1) => {
                self.method = Some(number(dictionary, 0x6098, 0));
                put_number(dictionary, 0x6098, 0, 35);
                requests.configuration = true;
                self.homing = Homing::Ordered;
            }
            (0x4000, 4) => requests.order = Some((0x1011, 1)),
            (0x4000, 5) => requests.order = Some((0x1010, 1)),
            (0x4000, 6 | 7) => self.start_anew(seen),
            _ => return,
        }
        if entry.index == 0x4000 {
            self.is_busy = true;
            put_number(dictionary, 0x4000, 1, 1);
        }
        requests.commands = true;
    }

    /// Whether a command has begun homing and it goes on.
    pub(super) fn is_homing(&self) -> bool {
        self.homing != Homing::None
    }

    /// A cold start, once the master has its answer.
    pub(super) fn start_anew(&mut self, seen: &Seen) {
        self.cold_start = seen.at.checked_add_duration(ANSWER_TIME);
    }

    /// Homing begins as by MH.
    pub(super) const fn home(&mut self) {
        self.homing = Homing::Ordered;
    }

    /// A controlword; returns its bits that rose.
    pub(super) fn controlword(&mut self, word: u16, seen: &Seen) -> u16 {
        let rises = word & !self.word;
        self.word = word;
        self.is_disabled = false;
        self.homing = Homing::None;
        self.resets |= rises & RESET_CATEGORY_2 != 0 && CATEGORY_2.contains(&seen.error_code);
        rises
    }

    /// A tick has passed. Returns whether the commands are others now.
    pub(super) fn tick<D: Dictionary>(
        &mut self,
        dictionary: &mut D,
        seen: &Seen,
        requests: &mut Requests,
    ) -> bool {
        if self.is_busy {
            self.is_busy = seen.is_storing || self.cold_start.is_some();
            put_number(dictionary, 0x4000, 1, i64::from(self.is_busy));
        }
        if self.cold_start.is_some_and(|at| seen.at >= at) {
            self.cold_start = None;
            requests.reset = true;
        }
        let before = self.homing;
        match self.homing {
            Homing::None => return false,
            Homing::Ordered => {}
            Homing::Begun(ticks) if ticks < 3 => self.homing = Homing::Begun(ticks + 1),
            // Attained, failed or interrupted.
            Homing::Begun(_) if seen.statusword & 0x3400 != 0 || !seen.is_enabled => {
                self.homing = Homing::None;
                if let Some(method) = self.method.take() {
                    put_number(dictionary, 0x6098, 0, method);
                    requests.configuration = true;
                }
            }
            Homing::Begun(_) => {}
        }
        self.homing == Homing::Ordered || self.homing != before
    }

    pub(super) fn command(&mut self, seen: &Seen, commands: &mut Commands) {
        if self.is_disabled {
            // Quick stop, and then power off.
            commands.controlword = commands.controlword & !0x8F | 0x02;
        }
        if core::mem::take(&mut self.resets) {
            commands.rising |= FAULT_RESET;
        }
        if self.homing == Homing::None {
            return;
        }
        commands.mode = 6;
        if seen.mode == 6 {
            if self.homing == Homing::Ordered {
                self.homing = Homing::Begun(0);
                commands.rising |= NEW_SET_POINT;
            }
            commands.controlword |= NEW_SET_POINT;
        }
    }
}

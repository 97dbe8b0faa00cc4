//! Warnings and the faults they become, over-speed, the fieldbus watchdog, words of status, the display, outputs that compare.
//!
//! The manual describes no bit of STAT, DRVSTAT and TRJSTAT. As in its series DRVSTAT are the warnings of 2000h, TRJSTAT is 1002h; bit 5 of STAT
//! tells that the drive has started anew, until CLRHR.
//!
//! Of others it has the names alone. Chosen: CLRWARN 1 keeps a warning until CLRFAULT or bit 7 of the controlword; buErrcode is the code of a fault of the power stage
//! (2000h to 5FFFh), ocErrcode that of any other; FltDiag 1 or 2 is the output that flashes the number of the fault; an error of feedback, EEPROM or converter ends with
//! a cold start.

use canopen::Instant;
use canopen::od::{Dictionary, Entry};
use cia402::State;
use cia402::behaviour::{number, put_number};
use cia402::commands::Commands;
use cia402::statusword::WARNING;

use super::tasks::Faulty;
use super::{Seen, limits, units};

/// 2000h.
const FAULTY_TASK: i64 = 1 << 7;
const NO_REFERENCE: i64 = 1 << 8;
const WATCHDOG: i64 = 1 << 3;

/// F24, F08, n04.
const WARNING_IS_FAULT: u16 = 0xFF06;
const OVER_SPEED: u16 = 0x8480;
const NODE_SILENT: u16 = 0x8130;
/// F32, category 4: nothing clears it but power. F26: homing has run onto a limit switch.
const EXCEPTION: u16 = 0x6100;
const ON_LIMIT: u16 = 0x8612;

/// Errors that only a cold start ends: feedback, EEPROM, converter.
const COLD_START: [u16; 4] = [0x5380, 0x5530, 0x7300, 0x7303];

/// STAT.
const STARTED_ANEW: i64 = 1 << 5;

/// The texts of errors on the display, by the codes that the drive has.
const DISPLAYS: [(u16, u8); 23] = [
    (0x8612, 26),
    (0x4210, 1),
    (0x3210, 2),
    (0x8611, 3),
    (0x7300, 4),
    (0x7303, 4),
    (0x3220, 5),
    (0x4310, 6),
    (0x8480, 8),
    (0x5530, 9),
    (0x7305, 10),
    (0x7111, 11),
    (0x2380, 12),
    (0x4110, 13),
    (0x5400, 14),
    (0x8331, 15),
    (0x3100, 16),
    (0x5380, 17),
    (0x5420, 18),
    (0x2330, 22),
    (0x8140, 23),
    (0xFF06, 24),
    (0x7122, 25),
];

/// What the other parts of the module have found.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    /// Bits of 2000h.
    pub(super) warnings: i64,
    /// Those that the drive has set and that are not to be told.
    pub(super) hidden: i64,
    pub(super) fault: Option<u16>,
    pub(super) is_jogging: bool,
    pub(super) is_hardware_enabled: bool,
    /// Position registers.
    pub(super) registers: u16,
    /// Microseconds since the tick before.
    pub(super) elapsed: u32,
}

/// What the module finds by itself.
#[derive(Debug, Default)]
pub(super) struct Status {
    /// Why the last motion task did not start.
    pub(super) faulty: Option<Faulty>,
    fault: Option<u16>,
    has_started_anew: bool,
    has_exception: bool,
    /// When the master last wrote something.
    heard: Option<Instant>,
    was_written: bool,
    is_silent: bool,
    /// What the drive's own words do not have: of 2000h, of 1002h, and 6063h.
    beside: (i64, i64, i64),
    /// What of the drive's own 2000h is not told.
    hidden: i64,
    is_warned: bool,
    /// CLRWARN 1: warnings that have come and were not cleared.
    held: i64,
    /// The error that stands, while bit 3 of the statusword does.
    error: u16,
    /// FltDiag: how long the fault has been told.
    told: u64,
    /// FltDiag: the level of an output, and its bit.
    diagnostic: Option<(bool, u32)>,
    /// What the loops of the motor have to tell: of 2000h, of 1002h.
    pub(super) more: (i64, i64),
    /// Levels of the outputs that compare, and which those are.
    levels: (u32, u32),
}

impl Status {
    pub(super) fn power_on(&mut self) {
        self.has_started_anew = true;
    }

    pub(super) fn written(&mut self, entry: &Entry) {
        self.was_written = true;
        if (entry.index, entry.sub) == (0x3519, 1) {
            self.has_started_anew = false;
        }
    }

    pub(super) const fn fault(&self) -> Option<u16> {
        self.fault
    }

    /// Brings the words up to date. Returns whether the commands are others now.
    pub(super) fn show<D: Dictionary>(
        &mut self,
        dictionary: &mut D,
        seen: &Seen,
        found: &Found,
    ) -> bool {
        let before = (self.fault, self.levels);
        self.watch(dictionary, seen);
        let own = number(dictionary, 0x2000, 0) & !found.hidden;
        self.hidden = found.hidden;
        let mut warnings = own
            | found.warnings
            | limits::warnings(dictionary, seen)
            | self.more.0
            | match self.faulty {
                Some(Faulty::Task) => FAULTY_TASK,
                Some(Faulty::Reference) => NO_REFERENCE,
                None => 0,
            };
        if self.is_silent {
            warnings |= WATCHDOG;
        }
        self.held = if number(dictionary, 0x351B, 1) == 1 {
            self.held | warnings
        } else {
            0
        };
        warnings |= self.held;
        if warnings >> 16 & 0xFFFF != 0 {
            warnings |= 1 << 15;
        }
        put_number(dictionary, 0x2000, 0, warnings);
        self.beside.0 = warnings & !own;
        self.is_warned = warnings != 0;
        self.warn(dictionary);
        let first = (warnings != 0).then(|| i64::from(warnings.trailing_zeros()) + 1);
        put_number(dictionary, 0x38F7, 1, first.unwrap_or(0));
        let grave = warnings & number(dictionary, 0x363E, 1);
        if grave != 0 {
            let history = number(dictionary, 0x36CE, 1);
            put_number(dictionary, 0x36CE, 1, history | grave);
        }
        // VOSPD is 1/min; a turn has 65536 counts.
        let most = number(dictionary, 0x3627, 1).saturating_mul(65_536) / 60;
        let is_fast = most != 0 && i64::from(seen.speed).abs() > most;
        self.has_exception |= seen.error_code == EXCEPTION;
        let has_failed_to_home = seen.mode == 6 && seen.statusword & 1 << 13 != 0;
        self.fault = if self.has_exception {
            Some(EXCEPTION)
        } else if has_failed_to_home && seen.inputs & 0b11 != 0 {
            Some(ON_LIMIT)
        } else if grave != 0 {
            Some(WARNING_IS_FAULT)
        } else if is_fast {
            Some(OVER_SPEED)
        } else if self.is_silent {
            Some(NODE_SILENT)
        } else {
            found.fault
        };
        self.show_errors(dictionary, seen);
        self.show_words(dictionary, seen, (warnings, first), found);
        self.flash(dictionary, seen, found.elapsed);
        self.compare(dictionary, seen, warnings);
        before != (self.fault, self.levels)
    }

    /// Puts what was found in the last tick beside what the drive shows anew.
    pub(super) fn show_again<D: Dictionary>(&self, dictionary: &mut D) {
        self.warn(dictionary);
        let (warnings, register, internal) = self.beside;
        let word = number(dictionary, 0x2000, 0) & !self.hidden | warnings;
        put_number(dictionary, 0x2000, 0, word);
        let word = number(dictionary, 0x1002, 0) | register;
        put_number(dictionary, 0x1002, 0, word);
        put_number(dictionary, 0x6063, 0, internal);
    }

    /// Any warning is bit 7 of the statusword.
    fn warn<D: Dictionary>(&self, dictionary: &mut D) {
        if self.is_warned {
            let word = number(dictionary, 0x6041, 0) | i64::from(WARNING);
            put_number(dictionary, 0x6041, 0, word);
        }
    }

    /// EXTWD: a master that writes nothing for so many ms while the motor has power.
    fn watch<D: Dictionary>(&mut self, dictionary: &D, seen: &Seen) {
        let patience = u64::try_from(number(dictionary, 0x353A, 1)).unwrap_or(0) * 1_000;
        if core::mem::take(&mut self.was_written) || !seen.has_power || patience == 0 {
            self.heard = Some(seen.at);
        }
        let silent = self.heard.and_then(|at| seen.at.checked_duration_since(at));
        self.is_silent = patience != 0 && silent.is_some_and(|silent| silent.ticks() > patience);
    }

    fn show_words<D: Dictionary>(
        &mut self,
        dictionary: &mut D,
        seen: &Seen,
        (warnings, first): (i64, Option<i64>),
        found: &Found,
    ) {
        // Latches: what 60B9h would show stands in an object of our own.
        let latched = number(dictionary, 0x5101, 0);
        let latch = |from: u32, to: u32| (latched >> from & 1) << to;
        let own = number(dictionary, 0x1002, 0);
        let register = own
            | self.more.1
            | i64::from(found.is_jogging) << 17
            | i64::from(found.is_hardware_enabled) << 29
            | i64::from(found.registers & 0x1F) << 5
            | i64::from(found.registers >> 5 & 1) << 11
            | (number(dictionary, 0x36E4, 1) & 1) << 13
            | i64::from(is_stopping(seen)) << 19
            | i64::from(seen.mode == 6 && seen.statusword & 1 << 12 != 0) << 23
            | i64::from(COLD_START.contains(&self.error)) << 24
            | latch(9, 4)
            | latch(10, 18)
            | latch(1, 20)
            | latch(2, 21);
        put_number(dictionary, 0x1002, 0, register);
        self.beside.1 = register & !own;
        put_number(dictionary, 0x352D, 1, warnings);
        put_number(dictionary, 0x3613, 1, register);
        put_number(dictionary, 0x35FD, 1, i64::from(seen.statusword));
        let stat = i64::from(self.has_started_anew) * STARTED_ANEW;
        put_number(dictionary, 0x35FB, 1, stat);
        // PRBASE: a turn has so many bits in 6063h, and 16 in the drive.
        let shift = number(dictionary, 0x35D1, 1).clamp(0, 31);
        let internal = i64::from(seen.internal) << shift >> 16;
        put_number(dictionary, 0x6063, 0, internal);
        self.beside.2 = internal;
        // Twenty bits of a turn with sixteen.
        put_number(
            dictionary,
            0x35D2,
            1,
            i64::from(seen.internal) << 4 & 0xF_FFFF,
        );
        for (sub, stored, long, short) in [
            (1, 1, 0x357C, 0x367F),
            (2, 2, 0x357D, 0x3680),
            (3, 9, 0x357A, 0x3578),
            (4, 10, 0x357B, 0x3579),
        ] {
            if latched >> stored & 1 != 0 {
                let position = number(dictionary, 0x5102, sub);
                put_number(dictionary, long, 1, position);
                put_number(dictionary, short, 1, position as i16 as i64);
            }
        }
        put_number(dictionary, 0x5104, 0, display(seen, first).into());
    }

    /// buErrcode has the fault of the power stage, ocErrcode that of everything else.
    fn show_errors<D: Dictionary>(&mut self, dictionary: &mut D, seen: &Seen) {
        self.diagnostic = None;
        let is_fault = seen.statusword & 1 << 3 != 0;
        self.error = if is_fault { seen.error_code } else { 0 };
        let is_base = (0x2000..0x6000).contains(&self.error);
        let code = |is_there: bool| if is_there { self.error.into() } else { 0 };
        put_number(dictionary, 0x38F5, 1, code(is_base));
        put_number(dictionary, 0x38F6, 1, code(!is_base));
    }

    /// Whether a reset of what stands starts the drive anew.
    pub(super) fn needs_cold_start(&self) -> bool {
        COLD_START.contains(&self.error)
    }

    /// CLRWARN 1: what has gone is told no longer.
    pub(super) const fn clear_warnings(&mut self) {
        self.held = 0;
    }

    /// FltDiag 1 or 2: that output flashes the number of the fault, each 200 ms on and 200 ms off, and then is off for two seconds.
    fn flash<D: Dictionary>(&mut self, dictionary: &D, seen: &Seen, elapsed: u32) {
        const HALF: u64 = 200_000;
        const PAUSE: u64 = 10;
        let output @ 1..=2 = number(dictionary, 0x3B52, 1) else {
            return;
        };
        let flashes = if self.error == 0 {
            0
        } else {
            u64::from(fault_number(seen))
        };
        self.told = if flashes == 0 {
            0
        } else {
            (self.told + u64::from(elapsed)) % ((2 * flashes + PAUSE) * HALF)
        };
        let half = self.told / HALF;
        let level = half < 2 * flashes && half.is_multiple_of(2);
        self.diagnostic = Some((level, 15 + output as u32));
    }

    /// O1MODE and O2MODE that compare with O1TRIG and O2TRIG.
    fn compare<D: Dictionary>(&mut self, dictionary: &mut D, seen: &Seen, warnings: i64) {
        self.levels = (0, 0);
        for (place, mode, trigger) in [(16, 0x35AF, 0x35B0), (17, 0x35B2, 0x35B3)] {
            let trigger = number(dictionary, trigger, 1);
            let mode = number(dictionary, mode, 1);
            let Some(level) = level(mode, trigger, seen, warnings) else {
                continue;
            };
            self.levels.0 |= u32::from(level) << place;
            self.levels.1 |= 1 << place;
        }
        if let Some((level, place)) = self.diagnostic {
            self.levels.0 = self.levels.0 & !(1 << place) | u32::from(level) << place;
            self.levels.1 |= 1 << place;
        }
    }

    /// Puts the outputs that compare into the commands.
    pub(super) fn outputs<D: Dictionary>(&self, _: &D, commands: &mut Commands) {
        let (levels, those) = self.levels;
        if those != 0 {
            commands.digital_outputs = commands.digital_outputs & !those | levels;
            commands.digital_outputs_mask |= those;
            commands.outputs_written = true;
        }
    }
}

/// What an output that compares shows, as in its series: mode 1 slower and 2 faster (1/min), 6 beyond a position, 16 a warning.
pub(super) fn level(mode: i64, trigger: i64, seen: &Seen, warnings: i64) -> Option<bool> {
    let speed = units::per_minute(seen.speed).abs();
    Some(match mode {
        1 => speed < trigger,
        2 => speed > trigger,
        6 => i64::from(seen.position) > trigger,
        16 => warnings != 0,
        _ => return None,
    })
}

/// An emergency ramp: quick stop, or the reaction to a fault.
fn is_stopping(seen: &Seen) -> bool {
    let state = State::from_statusword(seen.statusword);
    matches!(
        state,
        Some(State::QuickStopActive | State::FaultReactionActive)
    )
}

/// The number behind the F on the display.
fn fault_number(seen: &Seen) -> u8 {
    let fault = DISPLAYS.iter().find(|(code, _)| *code == seen.error_code);
    fault.map_or(32, |(_, number)| *number)
}

/// What the display shows, four characters: F and the number of the fault, n and that of the warning, E or D.
fn display(seen: &Seen, warning: Option<i64>) -> u32 {
    let is_fault = seen.statusword & 1 << 3 != 0;
    let text = |letter: u8, number: u8| {
        u32::from_le_bytes([letter, b'0' + number / 10 % 10, b'0' + number % 10, b' '])
    };
    match (is_fault, warning) {
        (true, _) => text(b'F', fault_number(seen)),
        (false, Some(number)) => text(b'n', u8::try_from(number).unwrap_or(0)),
        (false, None) if seen.has_power => u32::from_le_bytes(*b"E   "),
        (false, None) => u32::from_le_bytes(*b"D   "),
    }
}

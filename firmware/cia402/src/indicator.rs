//! The status LED of the drive: the state of the power stage, and the error code of a fault by flashes.
//!
//! CiA 303-3 has lights for the communication only. This one is for whoever stands before the machine without a master:
//!
//! | the drive | the light |
//! |---|---|
//! | switch on disabled, or without supply | a flash of 50 ms every 2 s: the drive is alive |
//! | ready to switch on, switched on | 500 ms lit, 500 ms dark |
//! | operation enabled, quick stop active | lit |
//! | fault | the first two digits of the error code 603Fh, by flashes of 200 ms |
//!
//! A fault is told digit by digit: as many flashes as the digit, 600 ms dark, the second digit, 2 s dark, and again. A digit 0 is one
//! flash of 800 ms; A to F are 10 to 15 flashes. 8611h is eight flashes and six. The first digit says where to look: 2 current,
//! 3 voltage, 4 temperature, 5 hardware, 6 software, 7 additional modules, 8 monitoring, 15 the manufacturer.

use canopen::cia303::Pattern;

use crate::state_machine::State;

/// What the LED shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DriveSignal {
    /// The state of the drive.
    pub state: State,
    /// 603Fh.
    pub error_code: u16,
}

impl DriveSignal {
    /// From the statusword 6041h and the error code 603Fh.
    pub fn new(statusword: u16, error_code: u16) -> Self {
        Self {
            state: State::from_statusword(statusword).unwrap_or(State::NotReadyToSwitchOn),
            error_code,
        }
    }
}

/// Steps of 50 ms: a flash of a digit, and the pause after it.
const FLASH: u16 = 4;
/// The one flash of a digit 0.
const LONG_FLASH: u16 = 16;
/// Dark between the digits, beside the pause of the last flash.
const BETWEEN: u16 = 8;
/// Dark after both digits, beside the pause of the last flash.
const AFTER: u16 = 36;

/// Steps of the flash that shows that the drive is alive, and of its period.
const ALIVE_FLASH: u16 = 1;
const ALIVE_PERIOD: u16 = 40;

/// Steps of half a period while the drive is ready.
const READY: u16 = 10;

/// The LED, and the step of its pattern.
#[derive(Clone, Debug, Default)]
pub struct DriveLight {
    step: u16,
    said: Option<DriveSignal>,
}

impl DriveLight {
    /// The time of one step, the same as that of the other lights.
    pub const STEP: canopen::Duration = Pattern::STEP;

    /// At the start.
    pub const fn new() -> Self {
        Self {
            step: 0,
            said: None,
        }
    }

    /// Whether the light is lit in this step; the next call comes [`DriveLight::STEP`] later. Something new is said from its
    /// beginning.
    pub fn advance(&mut self, signal: DriveSignal) -> bool {
        let same = self.said.is_some_and(|said| says_the_same(&said, &signal));
        let step = if same { self.step } else { 0 };
        let (is_lit, turn) = match signal.state {
            State::NotReadyToSwitchOn | State::SwitchOnDisabled => {
                (step < ALIVE_FLASH, ALIVE_PERIOD)
            }
            State::ReadyToSwitchOn | State::SwitchedOn => (step < READY, 2 * READY),
            State::OperationEnabled | State::QuickStopActive => (true, 1),
            State::FaultReactionActive | State::Fault => of_code(signal.error_code, step),
        };
        let next = step.saturating_add(1);
        self.step = if next < turn { next } else { 0 };
        self.said = Some(signal);
        is_lit
    }
}

/// Whether two signals light the light in the same way.
fn says_the_same(one: &DriveSignal, other: &DriveSignal) -> bool {
    let kind = |signal: &DriveSignal| match signal.state {
        State::NotReadyToSwitchOn | State::SwitchOnDisabled => (0, 0),
        State::ReadyToSwitchOn | State::SwitchedOn => (1, 0),
        State::OperationEnabled | State::QuickStopActive => (2, 0),
        State::FaultReactionActive | State::Fault => (3, signal.error_code >> 8),
    };
    kind(one) == kind(other)
}

/// Whether the light is lit in a step of an error code, and how many steps the code takes.
fn of_code(error_code: u16, step: u16) -> (bool, u16) {
    let (first, second) = (error_code >> 12, error_code >> 8 & 0xF);
    let second_from = steps(first).saturating_add(BETWEEN);
    let turn = second_from
        .saturating_add(steps(second))
        .saturating_add(AFTER);
    let is_lit = match step.checked_sub(second_from) {
        None => is_flash(first, step),
        Some(step) => is_flash(second, step),
    };
    (is_lit, turn)
}

/// Steps of a digit with the pause after its last flash.
const fn steps(digit: u16) -> u16 {
    match digit {
        0 => LONG_FLASH + FLASH,
        _ => digit.saturating_mul(2 * FLASH),
    }
}

/// Whether a step, counted from the start of the digit, is part of one of its flashes.
const fn is_flash(digit: u16, step: u16) -> bool {
    match digit {
        0 => step < LONG_FLASH,
        _ => step < steps(digit) && step % (2 * FLASH) < FLASH,
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::*;

    /// Lit and dark spans in milliseconds, from the beginning of a signal on.
    fn spans(state: State, error_code: u16, milliseconds: u64) -> Vec<(bool, u64)> {
        let mut light = DriveLight::new();
        let mut spans: Vec<(bool, u64)> = Vec::new();
        for _ in 0..milliseconds / 50 {
            let is_lit = light.advance(DriveSignal { state, error_code });
            match spans.last_mut() {
                Some((last, time)) if *last == is_lit => *time += 50,
                _ => spans.push((is_lit, 50)),
            }
        }
        spans
    }

    #[test]
    fn a_drive_that_lives_glimpses_every_two_seconds() {
        for state in [State::NotReadyToSwitchOn, State::SwitchOnDisabled] {
            let expected = [(true, 50), (false, 1_950)].repeat(3);
            assert_eq!(spans(state, 0, 6_000), expected);
        }
    }

    #[test]
    fn a_drive_that_is_ready_blinks_slowly() {
        for state in [State::ReadyToSwitchOn, State::SwitchedOn] {
            assert_eq!(
                spans(state, 0, 3_000),
                [(true, 500), (false, 500)].repeat(3)
            );
        }
    }

    #[test]
    fn an_enabled_drive_is_lit() {
        for state in [State::OperationEnabled, State::QuickStopActive] {
            assert_eq!(spans(state, 0, 5_000), [(true, 5_000)]);
        }
    }

    /// What a code looks like: (flashes, long) of both digits.
    fn told(error_code: u16) -> Vec<(bool, u64)> {
        let mut spans = Vec::new();
        for (digit, pause) in [(error_code >> 12, 600), (error_code >> 8 & 0xF, 2_000)] {
            let flashes = if digit == 0 {
                [(true, 800), (false, 200)].to_vec()
            } else {
                [(true, 200), (false, 200)].repeat(digit.into())
            };
            spans.extend(flashes);
            spans.last_mut().unwrap().1 = pause;
        }
        spans
    }

    #[test]
    fn a_fault_is_told_by_its_first_two_digits_again_and_again() {
        for state in [State::FaultReactionActive, State::Fault] {
            for error_code in [0x8611, 0x5400, 0x2310, 0xFF05, 0x0000, 0x1000] {
                let once = told(error_code);
                let time: u64 = once.iter().map(|(_, time)| time).sum();
                let seen = spans(state, error_code, 3 * time);
                assert_eq!(seen, once.repeat(3), "{error_code:04X}");
            }
        }
        assert_eq!(
            told(0x8611).iter().filter(|(is_lit, _)| *is_lit).count(),
            14
        );
    }

    #[test]
    fn something_new_is_said_from_its_beginning() {
        let mut light = DriveLight::new();
        let signal = |state| DriveSignal {
            state,
            error_code: 0x2310,
        };
        for _ in 0..7 {
            light.advance(signal(State::SwitchOnDisabled));
        }
        let fault: Vec<bool> = (0..5)
            .map(|_| light.advance(signal(State::Fault)))
            .collect();
        assert_eq!(fault, [true, true, true, true, false]);
        // The reaction is over: it is the same fault, and the code goes on.
        assert!(!light.advance(signal(State::FaultReactionActive)));
    }

    #[test]
    fn the_signal_comes_from_the_objects() {
        let signal = DriveSignal::new(0x0218, 0x8611);
        assert_eq!((signal.state, signal.error_code), (State::Fault, 0x8611));
        assert_eq!(DriveSignal::new(0x1637, 0).state, State::OperationEnabled);
    }
}

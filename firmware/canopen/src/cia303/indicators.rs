//! What the two lights of a device say, step by step.

use super::Pattern;
use crate::cia301::nmt::NmtState;

/// What the lights are to say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Signal {
    /// For the green light.
    pub state: NmtState,
    /// For the red light: the device has a fault.
    pub fault: bool,
}

/// Which lights are lit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lights {
    /// The green light.
    pub run: bool,
    /// The red light.
    pub error: bool,
}

/// Both lights, and where they are in their patterns.
#[derive(Clone, Debug)]
pub struct Indicators {
    step: u8,
}

impl Indicators {
    /// At the start of the patterns.
    pub const fn new() -> Self {
        Self { step: 0 }
    }

    /// The lights of this step; the next call comes [`Pattern::STEP`] later.
    pub const fn advance(&mut self, signal: Signal) -> Lights {
        let lights = Lights {
            run: run_pattern(signal.state).is_lit(self.step),
            error: error_pattern(signal.fault).is_lit(self.step),
        };
        self.step = (self.step + 1) % Pattern::STEPS;
        lights
    }
}

impl Default for Indicators {
    fn default() -> Self {
        Self::new()
    }
}

/// The pattern of the green light.
const fn run_pattern(state: NmtState) -> Pattern {
    match state {
        NmtState::Initialisation => Pattern::Off,
        NmtState::Stopped => Pattern::SingleFlash,
        NmtState::PreOperational => Pattern::Blinking,
        NmtState::Operational => Pattern::On,
    }
}

/// The pattern of the red light.
const fn error_pattern(fault: bool) -> Pattern {
    if fault { Pattern::On } else { Pattern::Off }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::*;

    const STEPS: usize = 4 * Pattern::STEPS as usize;

    fn advance(indicators: &mut Indicators, state: NmtState, fault: bool) -> Lights {
        indicators.advance(Signal { state, fault })
    }

    /// In how many of the steps of four full turns the green light is lit.
    fn lit_steps(state: NmtState) -> usize {
        let mut indicators = Indicators::new();
        (0..STEPS)
            .filter(|_| advance(&mut indicators, state, false).run)
            .count()
    }

    #[test]
    fn the_green_light_shows_the_nmt_state() {
        assert_eq!(lit_steps(NmtState::Initialisation), 0);
        assert_eq!(lit_steps(NmtState::Stopped), STEPS / 6);
        assert_eq!(lit_steps(NmtState::PreOperational), STEPS / 2);
        assert_eq!(lit_steps(NmtState::Operational), STEPS);
    }

    #[test]
    fn the_red_light_shows_the_fault_from_the_next_step_on() {
        for state in [NmtState::Stopped, NmtState::Operational] {
            let mut indicators = Indicators::new();
            for fault in [false, true, true, false, true] {
                assert_eq!(advance(&mut indicators, state, fault).error, fault);
            }
        }
    }

    #[test]
    fn a_new_pattern_joins_in_where_the_others_are() {
        let mut stayed = Indicators::new();
        let mut changed = Indicators::new();
        for _ in 0..7 {
            advance(&mut stayed, NmtState::PreOperational, false);
            advance(&mut changed, NmtState::Stopped, true);
        }
        let turn = |indicators: &mut Indicators| -> Vec<Lights> {
            (0..STEPS)
                .map(|_| advance(indicators, NmtState::PreOperational, false))
                .collect()
        };
        assert_eq!(turn(&mut changed), turn(&mut stayed));
    }
}

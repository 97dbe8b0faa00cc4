//! What the two lights of a device say, step by step.

use super::Pattern;
use crate::cia301::nmt::NmtState;

/// What is wrong with the communication, the gravest last (CiA 303-3, "error LED").
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum CommunicationState {
    /// Nothing.
    #[default]
    NoError,
    /// What was stored does not fit this device, or is damaged.
    InvalidConfiguration,
    /// The CAN controller has counted many errors.
    WarningLimit,
    /// A watched node is silent, or nobody guards this one any more.
    ErrorControl,
    /// SYNC was not received in time.
    Sync,
    /// A PDO was not received in time.
    EventTimer,
    /// The CAN controller has left the bus.
    BusOff,
}

/// What the lights are to say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Signal {
    /// For the green light.
    pub state: NmtState,
    /// For both lights: the bit rate is being found, or the device is being configured by LSS, or waits for that.
    pub configuring: bool,
    /// For the red light.
    pub communication: CommunicationState,
}

/// Which lights are lit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lights {
    /// The green light.
    pub run: bool,
    /// The red light.
    pub error: bool,
}

impl Lights {
    /// The same on one light with two colours: where both would be lit, it is red.
    pub const fn bicolour(self) -> Self {
        Self {
            run: self.run && !self.error,
            error: self.error,
        }
    }
}

/// Both lights, and where they are in their patterns.
#[derive(Clone, Debug)]
pub struct Indicators {
    step: u16,
}

impl Indicators {
    /// At the start of the patterns.
    pub const fn new() -> Self {
        Self { step: 0 }
    }

    /// The lights of this step; the next call comes [`Pattern::STEP`] later.
    pub const fn advance(&mut self, signal: Signal) -> Lights {
        let lights = Lights {
            run: run_pattern(&signal).is_lit(self.step),
            error: match error_pattern(&signal) {
                // Alternately with the green light.
                Pattern::Flickering => Pattern::Flickering.is_lit(self.step + 1),
                pattern => pattern.is_lit(self.step),
            },
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
const fn run_pattern(signal: &Signal) -> Pattern {
    if signal.configuring {
        return Pattern::Flickering;
    }
    match signal.state {
        NmtState::Initialisation => Pattern::Off,
        NmtState::Stopped => Pattern::SingleFlash,
        NmtState::PreOperational => Pattern::Blinking,
        NmtState::Operational => Pattern::On,
    }
}

/// The pattern of the red light. Bus-off goes before everything: nobody can configure such a device.
const fn error_pattern(signal: &Signal) -> Pattern {
    match signal.communication {
        CommunicationState::BusOff => Pattern::On,
        _ if signal.configuring => Pattern::Flickering,
        CommunicationState::NoError => Pattern::Off,
        CommunicationState::InvalidConfiguration => Pattern::Blinking,
        CommunicationState::WarningLimit => Pattern::SingleFlash,
        CommunicationState::ErrorControl => Pattern::DoubleFlash,
        CommunicationState::Sync => Pattern::TripleFlash,
        CommunicationState::EventTimer => Pattern::QuadrupleFlash,
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::*;

    const STEPS: usize = Pattern::STEPS as usize;

    const QUIET: Signal = Signal {
        state: NmtState::PreOperational,
        configuring: false,
        communication: CommunicationState::NoError,
    };

    fn turn(signal: Signal) -> Vec<Lights> {
        let mut indicators = Indicators::new();
        (0..STEPS).map(|_| indicators.advance(signal)).collect()
    }

    fn pattern(pattern: Pattern) -> Vec<bool> {
        (0..Pattern::STEPS)
            .map(|step| pattern.is_lit(step))
            .collect()
    }

    fn run(signal: Signal) -> Vec<bool> {
        turn(signal).iter().map(|lights| lights.run).collect()
    }

    fn error(signal: Signal) -> Vec<bool> {
        turn(signal).iter().map(|lights| lights.error).collect()
    }

    #[test]
    fn the_green_light_shows_the_nmt_state() {
        for (state, expected) in [
            (NmtState::Initialisation, Pattern::Off),
            (NmtState::Stopped, Pattern::SingleFlash),
            (NmtState::PreOperational, Pattern::Blinking),
            (NmtState::Operational, Pattern::On),
        ] {
            assert_eq!(run(Signal { state, ..QUIET }), pattern(expected));
        }
    }

    #[test]
    fn the_red_light_shows_what_is_wrong() {
        for (communication, expected) in [
            (CommunicationState::NoError, Pattern::Off),
            (CommunicationState::InvalidConfiguration, Pattern::Blinking),
            (CommunicationState::WarningLimit, Pattern::SingleFlash),
            (CommunicationState::ErrorControl, Pattern::DoubleFlash),
            (CommunicationState::Sync, Pattern::TripleFlash),
            (CommunicationState::EventTimer, Pattern::QuadrupleFlash),
            (CommunicationState::BusOff, Pattern::On),
        ] {
            let signal = Signal {
                communication,
                ..QUIET
            };
            assert_eq!(error(signal), pattern(expected), "{communication:?}");
        }
    }

    #[test]
    fn both_lights_flicker_in_turn_while_the_device_is_configured() {
        let signal = Signal {
            configuring: true,
            communication: CommunicationState::WarningLimit,
            ..QUIET
        };
        for (step, lights) in turn(signal).into_iter().enumerate() {
            assert_eq!(lights.run, step % 2 == 0);
            assert_eq!(lights.error, !lights.run);
        }
        let off_the_bus = Signal {
            communication: CommunicationState::BusOff,
            ..signal
        };
        assert_eq!(error(off_the_bus), pattern(Pattern::On));
    }

    #[test]
    fn one_light_with_two_colours_is_red_where_both_would_be_lit() {
        let signal = Signal {
            communication: CommunicationState::ErrorControl,
            ..QUIET
        };
        for lights in turn(signal) {
            let one = lights.bicolour();
            assert_eq!(one.error, lights.error);
            assert_eq!(one.run, lights.run && !lights.error);
        }
        let both = Lights {
            run: true,
            error: true,
        };
        let red = Lights {
            run: false,
            error: true,
        };
        assert_eq!(both.bicolour(), red);
    }

    #[test]
    fn a_new_pattern_joins_in_where_the_others_are() {
        let mut stayed = Indicators::new();
        let mut changed = Indicators::new();
        let other = Signal {
            state: NmtState::Stopped,
            configuring: false,
            communication: CommunicationState::BusOff,
        };
        for _ in 0..7 {
            stayed.advance(QUIET);
            changed.advance(other);
        }
        for _ in 0..STEPS {
            assert_eq!(changed.advance(QUIET), stayed.advance(QUIET));
        }
    }
}

//! The patterns of a light.

use crate::time::Duration;

/// What a light does (CiA 303-3, "indicator states and flash rates").
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pattern {
    /// Always dark.
    Off,
    /// Always lit.
    On,
    /// 200 ms lit, 200 ms dark.
    Blinking,
    /// 200 ms lit, 1 s dark.
    SingleFlash,
}

/// One flash of all patterns but flickering, in steps.
const FLASH: u8 = 4;

impl Pattern {
    /// The time of one step: half a period of flickering, the fastest pattern of the standard.
    pub const STEP: Duration = Duration::millis(50);

    /// Steps after which every pattern is at its start again: 1.2 s.
    pub(super) const STEPS: u8 = 24;

    /// Whether the light is lit in this step, counted from the start of the pattern.
    pub(super) const fn is_lit(self, step: u8) -> bool {
        match self {
            Self::Off => false,
            Self::On => true,
            Self::Blinking => step % (2 * FLASH) < FLASH,
            Self::SingleFlash => step % (6 * FLASH) < FLASH,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::*;

    /// Lit (`true`) and dark spans of 2.4 seconds, in milliseconds.
    fn spans(pattern: Pattern) -> Vec<(bool, u64)> {
        let mut spans: Vec<(bool, u64)> = Vec::new();
        for step in 0..2 * Pattern::STEPS {
            let is_lit = pattern.is_lit(step);
            match spans.last_mut() {
                Some((last, time)) if *last == is_lit => *time += Pattern::STEP.to_millis(),
                _ => spans.push((is_lit, Pattern::STEP.to_millis())),
            }
        }
        spans
    }

    #[test]
    fn off_is_dark() {
        assert_eq!(spans(Pattern::Off), [(false, 2_400)]);
    }

    #[test]
    fn on_is_lit() {
        assert_eq!(spans(Pattern::On), [(true, 2_400)]);
    }

    #[test]
    fn blinking_is_200_ms_lit_and_200_ms_dark() {
        let expected = [(true, 200), (false, 200)].repeat(6);
        assert_eq!(spans(Pattern::Blinking), expected);
    }

    #[test]
    fn a_single_flash_is_200_ms_lit_and_a_second_dark() {
        let expected = [(true, 200), (false, 1_000)].repeat(2);
        assert_eq!(spans(Pattern::SingleFlash), expected);
    }

    #[test]
    fn every_pattern_is_at_its_start_after_all_steps() {
        for pattern in [
            Pattern::Off,
            Pattern::On,
            Pattern::Blinking,
            Pattern::SingleFlash,
        ] {
            for step in 0..Pattern::STEPS {
                assert_eq!(
                    pattern.is_lit(step),
                    pattern.is_lit(step + Pattern::STEPS),
                    "{pattern:?}"
                );
            }
        }
    }
}

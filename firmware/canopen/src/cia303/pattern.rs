//! The patterns of a light.

use crate::time::Duration;

/// What a light does (CiA 303-3, "indicator states and flash rates").
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pattern {
    /// Always dark.
    Off,
    /// Always lit.
    On,
    /// 50 ms lit, 50 ms dark: 10 Hz.
    Flickering,
    /// 200 ms lit, 200 ms dark: 2.5 Hz.
    Blinking,
    /// 200 ms lit, 1 s dark.
    SingleFlash,
    /// Two flashes of 200 ms with 200 ms between, 1 s dark.
    DoubleFlash,
    /// Three such flashes, 1 s dark.
    TripleFlash,
    /// Four such flashes, 1 s dark.
    QuadrupleFlash,
}

/// Steps of one flash of all patterns but flickering, and of the pause between two.
const FLASH: u16 = 4;

/// Steps of the dark second after the last flash.
const PAUSE: u16 = 20;

impl Pattern {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Off,
        Self::On,
        Self::Flickering,
        Self::Blinking,
        Self::SingleFlash,
        Self::DoubleFlash,
        Self::TripleFlash,
        Self::QuadrupleFlash,
    ];

    /// The time of one step: half a period of flickering, the fastest pattern of the standard.
    pub const STEP: Duration = Duration::millis(50);

    /// Steps after which every pattern is at its start again: 24 s, a multiple of 0.1, 0.4, 1.2, 1.6, 2.0 and 2.4 s.
    pub(super) const STEPS: u16 = 480;

    /// Whether the light is lit in this step, counted from the start of the pattern.
    pub(super) const fn is_lit(self, step: u16) -> bool {
        match self {
            Self::Off => false,
            Self::On => true,
            Self::Flickering => step.is_multiple_of(2),
            Self::Blinking => step % (2 * FLASH) < FLASH,
            Self::SingleFlash => is_flash(step, 1),
            Self::DoubleFlash => is_flash(step, 2),
            Self::TripleFlash => is_flash(step, 3),
            Self::QuadrupleFlash => is_flash(step, 4),
        }
    }
}

/// Whether a step is one of so many flashes, which are followed by the pause.
const fn is_flash(step: u16, flashes: u16) -> bool {
    let lit_and_dark = (2 * flashes - 1) * FLASH;
    let step = step % (lit_and_dark + PAUSE);
    step < lit_and_dark && (step / FLASH).is_multiple_of(2)
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::*;

    /// Lit (`true`) and dark spans of a full turn, in milliseconds.
    fn spans(pattern: Pattern) -> Vec<(bool, u64)> {
        let mut spans: Vec<(bool, u64)> = Vec::new();
        for step in 0..Pattern::STEPS {
            let is_lit = pattern.is_lit(step);
            match spans.last_mut() {
                Some((last, time)) if *last == is_lit => *time += Pattern::STEP.to_millis(),
                _ => spans.push((is_lit, Pattern::STEP.to_millis())),
            }
        }
        spans
    }

    /// The pattern is these spans, lit first, again and again.
    fn assert_pattern(pattern: Pattern, milliseconds: &[u64]) {
        let lit = [true, false].into_iter().cycle();
        let once: Vec<(bool, u64)> = lit.zip(milliseconds.iter().copied()).collect();
        let turns = 24_000 / milliseconds.iter().sum::<u64>();
        assert_eq!(spans(pattern), once.repeat(turns as usize), "{pattern:?}");
    }

    #[test]
    fn off_is_dark() {
        assert_eq!(spans(Pattern::Off), [(false, 24_000)]);
    }

    #[test]
    fn on_is_lit() {
        assert_eq!(spans(Pattern::On), [(true, 24_000)]);
    }

    #[test]
    fn flickering_is_50_ms_lit_and_50_ms_dark() {
        assert_pattern(Pattern::Flickering, &[50, 50]);
    }

    #[test]
    fn blinking_is_200_ms_lit_and_200_ms_dark() {
        assert_pattern(Pattern::Blinking, &[200, 200]);
    }

    #[test]
    fn a_single_flash_is_200_ms_lit_and_a_second_dark() {
        assert_pattern(Pattern::SingleFlash, &[200, 1_000]);
    }

    #[test]
    fn a_double_flash_is_two_and_a_second_dark() {
        assert_pattern(Pattern::DoubleFlash, &[200, 200, 200, 1_000]);
    }

    #[test]
    fn a_triple_flash_is_three_and_a_second_dark() {
        assert_pattern(Pattern::TripleFlash, &[200, 200, 200, 200, 200, 1_000]);
    }

    #[test]
    fn a_quadruple_flash_is_four_and_a_second_dark() {
        let flashes = [200, 200, 200, 200, 200, 200, 200, 1_000];
        assert_pattern(Pattern::QuadrupleFlash, &flashes);
    }

    #[test]
    fn every_pattern_is_at_its_start_after_all_steps() {
        for pattern in Pattern::ALL {
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

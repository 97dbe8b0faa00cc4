//! The analogue input, object 2064h: what its converter of 12 bits reads, as a voltage, and smoothed.
//!
//! `voltage = offset + raw * full scale / 4095`. The smoothed value follows the raw one as a low-pass of first order does; it is
//! kept finer than the converter, so that it settles on the value and not beside it. The values are there to be shown; no set-point
//! comes from them.

use motion::low;

use crate::configuration::AnalogueConfiguration;

/// The largest number of the converter.
pub const LARGEST: u16 = 4095;

/// The input, as objects show it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Analogue {
    /// 2064h:1, 0 ..= 4095.
    pub raw: u16,
    /// 2064h:2 in millivolts.
    pub voltage: i32,
    /// 2064h:3 in millivolts.
    pub filtered: i32,
}

/// The input at work.
#[derive(Debug)]
pub(crate) struct AnalogueInput {
    raw: u16,
    /// The smoothed value in 2⁻¹⁶ of the converter's unit; `None` before the first reading.
    smooth: Option<i32>,
}

/// Bits of the smoothed value behind the point.
const FRACTION: u32 = 16;

impl AnalogueInput {
    pub(crate) const fn new() -> Self {
        Self {
            raw: 0,
            smooth: None,
        }
    }

    /// A reading, `elapsed` microseconds after the last one.
    pub(crate) fn observe(
        &mut self,
        raw: u16,
        elapsed: u32,
        configuration: &AnalogueConfiguration,
    ) {
        self.raw = raw.min(LARGEST);
        let target = i32::from(self.raw) << FRACTION;
        let time = u32::from(configuration.filter) * 1000;
        self.smooth = Some(match self.smooth {
            Some(smooth) if time > elapsed => {
                let distance = i64::from(target - smooth);
                // The time is more than `elapsed`, so it is not 0.
                let step = (distance * i64::from(elapsed))
                    .checked_div(time.into())
                    .unwrap_or(distance);
                smooth + low::i32(step)
            }
            _ => target,
        });
    }

    /// What objects show.
    pub(crate) fn shown(&self, configuration: &AnalogueConfiguration) -> Analogue {
        let smooth = self.smooth.unwrap_or(0);
        Analogue {
            raw: self.raw,
            voltage: millivolts(i32::from(self.raw) << FRACTION, configuration),
            filtered: millivolts(smooth, configuration),
        }
    }
}

/// A value of the converter with its fraction in millivolts, rounded to the nearest.
fn millivolts(value: i32, configuration: &AnalogueConfiguration) -> i32 {
    const DIVISOR: i64 = (LARGEST as i64) << FRACTION;
    let product = i64::from(value) * i64::from(configuration.full_scale);
    let half = if product < 0 { -DIVISOR } else { DIVISOR } / 2;
    let scaled = (product + half) / DIVISOR;
    let shifted = scaled.saturating_add(configuration.offset.into());
    let end = if shifted < 0 { i32::MIN } else { i32::MAX };
    i32::try_from(shifted).unwrap_or(end)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(raw: u16, configuration: AnalogueConfiguration) -> (u16, i32, i32) {
        let mut input = AnalogueInput::new();
        input.observe(raw, 1_000, &configuration);
        let Analogue {
            raw,
            voltage,
            filtered,
        } = input.shown(&configuration);
        (raw, voltage, filtered)
    }

    #[test]
    fn both_ends_of_the_converter_are_both_ends_of_the_scale() {
        let both_signs = AnalogueConfiguration {
            full_scale: 20_000,
            offset: -10_000,
            filter: 0,
        };
        assert_eq!(shown(0, both_signs), (0, -10_000, -10_000));
        assert_eq!(shown(4095, both_signs), (4095, 10_000, 10_000));
        assert_eq!(shown(9999, both_signs), (4095, 10_000, 10_000));
        assert_eq!(
            shown(2048, AnalogueConfiguration::NONE),
            (2048, 5_001, 5_001)
        );
        let upside_down = AnalogueConfiguration {
            full_scale: -10_000,
            ..AnalogueConfiguration::NONE
        };
        assert_eq!(shown(2048, upside_down), (2048, -5_001, -5_001));
    }

    #[test]
    fn numbers_stop_at_the_ends_of_their_type() {
        let huge = AnalogueConfiguration {
            full_scale: i32::MAX,
            offset: i32::MAX,
            filter: 0,
        };
        assert_eq!(shown(4095, huge).1, i32::MAX);
    }

    #[test]
    fn the_filter_has_its_time_constant_and_settles_on_the_value() {
        let configuration = AnalogueConfiguration {
            filter: 50,
            ..AnalogueConfiguration::NONE
        };
        let mut input = AnalogueInput::new();
        input.observe(0, 1_000, &configuration);
        let mut after = |ticks| {
            for _ in 0..ticks {
                input.observe(4095, 1_000, &configuration);
            }
            input.shown(&configuration).filtered
        };
        // 1 - 1/e of it after a time constant.
        assert!((6_250..6_400).contains(&after(50)));
        assert_eq!(after(1_000), 10_000);
    }
}

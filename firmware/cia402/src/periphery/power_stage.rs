//! The supply and the temperature of the power stage: objects 2073h and 2074h.
//!
//! Each threshold has a hysteresis: what has passed it counts as beyond until it has come back by so much. A board that does not
//! measure a value never passes its thresholds; whether there is a supply is then what its input says.
//!
//! | | statusword | error code |
//! |---|---|---|
//! | supply below 2073h:1 | bit 4 is 0 | fault 3220h while the motor should have power |
//! | supply below 2073h:2, and there | bit 7 | warning 3120h |
//! | supply at 2073h:3 or above | bit 7 | warning 3110h |
//! | supply at 2073h:4 or above | | fault 3210h |
//! | temperature at 2074h:2 or above | bit 7 | warning 4310h |
//! | temperature at 2074h:3 or above | | fault 4210h |
//!
//! A threshold of 0 V is off.

use crate::board::Inputs;
use crate::configuration::Thresholds;

/// What is beyond its threshold, and whether there is a supply.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct PowerStage {
    /// There is enough supply: statusword bit 4.
    pub(crate) has_supply: bool,
    /// There is too much of it.
    pub(crate) over_voltage: bool,
    /// It is too hot.
    pub(crate) over_temperature: bool,
    /// What is warned of.
    pub(crate) warnings: Warnings,
    /// The supply is below its lower threshold.
    pub(crate) under_voltage: bool,
    /// The supply is below that of its warning.
    pub(crate) is_low: bool,
}

/// What the thresholds warn of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Warnings {
    pub(crate) under_voltage: bool,
    pub(crate) over_voltage: bool,
    pub(crate) temperature: bool,
}

impl PowerStage {
    pub(crate) const fn new() -> Self {
        Self {
            has_supply: false,
            over_voltage: false,
            over_temperature: false,
            warnings: Warnings {
                under_voltage: false,
                over_voltage: false,
                temperature: false,
            },
            under_voltage: false,
            is_low: false,
        }
    }

    /// Looks at what the board measures.
    pub(crate) fn observe(&mut self, inputs: &Inputs, thresholds: &Thresholds) {
        self.has_supply = inputs.supply;
        if inputs.supply_voltage.is_some() || inputs.temperature.is_some() {
            self.compare(inputs, thresholds);
        }
    }

    #[inline(never)]
    fn compare(&mut self, inputs: &Inputs, thresholds: &Thresholds) {
        if let Some(voltage) = inputs.supply_voltage {
            let hysteresis = thresholds.voltage_hysteresis;
            let below =
                |was, threshold| voltage < beyond(threshold, if was { hysteresis } else { 0 });
            let above = |was, threshold: u32| {
                let back = if was { hysteresis } else { 0 };
                threshold > 0 && voltage >= threshold.saturating_sub(back)
            };
            self.under_voltage = below(self.under_voltage, thresholds.under_voltage);
            self.is_low = below(self.is_low, thresholds.under_voltage_warning);
            self.over_voltage = above(self.over_voltage, thresholds.over_voltage);
            self.has_supply &= !self.under_voltage;
            self.warnings.over_voltage =
                above(self.warnings.over_voltage, thresholds.over_voltage_warning);
            // Where there is none it is not low.
            self.warnings.under_voltage = self.is_low && self.has_supply;
        }
        if let Some(temperature) = inputs.temperature {
            let hysteresis = i32::from(thresholds.temperature_hysteresis);
            let above = |was, threshold: i16| {
                let back = if was { hysteresis } else { 0 };
                i32::from(temperature) >= i32::from(threshold) - back
            };
            self.over_temperature = above(self.over_temperature, thresholds.over_temperature);
            self.warnings.temperature =
                above(self.warnings.temperature, thresholds.temperature_warning);
        }
    }
}

/// A lower threshold with its hysteresis; one that is off stays so.
const fn beyond(threshold: u32, hysteresis: u32) -> u32 {
    if threshold == 0 {
        0
    } else {
        threshold.saturating_add(hysteresis)
    }
}

#[cfg(test)]
mod tests;

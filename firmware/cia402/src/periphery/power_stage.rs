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

use crate::drive::Inputs;
use crate::objects::Objects;

/// Where supply and temperature become warnings and faults.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Thresholds {
    /// 2073h:1 in millivolts; 0 is off, as for the other voltages.
    pub under_voltage: u32,
    /// 2073h:2 in millivolts.
    pub under_voltage_warning: u32,
    /// 2073h:3 in millivolts.
    pub over_voltage_warning: u32,
    /// 2073h:4 in millivolts.
    pub over_voltage: u32,
    /// 2073h:5 in millivolts.
    pub voltage_hysteresis: u32,
    /// 2074h:2 in tenths of a degree Celsius.
    pub temperature_warning: i16,
    /// 2074h:3 in tenths of a degree Celsius.
    pub over_temperature: i16,
    /// 2074h:4 in tenths of a degree.
    pub temperature_hysteresis: u16,
}

impl Thresholds {
    /// What holds before anything is set up: nothing is too much.
    pub const NONE: Self = Self {
        under_voltage: 0,
        under_voltage_warning: 0,
        over_voltage_warning: 0,
        over_voltage: 0,
        voltage_hysteresis: 0,
        temperature_warning: i16::MAX,
        over_temperature: i16::MAX,
        temperature_hysteresis: 0,
    };

    /// What the objects say.
    pub(crate) fn of<D: Objects>(dictionary: &D) -> Self {
        Self {
            under_voltage: dictionary.under_voltage_fault(),
            under_voltage_warning: dictionary.under_voltage_warning(),
            over_voltage_warning: dictionary.over_voltage_warning(),
            over_voltage: dictionary.over_voltage_fault(),
            voltage_hysteresis: dictionary.voltage_hysteresis(),
            temperature_warning: dictionary.temperature_warning(),
            over_temperature: dictionary.over_temperature_fault(),
            temperature_hysteresis: dictionary.temperature_hysteresis(),
        }
    }
}

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
                i32::from(temperature) >= i32::from(threshold).wrapping_sub(back)
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

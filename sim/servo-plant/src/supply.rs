//! The supply, the capacitor of the bus, and the brake chopper.

use crate::data::SupplyData;

/// The bus.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Supply {
    /// In V.
    pub(crate) voltage: f64,
}

impl Supply {
    pub(crate) fn new(data: &SupplyData) -> Self {
        Self {
            voltage: data.voltage,
        }
    }

    /// The stage draws a power for a time, or gives it back. Gives the energy that the supply has put in, in J.
    ///
    /// The current of the stage is that power at the voltage of the start; supply and chopper are solved exactly.
    pub(crate) fn go_on(
        &mut self,
        data: &SupplyData,
        power: f64,
        chops: bool,
        is_fed: bool,
        time: f64,
    ) -> f64 {
        let before = self.voltage;
        let drawn = power / before.max(1.0);
        let feeds = is_fed && before - drawn * time / data.capacitance <= data.voltage;
        let mut conductance = 0.0;
        let mut current = -drawn;
        if feeds {
            conductance += 1.0 / data.resistance;
            current += data.voltage / data.resistance;
        }
        if chops {
            conductance += 1.0 / data.chopper;
        }
        let rate = conductance / data.capacitance;
        let reach = if rate * time < 1e-9 {
            time
        } else {
            (1.0 - libm::exp(-rate * time)) / rate
        };
        let slope = (current - conductance * before) / data.capacitance;
        self.voltage = (before + slope * reach).max(0.0);
        if feeds {
            let middle = f64::midpoint(before, self.voltage);
            ((data.voltage - middle) / data.resistance * middle * time).max(0.0)
        } else {
            0.0
        }
    }
}

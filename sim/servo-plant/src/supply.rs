//! The supply, the capacitor of the bus, and the brake chopper.

use crate::STEP;
use crate::data::SupplyData;

/// The bus.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Supply {
    /// In V.
    pub(crate) voltage: f64,
    /// What acts on it in a step, without and with the supply, each without and with the chopper.
    ways: [[Way; 2]; 2],
    /// Of the supply without load, in V.
    open: f64,
    /// What the supply drives into a short, in A.
    max: f64,
    /// What an ampere takes from the bus in a step, in V.
    taken: f64,
}

/// What acts on the bus in a step.
#[derive(Clone, Copy, Debug)]
struct Way {
    /// In 1/Ω.
    conductance: f64,
    /// What an ampere of the beginning makes of the voltage in the step, in V.
    reach: f64,
}

impl Way {
    fn new(data: &SupplyData, feeds: bool, chops: bool) -> Self {
        let mut conductance = 0.0;
        if feeds {
            conductance += 1.0 / data.resistance;
        }
        if chops {
            conductance += 1.0 / data.chopper;
        }
        let rate = conductance / data.capacitance;
        let reach = if rate * STEP < 1e-9 {
            STEP
        } else {
            (1.0 - libm::exp(-rate * STEP)) / rate
        };
        Self {
            conductance,
            reach: reach / data.capacitance,
        }
    }
}

impl Supply {
    pub(crate) fn new(data: &SupplyData) -> Self {
        Self {
            voltage: data.voltage,
            ways: [false, true]
                .map(|feeds| [false, true].map(|chops| Way::new(data, feeds, chops))),
            open: data.voltage,
            max: data.voltage / data.resistance,
            taken: STEP / data.capacitance,
        }
    }

    /// The stage draws a power for a step, or gives it back. Gives the energy that the supply has put in, in J.
    ///
    /// The current of the stage is that power at the voltage of the start; supply and chopper are solved exactly.
    pub(crate) fn go_on(&mut self, power: f64, chops: bool, is_fed: bool) -> f64 {
        let before = self.voltage;
        let drawn = power / before.max(1.0);
        let feeds = is_fed && before - drawn * self.taken <= self.open;
        let Way { conductance, reach } = self.ways[usize::from(feeds)][usize::from(chops)];
        let mut current = -drawn;
        if feeds {
            current += self.max;
        }
        self.voltage = (before + (current - conductance * before) * reach).max(0.0);
        if feeds {
            let middle = f64::midpoint(before, self.voltage);
            ((self.max - middle * self.ways[1][0].conductance) * middle * STEP).max(0.0)
        } else {
            0.0
        }
    }
}

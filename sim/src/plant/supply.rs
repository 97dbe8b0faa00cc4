//! The supply of the power stage: it sags by the current that is drawn, and dips and surges when the script says so.

use canopen::Instant;

use super::motor::SupplyData;

/// Over what time the power that is drawn is taken, in seconds: capacitors bear the rest.
const SMOOTHING: f64 = 0.001;

/// The supply at work.
#[derive(Clone, Debug)]
pub(super) struct Supply {
    data: SupplyData,
    /// What is drawn, in W.
    power: f64,
    /// In V.
    voltage: f64,
}

impl Supply {
    pub(super) fn new(data: SupplyData) -> Self {
        let voltage = f64::from(data.voltage) / 1e3;
        Self {
            data,
            power: 0.0,
            voltage,
        }
    }

    /// Some seconds have gone by until `now` in which so much power (in W) was drawn. What a motor gives back while it brakes
    /// goes into a brake resistor.
    pub(super) fn step(&mut self, now: Instant, power: f64, seconds: f64) {
        self.power += (power.max(0.0) - self.power) * (seconds / SMOOTHING).min(1.0);
        let source = f64::from(self.source(now)) / 1e3;
        let resistance = f64::from(self.data.resistance) / 1e3;
        let current = if self.voltage > 1.0 {
            self.power / self.voltage
        } else {
            0.0
        };
        self.voltage = (source - resistance * current).max(0.0);
    }

    /// What the source gives, in mV.
    fn source(&self, now: Instant) -> u32 {
        let holds = |from: u64, span: u64| (from..from.saturating_add(span)).contains(&now.ticks());
        self.data
            .changes
            .iter()
            .rfind(|change| holds(change.at.ticks(), change.duration.ticks()))
            .map_or(self.data.voltage, |change| change.voltage)
    }

    /// In V.
    pub(super) const fn volts(&self) -> f64 {
        self.voltage
    }

    /// In mV.
    pub(super) fn millivolts(&self) -> u32 {
        (self.voltage * 1e3).round() as u32
    }
}

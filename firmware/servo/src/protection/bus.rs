//! The bus of a motor that brakes: a chopper that burns what comes back, and a limit of the braking that leaves the bus below its bound.

use crate::motor::Implausible;
use crate::number::between;

/// Below this share of the voltage at which the chopper ends, the supply is not what it was.
const SUNK: f32 = 0.85;

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bus {
    chop_from: f32,
    chop_until: f32,
    brake_until: f32,
    chops: bool,
}

impl Bus {
    /// The chopper is on from a voltage until the bus is below another; where the chopper begins braking begins to be limited, and at the third
    /// there is none. All in V.
    ///
    /// # Errors
    /// If the three do not rise, `chop_until < chop_from < brake_until`, from 1 V to 2 kV.
    pub fn new(chop_until: f32, chop_from: f32, brake_until: f32) -> Result<Self, Implausible> {
        Implausible::unless(
            chop_until >= 1.0
                && chop_until < chop_from
                && chop_from < brake_until
                && brake_until <= 2e3,
        )?;
        Ok(Self {
            chop_from,
            chop_until,
            brake_until,
            chops: false,
        })
    }

    /// The bus has this voltage. Gives whether the chopper is to be on.
    pub fn run(&mut self, voltage: f32) -> bool {
        // NaN is no reason to burn.
        self.chops = voltage >= self.chop_from || (self.chops && voltage > self.chop_until);
        self.chops
    }

    /// The share of the time for which a chopper is to be on that can be switched in each period: evenly from where it ends to where it begins, 0 to 1. What is no
    /// number is no reason to burn.
    pub fn chopping(&self, voltage: f32) -> f32 {
        let share = (voltage - self.chop_until) / (self.chop_from - self.chop_until);
        between(share, 0.0, 1.0)
    }

    /// Whether the supply is not what it was: a current that does not flow then is no wire's fault.
    pub fn is_sunk(&self, voltage: f32) -> bool {
        voltage < SUNK * self.chop_until
    }

    /// The share of a braking current that is left on this bus, 0 to 1. NaN leaves none.
    pub fn braking(&self, voltage: f32) -> f32 {
        let share = (self.brake_until - voltage) / (self.brake_until - self.chop_from);
        between(share, 0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_chopper_has_a_hysteresis_and_braking_ends_before_the_bound() {
        let mut bus = Bus::new(50.0, 52.0, 56.0).unwrap();
        let seen: std::vec::Vec<bool> = [49.0, 51.0, 52.0, 51.0, 50.5, 50.0, 51.0, f32::NAN]
            .into_iter()
            .map(|voltage| bus.run(voltage))
            .collect();
        assert_eq!(seen, [false, false, true, true, true, false, false, false]);
        let shares = [49.0, 50.0, 51.0, 52.0, 60.0, f32::NAN].map(|voltage| bus.chopping(voltage));
        assert_eq!(shares, [0.0, 0.0, 0.5, 1.0, 1.0, 0.0]);
        let left = [48.0, 52.0, 54.0, 56.0, 70.0, f32::NAN].map(|voltage| bus.braking(voltage));
        assert_eq!(left, [1.0, 1.0, 0.5, 0.0, 0.0, 0.0]);
        assert!(Bus::new(50.0, f32::NAN, 60.0).is_err());
        assert_eq!(
            [42.0, 43.0].map(|voltage| bus.is_sunk(voltage)),
            [true, false]
        );
    }
}

//! Pulse widths of a voltage.
//!
//! Three half bridges: what all have in common does nothing to the motor. Half the sum of the greatest and the least is taken from all, which
//! centres them in the bus and gives 2/√3 of the voltage that sines alone could (space vector modulation). Two full bridges: each gives its share of the bus.
//!
//! The dead time takes `bus · dead time / period` from a half bridge in the direction of its current, twice that from a full bridge. It is given back by
//! the sign of the current, bent to nothing below the ripple, where the current passes zero within a period.

use crate::motor::{Implausible, Wiring};
use crate::number::{greater, is_within, lesser, limit, within};
use crate::transform::Stator;

/// 1/√3: the share of the bus that three phases can have as their amplitude.
const THREE_PHASE_REACH: f32 = 0.577_350_3;

/// The modulation of a power stage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Modulation {
    wiring: Wiring,
    /// What of the period is lost in dead time.
    lost: f32,
    /// 1 / ripple, in 1/A.
    by_ripple: f32,
    /// The greatest share of the period that is switched.
    reach: f32,
}

impl Modulation {
    /// With a dead time as a share of the period; the ripple of the current in A; and the greatest share of the period that may be used, which
    /// leaves time to measure.
    ///
    /// # Errors
    /// With a dead time outside 0 to 0.2, a ripple outside 1 mA to 1 kA, or a reach outside 0.1 to 1.
    pub fn new(
        wiring: Wiring,
        dead_time: f32,
        ripple: f32,
        reach: f32,
    ) -> Result<Self, Implausible> {
        let is_one = is_within(dead_time, 0.0, 0.2)
            && is_within(ripple, 1e-3, 1e3)
            && is_within(reach, 0.1, 1.0);
        let modulation = Self {
            wiring,
            lost: match wiring {
                Wiring::TwoPhase => dead_time + dead_time,
                Wiring::ThreePhase => dead_time,
            },
            by_ripple: 1.0 / ripple,
            reach,
        };
        is_one.then_some(modulation).ok_or(Implausible)
    }

    /// The greatest amplitude of a voltage on this bus, in V.
    #[inline]
    pub fn max_voltage(&self, bus: f32) -> f32 {
        match self.wiring {
            Wiring::TwoPhase => bus * self.reach,
            Wiring::ThreePhase => bus * self.reach * THREE_PHASE_REACH,
        }
    }

    /// The pulse widths of a voltage, with the currents of the phases, on a bus by whose inverse it is multiplied. Of three phases from 0 to 1; of two
    /// from −1 to 1, as a share of the bus.
    #[inline]
    pub fn widths(&self, voltage: Stator, currents: [f32; 3], by_bus: f32) -> [f32; 3] {
        let [a, b, c] = voltage.phases(self.wiring);
        let [ia, ib, ic] = currents;
        let given_back = |current: f32| self.lost * within(current * self.by_ripple, -1.0, 1.0);
        let (a, b) = (a * by_bus + given_back(ia), b * by_bus + given_back(ib));
        match self.wiring {
            Wiring::TwoPhase => [limit(a, self.reach), limit(b, self.reach), 0.0],
            Wiring::ThreePhase => {
                let c = c * by_bus + given_back(ic);
                let (max, least) = (greater(a, greater(b, c)), lesser(a, lesser(b, c)));
                let middle = 0.5 - 0.5 * (max + least);
                let edge = 0.5 - 0.5 * self.reach;
                [a, b, c].map(|phase| within(phase + middle, edge, 1.0 - edge))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Angle;
    use crate::transform::Rotor;
    use proptest::prelude::*;

    proptest! {
        /// All that the circle allows comes out undistorted.
        #[test]
        fn the_widths_make_the_voltage(part in 0.0..1.0_f32, bits: u32, bus in 10.0..60.0_f32) {
            for wiring in [Wiring::TwoPhase, Wiring::ThreePhase] {
                let modulation = Modulation::new(wiring, 0.0, 0.1, 1.0).unwrap();
                let wanted = Rotor { d: modulation.max_voltage(bus) * part, q: 0.0 }
                    .beside_stator(Angle::from_bits(bits).sine_cosine());
                let widths = modulation.widths(wanted, [0.0; 3], 1.0 / bus);
                let made = Stator::of_phases(wiring, widths.map(|width| width * bus));
                prop_assert!((made.alpha - wanted.alpha).abs() < 1e-3);
                prop_assert!((made.beta - wanted.beta).abs() < 1e-3);
            }
        }

        /// Whatever is asked for, a width is one.
        #[test]
        fn no_number_makes_a_width_that_is_none(bits: [u32; 6], reach in 0.1..1.0_f32) {
            let [alpha, beta, a, b, c, by_bus] = bits.map(f32::from_bits);
            for wiring in [Wiring::TwoPhase, Wiring::ThreePhase] {
                let modulation = Modulation::new(wiring, 0.01, 0.1, reach).unwrap();
                for width in modulation.widths(Stator { alpha, beta }, [a, b, c], by_bus) {
                    prop_assert!((-reach..=1.0).contains(&width), "{}", width);
                    prop_assert!(wiring == Wiring::TwoPhase || width >= 0.0);
                }
            }
        }
    }

    #[test]
    fn the_dead_time_is_given_back_in_the_direction_of_the_current() {
        let modulation = Modulation::new(Wiring::ThreePhase, 0.01, 0.1, 1.0).unwrap();
        let none = Stator::default();
        let widths = modulation.widths(none, [1.0, -0.05, -0.95], 1.0 / 48.0);
        let made = [widths[0] - widths[2], widths[1] - widths[2]];
        assert!((made[0] - 0.02).abs() < 1e-6 && (made[1] - 0.005).abs() < 1e-6);
        let modulation = Modulation::new(Wiring::TwoPhase, 0.01, 0.1, 1.0).unwrap();
        let widths = modulation.widths(none, [1.0, -1.0, 0.0], 1.0 / 48.0);
        assert_eq!(
            widths,
            [0.02, -0.02, 0.0],
            "both sides of a full bridge switch"
        );
    }
}

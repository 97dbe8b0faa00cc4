//! Pulse widths of a voltage.
//!
//! Three half bridges: what all have in common does nothing to the motor. Half the sum of the greatest and the least is taken from all, which
//! centres them in the bus and gives 2/√3 of the voltage that sines alone could (space vector modulation). Two full bridges: each gives its share of the bus.
//!
//! The dead time takes `bus · dead time / period` from a half bridge in the direction of its current, twice that from a full bridge. It is given back by
//! the sign of the current, bent to nothing below the ripple, where the current passes zero within a period.
//!
//! A voltage becomes whole numbers before it becomes phases: two are converted, not three, and the core bounds one by one instruction, a float by four.

use crate::motor::{Implausible, Wiring};
use crate::number::{are_within, held};
use crate::transform::{HEIGHT, Stator};

/// 1/√3: the share of the bus that three phases can have as their amplitude.
const THREE_PHASE_REACH: f32 = 0.577_350_3;

/// The pulse widths of a period, in parts of 2¹⁵: a half bridge has the lower switch on all the time at −2¹⁵, both as long at 0; a full
/// bridge gives that share of the bus. The third of two phases is 0.
pub type Widths = [i16; 3];

/// The mean of each phase in a period, as a share of the bus: of three phases against its lower side, from 0 to 1; of two from one side of a full bridge to the
/// other, from −1 to 1.
pub fn shares(wiring: Wiring, widths: Widths) -> [f32; 3] {
    widths.map(|width| {
        let share = f32::from(width) * (1.0 / 32_768.0);
        match wiring {
            Wiring::TwoPhase => share,
            Wiring::ThreePhase => 0.5 + 0.5 * share,
        }
    })
}

/// Within the reach a phase has 27 bits and a sign, a current within the ripple 12; so has what is lost in dead time, once it is multiplied by that.
const REACH_BITS: u32 = 27;
const RIPPLE_BITS: u32 = 12;

/// With the whole period as its reach a part of it is so many parts of 2³² of a width; 32 less, as a width of 2¹⁵ is none.
const WIDTH_OF_REACH: f32 = 1_048_576.0;

/// The modulation of a power stage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Modulation {
    wiring: Wiring,
    /// What is lost in dead time, in parts of the reach, for a part of the ripple.
    lost: i32,
    /// Parts of the ripple in 1 A.
    by_ripple: f32,
    /// The greatest amplitude of a voltage, as a share of the bus.
    max_share: f32,
    /// Parts of the reach in the share 1 of the bus, and that share in a part.
    by_reach: f32,
    of_reach: f32,
    /// What of β is in the phases across A.
    height: f32,
    /// Parts of 2³² of a width in a part of the reach.
    reach: i32,
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
        Implausible::unless(are_within(
            [dead_time, ripple, reach],
            &[(0.0, 0.2), (1e-3, 1e3), (0.1, 1.0)],
        ))?;
        let whole = (1 << REACH_BITS) as f32;
        let (max_share, by_reach, height) = match wiring {
            Wiring::TwoPhase => (reach, whole / reach, 1.0),
            Wiring::ThreePhase => (reach * THREE_PHASE_REACH, 2.0 * whole / reach, HEIGHT),
        };
        let of_ripple = (1 << RIPPLE_BITS) as f32;
        Ok(Self {
            wiring,
            // A full bridge loses it on both sides, and has twice the bus from one end of its reach to the other.
            lost: (dead_time * 2.0 * whole / reach / of_ripple) as i32,
            by_ripple: of_ripple / ripple,
            max_share,
            by_reach,
            of_reach: 1.0 / by_reach,
            height,
            reach: ((reach * WIDTH_OF_REACH) as i32).min(WIDTH_OF_REACH as i32 - 32),
        })
    }

    /// The greatest amplitude of a voltage on this bus, in V.
    #[inline]
    pub fn max_voltage(&self, bus: f32) -> f32 {
        bus * self.max_share
    }

    /// Parts of the reach in 1 V, on a bus by whose inverse it is multiplied.
    #[inline(always)]
    pub(crate) fn of_volt(&self, by_bus: f32) -> f32 {
        self.by_reach * by_bus
    }

    /// Volts of a part of the reach.
    #[inline(always)]
    pub(crate) fn volts(&self, bus: f32) -> f32 {
        self.of_reach * bus
    }

    /// The greatest amplitude of a voltage in parts of the reach, whatever the bus.
    pub(crate) fn circle(&self) -> f32 {
        self.max_share * self.by_reach
    }

    /// The pulse widths of a voltage, with the currents of the phases, on a bus by whose inverse it is multiplied.
    #[inline(always)]
    pub fn widths(&self, voltage: Stator, currents: [f32; 3], by_bus: f32) -> Widths {
        let parts = self.of_volt(by_bus);
        let voltage = Stator {
            alpha: voltage.alpha * parts,
            beta: voltage.beta * parts,
        };
        self.widths_of_parts(voltage, currents)
    }

    /// The same of a voltage in parts of the reach.
    #[inline(always)]
    pub(crate) fn widths_of_parts(&self, voltage: Stator, currents: [f32; 3]) -> Widths {
        // NaN is 0 here. A phase is at most three times the reach, and what is lost four times: the difference of two is within the range.
        let whole = |voltage: f32| held(voltage as i32, REACH_BITS + 1);
        let lost = |current: f32| self.lost * held((current * self.by_ripple) as i32, RIPPLE_BITS);
        let width = |phase: i32| {
            let part = i64::from(held(phase, REACH_BITS)) * i64::from(self.reach);
            ((part + (1 << 31)) >> 32) as i16
        };
        let [ia, ib, ic] = currents;
        let (a, across) = (whole(voltage.alpha), whole(voltage.beta * self.height));
        match self.wiring {
            Wiring::TwoPhase => [width(a + lost(ia)), width(across + lost(ib)), 0],
            Wiring::ThreePhase => {
                let back = a >> 1;
                let (a, b, c) = (
                    a + lost(ia),
                    across - back + lost(ib),
                    lost(ic) - (across + back),
                );
                // The core has no greater of two, but one that is not below 0.
                let more = (a - b).max(0);
                let (most, least) = (b + more, a - more);
                let middle = (most + (c - most).max(0) + least - (least - c).max(0)) >> 1;
                [a, b, c].map(|phase| width(phase - middle))
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
                let shares = shares(wiring, widths);
                let made = Stator::of_phases(wiring, shares.map(|share| share * bus));
                prop_assert!((made.alpha - wanted.alpha).abs() < 1e-4 * bus);
                prop_assert!((made.beta - wanted.beta).abs() < 1e-4 * bus);
            }
        }

        /// Whatever is asked for, a width is one.
        #[test]
        fn no_number_makes_a_width_that_is_none(bits: [u32; 6], reach in 0.1..1.0_f32, dead in 0.0..0.2_f32) {
            let [alpha, beta, a, b, c, by_bus] = bits.map(f32::from_bits);
            for wiring in [Wiring::TwoPhase, Wiring::ThreePhase] {
                let modulation = Modulation::new(wiring, dead, 0.1, reach).unwrap();
                for width in modulation.widths(Stator { alpha, beta }, [a, b, c], by_bus) {
                    prop_assert!(f32::from(width).abs() <= reach * 32_768.0 + 1.0, "{}", width);
                }
            }
        }
    }

    #[test]
    fn the_dead_time_is_given_back_in_the_direction_of_the_current() {
        let modulation = Modulation::new(Wiring::ThreePhase, 0.01, 0.1, 1.0).unwrap();
        let none = Stator::default();
        let widths = modulation.widths(none, [1.0, -0.05, -0.95], 1.0 / 48.0);
        let [a, b, c] = shares(Wiring::ThreePhase, widths);
        assert!((a - c - 0.02).abs() < 5e-5 && (b - c - 0.005).abs() < 5e-5);
        let modulation = Modulation::new(Wiring::TwoPhase, 0.01, 0.1, 1.0).unwrap();
        let widths = modulation.widths(none, [1.0, -1.0, 0.0], 1.0 / 48.0);
        let [a, b, _] = shares(Wiring::TwoPhase, widths);
        // Both sides of a full bridge switch.
        assert!((a - 0.02).abs() < 1e-4 && (b + 0.02).abs() < 1e-4);
    }
}

//! A phase that carries nothing though something is asked of it: its wire or its switch is broken.
//!
//! The squares of what is asked of each phase, as far as the current loop has had the time to reach it, and of what it carries fade over a time.
//! A phase of which much was asked, and that carried less than a fifth of it and of another phase, is lost. At a standstill a phase may have nothing to carry; then nothing is said of it.
//! Where all of them carry little the bus has not the voltage for the speed. Or nothing is connected: a voltage that the model does not know shows that.

use crate::motor::{Implausible, Wiring};
use crate::number::{are_within, fade, greater, lesser};

/// The share of the square of what is asked, and of another phase, below which a phase is lost: 0.2².
const LEAST: f32 = 0.04;

/// The greatest square of a current, in A²; NaN counts as this.
const MAX: f32 = 1e8;

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhaseLoss {
    wiring: Wiring,
    enough: f32,
    fades: f32,
    asked: [f32; 3],
    carried: [f32; 3],
}

impl PhaseLoss {
    /// Where at least so many A are asked for, over a time in s, with a period in s.
    ///
    /// # Errors
    /// With a current outside 1 mA to 10 kA, a period outside 5 µs to 10 ms, or a time that is not 2 periods to 10 s.
    pub fn new(wiring: Wiring, current: f32, time: f32, period: f32) -> Result<Self, Implausible> {
        Implausible::unless(
            are_within(
                [current, period, time],
                &[(1e-3, 1e4), (5e-6, 10e-3), (10e-6, 10.0)],
            ) && time >= 2.0 * period,
        )?;
        Ok(Self {
            wiring,
            enough: current * current,
            fades: fade(1.0 / time, period),
            asked: [0.0; 3],
            carried: [0.0; 3],
        })
    }

    /// A period, in which this was asked of the phases, and this was measured, in A. Gives the phase that is lost.
    pub fn run(&mut self, asked: [f32; 3], carried: [f32; 3]) -> Option<usize> {
        follow(&mut self.asked, &asked, self.fades);
        follow(&mut self.carried, &carried, self.fades);
        let phases = self.asked.iter().zip(&self.carried);
        let mut lost = phases.take(self.wiring.phases());
        let [a, b, c] = self.carried;
        let most = greater(greater(a, b), c);
        // Half the square is the mean of a sine of that size.
        lost.position(|(asked, carried)| {
            *asked > 0.5 * self.enough && *carried < LEAST * asked && *carried <= LEAST * most
        })
    }
}

#[inline(never)]
fn follow(means: &mut [f32; 3], currents: &[f32; 3], fades: f32) {
    for (mean, current) in means.iter_mut().zip(currents) {
        let square = lesser(current * current, MAX);
        *mean = square + fades * (*mean - square);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is found behind half a second in which so many A were asked of each phase and carried by it, in turn.
    fn found(asked: f32, carried: [f32; 3]) -> Option<usize> {
        let mut loss = PhaseLoss::new(Wiring::ThreePhase, 0.1, 0.02, 250e-6).unwrap();
        let turns = (0..2_000_u16).map(|period| {
            let wave = [0.0, 2.1, 4.2].map(|phase: f32| (f32::from(period) * 0.1 - phase).sin());
            let carried = core::array::from_fn(|phase| wave[phase] * carried[phase]);
            loss.run(wave.map(|wave| wave * asked), carried)
        });
        turns.last().flatten()
    }

    #[test]
    fn one_that_carries_nothing_is_lost() {
        assert_eq!(found(4.0, [4.0; 3]), None);
        assert_eq!(found(4.0, [3.0, 0.0, 3.0]), Some(1));
        assert_eq!(
            found(4.0, [0.6, 0.6, 0.02]),
            Some(2),
            "whatever the others have of it"
        );
    }

    #[test]
    fn a_bus_without_the_voltage_for_a_speed_is_no_phase_that_is_lost() {
        assert_eq!(found(4.0, [0.3; 3]), None);
        assert_eq!(found(12.0, [1.0, 0.8, 1.1]), None);
    }
}

//! A phase that carries nothing though something is asked of it: its wire or its switch is broken.
//!
//! The squares of what is asked of each phase, as far as the current loop has had the time to reach it, and of what it carries fade over a time.
//! A phase of which much was asked, and that carried less than a fifth of it, is lost. At a standstill a phase may have nothing to carry; then nothing is said of it.

use crate::motor::{Implausible, Wiring};
use crate::number::{fade, is_within, lesser};

/// The share of the square, below which a phase is lost: 0.2².
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
            is_within(current, 1e-3, 1e4)
                && is_within(period, 5e-6, 10e-3)
                && is_within(time, 2.0 * period, 10.0),
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
        // Half the square is the mean of a sine of that size.
        lost.position(|(asked, carried)| *asked > 0.5 * self.enough && *carried < LEAST * asked)
    }
}

#[inline(never)]
fn follow(means: &mut [f32; 3], currents: &[f32; 3], fades: f32) {
    for (mean, current) in means.iter_mut().zip(currents) {
        let square = lesser(current * current, MAX);
        *mean = square + fades * (*mean - square);
    }
}

//! The interrupt between two control ticks, by TIMER1.

use super::device::{Timer, TIMER1};

/// An interrupt every so many clocks from now on.
pub fn start(clocks: u32) {
    TIMER1.reload.write(clocks - 1);
    TIMER1.ctrl.write(Timer::RUN);
}

/// The interrupt has been served.
pub fn done() {
    TIMER1.intstatus.write(1);
}

//! The deadline of the node task, by the first half of the double timer.

use super::device::{DualTimer, DUALTIMER1};

/// No alarm.
pub fn start() {
    DUALTIMER1.control.write(DualTimer::ONCE);
}

/// An interrupt after so many clocks.
pub fn wake_in(clocks: u32) {
    DUALTIMER1.load.write(clocks.max(1));
    DUALTIMER1
        .control
        .write(DualTimer::ONCE | DualTimer::ENABLE);
}

/// The interrupt has been served.
pub fn woken() {
    DUALTIMER1.intclr.write(1);
}

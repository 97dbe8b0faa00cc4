//! The two lights on the pins of the board; CiA 303-3 says when they are lit.

use canopen::cia303::{Indicators, Signal};

use crate::board::Lights;

/// The pins and what they show.
pub struct Panel<L> {
    lights: L,
    indicators: Indicators,
}

impl<L: Lights> Panel<L> {
    /// The lights at the start of their patterns.
    pub fn new(lights: L) -> Self {
        Self {
            lights,
            indicators: Indicators::new(),
        }
    }

    /// One step of the patterns.
    pub fn advance(&mut self, signal: Signal) {
        let lit = self.indicators.advance(signal);
        self.lights.set_run(lit.run);
        self.lights.set_error(lit.error);
    }
}

//! The lights on the pins of the board: two for the network (CiA 303-3 says when they are lit), one for the drive.

use canopen::cia303::{Indicators, Signal};
use cia402::{DriveLight, DriveSignal};

use crate::board::Lights;

/// What all lights are to say.
pub struct Signals {
    pub network: Signal,
    pub drive: DriveSignal,
}

/// The pins and what they show.
pub struct Panel<L> {
    lights: L,
    indicators: Indicators,
    drive: DriveLight,
}

impl<L: Lights> Panel<L> {
    /// The lights at the start of their patterns.
    pub fn new(lights: L) -> Self {
        Self {
            lights,
            indicators: Indicators::new(),
            drive: DriveLight::new(),
        }
    }

    /// One step of the patterns.
    pub fn advance(&mut self, signals: &Signals) {
        let lit = self.indicators.advance(signals.network);
        let lit = if L::BICOLOUR { lit.bicolour() } else { lit };
        self.lights.set_run(lit.run);
        self.lights.set_error(lit.error);
        self.lights.set_drive(self.drive.advance(signals.drive));
    }
}

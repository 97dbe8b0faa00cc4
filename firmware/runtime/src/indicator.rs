//! The lights of a drive: two for the network (CiA 303-3 says when they are lit), one for the drive.

use canopen::cia303::{Indicators, Signal};
use cia402::{DriveLight, DriveSignal};

/// The pins of the lights.
pub trait Lights {
    /// The green and the red light are one with two colours.
    const BICOLOUR: bool;

    /// The green light.
    fn set_run(&mut self, on: bool);

    /// The red light.
    fn set_error(&mut self, on: bool);

    /// The light of the drive.
    fn set_drive(&mut self, on: bool);
}

/// What all lights are to say.
#[derive(Clone, Copy, Debug)]
pub struct Signals {
    /// What the network does.
    pub network: Signal,
    /// What the drive does.
    pub drive: DriveSignal,
}

/// The lights and what they show.
#[derive(Debug)]
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

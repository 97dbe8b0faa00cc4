//! The lights.

use embedded_hal::digital::OutputPin;
use runtime::Lights;

/// The green, the red and the drive's light, each on a pin of its own. The green and the red one may be one with two colours, as it
/// shows yellow where both are lit; set [`Lights::BICOLOUR`] for such a light.
pub struct PinLights<Run, Error, Drive> {
    run: Run,
    error: Error,
    drive: Drive,
}

impl<Run: OutputPin, Error: OutputPin, Drive: OutputPin> PinLights<Run, Error, Drive> {
    /// As the pins are: all dark.
    pub fn new(run: Run, error: Error, drive: Drive) -> Self {
        Self { run, error, drive }
    }
}

// A pin of the chip cannot fail, and a light that does is no reason to stop.
impl<Run: OutputPin, Error: OutputPin, Drive: OutputPin> Lights for PinLights<Run, Error, Drive> {
    const BICOLOUR: bool = false;

    fn set_run(&mut self, on: bool) {
        let _ = self.run.set_state(on.into());
    }

    fn set_error(&mut self, on: bool) {
        let _ = self.error.set_state(on.into());
    }

    fn set_drive(&mut self, on: bool) {
        let _ = self.drive.set_state(on.into());
    }
}

//! Where the energy has gone, so that a balance tells whether the equations hold.

/// All in J since the start; stores as they are now.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// From the supply into the bus.
    pub supplied: f64,
    /// Through the terminals of the motor.
    pub electrical: f64,
    /// Heat of the windings.
    pub copper: f64,
    /// Heat of friction of motor, load and coupling.
    pub friction: f64,
    /// Done against the torque on the load.
    pub load: f64,
    /// In the inductances.
    pub magnetic: f64,
    /// In the detents.
    pub detent: f64,
    /// In what turns.
    pub kinetic: f64,
    /// In the coupling.
    pub spring: f64,
}

impl Energy {
    /// What went into the motor and is nowhere; 0 but for the error of the integration. Only for a motor that started at rest and
    /// with all its phases.
    pub fn missing(&self) -> f64 {
        let stored = self.magnetic + self.detent + self.kinetic + self.spring;
        self.electrical - self.copper - self.friction - self.load - stored
    }
}

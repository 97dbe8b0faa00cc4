//! A wire that touches what it should not.

/// A phase has a way to the negative side of the bus beside the motor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Short {
    /// Which phase; of a motor of two, the first wire of its winding.
    pub phase: usize,
    /// Of that way, in Ω.
    pub resistance: f64,
    /// Of that way, in H.
    pub inductance: f64,
    current: f64,
}

impl Short {
    /// Without a current.
    pub const fn new(phase: usize, resistance: f64, inductance: f64) -> Self {
        Self {
            phase,
            resistance,
            inductance,
            current: 0.0,
        }
    }

    /// What flows beside the motor, in A.
    pub fn current(&self) -> f64 {
        self.current
    }

    /// The half bridge has this voltage for a time. Gives the energy that it puts in, in J.
    pub(crate) fn go_on(&mut self, voltage: f64, time: f64) -> f64 {
        let rate = self.resistance / self.inductance;
        let end = voltage / self.resistance;
        let gone = 1.0 - libm::exp(-rate * time);
        let away = self.current - end;
        self.current = end + away * (1.0 - gone);
        voltage * (end * time + away * gone / rate)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_goes_in_is_burnt_or_stored() {
        let mut short = Short::new(0, 0.5, 1e-3);
        let (mut input, mut burnt) = (0.0, 0.0);
        for _ in 0..4_000 {
            let before = short.current();
            input += short.go_on(24.0, 5e-7);
            burnt += 0.5 * f64::midpoint(before, short.current()).powi(2) * 5e-7;
        }
        // The time of L/R.
        let current = 48.0 * (1.0 - (-1.0_f64).exp());
        assert!((short.current() - current).abs() < 1e-9);
        let stored = 0.5e-3 * current * current;
        assert!(
            (input - burnt - stored).abs() < 1e-6,
            "{input}, {burnt}, {stored}"
        );
        for _ in 0..20_000 {
            assert_eq!(short.go_on(0.0, 1e-6), 0.0, "nothing comes back");
        }
        assert!(short.current() < 0.01);
    }
}

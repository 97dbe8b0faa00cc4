//! What a motor is, for the loops: the data of its maker or of a measurement, checked once.

use crate::number::are_within;

/// How the phases are wired.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wiring {
    /// Two phases, each on a full bridge: a stepper.
    TwoPhase,
    /// Three in a star, each on a half bridge.
    ThreePhase,
}

impl Wiring {
    /// How many phases.
    pub const fn phases(self) -> usize {
        match self {
            Self::TwoPhase => 2,
            Self::ThreePhase => 3,
        }
    }

    /// The torque in N·m of an ampere in q, with none in d, by pole pairs and flux in V·s: m/2 p ψ.
    pub fn torque_constant(self, pole_pairs: u16, flux: f32) -> f32 {
        self.phases() as f32 * 0.5 * f32::from(pole_pairs) * flux
    }
}

/// A motor with permanent magnets: PMSM, BLDC, or a hybrid stepper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motor {
    /// How the phases are wired.
    pub wiring: Wiring,
    /// Electrical turns in a mechanical one: 50 in a stepper of 200 full steps.
    pub pole_pairs: u16,
    /// Of a phase, in Ω.
    pub resistance: f32,
    /// Along the magnet, in H.
    pub inductance_d: f32,
    /// Across it, in H.
    pub inductance_q: f32,
    /// Peak linkage of the magnet with a phase, in V·s per electrical rad.
    pub flux: f32,
    /// What it carries for ever, as the peak of a phase, in A.
    pub rated_current: f32,
    /// What it may carry for a moment, as the peak of a phase, in A.
    pub peak_current: f32,
    /// Of the rotor and what is fixed to it, in kg·m².
    pub inertia: f32,
    /// Counts of the encoder in a turn.
    pub counts: u32,
}

/// Data of a motor, a loop or a filter that are NaN, or not possible.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Implausible;

impl Implausible {
    /// # Errors
    /// Unless it can be.
    pub(crate) fn unless(can_be: bool) -> Result<(), Self> {
        if can_be { Ok(()) } else { Err(Self) }
    }
}

impl Motor {
    /// Whether it can be a motor.
    ///
    /// # Errors
    /// With 0 or more than 500 pole pairs; a resistance outside 1 mΩ to 1 kΩ; an inductance outside 1 µH to 1 H; a flux outside 1 µV·s to 10 V·s; a
    /// current outside 1 mA to 1 kA or a peak below the rated one; an inertia outside 10⁻⁹ to 1 kg·m²; counts outside 16 to 2²⁴.
    pub fn check(&self) -> Result<(), Implausible> {
        Implausible::unless(
            (1..=500).contains(&self.pole_pairs)
                && are_within(
                    [
                        self.resistance,
                        self.inductance_d,
                        self.inductance_q,
                        self.flux,
                        self.rated_current,
                        self.peak_current,
                        self.inertia,
                    ],
                    &[
                        (1e-3, 1e3),
                        (1e-6, 1.0),
                        (1e-6, 1.0),
                        (1e-6, 10.0),
                        (1e-3, 1e3),
                        (1e-3, 1e3),
                        (1e-9, 1.0),
                    ],
                )
                && self.peak_current >= self.rated_current
                && (16..=1 << 24).contains(&self.counts),
        )
    }

    /// The torque in N·m of an ampere in q, with none in d.
    pub fn torque_constant(&self) -> f32 {
        self.wiring.torque_constant(self.pole_pairs, self.flux)
    }

    /// The torque of the rated current, in N·m.
    pub fn rated_torque(&self) -> f32 {
        self.torque_constant() * self.rated_current
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// That of the plant's axis.
    pub(crate) fn servo_100w() -> Motor {
        Motor {
            wiring: Wiring::ThreePhase,
            pole_pairs: 4,
            resistance: 0.6,
            inductance_d: 0.8e-3,
            inductance_q: 0.8e-3,
            flux: 13.33e-3,
            rated_current: 4.0,
            peak_current: 12.0,
            inertia: 9.6e-6,
            counts: 10_000,
        }
    }

    #[test]
    fn a_motor_is_checked_once() {
        let motor = servo_100w();
        assert_eq!(motor.check(), Ok(()));
        assert!((motor.rated_torque() - 0.32).abs() < 1e-3);
        for wrong in [
            Motor {
                pole_pairs: 0,
                ..motor
            },
            Motor {
                resistance: f32::NAN,
                ..motor
            },
            Motor {
                inductance_q: 0.0,
                ..motor
            },
            Motor {
                flux: f32::INFINITY,
                ..motor
            },
            Motor {
                peak_current: 3.0,
                ..motor
            },
            Motor {
                inertia: -1.0,
                ..motor
            },
            Motor {
                counts: 15,
                ..motor
            },
        ] {
            assert_eq!(wrong.check(), Err(Implausible), "{wrong:?}");
        }
    }
}

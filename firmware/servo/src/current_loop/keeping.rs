//! What keeps a current at the speed of a period: resistance, coupling, the voltage of the magnet, and what is not known.

use crate::transform::Rotor;

/// What keeps a current at the speed of the period.
#[derive(Clone, Copy)]
pub(super) struct Keeping {
    pub(super) resistance: f32,
    /// Of the current across the magnet into d, and of that along it into q, in Ω.
    pub(super) across: f32,
    pub(super) along: f32,
    /// What is not known, and the voltage of the magnet.
    pub(super) d: f32,
    pub(super) q: f32,
}

impl Keeping {
    /// The voltage with which a current would stay as it is.
    #[inline(always)]
    pub(super) fn needed(&self, current: Rotor) -> Rotor {
        Rotor {
            d: self.d + self.resistance * current.d - self.across * current.q,
            q: self.q + self.resistance * current.q + self.along * current.d,
        }
    }

    /// What of a voltage, from which the rotor has turned on by an angle, is beyond that: it changes the current. Each sum goes on from a difference, which saves a copy.
    #[inline(always)]
    pub(super) fn beyond(&self, voltage: Rotor, angle: f32, current: Rotor) -> Rotor {
        let (d, q) = (voltage.d - self.d, voltage.q - self.q);
        Rotor {
            d: d + angle * voltage.q - self.resistance * current.d + self.across * current.q,
            q: q - angle * voltage.d - self.resistance * current.q - self.along * current.d,
        }
    }
}

//! Between the phases, the stator and the rotor (Clarke and Park), with the amplitude of a phase.
//!
//! Beside the stator a vector has the parts α, along phase A, and β, a quarter of an electrical turn ahead. Of two phases they are the phases themselves. In
//! the frame of the rotor it has d and q.

use crate::Angle;
use crate::motor::Wiring;

/// √3 / 2.
pub(crate) const HEIGHT: f32 = 0.866_025_4;

/// A vector beside the stator.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stator {
    /// Along phase A.
    pub alpha: f32,
    /// A quarter of an electrical turn ahead.
    pub beta: f32,
}

/// From the phases to the stator as factors: without a question for the wiring in each period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Clarke {
    /// Of the third phase: 0 if there is none.
    third: f32,
    /// Of what all have in common three times, out of α.
    common: f32,
    /// Of phase B less C, into β.
    across: f32,
}

impl Clarke {
    #[inline]
    pub(crate) const fn new(wiring: Wiring) -> Self {
        match wiring {
            Wiring::TwoPhase => Self {
                third: 0.0,
                common: 0.0,
                across: 1.0,
            },
            Wiring::ThreePhase => Self {
                third: 1.0,
                common: 1.0 / 3.0,
                across: 0.5 / HEIGHT,
            },
        }
    }

    /// The phases that there are: of two, the third becomes 0.
    #[inline(always)]
    pub(crate) fn phases(&self, [a, b, c]: [f32; 3]) -> [f32; 3] {
        [a, b, self.third * c]
    }

    /// Of phases that there are.
    #[inline(always)]
    pub(crate) fn stator(&self, [a, b, c]: [f32; 3]) -> Stator {
        Stator {
            alpha: a - self.common * (a + (b + c)),
            beta: self.across * (b - c),
        }
    }
}

/// A vector in the frame of the rotor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rotor {
    /// Along the magnet.
    pub d: f32,
    /// A quarter of an electrical turn ahead.
    pub q: f32,
}

impl Stator {
    /// Of what is in the phases (Clarke). What three have in common is left out.
    #[inline]
    pub fn of_phases(wiring: Wiring, phases: [f32; 3]) -> Self {
        let clarke = Clarke::new(wiring);
        clarke.stator(clarke.phases(phases))
    }

    /// In each phase. Three add up to 0; of two, the third is 0.
    #[inline]
    pub fn phases(self, wiring: Wiring) -> [f32; 3] {
        match wiring {
            Wiring::TwoPhase => [self.alpha, self.beta, 0.0],
            Wiring::ThreePhase => {
                let across = HEIGHT * self.beta;
                let back = -0.5 * self.alpha;
                [self.alpha, back + across, back - across]
            }
        }
    }

    /// Seen from a rotor with sine and cosine of its electrical angle (Park).
    #[inline]
    pub fn from_rotor(self, (sine, cosine): (f32, f32)) -> Rotor {
        Rotor {
            d: self.alpha * cosine + self.beta * sine,
            q: self.beta * cosine - self.alpha * sine,
        }
    }
}

/// Sine and cosine of an angle, where there is time for a call.
#[inline(never)]
pub(crate) fn direction(angle: Angle) -> (f32, f32) {
    angle.sine_cosine()
}

impl Rotor {
    /// Nothing.
    pub const ZERO: Self = Self { d: 0.0, q: 0.0 };

    /// Beside the stator, with sine and cosine of the electrical angle of the rotor.
    #[inline]
    pub fn beside_stator(self, (sine, cosine): (f32, f32)) -> Stator {
        Stator {
            alpha: self.d * cosine - self.q * sine,
            beta: self.d * sine + self.q * cosine,
        }
    }

    /// Turned by an angle with this sine and cosine.
    #[inline]
    pub fn turned(self, sine_cosine: (f32, f32)) -> Self {
        let Stator { alpha: d, beta: q } = self.beside_stator(sine_cosine);
        Self { d, q }
    }

    /// So many times as long.
    #[inline(always)]
    pub(crate) fn times(self, factor: f32) -> Self {
        Self {
            d: self.d * factor,
            q: self.q * factor,
        }
    }

    /// The sum of both.
    #[inline(always)]
    pub(crate) fn plus(self, other: Self) -> Self {
        Self {
            d: self.d + other.d,
            q: self.q + other.q,
        }
    }

    /// The difference of both.
    #[inline(always)]
    pub(crate) fn minus(self, other: Self) -> Self {
        Self {
            d: self.d - other.d,
            q: self.q - other.q,
        }
    }

    /// What is left of the difference to another a period later is this share.
    pub(crate) fn fading_to(self, other: Self, share: f32) -> Self {
        Self {
            d: other.d + share * (self.d - other.d),
            q: other.q + share * (self.q - other.q),
        }
    }

    /// The square of its size.
    #[inline]
    pub fn square(self) -> f32 {
        self.d * self.d + self.q * self.q
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn there_and_back_is_the_same(d in -50.0..50.0_f32, q in -50.0..50.0_f32, bits: u32) {
            let turned = Angle::from_bits(bits).sine_cosine();
            for wiring in [Wiring::TwoPhase, Wiring::ThreePhase] {
                let phases = Rotor { d, q }.beside_stator(turned).phases(wiring);
                if wiring == Wiring::ThreePhase {
                    prop_assert!(phases.iter().sum::<f32>().abs() < 1e-4);
                }
                let back = Stator::of_phases(wiring, phases.map(|phase| phase + 7.0 * f32::from(u8::from(wiring == Wiring::ThreePhase)))).from_rotor(turned);
                prop_assert!((back.d - d).abs() < 1e-3 && (back.q - q).abs() < 1e-3);
            }
        }
    }

    /// The phases are where the magnet is: a current in d at angle 0 is all in phase A.
    #[test]
    fn the_magnet_lies_along_phase_a() {
        let phases = Rotor { d: 2.0, q: 0.0 }
            .beside_stator(Angle::ZERO.sine_cosine())
            .phases(Wiring::ThreePhase);
        assert_eq!(phases, [2.0, -1.0, -1.0]);
        let turned = Rotor { d: 2.0, q: 0.0 }
            .beside_stator(Angle::from_turns(1.0 / 3.0).sine_cosine())
            .phases(Wiring::ThreePhase);
        assert!((turned[1] - 2.0).abs() < 1e-4, "a third further it is B");
    }
}

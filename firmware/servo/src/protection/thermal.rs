//! I²t: a current above the rated one for as long as the winding, or the stage, bears the heat.
//!
//! What is above the square of the rated current adds up, what is below takes away. The budget is what the peak current may add in its time. When
//! nine tenths of it are spent the limit falls, with the rest of the budget, from the peak to the rated current; there it stays whatever is asked for.

use crate::motor::Implausible;
use crate::number::{are_within, between, lesser, root};

/// The rest of the budget from which on the limit falls.
const REST: f32 = 0.1;

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thermal {
    rated_square: f32,
    peak: f32,
    period: f32,
    /// In A²s.
    budget: f32,
    spent: f32,
}

impl Thermal {
    /// For a rated and a peak current in A, of which the peak lasts so many s from cold, with a period in s.
    ///
    /// # Errors
    /// With a rated current outside 1 mA to 1 kA, a peak below it or above 10 kA, a time outside a period to 1,000 s, or a period outside 20 µs to 1 s.
    pub fn new(rated: f32, peak: f32, time: f32, period: f32) -> Result<Self, Implausible> {
        Implausible::unless(
            are_within(
                [rated, peak, time, period],
                &[(1e-3, 1e3), (1e-3, 1e4), (20e-6, 1e3), (20e-6, 1.0)],
            ) && peak >= rated
                && time >= period,
        )?;
        let rated_square = rated * rated;
        Ok(Self {
            rated_square,
            peak,
            period,
            budget: (peak * peak - rated_square) * time,
            spent: 0.0,
        })
    }

    /// A period with this square of the current has passed, in A². Gives the greatest current for the next, in A.
    #[inline(never)]
    pub fn run(&mut self, square: f32) -> f32 {
        // A square that is NaN is the worst.
        let square = lesser(square, 1e8);
        let spent = self.spent + (square - self.rated_square) * self.period;
        self.spent = between(spent, 0.0, self.budget);
        // Of no budget nothing is left.
        let left = between((self.budget - self.spent) / (REST * self.budget), 0.0, 1.0);
        if left >= 1.0 {
            return self.peak;
        }
        root(self.rated_square + left * (self.peak * self.peak - self.rated_square))
    }

    /// What is spent of the budget, 0 to 1: above 0.9 the limit falls, and a warning is due.
    pub fn share(&self) -> f32 {
        between(self.spent / self.budget, 0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_peak_lasts_for_its_time_and_the_rated_current_for_ever() {
        let mut thermal = Thermal::new(4.0, 12.0, 2.0, 1e-3).unwrap();
        let mut allowed = 12.0_f32;
        let mut full = 0;
        for _ in 0..20_000 {
            allowed = thermal.run(allowed * allowed);
            full += u32::from(allowed > 11.999);
        }
        assert!((1_790..=1_810).contains(&full), "{full} ms at the peak");
        assert!((4.0..4.1).contains(&allowed), "{allowed}");
        assert!(thermal.share() > 0.99);
        for _ in 0..20_000 {
            allowed = thermal.run(0.0);
        }
        assert!((allowed - 12.0).abs() < 1e-3, "it has cooled down");
    }

    proptest! {
        /// What is above the rated square never adds up to more than the budget, if the limit is kept, whatever is asked for.
        #[test]
        fn the_budget_holds(asked in prop::collection::vec((0.0..20.0_f32, 1..800_u32), 1..30)) {
            let mut thermal = Thermal::new(4.0, 12.0, 0.5, 1e-3).unwrap();
            let (mut allowed, mut heat) = (12.0_f32, 0.0_f64);
            for (current, periods) in asked {
                for _ in 0..periods {
                    let square = current.min(allowed).powi(2);
                    allowed = thermal.run(square);
                    heat = (heat + f64::from(square - 16.0) * 1e-3).max(0.0);
                    prop_assert!(heat <= 128.0 * 0.5 * 1.01, "{}", heat);
                }
            }
        }

        #[test]
        fn no_number_is_a_limit(bits: u32, more in prop::collection::vec(any::<u32>(), 1..20)) {
            let mut thermal = Thermal::new(4.0, 12.0, 0.5, 1e-3).unwrap();
            for bits in more.into_iter().chain([bits]) {
                let allowed = thermal.run(f32::from_bits(bits));
                prop_assert!((3.999..=12.001).contains(&allowed));
            }
        }
    }
}

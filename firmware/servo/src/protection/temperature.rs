//! Less current where it is hot: all of it below one temperature, none above another, evenly between.

use crate::motor::Implausible;
use crate::number::between;

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Derating {
    from: f32,
    to: f32,
}

impl Derating {
    /// From a temperature to another, in °C.
    ///
    /// # Errors
    /// If the second is not above the first, or one is outside −100 to 500 °C.
    pub fn new(from: f32, to: f32) -> Result<Self, Implausible> {
        Implausible::unless(from >= -100.0 && from < to && to <= 500.0)?;
        Ok(Self { from, to })
    }

    /// The share of the current at this temperature, 0 to 1. NaN leaves none.
    pub fn share(&self, temperature: f32) -> f32 {
        between((self.to - temperature) / (self.to - self.from), 0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_falls_evenly() {
        let derating = Derating::new(80.0, 100.0).unwrap();
        let shares = [20.0, 80.0, 95.0, 100.0, 400.0, f32::NAN].map(|at| derating.share(at));
        assert_eq!(shares, [1.0, 1.0, 0.25, 0.0, 0.0, 0.0]);
        assert!(Derating::new(100.0, 100.0).is_err());
    }
}

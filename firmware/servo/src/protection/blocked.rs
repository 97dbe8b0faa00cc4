//! A rotor that does not turn though much is asked of it: a current above a bound and a speed below another, for a time without a break.

use crate::motor::Implausible;
use crate::number::is_within;

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blocked {
    current: f32,
    speed: f32,
    periods: u32,
    seen: u32,
}

impl Blocked {
    /// Above a current in A and below a speed in rad/s for so many periods.
    ///
    /// # Errors
    /// With a current or a speed outside 0 to 10 kA and 10⁴ rad/s, or no period.
    pub fn new(current: f32, speed: f32, periods: u32) -> Result<Self, Implausible> {
        let is_one = is_within(current, 0.0, 1e4) && is_within(speed, 0.0, 1e4) && periods > 0;
        let blocked = Self {
            current,
            speed,
            periods,
            seen: 0,
        };
        is_one.then_some(blocked).ok_or(Implausible)
    }

    /// A period with this current and speed has passed. Gives whether the rotor is blocked.
    pub fn run(&mut self, current: f32, speed: f32) -> bool {
        if current.abs() > self.current && speed.abs() < self.speed {
            self.seen = self.seen.saturating_add(1);
        } else {
            self.seen = 0;
        }
        self.seen >= self.periods
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_without_a_break() {
        let mut blocked = Blocked::new(4.0, 1.0, 3).unwrap();
        let seen = [
            (5.0, 0.0),
            (5.0, 0.5),
            (5.0, 2.0),
            (-5.0, 0.0),
            (5.0, -0.5),
            (5.0, 0.0),
            (4.0, 0.0),
        ]
        .map(|(current, speed)| blocked.run(current, speed));
        assert_eq!(seen, [false, false, false, false, false, true, false]);
        assert!(Blocked::new(4.0, 1.0, 0).is_err());
    }
}

//! A rotor that does not turn though it is pushed as hard as may be: a speed below a bound, for a time without a break.

use crate::motor::Implausible;
use crate::number::{are_within, between};

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blocked {
    speed: f32,
    periods: u32,
    seen: u32,
}

impl Blocked {
    /// Below a speed in rad/s for a time in s, of periods in s. A time of 0 is for ever.
    ///
    /// # Errors
    /// With a speed outside 0 to 10⁴ rad/s, a time outside 0 to 1,000 s, or a period outside 5 µs to 10 ms.
    #[inline(never)]
    pub fn new(speed: f32, time: f32, period: f32) -> Result<Self, Implausible> {
        Implausible::unless(are_within(
            [speed, time, period],
            &[(0.0, 1e4), (0.0, 1e3), (5e-6, 10e-3)],
        ))?;
        Ok(Self {
            speed,
            periods: if time > 0.0 {
                between(time / period, 1.0, 1e9) as u32
            } else {
                u32::MAX
            },
            seen: 0,
        })
    }

    /// Nothing has been seen yet.
    pub fn restart(&mut self) {
        self.seen = 0;
    }

    /// A period with this speed has passed, in which the rotor was pushed, or not. Gives whether it is blocked.
    pub fn run(&mut self, is_pushed: bool, speed: f32) -> bool {
        if is_pushed && speed.abs() < self.speed && self.periods < u32::MAX {
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
        let seen = [
            (true, 0.0),
            (true, 0.5),
            (true, 2.0),
            (true, 0.0),
            (true, -0.5),
            (true, 0.0),
            (false, 0.0),
        ];
        let mut blocked = Blocked::new(1.0, 3e-3, 1e-3).unwrap();
        let found = seen.map(|(is_pushed, speed)| blocked.run(is_pushed, speed));
        assert_eq!(found, [false, false, false, false, false, true, false]);
        let mut never = Blocked::new(1.0, 0.0, 1e-3).unwrap();
        assert!(seen.iter().all(|_| !never.run(true, 0.0)));
        assert!(Blocked::new(1.0, -1.0, 1e-3).is_err());
    }
}

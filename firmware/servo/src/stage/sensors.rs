//! Counts of the current sensors.

/// The counts of three phases from those of two sensors, in the phases behind the first: the currents of a star add up to nothing. `middle` is the count without a
/// current. What is beyond the range of a count stays at its end, where the trip is long passed.
#[inline]
pub fn three_of_two(second: u16, third: u16, middle: u16) -> [u16; 3] {
    let all = 3 * u32::from(middle);
    let first = all.saturating_sub(u32::from(second) + u32::from(third));
    [first.min(0xFFFF) as u16, second, third]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::offsets::{Calibration, CurrentSense};

    #[test]
    fn the_first_phase_carries_back_what_the_others_carry_whatever_their_offsets() {
        let mut sense = CurrentSense::new(0.02, 2_048, 100).unwrap();
        while sense.learn(three_of_two(2_080, 2_030, 2_048)) == Calibration::Running {}
        let [a, b, c] = sense.amperes(three_of_two(2_180, 2_080, 2_048));
        assert!((b - 2.0).abs() < 1e-5 && (c - 1.0).abs() < 1e-5 && (a + 3.0).abs() < 1e-5);
    }

    #[test]
    fn what_is_beyond_a_count_stays_at_its_end() {
        assert_eq!(three_of_two(4_095, 4_095, 2_048)[0], 0);
        assert_eq!(three_of_two(0, 0, 2_048)[0], 6_144);
        assert_eq!(three_of_two(0, 0, 0xFFFF)[0], 0xFFFF);
    }
}

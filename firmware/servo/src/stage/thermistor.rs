//! A thermistor of 10 kΩ at 25 °C (B = 3,434 K) against 3.3 kΩ to ground, at a converter of 12 bits.

/// Tenths of a degree Celsius at each 128 counts.
const TENTHS: [i16; 33] = [
    -400, -251, -114, -23, 48, 108, 160, 208, 253, 295, 335, 375, 413, 452, 490, 528, 568, 608,
    649, 692, 738, 786, 838, 894, 957, 1027, 1109, 1205, 1326, 1487, 1728, 2000, 2000,
];

/// The temperature in 0.1 °C, within 0.5 °C from −10 to 110 °C. A wire that is cut is −40 °C, one that touches the supply 200 °C.
pub fn tenths(counts: u16) -> i16 {
    let counts = counts.min(4_095);
    let at = usize::from(counts >> 7);
    let part = i32::from(counts & 127);
    let (Some(&low), Some(&high)) = (TENTHS.get(at), TENTHS.get(at + 1)) else {
        return i16::MAX;
    };
    let rise = (i32::from(high) - i32::from(low)) * part;
    low.saturating_add((rise / 128) as i16)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_law_of_a_thermistor() {
        for counts in 1..4_095_u16 {
            let share = f64::from(counts) / 4_096.0;
            let resistance = 3_300.0 * (1.0 - share) / share;
            let kelvin = 1.0 / (1.0 / 298.15 + (resistance / 10_000.0).ln() / 3_434.0);
            let exact = kelvin - 273.15;
            if (-10.0..110.0).contains(&exact) {
                let away = f64::from(tenths(counts)) / 10.0 - exact;
                assert!(away.abs() < 0.5, "{counts}: {away}");
            }
        }
        assert_eq!([tenths(0), tenths(u16::MAX)], [-400, 2_000]);
    }
}

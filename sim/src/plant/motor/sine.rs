//! A sine of our own: the mathematics library of each system rounds in its own way, and a run is to be the same everywhere.

use std::f64::consts::FRAC_PI_2;

/// The sine of so many quarter turns, to 1e-7. A full step is a quarter of an electrical turn.
pub(super) fn sine(quarters: f64) -> f64 {
    let within = within_turn(quarters);
    // Back to the branch about zero: -1 ..= 1.
    let folded = if within > 1.0 {
        2.0 - within
    } else if within < -1.0 {
        -2.0 - within
    } else {
        within
    };
    let x = folded * FRAC_PI_2;
    let square = x * x;
    // The series of the sine as far as x to the 11th.
    let mut sum = 1.0;
    for divisor in [110.0, 72.0, 42.0, 20.0, 6.0] {
        sum = 1.0 - sum * square / divisor;
    }
    x * sum
}

/// The same angle in -2 ..= 2 quarters.
pub(super) fn within_turn(quarters: f64) -> f64 {
    quarters - 4.0 * (quarters / 4.0).round()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_sine() {
        for n in -5_000..5_000 {
            let quarters = f64::from(n) / 317.0;
            let expected = (quarters * FRAC_PI_2).sin();
            assert!((sine(quarters) - expected).abs() < 1e-7, "{quarters}");
        }
    }
}

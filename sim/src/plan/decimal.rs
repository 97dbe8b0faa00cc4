//! Decimal numbers of steps/s, without a detour through floats.

use motion::{SignedSpeed, Speed};

/// More digits behind the point change nothing.
const MOST_DIGITS: usize = 18;

/// An amount, to the nearest 2⁻³² steps/s; what is not 0 stays more than that.
pub(super) fn speed(text: &str) -> Result<Speed, String> {
    if text.starts_with('-') {
        return Err("give an amount: the direction is that of the distance".to_owned());
    }
    let (whole, part) = text.split_once('.').unwrap_or((text, "0"));
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    if !is_number(whole) || !is_number(part) {
        return Err("not a decimal number".to_owned());
    }
    let too_large = |_| format!("above {} steps/s", u32::MAX);
    let whole: u32 = whole.parse().map_err(too_large)?;
    let digits = &part[..part.len().min(MOST_DIGITS)];
    let scale = 10_u128.pow(digits.len() as u32);
    let numerator: u128 = digits
        .bytes()
        .fold(0, |number, digit| number * 10 + u128::from(digit - b'0'));
    let fraction = (numerator << 32).saturating_add(scale / 2) / scale;
    let bits = (u128::from(whole) << 32) + fraction;
    let is_nothing = whole == 0 && part.bytes().all(|digit| digit == b'0');
    let least = if is_nothing { 0 } else { Speed::LEAST.bits() };
    Ok(Speed::from_bits(
        u64::try_from(bits).unwrap_or(u64::MAX).max(least),
    ))
}

/// The same with a sign, within 2³¹ steps/s.
pub(super) fn velocity(text: &str) -> Result<SignedSpeed, String> {
    let (amount, reverse) = match text.strip_prefix('-') {
        Some(amount) => (amount, true),
        None => (text, false),
    };
    let amount = speed(amount)?;
    if amount > Speed::per_second(1 << 31) {
        return Err(format!("beyond {} steps/s", 1_u32 << 31));
    }
    Ok(amount.signed(reverse))
}

/// As people read it; the number itself is not needed any more.
pub(super) fn shown(speed: Speed) -> f64 {
    speed.bits() as f64 / 2f64.powi(32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimals_are_exact_to_their_last_bit() {
        assert_eq!(speed("100000"), Ok(Speed::per_second(100_000)));
        assert_eq!(speed("0.5").unwrap().bits(), 1 << 31);
        assert_eq!(speed("1.25").unwrap().bits(), 5 << 30);
        // 0.000278 · 2³² is 1,194,000.9
        assert_eq!(speed("0.000278").unwrap().bits(), 1_194_001);
        assert_eq!(
            speed("0.000277777777777777777777").unwrap().bits(),
            1_193_046
        );
        assert_eq!(velocity("-0.5").unwrap().bits(), -(1 << 31));
        assert_eq!(speed("4294967295.99999999999").unwrap(), Speed::MAX);
    }

    #[test]
    fn what_is_not_nothing_does_not_become_it() {
        assert_eq!(speed("0.000"), Ok(Speed::ZERO));
        assert_eq!(speed("0.0000000000000000000000001"), Ok(Speed::LEAST));
    }

    #[test]
    fn what_is_no_decimal_is_refused() {
        for text in ["", ".", "1.", ".5", "1e3", "-1", "1,5", " 1", "4294967296"] {
            assert!(speed(text).is_err(), "{text}");
        }
        assert!(velocity("2147483649").is_err());
        assert!(velocity("--1").is_err());
    }
}

//! Numbers as data sheets write them: decimal, `0x` hexadecimal, leading-zero octal, signed, `$NODEID` added on either side.

use crate::diagnostic::Mistake;

/// A number, and whether its text was a bit pattern (hexadecimal, octal) rather than a quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Number {
    pub(crate) value: i128,
    pub(crate) is_pattern: bool,
}

impl Number {
    /// Reads one number.
    pub(crate) fn parse(text: &str) -> Result<Self, Mistake> {
        Self::spelled(text).map_err(|message| Mistake {
            message,
            help: nearest(text).map(|near| format!("write `{near}`")),
        })
    }

    /// What was meant by a text that is no number, where that is plain.
    pub(crate) fn meant(text: &str) -> Option<Self> {
        Self::spelled(&nearest(text)?).ok()
    }

    fn spelled(text: &str) -> Result<Self, String> {
        let (is_negative, unsigned) = match text.strip_prefix('-') {
            Some(unsigned) => (true, unsigned),
            None => (false, text.strip_prefix('+').unwrap_or(text)),
        };
        let (digits, radix) = match unsigned
            .strip_prefix("0x")
            .or_else(|| unsigned.strip_prefix("0X"))
        {
            Some(digits) => (digits, 16),
            None if unsigned.len() > 1 && unsigned.starts_with('0') => (unsigned, 8),
            None => (unsigned, 10),
        };
        let spelled_right = !digits.is_empty() && digits.chars().all(|digit| digit.is_digit(radix));
        if !spelled_right {
            return Err(format!(
                "`{text}` is not a number (decimal, 0x hexadecimal or leading-zero octal)"
            ));
        }
        let magnitude = u64::from_str_radix(digits, radix)
            .map_err(|_| format!("`{text}` is beyond 64 bits"))?;
        let magnitude = i128::from(magnitude);
        Ok(Self {
            value: if is_negative { -magnitude } else { magnitude },
            is_pattern: radix != 10,
        })
    }

    /// Reads a number that lies between `low` and `high`.
    pub(crate) fn parse_within(text: &str, low: i128, high: i128) -> Result<i128, Mistake> {
        let value = Self::parse(text)?.value;
        if (low..=high).contains(&value) {
            Ok(value)
        } else {
            Err(format!("{text} is not between {low} and {high}").into())
        }
    }
}

/// What somebody may have meant who spelled a number in one of the ways that other languages have; `None` where nobody can tell.
fn nearest(text: &str) -> Option<String> {
    let bare = text.trim_matches(['"', '\'']).trim();
    // A comment that has no blank in front of it.
    let bare = bare.split(';').next().unwrap_or(bare).trim_end();
    let lower = bare.to_ascii_lowercase();
    let begins_with_digit = bare.starts_with(|letter: char| letter.is_ascii_digit());
    // `1e3` may be 1000, or 1E3h: nobody can tell.
    let is_power_of_ten = (lower.split_once('e')).is_some_and(|(left, right)| {
        Number::spelled(left).is_ok() && Number::spelled(right).is_ok()
    });
    let hexadecimal = lower.strip_suffix('h').unwrap_or(bare);
    let meant = [
        Some(bare.to_owned()),
        // A leading zero makes a number octal, and there is no octal 8.
        Some(bare.trim_start_matches('0').to_owned()),
        // `10u` of C, `1.0`.
        Some(bare.trim_end_matches(['u', 'U', 'l', 'L']).to_owned()),
        bare.strip_suffix(".0").map(str::to_owned),
        (begins_with_digit && !is_power_of_ten).then(|| format!("0x{hexadecimal}")),
        matches!(&*lower, "true" | "yes").then(|| "1".into()),
        matches!(&*lower, "false" | "no").then(|| "0".into()),
    ];
    let mut meant = meant.into_iter().flatten();
    meant.find(|near| near != text && Number::spelled(near).is_ok())
}

/// A default value: a number, with the node-ID added or not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct DefaultNumber {
    pub(crate) number: Number,
    pub(crate) adds_node_id: bool,
}

impl DefaultNumber {
    /// Reads `n`, `$NODEID`, `$NODEID+n` or `n+$NODEID`.
    pub(crate) fn parse(text: &str) -> Result<Self, Mistake> {
        if let Some(default) = Self::with_node_id(text) {
            return Ok(default);
        }
        let adds_node_id = false;
        let upper = text.to_ascii_uppercase();
        let Some(at) = upper.find("NODEID") else {
            let number = Number::parse(text)?;
            return Ok(Self {
                number,
                adds_node_id,
            });
        };
        let near = with_dollar(text, at);
        let is_meant = Self::with_node_id(&near).is_some();
        Err(Mistake {
            message: format!("`{text}` is not a number, $NODEID, $NODEID+number or number+$NODEID"),
            help: is_meant.then(|| format!("write `{near}`")),
        })
    }

    /// What was meant by a text that is none of these, where that is plain.
    pub(crate) fn meant(text: &str) -> Option<Self> {
        let at = text.to_ascii_uppercase().find("NODEID");
        match at {
            Some(at) => Self::with_node_id(&with_dollar(text, at)),
            None => Number::meant(text).map(|number| Self {
                number,
                adds_node_id: false,
            }),
        }
    }

    /// Reads what adds the node-ID; `None` for everything else.
    fn with_node_id(text: &str) -> Option<Self> {
        let is_node_id = |part: &str| part.trim().eq_ignore_ascii_case("$NODEID");
        let number = match text.split_once('+') {
            None if is_node_id(text) => "0",
            Some((left, right)) if is_node_id(left) && !right.trim().starts_with('+') => right,
            // A sign of the number comes first.
            _ => {
                text.rsplit_once('+')
                    .filter(|(_, right)| is_node_id(right))?
                    .0
            }
        };
        Some(Self {
            number: Number::spelled(number.trim()).ok()?,
            adds_node_id: true,
        })
    }
}

/// A text with the `$` in front of its NODEID, which is easily forgotten.
fn with_dollar(text: &str, at: usize) -> String {
    let mut near = text.to_owned();
    near.insert(at, '$');
    near
}

#[cfg(test)]
mod tests;

//! Numbers as data sheets write them: decimal, `0x` hexadecimal, leading-zero octal, signed, `$NODEID` added on either side.

/// A number, and whether its text was a bit pattern (hexadecimal, octal) rather than a quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Number {
    pub(crate) value: i128,
    pub(crate) is_pattern: bool,
}

impl Number {
    /// Reads one number.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let unsigned = text.strip_prefix('-').unwrap_or(text);
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
        let value = if unsigned.len() < text.len() {
            -i128::from(magnitude)
        } else {
            i128::from(magnitude)
        };
        Ok(Self {
            value,
            is_pattern: radix != 10,
        })
    }

    /// Reads a number that lies between `low` and `high`.
    pub(crate) fn parse_within(text: &str, low: i128, high: i128) -> Result<i128, String> {
        let value = Self::parse(text)?.value;
        if (low..=high).contains(&value) {
            Ok(value)
        } else {
            Err(format!("{text} is not between {low} and {high}"))
        }
    }
}

/// A default value: a number, with the node-ID added or not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct DefaultNumber {
    pub(crate) number: Number,
    pub(crate) adds_node_id: bool,
}

impl DefaultNumber {
    /// Reads `n`, `$NODEID`, `$NODEID+n` or `n+$NODEID`.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let is_node_id = |part: &str| part.trim().eq_ignore_ascii_case("$NODEID");
        if is_node_id(text) {
            let number = Number {
                value: 0,
                is_pattern: false,
            };
            return Ok(Self {
                number,
                adds_node_id: true,
            });
        }
        let Some((left, right)) = text.split_once('+') else {
            return Ok(Self {
                number: Number::parse(text)?,
                adds_node_id: false,
            });
        };
        let number = match (is_node_id(left), is_node_id(right)) {
            (true, false) => right,
            (false, true) => left,
            _ => {
                return Err(format!(
                    "`{text}` is not a number, $NODEID, $NODEID+number or number+$NODEID"
                ));
            }
        };
        Ok(Self {
            number: Number::parse(number.trim())?,
            adds_node_id: true,
        })
    }
}

#[cfg(test)]
mod tests;

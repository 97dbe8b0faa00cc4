//! Controlword and statusword (CiA 402-2) and the state of a node in words.

/// Profile position (6060h), whose words are meant where the mode is not known.
const PROFILE_POSITION: i8 = 1;

/// What a statusword says: the state, then the bits that are set, in profile position mode.
pub fn statusword(word: u16) -> String {
    statusword_in(word, PROFILE_POSITION)
}

/// The same in another mode of operation: bits 12 and 13 are the mode's.
pub fn statusword_in(word: u16, mode: i8) -> String {
    let (bit_12, bit_13) = match mode {
        1 => ("set-point acknowledged", "following error"),
        3 => ("speed is 0", "maximum slippage"),
        6 => ("homing attained", "homing error"),
        7 => ("interpolation active", ""),
        8 | 9 => ("follows the command value", "following error"),
        10 => ("follows the command value", ""),
        _ => ("", ""),
    };
    let state = match word & 0x6F {
        0x21 => "ready to switch on",
        0x23 => "switched on",
        0x27 => "operation enabled",
        0x07 => "quick stop active",
        _ => match word & 0x4F {
            0x00 => "not ready to switch on",
            0x40 => "switch on disabled",
            0x0F => "fault reaction active",
            0x08 => "fault",
            _ => "no state of CiA 402",
        },
    };
    let bits = [
        (7, "warning"),
        (10, "target reached"),
        (11, "internal limit active"),
        (12, bit_12),
        (13, bit_13),
    ];
    named(state, word, &bits)
}

/// What a controlword commands, in profile position mode.
pub fn controlword(word: u16) -> String {
    controlword_in(word, PROFILE_POSITION)
}

/// The same in another mode of operation: bits 4 to 6 are the mode's.
pub fn controlword_in(word: u16, mode: i8) -> String {
    let command = match word {
        _ if word & 0x80 != 0 => "fault reset",
        _ if word & 0x02 == 0 => "disable voltage",
        _ if word & 0x04 == 0 => "quick stop",
        _ if word & 0x01 == 0 => "shutdown",
        _ if word & 0x08 == 0 => "switch on",
        _ => "enable operation",
    };
    let [bit_4, bit_5, bit_6] = match mode {
        1 => ["new set-point", "change immediately", "relative"],
        2 => ["ramp enabled", "ramp unlocked", "ramp input"],
        6 => ["start homing", "", ""],
        7 => ["enable interpolation", "", ""],
        _ => [""; 3],
    };
    let bits = [(4, bit_4), (5, bit_5), (6, bit_6), (8, "halt")];
    named(command, word, &bits)
}

/// The state of a node as its heartbeat says it (CiA 301).
pub fn node_state(state: u8) -> &'static str {
    match state & 0x7F {
        0x00 => "initialising",
        0x04 => "stopped",
        0x05 => "operational",
        0x7F => "pre-operational",
        _ => "unknown state",
    }
}

fn named(first: &str, word: u16, bits: &[(u32, &str)]) -> String {
    let set = bits
        .iter()
        .filter(|(bit, name)| word >> bit & 1 == 1 && !name.is_empty())
        .map(|(_, name)| *name);
    let parts: Vec<&str> = std::iter::once(first).chain(set).collect();
    parts.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_state_has_its_name() {
        let names = [
            (0x0000, "not ready to switch on"),
            (0x0250, "switch on disabled"),
            (0x0231, "ready to switch on"),
            (0x0233, "switched on"),
            (0x0237, "operation enabled"),
            (0x0217, "quick stop active"),
            (0x021F, "fault reaction active"),
            (0x0218, "fault"),
        ];
        for (word, name) in names {
            assert_eq!(statusword(word), name, "{word:04X}");
        }
        assert_eq!(
            statusword(0x1637),
            "operation enabled, target reached, set-point acknowledged"
        );
    }

    #[test]
    fn the_bits_of_a_mode_have_its_names() {
        let told = |mode, status, control| {
            let words = [statusword_in(status, mode), controlword_in(control, mode)];
            words.join(" | ")
        };
        let names = [
            (
                6,
                "operation enabled, target reached, homing attained | enable operation, start homing",
            ),
            (
                3,
                "operation enabled, target reached, speed is 0 | enable operation",
            ),
            (
                8,
                "operation enabled, target reached, follows the command value | enable operation",
            ),
            (4, "operation enabled, target reached | enable operation"),
        ];
        for (mode, name) in names {
            assert_eq!(told(mode, 0x1637, 0x1F), name, "{mode}");
        }
        assert_eq!(
            controlword_in(0x7F, 2),
            "enable operation, ramp enabled, ramp unlocked, ramp input"
        );
    }

    #[test]
    fn every_command_has_its_name() {
        let names = [
            (0x00, "disable voltage"),
            (0x02, "quick stop"),
            (0x06, "shutdown"),
            (0x07, "switch on"),
            (0x0F, "enable operation"),
            (0x1F, "enable operation, new set-point"),
            (0x10F, "enable operation, halt"),
            (0x80, "fault reset"),
        ];
        for (word, name) in names {
            assert_eq!(controlword(word), name, "{word:04X}");
        }
    }
}

//! Emergency error codes in words: CiA 301 (table 26) and the codes of drives that 603Fh shows (CiA 402-2).

/// Codes by their value. One that is not here has the words of its group: the codes that end in more zeros.
const WORDS: [(u16, &str); 62] = [
    (0x0000, "no error"),
    (0x1000, "generic error"),
    (0x2000, "current"),
    (0x2100, "current on the side of the supply"),
    (0x2200, "current inside the device"),
    (0x2300, "current on the side of the motor"),
    (0x2310, "overcurrent on the side of the motor"),
    (
        0x2320,
        "short circuit or earth leakage on the side of the motor",
    ),
    (0x2350, "overload of the motor (I²t)"),
    (0x3000, "voltage"),
    (0x3100, "supply voltage"),
    (0x3110, "supply voltage too high"),
    (0x3120, "supply voltage too low"),
    (0x3200, "voltage inside the device"),
    (0x3210, "DC link voltage too high"),
    (0x3220, "DC link voltage too low"),
    (0x3300, "output voltage"),
    (0x4000, "temperature"),
    (0x4100, "ambient temperature"),
    (0x4200, "temperature of the device"),
    (0x4210, "device too hot"),
    (0x4220, "device too cold"),
    (0x4300, "temperature of the drive"),
    (0x4310, "drive too hot"),
    (0x5000, "hardware of the device"),
    (0x5100, "supply of the electronics"),
    (0x5200, "control hardware"),
    (0x5300, "operating unit"),
    (0x5400, "power stage"),
    (0x5440, "contactors"),
    (0x5500, "memory"),
    (0x5530, "parameter memory"),
    (0x6000, "software of the device"),
    (0x6010, "watchdog"),
    (0x6100, "internal software"),
    (0x6200, "user software"),
    (0x6300, "data record"),
    (0x6310, "parameters are lost"),
    (0x6320, "parameters contradict each other"),
    (0x7000, "additional modules"),
    (0x7100, "power"),
    (0x7110, "brake chopper"),
    (0x7120, "motor"),
    (0x7121, "motor blocked"),
    (0x7122, "motor error or commutation"),
    (0x7200, "measurement circuit"),
    (0x7300, "sensor"),
    (0x7305, "encoder"),
    (0x8000, "monitoring"),
    (0x8100, "communication"),
    (0x8110, "CAN overrun, objects lost"),
    (0x8120, "CAN error passive"),
    (0x8130, "life guard or heartbeat error"),
    (0x8140, "recovered from bus-off"),
    (0x8150, "CAN-ID collision"),
    (0x8200, "protocol error"),
    (0x8210, "PDO too short"),
    (0x8220, "PDO too long"),
    (0x8611, "following error"),
    (0x8612, "reference limit"),
    (0x9000, "external error"),
    (0xF000, "additional functions"),
];

/// What a code says; of one that no standard names, what its group says.
pub fn error_words(code: u16) -> Option<&'static str> {
    let of = |wanted: u16| WORDS.iter().find(|(known, _)| *known == wanted);
    let groups = [code, code & 0xFFF0, code & 0xFF00, code & 0xF000];
    let named = groups.into_iter().filter(|group| *group != 0 || code == 0);
    named.filter_map(of).map(|(_, words)| *words).next()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_code_has_its_own_words_or_those_of_its_group() {
        assert_eq!(error_words(0x8130), Some("life guard or heartbeat error"));
        assert_eq!(error_words(0x3221), Some("DC link voltage too low"));
        assert_eq!(error_words(0x2A55), Some("current"));
        assert_eq!(error_words(0x0000), Some("no error"));
        assert_eq!(error_words(0x00FF), None);
        assert_eq!(error_words(0xB000), None);
    }

    #[test]
    fn codes_stand_in_their_order_once() {
        assert!(WORDS.windows(2).all(|pair| pair[0].0 < pair[1].0));
    }
}

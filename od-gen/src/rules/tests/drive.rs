//! Rules of CiA 402.

use super::{Case, case};

pub(super) const CASES: &[Case] = &[
    case(
        "standard-type",
        &["drive", "6085 I32 rw 1"],
        &["drive", "6085 U32 rw 1"],
    ),
    case(
        "standard-access",
        &["drive", "603F U16 rw 0"],
        &["drive", "603F U16 ro 0"],
    ),
    // The second axis is held to the same.
    case(
        "standard-type",
        &[
            "drive",
            "6840 U16 rw 0 map",
            "6841 U32 ro 0 map",
            "6860 I8 rw 0",
            "6861 I8 ro 0",
            "6D02 U32 ro 0",
        ],
        &[
            "drive",
            "6840 U16 rw 0 map",
            "6841 U16 ro 0 map",
            "6860 I8 rw 0",
            "6861 I8 ro 0",
            "6D02 U32 ro 0",
        ],
    ),
    case("drive-object", &["drive", "-6061"], &["drive"]),
    case(
        "drive-words-mappable",
        &[
            "drive",
            "6040 U16 rw 0",
            "1400:1 U32 rw $NODEID+0x200",
            "1400:2 U8 rw 255",
            "1600:0 U8 rw 1",
            "1600:1 U32 rw 0x607A0020",
        ],
        &[
            "drive",
            "6040 U16 rw 0 map",
            "1400:1 U32 rw $NODEID+0x200",
            "1400:2 U8 rw 255",
            "1600:0 U8 rw 1",
            "1600:1 U32 rw 0x60400010",
        ],
    ),
    case(
        "drive-type",
        &["drive", "1000 U32 const 0x00000192"],
        &["drive", "1000 U32 const 0x00020192"],
    ),
    case(
        "mode-object",
        &["drive", "6502 U32 ro 0x21"],
        &[
            "drive",
            "6502 U32 ro 0x21",
            "6098 I8 rw 0",
            "6099:1 U32 rw 1",
            "6099:2 U32 rw 1",
        ],
    ),
    case(
        "mode-not-claimed",
        &["drive", "6098 I8 rw 0"],
        &["drive", "60FF I32 rw 0"],
    ),
    case(
        "reserved-mode",
        &["drive", "6502 U32 ro 0x11"],
        &["drive", "6502 U32 ro 0x10001"],
    ),
    case(
        "default-mode",
        &["drive", "6060 I8 rw 3"],
        &["drive", "6060 I8 rw -3"],
    ),
    case(
        "zero-factor",
        &["drive", "6091:1 U32 rw 1", "6091:2 U32 rw 0"],
        &["drive", "6091:1 U32 rw 1", "6091:2 U32 rw 1"],
    ),
    case(
        "obsolete-unit",
        &["drive", "6089 I8 rw 0"],
        &["drive", "60A8 U32 rw 0xFD010000"],
    ),
    case(
        "si-unit",
        &["drive", "60A9 U32 rw 0xFD010301"],
        &["drive", "60A9 U32 rw 0xFD010300"],
    ),
    case(
        "polarity",
        &["drive", "607E U8 rw 1"],
        &["drive", "607E U8 rw 0xC0"],
    ),
    case(
        "option-code",
        &["drive", "605A I16 rw 9"],
        &["drive", "605A I16 rw -9"],
    ),
    case(
        "crossed-limits",
        &["drive", "607D:1 I32 rw 5", "607D:2 I32 rw -5"],
        &["drive", "607D:1 I32 rw 0", "607D:2 I32 rw 0"],
    ),
    case(
        "homing-method",
        &[
            "drive",
            "6502 U32 ro 0x21",
            "6098 I8 rw 15",
            "6099:1 U32 rw 1",
            "6099:2 U32 rw 1",
        ],
        &[
            "drive",
            "6502 U32 ro 0x21",
            "6098 I8 rw -1",
            "6099:1 U32 rw 1",
            "6099:2 U32 rw 1",
        ],
    ),
    case(
        "homing-method",
        &[
            "drive",
            "6502 U32 ro 0x21",
            "6098 I8 rw 17",
            "6099:1 U32 rw 1",
            "6099:2 U32 rw 1",
            "60E3:1 I8 ro 35",
        ],
        &[
            "drive",
            "6502 U32 ro 0x21",
            "6098 I8 rw 35",
            "6099:1 U32 rw 1",
            "6099:2 U32 rw 1",
            "60E3:1 I8 ro 35",
        ],
    ),
    case(
        "interpolation-time",
        &[
            "drive",
            "6502 U32 ro 0x81",
            "60C2:1 U8 rw 0",
            "60C2:2 I8 rw -3",
        ],
        &[
            "drive",
            "6502 U32 ro 0x81",
            "60C2:1 U8 rw 1",
            "60C2:2 I8 rw -3",
        ],
    ),
    case(
        "interpolation-time",
        &["drive", "60C2:1 U8 rw 1", "60C2:2 I8 rw 64"],
        &["drive", "60C2:1 U8 rw 0", "60C2:2 I8 rw 63"],
    ),
    case(
        "velocity-above-maximum",
        &["drive", "607F U32 rw 999"],
        &["drive", "607F U32 rw 1000"],
    ),
];

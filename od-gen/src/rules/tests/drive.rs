//! Rules of CiA 402.

use super::Case;

pub(super) const CASES: &[Case] = &[
    Case {
        rule: "standard-type",
        bad: &["drive", "6085 I32 rw 1"],
        good: &["drive", "6085 U32 rw 1"],
    },
    Case {
        rule: "standard-access",
        bad: &["drive", "603F U16 rw 0"],
        good: &["drive", "603F U16 ro 0"],
    },
    // The second axis is held to the same.
    Case {
        rule: "standard-type",
        bad: &[
            "drive",
            "6840 U16 rw 0 map",
            "6841 U32 ro 0 map",
            "6860 I8 rw 0",
            "6861 I8 ro 0",
            "6D02 U32 ro 0",
        ],
        good: &[
            "drive",
            "6840 U16 rw 0 map",
            "6841 U16 ro 0 map",
            "6860 I8 rw 0",
            "6861 I8 ro 0",
            "6D02 U32 ro 0",
        ],
    },
    Case {
        rule: "drive-object",
        bad: &["drive", "-6061"],
        good: &["drive"],
    },
    Case {
        rule: "drive-words-mappable",
        bad: &[
            "drive",
            "6040 U16 rw 0",
            "1400:1 U32 rw $NODEID+0x200",
            "1400:2 U8 rw 255",
            "1600:0 U8 rw 1",
            "1600:1 U32 rw 0x607A0020",
        ],
        good: &[
            "drive",
            "6040 U16 rw 0 map",
            "1400:1 U32 rw $NODEID+0x200",
            "1400:2 U8 rw 255",
            "1600:0 U8 rw 1",
            "1600:1 U32 rw 0x60400010",
        ],
    },
    Case {
        rule: "drive-type",
        bad: &["drive", "1000 U32 const 0x00000192"],
        good: &["drive", "1000 U32 const 0x00020192"],
    },
    Case {
        rule: "mode-object",
        bad: &["drive", "6502 U32 ro 0x21"],
        good: &[
            "drive",
            "6502 U32 ro 0x21",
            "6098 I8 rw 0",
            "6099:1 U32 rw 1",
            "6099:2 U32 rw 1",
        ],
    },
    Case {
        rule: "mode-not-claimed",
        bad: &["drive", "6098 I8 rw 0"],
        good: &["drive", "60FF I32 rw 0"],
    },
    Case {
        rule: "reserved-mode",
        bad: &["drive", "6502 U32 ro 0x11"],
        good: &["drive", "6502 U32 ro 0x10001"],
    },
    Case {
        rule: "default-mode",
        bad: &["drive", "6060 I8 rw 3"],
        good: &["drive", "6060 I8 rw -3"],
    },
    Case {
        rule: "zero-factor",
        bad: &["drive", "6091:1 U32 rw 1", "6091:2 U32 rw 0"],
        good: &["drive", "6091:1 U32 rw 1", "6091:2 U32 rw 1"],
    },
    Case {
        rule: "obsolete-unit",
        bad: &["drive", "6089 I8 rw 0"],
        good: &["drive", "60A8 U32 rw 0xFD010000"],
    },
    Case {
        rule: "si-unit",
        bad: &["drive", "60A9 U32 rw 0xFD010301"],
        good: &["drive", "60A9 U32 rw 0xFD010300"],
    },
    Case {
        rule: "polarity",
        bad: &["drive", "607E U8 rw 1"],
        good: &["drive", "607E U8 rw 0xC0"],
    },
    Case {
        rule: "option-code",
        bad: &["drive", "605A I16 rw 9"],
        good: &["drive", "605A I16 rw -9"],
    },
    Case {
        rule: "crossed-limits",
        bad: &["drive", "607D:1 I32 rw 5", "607D:2 I32 rw -5"],
        good: &["drive", "607D:1 I32 rw 0", "607D:2 I32 rw 0"],
    },
    Case {
        rule: "homing-method",
        bad: &[
            "drive",
            "6502 U32 ro 0x21",
            "6098 I8 rw 15",
            "6099:1 U32 rw 1",
            "6099:2 U32 rw 1",
        ],
        good: &[
            "drive",
            "6502 U32 ro 0x21",
            "6098 I8 rw -1",
            "6099:1 U32 rw 1",
            "6099:2 U32 rw 1",
        ],
    },
    Case {
        rule: "homing-method",
        bad: &[
            "drive",
            "6502 U32 ro 0x21",
            "6098 I8 rw 17",
            "6099:1 U32 rw 1",
            "6099:2 U32 rw 1",
            "60E3:1 I8 ro 35",
        ],
        good: &[
            "drive",
            "6502 U32 ro 0x21",
            "6098 I8 rw 35",
            "6099:1 U32 rw 1",
            "6099:2 U32 rw 1",
            "60E3:1 I8 ro 35",
        ],
    },
    Case {
        rule: "interpolation-time",
        bad: &[
            "drive",
            "6502 U32 ro 0x81",
            "60C2:1 U8 rw 0",
            "60C2:2 I8 rw -3",
        ],
        good: &[
            "drive",
            "6502 U32 ro 0x81",
            "60C2:1 U8 rw 1",
            "60C2:2 I8 rw -3",
        ],
    },
    Case {
        rule: "interpolation-time",
        bad: &["drive", "60C2:1 U8 rw 1", "60C2:2 I8 rw 64"],
        good: &["drive", "60C2:1 U8 rw 0", "60C2:2 I8 rw 63"],
    },
    Case {
        rule: "velocity-above-maximum",
        bad: &["drive", "607F U32 rw 999"],
        good: &["drive", "607F U32 rw 1000"],
    },
];

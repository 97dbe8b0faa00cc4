//! Rules of CiA 301 but for PDOs.

use super::Case;

pub(super) const CASES: &[Case] = &[
    Case {
        rule: "standard-kind",
        bad: &["1016:1 U32 rw 0", "1016 RECORD"],
        good: &["1016:1 U32 rw 0"],
    },
    Case {
        rule: "standard-type",
        bad: &["1017 U32 rw 1000"],
        good: &["1017 U16 rw 1000"],
    },
    Case {
        rule: "standard-access",
        bad: &["1001 U8 rw 0"],
        good: &["1001 U8 const 0"],
    },
    Case {
        rule: "missing-sub-index",
        bad: &["@LSS_Supported=0", "-1018:1"],
        good: &["@LSS_Supported=0", "-1018:4"],
    },
    Case {
        rule: "unknown-sub-index",
        bad: &["1018:5 U32 ro 0"],
        good: &["1029:1 U8 rw 0", "1029:2 U8 rw 0"],
    },
    Case {
        rule: "identity-mismatch",
        bad: &["@ProductNumber=0x23"],
        good: &["@ProductNumber=34"],
    },
    Case {
        rule: "no-vendor-id",
        bad: &["@VendorNumber=0", "1018:1 U32 ro 0"],
        good: &["@VendorNumber=1", "1018:1 U32 ro 1"],
    },
    Case {
        rule: "lss-without-identity",
        bad: &["-1018:4"],
        good: &["-1018:4", "@LSS_Supported=0"],
    },
    Case {
        rule: "no-bit-rate",
        bad: &["@BaudRate_125=0"],
        good: &["@BaudRate_125=0", "@BaudRate_1000=1"],
    },
    Case {
        rule: "boot-up-role",
        bad: &["@SimpleBootUpSlave=0"],
        good: &["@SimpleBootUpSlave=0", "@SimpleBootUpMaster=1"],
    },
    Case {
        rule: "modular-device",
        bad: &["@DynamicChannelsSupported=1"],
        good: &["@DynamicChannelsSupported=0"],
    },
    Case {
        rule: "compact-pdo",
        bad: &["@CompactPDO=3", "@NrOfRXPDO=0"],
        good: &["@CompactPDO=3", "@NrOfRXPDO=1"],
    },
    Case {
        rule: "compact-pdo",
        bad: &["@CompactPDO=67", "@NrOfTXPDO=2"],
        good: &["@CompactPDO=0x3F", "@NrOfTXPDO=2"],
    },
    Case {
        rule: "profile-without-objects",
        bad: &["1000 U32 const 0x00030191"],
        good: &["1000 U32 const 0x00030191", "6000:1 U8 ro 0"],
    },
    Case {
        rule: "objects-without-profile",
        bad: &["6000:1 U8 ro 0"],
        good: &["2000:1 U8 ro 0"],
    },
    Case {
        rule: "axis-device-type",
        bad: &["drive", "67FF U32 ro 0x00030191"],
        good: &["drive", "67FF U32 ro 0x00040192"],
    },
    Case {
        rule: "no-error-control",
        bad: &["-1017"],
        good: &["-1017", "100C U16 rw 0", "100D U8 rw 0"],
    },
    Case {
        rule: "half-a-guard",
        bad: &["100C U16 rw 0"],
        good: &["100C U16 rw 0", "100D U8 rw 0"],
    },
    Case {
        rule: "guarding-beside-heartbeat",
        bad: &["100C U16 rw 100", "100D U8 rw 3"],
        good: &["1017 U16 rw 0", "100C U16 rw 100", "100D U8 rw 3"],
    },
    Case {
        rule: "heartbeat-consumer",
        bad: &["1016:1 U32 rw 0x008003E8"],
        good: &["1016:1 U32 rw 0x007F03E8"],
    },
    Case {
        rule: "heartbeat-consumed-twice",
        bad: &["1016:1 U32 rw 0x000503E8", "1016:2 U32 rw 0x00050064"],
        good: &["1016:1 U32 rw 0x000503E8", "1016:2 U32 rw 0x00050000"],
    },
    Case {
        rule: "error-behaviour",
        bad: &["1029:1 U8 rw 3"],
        good: &["1029:1 U8 rw 2"],
    },
    Case {
        rule: "nmt-startup",
        bad: &["1F80 U32 rw 1"],
        good: &["1F80 U32 rw 1", "@SimpleBootUpMaster=1"],
    },
    Case {
        rule: "nmt-startup",
        bad: &["1F80 U32 rw 0x80"],
        good: &["1F80 U32 rw 0x04"],
    },
    Case {
        rule: "sync-without-cob-id",
        bad: &["1007 U32 rw 0"],
        good: &["1005 U32 rw 0x80", "1007 U32 rw 0"],
    },
    Case {
        rule: "sync-producer-without-period",
        bad: &["1005 U32 rw 0x40000080", "1006 U32 rw 0"],
        good: &["1005 U32 rw 0x40000080", "1006 U32 rw 10000"],
    },
    Case {
        rule: "sync-window",
        bad: &["1005 U32 rw 0x80", "1006 U32 rw 1000", "1007 U32 rw 1000"],
        good: &["1005 U32 rw 0x80", "1006 U32 rw 1000", "1007 U32 rw 999"],
    },
    Case {
        rule: "sync-counter",
        bad: &["1005 U32 rw 0x80", "1019 U8 rw 1"],
        good: &["1005 U32 rw 0x80", "1019 U8 rw 240"],
    },
    Case {
        rule: "emergency-without-cob-id",
        bad: &["1015 U16 rw 0"],
        good: &["1014 U32 rw $NODEID+0x80", "1015 U16 rw 0"],
    },
    Case {
        rule: "error-list",
        bad: &[
            "1014 U32 rw $NODEID+0x80",
            "1003:0 U8 rw 1",
            "1003:1 U32 ro 0",
        ],
        good: &[
            "1014 U32 rw $NODEID+0x80",
            "1003:0 U8 rw 0",
            "1003:1 U32 ro 0",
        ],
    },
    Case {
        rule: "error-list",
        bad: &[
            "1014 U32 rw $NODEID+0x80",
            "1003:0 U8 ro 0",
            "1003:1 U32 ro 0",
        ],
        good: &[
            "1014 U32 rw $NODEID+0x80",
            "1003:0 U8 rw 0",
            "1003:1 U32 ro 0",
        ],
    },
    Case {
        rule: "store-without-restore",
        bad: &["1010:1 U32 rw 1", "1010:2 U32 rw 1", "1011:1 U32 rw 1"],
        good: &["1010:1 U32 rw 1", "1011:1 U32 rw 1"],
    },
    Case {
        rule: "store-capability",
        bad: &["1010:1 U32 rw 0x65766173", "1011:1 U32 rw 1"],
        good: &["1010:1 U32 rw 3", "1011:1 U32 rw 1"],
    },
    Case {
        rule: "program-download",
        bad: &["1F51:1 U8 rw 0"],
        good: &["1F50:1 DOMAIN rw", "1F51:1 U8 rw 0"],
    },
    Case {
        rule: "restricted-cob-id",
        bad: &["1028:1 U32 rw 0x701"],
        good: &["1028:1 U32 rw 0x80000701"],
    },
    Case {
        rule: "extended-cob-id",
        bad: &["1014 U32 rw $NODEID+0x20000080"],
        good: &["1014 U32 rw $NODEID+0x80000080"],
    },
    Case {
        rule: "reserved-cob-id-bit",
        bad: &["1014 U32 rw $NODEID+0x40000080"],
        good: &["1014 U32 rw $NODEID+0x80"],
    },
    Case {
        rule: "default-sdo-cob-id",
        bad: &["1200:1 U32 ro $NODEID+0x600", "1200:2 U32 rw $NODEID+0x580"],
        good: &["1200:1 U32 ro $NODEID+0x600", "1200:2 U32 ro $NODEID+0x580"],
    },
    Case {
        rule: "default-sdo-cob-id",
        bad: &["1200:1 U32 ro 0x600", "1200:2 U32 ro $NODEID+0x580"],
        good: &[
            "1200:1 U32 const $NODEID+0x600",
            "1200:2 U32 const $NODEID+0x580",
        ],
    },
    Case {
        rule: "predefined-cob-id",
        bad: &["1005 U32 rw 0x81"],
        good: &["1005 U32 rw 0x80"],
    },
    Case {
        rule: "predefined-cob-id",
        bad: &["1014 U32 rw 0x85"],
        good: &["1014 U32 rw 0x85", "node 5"],
    },
    Case {
        rule: "configured-read-only",
        bad: &["node 5", "2000 U8 ro 0 =1"],
        good: &["node 5", "2000 U8 rw 0 =1"],
    },
    Case {
        rule: "configured-outside-limits",
        bad: &["node 5", "2000 U8 rw 0 =6 <=5"],
        good: &["node 5", "2000 U8 rw 0 =5 <=5"],
    },
];

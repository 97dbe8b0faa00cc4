//! Rules of CiA 301 but for PDOs.

use super::{Case, case};

pub(super) const CASES: &[Case] = &[
    case(
        "standard-kind",
        &["1016:1 U32 rw 0", "1016 RECORD"],
        &["1016:1 U32 rw 0"],
    ),
    case(
        "standard-type",
        &["1017 U32 rw 1000"],
        &["1017 U16 rw 1000"],
    ),
    case("standard-access", &["1001 U8 rw 0"], &["1001 U8 const 0"]),
    case(
        "missing-sub-index",
        &["@LSS_Supported=0", "-1018:1"],
        &["@LSS_Supported=0", "-1018:4"],
    ),
    case(
        "unknown-sub-index",
        &["1018:5 U32 ro 0"],
        &["1029:1 U8 rw 0", "1029:2 U8 rw 0"],
    ),
    case(
        "identity-mismatch",
        &["@ProductNumber=0x23"],
        &["@ProductNumber=34"],
    ),
    case(
        "no-vendor-id",
        &["@VendorNumber=0", "1018:1 U32 ro 0"],
        &["@VendorNumber=1", "1018:1 U32 ro 1"],
    ),
    case(
        "lss-without-identity",
        &["-1018:4"],
        &["-1018:4", "@LSS_Supported=0"],
    ),
    case(
        "no-bit-rate",
        &["@BaudRate_125=0"],
        &["@BaudRate_125=0", "@BaudRate_1000=1"],
    ),
    case(
        "boot-up-role",
        &["@SimpleBootUpSlave=0"],
        &["@SimpleBootUpSlave=0", "@SimpleBootUpMaster=1"],
    ),
    case(
        "modular-device",
        &["@DynamicChannelsSupported=1"],
        &["@DynamicChannelsSupported=0"],
    ),
    case(
        "compact-pdo",
        &["@CompactPDO=3", "@NrOfRXPDO=0"],
        &["@CompactPDO=3", "@NrOfRXPDO=1"],
    ),
    case(
        "compact-pdo",
        &["@CompactPDO=67", "@NrOfTXPDO=2"],
        &["@CompactPDO=0x3F", "@NrOfTXPDO=2"],
    ),
    case(
        "profile-without-objects",
        &["1000 U32 const 0x00030191"],
        &["1000 U32 const 0x00030191", "6000:1 U8 ro 0"],
    ),
    case(
        "objects-without-profile",
        &["6000:1 U8 ro 0"],
        &["2000:1 U8 ro 0"],
    ),
    case(
        "axis-device-type",
        &["drive", "67FF U32 ro 0x00030191"],
        &["drive", "67FF U32 ro 0x00040192"],
    ),
    case(
        "no-error-control",
        &["-1017"],
        &["-1017", "100C U16 rw 0", "100D U8 rw 0"],
    ),
    case(
        "half-a-guard",
        &["100C U16 rw 0"],
        &["100C U16 rw 0", "100D U8 rw 0"],
    ),
    case(
        "guarding-beside-heartbeat",
        &["100C U16 rw 100", "100D U8 rw 3"],
        &["1017 U16 rw 0", "100C U16 rw 100", "100D U8 rw 3"],
    ),
    case(
        "heartbeat-consumer",
        &["1016:1 U32 rw 0x008003E8"],
        &["1016:1 U32 rw 0x007F03E8"],
    ),
    case(
        "heartbeat-consumed-twice",
        &["1016:1 U32 rw 0x000503E8", "1016:2 U32 rw 0x00050064"],
        &["1016:1 U32 rw 0x000503E8", "1016:2 U32 rw 0x00050000"],
    ),
    case("error-behaviour", &["1029:1 U8 rw 3"], &["1029:1 U8 rw 2"]),
    case(
        "nmt-startup",
        &["1F80 U32 rw 1"],
        &["1F80 U32 rw 1", "@SimpleBootUpMaster=1"],
    ),
    case("nmt-startup", &["1F80 U32 rw 0x80"], &["1F80 U32 rw 0x04"]),
    case(
        "sync-without-cob-id",
        &["1007 U32 rw 0"],
        &["1005 U32 rw 0x80", "1007 U32 rw 0"],
    ),
    case(
        "sync-producer-without-period",
        &["1005 U32 rw 0x40000080", "1006 U32 rw 0"],
        &["1005 U32 rw 0x40000080", "1006 U32 rw 10000"],
    ),
    case(
        "sync-window",
        &["1005 U32 rw 0x80", "1006 U32 rw 1000", "1007 U32 rw 1000"],
        &["1005 U32 rw 0x80", "1006 U32 rw 1000", "1007 U32 rw 999"],
    ),
    case(
        "sync-counter",
        &["1005 U32 rw 0x80", "1019 U8 rw 1"],
        &["1005 U32 rw 0x80", "1019 U8 rw 240"],
    ),
    case(
        "emergency-without-cob-id",
        &["1015 U16 rw 0"],
        &["1014 U32 rw $NODEID+0x80", "1015 U16 rw 0"],
    ),
    case(
        "error-list",
        &[
            "1014 U32 rw $NODEID+0x80",
            "1003:0 U8 rw 1",
            "1003:1 U32 ro 0",
        ],
        &[
            "1014 U32 rw $NODEID+0x80",
            "1003:0 U8 rw 0",
            "1003:1 U32 ro 0",
        ],
    ),
    case(
        "error-list",
        &[
            "1014 U32 rw $NODEID+0x80",
            "1003:0 U8 ro 0",
            "1003:1 U32 ro 0",
        ],
        &[
            "1014 U32 rw $NODEID+0x80",
            "1003:0 U8 rw 0",
            "1003:1 U32 ro 0",
        ],
    ),
    case(
        "store-without-restore",
        &["1010:1 U32 rw 1", "1010:2 U32 rw 1", "1011:1 U32 rw 1"],
        &["1010:1 U32 rw 1", "1011:1 U32 rw 1"],
    ),
    case(
        "store-capability",
        &["1010:1 U32 rw 0x65766173", "1011:1 U32 rw 1"],
        &["1010:1 U32 rw 3", "1011:1 U32 rw 1"],
    ),
    case(
        "program-download",
        &["1F51:1 U8 rw 0"],
        &["1F50:1 DOMAIN rw", "1F51:1 U8 rw 0"],
    ),
    case(
        "restricted-cob-id",
        &["1028:1 U32 rw 0x701"],
        &["1028:1 U32 rw 0x80000701"],
    ),
    case(
        "cob-id-left-open",
        &["1028:1 U32 rw 0", "1028:2 U32 rw 0"],
        &["1028:1 U32 rw 0x80000000", "1028:2 U32 rw 0x85"],
    ),
    case(
        "cob-id-left-open",
        &["1005 U32 rw 0x80", "1014 U32 rw 0x80"],
        &["1005 U32 rw 0x80", "1014 U32 rw $NODEID+0x80"],
    ),
    case(
        "sdo-client-cob-id",
        &[
            "1280:1 U32 rw 0x601",
            "1280:2 U32 rw 0x80000000",
            "1280:3 U8 rw 1",
        ],
        &[
            "1280:1 U32 rw 0x80000601",
            "1280:2 U32 rw 0x80000581",
            "1280:3 U8 rw 1",
        ],
    ),
    case(
        "cob-id-used-twice-with-a-node-id",
        &["1014 U32 rw $NODEID+0x80", "1028:1 U32 rw 0x85"],
        &["1014 U32 rw $NODEID+0x80", "1028:1 U32 rw 0x80000085"],
    ),
    case(
        "extended-cob-id",
        &["1014 U32 rw $NODEID+0x20000080"],
        &["1014 U32 rw $NODEID+0x80000080"],
    ),
    case(
        "reserved-cob-id-bit",
        &["1014 U32 rw $NODEID+0x40000080"],
        &["1014 U32 rw $NODEID+0x80"],
    ),
    case(
        "default-sdo-cob-id",
        &["1200:1 U32 ro $NODEID+0x600", "1200:2 U32 rw $NODEID+0x580"],
        &["1200:1 U32 ro $NODEID+0x600", "1200:2 U32 ro $NODEID+0x580"],
    ),
    case(
        "default-sdo-cob-id",
        &["1200:1 U32 ro 0x600", "1200:2 U32 ro $NODEID+0x580"],
        &[
            "1200:1 U32 const $NODEID+0x600",
            "1200:2 U32 const $NODEID+0x580",
        ],
    ),
    case(
        "predefined-cob-id",
        &["1005 U32 rw 0x81"],
        &["1005 U32 rw 0x80"],
    ),
    case(
        "predefined-cob-id",
        &["1014 U32 rw 0x85"],
        &["1014 U32 rw 0x85", "node 5"],
    ),
    case(
        "configured-read-only",
        &["node 5", "2000 U8 ro 0 =1"],
        &["node 5", "2000 U8 rw 0 =1"],
    ),
    case(
        "configured-outside-limits",
        &["node 5", "2000 U8 rw 0 =6 <=5"],
        &["node 5", "2000 U8 rw 0 =5 <=5"],
    ),
];

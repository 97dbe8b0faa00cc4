//! The communication objects (CiA 301, 7.5.2), and those of CiA 302 that this family of devices knows.

use super::Rights::{Any, Read, Write};
use super::{Known, Sub, array, elements, needed, one, open, optional, record, var};
use crate::data_type::DataType::{Domain, Unsigned8, Unsigned16, Unsigned32, VisibleString};

/// SDO parameter of a server or a client beyond the first server.
const SDO: &[Sub] = &[
    needed(1, Unsigned32, Any),
    needed(2, Unsigned32, Any),
    optional(3, Unsigned8, Any),
];

const RPDO: &[Sub] = &[
    needed(1, Unsigned32, Any),
    needed(2, Unsigned8, Any),
    optional(3, Unsigned16, Any),
    optional(4, Unsigned8, Any),
    optional(5, Unsigned16, Any),
];

const TPDO: &[Sub] = &[
    needed(1, Unsigned32, Any),
    needed(2, Unsigned8, Any),
    optional(3, Unsigned16, Any),
    optional(4, Unsigned8, Any),
    optional(5, Unsigned16, Any),
    optional(6, Unsigned8, Any),
];

const MAPPING: &[Sub] = &[elements(1, 64, Unsigned32, Any)];

/// By index.
pub(super) const OBJECTS: &[Known] = &[
    var(0x1000, &[one(Unsigned32, Read)]),
    var(0x1001, &[one(Unsigned8, Read)]),
    var(0x1002, &[one(Unsigned32, Read)]),
    array(0x1003, &[elements(1, 254, Unsigned32, Read)]),
    var(0x1005, &[one(Unsigned32, Any)]),
    var(0x1006, &[one(Unsigned32, Any)]),
    var(0x1007, &[one(Unsigned32, Any)]),
    var(0x1008, &[one(VisibleString, Read)]),
    var(0x1009, &[one(VisibleString, Read)]),
    var(0x100A, &[one(VisibleString, Read)]),
    var(0x100C, &[one(Unsigned16, Any)]),
    var(0x100D, &[one(Unsigned8, Any)]),
    array(0x1010, &[elements(1, 127, Unsigned32, Any)]),
    array(0x1011, &[elements(1, 127, Unsigned32, Any)]),
    var(0x1012, &[one(Unsigned32, Any)]),
    var(0x1013, &[one(Unsigned32, Any)]),
    var(0x1014, &[one(Unsigned32, Any)]),
    var(0x1015, &[one(Unsigned16, Any)]),
    array(0x1016, &[elements(1, 127, Unsigned32, Any)]),
    var(0x1017, &[one(Unsigned16, Any)]),
    record(
        0x1018,
        0x1018,
        &[
            needed(1, Unsigned32, Read),
            optional(2, Unsigned32, Read),
            optional(3, Unsigned32, Read),
            optional(4, Unsigned32, Read),
        ],
    ),
    var(0x1019, &[one(Unsigned8, Any)]),
    array(0x1020, &[elements(1, 2, Unsigned32, Any)]),
    array(0x1028, &[elements(1, 127, Unsigned32, Any)]),
    array(0x1029, &[elements(1, 254, Unsigned8, Any)]),
    record(0x1200, 0x1200, SDO),
    record(0x1201, 0x12FF, SDO),
    record(0x1400, 0x15FF, RPDO),
    record(0x1600, 0x17FF, MAPPING),
    record(0x1800, 0x19FF, TPDO),
    record(0x1A00, 0x1BFF, MAPPING),
    array(0x1F50, &[elements(1, 254, Domain, Any)]),
    array(0x1F51, &[elements(1, 254, Unsigned8, Write)]),
    array(0x1F56, &[elements(1, 254, Unsigned32, Read)]),
    array(0x1F57, &[elements(1, 254, Unsigned32, Read)]),
    var(0x1F80, &[one(Unsigned32, Any)]),
    array(0x1F81, &[elements(1, 127, Unsigned32, Any)]),
    array(0x1F82, &[open(1, 128)]),
];

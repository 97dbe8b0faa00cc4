//! Rules of one value: type, access, limits, default (CiA 306, 4.6).

use super::Rule;

pub(crate) const RULES: &[&Rule] = &[
    &NOT_A_NUMBER,
    &OUT_OF_RANGE,
    &FILE_VERSION,
    &NO_DATA_TYPE,
    &DATA_TYPE,
    &NO_ACCESS,
    &ACCESS,
    &MAPPING_OF_VARIABLE_LENGTH,
    &DEFAULT_TYPE,
    &LIMIT_TYPE,
    &LIMIT_OF_NO_NUMBER,
    &LIMIT_OF_NODE,
    &VALUE_OF_A_DOMAIN,
    &LOW_ABOVE_HIGH,
    &DEFAULT_OUTSIDE_LIMITS,
    &CONST_WITHOUT_DEFAULT,
    &NODE_ID_TYPE,
    &NODE_ID_ROOM,
    &STRING,
    &OCTET_STRING,
    &CAPACITY,
    &CAPACITY_OF_NO_STRING,
    &CAPACITY_TOO_SMALL,
    &VALUE_TOO_LARGE,
    &STORAGE,
    &STORAGE_OF_FIXED,
    &MEMORY,
    &DICTIONARY_TOO_LARGE,
];

pub(crate) static NOT_A_NUMBER: Rule = Rule::error(
    "not-a-number",
    "A number is spelled as CiA 306 spells numbers.",
    "Decimal, 0x hexadecimal, octal with a leading zero, all of them with a sign before them or not. When this is silenced, \
     what was plainly meant counts (08, 1000h, TRUE, the name of a DataType). Else a limit is none, a default is 0, and any other key counts \
     as missing.",
);

pub(crate) static OUT_OF_RANGE: Rule = Rule::error(
    "out-of-range",
    "The number of a key is one that the key can have.",
    "The message names the range. When this is silenced, the key counts as missing.",
);

pub(crate) static FILE_VERSION: Rule = Rule::masters(
    "file-version",
    "FileVersion and FileRevision are whole numbers, 0 to 255.",
    "Many files have 1.0 there; the part before the point counts. It says nothing about the device.",
);

pub(crate) static NO_DATA_TYPE: Rule = Rule::error(
    "no-data-type",
    "A value has a DataType.",
    "Without it nobody knows how many bytes there are. When this is silenced, the dictionary does not have the value.",
);

pub(crate) static DATA_TYPE: Rule = Rule::masters(
    "data-type",
    "DataType is a type of CiA 301.",
    "The numbers are those of CiA 301, table 44. Types of the manufacturer and of device profiles are no types of a \
     single value. When this is silenced, the dictionary does not have the value.",
).strict();

pub(crate) static NO_ACCESS: Rule = Rule::error(
    "no-access",
    "A value has an AccessType.",
    "Without it nobody knows whether it may be written. When this is silenced, it is ro.",
);

pub(crate) static ACCESS: Rule = Rule::error(
    "access-type",
    "AccessType is one of CiA 306.",
    "ro, wo, rw, rwr (rw, an input of the process), rww (rw, an output of the process) or const. When this is silenced, \
     the value is ro.",
);

pub(crate) static MAPPING_OF_VARIABLE_LENGTH: Rule = Rule::firmware(
    "mapping-of-variable-length",
    "What a PDO carries has a fixed length.",
    "Strings and domains differ in length: a PDO cannot carry them. When this is silenced, PDOMapping counts as 0.",
);

pub(crate) static DEFAULT_TYPE: Rule = Rule::error(
    "default-type",
    "A default can be held by its type.",
    "The message names what the type can hold. Hexadecimal numbers are bit patterns: 0xFFFF is -1 in an INTEGER16. \
     When this is silenced, as many of its lowest bits count as the type has; of a BOOLEAN whether it is 0.",
);

pub(crate) static LIMIT_TYPE: Rule = Rule::error(
    "limit-type",
    "A limit can be held by its type.",
    "The message names what the type can hold. Hexadecimal numbers are bit patterns: 0xFFFF is -1 in an INTEGER16. \
     When this is silenced, the nearest number of the type counts.",
);

pub(crate) static LIMIT_OF_NO_NUMBER: Rule = Rule::masters(
    "limit-of-no-number",
    "Only numbers have limits.",
    "A limit of a string or a domain means nothing, and is left out.",
);

pub(crate) static LIMIT_OF_NODE: Rule = Rule::firmware(
    "limit-of-node",
    "A limit is the same for every node-ID.",
    "Limits lie in flash, where no node-ID is known. $NODEID in them is understood by everything but `rust`. When this is silenced, code has no such limit.",
);

pub(crate) static VALUE_OF_A_DOMAIN: Rule = Rule::masters(
    "value-of-a-domain",
    "A DOMAIN has no DefaultValue and no ParameterValue.",
    "Its bytes come from the application, and in a DCF from the file that DownloadFile names. The value is left out.",
);

pub(crate) static LOW_ABOVE_HIGH: Rule = Rule::error(
    "low-above-high",
    "LowLimit is not above HighLimit.",
    "No value can be between them: every write would be refused. When this is silenced, there are no limits.",
);

pub(crate) static DEFAULT_OUTSIDE_LIMITS: Rule = Rule::error(
    "default-outside-limits",
    "A default lies between the limits, with every node-ID.",
    "A default that could not be written back is most often a mistake. Code starts with 0 where there is no DefaultValue. When \
     this is silenced, the device starts with the default all the same.",
);

pub(crate) static CONST_WITHOUT_DEFAULT: Rule = Rule::firmware(
    "const-without-default",
    "A const value has a DefaultValue.",
    "It could never become anything else. When this is silenced, it is 0.",
);

pub(crate) static NODE_ID_TYPE: Rule = Rule::firmware(
    "node-id-type",
    "$NODEID goes with unsigned numbers.",
    "The node-ID is 1 to 127; it is added to COB-IDs and their like. When this is silenced, it is left out.",
);

pub(crate) static NODE_ID_ROOM: Rule = Rule::error(
    "node-id-room",
    "A default with $NODEID fits its type with every node-ID.",
    "The largest node-ID is 127. When this is silenced, the sum wraps around.",
);

pub(crate) static STRING: Rule = Rule::masters(
    "string-spelling",
    "A VISIBLE_STRING holds the characters 20h to 7Eh.",
    "Other letters have no agreed bytes on the bus. When this is silenced, they travel in UTF-8.",
)
.strict();

pub(crate) static OCTET_STRING: Rule = Rule::masters(
    "octet-string-spelling",
    "An OCTET_STRING is written as two hexadecimal digits a byte.",
    "Spaces between bytes are allowed. When this is silenced, the letters themselves are the bytes.",
).strict();

pub(crate) static CAPACITY: Rule = Rule::firmware(
    "capacity",
    "`;Capacity=` is how many bytes a string can hold.",
    "CiA 306 has no key for the room that a string has, so it stands in a comment of the section. When this is \
     silenced, the comment does not count.",
);

pub(crate) static CAPACITY_OF_NO_STRING: Rule = Rule::warning(
    "capacity-of-no-string",
    "Only strings and domains that can be written have a capacity.",
    "Everything else is as long as its type or its default.",
);

pub(crate) static CAPACITY_TOO_SMALL: Rule = Rule::firmware(
    "capacity-too-small",
    "A string has room for its default.",
    "Make `;Capacity=` larger, or the default shorter. When this is silenced, the string has room for its default.",
);

pub(crate) static VALUE_TOO_LARGE: Rule = Rule::firmware(
    "value-too-large",
    "A value has at most 65535 bytes.",
    "Descriptors hold 16-bit lengths. What is larger is a DOMAIN, which the application serves piece by piece. \
     When this is silenced, the dictionary does not have the value.",
);

pub(crate) static STORAGE: Rule = Rule::firmware(
    "storage",
    "`;Storage=` names a group.",
    "It is none, communication, application or manufacturer, and says which sub-index of 1010h stores a value: CiA \
     306 has no key for it. When this is silenced, the comment does not count.",
);

pub(crate) static STORAGE_OF_FIXED: Rule = Rule::warning(
    "storage-of-a-fixed-value",
    "Only what can be written is stored.",
    "`;Storage=` of an object that nobody can write means nothing.",
);

pub(crate) static MEMORY: Rule = Rule::firmware(
    "memory",
    "The comment ;Memory=application is in the section of a value that the application can have.",
    "The application then gives and takes it when a master reads or writes, one value at a time, and it takes no RAM: for the elements \
     of large arrays. That goes with objects from 2000h on that are not const, that no PDO carries and that 1010h does not store. When \
     this is silenced, the value is in RAM.",
);

pub(crate) static DICTIONARY_TOO_LARGE: Rule = Rule::firmware(
    "dictionary-too-large",
    "The values of a dictionary take at most 64 KiB, and their limits twice as much.",
    "Descriptors hold 16-bit offsets. When this is silenced, the application has the values that find no room, as with \
     ;Memory=application, and limits that find none are not checked.",
);

//! Rules of the sections: lists, objects, sub-indices (CiA 306, 4.5 and 4.6).

use super::Rule;

pub(crate) const RULES: &[&Rule] = &[
    &MISSING_SECTION,
    &MISSING_FILE_INFO,
    &MISSING_MANDATORY_OBJECT,
    &LIST_NUMBERING,
    &LIST_COUNT,
    &NOT_AN_INDEX,
    &LISTED_TWICE,
    &WRONG_LIST,
    &LISTED_WITHOUT_SECTION,
    &NOT_LISTED,
    &OBJECT_TYPE,
    &TYPE_DEFINITION,
    &SUB_WITHOUT_OBJECT,
    &SUBS_OF_A_VARIABLE,
    &SUB_NUMBER,
    &NO_SUB_NUMBER,
    &NO_SUB_0,
    &SUB_0_TYPE,
    &SUB_0_VALUE,
    &SUB_FF,
    &SUB_OBJECT_TYPE,
    &HEADER_KEY,
    &ARRAY_OF_MANY_TYPES,
    &COMPACT_AND_SUBS,
    &COMPACT_LIST,
    &NO_NAME,
    &PLAIN_NAME,
    &NO_MODULE,
];

pub(crate) static MISSING_SECTION: Rule = Rule::error(
    "missing-section",
    "The sections DeviceInfo and MandatoryObjects are there.",
    "CiA 306 asks for them in every file. When this is silenced, a missing section counts as empty.",
);

pub(crate) static MISSING_FILE_INFO: Rule = Rule::masters(
    "missing-file-info",
    "The section FileInfo is there.",
    "CiA 306 asks for it, and tools show it: name, version and date of the file. It says nothing about the device.",
);

pub(crate) static MISSING_MANDATORY_OBJECT: Rule = Rule::error(
    "missing-mandatory-object",
    "The objects 1000h, 1001h and 1018h are there.",
    "CiA 301 asks for them in every device.",
);

pub(crate) static LIST_NUMBERING: Rule = Rule::masters(
    "list-numbering",
    "The keys of a list are numbered from 1 on, without gaps.",
    "Some tools stop reading a list at the first gap.",
);

pub(crate) static LIST_COUNT: Rule = Rule::error(
    "list-count",
    "A list has as many entries as it says.",
    "SupportedObjects, NrOfEntries and their like count what follows. Some tools believe the number and read no \
     further. When this is silenced, everything that is listed counts.",
);

pub(crate) static NOT_AN_INDEX: Rule = Rule::error(
    "not-an-index",
    "What a list names is an index, 0x1000 to 0xFFFF.",
    "A list names the objects that have sections. When this is silenced, 1000h is the index that it means, \
     and any other line does not count.",
);

pub(crate) static LISTED_TWICE: Rule = Rule::masters(
    "listed-twice",
    "An object is listed once.",
    "Remove one of the two.",
);

pub(crate) static WRONG_LIST: Rule = Rule::masters(
    "wrong-list",
    "An object is in the list it belongs in.",
    "1000h, 1001h and 1018h are mandatory, 2000h to 5FFFh are the manufacturer's, everything else is optional (CiA \
     306, 4.5.3).",
);

pub(crate) static LISTED_WITHOUT_SECTION: Rule = Rule::error(
    "listed-without-section",
    "A listed object has a section.",
    "When this is silenced, the object does not exist.",
);

pub(crate) static NOT_LISTED: Rule = Rule::masters(
    "not-listed",
    "An object that has a section is listed.",
    "Tools that go by the lists do not see it. When this is silenced, it exists.",
)
.strict();

pub(crate) static OBJECT_TYPE: Rule = Rule::error(
    "object-type",
    "The kind of an object is one of CiA 301.",
    "ObjectType is 0x0 (NULL), 0x2 (DOMAIN), 0x5 (DEFTYPE), 0x6 (DEFSTRUCT), 0x7 (VAR), 0x8 (ARRAY) or 0x9 (RECORD); \
     without the key it is VAR. When this is silenced, a name such as VAR counts, and else an object with sub-indices is a RECORD \
     and one without is a VAR.",
);

pub(crate) static TYPE_DEFINITION: Rule = Rule::error(
    "type-definition",
    "Data types are defined below 1000h, and nothing else is.",
    "The indices 0001h to 0FFFh are for DEFTYPE and DEFSTRUCT, all others for objects.",
);

pub(crate) static SUB_WITHOUT_OBJECT: Rule = Rule::error(
    "sub-without-object",
    "A sub-index belongs to an object.",
    "The section of the object is missing. When this is silenced, the sub-index does not exist.",
);

pub(crate) static SUBS_OF_A_VARIABLE: Rule = Rule::error(
    "subs-of-a-variable",
    "A VAR has no sub-indices.",
    "Either it is an ARRAY or a RECORD, or the sections of its sub-indices are too much. They are left out when this \
     is silenced.",
);

pub(crate) static SUB_NUMBER: Rule = Rule::error(
    "sub-number",
    "SubNumber is how many sub-indices have a section.",
    "It counts sub-index 0 too. Some tools believe the number and read no further. When this is silenced, every \
     section counts.",
);

pub(crate) static NO_SUB_NUMBER: Rule = Rule::masters(
    "no-sub-number",
    "An ARRAY and a RECORD have SubNumber or CompactSubObj.",
    "Every section of a sub-index counts without it.",
);

pub(crate) static NO_SUB_0: Rule = Rule::masters(
    "no-sub-0",
    "An ARRAY and a RECORD have a sub-index 0.",
    "It is added: UNSIGNED8, const, the highest sub-index.",
);

pub(crate) static SUB_0_TYPE: Rule = Rule::error(
    "sub-0-type",
    "Sub-index 0 is UNSIGNED8.",
    "It is the highest sub-index that there is (CiA 301, 7.4.6).",
);

pub(crate) static SUB_0_VALUE: Rule = Rule::masters(
    "sub-0-value",
    "Sub-index 0 is the highest sub-index.",
    "Where it can change (1003h, PDO mappings), its default is not above the highest sub-index. Masters read it to \
     know how far to go.",
).strict();

pub(crate) static SUB_FF: Rule = Rule::error(
    "sub-ff",
    "Sub-index FFh is reserved.",
    "CiA 301 gives it to the description of the object's type; it is no value.",
);

pub(crate) static SUB_OBJECT_TYPE: Rule = Rule::masters(
    "sub-object-type",
    "A sub-index is a VAR or a DOMAIN.",
    "Objects do not nest.",
)
.strict();

pub(crate) static HEADER_KEY: Rule = Rule::masters(
    "header-key",
    "The header of an ARRAY or a RECORD has no keys of values.",
    "AccessType, DefaultValue and limits belong to the sub-indices, and so does the DataType of a RECORD; the header has them with \
     CompactSubObj alone (CiA 306, 4.6). They mean nothing.",
);

pub(crate) static ARRAY_OF_MANY_TYPES: Rule = Rule::masters(
    "array-of-many-types",
    "The elements of an ARRAY have one type.",
    "An object with elements of several types is a RECORD.",
)
.strict();

pub(crate) static COMPACT_AND_SUBS: Rule = Rule::masters(
    "compact-and-subs",
    "An object has CompactSubObj or sections of its sub-indices.",
    "With CompactSubObj all sub-indices are like the object. When this is silenced, sections of their own count for \
     those that have them.",
).strict();

pub(crate) static COMPACT_LIST: Rule = Rule::error(
    "compact-list",
    "The lists of names and values of a compact object name sub-indices that it has.",
    "`[2000Name]`, `[2000Value]` and `[2000Denotation]` go with CompactSubObj; their keys are sub-indices in decimal.",
);

pub(crate) static NO_NAME: Rule = Rule::error(
    "no-name",
    "An object and a sub-index have a ParameterName.",
    "When this is silenced, the index is the name.",
);

pub(crate) static PLAIN_NAME: Rule = Rule::warning(
    "plain-name",
    "A ParameterName has a letter A to Z or a digit.",
    "It becomes a name in code. One that is empty, or has none of these letters, becomes the index.",
);

pub(crate) static NO_MODULE: Rule = Rule::error(
    "no-module",
    "A plugged module is one that the device knows.",
    "ConnectedModules names modules by their number in SupportedModules. When this is silenced, the module is left out.",
);

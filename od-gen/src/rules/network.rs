//! Rules of a description of a network: its nodes against their data sheets and against each other.

use super::Rule;

pub(crate) const RULES: &[&Rule] = &[
    &SYNTAX,
    &SHEET,
    &NODE,
    &GUARD,
    &PDO,
    &MAPPING,
    &FROM,
    &COB_ID_CLASH,
    &WITHOUT_PRODUCER,
    &PDO_LENGTH,
    &BUS_OVERLOAD,
    &BUS_LOAD,
];

pub(crate) static SYNTAX: Rule = Rule::fatal(
    "network-syntax",
    "A description of a network is TOML with the tables [network], [sync], [master] and [[node]], or YAML with the same keys.",
    "od-gen/README.md lists the keys of each.",
);

pub(crate) static SHEET: Rule = Rule::fatal(
    "network-sheet",
    "The data sheet of each node can be read.",
    "The path is from the folder of the description. `od-gen check` says what is wrong with the data sheet itself.",
);

pub(crate) static NODE: Rule = Rule::fatal(
    "network-node",
    "Each node has a name and a node-ID of its own.",
    "Names are letters, digits, `_` and `-`, as files are called by them; `master` is the master's. Node-IDs are 1 to 127. Bit rates \
     are 10, 20, 50, 125, 250, 500, 800 and 1000 kbit/s.",
);

pub(crate) static GUARD: Rule = Rule::fatal(
    "network-heartbeat",
    "Whoever guards a heartbeat can, and the heartbeat is there.",
    "The producer has 1017h and a time above 0; the consumer has 1016h with an element that is free. A consumer waits for the producer's \
     time multiplied with heartbeat_multiplier, which is at most 65,535 ms.",
);

pub(crate) static PDO: Rule = Rule::fatal(
    "network-pdo",
    "A PDO of a node is one that its data sheet has.",
    "[node.tpdo.1] is 1800h and 1A00h. A PDO that is on has a COB-ID: that of the data sheet, `auto`, or a number.",
);

pub(crate) static MAPPING: Rule = Rule::fatal(
    "network-mapping",
    "What is mapped exists, may be mapped in this direction, and fits in a frame.",
    "Objects are named by ParameterName in small letters with underscores (`statusword`), a sub-index behind a dot \
     (`digital_outputs.physical_outputs`), or by index (`60FEh:1`); gaps by their type (`UNSIGNED8`). `od-gen doc` lists them.",
);

pub(crate) static FROM: Rule = Rule::fatal(
    "network-from",
    "A receive PDO hears a transmit PDO of another node.",
    "It is named by NODE.tpdoN, or by the name that it has.",
);

pub(crate) static COB_ID_CLASH: Rule = Rule::fatal(
    "cob-id-clash",
    "What one node sends with an identifier, no other node sends.",
    "Two frames with one identifier and different data that are sent at the same time destroy each other on the bus. SYNC, TIME, EMCY, PDOs, \
     SDO, heartbeats, NMT and LSS of all nodes are looked at. Give one of them another identifier.",
);

pub(crate) static WITHOUT_PRODUCER: Rule = Rule::warning(
    "rpdo-without-producer",
    "A receive PDO that is on is sent by somebody.",
    "The master sends those that the description lists without `from`. One that the data sheet switches on and nobody sends takes part in \
     nothing: list it, or switch it off with `enabled = false`.",
);

pub(crate) static PDO_LENGTH: Rule = Rule::fatal(
    "pdo-length",
    "A receive PDO maps as many bytes as its producer sends.",
    "Of fewer bytes than it maps a device makes nothing but emergency 8210h; of more it drops the rest (CiA 301, 7.2.2.5).",
);

pub(crate) static BUS_OVERLOAD: Rule = Rule::fatal(
    "bus-overload",
    "What is sent in any case fits on the bus.",
    "SYNC, PDOs and heartbeats are counted with all stuff bits that frames of their length can have, from the SYNC period, the event timers and \
     the times of heartbeats. SDO, emergencies and NMT need room too.",
);

pub(crate) static BUS_LOAD: Rule = Rule::warning(
    "bus-load",
    "What may be sent fits on the bus.",
    "An event-driven PDO is sent at most once in its inhibit time. Where all of them are sent that often, the lowest priorities wait.",
);

//! Rules of bindings: a file `*.bind.toml` against its data sheet and against the parameters of the drive.

use super::{Class, Rule};

pub(crate) const RULES: &[&Rule] = &[
    &SYNTAX,
    &OBJECT,
    &OBJECT_TYPE,
    &BOUND_TWICE,
    &PARAMETER,
    &ACCESS,
    &SCALE,
    &VALUES,
    &RANGE,
    &STORAGE,
    &HABIT,
    &UNBOUND,
];

pub(crate) static SYNTAX: Rule = Rule::error(
    "binding-syntax",
    "A file of bindings is TOML with the tables [[binding]], [storage], [foreign], [constants] and [habits].",
    "A binding has the keys object and parameter, and may have scale, offset, access and values; storage has the key objects. When \
     this is silenced in the data sheet, nothing is bound.",
).of(Class::Firmware);

pub(crate) static OBJECT: Rule = Rule::error(
    "binding-object",
    "A binding names a value of the data sheet, 2000h to FFFFh.",
    "Objects are named by index, with the sub-index behind a colon: 2054h, 2060h:1. When this is silenced, the binding does not count.",
).of(Class::Firmware);

pub(crate) static OBJECT_TYPE: Rule = Rule::error(
    "binding-object-type",
    "A bound object is a number.",
    "Parameters of the drive are integers: strings, times, REAL numbers and domains cannot stand for them. When this is silenced, the binding does not count.",
).of(Class::Firmware);

pub(crate) static BOUND_TWICE: Rule = Rule::error(
    "bound-twice",
    "An object stands for one parameter.",
    "Each object is bound once, and one that is at home in CiA 402 only to the parameter that is at home there. When \
     this is silenced, the first binding counts.",
).of(Class::Firmware);

pub(crate) static PARAMETER: Rule = Rule::error(
    "binding-parameter",
    "A binding names a parameter that the drive offers.",
    "The names are those of the objects of CiA 402, in lower case and with underscores: profile_velocity. When this is \
     silenced, the binding does not count.",
).of(Class::Firmware);

pub(crate) static ACCESS: Rule = Rule::error(
    "binding-access",
    "The access of a binding goes with its object and its parameter.",
    "What the drive shows (a statusword, an actual position) goes with objects that masters only read. What the drive takes \
     goes with objects that masters can write: rw follows the parameter when another object changes it, wo does not. An \
     object that masters only read may show it (ro), and a const object may fix it. When this is silenced, the binding does not count.",
).of(Class::Firmware);

pub(crate) static SCALE: Rule = Rule::error(
    "binding-scale",
    "The scale of a binding is a whole number or a fraction, and not 0.",
    "parameter = object * scale + offset, in integers: 10, \"1/10\", \"256/51200\". It does not go with a list of values. When this \
     is silenced, the binding does not count.",
).of(Class::Firmware);

pub(crate) static VALUES: Rule = Rule::error(
    "binding-values",
    "The values of a binding are numbers of the object, each with a number of the parameter.",
    "Every value is in the range of its object and in that of the parameter, the default of the object is among them, and \
     where the object shows the parameter no number of it is there twice. When this is silenced, the binding does not count.",
).of(Class::Firmware);

pub(crate) static RANGE: Rule = Rule::error(
    "binding-range",
    "The default of a bound object means something to the drive.",
    "Converted, it lies in the range of the parameter. A write that does not is refused by the device. When this is \
     silenced, the binding does not count.",
).of(Class::Firmware);

pub(crate) static STORAGE: Rule = Rule::error(
    "binding-storage",
    "The lists [storage] and [foreign] name objects or ranges of them.",
    "2100h, or 2100h-21FFh. When this is silenced, the line does not count.",
)
.of(Class::Firmware);

pub(crate) static HABIT: Rule = Rule::error(
    "binding-habit",
    "The tables [habits], [[word]] and [[error]] name what the firmware knows, with values that it can have.",
    "What a device does in the way of its maker: node_id = 65, wrong_signature = 0x08000022, maps_while_valid = true; of what facts a word is made, \
     `statusword`, `statusword 3`, `input 4`, `power`, `referenced`, `moving`, `standstill`, `mode 6`, `error 8611h`, `always`; and how it tells of an error. When this is \
     silenced, the habit does not count.",
)
.of(Class::Firmware);

pub(crate) static UNBOUND: Rule = Rule::warning(
    "unbound-object",
    "The objects of the manufacturer are bound, or listed as plain storage.",
    "An object that stands for nothing keeps what is written to it and does nothing. The list [storage] says that this is \
     meant.",
);

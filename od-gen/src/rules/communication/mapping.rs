//! Rules: the default mappings name objects that a PDO can carry, and fit in a frame (CiA 301, 7.5.2.36 and 7.5.2.38).

use crate::data_type::DataType;
use crate::diagnostic::Findings;
use crate::model::{Access, Entry, Field, Object};
use crate::rules::setting::Setting;
use crate::rules::{Rule, Subject};
use crate::source::Span;

pub(crate) const RULES: &[&Rule] = &[
    &MAPPING_GAP,
    &MAPPED_MISSING,
    &UNUSED_MAPPING,
    &MAPPED_UNMAPPABLE,
    &MAPPED_DIRECTION,
    &MAPPED_LENGTH,
    &MAPPED_TWICE,
    &MAPPING_TOO_LONG,
    &MAPPING_GRANULARITY,
    &DUMMY,
    &CONST_MAPPABLE,
];

static MAPPING_GAP: Rule = Rule::masters(
    "mapping-gap",
    "Each mapping entry that counts names an object.",
    "Up to the number in sub-index 0 the entries are used; an entry of 0 among them names nothing. A gap in a receive PDO is \
     made with a dummy, such as 0x00050008 for one byte. When this is silenced, the PDO is switched off.",
).strict();

static MAPPED_MISSING: Rule = Rule::error(
    "mapped-object-missing",
    "What is mapped exists.",
    "A mapping entry is index, sub-index and length in bits: 0x60400010. When this is silenced, the PDO is switched off until a \
     master writes another mapping.",
);

static UNUSED_MAPPING: Rule = Rule::masters(
    "unused-mapping",
    "What stands in a mapping could be mapped, also beyond the number in sub-index 0.",
    "Entries beyond sub-index 0 map nothing as the device comes. A master that only raises the number is refused by the device.",
)
.strict();

static MAPPED_UNMAPPABLE: Rule = Rule::masters(
    "mapped-object-unmappable",
    "What is mapped has PDOMapping=1.",
    "The device would refuse this mapping from a master.",
)
.strict();

static MAPPED_DIRECTION: Rule = Rule::error(
    "mapped-direction",
    "A receive PDO writes its objects, a transmit PDO reads them.",
    "ro, const and rwr go into transmit PDOs, wo and rww into receive PDOs, rw into both (CiA 306, AccessType).",
);

static MAPPED_LENGTH: Rule = Rule::error(
    "mapped-length",
    "A mapping entry has the length of its object.",
    "The last byte of the entry is the length in bits, 0x10 for 16 bits, 1 for a BOOLEAN. Of an unsigned number the low bits can \
     be mapped, unless they are whole bytes: the length of another type is most often a mistake.",
);

static MAPPED_TWICE: Rule = Rule::masters(
    "mapped-twice",
    "A PDO carries an object once.",
    "In a receive PDO the later place wins, in a transmit PDO the second one is wasted.",
);

static MAPPING_TOO_LONG: Rule = Rule::error(
    "mapping-too-long",
    "What is mapped into a PDO takes at most 64 bits.",
    "A CAN frame has eight bytes.",
);

static MAPPING_GRANULARITY: Rule = Rule::masters(
    "mapping-granularity",
    "Mapped lengths are multiples of Granularity.",
    "Granularity in DeviceInfo tells masters which lengths the device can map: 8 for whole bytes, 1 for single bits.",
);

static DUMMY: Rule = Rule::masters(
    "dummy-mapping",
    "A gap is in a receive PDO, and DummyUsage allows it.",
    "The data types 0001h to 0007h make gaps in a receive PDO, of their length, for bytes that are meant for other devices \
     (CiA 301, 7.4.7). `Dummy0005=1` in DummyUsage says that the device has them.",
).strict();

static CONST_MAPPABLE: Rule = Rule::warning(
    "const-mappable",
    "What never changes cannot be mapped.",
    "A const object in a transmit PDO wastes bus time, and in a receive PDO it could never be written.",
);

/// Bits in the eight bytes of a frame.
const FRAME_BITS: u32 = 64;

#[derive(Clone, Copy, PartialEq, Eq)]
enum Direction {
    Receive,
    Transmit,
}

impl Direction {
    fn name(self) -> &'static str {
        match self {
            Self::Receive => "receive",
            Self::Transmit => "transmit",
        }
    }
}

pub(crate) fn check(model: &Subject<'_>, findings: &mut Findings) {
    for (object, entry) in model.entries() {
        if entry.access == Access::Constant && entry.pdo_mapping {
            let message = format!(
                "{:04X}h:{:X} is const and mappable",
                object.index, entry.sub
            );
            let span = entry.places.of(Field::PdoMapping);
            let finding = findings.report(&CONST_MAPPABLE, span, message);
            finding.help("write `PDOMapping=0`, or `AccessType=ro` for what the device changes");
        }
    }
    let receive = model.objects_in(0x1600..=0x17FF).iter();
    let transmit = model.objects_in(0x1A00..=0x1BFF).iter();
    let receive = receive.map(|object| (object, Direction::Receive));
    let transmit = transmit.map(|object| (object, Direction::Transmit));
    for (object, direction) in receive.chain(transmit) {
        check_mapping(model, object, direction, findings);
    }
}

fn check_mapping(
    model: &Subject<'_>,
    object: &Object,
    direction: Direction,
    findings: &mut Findings,
) {
    let index = object.index;
    let count = object.entry(0).and_then(Setting::of);
    let used = count.map_or(0, |count| count.value);
    // A multiplexed PDO names what it carries in each frame; every other number above 64 has been reported.
    if used > 64 {
        return;
    }
    let mut bits = 0;
    let mut seen: Vec<(u32, u8, Span)> = Vec::new();
    for entry in object.entries.iter().filter(|entry| entry.sub != 0) {
        let Some(setting) = Setting::of(entry) else {
            continue;
        };
        let mapped = Mapped::of(setting.value);
        let is_used = i128::from(entry.sub) <= used;
        let place = format!("{index:04X}h:{:X}", entry.sub);
        if setting.value == 0 {
            if is_used {
                let message = format!("{place} maps nothing, but {index:04X}h:0 is {used}");
                let finding = findings.report(&MAPPING_GAP, setting.span, message);
                if let Some(count) = count {
                    finding.also(count.span, "so many are mapped");
                }
            }
            continue;
        }
        let mut found = findings.same_file();
        check_mapped(model, &mapped, direction, &place, setting.span, &mut found);
        if !is_used {
            found.all_under(&UNUSED_MAPPING);
        }
        findings.append(found);
        if !is_used {
            continue;
        }
        bits += u32::from(mapped.bits);
        let is_gap = mapped.index < 0x1000;
        if let Some((_, first, span)) = seen
            .iter()
            .find(|(value, ..)| *value == mapped.value && !is_gap)
        {
            let message = format!("{place} maps the same object as {index:04X}h:{first:X}");
            let finding = findings.report(&MAPPED_TWICE, setting.span, message);
            finding.also(*span, "the first one");
        }
        seen.push((mapped.value, entry.sub, setting.span));
    }
    if bits > FRAME_BITS {
        let message = format!("{index:04X}h maps {bits} bits, a PDO carries {FRAME_BITS}");
        let span = count.map_or(object.places.section, |count| count.span);
        findings.report(&MAPPING_TOO_LONG, span, message);
    }
}

/// A mapping entry: index, sub-index, length in bits.
struct Mapped {
    value: u32,
    index: u16,
    sub: u8,
    bits: u8,
}

impl Mapped {
    fn of(value: i128) -> Self {
        let value = u32::try_from(value).unwrap_or_default();
        let [high, low, sub, bits] = value.to_be_bytes();
        Self {
            value,
            index: u16::from_be_bytes([high, low]),
            sub,
            bits,
        }
    }
}

fn check_mapped(
    model: &Subject<'_>,
    mapped: &Mapped,
    direction: Direction,
    place: &str,
    span: Span,
    findings: &mut Findings,
) {
    let Mapped {
        value,
        index,
        sub,
        bits,
    } = *mapped;
    let what = format!("{place} maps {value:08X}h");
    let mut known = None;
    let (data_type, size) = if index < 0x1000 {
        match dummy(model, mapped, direction) {
            Ok(dummy) => dummy,
            Err(why) => {
                findings.report(&DUMMY, span, format!("{what}: {why}"));
                return;
            }
        }
    } else {
        let Some(entry) = model.entry(index, sub) else {
            if model.lacks(index, sub) {
                let message = format!("{what}: {index:04X}h:{sub:X} does not exist");
                findings.report(&MAPPED_MISSING, span, message);
            }
            return;
        };
        if !check_direction(entry, index, direction, &what, span, findings) {
            return;
        }
        known = Some(entry.places.of(Field::DataType));
        (entry.data_type, entry.size)
    };
    if !is_length_right(data_type, size, bits) {
        let length = length_of(data_type, size);
        let message = format!("{what}: {index:04X}h:{sub:X} has {length} bits, not {bits}");
        let finding = findings.report(&MAPPED_LENGTH, span, message);
        if let Some(known) = known {
            finding.also(known, "the type of the object");
        }
        finding.help(match known {
            Some(_) => format!(
                "write 0x{:08X}, or give {index:04X}h:{sub:X} a type of {bits} bits",
                value & !0xFF | length & 0xFF
            ),
            None => format!("write 0x{:08X}", value & !0xFF | length & 0xFF),
        });
        return;
    }
    check_granularity(model, mapped, &what, span, findings);
}

fn check_direction(
    entry: &Entry,
    index: u16,
    direction: Direction,
    what: &str,
    span: Span,
    findings: &mut Findings,
) -> bool {
    let (is_right, sub) = match direction {
        Direction::Receive => (entry.is_rpdo_mappable(), entry.sub),
        Direction::Transmit => (entry.is_tpdo_mappable(), entry.sub),
    };
    if is_right {
        return true;
    }
    let (name, access) = (direction.name(), entry.access.name());
    if entry.pdo_mapping {
        let message = format!(
            "{what}: {index:04X}h:{sub:X} is {access}, which does not go into a {name} PDO"
        );
        let finding = findings.report(&MAPPED_DIRECTION, span, message);
        finding.also(entry.places.of(Field::AccessType), "the object");
    } else {
        let message = format!("{what}: {index:04X}h:{sub:X} cannot be mapped");
        let finding = findings.report(&MAPPED_UNMAPPABLE, span, message);
        finding.also(entry.places.of(Field::PdoMapping), "the object");
        finding.help(format!(
            "write `PDOMapping=1` in [{index:04X}], or map another object"
        ));
    }
    false
}

fn check_granularity(
    model: &Subject<'_>,
    mapped: &Mapped,
    what: &str,
    span: Span,
    findings: &mut Findings,
) {
    let granularity = model.device.granularity;
    if granularity != 0 && !mapped.bits.is_multiple_of(granularity) {
        let bits = mapped.bits;
        let message = format!("{what}: {bits} bits are no multiple of Granularity, {granularity}");
        let finding = findings.report(&MAPPING_GRANULARITY, span, message);
        finding.also(
            model.device.places.of("Granularity"),
            "what the device can map",
        );
    }
}

/// Bits of a value in a PDO: a BOOLEAN takes one (CiA 301, 7.1.4.2).
fn length_of(data_type: DataType, size: u16) -> u32 {
    match data_type {
        DataType::Boolean => 1,
        _ => u32::from(size) * 8,
    }
}

/// Whether a value can be mapped with this length: whole, a BOOLEAN as the byte that it is in the dictionary, an unsigned number
/// with its low bits. The length in whole bytes of another type is a mistake.
fn is_length_right(data_type: DataType, size: u16, bits: u8) -> bool {
    let (whole, length) = (u32::from(size) * 8, u32::from(bits));
    let is_part = length < whole && !length.is_multiple_of(8);
    match data_type {
        DataType::Boolean => matches!(length, 1 | 8),
        _ if data_type.is_signed() || data_type.is_real() => length == whole,
        _ => length == whole || is_part,
    }
}

/// A gap in a receive PDO: the data type that names it, and its bytes.
fn dummy(
    model: &Subject<'_>,
    mapped: &Mapped,
    direction: Direction,
) -> Result<(DataType, u16), String> {
    let Mapped { index, sub, .. } = *mapped;
    let dummy = DataType::from_code(index.into())
        .and_then(|data_type| Some((data_type, data_type.size()?)))
        .filter(|_| sub == 0);
    let dummy = dummy.ok_or_else(|| format!("{index:04X}h:{sub:X} is no data type of a gap"))?;
    if direction == Direction::Transmit {
        return Err("a gap is for receive PDOs".into());
    }
    if model.dummies.contains(&index) {
        Ok(dummy)
    } else {
        Err(format!("[DummyUsage] does not allow Dummy{index:04X}"))
    }
}

//! Objects and their values, by SDO.

use master::bus::Station;
use od_gen::DataType;
use od_gen::model::{Access, DefaultValue, Entry, Limit, Model};
use tests::line::Line;

use super::{NODE, is_for_reading, is_for_writing};

const NO_OBJECT: u32 = 0x0602_0000;
const NO_SUB_INDEX: u32 = 0x0609_0011;
const READ_ONLY: u32 = 0x0601_0002;
const WRITE_ONLY: u32 = 0x0601_0001;
const IN_USE: u32 = 0x0601_0000;
/// Of objects in a mapping.
const NOT_ALTERNATED: u32 = 0x0503_0000;
const UNKNOWN_COMMAND: u32 = 0x0504_0001;
const TOO_MANY: u32 = 0x0604_0042;
const TOO_LONG: u32 = 0x0607_0012;
const TOO_SHORT: u32 = 0x0607_0013;
const TOO_HIGH: u32 = 0x0609_0031;
const TOO_LOW: u32 = 0x0609_0032;
const INVALID: u32 = 0x0609_0030;
const NO_SIGNATURE: u32 = 0x0800_0020;
const NO_DATA: u32 = 0x0800_0024;

/// A default as the device must show it.
fn bytes(data_type: DataType, value: &DefaultValue) -> Vec<u8> {
    match value {
        DefaultValue::Text(text) => text.clone(),
        DefaultValue::Real(_) => panic!("no device has a REAL"),
        DefaultValue::Number {
            value,
            adds_node_id,
        } => {
            let number = value + if *adds_node_id { i128::from(NODE) } else { 0 };
            let size = data_type.size().expect("a number").into();
            number.to_le_bytes()[..size].to_vec()
        }
    }
}

/// Every readable object is there with its size and default, and what is read-only cannot be written.
pub fn are_what_the_data_sheet_says<S: Station>(sheet: &Model, line: &mut Line<S>) {
    for (object, entry) in sheet.entries() {
        let (index, sub) = (object.index, entry.sub);
        let what = format!("{index:04X}h:{sub:02X}");
        if entry.access.is_readable() {
            // An empty history has no entries, by CiA 301.
            let read = if index == 0x1003 && sub > 0 {
                assert_eq!(line.try_read(index, sub), Err(NO_DATA), "{what}");
                None
            } else if is_for_reading(entry) {
                Some(line.read(index, sub))
            } else {
                None
            };
            if let (Some(read), Some(size)) = (&read, entry.data_type.size()) {
                assert_eq!(read.len(), usize::from(size), "{what}");
            }
            if let (Some(read), Some(default)) = (read, &entry.default) {
                assert_eq!(read, bytes(entry.data_type, default), "{what}");
            }
        } else {
            assert_eq!(line.try_read(index, sub), Err(WRITE_ONLY), "{what}");
        }
        if !entry.access.is_writable() {
            let size = entry.data_type.size().unwrap_or(1);
            let refused = line.try_write(index, sub, &vec![0; size.into()]);
            assert_eq!(refused, Err(READ_ONLY), "{what}");
        }
    }
}

/// What the data sheet does not list is not there.
pub fn are_those_of_the_data_sheet<S: Station>(sheet: &Model, line: &mut Line<S>) {
    for object in &sheet.objects {
        let subs: Vec<u8> = object.entries.iter().map(|entry| entry.sub).collect();
        for sub in (0..=255).filter(|sub| !subs.contains(sub)) {
            let missing = line.try_read(object.index, sub);
            assert_eq!(
                missing,
                Err(NO_SUB_INDEX),
                "{:04X}h:{sub:02X}",
                object.index
            );
        }
    }
    let is_there = |index: &u16| sheet.object(*index).is_some();
    for index in (0x1000..0x6800).step_by(7).filter(|index| !is_there(index)) {
        assert_eq!(line.try_read(index, 0), Err(NO_OBJECT), "{index:04X}h");
    }
}

/// A number with a byte more or less than its type is refused, and changes nothing.
pub fn have_their_length<S: Station>(sheet: &Model, line: &mut Line<S>) {
    for (object, entry) in sheet.entries().filter(|(_, entry)| is_for_writing(entry)) {
        let (index, sub) = (object.index, entry.sub);
        let Some(size) = entry.data_type.size() else {
            continue;
        };
        let what = format!("{index:04X}h:{sub:02X}");
        let longer = line.try_write(index, sub, &vec![0; usize::from(size) + 1]);
        assert_eq!(longer, Err(TOO_LONG), "{what}");
        if size > 1 {
            let shorter = line.try_write(index, sub, &vec![0; usize::from(size) - 1]);
            assert_eq!(shorter, Err(TOO_SHORT), "{what}");
        }
    }
    are_what_the_data_sheet_says(sheet, line);
}

/// What lies beyond LowLimit or HighLimit is refused. An object whose owner knows better may say so in its own word.
pub fn have_their_limits<S: Station>(sheet: &Model, line: &mut Line<S>) {
    for (object, entry) in sheet.entries().filter(|(_, entry)| is_for_writing(entry)) {
        let (index, sub) = (object.index, entry.sub);
        let Some((lowest, highest)) = entry.data_type.range() else {
            continue;
        };
        let integer = |limit: Option<Limit>| limit.and_then(Limit::integer);
        let below = integer(entry.low_limit).map(|limit| (limit - 1, TOO_LOW));
        let above = integer(entry.high_limit).map(|limit| (limit + 1, TOO_HIGH));
        for (value, code) in below.into_iter().chain(above) {
            if !(lowest..=highest).contains(&value) || outcome(sheet, index, sub).is_err() {
                continue;
            }
            let refused = line.try_write(
                index,
                sub,
                &bytes(entry.data_type, &DefaultValue::number(value)),
            );
            assert!(
                [code, INVALID, TOO_MANY].map(Err).contains(&refused),
                "{index:04X}h:{sub:02X} := {value}: {refused:08X?}"
            );
        }
    }
    are_what_the_data_sheet_says(sheet, line);
}

/// Expedited or by segments, and by blocks of one, of seven and of as many segments as there are, the same bytes come.
pub fn are_read_in_each_form<S: Station>(sheet: &Model, line: &mut Line<S>) {
    for (object, entry) in sheet.entries().filter(|(_, entry)| is_for_reading(entry)) {
        let (index, sub) = (object.index, entry.sub);
        let what = format!("{index:04X}h:{sub:02X}");
        for block_size in [1, 7, 127] {
            let before = line.try_read(index, sub);
            let by_blocks = line.block_upload(index, sub, block_size);
            // What the device measures may change in between.
            let after = line.try_read(index, sub);
            if before == after {
                assert_eq!(by_blocks, before, "{what}");
            }
        }
    }
}

/// What a write that is right by itself ends with, as the device is at power-on.
fn outcome(sheet: &Model, index: u16, sub: u8) -> Result<(), u32> {
    match index {
        // It is the signature that they take.
        0x1010 | 0x1011 if sub > 0 => Err(NO_SIGNATURE),
        // A mapping is locked while its PDO is valid, its entries while they count, even with the value that they have.
        0x1600..0x1800 | 0x1A00..0x1C00 if sub == 0 && is_valid(sheet, index - 0x200) => {
            Err(IN_USE)
        }
        0x1600..0x1800 | 0x1A00..0x1C00 if sub > 0 && count(sheet, index) > 0 => Err(IN_USE),
        0x1800..0x1A00 if sub == 6 && is_valid(sheet, index) => Err(INVALID),
        _ => Ok(()),
    }
}

/// Whether the PDO with these communication parameters is valid at power-on.
fn is_valid(sheet: &Model, index: u16) -> bool {
    let cob_id = sheet.entry(index, 1).and_then(Entry::default_number);
    cob_id.is_some_and(|cob_id| cob_id & 0x8000_0000 == 0)
}

/// How many objects are mapped at power-on.
fn count(sheet: &Model, index: u16) -> i128 {
    let count = sheet.entry(index, 0).and_then(Entry::default_number);
    count.unwrap_or(0)
}

/// A segment without a transfer, a command that there is none of, and a toggle bit that does not
/// toggle, which ends its transfer.
pub fn are_read_in_turn<S: Station>(sheet: &Model, line: &mut Line<S>) {
    for command in [0x00, 0x10, 0x60, 0x70, 0xE0, 0xFF] {
        let refused = line.ask([command, 0, 0x10, 0, 0, 0, 0, 0]);
        assert_eq!(refused, Err(UNKNOWN_COMMAND), "{command:02X}h");
    }
    let mut tried = 0;
    for (object, entry) in sheet.entries().filter(|(_, entry)| is_for_reading(entry)) {
        let (index, sub) = (object.index, entry.sub);
        if line.try_read(index, sub).is_ok_and(|value| value.len() > 4) {
            let [low, high] = index.to_le_bytes();
            assert!(line.ask([0x40, low, high, sub, 0, 0, 0, 0]).is_ok());
            let what = format!("{index:04X}h:{sub:02X}");
            for (command, code) in [(0x70, NOT_ALTERNATED), (0x60, UNKNOWN_COMMAND)] {
                let refused = line.ask([command, 0, 0, 0, 0, 0, 0, 0]);
                assert_eq!(refused, Err(code), "{what}");
            }
            tried += 1;
        }
    }
    // The I/O device has nothing that is longer than a frame.
    let has_text = sheet
        .entries()
        .any(|(_, entry)| entry.data_type == DataType::VisibleString);
    assert_eq!(tried > 0, has_text);
}

/// Every value that was read is taken back, whichever way a master writes it, and is read again.
pub fn are_written_in_each_form<S: Station>(sheet: &Model, line: &mut Line<S>) {
    for (object, entry) in sheet.entries() {
        let (index, sub) = (object.index, entry.sub);
        if !is_for_writing(entry) || !is_for_reading(entry) {
            continue;
        }
        // A DOMAIN of no bytes; an empty history.
        let Ok(value) = line.try_read(index, sub) else {
            continue;
        };
        if entry.data_type == DataType::Domain && value.is_empty() {
            continue;
        }
        let expected = outcome(sheet, index, sub);
        let what = format!("{index:04X}h:{sub:02X} := {value:02X?}");
        let mut forms = vec![
            ("with its size", line.try_write(index, sub, &value)),
            ("by segments", by_segments(line, index, sub, &value, true)),
            (
                "segments, no size",
                by_segments(line, index, sub, &value, false),
            ),
            ("by blocks", line.block_download(index, sub, &value)),
        ];
        if entry.data_type.size().is_some_and(|size| size <= 4) {
            forms.push(("without a size", without_size(line, index, sub, &value)));
        }
        for (form, result) in forms {
            assert_eq!(result, expected, "{what}, {form}");
        }
        if entry.access != Access::ReadWriteOutput {
            assert_eq!(line.read(index, sub), value, "{what}");
        }
    }
}

/// An expedited download that does not say how many of its bytes count.
fn without_size<S: Station>(
    line: &mut Line<S>,
    index: u16,
    sub: u8,
    value: &[u8],
) -> Result<(), u32> {
    let [low, high] = index.to_le_bytes();
    let mut request = [0x22, low, high, sub, 0, 0, 0, 0];
    request[4..4 + value.len()].copy_from_slice(value);
    line.ask(request).map(|_| ())
}

/// A download by segments, even of what fits into one frame.
fn by_segments<S: Station>(
    line: &mut Line<S>,
    index: u16,
    sub: u8,
    value: &[u8],
    is_size_told: bool,
) -> Result<(), u32> {
    let [low, high] = index.to_le_bytes();
    let size = if is_size_told { value.len() as u32 } else { 0 };
    let [a, b, c, d] = size.to_le_bytes();
    line.ask([0x20 | u8::from(is_size_told), low, high, sub, a, b, c, d])?;
    line.send_segments(value)
}

//! PDOs: their transmission types, what may be mapped, remote frames.

use std::ops::Range;

use canopen::{Duration, Frame};
use master::bus::Station;
use od_gen::DataType;
use od_gen::model::{Entry, Model};
use tests::line::Line;

use super::NODE;

const RECEIVE: u16 = 0x1400;
const TRANSMIT: u16 = 0x1800;
const RECEIVE_ID: u32 = 0x200 + NODE as u32;
const TRANSMIT_ID: u32 = 0x180 + NODE as u32;
const NO_REMOTE: u32 = 1 << 30;
const INVALID: u32 = 1 << 31;

const MISSING: u32 = 0x0602_0000;
const NOT_MAPPABLE: u32 = 0x0604_0041;
const INVALID_VALUE: u32 = 0x0609_0030;

/// The bits of an entry in a mapping.
fn bits(data_type: DataType) -> u32 {
    match data_type {
        DataType::Boolean => 1,
        other => u32::from(other.size().unwrap_or(0)) * 8,
    }
}

fn mapping(index: u16, entry: &Entry) -> u32 {
    u32::from(index) << 16 | u32::from(entry.sub) << 8 | bits(entry.data_type)
}

/// The communication parameters in this range that the device has.
fn pdos(sheet: &Model, indices: Range<u16>) -> Vec<u16> {
    let is_there = |index: &u16| sheet.object(*index).is_some();
    indices.filter(is_there).collect()
}

/// Every PDO of the device becomes invalid, so that what comes is the one that is tried.
fn switch_all_off<S: Station>(sheet: &Model, line: &mut Line<S>) {
    let all = pdos(sheet, 0x1400..0x1600).into_iter();
    for index in all.chain(pdos(sheet, 0x1800..0x1A00)) {
        let cob_id = line.read_u32(index, 1);
        line.write_u32(index, 1, cob_id | INVALID);
    }
}

/// The PDO carries this object alone and has this type; a transmit PDO has no timers.
fn map<S: Station>(
    sheet: &Model,
    line: &mut Line<S>,
    communication: u16,
    cob_id: u32,
    object: u32,
    transmission_type: u8,
) {
    line.write_u32(communication, 1, cob_id | INVALID);
    line.write_u8(communication + 0x200, 0, 0);
    line.write_u32(communication + 0x200, 1, object);
    line.write_u8(communication + 0x200, 0, 1);
    line.write_u8(communication, 2, transmission_type);
    for timer in [3, 5] {
        let is_writable = |entry: &Entry| entry.access.is_writable();
        if sheet.entry(communication, timer).is_some_and(is_writable) {
            line.write_u16(communication, timer, 0);
        }
    }
    line.write_u32(communication, 1, cob_id);
}

/// An object that a transmit PDO may carry, and that nothing changes while nobody writes it.
fn still_object(sheet: &Model) -> u32 {
    let is_still =
        |(_, entry): &(_, &Entry)| entry.is_tpdo_mappable() && entry.access.is_writable();
    let (object, entry) = sheet
        .entries()
        .find(is_still)
        .or_else(|| sheet.entries().find(|(_, entry)| entry.is_tpdo_mappable()))
        .expect("something to send");
    mapping(object.index, entry)
}

/// How many frames of the transmit PDO come within so many microseconds.
fn count<S: Station>(line: &mut Line<S>, microseconds: u64) -> usize {
    line.run_micros(microseconds);
    let mut count = 0;
    while let Some(frame) = line.next(Duration::from_ticks(0)) {
        count += usize::from(frame.standard_id().map(u32::from) == Some(TRANSMIT_ID));
    }
    count
}

/// How many frames of the transmit PDO follow a SYNC.
fn at_sync<S: Station>(line: &mut Line<S>) -> usize {
    line.queue("080 [0]");
    count(line, 200)
}

/// 0 to 240, 254 and 255 are there for both directions, 252 and 253 to send; the others are reserved.
pub fn types_are_those_of_the_standard<S: Station>(sheet: &Model, line: &mut Line<S>) {
    for (indices, remote) in [(0x1400..0x1600, false), (0x1800..0x1A00, true)] {
        for index in pdos(sheet, indices) {
            for transmission_type in 0..=255 {
                let expected = match transmission_type {
                    0..=240 | 254 | 255 => Ok(()),
                    252 | 253 if remote => Ok(()),
                    _ => Err(INVALID_VALUE),
                };
                let result = line.try_write(index, 2, &[transmission_type]);
                assert_eq!(result, expected, "{index:04X}h:02 := {transmission_type}");
            }
        }
    }
}

/// Type 0 once, as entering Operational is its event; 1 to 240 at each SYNC of that number; the others at no SYNC, and of them the
/// event-driven ones when Operational is entered.
pub fn is_sent_by_sync<S: Station>(sheet: &Model, line: &mut Line<S>) {
    switch_all_off(sheet, line);
    let object = still_object(sheet);
    for transmission_type in (0..=240).chain([252, 253, 254, 255]) {
        line.send(&format!("000 [2] 80 {NODE:02X}"));
        map(
            sheet,
            line,
            TRANSMIT,
            TRANSMIT_ID | NO_REMOTE,
            object,
            transmission_type,
        );
        assert_eq!(
            count(line, 2_000),
            0,
            "type {transmission_type} before Operational"
        );
        assert_eq!(
            at_sync(line),
            0,
            "type {transmission_type} before Operational"
        );
        line.send(&format!("000 [2] 01 {NODE:02X}"));
        let entered = count(line, 2_000);
        assert_eq!(
            entered,
            usize::from(transmission_type >= 254),
            "type {transmission_type} on entering Operational"
        );
        let rounds = if transmission_type > 16 { 1 } else { 3 };
        for sync in 1..=rounds * u32::from(transmission_type.min(240)).max(1) {
            let expected = match transmission_type {
                0 => sync == 1,
                1..=240 => sync % u32::from(transmission_type) == 0,
                _ => false,
            };
            let sent = at_sync(line);
            assert_eq!(
                sent,
                usize::from(expected),
                "type {transmission_type} at SYNC {sync}"
            );
        }
    }
}

/// Two values of an object that a transmit PDO may carry, that an SDO changes and nothing else: the
/// first that is found.
fn changing_object<S: Station>(
    sheet: &Model,
    line: &mut Line<S>,
) -> Option<(u16, u8, [Vec<u8>; 2])> {
    let mut entries = sheet.entries().filter(|(_, entry)| {
        entry.is_tpdo_mappable() && entry.access.is_writable() && entry.access.is_readable()
    });
    entries.find_map(|(object, entry)| {
        let (index, sub) = (object.index, entry.sub);
        let value = line.try_read(index, sub).ok()?;
        let mut other = value.clone();
        *other.first_mut()? ^= 1;
        line.try_write(index, sub, &other).ok()?;
        let is_kept = value.len() <= 4 && line.read(index, sub) == other;
        is_kept.then_some((index, sub, [value, other]))
    })
}

/// Types 254 and 255: by the event timer, and by each change, but no sooner than the inhibit time
/// is over.
pub fn is_sent_by_event<S: Station>(sheet: &Model, line: &mut Line<S>) {
    switch_all_off(sheet, line);
    let changing = changing_object(sheet, line);
    let object = match &changing {
        Some((index, sub, _)) => {
            let entry = sheet.entry(*index, *sub).expect("it was found");
            mapping(*index, entry)
        }
        None => still_object(sheet),
    };
    for transmission_type in [254, 255] {
        let try_times = |inhibit_time: u16, event_timer: u16, line: &mut Line<S>| {
            line.send(&format!("000 [2] 80 {NODE:02X}"));
            map(
                sheet,
                line,
                TRANSMIT,
                TRANSMIT_ID | NO_REMOTE,
                object,
                transmission_type,
            );
            line.write_u32(TRANSMIT, 1, TRANSMIT_ID | NO_REMOTE | INVALID);
            line.write_u16(TRANSMIT, 3, inhibit_time);
            line.write_u16(TRANSMIT, 5, event_timer);
            line.write_u32(TRANSMIT, 1, TRANSMIT_ID | NO_REMOTE);
            line.send(&format!("000 [2] 01 {NODE:02X}"));
            assert_eq!(count(line, 2_000), 1, "on entering Operational");
        };
        let what = format!("type {transmission_type}");
        try_times(0, 50, line);
        assert_eq!(count(line, 500_000), 10, "{what}, each 50 ms");
        try_times(0, 0, line);
        assert_eq!(count(line, 500_000), 0, "{what}, no timer");
        let Some((index, sub, values)) = &changing else {
            continue;
        };
        for (inhibit_time, least, most) in [(0, 100, 100), (100, 9, 11)] {
            try_times(inhibit_time, 0, line);
            let mut sent = 0;
            for change in 1..=100 {
                let value = &values[(change + 1) % 2];
                let [low, high] = index.to_le_bytes();
                let mut request = [
                    0x23 | (4 - value.len() as u8) << 2,
                    low,
                    high,
                    *sub,
                    0,
                    0,
                    0,
                    0,
                ];
                request[4..4 + value.len()].copy_from_slice(value);
                line.queue_frame(Frame::data_frame(0x600 + u16::from(NODE), &request));
                sent += count(line, 1_000);
            }
            sent += count(line, 20_000);
            assert!(
                (least..=most).contains(&sent),
                "{what}, inhibit time {inhibit_time}: {sent}"
            );
        }
    }
    // A device whose values nobody writes, as its inputs, has its timer alone.
    let has_outputs = sheet
        .entries()
        .any(|(_, entry)| entry.is_tpdo_mappable() && entry.access.is_writable());
    assert_eq!(changing.is_some(), has_outputs);
}

/// Bit 30 of the COB-ID says whether a remote frame is answered; types 252 and 253 live on them, whatever it says.
pub fn answers_remote_frames<S: Station>(sheet: &Model, line: &mut Line<S>) {
    switch_all_off(sheet, line);
    let object = still_object(sheet);
    line.start();
    for transmission_type in (0..=240).chain([252, 253, 254, 255]) {
        for forbidden in [0, NO_REMOTE] {
            map(
                sheet,
                line,
                TRANSMIT,
                TRANSMIT_ID | forbidden,
                object,
                transmission_type,
            );
            count(line, 2_000);
            line.queue(&format!("{TRANSMIT_ID:03X} [8] rtr"));
            let answers = matches!(transmission_type, 252 | 253) || forbidden == 0;
            assert_eq!(
                count(line, 2_000),
                usize::from(answers),
                "type {transmission_type}, bit 30 of {forbidden:08X}h"
            );
        }
    }
}

/// Types 0 to 240 take effect at the next SYNC, 254 and 255 at once.
pub fn is_received_by_sync<S: Station>(sheet: &Model, line: &mut Line<S>) {
    switch_all_off(sheet, line);
    // An object that keeps any value: the first that an SDO changes by one.
    let mut candidates = sheet.entries().filter(|(_, entry)| {
        entry.is_rpdo_mappable() && entry.access.is_readable() && entry.data_type.size().is_some()
    });
    let (object, entry, values) = candidates
        .find_map(|(object, entry)| {
            let value = line.try_read(object.index, entry.sub).ok()?;
            let mut other = value.clone();
            other[0] ^= 1;
            line.try_write(object.index, entry.sub, &other).ok()?;
            let is_kept = line.read(object.index, entry.sub) == other;
            is_kept.then_some((object, entry, [value, other]))
        })
        .expect("something to receive");
    line.start();
    for transmission_type in (0..=240).chain([254, 255]) {
        map(
            sheet,
            line,
            RECEIVE,
            RECEIVE_ID,
            mapping(object.index, entry),
            transmission_type,
        );
        line.write(object.index, entry.sub, &values[0]);
        let bytes: Vec<String> = values[1].iter().map(|byte| format!("{byte:02X}")).collect();
        line.send(&format!(
            "{RECEIVE_ID:03X} [{}] {}",
            bytes.len(),
            bytes.join(" ")
        ));
        line.run_millis(2);
        let at_once = line.read(object.index, entry.sub);
        assert_eq!(
            at_once,
            values[usize::from(transmission_type >= 254)],
            "type {transmission_type} before SYNC"
        );
        line.send("080 [0]");
        line.run_millis(2);
        let behind_sync = line.read(object.index, entry.sub);
        assert_eq!(
            behind_sync, values[1],
            "type {transmission_type} behind SYNC"
        );
    }
}

/// Every object is mapped each way or refused as PDOMapping and AccessType say; what is sent is what an SDO reads.
pub fn objects_are_mapped<S: Station>(sheet: &Model, line: &mut Line<S>) {
    switch_all_off(sheet, line);
    for communication in [RECEIVE, TRANSMIT] {
        line.write_u8(communication + 0x200, 0, 0);
    }
    line.start();
    let mut sent = 0;
    for (object, entry) in sheet.entries() {
        let what = format!("{:04X}h:{:02X}", object.index, entry.sub);
        let number = mapping(object.index, entry);
        for (communication, is_mappable) in [
            (RECEIVE, entry.is_rpdo_mappable()),
            (TRANSMIT, entry.is_tpdo_mappable()),
        ] {
            line.write_u32(communication, 1, TRANSMIT_ID | INVALID);
            line.write_u8(communication + 0x200, 0, 0);
            let result = line.try_write(communication + 0x200, 1, &number.to_le_bytes());
            let expected = if is_mappable {
                Ok(())
            } else {
                Err(NOT_MAPPABLE)
            };
            assert_eq!(result, expected, "{what} in {communication:04X}h");
        }
        if !entry.is_tpdo_mappable() || !bits(entry.data_type).is_multiple_of(8) {
            continue;
        }
        line.write_u8(TRANSMIT + 0x200, 0, 1);
        line.write_u8(TRANSMIT, 2, 1);
        line.write_u32(TRANSMIT, 1, TRANSMIT_ID | NO_REMOTE);
        let before = line.try_read(object.index, entry.sub);
        line.queue("080 [0]");
        let frame = line.drain_until(
            &format!("{TRANSMIT_ID:03X} [{}] ..", bits(entry.data_type) / 8),
            20,
        );
        if before == line.try_read(object.index, entry.sub) {
            assert_eq!(Ok(frame.payload()), before.as_deref(), "{what}");
            sent += 1;
        }
    }
    assert!(sent > 0, "something was compared");
    for communication in [RECEIVE, TRANSMIT] {
        line.write_u32(communication, 1, TRANSMIT_ID | INVALID);
        line.write_u8(communication + 0x200, 0, 0);
        let missing = line.try_write(communication + 0x200, 1, &[8, 0, 0xFF, 0x5F]);
        assert_eq!(missing, Err(MISSING));
    }
}

/// A receive PDO takes the dummies that DummyUsage lists, a transmit PDO none.
pub fn dummies_are_mapped<S: Station>(sheet: &Model, line: &mut Line<S>) {
    switch_all_off(sheet, line);
    for communication in [RECEIVE, TRANSMIT] {
        line.write_u8(communication + 0x200, 0, 0);
    }
    for data_type in DataType::ALL {
        let code = data_type.code();
        let number = u32::from(code) << 16 | bits(data_type);
        if bits(data_type) == 0 {
            continue;
        }
        for communication in [RECEIVE, TRANSMIT] {
            let is_listed = communication == RECEIVE && sheet.dummies.contains(&code);
            let result = line.try_write(communication + 0x200, 1, &number.to_le_bytes());
            // CiA 301 has dummies of integers and REAL alone: no other type is an object.
            let is_refused = matches!(result, Err(NOT_MAPPABLE | MISSING));
            assert!(
                if is_listed {
                    result.is_ok()
                } else {
                    is_refused
                },
                "dummy {code:04X}h in {communication:04X}h: {result:08X?}"
            );
        }
    }
}

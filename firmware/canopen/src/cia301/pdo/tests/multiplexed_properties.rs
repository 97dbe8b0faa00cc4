//! What holds for multiplexed PDOs whatever the lists, and whatever the frames.

use std::vec::Vec;

use proptest::collection::vec;
use proptest::prelude::*;

use super::device::Device;
use super::objects::Objects;
use crate::od::{Dictionary, Entry, find, set, value};

const SOURCE: u8 = 254;
const DESTINATION: u8 = 255;

/// Objects with up to four bytes that take any value of a receive PDO, by index and highest sub-index.
const TAKERS: [(u16, u8); 9] = [
    (0x2000, 0),
    (0x2001, 0),
    (0x2002, 0),
    (0x2006, 0),
    (0x2009, 0),
    (0x200A, 0),
    (0x200B, 0),
    (0x200C, 8),
    (0x200E, 0),
];

/// Whether a receive PDO may write an object, by what the dictionary of these tests is known to have.
fn takes(index: u16, sub: u8) -> bool {
    let is_taker =
        |(taker, last): &(u16, u8)| *taker == index && sub <= *last && (*last == 0 || sub > 0);
    TAKERS.iter().any(is_taker)
        || (index == 0x2007 && sub == 0)
        || (index == 0x200F && (1..=64).contains(&sub))
        || (index == 0x2010 && (sub == 1 || sub == 4))
}

/// Whether a transmit PDO may carry an object: all that a receive PDO may write but 2006h, and some more.
fn is_sent(index: u16, sub: u8) -> bool {
    (index, sub) == (0x2005, 0)
        || (index, sub) == (0x1001, 0)
        || (index, sub) == (0x1005, 0)
        || (index, sub) == (0x1018, 1)
        || (index, sub) == (0x1018, 2)
        || (index != 0x2006 && takes(index, sub))
}

/// An object, mostly one of the device or close to it.
fn address() -> impl Strategy<Value = (u16, u8)> {
    let near = (0x1FFE_u16..0x2012, 0_u8..10);
    let many = (Just(0x200F_u16), 0_u8..70);
    prop_oneof![6 => near, 2 => many, 1 => any::<(u16, u8)>()]
}

/// An entry of a dispatcher list, in the order of its bytes from the highest: block size, the object here, the object there,
/// its node.
#[derive(Clone, Copy, Debug)]
struct Dispatched {
    block: u8,
    own: (u16, u8),
    theirs: (u16, u8),
    node_id: u8,
}

impl Dispatched {
    fn number(self) -> u64 {
        let object = |(index, sub): (u16, u8)| (u64::from(index), u64::from(sub));
        let ((own, own_sub), (theirs, their_sub)) = (object(self.own), object(self.theirs));
        u64::from(self.block) << 56
            | own << 40
            | own_sub << 32
            | theirs << 16
            | their_sub << 8
            | u64::from(self.node_id)
    }

    /// The object here that stands for this one, in numbers that do not wrap.
    fn stands_for(self, node_id: u8, (index, sub): (u16, u8)) -> Option<(u16, u8)> {
        let offset = i32::from(sub) - i32::from(self.theirs.1);
        let is_there = node_id == self.node_id
            && index == self.theirs.0
            && (0..i32::from(self.block)).contains(&offset);
        let own = u8::try_from(i32::from(self.own.1) + offset).ok()?;
        is_there.then_some((self.own.0, own))
    }
}

fn dispatched() -> impl Strategy<Value = Dispatched> {
    let block = prop_oneof![4 => 0_u8..6, 1 => any::<u8>()];
    let node_id = prop_oneof![6 => 4_u8..7, 1 => any::<u8>()];
    let theirs = prop_oneof![4 => (0x6000_u16..0x6002, 0_u8..6), 1 => any::<(u16, u8)>()];
    (block, address(), theirs, node_id).prop_map(|(block, own, theirs, node_id)| Dispatched {
        block,
        own,
        theirs,
        node_id,
    })
}

/// What a multiplexed frame holds: its first byte, an address, a value.
fn message() -> impl Strategy<Value = (u8, (u16, u8), [u8; 4])> {
    let first = prop_oneof![
        4 => prop::sample::select(&[0x80_u8, 0x84, 0x85, 0x00, 0x04, 0x05, 0x06][..]),
        1 => any::<u8>(),
    ];
    let theirs = (0x6000_u16..0x6002, 0_u8..8);
    let value = prop_oneof![2 => (0_u8..3).prop_map(|low| [low, 0, 0, 0]), 1 => any::<[u8; 4]>()];
    (first, prop_oneof![address(), theirs], value)
}

fn bytes((first, (index, sub), [a, b, c, d]): (u8, (u16, u8), [u8; 4])) -> [u8; 8] {
    let [low, high] = index.to_le_bytes();
    [first, low, high, sub, a, b, c, d]
}

/// The objects whose bytes are not the same.
fn changed(before: &Objects, after: &Objects) -> Vec<&'static Entry> {
    let entries = Objects::TABLE.entries.iter();
    entries
        .filter(|entry| value(before, entry) != value(after, entry))
        .collect()
}

/// Gives a frame to the device: it writes this object at most, with the bytes of the frame, and does so if the object takes any
/// value.
fn gives(
    device: &mut Device,
    target: Option<(u16, u8)>,
    frame: [u8; 8],
) -> Result<(), TestCaseError> {
    let target = target.filter(|(index, sub)| takes(*index, *sub));
    let before = device.objects.clone();
    let written = device.writes(0x204, &frame);
    for entry in changed(&before, &device.objects) {
        prop_assert_eq!(Some((entry.index, entry.sub)), target);
    }
    let Some((index, sub)) = target else {
        prop_assert_eq!(written, 0);
        return Ok(());
    };
    let has = device.bytes(index, sub);
    if written == 0 {
        let may_refuse = matches!(index, 0x2000 | 0x2007 | 0x2009 | 0x200F);
        prop_assert!(may_refuse, "{:04X}h:{:02X} was left out", index, sub);
    } else {
        prop_assert_eq!(written, 1);
        prop_assert_eq!(&has[..], &frame[4..4 + has.len()]);
    }
    Ok(())
}

proptest! {
    #[test]
    fn p19_in_destination_address_mode_a_frame_writes_what_it_names_and_nothing_else(
        messages in vec(message(), 1..30),
    ) {
        let mut device = Device::new();
        device.multiplex(0x1400, 0, DESTINATION).unwrap();
        device.enter_operational();
        for message in messages {
            let (first, address, _) = message;
            let is_for_us = matches!(first, 0x80 | 0x84);
            gives(&mut device, is_for_us.then_some(address), bytes(message))?;
            if !is_for_us {
                prop_assert_eq!(device.reports(), []);
            }
            device.reports();
        }
    }

    #[test]
    fn p19_in_source_address_mode_a_frame_writes_what_the_dispatcher_list_says_and_nothing_else(
        lists in vec((1_u8..3, dispatched()), 0..6),
        messages in vec(message(), 1..30),
    ) {
        let mut device = Device::new();
        device.multiplex(0x1400, 0, SOURCE).unwrap();
        device.enter_operational();
        let mut listed = [None; 2];
        for (sub, entry) in lists {
            if device.write(0x1FD0, sub, &entry.number().to_le_bytes()).is_ok() {
                listed[usize::from(sub - 1)] = Some(entry);
            }
        }
        for message in messages {
            let (first, address, _) = message;
            let own = listed.iter().flatten().find_map(|entry| {
                let own = entry.stands_for(first, address)?;
                takes(own.0, own.1).then_some(own)
            });
            gives(&mut device, own, bytes(message))?;
            prop_assert_eq!(device.reports(), [], "objects of others are no errors");
        }
    }

    /// Frames of any length, and lists that no master could have written: the application may put anything into them.
    #[test]
    fn p19_no_list_and_no_frame_writes_what_no_pdo_may(
        count in prop::sample::select(&[SOURCE, DESTINATION][..]),
        lists in vec(dispatched(), 2),
        frames in vec((message(), prop_oneof![4 => Just(8_usize), 1 => 0..8_usize]), 0..30),
    ) {
        let mut device = Device::new();
        for communication in [0x1400, 0x1800] {
            device.multiplex(communication, 0, count).unwrap();
        }
        for (sub, entry) in (1..).zip(lists) {
            let number = entry.number().to_be_bytes();
            for (index, bytes) in [(0x1FD0, &number[..]), (0x1FA0, &number[..4])] {
                let little_endian: Vec<u8> = bytes.iter().rev().copied().collect();
                let list = find::<Objects>(index, sub).unwrap();
                set(&mut device.objects, list, &little_endian).unwrap();
            }
        }
        device.enter_operational();
        for (message, length) in frames {
            let before = device.objects.clone();
            device.frame(0x204, &bytes(message)[..length]);
            for entry in changed(&before, &device.objects) {
                prop_assert!(takes(entry.index, entry.sub));
                prop_assert_eq!(length, 8);
            }
            device.reports();
            for (cob_id, bytes) in device.after(1) {
                prop_assert_eq!((cob_id, bytes.len()), (0x184, 8));
                prop_assert!(is_sent(u16::from_le_bytes([bytes[1], bytes[2]]), bytes[3]));
            }
        }
    }

    /// A scan sends the objects of the lists in their order, with their values, and those that are not there it leaves out.
    #[test]
    fn a_scan_sends_what_the_scanner_list_says_and_nothing_else(
        lists in vec((prop_oneof![4 => 0_u8..6, 1 => any::<u8>()], address()), 2),
        values in any::<[u8; 8]>(),
    ) {
        let mut device = Device::new();
        device.multiplex(0x1800, 0, SOURCE).unwrap();
        for (sub, byte) in (1..).zip(values) {
            device.write(0x200C, sub, &[byte]).unwrap();
        }
        let mut expected = Vec::new();
        for (number, (block, (index, sub))) in (1..).zip(lists) {
            let entry = u32::from(block) << 24 | u32::from(index) << 8 | u32::from(sub);
            if device.write_u32(0x1FA0, number, entry).is_ok() {
                let subs = (0..block).filter_map(|offset| sub.checked_add(offset));
                expected.extend(subs.filter(|sub| is_sent(index, *sub)).map(|sub| (index, sub)));
            }
        }
        device.enter_operational();
        let mut sent = Vec::new();
        for _ in 0..600 {
            for (cob_id, frame) in device.after(1) {
                prop_assert_eq!((cob_id, frame.len(), frame[0]), (0x184, 8, 4));
                let (index, sub) = (u16::from_le_bytes([frame[1], frame[2]]), frame[3]);
                let mut bytes = device.bytes(index, sub);
                bytes.resize(4, 0);
                prop_assert_eq!(&frame[4..], &bytes[..]);
                sent.push((index, sub));
            }
        }
        prop_assert_eq!(sent, expected);
    }
}

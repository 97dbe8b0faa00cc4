use std::collections::BTreeMap;
use std::vec;
use std::vec::Vec;

use proptest::prelude::*;

use super::{Mailbox, Mailboxes, Outbox, Pending, Sender};
use crate::Frame;

/// Identifiers below are process data, those above are not.
const PROCESS_DATA: u16 = 0x500;

/// A PDO that answers a SYNC of the device.
const SYNCHRONOUS: u16 = 0x1FF;
const SYNC: u16 = 0x4FF;

/// Frames that wait in a device: of process data the newest, of everything else all, in their order.
#[derive(Default)]
struct Device {
    waiting: BTreeMap<u16, Vec<u8>>,
}

impl Device {
    fn put(&mut self, cob_id: u16, value: u8) {
        let values = self.waiting.entry(cob_id).or_default();
        if cob_id < PROCESS_DATA {
            values.clear();
        }
        values.push(value);
    }
}

impl Sender for Device {
    fn pending(&self) -> Option<Pending> {
        let cob_id = *self.waiting.keys().next()?;
        Some(Pending {
            place: 0,
            cob_id,
            is_process_data: cob_id < PROCESS_DATA,
            follows: (cob_id == SYNCHRONOUS).then_some(SYNC),
        })
    }

    fn take(&mut self, _: &Pending) -> Option<Frame> {
        let mut first = self.waiting.first_entry()?;
        let value = first.get_mut().remove(0);
        let frame = Frame::data_frame(*first.key(), &[value]);
        if first.get().is_empty() {
            first.remove();
        }
        Some(frame)
    }
}

/// The mailboxes of bxCAN: a frame gets one only if it goes before everything that waits there.
#[derive(Default)]
struct Controller {
    mailboxes: Vec<(u16, u8)>,
}

impl Controller {
    /// The bus is free: the most urgent frame leaves.
    fn leave(&mut self) -> Option<(u16, u8)> {
        let first = self.mailboxes.iter().min().copied()?;
        self.mailboxes.retain(|frame| *frame != first);
        Some(first)
    }
}

impl Mailboxes for Controller {
    fn mailbox_for(&mut self, cob_id: u16) -> Mailbox {
        if self.mailboxes.iter().any(|(waiting, _)| *waiting <= cob_id) {
            Mailbox::None
        } else if self.mailboxes.len() == 3 {
            Mailbox::InPlaceOfAnother
        } else {
            Mailbox::Free
        }
    }

    fn holds(&mut self, cob_id: u16) -> bool {
        self.mailboxes.iter().any(|(waiting, _)| *waiting == cob_id)
    }

    fn put(&mut self, frame: &Frame) -> Option<Frame> {
        let cob_id = frame.standard_id().unwrap();
        assert_ne!(self.mailbox_for(cob_id), Mailbox::None, "there is no room");
        let back = if self.mailboxes.len() == 3 {
            let last = self.mailboxes.iter().max().copied().unwrap();
            self.mailboxes.retain(|frame| *frame != last);
            Some(Frame::data_frame(last.0, &[last.1]))
        } else {
            None
        };
        self.mailboxes.push((cob_id, frame.payload()[0]));
        back
    }
}

#[derive(Default)]
struct Bench {
    device: Device,
    outbox: Outbox<3>,
    controller: Controller,
}

impl Bench {
    fn put(&mut self, cob_id: u16, value: u8) {
        self.device.put(cob_id, value);
        self.send();
    }

    fn send(&mut self) {
        self.outbox.send(&mut self.device, &mut self.controller);
    }

    /// Everything leaves, in this order.
    fn drain(&mut self) -> Vec<(u16, u8)> {
        let mut left = Vec::new();
        while let Some(frame) = self.controller.leave() {
            left.push(frame);
            self.send();
        }
        assert_eq!(self.device.pending(), None);
        assert!(self.outbox.waiting.iter().all(Option::is_none));
        left
    }
}

#[test]
fn a_pdo_does_not_overtake_the_sync_that_it_answers() {
    for urgent in 0..4 {
        let mut bench = Bench::default();
        bench.put(SYNC, 1);
        // They may make SYNC wait for a mailbox once more.
        for number in 0..urgent {
            bench.put(3 - number, 0);
        }
        bench.put(SYNCHRONOUS, 2);
        let left = bench.drain();
        assert_eq!(left[left.len() - 2..], [(SYNC, 1), (SYNCHRONOUS, 2)]);
    }
}

#[test]
fn an_urgent_frame_takes_the_place_of_another_which_is_not_lost() {
    let mut bench = Bench::default();
    for cob_id in [0x584, 0x583, 0x582, 0x84] {
        bench.put(cob_id, 1);
    }
    assert_eq!(bench.controller.leave(), Some((0x84, 1)));
    assert_eq!(bench.drain(), [(0x582, 1), (0x583, 1), (0x584, 1)]);
}

#[test]
fn process_data_that_had_to_make_way_leaves_with_the_newest_values() {
    let mut bench = Bench::default();
    for cob_id in [0x484, 0x384, 0x284, 0x184] {
        bench.put(cob_id, 1);
    }
    assert_eq!(bench.outbox.first(), Some((0, 0x484)));
    bench.put(0x484, 2);
    bench.put(0x484, 3);
    assert_eq!(
        bench.drain(),
        [(0x184, 1), (0x284, 1), (0x384, 1), (0x484, 3)]
    );
}

#[test]
fn process_data_waits_in_the_device_for_a_mailbox() {
    let mut bench = Bench::default();
    // One is in a mailbox, and no second one with its identifier.
    for value in 1..=5 {
        bench.put(0x184, value);
    }
    assert_eq!(bench.drain(), [(0x184, 1), (0x184, 5)]);
}

#[test]
fn messages_are_sent_one_and_all() {
    let mut bench = Bench::default();
    bench.put(0x584, 1);
    for (cob_id, value) in [(0x584, 2), (0x583, 1), (0x582, 1), (0x581, 1), (0x584, 3)] {
        bench.put(cob_id, value);
    }
    assert_eq!(
        bench.drain(),
        [
            (0x581, 1),
            (0x582, 1),
            (0x583, 1),
            (0x584, 1),
            (0x584, 2),
            (0x584, 3)
        ]
    );
}

#[test]
fn when_all_places_are_taken_nothing_has_to_make_way() {
    let mut bench = Bench::default();
    // Three in mailboxes, three here; the seventh waits in the device though it is the most urgent.
    for cob_id in [0x587, 0x586, 0x585, 0x584, 0x583, 0x582, 0x581] {
        bench.put(cob_id, 1);
    }
    assert!(bench.outbox.is_full());
    assert_eq!(bench.device.pending().unwrap().cob_id, 0x581);
    assert_eq!(bench.controller.leave(), Some((0x582, 1)));
    bench.send();
    let left: Vec<u16> = bench
        .drain()
        .into_iter()
        .map(|(cob_id, _)| cob_id)
        .collect();
    assert_eq!(left, [0x581, 0x583, 0x584, 0x585, 0x586, 0x587]);
}

#[test]
fn what_waits_is_void_after_a_reset() {
    let mut bench = Bench::default();
    for cob_id in [0x584, 0x583, 0x582, 0x581] {
        bench.put(cob_id, 1);
    }
    bench.outbox.clear();
    assert_eq!(bench.drain(), [(0x581, 1), (0x582, 1), (0x583, 1)]);
}

proptest! {
    /// Whatever comes in whatever order while frames leave at any time: messages leave one and all in their order, process data
    /// never goes back in time and ends with the newest value, and nothing waits for ever.
    #[test]
    fn nothing_is_lost_and_nothing_old_follows_the_new(
        steps in prop::collection::vec((0..12_u16, any::<bool>()), 1..200)
    ) {
        let mut bench = Bench::default();
        let mut put: BTreeMap<u16, Vec<u8>> = BTreeMap::new();
        let mut left: BTreeMap<u16, Vec<u8>> = BTreeMap::new();
        let mut leave = |frame: Option<(u16, u8)>| {
            if let Some((cob_id, value)) = frame {
                left.entry(cob_id).or_default().push(value);
            }
        };
        for (number, (object, leaves)) in (0..).zip(&steps) {
            let cob_id = 0x481 + object * 0x15;
            put.entry(cob_id).or_default().push(number);
            bench.put(cob_id, number);
            if *leaves {
                leave(bench.controller.leave());
                bench.send();
            }
        }
        bench.drain().into_iter().for_each(|frame| leave(Some(frame)));
        for (cob_id, values) in put {
            let sent = left.remove(&cob_id).unwrap_or(vec![]);
            if cob_id < PROCESS_DATA {
                prop_assert!(sent.is_sorted_by(|a, b| a < b), "{cob_id:03X}: {sent:?}");
                prop_assert_eq!(sent.last(), values.last());
            } else {
                prop_assert_eq!(sent, values);
            }
        }
        prop_assert!(left.is_empty());
    }
}

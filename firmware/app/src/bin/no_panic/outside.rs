//! What the device meets outside: a parameter store and mailboxes that may say anything.

use canopen::cia301::parameters::{ParameterSet, ParameterSets, ParameterStore, CHUNK};
use canopen::node::StoreError;
use canopen::outbox::{Mailbox, Mailboxes};
use canopen::Frame;

use super::{any, any_frame, any_result, look};

/// A parameter store that may say anything.
pub struct AnyStore;

impl ParameterStore for AnyStore {
    fn keep_serial_number(&mut self, number: u32) -> Result<(), StoreError> {
        look(number);
        any_result()
    }

    fn begin(&mut self, sets: ParameterSets) -> Result<(), StoreError> {
        look(sets.has(ParameterSet::Communication).into());
        any_result()
    }

    fn append(&mut self, set: ParameterSet, chunk: &[u8]) -> Result<(), StoreError> {
        look(set as u32 + chunk.len() as u32);
        chunk.iter().for_each(|byte| look((*byte).into()));
        any_result()
    }

    fn commit(&mut self) -> Result<(), StoreError> {
        any_result()
    }

    fn open(&mut self, set: ParameterSet) -> Result<u16, StoreError> {
        look(set as u32);
        any_result().map(|()| any() as u16)
    }

    fn read(
        &mut self,
        set: ParameterSet,
        number: u16,
        chunk: &mut [u8; CHUNK],
    ) -> Result<usize, StoreError> {
        look(set as u32 + u32::from(number));
        for byte in chunk.iter_mut() {
            *byte = any() as u8;
        }
        any_result().map(|()| any() as usize)
    }
}

/// Mailboxes that may say anything.
pub struct AnyMailboxes;

impl Mailboxes for AnyMailboxes {
    fn mailbox_for(&mut self, cob_id: u16) -> Mailbox {
        look(cob_id.into());
        match any() {
            0 => Mailbox::None,
            1 => Mailbox::Free,
            _ => Mailbox::InPlaceOfAnother,
        }
    }

    fn holds(&mut self, cob_id: u16) -> bool {
        look(cob_id.into());
        any() == 0
    }

    fn put(&mut self, frame: &Frame) -> Option<Frame> {
        look(frame.length().into());
        (any() == 0).then(any_frame)
    }
}

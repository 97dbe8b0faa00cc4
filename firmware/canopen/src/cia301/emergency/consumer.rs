//! The emergency consumer (CiA 301, 7.5.2.31; object 1028h): the errors of other devices, handed to the firmware.
//!
//! Each sub-index has the COB-ID of one other device, bit 31 set while it is not listened to. A message has eight bytes; anything
//! else is ignored.

use crate::od::{self, Dictionary};
use crate::wire::Frame;
use crate::wire::cob_id::CobId;

/// Index of the emergency consumers.
pub const CONSUMER_INDEX: u16 = 0x1028;

/// An error that another device tells of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReceivedEmergency {
    /// The sub-index of 1028h that listens to it: by CiA 301 the node-ID of the other device.
    pub consumer: u8,
    /// Emergency error code; 0000h: an error is gone.
    pub code: u16,
    /// The error register 1001h of the other device.
    pub register: u8,
    /// Manufacturer-specific bytes.
    pub info: [u8; 5],
}

/// The identifiers that are listened to, with their sub-indices.
pub fn consumed<D: Dictionary>(dictionary: &D) -> impl Iterator<Item = (u16, u8)> {
    let entries = D::TABLE.range(CONSUMER_INDEX..=CONSUMER_INDEX).iter();
    entries.filter_map(|entry| {
        let value = od::value(dictionary, entry).try_into().ok()?;
        let cob_id = CobId(u32::from_le_bytes(value));
        let is_used = cob_id.is_valid() && cob_id.is_base_frame();
        is_used.then(|| (cob_id.identifier(), entry.sub))
    })
}

/// Reads a message with this identifier; `None` if it is not one that is listened to.
pub fn receive<D: Dictionary>(
    dictionary: &D,
    cob_id: u16,
    frame: &Frame,
) -> Option<ReceivedEmergency> {
    let &[low, high, register, ref info @ ..] = frame.full_payload()?;
    let (_, consumer) = consumed(dictionary).find(|(listened, _)| *listened == cob_id)?;
    Some(ReceivedEmergency {
        consumer,
        code: u16::from_le_bytes([low, high]),
        register,
        info: *info,
    })
}

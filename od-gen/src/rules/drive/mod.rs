//! Rules of the drive profile, CiA 402. They hold for each axis of a device that claims the profile.

pub(super) mod modes;
pub(super) mod objects;
pub(super) mod units;
pub(super) mod values;

use super::setting::number;
use crate::model::Model;

/// Indices from one axis to the next.
const AXIS: u16 = 0x800;

/// Whether 1000h claims CiA 402.
pub(super) fn is_drive(model: &Model) -> bool {
    number(model, 0x1000, 0).is_some_and(|device_type| device_type & 0xFFFF == 402)
}

/// What is added to an index of the first axis for each axis of the device: the first one, and those that have a controlword or
/// a statusword.
fn axes(model: &Model) -> impl Iterator<Item = u16> {
    let count = if is_drive(model) { 8 } else { 0 };
    (0..count).map(|axis| axis * AXIS).filter(|offset| {
        let has = |index| model.object(index + offset).is_some();
        *offset == 0 || has(0x6040) || has(0x6041)
    })
}

/// The index that an object of any axis has on the first one.
pub(super) fn on_first_axis(model: &Model, index: u16) -> Option<u16> {
    let offset = index.checked_sub(0x6000)?;
    let own = 0x6000 + offset % AXIS;
    axes(model).any(|axis| own + axis == index).then_some(own)
}

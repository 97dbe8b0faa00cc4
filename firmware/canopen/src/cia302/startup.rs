//! NMT start-up (CiA 302-2, object 1F80h): whether a device becomes Operational by itself.
//!
//! Bit 2 is 0 for a device that starts itself after its boot-up message, and 1 for one that waits for the NMT master. It counts
//! at the next boot. All other bits are about being the NMT master, which this device is not: they cannot be set. A device without 1F80h
//! waits.

use crate::cia301::sdo::AbortCode;
use crate::od::{self, Dictionary};

/// Index of the NMT start-up object.
pub const INDEX: u16 = 0x1F80;

/// Bit 2: wait for the NMT master.
const WAIT: u32 = 1 << 2;

/// Whether the device becomes Operational by itself.
pub fn starts_itself<D: Dictionary>(dictionary: &D) -> bool {
    od::fixed::<D, INDEX, 0>(dictionary).is_some_and(|startup| startup & WAIT == 0)
}

/// Whether 1F80h may get this value. Called when it has passed the dictionary's own checks.
///
/// # Errors
/// [`AbortCode::InvalidValue`]: a bit other than bit 2.
pub fn validate(value: &[u8]) -> Result<(), AbortCode> {
    let value = value.try_into().map_or(0, u32::from_le_bytes);
    if value & !WAIT == 0 {
        Ok(())
    } else {
        Err(AbortCode::InvalidValue)
    }
}

//! The memory of the streamed objects: 2020h "User memory" and 20D3h "Scope data". The board says how much; what the data sheet does not list
//! has none.

use canopen::od::Dictionary as _;
use cia402::recorder::Memory;

use crate::board::{Board, Selected};
use crate::dictionary::Dictionary;

/// The longest value of 2020h, in bytes.
pub const USER_MEMORY: usize = if_listed(runtime::USER_MEMORY, Selected::USER_MEMORY);

/// Words of samples.
pub const SCOPE_WORDS: usize = if_listed(runtime::SCOPE_DATA, Selected::SCOPE_WORDS);

/// The bytes of one value of 2020h.
pub type UserMemory = &'static mut [u8; USER_MEMORY];

/// The application of the firmware.
pub type Machine = runtime::Machine<UserMemory, &'static Memory>;

/// The size, if the data sheet lists the object.
const fn if_listed(index: u16, size: usize) -> usize {
    if runtime::is_listed(Dictionary::TABLE, index) {
        size
    } else {
        0
    }
}

//! The identifiers of the servers: SDO server parameters 1200h to 127Fh (CiA 301, 7.5.2.33).
//!
//! The default server, 1200h, has the identifiers of the predefined connection set. The others are off until both of
//! their identifiers, sub-index 1 for requests and sub-index 2 for answers, are valid; a change counts at once.

use super::AbortCode;
use crate::od::{Dictionary, Entry, read_u32};
use crate::settings::NodeId;
use crate::wire::cob_id::{self, CobId, is_restricted};

/// The object of the first server.
const FIRST: u16 = 0x1200;
/// COB-ID from client to server.
const REQUEST: u8 = 1;
/// COB-ID from server to client.
const RESPONSE: u8 = 2;

/// Bit 30: the identifier was assigned for a while, by an SDO manager.
const DYNAMIC: u32 = 1 << 30;

/// The identifiers of a server.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct CobIds {
    pub(crate) request: u16,
    pub(crate) response: u16,
}

impl CobIds {
    /// Those of the default server.
    pub(super) const fn predefined(node_id: NodeId) -> Self {
        Self {
            request: cob_id::sdo_request(node_id),
            response: cob_id::sdo_response(node_id),
        }
    }

    /// Those of another server; `None` while it is off.
    pub(super) fn of<D: Dictionary>(dictionary: &D, number: u16) -> Option<Self> {
        let index = FIRST.saturating_add(number);
        Some(Self {
            request: identifier(dictionary, index, REQUEST)?,
            response: identifier(dictionary, index, RESPONSE)?,
        })
    }
}

/// The identifier at a sub-index, if it is valid.
fn identifier<D: Dictionary>(dictionary: &D, index: u16, sub: u8) -> Option<u16> {
    let cob_id = CobId(read_u32(dictionary, index, sub)?);
    (cob_id.is_valid() && cob_id.is_base_frame()).then(|| cob_id.identifier())
}

/// Whether an object of 1200h to 127Fh may get this value, which has passed the dictionary's own checks; nothing changes.
///
/// # Errors
/// [`AbortCode::InvalidValue`]: a 29-bit or dynamic identifier (bits 29 and 30), a restricted one, the one that the server has
/// for the other direction, or another one while the server is on.
pub(crate) fn validate<D: Dictionary>(
    dictionary: &D,
    entry: &Entry,
    value: &[u8],
) -> Result<(), AbortCode> {
    let other = match entry.sub {
        REQUEST => RESPONSE,
        RESPONSE => REQUEST,
        _ => return Ok(()),
    };
    let Ok(value) = value.try_into() else {
        return Err(AbortCode::LengthMismatch);
    };
    let new = CobId(u32::from_le_bytes(value));
    let present = identifier(dictionary, entry.index, entry.sub);
    let opposite = identifier(dictionary, entry.index, other);
    let is_moved = opposite.is_some() && present.is_some_and(|present| present != new.identifier());
    let is_taken = is_restricted(new.identifier()) || opposite == Some(new.identifier());
    let is_unknown = !new.is_base_frame() || new.0 & DYNAMIC != 0;
    if is_unknown || new.is_valid() && (is_moved || is_taken) {
        Err(AbortCode::InvalidValue)
    } else {
        Ok(())
    }
}

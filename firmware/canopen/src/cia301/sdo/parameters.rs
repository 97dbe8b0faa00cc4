//! The identifiers of the servers: SDO server parameters 1200h to 127Fh (CiA 301, 7.5.2.33).
//!
//! The default server, 1200h, has the identifiers of the predefined connection set. The others are off until both of
//! their identifiers, sub-index 1 for requests and sub-index 2 for answers, are valid; a change counts at once.

use super::AbortCode;
use crate::cia301::cob_ids;
use crate::od::{Dictionary, Entry, read_u32};
use crate::settings::NodeId;
use crate::wire::cob_id::{self, CobId};

/// The object of the first server.
const FIRST: u16 = 0x1200;
/// COB-ID from client to server.
const REQUEST: u8 = 1;
/// COB-ID from server to client.
const RESPONSE: u8 = 2;

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
    if !matches!(entry.sub, REQUEST | RESPONSE) {
        return Ok(());
    }
    let other = REQUEST + RESPONSE - entry.sub;
    let opposite = identifier(dictionary, entry.index, other);
    let wanted = CobId(value.try_into().map_or(CobId::INVALID, u32::from_le_bytes));
    if wanted.is_valid() && opposite == Some(wanted.identifier()) {
        return Err(AbortCode::InvalidValue);
    }
    cob_ids::validate(dictionary, entry, value, opposite.is_some())
}

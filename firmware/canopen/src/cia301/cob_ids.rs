//! The rules of the objects that hold a COB-ID, as data: which bits are what, and when the identifier may change.
//!
//! | object | in use while | may not be 1 | identifier, while in use |
//! |---|---|---|---|
//! | 1005h | bit 30 is 1 | bits 11 to 29 | stays, even in the write that ends it |
//! | 1012h | bit 30 or 31 is 1 | bits 11 to 29 | stays |
//! | 1014h, 1028h, 1200h to 127Fh | bit 31 is 0 | bits 11 to 30 | stays |
//! | 1400h, 1800h and up | bit 31 is 0 | bits 11 to 29 | stays |
//!
//! No transmit PDO has an identifier that the device uses for SYNC, TIME, EMCY or SDO, whichever of both is written: 06090030h, too.
//!
//! No identifier is a restricted one (CiA 301, table 40); what is switched off by bit 31 may hold any. A server of 1200h to 127Fh is
//! in use while both of its identifiers are, so one of them may change while the other one is off.

use super::sdo::AbortCode;
use crate::od::{Dictionary, Entry, raw, raw_of};
use crate::wire::cob_id::{CobId, is_restricted};

/// The rule of one object.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rule {
    /// The bits that say whether the service is in use: 1 for yes, if they are not inverted.
    in_use: u32,
    /// Those of them that are 1 for no.
    inverted: u32,
    /// Bits that may not be 1.
    zero: u32,
    /// The identifier of a write that switches off may be another one.
    moves_when_off: bool,
}

const BIT_30: u32 = 1 << 30;
const BIT_31: u32 = 1 << 31;
/// The bits of a 29-bit identifier, and the one that says that it is one.
const EXTENDED: u32 = 0x3FFF_F800;

impl Rule {
    const SYNC: Self = Self {
        in_use: BIT_30,
        inverted: 0,
        zero: EXTENDED,
        moves_when_off: false,
    };
    const TIME: Self = Self {
        in_use: BIT_30 | BIT_31,
        inverted: 0,
        zero: EXTENDED,
        moves_when_off: true,
    };
    const SERVICE: Self = Self {
        in_use: BIT_31,
        inverted: BIT_31,
        zero: EXTENDED | BIT_30,
        moves_when_off: true,
    };
    const PDO: Self = Self {
        zero: EXTENDED,
        ..Self::SERVICE
    };

    /// That of an object; `None` if it holds no COB-ID.
    #[inline(never)]
    pub(crate) const fn of(entry: &Entry) -> Option<&'static Self> {
        match (entry.index, entry.sub) {
            (0x1005, _) => Some(&Self::SYNC),
            (0x1012, _) => Some(&Self::TIME),
            (0x1014, _) | (0x1028, 1..) | (0x1200..=0x127F, 1 | 2) => Some(&Self::SERVICE),
            (0x1400..=0x15FF | 0x1800..=0x19FF, 1) => Some(&Self::PDO),
            _ => None,
        }
    }

    const fn is_used(&self, cob_id: u32) -> bool {
        (cob_id ^ self.inverted) & self.in_use != 0
    }

    /// The same COB-ID, switched off.
    pub(crate) const fn switched_off(&self, cob_id: u32) -> u32 {
        cob_id & !self.in_use | self.inverted
    }

    /// Whether a service may get another COB-ID; it counts as in use only if `is_on`.
    const fn allows(&self, present: u32, wanted: u32, is_on: bool) -> bool {
        let (from, to) = (CobId(present).identifier(), CobId(wanted).identifier());
        let is_off = !self.is_used(wanted);
        let may_be_any = is_off && self.inverted != 0;
        let stays = is_on && self.is_used(present) && !(is_off && self.moves_when_off);
        wanted & self.zero == 0 && (may_be_any || !is_restricted(to)) && (from == to || !stays)
    }
}

/// Whether an object that holds a COB-ID may get this value, which has passed the dictionary's own checks; others may. `is_on` is
/// false for a service that is not in use for another reason.
///
/// # Errors
/// [`AbortCode::InvalidValue`]: the rule of the object does not allow it.
#[inline(never)]
pub(crate) fn validate<D: Dictionary>(
    dictionary: &D,
    entry: &Entry,
    new: &[u8],
    is_on: bool,
) -> Result<(), AbortCode> {
    let Some(rule) = Rule::of(entry) else {
        return Ok(());
    };
    match (raw_of(dictionary, entry), number(new)) {
        (Some(present), Some(new)) if rule.allows(present, new, is_on) => Ok(()),
        (Some(_), Some(_)) => Err(AbortCode::InvalidValue),
        _ => Err(AbortCode::LengthMismatch),
    }
}

/// A COB-ID as it was sent.
fn number(bytes: &[u8]) -> Option<u32> {
    bytes.try_into().ok().map(u32::from_le_bytes)
}

/// Whether this value would give a transmit PDO and another service of the device the same identifier. Two transmit PDOs may have the
/// same one.
#[cold]
#[inline(never)]
pub(crate) fn is_taken<D: Dictionary>(dictionary: &D, entry: &Entry, new: &[u8]) -> bool {
    let Some(new) = number(new).filter(|new| is_sent(entry, *new)) else {
        return false;
    };
    let is_same = |cob_id: &u32| CobId(*cob_id).identifier() == CobId(new).identifier();
    let takes = |other: &Entry| {
        let cob_id = raw(dictionary, other).filter(is_same);
        cob_id.is_some_and(|cob_id| is_sent(other, cob_id))
    };
    let others = match entry.index {
        TRANSMIT_PDO.. => 0x1005..=0x127F,
        _ => TRANSMIT_PDO..=0x19FF,
    };
    D::TABLE.range(others).iter().any(takes)
}

/// The communication parameter of the first transmit PDO.
const TRANSMIT_PDO: u16 = 0x1800;

/// Whether an object with this value makes the device send its identifier, or the clients of its
/// SDO server.
fn is_sent(entry: &Entry, cob_id: u32) -> bool {
    let is_heard_only = matches!(entry.index, 0x1028 | 0x1400..=0x17FF);
    // Whoever follows SYNC, must not send it as something else.
    let is_used = |rule: &Rule| rule.is_used(cob_id) || entry.index == 0x1005;
    !is_heard_only && CobId(cob_id).is_base_frame() && Rule::of(entry).is_some_and(is_used)
}

//! What a master may write to the objects of the emergency producer: 1003h, 1014h, 1015h.

use super::Producer;
use super::history::{self, History};
use crate::cia301::cob_ids;
use crate::cia301::sdo::AbortCode;
use crate::od::{self, Dictionary, Entry};
use crate::wire::cob_id::CobId;

/// COB-ID EMCY.
const COB_ID: u16 = 0x1014;
/// Inhibit time EMCY, in 100 µs.
const INHIBIT_TIME: u16 = 0x1015;

/// One unit of an inhibit time, in µs.
const INHIBIT_UNIT: u32 = 100;

impl Producer {
    /// Takes its parameters from the dictionary, after power-on values have been loaded.
    pub fn configure<D: Dictionary>(&mut self, dictionary: &D) {
        self.configure_cob_id(dictionary);
        self.configure_inhibit_time(dictionary);
    }

    /// Whether 1003h, 1014h or 1015h may get this value; called after the dictionary's own checks.
    ///
    /// # Errors
    /// [`AbortCode::InvalidValue`]: 1003h:0 is not 0 (CiA 301, 7.5.2.6); 1014h is an extended, restricted or other
    /// identifier while the present one is valid (7.5.2.17).
    pub fn validate<D: Dictionary>(
        &self,
        dictionary: &D,
        entry: &Entry,
        value: &[u8],
    ) -> Result<(), AbortCode> {
        let is_allowed = match entry.index {
            history::INDEX => value == [0],
            COB_ID => return cob_ids::validate(dictionary, entry, value, true),
            _ => true,
        };
        if is_allowed {
            Ok(())
        } else {
            Err(D::HABITS.wrong_history_count)
        }
    }

    /// 1003h, 1014h or 1015h was written.
    pub fn written<D: Dictionary>(&mut self, dictionary: &mut D, entry: &Entry) {
        match entry.index {
            history::INDEX => History::of::<D>().clear(dictionary),
            COB_ID => self.configure_cob_id(dictionary),
            _ => self.configure_inhibit_time(dictionary),
        }
    }

    fn configure_cob_id<D: Dictionary>(&mut self, dictionary: &D) {
        let cob_id = od::fixed::<D, COB_ID, 0>(dictionary).unwrap_or(CobId::INVALID);
        self.queue.set_cob_id(CobId(cob_id));
    }

    fn configure_inhibit_time<D: Dictionary>(&mut self, dictionary: &D) {
        let units = od::fixed::<D, INHIBIT_TIME, 0>(dictionary).unwrap_or(0);
        self.queue
            .set_inhibit_time(units.saturating_mul(INHIBIT_UNIT));
    }
}

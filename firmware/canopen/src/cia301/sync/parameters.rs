//! What a master may write to the objects of SYNC: 1005h, 1006h, 1007h, 1019h.

use super::{COB_ID, COUNTER_OVERFLOW, MOST_COUNTER, NOT_IN_USE, PERIOD, Sync, WINDOW};
use crate::cia301::cob_ids;
use crate::cia301::sdo::AbortCode;
use crate::od::{Dictionary, Entry, fixed};
use crate::time::{Instant, NEVER};
use crate::wire::cob_id::CobId;

/// Bit 30 of 1005h: the device produces SYNC.
const PRODUCE: u32 = 1 << 30;

impl Sync {
    /// Takes its parameters after power-on values were loaded; a device without 1005h has no SYNC. Errors end: ask
    /// [`Sync::report`] afterwards.
    pub fn configure<D: Dictionary>(&mut self, dictionary: &D, now: Instant) {
        self.errors.end();
        self.is_running = false;
        self.is_followed = false;
        self.counter = 0;
        self.window_end = NEVER;
        self.next = NEVER;
        self.written(dictionary, now);
    }

    /// Whether 1005h, 1006h, 1007h or 1019h may get this value. Called when it has passed the dictionary's own checks; nothing
    /// changes.
    ///
    /// # Errors
    /// - [`AbortCode::InvalidValue`]: 1005h has a 29-bit or a restricted identifier, or another identifier while the device produces
    ///   SYNC (CiA 301, 7.5.2.5); 1019h is 1 or above 240 (7.5.2.22).
    /// - [`AbortCode::DeviceState`]: 1019h while 1006h is not 0.
    pub fn validate<D: Dictionary>(
        &self,
        dictionary: &D,
        entry: &Entry,
        value: &[u8],
    ) -> Result<(), AbortCode> {
        match (entry.index, value) {
            (COB_ID, _) => cob_ids::validate(dictionary, entry, value, true),
            (COUNTER_OVERFLOW, _) if fixed::<D, PERIOD, 0>(dictionary).unwrap_or(0) != 0 => {
                Err(AbortCode::DeviceState)
            }
            (COUNTER_OVERFLOW, [1 | 241..]) => Err(AbortCode::InvalidValue),
            _ => Ok(()),
        }
    }

    /// One of its objects was written: it counts from the next frame on. Who is switched on or gets a new period begins with a
    /// whole one; anything else leaves the rhythm as it is. Ask [`Sync::report`] afterwards.
    pub fn written<D: Dictionary>(&mut self, dictionary: &D, now: Instant) {
        let cob_id = CobId(fixed::<D, COB_ID, 0>(dictionary).unwrap_or(0));
        let before = (self.cob_id, self.is_producer, self.period);
        self.cob_id = if cob_id.is_base_frame() {
            cob_id.identifier()
        } else {
            NOT_IN_USE
        };
        self.is_producer = self.cob_id != NOT_IN_USE && cob_id.0 & PRODUCE != 0;
        let (_, was_producer, _) = before;
        if self.is_producer != was_producer {
            self.counter = 0;
            self.is_followed = false;
        }
        self.overflow = fixed::<D, COUNTER_OVERFLOW, 0>(dictionary)
            .unwrap_or(0)
            .min(MOST_COUNTER.into()) as u8;
        self.period = fixed::<D, PERIOD, 0>(dictionary).unwrap_or(0);
        self.window = fixed::<D, WINDOW, 0>(dictionary).unwrap_or(0);
        if self.window == 0 {
            self.window_end = NEVER;
        }
        if self.is_producer || self.period == 0 {
            self.errors.missed(false);
        }
        if (self.cob_id, self.is_producer, self.period) != before {
            self.restart(now);
        }
        self.find_plain();
    }
}

//! The scope as a master sees it: the rules of 20D0h to 20D2h, and the orders that come of them.
//!
//! What is set up can be changed while the recorder is not at work; otherwise it is 08000022h. The state that 20D0h:2 shows follows an
//! order at once, before a tick has carried it out: who arms the recorder and then asks for the state never reads of the recording
//! before.

use canopen::cia301::sdo::AbortCode;
use canopen::od::{self, Dictionary, Entry};

use crate::scope::{CHANNEL_MAP, Orders, SCOPE, Setup, Signal, State, Status, TRIGGER, sub};

/// What may be written to 20D0h:1.
mod order {
    pub(super) const STOP: u8 = 0;
    pub(super) const ARM: u8 = 1;
    pub(super) const TRIGGER: u8 = 2;
}

/// The node's half of the scope.
#[derive(Debug, Default)]
pub(crate) struct ScopeObjects {
    /// What the objects show.
    status: Status,
    /// They do not yet.
    is_stale: bool,
    orders: Orders,
}

impl ScopeObjects {
    /// Whether an object may be written.
    pub(crate) fn check<D: Dictionary>(
        &self,
        dictionary: &D,
        entry: &Entry,
        value: &[u8],
    ) -> Result<(), AbortCode> {
        if !matches!(entry.index, SCOPE..=TRIGGER) {
            return Ok(());
        }
        if (entry.index, entry.sub) == (SCOPE, sub::CONTROL) {
            return self.check_order(dictionary, value);
        }
        if self.status.state.is_at_work() {
            return Err(AbortCode::DeviceState);
        }
        let is_mapping = entry.index == CHANNEL_MAP || (entry.index, entry.sub) == (TRIGGER, 1);
        match value.first_chunk() {
            Some(bytes) if is_mapping => match u32::from_le_bytes(*bytes) {
                0 => Ok(()),
                mapping if Signal::mapped(mapping).is_some() => Ok(()),
                _ => Err(AbortCode::NotMappable),
            },
            _ => Ok(()),
        }
    }

    fn check_order<D: Dictionary>(&self, dictionary: &D, value: &[u8]) -> Result<(), AbortCode> {
        let state = self.status.state;
        match value.first().copied() {
            Some(order::STOP) => Ok(()),
            Some(order::ARM) if state.is_at_work() => Err(AbortCode::DeviceState),
            Some(order::ARM) => Setup::of(dictionary).check(self.status.memory / 4),
            Some(order::TRIGGER) if state == State::Armed => Ok(()),
            Some(order::TRIGGER) => Err(AbortCode::DeviceState),
            _ => Err(AbortCode::InvalidValue),
        }
    }

    /// An object was written.
    pub(crate) fn written<D: Dictionary>(&mut self, dictionary: &mut D, entry: &Entry) {
        if (entry.index, entry.sub) != (SCOPE, sub::CONTROL) {
            return;
        }
        match od::read_u8(dictionary, SCOPE, sub::CONTROL) {
            Some(order::STOP) => self.stop(),
            Some(order::ARM) => self.order(Orders {
                arm: Some(Setup::of(dictionary)),
                ..Orders::default()
            }),
            Some(order::TRIGGER) => self.order(Orders {
                trigger: true,
                ..Orders::default()
            }),
            _ => {}
        }
        self.put_out(dictionary);
    }

    /// The device starts anew: what is being recorded ends, what has been recorded stays.
    pub(crate) fn power_on<D: Dictionary>(&mut self, dictionary: &mut D) {
        self.stop();
        self.is_stale = true;
        self.put_out(dictionary);
    }

    fn stop(&mut self) {
        self.order(Orders {
            stop: true,
            ..Orders::default()
        });
    }

    fn order(&mut self, orders: Orders) {
        self.orders = orders.after(self.orders);
        self.note(self.status.behind(&orders));
    }

    /// The orders that have come since the last call.
    pub(crate) fn take_orders(&mut self) -> Option<Orders> {
        let orders = core::mem::take(&mut self.orders);
        (!orders.is_empty()).then_some(orders)
    }

    /// Shows what the recorder says of itself.
    #[inline]
    pub(crate) fn show<D: Dictionary>(&mut self, dictionary: &mut D, status: Status) {
        self.note(status);
        if self.is_stale {
            self.put_out(dictionary);
        }
    }

    fn note(&mut self, status: Status) {
        self.is_stale |= status != self.status;
        self.status = status;
    }

    #[cold]
    #[inline(never)]
    fn put_out<D: Dictionary>(&mut self, dictionary: &mut D) {
        self.is_stale = false;
        // A dictionary without these objects has no place for them.
        od::write_u8(dictionary, SCOPE, sub::STATE, self.status.state as u8);
        od::write_u16(dictionary, SCOPE, sub::RECORDED, self.status.recorded);
        od::write_u32(dictionary, SCOPE, sub::MEMORY, self.status.memory);
        od::write_u32(dictionary, SCOPE, sub::TICK, self.status.tick);
    }
}

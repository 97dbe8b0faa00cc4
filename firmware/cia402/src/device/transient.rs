//! States that end by themselves, and that masters have to see: quick stop active and fault reaction active.
//!
//! Newer data takes the place of what waits in a transmit PDO, so a state of a millisecond may never reach the bus: it is busy, an inhibit
//! time runs, SYNC is still to come. The device therefore tells the drive when a PDO with the state has been taken out to be sent, and the
//! drive leaves the state then, but 50 ms after it began at the latest. The stop of the motor is not delayed by that, nor is power off at
//! once, by an option code or "disable voltage". Where the power goes off once the motor stands, it stays on until the state ends; the
//! brake, if there is one, has closed by then.
//!
//! The state is not prolonged where no PDO can show it: no transmit PDO but those on remote request has the statusword, the node is not
//! Operational, or it is bus-off.

use canopen::cia301::nmt::NmtState;
use canopen::od::{self};
use canopen::{Application, Frame};

use motion::low;

use super::{Activity, Device};
use crate::behaviour::Behaves;
use crate::exchange::{Actuals, Share};
use crate::parameters::Parameter;
use crate::state_machine::State;

/// TPDO communication parameters, and from there to the mapping.
const COMMUNICATION: u16 = 0x1800;
const TO_MAPPING: u16 = 0x200;
/// Bit 31 of the COB-ID: the PDO is not there.
const NOT_VALID: u32 = 1 << 31;
/// The bits of the statusword that tell the state.
const STATE_BITS: u32 = 7;

/// How a state that ends by itself is being shown.
#[derive(Debug)]
pub(super) struct TransientStates {
    /// The drive was told that a transmit PDO may show its states.
    is_watched: bool,
    /// The controller has left the bus.
    is_bus_off: bool,
    /// The state that the dictionary shows, if it is one of them.
    state: Option<State>,
    /// A PDO has shown it, or none can.
    is_done: bool,
}

impl TransientStates {
    pub(super) const fn new() -> Self {
        Self {
            is_watched: false,
            is_bus_off: false,
            state: None,
            is_done: true,
        }
    }
}

impl<D: Behaves, A: Application<D>> Device<D, A> {
    /// Whether the controller is bus-off, so that no PDO is sent.
    pub(super) fn look_at_bus<X: Share>(&mut self, is_bus_off: bool, exchange: &mut X) {
        self.transient.is_bus_off = is_bus_off;
        self.watch(exchange);
    }

    /// Tells the drive whether a transmit PDO may show its states.
    pub(super) fn watch<X: Share>(&mut self, exchange: &mut X) {
        let is_watched = self.activity == Activity::Running
            && self.node.state() == NmtState::Operational
            && !self.transient.is_bus_off;
        if is_watched != self.transient.is_watched {
            self.transient.is_watched = is_watched;
            exchange.lock(|exchange| exchange.watch(is_watched));
        }
    }

    /// The dictionary shows these values, and the node has made its PDOs of them.
    pub(super) fn follow_state<X: Share>(&mut self, actuals: &Actuals, exchange: &mut X) {
        self.watch(exchange);
        // What has left since the last call: the dictionary may show something older now.
        self.tell(exchange);
        let state = State::from_statusword(actuals.statusword).filter(|state| state.is_transient());
        if state != self.transient.state {
            self.transient.state = state;
            self.transient.is_done =
                state.is_none() || pdos(self.node.dictionary()).next().is_none();
            self.tell(exchange);
        }
    }

    /// Tells the drive that a state is done, and again as long as it lasts: one that it has left and entered again meanwhile shows
    /// in the same PDO.
    fn tell<X: Share>(&self, exchange: &mut X) {
        if let Some(state) = self.transient.state.filter(|_| self.transient.is_done) {
            exchange.lock(|exchange| exchange.mark_state_shown(state));
        }
    }

    /// A frame has been taken out to be sent.
    pub(super) fn sees(&mut self, frame: &Frame) {
        if !self.transient.is_done {
            self.look_for_state(frame);
        }
    }

    #[cold]
    #[inline(never)]
    fn look_for_state(&mut self, frame: &Frame) {
        let id = frame.standard_id().map(u32::from);
        let data = u64::from_le_bytes(*frame.bytes());
        let mut shown = pdos(self.node.dictionary())
            .filter(|(cob_id, _)| Some(*cob_id) == id)
            .filter_map(|(_, bit)| data.checked_shr(bit));
        self.transient.is_done = shown
            .any(|word| State::from_statusword(low::u16(low::u32(word))) == self.transient.state);
    }
}

/// The transmit PDOs that show the state without being asked: identifier, and at which bit the statusword begins.
fn pdos<D: Behaves>(dictionary: &D) -> impl Iterator<Item = (u32, u32)> {
    let records = D::TABLE.range(COMMUNICATION..=COMMUNICATION + TO_MAPPING - 1);
    records
        .iter()
        .filter(|entry| entry.sub == 1)
        .filter_map(move |entry| {
            let cob_id = od::read_u32(dictionary, entry.index, 1)?;
            let is_asked_for = matches!(od::read_u8(dictionary, entry.index, 2)?, 252 | 253);
            if cob_id & NOT_VALID != 0 || is_asked_for {
                return None;
            }
            let bit = statusword_in(dictionary, entry.index.wrapping_add(TO_MAPPING))?;
            Some((cob_id & 0x7FF, bit))
        })
}

/// At which bit of a mapping the statusword begins.
fn statusword_in<D: Behaves>(dictionary: &D, mapping: u16) -> Option<u32> {
    let objects = od::read_u8(dictionary, mapping, 0)?;
    let mut bit: u32 = 0;
    for sub in 1..=objects.min(64) {
        let [length, object, low, high] = od::read_u32(dictionary, mapping, sub)?.to_le_bytes();
        let length = u32::from(length);
        let entry = od::find::<D>(u16::from_le_bytes([low, high]), object);
        if length >= STATE_BITS
            && entry.is_ok_and(|entry| D::parameter(entry) == Some(Parameter::Statusword))
        {
            return Some(bit);
        }
        bit = bit.saturating_add(length);
    }
    None
}

//! Node-ID, bit rate and serial number as objects of the manufacturer.
//!
//! | object | holds |
//! |---|---|
//! | 5FF0h:1 | node-ID, 1 to 127, or 255 for none |
//! | 5FF0h:2 | bit rate, an index of the LSS bit timing table 0; 9 to find it |
//! | 5FF0h:3, :4 | where node-ID and bit rate of this power-on come from: 0 factory, 1 store, 2 switches, 3 build |
//! | 5FF2h:1 | serial number that production has given, 0 for none |
//!
//! 5FF0h:1 and :2 are what LSS stores with 17h, in another way: a value that is written is stored at once, and the answer comes when it is
//! safe. A node-ID counts from the next reset on, a bit rate from the next power-on. They show what is stored, with what LSS has
//! configured since, whatever source counts now.
//!
//! The serial number is written once, in production ([`crate::protection`]), stored at once, and is 1018h:4 from the next NMT reset
//! node on. A dictionary may leave these objects out, or have others for them ([`crate::NetworkObjects`]).

use canopen::cia301::parameters::ParameterStore;
use canopen::cia301::sdo::AbortCode;
use canopen::node::StoreError;
use canopen::od::{self, Dictionary, Entry};
use canopen::settings::{PowerOn, Source, Wish};
use canopen::{Application, BitTiming, Configuration, NodeId};

use super::Device;
use crate::behaviour::Behaves;
use crate::exchange::Share;
use crate::objects::Objects;
use crate::protection::{NETWORK, PRODUCTION};

/// The sub-indices of 5FF0h; the first two are also the names of the settings, whatever objects they have.
const NODE_ID: u8 = 1;
const BIT_TIMING: u8 = 2;
const SOURCE_OF_NODE_ID: u8 = 3;
const SOURCE_OF_BIT_TIMING: u8 = 4;

/// The sub-index of 5FF2h.
const SERIAL_NUMBER: u8 = 1;

/// What the hooks know of these objects, and what has been written to them.
#[derive(Debug, Default)]
pub(crate) struct Commissioning {
    takes_node_id: bool,
    /// The bit rates that can be configured, a bit for each index.
    timings: u16,
    /// There is a store for a serial number.
    has_store: bool,
    /// 5FF0h was written, and what; the answer waits for the store.
    settings: Option<(u8, Wish)>,
    settings_are_ordered: bool,
    /// 5FF2h:1 was written; the answer waits for the store.
    serial_number: Option<u32>,
}

impl Commissioning {
    /// There is a store.
    pub(crate) const fn support(&mut self) {
        self.has_store = true;
    }

    /// Whether one of these objects may get a value.
    pub(crate) fn check<D: Behaves>(&self, entry: &Entry, value: &[u8]) -> Result<(), AbortCode> {
        if let Some(setting) = setting::<D>(entry) {
            if self.settings.is_some() || setting == NODE_ID && !self.takes_node_id {
                return Err(AbortCode::DeviceState);
            }
            return match wish::<D>(setting, value) {
                Some(Wish {
                    bit_timing: Some(timing),
                    ..
                }) if !self.takes(timing) => Err(AbortCode::InvalidValue),
                Some(_) => Ok(()),
                None => Err(AbortCode::InvalidValue),
            };
        }
        match (entry.index, entry.sub, value) {
            (PRODUCTION, SERIAL_NUMBER, _) if !self.has_store => Err(AbortCode::NotTransferable),
            (PRODUCTION, SERIAL_NUMBER, _) if self.serial_number.is_some() => {
                Err(AbortCode::DeviceState)
            }
            // It stands for "none".
            (PRODUCTION, SERIAL_NUMBER, [0, 0, 0, 0]) => Err(AbortCode::InvalidValue),
            _ => Ok(()),
        }
    }

    /// One of these objects was written. Returns whether the answer waits for the store.
    pub(crate) fn written<D: Behaves>(&mut self, dictionary: &D, entry: &Entry) {
        if let Some(setting) = setting::<D>(entry) {
            let wish = wish::<D>(setting, od::value(dictionary, entry));
            self.settings = wish.map(|wish| (setting, wish));
            self.settings_are_ordered = false;
        } else if (entry.index, entry.sub) == (PRODUCTION, SERIAL_NUMBER) {
            self.serial_number = od::read_u32(dictionary, PRODUCTION, SERIAL_NUMBER);
        }
    }

    /// Whether the answer to a write of this entry waits for the store.
    pub(crate) fn is_waiting<D: Objects>(&self, entry: &Entry) -> bool {
        if setting::<D>(entry).is_some() {
            self.settings.is_some()
        } else {
            let is_serial_number = (entry.index, entry.sub) == (PRODUCTION, SERIAL_NUMBER);
            is_serial_number && self.serial_number.is_some()
        }
    }

    const fn takes(&self, timing: BitTiming) -> bool {
        self.timings & bit(timing) != 0
    }
}

const fn bit(timing: BitTiming) -> u16 {
    1_u16.wrapping_shl(timing.table_index() as u32)
}

/// Which setting an object is.
pub(super) fn setting<D: Objects>(entry: &Entry) -> Option<u8> {
    let network = &D::DRIVE_HABITS.network;
    let own = (entry.index, entry.sub);
    if own == network.node_id {
        Some(NODE_ID)
    } else if own == network.bit_rate {
        Some(BIT_TIMING)
    } else {
        None
    }
}

/// The object of a setting.
const fn object<D: Objects>(setting: u8) -> (u16, u8) {
    match setting {
        NODE_ID => D::DRIVE_HABITS.network.node_id,
        _ => D::DRIVE_HABITS.network.bit_rate,
    }
}

/// What the bytes of a setting ask for.
fn wish<D: Behaves>(setting: u8, value: &[u8]) -> Option<Wish> {
    let number = match value {
        [number] if D::DRIVE_HABITS.network.are_own() => *number,
        _ if D::DRIVE_HABITS.network.are_own() => return None,
        _ => translated::<D>(setting, value)?,
    };
    Some(match setting {
        NODE_ID => Wish {
            node_id: Some(NodeId::new(number)?),
            bit_timing: None,
        },
        _ => Wish {
            node_id: None,
            bit_timing: Some(timing::<D>(number)?),
        },
    })
}

/// The value for 5FF0h of a setting written to an object of another manufacturer.
fn translated<D: Objects>(setting: u8, value: &[u8]) -> Option<u8> {
    let bytes = value.iter().rev();
    let number = bytes.fold(0, |all, byte| all << 8 | u32::from(*byte));
    let rates = D::DRIVE_HABITS.network.bit_rates;
    if setting == BIT_TIMING && !rates.is_empty() {
        let found = rates.iter().find(|(own, _)| *own == number);
        return found.map(|(_, index)| *index);
    }
    u8::try_from(number).ok()
}

/// What an index of the LSS bit timing table 0 stands for here.
const fn timing<D: Dictionary>(index: u8) -> Option<BitTiming> {
    if D::HABITS.lss_100_kbit {
        BitTiming::from_stored_index(index)
    } else {
        BitTiming::from_table_index(index)
    }
}

impl<D: Behaves, A: Application<D>> Device<D, A> {
    /// It was powered on with these sources of node-ID and bit rate ([`canopen::Node::start`]); 5FF0h shows them.
    pub fn start(&mut self, power_on: &PowerOn) {
        self.node.start(power_on);
        self.sources = (power_on.node_id.source, power_on.bit_timing.source);
    }

    /// Production has given it this serial number, or none: it goes before the one of [`Device::new`].
    pub fn produced_as(&mut self, serial_number: Option<u32>) {
        self.hooks.set_serial_number(serial_number);
    }

    /// Boot: the objects are at their power-on values.
    pub(super) fn start_commissioning(&mut self) {
        let commissioning = &mut self.hooks.commissioning;
        commissioning.takes_node_id = self.node.takes_node_id();
        commissioning.timings = (0..=BitTiming::AUTOMATIC_INDEX)
            .filter_map(timing::<D>)
            .filter(|timing| self.node.takes(*timing))
            .fold(0, |timings, timing| timings | bit(timing));
        self.show_configuration();
    }

    /// Has stored what was written, and shows what LSS has configured.
    pub(super) fn serve_commissioning(&mut self) {
        let commissioning = &mut self.hooks.commissioning;
        if let Some((setting, wish)) = commissioning.settings
            && !commissioning.settings_are_ordered
        {
            commissioning.settings_are_ordered = true;
            if self.node.configure_and_store(&wish).is_err() {
                self.end_settings(setting, Err(AbortCode::InvalidValue));
            }
        }
        if self.hooks.protection.is_stale() {
            self.hooks.protection.serve(self.node.dictionary_mut());
        }
        if self.configuration != self.node.configuration() {
            self.show_configuration();
        }
    }

    /// What the firmware says of settings that were to be stored ([`canopen::Event::StoreSettings`]).
    pub(super) fn end_storing_settings(&mut self, result: Result<(), StoreError>) {
        if let Some((setting, _)) = self.hooks.commissioning.settings
            && self.hooks.commissioning.settings_are_ordered
            && !self.node.is_storing_settings()
        {
            self.end_settings(setting, result.map_err(AbortCode::from));
        }
    }

    fn end_settings(&mut self, setting: u8, result: Result<(), AbortCode>) {
        self.hooks.commissioning.settings = None;
        let (index, sub) = object::<D>(setting);
        self.node.complete_write(index, sub, result);
        self.show_configuration();
    }

    /// Stores a serial number that was written; the drive has no power then.
    pub(super) fn store_serial_number<S: ParameterStore, X: Share>(
        &mut self,
        store: &mut S,
        exchange: &mut X,
    ) {
        let Some(number) = self.hooks.commissioning.serial_number else {
            return;
        };
        let result = if exchange.lock(|exchange| exchange.is_safe()) {
            store.keep_serial_number(number).map_err(AbortCode::from)
        } else if exchange.lock(|exchange| exchange.actuals_at(canopen::time::NEVER).safe) {
            // The next control tick knows for sure.
            return;
        } else {
            Err(AbortCode::DeviceState)
        };
        self.hooks.commissioning.serial_number = None;
        let dictionary = self.node.dictionary_mut();
        if result.is_ok() {
            self.hooks.set_serial_number(Some(number));
            self.hooks.protection.end_production(dictionary);
        }
        // Whatever was written, the object tells what is stored.
        od::write_u32(dictionary, PRODUCTION, SERIAL_NUMBER, self.hooks.produced());
        self.node.complete_write(PRODUCTION, SERIAL_NUMBER, result);
    }

    #[cold]
    #[inline(never)]
    fn show_configuration(&mut self) {
        self.configuration = self.node.configuration();
        let Configuration {
            node_id,
            bit_timing,
        } = self.configuration;
        if !D::DRIVE_HABITS.network.are_own() {
            self.show_elsewhere(node_id.get(), bit_timing.table_index());
            return;
        }
        let (of_node_id, of_bit_timing) = self.sources;
        for (sub, value) in [
            (NODE_ID, node_id.get()),
            (BIT_TIMING, bit_timing.table_index()),
            (SOURCE_OF_NODE_ID, of_node_id as u8),
            (SOURCE_OF_BIT_TIMING, of_bit_timing as u8),
        ] {
            // A dictionary without the object has no place for it.
            let _ = od::write_u8(self.node.dictionary_mut(), NETWORK, sub, value);
        }
    }

    /// Shows the settings in objects of another manufacturer.
    fn show_elsewhere(&mut self, node_id: u8, rate: u8) {
        let rates = D::DRIVE_HABITS.network.bit_rates;
        let rate = match rates.iter().find(|(_, index)| *index == rate) {
            Some((number, _)) => *number,
            // There is no number for it.
            None if !rates.is_empty() => return self.show_number(NODE_ID, node_id.into()),
            None => rate.into(),
        };
        self.show_number(NODE_ID, node_id.into());
        self.show_number(BIT_TIMING, rate);
    }

    /// Puts a number into the object of a setting, if there is one.
    fn show_number(&mut self, setting: u8, number: u32) {
        let (index, sub) = object::<D>(setting);
        if let Ok(entry) = od::find::<D>(index, sub)
            && let Some(bytes) = number.to_le_bytes().get(..usize::from(entry.size()))
        {
            // It has its own limits.
            let _ = od::set(self.node.dictionary_mut(), entry, bytes);
        }
    }
}

/// The sources of the settings where none were given: both from the factory.
pub(super) const FACTORY_SOURCES: (Source, Source) = (Source::Factory, Source::Factory);

//! Node-ID and bit rate at power-on. Which source goes before which is for [`Sources`] to say.

use canopen::settings::{PowerOn, Sources, Wish};
use canopen::{BitRate, Configuration};

use crate::ports::Storage;

/// What is asked for at a power-on, beside what is stored.
#[derive(Clone, Copy, Debug, Default)]
pub struct PowerUp {
    /// What the build fixes.
    pub build: Wish,
    /// What the switches of the board ask for.
    pub switches: Wish,
    /// What the device leaves the factory with.
    pub factory: Configuration,
    /// The input for the factory reset is held.
    pub factory_reset: bool,
}

impl PowerUp {
    /// Forgets what is stored if a factory reset is asked for, and finds out what the device starts with. Settings that the flash does
    /// not forget do not count while the input is held: a device that nobody reaches is reached again. A store that cannot be
    /// read counts as empty.
    pub fn choose<S: Storage>(&self, store: &mut Option<S>, supported: &[BitRate]) -> PowerOn {
        let sources = Sources {
            build: self.build,
            switches: self.switches,
            stored: store.as_mut().and_then(|store| self.stored(store)),
            factory: self.factory,
        };
        let power_on = sources.choose(supported);
        info!(
            "node-ID {=u8} (source {=u8}), bit timing index {=u8} (source {=u8})",
            power_on.node_id.value.get(),
            power_on.node_id.source as u8,
            power_on.bit_timing.value.table_index(),
            power_on.bit_timing.source as u8
        );
        power_on
    }

    fn stored<S: Storage>(&self, store: &mut S) -> Option<Configuration> {
        if self.factory_reset {
            info!("factory reset");
            store.forget().ok()?;
        }
        store.load().ok().flatten()
    }
}

//! Node-ID and bit rate at power-on, and the settings of the layer setting services in the board's parameter sectors.
//!
//! Which source goes before which is for [`Sources`] to say. The build fixes what the environment variables `AXIS402_NODE_ID` (1 to
//! 127) and `AXIS402_BIT_RATE` (in kbit/s, or `auto`) say while it runs.

use canopen::node::StoreError;
use canopen::settings::{PowerOn, Sources, Switches, Wish};
use canopen::{BitRate, Configuration};
use embedded_storage::nor_flash::NorFlash;
use store::Store;

/// The parameter store; `None` if the board's sectors do not suit it.
pub type Parameters<F> = Option<Store<F>>;

/// What the switches of the board mean.
const SWITCHES: Switches = Switches::ROTARY;

/// What the build fixes.
const BUILD: Wish = match Wish::of_build(
    option_env!("AXIS402_NODE_ID"),
    option_env!("AXIS402_BIT_RATE"),
) {
    Some(wish) => wish,
    None => panic!(
        "AXIS402_NODE_ID is 1 to 127, AXIS402_BIT_RATE a bit rate of CiA 301 in kbit/s or auto"
    ),
};

/// What the board has read at power-up.
pub struct Inputs {
    /// The switches; `None` on a board without any.
    pub switches: Option<u16>,
    /// The input for the factory reset is held.
    pub factory_reset: bool,
}

/// Opens the store, forgets what is in it if a factory reset is asked for, and finds out what the device starts with. Settings that
/// the flash does not forget do not count while the input is held: a device that nobody reaches is reached again.
pub fn load<F: NorFlash>(
    sectors: F,
    inputs: &Inputs,
    supported: &[BitRate],
) -> (Parameters<F>, PowerOn) {
    // All of the board's sectors. They are far smaller than 4 GiB.
    let range = 0..sectors.capacity() as u32;
    let mut store = Store::new(sectors, range).ok();
    let mut is_void = false;
    if let (true, Some(store)) = (inputs.factory_reset, &mut store) {
        match store.forget() {
            Ok(()) => defmt::warn!("factory reset"),
            Err(error) => {
                defmt::error!("factory reset: {}", defmt::Display2Format(&error));
                is_void = true;
            }
        }
    }
    let stored = match store.as_mut().map(Store::load) {
        Some(Ok(stored)) => stored.filter(|_| !is_void),
        Some(Err(error)) => {
            defmt::error!("parameters: {}", defmt::Display2Format(&error));
            None
        }
        None => {
            defmt::error!("the parameter sectors do not suit the store");
            None
        }
    };
    let sources = Sources {
        build: BUILD,
        switches: inputs
            .switches
            .map_or(Wish::NOTHING, |reading| SWITCHES.wish(reading)),
        stored,
    };
    let power_on = sources.choose(supported);
    defmt::info!(
        "node-ID {=u8} (source {=u8}), bit timing index {=u8} (source {=u8})",
        power_on.node_id.value.get(),
        power_on.node_id.source as u8,
        power_on.bit_timing.value.table_index(),
        power_on.bit_timing.source as u8,
    );
    (store, power_on)
}

/// The serial number that production has given to the device, if it has.
pub fn serial_number<F: NorFlash>(store: &mut Parameters<F>) -> Option<u32> {
    store.as_mut()?.serial_number().ok().flatten()
}

/// Stores the settings.
pub fn save<F: NorFlash>(
    store: &mut Parameters<F>,
    settings: &Configuration,
) -> Result<(), StoreError> {
    let store = store.as_mut().ok_or(StoreError::NotSupported)?;
    store.save(settings).map_err(|error| {
        defmt::error!("parameters: {}", defmt::Display2Format(&error));
        StoreError::Medium
    })
}

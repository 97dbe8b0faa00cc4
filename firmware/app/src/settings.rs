//! The settings of the layer setting services in the board's parameter sectors.

use canopen::node::StoreError;
use canopen::Settings;
use embedded_storage::nor_flash::NorFlash;
use store::Store;

/// The parameter store; `None` if the board's sectors do not suit it.
pub type Parameters<F> = Option<Store<F>>;

/// Opens the store and reads the settings; without any the device is as it left the factory.
pub fn load<F: NorFlash>(sectors: F) -> (Parameters<F>, Settings) {
    // All of the board's sectors. They are far smaller than 4 GiB.
    let range = 0..sectors.capacity() as u32;
    let mut store = Store::new(sectors, range).ok();
    let stored = match store.as_mut().map(Store::load) {
        Some(Ok(stored)) => stored,
        Some(Err(error)) => {
            defmt::error!("parameters: {}", defmt::Display2Format(&error));
            None
        }
        None => {
            defmt::error!("the parameter sectors do not suit the store");
            None
        }
    };
    let settings = stored.unwrap_or_default();
    defmt::info!(
        "node-ID {=u8}, {=u32} kbit/s",
        settings.node_id.get(),
        settings.bit_rate.kbit_per_second()
    );
    (store, settings)
}

/// Stores the settings.
pub fn save<F: NorFlash>(store: &mut Parameters<F>, settings: &Settings) -> Result<(), StoreError> {
    let store = store.as_mut().ok_or(StoreError::NotSupported)?;
    store.save(settings).map_err(|error| {
        defmt::error!("parameters: {}", defmt::Display2Format(&error));
        StoreError::Medium
    })
}

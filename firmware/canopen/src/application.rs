//! What the device asks of the firmware around it when an object is written.

use crate::cia301::sdo::AbortCode;
use crate::od::{Dictionary, Entry};

/// The application's word on its own objects (everything outside 1000h to 1FFFh). Both calls are short and never wait.
pub trait Application<D: Dictionary> {
    /// The last check of a write that passed every rule of the dictionary (existence, access, length, limits). `value` is
    /// what was sent, little-endian. Nothing has changed yet. By SDO an error is sent as the abort code; of a receive
    /// PDO, the object keeps its value and the others are written.
    fn validate(&mut self, dictionary: &D, entry: &Entry, value: &[u8]) -> Result<(), AbortCode> {
        let _ = (dictionary, entry, value);
        Ok(())
    }

    /// An object was written, by SDO or by a receive PDO; the dictionary holds the new value. For a PDO this is called
    /// for each mapped object after all of them have been copied.
    fn written(&mut self, dictionary: &mut D, entry: &Entry) {
        let _ = (dictionary, entry);
    }

    /// Power-on values have just been loaded (reset node): put in what only the firmware knows, such as the serial number.
    fn power_on(&mut self, dictionary: &mut D) {
        let _ = dictionary;
    }
}

/// No application: plain objects, for tests and simple devices.
impl<D: Dictionary> Application<D> for () {}

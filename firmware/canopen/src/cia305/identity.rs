//! The LSS address of a device.

use core::fmt;

use crate::od::{Dictionary, fixed};

/// The four words of the identity object 1018h, by which LSS tells devices apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Identity {
    /// 1018h:1, given to the maker by CiA.
    pub vendor_id: u32,
    /// 1018h:2.
    pub product_code: u32,
    /// 1018h:3.
    pub revision_number: u32,
    /// 1018h:4.
    pub serial_number: u32,
}

impl Identity {
    /// The identity that a dictionary holds; a word it does not have is 0.
    pub fn of<D: Dictionary>(dictionary: &D) -> Self {
        Self {
            vendor_id: fixed::<D, 0x1018, 1>(dictionary).unwrap_or(0),
            product_code: fixed::<D, 0x1018, 2>(dictionary).unwrap_or(0),
            revision_number: fixed::<D, 0x1018, 3>(dictionary).unwrap_or(0),
            serial_number: fixed::<D, 0x1018, 4>(dictionary).unwrap_or(0),
        }
    }

    /// The words in the order of the object.
    pub const fn words(&self) -> [u32; 4] {
        [
            self.vendor_id,
            self.product_code,
            self.revision_number,
            self.serial_number,
        ]
    }
}

impl fmt::Display for Identity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [vendor, product, revision, serial] = self.words();
        write!(
            f,
            "vendor {vendor:08X}h, product {product:08X}h, revision {revision:08X}h, serial {serial:08X}h"
        )
    }
}

impl From<[u32; 4]> for Identity {
    fn from([vendor_id, product_code, revision_number, serial_number]: [u32; 4]) -> Self {
        Self {
            vendor_id,
            product_code,
            revision_number,
            serial_number,
        }
    }
}

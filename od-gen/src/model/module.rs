//! Modular devices: what each module adds to the dictionary of its bus coupler (CiA 306, 4.7).

use super::Object;
use super::entry::{Access, Entry};

/// A kind of module that can be plugged to the device.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Module {
    /// Its number in SupportedModules, from 1 on.
    pub number: u8,
    /// ProductName.
    pub product_name: String,
    /// ProductVersion.
    pub product_version: u8,
    /// ProductRevision.
    pub product_revision: u8,
    /// OrderCode.
    pub order_code: String,
    /// The lines of its comments.
    pub comments: Vec<String>,
    /// Objects that are there as soon as one such module is.
    pub fixed: Vec<Object>,
    /// Sub-indices that each such module adds to an object.
    pub extensions: Vec<Extension>,
}

/// Sub-indices that a module adds to an object.
#[derive(Clone, Debug, PartialEq)]
pub struct Extension {
    /// The object.
    pub index: u16,
    /// What each of them is like; its sub-index is 1.
    pub entry: Entry,
    /// How many one module adds.
    pub count: u8,
    /// Whether the next object goes on when this one has no sub-index left.
    pub continues: bool,
}

/// A range of indices for the variables of a programmable device (CiA 306, DynamicChannels; CiA 302).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DynamicChannel {
    /// Type: the number of the data type.
    pub data_type: u16,
    /// Dir: the access of the variables; `None` where the file does not say it.
    pub access: Option<Access>,
    /// Range: first index.
    pub first: u16,
    /// Range: last index.
    pub last: u16,
    /// What follows the offset of BOOLEANs behind a comma: the difference of their addresses.
    pub difference: Option<u32>,
    /// PPOffset: where the first variable lies in the process image.
    pub offset: u32,
}

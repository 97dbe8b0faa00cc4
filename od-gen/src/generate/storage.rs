//! Which values are stored with which group (CiA 301, 7.5.2.13: the sub-indices of 1010h).

use crate::model::{Access, Entry, Object};

/// A sub-index of 1010h and 1011h; the order is that of `canopen::od::StorageGroup`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum StorageGroup {
    Communication,
    Application,
    Manufacturer,
}

impl StorageGroup {
    pub(super) const ALL: [Self; 3] = [Self::Communication, Self::Application, Self::Manufacturer];

    /// The group of a value by the profile area it is in. Only parameters are stored: what is `rw`. A process value (`rww`,
    /// `rwr`) is not, and neither are the error history and the objects that store and restore.
    pub(super) fn of(object: &Object, entry: &Entry) -> Option<Self> {
        if entry.access != Access::ReadWrite {
            return None;
        }
        match object.index {
            0x1003 | 0x1010 | 0x1011 => None,
            0x1000..=0x1FFF => Some(Self::Communication),
            0x2000..=0x5FFF => Some(Self::Manufacturer),
            0x6000..=0x9FFF => Some(Self::Application),
            _ => None,
        }
    }
}

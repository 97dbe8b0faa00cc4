//! What a dictionary takes in the device, in bytes.

use super::layout::Layout;
use crate::model::Model;

/// Bytes of a descriptor: `canopen::od::Entry`.
const DESCRIPTOR: usize = 10;

/// Bytes of a bucket: a position.
const BUCKET: usize = 2;

/// What a dictionary takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Figures {
    /// Values: one descriptor each.
    pub entries: usize,
    /// Flash of the descriptors, and of the buckets that they are found by.
    pub descriptors: usize,
    /// Flash of the limits: each pair is there once, whichever values have it.
    pub limits: usize,
    /// Flash of the values: those that never change, and the defaults of the others.
    pub values: usize,
    /// RAM of the values that can change.
    pub ram: usize,
}

impl Figures {
    /// Those of a data sheet.
    pub fn of(model: &Model) -> Self {
        let layout = Layout::new(model);
        Self {
            entries: layout.rows.len(),
            descriptors: layout.rows.len() * DESCRIPTOR + layout.buckets() * BUCKET,
            limits: layout.limits.len(),
            values: layout.rom.len() + layout.defaults.len(),
            ram: layout.defaults.len(),
        }
    }

    /// All of its flash but the code of hooks and bindings.
    pub fn flash(&self) -> usize {
        self.descriptors + self.limits + self.values
    }
}

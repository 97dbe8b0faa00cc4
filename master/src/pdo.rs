//! PDO configuration by the standard procedure (CiA 301, 7.5.2.36): switch off, unmap, map, set up, switch on.

use crate::{Failure, Line, Master};

/// An object in a PDO.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MappedObject {
    /// Index.
    pub index: u16,
    /// Sub-index.
    pub sub: u8,
    /// Length in bits.
    pub bits: u8,
}

impl MappedObject {
    /// An object that has no sub-indexes.
    pub const fn new(index: u16, bits: u8) -> Self {
        Self {
            index,
            sub: 0,
            bits,
        }
    }

    /// As it is written into a mapping record.
    pub const fn entry(self) -> u32 {
        (self.index as u32) << 16 | (self.sub as u32) << 8 | self.bits as u32
    }
}

/// How a PDO shall be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PdoSetup {
    /// Its identifier.
    pub cob_id: u16,
    /// Transmission type.
    pub transmission_type: u8,
    /// Inhibit time in 100 µs (transmit PDOs only).
    pub inhibit_time: Option<u16>,
    /// Event timer in milliseconds (transmit PDOs only).
    pub event_timer: Option<u16>,
    /// What it carries.
    pub objects: Vec<MappedObject>,
}

impl<L: Line> Master<L> {
    /// Sets up receive PDO `number` (1 to 512).
    ///
    /// # Errors
    /// The failure of the SDO transfer that failed.
    pub fn set_up_rpdo(&mut self, node: u8, number: u16, setup: &PdoSetup) -> Result<(), Failure> {
        self.set_up_pdo(node, 0x1400 + number - 1, 0x1600 + number - 1, setup)
    }

    /// Sets up transmit PDO `number` (1 to 512).
    ///
    /// # Errors
    /// The failure of the SDO transfer that failed.
    pub fn set_up_tpdo(&mut self, node: u8, number: u16, setup: &PdoSetup) -> Result<(), Failure> {
        self.set_up_pdo(node, 0x1800 + number - 1, 0x1A00 + number - 1, setup)
    }

    fn set_up_pdo(
        &mut self,
        node: u8,
        communication: u16,
        mapping: u16,
        setup: &PdoSetup,
    ) -> Result<(), Failure> {
        const INVALID: u32 = 1 << 31;
        const NO_RTR: u32 = 1 << 30;
        let present: u32 = self.read(node, communication, 1)?;
        self.write(node, communication, 1, present | INVALID)?;
        self.write(node, mapping, 0, 0u8)?;
        for (sub, object) in (1u8..).zip(&setup.objects) {
            self.write(node, mapping, sub, object.entry())?;
        }
        self.write(node, mapping, 0, setup.objects.len() as u8)?;
        self.write(node, communication, 2, setup.transmission_type)?;
        if let Some(inhibit_time) = setup.inhibit_time {
            self.write(node, communication, 3, inhibit_time)?;
        }
        if let Some(event_timer) = setup.event_timer {
            self.write(node, communication, 5, event_timer)?;
        }
        let flags = if communication >= 0x1800 { NO_RTR } else { 0 };
        self.write(node, communication, 1, u32::from(setup.cob_id) | flags)
    }
}

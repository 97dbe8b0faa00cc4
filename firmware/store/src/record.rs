//! The record of the settings: node-ID and bit rate, as the layer setting services store them (CiA 305, service 17h).
//!
//! The bit rate is an index of table 0 of CiA 305, 9 for one that is to be found.

use canopen::{BitTiming, Configuration, NodeId};
use sequential_storage::map::{SerializationError, Value};

use crate::Error;

/// Bytes of a record.
pub const RECORD: usize = 3;

/// Layout 1: layout, node-ID, index in the bit timing table 0 of CiA 305.
const LAYOUT: u8 = 1;

/// The bytes of a record; the first names the layout of the rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Record([u8; RECORD]);

impl Record {
    /// The record of these settings.
    pub fn of_settings(settings: &Configuration) -> Self {
        Self([
            LAYOUT,
            settings.node_id.get(),
            settings.bit_timing.table_index(),
        ])
    }

    /// The settings in this record.
    pub fn settings<E>(self) -> Result<Configuration, Error<E>> {
        let [layout, node_id, bit_timing] = self.0;
        if layout != LAYOUT {
            return Err(Error::Layout(layout));
        }
        let bit_timing = BitTiming::from_table_index(bit_timing);
        match (NodeId::new(node_id), bit_timing) {
            (Some(node_id), Some(bit_timing)) => Ok(Configuration {
                node_id,
                bit_timing,
            }),
            _ => Err(Error::Content),
        }
    }
}

impl Value<'_> for Record {
    fn serialize_into(&self, buffer: &mut [u8]) -> Result<usize, SerializationError> {
        let bytes = buffer
            .first_chunk_mut()
            .ok_or(SerializationError::BufferTooSmall)?;
        *bytes = self.0;
        Ok(RECORD)
    }

    fn deserialize_from(buffer: &[u8]) -> Result<(Self, usize), SerializationError> {
        // A later layout may be longer: its first bytes are enough to say that it is unknown. A shorter one is no record.
        let bytes = buffer
            .first_chunk()
            .ok_or(SerializationError::InvalidFormat)?;
        Ok((Self(*bytes), RECORD))
    }
}

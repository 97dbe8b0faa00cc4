//! A node and the data sheet that says what its objects are.

use std::sync::Arc;

use super::Problem;
use crate::data_sheet::{Address, DataSheet};
use crate::{Failure, Line, Master, SdoChannel};

/// The abort code of a client that waited in vain (CiA 301).
const TIMED_OUT: u32 = 0x0504_0000;

/// The abort code for an object that is not there.
const NO_OBJECT: u32 = 0x0602_0000;

/// The identifiers of the first SDO server; those of the others follow.
const SDO_SERVERS: u16 = 0x1200;

/// A node that a command is about.
#[derive(Clone, Debug)]
pub struct Node {
    /// Its node-ID.
    pub id: u8,
    /// What its objects are.
    pub sheet: Arc<DataSheet>,
}

impl Node {
    /// A node with a data sheet; without one it is asked who it is. The generic drive, with a stepper or a servo, is known by its
    /// vendor-ID and product code, of every other device only what the standards say.
    ///
    /// # Errors
    /// [`Problem::Failed`] if it does not answer.
    pub fn meet<L: Line>(
        master: &mut Master<L>,
        id: u8,
        sheet: Option<Arc<DataSheet>>,
    ) -> Result<Self, Problem> {
        if let Some(sheet) = sheet {
            return Ok(Self { id, sheet });
        }
        let stranger = Self {
            id,
            sheet: DataSheet::standard(),
        };
        let mut words = [0; 2];
        for (sub, word) in (1..).zip(&mut words) {
            match stranger.upload(master, Address::new(0x1018, sub)) {
                Ok(bytes) => *word = u32::from_le_bytes(bytes.try_into().unwrap_or_default()),
                // It is there; it need not say who it is.
                Err(Failure::Abort { .. }) => return Ok(stranger),
                Err(failure) => return Err(Problem::with_node(id, failure)),
            }
        }
        let [vendor_id, product_code] = words;
        Ok(match DataSheet::built_in(vendor_id, product_code) {
            Some(sheet) => Self { id, sheet },
            None => stranger,
        })
    }

    /// From now on the node is read and written through its SDO server of this number, 1 being the default one.
    ///
    /// # Errors
    /// [`Problem::Failed`] if it has no such server, or it is not in use.
    pub fn use_sdo_server<L: Line>(
        &self,
        master: &mut Master<L>,
        number: u8,
    ) -> Result<(), Problem> {
        let index = SDO_SERVERS + u16::from(number.saturating_sub(1));
        let mut identifiers = [0; 2];
        for (sub, identifier) in (1..).zip(&mut identifiers) {
            let cob_id = self.upload(master, Address::new(index, sub));
            let cob_id = cob_id.map_err(|failure| match failure {
                Failure::Abort { code, .. } if code == NO_OBJECT => Problem::Failed(format!(
                    "node {} has no SDO server {number}: {index:04X}h is missing",
                    self.id
                )),
                other => Problem::with_node(self.id, other),
            })?;
            let cob_id = u32::from_le_bytes(cob_id.try_into().unwrap_or_default());
            // Bit 31: not in use. Bit 29: an identifier of 29 bits, which no master here sends.
            *identifier = match u16::try_from(cob_id) {
                Ok(identifier) if identifier != 0 => identifier,
                _ => {
                    return Err(Problem::Failed(format!(
                        "node {}: SDO server {number} has no identifiers; {index:04X}h:01 and :02 take two that no other device uses",
                        self.id
                    )));
                }
            };
        }
        let [request, answer] = identifiers;
        master.set_sdo_channel(self.id, SdoChannel { request, answer });
        Ok(())
    }

    /// Reads a value as it travels. A node that is silent is told that nobody waits any longer.
    ///
    /// # Errors
    /// As [`Master::read`].
    pub fn upload<L: Line>(
        &self,
        master: &mut Master<L>,
        address: Address,
    ) -> Result<Vec<u8>, Failure> {
        let result = master.read(self.id, address.index, address.sub);
        self.conclude(master, address, result)
    }

    /// Writes a value as it travels, as [`Node::upload`] reads it.
    ///
    /// # Errors
    /// As [`Master::write`].
    pub fn download<L: Line>(
        &self,
        master: &mut Master<L>,
        address: Address,
        bytes: &[u8],
    ) -> Result<(), Failure> {
        let result = master.write(self.id, address.index, address.sub, bytes.to_vec());
        self.conclude(master, address, result)
    }

    fn conclude<L: Line, T>(
        &self,
        master: &mut Master<L>,
        address: Address,
        result: Result<T, Failure>,
    ) -> Result<T, Failure> {
        if matches!(
            result,
            Err(Failure::Timeout { .. } | Failure::Unexpected { .. } | Failure::TimeIsUp { .. })
        ) {
            master.abort_sdo(self.id, address.index, address.sub, TIMED_OUT);
        }
        result
    }

    /// `6064h:00 Position actual value`, or the number alone.
    pub fn title(&self, address: Address) -> String {
        match self.sheet.name(address) {
            Some(name) => format!("{address} {name}"),
            None => address.to_string(),
        }
    }
}

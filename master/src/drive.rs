//! What a master of CiA 402 drives does all the time: controlword out, statusword in, both in the first bytes of a PDO.

use canopen::Duration;

use crate::{Failure, Line, Master};

impl<L: Line> Master<L> {
    /// Sends a controlword by receive PDO 1 (identifier 200h + node-ID, mapped to 6040h alone).
    pub fn controlword(&mut self, node: u8, controlword: u16) {
        self.send_data(0x200 + u16::from(node), &controlword.to_le_bytes());
    }

    /// Waits for a transmit PDO 1 (180h + node-ID) whose first two bytes, the statusword, have `value` under `mask`.
    ///
    /// # Errors
    /// [`Failure::Timeout`] if none came `within` the time.
    pub fn wait_for_statusword(
        &mut self,
        node: u8,
        mask: u16,
        value: u16,
        within: Duration,
    ) -> Result<u16, Failure> {
        let cob_id = 0x180 + u16::from(node);
        let expected = format!("statusword {value:04X}h under mask {mask:04X}h from node {node}");
        self.wait_for(&expected, within, |frame| {
            let statusword = match frame.payload() {
                [low, high, ..] if frame.standard_id() == Some(cob_id) => {
                    u16::from_le_bytes([*low, *high])
                }
                _ => return None,
            };
            (statusword & mask == value).then_some(statusword)
        })
    }
}

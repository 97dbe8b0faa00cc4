//! SDO transfers in words. A segment means nothing without its transfer, so the frames of each node are followed.

use super::abort::abort_code;
use super::objects;
use crate::data_sheet::DataSheet;

/// The transfer a node is in.
#[derive(Clone, Debug, Default)]
pub struct SdoWatcher {
    index: u16,
    sub: u8,
    bytes: Vec<u8>,
    download: bool,
}

impl SdoWatcher {
    /// A frame of the client.
    pub fn request(&mut self, frame: &[u8; 8], sheet: &DataSheet) -> String {
        let [command, low, high, sub, data @ ..] = *frame;
        match command >> 5 {
            1 => {
                self.begin(low, high, sub, true);
                let name = objects::name(sheet, self.index, self.sub);
                if command & 0x02 == 0 {
                    return format!("SDO write {name}, in segments");
                }
                let unused = if command & 0x01 != 0 {
                    usize::from(command >> 2 & 0x03)
                } else {
                    0
                };
                let value = objects::value(sheet, self.index, self.sub, &data[..4 - unused]);
                format!("SDO write {name} := {value}")
            }
            2 => {
                self.begin(low, high, sub, false);
                format!("SDO read {}", objects::name(sheet, self.index, self.sub))
            }
            0 => {
                self.segment(frame);
                format!("SDO segment, {} bytes so far", self.bytes.len())
            }
            3 => "SDO next segment, please".to_owned(),
            4 => abort(data),
            _ => "SDO request".to_owned(),
        }
    }

    /// A frame of the server.
    pub fn answer(&mut self, frame: &[u8; 8], sheet: &DataSheet) -> String {
        let [command, _, _, _, data @ ..] = *frame;
        match command >> 5 {
            2 if command & 0x02 != 0 => {
                let unused = if command & 0x01 != 0 {
                    usize::from(command >> 2 & 0x03)
                } else {
                    0
                };
                let value = objects::value(sheet, self.index, self.sub, &data[..4 - unused]);
                format!("SDO answer {value}")
            }
            2 => format!("SDO answer, {} bytes follow", u32::from_le_bytes(data)),
            3 => "SDO written".to_owned(),
            0 if !self.download => {
                self.segment(frame);
                if command & 0x01 == 0 {
                    format!("SDO segment, {} bytes so far", self.bytes.len())
                } else {
                    format!(
                        "SDO last segment: {}",
                        objects::value(sheet, self.index, self.sub, &self.bytes)
                    )
                }
            }
            1 => "SDO segment taken".to_owned(),
            4 => abort(data),
            _ => "SDO answer".to_owned(),
        }
    }

    fn begin(&mut self, low: u8, high: u8, sub: u8, download: bool) {
        *self = Self {
            index: u16::from_le_bytes([low, high]),
            sub,
            bytes: Vec::new(),
            download,
        };
    }

    fn segment(&mut self, frame: &[u8; 8]) {
        let unused = usize::from(frame[0] >> 1 & 0x07);
        self.bytes.extend_from_slice(&frame[1..8 - unused]);
    }
}

fn abort(code: [u8; 4]) -> String {
    format!("SDO abort {}", abort_code(u32::from_le_bytes(code)))
}

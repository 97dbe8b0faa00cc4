//! SDO transfers in words. A segment means nothing without its transfer, so the frames of each node are followed.

use super::abort::abort_code;
use super::objects;
use super::sdo_block::Block;
use crate::data_sheet::DataSheet;

/// The transfer a node is in.
#[derive(Clone, Debug, Default)]
pub struct SdoWatcher {
    index: u16,
    sub: u8,
    bytes: Vec<u8>,
    download: bool,
    block: Option<Block>,
}

impl SdoWatcher {
    /// A frame of the client.
    pub fn request(&mut self, frame: &[u8; 8], sheet: &DataSheet) -> String {
        let [command, low, high, sub, data @ ..] = *frame;
        if let Some(block) = self.block_of(true, frame) {
            return block.segment(frame);
        }
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
            4 => self.abort(data),
            5 => match (command & 0x03, &mut self.block) {
                (0, _) => {
                    self.begin(low, high, sub, false);
                    self.block = Some(Block::new(false));
                    let name = objects::name(sheet, self.index, self.sub);
                    format!("SDO block read {name}, {} segments at a time", data[0])
                }
                (1, _) => {
                    self.block = None;
                    "SDO read".to_owned()
                }
                (2, Some(block)) => block.confirm(low),
                (3, Some(block)) => {
                    block.go_ahead();
                    "SDO block: go ahead".to_owned()
                }
                _ => "SDO request".to_owned(),
            },
            6 if command & 0x01 == 0 => {
                self.begin(low, high, sub, true);
                self.block = Some(Block::new(true));
                let name = objects::name(sheet, self.index, self.sub);
                format!("SDO block write {name}{}", size(command, data))
            }
            6 => self.end_block(command, sheet),
            _ => "SDO request".to_owned(),
        }
    }

    /// A frame of the server.
    pub fn answer(&mut self, frame: &[u8; 8], sheet: &DataSheet) -> String {
        let [command, low, _, _, data @ ..] = *frame;
        if let Some(block) = self.block_of(false, frame) {
            return block.segment(frame);
        }
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
            4 => self.abort(data),
            5 => match (command & 0x03, &mut self.block) {
                (0, Some(block)) => {
                    block.go_ahead();
                    format!("SDO block: go ahead, {} segments at a time", data[0])
                }
                (1, _) => {
                    self.block = None;
                    "SDO written".to_owned()
                }
                (2, Some(block)) => block.confirm(low),
                _ => "SDO answer".to_owned(),
            },
            6 if command & 0x01 == 0 => format!("SDO block answer{}", size(command, data)),
            6 => self.end_block(command, sheet),
            _ => "SDO answer".to_owned(),
        }
    }

    fn begin(&mut self, low: u8, high: u8, sub: u8, download: bool) {
        *self = Self {
            index: u16::from_le_bytes([low, high]),
            sub,
            bytes: Vec::new(),
            download,
            block: None,
        };
    }

    /// The block transfer of which this frame is a segment.
    fn block_of(&mut self, is_client: bool, frame: &[u8; 8]) -> Option<&mut Block> {
        let block = self.block.as_mut()?;
        (block.is_download == is_client && block.is_segment(frame)).then_some(block)
    }

    fn end_block(&mut self, command: u8, sheet: &DataSheet) -> String {
        let Some(block) = self.block.take() else {
            return "SDO block end".to_owned();
        };
        let is_download = block.is_download;
        let value = block.value(command >> 2 & 0x07);
        // The confirmation is still to come.
        self.block = Some(Block::new(is_download));
        let value = objects::value(sheet, self.index, self.sub, &value);
        format!("SDO block end: {value}")
    }

    fn abort(&mut self, code: [u8; 4]) -> String {
        self.block = None;
        format!("SDO abort {}", abort_code(u32::from_le_bytes(code)))
    }

    fn segment(&mut self, frame: &[u8; 8]) {
        let unused = usize::from(frame[0] >> 1 & 0x07);
        self.bytes.extend_from_slice(&frame[1..8 - unused]);
    }
}

/// The size that a block transfer announces, if it does.
fn size(command: u8, data: [u8; 4]) -> String {
    match command & 0x02 {
        0 => String::new(),
        _ => format!(", {} bytes", u32::from_le_bytes(data)),
    }
}

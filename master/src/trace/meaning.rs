//! What a frame means, by its identifier in the predefined connection set (CiA 301) and what was seen before.

use std::collections::HashMap;
use std::sync::Arc;

use canopen::Frame;

use super::lss;
use super::objects;
use super::sdo::SdoWatcher;
use super::words;
use crate::MappedObject;
use crate::data_sheet::DataSheet;

/// Follows a bus and puts its frames into words.
#[derive(Clone, Debug)]
pub struct Interpreter {
    sheet: Arc<DataSheet>,
    sheets: HashMap<u8, Arc<DataSheet>>,
    sdo: HashMap<u8, SdoWatcher>,
    pdos: HashMap<u16, Pdo>,
}

/// What is known of a PDO.
#[derive(Clone, Debug)]
struct Pdo {
    node: u8,
    label: String,
    objects: Vec<MappedObject>,
}

impl Interpreter {
    /// Knows the predefined connection set, and of PDOs that the first carries controlword or statusword. All nodes are what
    /// `sheet` says, unless [`Interpreter::learn_sheet`] tells something else.
    pub fn new(sheet: Arc<DataSheet>) -> Self {
        Self {
            sheet,
            sheets: HashMap::new(),
            sdo: HashMap::new(),
            pdos: HashMap::new(),
        }
    }

    /// Tells what this node is.
    pub fn learn_sheet(&mut self, node: u8, sheet: Arc<DataSheet>) {
        self.sheets.insert(node, sheet);
    }

    /// Tells what the PDO with this identifier carries, of which node it is, and what to call it.
    pub fn learn_pdo(&mut self, cob_id: u16, node: u8, label: &str, objects: &[MappedObject]) {
        let pdo = Pdo {
            node,
            label: label.to_owned(),
            objects: objects.to_vec(),
        };
        self.pdos.insert(cob_id, pdo);
    }

    fn sheet_of(&self, node: u8) -> Arc<DataSheet> {
        Arc::clone(self.sheets.get(&node).unwrap_or(&self.sheet))
    }

    /// What a frame means, in one line; empty for a frame that means nothing in CANopen.
    pub fn meaning(&mut self, frame: &Frame) -> String {
        let Some(cob_id) = frame.standard_id() else {
            return String::new();
        };
        let node = (cob_id & 0x7F) as u8;
        let payload = frame.payload();
        if let Some(pdo) = self.pdos.get(&cob_id) {
            let contents = contents(&self.sheet_of(pdo.node), &pdo.objects, payload);
            return format!("{}: {contents}", pdo.label);
        }
        let sheet = self.sheet_of(node);
        match (cob_id & 0x780, payload, frame.full_payload()) {
            (0x000, [command, node], _) if cob_id == 0 => nmt(*command, *node),
            (0x080, _, _) if node == 0 => "SYNC".to_owned(),
            (0x080, [low, high, register, ..], _) => {
                let code = u16::from_le_bytes([*low, *high]);
                match code {
                    0 => format!("EMCY of node {node}: no error, register {register:02X}h"),
                    _ => {
                        format!("EMCY of node {node}: error {code:04X}h, register {register:02X}h")
                    }
                }
            }
            (0x180, [low, high, ..], _) => {
                format!(
                    "TPDO 1: {}",
                    words::statusword(u16::from_le_bytes([*low, *high]))
                )
            }
            (0x200, [low, high, ..], _) => {
                format!(
                    "RPDO 1: {}",
                    words::controlword(u16::from_le_bytes([*low, *high]))
                )
            }
            (group @ 0x180..=0x500, _, _) => {
                let number = (group - 0x180) / 0x100 + 1;
                let kind = if group & 0x80 != 0 { "TPDO" } else { "RPDO" };
                format!("{kind} {number} of node {node}")
            }
            (0x600, _, Some(bytes)) => self.sdo.entry(node).or_default().request(bytes, &sheet),
            (0x580, _, Some(bytes)) => self.sdo.entry(node).or_default().answer(bytes, &sheet),
            (0x700, [0], _) => format!("boot-up of node {node}"),
            (0x700, [state], _) => {
                format!("heartbeat of node {node}: {}", words::node_state(*state))
            }
            (_, _, Some(bytes)) if cob_id == 0x7E5 => lss::request(bytes),
            (_, _, Some(bytes)) if cob_id == 0x7E4 => lss::answer(bytes),
            _ => String::new(),
        }
    }
}

/// The mapped objects in the order in which they lie in the PDO. One of a few bits has the lowest bits that are left.
fn contents(sheet: &DataSheet, objects: &[MappedObject], payload: &[u8]) -> String {
    let bits = 8 * payload.len() as u32;
    let word = (payload.iter().rev()).fold(0u64, |word, byte| word << 8 | u64::from(*byte));
    let mut parts = Vec::new();
    let mut at = 0;
    for object in objects {
        let length = u32::from(object.bits);
        if at + length > bits {
            break;
        }
        let value =
            word.checked_shr(at).unwrap_or(0) & (u64::MAX >> 64u32.saturating_sub(length).min(63));
        at += length;
        // Data types stand for gaps.
        if object.index >= 0x1000 {
            let bytes = value.to_le_bytes();
            let used = length.div_ceil(8) as usize;
            parts.push(objects::short(
                sheet,
                object.index,
                object.sub,
                &bytes[..used.min(8)],
            ));
        }
    }
    parts.join("; ")
}

fn nmt(command: u8, node: u8) -> String {
    let command = match command {
        0x01 => "start",
        0x02 => "stop",
        0x80 => "enter pre-operational,",
        0x81 => "reset",
        0x82 => "reset communication of",
        _ => "unknown command to",
    };
    match node {
        0 => format!("NMT: {command} all nodes"),
        _ => format!("NMT: {command} node {node}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn meanings(frames: &[(u16, &[u8])]) -> Vec<String> {
        let mut interpreter = Interpreter::new(DataSheet::axis402());
        interpreter.learn_pdo(
            0x384,
            4,
            "TPDO 3",
            &[MappedObject::new(0x6041, 16), MappedObject::new(0x6064, 32)],
        );
        frames
            .iter()
            .map(|(cob_id, data)| interpreter.meaning(&Frame::data_frame(*cob_id, data)))
            .collect()
    }

    #[test]
    fn the_predefined_connection_set_is_known() {
        let frames: [(u16, &[u8]); 11] = [
            (0x704, &[0]),
            (0x704, &[0x7F]),
            (0x000, &[1, 4]),
            (0x000, &[0x81, 0]),
            (0x080, &[]),
            (0x084, &[0x20, 0x32, 0x05, 0, 0, 0, 0, 0]),
            (0x204, &[0x0F, 0]),
            (0x184, &[0x37, 0x06]),
            (0x384, &[0x37, 0x02, 0xFB, 0xFF, 0xFF, 0xFF]),
            (0x484, &[1]),
            (0x123, &[]),
        ];
        assert_eq!(
            meanings(&frames),
            [
                "boot-up of node 4",
                "heartbeat of node 4: pre-operational",
                "NMT: start node 4",
                "NMT: reset all nodes",
                "SYNC",
                "EMCY of node 4: error 3220h, register 05h",
                "RPDO 1: enable operation",
                "TPDO 1: operation enabled, target reached",
                "TPDO 3: operation enabled; position actual value -5",
                "TPDO 4 of node 4",
                "",
            ]
        );
    }

    #[test]
    fn mapped_objects_may_have_any_number_of_bits() {
        let mut interpreter = Interpreter::new(DataSheet::axis402());
        let objects = [
            MappedObject::new(0x1001, 4),
            MappedObject::new(0x0005, 4),
            MappedObject::new(0x6041, 16),
            MappedObject::new(0x6061, 8),
            MappedObject::new(0x6064, 32),
        ];
        interpreter.learn_pdo(0x184, 4, "TPDO 1", &objects);
        let frame = Frame::data_frame(0x184, &[0x95, 0x37, 0x02, 0xFF, 0xFE, 0xFF, 0xFF, 0xFF]);
        assert_eq!(
            interpreter.meaning(&frame),
            "TPDO 1: error register 5; operation enabled; modes of operation display -1; position actual value -2"
        );
    }

    #[test]
    fn sdo_transfers_are_followed() {
        let frames: [(u16, &[u8]); 9] = [
            (0x604, &[0x23, 0x83, 0x60, 0, 0x50, 0xC3, 0, 0]),
            (0x584, &[0x60, 0x83, 0x60, 0, 0, 0, 0, 0]),
            (0x604, &[0x40, 0x08, 0x10, 0, 0, 0, 0, 0]),
            (0x584, &[0x41, 0x08, 0x10, 0, 9, 0, 0, 0]),
            (0x604, &[0x60, 0, 0, 0, 0, 0, 0, 0]),
            (0x584, &[0x00, b'A', b'x', b'i', b's', b'4', b'0', b'2']),
            (0x584, &[0x1B, b'!', b'!', 0, 0, 0, 0, 0]),
            (0x604, &[0x40, 0x00, 0x99, 0, 0, 0, 0, 0]),
            (0x584, &[0x80, 0x00, 0x99, 0, 0, 0, 0x02, 0x06]),
        ];
        assert_eq!(
            meanings(&frames),
            [
                "SDO write 6083h profile acceleration := 50000",
                "SDO written",
                "SDO read 1008h manufacturer device name",
                "SDO answer, 9 bytes follow",
                "SDO next segment, please",
                "SDO segment, 7 bytes so far",
                "SDO last segment: \"Axis402!!\"",
                "SDO read 9900h",
                "SDO abort 06020000h: object does not exist",
            ]
        );
    }

    #[test]
    fn block_transfers_are_followed() {
        let frames: [(u16, &[u8]); 16] = [
            (0x604, &[0xC6, 0x20, 0x20, 0, 10, 0, 0, 0]),
            (0x584, &[0xA4, 0x20, 0x20, 0, 2, 0, 0, 0]),
            // Both look like other requests; the second is lost.
            (0x604, &[0x01, b'T', b'e', b'n', b' ', b'b', b'y', b't']),
            (0x584, &[0xA2, 1, 2, 0, 0, 0, 0, 0]),
            (0x604, &[0x81, b'e', b's', b'.', 0, 0, 0, 0]),
            (0x584, &[0xA2, 1, 2, 0, 0, 0, 0, 0]),
            (0x604, &[0xD1, 0x34, 0x12, 0, 0, 0, 0, 0]),
            (0x584, &[0xA1, 0, 0, 0, 0, 0, 0, 0]),
            (0x604, &[0xA4, 0x20, 0x20, 0, 127, 0, 0, 0]),
            (0x584, &[0xC6, 0x20, 0x20, 0, 5, 0, 0, 0]),
            (0x604, &[0xA3, 0, 0, 0, 0, 0, 0, 0]),
            (0x584, &[0x81, 1, 2, 3, 4, 5, 0, 0]),
            (0x604, &[0xA2, 1, 127, 0, 0, 0, 0, 0]),
            (0x584, &[0xC9, 0, 0, 0, 0, 0, 0, 0]),
            (0x604, &[0xA1, 0, 0, 0, 0, 0, 0, 0]),
            (0x584, &[0x80, 0x20, 0x20, 0, 0, 0, 4, 5]),
        ];
        assert_eq!(
            meanings(&frames),
            [
                "SDO block write 2020h user memory, 10 bytes",
                "SDO block: go ahead, 2 segments at a time",
                "SDO block segment 1",
                "SDO block: taken up to segment 1",
                "SDO block segment 1, the last",
                "SDO block: taken up to segment 1",
                "SDO block end: \"Ten bytes.\"",
                "SDO written",
                "SDO block read 2020h user memory, 127 segments at a time",
                "SDO block answer, 5 bytes",
                "SDO block: go ahead",
                "SDO block segment 1, the last",
                "SDO block: taken up to segment 1",
                "SDO block end: 21542142465",
                "SDO read",
                "SDO abort 05040000h: SDO protocol timed out",
            ]
        );
    }

    #[test]
    fn lss_services_are_known() {
        let frames: [(u16, &[u8]); 4] = [
            (0x7E5, &[0x51, 0, 0, 0, 0, 0x80, 0, 0]),
            (0x7E4, &[0x4F, 0, 0, 0, 0, 0, 0, 0]),
            (0x7E5, &[0x11, 4, 0, 0, 0, 0, 0, 0]),
            (0x7E4, &[0x17, 2, 0, 0, 0, 0, 0, 0]),
        ];
        assert_eq!(
            meanings(&frames),
            [
                "LSS fastscan: is anybody there without a node-ID?",
                "LSS: yes",
                "LSS: take node-ID 4",
                "LSS: refused, error 2",
            ]
        );
    }

    proptest::proptest! {
        /// What a bus carries is not in the hands of who watches it.
        #[test]
        fn no_traffic_is_too_strange_to_be_told(
            frames: Vec<(u8, [u8; 8], u8)>,
        ) {
            let mut interpreter = Interpreter::new(DataSheet::axis402());
            let objects = [MappedObject::new(0x6041, 13), MappedObject::new(0x6064, 255)];
            interpreter.learn_pdo(0x184, 4, "TPDO 1", &objects);
            for (kind, bytes, length) in frames {
                // Mostly SDO, where one frame depends on another.
                let cob_id = [0x604, 0x584, 0x184, 0x084, 0x7E4, 0x7E5, 0x704, 0x604, 0x584];
                let cob_id = cob_id[usize::from(kind) % cob_id.len()];
                let length = if kind & 0x80 != 0 { 8 } else { usize::from(length) % 9 };
                interpreter.meaning(&Frame::data_frame(cob_id, &bytes[..length]));
            }
        }
    }
}

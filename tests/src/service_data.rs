//! A small SDO client for the cases: reads and writes whole objects, expedited or by segments.

use canopen::Frame;
use master::bus::Station;

use crate::line::Line;
use crate::notation::show;

impl<S: Station> Line<S> {
    /// Sends a request and returns the server's answer; other frames between are forgotten. An abort is its code.
    ///
    /// # Errors
    /// The abort code.
    pub fn ask(&mut self, request: [u8; 8]) -> Result<[u8; 8], u32> {
        let node_id = u16::from(self.node_id);
        self.queue_frame(Frame::data_frame(0x600 + node_id, &request));
        let answer = self.drain_until(&format!("{:03X}: xx ..", 0x580 + node_id), 250);
        let bytes = *answer.bytes();
        match bytes {
            [0x80, _, _, _, a, b, c, d] => Err(u32::from_le_bytes([a, b, c, d])),
            _ => Ok(bytes),
        }
    }

    /// Reads an object, or the abort code.
    pub fn try_read(&mut self, index: u16, sub: u8) -> Result<Vec<u8>, u32> {
        let [low, high] = index.to_le_bytes();
        let answer = self.ask([0x40, low, high, sub, 0, 0, 0, 0])?;
        if answer[0] & 0x02 != 0 {
            let unused = usize::from(answer[0] >> 2 & 3);
            return Ok(answer[4..8 - unused].to_vec());
        }
        let size = u32::from_le_bytes([answer[4], answer[5], answer[6], answer[7]]) as usize;
        let mut value = Vec::new();
        let mut toggle = 0;
        loop {
            let segment = self.ask([0x60 | toggle, 0, 0, 0, 0, 0, 0, 0])?;
            assert_eq!(
                segment[0] & 0x10,
                toggle,
                "toggle of {}",
                show(&Frame::data_frame(0, &segment))
            );
            value.extend_from_slice(&segment[1..8 - usize::from(segment[0] >> 1 & 7)]);
            if segment[0] & 1 == 1 {
                assert_eq!(value.len(), size, "size that was indicated");
                return Ok(value);
            }
            toggle ^= 0x10;
        }
    }

    /// Writes an object, or the abort code.
    pub fn try_write(&mut self, index: u16, sub: u8, value: &[u8]) -> Result<(), u32> {
        let [low, high] = index.to_le_bytes();
        if (1..=4).contains(&value.len()) {
            let mut request = [
                0x23 | (4 - value.len() as u8) << 2,
                low,
                high,
                sub,
                0,
                0,
                0,
                0,
            ];
            request[4..4 + value.len()].copy_from_slice(value);
            self.ask(request)?;
            return Ok(());
        }
        let [a, b, c, d] = (value.len() as u32).to_le_bytes();
        self.ask([0x21, low, high, sub, a, b, c, d])?;
        self.send_segments(value)
    }

    /// Sends a value by segments, or the abort code. The download has been initiated.
    ///
    /// # Errors
    /// The abort code.
    pub fn send_segments(&mut self, value: &[u8]) -> Result<(), u32> {
        let mut toggle = 0;
        let mut rest = value;
        loop {
            let (now, later) = rest.split_at(rest.len().min(7));
            let mut request = [
                toggle | (7 - now.len() as u8) << 1 | u8::from(later.is_empty()),
                0,
                0,
                0,
                0,
                0,
                0,
                0,
            ];
            request[1..=now.len()].copy_from_slice(now);
            self.ask(request)?;
            if later.is_empty() {
                return Ok(());
            }
            rest = later;
            toggle ^= 0x10;
        }
    }

    /// Reads an object that must be readable.
    #[track_caller]
    pub fn read(&mut self, index: u16, sub: u8) -> Vec<u8> {
        self.try_read(index, sub).unwrap_or_else(|code| {
            panic!("reading {index:04X}h:{sub:02X} was refused with {code:08X}")
        })
    }

    /// Writes an object that must take the value.
    #[track_caller]
    pub fn write(&mut self, index: u16, sub: u8, value: &[u8]) {
        if let Err(code) = self.try_write(index, sub, value) {
            panic!("writing {value:02X?} to {index:04X}h:{sub:02X} was refused with {code:08X}");
        }
    }
}

/// Typed access, one pair for each number type the cases need.
macro_rules! typed {
    ($($number:ty: $read:ident, $write:ident;)*) => {
        impl<S: Station> Line<S> {
            $(
                /// Reads a number; the object must have exactly its size.
                #[track_caller]
                pub fn $read(&mut self, index: u16, sub: u8) -> $number {
                    let bytes = self.read(index, sub);
                    <$number>::from_le_bytes(bytes.as_slice().try_into().unwrap_or_else(|_| panic!("{index:04X}h:{sub:02X} has {} bytes", bytes.len())))
                }

                /// Writes a number.
                #[track_caller]
                pub fn $write(&mut self, index: u16, sub: u8, value: $number) {
                    self.write(index, sub, &value.to_le_bytes());
                }
            )*
        }
    };
}

typed! {
    u8: read_u8, write_u8;
    i8: read_i8, write_i8;
    u16: read_u16, write_u16;
    i16: read_i16, write_i16;
    u32: read_u32, write_u32;
    i32: read_i32, write_i32;
    u64: read_u64, write_u64;
}

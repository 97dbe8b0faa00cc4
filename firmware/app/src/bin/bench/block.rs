//! Block transfer of 889 bytes, 127 full segments, which the application gives and takes.

use canopen::cia301::sdo::{AbortCode, Completion};
use canopen::od::Entry;
use canopen::Application;

use crate::device::{Device, Dictionary, ANSWER, REQUEST};

/// Bytes of object 2002h.
const LENGTH: usize = 889;

/// The value of object 2002h.
pub struct Domain([u8; LENGTH]);

impl Domain {
    pub fn new() -> Self {
        let mut bytes = [0; LENGTH];
        for (number, byte) in bytes.iter_mut().enumerate() {
            *byte = (number * 7) as u8;
        }
        Self(bytes)
    }
}

impl Application<Dictionary> for Domain {
    // Nothing is done when an object has been written.
    const WRITES_BACK: bool = false;

    fn size(&mut self, _: &Dictionary, _: &Entry) -> Result<Option<u32>, AbortCode> {
        Ok(Some(LENGTH as u32))
    }

    fn read_at(
        &mut self,
        _: &Dictionary,
        _: &Entry,
        position: u32,
        into: &mut [u8],
    ) -> Result<usize, AbortCode> {
        let rest = self.0.get(position as usize..).unwrap_or(&[]);
        for (to, from) in into.iter_mut().zip(rest) {
            *to = *from;
        }
        Ok(into.len().min(rest.len()))
    }

    fn begin_write(
        &mut self,
        _: &Dictionary,
        _: &Entry,
        size: Option<u32>,
    ) -> Result<(), AbortCode> {
        if size == Some(LENGTH as u32) {
            Ok(())
        } else {
            Err(AbortCode::LengthMismatch)
        }
    }

    fn write_at(
        &mut self,
        _: &Dictionary,
        _: &Entry,
        position: u32,
        data: &[u8],
    ) -> Result<(), AbortCode> {
        let begin = position as usize;
        match self.0.get_mut(begin..begin.saturating_add(data.len())) {
            Some(room) => room.copy_from_slice(data),
            None => return Err(AbortCode::LengthTooHigh),
        }
        Ok(())
    }

    fn end_write(
        &mut self,
        _: &mut Dictionary,
        _: &Entry,
        _: u32,
    ) -> Result<Completion, AbortCode> {
        Ok(Completion::Now)
    }
}

/// CRC-16/XMODEM, bit by bit.
fn crc(data: &[u8]) -> u16 {
    let mut crc = 0_u16;
    for byte in data {
        crc ^= u16::from(*byte) << 8;
        for _ in 0..8 {
            crc = (crc << 1) ^ if crc >> 15 == 1 { 0x1021 } else { 0 };
        }
    }
    crc
}

/// Segment number `seqno` of the only sub-block.
fn segment(seqno: u8, data: &[u8]) -> [u8; 8] {
    let mut frame = [0; 8];
    frame[0] = seqno | if seqno == 127 { 0x80 } else { 0 };
    frame[1..].copy_from_slice(data);
    frame
}

/// The rows of block transfer.
pub fn run(device: &mut Device) {
    let value = device.application.0;
    let [low, high] = crc(&value).to_le_bytes();
    device.sdo(
        [0xA4, 0x02, 0x20, 0, 127, 0, 0, 0],
        [0xC6, 0x02, 0x20, 0, 0x79, 3, 0, 0],
    );
    device.receive(REQUEST, &[0xA3, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(device.sent.len(), 127);
    for ((seqno, data), frame) in (1..).zip(value.chunks(7)).zip(&device.sent) {
        assert_eq!(frame.standard_id(), Some(ANSWER));
        assert_eq!(frame.payload(), segment(seqno, data));
    }
    device.sdo(
        [0xA2, 127, 127, 0, 0, 0, 0, 0],
        [0xC1, low, high, 0, 0, 0, 0, 0],
    );
    device.receive(REQUEST, &[0xA1, 0, 0, 0, 0, 0, 0, 0]);
    device.expect_nothing();
    device.row("SDO block upload, 889 bytes");

    let value = value.map(|byte| !byte);
    let [low, high] = crc(&value).to_le_bytes();
    device.sdo(
        [0xC6, 0x02, 0x20, 0, 0x79, 3, 0, 0],
        [0xA4, 0x02, 0x20, 0, 127, 0, 0, 0],
    );
    for (seqno, data) in (1..).zip(value.chunks(7)) {
        device.receive(REQUEST, &segment(seqno, data));
        if seqno == 127 {
            device.expect(ANSWER, &[0xA2, 127, 127, 0, 0, 0, 0, 0]);
        } else {
            device.expect_nothing();
        }
    }
    device.sdo(
        [0xC1, low, high, 0, 0, 0, 0, 0],
        [0xA1, 0, 0, 0, 0, 0, 0, 0],
    );
    device.row("SDO block download, 889 bytes");
    assert!(device.application.0 == value);
}

//! How long a classic CAN frame occupies the bus, and who wins arbitration (ISO 11898-1).
//!
//! The length is that of the very frame, stuff bits included: the bits from start of frame to the end of the CRC are
//! built, the CRC-15 with them, and counted with a stuff bit after each run of five equal bits.

use canopen::{BitRate, Duration, Frame};
use embedded_can::Id;

/// CRC delimiter, acknowledge slot and its delimiter, end of frame: ten bits that are never stuffed.
const TAIL_BITS: u32 = 10;

/// Bits between two frames in which nobody may start.
pub const INTERMISSION_BITS: u32 = 3;

/// Bits of an error flag with its echo and delimiter, at most (6 + 6 + 8).
pub const ERROR_FRAME_BITS: u32 = 20;

/// Bits of a frame on the wire from start of frame to end of frame, stuff bits included.
pub fn frame_bits(frame: &Frame) -> u32 {
    let mut bits = Bits::default();
    bits.push(0, 1); // start of frame
    match frame.id() {
        Id::Standard(id) => {
            bits.push(id.as_raw().into(), 11);
            bits.push(frame.is_remote().into(), 1);
            bits.push(0, 2); // IDE, reserved
        }
        Id::Extended(id) => {
            bits.push(id.as_raw() >> 18, 11);
            bits.push(0b11, 2); // SRR, IDE
            bits.push(id.as_raw() & 0x3_FFFF, 18);
            bits.push(frame.is_remote().into(), 1);
            bits.push(0, 2); // reserved
        }
    }
    bits.push(frame.length().into(), 4);
    for byte in frame.payload() {
        bits.push((*byte).into(), 8);
    }
    let crc = bits.crc;
    bits.push(crc.into(), 15);
    bits.count + bits.stuffed + TAIL_BITS
}

/// The time of so many bits, rounded up to whole microseconds.
pub fn bit_time(bits: u32, bit_rate: BitRate) -> Duration {
    let microseconds = (u64::from(bits) * 1000).div_ceil(u64::from(bit_rate.kbit_per_second()));
    Duration::from_ticks(microseconds)
}

/// The arbitration field as a number: of several frames that start together, the lowest wins.
pub fn arbitration(frame: &Frame) -> u32 {
    match frame.id() {
        Id::Standard(id) => u32::from(id.as_raw()) << 21 | u32::from(frame.is_remote()) << 20,
        Id::Extended(id) => {
            let (base, extension) = (id.as_raw() >> 18, id.as_raw() & 0x3_FFFF);
            base << 21 | 0b11 << 19 | extension << 1 | u32::from(frame.is_remote())
        }
    }
}

/// The stuffed part of a frame while it is built.
#[derive(Default)]
struct Bits {
    count: u32,
    stuffed: u32,
    run: u32,
    last: Option<bool>,
    crc: u16,
}

impl Bits {
    /// Appends the low `length` bits of `value`, most significant first.
    fn push(&mut self, value: u32, length: u32) {
        for shift in (0..length).rev() {
            self.bit(value >> shift & 1 == 1);
        }
    }

    fn bit(&mut self, bit: bool) {
        self.count += 1;
        let feedback = bit != (self.crc & 0x4000 != 0);
        self.crc = self.crc << 1 & 0x7FFF;
        if feedback {
            self.crc ^= 0x4599;
        }
        self.run = if self.last == Some(bit) {
            self.run + 1
        } else {
            1
        };
        self.last = Some(bit);
        if self.run == 5 {
            // The stuff bit is the opposite, and begins a run of its own.
            self.stuffed += 1;
            self.run = 1;
            self.last = Some(!bit);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use embedded_can::{ExtendedId, Frame as _};

    #[test]
    fn a_frame_is_never_shorter_than_unstuffed_and_never_longer_than_worst_case() {
        for length in 0..=8u8 {
            for fill in [0x00, 0x55, 0xFF, 0x1F, 0xE0] {
                let frame = Frame::data_frame(0x604, &vec![fill; length.into()]);
                let bits = frame_bits(&frame);
                let nominal = 44 + 8 * u32::from(length);
                assert!(bits >= nominal, "{bits} < {nominal}");
                assert!(bits <= nominal + (34 + 8 * u32::from(length) - 1) / 4);
            }
        }
    }

    #[test]
    fn an_alternating_frame_needs_few_stuff_bits_and_zeros_need_many() {
        let alternating = frame_bits(&Frame::data_frame(0x2AA, &[0x55; 8]));
        let zeros = frame_bits(&Frame::data_frame(0x000, &[0x00; 8]));
        assert!(alternating < 112);
        // 83 zeros in a row but for the length field: one stuff bit for each four after the first five.
        assert!(zeros >= 108 + 14, "{zeros}");
    }

    #[test]
    fn the_crc_is_that_of_iso_11898() {
        // The remainder of a message followed by its own checksum is zero.
        let mut bits = Bits::default();
        bits.push(0x014, 12);
        bits.push(0b000_0001, 7);
        bits.push(0x01, 8);
        let crc = bits.crc;
        assert_ne!(crc, 0);
        bits.push(crc.into(), 15);
        assert_eq!(bits.crc, 0);
    }

    #[test]
    fn time_follows_the_bit_rate() {
        assert_eq!(bit_time(111, BitRate::Kbit1000).ticks(), 111);
        assert_eq!(bit_time(111, BitRate::Kbit10).ticks(), 11_100);
        assert_eq!(bit_time(111, BitRate::Kbit800).ticks(), 139);
    }

    #[test]
    fn lower_identifiers_win_data_beats_remote_and_standard_beats_extended() {
        let standard = Frame::data_frame(0x100, &[]);
        let remote = Frame::remote_frame(0x100, 0);
        let extended = Frame::new(ExtendedId::new(0x100 << 18).unwrap(), &[]).unwrap();
        let lower = Frame::data_frame(0x0FF, &[]);
        let order = [lower, standard, remote, extended].map(|frame| arbitration(&frame));
        assert!(order.is_sorted_by(|a, b| a < b), "{order:?}");
    }
}

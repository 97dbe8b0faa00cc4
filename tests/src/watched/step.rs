//! What can happen to a device, and its form as bytes: what a fuzzer changes and keeps.

use canopen::{Duration, Frame};
use embedded_can::{ExtendedId, Frame as _, Id, StandardId};

/// One thing that happens to a device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Step {
    /// A frame comes.
    Frame(Frame),
    /// Time passes.
    Pass(Duration),
    /// The firmware reports the error FF00h + number, with the number as bits of the error register.
    Report(u8),
    /// That error is gone.
    Clear(u8),
    /// The application changes a value that a TPDO carries.
    Change(u32),
    /// The bus takes this many frames.
    Transmit(u8),
}

/// Microseconds of one unit of time in bytes: 16 bits of it are more than three seconds.
const TIME_UNIT: u64 = 50;

const EXTENDED: u8 = 0x10;
const REMOTE: u8 = 0x20;

/// Steps as bytes. The upper two bits of the first byte tell the kind.
pub fn encode(steps: &[Step]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for step in steps {
        match step {
            Step::Frame(frame) => {
                let (id, extended) = match frame.id() {
                    Id::Standard(id) => (id.as_raw(), 0),
                    // Of a 29-bit identifier the lower half is enough.
                    Id::Extended(id) => (id.as_raw() as u16, EXTENDED),
                };
                let remote = if frame.is_remote() { REMOTE } else { 0 };
                bytes.push(frame.length() | extended | remote);
                bytes.extend(id.to_le_bytes());
                bytes.extend(frame.payload());
            }
            Step::Pass(span) => {
                let units = u16::try_from(span.ticks() / TIME_UNIT).unwrap_or(u16::MAX);
                bytes.push(0x40);
                bytes.extend(units.to_le_bytes());
            }
            Step::Report(number) => bytes.extend([0x80, *number]),
            Step::Clear(number) => bytes.extend([0x81, *number]),
            Step::Change(value) => {
                bytes.push(0x82);
                bytes.extend(value.to_le_bytes());
            }
            Step::Transmit(frames) => bytes.push(0xC0 | frames.min(&0x3F)),
        }
    }
    bytes
}

/// The steps of these bytes. All bytes have a meaning; an end in the middle of a step is filled with zeros.
pub fn decode(bytes: &[u8]) -> impl Iterator<Item = Step> {
    let mut bytes = bytes.iter().copied();
    std::iter::from_fn(move || {
        let first = bytes.next()?;
        let mut next = || bytes.next().unwrap_or_default();
        Some(match first >> 6 {
            0 => {
                let id = u16::from_le_bytes([next(), next()]);
                let id = if first & EXTENDED == 0 {
                    Id::from(StandardId::new(id & 0x7FF).unwrap_or(StandardId::ZERO))
                } else {
                    Id::from(ExtendedId::new(id.into()).unwrap_or(ExtendedId::ZERO))
                };
                let length = usize::from(first & 0x0F).min(8);
                if first & REMOTE != 0 {
                    Step::Frame(Frame::new_remote(id, length)?)
                } else {
                    let mut data = [0; 8];
                    data[..length].fill_with(next);
                    Step::Frame(Frame::new(id, &data[..length])?)
                }
            }
            1 => {
                let units = u16::from_le_bytes([next(), next()]);
                Step::Pass(Duration::from_ticks(u64::from(units) * TIME_UNIT))
            }
            2 => match first & 3 {
                0 => Step::Report(next()),
                1 => Step::Clear(next()),
                _ => Step::Change(u32::from_le_bytes([next(), next(), next(), next()])),
            },
            _ => Step::Transmit(first & 0x3F),
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_survive_their_bytes() {
        let steps = [
            Step::Frame(Frame::data_frame(0x604, &[0x40, 0, 0x10, 0, 0, 0, 0, 0])),
            Step::Frame(Frame::data_frame(0x080, &[])),
            Step::Frame(Frame::remote_frame(0x704, 1)),
            Step::Frame(Frame::new(ExtendedId::new(0x604).unwrap(), &[1, 2]).unwrap()),
            Step::Pass(Duration::millis(1_000)),
            Step::Report(7),
            Step::Clear(7),
            Step::Change(0x0102_0304),
            Step::Transmit(5),
        ];
        assert_eq!(decode(&encode(&steps)).collect::<Vec<_>>(), steps);
    }

    #[test]
    fn all_bytes_mean_something() {
        for first in 0..=u8::MAX {
            let steps: Vec<_> = decode(&[first, 0xFF, 0xFF, first, first, 3]).collect();
            assert!(!steps.is_empty(), "{first:02X}");
        }
        assert_eq!(decode(&[]).count(), 0);
    }
}

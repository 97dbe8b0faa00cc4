//! The notation of `candump` (can-utils): time in seconds, interface, identifier, length, bytes.

use std::fmt::Write;

use canopen::{Frame, Instant};
use embedded_can::Id;

/// The interface name in every line.
const INTERFACE: &str = "can0";

/// A frame as `candump -t z` prints it: `(0.001234)  can0  704   [1]  00`.
pub fn line(at: Instant, frame: &Frame) -> String {
    let mut line = format!(
        "({})  {INTERFACE}  {}   [{}] ",
        time(at),
        identifier(frame),
        frame.length()
    );
    if frame.is_remote() {
        line.push_str(" remote request");
    }
    for byte in frame.payload() {
        // Writing to a string cannot fail.
        let _ = write!(line, " {byte:02X}");
    }
    line
}

/// A time in seconds with six decimals.
pub fn time(at: Instant) -> String {
    format!("{}.{:06}", at.ticks() / 1_000_000, at.ticks() % 1_000_000)
}

/// The identifier: three digits for 11 bits, eight for 29.
pub fn identifier(frame: &Frame) -> String {
    match frame.id() {
        Id::Standard(id) => format!("{:03X}", id.as_raw()),
        Id::Extended(id) => format!("{:08X}", id.as_raw()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use embedded_can::{ExtendedId, Frame as _};

    #[test]
    fn lines_look_like_those_of_candump() {
        let at = Instant::from_ticks(1_234);
        assert_eq!(
            line(at, &Frame::data_frame(0x704, &[0])),
            "(0.001234)  can0  704   [1]  00"
        );
        assert_eq!(
            line(
                at,
                &Frame::data_frame(0x604, &[0x40, 0, 0x10, 0, 0, 0, 0, 0])
            ),
            "(0.001234)  can0  604   [8]  40 00 10 00 00 00 00 00"
        );
        assert_eq!(
            line(at, &Frame::data_frame(0x080, &[])),
            "(0.001234)  can0  080   [0] "
        );
        assert_eq!(
            line(at, &Frame::remote_frame(0x704, 1)),
            "(0.001234)  can0  704   [1]  remote request"
        );
        let extended = Frame::new(ExtendedId::new(0x1234).unwrap(), &[7]).unwrap();
        assert_eq!(
            line(Instant::from_ticks(12_000_000), &extended),
            "(12.000000)  can0  00001234   [1]  07"
        );
    }
}

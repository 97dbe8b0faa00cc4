//! What a line says.

use canopen::{BitRate, Frame};
use embedded_can::{ExtendedId, Frame as _, StandardId};

/// A bit rate of the command `S`: 10, 20, 50, 100, 125, 250, 500, 800, 1000 kbit/s by its digit, 0 to 8.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AdapterBitRate(u8);

impl AdapterBitRate {
    const KBIT_PER_SECOND: [u32; 9] = [10, 20, 50, 100, 125, 250, 500, 800, 1000];

    /// From the digit of the command, 0 to 8.
    pub fn from_digit(digit: u8) -> Option<Self> {
        (digit <= 8).then_some(Self(digit))
    }

    /// The digit of the command, 0 to 8.
    pub fn digit(self) -> u8 {
        self.0
    }

    /// In kbit/s.
    pub fn kbit_per_second(self) -> u32 {
        Self::KBIT_PER_SECOND
            .get(usize::from(self.0))
            .copied()
            .unwrap_or(0)
    }

    /// As CANopen has it; `None` for 100 kbit/s, which CiA 301 leaves out.
    pub fn bit_rate(self) -> Option<BitRate> {
        BitRate::ALL
            .into_iter()
            .find(|rate| rate.kbit_per_second() == self.kbit_per_second())
    }
}

impl From<BitRate> for AdapterBitRate {
    fn from(bit_rate: BitRate) -> Self {
        let same = (0..=8)
            .map(Self)
            .find(|own| own.kbit_per_second() == bit_rate.kbit_per_second());
        same.unwrap_or(Self(8))
    }
}

/// One line from the PC.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// `t`, `T`, `r`, `R`: send this frame.
    Frame(Frame),
    /// `S` and a digit: a bit rate of the list.
    SetBitRate(AdapterBitRate),
    /// `s` and 4 to 8 hexadecimal digits: bit timing registers of the adapter's controller.
    SetBitTiming(u32),
    /// `O`: open the channel.
    Open,
    /// `L`: open the channel, listen only.
    Listen,
    /// `C`: close the channel.
    Close,
    /// `V` or `v`: which version?
    Version,
    /// `N`: which serial number?
    SerialNumber,
    /// `F`: which status flags?
    Status,
    /// `Z0`, `Z1`: time stamps off or on.
    TimeStamps(bool),
    /// `M`, `m`, `W`, `X`, `U` with digits: filters and port settings that mean nothing here.
    Setting,
    /// A line with nothing in it; PCs send some to clear the adapter's buffer.
    Empty,
    /// Anything else.
    Malformed,
}

impl Command {
    /// Reads a line, without its CR.
    pub fn parse(line: &[u8]) -> Self {
        Self::parsed(line).unwrap_or(Self::Malformed)
    }

    fn parsed(line: &[u8]) -> Option<Self> {
        let (letter, rest) = match line {
            [] => return Some(Self::Empty),
            [letter, rest @ ..] => (*letter, rest),
        };
        match letter {
            b't' => frame(rest, 3, false),
            b'T' => frame(rest, 8, false),
            b'r' => frame(rest, 3, true),
            b'R' => frame(rest, 8, true),
            b'S' => match rest {
                [digit @ b'0'..=b'8'] => {
                    AdapterBitRate::from_digit(digit - b'0').map(Self::SetBitRate)
                }
                _ => None,
            },
            b's' if (4..=8).contains(&rest.len()) => hexadecimal(rest).map(Self::SetBitTiming),
            b'Z' => match rest {
                [b'0'] => Some(Self::TimeStamps(false)),
                [b'1'] => Some(Self::TimeStamps(true)),
                _ => None,
            },
            b'M' | b'm' if rest.len() == 8 => hexadecimal(rest).map(|_| Self::Setting),
            b'W' | b'X' | b'U' if rest.len() == 1 => hexadecimal(rest).map(|_| Self::Setting),
            _ if !rest.is_empty() => None,
            b'O' => Some(Self::Open),
            b'L' => Some(Self::Listen),
            b'C' => Some(Self::Close),
            b'V' | b'v' => Some(Self::Version),
            b'N' => Some(Self::SerialNumber),
            b'F' => Some(Self::Status),
            _ => None,
        }
    }
}

/// A frame after its letter: identifier, length, and for a data frame exactly so many bytes.
fn frame(text: &[u8], identifier_digits: usize, remote: bool) -> Option<Command> {
    let id = hexadecimal(text.get(..identifier_digits)?)?;
    let length = usize::from(match text.get(identifier_digits)? {
        digit @ b'0'..=b'8' => digit - b'0',
        _ => return None,
    });
    let digits = text.get(identifier_digits + 1..)?;
    let mut bytes = [0; 8];
    let data = bytes.get_mut(..if remote { 0 } else { length })?;
    if digits.len() != 2 * data.len() {
        return None;
    }
    for (byte, pair) in data.iter_mut().zip(digits.chunks_exact(2)) {
        *byte = u8::try_from(hexadecimal(pair)?).ok()?;
    }
    let id = if identifier_digits == 3 {
        embedded_can::Id::Standard(StandardId::new(u16::try_from(id).ok()?)?)
    } else {
        embedded_can::Id::Extended(ExtendedId::new(id)?)
    };
    let frame = if remote {
        Frame::new_remote(id, length)
    } else {
        Frame::new(id, data)
    };
    frame.map(Command::Frame)
}

/// At most eight hexadecimal digits, at least one.
fn hexadecimal(digits: &[u8]) -> Option<u32> {
    if digits.is_empty() || digits.len() > 8 {
        return None;
    }
    digits.iter().try_fold(0u32, |value, digit| {
        let digit = char::from(*digit).to_digit(16)?;
        Some(value << 4 | digit)
    })
}

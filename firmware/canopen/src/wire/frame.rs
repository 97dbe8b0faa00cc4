//! The classic CAN frame, data or remote, 11 or 29 bit identifier, 0 to 8 bytes.

use core::num::NonZeroU32;

use embedded_can::{ExtendedId, Id, StandardId};

/// A classic CAN frame. It implements [`embedded_can::Frame`], so any driver can carry it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    /// 11 or 29 bits of identifier, [`EXTENDED`], [`REMOTE`] and [`PRESENT`]: one comparison finds a data frame with the 11-bit
    /// identifier that one looks for, and a frame moves in four words, as does "no frame".
    header: NonZeroU32,
    data: [u8; 8],
    length: u8,
}

/// Bit of the header: the identifier has 29 bits.
const EXTENDED: u32 = 1 << 31;
/// Bit of the header: a remote frame.
const REMOTE: u32 = 1 << 30;
/// Bit of the header: there is a frame.
const PRESENT: NonZeroU32 = NonZeroU32::MIN.saturating_add((1 << 29) - 1);
/// The bits of an 11-bit identifier.
const STANDARD_ID: u16 = 0x7FF;

impl Frame {
    /// A data frame with an 11-bit identifier (only its low 11 bits count) and at most 8 bytes (more are cut off).
    pub fn data_frame(cob_id: u16, data: &[u8]) -> Self {
        let mut bytes = [0; 8];
        let mut length = 0;
        for (to, from) in bytes.iter_mut().zip(data) {
            *to = *from;
            length += 1;
        }
        Self {
            header: standard(cob_id),
            length,
            data: bytes,
        }
    }

    /// A data frame with an 11-bit identifier (only its low 11 bits count) and eight bytes.
    pub fn full(cob_id: u16, data: [u8; 8]) -> Self {
        Self {
            header: standard(cob_id),
            length: 8,
            data,
        }
    }

    /// A data frame with an 11-bit identifier and the first `length` of these bytes; the others are 0.
    #[inline]
    pub(crate) fn of_length(cob_id: u16, data: [u8; 8], length: u8) -> Self {
        Self {
            header: standard(cob_id),
            length: length.min(8),
            data,
        }
    }

    /// A remote frame with an 11-bit identifier (only its low 11 bits count) that asks for `length` bytes (at most 8).
    pub fn remote_frame(cob_id: u16, length: u8) -> Self {
        Self {
            header: standard(cob_id) | REMOTE,
            length: length.min(8),
            data: [0; 8],
        }
    }

    /// The 11-bit identifier; `None` for an extended frame.
    #[inline]
    pub fn standard_id(&self) -> Option<u16> {
        if self.header.get() & EXTENDED == 0 {
            Some(self.header.get() as u16 & STANDARD_ID)
        } else {
            None
        }
    }

    /// The 11 bits of [`Frame::standard_id`], of a frame that is known to have no more.
    #[inline]
    pub(crate) fn low_id(&self) -> u16 {
        self.header.get() as u16 & STANDARD_ID
    }

    /// The bytes of a data frame; empty for a remote frame.
    pub fn payload(&self) -> &[u8] {
        if self.is_remote() {
            return &[];
        }
        self.data
            .get(..usize::from(self.length))
            .unwrap_or(&self.data)
    }

    /// All eight byte positions; those beyond the length are zero.
    pub fn bytes(&self) -> &[u8; 8] {
        &self.data
    }

    /// The payload of a data frame with exactly eight bytes, as SDO and LSS require.
    pub fn full_payload(&self) -> Option<&[u8; 8]> {
        (!self.is_remote() && self.length == 8).then_some(&self.data)
    }

    /// Whether this is a remote frame.
    #[inline]
    pub fn is_remote(&self) -> bool {
        self.header.get() & REMOTE != 0
    }

    /// The identifier, 11 or 29 bits.
    pub fn id(&self) -> Id {
        let identifier = self.header.get() & !(EXTENDED | REMOTE | PRESENT.get());
        match self.standard_id() {
            Some(cob_id) => Id::Standard(StandardId::new(cob_id).unwrap_or(StandardId::ZERO)),
            None => Id::Extended(ExtendedId::new(identifier).unwrap_or(ExtendedId::ZERO)),
        }
    }

    /// The length code: bytes carried, or asked for by a remote frame.
    pub fn length(&self) -> u8 {
        self.length
    }
}

/// The header of a data frame with an 11-bit identifier.
fn standard(cob_id: u16) -> NonZeroU32 {
    PRESENT | u32::from(cob_id & STANDARD_ID)
}

/// The header of a data frame.
fn header(id: Id) -> NonZeroU32 {
    match id {
        Id::Standard(id) => standard(id.as_raw()),
        Id::Extended(id) => PRESENT | id.as_raw() | EXTENDED,
    }
}

impl embedded_can::Frame for Frame {
    fn new(id: impl Into<Id>, data: &[u8]) -> Option<Self> {
        (data.len() <= 8).then(|| Self {
            header: header(id.into()),
            ..Self::data_frame(0, data)
        })
    }

    fn new_remote(id: impl Into<Id>, dlc: usize) -> Option<Self> {
        let length = u8::try_from(dlc).ok().filter(|length| *length <= 8)?;
        Some(Self {
            header: header(id.into()) | REMOTE,
            ..Self::remote_frame(0, length)
        })
    }

    fn is_extended(&self) -> bool {
        self.header.get() & EXTENDED != 0
    }

    fn is_remote_frame(&self) -> bool {
        self.is_remote()
    }

    fn id(&self) -> Id {
        self.id()
    }

    fn dlc(&self) -> usize {
        usize::from(self.length)
    }

    fn data(&self) -> &[u8] {
        self.payload()
    }
}

#[cfg(test)]
mod tests {
    use embedded_can::Frame as _;

    use super::*;

    #[test]
    fn only_a_frame_with_11_bits_has_a_standard_id() {
        let long = ExtendedId::new(0x604).unwrap();
        let longest = ExtendedId::MAX;
        let short = StandardId::new(0x604).unwrap();
        let cases = [
            (Frame::new(short, &[1]), Some(0x604)),
            (Frame::new_remote(short, 1), Some(0x604)),
            (Frame::new(long, &[1]), None),
            (Frame::new_remote(long, 1), None),
            (Frame::new(longest, &[1]), None),
        ];
        for (frame, standard_id) in cases {
            let frame = frame.unwrap();
            assert_eq!(frame.standard_id(), standard_id);
        }
    }

    #[test]
    fn an_identifier_comes_back_as_it_went_in() {
        for id in [0, 1, 0x7FF, 0x800, 0x1FFF_FFFF] {
            let id = ExtendedId::new(id).unwrap();
            assert_eq!(Frame::new_remote(id, 0).unwrap().id(), Id::Extended(id));
        }
        for id in [0, 1, 0x7FF] {
            let id = StandardId::new(id).unwrap();
            assert_eq!(Frame::new(id, &[]).unwrap().id(), Id::Standard(id));
        }
    }
}

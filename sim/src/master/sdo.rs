//! The SDO client: expedited and segmented transfers on the default channel (600h and 580h + node-ID).

use canopen::Frame;

use super::{Failure, Line, Master};

/// A number or string as it travels in an SDO.
pub trait Value: Sized {
    /// From the bytes of an upload; `None` if their length does not fit.
    fn from_bytes(bytes: &[u8]) -> Option<Self>;
    /// The bytes of a download.
    fn to_bytes(&self) -> Vec<u8>;
}

macro_rules! numbers {
    ($($number:ty),*) => { $(
        impl Value for $number {
            fn from_bytes(bytes: &[u8]) -> Option<Self> {
                Some(<$number>::from_le_bytes(bytes.try_into().ok()?))
            }
            fn to_bytes(&self) -> Vec<u8> {
                self.to_le_bytes().to_vec()
            }
        }
    )* };
}

numbers!(u8, u16, u32, u64, i8, i16, i32, i64);

impl Value for String {
    fn from_bytes(bytes: &[u8]) -> Option<Self> {
        Self::from_utf8(bytes.to_vec()).ok()
    }
    fn to_bytes(&self) -> Vec<u8> {
        self.as_bytes().to_vec()
    }
}

impl Value for Vec<u8> {
    fn from_bytes(bytes: &[u8]) -> Option<Self> {
        Some(bytes.to_vec())
    }
    fn to_bytes(&self) -> Vec<u8> {
        self.clone()
    }
}

impl<L: Line> Master<L> {
    /// Reads an object.
    ///
    /// # Errors
    /// [`Failure::Abort`] if the device refuses, [`Failure::WrongValue`] if the length does not fit the type,
    /// [`Failure::Timeout`] or [`Failure::Unexpected`] if the device does not keep to the protocol.
    pub fn read<T: Value>(&mut self, node: u8, index: u16, sub: u8) -> Result<T, Failure> {
        let bytes = self.upload(node, index, sub)?;
        T::from_bytes(&bytes).ok_or_else(|| Failure::WrongValue {
            expected: format!("{index:04X}h:{sub:02X} as {}", std::any::type_name::<T>()),
            got: format!("{bytes:02X?}"),
        })
    }

    /// Writes an object, expedited up to four bytes, segmented beyond.
    ///
    /// # Errors
    /// As [`Master::read`].
    pub fn write<T: Value>(
        &mut self,
        node: u8,
        index: u16,
        sub: u8,
        value: T,
    ) -> Result<(), Failure> {
        let bytes = value.to_bytes();
        match bytes.len() {
            1..=4 => self.download_expedited(node, index, sub, &bytes),
            _ => self.download_segmented(node, index, sub, &bytes),
        }
    }

    /// Sends one SDO request and waits for its answer, whatever it is.
    ///
    /// # Errors
    /// [`Failure::Timeout`] if none came.
    pub fn sdo_request(&mut self, node: u8, request: [u8; 8]) -> Result<[u8; 8], Failure> {
        let answer_id = 0x580 + u16::from(node);
        let answer = |frame: &Frame| (frame.standard_id() == Some(answer_id)).then_some(*frame);
        // Answers nobody waited for would be taken for this one's.
        while self.line.inbox().take_from(0, answer).is_some() {}
        self.send_data(0x600 + u16::from(node), &request);
        let frame = self.wait_for(
            &format!("an SDO answer {answer_id:03X}"),
            self.answer_time,
            answer,
        )?;
        frame.full_payload().copied().ok_or(Failure::Unexpected {
            expected: "eight bytes".to_owned(),
            got: frame,
            at: self.now(),
        })
    }

    fn upload(&mut self, node: u8, index: u16, sub: u8) -> Result<Vec<u8>, Failure> {
        let [low, high] = index.to_le_bytes();
        let answer = self.transfer(node, index, sub, [0x40, low, high, sub, 0, 0, 0, 0])?;
        let [command, _, _, _, data @ ..] = answer;
        self.check(
            node,
            answer,
            command & 0xE0 == 0x40 && answer[1..4] == [low, high, sub],
        )?;
        if command & 0x02 != 0 {
            let unused = if command & 0x01 != 0 {
                usize::from(command >> 2 & 0x03)
            } else {
                0
            };
            return Ok(data[..4 - unused].to_vec());
        }
        let announced = (command & 0x01 != 0).then(|| u32::from_le_bytes(data));
        let mut bytes = Vec::new();
        let mut toggle = 0x00;
        loop {
            let answer = self.transfer(node, index, sub, [0x60 | toggle, 0, 0, 0, 0, 0, 0, 0])?;
            let [command, data @ ..] = answer;
            self.check(node, answer, command & 0xF0 == toggle)?;
            bytes.extend_from_slice(&data[..7 - usize::from(command >> 1 & 0x07)]);
            toggle ^= 0x10;
            if command & 0x01 != 0 {
                break;
            }
        }
        match announced {
            Some(size) if size as usize != bytes.len() => Err(Failure::WrongValue {
                expected: format!("{size} bytes of {index:04X}h:{sub:02X}"),
                got: format!("{} bytes", bytes.len()),
            }),
            _ => Ok(bytes),
        }
    }

    fn download_expedited(
        &mut self,
        node: u8,
        index: u16,
        sub: u8,
        bytes: &[u8],
    ) -> Result<(), Failure> {
        let [low, high] = index.to_le_bytes();
        let unused = 4 - bytes.len() as u8;
        let mut request = [0x23 | unused << 2, low, high, sub, 0, 0, 0, 0];
        request[4..4 + bytes.len()].copy_from_slice(bytes);
        let answer = self.transfer(node, index, sub, request)?;
        self.check(node, answer, answer[..4] == [0x60, low, high, sub])
    }

    /// Writes an object in segments, whatever its length.
    ///
    /// # Errors
    /// As [`Master::read`].
    pub fn download_segmented(
        &mut self,
        node: u8,
        index: u16,
        sub: u8,
        bytes: &[u8],
    ) -> Result<(), Failure> {
        let [low, high] = index.to_le_bytes();
        let [a, b, c, d] = (bytes.len() as u32).to_le_bytes();
        let answer = self.transfer(node, index, sub, [0x21, low, high, sub, a, b, c, d])?;
        self.check(node, answer, answer[..4] == [0x60, low, high, sub])?;
        let mut toggle = 0x00;
        let mut rest = bytes;
        loop {
            let (part, after) = rest.split_at(rest.len().min(7));
            let mut request = [0; 8];
            request[0] = toggle | (7 - part.len() as u8) << 1 | u8::from(after.is_empty());
            request[1..=part.len()].copy_from_slice(part);
            let answer = self.transfer(node, index, sub, request)?;
            self.check(node, answer, answer[0] == 0x20 | toggle)?;
            if after.is_empty() {
                return Ok(());
            }
            rest = after;
            toggle ^= 0x10;
        }
    }

    /// A request and its answer; an abort of the device is a failure.
    fn transfer(
        &mut self,
        node: u8,
        index: u16,
        sub: u8,
        request: [u8; 8],
    ) -> Result<[u8; 8], Failure> {
        let answer = self.sdo_request(node, request)?;
        match answer {
            [0x80, _, _, _, code @ ..] => Err(Failure::Abort {
                index,
                sub,
                code: u32::from_le_bytes(code),
            }),
            _ => Ok(answer),
        }
    }

    fn check(&self, node: u8, answer: [u8; 8], good: bool) -> Result<(), Failure> {
        if good {
            return Ok(());
        }
        Err(Failure::Unexpected {
            expected: "the answer to this SDO request".to_owned(),
            got: Frame::data_frame(0x580 + u16::from(node), &answer),
            at: self.now(),
        })
    }
}

//! An object that the firmware serves piece by piece.

use canopen::cia301::sdo::{AbortCode, Completion};

/// Its value, and what has been done with it.
#[derive(Debug)]
pub struct Stream {
    pub value: Vec<u8>,
    /// What is being written; `None` while nothing is.
    pub incoming: Option<Vec<u8>>,
    /// Whether the size is told before the value is read.
    pub knows_size: bool,
    /// By so much the size that is told is too large.
    pub missing: u32,
    /// The position that can neither be read nor written.
    pub fails_at: Option<(usize, AbortCode)>,
    pub completion: Completion,
    pub abandoned: usize,
}

impl Default for Stream {
    fn default() -> Self {
        Self {
            value: Vec::new(),
            incoming: None,
            knows_size: true,
            missing: 0,
            fails_at: None,
            completion: Completion::Now,
            abandoned: 0,
        }
    }
}

impl Stream {
    pub fn size(&self) -> Option<u32> {
        self.knows_size
            .then_some(self.value.len() as u32 + self.missing)
    }

    pub fn read_at(&self, position: u32, into: &mut [u8]) -> Result<usize, AbortCode> {
        let rest = &self.value[position as usize..];
        let length = rest.len().min(into.len());
        self.check(position as usize + length)?;
        into[..length].copy_from_slice(&rest[..length]);
        Ok(length)
    }

    pub fn begin_write(&mut self) -> Result<(), AbortCode> {
        assert!(self.incoming.is_none(), "one client at a time");
        self.incoming = Some(Vec::new());
        Ok(())
    }

    pub fn write_at(&mut self, position: u32, data: &[u8]) -> Result<(), AbortCode> {
        let incoming = self.incoming.as_mut().expect("a write has begun");
        assert_eq!(
            incoming.len(),
            position as usize,
            "in order, each byte once"
        );
        incoming.extend_from_slice(data);
        let length = incoming.len();
        self.check(length).inspect_err(|_| self.incoming = None)
    }

    pub fn end_write(&mut self, length: u32) -> Result<Completion, AbortCode> {
        self.value = self.incoming.take().expect("a write has begun");
        assert_eq!(self.value.len(), length as usize);
        Ok(self.completion)
    }

    pub fn abandon_write(&mut self) {
        assert!(self.incoming.take().is_some(), "a write has begun");
        self.abandoned += 1;
    }

    fn check(&self, end: usize) -> Result<(), AbortCode> {
        match self.fails_at {
            Some((position, code)) if end > position => Err(code),
            _ => Ok(()),
        }
    }
}

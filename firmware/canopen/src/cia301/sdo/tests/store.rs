//! Two objects: a string in RAM, and a value of the application.

use std::vec::Vec;

use super::{STREAM, STRING};
use crate::cia301::sdo::{AbortCode, Completion, Objects, Streams, Value};
use crate::od::{Attributes, DataType, Entry};
use crate::wire::sdo::Multiplexer;

static STRING_ENTRY: Entry = entry(0x2000, 4000, 0);
static STREAM_ENTRY: Entry = entry(0x2001, 0, Attributes::STREAMED);

const fn entry(index: u16, size: u16, attributes: u16) -> Entry {
    let attributes = Attributes::READ | Attributes::WRITE | attributes;
    Entry::new((index, 0), DataType::OctetString, 0, size, attributes)
}

/// The values; both objects show the same one.
#[derive(Debug, Default)]
pub(super) struct Store {
    pub(super) value: Vec<u8>,
    /// What is being streamed in.
    pub(super) incoming: Option<Vec<u8>>,
    /// Whether the application tells the size before it is read.
    pub(super) hides_size: bool,
    /// The owner takes its time.
    pub(super) is_slow: bool,
}

impl Store {
    fn completion(&self) -> Completion {
        if self.is_slow {
            Completion::Later
        } else {
            Completion::Now
        }
    }
}

impl Streams for Store {
    fn read_at(
        &mut self,
        _: &'static Entry,
        position: u32,
        into: &mut [u8],
    ) -> Result<usize, AbortCode> {
        let rest = &self.value[position as usize..];
        let length = rest.len().min(into.len());
        into[..length].copy_from_slice(&rest[..length]);
        Ok(length)
    }

    fn write_at(&mut self, _: &'static Entry, position: u32, data: &[u8]) -> Result<(), AbortCode> {
        let incoming = self.incoming.as_mut().expect("a write has begun");
        assert_eq!(
            incoming.len(),
            position as usize,
            "each byte once, in order"
        );
        incoming.extend_from_slice(data);
        Ok(())
    }

    fn abandon_write(&mut self, _: &'static Entry) {
        assert!(self.incoming.take().is_some(), "a write has begun");
    }
}

impl Objects for Store {
    fn readable(&mut self, object: Multiplexer) -> Result<&'static Entry, AbortCode> {
        self.writable(object)
    }

    fn number(&self, _: &Entry) -> Option<u32> {
        None
    }

    fn open(&mut self, entry: &'static Entry) -> Result<Value<'_>, AbortCode> {
        if entry.is_streamed() {
            let size = (!self.hides_size).then_some(self.value.len() as u32);
            Ok(Value::Streamed(entry, size))
        } else {
            Ok(Value::Variable(&self.value))
        }
    }

    fn writable(&mut self, object: Multiplexer) -> Result<&'static Entry, AbortCode> {
        match object {
            STRING => Ok(&STRING_ENTRY),
            STREAM => Ok(&STREAM_ENTRY),
            _ => Err(AbortCode::NoObject),
        }
    }

    fn write(&mut self, _: &'static Entry, value: &[u8]) -> Result<Completion, AbortCode> {
        self.value = value.to_vec();
        Ok(self.completion())
    }

    fn begin_write(&mut self, _: &'static Entry, _: Option<u32>) -> Result<(), AbortCode> {
        assert!(self.incoming.is_none(), "the write before has ended");
        self.incoming = Some(Vec::new());
        Ok(())
    }

    fn end_write(&mut self, _: &'static Entry, length: u32) -> Result<Completion, AbortCode> {
        self.value = self.incoming.take().expect("a write has begun");
        assert_eq!(self.value.len(), length as usize);
        Ok(self.completion())
    }
}

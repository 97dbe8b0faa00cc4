//! A DOMAIN that lies in memory: bytes of any length up to what there is room for.
//!
//! It has the room twice. What a client writes goes into the spare half, and takes the place of the value when all of it has
//! come; so a transfer that ends early changes nothing, and meanwhile the old value can be read.

use super::{Sink, Source};
use crate::application::Completion;
use crate::copy::copy;
use crate::od::Dictionary;
use crate::wire::sdo::AbortCode;

/// The value of a DOMAIN, in two buffers `B` of the same size. It is empty at first, whatever the buffers hold.
///
/// The buffers change places after each write: let `B` be a reference or a vector and not an array.
#[derive(Debug)]
pub struct Domain<B> {
    value: B,
    spare: B,
    /// Bytes of the value.
    length: usize,
}

impl<B: AsRef<[u8]> + AsMut<[u8]>> Domain<B> {
    /// An empty value that may grow to the size of the smaller buffer.
    pub const fn new(value: B, spare: B) -> Self {
        Self {
            value,
            spare,
            length: 0,
        }
    }

    /// The value: what a client has written last.
    pub fn value(&self) -> &[u8] {
        self.value.as_ref().get(..self.length).unwrap_or_default()
    }

    /// Where the next value is written: no more than the other half can hold, too.
    fn room(&mut self) -> &mut [u8] {
        let capacity = self.capacity();
        self.spare.as_mut().get_mut(..capacity).unwrap_or_default()
    }

    /// The longest value, in bytes.
    pub fn capacity(&self) -> usize {
        self.value.as_ref().len().min(self.spare.as_ref().len())
    }
}

impl<D: Dictionary, B: AsRef<[u8]> + AsMut<[u8]>> Source<D> for Domain<B> {
    fn size(&mut self, _: &D) -> Result<Option<u32>, AbortCode> {
        Ok(u32::try_from(self.length).ok())
    }

    fn read_at(&mut self, _: &D, position: u32, into: &mut [u8]) -> Result<usize, AbortCode> {
        let rest = usize::try_from(position)
            .ok()
            .and_then(|position| self.value().get(position..))
            .unwrap_or_default();
        copy(into, rest);
        Ok(rest.len().min(into.len()))
    }
}

impl<D: Dictionary, B: AsRef<[u8]> + AsMut<[u8]>> Sink<D> for Domain<B> {
    fn begin(&mut self, _: &D, size: Option<u32>) -> Result<(), AbortCode> {
        let fits = |size: u32| usize::try_from(size).is_ok_and(|size| size <= self.capacity());
        if size.is_none_or(fits) {
            Ok(())
        } else {
            Err(AbortCode::LengthTooHigh)
        }
    }

    fn write_at(&mut self, _: &D, position: u32, data: &[u8]) -> Result<(), AbortCode> {
        let room = usize::try_from(position)
            .ok()
            .and_then(|from| self.room().get_mut(from..)?.get_mut(..data.len()))
            .ok_or(AbortCode::LengthTooHigh)?;
        copy(room, data);
        Ok(())
    }

    fn end(&mut self, _: &mut D, length: u32) -> Result<Completion, AbortCode> {
        self.length = usize::try_from(length).map_err(|_| AbortCode::LengthTooHigh)?;
        core::mem::swap(&mut self.value, &mut self.spare);
        Ok(Completion::Now)
    }
}

#[cfg(test)]
mod tests;

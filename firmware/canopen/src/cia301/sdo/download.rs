//! Download: the client writes an object, expedited or in segments.

use super::AbortCode;
use super::server::{Objects, Server, Transfer};
use crate::copy::copy;
use crate::od::Entry;
use crate::time::Instant;
use crate::wire::sdo::{Multiplexer, Payload, Response};

impl Server {
    /// Writes a short value at once; gets ready for the segments of a long one.
    pub(super) fn initiate_download<O: Objects>(
        &mut self,
        object: Multiplexer,
        payload: Payload<'_>,
        now: Instant,
        objects: &mut O,
    ) -> Option<[u8; 8]> {
        self.reset();
        self.object = object;
        let answer = Response::InitiateDownload(object).emit();
        let result = objects.writable(object).and_then(|entry| {
            match payload {
                Payload::Expedited(value) => objects.write(entry, value),
                Payload::ExpeditedUnsized(value) => objects.write(entry, of_length(value, entry)),
                Payload::Segmented(size) => {
                    self.open_download(entry, size, now)?;
                    return Ok(None);
                }
            }
            .map(Some)
        });
        match result {
            Ok(Some(completion)) => self.written(completion, answer),
            Ok(None) => Some(answer),
            Err(code) => Some(self.abort(object, code)),
        }
    }

    /// Refuses at once what can only fail at the end.
    fn open_download(
        &mut self,
        entry: &'static Entry,
        size: Option<u32>,
        now: Instant,
    ) -> Result<(), AbortCode> {
        let announced = match size {
            Some(size) => Some(announced_size(size, entry, self.buffer.len())?),
            None => None,
        };
        self.toggle = false;
        self.length = 0;
        self.transfer = Transfer::Download { entry, announced };
        self.wait(now);
        Ok(())
    }

    /// Adds a segment to the buffer; after the last one the object is written.
    pub(super) fn download_segment<O: Objects>(
        &mut self,
        toggle: bool,
        data: &[u8],
        last: bool,
        now: Instant,
        objects: &mut O,
    ) -> Option<[u8; 8]> {
        let Transfer::Download { entry, announced } = self.transfer else {
            return Some(self.abort_stray_segment());
        };
        if self.is_too_late(now) {
            return Some(self.abort(self.object, AbortCode::TimedOut));
        }
        if toggle != self.toggle {
            return Some(self.abort(self.object, AbortCode::ToggleNotAlternated));
        }
        if let Err(code) = self.append(data, entry, announced) {
            return Some(self.abort(self.object, code));
        }
        let answer = Response::DownloadSegment { toggle }.emit();
        if last {
            if announced.is_some_and(|announced| self.length < announced) {
                return Some(self.abort(self.object, AbortCode::LengthTooLow));
            }
            let value = self.buffer.get(..self.length).unwrap_or(&[]);
            return match objects.write(entry, value) {
                Ok(completion) => self.written(completion, answer),
                Err(code) => Some(self.abort(self.object, code)),
            };
        }
        self.toggle = !toggle;
        self.wait(now);
        Some(answer)
    }

    fn append(
        &mut self,
        data: &[u8],
        entry: &Entry,
        announced: Option<usize>,
    ) -> Result<(), AbortCode> {
        let length = self.length.saturating_add(data.len());
        let most = announced.unwrap_or(usize::from(entry.size));
        if length > most {
            return Err(AbortCode::LengthTooHigh);
        }
        let room = self
            .buffer
            .get_mut(self.length..length)
            .ok_or(AbortCode::OutOfMemory)?;
        copy(room, data);
        self.length = length;
        Ok(())
    }
}

/// The bytes that count in an expedited value whose length the client does not tell: as many as the object has.
fn of_length<'a>(value: &'a [u8; 4], entry: &Entry) -> &'a [u8] {
    value.get(..usize::from(entry.size)).unwrap_or(value)
}

/// Whether an object can take the size that the client announces.
fn announced_size(size: u32, entry: &Entry, room: usize) -> Result<usize, AbortCode> {
    let expected = u32::from(entry.size);
    if size > expected {
        return Err(AbortCode::LengthTooHigh);
    }
    if size < expected && !entry.data_type.is_variable() {
        return Err(AbortCode::LengthTooLow);
    }
    // Not beyond 16 bits, because the size of an entry is not.
    let size = size as usize;
    if size > room {
        return Err(AbortCode::OutOfMemory);
    }
    Ok(size)
}

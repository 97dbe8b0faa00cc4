//! Download: the client writes an object, expedited or in segments.

use super::objects::{Objects, Streams};
use super::server::{Place, Server, Step};
use super::{AbortCode, Completion};
use crate::copy::copy;
use crate::od::Entry;
use crate::time::{Instant, has_come};
use crate::wire::sdo::{Multiplexer, Payload, Response};

impl<B: AsRef<[u8]> + AsMut<[u8]>> Server<B> {
    /// Writes a short value at once; gets ready for the segments of a long one.
    pub(super) fn initiate_download<O: Objects>(
        &mut self,
        object: Multiplexer,
        payload: Payload<'_>,
        now: Instant,
        objects: &mut O,
    ) {
        self.begin(objects);
        self.object = object;
        let answer = Response::InitiateDownload(object).emit();
        let entry = match objects.writable(object) {
            Ok(entry) => entry,
            Err(code) => return self.abort(object, code, objects),
        };
        let (value, is_sized) = match payload {
            Payload::Expedited(value) => (value, true),
            Payload::ExpeditedUnsized(value) => (of_length(value, entry), false),
            Payload::Segmented(size) => {
                return match self.open_download(entry, size, objects) {
                    Ok(()) => {
                        self.step = Step::Download;
                        self.toggle = false;
                        self.wait(now);
                        self.answers.push(answer);
                    }
                    Err(code) => self.abort(object, code, objects),
                };
            }
        };
        if O::ARE_THERE && entry.is_streamed() {
            return self.stream_expedited(entry, value, is_sized, answer, objects);
        }
        match objects.write(entry, value) {
            // Nothing is open.
            Ok(Completion::Now) => self.answers.push(answer),
            Ok(Completion::Later) => self.written(Completion::Later, answer),
            Err(code) => self.abort(object, code, objects),
        }
    }

    /// A short value of an object that takes it piece by piece: one piece.
    #[cold]
    #[inline(never)]
    fn stream_expedited<O: Objects>(
        &mut self,
        entry: &'static Entry,
        value: &[u8],
        is_sized: bool,
        answer: [u8; 8],
        objects: &mut O,
    ) {
        let size = is_sized.then_some(value.len() as u32);
        let result = self
            .open_download(entry, size, objects)
            .and_then(|()| self.append(value, objects));
        match result {
            Ok(()) => self.finish(answer, objects),
            Err(code) => self.abort(self.object, code, objects),
        }
    }

    /// Gets ready for the data of a long value, and refuses at once what can only fail at the end.
    pub(super) fn open_download<O: Objects>(
        &mut self,
        entry: &'static Entry,
        size: Option<u32>,
        objects: &mut O,
    ) -> Result<(), AbortCode> {
        let bound = u32::from(entry.size());
        let is_streamed = O::ARE_THERE && entry.is_streamed();
        let most = if is_streamed && bound == 0 {
            u32::MAX
        } else {
            bound
        };
        if let Some(size) = size {
            if size > most {
                return Err(AbortCode::LengthTooHigh);
            }
            if size < bound && !is_streamed && !entry.is_variable() {
                return Err(AbortCode::LengthTooLow);
            }
        }
        if is_streamed {
            objects.begin_write(entry, size)?;
            self.place = Place::Sink(entry);
        } else {
            if size.is_some_and(|size| size as usize > self.buffer.as_ref().len()) {
                return Err(AbortCode::OutOfMemory);
            }
            self.place = Place::Buffer(entry);
        }
        self.size = size;
        self.most = size.unwrap_or(most);
        self.position = 0;
        Ok(())
    }

    /// Adds a segment; after the last one the object is written.
    pub(super) fn download_segment<O: Objects>(
        &mut self,
        toggle: bool,
        data: &[u8],
        last: bool,
        now: Instant,
        objects: &mut O,
    ) {
        if let Err(code) = self.take_segment(toggle, data, now, objects) {
            return self.abort(self.object, code, objects);
        }
        let answer = Response::DownloadSegment { toggle }.emit();
        if last {
            return self.finish(answer, objects);
        }
        self.toggle = !toggle;
        self.wait(now);
        self.answers.push(answer);
    }

    #[inline]
    fn take_segment<O: Objects>(
        &mut self,
        toggle: bool,
        data: &[u8],
        now: Instant,
        objects: &mut O,
    ) -> Result<(), AbortCode> {
        if self.step != Step::Download {
            return Err(self.stray());
        }
        if has_come(self.deadline, now) {
            return Err(AbortCode::TimedOut);
        }
        if toggle != self.toggle {
            return Err(AbortCode::ToggleNotAlternated);
        }
        self.append(data, objects)
    }

    /// Takes the next bytes of the value.
    #[inline]
    pub(super) fn append<S: Streams>(
        &mut self,
        data: &[u8],
        streams: &mut S,
    ) -> Result<(), AbortCode> {
        let position = self.position;
        let end = position.saturating_add(data.len() as u32);
        if end > self.most {
            return Err(AbortCode::LengthTooHigh);
        }
        if let Place::Sink(entry) = self.place
            && S::ARE_THERE
        {
            if let Err(code) = streams.write_at(entry, position, data) {
                self.place = Place::Nowhere;
                return Err(code);
            }
        } else {
            let room = self
                .buffer
                .as_mut()
                .get_mut(position as usize..end as usize)
                .ok_or(AbortCode::OutOfMemory)?;
            copy(room, data);
        }
        self.position = end;
        Ok(())
    }

    /// All data is there: writes the object.
    pub(super) fn finish<O: Objects>(&mut self, answer: [u8; 8], objects: &mut O) {
        let length = self.position;
        let result = if self.size.is_some_and(|size| length < size) {
            Err(AbortCode::LengthTooLow)
        } else {
            match self.place {
                Place::Sink(entry) if O::ARE_THERE => {
                    self.place = Place::Nowhere;
                    objects.end_write(entry, length)
                }
                Place::Buffer(entry) => {
                    let value = self.buffer.as_ref().get(..length as usize);
                    objects.write(entry, value.unwrap_or(&[]))
                }
                _ => Err(AbortCode::General),
            }
        };
        match result {
            Ok(completion) => self.written(completion, answer),
            Err(code) => self.abort(self.object, code, objects),
        }
    }
}

/// The bytes that count in an expedited value whose length the client does not tell: as many as the object has.
fn of_length<'a>(value: &'a [u8; 4], entry: &Entry) -> &'a [u8] {
    if entry.size() == 0 {
        return value;
    }
    value.get(..usize::from(entry.size())).unwrap_or(value)
}

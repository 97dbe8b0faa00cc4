//! Upload: the client reads an object, expedited or in segments.

use super::server::{Objects, Server, Transfer};
use super::{AbortCode, SDO_BUFFER};
use crate::copy::copy;
use crate::time::Instant;
use crate::wire::sdo::{Multiplexer, Payload, Response};

/// Data bytes of one segment.
const SEGMENT: usize = 7;

impl Server {
    /// Sends a short value at once; takes a snapshot of a long one, and of an empty string, whose length 0 only the
    /// segmented form can tell.
    pub(super) fn initiate_upload<O: Objects>(
        &mut self,
        object: Multiplexer,
        now: Instant,
        objects: &mut O,
    ) -> [u8; 8] {
        self.reset();
        let value = match objects.read(object) {
            Ok(value) => value,
            Err(code) => return self.abort(object, code),
        };
        let payload = if matches!(value.len(), 1..=4) {
            Payload::Expedited(value)
        } else {
            let Some(room) = self.buffer.get_mut(..value.len()) else {
                return self.abort(object, AbortCode::OutOfMemory);
            };
            copy(room, value);
            self.length = value.len();
            self.object = object;
            self.toggle = false;
            self.transfer = Transfer::Upload { position: 0 };
            self.wait(now);
            // At most SDO_BUFFER.
            Payload::Segmented(Some(self.length as u32))
        };
        Response::InitiateUpload { object, payload }.emit()
    }

    /// Sends the next seven bytes of the snapshot.
    pub(super) fn upload_segment(&mut self, toggle: bool, now: Instant) -> [u8; 8] {
        let Transfer::Upload { position } = self.transfer else {
            return self.abort_stray_segment();
        };
        if self.is_too_late(now) {
            return self.abort(self.object, AbortCode::TimedOut);
        }
        if toggle != self.toggle {
            return self.abort(self.object, AbortCode::ToggleNotAlternated);
        }
        let next = position.saturating_add(SEGMENT);
        let last = next >= self.length;
        let end = next.min(self.length).min(SDO_BUFFER);
        let data = self.buffer.get(position..end).unwrap_or(&[]);
        let answer = Response::UploadSegment { toggle, data, last }.emit();
        if last {
            self.reset();
        } else {
            self.transfer = Transfer::Upload { position: next };
            self.toggle = !toggle;
            self.wait(now);
        }
        answer
    }
}

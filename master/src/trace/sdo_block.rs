//! SDO block transfers in words (CiA 301, 7.2.4.3.8 to 7.2.4.3.16). Within a sub-block a segment may look like any other frame, so it is
//! followed who is sending segments.

/// A block transfer under way.
#[derive(Clone, Debug)]
pub(super) struct Block {
    /// Whether the client sends the segments.
    pub(super) is_download: bool,
    /// Whether the next frame of the sender is a segment.
    is_streaming: bool,
    /// The number of the last segment of all, once it came.
    last: Option<u8>,
    /// What has been confirmed.
    taken: Vec<u8>,
    /// The segments of this sub-block, as far as none is missing.
    segments: Vec<u8>,
}

impl Block {
    pub(super) fn new(is_download: bool) -> Self {
        Self {
            is_download,
            is_streaming: false,
            last: None,
            taken: Vec::new(),
            segments: Vec::new(),
        }
    }

    /// Whether this frame of the sender is a segment: any but an abort, while segments come.
    pub(super) fn is_segment(&self, frame: &[u8; 8]) -> bool {
        self.is_streaming && frame[0] != 0x80
    }

    /// The receiver is ready for segments.
    pub(super) fn go_ahead(&mut self) {
        self.is_streaming = true;
    }

    /// A segment.
    pub(super) fn segment(&mut self, frame: &[u8; 8]) -> String {
        let [command, data @ ..] = frame;
        let number = command & 0x7F;
        if usize::from(number) == self.segments.len() / data.len() + 1 {
            self.segments.extend_from_slice(data);
        }
        if command & 0x80 == 0 {
            return format!("SDO block segment {number}");
        }
        self.last = Some(number);
        format!("SDO block segment {number}, the last")
    }

    /// The receiver has taken so many segments of this sub-block; what came behind them comes again.
    pub(super) fn confirm(&mut self, count: u8) -> String {
        self.segments.truncate(7 * usize::from(count));
        self.taken.append(&mut self.segments);
        self.is_streaming = self.last != Some(count);
        self.last = None;
        format!("SDO block: taken up to segment {count}")
    }

    /// The whole value; in the last segment so many bytes mean nothing.
    pub(super) fn value(mut self, unused: u8) -> Vec<u8> {
        let length = self.taken.len().saturating_sub(unused.into());
        self.taken.truncate(length);
        self.taken
    }
}

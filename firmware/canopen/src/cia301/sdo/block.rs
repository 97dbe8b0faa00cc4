//! What both directions of block transfer keep of the sub-block under way.

/// The sub-block under way, and the checksum of all data so far.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    /// Both sides make the checksum.
    pub(super) has_crc: bool,
    /// Of the data before [`Block::checked`].
    pub(super) crc: u16,
    /// Upload: up to this position the checksum is made; what is sent again is in it already.
    pub(super) checked: u32,
    /// Download: the last segment taken. Upload: the last segment sent.
    pub(super) seqno: u8,
    /// Upload: segments of this sub-block.
    pub(super) size: u8,
    /// Upload: the position of the first segment.
    pub(super) base: u32,
    /// Upload: the last segment sent is the last of all, with so many bytes that hold nothing.
    pub(super) last: Option<u8>,
    /// Download: the newest segment behind a gap, which was not taken; 0 for none.
    pub(super) ahead: u8,
    /// Download: byte 0 of the segment that closed the sub-block before, 0 for none.
    pub(super) closing: u8,
    /// Download: the last segment of all. How many of its bytes count is told at the end of the transfer.
    pub(super) held: [u8; 7],
    /// Download: the client was told again what has arrived.
    pub(super) is_reminded: bool,
    /// Download: with the last reminder a sub-block was confirmed that the client may not have finished.
    pub(super) is_cut: bool,
}

impl Block {
    pub(super) const fn new() -> Self {
        Self {
            has_crc: false,
            crc: 0,
            checked: 0,
            seqno: 0,
            size: 0,
            base: 0,
            last: None,
            ahead: 0,
            closing: 0,
            held: [0; 7],
            is_reminded: false,
            is_cut: false,
        }
    }
}

//! The concise DCF (CiA 302-3, 1F22h): what a master writes into a node, in its order.

/// One value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Write {
    pub(super) index: u16,
    pub(super) sub: u8,
    pub(super) bytes: Vec<u8>,
}

/// The number of values, then index, sub-index, length and bytes of each, the low byte first. Empty without values.
pub(super) fn bytes(writes: &[Write]) -> Vec<u8> {
    if writes.is_empty() {
        return Vec::new();
    }
    let length = |count: usize| u32::try_from(count).unwrap_or(u32::MAX).to_le_bytes();
    let mut stream = length(writes.len()).to_vec();
    for write in writes {
        stream.extend(write.index.to_le_bytes());
        stream.push(write.sub);
        stream.extend(length(write.bytes.len()));
        stream.extend(&write.bytes);
    }
    stream
}

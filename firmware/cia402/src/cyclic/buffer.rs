//! The data records of the interpolated position mode that wait (60C4h): first in, first out.

use heapless::Deque;
use motion::low;

/// 60C4h:1: the most records that wait.
pub const RECORDS: usize = 32;

/// How the buffer is set up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BufferConfiguration {
    /// 60C4h:2: how many records may wait.
    pub size: u32,
    /// 60C4h:3 = 1: in a full buffer a record takes the place of the oldest one. With 0 it is dropped.
    pub is_ring: bool,
    /// 60C4h:6 = 1; with 0 the buffer is empty and takes nothing.
    pub is_open: bool,
}

impl BufferConfiguration {
    /// What holds before anything is set up.
    pub const NONE: Self = Self {
        size: low::word(RECORDS),
        is_ring: false,
        is_open: true,
    };
}

/// The records.
#[derive(Debug)]
pub(crate) struct Buffer {
    records: Deque<i32, RECORDS>,
}

impl Buffer {
    pub(crate) const fn new() -> Self {
        Self {
            records: Deque::new(),
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.records.len()
    }

    pub(crate) fn clear(&mut self) {
        self.records.clear();
    }

    /// Takes a record.
    pub(crate) fn push(&mut self, record: i32, configuration: BufferConfiguration) {
        if !configuration.is_open {
            return;
        }
        let size = usize::try_from(configuration.size).unwrap_or(RECORDS);
        if self.records.len() >= size.min(RECORDS) {
            if !configuration.is_ring {
                return;
            }
            self.records.pop_front();
        }
        let _ = self.records.push_back(record);
    }

    /// The next record, removed.
    pub(crate) fn pop(&mut self) -> Option<i32> {
        self.records.pop_front()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filled(configuration: BufferConfiguration) -> std::vec::Vec<i32> {
        let mut buffer = Buffer::new();
        for record in 1..=5 {
            buffer.push(record, configuration);
        }
        std::iter::from_fn(|| buffer.pop()).collect()
    }

    #[test]
    fn m68_a_full_buffer_drops_what_comes() {
        let configuration = BufferConfiguration {
            size: 3,
            ..BufferConfiguration::NONE
        };
        assert_eq!(filled(configuration), [1, 2, 3]);
    }

    #[test]
    fn m68_a_full_ring_drops_the_oldest() {
        let configuration = BufferConfiguration {
            size: 3,
            is_ring: true,
            ..BufferConfiguration::NONE
        };
        assert_eq!(filled(configuration), [3, 4, 5]);
    }

    #[test]
    fn m68_a_cleared_buffer_takes_nothing() {
        let configuration = BufferConfiguration {
            is_open: false,
            ..BufferConfiguration::NONE
        };
        assert_eq!(filled(configuration), []);
    }
}

//! Pulses whose direction may be turned round, 2072h.

use motion::{Direction, PulseSink, Record, Ticks};

/// Pulses on their way to a motor that may turn the other way.
#[derive(Debug)]
pub(super) struct Directed<'a, S> {
    pub(super) pulses: &'a mut S,
    pub(super) is_reversed: bool,
}

impl<S: PulseSink> PulseSink for Directed<'_, S> {
    fn push(&mut self, record: Record) -> Result<(), Record> {
        if !self.is_reversed {
            return self.pulses.push(record);
        }
        self.pulses.push(turned(record)).map_err(turned)
    }

    fn push_all(&mut self, records: &[Record]) -> usize {
        if !self.is_reversed {
            return self.pulses.push_all(records);
        }
        let taken = records
            .iter()
            .take_while(|record| self.push(**record).is_ok());
        taken.count()
    }

    fn pending(&self) -> Ticks {
        self.pulses.pending()
    }

    fn free(&self) -> usize {
        self.pulses.free()
    }
}

/// The same pulses the other way.
const fn turned(record: Record) -> Record {
    Record {
        direction: match record.direction {
            Direction::Forward => Direction::Reverse,
            Direction::Reverse => Direction::Forward,
        },
        ..record
    }
}

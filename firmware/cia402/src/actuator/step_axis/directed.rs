//! Pulses whose direction may be turned round, 2072h.

use motion::{PulseSink, Record, Ticks};

/// Records that are turned round before they are handed on: as many as a time slice takes, as a rule.
const AT_ONCE: usize = 4;

/// Pulses on their way to a motor that may turn the other way.
#[derive(Debug)]
pub(crate) struct Directed<'a, S> {
    pub(crate) pulses: &'a mut S,
    pub(crate) is_reversed: bool,
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
        let mut taken = 0_usize;
        for part in records.chunks(AT_ONCE) {
            let Some(first) = part.first() else {
                break;
            };
            let mut others = [*first; AT_ONCE];
            for (other, record) in others.iter_mut().zip(part) {
                *other = turned(*record);
            }
            let others = others.get(..part.len()).unwrap_or_default();
            let number = self.pulses.push_all(others);
            taken = taken.wrapping_add(number);
            if number < part.len() {
                break;
            }
        }
        taken
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
        direction: record.direction.reversed(),
        ..record
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::Directed;
    use motion::{Direction, PulseSink, Record, Ticks};

    /// Takes as many as it has room for, and knows how often it was asked.
    #[derive(Debug, Default)]
    struct Sink {
        capacity: usize,
        taken: Vec<Record>,
        asked: usize,
    }

    impl PulseSink for Sink {
        fn push(&mut self, record: Record) -> Result<(), Record> {
            if self.taken.len() == self.capacity {
                return Err(record);
            }
            self.taken.push(record);
            Ok(())
        }

        fn push_all(&mut self, records: &[Record]) -> usize {
            self.asked += 1;
            let number = records.len().min(self.capacity - self.taken.len());
            self.taken.extend_from_slice(&records[..number]);
            number
        }

        fn pending(&self) -> Ticks {
            0
        }

        fn free(&self) -> usize {
            self.capacity - self.taken.len()
        }
    }

    #[test]
    fn records_are_turned_round_several_at_once_and_none_is_lost_or_taken_twice() {
        let record = |number: u32| Record {
            period: 100 + number,
            repeat: 3,
            width: 20,
            direction: if number.is_multiple_of(3) {
                Direction::Reverse
            } else {
                Direction::Forward
            },
        };
        let records: Vec<_> = (0..10).map(record).collect();
        for is_reversed in [false, true] {
            for capacity in 0..12 {
                let mut sink = Sink {
                    capacity,
                    ..Sink::default()
                };
                let mut directed = Directed {
                    pulses: &mut sink,
                    is_reversed,
                };
                assert_eq!(directed.push_all(&records), capacity.min(10));
                assert!(sink.asked <= 3);
                for (taken, record) in sink.taken.iter().zip(&records) {
                    let direction = if is_reversed {
                        record.direction.reversed()
                    } else {
                        record.direction
                    };
                    let wanted = Record {
                        direction,
                        ..*record
                    };
                    assert_eq!(*taken, wanted);
                }
            }
        }
    }
}

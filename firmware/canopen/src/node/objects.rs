//! The object dictionary as the SDO server sees it: with access rights, and with the rules of the objects' owners.

use super::services::Services;
use crate::application::Application;
use crate::cia301::cob_ids;
use crate::cia301::emergency;
use crate::cia301::sdo::{self, AbortCode, Completion, Others, Value};
use crate::od::{self, Attributes, Counts, Dictionary, Entry, Location};
use crate::time::Instant;
use crate::wire::sdo::Multiplexer;

/// What an SDO request can reach.
pub(super) struct Objects<'a, D: Dictionary, A> {
    pub(super) dictionary: &'a mut D,
    pub(super) application: &'a mut A,
    pub(super) services: &'a mut Services<D::Counts>,
    /// What other clients have under way.
    pub(super) others: Others<'a, <D::Counts as Counts>::SdoBuffer>,
    pub(super) now: Instant,
    /// A number that the application has, while it is read.
    pub(super) number: [u8; 8],
}

/// What the application serves piece by piece.
pub(super) struct Streams<'a, D, A> {
    pub(super) dictionary: &'a D,
    pub(super) application: &'a mut A,
}

impl<D: Dictionary, A: Application<D>> sdo::Streams for Streams<'_, D, A> {
    const ARE_THERE: bool = D::FEATURES.streams;
    const HAVE_BLOCK_TRANSFER: bool = D::FEATURES.block_transfer;

    fn read_at(
        &mut self,
        entry: &'static Entry,
        position: u32,
        into: &mut [u8],
    ) -> Result<usize, AbortCode> {
        self.application
            .read_at(self.dictionary, entry, position, into)
    }

    fn write_at(
        &mut self,
        entry: &'static Entry,
        position: u32,
        data: &[u8],
    ) -> Result<(), AbortCode> {
        self.application
            .write_at(self.dictionary, entry, position, data)
    }

    fn abandon_write(&mut self, entry: &'static Entry) {
        self.application.abandon_write(self.dictionary, entry);
    }
}

impl<D: Dictionary, A: Application<D>> Objects<'_, D, A> {
    fn streams(&mut self) -> Streams<'_, D, A> {
        Streams {
            dictionary: self.dictionary,
            application: self.application,
        }
    }
}

impl<D: Dictionary, A: Application<D>> sdo::Streams for Objects<'_, D, A> {
    const ARE_THERE: bool = D::FEATURES.streams;
    const HAVE_BLOCK_TRANSFER: bool = D::FEATURES.block_transfer;

    fn read_at(
        &mut self,
        entry: &'static Entry,
        position: u32,
        into: &mut [u8],
    ) -> Result<usize, AbortCode> {
        self.streams().read_at(entry, position, into)
    }

    fn write_at(
        &mut self,
        entry: &'static Entry,
        position: u32,
        data: &[u8],
    ) -> Result<(), AbortCode> {
        self.streams().write_at(entry, position, data)
    }

    fn abandon_write(&mut self, entry: &'static Entry) {
        self.streams().abandon_write(entry);
    }
}

impl<D: Dictionary, A: Application<D>> Objects<'_, D, A> {
    /// Writes an object whose owner is a service. `is_alone` is false for one of many that only fit each other as a whole.
    #[inline(never)]
    pub(super) fn write_communication_object(
        &mut self,
        entry: &'static Entry,
        value: &[u8],
        is_alone: bool,
    ) -> Result<Completion, AbortCode> {
        let is_changed = self.changes_configuration(entry, value);
        let checked = od::check(D::TABLE, entry, value);
        // To a value out of range the owner's answer is the more exact one: nine entries of a mapping are "too long
        // for a PDO", not "too high".
        if !matches!(
            checked,
            Err(AbortCode::ValueTooHigh | AbortCode::ValueTooLow)
        ) {
            checked?;
        }
        self.services.validate(self.dictionary, entry, value)?;
        checked?;
        if is_alone && cob_ids::is_taken(self.dictionary, entry, value) {
            return Err(AbortCode::InvalidValue);
        }
        if D::FEATURES.parameters && self.services.parameters.is_order(entry) {
            self.services.parameters.begin(entry);
            return Ok(Completion::Later);
        }
        od::put(self.dictionary, entry, value);
        self.services.written(self.dictionary, entry, self.now);
        self.end_write_of_value(entry, is_changed);
        Ok(Completion::Now)
    }

    /// A number that the application has: all of it at once, so that no part of it is older than the others.
    #[cold]
    #[inline(never)]
    fn fetch(&mut self, entry: &Entry) -> Result<&[u8], AbortCode> {
        let size = usize::from(entry.size());
        let room = self.number.get_mut(..size).ok_or(AbortCode::General)?;
        let given = self.application.read_at(self.dictionary, entry, 0, room)?;
        let whole = (given == size).then_some(&*room);
        whole.ok_or(AbortCode::NotTransferable)
    }

    /// A number for the application, which has passed every check.
    #[cold]
    #[inline(never)]
    fn give_number(&mut self, entry: &Entry, value: &[u8]) -> Result<Completion, AbortCode> {
        self.application
            .write_at(self.dictionary, entry, 0, value)?;
        Ok(Completion::Now)
    }

    /// Whether this value would make the configuration another one than that of 1020h.
    #[inline(always)] // Mostly nothing is dated.
    fn changes_configuration(&self, entry: &Entry, value: &[u8]) -> bool {
        D::FEATURES.configuration_date
            && self.services.parameters.is_dated(entry)
            && self.is_another(entry, value)
    }

    #[inline(never)]
    fn is_another(&self, entry: &Entry, value: &[u8]) -> bool {
        od::value(self.dictionary, entry) != value
    }

    /// A value was written: transmit PDOs may have to look at it, and the date of the configuration may be void.
    #[inline]
    fn end_write_of_value(&mut self, entry: &Entry, is_changed: bool) {
        self.services.values_changed();
        if is_changed {
            self.services.parameters.changed(self.dictionary, entry);
        }
    }
}

/// Whether an object belongs to the communication profile, whose objects this crate owns (CiA 301, table 39). The clock 1013h and what belongs to
/// the operating system of the device, 1023h to 1026h, are the application's.
pub(super) const fn is_communication_object(entry: &Entry) -> bool {
    entry.index >> 12 == 1 && !matches!(entry.index, 0x1013 | 0x1023..=0x1026)
}

impl<D: Dictionary, A: Application<D>> sdo::Objects for Objects<'_, D, A> {
    #[inline]
    fn readable(&mut self, object: Multiplexer) -> Result<&'static Entry, AbortCode> {
        let entry = od::find::<D>(object.index, object.sub)?;
        if !entry.attributes.has(Attributes::READ) {
            return Err(AbortCode::WriteOnly);
        }
        if entry.index == 0x1003 {
            emergency::is_present(self.dictionary, entry)?;
        }
        Ok(entry)
    }

    #[inline]
    fn number(&self, entry: &Entry) -> Option<u32> {
        od::raw(self.dictionary, entry)
    }

    fn open(&mut self, entry: &'static Entry) -> Result<Value<'_>, AbortCode> {
        Ok(match entry.location() {
            Location::Ram(_) => Value::Variable(od::value(self.dictionary, entry)),
            Location::Rom(offset) => Value::Constant(od::constant(D::TABLE, offset, entry.size())),
            Location::Application if !D::FEATURES.streams => Value::Constant(&[]),
            Location::Application if !entry.is_streamed() => Value::Variable(self.fetch(entry)?),
            Location::Application => {
                if self.others.are_reading(entry) {
                    // Theirs may be gone. They have to be told before the application turns to another one.
                    self.application
                        .read_at(self.dictionary, entry, 0, &mut [])?;
                }
                Value::Streamed(entry, self.application.size(self.dictionary, entry)?)
            }
        })
    }

    #[inline]
    fn writable(&mut self, object: Multiplexer) -> Result<&'static Entry, AbortCode> {
        let entry = od::find::<D>(object.index, object.sub)?;
        if entry.attributes.has(Attributes::WRITE) {
            Ok(entry)
        } else {
            Err(AbortCode::ReadOnly)
        }
    }

    fn write(&mut self, entry: &'static Entry, value: &[u8]) -> Result<Completion, AbortCode> {
        if is_communication_object(entry) {
            return self.write_communication_object(entry, value, true);
        }
        let is_changed = self.changes_configuration(entry, value);
        od::check(D::TABLE, entry, value)?;
        self.application.validate(self.dictionary, entry, value)?;
        if D::FEATURES.streams && entry.attributes.has(Attributes::STREAMED) {
            return self.give_number(entry, value);
        }
        od::put_here(self.dictionary, entry, value);
        self.application.written(self.dictionary, entry);
        self.end_write_of_value(entry, is_changed);
        Ok(self.application.completion(self.dictionary, entry))
    }

    fn begin_write(&mut self, entry: &'static Entry, size: Option<u32>) -> Result<(), AbortCode> {
        if self.others.are_writing(entry) || self.others.are_reading(entry) {
            return Err(AbortCode::DeviceState);
        }
        self.application.begin_write(self.dictionary, entry, size)
    }

    fn end_write(&mut self, entry: &'static Entry, length: u32) -> Result<Completion, AbortCode> {
        // A reader that has begun since must not get the rest of another value.
        if self.others.are_reading(entry) {
            self.application.abandon_write(self.dictionary, entry);
            return Err(AbortCode::DeviceState);
        }
        self.services.values_changed();
        self.application.end_write(self.dictionary, entry, length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::od::DataType;

    #[test]
    fn the_clock_and_the_operating_system_are_the_applications() {
        for (index, is_ours) in [
            (0x1000, true),
            (0x1012, true),
            (0x1013, false),
            (0x1014, true),
            (0x1022, true),
            (0x1023, false),
            (0x1026, false),
            (0x1027, true),
            (0x1FFF, true),
            (0x2000, false),
        ] {
            let entry = Entry::new((index, 0), DataType::Unsigned8, 0, Entry::NO_LIMITS, 0);
            assert_eq!(is_communication_object(&entry), is_ours, "{index:04X}h");
        }
    }
}

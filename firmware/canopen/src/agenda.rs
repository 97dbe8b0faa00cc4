//! What waits for the bus, and when there is something to do: the one place that both are kept in.
//!
//! Each object that may send has a bit and an identifier; of those that wait the lowest identifier goes first. A bit is set by what makes
//! its object due, and cleared when its last frame is taken. Nothing is sorted, so another COB-ID is one number written: mostly
//! one object waits, or a few. Of times there is one, the next: who starts a timer moves it forward ([`Agenda::wake_at`]). What is to be done at
//! once has a bit in place of a time: timers that have changed ([`Agenda::wake`]), values that transmit PDOs may look at ([`Agenda::look`]).

use crate::outbox::Pending;
use crate::slots::{Slots, Unused};
use crate::time::{Instant, earlier, has_come};

/// A moment that has always come: a fresh agenda is zero, and all is looked at first.
const AT_ONCE: Instant = Instant::from_ticks(0);

/// Timers have begun, or ended.
const TIMERS: u8 = 1 << 0;
/// Transmit PDOs have to be looked at.
const VALUES: u8 = 1 << 1;

/// Something that sends: the place of its bit. Of equal identifiers the lower number goes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Object(u8);

/// What an [`Object`] is, and its number among its kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// One of [`Object::BOOT_UP`] and the others with a name.
    Service,
    /// The transmit PDO with this number.
    Pdo(usize),
    /// The SDO server with this number.
    Answer(usize),
}

impl Object {
    /// Before everything else, because it must be the first frame of all.
    pub const BOOT_UP: Self = Self(0);
    pub const EMERGENCY: Self = Self(1);
    pub const SYNC: Self = Self(2);
    pub const TIME: Self = Self(3);
    pub const HEARTBEAT: Self = Self(4);
    pub const GUARDING: Self = Self(5);
    pub const LSS: Self = Self(6);

    /// What [`Agenda::pending`] has given.
    pub(crate) const fn of(pending: &Pending) -> Self {
        Self(pending.place)
    }

    /// The transmit PDO with this number, 0 for the first.
    pub const fn pdo(number: usize) -> Self {
        Self(SERVICES.wrapping_add(number) as u8)
    }

    /// The SDO server with this number, 0 for the first, of a device with so many transmit PDOs.
    pub const fn answer(number: usize, pdos: usize) -> Self {
        Self::pdo(pdos.wrapping_add(number))
    }

    /// Its bit in a [`Word`].
    #[inline]
    const fn bit(self) -> u32 {
        1 << (self.0 & 31)
    }

    /// What it is, in a device with so many transmit PDOs.
    #[inline]
    pub const fn kind(self, pdos: usize) -> Kind {
        let Some(number) = (self.0 as usize).checked_sub(SERVICES) else {
            return Kind::Service;
        };
        match number.checked_sub(pdos) {
            None => Kind::Pdo(number),
            Some(number) => Kind::Answer(number),
        }
    }
}

/// Services that send, beside PDO and SDO.
pub const SERVICES: usize = 7;

/// What becomes of a frame that waits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SendPolicy {
    /// It is sent, and those behind it: SDO, emergency messages, error control, LSS.
    Every,
    /// A newer one takes its place: SYNC, TIME, PDO.
    Newest,
    /// As well, and it goes behind the SYNC of the device.
    AtSync,
}

/// Places of objects in a word.
const PLACES: usize = u32::BITS as usize;

/// The bits of 32 objects that follow each other.
#[derive(Debug)]
pub struct Word {
    waiting: u32,
    /// Those whose newest frame alone is sent.
    newest: u32,
    /// Those of transmit PDOs that answer a SYNC.
    synchronous: u32,
    cob_ids: [u16; PLACES],
}

impl Unused for Word {
    const UNUSED: Self = Self {
        waiting: 0,
        newest: 0,
        synchronous: 0,
        cob_ids: [0; PLACES],
    };
}

/// What there is to do at a moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Due {
    Nothing,
    /// Transmit PDOs have to be looked at, and no time has come.
    Values,
    /// A time has come, or timers have changed; there may be values as well.
    All,
}

/// The agenda of a device; `W` are words for all that may send.
#[derive(Debug)]
pub struct Agenda<W> {
    words: W,
    /// Nothing may be sent.
    pub(crate) is_mute: bool,
    /// What is to be done at once: [`TIMERS`], [`VALUES`].
    due: u8,
    /// Nothing else is to be done before this moment.
    next: Instant,
    /// No timer but that of the heartbeat ends before this moment.
    timers: Instant,
    /// No transmit PDO has to be looked at before this moment.
    values: Instant,
}

impl<W: Slots<Word>> Agenda<W> {
    /// Nothing waits.
    pub(crate) const fn new() -> Self {
        Self {
            words: W::UNUSED,
            is_mute: false,
            due: 0,
            next: AT_ONCE,
            timers: AT_ONCE,
            values: AT_ONCE,
        }
    }

    /// The object that may send first. No synchronous PDO goes before a SYNC of the device that waits.
    #[inline(always)]
    pub(crate) fn first(&self) -> Option<Object> {
        match self.words.as_ref() {
            // Mostly nothing waits, or one object.
            [Word { waiting: 0, .. }] => None,
            [word] if word.waiting.is_power_of_two() && !self.is_mute => {
                Some(Object(word.waiting.trailing_zeros() as u8))
            }
            _ => self.search(),
        }
    }

    #[inline(never)]
    fn search(&self) -> Option<Object> {
        let has_sync = self.waits(Object::SYNC);
        // The identifier, and behind it the place.
        let mut lowest = u32::MAX;
        let mut base = 0;
        for word in self.words.as_ref() {
            let mut waiting = word.waiting;
            if has_sync {
                waiting &= !word.synchronous;
            }
            while waiting != 0 && !self.is_mute {
                let place = waiting.trailing_zeros();
                waiting &= waiting.wrapping_sub(1);
                let cob_id = word.cob_ids.get(place as usize).copied().unwrap_or(0);
                lowest = lowest.min(u32::from(cob_id) << 8 | base | place);
            }
            base = base.wrapping_add(u32::BITS);
        }
        (lowest != u32::MAX).then_some(Object(lowest as u8))
    }

    #[inline]
    fn word(&self, Object(place): Object) -> Option<&Word> {
        self.words.as_ref().get(usize::from(place >> 5))
    }

    #[inline]
    fn word_mut(&mut self, Object(place): Object) -> Option<&mut Word> {
        self.words.as_mut().get_mut(usize::from(place >> 5))
    }

    /// Whether an object waits.
    #[inline]
    pub(crate) fn waits(&self, object: Object) -> bool {
        self.word(object)
            .is_some_and(|word| word.waiting & object.bit() != 0)
    }

    /// An object waits from now on, or does not.
    #[inline]
    pub(crate) fn set(&mut self, object: Object, waits: bool) {
        if let Some(word) = self.word_mut(object) {
            word.waiting = with(word.waiting, object.bit(), waits);
        }
    }

    /// What [`Agenda::first`] is to those who ask for room.
    #[inline]
    pub(crate) fn pending(&self) -> Option<Pending> {
        let object = self.first()?;
        let word = self.word(object)?;
        let sync = self.cob_id(Object::SYNC);
        let answers_sync = word.synchronous & object.bit() != 0 && sync != 0;
        Some(Pending {
            place: object.0,
            cob_id: self.cob_id(match object {
                Object::BOOT_UP => Object::HEARTBEAT,
                _ => object,
            }),
            is_process_data: word.newest & object.bit() != 0,
            follows: answers_sync.then_some(sync),
        })
    }

    /// The identifier of an object.
    #[inline]
    pub(crate) fn cob_id(&self, object: Object) -> u16 {
        let place = usize::from(object.0) % PLACES;
        let word = self.word(object);
        word.and_then(|word| word.cob_ids.get(place).copied())
            .unwrap_or(0)
    }

    /// An object sends with this identifier from now on, 0 for SYNC that another device sends. If it waits, it goes on waiting.
    #[inline(never)]
    pub(crate) fn name(&mut self, object: Object, cob_id: u16, policy: SendPolicy) {
        if let Some(word) = self.word_mut(object) {
            word.newest = with(word.newest, object.bit(), policy != SendPolicy::Every);
            word.synchronous = with(word.synchronous, object.bit(), policy == SendPolicy::AtSync);
            if let Some(place) = word.cob_ids.get_mut(usize::from(object.0) % PLACES) {
                *place = cob_id;
            }
        }
    }

    /// Nothing waits any more but LSS answers, which belong to no NMT state.
    pub(crate) fn clear(&mut self) {
        let lss = self.waits(Object::LSS);
        for word in self.words.as_mut() {
            word.waiting = 0;
        }
        self.set(Object::LSS, lss);
    }

    /// What there is to do.
    #[inline]
    pub(crate) const fn due(&self, now: Instant) -> Due {
        match self.due {
            0 if !has_come(self.next, now) => Due::Nothing,
            VALUES if !has_come(self.next, now) => Due::Values,
            _ => Due::All,
        }
    }

    /// Whether timers beside that of the heartbeat have to be looked at.
    #[inline]
    pub(crate) const fn has_timers(&self, now: Instant) -> bool {
        self.due & TIMERS != 0 || has_come(self.timers, now)
    }

    /// Whether transmit PDOs have to be looked at.
    #[inline]
    pub(crate) const fn has_values(&self, now: Instant) -> bool {
        self.due & VALUES != 0 || has_come(self.values, now)
    }

    /// Nothing is to be done before this moment.
    #[inline]
    pub(crate) const fn next(&self) -> Instant {
        self.next
    }

    /// A timer has begun that ends at this moment.
    #[inline]
    pub(crate) const fn wake_at(&mut self, deadline: Instant) {
        // Mostly another one ends before, such as that of the segment before this one.
        if deadline.ticks() < self.timers.ticks() {
            self.timers = deadline;
            self.next = earlier(self.next, deadline);
        }
    }

    /// Timers have begun, or ended.
    #[inline]
    pub(crate) const fn wake(&mut self) {
        self.due |= TIMERS;
    }

    /// Transmit PDOs have to be looked at: a value may have changed, or an inhibit time is to begin.
    #[inline]
    pub(crate) const fn look(&mut self) {
        self.due |= VALUES;
    }

    /// All timers have been looked at; the next one of them ends at `deadline`.
    pub(crate) const fn set_timers(&mut self, deadline: Instant) {
        self.due &= !TIMERS;
        self.timers = deadline;
    }

    /// All transmit PDOs have been looked at; they want to be looked at again at `deadline`. Returns whether that is another moment than
    /// before.
    #[inline]
    pub(crate) const fn set_values(&mut self, deadline: Instant) -> bool {
        self.due &= !VALUES;
        let is_new = deadline.ticks() != self.values.ticks();
        self.values = deadline;
        is_new
    }

    /// All that was due is done; the heartbeat is due at this moment. Returns the next of all deadlines.
    #[inline]
    pub(crate) const fn set_next(&mut self, heartbeat: Instant) -> Instant {
        self.next = earlier(earlier(self.timers, self.values), heartbeat);
        self.next
    }
}

/// A word with these bits set, or without them.
#[inline]
const fn with(word: u32, bits: u32, are_set: bool) -> u32 {
    word & !bits | if are_set { bits } else { 0 }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use proptest::prelude::*;

    use super::*;

    /// As many transmit PDOs as two words have room for.
    const PDOS: usize = 56;

    #[test]
    fn every_object_is_known_by_its_number() {
        for number in 0..PDOS {
            assert_eq!(Object::pdo(number).kind(PDOS), Kind::Pdo(number));
        }
        for number in 0..128 {
            assert_eq!(
                Object::answer(number, PDOS).kind(PDOS),
                Kind::Answer(number)
            );
        }
        assert_eq!(Object::SYNC.kind(0), Kind::Service);
        assert_eq!(Object::LSS.kind(0), Kind::Service);
    }

    #[test]
    fn nothing_leaves_a_mute_device() {
        let mut agenda = Agenda::<[Word; 1]>::new();
        agenda.is_mute = true;
        agenda.name(Object::EMERGENCY, 0x084, SendPolicy::Every);
        agenda.set(Object::EMERGENCY, true);
        assert_eq!(agenda.first(), None);
        agenda.set(Object::BOOT_UP, true);
        assert_eq!(agenda.first(), None);
        agenda.is_mute = false;
        assert_eq!(agenda.first(), Some(Object::BOOT_UP));
        agenda.set(Object::BOOT_UP, false);
        assert_eq!(agenda.first(), Some(Object::EMERGENCY));
    }

    #[test]
    fn only_lss_outlives_a_reset() {
        let mut agenda = Agenda::<[Word; 2]>::new();
        let all = [
            Object::BOOT_UP,
            Object::LSS,
            Object::pdo(0),
            Object::pdo(40),
        ];
        for object in all {
            agenda.set(object, true);
        }
        agenda.clear();
        assert_eq!(
            all.map(|object| agenda.waits(object)),
            [false, true, false, false]
        );
    }

    proptest! {
        #[test]
        fn what_waits_leaves_in_the_order_of_identifiers_and_synchronous_pdos_behind_sync(
            cob_ids in prop::collection::vec(0x080_u16..0x700, 64),
            renamed in prop::collection::vec((0_usize..64, 0x080_u16..0x700), 0..20),
            waiting in any::<u64>(),
            synchronous in any::<u64>(),
        ) {
            let object = |place: usize| Object(place as u8);
            let is_in = |set: u64, place: usize| set >> place & 1 != 0;
            let answers_sync =
                |place: usize| place >= SERVICES && is_in(synchronous, place);
            let policy = |place| match answers_sync(place) {
                true => SendPolicy::AtSync,
                false => SendPolicy::Every,
            };
            let mut agenda = Agenda::<[Word; 2]>::new();
            let mut names = cob_ids;
            for (place, cob_id) in names.iter().enumerate() {
                agenda.name(object(place), *cob_id, policy(place));
                agenda.set(object(place), is_in(waiting, place));
            }
            // Who waits goes on waiting with another identifier.
            for (place, cob_id) in renamed {
                agenda.name(object(place), cob_id, policy(place));
                names[place] = cob_id;
            }
            let sync = usize::from(Object::SYNC.0);
            let is_behind_sync = |place| is_in(waiting, sync) && answers_sync(place);
            let mut expected: Vec<_> = (0..64).filter(|place| is_in(waiting, *place)).collect();
            // A synchronous PDO waits for SYNC; from then on the lowest identifier goes, as before.
            let mut in_order = Vec::new();
            let mut sync_waits = is_in(waiting, sync);
            while !expected.is_empty() {
                let ready = expected.iter().copied();
                let ready = ready.filter(|place| !(sync_waits && is_behind_sync(*place)));
                let next = ready.min_by_key(|place| (names[*place], *place)).unwrap();
                sync_waits &= next != sync;
                expected.retain(|place| *place != next);
                in_order.push(object(next));
            }
            let left: Vec<_> = core::iter::from_fn(|| {
                let first = agenda.first()?;
                agenda.set(first, false);
                Some(first)
            })
            .collect();
            prop_assert_eq!(left, in_order);
            prop_assert_eq!(agenda.first(), None);
        }
    }
}

//! What waits for the bus, and when there is something to do: the one place that both are kept in.
//!
//! Each object that may send has a bit, and the bits are in the order of identifiers: the lowest one that is set goes first. A bit is set
//! by what makes its object due, and cleared when its last frame is taken. Of times there is one, the next: who starts a timer moves
//! it forward ([`Agenda::wake_at`]), who changes a value that transmit PDOs may look at, too ([`Agenda::look`]).

use crate::od::{Slots, Unused};
use crate::time::{Instant, earlier};

/// No 11-bit identifier is equal to it.
const NO_COB_ID: u16 = u16::MAX;

/// A moment that has always come.
const AT_ONCE: Instant = Instant::from_ticks(0);

/// Something that sends. Of equal identifiers the lower number goes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Object(u8);

/// What an [`Object`] is, and its number among its kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Before everything else, because it must be the first frame of all.
    BootUp,
    Emergency,
    /// The transmit PDO with this number.
    Pdo(usize),
    Sync,
    Time,
    /// The SDO server with this number.
    Answer(usize),
    Heartbeat,
    Guarding,
    Lss,
}

impl Object {
    pub const BOOT_UP: Self = Self(0);
    pub const EMERGENCY: Self = Self(1);
    pub const SYNC: Self = Self(Self::FIRST_SERVICE);
    pub const TIME: Self = Self(Self::FIRST_SERVICE + 1);
    pub const HEARTBEAT: Self = Self(Self::FIRST_SERVICE + 2);
    pub const GUARDING: Self = Self(Self::FIRST_SERVICE + 3);
    pub const LSS: Self = Self(Self::FIRST_SERVICE + 4);

    const FIRST_PDO: u8 = 2;
    const FIRST_SERVICE: u8 = 120;
    const FIRST_ANSWER: u8 = 128;

    /// The transmit PDO with this number, 0 for the first.
    pub const fn pdo(number: usize) -> Self {
        Self(Self::FIRST_PDO.wrapping_add(number as u8))
    }

    /// The SDO server with this number, 0 for the first.
    pub const fn answer(number: usize) -> Self {
        Self(Self::FIRST_ANSWER.wrapping_add(number as u8))
    }

    /// Its number among the services; beyond all of them for a PDO or a server.
    const fn service(self) -> usize {
        match self.0 {
            number @ ..Self::FIRST_PDO => number as usize,
            number @ Self::FIRST_SERVICE.. => {
                (number - Self::FIRST_SERVICE + Self::FIRST_PDO) as usize
            }
            _ => SERVICES,
        }
    }

    /// What it is.
    #[inline]
    pub const fn kind(self) -> Kind {
        match self {
            Self(number @ Self::FIRST_ANSWER..) => {
                Kind::Answer((number - Self::FIRST_ANSWER) as usize)
            }
            Self::BOOT_UP => Kind::BootUp,
            Self::EMERGENCY => Kind::Emergency,
            Self(number @ ..Self::FIRST_SERVICE) => {
                Kind::Pdo(number.wrapping_sub(Self::FIRST_PDO) as usize)
            }
            Self::SYNC => Kind::Sync,
            Self::TIME => Kind::Time,
            Self::HEARTBEAT => Kind::Heartbeat,
            Self::GUARDING => Kind::Guarding,
            _ => Kind::Lss,
        }
    }
}

/// The place of an object in the order of identifiers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rank(u8);

impl Rank {
    /// Until [`Agenda::arrange`] tells.
    pub const FIRST: Self = Self(0);
}

/// Services that send, beside PDO and SDO.
const SERVICES: usize = 7;

/// Places of objects.
const PLACES: usize = u32::BITS as usize;

/// The bits of 32 objects that follow each other.
#[derive(Debug)]
pub struct Word {
    waiting: u32,
    /// Those of transmit PDOs that answer a SYNC.
    synchronous: u32,
    objects: [Object; PLACES],
}

impl Unused for Word {
    const UNUSED: Self = Self {
        waiting: 0,
        synchronous: 0,
        objects: [Object::BOOT_UP; PLACES],
    };
}

impl Word {
    /// Those of its objects that wait.
    fn waiting(&self) -> impl Iterator<Item = Object> {
        let objects = (0..).zip(self.objects);
        objects.filter_map(|(place, object)| (self.waiting >> place & 1 != 0).then_some(object))
    }
}

/// All that may send.
pub(crate) trait Senders {
    /// Calls `each` with every object, its identifier if it has one now, and whether it answers a SYNC.
    fn each(&self, each: &mut dyn FnMut(Object, Option<u16>, bool));

    /// The place of an object.
    fn place(&mut self, object: Object, rank: Rank);
}

/// The agenda of a device; `W` are words for all that may send.
#[derive(Debug)]
pub struct Agenda<W> {
    words: W,
    /// The places of the services, by [`Object::service`].
    services: [Rank; SERVICES],
    /// The device produces a SYNC that waits: no synchronous PDO goes before it.
    has_sync: bool,
    /// Nothing may be sent.
    pub(crate) is_mute: bool,
    /// Nothing is to be done before this moment.
    next: Instant,
    /// No timer but that of the heartbeat ends before this moment.
    timers: Instant,
    /// No transmit PDO has to be looked at before this moment.
    values: Instant,
}

impl<W: Slots<Word>> Agenda<W> {
    /// Nothing waits, and nothing may be sent.
    pub(crate) fn new() -> Self {
        Self {
            words: W::UNUSED,
            services: [Rank::FIRST; SERVICES],
            has_sync: false,
            is_mute: true,
            next: AT_ONCE,
            timers: AT_ONCE,
            values: AT_ONCE,
        }
    }

    /// The object that may send first.
    #[inline]
    pub(crate) fn first(&self) -> Option<Object> {
        for word in self.words.as_ref() {
            let mut waiting = word.waiting;
            // Mostly nothing does.
            if waiting == 0 {
                continue;
            }
            if self.has_sync {
                waiting &= !word.synchronous;
            }
            if waiting != 0 && !self.is_mute {
                return word.objects.get(waiting.trailing_zeros() as usize).copied();
            }
        }
        None
    }

    /// Whether the object at this place waits.
    #[inline]
    pub(crate) fn waits(&self, Rank(rank): Rank) -> bool {
        let word = self.words.as_ref().get(usize::from(rank >> 5));
        word.is_some_and(|word| word.waiting >> (rank & 31) & 1 != 0)
    }

    /// The object at this place waits from now on, or does not.
    #[inline]
    pub(crate) fn set(&mut self, Rank(rank): Rank, waits: bool) {
        if let Some(word) = self.words.as_mut().get_mut(usize::from(rank >> 5)) {
            let bit = 1 << (rank & 31);
            word.waiting = word.waiting & !bit | if waits { bit } else { 0 };
        }
    }

    /// A service waits from now on, or does not.
    #[inline(never)]
    pub(crate) fn put(&mut self, service: Object, waits: bool) {
        if service == Object::SYNC {
            self.has_sync = waits;
        }
        if let Some(rank) = self.services.get(service.service()) {
            self.set(*rank, waits);
        }
    }

    /// Puts the objects into the order of their identifiers; who waits goes on waiting.
    #[cold]
    #[inline(never)]
    pub(crate) fn arrange(&mut self, senders: &mut impl Senders) {
        let before = core::mem::replace(&mut self.words, W::UNUSED);
        let mut last = None;
        let mut rank = 0;
        for word in self.words.as_mut() {
            for place in 0..PLACES {
                let mut next: Option<((u16, Object), bool)> = None;
                senders.each(&mut |object, cob_id, is_synchronous| {
                    let key = (cob_id.unwrap_or(NO_COB_ID), object);
                    let is_left = last.is_none_or(|last| key > last);
                    if is_left && next.is_none_or(|(first, _)| key < first) {
                        next = Some((key, is_synchronous));
                    }
                });
                let Some((key, is_synchronous)) = next else {
                    return;
                };
                last = Some(key);
                let (_, object) = key;
                if let Some(at) = word.objects.get_mut(place) {
                    *at = object;
                }
                let waits = before.as_ref().iter().flat_map(Word::waiting);
                word.waiting |= u32::from({ waits }.any(|waiting| waiting == object)) << place;
                word.synchronous |= u32::from(is_synchronous) << place;
                senders.place(object, Rank(rank));
                if let Some(place) = self.services.get_mut(object.service()) {
                    *place = Rank(rank);
                }
                rank = rank.wrapping_add(1);
            }
        }
    }

    /// Nothing waits any more but LSS answers, which belong to no NMT state.
    pub(crate) fn clear(&mut self) {
        self.has_sync = false;
        for word in self.words.as_mut() {
            let lss = word
                .objects
                .iter()
                .position(|object| *object == Object::LSS);
            word.waiting &= lss.map_or(0, |place| 1 << place);
        }
    }

    /// Nothing is to be done before this moment.
    #[inline]
    pub(crate) const fn next(&self) -> Instant {
        self.next
    }

    /// No timer but that of the heartbeat ends before this moment.
    #[inline]
    pub(crate) const fn timers(&self) -> Instant {
        self.timers
    }

    /// No transmit PDO has to be looked at before this moment.
    #[inline]
    pub(crate) const fn values(&self) -> Instant {
        self.values
    }

    /// A timer has begun that ends at this moment.
    #[inline]
    pub(crate) const fn wake_at(&mut self, deadline: Instant) {
        self.timers = earlier(self.timers, deadline);
        self.next = earlier(self.next, deadline);
    }

    /// Timers have begun, or ended.
    #[inline]
    pub(crate) const fn wake(&mut self) {
        self.timers = AT_ONCE;
        self.next = AT_ONCE;
    }

    /// Transmit PDOs have to be looked at: a value may have changed, or an inhibit time is to begin.
    #[inline]
    pub(crate) const fn look(&mut self) {
        self.values = AT_ONCE;
        self.next = AT_ONCE;
    }

    /// All timers have been looked at; the next one of them ends at `deadline`.
    pub(crate) const fn set_timers(&mut self, deadline: Instant) {
        self.timers = deadline;
    }

    /// All transmit PDOs have been looked at; they want to be looked at again at `deadline`.
    pub(crate) const fn set_values(&mut self, deadline: Instant) {
        self.values = deadline;
    }

    /// All that was due is done; the heartbeat is due at this moment.
    pub(crate) const fn set_next(&mut self, heartbeat: Instant) {
        self.next = earlier(earlier(self.timers, self.values), heartbeat);
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use proptest::prelude::*;

    use super::*;

    /// Objects with their identifiers, and where they are.
    struct Device {
        objects: Vec<(Object, Option<u16>, bool)>,
        ranks: Vec<(Object, Rank)>,
    }

    impl Senders for Device {
        fn each(&self, each: &mut dyn FnMut(Object, Option<u16>, bool)) {
            for (object, cob_id, is_synchronous) in &self.objects {
                each(*object, *cob_id, *is_synchronous);
            }
        }

        fn place(&mut self, object: Object, rank: Rank) {
            self.ranks.retain(|(other, _)| *other != object);
            self.ranks.push((object, rank));
        }
    }

    impl Device {
        fn rank(&self, object: Object) -> Rank {
            self.ranks.iter().find(|(o, _)| *o == object).unwrap().1
        }

        fn cob_id(&self, object: Object) -> u16 {
            let found = self.objects.iter().find(|(o, _, _)| *o == object);
            found.unwrap().1.unwrap_or(NO_COB_ID)
        }
    }

    /// `pdos` transmit PDOs with these identifiers, a server and the services.
    fn some(pdos: &[u16]) -> Device {
        let mut objects: Vec<_> = pdos
            .iter()
            .enumerate()
            .map(|(number, cob_id)| (Object::pdo(number), Some(*cob_id), number % 2 == 0))
            .collect();
        objects.push((Object::BOOT_UP, Some(0), false));
        objects.push((Object::SYNC, Some(0x300), false));
        objects.push((Object::answer(0), Some(0x584), false));
        objects.push((Object::EMERGENCY, None, false));
        Device {
            objects,
            ranks: Vec::new(),
        }
    }

    fn drain(agenda: &mut Agenda<[Word; 2]>, senders: &Device) -> Vec<Object> {
        core::iter::from_fn(|| {
            let first = agenda.first()?;
            agenda.set(senders.rank(first), false);
            if first == Object::SYNC {
                agenda.put(first, false);
            }
            Some(first)
        })
        .collect()
    }

    #[test]
    fn every_object_is_known_by_its_number() {
        for number in 0..118 {
            assert_eq!(Object::pdo(number).kind(), Kind::Pdo(number));
        }
        for number in 0..128 {
            assert_eq!(Object::answer(number).kind(), Kind::Answer(number));
        }
        assert_eq!(Object::SYNC.kind(), Kind::Sync);
        assert_eq!(Object::LSS.kind(), Kind::Lss);
    }

    #[test]
    fn nothing_leaves_a_mute_device() {
        let mut senders = some(&[0x181]);
        let mut agenda = Agenda::<[Word; 2]>::new();
        agenda.arrange(&mut senders);
        agenda.put(Object::BOOT_UP, true);
        assert_eq!(agenda.first(), None);
        agenda.is_mute = false;
        assert_eq!(agenda.first(), Some(Object::BOOT_UP));
    }

    proptest! {
        #[test]
        fn what_waits_leaves_in_the_order_of_identifiers_and_synchronous_pdos_behind_sync(
            before in prop::collection::vec(0x181_u16..0x580, 0..40),
            seed in any::<u64>(),
            shift in 0_u16..0x100,
        ) {
            let mut senders = some(&before);
            let mut agenda = Agenda::<[Word; 2]>::new();
            agenda.is_mute = false;
            agenda.arrange(&mut senders);
            let waits = |place: usize| seed >> (place % 64) & 1 != 0;
            let mut waiting = Vec::new();
            for (place, (object, _, _)) in senders.objects.iter().enumerate() {
                if waits(place) {
                    agenda.set(senders.rank(*object), true);
                    waiting.push(*object);
                }
            }
            if waiting.contains(&Object::SYNC) {
                agenda.put(Object::SYNC, true);
            }
            // Other identifiers, and whoever waits goes on waiting.
            for (_, cob_id, _) in &mut senders.objects {
                *cob_id = cob_id.map(|cob_id| if cob_id == 0 { 0 } else { 0x181 + (cob_id ^ shift) % 0x400 });
            }
            agenda.arrange(&mut senders);
            let sync = waiting.contains(&Object::SYNC).then(|| senders.cob_id(Object::SYNC));
            let is_behind = |object: Object| {
                let found = senders.objects.iter().find(|(o, _, _)| *o == object);
                let key = (senders.cob_id(object), object);
                sync.is_some_and(|sync| found.unwrap().2 && key < (sync, Object::SYNC))
            };
            let (mut late, mut order): (Vec<_>, Vec<_>) =
                waiting.into_iter().partition(|object| is_behind(*object));
            let key = |object: &Object| (senders.cob_id(*object), *object);
            order.sort_by_key(key);
            late.sort_by_key(key);
            if let Some(at) = order.iter().position(|object| *object == Object::SYNC) {
                order.splice(at + 1..at + 1, late);
            }
            prop_assert_eq!(drain(&mut agenda, &senders), order);
        }
    }
}

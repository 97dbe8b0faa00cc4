//! The emergency producer: from errors that come and go to the error register, the history and the messages.

use core::ops::Range;

use super::active::{ActiveErrors, Meant};
use super::history::History;
use super::queue::EmergencyQueue;
use super::{Emergency, Message};
use crate::od::{Dictionary, place};
use crate::time::Instant;
use crate::wire::Frame;

/// An error as masters of this device are told of it, and its word in the history.
#[inline(always)]
fn told<D: Dictionary>(error: Message) -> (Message, u32) {
    let [low, high, _, number, ..] = error.0.to_le_bytes();
    let Some(told) = D::HABITS.error_mapping(u16::from_le_bytes([low, high])) else {
        return (error, error.history_word());
    };
    let mut info = told.info;
    let place = told.number_byte.and_then(|byte| byte.checked_sub(3));
    if let Some(place) = place.and_then(|place| info.get_mut(usize::from(place))) {
        *place = number;
    }
    let seen = Emergency {
        code: told.code,
        register: told.register,
        info,
    };
    let word = u32::from(told.history) << 16 | u32::from(told.code);
    (seen.message(), word)
}

/// The emergency producer of a device.
#[derive(Debug)]
pub struct Producer {
    active: ActiveErrors,
    pub(super) queue: EmergencyQueue,
}

impl Producer {
    /// A producer without errors, silent until [`Producer::configure`].
    pub const fn new() -> Self {
        Self {
            active: ActiveErrors::new(),
            queue: EmergencyQueue::new(),
        }
    }

    /// Forgets every error: NMT reset node. Whoever still sees its error reports it again.
    pub fn reset(&mut self) {
        self.active.reset();
        self.queue.clear();
    }

    /// The errors that stand: the code in the low half, the first two bytes of the manufacturer in the high one.
    pub fn standing(&self) -> impl Iterator<Item = u32> {
        self.active.words()
    }

    /// Drops the messages that wait, and has none until [`Producer::enter`]: communication starts anew, and a device without a
    /// node-ID has no emergency messages.
    pub fn drop_messages(&mut self) {
        self.queue.end();
    }

    /// The NMT state changed; `has_messages` says whether the new one has emergency messages. What comes in one that has none
    /// waits for one that has; what may leave already still does.
    pub fn enter(&mut self, has_messages: bool, now: Instant) {
        if has_messages {
            self.queue.start(now);
        } else {
            self.queue.stop();
        }
    }

    /// A master has stopped the device: nothing leaves any more.
    pub fn hold_back(&mut self) {
        self.queue.hold_back();
    }

    /// An error appeared. Nothing happens if it stands already.
    #[inline(always)]
    pub(crate) fn report<D: Dictionary>(
        &mut self,
        dictionary: &mut D,
        error: Message,
        now: Instant,
    ) {
        let (told, word) = told::<D>(error);
        if !self.active.add(error.with_register(told.register())) {
            return;
        }
        let register = self.show_register(dictionary);
        History::of::<D>().insert(dictionary, word);
        self.queue.push(told.with_register(register), now);
        if D::HABITS.tells_of_the_rest {
            self.queue
                .push(Message::NO_ERROR.with_register(register), now);
        }
    }

    /// The errors that stand are in the history, which has just been emptied: reset communication.
    pub fn show_history<D: Dictionary>(&self, dictionary: &mut D) {
        for error in self.active.all() {
            History::of::<D>().insert(dictionary, told::<D>(error).1);
        }
    }

    /// Tells of every error that stands, the oldest first: the first state with emergency messages is entered, and whoever listened
    /// before may not listen now.
    pub fn tell_all<D: Dictionary>(&mut self, now: Instant) {
        let register = self.active.register();
        for error in self.active.all() {
            let (told, _) = told::<D>(error);
            self.queue.push(told.with_register(register), now);
        }
    }

    /// These errors are gone. Nothing happens if none of them stood.
    pub fn clear<D: Dictionary>(&mut self, dictionary: &mut D, errors: Meant, now: Instant) {
        if !self.active.remove(errors) {
            return;
        }
        let register = self.show_register(dictionary);
        self.queue
            .push(Message::NO_ERROR.with_register(register), now);
    }

    /// Writes the error register to 1001h: after an error came or went, and after power-on values were loaded.
    #[inline]
    pub fn show_register<D: Dictionary>(&self, dictionary: &mut D) -> u8 {
        let register = self.active.register();
        if let Some(place) = dictionary.ram_mut().get_mut(register_place::<D>()) {
            *place = register;
        }
        register
    }

    /// Whether the error register or the history may lie in these places of RAM.
    pub fn shows_in<D: Dictionary>(places: &Range<u16>) -> bool {
        let bytes = usize::from(places.start)..usize::from(places.end);
        bytes.contains(&register_place::<D>()) || History::of::<D>().lies_in(&bytes)
    }

    /// The identifier of its messages; 0 while it is switched off.
    pub const fn cob_id(&self) -> u16 {
        self.queue.cob_id()
    }

    /// Whether a message may be sent now.
    #[inline]
    pub const fn is_pending(&self) -> bool {
        self.queue.is_released()
    }

    /// Whether messages keep a distance.
    #[inline]
    pub const fn has_inhibit_time(&self) -> bool {
        self.queue.has_inhibit_time()
    }

    /// Lets the inhibit time pass; it begins with the first call after a message has left.
    pub fn poll(&mut self, now: Instant) {
        self.queue.poll(now);
    }

    /// [`Producer::poll`] has nothing to do before this moment.
    pub fn deadline(&self) -> Instant {
        self.queue.deadline()
    }

    /// The message that may be sent now, removed.
    #[inline]
    pub fn take(&mut self) -> Option<Frame> {
        self.queue.take()
    }

    /// Messages that lost their room since power-on.
    pub fn overflows(&self) -> u32 {
        self.queue.overflows()
    }
}

/// Where object 1001h lies in RAM.
#[inline]
const fn register_place<D: Dictionary>() -> usize {
    const { place(D::TABLE, 0x1001, 0, 1) }
}

impl Default for Producer {
    fn default() -> Self {
        Self::new()
    }
}

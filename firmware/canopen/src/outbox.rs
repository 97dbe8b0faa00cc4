//! Between the device and the mailboxes of a CAN controller.
//!
//! A controller sends the lowest identifier of its few mailboxes first. So that an urgent frame never waits behind others, one of
//! them has to make way when all mailboxes are taken; it waits here, and goes back when there is room.
//!
//! The contract:
//! - The device is asked for a frame only when a mailbox takes it. Until then it waits in the device, in the place of its
//!   communication object, where process data is replaced by newer data.
//! - Of frames with the same identifier the older leaves first, but process data that waits here is void when the device has
//!   newer data for the same identifier: it leaves once, with the newest values.
//! - A PDO that answers a SYNC of the device waits until that has left, whatever their identifiers are.
//! - Nothing else is lost. When all places are taken no further frame has to make way.

use crate::Frame;

/// What the device would send next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pending {
    /// Its place among all that sends, for [`Sender::take`].
    pub place: u8,
    /// Its identifier, the lowest of what waits in the device.
    pub cob_id: u16,
    /// Whether newer data takes the place of older data: PDO, SYNC and TIME. SDO, emergency messages, error control and LSS are
    /// sent one and all.
    pub is_process_data: bool,
    /// The identifier of the SYNC that it answers, which the device has sent and which it must not overtake.
    pub follows: Option<u16>,
}

/// Who has frames to send.
pub trait Sender {
    /// What may leave first; `None` if nothing.
    fn pending(&self) -> Option<Pending>;

    /// The frame of what [`Sender::pending`] has just given.
    fn take(&mut self, next: &Pending) -> Option<Frame>;
}

/// The mailbox that a frame would get.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mailbox {
    /// Not before one that waits there has left: those that wait are more urgent, or one has the same identifier.
    None,
    /// A mailbox is free for it.
    Free,
    /// All are taken, and one of lower priority would make way for it.
    InPlaceOfAnother,
}

/// The transmit mailboxes of a CAN controller. Frames with one identifier leave in the order in which they are put.
pub trait Mailboxes {
    /// The mailbox that a frame with this 11-bit identifier would get.
    fn mailbox_for(&mut self, cob_id: u16) -> Mailbox;

    /// Whether a frame with this 11-bit identifier waits in a mailbox that one with a lower identifier may overtake.
    fn holds(&mut self, cob_id: u16) -> bool {
        let _ = cob_id;
        false
    }

    /// Takes the frame, for which there is room. Gives back the one that had to make way, or this one if there is no room after all.
    fn put(&mut self, frame: &Frame) -> Option<Frame>;

    /// What waits is void: the device starts anew, or the bit rate changes. A frame that is on the bus leaves.
    fn withdraw(&mut self) {}
}

/// Frames that had to make way, at most `PLACES` of them.
#[derive(Debug)]
pub struct Outbox<const PLACES: usize> {
    waiting: [Option<Frame>; PLACES],
    /// So many wait; mostly none.
    count: usize,
}

impl<const PLACES: usize> Outbox<PLACES> {
    /// Nothing waits.
    pub const fn new() -> Self {
        Self {
            waiting: [None; PLACES],
            count: 0,
        }
    }

    /// What waits is void: the device starts anew.
    pub fn clear(&mut self) {
        *self = Self::new();
    }

    /// Hands frames to the mailboxes, the most urgent first, until there is no room or nothing is left. To be called after each call
    /// of the device, and when a mailbox has become free.
    pub fn send(&mut self, device: &mut impl Sender, mailboxes: &mut impl Mailboxes) {
        loop {
            let is_ahead = |sync| self.holds(sync) || mailboxes.holds(sync);
            let must_wait = |next: &Pending| next.follows.is_some_and(is_ahead);
            let pending = device.pending().filter(|next| !must_wait(next));
            let of_device = pending.map(|pending| pending.cob_id);
            let (place, own) = match (self.first(), of_device) {
                (None, None) => return,
                (Some((place, own)), of_device) if of_device.is_none_or(|id| own <= id) => {
                    (Some(place), own)
                }
                (_, of_device) => (None, of_device.unwrap_or_default()),
            };
            if place.is_some()
                && pending.is_some_and(|next| next.is_process_data && next.cob_id == own)
            {
                // The device has newer data for it.
                self.remove(place);
                continue;
            }
            match mailboxes.mailbox_for(own) {
                Mailbox::None => return,
                Mailbox::InPlaceOfAnother if place.is_none() && self.is_full() => return,
                Mailbox::Free | Mailbox::InPlaceOfAnother => {}
            }
            let frame = match (place, &pending) {
                (Some(_), _) => self.remove(place),
                (None, Some(next)) => device.take(next),
                (None, None) => None,
            };
            let Some(frame) = frame else { return };
            if let Some(back) = mailboxes.put(&frame) {
                self.keep(back);
                if back.id() == frame.id() {
                    return;
                }
            }
        }
    }

    /// The most urgent frame that waits: its place and its identifier.
    #[inline]
    fn first(&self) -> Option<(usize, u16)> {
        match self.count {
            0 => None,
            _ => self.search(),
        }
    }

    #[inline(never)]
    fn search(&self) -> Option<(usize, u16)> {
        let waiting = self.waiting.iter().enumerate();
        waiting
            .filter_map(|(place, frame)| Some((place, frame.as_ref()?.standard_id()?)))
            .min_by_key(|(_, cob_id)| *cob_id)
    }

    fn holds(&self, cob_id: u16) -> bool {
        let mut waiting = self.waiting.iter().flatten();
        self.count != 0 && waiting.any(|frame| frame.standard_id() == Some(cob_id))
    }

    fn is_full(&self) -> bool {
        self.count == PLACES
    }

    fn remove(&mut self, place: Option<usize>) -> Option<Frame> {
        let frame = self.waiting.get_mut(place?)?.take()?;
        self.count = self.count.saturating_sub(1);
        Some(frame)
    }

    fn keep(&mut self, frame: Frame) {
        if let Some(free) = self.waiting.iter_mut().find(|place| place.is_none()) {
            *free = Some(frame);
            self.count = self.count.saturating_add(1);
        }
    }
}

impl<const PLACES: usize> Default for Outbox<PLACES> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests;

//! The three transmit mailboxes of the CAN controller.
//!
//! The controller offers the frame with the lowest identifier of its mailboxes to the bus, and repeats it until it has gone out. A frame gets a
//! mailbox only if it goes before everything that waits there, so two frames with the same identifier leave in the order they came. With all
//! three full, the lowest priority makes way: its withdrawal is asked for, and the urgent frame waits beside the mailboxes until the interrupt of
//! that. A frame that is on the bus already leaves; one that was withdrawn waits until the next mailbox is free. So nothing is lost, an urgent
//! frame never waits behind three others, and nobody waits for the controller.

use canopen::outbox::Mailbox;
use canopen::Frame;
use embedded_can::{ExtendedId, Frame as _, Id, StandardId};
use stm32f4xx_hal::pac::CAN1;

const MAILBOXES: usize = 3;

/// Bits of an identifier register: an extended identifier, a remote frame, a request.
const EXTENDED: u32 = 1 << 2;
const REMOTE: u32 = 1 << 1;
const REQUEST: u32 = 1 << 0;

/// Bits of CAN_TSR for mailbox 0; those of the next are eight bits further up: a request is over, the frame has left, withdraw it.
const COMPLETED: u32 = 1 << 0;
const HAS_LEFT: u32 = 1 << 1;
const WITHDRAW: u32 = 1 << 7;

/// Frames that wait beside the mailboxes.
pub struct Transmission {
    /// It waits for a mailbox that another one is to leave.
    urgent: Option<Frame>,
    /// It had to make way.
    withdrawn: Option<Frame>,
}

impl Transmission {
    /// Nothing waits.
    pub const fn new() -> Self {
        Self {
            urgent: None,
            withdrawn: None,
        }
    }

    /// What there is for a frame with this identifier.
    pub fn mailbox_for(&self, can: &CAN1, cob_id: u16) -> Mailbox {
        if self.urgent.is_some() || self.withdrawn.is_some() {
            // An interrupt comes first.
            return Mailbox::None;
        }
        let waiting = waiting(can);
        if waiting.iter().flatten().any(|id| *id <= cob_id) {
            Mailbox::None
        } else if waiting.iter().all(Option::is_some) {
            Mailbox::InPlaceOfAnother
        } else {
            Mailbox::Free
        }
    }

    /// Whether a frame with this identifier waits.
    pub fn holds(&self, can: &CAN1, cob_id: u16) -> bool {
        let mut beside = [&self.urgent, &self.withdrawn].into_iter().flatten();
        waiting(can).contains(&Some(cob_id))
            || beside.any(|frame| frame.standard_id() == Some(cob_id))
    }

    /// Takes a frame for which there is room, and gives back one that it has none for.
    pub fn put(&mut self, can: &CAN1, frame: &Frame) -> Option<Frame> {
        let Some(last) = last_in_order(waiting(can)) else {
            return write(can, frame);
        };
        if self.urgent.is_some() || self.withdrawn.is_some() {
            return Some(*frame);
        }
        self.urgent = Some(*frame);
        // SAFETY: a bit of the register, where a 0 does nothing.
        can.tsr()
            .write(|w| unsafe { w.bits(WITHDRAW << (8 * last)) });
        None
    }

    /// Everything that waits is void. A frame that is on the bus leaves.
    pub fn withdraw(&mut self, can: &CAN1) {
        *self = Self::new();
        let all = (0..MAILBOXES).fold(0, |bits, mailbox| bits | WITHDRAW << (8 * mailbox));
        // SAFETY: bits of the register, where a 0 does nothing.
        can.tsr().write(|w| unsafe { w.bits(all) });
    }

    /// Frames have left, or were withdrawn.
    pub fn on_interrupt(&mut self, can: &CAN1) {
        for mailbox in 0..MAILBOXES {
            let status = can.tsr().read().bits() >> (8 * mailbox);
            if status & COMPLETED == 0 {
                continue;
            }
            // SAFETY: a bit of the register, where a 0 does nothing; the flag goes with what it says of the frame.
            can.tsr()
                .write(|w| unsafe { w.bits(COMPLETED << (8 * mailbox)) });
            let makes_way = status & HAS_LEFT == 0 && self.urgent.is_some();
            if makes_way && self.withdrawn.is_none() {
                self.withdrawn = read(can, mailbox);
            }
        }
        self.urgent = self.urgent.take().and_then(|frame| write(can, &frame));
        if self.urgent.is_none() {
            self.withdrawn = self.withdrawn.take().and_then(|frame| write(can, &frame));
        }
    }
}

/// The identifiers of the frames that wait in the mailboxes: of an extended one the upper eleven bits.
fn waiting(can: &CAN1) -> [Option<u16>; MAILBOXES] {
    [0, 1, 2].map(|mailbox: usize| {
        let identifier = can.tx(mailbox).tir().read().bits();
        (identifier & REQUEST != 0).then_some((identifier >> 21) as u16)
    })
}

/// The mailbox whose frame would leave last, if all are taken.
fn last_in_order(waiting: [Option<u16>; MAILBOXES]) -> Option<usize> {
    let [Some(first), Some(second), Some(third)] = waiting else {
        return None;
    };
    let order = [(first, 0), (second, 1), (third, 2)];
    order.into_iter().max().map(|(_, mailbox)| mailbox)
}

/// Puts a frame into a free mailbox, or gives it back.
fn write(can: &CAN1, frame: &Frame) -> Option<Frame> {
    let Some(mailbox) = waiting(can).iter().position(Option::is_none) else {
        return Some(*frame);
    };
    let mailbox = can.tx(mailbox);
    let [a, b, c, d, e, f, g, h] = *frame.bytes();
    let remote = if frame.is_remote() { REMOTE } else { 0 };
    let identifier = match frame.id() {
        Id::Standard(id) => u32::from(id.as_raw()) << 21,
        Id::Extended(id) => id.as_raw() << 3 | EXTENDED,
    };
    // SAFETY: the mailbox is free until the request, which is the last; each value is one of its register: a frame has 8 bytes at most.
    unsafe {
        mailbox.tdtr().write(|w| w.bits(frame.length() as u32));
        mailbox
            .tdlr()
            .write(|w| w.bits(u32::from_le_bytes([a, b, c, d])));
        mailbox
            .tdhr()
            .write(|w| w.bits(u32::from_le_bytes([e, f, g, h])));
        mailbox
            .tir()
            .write(|w| w.bits(identifier | remote | REQUEST));
    }
    None
}

/// What lies in a mailbox.
fn read(can: &CAN1, mailbox: usize) -> Option<Frame> {
    let mailbox = can.tx(mailbox);
    let words = [mailbox.tdlr().read().bits(), mailbox.tdhr().read().bits()];
    let length = mailbox.tdtr().read().dlc().bits();
    frame(mailbox.tir().read().bits(), length, words)
}

/// A frame as the registers of a mailbox have it.
pub fn frame(identifier: u32, length: u8, [low, high]: [u32; 2]) -> Option<Frame> {
    let id = if identifier & EXTENDED == 0 {
        Id::Standard(StandardId::new((identifier >> 21) as u16)?)
    } else {
        Id::Extended(ExtendedId::new(identifier >> 3)?)
    };
    // A length of 9 to 15 on the bus is 8 bytes.
    let length = usize::from(length.min(8));
    if identifier & REMOTE != 0 {
        return Frame::new_remote(id, length);
    }
    let bytes = (u64::from(high) << 32 | u64::from(low)).to_le_bytes();
    Frame::new(id, bytes.get(..length)?)
}

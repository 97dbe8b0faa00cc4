//! The CAN controller (bxCAN): three transmit mailboxes, a receive FIFO of three frames, and error counters.
//!
//! - Sending: the controller offers the frame with the lowest identifier of its mailboxes to the bus, and repeats it
//!   until it has gone out. A frame gets a mailbox only if it goes before everything that waits there, so two frames
//!   with the same identifier leave in the order they came. With all three full, the lowest priority gives way: it is
//!   taken back and returned to be offered again ([`canopen::Outbox`]). So nothing is lost, and an urgent frame never waits
//!   behind three others.
//! - Receiving: every frame passes the filter. A frame that finds the FIFO full is lost and counted.
//! - Errors: the controller is error passive from 128 errors on, and bus-off after 256 transmit errors; each raises the error
//!   interrupt. It stays bus-off until it is started again, when the device says so, and 128 times 11 recessive bits have
//!   passed. What its mailboxes hold waits.
//! - Listening: in silent mode the controller takes part as always, but the dominant bits that it would send, such as an
//!   acknowledge, go to itself only. It shows the last error it saw, or that the last frame was whole.

use bxcan::filter::Mask32;
use bxcan::{Fifo, Interrupts};
use canopen::outbox::{Mailboxes, Room};
use canopen::{BitRate, ControllerState, Frame};
use embedded_can::{ExtendedId, Frame as _, Id, StandardId};
use stm32f4xx_hal::can::Can;
use stm32f4xx_hal::pac;

use super::bit_timing;
use crate::board::Receive;
use crate::clock;
use runtime::{Controller as _, Inbox, Unreachable};

/// CAN1 with all its filters.
pub struct Controller {
    can: bxcan::Can<Can<pac::CAN1>>,
}

impl Controller {
    /// A controller that is not on the bus yet. It takes frames of every identifier: which of them matter is for the CANopen
    /// device to say.
    pub fn new(can: Can<pac::CAN1>) -> Self {
        let mut can = bxcan::Can::builder(can).leave_disabled();
        can.modify_filters()
            .enable_bank(0, Fifo::Fifo0, Mask32::accept_all());
        can.enable_interrupts(
            Interrupts::FIFO0_MESSAGE_PENDING
                | Interrupts::FIFO0_OVERRUN
                | Interrupts::TRANSMIT_MAILBOX_EMPTY
                | Interrupts::ERROR,
        );
        registers()
            .ier()
            .modify(|_, w| w.bofie().set_bit().epvie().set_bit());
        Self { can }
    }
}

/// The identifiers of the frames that wait in the mailboxes.
fn waiting() -> [Option<u16>; 3] {
    let can = registers();
    [0, 1, 2].map(|mailbox: usize| {
        let waiting = can.tx(mailbox).tir().read();
        // The upper eleven bits, of an extended identifier too.
        waiting
            .txrq()
            .bit_is_set()
            .then(|| (waiting.bits() >> 21) as u16)
    })
}

impl Mailboxes for Controller {
    fn room(&mut self, cob_id: u16) -> Room {
        let waiting = waiting();
        if waiting.iter().flatten().any(|id| *id <= cob_id) {
            Room::None
        } else if waiting.iter().all(Option::is_some) {
            Room::InPlaceOfAnother
        } else {
            Room::Free
        }
    }

    fn holds(&mut self, cob_id: u16) -> bool {
        waiting().contains(&Some(cob_id))
    }

    fn put(&mut self, frame: &Frame) -> Option<Frame> {
        match self.can.transmit(&to_controller(frame)?) {
            Ok(status) => status.dequeued_frame().and_then(from_controller),
            Err(_full) => Some(*frame),
        }
    }
}

impl Controller {
    /// The error interrupt, if there is one.
    fn note_errors(&mut self) {
        if registers().msr().read().erri().bit_is_clear() {
            return;
        }
        registers().msr().write(|w| w.erri().set_bit());
        if self.state() == ControllerState::BusOff {
            defmt::warn!("bus-off: the controller left the bus after too many errors");
        }
    }

    /// Goes on the bus at this rate, or listens to it in silence.
    fn enter(&mut self, bit_rate: BitRate, silent: bool) -> Result<(), Unreachable> {
        let timing = bit_timing::register(bit_rate).ok_or(Unreachable)?;
        self.can
            .modify_config()
            .set_bit_timing(timing)
            .set_silent(silent)
            .leave_disabled();
        // Not waiting: the controller goes on the bus by itself after 11 recessive bits; `WouldBlock` says just that. `bxcan`
        // also lets it return by itself from bus-off (ABOM), which is for the device to order.
        let _ = self.can.enable_non_blocking();
        registers().mcr().modify(|_, w| w.abom().clear_bit());
        Ok(())
    }
}

impl runtime::Controller for Controller {
    const BIT_RATES: &'static [BitRate] = &bit_timing::BIT_RATES;

    fn leave(&mut self) -> bool {
        // The order that `bxcan` gives too, which then waits for the answer: a frame of 10 kbit/s takes 13 ms.
        registers()
            .mcr()
            .modify(|_, w| w.sleep().clear_bit().inrq().set_bit());
        let status = registers().msr().read();
        status.inak().bit_is_set() && status.slak().bit_is_clear()
    }

    fn start(&mut self, bit_rate: BitRate) -> Result<(), Unreachable> {
        self.enter(bit_rate, false)
    }

    fn listen(&mut self, bit_rate: BitRate) -> Result<(), Unreachable> {
        self.enter(bit_rate, true)?;
        // What it says of the bit rate before is void.
        self.error_seen();
        Ok(())
    }

    fn error_seen(&mut self) -> bool {
        let code = registers().esr().read().lec().bits();
        // 7 is left as it is until the next frame, whole (0) or broken (1 to 6).
        registers().esr().modify(|_, w| w.lec().set(7));
        (1..=6).contains(&code)
    }

    fn state(&mut self) -> ControllerState {
        let status = registers().esr().read();
        if status.boff().bit_is_set() {
            ControllerState::BusOff
        } else if status.epvf().bit_is_set() {
            ControllerState::ErrorPassive
        } else if status.ewgf().bit_is_set() {
            ControllerState::Warning
        } else {
            ControllerState::ErrorActive
        }
    }
}

/// The receive FIFO; the controller is reached through [`Controller`].
pub struct Receiver;

impl Receive<Controller> for Receiver {
    fn on_interrupt(&mut self, bus: &mut Controller, inbox: &mut Inbox) {
        bus.can.clear_tx_interrupt();
        bus.note_errors();
        loop {
            match bus.can.receive() {
                Ok(frame) => {
                    if let Some(frame) = from_controller(&frame) {
                        inbox.put(frame, clock::now());
                    }
                }
                Err(nb::Error::Other(_overrun)) => inbox.count_lost(),
                Err(nb::Error::WouldBlock) => break,
            }
        }
    }
}

/// The registers, for what `bxcan` leaves out.
fn registers() -> &'static pac::can1::RegisterBlock {
    // SAFETY: `Controller` owns CAN1, and its methods touch one register after the other. What is touched here, `bxcan` does
    // not use: the interrupt enables of bus-off and error passive, once at the start, the error flag, the last error code, and the
    // read-only status;
    // or it uses it the same way: the request to leave the bus, and the return from bus-off, which it only sets. What waits in
    // the mailboxes is read only.
    unsafe { &*pac::CAN1::ptr() }
}

fn to_controller(frame: &Frame) -> Option<bxcan::Frame> {
    let id = match frame.id() {
        Id::Standard(id) => bxcan::Id::Standard(bxcan::StandardId::new(id.as_raw())?),
        Id::Extended(id) => bxcan::Id::Extended(bxcan::ExtendedId::new(id.as_raw())?),
    };
    Some(if frame.is_remote() {
        bxcan::Frame::new_remote(id, frame.length())
    } else {
        bxcan::Frame::new_data(id, bxcan::Data::new(frame.payload())?)
    })
}

fn from_controller(frame: &bxcan::Frame) -> Option<Frame> {
    let id = match frame.id() {
        bxcan::Id::Standard(id) => Id::Standard(StandardId::new(id.as_raw())?),
        bxcan::Id::Extended(id) => Id::Extended(ExtendedId::new(id.as_raw())?),
    };
    match frame.data() {
        Some(data) => Frame::new(id, data),
        None => Frame::new_remote(id, usize::from(frame.dlc())),
    }
}

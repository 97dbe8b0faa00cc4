//! The CAN controller (bxCAN): a receive FIFO of three frames, error counters, and the mailboxes ([`super::mailboxes`]).
//!
//! - Receiving: every frame passes the filter. A frame that finds the FIFO full is lost and counted.
//! - Errors: the controller is error passive from 128 errors on, and bus-off after 256 transmit errors; each raises the error
//!   interrupt. It stays bus-off until it is started again, when the device says so, and 128 times 11 recessive bits have
//!   passed: it goes from initialisation straight to normal mode, as RM0090, 32.7.6 has it. What its mailboxes hold waits.
//! - Listening: in silent mode the controller takes part as always, but the dominant bits that it would send, such as an
//!   acknowledge, go to itself only. It shows the last error it saw, or that the last frame was whole.
//! - Nothing waits for a register without an end.

use canopen::outbox::{Mailbox, Mailboxes};
use canopen::{BitRate, ControllerState, Frame};
use stm32f4xx_hal::gpio::{Alternate, PB8, PB9};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

use super::bit_timing;
use super::mailboxes::{self, Transmission};
use crate::board::Receive;
use crate::clock;
use runtime::{Controller as _, Inbox, Unreachable};

/// Silent mode in CAN_BTR.
const SILENT: u32 = 1 << 31;

/// Looks at a register that changes within some clocks of the controller, unless a frame is on the bus.
const MOST_POLLS: u32 = 10_000;

/// Frames that an interrupt takes, three and those that come meanwhile.
const MOST_FRAMES: u32 = 8;

/// CAN1 with all its filters.
pub struct Controller {
    can: pac::CAN1,
    transmission: Transmission,
}

impl Controller {
    /// A controller that is not on the bus yet. It takes frames of every identifier: which of them matter is for the CANopen
    /// device to say.
    pub fn new(
        can: pac::CAN1,
        _pins: (PB9<Alternate<9>>, PB8<Alternate<9>>),
        rcc: &mut Rcc,
    ) -> Self {
        pac::CAN1::enable(rcc);
        pac::CAN1::reset(rcc);
        let mut controller = Self {
            can,
            transmission: Transmission::new(),
        };
        controller.request_initialisation();
        controller.accept_all();
        controller.can.ier().write(|w| {
            w.fmpie0().set_bit().fovie0().set_bit();
            w.tmeie().set_bit();
            w.errie().set_bit().bofie().set_bit().epvie().set_bit()
        });
        controller
    }

    /// Bank 0: one mask of 32 bits that leaves everything through, to FIFO 0.
    fn accept_all(&mut self) {
        let can = &self.can;
        can.fmr().modify(|_, w| w.finit().set_bit());
        // SAFETY: every value is one of these registers. The masks are 0, so identifiers of the bank do not matter.
        unsafe {
            can.fm1r().write(|w| w.bits(0));
            can.fs1r().write(|w| w.bits(1));
            can.ffa1r().write(|w| w.bits(0));
            can.fb(0).fr1().write(|w| w.bits(0));
            can.fb(0).fr2().write(|w| w.bits(0));
            can.fa1r().write(|w| w.bits(1));
        }
        can.fmr().modify(|_, w| w.finit().clear_bit());
    }

    /// Asks for initialisation mode, which comes after the frame that is on the bus.
    fn request_initialisation(&mut self) {
        let mcr = self.can.mcr();
        mcr.modify(|_, w| w.sleep().clear_bit().inrq().set_bit());
    }

    fn is_initialising(&self) -> bool {
        let status = self.can.msr().read();
        status.inak().bit_is_set() && status.slak().bit_is_clear()
    }

    /// The error interrupt, if there is one.
    fn note_errors(&mut self) {
        if self.can.msr().read().erri().bit_is_clear() {
            return;
        }
        self.can.msr().write(|w| w.erri().set_bit());
        if self.state() == ControllerState::BusOff {
            defmt::warn!("bus-off: the controller left the bus after too many errors");
        }
    }

    /// Goes on the bus at this rate, or listens to it in silence.
    fn enter(&mut self, bit_rate: BitRate, mode: u32) -> Result<(), Unreachable> {
        let timing = bit_timing::register(bit_rate).ok_or(Unreachable)?;
        self.request_initialisation();
        // At once, but for a frame on the bus, for which `leave` has waited.
        if !(0..MOST_POLLS).any(|_| self.is_initialising()) {
            defmt::error!("the CAN controller does not leave the bus");
            return Ok(());
        }
        // SAFETY: a bit timing of this controller, and a bit of the register.
        self.can.btr().write(|w| unsafe { w.bits(timing | mode) });
        // Not waiting: the controller goes on the bus by itself after 11 recessive bits.
        self.can.mcr().modify(|_, w| w.inrq().clear_bit());
        Ok(())
    }

    /// The oldest frame of the FIFO; `Err` if some were lost before it.
    fn receive(&mut self) -> Option<Result<Frame, ()>> {
        let can = &self.can;
        let fifo = can.rf0r().read();
        if fifo.fovr().bit_is_set() {
            can.rf0r().write(|w| w.fovr().clear());
            return Some(Err(()));
        }
        if fifo.fmp().bits() == 0 {
            return None;
        }
        let rx = can.rx(0);
        let words = [rx.rdlr().read().bits(), rx.rdhr().read().bits()];
        let length = rx.rdtr().read().dlc().bits();
        let frame = mailboxes::frame(rx.rir().read().bits(), length, words);
        can.rf0r().write(|w| w.rfom().release());
        // The FIFO goes on some clocks later.
        let goes_on = || can.rf0r().read().rfom().bit_is_clear();
        let _ = (0..MOST_POLLS).any(|_| goes_on());
        frame.map(Ok)
    }
}

impl Mailboxes for Controller {
    fn mailbox_for(&mut self, cob_id: u16) -> Mailbox {
        self.transmission.mailbox_for(&self.can, cob_id)
    }

    fn holds(&mut self, cob_id: u16) -> bool {
        self.transmission.holds(&self.can, cob_id)
    }

    fn put(&mut self, frame: &Frame) -> Option<Frame> {
        self.transmission.put(&self.can, frame)
    }

    fn withdraw(&mut self) {
        self.transmission.withdraw(&self.can);
    }
}

impl runtime::Controller for Controller {
    const BIT_RATES: &'static [BitRate] = &bit_timing::BIT_RATES;

    fn leave(&mut self) -> bool {
        self.request_initialisation();
        self.is_initialising()
    }

    fn start(&mut self, bit_rate: BitRate) -> Result<(), Unreachable> {
        self.enter(bit_rate, 0)
    }

    fn listen(&mut self, bit_rate: BitRate) -> Result<(), Unreachable> {
        self.enter(bit_rate, SILENT)?;
        // What it says of the bit rate before is void.
        self.error_seen();
        Ok(())
    }

    fn error_seen(&mut self) -> bool {
        let code = self.can.esr().read().lec().bits();
        // 7 is left as it is until the next frame, whole (0) or broken (1 to 6).
        self.can.esr().modify(|_, w| w.lec().set(7));
        (1..=6).contains(&code)
    }

    fn state(&mut self) -> ControllerState {
        let status = self.can.esr().read();
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
        bus.transmission.on_interrupt(&bus.can);
        bus.note_errors();
        for _ in 0..MOST_FRAMES {
            match bus.receive() {
                Some(Ok(frame)) => inbox.put(frame, clock::now()),
                Some(Err(())) => inbox.count_lost(),
                None => break,
            }
        }
    }
}

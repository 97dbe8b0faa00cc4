//! The CAN bus of the emulator: SLCAN over USART2.
//!
//! The emulated USART sends a byte in the instruction that writes it and always has room for the next. It receives as
//! fast as the host can send; when the inbox is full the receive interrupt is switched off and the byte stays where it
//! is, which holds up the sender.

use canopen::outbox::{Mailboxes, Room};
use canopen::{BitRate, ControllerState, Frame};
use cortex_m::peripheral::NVIC;
use slcan::{Channel, Decoder};
use stm32f4xx_hal::pac;

use crate::board::Receive;
use crate::clock;
use runtime::{Controller, Inbox, Unreachable};

/// USART2 and the client's channel.
pub struct SerialBus {
    serial: pac::USART2,
    channel: Channel,
}

impl SerialBus {
    /// The port is open for clients once the node is on, and takes bytes ([`Controller::resume`]): who is answered finds a node. Their
    /// channel is closed until they open it.
    pub fn new(serial: pac::USART2) -> Self {
        serial.cr1().write(|w| {
            w.ue().enabled();
            w.te().enabled();
            w.re().enabled()
        });
        Self {
            serial,
            channel: Channel::new(),
        }
    }

    fn write(&mut self, bytes: &[u8]) {
        for byte in bytes {
            while self.serial.sr().read().txe().bit_is_clear() {}
            self.serial.dr().write(|w| w.dr().set((*byte).into()));
        }
    }
}

impl Mailboxes for SerialBus {
    fn room(&mut self, _cob_id: u16) -> Room {
        Room::Free
    }

    fn put(&mut self, frame: &Frame) -> Option<Frame> {
        if self.channel.is_open() {
            self.write(&slcan::encode(frame));
        }
        None
    }
}

impl Controller for SerialBus {
    const BIT_RATES: &'static [BitRate] = &BitRate::ALL;

    fn leave(&mut self) -> bool {
        true
    }

    fn start(&mut self, _bit_rate: BitRate) -> Result<(), Unreachable> {
        Ok(())
    }

    fn listen(&mut self, bit_rate: BitRate) -> Result<(), Unreachable> {
        self.start(bit_rate)
    }

    fn error_seen(&mut self) -> bool {
        false
    }

    fn state(&mut self) -> ControllerState {
        ControllerState::ErrorActive
    }

    fn resume(&mut self) {
        if self.serial.cr1().read().rxneie().is_disabled() {
            self.serial.cr1().modify(|_, w| w.rxneie().enabled());
            // For the frame that waits, even if no byte follows it.
            NVIC::pend(pac::Interrupt::USART2);
        }
    }
}

/// Bytes on their way to become frames.
pub struct Receiver {
    decoder: Decoder,
    /// A frame the inbox had no room for; no more bytes are taken until it has.
    waiting: Option<Frame>,
}

impl Receiver {
    /// At the start of a line.
    pub fn new() -> Self {
        Self {
            decoder: Decoder::new(),
            waiting: None,
        }
    }
}

impl Receive<SerialBus> for Receiver {
    fn on_interrupt(&mut self, bus: &mut SerialBus, inbox: &mut Inbox) {
        loop {
            if let Some(frame) = self.waiting.take() {
                if inbox.is_full() {
                    self.waiting = Some(frame);
                    // The last byte was read, so the emulator has dropped the interrupt line; the next byte would raise it.
                    bus.serial.cr1().modify(|_, w| w.rxneie().disabled());
                    return;
                }
                inbox.put(frame, clock::now());
            }
            // The emulator drops the interrupt line with each byte read, even if the next one is there: take them all.
            if bus.serial.sr().read().rxne().bit_is_clear() {
                return;
            }
            // Eight data bits.
            let byte = bus.serial.dr().read().dr().bits() as u8;
            if let Some(command) = self.decoder.push(byte) {
                let answer = bus.channel.command(command);
                bus.write(answer.reply);
                self.waiting = answer.frame;
            }
        }
    }
}

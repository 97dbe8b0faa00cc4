//! The CAN bus of the emulator: SLCAN over UART0.
//!
//! The emulated port sends a byte in the instruction that writes it, as long as the host takes it. It receives as
//! fast as the host can send; when the inbox is full the receive interrupt is switched off and the byte stays where it
//! is, which holds up the sender.

use canopen::outbox::{Mailbox, Mailboxes};
use canopen::{BitRate, ControllerState, Frame};
use cortex_m::peripheral::NVIC;
use slcan::{Channel, Decoder};

use super::device::{Interrupt, Uart, UART0};
use crate::board::Receive;
use crate::clock;
use runtime::{Controller, Inbox, Unreachable};

/// Clocks of a bit. The emulator has no use for it, but for that it is a valid one.
const BIT: u32 = 16;

/// UART0 and the client's channel.
pub struct SerialBus {
    channel: Channel,
}

impl SerialBus {
    /// The port is open for clients once the node is on, and takes bytes ([`Controller::resume`]): who is answered finds a node. Their
    /// channel is closed until they open it.
    pub fn new() -> Self {
        UART0.bauddiv.write(BIT);
        UART0.ctrl.write(Uart::ENABLE);
        Self {
            channel: Channel::new(),
        }
    }

    fn write(&mut self, bytes: &[u8]) {
        for byte in bytes {
            while UART0.state.read() & Uart::TX_FULL != 0 {}
            UART0.data.write((*byte).into());
        }
    }
}

impl Mailboxes for SerialBus {
    fn mailbox_for(&mut self, _cob_id: u16) -> Mailbox {
        Mailbox::Free
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
        if UART0.ctrl.read() != Uart::ENABLE_WITH_RX_INTERRUPT {
            UART0.ctrl.write(Uart::ENABLE_WITH_RX_INTERRUPT);
            // For the frame that waits, and the byte, even if none follows it.
            NVIC::pend(Interrupt::UART0RX);
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
        // It stands for a byte that comes, not for one that is there.
        UART0.intstatus.write(Uart::RX_INTERRUPT);
        loop {
            if let Some(frame) = self.waiting.take() {
                if inbox.is_full() {
                    self.waiting = Some(frame);
                    UART0.ctrl.write(Uart::ENABLE);
                    return;
                }
                inbox.put(frame, clock::now());
            }
            if UART0.state.read() & Uart::RX_FULL == 0 {
                return;
            }
            // Eight data bits.
            let byte = UART0.data.read() as u8;
            if let Some(command) = self.decoder.push(byte) {
                let answer = bus.channel.command(command);
                bus.write(answer.reply);
                self.waiting = answer.frame;
            }
        }
    }
}

//! The switches of the board, read once at power-up: two hexadecimal rotary switches, and the input for the factory reset.
//!
//! A switch closes to ground, so an input without one reads as open: 00h, and no factory reset.

use canopen::settings::{Switches, Wish};
use stm32f4xx_hal::gpio::{ErasedPin, Input};

use crate::board::chip::CORE_HZ;

/// How long the input for the factory reset must be held from power-up on, in milliseconds.
const HOLD_MS: u32 = 100;

/// Readings until the last one is taken, whatever it is.
const MOST_READINGS: u32 = 20;

/// What the switches ask for. `digits`: their inputs, the lowest bit first.
pub fn read(digits: &[ErasedPin<Input>]) -> Wish {
    Switches::ROTARY.wish(settled(digits))
}

/// A reading that was the same a millisecond before: a switch may just be turned.
fn settled(digits: &[ErasedPin<Input>]) -> u16 {
    let mut reading = closed(digits);
    for _ in 0..MOST_READINGS {
        wait_a_millisecond();
        let before = core::mem::replace(&mut reading, closed(digits));
        if reading == before {
            break;
        }
    }
    reading
}

/// The switches that are closed, a bit each.
fn closed(digits: &[ErasedPin<Input>]) -> u16 {
    digits
        .iter()
        .rev()
        .fold(0, |reading, pin| reading << 1 | u16::from(pin.is_low()))
}

/// An input that is closed all the time. One that is open takes no time.
pub fn is_held(pin: &ErasedPin<Input>) -> bool {
    (0..HOLD_MS).all(|_| {
        let is_closed = pin.is_low();
        if is_closed {
            wait_a_millisecond();
        }
        is_closed
    })
}

fn wait_a_millisecond() {
    cortex_m::asm::delay(CORE_HZ / 1_000);
}

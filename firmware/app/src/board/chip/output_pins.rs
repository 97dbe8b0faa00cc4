//! The digital outputs.

use stm32f4xx_hal::gpio::{ErasedPin, Output};

/// Their pins, output 1 first.
pub struct OutputPins<const COUNT: usize> {
    pins: [ErasedPin<Output>; COUNT],
    /// As they are.
    levels: u8,
}

impl<const COUNT: usize> OutputPins<COUNT> {
    /// All of them are low.
    pub fn new(pins: [ErasedPin<Output>; COUNT]) -> Self {
        Self { pins, levels: 0 }
    }

    /// The level of output `n` is bit `n − 1`.
    pub fn set(&mut self, levels: u8) {
        if levels == self.levels {
            return;
        }
        self.levels = levels;
        for (output, pin) in self.pins.iter_mut().enumerate() {
            pin.set_state((levels & 1 << output != 0).into());
        }
    }
}

//! Pulse trains by an advanced-control timer, without an interrupt per step.
//!
//! The timer (TIM1 of the STM32F4) makes PWM: channel 1 is the step signal, channel 2 the direction. A *slot* of the [`Ring`] is
//! a run: so many periods of so many ticks, a pulse at the beginning of each, or none. At every update event a run begins with
//! what was preloaded, and a DMA burst preloads the next slot: what is written during run k acts in run k + 1. A second timer
//! counts the pulses that really left. [`Output`] is the axis's [`PulseSink`](crate::PulseSink) on top of that; a board brings
//! [`Registers`], and nothing else.
//!
//! Names of registers are those of the reference manual RM0090 (STM32F405), chapters 10 (DMA), 17 (advanced-control timers) and
//! 18 (general-purpose timers).
//!
//! The contract:
//! - Behind the last record the ring is silent, a tenth of a second in every slot, and a slot that was played is made silent
//!   again: if records do not come in time the pulses end, and nothing is played twice. So many slots are always silent that the
//!   ring takes more than 6 seconds to come round with the processor stopped, which is for a watchdog to end.
//! - If the DMA stream itself stands still, the timer would play its last run for ever: the train is cut within a millisecond, and it is
//!   told ([`Output::has_failed`]).
//! - The direction changes with the beginning of a silent run, by hardware: set-up and hold times are exact to the tick.
//! - A record is taken whole or not at all. What cannot follow the record before without a gap is not taken until the ring has run
//!   dry and is started anew.
//! - No run is shorter than a DMA burst may take ([`SHORTEST_RECORD`](crate::record::SHORTEST_RECORD)).
//! - The position comes from the counter. It is right after a cut in the middle of a train, too.

mod count;
mod interrupts;
mod output;
mod registers;
mod ring;
mod set_up;
mod slots;
#[cfg(test)]
mod tests;

pub use interrupts::{CaptureChannel, count_at_edge, on_break};
pub use output::Output;
pub use registers::{Register, Registers, bits};
pub use ring::{Ring, SLOTS, WORDS};

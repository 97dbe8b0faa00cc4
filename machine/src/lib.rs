//! The board as the tests know it: the timers that make step pulses, register by register, and what is measured on their pins.
//!
//! - [`timer_model`]: TIM1, its DMA stream and the timer that counts; the drive on them.
//! - [`exactness`]: how exact the pulses are, and how soon they follow an order.
#![forbid(unsafe_code)]

pub mod exactness;
pub mod timer_model;

/// The object dictionary of the generic drive, made from `eds/axis402.eds`.
pub mod dictionary {
    include!(concat!(env!("OUT_DIR"), "/dictionary.rs"));
}

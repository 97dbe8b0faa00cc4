//! The firmware of the drive: its tasks, and nothing else.
//!
//! | task | priority | raised by | does |
//! |---|---|---|---|
//! | `trip` | 8 | the gate driver of a servo | no current |
//! | `current` | 7 | the converters of a servo, 20 kHz | its current loop: samples to pulse widths |
//! | `loops` | 6 | `current`, 4 kHz | its loops above that: velocity, position, limits, what is watched |
//! | `step`, `cut_off` | 6 | step timer: a step, where it needs help with each; its break input | step pulses, counted; stops the timer whose pulses no longer leave |
//! | `edge` | 6 | an edge of a digital input | captures the position |
//! | `received`, `sent`, `error` | 5 | CAN controller | stamps frames and queues them; room for the next frame; errors |
//! | `refill` | 4 | refill timer, or `loops`, 4 kHz | commits pulses |
//! | `control` | 3 | system timer, 1 kHz or in step with SYNC | state machine, mode, planner |
//! | `stop` | 3 | `node`, for a command to stop | the control tick for it, which does not wait for the next one |
//! | `node` | 2 | the start, a frame, room to send, every control tick, a deadline of its own | CANopen, which it powers on first; writes the parameter sectors |
//! | `wake` | 2 | wake timer | runs `node` at its deadline |
//! | `lights` | 1 | `node`, every 50 ms | green and red light |
//!
//! A task may only be interrupted by those above it. What two of them share is locked while a snapshot is copied or a
//! frame handed over, no longer; the emitter, which the refill needs, also while a tick commits the first pulses of a motor that stood.
//!
//! What the tasks do is in [`tasks`] and in the crate `runtime`. Which interrupts raise them is the board's: it makes the app
//! of itself by the macro [`app`](macro@app), with its device and the names of its interrupts.
#![no_std]
#![no_main]
#![allow(
    missing_debug_implementations,
    reason = "nobody prints what a task owns, and the text would cost flash"
)]

#[macro_use]
mod app;
mod board;
#[forbid(unsafe_code)]
mod clock;
#[forbid(unsafe_code)]
mod control;
#[forbid(unsafe_code)]
mod dictionary;
#[forbid(unsafe_code)]
mod machine;
#[forbid(unsafe_code)]
mod settings;
#[forbid(unsafe_code)]
mod share;
#[forbid(unsafe_code)]
mod stepping;
#[forbid(unsafe_code)]
mod tasks;

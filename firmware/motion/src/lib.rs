//! Exact integer motion: where a stepper axis is to be at every tick of its timer, and the pulses that take it there.
//!
//! A command becomes a [`Plan`], a closed form of at most five phases that ends on the target by construction. An [`Axis`] walks
//! along its plan in chords and turns them into [`Record`]s, which a [`PulseSink`] plays: a DMA ring, an interrupt, a simulated
//! motor. The pulses that were sent always add up to the distance that was commanded, whatever happened on the way.
//!
//! The contract:
//! - Integers only. Positions are Q32 steps, velocities Q56 steps per tick, times ticks; plans keep all of them in Q96. What is asked
//!   for and shown are steps/s, Q32: from one step in an hour to the timer's ceiling nothing changes but the number.
//! - Limits are never exceeded; zero limits are refused with a [`PlanError`].
//! - No input makes it panic, block or loop without bound.
//! - It knows no bus, no register and no clock but the count of ticks it is given.
#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    deny(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::indexing_slicing,
        clippy::unreachable
    )
)]

#[cfg(test)]
extern crate std;

pub mod advanced_timer;
mod average;
pub mod axis;
pub mod clock;
mod crossings;
mod divide;
pub mod driver;
pub mod fixed;
pub mod homing;
mod path;
pub mod plan;
pub mod record;
mod root;
pub mod speed;
pub mod step_interrupt;
mod train;
#[cfg(test)]
mod vectors;
mod wide;

pub use average::Mean;
pub use axis::{AdvanceError, Axis, AxisConfig, Demand};
pub use clock::{Clock, Ticks};
pub use divide::{by_digit, quotient};
pub use driver::{Driver, Nanoseconds};
pub use fixed::{Position, State, Velocity};
pub use path::FollowError;
pub use plan::phase::Phase;
pub use plan::{Goal, Limits, Plan, PlanError, Ramps};
pub use record::{Direction, DriverTiming, PulseSink, Record};
pub use speed::{SignedSpeed, Speed};

//! Exact integer motion: where a stepper axis is to be at every tick of its timer, and the pulses that take it there.
//!
//! A command becomes a [`Plan`], a closed form that ends on the target by construction. An [`Axis`] follows it, or its [`Mean`], or a path of
//! set-points, as polynomials; one stepper evaluates these and turns them into [`Record`]s, which a [`PulseSink`] plays: a DMA ring,
//! an interrupt, a simulated motor. The pulses that were sent always add up to the distance that was commanded, whatever happened on the way.
//!
//! # Glossary
//!
//! | word | what is meant |
//! |---|---|
//! | tick | a period of the step timer's clock; all times are whole numbers of them |
//! | step | a microstep, the unit of all positions; a *whole step* is what a pulse makes |
//! | distance | from one position to another |
//! | trajectory | where the axis is at every tick: a plan, the mean of a plan, or a path |
//! | plan | a trajectory in closed form from a state to a goal within limits; made of *phases* |
//! | draft | what a plan starts from, copied at the horizon: it is made while the motion before is played |
//! | lead | how a plan begins in a smooth ramp: the end of that ramp, or a jerk to zero acceleration |
//! | virtual start | where a jerk-limited ramp that begins with an acceleration would have begun from an acceleration of zero |
//! | phase | a stretch of a plan with constant acceleration or constant jerk |
//! | corner | the tick at which one phase or path segment ends and the next begins |
//! | ramp | a change of velocity: linear, sin², with limited jerk, or the moving average of a linear one |
//! | mean | the moving average of a plan over a *window* of time |
//! | run | a parabola of the plan below a mean, kept until it has left the window |
//! | path | set-points with their ticks, as cyclic modes give them; from one to the next is a *path segment* |
//! | polynomial | of degree 3 at most, up to an end tick: what every trajectory comes as |
//! | piece | a ramp or a cruise of a plan, as the plan keeps it until one of its phases is entered |
//! | anchor | the moment for which position, velocity and acceleration of a piece or phase are kept |
//! | chord | as much of a polynomial as becomes pulses in one go: evenly spaced between its first crossing and its last |
//! | crossing | where the position passes the middle between two whole steps: there the pulse belongs |
//! | record | a run of equal periods, each with a pulse, or silence; what a sink plays |
//! | train | the account of steps and ticks that makes records of chords |
//! | open period | the time behind the last pulse, which becomes a record when it is known how long it is |
//! | time slice | a quarter of a millisecond on the board: a refill commits one, and two are committed ahead |
//! | committed | given to the timer as records: it will be played, whatever is ordered |
//! | horizon | the tick up to which the trajectory has become records; a new order plans from the state there |
//! | refill | a call of [`Axis::advance`], which commits up to two time slices |
//! | rest | standstill at the end of a motion, on a whole step |
//!
//! # The contract
//!
//! - No floats in positions or times: positions are Q32 steps, velocities Q56 steps per tick, times ticks; plans keep all of them in Q96, and a sixth of a
//!   jerk in Q128. What is asked for and shown are steps/s, Q32: from one step in an hour to the timer's ceiling nothing changes but the number.
//! - Each format is a type (`fixed`, `exact`, `speed`), so none is taken for another. Of these numbers positions alone wrap, modulo 2³² steps.
//! - Limits are never exceeded; zero limits are refused with a [`PlanError`].
//! - No input makes it panic, block or loop without bound.
//! - It knows no bus, no register and no clock but the count of ticks it is given.
#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    deny(
        clippy::cast_lossless,
        clippy::cast_possible_truncation,
        clippy::cast_possible_wrap,
        clippy::cast_sign_loss,
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
mod divide;
pub mod driver;
mod exact;
pub mod fixed;
pub mod homing;
mod iterations;
pub mod low;
mod path;
pub mod plan;
pub mod record;
mod root;
pub mod speed;
pub mod step_interrupt;
mod stepper;
mod u256;
#[cfg(test)]
mod vectors;

pub use average::Mean;
pub use axis::{AdvanceError, Axis, AxisConfig, Demand, Draft, Reference};
pub use clock::{Clock, Ticks};
pub use divide::{div_rem, quotient};
pub use driver::{Driver, Nanoseconds};
pub use fixed::{Position, State, Velocity};
pub use path::FollowError;
pub use plan::phase::Phase;
pub use plan::{Goal, Limits, Plan, PlanError, Ramps, SIN_SQUARED};
pub use record::{Direction, DriverTiming, PulseSink, Record};
pub use root::isqrt;
pub use speed::{SignedSpeed, Speed};

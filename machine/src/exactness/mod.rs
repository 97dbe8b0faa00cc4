//! How exact the pulses are: measured on the pins of the modelled timers, where nothing is left to believe.
//!
//! These are the figures of `docs/benchmarks.md`, "Exactness". All of it is virtual time, so each is the same on every PC. `cargo xtask
//! bench` prints them (`machine/examples/exactness.rs`), and the tests hold them to their goals.
//!
//! - [`count`]: pulses too many or too few.
//! - [`duration`]: when a move ends.
//! - [`position`]: how far a pulse is from where the plan has it.
//! - [`rate`]: pulses and CANopen together.
//! - [`reaction`]: from an order to the first slower step.

pub mod count;
pub mod duration;
pub mod position;
pub mod rate;
pub mod reaction;
#[cfg(test)]
mod tests;

use canopen::Duration;
use motion::DriverTiming;

use crate::timer_model::board::Board;
use master::bus::simulated::{Bus, Handle};
use master::{Failure, Master, NmtCommand};

/// What a TMC2209 needs at 168 MHz: 100 ns high and low, 20 ns around a change of direction.
pub const FAST: DriverTiming = DriverTiming {
    pulse_high: 17,
    pulse_low: 17,
    direction_setup: 4,
    direction_hold: 4,
};

/// Steps/s² of moves at high rates.
pub const STEEP: u32 = 5_000_000;

/// Numbers that look random, from a seed (an xorshift generator).
#[derive(Clone, Debug)]
pub struct Numbers(u64);

impl Numbers {
    /// The same seed gives the same numbers.
    pub fn new(seed: u64) -> Self {
        Self(seed.max(1))
    }

    /// The next one, below `end`, which is not 0.
    pub fn below(&mut self, end: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0 % end
    }
}

/// How long an answer of the drive may take.
const PATIENCE: Duration = Duration::from_ticks(100_000);

/// Profile velocity, 6060h.
const PROFILE_VELOCITY: i8 = 3;

/// Profile position, 6060h.
const PROFILE_POSITION: i8 = 1;

/// A board on a bus, whose refills come `phase` behind the control ticks, with a master: no limit but those of the driver, ramps of [`STEEP`], operation enabled in profile velocity.
pub(crate) fn enabled(bus: Bus, phase: Duration) -> Result<(Master, Handle<Board>), Failure> {
    let mut master = Master::new(bus);
    let board = master.bus_mut().attach(Board::new(FAST, phase));
    let node = Board::NODE;
    master.expect_boot_up(node, PATIENCE)?;
    // 100,000 rpm are 5.3 million steps/s.
    for (index, limit) in [
        (0x6080, 100_000u32),
        (0x607F, 5_000_000),
        (0x6081, 5_000_000),
        (0x6083, STEEP),
        (0x6084, STEEP),
        (0x6085, STEEP),
    ] {
        master.write(node, index, 0, limit)?;
    }
    master.nmt(NmtCommand::Start, node);
    master.write(node, 0x6060, 0, PROFILE_VELOCITY)?;
    for (controlword, state) in [(0x06, 0x21), (0x07, 0x23), (0x0F, 0x27)] {
        master.controlword(node, controlword);
        master.wait_for_statusword(node, 0x6F, state, PATIENCE)?;
    }
    Ok((master, board))
}

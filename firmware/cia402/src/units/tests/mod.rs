//! What the units of a master come to: in numbers, and in what the motor does.

mod limits;
mod moves;
mod numbers;
mod rotary;

use super::{Factors, Units};
use crate::testing::Rig;

/// No factor but the one that a unit is so many increments.
const NONE: Factors = Factors {
    position_encoder: Some((1, 1)),
    velocity_encoder: (0, 1),
    gear: (1, 1),
    feed: (1, 1),
    velocity: (1, 1),
    acceleration: (1, 1),
    polarity: 0,
    range: (0, 0),
};

/// So many increments are so many units.
fn ratio(increments: u32, units: u32) -> Factors {
    Factors {
        position_encoder: Some((increments, 1)),
        feed: (units, 1),
        ..NONE
    }
}

/// A drive in operation enabled whose master counts like this. What the rig asks for otherwise is in increments.
fn rig(factors: Factors) -> Rig {
    let mut rig = Rig::new();
    rig.configuration.units = Units::new(factors).unwrap();
    rig.commands.profile_velocity = 20_000.into();
    rig.commands.profile_acceleration = 10_000_000;
    rig.commands.profile_deceleration = 10_000_000;
    rig.enable();
    rig
}

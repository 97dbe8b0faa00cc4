//! What a board gives to its drive, and what it gets.

use canopen::{Duration, Instant};
use motion::AxisConfig;

use crate::inputs::DigitalInputs;

/// What a drive is built from.
#[derive(Clone, Copy, Debug)]
pub struct DriveConfig {
    /// The step generator: clock, time slice length, timing of the motor driver.
    pub axis: AxisConfig,
    /// The period of the control tick, the nominal time between two calls of [`crate::Drive::tick`].
    pub tick: Duration,
    /// How often pulses are committed in the period of a tick, at least 1. With 1 [`crate::Drive::tick`] commits them; with more,
    /// [`crate::Drive::refill`] or [`crate::Emitter::refill`] does, and a tick only for a motor that stands. Two time slices are committed
    /// ahead. A time slice is at least as long as the time between two commitments, so that one of these may come late by as much.
    pub refills: u32,
}

/// Position compare: an output rises with the pulse that reaches a position, and again at positions evenly spaced behind it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Compare {
    /// The first position in increments: in [`Commands`](crate::commands::Commands) as the master counts, in [`Outputs`] as the board does.
    pub position: i32,
    /// From one to the next; 0 for one alone.
    pub spacing: i32,
    /// After so many it is over; 0: never.
    pub count: u16,
    /// A change of this number starts it again from the first position.
    pub number: u8,
    /// The output, a bit as in [`Outputs::digital`].
    pub output: u8,
}

/// What the board measures, read once at the start of a tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Inputs {
    /// The power stage has its supply (statusword bit 4).
    pub supply: bool,
    /// Position in increments: pulses that really left, or the encoder. When the motor has power and stands, it has to be
    /// where the pulses lead, up to `position_tolerance`; anything else is the fault 8611h.
    pub position: i64,
    /// Increments of a turn of an absolute encoder within which it knows its angle; `position` counts from its zero. 0 with any other encoder, and before it
    /// has told its angle.
    pub absolute_turn: u32,
    /// How far an encoder may be from where the pulses lead while the motor is held, in increments: two and a half full steps of
    /// a stepper motor, which loses four at a time. 0 where pulses are counted: none may be missing.
    pub position_tolerance: u32,
    /// A fault the board has found, as a CiA 402 error code; it stands as long as it is reported.
    pub fault: Option<u16>,
    /// What the board warns of, as a CiA 402 error code (temperature, load): statusword bit 7 and an emergency message as long as
    /// it is reported. It changes no state.
    pub warning: Option<u16>,
    /// The digital inputs.
    pub digital: DigitalInputs,
    /// The motor driver senses that the motor is blocked; `None` if it has no such sense.
    pub stall: Option<bool>,
    /// The supply of the power stage in millivolts; `None` if the board cannot measure it. Then `supply` alone counts.
    pub supply_voltage: Option<u32>,
    /// The temperature of the power stage in tenths of a degree Celsius; `None` if the board cannot measure it.
    pub temperature: Option<i16>,
    /// The analogue input as its converter of 12 bits reads it, 0 ..= 4095; `None` if there is none.
    pub analogue: Option<u16>,
    /// The supply of the electronics in millivolts; `None` if the board cannot measure it.
    pub auxiliary_voltage: Option<u32>,
    /// The battery of an encoder in millivolts; `None` if there is none.
    pub battery_voltage: Option<u32>,
    /// The board carries out [`Outputs::compare`].
    pub has_compare: bool,
    /// The second counter, an external encoder; it goes on behind the end of its bits. 0 where the board has none.
    pub counter: i32,
}

/// What the board must do, set at the end of a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Outputs {
    /// When the next tick is due, in step with SYNC, to the nearest microsecond (rounding does not add up); `None` for the nominal period,
    /// and after an early tick.
    pub next_tick: Option<Instant>,
    /// The power stage is on: there is current in the motor.
    pub power_stage: bool,
    /// The brake is open.
    pub brake_released: bool,
    /// Pulses not yet sent must be dropped: the power is off, or there is no ramp to stop on.
    pub drop_pulses: bool,
    /// The current that the motor driver is to put into the motor, in milliamperes; 0 without power.
    pub current: u16,
    /// How many pulses of a full step the motor driver is to be set to.
    pub microsteps: u16,
    /// The levels of the digital outputs, output `n` in bit `n − 1`.
    pub digital: u8,
    /// An output that is to rise at positions, each time for a control tick, whatever its level is here. A board that cannot leaves it alone.
    pub compare: Option<Compare>,
}

/// The axis with time slices at least as long as the time from one commitment to the next, so that with two of them one may come late by as much.
#[inline(never)]
pub(crate) fn outlast_tick(config: DriveConfig) -> AxisConfig {
    let tick = u64::from(config.axis.clock.hz()).saturating_mul(config.tick.ticks()) / 1_000_000;
    let apart = tick.checked_div(config.refills.into()).unwrap_or(tick);
    let least = u32::try_from(apart).unwrap_or(u32::MAX);
    AxisConfig {
        time_slice: config.axis.time_slice.max(least),
        ..config.axis
    }
}

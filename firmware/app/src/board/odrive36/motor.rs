//! The motor at M0, and what the board measures of it. A master may say more of the motor (20C2h); what is fixed here is its encoder, its pole pairs, its currents and the bus.
//!
//! It is the motor of the virtual axis `servo_100w`. Another one is another `DATA`.

use runtime::servo::{Feedback, ServoData, StageData};
use servo::stage::drv8301::{Gain, Settings};
use servo::stage::sensors;
use servo::{Motor, Wiring};

use super::pwm;
use crate::board::chip::CORE_HZ;
use crate::board::servo_stage::converters::Channels;
use crate::board::servo_stage::pwm::{CONTROL, PERIOD};

/// Gain of the amplifiers behind the shunts: ±41 A, of which the trip is 24 A.
const GAIN: Gain = Gain::Eighty;

/// The shunts of phases B and C, in Ω (board version 3.4 and later).
const SHUNT: f32 = 500e-6;

/// The count without a current, and how far from it an amplifier may be.
const MIDDLE: u16 = 2_048;
const SPREAD: u16 = 200;

/// Clocks of a period that are left for the currents to be seen at the lower switches: 2.5 µs.
const SEEN: f32 = 420.0;

/// Volts of a count of the converters.
const COUNT: f32 = 3.3 / 4_096.0;

/// What the voltage of the bus is divided by on boards for 48 V and more.
const DIVIDER: f32 = 19.0;

/// The gate driver: a switch that has 0.73 V while it is on carries too much, about 150 A.
pub const GATES: Settings = Settings {
    limit: 21,
    gain: GAIN,
};

/// See the module.
pub const DATA: ServoData = ServoData {
    motor: Motor {
        wiring: Wiring::ThreePhase,
        pole_pairs: 4,
        resistance: 0.6,
        inductance_d: 0.8e-3,
        inductance_q: 0.8e-3,
        flux: 13.33e-3,
        rated_current: 4.0,
        peak_current: 12.0,
        inertia: 19.6e-6,
        counts: 10_000,
    },
    friction: 5e-3,
    bandwidth: 600.0,
    speed: 3_000,
    feedback: Feedback::Incremental,
    encoder: 0,
    stage: StageData {
        period: PERIOD / CORE_HZ as f32,
        control: CONTROL,
        voltage: 48.0,
        dead_time: pwm::DEAD as f32 / PERIOD,
        ripple: 0.3 * PERIOD / 8_400.0,
        reach: 1.0 - 2.0 * SEEN / PERIOD,
        current: COUNT / GAIN.factor() / SHUNT,
        middle: (MIDDLE, SPREAD),
        bus: COUNT * DIVIDER,
        // More than the motor: its peak for ever.
        bears: (12.0, 2.0),
    },
};

/// The channels of the converters: PA6, PC0 and PC1.
pub const CHANNELS: Channels = Channels {
    bus: 6,
    currents: [10, 11],
};

/// The counts of the phases, from those of B and C.
#[inline]
pub fn three_currents(b: u16, c: u16) -> [u16; 3] {
    sensors::three_of_two(b, c, MIDDLE)
}

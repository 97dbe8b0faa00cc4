//! The motor, and what the board measures of it. A master may say more of the motor (20C2h); what
//! is fixed here is its encoder, its pole pairs, its currents and the bus.
//!
//! It is the stepper of the virtual axis `nema17`. Another one is another `DATA`.

use runtime::servo::{Feedback, ServoData, StageData};
use servo::{Motor, Wiring};

use crate::board::chip::CORE_HZ;
use crate::board::servo_stage::converters::Channels;
use crate::board::servo_stage::pwm::{CONTROL, PERIOD};

/// The shunts in Ω, and the gain of the amplifiers behind them: ±8.2 A, of which the trip is 4.8 A.
const SHUNT: f32 = 10e-3;
const GAIN: f32 = 20.0;

/// The count without a current, and how far from it an amplifier may be.
const MIDDLE: u16 = 2_048;
const SPREAD: u16 = 100;

/// Volts of a count of the converters.
const COUNT: f32 = 3.3 / 4_096.0;

/// What the voltage of the bus is divided by.
const DIVIDER: f32 = 16.0;

/// See the module.
pub const DATA: ServoData = ServoData {
    motor: Motor {
        wiring: Wiring::TwoPhase,
        pole_pairs: 50,
        resistance: 1.65,
        inductance_d: 3.2e-3,
        inductance_q: 3.2e-3,
        flux: 3.66e-3,
        rated_current: 1.7,
        peak_current: 2.4,
        inertia: 10.8e-6,
        counts: 4_096,
    },
    friction: 4e-3,
    bandwidth: 700.0,
    speed: 1_200,
    feedback: Feedback::Incremental,
    encoder: 0,
    stage: StageData {
        period: PERIOD / CORE_HZ as f32,
        control: CONTROL,
        voltage: 24.0,
        // A DRV8412 has some ns; about 1 µs, as other drivers have it, is 0.02.
        dead_time: 0.0,
        ripple: 0.1,
        // 5 % of the period, 2.5 µs, are left for the amplifiers to come to rest behind an edge.
        reach: 0.9,
        current: COUNT / GAIN / SHUNT,
        middle: (MIDDLE, SPREAD),
        bus: COUNT * DIVIDER,
        // More than the motor: its peak for ever.
        bears: (2.4, 2.0),
    },
};

/// The channels of the converters: PC0, PA0 and PA1.
pub const CHANNELS: Channels = Channels {
    bus: 10,
    currents: [0, 1],
};

/// The counts of the phases; of the third there is none.
#[inline]
pub fn three_currents(a: u16, b: u16) -> [u16; 3] {
    [a, b, MIDDLE]
}

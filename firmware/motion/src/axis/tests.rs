//! The axis, judged by a model of the timer that plays its records.

mod averaged;
mod behaviour;
mod draft;
mod forms;
mod hours;
mod mean;
mod preview;
mod random;
mod replay;
mod slow;
mod span;
mod start_speed;
mod steady;
mod vectors;

use super::{Axis, AxisConfig};
use crate::{Clock, DriverTiming};
use replay::Replay;

const HZ: u32 = 168_000_000;

/// 100 ns high, 100 ns low, 20 ns direction: a TMC2209 at 168 MHz.
const FAST: DriverTiming = DriverTiming {
    pulse_high: 17,
    pulse_low: 17,
    direction_setup: 4,
    direction_hold: 4,
};

/// 1.9 µs high and low, 650 ns direction: a DRV8825 at 168 MHz.
const SLOW: DriverTiming = DriverTiming {
    pulse_high: 320,
    pulse_low: 320,
    direction_setup: 110,
    direction_hold: 110,
};

fn config(timing: DriverTiming) -> AxisConfig {
    // A quarter of a millisecond.
    AxisConfig {
        clock: Clock::new(HZ).unwrap(),
        time_slice: HZ / 4000,
        timing,
    }
}

fn axis(timing: DriverTiming) -> (Axis, Replay) {
    let axis = Axis::new(config(timing));
    let replay = Replay::new(timing, axis.stepper.time_slice().into());
    (axis, replay)
}

/// Advances in control ticks of one time slice until the axis rests and everything is played.
fn run(axis: &mut Axis, sink: &mut Replay) {
    for _ in 0..100_000_000u64 {
        axis.advance(sink).unwrap();
        sink.account(axis);
        if axis.is_at_rest() {
            sink.play_out();
            return;
        }
        sink.play(axis.stepper.time_slice().into());
    }
    panic!("the motion does not end");
}

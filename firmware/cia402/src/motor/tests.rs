use canopen::{Duration, Instant};
use motion::{AxisConfig, Clock, DriverTiming, Limits};

use super::Motor;
use crate::DriveConfig;
use crate::actuator::{Emitter, StepAxis};
use crate::cyclic::micros_q16;
use crate::testing::Player;

#[test]
fn what_is_followed_has_no_ramp_of_its_own() {
    let config = DriveConfig {
        axis: AxisConfig {
            clock: Clock::new(1_000_000).unwrap(),
            time_slice: 500,
            timing: DriverTiming {
                pulse_high: 2,
                pulse_low: 2,
                direction_setup: 5,
                direction_hold: 5,
            },
        },
        tick: Duration::from_ticks(1_000),
        refills: 1,
    };
    let mut motor = Motor::new(|| StepAxis::new(config, || Emitter::new(config)));
    let mut pulses = Player::with_capacity(256);
    let limits = Limits {
        velocity: 1_000.into(),
        acceleration: 1_600_000,
        deceleration: 1_600_000,
    };
    motor.ramp_to(1_000.into(), limits).unwrap();
    assert_eq!(motor.deceleration(), 1_600_000);
    assert_eq!(motor.hardest(), 1_700_000);
    let mut now = Instant::from_ticks(0);
    for _ in 0..10 {
        motor.observe(micros_q16(now), pulses.position, true, &pulses);
        motor.advance(&mut pulses);
        pulses.play(1_000);
        now += Duration::from_ticks(1_000);
    }
    let soon = micros_q16(now + Duration::from_ticks(4_000));
    motor.follow_velocity(soon, 900.into()).unwrap();
    assert_eq!(motor.deceleration(), 0);
    assert_eq!(motor.hardest(), 0);
}

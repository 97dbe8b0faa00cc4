//! Which current when.

use proptest::prelude::*;

use super::*;

const CURRENTS: MotorCurrents = MotorCurrents {
    run: 1_000,
    hold: 400,
    boost: 1_500,
    hold_delay: 100,
};

const MILLISECOND: u32 = 1_000;

fn moving(velocity: i32) -> Motion {
    Motion {
        power: true,
        standstill: false,
        velocity,
    }
}

const STANDING: Motion = Motion {
    power: true,
    standstill: true,
    velocity: 0,
};

const OFF: Motion = Motion {
    power: false,
    ..STANDING
};

#[test]
fn a_motor_is_held_with_less_after_the_delay() {
    let mut current = MotorCurrent::new();
    let mut tick = |motion| current.choose(motion, MILLISECOND, &CURRENTS);
    assert_eq!(tick(OFF), 0);
    for _ in 0..100 {
        assert_eq!(tick(STANDING), 1_000);
    }
    for _ in 0..10 {
        assert_eq!(tick(STANDING), 400);
    }
    assert_eq!(tick(moving(10)), 1_500);
    assert_eq!(tick(STANDING), 1_000);
    assert_eq!(tick(OFF), 0);
    assert_eq!(tick(STANDING), 1_000, "power comes: the motor may swing");
}

#[test]
fn a_ramp_has_the_boost_current() {
    let mut current = MotorCurrent::new();
    let mut tick = |motion| current.choose(motion, MILLISECOND, &CURRENTS);
    for velocity in 1..50 {
        assert_eq!(tick(moving(velocity)), 1_500);
    }
    for _ in 1..20 {
        assert_eq!(tick(moving(49)), 1_500);
    }
    for _ in 0..50 {
        assert_eq!(tick(moving(49)), 1_000);
    }
    assert_eq!(tick(moving(48)), 1_500);
}

#[test]
fn without_a_boost_current_the_run_current_counts() {
    let currents = MotorCurrents {
        boost: 0,
        ..CURRENTS
    };
    assert_eq!(
        MotorCurrent::new().choose(moving(5), MILLISECOND, &currents),
        1_000
    );
}

#[test]
fn without_a_delay_the_motor_is_held_at_once() {
    let currents = MotorCurrents {
        hold_delay: 0,
        ..CURRENTS
    };
    assert_eq!(
        MotorCurrent::new().choose(STANDING, MILLISECOND, &currents),
        400
    );
}

proptest! {
    /// Whatever the motor does: none without power, never less than the run current while it moves or has moved within the
    /// delay, the hold current always after it, and the boost current while its velocity changes.
    #[test]
    fn the_current_follows_the_motion(
        spans in prop::collection::vec((0u8..4, -500i32..500, 1u32..60), 1..60),
    ) {
        let mut current = MotorCurrent::new();
        let mut stood = 0;
        let (mut velocity, mut steady) = (0, u32::MAX);
        for (kind, speed, ticks) in spans {
            for tick in 0..ticks {
                let motion = match kind {
                    0 => OFF,
                    1 => STANDING,
                    2 => moving(speed),
                    _ => moving(speed.wrapping_add(tick as i32)),
                };
                let given = current.choose(motion, MILLISECOND, &CURRENTS);
                if !motion.power {
                    (stood, velocity, steady) = (0, 0, u32::MAX);
                    prop_assert_eq!(given, 0);
                    continue;
                }
                steady = if motion.velocity == velocity { steady.saturating_add(1) } else { 0 };
                velocity = motion.velocity;
                if motion.standstill {
                    prop_assert_eq!(given, if stood < 100 { 1_000 } else { 400 });
                    stood += 1;
                } else {
                    stood = 0;
                    prop_assert_eq!(given, if steady < 20 { 1_500 } else { 1_000 });
                }
            }
        }
    }
}

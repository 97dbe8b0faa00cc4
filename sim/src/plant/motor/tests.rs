use proptest::prelude::*;
use proptest::test_runner::contextualize_config;

use super::*;

const MICROSTEPS: u16 = 16;

/// Orders at the rated current and 48 V.
const RATED: Orders = Orders {
    current: 2_800,
    microsteps: MICROSTEPS,
    is_braked: false,
    supply: 48.0,
};

const OFF: Orders = Orders {
    current: 0,
    ..RATED
};

fn with_load(load: Load) -> Motor {
    let data = MotorData {
        load,
        ..MotorData::default()
    };
    data.check().unwrap();
    Motor::new(&data, 0, None)
}

/// A load of twice the rotor's inertia, with some friction.
fn ordinary() -> Load {
    Load {
        inertia: 600,
        friction: 40,
        drag: 30,
        ..Load::default()
    }
}

/// Ramps up with so many full steps/s² to a speed in full steps/s and down again, and lets the motor come to rest. Returns the
/// number of steps sent, in steps of the axis.
fn ramp(motor: &mut Motor, orders: Orders, speed: f64, acceleration: f64) -> i64 {
    let mut velocity: f64 = 0.0;
    let mut way = 0.0;
    let mut sent = 0;
    let rise = speed / acceleration;
    let steps = (3.0 * rise / SECONDS) as u32 + 20_000;
    for n in 0..steps {
        let time = f64::from(n) * SECONDS;
        velocity = if time < rise {
            velocity + acceleration * SECONDS
        } else if time < 2.0 * rise {
            velocity
        } else {
            (velocity - acceleration * SECONDS).max(0.0)
        };
        way += velocity * SECONDS * f64::from(orders.microsteps);
        let due = way as i64 - sent;
        sent += due;
        motor.take(due, orders.microsteps);
        motor.step(orders);
    }
    sent
}

#[test]
fn a_motor_that_has_the_torque_goes_where_the_pulses_lead() {
    let mut motor = with_load(ordinary());
    let sent = ramp(&mut motor, RATED, 2_000.0, 40_000.0);
    assert!(
        (motor.place() - sent).abs() <= 1,
        "{} {sent}",
        motor.place()
    );
}

#[test]
fn too_much_acceleration_loses_whole_electrical_turns() {
    let mut motor = with_load(ordinary());
    let sent = ramp(&mut motor, RATED, 2_000.0, 2_000_000.0);
    let lost = sent - motor.place();
    let turn = 4 * i64::from(MICROSTEPS);
    assert!(lost >= turn, "{lost}");
    let beside = (lost + turn / 2).rem_euclid(turn) - turn / 2;
    assert!(beside.abs() <= 2, "{lost} is no multiple of {turn}");
}

/// The greatest speed at which a motor still follows, in full steps/s.
fn pull_out_speed(orders: Orders) -> f64 {
    let speeds = (1..60).map(|n| f64::from(n) * 500.0);
    speeds
        .take_while(|speed| {
            let mut motor = with_load(ordinary());
            let sent = ramp(&mut motor, orders, *speed, 20_000.0);
            (motor.place() - sent).abs() <= 2
        })
        .last()
        .unwrap()
}

#[test]
fn more_voltage_and_more_current_give_more_speed_and_torque() {
    let low = pull_out_speed(Orders {
        supply: 24.0,
        ..RATED
    });
    let high = pull_out_speed(RATED);
    assert!(low < 0.7 * high, "{low} {high}");

    let fast = 400_000.0;
    let lost = |current| {
        let orders = Orders { current, ..RATED };
        let mut motor = with_load(ordinary());
        let sent = ramp(&mut motor, orders, 1_000.0, fast / 4.0);
        (sent - motor.place()).abs() > 32
    };
    assert!(lost(500) && !lost(2_800));
}

#[test]
fn the_holding_torque_holds_up_to_itself() {
    let holds = |torque, current| {
        let mut motor = with_load(Load {
            torque,
            ..Load::default()
        });
        for _ in 0..50_000 {
            motor.step(Orders { current, ..RATED });
        }
        motor.place() < 2 * i64::from(MICROSTEPS)
    };
    // A load that comes all at once swings the rotor further than it rests.
    assert!(holds(900, 2_800) && !holds(1_400, 2_800));
    assert!(holds(450, 1_400) && !holds(700, 1_400));
    assert!(holds(20, 0) && !holds(60, 0), "the detents alone");
}

#[test]
fn a_brake_holds_what_falls() {
    let mut motor = with_load(Load {
        torque: -300,
        brake: 800,
        ..Load::default()
    });
    let braked = Orders {
        is_braked: true,
        ..OFF
    };
    for _ in 0..10_000 {
        motor.step(braked);
    }
    assert_eq!(motor.place(), 0);
    for _ in 0..10_000 {
        motor.step(OFF);
    }
    assert!(motor.place() < -1_000);
}

#[test]
fn without_current_it_runs_down() {
    let mut motor = with_load(ordinary());
    motor.rotor.velocity = 1_000.0;
    let mut last = motor.rotor.velocity;
    for _ in 0..25_000 {
        motor.step(OFF);
        assert!(motor.rotor.velocity < last + 50.0, "detents at most");
        last = motor.rotor.velocity;
    }
    assert_eq!(motor.rotor.velocity, 0.0, "it has come to rest");
    let place = motor.place();
    assert!(place > 100, "{place}");
    for _ in 0..1_000 {
        motor.step(OFF);
    }
    assert_eq!(motor.place(), place);
}

#[test]
fn the_swinging_after_a_step_dies_away() {
    let mut motor = with_load(Load {
        inertia: 600,
        ..Load::default()
    });
    motor.take(8, MICROSTEPS);
    let mut places = Vec::new();
    for _ in 0..25_000 {
        motor.step(RATED);
        places.push(motor.place());
    }
    assert!(places.iter().any(|place| *place > 10), "it overshoots");
    assert!(places.iter().rev().take(5_000).all(|place| *place == 8));
}

#[test]
fn the_winding_warms_up_and_tells_so() {
    let data = MotorData {
        heat: Heat {
            ambient: 20,
            rise: 50,
            time_constant: Duration::from_ticks(1_000_000),
        },
        ..MotorData::default()
    };
    let mut motor = Motor::new(&data, 0, None);
    assert_eq!(motor.temperature(), 200);
    for _ in 0..50_000 {
        motor.step(RATED);
    }
    // 63 % of 50 K after the time constant.
    assert_eq!(motor.temperature(), 200 + 316);
    let half = Orders {
        current: 1_400,
        ..RATED
    };
    for _ in 0..500_000 {
        motor.step(half);
    }
    assert_eq!(
        motor.temperature(),
        200 + 125,
        "by the square of the current"
    );
}

#[test]
fn a_stall_is_sensed_while_it_lasts() {
    let data = MotorData {
        senses_stall: true,
        load: ordinary(),
        ..MotorData::default()
    };
    // The stop is 20 full steps away, a pulse comes every 500 microseconds.
    let mut motor = Motor::new(&data, 0, Some(&(-320..=320)));
    let run = |motor: &mut Motor, pulses: u32, direction| {
        (0..pulses * 25)
            .map(|n| {
                motor.take(if n % 25 == 0 { direction } else { 0 }, MICROSTEPS);
                motor.step(RATED);
                (motor.stall().unwrap(), motor.is_at_stop())
            })
            .collect::<Vec<_>>()
    };
    assert!(run(&mut motor, 320, 1).iter().all(|(stall, _)| !stall));
    let blocked = run(&mut motor, 400, 1);
    let first = blocked.iter().position(|(stall, _)| *stall).unwrap();
    assert!(blocked[..first].iter().any(|(_, at_stop)| *at_stop));
    assert!(
        blocked[first..].iter().all(|(stall, _)| *stall),
        "all along"
    );
    let back = run(&mut motor, 400, -1);
    let last = back.iter().rposition(|(stall, _)| *stall).unwrap();
    assert!(last < 150 * 25, "after an electrical turn it is over");
}

#[test]
fn an_end_stop_gives_way_and_throws_back() {
    let data = MotorData {
        load: Load {
            compliance: 8,
            ..Load::default()
        },
        detent_torque: 0,
        ..MotorData::default()
    };
    let mut motor = Motor::new(&data, 0, Some(&(-320..=320)));
    motor.rotor.velocity = 1_500.0;
    let places: Vec<i64> = (0..1_000)
        .map(|_| {
            motor.step(OFF);
            motor.place()
        })
        .collect();
    let furthest = *places.iter().max().unwrap();
    assert!((325..400).contains(&furthest), "{furthest}");
    assert!(
        (-1_200.0..-800.0).contains(&motor.rotor.velocity),
        "half of the energy is lost"
    );
}

#[test]
fn an_encoder_tells_what_it_can_resolve() {
    let data = MotorData {
        encoder_counts: Some(400),
        ..MotorData::default()
    };
    let mut motor = Motor::new(&data, 100, None);
    motor.power_on();
    // 3,200 pulses a turn: eight of them are a count.
    for (steps, shown) in [(3, 0), (5, 8), (11, 16), (-19, 0), (-3_200, -3_200)] {
        motor.displace(steps);
        assert_eq!(motor.measured(16), shown);
    }
    assert_eq!(motor.measured(32), -6_400, "in the pulses of the driver");
    motor.power_on();
    assert_eq!(motor.measured(16), 0);
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig::with_cases(64)))]
    #[test]
    fn without_drive_the_energy_never_grows(
        velocity in -3_000.0f64..3_000.0,
        friction in 0u32..100,
        drag in 0u32..100,
        detent in 0u32..100,
        torque in -20i32..=20,
        inertia in 0u32..2_000,
        compliance in 2u32..100,
    ) {
        let data = MotorData {
            detent_torque: detent,
            load: Load { inertia, friction, drag, torque, compliance, ..Load::default() },
            ..MotorData::default()
        };
        data.check().unwrap();
        let mut motor = Motor::new(&data, 0, Some(&(-3_200..=3_200)));
        motor.rotor.velocity = velocity;
        let start = motor.rotor.energy(&motor.mechanics);
        // What a step of the integration may be wrong by: the energy of the detents swings a little.
        let allowed = 0.02 * start.abs() + 1e-5;
        for _ in 0..20_000 {
            motor.step(OFF);
            let energy = motor.rotor.energy(&motor.mechanics);
            prop_assert!(energy <= start + allowed, "{energy} > {start}");
        }
    }

    #[test]
    fn the_same_pulses_give_the_same_motion_bit_for_bit(
        pulses in prop::collection::vec(-3i64..=3, 1..400),
        current in 0u16..3_000,
    ) {
        let run = || {
            let mut motor = with_load(ordinary());
            for pulse in &pulses {
                motor.take(*pulse, MICROSTEPS);
                motor.step(Orders { current, ..RATED });
            }
            (motor.rotor.position.to_bits(), motor.rotor.velocity.to_bits())
        };
        prop_assert_eq!(run(), run());
    }
}

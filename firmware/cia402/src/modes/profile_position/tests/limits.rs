//! Limits that are written while a set-point is under way, waits, or is halted; and ramps too gentle for a software limit.

use motion::Ramps;
use proptest::prelude::*;
use proptest::test_runner::contextualize_config;

use super::{HALT, IMMEDIATELY};
use crate::controlword::CHANGE_ON_SET_POINT;
use crate::profile::all_ramps;
use crate::testing::Rig;

/// A drive on its way to 100,000, past 5,000.
fn under_way() -> Rig {
    let mut rig = Rig::enabled();
    rig.set_point(100_000, 0);
    rig.until("on its way", |rig| rig.motor.position > 5_000);
    assert_eq!(rig.speed(), 10);
    rig
}

fn limit(rig: &mut Rig, low: i32, high: i32) {
    rig.configuration.position_limits = (low, high);
    rig.post();
}

/// The farthest position until the motor stands, and where that is.
fn farthest(rig: &mut Rig) -> (i64, i64) {
    rig.tick();
    let mut farthest = rig.motor.position;
    while rig.actuals().is_moving {
        rig.tick();
        farthest = farthest.max(rig.motor.position);
    }
    (farthest, rig.motor.position)
}

#[test]
fn d21_a_software_limit_written_on_the_way_ends_the_move() {
    for sign in [1, -1] {
        let mut rig = Rig::enabled();
        rig.set_point(100_000 * sign, 0);
        rig.ticks(600);
        limit(&mut rig, -20_000, 20_000);
        rig.tick();
        assert!(rig.limited());
        assert_eq!(rig.rest(), i64::from(20_000 * sign));
        rig.ticks(50);
        assert!(rig.limited() && !rig.reached());
        // Nothing moves by itself when it is lifted behind the end.
        limit(&mut rig, 0, 0);
        assert_eq!(rig.rest(), i64::from(20_000 * sign));
        rig.set_point(0, 0);
        assert_eq!(rig.rest(), 0);
        rig.ticks(50);
        assert!(!rig.limited() && rig.reached());
    }
}

#[test]
fn d21_a_software_limit_written_during_halt_counts_when_it_is_released() {
    let mut rig = under_way();
    rig.write(0x1F | HALT);
    rig.rest();
    limit(&mut rig, -1, 50_000);
    rig.tick();
    rig.write(0x1F);
    rig.tick();
    assert!(rig.limited());
    assert_eq!(rig.rest(), 50_000);
    rig.ticks(50);
    assert!(rig.limited() && !rig.reached());
}

#[test]
fn d21_a_software_limit_written_during_halt_behind_the_motor_lets_it_stand() {
    let mut rig = under_way();
    rig.write(0x1F | HALT);
    let halted = rig.rest();
    limit(&mut rig, -1, 3_000);
    rig.write(0x1F);
    assert_eq!(rig.rest(), halted);
    assert!(rig.limited() && !rig.reached());
    rig.set_point(2_000, 0);
    assert_eq!(rig.rest(), 2_000);
}

#[test]
fn d21_a_software_limit_that_is_lifted_on_the_way_lets_the_target_be_reached() {
    let mut rig = under_way();
    limit(&mut rig, -1, 20_000);
    rig.ticks(10);
    assert!(rig.limited());
    limit(&mut rig, -1, 200_000);
    rig.tick();
    assert!(!rig.limited());
    assert_eq!(rig.rest(), 100_000);
    rig.ticks(50);
    assert!(rig.reached());
}

#[test]
fn d21_a_software_limit_counts_for_a_set_point_that_waits() {
    let mut rig = under_way();
    rig.set_point(0, IMMEDIATELY);
    rig.ticks(2);
    rig.set_point(100_000, 0);
    rig.tick();
    limit(&mut rig, -1, 20_000);
    rig.tick();
    assert!(!rig.limited(), "the one under way is within");
    rig.until("the first target", |rig| rig.motor.position == 0);
    rig.until("the limit", |rig| rig.motor.position == 20_000);
    rig.ticks(50);
    assert_eq!(rig.motor.position, 20_000);
    assert!(rig.limited() && !rig.reached());
}

#[test]
fn a_limit_written_on_the_way_keeps_the_blending() {
    let mut rig = Rig::enabled();
    rig.set_point(20_000, 0);
    rig.ticks(500);
    rig.set_point(40_000, CHANGE_ON_SET_POINT);
    rig.tick();
    rig.configuration.max_velocity = 9_000.into();
    limit(&mut rig, -1, 30_000);
    rig.until("the first target", |rig| rig.motor.position >= 19_990);
    assert_eq!(rig.speed(), 9);
    assert_eq!(rig.rest(), 30_000);
    assert!(rig.limited());
}

#[test]
fn m44_a_software_limit_nearer_than_6084h_allows_is_met_on_a_harder_ramp() {
    let mut rig = under_way();
    let near = i32::try_from(rig.motor.position).unwrap() + 150;
    limit(&mut rig, -1, near);
    rig.tick();
    assert!(rig.limited());
    assert_eq!(farthest(&mut rig), (near.into(), near.into()));
    rig.ticks(50);
    assert!(rig.limited() && !rig.reached());
}

#[test]
fn m44_a_software_limit_nearer_than_6085h_allows_is_passed_without_a_way_back() {
    let mut rig = under_way();
    let near = i32::try_from(rig.motor.position).unwrap() + 40;
    limit(&mut rig, -1, near);
    let (farthest, end) = farthest(&mut rig);
    assert_eq!(farthest, end, "it does not come back");
    assert!((10..=40).contains(&(end - i64::from(near))), "{end}");
    assert!(rig.limited() && !rig.reached());
    rig.set_point(100, 0);
    assert_eq!(rig.rest(), 100);
}

#[test]
fn m39_limits_of_velocity_and_ramps_bite_on_the_distance() {
    let mut rig = under_way();
    rig.configuration.max_velocity = 4_000.into();
    rig.post();
    rig.tick();
    assert!(rig.limited());
    rig.ticks(100);
    assert_eq!(rig.speed(), 4);
    rig.configuration.max_velocity = u32::MAX.into();
    rig.configuration.max_acceleration = 10_000;
    rig.post();
    rig.ticks(100);
    assert_eq!(rig.speed(), 5, "60C5h");
    rig.ticks(600);
    assert_eq!(rig.speed(), 10);
    rig.configuration.max_deceleration = 20_000;
    rig.post();
    let braking = 10_000 * 10_000 / 2 / 20_000;
    rig.until("braking", |rig| rig.motor.position >= 100_000 - braking);
    rig.ticks(100);
    assert_eq!(rig.speed(), 8, "60C6h");
    assert_eq!(rig.rest(), 100_000);
    rig.ticks(50);
    assert!(rig.reached() && rig.limited(), "the profile was cut");
}

#[test]
fn m39_a_lower_60c6h_while_the_motor_brakes_takes_it_not_beyond_its_target() {
    let mut rig = under_way();
    rig.until("braking", |rig| rig.motor.position >= 99_800);
    rig.configuration.max_deceleration = 10_000;
    rig.post();
    assert_eq!(farthest(&mut rig), (100_000, 100_000));
    assert!(rig.limited());
}

#[test]
fn what_is_written_but_changes_no_limit_changes_no_motion() {
    let mut rig = under_way();
    rig.until("braking", |rig| rig.motor.position >= 99_700);
    let mut speed = rig.speed();
    while rig.actuals().is_moving {
        rig.configuration.position_window_time += 1;
        rig.post();
        let next = rig.speed();
        assert!(next <= speed + 1, "from {speed} to {next}");
        speed = next;
    }
    assert!(!rig.limited());
    assert_eq!(rig.motor.position, 100_000);
}

#[test]
fn m44_a_gentler_6084h_carries_no_set_point_through_a_software_limit() {
    for target in [6_000, 4_000] {
        let mut rig = Rig::enabled();
        limit(&mut rig, -1, 6_000);
        rig.set_point(6_000, 0);
        rig.until("600 steps before it", |rig| rig.motor.position >= 5_300);
        rig.commands.profile_deceleration = 10_000;
        rig.set_point(target, IMMEDIATELY);
        rig.tick();
        assert!(rig.limited(), "the ramp is not the one asked for");
        let (farthest, end) = farthest(&mut rig);
        assert!(farthest <= 6_000, "{farthest}");
        assert_eq!(end, target.into());
        rig.ticks(50);
        assert!(rig.reached());
    }
}

#[test]
fn m44_a_set_point_given_again_while_it_brakes_to_a_limit_is_not_limited() {
    for profile in all_ramps(2_000_000) {
        let mut rig = Rig::enabled();
        rig.configuration.profile.ramps = profile;
        limit(&mut rig, -1, 6_000);
        rig.set_point(6_000, 0);
        rig.until("braking", |rig| rig.motor.position >= 5_500);
        while rig.actuals().is_moving {
            rig.set_point(6_000, IMMEDIATELY);
            rig.tick();
            assert!(!rig.limited(), "{profile:?} at {}", rig.motor.position);
            assert!(rig.motor.position <= 6_000);
        }
        assert_eq!(rig.motor.position, 6_000);
    }
}

/// The stop that is tried out has the window of the motion that comes after it.
#[test]
fn m44_an_average_that_begins_in_motion_stops_before_the_limit() {
    let mut rig = Rig::enabled();
    limit(&mut rig, -1, 6_000);
    rig.commands.profile_acceleration = 50_000;
    rig.commands.profile_deceleration = 50_000;
    rig.set_point(6_000, 0);
    // A linear ramp takes 1,000 steps, and half of a window of 101 ms 505 more.
    rig.until("1,200 steps before it", |rig| rig.motor.position >= 4_800);
    rig.configuration.profile.ramps = Ramps::MovingAverage(50_000_000);
    rig.commands.profile_acceleration = 5_000_000;
    rig.set_point(5_999, IMMEDIATELY);
    rig.tick();
    assert!(rig.limited(), "the ramp is not the one asked for");
    let (farthest, end) = farthest(&mut rig);
    assert!(farthest <= 6_000, "{farthest}");
    assert_eq!(end, 5_999);
}

#[test]
fn m30_an_end_velocity_that_is_cut_shows_in_bit_11() {
    // To 6081h, to 607Fh, and to what a software limit behind the target leaves.
    for (end, velocity, high) in [
        (11_000, u32::MAX, 0),
        (9_000, 8_000, 0),
        (9_000, u32::MAX, 5_100),
    ] {
        let mut rig = Rig::enabled();
        rig.configuration.max_velocity = velocity.into();
        rig.configuration.position_limits = (-1, high);
        rig.commands.end_velocity = end.into();
        rig.set_point(5_000, 0);
        rig.tick();
        assert!(rig.limited(), "{end} {velocity} {high}");
    }
    let mut rig = Rig::enabled();
    rig.commands.end_velocity = 9_000.into();
    rig.set_point(5_000, 0);
    rig.tick();
    assert!(!rig.limited());
}

/// A set-point or a target velocity, and the ramps with which it is to be gone to.
#[derive(Clone, Copy, Debug)]
struct Order {
    mode: i8,
    number: i32,
    bits: u16,
    end_velocity: u32,
    deceleration: u32,
    ramps: Ramps,
    hold: usize,
}

fn any_order(ramps: std::vec::Vec<Ramps>) -> impl Strategy<Value = Order> {
    (
        prop::sample::select(std::vec![1, 3]),
        -6_000..6_000,
        prop::sample::select(std::vec![0, IMMEDIATELY, CHANGE_ON_SET_POINT]),
        prop::sample::select(std::vec![0, 0, 3_000]),
        5_000u32..200_000,
        prop::sample::select(ramps),
        1usize..200,
    )
        .prop_map(
            |(mode, number, bits, end_velocity, deceleration, ramps, hold)| Order {
                mode,
                number,
                bits,
                end_velocity,
                deceleration,
                ramps,
                hold,
            },
        )
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig::with_cases(128)))]
    /// However ramps, profiles, targets and velocities follow each other: no software limit is passed.
    #[test]
    fn m44_no_software_limit_is_passed(
        orders in prop::collection::vec(any_order(built_in_ramps()), 1..20),
    ) {
        assert_no_limit_is_passed(orders)?;
    }

    #[cfg(feature = "limited-jerk")]
    #[test]
    fn m44_no_software_limit_is_passed_with_limited_jerk(
        orders in prop::collection::vec(any_order(all_ramps(5_000_000)), 1..20),
    ) {
        assert_no_limit_is_passed(orders)?;
    }
}

/// What the random orders above have found.
#[test]
fn m44_no_software_limit_is_passed_by_orders_that_once_did() {
    use Ramps::{Linear, MovingAverage, SinSquared};
    let ways: [&[_]; 3] = [
        // Harder limits of an order elsewhere: how soon they bring the acceleration of now to zero depends on its velocity too.
        &[
            (1, 451, 0, 3_000, 84_359, Linear, 99),
            (3, 2_901, 0, 0, 10_084, Linear, 162),
            (3, 2_229, 0, 0, 5_000, Linear, 99),
            (3, 3_832, 0, 0, 31_003, Linear, 143),
            (1, 0, 0, 0, 30_949, Linear, 22),
            (3, -979, 0, 0, 192_454, Linear, 115),
            (1, 0, 0, 0, 16_773, Linear, 120),
            (1, 2_994, 0, 0, 68_370, SinSquared, 79),
            (1, 0, IMMEDIATELY, 0, 104_761, SinSquared, 38),
        ],
        // On the limit, half a step before standstill.
        &[
            (3, 486, 0, 0, 5_000, Linear, 129),
            (3, 2_093, 0, 0, 5_000, Linear, 167),
            (1, 0, 0, 0, 114_214, Linear, 39),
            (1, 1_996, 0, 3_000, 14_132, SinSquared, 123),
            (1, 0, 0, 0, 5_000, Linear, 116),
            (1, 2_004, IMMEDIATELY, 3_000, 80_914, Linear, 49),
            (3, 2_650, 0, 0, 35_553, SinSquared, 108),
            (3, 1_784, 0, 0, 124_982, Linear, 69),
            (3, 1, 0, 0, 5_000, Linear, 72),
            (3, -1, 0, 0, 5_000, Linear, 6),
        ],
        // sin² to the target of a mean.
        &[
            (1, 429, 0, 0, 62_856, Linear, 50),
            (
                1,
                3_000,
                IMMEDIATELY,
                0,
                48_478,
                MovingAverage(5_000_000),
                43,
            ),
            (1, 0, 0, 0, 5_000, Linear, 98),
            (1, 0, 0, 0, 5_000, Linear, 23),
            (1, 0, 0, 0, 5_000, Linear, 51),
            (1, 0, CHANGE_ON_SET_POINT, 0, 5_000, Linear, 95),
            (1, 3_000, IMMEDIATELY, 0, 48_478, SinSquared, 69),
        ],
    ];
    for way in ways {
        let order = |(mode, number, bits, end_velocity, deceleration, ramps, hold)| Order {
            mode,
            number,
            bits,
            end_velocity,
            deceleration,
            ramps,
            hold,
        };
        assert_no_limit_is_passed(way.iter().copied().map(order).collect()).unwrap();
    }
}

/// The ramps of the default image.
fn built_in_ramps() -> std::vec::Vec<Ramps> {
    std::vec![
        Ramps::Linear,
        Ramps::SinSquared,
        Ramps::MovingAverage(5_000_000)
    ]
}

fn assert_no_limit_is_passed(orders: std::vec::Vec<Order>) -> Result<(), TestCaseError> {
    let mut rig = Rig::enabled();
    rig.configuration.quick_stop_deceleration = 4_000_000;
    rig.configuration.position_limits = (-3_000, 3_000);
    for order in orders {
        rig.commands.mode = order.mode;
        rig.commands.profile_deceleration = order.deceleration;
        rig.commands.end_velocity = order.end_velocity.into();
        rig.configuration.profile.ramps = order.ramps;
        rig.commands.target_velocity = (order.number * 2).into();
        rig.set_point(order.number, order.bits);
        for _ in 0..order.hold {
            rig.tick();
            prop_assert!(
                rig.motor.position.abs() <= 3_000,
                "{:?}: {}",
                order,
                rig.motor.position
            );
        }
    }
    Ok(())
}

use crate::Mode;
use crate::profile::all_ramps;
use crate::statusword::{INTERNAL_LIMIT, SLIPPAGE, SPEED_ZERO, TARGET_REACHED};
use crate::testing::Rig;
use motion::Ramps;

/// A drive in profile velocity, at rest. 6083h and 6084h are 100,000 steps/s²: 100 ticks to 10,000 steps/s.
fn enabled() -> Rig {
    let mut rig = Rig::enabled();
    rig.commands.mode = Mode::ProfileVelocity.code();
    rig.configuration.velocity_window = 100.into();
    rig.configuration.velocity_window_time = 10;
    rig.configuration.velocity_threshold = 50.into();
    rig.configuration.velocity_threshold_time = 5;
    rig.post();
    rig.ticks(20);
    assert_eq!(rig.actuals().mode_display, 3);
    rig
}

fn run(rig: &mut Rig, velocity: i32) {
    rig.commands.target_velocity = velocity.into();
    rig.post();
}

/// The greatest change of speed from one tick to the next, in steps per tick, over so many ticks.
fn roughest(rig: &mut Rig, ticks: usize) -> i64 {
    let mut before = rig.speed();
    let mut roughest = 0;
    for _ in 0..ticks {
        let speed = rig.speed();
        roughest = roughest.max((speed - before).abs());
        before = speed;
    }
    roughest
}

#[test]
fn m41_a_change_in_the_ramp_goes_on_without_a_jump() {
    let mut rig = enabled();
    run(&mut rig, 10_000);
    rig.ticks(50);
    run(&mut rig, 2_000);
    // A tenth of a step per tick on 6083h and 6084h, and a step of rounding.
    assert!(roughest(&mut rig, 200) <= 2);
    assert_eq!(rig.actuals().velocity_actual, 2_000);
}

#[test]
fn m41_a_change_of_sign_passes_through_zero_on_both_ramps() {
    let mut rig = enabled();
    rig.commands.profile_acceleration = 50_000;
    run(&mut rig, 10_000);
    rig.ticks(300);
    run(&mut rig, -10_000);
    let begin = rig.motor.position;
    let slowing = rig.until("standstill", |rig| rig.actuals().velocity_demand <= 0);
    assert!((100..=105).contains(&slowing), "{slowing} ticks on 6084h");
    assert!((500..545).contains(&(rig.motor.position - begin)));
    let speeding = rig.until("speed", |rig| rig.actuals().velocity_demand == -10_000);
    assert!((198..=203).contains(&speeding), "{speeding} ticks on 6083h");
    assert_eq!(rig.speed(), -10);
}

#[test]
fn d27_halt_stops_and_release_runs_again() {
    let mut rig = enabled();
    run(&mut rig, 10_000);
    rig.ticks(200);
    rig.write(0x10F);
    rig.tick();
    assert!(!rig.reached());
    let stopped = rig.rest();
    assert!(rig.has(TARGET_REACHED | SPEED_ZERO));
    run(&mut rig, 5_000);
    rig.ticks(50);
    assert_eq!(rig.motor.position, stopped);
    rig.write(0x0F);
    rig.ticks(200);
    assert_eq!(rig.speed(), 5);
}

#[test]
fn m42_speed_is_zero_by_threshold_and_time() {
    let mut rig = enabled();
    run(&mut rig, 40);
    rig.ticks(50);
    assert!(rig.has(SPEED_ZERO), "below the threshold");
    run(&mut rig, 1_000);
    let above = rig.until("above", |rig| rig.actuals().velocity_actual > 50);
    let told = rig.until("told", |rig| !rig.has(SPEED_ZERO));
    assert_eq!(told, 5, "{above} ticks to the threshold");
    run(&mut rig, 0);
    rig.until("below", |rig| rig.actuals().velocity_actual <= 50);
    assert!(rig.has(SPEED_ZERO), "at once");
}

#[test]
fn m42_slippage_shows_while_the_motor_does_not_follow() {
    let mut rig = enabled();
    rig.configuration.max_slippage = 2_000.into();
    run(&mut rig, 10_000);
    rig.ticks(200);
    assert!(!rig.has(SLIPPAGE));
    for _ in 0..20 {
        rig.motor.position -= 5;
        rig.tick();
    }
    assert!(rig.has(SLIPPAGE));
    let velocity = rig.actuals().velocity_actual;
    assert!((4_500..=5_500).contains(&velocity), "{velocity}");
    assert!(rig.actuals().following_error >= 99);
    rig.ticks(20);
    assert!(!rig.has(SLIPPAGE));
}

#[test]
fn m39_the_velocity_is_cut_and_bit_11_tells() {
    let mut rig = enabled();
    rig.configuration.max_velocity = 4_000.into();
    run(&mut rig, -10_000);
    rig.ticks(200);
    assert_eq!(rig.speed(), -4);
    assert!(rig.limited() && !rig.reached());
    rig.configuration.max_velocity = 20_000.into();
    rig.post();
    rig.ticks(200);
    assert_eq!(rig.speed(), -10);
    assert!(!rig.limited() && rig.reached());
}

#[test]
fn m39_ramps_are_capped_by_60c5h_and_60c6h() {
    let mut rig = enabled();
    rig.configuration.max_acceleration = 50_000;
    rig.configuration.max_deceleration = 20_000;
    run(&mut rig, 10_000);
    rig.tick();
    assert!(rig.limited());
    let speeding = rig.until("speed", |rig| rig.actuals().velocity_demand == 10_000);
    assert!((198..=204).contains(&speeding), "{speeding}");
    run(&mut rig, 0);
    let slowing = rig.until("rest", |rig| rig.actuals().velocity_demand == 0);
    assert!((498..=504).contains(&slowing), "{slowing}");
}

#[test]
fn m44_a_software_limit_is_never_passed_and_the_way_back_is_free() {
    let mut rig = enabled();
    rig.configuration.position_limits = (-300, 5_000);
    run(&mut rig, 10_000);
    rig.ticks(200);
    assert!(!rig.limited(), "on its way");
    assert_eq!(rig.rest(), 5_000);
    assert!(rig.limited() && !rig.reached() && rig.has(SPEED_ZERO));
    run(&mut rig, -10_000);
    rig.tick();
    assert!(!rig.has(INTERNAL_LIMIT));
    assert_eq!(rig.rest(), -300);
    assert!(rig.limited());
}

#[test]
fn m44_beyond_a_limit_only_the_way_back_is_free() {
    let mut rig = enabled();
    run(&mut rig, 1_000);
    rig.ticks(500);
    run(&mut rig, 0);
    let beyond = rig.rest();
    rig.configuration.position_limits = (0, 100);
    run(&mut rig, 1_000);
    assert_eq!(rig.rest(), beyond);
    assert!(rig.limited());
    run(&mut rig, -1_000);
    assert_eq!(rig.rest(), 0);
}

#[test]
fn m44_a_gentler_6084h_carries_no_velocity_through_a_software_limit() {
    // 6084h, and a velocity the other way that is braked for with it.
    for velocity in [10_000, -3_000] {
        let mut rig = enabled();
        rig.configuration.position_limits = (-8_000, 8_000);
        run(&mut rig, 10_000);
        rig.until("600 steps before it", |rig| rig.motor.position >= 7_400);
        rig.commands.profile_deceleration = 10_000;
        run(&mut rig, velocity);
        rig.tick();
        assert!(rig.limited(), "{velocity}");
        let mut farthest = 0;
        for _ in 0..1_000 {
            rig.tick();
            farthest = farthest.max(rig.motor.position);
        }
        assert!(
            (7_990..=8_000).contains(&farthest),
            "{velocity}: {farthest}"
        );
        assert_eq!(rig.limited(), velocity > 0, "{velocity}");
    }
}

#[test]
fn m44_with_a_gentle_6085h_the_ramp_that_was_begun_stops_the_motor_before_the_limit() {
    let mut rig = enabled();
    rig.configuration.quick_stop_deceleration = 20_000;
    rig.configuration.position_limits = (-8_000, 8_000);
    run(&mut rig, 10_000);
    rig.until("braking", |rig| rig.motor.position >= 7_700);
    rig.commands.profile_deceleration = 10_000;
    rig.post();
    rig.tick();
    assert_eq!(rig.rest(), 8_000);
}

#[test]
fn m44_a_limit_that_appears_too_near_stops_the_motor_without_a_way_back() {
    let mut rig = enabled();
    run(&mut rig, 10_000);
    rig.ticks(200);
    let near = i32::try_from(rig.motor.position).unwrap() + 100;
    rig.configuration.position_limits = (-1_000, near);
    // 6085h: 250 steps.
    rig.configuration.quick_stop_deceleration = 200_000;
    rig.post();
    let stopped = rig.rest();
    let beyond = stopped - i64::from(near);
    assert!((150..=180).contains(&beyond), "{beyond} steps beyond");
    assert!(rig.limited());
    assert_eq!(rig.rest(), stopped);
}

#[test]
fn m19_from_profile_position_the_motor_goes_on_to_60ffh() {
    let mut rig = Rig::enabled();
    rig.set_point(100_000, 0);
    rig.ticks(200);
    rig.commands.mode = 3;
    run(&mut rig, 4_000);
    rig.tick();
    assert_eq!(rig.actuals().mode_display, 3);
    assert!(roughest(&mut rig, 100) <= 2);
    assert_eq!(rig.actuals().velocity_demand, 4_000);
    rig.commands.mode = 1;
    rig.post();
    rig.tick();
    assert_eq!(rig.actuals().mode_display, 3, "it slows down first");
    let stopped = rig.rest();
    assert_eq!(rig.actuals().mode_display, 1);
    rig.ticks(50);
    assert_eq!(rig.motor.position, stopped, "the set-point is forgotten");
}

#[test]
fn m09_60ffh_during_quick_stop_is_ignored() {
    let mut rig = enabled();
    run(&mut rig, 10_000);
    rig.ticks(200);
    rig.configuration.quick_stop = crate::testing::quick_stop(6);
    rig.write(0x02);
    rig.tick();
    run(&mut rig, 20_000);
    let stopped = rig.rest();
    rig.ticks(50);
    assert_eq!(rig.motor.position, stopped);
}

#[test]
fn i11_a_velocity_crosses_the_end_of_32_bits_without_a_jump() {
    for ramps in all_ramps(2_000_000) {
        for sign in [1, -1] {
            cross(ramps, sign);
        }
    }
}

/// Across the end at a velocity that is kept, back across it within a ramp that turns, and to rest.
fn cross(ramps: Ramps, sign: i32) {
    let mut rig = enabled();
    rig.configuration.profile.ramps = ramps;
    // Turned by hand, without power.
    rig.write(0x00);
    rig.ticks(3);
    rig.motor.position = i64::from(sign) * (i64::from(i32::MAX) - 5_000);
    rig.ticks(3);
    for controlword in [0x06, 0x07, 0x0F] {
        rig.write(controlword);
        rig.tick();
    }
    run(&mut rig, 10_000 * sign);
    rig.ticks(300);
    let mut before = rig.actuals().position_actual;
    assert_eq!(before.signum(), sign, "{ramps:?}: not there yet");
    for _ in 0..1_000 {
        assert_eq!(rig.speed(), i64::from(10 * sign), "{ramps:?}");
        let actuals = rig.actuals();
        assert_eq!(actuals.position_actual.wrapping_sub(before), 10 * sign);
        assert_eq!(actuals.following_error.abs() / 2, 0);
        before = actuals.position_actual;
    }
    assert_eq!(before.signum(), -sign, "{ramps:?}: wrapped");
    assert!(rig.reached() && !rig.limited());
    run(&mut rig, -10_000 * sign);
    let turned = (0..2_000).any(|_| {
        rig.tick();
        let now = rig.actuals().position_actual;
        let step = now.wrapping_sub(before);
        assert!(step.abs() <= 11, "{ramps:?}: {step} steps in a tick");
        before = now;
        step.signum() == -sign && now.signum() == sign
    });
    assert!(turned, "{ramps:?}: back across the end");
    run(&mut rig, 0);
    rig.rest();
    assert_eq!(rig.actuals().velocity_demand, 0, "{ramps:?}");
    assert!(!rig.limited());
}

#[test]
fn ramps_written_behind_an_edge_of_bit_4_count_at_once() {
    let mut rig = enabled();
    rig.commands.target_velocity = 10_000.into();
    rig.write(0x1F);
    rig.commands.profile_acceleration = 1_000_000;
    rig.post();
    let ticks = rig.until("velocity", |rig| rig.actuals().velocity_demand == 10_000);
    assert!(ticks <= 15, "{ticks}");
}

#[test]
fn m44_no_order_hardens_the_ramp_beyond_6085h() {
    let mut rig = enabled();
    run(&mut rig, 10_000);
    rig.ticks(200);
    let near = i32::try_from(rig.motor.position).unwrap() + 100;
    rig.configuration.position_limits = (-1_000, near);
    // 6085h: 250 steps.
    rig.configuration.quick_stop_deceleration = 200_000;
    rig.post();
    let before = rig.motor.position;
    for tick in 0..100 {
        run(&mut rig, 10_000 + tick % 2);
        rig.tick();
    }
    assert_eq!(rig.speed(), 0);
    // What was committed before goes on: up to 20 steps.
    let distance = rig.motor.position - before;
    assert!((250..=280).contains(&distance), "{distance} steps");
    assert!(rig.limited());
}

#[test]
fn m44_a_limit_that_6085h_just_spares_is_reached_whatever_is_asked_for() {
    for near in [280, 300, 400] {
        let mut rig = enabled();
        run(&mut rig, 10_000);
        rig.ticks(200);
        let near = i32::try_from(rig.motor.position).unwrap() + near;
        rig.configuration.position_limits = (-1_000, near);
        rig.configuration.quick_stop_deceleration = 200_000;
        rig.commands.profile_deceleration = 20_000;
        rig.post();
        for tick in 0..300 {
            run(&mut rig, 10_000 + tick % 2);
            rig.tick();
        }
        let beyond = rig.motor.position - i64::from(near);
        assert!((-2..=1).contains(&beyond), "{near}: {beyond} steps beyond");
    }
}

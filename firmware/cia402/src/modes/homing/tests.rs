//! Homing in the drive: what the statusword says of it, and what it leaves behind.

use crate::configuration::HomingConfiguration;
use crate::inputs::InputConfiguration;
use crate::state_machine::State;
use crate::statusword::{HOMING_ATTAINED, HOMING_ERROR, INTERNAL_LIMIT, TARGET_REACHED};
use crate::testing::Rig;

const START: u16 = 0x1F;

/// A drive in operation enabled, in homing mode; input 1 is the home switch, 2 the negative and 3 the positive limit switch.
fn homing(method: i8) -> Rig {
    let mut rig = Rig::new();
    rig.commands.mode = 6;
    rig.configuration.inputs = InputConfiguration {
        home: 1,
        negative_limit: 2,
        positive_limit: 4,
        ..InputConfiguration::NONE
    };
    rig.configuration.homing = HomingConfiguration {
        method,
        search_speed: 10_000.into(),
        zero_speed: 1_000.into(),
        acceleration: 200_000,
        ..HomingConfiguration::NONE
    };
    rig.enable();
    rig
}

/// Bits 13, 12 and 10.
fn bits(rig: &Rig) -> (bool, bool, bool) {
    (
        rig.has(HOMING_ERROR),
        rig.has(HOMING_ATTAINED),
        rig.reached(),
    )
}

/// Ticks with the home switch active from position `edge` on, until the condition holds.
fn until(rig: &mut Rig, edge: i64, condition: impl Fn(&Rig) -> bool) {
    for _ in 0..20_000 {
        rig.digital.levels = u8::from(rig.motor.position >= edge);
        rig.tick();
        if condition(rig) {
            return;
        }
    }
    panic!("never; {:?}", rig.actuals());
}

#[test]
fn m47_the_bits_from_idle_to_attained() {
    let mut rig = homing(19);
    assert_eq!(bits(&rig), (false, false, true));
    rig.write(START);
    rig.tick();
    assert_eq!(
        bits(&rig),
        (false, false, false),
        "in the tick that takes the start"
    );
    until(&mut rig, 500, |rig| {
        let bits = bits(rig);
        assert!(!bits.0);
        bits.1
    });
    assert_eq!(bits(&rig), (false, true, true));
    assert!(rig.actuals().referenced);
}

#[test]
fn m52_positions_count_from_the_home_position_and_nothing_trips() {
    for (subtracted, at_home) in [(false, 250), (true, -250)] {
        let mut rig = homing(19);
        rig.configuration.homing.offset = 250;
        rig.configuration.homing.options = u16::from(subtracted);
        rig.post();
        rig.write(START);
        until(&mut rig, 500, |rig| rig.has(HOMING_ATTAINED));
        let shown = rig.actuals();
        // The switch is looked at once a tick, at 1,000 steps/s.
        let home = rig.motor.position - i64::from(shown.position_actual) + at_home;
        assert!((498..=500).contains(&home), "{home}");
        assert_eq!(shown.position_demand, shown.position_actual);
        rig.ticks(50);
        assert_eq!(rig.state(), State::OperationEnabled);
        assert_eq!(rig.notices(), []);
        // A target counts from there too.
        rig.commands.mode = 1;
        rig.write(0x0F);
        rig.ticks(3);
        rig.set_point(i32::try_from(at_home).unwrap(), 0);
        assert_eq!(rig.rest(), home);
        assert_eq!(i64::from(rig.actuals().position_actual), at_home);
    }
}

#[test]
fn m48_bit_4_that_falls_interrupts_and_the_old_home_stays() {
    let mut rig = homing(37);
    rig.write(START);
    rig.ticks(3);
    assert_eq!(bits(&rig), (false, true, true));
    rig.write(0x0F);
    rig.tick();
    rig.configuration.homing.method = 19;
    rig.post();
    rig.write(START);
    rig.ticks(100);
    assert_eq!(bits(&rig), (false, false, false));
    rig.write(0x0F);
    rig.tick();
    assert!(!rig.reached(), "the motor has not stopped yet");
    rig.rest();
    assert_eq!(bits(&rig), (false, false, true));
    assert!(rig.actuals().referenced);
    // Entered anew, the mode tells of the home position again.
    for mode in [1, 6] {
        rig.commands.mode = mode;
        rig.post();
        rig.ticks(3);
    }
    assert_eq!(bits(&rig), (false, true, true));
}

#[test]
fn m49_halt_pauses_and_release_goes_on() {
    let mut rig = homing(19);
    rig.write(START);
    rig.ticks(30);
    rig.write(START | 0x100);
    rig.tick();
    assert!(!rig.reached());
    let halted = rig.rest();
    assert_eq!(bits(&rig), (false, false, true));
    rig.ticks(100);
    assert_eq!(rig.motor.position, halted);
    rig.write(START);
    rig.tick();
    assert_eq!(bits(&rig), (false, false, false));
    until(&mut rig, 500, |rig| rig.has(HOMING_ATTAINED));
}

#[test]
fn m50_what_is_no_method_or_has_no_switch_fails_and_moves_nothing() {
    for (method, failure) in [(0, 7), (15, 7), (33, 1), (1, 1), (-3, 1)] {
        let mut rig = homing(method);
        rig.write(START);
        rig.tick();
        assert!(
            rig.has(HOMING_ERROR) && !rig.has(HOMING_ATTAINED),
            "method {method}"
        );
        rig.ticks(20);
        assert_eq!(bits(&rig), (true, false, true));
        assert_eq!(rig.motor.position, 0);
        assert_eq!(rig.actuals().homing_failure, failure);
        // The next start is another try.
        rig.write(0x0F);
        rig.configuration.homing.method = 35;
        rig.post();
        rig.write(START);
        rig.ticks(3);
        assert_eq!(bits(&rig), (false, true, true));
        assert_eq!(rig.actuals().homing_failure, 0);
    }
}

#[test]
fn m51_what_is_written_on_the_way_counts_for_the_next_time() {
    let mut rig = homing(19);
    rig.write(START);
    rig.ticks(20);
    rig.configuration.homing = HomingConfiguration {
        method: 21,
        search_speed: 1.into(),
        offset: 9_999,
        ..HomingConfiguration::NONE
    };
    rig.post();
    until(&mut rig, 2_000, |rig| rig.has(HOMING_ATTAINED));
    assert!(rig.actuals().position_actual.abs() < 100);
}

#[test]
fn m20_a_held_start_bit_starts_nothing_with_the_mode() {
    let mut rig = Rig::enabled();
    rig.configuration.homing.method = 37;
    rig.post();
    rig.write(START);
    rig.ticks(3);
    rig.commands.mode = 6;
    rig.post();
    rig.ticks(10);
    assert_eq!(rig.actuals().mode_display, 6);
    assert_eq!(bits(&rig), (false, false, true));
    assert!(!rig.actuals().referenced);
}

#[test]
fn disabling_interrupts_and_enabling_does_not_go_on() {
    let mut rig = homing(19);
    rig.write(START);
    rig.ticks(50);
    rig.write(0x07);
    rig.until("switched on", |rig| rig.state() == State::SwitchedOn);
    let stopped = rig.rest();
    rig.write(0x0F);
    rig.ticks(100);
    assert_eq!(rig.motor.position, stopped);
    assert_eq!(bits(&rig), (false, false, true));
}

#[test]
fn a_limit_switch_that_is_not_looked_for_is_an_error() {
    let mut rig = homing(19);
    rig.write(START);
    rig.ticks(50);
    rig.digital.levels = 4;
    rig.tick();
    assert!(rig.has(HOMING_ERROR) && !rig.reached());
    rig.rest();
    assert_eq!(bits(&rig), (true, false, true));
    assert_eq!(rig.actuals().homing_failure, 2);
    assert_eq!(rig.state(), State::OperationEnabled, "no fault");
}

#[test]
fn a_hard_stop_is_felt_by_the_motor_driver() {
    let mut rig = homing(-3);
    rig.configuration.homing.block_time = 5;
    rig.configuration.homing.back_off = 40;
    rig.stall = Some(false);
    rig.post();
    rig.write(START);
    rig.ticks(60);
    assert!(!rig.has(HOMING_ERROR));
    rig.stall = Some(true);
    let mut blocked_at = 0;
    for _ in 0..7 {
        blocked_at = rig.motor.position;
        rig.tick();
    }
    rig.stall = Some(false);
    rig.until("attained", |rig| rig.has(HOMING_ATTAINED));
    assert_eq!(rig.actuals().position_actual, -40);
    assert!((rig.motor.position + 40 - blocked_at).abs() <= 10);
    assert_eq!(rig.state(), State::OperationEnabled);
}

#[test]
fn power_that_goes_in_motion_takes_the_home_position_along() {
    let mut rig = homing(37);
    rig.write(START);
    rig.ticks(3);
    rig.write(0x00);
    rig.ticks(3);
    assert!(rig.actuals().referenced, "at rest nothing is lost");
    rig.commands.mode = 1;
    rig.enable();
    rig.set_point(100_000, 0);
    rig.ticks(50);
    rig.write(0x00);
    rig.ticks(2);
    assert!(!rig.actuals().referenced);
}

/// A drive in profile position with limit switches at inputs 2 and 3.
fn limited() -> Rig {
    let mut rig = homing(0);
    rig.commands.mode = 1;
    rig.post();
    rig.ticks(3);
    rig
}

#[test]
fn m54_a_limit_switch_stops_and_leaves_the_way_back_free() {
    let mut rig = limited();
    rig.set_point(100_000, 0);
    rig.ticks(200);
    let met = rig.motor.position;
    rig.digital.levels = 4;
    rig.tick();
    assert!(rig.has(INTERNAL_LIMIT));
    let stopped = rig.rest();
    // 10,000 steps/s on 1,000,000 steps/s², and what was under way.
    assert!((50..120).contains(&(stopped - met)), "{}", stopped - met);
    assert_eq!(rig.actuals().digital_inputs, 0x0004_0002);
    rig.ticks(100);
    assert!(!rig.reached(), "m36: not at the target");
    assert_eq!(rig.state(), State::OperationEnabled);
    assert_eq!(rig.notices(), []);
    // On into the switch: refused. Back: at once.
    rig.set_point(200_000, 0);
    rig.ticks(50);
    assert_eq!(rig.motor.position, stopped);
    assert!(rig.acknowledged());
    rig.set_point(0, 0);
    rig.ticks(100);
    assert!(rig.motor.position < stopped);
    rig.digital.levels = 0;
    assert_eq!(rig.rest(), 0);
    rig.ticks(20);
    assert!(rig.reached() && !rig.has(INTERNAL_LIMIT));
    let target_reached = rig.has(TARGET_REACHED);
    assert!(target_reached);
}

#[test]
fn m48_an_interrupted_homing_slows_down_no_faster_than_allowed() {
    let mut rig = homing(19);
    rig.configuration.max_deceleration = 20_000;
    rig.post();
    rig.write(START);
    rig.ticks(200);
    let begin = rig.motor.position;
    rig.write(0x0F);
    let distance = rig.rest() - begin;
    // 10,000 steps/s on 20,000 steps/s², not on 200,000.
    assert!((2_500..2_600).contains(&distance), "{distance}");
}

#[test]
fn m39_speeds_and_ramps_of_homing_that_are_cut_show_in_bit_11() {
    type Cut = fn(&mut Rig);
    let cuts: [Cut; 3] = [
        |rig| rig.configuration.max_velocity = 4_000.into(),
        |rig| rig.configuration.max_acceleration = 20_000,
        |rig| rig.configuration.max_deceleration = 20_000,
    ];
    for cut in cuts {
        let mut rig = homing(19);
        cut(&mut rig);
        rig.post();
        rig.tick();
        assert!(!rig.has(INTERNAL_LIMIT), "nothing is under way");
        rig.write(START);
        rig.ticks(3);
        assert!(rig.has(INTERNAL_LIMIT));
        until(&mut rig, 500, |rig| rig.has(HOMING_ATTAINED));
        assert!(!rig.has(INTERNAL_LIMIT), "it is done");
    }
    // 6099h:2 alone is below 607Fh.
    let mut rig = homing(19);
    rig.configuration.max_velocity = 4_000.into();
    rig.post();
    rig.write(START);
    until(&mut rig, 500, |rig| rig.motor.position > 500);
    until(&mut rig, 500, |rig| rig.actuals().velocity_demand == -1_000);
    assert!(!rig.has(INTERNAL_LIMIT));
    // Neither is there anything to tell where nothing is cut.
    let mut rig = homing(19);
    rig.write(START);
    until(&mut rig, 500, |rig| {
        assert!(!rig.has(INTERNAL_LIMIT));
        rig.has(HOMING_ATTAINED)
    });
}

#[test]
fn m39_the_halt_of_a_homing_whose_speed_is_cut_is_cut_only_in_its_own_ramp() {
    for stop_is_cut in [false, true] {
        let mut rig = homing(19);
        rig.configuration.max_velocity = 4_000.into();
        if stop_is_cut {
            rig.configuration.max_deceleration = 20_000;
        }
        rig.post();
        rig.write(START);
        rig.ticks(100);
        assert!(rig.has(INTERNAL_LIMIT));
        rig.write(START | 0x100);
        rig.ticks(5);
        assert!(rig.speed() > 0, "it slows down");
        assert_eq!(rig.has(INTERNAL_LIMIT), stop_is_cut);
        rig.rest();
        assert!(!rig.has(INTERNAL_LIMIT), "nothing is under way");
        rig.write(START);
        rig.ticks(50);
        assert!(rig.has(INTERNAL_LIMIT));
    }
}

#[test]
fn m57_homing_does_not_look_at_the_software_limits() {
    let mut rig = homing(19);
    rig.configuration.position_limits = (-100, 100);
    rig.post();
    rig.write(START);
    until(&mut rig, 500, |rig| rig.has(HOMING_ATTAINED));
    assert!((490..=500).contains(&rig.motor.position));
    assert!(!rig.has(INTERNAL_LIMIT));
}

/// Homing that drives back, with the end of the 32-bit count at position 490, 10 steps before the switch.
fn across_the_count(offset: i32) -> Rig {
    let mut rig = homing(37);
    rig.configuration.homing.offset = i32::MAX - 490;
    rig.post();
    rig.write(START);
    rig.ticks(3);
    rig.write(0x0F);
    rig.configuration.homing.method = 19;
    rig.configuration.homing.acceleration = 20_000;
    rig.configuration.homing.options |= 1 << 3;
    rig.configuration.homing.offset = offset;
    rig.post();
    rig.write(START);
    rig
}

#[test]
fn the_way_back_home_is_the_short_one_across_the_end_of_the_count() {
    let mut rig = across_the_count(250);
    until(&mut rig, 500, |rig| {
        rig.has(HOMING_ATTAINED) || rig.has(HOMING_ERROR)
    });
    assert_eq!(bits(&rig), (false, true, true));
    assert_eq!(rig.actuals().position_actual, 250);
    assert!((498..=500).contains(&rig.motor.position));
}

#[test]
fn the_motor_goes_back_to_a_home_position_at_the_end_of_the_count() {
    // Behind home the count that is shown has begun anew.
    let mut rig = across_the_count(i32::MIN);
    until(&mut rig, 500, |rig| {
        rig.has(HOMING_ATTAINED) || rig.has(HOMING_ERROR)
    });
    assert_eq!(bits(&rig), (false, true, true));
    assert_eq!(rig.actuals().position_actual, i32::MIN);
    assert!((498..=500).contains(&rig.motor.position));
}

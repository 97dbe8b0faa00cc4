use motion::{AdvanceError, PulseSink as _};

use crate::faults::FaultNotice::{Cleared, Raised};
use crate::faults::{EXTERNAL, POSITION_MISMATCH, PULSES_LATE, UNDER_VOLTAGE};
use crate::state_machine::State;
use crate::testing::Rig;

const OVER_TEMPERATURE: u16 = 0x4210;
const OVER_CURRENT: u16 = 0x2310;

fn cruising() -> Rig {
    let mut rig = Rig::enabled();
    rig.set_point(100_000, 0);
    rig.ticks(200);
    rig
}

#[test]
fn d09_a_fault_on_the_way_stops_on_the_quick_stop_ramp() {
    let mut rig = cruising();
    let begin = rig.motor.position;
    rig.fault = Some(OVER_TEMPERATURE);
    rig.tick();
    assert_eq!(rig.state(), State::FaultReactionActive);
    assert!(rig.outputs.power_stage);
    rig.until("fault", |rig| rig.state() == State::Fault);
    let stopped = rig.motor.position - begin;
    assert!((50..90).contains(&stopped), "{stopped} steps");
    assert!(!rig.outputs.power_stage);
}

#[test]
fn m10_the_code_shows_and_is_sent_once() {
    let mut rig = cruising();
    assert_eq!(rig.actuals().error_code, 0);
    rig.fault = Some(OVER_TEMPERATURE);
    assert_eq!(rig.tick().error_code, OVER_TEMPERATURE);
    rig.ticks(100);
    rig.fault = None;
    rig.ticks(10);
    rig.fault = Some(OVER_TEMPERATURE);
    rig.ticks(10);
    assert_eq!(rig.notices(), [Raised(OVER_TEMPERATURE)]);
}

#[test]
fn a_fault_at_standstill_still_shows_the_reaction() {
    let mut rig = Rig::enabled();
    rig.fault = Some(OVER_TEMPERATURE);
    rig.tick();
    assert_eq!(rig.state(), State::FaultReactionActive);
    rig.tick();
    assert_eq!(rig.state(), State::Fault);
}

#[test]
fn a_fault_before_operation_never_switches_the_power_on() {
    let mut rig = Rig::new();
    rig.ticks(2);
    rig.fault = Some(OVER_TEMPERATURE);
    for state in [State::FaultReactionActive, State::Fault, State::Fault] {
        rig.tick();
        assert_eq!(rig.state(), state);
        assert!(!rig.outputs.power_stage);
    }
}

#[test]
fn a_fault_of_the_current_cuts_the_power_at_once() {
    let mut rig = cruising();
    rig.fault = Some(OVER_CURRENT);
    rig.tick();
    assert_eq!(rig.state(), State::FaultReactionActive);
    assert!(!rig.outputs.power_stage && rig.outputs.drop_pulses);
    rig.tick();
    assert_eq!(rig.state(), State::Fault);
}

#[test]
fn an_axis_that_has_failed_is_a_fault_and_home_is_unknown_whatever_20a2h_says() {
    for late_is_fault in [true, false] {
        let mut rig = homed(100_000);
        rig.configuration.late_is_fault = late_is_fault;
        rig.post();
        rig.ticks(200);
        rig.drive.motor.look_at(Err(AdvanceError::Internal));
        rig.until("fault", |rig| rig.state() == State::Fault);
        assert_eq!(rig.actuals().error_code, PULSES_LATE);
        assert!(!rig.actuals().referenced);
        assert_eq!(rig.notices(), [Raised(PULSES_LATE)]);
    }
}

/// A drive whose home position is known and that goes on by `target` steps.
fn homed(target: i32) -> Rig {
    let mut rig = Rig::new();
    rig.commands.mode = 6;
    rig.configuration.homing.method = 37;
    rig.enable();
    rig.write(0x1F);
    rig.ticks(3);
    assert!(rig.actuals().referenced);
    rig.commands.mode = 1;
    rig.write(0x0F);
    rig.ticks(2);
    rig.set_point(target, 0);
    rig.tick();
    rig
}

#[test]
fn pulses_cut_off_from_outside_end_operation_at_once_and_take_the_home_position_along() {
    let mut rig = homed(100_000);
    rig.ticks(200);
    rig.fault = Some(EXTERNAL);
    rig.tick();
    assert_eq!(rig.state(), State::FaultReactionActive);
    assert!(!rig.outputs.power_stage && rig.outputs.drop_pulses);
    rig.tick();
    assert_eq!(rig.state(), State::Fault);
    assert!(!rig.actuals().referenced);
    assert_eq!(rig.notices(), [Raised(EXTERNAL)]);
}

#[test]
fn pulses_cut_off_from_outside_in_the_last_tick_of_a_motion_take_the_home_position_along() {
    // The tick that finds the break is the one that finds every pulse counted, too.
    let mut rig = homed(1_000);
    rig.until("last pulse", |rig| rig.motor.pending() == 0);
    rig.fault = Some(EXTERNAL);
    rig.ticks(2);
    assert_eq!(rig.state(), State::Fault);
    assert!(!rig.actuals().referenced);
}

#[test]
fn pulses_cut_off_from_outside_at_rest_keep_the_home_position() {
    let mut rig = homed(1_000);
    rig.rest();
    rig.fault = Some(EXTERNAL);
    rig.ticks(10);
    assert_eq!(rig.state(), State::Fault);
    assert!(rig.actuals().referenced);
}

#[test]
fn a_worse_fault_during_the_reaction_cuts_the_power() {
    let mut rig = cruising();
    rig.configuration.quick_stop_deceleration = 10_000;
    rig.post();
    rig.fault = Some(OVER_TEMPERATURE);
    rig.ticks(3);
    assert!(rig.outputs.power_stage);
    rig.fault = Some(OVER_CURRENT);
    rig.tick();
    assert!(!rig.outputs.power_stage && rig.outputs.drop_pulses);
    assert_eq!(
        rig.notices(),
        [Raised(OVER_TEMPERATURE), Raised(OVER_CURRENT)]
    );
}

#[test]
fn d10_only_the_rising_edge_of_bit_7_resets() {
    let mut rig = Rig::enabled();
    rig.write(0x8F);
    rig.tick();
    rig.fault = Some(OVER_TEMPERATURE);
    rig.ticks(3);
    rig.fault = None;
    rig.ticks(3);
    assert_eq!(rig.state(), State::Fault, "bit 7 is held");
    rig.write(0x8F);
    rig.ticks(3);
    assert_eq!(rig.state(), State::Fault, "written again");
    rig.write(0x0F);
    rig.ticks(3);
    assert_eq!(rig.state(), State::Fault);
    rig.write(0x8F);
    rig.tick();
    assert_eq!(rig.state(), State::SwitchOnDisabled);
    assert_eq!(
        rig.notices(),
        [Raised(OVER_TEMPERATURE), Cleared(OVER_TEMPERATURE)]
    );
}

#[test]
fn m11_a_reset_does_not_enable() {
    let mut rig = Rig::enabled();
    rig.fault = Some(OVER_TEMPERATURE);
    rig.ticks(3);
    rig.fault = None;
    rig.write(0x00);
    rig.tick();
    rig.write(0x8F);
    rig.ticks(5);
    assert_eq!(rig.state(), State::SwitchOnDisabled);
    rig.write(0x06);
    rig.tick();
    assert_eq!(rig.state(), State::ReadyToSwitchOn);
}

#[test]
fn m12_a_fault_reset_in_another_state_does_nothing() {
    let mut rig = Rig::enabled();
    rig.write(0x8F);
    rig.ticks(3);
    assert_eq!(rig.state(), State::OperationEnabled);
    assert!(rig.notices().is_empty());
}

#[test]
fn m13_the_supply_lost_in_operation_is_a_fault() {
    let mut rig = cruising();
    rig.supply = false;
    rig.tick();
    assert!(!rig.outputs.power_stage && rig.outputs.drop_pulses);
    rig.ticks(3);
    assert_eq!(rig.actuals().error_code, UNDER_VOLTAGE);
    assert_eq!(rig.state(), State::Fault);
    rig.write(0x80);
    rig.ticks(3);
    assert_eq!(rig.state(), State::Fault, "still no supply");
    rig.supply = true;
    rig.write(0x00);
    rig.tick();
    rig.write(0x80);
    rig.tick();
    assert_eq!(rig.state(), State::SwitchOnDisabled);
}

#[test]
fn an_encoder_may_show_the_play_of_the_motor_but_no_lost_step() {
    let mut rig = Rig::enabled();
    rig.position_tolerance = 33;
    rig.set_point(1_000, 0);
    assert_eq!(rig.rest(), 1_000);
    for play in [-33, 66, -33] {
        rig.motor.position += play;
        rig.ticks(3);
        assert_eq!(rig.state(), State::OperationEnabled);
    }
    rig.motor.position -= 34;
    rig.ticks(3);
    assert_eq!(rig.state(), State::Fault);
    assert_eq!(rig.actuals().error_code, POSITION_MISMATCH);
}

#[test]
fn pulses_that_went_astray_are_found_at_rest() {
    let mut rig = Rig::enabled();
    rig.set_point(1_000, 0);
    assert_eq!(rig.rest(), 1_000);
    rig.motor.position -= 1;
    rig.ticks(3);
    assert_eq!(rig.state(), State::Fault);
    assert_eq!(rig.actuals().error_code, POSITION_MISMATCH);
    rig.write(0x00);
    rig.tick();
    rig.write(0x80);
    rig.tick();
    assert_eq!(
        rig.state(),
        State::SwitchOnDisabled,
        "without power the axis has taken over the position"
    );
    assert_eq!(
        rig.notices(),
        [Raised(POSITION_MISMATCH), Cleared(POSITION_MISMATCH)]
    );
}

#[test]
fn d10_a_reset_counts_while_the_reaction_goes_on_only_to_be_seen() {
    // The motor moves at first, and the master waits for so many ticks before it resets.
    for (waits, resets) in [(1, false), (30, true), (49, true)] {
        let mut rig = cruising();
        rig.exchange.watch(true);
        rig.fault = Some(OVER_TEMPERATURE);
        rig.tick();
        rig.fault = None;
        rig.ticks(waits);
        assert_eq!(rig.state(), State::FaultReactionActive);
        rig.write(0x80);
        rig.ticks(3);
        rig.write(0x00);
        rig.ticks(60);
        let ends = if resets {
            State::SwitchOnDisabled
        } else {
            State::Fault
        };
        assert_eq!(rig.state(), ends, "{waits}");
    }
}

#[test]
fn d10_a_reset_and_the_way_up_in_a_hurry_count_while_the_reaction_goes_on_only_to_be_seen() {
    for waits in [30, 49] {
        let mut rig = cruising();
        rig.exchange.watch(true);
        rig.fault = Some(OVER_TEMPERATURE);
        rig.tick();
        rig.fault = None;
        rig.ticks(waits);
        assert_eq!(rig.state(), State::FaultReactionActive);
        for controlword in [0x80, 0x06, 0x0F] {
            rig.write(controlword);
        }
        rig.ticks(60);
        assert_eq!(rig.state(), State::OperationEnabled, "{waits}");
    }
    // While the motor still slows down the reset is for nothing, and so is what comes with it.
    let mut rig = cruising();
    rig.exchange.watch(true);
    rig.fault = Some(OVER_TEMPERATURE);
    rig.tick();
    rig.fault = None;
    for controlword in [0x80, 0x06, 0x0F] {
        rig.write(controlword);
    }
    rig.ticks(100);
    assert_eq!(rig.state(), State::Fault);
    rig.write(0x8F);
    rig.write(0x0F);
    rig.ticks(10);
    assert_eq!(rig.state(), State::SwitchOnDisabled);
}

#[test]
fn d10_a_reset_during_the_reaction_is_for_no_fault_that_follows() {
    let mut rig = cruising();
    rig.exchange.watch(true);
    rig.fault = Some(OVER_TEMPERATURE);
    rig.ticks(30);
    rig.write(0x80);
    rig.tick();
    rig.fault = Some(OVER_CURRENT);
    rig.tick();
    rig.fault = None;
    rig.ticks(60);
    assert_eq!(rig.state(), State::Fault);
    rig.write(0x00);
    rig.write(0x80);
    rig.tick();
    assert_eq!(rig.state(), State::SwitchOnDisabled);
}

#[test]
fn d12_a_reset_during_the_reaction_with_the_cause_present_stays_in_fault() {
    let mut rig = cruising();
    rig.exchange.watch(true);
    rig.fault = Some(OVER_TEMPERATURE);
    rig.ticks(30);
    rig.write(0x80);
    rig.ticks(60);
    assert_eq!(rig.state(), State::Fault);
    rig.fault = None;
    rig.ticks(10);
    assert_eq!(rig.state(), State::Fault);
}

use motion::PulseSink;

use crate::state_machine::State;
use crate::statusword;
use crate::testing::{Rig, quick_stop};

/// A drive that cruises at 10 steps a tick.
fn cruising() -> Rig {
    let mut rig = Rig::enabled();
    rig.set_point(100_000, 0);
    rig.ticks(200);
    assert_eq!(rig.speed(), 10);
    rig
}

#[test]
fn m07_each_option_stops_on_its_ramp_and_ends_in_its_state() {
    // 10000 steps/s: 500 steps on 6084h, 50 on 6085h; the two time slices that are committed already come on top.
    for (option, ramp, end) in [
        (1, 500, State::SwitchOnDisabled),
        (2, 50, State::SwitchOnDisabled),
        (3, 50, State::SwitchOnDisabled),
        (4, 50, State::SwitchOnDisabled),
        (5, 500, State::QuickStopActive),
        (6, 50, State::QuickStopActive),
        (7, 50, State::QuickStopActive),
        (8, 50, State::QuickStopActive),
    ] {
        let mut rig = cruising();
        rig.configuration.quick_stop = quick_stop(option);
        let begin = rig.motor.position;
        rig.write(0x02);
        rig.tick();
        assert_eq!(rig.state(), State::QuickStopActive);
        assert!(rig.outputs.power_stage);
        let stopped = rig.rest() - begin;
        assert!(
            (ramp..ramp + 40).contains(&stopped),
            "option {option}: {stopped} steps"
        );
        assert_eq!(rig.state(), end, "option {option}");
        assert_eq!(rig.outputs.power_stage, end == State::QuickStopActive);
        assert_eq!(
            rig.reached(),
            end == State::QuickStopActive,
            "bit 10 tells that it stands"
        );
    }
}

#[test]
fn the_power_goes_off_after_the_last_pulse() {
    let stop = |option: Option<i16>| {
        let mut rig = cruising();
        // So hard that the ramp ends long before the pulses committed already have left.
        rig.configuration.quick_stop_deceleration = 50_000_000;
        match option {
            Some(option) => {
                rig.configuration.quick_stop = quick_stop(option);
                rig.write(0x02);
            }
            None => rig.write(0x07),
        }
        rig.until("power off", |rig| !rig.outputs.power_stage || rig.reached());
        rig.ticks(5);
        rig.motor.position
    };
    assert_eq!(stop(Some(1)), stop(Some(5)));
    assert_eq!(stop(Some(2)), stop(Some(6)));
    assert_eq!(stop(None), stop(Some(5)));
}

#[test]
fn m07_option_0_cuts_the_power() {
    let mut rig = cruising();
    rig.configuration.quick_stop = quick_stop(0);
    rig.write(0x02);
    rig.tick();
    assert_eq!(rig.state(), State::QuickStopActive);
    assert!(!rig.outputs.power_stage && rig.outputs.drop_pulses);
    rig.tick();
    assert_eq!(rig.state(), State::SwitchOnDisabled);
}

#[test]
fn m08_quick_stop_active_shows_even_at_standstill() {
    for option in [0, 1, 2] {
        let mut rig = Rig::enabled();
        rig.ticks(5);
        rig.configuration.quick_stop = quick_stop(option);
        rig.write(0x02);
        rig.tick();
        assert_eq!(rig.state(), State::QuickStopActive);
        rig.tick();
        assert_eq!(rig.state(), State::SwitchOnDisabled);
    }
}

#[test]
fn m09_a_set_point_during_quick_stop_is_ignored() {
    let mut rig = cruising();
    rig.configuration.quick_stop = quick_stop(6);
    rig.write(0x02);
    rig.tick();
    rig.commands.target_position = 5;
    rig.write(0x12);
    rig.tick();
    assert!(!rig.acknowledged());
    let stopped = rig.rest();
    assert!(stopped > 1_000);
    rig.write(0x0F);
    rig.tick();
    assert_eq!(rig.state(), State::OperationEnabled, "transition 16");
    assert_eq!(rig.rest(), stopped);
    rig.set_point(-20, 0);
    assert_eq!(rig.rest(), -20);
}

#[test]
fn d08_a_quick_stop_is_never_cut_short() {
    for (option, end) in [(2, State::SwitchOnDisabled), (6, State::OperationEnabled)] {
        let mut rig = cruising();
        rig.configuration.quick_stop = quick_stop(option);
        rig.write(0x02);
        rig.tick();
        rig.write(0x0F);
        rig.tick();
        assert_eq!(rig.state(), State::QuickStopActive);
        rig.rest();
        assert_eq!(rig.state(), end);
    }
}

#[test]
fn disable_voltage_leaves_quick_stop_active_at_once() {
    let mut rig = cruising();
    rig.configuration.quick_stop = quick_stop(5);
    rig.write(0x02);
    rig.tick();
    rig.write(0x00);
    rig.tick();
    assert_eq!(rig.state(), State::SwitchOnDisabled);
    assert!(!rig.outputs.power_stage);
    assert_eq!(rig.motor.pending(), 0);
}

#[test]
fn m05_shutdown_on_the_way_cuts_the_power() {
    let mut rig = cruising();
    rig.write(0x06);
    rig.tick();
    assert_eq!(rig.state(), State::ReadyToSwitchOn);
    assert!(!rig.outputs.power_stage && rig.outputs.drop_pulses);
}

#[test]
fn m05_disable_operation_on_the_way_stops_with_6084h() {
    let mut rig = cruising();
    let begin = rig.motor.position;
    rig.write(0x07);
    let stopped = rig.rest() - begin;
    assert!((500..540).contains(&stopped), "{stopped} steps");
    assert_eq!(rig.state(), State::SwitchedOn);
    assert!(!rig.outputs.power_stage);
}

#[test]
fn m06_quick_stop_depends_on_the_state() {
    for (path, end) in [
        (&[0x06][..], State::SwitchOnDisabled),
        (&[0x06, 0x07], State::SwitchOnDisabled),
        (&[0x06, 0x07, 0x0F], State::QuickStopActive),
    ] {
        let mut rig = Rig::new();
        rig.ticks(2);
        for &controlword in path {
            rig.write(controlword);
            rig.tick();
        }
        rig.write(0x02);
        rig.tick();
        assert_eq!(rig.state(), end);
    }
}

#[test]
fn a_quick_stop_between_two_ticks_is_obeyed() {
    let mut rig = cruising();
    rig.write(0x02);
    rig.write(0x0F);
    rig.tick();
    assert_eq!(rig.state(), State::QuickStopActive);
    rig.rest();
    assert_eq!(rig.state(), State::SwitchOnDisabled);
}

#[test]
fn a_stop_without_a_ramp_stops_the_pulses() {
    let mut rig = cruising();
    rig.configuration.quick_stop = quick_stop(6);
    rig.configuration.quick_stop_deceleration = 0;
    rig.write(0x02);
    rig.tick();
    assert!(rig.outputs.power_stage && rig.outputs.drop_pulses);
    let stopped = rig.seen;
    rig.ticks(5);
    assert_eq!(rig.motor.position, stopped);
    assert!(!rig.outputs.drop_pulses);
    rig.write(0x0F);
    rig.tick();
    rig.set_point(7, 0);
    assert_eq!(rig.rest(), 7, "the position is known exactly");
    assert!(rig.reached());
    assert!(!rig.has(statusword::WARNING));
}

#[test]
fn m14_a_warning_of_the_board_shows_and_changes_no_state() {
    use crate::faults::FaultNotice;
    let mut rig = cruising();
    rig.warning = Some(0x4210);
    rig.ticks(5);
    assert!(rig.has(statusword::WARNING));
    assert_eq!(rig.state(), State::OperationEnabled);
    assert_eq!(rig.speed(), 10);
    assert_eq!(rig.actuals().error_code, 0, "no fault");
    rig.warning = None;
    rig.tick();
    assert!(!rig.has(statusword::WARNING));
    assert_eq!(
        rig.notices(),
        [FaultNotice::Raised(0x4210), FaultNotice::Cleared(0x4210)]
    );
}

#[test]
fn pulses_that_come_late_are_a_fault() {
    use crate::faults::{FaultNotice, PULSES_LATE};
    let mut rig = cruising();
    rig.motor.play(10_000);
    rig.until("fault", |rig| rig.state() == State::Fault);
    assert_eq!(rig.actuals().error_code, PULSES_LATE);
    assert_eq!(rig.notices(), [FaultNotice::Raised(PULSES_LATE)]);
}

#[test]
fn pulses_that_come_late_are_only_told_where_20a2h_is_0() {
    use crate::faults::{FaultNotice, PULSES_LATE};
    let mut rig = cruising();
    rig.configuration.late_is_fault = false;
    rig.post();
    rig.motor.play(10_000);
    rig.ticks(2);
    assert!(rig.has(statusword::WARNING));
    assert_eq!(rig.state(), State::OperationEnabled);
    rig.until("target", Rig::reached);
    rig.rest();
    assert_eq!(rig.motor.position, 100_000);
    assert!(!rig.has(statusword::WARNING));
    assert_eq!(
        rig.notices(),
        [
            FaultNotice::Raised(PULSES_LATE),
            FaultNotice::Cleared(PULSES_LATE)
        ]
    );
}

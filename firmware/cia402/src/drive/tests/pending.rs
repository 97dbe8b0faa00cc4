//! Stops under way, and what comes in between: a motor that is told to stop goes on stopping, and never more gently.

use crate::option_codes::{AbortConnectionOption, Stop, StopRamp};
use crate::state_machine::State;
use crate::testing::{Rig, quick_stop};

const HALT: u16 = 1 << 8;

/// A drive that turns at 10,000 steps/s: 500 steps to rest on 6084h, 50 on 6085h.
fn turning(mode: i8) -> Rig {
    let mut rig = Rig::enabled();
    rig.commands.mode = mode;
    rig.commands.target_velocity = motion::SignedSpeed::per_second(10_000);
    rig.write(0x0F);
    rig.ticks(3);
    if mode == 1 {
        rig.set_point(100_000, 0);
    }
    rig.ticks(200);
    assert_eq!(rig.speed(), 10, "mode {mode}");
    rig
}

#[test]
fn m05_a_controlword_with_bit_7_is_no_command_and_takes_none_back() {
    for (command, end) in [(0x07, State::SwitchedOn), (0x06, State::ReadyToSwitchOn)] {
        for bits in [0x80, 0x80 | command] {
            for mode in [1, 3] {
                let mut rig = turning(mode);
                rig.configuration.shutdown = Stop::on_leaving(1).unwrap();
                let begin = rig.motor.position;
                rig.write(command);
                rig.ticks(30);
                assert_eq!(rig.state(), State::OperationEnabled);
                rig.write(bits);
                let distance = rig.rest() - begin;
                assert!(
                    (500..540).contains(&distance),
                    "{bits:X}h, mode {mode}: {distance}"
                );
                assert_eq!(rig.state(), end, "{bits:X}h, mode {mode}");
                rig.ticks(50);
                assert_eq!(rig.motor.position - begin, distance);
            }
        }
    }
}

#[test]
fn m05_a_command_that_bit_7_overwrites_before_the_control_tick_is_obeyed() {
    for (command, end) in [(0x07, State::SwitchedOn), (0x06, State::ReadyToSwitchOn)] {
        let mut rig = turning(3);
        rig.configuration.shutdown = Stop::on_leaving(1).unwrap();
        let begin = rig.motor.position;
        rig.write(command);
        rig.write(0x80 | command);
        let distance = rig.rest() - begin;
        assert!((500..540).contains(&distance), "{command:X}h: {distance}");
        assert_eq!(rig.state(), end, "{command:X}h");
    }
    // The last one that is one, and only once.
    let mut rig = turning(3);
    rig.write(0x07);
    rig.write(0x0F);
    rig.write(0x8F);
    rig.ticks(200);
    assert_eq!((rig.state(), rig.speed()), (State::OperationEnabled, 10));
    rig.write(0x00);
    rig.tick();
    rig.write(0x06);
    rig.write(0x86);
    rig.tick();
    assert_eq!(rig.state(), State::ReadyToSwitchOn);
    rig.ticks(20);
    assert_eq!(rig.state(), State::ReadyToSwitchOn);
}

#[test]
fn m05_enable_operation_takes_back_what_has_not_happened() {
    let mut rig = turning(3);
    rig.write(0x07);
    rig.ticks(30);
    rig.write(0x87);
    rig.ticks(10);
    rig.write(0x0F);
    rig.ticks(200);
    assert_eq!(rig.state(), State::OperationEnabled);
    assert_eq!(rig.speed(), 10);
    rig.write(0x8F);
    rig.ticks(200);
    assert_eq!(rig.speed(), 10, "nothing is pending any more");
}

#[test]
fn m05_of_two_pending_commands_the_last_counts() {
    let mut rig = turning(3);
    rig.configuration.shutdown = Stop::on_leaving(1).unwrap();
    rig.write(0x07);
    rig.ticks(30);
    rig.write(0x06);
    rig.write(0x86);
    rig.ticks(10);
    rig.write(0x06);
    rig.rest();
    assert_eq!(rig.state(), State::ReadyToSwitchOn);
}

/// Steps to rest.
fn distance(rig: &mut Rig) -> i64 {
    let begin = rig.motor.position;
    rig.rest() - begin
}

#[test]
fn d15_a_mode_change_makes_a_halt_no_gentler() {
    for late in [None, Some(true), Some(false)] {
        let mut rig = turning(3);
        rig.configuration.halt = StopRamp::on_halt(2).unwrap();
        match late {
            // Together, as ros2_canopen does it.
            None => {
                rig.commands.mode = 1;
                rig.write(0x0F | HALT);
            }
            Some(mode_is_late) => {
                let change = |rig: &mut Rig, is_mode: bool| {
                    if is_mode {
                        rig.commands.mode = 1;
                        rig.post();
                    } else {
                        rig.write(0x0F | HALT);
                    }
                };
                change(&mut rig, !mode_is_late);
                rig.ticks(2);
                change(&mut rig, mode_is_late);
            }
        }
        let distance = distance(&mut rig);
        // In the two ticks the motor may have begun to stop.
        assert!((30..110).contains(&distance), "{late:?}: {distance} steps");
        assert_eq!(rig.actuals().mode_display, 1);
    }
}

#[test]
fn m35_a_command_to_leave_makes_a_halt_no_gentler() {
    for together in [true, false] {
        let mut rig = turning(3);
        rig.configuration.halt = StopRamp::on_halt(2).unwrap();
        if !together {
            rig.write(0x0F | HALT);
            rig.ticks(2);
        }
        rig.write(0x07 | HALT);
        let distance = distance(&mut rig);
        assert!((30..90).contains(&distance), "{together}: {distance} steps");
        assert_eq!(rig.state(), State::SwitchedOn);
    }
}

#[test]
fn m16_the_loss_of_the_network_hardens_a_slow_quick_stop() {
    for option in [1, 5] {
        let mut rig = turning(3);
        rig.configuration.quick_stop = quick_stop(option);
        rig.write(0x02);
        rig.ticks(10);
        rig.commands.remote = false;
        rig.commands.connection_error = Some(0x8130);
        rig.post();
        let distance = distance(&mut rig);
        assert!(
            (30..90).contains(&distance),
            "605Ah = {option}: {distance} steps"
        );
        assert_eq!(rig.state(), State::SwitchOnDisabled);
    }
}

#[test]
fn m16_the_loss_of_the_network_hardens_a_slow_fault_reaction() {
    let mut rig = turning(3);
    rig.configuration.fault_reaction = Stop::on_fault(1).unwrap();
    rig.post();
    rig.fault = Some(0x4210);
    rig.ticks(10);
    assert_eq!(rig.state(), State::FaultReactionActive);
    rig.commands.remote = false;
    rig.commands.connection_error = Some(0x8130);
    rig.post();
    let distance = distance(&mut rig);
    assert!((30..90).contains(&distance), "{distance} steps");
    assert_eq!(rig.state(), State::Fault);
}

#[test]
fn m16_with_6007h_0_a_quick_stop_stays_as_it_is() {
    let mut rig = turning(3);
    rig.configuration.abort_connection = AbortConnectionOption::from_code(0).unwrap();
    rig.configuration.quick_stop = quick_stop(5);
    rig.write(0x02);
    rig.ticks(10);
    rig.commands.remote = false;
    rig.commands.connection_error = Some(0x8130);
    rig.post();
    let distance = distance(&mut rig);
    assert!((380..450).contains(&distance), "{distance} steps");
    assert_eq!(rig.state(), State::QuickStopActive);
}

//! Changes of 6060h.

use super::HALT;
use crate::state_machine::State;
use crate::testing::Rig;

#[test]
fn m18_an_unsupported_mode_in_a_pdo_is_ignored() {
    let mut rig = Rig::enabled();
    rig.commands.mode = 5;
    rig.set_point(100, 0);
    assert_eq!(rig.rest(), 100);
    assert_eq!(rig.actuals().mode_display, 1);
}

#[test]
fn m19_a_mode_change_on_the_way_stops_first() {
    let mut rig = Rig::enabled();
    rig.set_point(100_000, 0);
    rig.ticks(200);
    let begin = rig.motor.position;
    rig.commands.mode = 0;
    rig.post();
    rig.tick();
    assert_eq!(rig.actuals().mode_display, 1, "not yet");
    let stopped = rig.rest() - begin;
    assert!((500..540).contains(&stopped), "{stopped}");
    assert_eq!(rig.actuals().mode_display, 0);
    assert_eq!(rig.state(), State::OperationEnabled);
}

#[test]
fn d14_a_mode_change_at_speed_is_a_smooth_stop() {
    let mut rig = Rig::enabled();
    rig.set_point(100_000, 0);
    rig.ticks(200);
    let mut speed = rig.speed();
    rig.commands.mode = 0;
    rig.post();
    while rig.actuals().mode_display == 1 {
        let next = rig.speed();
        assert!(
            (next - speed).abs() <= 1,
            "from {speed} to {next} steps a tick"
        );
        speed = next;
    }
    assert_eq!(speed, 0, "6061h changes when the motor stands");
}

#[test]
fn d15_a_mode_change_with_halt_is_accepted_at_speed() {
    let mut rig = Rig::enabled();
    rig.set_point(100_000, 0);
    rig.ticks(200);
    rig.commands.mode = 0;
    rig.write(0x1F | HALT);
    let stopped = rig.rest();
    assert_eq!(rig.actuals().mode_display, 0);
    rig.commands.mode = 1;
    rig.write(0x0F);
    rig.tick();
    assert_eq!(rig.actuals().mode_display, 1);
    assert_eq!(rig.rest(), stopped, "the end of the halt finds no target");
}

#[test]
fn m19_a_mode_change_taken_back_still_stops() {
    let mut rig = Rig::enabled();
    rig.set_point(100_000, 0);
    rig.ticks(200);
    rig.commands.mode = 0;
    rig.post();
    rig.ticks(3);
    rig.commands.mode = 1;
    rig.post();
    assert!(rig.rest() < 3_000);
    assert!(!rig.acknowledged());
    rig.set_point(0, 0);
    assert_eq!(rig.rest(), 0);
}

#[test]
fn m20_a_mode_change_works_in_every_state_and_moves_nothing() {
    for path in [&[][..], &[0x06], &[0x06, 0x07], &[0x06, 0x07, 0x0F]] {
        for bits in [0, HALT, 0x10, HALT | 0x10] {
            let mut rig = Rig::new();
            rig.commands.mode = 0;
            rig.commands.target_position = 1_000;
            rig.ticks(2);
            for &controlword in path {
                rig.write(controlword | bits);
                rig.tick();
            }
            let state = rig.state();
            for mode in [1, 0, 1] {
                rig.commands.mode = mode;
                rig.post();
                rig.tick();
                assert_eq!(rig.actuals().mode_display, mode, "{state:?} {bits:X}");
            }
            rig.ticks(50);
            assert_eq!(rig.state(), state);
            assert_eq!(rig.motor.position, 0);
            assert!(!rig.acknowledged());
        }
    }
}

#[test]
fn m20_a_mode_change_works_in_fault() {
    let mut rig = Rig::enabled();
    rig.fault = Some(0x4210);
    rig.ticks(3);
    rig.commands.mode = 0;
    rig.post();
    assert_eq!(rig.tick().mode_display, 0);
    assert_eq!(rig.state(), State::Fault);
}

#[test]
fn m23_a_mode_begins_with_its_bits_at_rest() {
    let mut rig = Rig::enabled();
    rig.configuration.position_limits = (-10, 10);
    rig.set_point(50, 0);
    rig.rest();
    assert!(rig.acknowledged() && rig.limited());
    rig.commands.mode = 0;
    rig.post();
    rig.tick();
    assert_eq!(
        (
            rig.actuals().mode_display,
            rig.actuals().statusword & 0x3C00
        ),
        (0, 0)
    );
    rig.commands.mode = 1;
    rig.post();
    rig.tick();
    assert_eq!(rig.actuals().mode_display, 1);
    assert!(!rig.acknowledged() && !rig.limited());
}

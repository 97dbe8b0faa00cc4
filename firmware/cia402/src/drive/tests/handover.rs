//! From one mode to another, and what a mode tells while it is not at work.

use motion::SignedSpeed;

use crate::state_machine::State;
use crate::statusword;
use crate::testing::Rig;

const CSV: i8 = 9;
const HOMING: i8 = 6;

fn change_to(rig: &mut Rig, mode: i8) {
    rig.commands.mode = mode;
    rig.post();
    rig.tick();
    assert_eq!(rig.actuals().mode_display, mode);
}

/// A drive on its way through 10,000 to a software limit at 20,000; no set-point of the cyclic modes ever comes.
fn on_the_way(mode: i8, end_velocity: u32) -> Rig {
    let mut rig = Rig::enabled();
    rig.configuration.position_limits = (-20_000, 20_000);
    rig.commands.end_velocity = end_velocity.into();
    if mode == 1 {
        rig.set_point(10_000, 0);
    } else {
        rig.commands.mode = mode;
        rig.commands.target_velocity = SignedSpeed::per_second(10_000);
        rig.write(0x0F);
    }
    rig.ticks(400);
    rig
}

#[test]
fn m19_cyclic_velocity_out_of_a_motion_without_end_stops_at_the_software_limit() {
    // Before the target with an end velocity, behind it, and out of profile velocity.
    for (mode, end_velocity, later) in [(1, 5_000, 0), (1, 5_000, 1_000), (3, 0, 0)] {
        let mut rig = on_the_way(mode, end_velocity);
        rig.ticks(later);
        change_to(&mut rig, CSV);
        assert!(rig.speed() > 4, "it goes on");
        rig.ticks(200);
        assert!(rig.speed() > 4, "it goes on");
        assert_eq!(rig.rest(), 20_000, "{mode} {end_velocity} {later}");
        assert!(rig.limited() && !rig.has(statusword::FOLLOWS));
        assert_eq!(rig.state(), State::OperationEnabled);
        rig.configuration.position_limits = (0, 0);
        rig.post();
        assert_eq!(rig.rest(), 20_000, "it does not go on by itself");
    }
}

#[test]
fn m19_a_blended_move_that_cyclic_velocity_takes_over_stops_at_the_software_limit() {
    let mut rig = on_the_way(1, 0);
    rig.set_point(15_000, 1 << 9);
    rig.ticks(10);
    change_to(&mut rig, CSV);
    assert_eq!(rig.rest(), 20_000);
    assert!(rig.limited());
}

#[test]
fn m44_a_software_limit_written_before_the_first_set_point_of_cyclic_velocity_counts() {
    for (mode, end_velocity) in [(1, 5_000), (1, 0), (3, 0)] {
        let mut rig = on_the_way(mode, end_velocity);
        change_to(&mut rig, CSV);
        rig.ticks(50);
        rig.configuration.position_limits = (-20_000, 8_000);
        rig.post();
        assert_eq!(rig.rest(), 8_000, "{mode} {end_velocity}");
        assert!(rig.limited());
    }
}

#[test]
fn m19_a_move_within_the_limits_ends_where_it_was_to_end() {
    let mut rig = on_the_way(1, 0);
    change_to(&mut rig, CSV);
    assert_eq!(rig.rest(), 10_000);
    assert!(!rig.limited());
    // Halted, and a stop that is under way: neither goes on.
    let mut rig = on_the_way(3, 0);
    rig.write(0x10F);
    rig.ticks(10);
    change_to(&mut rig, CSV);
    rig.write(0x0F);
    assert!(rig.rest() < 8_000);
}

#[test]
fn m53_whether_home_is_known_shows_in_every_state() {
    let mut rig = Rig::enabled();
    rig.configuration.homing.method = 35;
    change_to(&mut rig, HOMING);
    rig.write(0x1F);
    rig.ticks(3);
    assert!(rig.actuals().referenced);
    let bits = statusword::HOMING_ATTAINED | statusword::TARGET_REACHED | statusword::HOMING_ERROR;
    for (controlword, state) in [
        (0x07, State::SwitchedOn),
        (0x06, State::ReadyToSwitchOn),
        (0x00, State::SwitchOnDisabled),
    ] {
        rig.write(controlword);
        rig.ticks(3);
        assert_eq!(rig.state(), state);
        let shown = rig.actuals().statusword & bits;
        assert_eq!(shown, statusword::HOMING_ATTAINED, "{state:?}");
        // The bit means something else in another mode.
        change_to(&mut rig, 1);
        assert_eq!(rig.actuals().statusword & bits, 0);
        change_to(&mut rig, HOMING);
        assert_eq!(rig.actuals().statusword & bits, shown);
    }
    rig.configuration.homing.options |= 1 << 7;
    rig.post();
    rig.tick();
    assert_eq!(rig.actuals().statusword & bits, 0, "2030h:1 bit 7");
    // A drive that has lost its home position.
    let mut rig = Rig::new();
    rig.commands.mode = HOMING;
    rig.write(0x06);
    rig.ticks(5);
    assert_eq!(rig.actuals().statusword & bits, 0);
}

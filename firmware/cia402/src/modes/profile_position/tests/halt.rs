//! Controlword bit 8.

use super::{HALT, IMMEDIATELY};
use crate::state_machine::State;
use crate::testing::Rig;

#[test]
fn m35_halt_stops_and_goes_on_to_the_same_target() {
    let mut rig = Rig::enabled();
    rig.set_point(10_000, 0);
    rig.ticks(200);
    let begin = rig.motor.position;
    rig.write(0x1F | HALT);
    rig.tick();
    assert!(!rig.reached());
    let stopped = rig.rest();
    assert!(
        (500..540).contains(&(stopped - begin)),
        "on 6084h: {}",
        stopped - begin
    );
    assert!(rig.reached(), "halted");
    assert_eq!(rig.state(), State::OperationEnabled);
    rig.write(0x1F);
    rig.tick();
    assert!(!rig.reached());
    assert_eq!(rig.rest(), 10_000);
}

#[test]
fn m35_a_set_point_during_halt_waits_for_its_end() {
    for bits in [0, IMMEDIATELY] {
        let mut rig = Rig::enabled();
        rig.write(0x0F | HALT);
        rig.tick();
        rig.set_point(700, HALT | bits);
        rig.tick();
        assert!(rig.acknowledged() && !rig.reached());
        rig.ticks(50);
        assert!(rig.reached(), "halted");
        assert_eq!(rig.motor.position, 0);
        rig.write(0x0F);
        assert_eq!(rig.rest(), 700);
    }
}

#[test]
fn m35_a_set_point_that_waits_given_with_the_end_of_a_halt() {
    let mut rig = Rig::enabled();
    rig.set_point(3_000, 0);
    rig.ticks(100);
    rig.write(0x0F | HALT);
    rig.rest();
    rig.commands.target_position = 5_000;
    rig.write(0x1F);
    rig.tick();
    assert!(rig.acknowledged());
    rig.write(0x0F);
    rig.until("the first target", |rig| rig.motor.position == 3_000);
    assert_eq!(rig.speed(), 0, "it stands there");
    rig.until("the second target", |rig| rig.motor.position == 5_000);
}

#[test]
fn halt_and_its_end_on_the_way_are_smooth() {
    let mut rig = Rig::enabled();
    rig.set_point(5_000, 0);
    rig.ticks(150);
    let mut speed = rig.speed();
    rig.write(0x1F | HALT);
    for count in 0..400 {
        if count == 30 {
            rig.write(0x1F);
        }
        let next = rig.speed();
        // A count of steps is one too many or too few at either end of a tick.
        assert!(
            (next - speed).abs() <= 2,
            "from {speed} to {next} steps a tick"
        );
        speed = next;
    }
    assert_eq!(rig.rest(), 5_000);
}

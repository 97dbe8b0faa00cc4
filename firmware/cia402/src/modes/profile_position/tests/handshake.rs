//! Controlword bit 4 and statusword bit 12: which set-points are taken, and when they begin.

use super::{IMMEDIATELY, RELATIVE};
use crate::option_codes::Stop;
use crate::state_machine::State;
use crate::testing::Rig;

#[test]
fn m24_the_acknowledge_shows_for_an_edge_between_two_ticks() {
    let mut rig = Rig::enabled();
    rig.set_point(1_000, 0);
    rig.write(0x0F);
    rig.tick();
    assert!(rig.acknowledged());
    rig.tick();
    assert!(!rig.acknowledged());
    assert_eq!(rig.rest(), 1_000);
}

#[test]
fn m26_bit_4_in_the_enabling_controlword_is_no_set_point() {
    let mut rig = Rig::new();
    rig.commands.target_position = 5_000;
    rig.ticks(2);
    for controlword in [0x06, 0x07, 0x1F] {
        rig.write(controlword);
        rig.tick();
    }
    rig.ticks(50);
    assert_eq!(rig.state(), State::OperationEnabled);
    assert_eq!(rig.motor.position, 0);
    assert!(!rig.acknowledged());
    rig.set_point(70, 0);
    assert_eq!(rig.rest(), 70);
}

#[test]
fn m28_a_refused_set_point_changes_neither_of_the_others() {
    let mut rig = Rig::enabled();
    for target in [2_000, 3_000, 9_000] {
        rig.set_point(target, 0);
        rig.tick();
    }
    rig.commands.profile_velocity = 1.into();
    rig.post();
    let mut highest = 0;
    rig.until("second set-point done", |rig| {
        rig.reached() && rig.motor.position == 3_000
    });
    for _ in 0..100 {
        rig.tick();
        highest = highest.max(rig.motor.position);
    }
    assert_eq!(highest, 3_000);
}

#[test]
fn d19_change_immediately_turns_to_the_new_target_smoothly() {
    let mut rig = Rig::enabled();
    rig.set_point(100_000, IMMEDIATELY);
    rig.ticks(200);
    rig.set_point(0, IMMEDIATELY);
    let mut positions = std::vec![rig.motor.position];
    for _ in 0..210 {
        rig.tick();
        positions.push(rig.motor.position);
    }
    // In a tick the speed falls by a tenth of a step per tick. The motor is within half a step of
    // the motion, so a change between two distances shows that to less than 2 steps: 4 steps in
    // one tick and 6 in the next are even pulses. Over many ticks that leaves no room.
    for (ticks, fall) in [(1, 1), (3, 1), (10, 10), (30, 90)] {
        for three in positions.windows(2 * ticks + 1) {
            let (first, next) = (three[ticks] - three[0], three[2 * ticks] - three[ticks]);
            assert!(
                (-fall - 1..=1).contains(&(next - first)),
                "from {first} to {next} steps in {ticks} ticks"
            );
        }
    }
    let speed = rig.speed();
    assert_eq!(speed, -10);
    assert_eq!(rig.rest(), 0);
}

#[test]
fn change_immediately_drops_the_set_point_that_waits() {
    let mut rig = Rig::enabled();
    rig.set_point(2_000, 0);
    rig.tick();
    rig.set_point(5_000, 0);
    rig.tick();
    rig.set_point(1_500, IMMEDIATELY);
    rig.tick();
    rig.write(0x0F);
    rig.tick();
    assert!(!rig.acknowledged());
    assert_eq!(rig.rest(), 1_500);
}

#[test]
fn m29_of_two_immediate_set_points_in_one_tick_the_last_wins() {
    let mut rig = Rig::enabled();
    rig.set_point(2_000, IMMEDIATELY);
    rig.set_point(-300, IMMEDIATELY);
    rig.tick();
    assert!(rig.acknowledged());
    assert_eq!(rig.rest(), -300);
}

#[test]
fn m27_what_is_written_after_the_edge_is_for_the_next_set_point() {
    let mut rig = Rig::enabled();
    rig.set_point(400, 0);
    rig.commands.target_position = 900;
    rig.commands.profile_velocity = 0.into();
    rig.write(0x0F | RELATIVE);
    assert_eq!(rig.rest(), 400);
}

#[test]
fn what_is_written_behind_the_edge_counts_for_all_but_the_set_point() {
    let mut rig = Rig::enabled();
    rig.configuration.fault_reaction = Stop::on_fault(1).unwrap();
    rig.set_point(100_000, 0);
    rig.commands.profile_velocity = 1_000.into();
    rig.commands.target_position = 5;
    rig.commands.profile_deceleration = 1_000_000;
    rig.write(0x0F | RELATIVE);
    rig.ticks(200);
    assert_eq!(rig.speed(), 10, "its 6081h");
    assert_eq!(rig.actuals().position_demand / 1_000, 1, "its target");
    let begin = rig.motor.position;
    rig.fault = Some(0x4210);
    let stopped = rig.rest() - begin;
    assert!((50..90).contains(&stopped), "the newest 6084h: {stopped}");
}

//! Profiles that count from the next set-point, and those that cannot be carried out.

use super::IMMEDIATELY;
use crate::testing::Rig;

#[test]
fn a_velocity_the_pulses_cannot_reach_is_cut() {
    let mut rig = Rig::enabled();
    rig.commands.profile_velocity = 1_000_000.into();
    rig.set_point(500, 0);
    rig.tick();
    assert!(rig.limited());
    assert_eq!(rig.rest(), 500);
    rig.ticks(20);
    assert!(rig.reached());
}

#[test]
fn m37_the_velocity_counts_from_the_next_set_point() {
    let mut rig = Rig::enabled();
    rig.set_point(5_000, 0);
    rig.ticks(200);
    rig.commands.profile_velocity = 2_000.into();
    rig.post();
    rig.ticks(50);
    assert_eq!(rig.speed(), 10);
    rig.set_point(6_000, IMMEDIATELY);
    rig.ticks(120);
    assert_eq!(rig.speed(), 2);
    assert_eq!(rig.rest(), 6_000);
}

#[test]
fn m37_velocity_0_does_not_move() {
    let mut rig = Rig::enabled();
    rig.ticks(20);
    let profile_velocity = rig.commands.profile_velocity;
    rig.commands.profile_velocity = 0.into();
    rig.set_point(1_000, 0);
    rig.tick();
    assert!(rig.acknowledged());
    rig.write(0x0F);
    rig.ticks(100);
    assert_eq!(rig.motor.position, 0);
    assert!(!rig.reached() && !rig.acknowledged() && rig.limited());
    // The next one is not kept waiting.
    rig.commands.profile_velocity = profile_velocity;
    rig.set_point(800, 0);
    assert_eq!(rig.rest(), 800);
    assert!(!rig.limited());
}

#[test]
fn m37_velocity_0_on_the_way_stops() {
    let mut rig = Rig::enabled();
    rig.set_point(100_000, 0);
    rig.ticks(200);
    let begin = rig.motor.position;
    rig.commands.profile_velocity = 0.into();
    rig.set_point(200_000, IMMEDIATELY);
    let stopped = rig.rest() - begin;
    assert!((500..540).contains(&stopped), "{stopped}");
    rig.ticks(50);
    assert!(!rig.reached());
}

#[test]
fn an_impossible_set_point_that_waited_lets_the_next_one_through() {
    let mut rig = Rig::enabled();
    rig.set_point(500, 0);
    rig.tick();
    rig.commands.profile_acceleration = 0;
    rig.set_point(1_000, 0);
    assert_eq!(rig.rest(), 500);
    assert!(!rig.reached());
    rig.commands.profile_acceleration = 100_000;
    rig.set_point(1_200, 0);
    assert_eq!(rig.rest(), 1_200);
}

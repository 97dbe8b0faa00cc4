//! Stops that would end beyond a software limit.

use crate::mode::Mode;
use crate::option_codes::{AbortConnectionOption, Stop, StopRamp};
use crate::testing::{Rig, quick_stop};

const LIMIT: i64 = 20_000;

/// A drive at 30,000 steps/s, 1500 steps before its limit: 450 steps to rest on 6085h, 4,500 on 6084h as it is now. Its set-point still
/// has the 6084h of before.
fn before_the_limit() -> Rig {
    let mut rig = Rig::new();
    rig.configuration.position_limits = (-20_000, 20_000);
    rig.configuration.quick_stop = quick_stop(1);
    rig.configuration.shutdown = Stop::on_leaving(1).unwrap();
    rig.configuration.disable_operation = Stop::on_leaving(1).unwrap();
    rig.configuration.halt = StopRamp::SlowDown;
    rig.configuration.fault_reaction = Stop::on_fault(1).unwrap();
    rig.configuration.abort_connection = AbortConnectionOption::FaultSignal;
    rig.commands.profile_velocity = 30_000.into();
    rig.commands.profile_deceleration = 1_000_000;
    rig.enable();
    rig.set_point(20_000, 0);
    rig.until("near the limit", |rig| rig.motor.position > LIMIT - 1_500);
    assert_eq!(rig.speed(), 30);
    rig.commands.profile_deceleration = 100_000;
    rig
}

#[test]
fn m44_no_stop_ends_beyond_a_software_limit() {
    type Stops = fn(&mut Rig);
    let ways: [(&str, Stops); 8] = [
        ("605Dh = 1", |rig| rig.write(0x10F)),
        ("605Ch = 1", |rig| rig.write(0x07)),
        ("605Bh = 1", |rig| rig.write(0x06)),
        ("605Ah = 1", |rig| rig.write(0x02)),
        ("605Ah = 5", |rig| {
            rig.configuration.quick_stop = quick_stop(5);
            rig.write(0x02);
        }),
        ("605Eh = 1", |rig| {
            rig.fault = Some(0x4210);
            rig.post();
        }),
        ("6007h = 1", |rig| {
            rig.commands.remote = false;
            rig.commands.connection_error = Some(0x8130);
            rig.post();
        }),
        ("another mode", |rig| {
            rig.commands.mode = Mode::CyclicPosition.code();
            rig.post();
        }),
    ];
    for (what, stops) in ways {
        let mut rig = before_the_limit();
        assert!(!rig.limited(), "{what}");
        stops(&mut rig);
        rig.ticks(3);
        assert!(rig.limited(), "{what}: bit 11 while the ramp is another");
        let rest = rig.rest();
        assert!(rest <= LIMIT, "{what}: {} steps beyond", rest - LIMIT);
        assert!(!rig.limited(), "{what}: it stands");
    }
}

#[test]
fn m44_a_stop_that_ends_within_the_software_limits_keeps_its_ramp() {
    let mut rig = before_the_limit();
    rig.commands.profile_deceleration = 500_000;
    rig.write(0x10F);
    let begin = rig.motor.position;
    rig.ticks(3);
    assert!(!rig.limited());
    let distance = rig.rest() - begin;
    assert!((900..1_000).contains(&distance), "{distance} steps");
}

#[test]
fn m44_a_stop_that_is_replaced_by_a_gentler_one_stays_within_the_software_limit() {
    let mut rig = before_the_limit();
    rig.write(0x10F);
    rig.ticks(5);
    rig.write(0x07);
    let rest = rig.rest();
    assert!(rest <= LIMIT, "{} steps beyond", rest - LIMIT);
}

#[test]
fn m44_a_stop_on_the_way_back_from_beyond_a_limit_keeps_its_ramp() {
    let mut rig = before_the_limit();
    rig.rest();
    // The limits are drawn in behind the motor.
    rig.configuration.position_limits = (-20_000, 100);
    rig.set_point(0, 0);
    rig.ticks(400);
    assert_eq!(rig.speed(), -30);
    rig.write(0x10F);
    let begin = rig.motor.position;
    rig.ticks(3);
    let distance = begin - rig.rest();
    assert!((4_500..4_600).contains(&distance), "{distance} steps");
}

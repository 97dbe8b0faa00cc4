use crate::Mode;
use crate::configuration::VelocityConfiguration;
use crate::testing::Rig;

/// Bits 4 to 6 of normal operation.
const RUN: u16 = 0x7F;

/// A drive in the velocity mode. 100 ticks to 10,000 steps/s, 200 back, 20 by quick stop.
fn enabled() -> Rig {
    let mut rig = Rig::enabled();
    rig.commands.mode = Mode::Velocity.code();
    rig.configuration.velocity = VelocityConfiguration {
        acceleration: 100_000,
        deceleration: 50_000,
        quick_stop: 500_000,
        ..VelocityConfiguration::NONE
    };
    rig.write(RUN);
    rig.tick();
    assert_eq!(rig.actuals().mode_display, 2);
    rig
}

fn run(rig: &mut Rig, velocity: i16) {
    rig.commands.vl_target_velocity = velocity;
    rig.post();
}

fn ticks_to(rig: &mut Rig, velocity: i32) -> usize {
    rig.until("velocity", |rig| rig.actuals().velocity_demand == velocity)
}

#[test]
fn m46_each_ramp_has_its_object() {
    let mut rig = enabled();
    run(&mut rig, 10_000);
    let speeding = ticks_to(&mut rig, 10_000);
    assert!((98..=104).contains(&speeding), "{speeding}");
    assert!(rig.reached());
    run(&mut rig, 0);
    let slowing = ticks_to(&mut rig, 0);
    assert!((198..=204).contains(&slowing), "{slowing}");
    run(&mut rig, -10_000);
    ticks_to(&mut rig, -10_000);
    rig.write(0x02);
    let stopping = ticks_to(&mut rig, 0);
    assert!((18..=24).contains(&stopping), "{stopping}");
}

#[test]
fn m46_bit_4_stops_on_the_quick_stop_ramp() {
    let mut rig = enabled();
    run(&mut rig, 10_000);
    rig.ticks(200);
    rig.write(RUN & !0x10);
    let stopping = ticks_to(&mut rig, 0);
    assert!((18..=24).contains(&stopping), "{stopping}");
    rig.rest();
    assert!(rig.reached());
    rig.write(RUN);
    rig.ticks(150);
    assert_eq!(rig.speed(), 10);
}

#[test]
fn m46_bit_5_holds_the_velocity_where_it_is() {
    let mut rig = enabled();
    run(&mut rig, 10_000);
    rig.ticks(50);
    rig.write(RUN & !0x20);
    rig.ticks(5);
    let held = rig.actuals().velocity_demand;
    assert!((4_000..6_000).contains(&held), "{held}");
    run(&mut rig, -3_000);
    rig.ticks(100);
    assert_eq!(rig.actuals().velocity_demand, held);
    assert!(!rig.reached());
    rig.write(RUN);
    rig.ticks(300);
    assert_eq!(rig.speed(), -3);
}

#[test]
fn m46_bit_6_takes_0_for_the_reference() {
    let mut rig = enabled();
    run(&mut rig, 10_000);
    rig.ticks(200);
    rig.write(RUN & !0x40);
    let slowing = ticks_to(&mut rig, 0);
    assert!((198..=204).contains(&slowing), "{slowing}");
}

#[test]
fn m46_halt_stops_on_the_ramp_of_605dh() {
    for (code, expected) in [(1, 200), (2, 20)] {
        let mut rig = enabled();
        rig.configuration.halt = crate::option_codes::StopRamp::on_halt(code).unwrap();
        run(&mut rig, 10_000);
        rig.ticks(200);
        rig.write(RUN | 0x100);
        let stopping = ticks_to(&mut rig, 0);
        assert!((expected - 2..=expected + 4).contains(&stopping));
        rig.write(RUN);
        rig.ticks(200);
        assert_eq!(rig.speed(), 10);
    }
}

#[test]
fn m46_the_amount_is_between_6046h_1_and_2_and_0_stays_0() {
    let mut rig = enabled();
    rig.configuration.velocity.min_amount = 1_000;
    rig.configuration.velocity.max_amount = 8_000;
    for (asked, expected, is_limited) in [
        (500, 1_000, true),
        (-1, -1_000, true),
        (5_000, 5_000, false),
        (-9_000, -8_000, true),
        (0, 0, false),
    ] {
        run(&mut rig, asked);
        ticks_to(&mut rig, expected);
        rig.ticks(300);
        assert_eq!(rig.actuals().velocity_demand, expected, "{asked}");
        assert_eq!(rig.limited(), is_limited, "{asked}");
        assert!(rig.reached());
    }
}

#[test]
fn m46_the_dimension_factor_scales_what_is_asked_and_shown() {
    let mut rig = enabled();
    rig.configuration.velocity.dimension = (5, 2);
    run(&mut rig, -400);
    rig.ticks(200);
    let actuals = rig.actuals();
    assert_eq!(actuals.velocity_demand, -1_000);
    assert_eq!(
        (actuals.vl_velocity_demand, actuals.vl_velocity_actual),
        (-400, -400)
    );
    assert_eq!(rig.speed(), -1);
}

#[test]
fn m44_the_software_limit_holds_here_too() {
    let mut rig = enabled();
    rig.configuration.position_limits = (-300, 5_000);
    run(&mut rig, 10_000);
    assert_eq!(rig.rest(), 5_000);
    assert!(rig.limited());
    run(&mut rig, -10_000);
    assert_eq!(rig.rest(), -300);
}

#[test]
fn the_last_controlword_between_two_ticks_counts() {
    let mut rig = enabled();
    rig.write(0x0F);
    rig.tick();
    run(&mut rig, 10_000);
    rig.write(0x1F);
    rig.write(RUN);
    ticks_to(&mut rig, 10_000);
    rig.write(0x0F);
    rig.rest();
    rig.write(RUN);
    rig.write(0x1F);
    rig.ticks(50);
    assert_eq!(rig.speed(), 0, "bits 5 and 6 are 0");
}

#[test]
fn m39_the_greatest_ramps_hold_here_too() {
    let mut rig = enabled();
    rig.configuration.max_acceleration = 50_000;
    rig.configuration.max_deceleration = 25_000;
    run(&mut rig, 10_000);
    let speeding = ticks_to(&mut rig, 10_000);
    assert!((198..=204).contains(&speeding), "60C5h: {speeding}");
    assert!(rig.limited());
    run(&mut rig, 0);
    let slowing = ticks_to(&mut rig, 0);
    assert!((398..=404).contains(&slowing), "60C6h: {slowing}");
    run(&mut rig, 10_000);
    ticks_to(&mut rig, 10_000);
    rig.write(RUN & !0x10);
    let stopping = ticks_to(&mut rig, 0);
    assert!((398..=404).contains(&stopping), "60C6h: {stopping}");
}

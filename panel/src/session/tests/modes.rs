//! What the drive does in its modes: velocities, homing.

use super::*;
use crate::homing::Switch;

#[test]
fn a_velocity_is_given_in_its_mode_and_a_stop_ends_it() {
    let mut bench = Bench::enabled();
    let why = bench.refused(Order::SetPoint { value: 500 });
    assert_eq!(
        why,
        "the mode at work has no set-point of velocity or torque"
    );
    for (mode, name) in [
        (3, "Target velocity (60FFh)"),
        (2, "Target velocity (6042h)"),
    ] {
        bench.done(Order::Mode { mode });
        bench.done(Order::SetPoint { value: 500 });
        bench.run_for(2_000);
        assert_eq!(
            bench.drive().set_point.as_ref().map(|of| of.name),
            Some(name)
        );
        assert_eq!(bench.drive().velocity, Some(500), "mode {mode}");
        bench.done(Order::SetPoint { value: 0 });
        bench.run_for(2_000);
        assert_eq!(bench.drive().velocity, Some(0));
    }
    let why = bench.refused(Order::SetPoint { value: 70_000 });
    assert_eq!(why, "70000 does not fit into 16 bits");
    bench.done(Order::SetPoint { value: -500 });
    bench.run_for(1_000);
    bench.desk.stop();
    bench.run_for(1_000);
    assert_eq!(bench.drive().state, Some(DriveState::SwitchOnDisabled));
    assert_eq!(bench.drive().velocity, Some(0));
}

#[test]
fn homing_is_set_up_as_it_is_drawn() {
    let mut bench = Bench::chosen();
    bench.done(Order::SetHoming {
        method: 24,
        fast: 2_000,
        slow: 200,
        acceleration: 50_000,
    });
    bench.run_for(100);
    let homing = bench.drive().homing.clone().unwrap();
    assert_eq!(
        (homing.method, homing.fast, homing.slow, homing.acceleration),
        (24, 2_000, 200, 50_000)
    );
    let method = homing
        .methods
        .iter()
        .find(|method| method.number == 24)
        .unwrap();
    assert_eq!(
        (
            method.switch,
            method.start,
            method.edge,
            method.side,
            method.index
        ),
        (Switch::HomeMiddle, 1, -1, 1, false)
    );
    assert_eq!(bench.done(read("6098")), "24");
    bench.done(Order::Enable);
    bench.done(go(1_000, None));
    bench.run_for(2_000);
    bench.done(Order::SetHoming {
        method: 37,
        fast: 2_000,
        slow: 200,
        acceleration: 50_000,
    });
    let told = |bench: &Bench| {
        let mut values = bench.drive().values.iter();
        let found = values.find(|(name, _)| *name == "Homing");
        found.map(|(_, text)| text.clone())
    };
    assert_eq!(told(&bench), None);
    bench.done(Order::Home);
    bench.run_for(1_000);
    assert_eq!(bench.drive().position, Some(0));
    assert_eq!(told(&bench).as_deref(), Some("done"));
    let words = bench.drive().statusword.clone().unwrap().words;
    assert_eq!(words, "operation enabled, target reached, homing attained");
}

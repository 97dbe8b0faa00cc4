//! One direction only (60F2h bits 7 and 6) on a rotary axis whose motor moves already.

use crate::profile::all_ramps;
use motion::Ramps;

use super::IMMEDIATELY;
use crate::testing::Rig;
use crate::units::{Factors, Units};

/// An axis of 36,000 steps a turn whose ramps are capped by 60C6h.
fn table(ramps: Ramps, option: u16) -> Rig {
    let mut rig = Rig::new();
    rig.configuration.units = Units::new(Factors {
        position_encoder: Some((1, 1)),
        velocity_encoder: (0, 1),
        gear: (1, 1),
        feed: (1, 1),
        velocity: (1, 1),
        acceleration: (1, 1),
        polarity: 0,
        range: (0, 35_999),
    })
    .unwrap();
    rig.configuration.profile.ramps = ramps;
    rig.configuration.max_deceleration = 20_000;
    rig.commands.positioning_option = option;
    rig.enable();
    rig
}

#[test]
fn m59_one_direction_holds_whatever_the_motor_does() {
    for ramps in all_ramps(1_000_000) {
        for (option, sign) in [(0x80, 1), (0x40, -1)] {
            // While it speeds up, and at 10,000 steps/s.
            for ticks in [20, 60, 90, 150, 400] {
                for ahead in [1, 30, 400, 1_000, 2_600] {
                    let mut rig = table(ramps, option);
                    let at = |rig: &Rig, distance: i64| {
                        i32::try_from((rig.motor.position + distance).rem_euclid(36_000)).unwrap()
                    };
                    let far = at(&rig, 30_000 * sign);
                    rig.set_point(far, 0);
                    rig.ticks(ticks);
                    let target = at(&rig, ahead * sign);
                    rig.set_point(target, IMMEDIATELY);
                    let mut last = rig.motor.position;
                    for _ in 0..8_000 {
                        rig.tick();
                        let distance = (rig.motor.position - last) * sign;
                        assert!(
                            distance >= 0,
                            "{ramps:?} {option:X}h: {distance} steps, {ahead} ahead after {ticks} ms"
                        );
                        last = rig.motor.position;
                    }
                    assert_eq!(last.rem_euclid(36_000), i64::from(target));
                    assert!(rig.reached());
                }
            }
        }
    }
}

//! The magnet found by moving it a little, from anywhere, and what that costs in motion.

mod rig;

use std::f64::consts::TAU;

use rig::{PERIOD, Rig, motor, turned};
use servo::current_loop::{CurrentConfig, Sample};
use servo::feedback::Commutation;
use servo::feedback::commutation::Step;
use servo::transform::Rotor;
use servo::{Angle, Motor};
use servo_plant::Plant;
use servo_plant::axes::{NEMA17, NEMA23, SERVO_100W, SERVO_400W};
use servo_plant::data::PlantData;

/// Lets it search; gives the step at the end, the true angle then, and the greatest motion, both in electrical turns.
fn search(rig: &mut Rig, current: f32) -> (Step, f64, f64) {
    let mut commutation = Commutation::new(&rig.motor, current, PERIOD).unwrap();
    let start = rig.plant.electrical_angle();
    let mut farthest = 0.0_f64;
    for _ in 0..100_000 {
        let sample = rig.sense();
        match commutation.run(rig.encoder.position(), rig.observer.speed()) {
            Step::Hold { angle, current } => {
                // The frame is where the field is, whatever the encoder says.
                let sample = Sample {
                    angle,
                    turn: Angle::ZERO,
                    ..sample
                };
                rig.act(&sample, Rotor { d: current, q: 0.0 });
                let away = (rig.plant.electrical_angle() - start).abs() / TAU;
                farthest = farthest.max(away);
            }
            end => return (end, rig.plant.electrical_angle() / TAU, farthest),
        }
    }
    panic!("it does not end");
}

fn rig(data: &PlantData, known: Motor, angle: f64) -> Rig {
    let config = CurrentConfig::quick(&known, PERIOD, 3.0 * known.peak_current, (10.0, 60.0));
    Rig::new(Plant::new(*data, 1).turning(angle, 0.0), known, config)
}

#[test]
fn the_magnet_is_found_from_anywhere_with_little_motion() {
    for (name, data, rated, peak, bound) in [
        ("nema17", NEMA17, 1.7, 2.4, 0.05),
        ("nema23", NEMA23, 4.2, 6.0, 0.05),
        ("servo_100w", SERVO_100W, 4.0, 12.0, 0.02),
        ("servo_400w", SERVO_400W, 17.0, 40.0, 0.02),
    ] {
        let known = motor(&data, rated, peak);
        let (mut worst, mut farthest) = (0.0_f64, 0.0_f64);
        for start in 0..6 {
            let turns = (f64::from(start) + 0.02) / 6.0;
            let mut rig = rig(&data, known, turns * TAU / f64::from(known.pole_pairs));
            let (end, truly, moved) = search(&mut rig, rated);
            let Step::Found(angle) = end else {
                panic!("{name} from {turns}: {end:?}")
            };
            let away = f64::from(angle.minus(turned(truly * TAU)).turns().abs());
            worst = worst.max(away);
            farthest = farthest.max(moved);
            assert!(away < bound, "{name} from {turns}: {away} turns off");
        }
        println!(
            "{name}: at most {:.1}° off, {:.0}° moved, electrical",
            worst * 360.0,
            farthest * 360.0
        );
        assert!(farthest < 0.65, "{name}: {farthest} turns");
    }
}

#[test]
fn what_does_not_follow_is_not_found() {
    let known = motor(&SERVO_100W, 4.0, 12.0);
    let mut held = SERVO_100W;
    held.load.coulomb_friction = 5.0;
    let (end, _, _) = search(&mut rig(&held, known, 0.2), 4.0);
    assert_eq!(end, Step::Failed, "a rotor that is held");
    let mut cut = rig(&SERVO_100W, known, 0.2);
    cut.plant.sensor_faults.encoder_is_cut = true;
    let (end, _, _) = search(&mut cut, 4.0);
    assert_eq!(end, Step::Failed, "an encoder that is cut");
}

/// Where the encoder counts the other way the field flees from the rotor, or goes with it round and round.
#[test]
fn an_encoder_that_counts_the_other_way_is_not_taken_for_right() {
    let known = motor(&SERVO_100W, 4.0, 12.0);
    for start in 0..3 {
        let mut rig = rig(&SERVO_100W, known, f64::from(start) * 0.5);
        let mut commutation = Commutation::new(&known, 4.0, PERIOD).unwrap();
        let mut end = None;
        for _ in 0..100_000 {
            let sample = rig.sense();
            match commutation.run(-rig.encoder.position(), -rig.observer.speed()) {
                Step::Hold { angle, current } => {
                    let sample = Sample {
                        angle,
                        turn: Angle::ZERO,
                        ..sample
                    };
                    rig.act(&sample, Rotor { d: current, q: 0.0 });
                }
                step => {
                    end = Some(step);
                    break;
                }
            }
        }
        assert_eq!(end, Some(Step::Failed));
    }
}

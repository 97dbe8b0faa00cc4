//! What the sensors of the plant see.

use std::f64::consts::TAU;

use proptest::prelude::*;
use servo_plant::axes::{NEMA17, SERVO_100W};
use servo_plant::data::SensorData;
use servo_plant::{Gates, Plant};

#[test]
fn the_same_seed_gives_the_same_numbers() {
    let mut data = SERVO_100W;
    data.sensors.current_noise = 0.05;
    data.sensors.count_noise = 0.7;
    let run = |seed| {
        let mut plant = Plant::new(data, seed);
        plant.gates = Gates::On([0.6, 0.5, 0.45]);
        (0..1_000)
            .map(|_| {
                plant.step();
                plant.measure()
            })
            .collect::<Vec<_>>()
    };
    assert_eq!(run(7), run(7));
    assert_ne!(run(7), run(8));
}

#[test]
fn the_index_is_where_it_is_from_both_sides() {
    let mut data = SERVO_100W;
    data.sensors.index = 1.0;
    let at = (1.0 / TAU * 10_000.0_f64).floor() as i64;
    for (from, velocity, count) in [
        (0.9, 10.0, at),
        (1.1, -10.0, at),
        (1.0 - TAU, -30.0, at - 10_000),
    ] {
        let mut plant = Plant::new(data, 1).turning(from, velocity);
        let mut seen = Vec::new();
        for _ in 0..4_000 {
            plant.step();
            seen.extend(plant.measure().index);
        }
        assert_eq!(seen, [count], "from {from}");
    }
}

#[test]
fn a_cut_encoder_stands_and_lost_counts_stay_lost() {
    let mut plant = Plant::new(SERVO_100W, 1).turning(0.0, 50.0);
    plant.run(1_000);
    plant.sensor_faults.lost_counts = 5;
    let true_count = (plant.angle() / TAU * 10_000.0).floor() as i64;
    assert_eq!(plant.measure().count, true_count - 5);
    plant.sensor_faults.encoder_is_cut = true;
    let before = plant.measure();
    plant.run(1_000);
    let after = plant.measure();
    assert_eq!((after.count, after.word), (before.count, before.word));
}

#[test]
fn a_current_is_measured_late_with_its_offset_in_whole_counts() {
    let mut data = NEMA17;
    data.sensors.current_delay = 3;
    data.sensors.current_offset = [0.25, -0.5, 0.0];
    data.sensors.current_count = 0.01;
    data.sensors.current_range = 0.6;
    let mut plant = Plant::new(data, 1);
    plant.gates = Gates::On([1.0, -1.0, 0.0]);
    let mut past = Vec::new();
    for _ in 0..30 {
        plant.step();
        past.push(plant.phase_currents());
        let seen = plant.measure().currents;
        let then = past.len().checked_sub(4).map_or([0.0; 3], |at| past[at]);
        for phase in 0..3 {
            let wanted = then[phase] + data.sensors.current_offset[phase];
            let wanted = wanted.clamp(-0.6, 0.6);
            assert!((seen[phase] - wanted).abs() <= 0.005 + 1e-9, "{seen:?}");
            let counts = seen[phase] / 0.01;
            assert!((counts - counts.round()).abs() < 1e-6);
        }
    }
}

#[test]
fn noise_has_the_deviation_that_it_is_given() {
    let mut data = SERVO_100W;
    data.sensors.current_noise = 0.1;
    let mut plant = Plant::new(data, 3);
    let seen: Vec<f64> = (0..20_000).map(|_| plant.measure().currents[0]).collect();
    let mean = seen.iter().sum::<f64>() / seen.len() as f64;
    let square = seen.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / seen.len() as f64;
    assert!(mean.abs() < 0.003, "{mean}");
    assert!((square.sqrt() - 0.1).abs() < 0.003, "{}", square.sqrt());
}

proptest! {
    /// Six sectors of the electrical turn, each with its own word, one sensor changing from each to the next.
    #[test]
    fn hall_sensors_tell_the_sector(turn in -3.0..3.0_f64) {
        let angle = turn * TAU / 4.0;
        let plant = |angle| Plant::new(SERVO_100W, 1).turning(angle, 0.0);
        let here = plant(angle).measure().hall;
        prop_assert!((1..=6).contains(&here));
        let sector = |angle: f64| ((angle * 4.0 / TAU - 1.0 / 12.0) * 6.0).floor() as i64;
        let next = angle + TAU / 4.0 / 6.0;
        prop_assert_eq!(sector(next), sector(angle) + 1);
        prop_assert_eq!((plant(next).measure().hall ^ here).count_ones(), 1);
    }

    #[test]
    fn an_absolute_angle_is_within_its_last_bit(angle in -20.0..20.0_f64, bits in 12..=20_u8, off in 0.0..0.02_f64) {
        let mut data = SERVO_100W;
        data.sensors = SensorData { bits, zero: 0.7, eccentricity: off, ..SensorData::ideal(4_000) };
        let word = Plant::new(data, 1).turning(angle, 0.0).measure().word.unwrap_or_default();
        let shown = f64::from(word) / f64::from(1u32 << bits) * TAU;
        let away = (shown - (angle - 0.7)).rem_euclid(TAU);
        let away = away.min(TAU - away);
        prop_assert!(away <= off + TAU / f64::from(1u32 << bits), "{} off", away);
    }
}

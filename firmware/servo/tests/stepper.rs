//! A stepper in closed loop under loads that are too great for it.

mod rig;

use std::f64::consts::TAU;

use proptest::prelude::*;
use rig::{PERIOD, Rig, motor};
use servo::Motor;
use servo::current_loop::CurrentConfig;
use servo::stepper::{Beyond, Field, Rotor, Stepper, StepperConfig, StepperDemand};
use servo_plant::Plant;
use servo_plant::axes::NEMA17;

/// Counts in a full step.
const FULL_STEP: f64 = 4_096.0 / 200.0;

const CONFIG: StepperConfig = StepperConfig {
    beyond: Beyond::MadeUpAtOnce,
    bound: 1.5,
    speed: 400.0,
    max_speed: 4_000.0,
    current: 2.4,
    at_rest: 0.4,
    fall: 0.05,
};

fn nema17() -> Motor {
    motor(&NEMA17, 1.7, 2.4)
}

/// The torque that holds a full step of lead, in N·m.
fn holding() -> f64 {
    f64::from(nema17().torque_constant() * CONFIG.current)
}

struct Axis {
    rig: Rig,
    stepper: Stepper,
    demand: f64,
    speed: f64,
    field: Option<Field>,
    /// The greatest true lead, in full steps.
    max: f64,
}

impl Axis {
    fn new(config: StepperConfig, seed: u64) -> Self {
        let known = nema17();
        let current = CurrentConfig::quick(&known, PERIOD, 6.0, (10.0, 60.0));
        Self {
            rig: Rig::new(Plant::new(NEMA17, seed), known, current),
            stepper: Stepper::new(&known, config, PERIOD).unwrap(),
            demand: 0.0,
            speed: 0.0,
            field: None,
            max: 0.0,
        }
    }

    /// A period with the demand going at a speed, in full steps/s.
    fn period(&mut self, speed: f64) {
        // No faster than a ramp of 20,000 full steps/s².
        let change = 20_000.0 * f64::from(PERIOD);
        self.speed += (speed - self.speed).clamp(-change, change);
        self.demand += self.speed * f64::from(PERIOD);
        let sample = self.rig.sense();
        let demand = StepperDemand {
            position: (self.demand * FULL_STEP * 65_536.0) as i64,
            speed: (self.speed * TAU / 4.0) as f32,
            is_at_rest: self.speed == 0.0,
        };
        let rotor = Rotor {
            position: self.rig.encoder.position(),
            angle: self.rig.encoder.angle(),
            speed: self.rig.observer.speed(),
        };
        let field = self.stepper.run(&demand, &rotor, f32::INFINITY);
        let lead = field
            .angle
            .minus(rig::turned(self.rig.plant.electrical_angle()));
        self.max = self.max.max(f64::from(lead.turns().abs()) * 4.0);
        self.rig.act(&sample, field.seen_from(sample.angle));
        self.field = Some(field);
    }

    fn run(&mut self, speed: f64, seconds: f64) {
        for _ in 0..(seconds / f64::from(PERIOD)) as u32 {
            self.period(speed);
        }
    }

    /// Where the rotor is beside the demand, in full steps.
    fn away(&self) -> f64 {
        self.rig.plant.angle() / TAU * 200.0 - self.demand
    }
}

#[test]
fn a_load_that_is_too_great_costs_no_step() {
    for beyond in [Beyond::MadeUpAtOnce, Beyond::MadeUpAtRest] {
        let mut axis = Axis::new(StepperConfig { beyond, ..CONFIG }, 1);
        axis.run(200.0, 0.1);
        axis.rig.plant.load_brake = 1.3 * holding();
        axis.run(200.0, 0.1);
        assert!(axis.away() < -15.0, "it cannot follow: {}", axis.away());
        assert!(axis.max < 1.6, "{}", axis.max);
        axis.rig.plant.load_brake = 0.0;
        axis.run(200.0, 0.02);
        let behind = axis.stepper.behind();
        axis.run(200.0, 0.1);
        let is_made_up = axis.stepper.behind() < behind;
        assert_eq!(is_made_up, beyond == Beyond::MadeUpAtOnce);
        axis.run(0.0, 0.6);
        assert_eq!(axis.stepper.behind(), 0);
        assert!(axis.away().abs() < 0.15, "{}", axis.away());
    }
}

/// The same without an encoder in the loop loses whole electrical turns, and is told so.
#[test]
fn supervised_a_lost_step_is_told() {
    let config = StepperConfig {
        beyond: Beyond::Reported,
        ..CONFIG
    };
    let mut axis = Axis::new(config, 1);
    axis.run(200.0, 0.1);
    assert!(!axis.field.unwrap().is_beyond);
    axis.rig.plant.load_brake = 1.3 * holding();
    axis.run(200.0, 0.1);
    assert!(axis.field.unwrap().is_beyond);
    axis.rig.plant.load_brake = 0.0;
    axis.run(0.0, 0.6);
    let lost = axis.away();
    assert!(lost.abs() > 3.5, "{lost}");
    assert!(
        (lost / 4.0 - (lost / 4.0).round()).abs() < 0.1,
        "whole electrical turns: {lost}"
    );
}

#[test]
fn the_current_falls_at_rest_and_rises_with_the_load() {
    let mut axis = Axis::new(CONFIG, 1);
    axis.run(0.0, 0.4);
    let rest = axis.field.unwrap().current;
    assert!(rest < 0.45 * CONFIG.current, "{rest}");
    axis.rig.plant.load_torque = 0.6 * holding();
    axis.run(0.0, 0.2);
    let loaded = axis.field.unwrap().current;
    assert!(loaded > 0.7 * CONFIG.current, "{loaded}");
    axis.rig.plant.load_torque = 0.0;
    axis.run(0.0, 0.4);
    let rest = axis.field.unwrap().current;
    assert!(rest < 0.45 * CONFIG.current, "{rest}");
}

/// How many random load profiles: `SERVO_PROFILES`, or a few.
fn profiles() -> u32 {
    let wanted = std::env::var("SERVO_PROFILES");
    wanted.map_or(24, |text| text.parse().unwrap())
}

/// Brakes up to one and a half times what the motor can hold, and loads that drive it, at any moments of any motion: no step is lost, and the lead stays within its bound.
#[test]
fn no_load_profile_costs_a_step() {
    let mut seed = 0x5EED_u64;
    let mut chance = move || {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        (seed >> 11) as f64 / (1u64 << 53) as f64
    };
    let (mut lead, mut away) = (0.0_f64, 0.0_f64);
    for profile in 0..profiles() {
        let bound = 1.1 + 0.6 * chance();
        let beyond = if chance() < 0.5 {
            Beyond::MadeUpAtOnce
        } else {
            Beyond::MadeUpAtRest
        };
        let config = StepperConfig {
            beyond,
            bound: bound as f32,
            speed: 1_500.0,
            ..CONFIG
        };
        let mut axis = Axis::new(config, profile.into());
        for _ in 0..6 {
            axis.rig.plant.load_brake = 1.5 * holding() * chance();
            // What drives it is less than it can hold at any lead within the bound.
            axis.rig.plant.load_torque = 0.25 * holding() * (2.0 * chance() - 1.0);
            let speed = 600.0 * (2.0 * chance() - 1.0);
            axis.run(speed, 0.01 + 0.03 * chance());
        }
        (axis.rig.plant.load_torque, axis.rig.plant.load_brake) = (0.0, 0.0);
        axis.run(0.0, 0.05);
        for _ in 0..20 {
            if axis.stepper.behind() == 0 {
                break;
            }
            axis.run(0.0, 0.05);
        }
        axis.run(0.0, 0.15);
        assert!(axis.rig.tripped.is_none());
        assert_eq!(axis.stepper.behind(), 0, "profile {profile}");
        // The rotor goes on by some tenths of a count while a period lasts.
        let over = axis.max - bound;
        assert!(over < 0.2, "profile {profile}: {over} beyond {bound}");
        assert!(
            axis.away().abs() < 0.15,
            "profile {profile}: {} full steps away",
            axis.away()
        );
        lead = lead.max(over);
        away = away.max(axis.away().abs());
    }
    println!(
        "{} profiles: {lead:.3} full steps beyond the bound, {away:.3} away at the end",
        profiles()
    );
}

proptest! {
    /// Whatever is demanded and measured: a current is one, at most the whole, and the lead is within its bound.
    #[test]
    fn no_number_gets_through(
        runs in prop::collection::vec((any::<i64>(), any::<i64>(), any::<u32>(), any::<u32>(), any::<u32>(), any::<bool>()), 1..60),
        bound in 1.1..1.7_f32,
        at_once: bool,
    ) {
        let beyond = if at_once { Beyond::MadeUpAtOnce } else { Beyond::MadeUpAtRest };
        let mut stepper = Stepper::new(&nema17(), StepperConfig { beyond, bound, ..CONFIG }, PERIOD).unwrap();
        for (position, at, speed, other, angle, is_at_rest) in runs {
            let demand = StepperDemand { position, speed: f32::from_bits(speed), is_at_rest };
            let rotor = Rotor { position: at >> 20, angle: servo::Angle::from_bits(angle), speed: f32::from_bits(other) };
            let field = stepper.run(&demand, &rotor, f32::INFINITY);
            prop_assert!(field.current > 0.0 && field.current <= CONFIG.current);
            prop_assert!(field.angle.minus(rotor.angle).turns().abs() * 4.0 <= bound + 1e-3);
            prop_assert!(field.lead.abs() <= bound + 1e-3);
        }
    }
}

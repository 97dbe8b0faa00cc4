//! Something breaks at a random moment of a random motion: the motor has no current then, soon, and never had too much of it.

mod profiles;

use cia402::{ServoGoal, ServoOrder};
use motion::{SignedSpeed, Speed};
use runtime::servo::{ServoSettings, StepperSettings};

use super::*;
use crate::plant::chance::Chance;

/// What breaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Breaks {
    /// The supply is cut off.
    Supply,
    /// The encoder counts no more.
    Encoder,
    /// The wire of a phase is cut.
    Phase(usize),
    /// The wire of a phase touches the bus.
    Wire(usize),
    /// Something feeds the bus.
    Bus,
    /// The rotor is held.
    Rotor,
}

impl Breaks {
    /// Which faults tell of it. What an encoder or a wire that is lost does to the motor hangs on the moment.
    fn shows_as(self, fault: Fault) -> bool {
        match self {
            Self::Supply => fault == Fault::UnderVoltage,
            Self::Wire(_) => matches!(fault, Fault::Short | Fault::OverCurrent),
            Self::Bus => fault == Fault::OverVoltage,
            Self::Rotor => fault == Fault::Blocked,
            Self::Encoder => matches!(
                fault,
                Fault::Encoder | Fault::Blocked | Fault::OverCurrent | Fault::PhaseLost
            ),
            Self::Phase(_) => matches!(
                fault,
                Fault::PhaseLost | Fault::Encoder | Fault::Blocked | Fault::OverCurrent
            ),
        }
    }
}

/// A motor on its way, and how a motion goes on.
struct Rig {
    servo: ServoMotor,
    data: ServoAxisData,
    /// In counts/s, and in counts.
    velocity: f64,
    position: f64,
    /// The greatest current of a phase.
    max: f64,
}

/// A stepper as it is by itself.
const STEPPER: StepperSettings = StepperSettings {
    mode: 0,
    bound: 150,
    speed: 1_000,
    current: 1_000,
    at_rest: 400,
    fall: 50,
    is_at_once: false,
};

/// A refill, in microseconds.
const REFILL: u64 = 250;

impl Rig {
    fn new(data: ServoAxisData, seed: u64) -> Self {
        let mut servo = ServoMotor::new(&data, seed);
        servo.energise(true);
        Self {
            servo,
            data,
            velocity: 0.0,
            position: 0.0,
            max: 0.0,
        }
    }

    /// The same with a stepper that is held so.
    fn stepper(data: ServoAxisData, seed: u64, stepper: StepperSettings) -> Self {
        let mut rig = Self::new(data, seed);
        rig.servo.energise(false);
        rig.servo.set_up(&ServoSettings {
            stepper,
            ..ServoSettings::default()
        });
        rig.servo.energise(true);
        rig
    }

    /// For so long towards a velocity, on a ramp of a tenth of a second.
    fn run(&mut self, seconds: f64, wanted: f64) {
        let counts = f64::from(self.data.plant.sensors.counts);
        let change = f64::from(self.data.speed) / 60.0 * counts * 10.0 * REFILL as f64 * 1e-6;
        for _ in 0..(seconds * 1e6) as u64 / REFILL {
            let acceleration =
                (wanted - self.velocity).clamp(-change, change) / (REFILL as f64 * 1e-6);
            let whole = self.position.floor();
            let goal = ServoGoal::Position {
                counts: whole as i64,
                part: ((self.position - whole) * 4_294_967_296.0) as u32,
                velocity: SignedSpeed::from_bits((self.velocity * 4_294_967_296.0) as i64),
                acceleration: acceleration as i32,
            };
            let order = ServoOrder {
                goal,
                torque: 0,
                velocity_ahead: SignedSpeed::ZERO,
                max_torque: (u32::MAX, u32::MAX),
                current: u32::MAX,
                velocity: Speed::MAX,
            };
            let at = self.servo.time * u64::from(STEP_CLOCK_HZ / 1_000_000);
            self.position +=
                (self.velocity + acceleration * REFILL as f64 * 0.5e-6) * REFILL as f64 * 1e-6;
            self.velocity += acceleration * REFILL as f64 * 1e-6;
            self.servo
                .run(REFILL, at, Some(&Ordered { order, at }), 0, 250);
            let phases = self.servo.plant.phase_currents();
            self.max = phases
                .iter()
                .fold(self.max, |max, phase| max.max(phase.abs()));
        }
    }
}

/// How many moments: `AXIS402_SOAK_BREAKS`, or some.
fn moments() -> u64 {
    let wanted = std::env::var("AXIS402_SOAK_BREAKS");
    wanted.map_or(200, |text| text.parse().unwrap())
}

#[test]
fn whatever_breaks_ends_the_current_and_the_motion() {
    let mut chance = Chance::new(402);
    let mut random = |from: f64, to: f64| {
        from + (to - from) * (chance.next() >> 11) as f64 / (1_u64 << 53) as f64
    };
    for moment in 0..moments() {
        let data = AXES[(moment % 4) as usize];
        // Steppers in each of their ways. A field that is only supervised turns on past a rotor that is held: that is a following error.
        let way = match (moment / 24 % 4, data.plant.motor.phases) {
            (_, Phases::Three) => 0,
            (1, _) if (moment / 4) % 6 == 5 => 3,
            (way, _) => way as u8,
        };
        let mut rig = Rig::stepper(
            data,
            moment,
            StepperSettings {
                mode: way,
                ..STEPPER
            },
        );
        let fastest = f64::from(data.speed) / 60.0 * f64::from(data.plant.sensors.counts);
        let sign = if random(-1.0, 1.0) < 0.0 { -1.0 } else { 1.0 };
        let wanted = sign * fastest * random(0.15, 0.7);
        let load = f64::from(rig.servo.loops.motor().rated_torque()) * random(0.05, 0.4);
        rig.servo.plant.load_brake = load;
        rig.run(random(0.005, 0.25), wanted);
        assert_eq!(
            rig.servo.fault(),
            None,
            "{moment}, way {way}: nothing is broken yet"
        );
        let breaks = match (moment / 4) % 6 {
            0 => Breaks::Supply,
            1 => Breaks::Encoder,
            2 => Breaks::Phase(random(0.0, 1.99) as usize),
            3 => Breaks::Bus,
            4 => Breaks::Wire(random(0.0, 1.99) as usize),
            _ => Breaks::Rotor,
        };
        match breaks {
            Breaks::Supply => rig.servo.plant.is_fed = false,
            Breaks::Encoder => rig.servo.plant.sensor_faults.encoder_is_cut = true,
            Breaks::Phase(phase) => rig.servo.plant.cut_phase = Some(phase),
            Breaks::Wire(phase) => {
                rig.servo.plant.short = Some(servo_plant::Short::new(phase, 0.05, 2e-6));
            }
            Breaks::Bus => rig.servo.plant.charge_bus(1.4 * data.plant.supply.voltage),
            Breaks::Rotor => rig.servo.plant.load_brake = 100.0,
        }
        let mut waited = 0.0;
        while rig.servo.fault().is_none() && waited < 2.5 {
            rig.run(0.005, wanted);
            waited += 0.005;
        }
        let what = format!("moment {moment}, {}, way {way}, {breaks:?}", data.name);
        let fault = rig
            .servo
            .fault()
            .unwrap_or_else(|| panic!("{what}: it goes on"));
        assert!(breaks.shows_as(fault), "{what}: {fault:?}");
        assert!(rig.servo.error_code().is_some());
        // The limit is the peak current; what is beyond it is the loop on its way, and trips at twice that.
        let limit = 2.1 * f64::from(data.peak_current);
        assert!(rig.max < limit, "{what}: {} A", rig.max);
        rig.run(0.1, wanted);
        let phases = rig.servo.plant.phase_currents();
        assert!(
            phases.iter().all(|phase| phase.abs() < 0.05),
            "{what}: {phases:?}"
        );
        assert_eq!(rig.servo.fault(), Some(fault), "{what}: it stays");
        // What turns comes to rest by its load alone.
        let begin = rig.servo.plant.velocity().abs();
        rig.run(0.05, wanted);
        let end = rig.servo.plant.velocity().abs();
        assert!(
            end <= begin && (end < begin || begin < 0.5),
            "{what}: {begin} {end}"
        );
        if (moment + 1) % 1_000 == 0 {
            println!("{} moments, and each has its fault", moment + 1);
        }
    }
}

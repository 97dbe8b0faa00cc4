//! The servo: the current interrupt from samples to compare values, and the loops above it.

use core::hint::black_box;

use ::servo::cascade::{Actual, Demand, Gains, Limits};
use ::servo::current_loop::CurrentConfig;
use ::servo::feedback::{Incremental, Observer};
use ::servo::filter::Filter;
use ::servo::interrupt::Counts;
use ::servo::modulation::Modulation;
use ::servo::offsets::CurrentSense;
use ::servo::stage::Counter;
use ::servo::transform::Rotor;
use ::servo::{Cascade, CurrentInterrupt, CurrentLoop, Motor, Wiring};

use crate::{count, row};

/// Of the modulation, in s.
const PERIOD: f32 = 50e-6;

/// Half a period is 4,200 counts of the timer.
const COUNTER: Counter = Counter::new(4_200);

const MOTOR: Motor = Motor {
    wiring: Wiring::ThreePhase,
    pole_pairs: 4,
    resistance: 0.6,
    inductance_d: 0.8e-3,
    inductance_q: 0.8e-3,
    flux: 13.33e-3,
    rated_current: 4.0,
    peak_current: 12.0,
    inertia: 9.6e-6,
    counts: 10_000,
};

fn interrupt(motor: &Motor, weakening: f32) -> CurrentInterrupt {
    let config = CurrentConfig {
        weakening,
        ..CurrentConfig::quick(motor, PERIOD, 20.0, (10.0, 60.0))
    };
    let modulation = Modulation::new(motor.wiring, 0.01, 0.1, 0.96).unwrap();
    CurrentInterrupt::new(
        CurrentSense::new(0.01, 2_048, 100).unwrap(),
        Incremental::new(motor, 0, 2),
        Observer::new(2_000.0, PERIOD).unwrap(),
        CurrentLoop::new(motor, config, modulation).unwrap(),
        0.016,
    )
    .unwrap()
}

/// Counts in, compare values out.
#[inline(never)]
fn period(interrupt: &mut CurrentInterrupt, counts: &Counts) -> Option<[u16; 3]> {
    let widths = interrupt.run(counts).ok()?;
    let [a, b, c] = widths;
    let value = |width| COUNTER.half_bridge(width);
    Some([value(a), value(b), value(c)])
}

/// The worst of a thousand periods of a motor that turns, while its current is noisy.
fn worst(mut interrupt: CurrentInterrupt) -> u32 {
    let (mut worst, mut made) = (0, 0);
    for at in 0..1_000_u16 {
        let noise = at.wrapping_mul(2_053) % 200;
        if at % 5 == 0 {
            let demand = Rotor {
                d: 0.0,
                q: f32::from(at % 50) * 0.1,
            };
            interrupt.order(demand, 5);
        }
        let counts = black_box(Counts {
            currents: [2_150 + noise, 2_000, 1_900 - noise],
            bus: 3_000,
            timer: at.wrapping_mul(25),
        });
        let (count, widths) = count(|| period(&mut interrupt, &counts));
        made += u32::from(widths.is_some_and(|widths| widths.iter().any(|width| *width > 0)));
        worst = worst.max(count);
    }
    assert!(made == 1_000, "each period has its widths");
    worst
}

/// The worst of a thousand ticks of position and velocity.
fn cascade() -> u32 {
    let gains = Gains::from_bandwidth(800.0);
    let low_pass = Filter::low_pass(800.0, 0.7, 250e-6).unwrap();
    let notch = Filter::notch(300.0, 2.0, 250e-6).unwrap();
    let mut cascade = Cascade::new(&MOTOR, gains, 0.03, 250e-6).unwrap();
    cascade.set_filters(low_pass, notch, 0.0);
    let mut worst = 0;
    for at in 0..1_000_u16 {
        let position = i64::from(at) * 25;
        let demand = black_box(Demand {
            position: Some(position),
            part: 0.25,
            velocity: 62.0,
            acceleration: 10.0,
            current: 0.0,
        });
        let actual = black_box(Actual {
            position: position - i64::from(at % 7),
            velocity: 61.0,
        });
        let (count, current) = count(|| cascade.run(&demand, actual, Limits::both(12.0)));
        assert!(current.abs() <= 12.0);
        worst = worst.max(count);
    }
    worst
}

/// All workloads of the servo.
pub fn run() {
    row(
        "servo: current interrupt, three phases",
        worst(interrupt(&MOTOR, 0.0)),
    );
    row(
        "servo: current interrupt, three phases, field weakened",
        worst(interrupt(&MOTOR, 8.0)),
    );
    let stepper = Motor {
        wiring: Wiring::TwoPhase,
        pole_pairs: 50,
        ..MOTOR
    };
    row(
        "servo: current interrupt, two phases",
        worst(interrupt(&stepper, 0.0)),
    );
    row("servo: position and velocity loop", cascade());
}

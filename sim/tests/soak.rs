//! Very many pulses through planner, train and the timers of the board: none too many, none too few.
//!
//! The ordinary run makes ten million pulses and a few hundred sequences of commands. `cargo xtask soak` makes a thousand million and
//! a million of them; it sets the two variables below.

use std::env;

use motion::advanced_timer::Ring;
use motion::{DriverTiming, Limits};
use sim::timer_model::Judge;
use sim::timer_model::rig::{HZ, Rig, SEGMENT};

/// A TMC2209 at 168 MHz.
const FAST: DriverTiming = DriverTiming {
    pulse_high: 17,
    pulse_low: 17,
    direction_setup: 4,
    direction_hold: 4,
};

fn setting(name: &str, ordinary: u64) -> u64 {
    env::var(name).map_or(ordinary, |text| {
        text.parse()
            .unwrap_or_else(|_| panic!("{name} is no number: {text}"))
    })
}

/// Numbers that look random, from a seed (an xorshift generator).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn below(&mut self, end: u64) -> u64 {
        self.next() % end
    }

    fn limits(&mut self) -> Limits {
        Limits {
            velocity: (1 + self.below(1_000_000) as u32).into(),
            acceleration: 1 << (14 + self.below(13)),
            deceleration: 1 << (14 + self.below(13)),
        }
    }
}

#[test]
fn every_pulse_of_long_moves_is_there() {
    let pulses = setting("AXIS402_SOAK_PULSES", 10_000_000);
    let ring = Ring::new();
    let mut rig = Rig::new(&ring, FAST, Judge::new(FAST));
    let limits = Limits {
        velocity: 1_000_000.into(),
        acceleration: 5_000_000,
        deceleration: 5_000_000,
    };
    let (mut target, mut forth) = (0_i64, true);
    while rig.model.judge().pulses < pulses {
        target += if forth { 4_000_037 } else { -3_999_949 };
        forth = !forth;
        let before = rig.model.judge().pulses;
        rig.axis.move_to(target, limits).unwrap();
        rig.finish(30_000);
        rig.account();
        assert_eq!(rig.model.judge().position, target);
        let way = if forth { 3_999_949 } else { 4_000_037 };
        assert_eq!(rig.model.judge().pulses - before, way);
    }
    assert_eq!(rig.underruns, 0);
    println!("{} pulses, count error 0", rig.model.judge().pulses);
}

#[test]
fn no_sequence_of_commands_makes_a_pulse_too_many() {
    let sequences = setting("AXIS402_SOAK_SEQUENCES", 300);
    let ring = Ring::new();
    let mut rig = Rig::new(&ring, FAST, Judge::new(FAST));
    let mut numbers = Numbers(0x9E37_79B9_7F4A_7C15);
    for sequence in 0..sequences {
        for _ in 0..6 {
            let limits = numbers.limits();
            let _ = match numbers.below(8) {
                0..=2 => {
                    let target = numbers.below(8_000) as i64 - 4_000;
                    rig.axis.move_to(target, limits)
                }
                3 | 4 => {
                    let velocity = numbers.below(400_000) as i32 - 200_000;
                    rig.axis.ramp_to(velocity.into(), limits)
                }
                5 | 6 => rig.axis.stop(limits.deceleration),
                _ => {
                    rig.output.drop_all();
                    rig.axis.abort();
                    let position = rig.output.position();
                    rig.axis.set_position(position);
                    Ok(())
                }
            };
            for _ in 0..numbers.below(12) {
                rig.refill(SEGMENT.into());
            }
            if numbers.below(50) == 0 {
                // The processor stands still for up to 5 ms.
                let pause = numbers.below(u64::from(HZ) / 200);
                rig.refill(pause);
            }
        }
        rig.axis.stop(200_000_000).unwrap();
        rig.finish(10_000);
        rig.account();
        // Where the count began makes no difference.
        if sequence % 64 == 63 {
            rig.axis
                .move_to(
                    0,
                    Limits {
                        velocity: 1_000_000.into(),
                        acceleration: 100_000_000,
                        deceleration: 100_000_000,
                    },
                )
                .unwrap();
            rig.finish(100_000);
            rig.account();
        }
    }
    println!(
        "{sequences} sequences, {} pulses, {} underruns told, count error 0",
        rig.model.judge().pulses,
        rig.underruns
    );
}

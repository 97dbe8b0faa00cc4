//! Any sequence of commands, with a processor that comes late or not at all: every pulse is accounted for.

use motion::{DriverTiming, Limits, Ramps};
use proptest::prelude::*;
use proptest::test_runner::contextualize_config;

use super::super::rig::{HZ, SEGMENT};
use super::{FAST, SLOW, rig};

#[derive(Clone, Debug)]
enum Command {
    MoveTo(i32, Limits),
    RampTo(i32, Limits),
    Stop(u32),
    /// Ramps for what comes from now on.
    Choose(Ramps),
    Drop,
    /// Refills on time.
    Refill(u8),
    /// A refill that comes after so many ticks.
    Late(u32),
}

fn limits() -> impl Strategy<Value = Limits> {
    (1..1_000_000u32, 14..27u32, 14..27u32).prop_map(|(velocity, a, d)| Limits {
        velocity: velocity.into(),
        acceleration: 1 << a,
        deceleration: 1 << d,
    })
}

/// Of every kind, at no less than a jerk of 2^`least` steps/s³.
pub(super) fn ramps(least: u32) -> impl Strategy<Value = Ramps> {
    let jerk = 1 << least..1_u32 << 31;
    prop_oneof![
        Just(Ramps::Linear),
        Just(Ramps::SinSquared),
        jerk.clone().prop_map(Ramps::JerkLimited),
        jerk.prop_map(Ramps::MovingAverage),
    ]
}

fn command() -> impl Strategy<Value = Command> {
    prop_oneof![
        3 => (-20_000..20_000i32, limits()).prop_map(|(target, limits)| Command::MoveTo(target, limits)),
        2 => (-50..50i32, limits()).prop_map(|(target, limits)| Command::MoveTo(target, limits)),
        2 => (-900_000..900_000i32, limits()).prop_map(|(velocity, limits)| Command::RampTo(velocity, limits)),
        2 => (1..50_000_000u32).prop_map(Command::Stop),
        2 => ramps(20).prop_map(Command::Choose),
        1 => Just(Command::Drop),
        8 => any::<u8>().prop_map(Command::Refill),
        2 => (0..4 * SEGMENT).prop_map(Command::Late),
        1 => (0..400 * SEGMENT).prop_map(Command::Late),
    ]
}

fn play(commands: &[Command], timing: DriverTiming, burst: u64, access: u64) {
    let mut rig = rig(timing);
    rig.model.set_burst(burst);
    rig.model.set_access(access);
    rig.model.set_interrupts(50, u64::from(HZ) / 100_000);
    for command in commands {
        let _ = match *command {
            Command::MoveTo(target, limits) => rig.axis.move_to(target.into(), limits),
            Command::RampTo(velocity, limits) => rig.axis.ramp_to(velocity.into(), limits),
            Command::Stop(deceleration) => rig.axis.stop(deceleration),
            Command::Choose(ramps) => {
                rig.axis.set_ramps(ramps);
                Ok(())
            }
            Command::Drop => {
                rig.output.drop_all();
                rig.axis.abort();
                let position = rig.output.position();
                rig.axis.set_position(position);
                rig.account();
                Ok(())
            }
            Command::Refill(times) => {
                for _ in 0..times {
                    rig.refill(SEGMENT.into());
                }
                Ok(())
            }
            Command::Late(ticks) => {
                rig.refill(ticks.into());
                Ok(())
            }
        };
    }
    rig.axis.stop(400_000_000).unwrap();
    rig.finish(200_000);
    rig.account();
    let home = Limits {
        velocity: 1_000_000.into(),
        acceleration: 100_000_000,
        deceleration: 100_000_000,
    };
    rig.axis.move_to(777, home).unwrap();
    rig.finish(200_000);
    rig.account();
    assert_eq!(rig.output.position() as i32, 777);
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig { cases: 100, failure_persistence: None, ..ProptestConfig::default() }))]

    #[test]
    fn every_pulse_that_leaves_is_accounted_for(
        commands in prop::collection::vec(command(), 1..25),
        fast: bool,
        burst in 5..84u64,
        access in 0..8u64,
    ) {
        play(&commands, if fast { FAST } else { SLOW }, burst, access);
    }
}

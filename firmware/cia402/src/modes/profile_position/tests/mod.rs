//! The mode in a drive, on virtual time. The profile: 10000 steps/s, 100000 steps/s² both ways (500 steps each).

mod beyond;
mod blending;
mod halt;
mod handshake;
mod limits;
mod mode_change;
mod rotary;
mod target;
mod velocity;

use proptest::prelude::*;
use proptest::test_runner::contextualize_config;

use crate::testing::Rig;

const IMMEDIATELY: u16 = 0x20;
const RELATIVE: u16 = 0x40;
const HALT: u16 = 0x100;

/// What a master may do in operation enabled.
#[derive(Clone, Copy, Debug)]
struct Move {
    target: i32,
    bits: u16,
    hold: usize,
}

fn any_move() -> impl Strategy<Value = Move> {
    (
        -5_000..5_000,
        prop::sample::select(std::vec![
            0,
            IMMEDIATELY,
            RELATIVE,
            RELATIVE | IMMEDIATELY,
            HALT,
            HALT | IMMEDIATELY
        ]),
        1usize..150,
    )
        .prop_map(|(target, bits, hold)| Move { target, bits, hold })
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig::with_cases(64)))]
    /// Whatever set-points came before: an acknowledged immediate one is where the motor ends, to the step.
    #[test]
    fn the_last_set_point_is_where_the_motor_ends(
        moves in prop::collection::vec(any_move(), 0..20),
        last in -5_000i32..5_000,
    ) {
        let mut rig = Rig::enabled();
        for Move { target, bits, hold } in moves {
            rig.set_point(target, bits);
            rig.ticks(hold);
        }
        rig.set_point(last, IMMEDIATELY);
        rig.tick();
        prop_assert!(rig.acknowledged() && !rig.reached());
        prop_assert_eq!(rig.rest(), i64::from(last));
        rig.ticks(20);
        prop_assert!(rig.reached());
        prop_assert_eq!(rig.actuals().position_demand, last);
    }
}

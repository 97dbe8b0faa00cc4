//! A processor that takes its time, and is interrupted wherever it hurts.

use motion::advanced_timer::Register;

use super::super::rig::{HZ, TIME_SLICE};
use super::{FAST, LIMITS, rig};

/// When a train begins the timer may be on its way already when the processor comes back to work out when its slots are fetched.
#[test]
fn an_interrupt_at_the_start_of_a_train_loses_no_slot() {
    for microseconds in [1, 5, 12, 20, 25, 30, 48, 60, 200] {
        let ticks = microseconds * u64::from(HZ) / 1_000_000;
        let mut rig = rig(FAST);
        rig.model.interrupt_behind(Register::Cr1, ticks);
        rig.axis.move_to(300, LIMITS).unwrap();
        rig.finish(10_000);
        rig.account();
        assert_eq!(rig.model.judge().position, 300, "{microseconds} us");
    }
}

/// Interrupts of up to 10 µs anywhere, and a few ticks for each access.
#[test]
fn interrupts_anywhere_lose_no_pulse() {
    for access in [2, 6] {
        let mut rig = rig(FAST);
        rig.model.set_access(access);
        rig.model.set_interrupts(20, u64::from(HZ) / 100_000);
        for target in [1_000, -2_000, -1_990, 5_000, 0] {
            rig.axis.move_to(target, LIMITS).unwrap();
            for _ in 0..40 {
                rig.refill(u64::from(TIME_SLICE));
            }
        }
        rig.finish(10_000);
        rig.account();
        assert_eq!(rig.model.judge().position, 0);
    }
}

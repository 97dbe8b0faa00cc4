//! Switches whose contacts bounce: the debounce time 2033h makes one change of them, and it is where they first closed.

use canopen::Duration;
use sim::plant::{Axis, Switch, Track};
use tests::DriveBench;

/// 60FDh bit 2: home switch.
const HOME: u32 = 1 << 2;

/// A drive that stands at 0 before a home switch at 3,000 whose contact bounces for 2.5 ms.
fn drive(seed: u64, debounce: u8) -> DriveBench {
    let axis = Axis {
        seed,
        track: Track {
            home: Some(Switch::from(3_000).bouncing(Duration::from_ticks(2_500))),
            ..Track::default()
        },
        ..Axis::default()
    };
    let mut drive = DriveBench::on(axis);
    drive.write_u8(0x2033, 0, debounce);
    drive
}

/// How often 60FDh changes its mind about the home switch while the motor drives over it.
fn changes(seed: u64, debounce: u8) -> usize {
    let mut drive = drive(seed, debounce);
    drive.enable();
    drive.write_u32(0x6081, 0, 20_000);
    drive.begin_move(6_000);
    let mut last = false;
    let mut changes = 0;
    for _ in 0..1_000 {
        drive.run_millis(1);
        let active = drive.axis().actuals().digital_inputs & HOME != 0;
        changes += usize::from(active != last);
        last = active;
    }
    assert!(last, "it is behind the switch");
    changes
}

#[test]
fn m61_a_bouncing_contact_is_one_change_behind_the_debounce_time() {
    assert!((0..20).all(|seed| changes(seed, 3) == 1));
    assert!((0..20).any(|seed| changes(seed, 0) > 1), "it does bounce");
}

#[test]
fn m61_home_is_where_a_bouncing_contact_first_closed() {
    for seed in 0..20 {
        let mut drive = drive(seed, 3);
        drive.write_u8(0x6060, 0, 6);
        // The edge in positive direction.
        drive.write_u8(0x6098, 0, 20);
        drive.write_u32(0x6099, 1, 20_000);
        drive.write_u32(0x6099, 2, 1_000);
        drive.enable();
        drive.run_millis(5);
        drive.command(0x1F);
        drive.run_millis(5);
        drive.reaches_target(5_000);
        assert_eq!(drive.statusword() & 0x3400, 0x1400);
        let shown = drive.read_i32(0x6064, 0);
        let zero = drive.axis().plant().rotor() - i64::from(shown);
        assert_eq!(zero, 3_000, "seed {seed}");
    }
}

//! What ros2_canopen sends to a drive, replayed: initialisation with homing, every mode, a fault, quick stop and shutdown. How it works is in
//! [`crate::ros2_driver`].

use tests::drive::{
    ACKNOWLEDGE, FAULT, OPERATION_ENABLED, QUICK_STOP_ACTIVE, SWITCH_ON_DISABLED, TARGET_REACHED,
};

use crate::cyclic_master::FOLLOWS;
use crate::ros2_driver::{
    BIT_4, CYCLE, HOME, RECORD, Ros, Rpdos, TARGET_POSITION, TARGET_VELOCITY, VELOCITY,
};

/// Up and back, 60 increments in a cycle at its fastest.
fn up_and_back() -> impl Iterator<Item = i32> {
    let distances = (0..300).map(|k: i32| match k {
        0..30 => 2 * k,
        30..120 => 60,
        120..180 => 60 - 2 * (k - 120),
        180..270 => -60,
        _ => -60 + 2 * (k - 270),
    });
    distances.scan(0, |target, distance| {
        *target += distance;
        Some(*target)
    })
}

#[test]
fn d34_ros2_canopen_initialises_a_drive_and_homes_it() {
    for rpdos in [Rpdos::Synchronous, Rpdos::EventDriven] {
        let mut ros = Ros::booted(rpdos, &[TARGET_POSITION, TARGET_VELOCITY]);
        ros.drive.write_i8(0x6098, 0, 24);
        ros.drive.write_u32(0x6099, 1, 5_000);
        ros.drive.write_u32(0x6099, 2, 500);
        ros.initialises();
        ros.homes();
        let home = |ros: &mut Ros| {
            ros.cycles(5);
            assert_eq!(ros.display, 0);
            ros.drive.position() - i64::from(*ros.shown.last().unwrap())
        };
        assert_eq!(home(&mut ros), HOME, "{rpdos:?}");
        // Again: it sees bit 12 as it enters the mode, calls that done, and leaves. Home stays known.
        let stands = ros.drive.position();
        ros.homes();
        assert_eq!(home(&mut ros), HOME);
        assert_eq!(ros.drive.read_u8(0x2034, 1), 1);
        assert!((ros.drive.position() - stands).abs() < 100);
        // 2030h:1 bit 7 is for it: bit 12 is 0 as the mode is entered, and it homes.
        ros.drive.write_u16(0x2030, 1, 1 << 7);
        ros.homes();
        assert_eq!(home(&mut ros), HOME);
    }
}

/// Its velocity mode: 6042h, and bits 4 to 6 with it.
#[test]
fn d34_the_velocity_mode_of_ros2_canopen() {
    // In RPDO 2, and by SDO as with its own `bus.yml`.
    for targets in [&[VELOCITY][..], &[TARGET_POSITION, TARGET_VELOCITY]] {
        let mut ros = Ros::initialised(Rpdos::Synchronous, targets);
        ros.switches_mode(2);
        for (target, expected) in [(5_000, 500), (-3_000, -300), (0, 0)] {
            ros.target = Some(target);
            ros.cycles(30);
            assert_eq!(ros.velocity, target);
            assert_eq!(ros.distance(), expected);
        }
        ros.switches_mode(0);
        ros.cycles(5);
        assert_eq!(ros.state(), OPERATION_ENABLED);
    }
}

/// Its profiled velocity mode: 60FFh and nothing else.
#[test]
fn d34_the_profiled_velocity_mode_of_ros2_canopen() {
    for rpdos in [Rpdos::Synchronous, Rpdos::EventDriven] {
        let mut ros = Ros::initialised(rpdos, &[TARGET_POSITION, TARGET_VELOCITY]);
        // From before; halt is set while there is no target.
        ros.set(TARGET_VELOCITY, 8_000);
        ros.switches_mode(3);
        ros.cycles(20);
        assert_eq!(ros.drive.position(), 0);
        for (target, expected) in [(8_000, 800), (-8_000, -800)] {
            ros.target = Some(target);
            ros.cycles(30);
            assert_eq!(ros.velocity, target);
            assert_eq!(ros.distance(), expected);
        }
        // A new mode out of motion, then off.
        ros.switches_mode(1);
        ros.cycles(50);
        assert_eq!(ros.velocity, 0);
        ros.switches_mode(0);
        ros.switches_state(SWITCH_ON_DISABLED);
    }
}

/// Its profiled position mode: always bit 5, 607Ah and bit 4 in one run, bit 4 falls with bit 12, and targets that follow each other
/// without waiting for bit 10.
#[test]
fn d34_the_profiled_position_mode_of_ros2_canopen() {
    for rpdos in [Rpdos::Synchronous, Rpdos::EventDriven] {
        let mut ros = Ros::initialised(rpdos, &[TARGET_POSITION, TARGET_VELOCITY]);
        ros.switches_mode(1);
        for target in [3_000, -2_000, 20_000, 20_000, 1_000] {
            ros.target = Some(target);
            ros.cycles(12);
            assert_eq!(ros.sent, Some(target));
            assert_eq!(ros.status & ACKNOWLEDGE, 0, "{target}");
            assert_eq!(ros.controlword & BIT_4, 0, "{target}");
            assert_eq!(ros.drive.read_i32(0x607A, 0), target);
        }
        ros.waits_for(1_000, "not there", |ros| ros.status & TARGET_REACHED != 0);
        ros.cycles(2);
        assert_eq!(ros.drive.position(), 1_000);
    }
}

/// Its cyclic position mode: 607Ah in every cycle and no halt. 60C2h as nobody wrote it, as it is right, and as its `bus.yml` has it: 50 ms,
/// though a target comes every 10 ms.
#[test]
fn d34_the_cyclic_position_mode_of_ros2_canopen() {
    for rpdos in [Rpdos::Synchronous, Rpdos::EventDriven] {
        for period in [None, Some(10), Some(50)] {
            let mut ros = Ros::initialised(rpdos, &[TARGET_POSITION, TARGET_VELOCITY]);
            if let Some(period) = period {
                ros.drive.write_u8(0x60C2, 1, period);
                ros.drive.write_u8(0x60C2, 2, i8::cast_unsigned(-3));
            }
            // Late by up to 5 ms, so still before the next SYNC.
            ros.unrest = CYCLE / 2;
            ros.switches_mode(8);
            ros.follows([0; 100]);
            let first = ros.commanded.len();
            ros.follows(up_and_back());
            ros.follows([*ros.commanded.last().unwrap(); 10]);
            ros.is_exact(first);
            assert!(ros.shown.iter().max() > Some(&7_000));
            assert!(OPERATION_ENABLED.is_shown_by(ros.status), "{period:?}");
            assert_ne!(ros.status & FOLLOWS, 0, "{rpdos:?} {period:?}");
        }
    }
}

/// Where its timer runs close to SYNC, a target is late now and then, and two come for the next SYNC.
#[test]
fn d34_a_target_of_ros2_canopen_on_the_wrong_side_of_sync_is_bridged() {
    for rpdos in [Rpdos::Synchronous, Rpdos::EventDriven] {
        let mut ros = Ros::initialised(rpdos, &[TARGET_POSITION, TARGET_VELOCITY]);
        ros.switches_mode(8);
        ros.follows([0; 100]);
        ros.unrest = CYCLE * 3 / 4;
        let first = ros.commanded.len();
        ros.follows(up_and_back());
        let repeats = ros.commanded[first + 40..]
            .windows(2)
            .filter(|pair| pair[0] == pair[1])
            .count();
        assert!(repeats > 10, "{repeats}");
        ros.unrest = 0;
        let end = *ros.commanded.last().unwrap();
        ros.follows([end; 20]);
        if rpdos == Rpdos::Synchronous {
            // The master repeats what it has, so there is a set-point for each SYNC.
            ros.is_exact(first);
        }
        for pair in ros.shown.windows(2) {
            assert!((pair[1] - pair[0]).abs() <= 120, "{pair:?}");
        }
        assert_eq!(ros.drive.position(), i64::from(end));
        assert!(OPERATION_ENABLED.is_shown_by(ros.status));
        assert_ne!(ros.status & FOLLOWS, 0);
    }
}

/// Its cyclic velocity mode: 60FFh in every cycle and no halt.
#[test]
fn d34_the_cyclic_velocity_mode_of_ros2_canopen() {
    for rpdos in [Rpdos::Synchronous, Rpdos::EventDriven] {
        let mut ros = Ros::initialised(rpdos, &[TARGET_VELOCITY]);
        ros.unrest = CYCLE / 2;
        ros.set(TARGET_VELOCITY, 3_000);
        ros.switches_mode(9);
        ros.cycles(20);
        assert_eq!(ros.drive.position(), 0, "halt is set without a target");
        ros.follows([0; 50]);
        for top in [8_000, -6_000] {
            let begin = ros.commanded.len();
            ros.follows((0..=50).map(|k| top / 50 * k));
            ros.follows([top; 20]);
            assert_eq!(ros.velocity, top);
            assert_eq!(ros.distance(), top / 10);
            ros.follows((0..50).rev().map(|k| top / 50 * k));
            ros.follows([0; 20]);
            assert_eq!(ros.velocity, 0);
            // All that was commanded was gone, each velocity for one cycle.
            let sum: i32 = ros.commanded[begin..].iter().sum();
            let distance = *ros.shown.last().unwrap() - ros.shown[begin];
            assert!(
                (distance - sum / 100).abs() <= 60,
                "{distance} of {}",
                sum / 100
            );
        }
        assert_eq!(ros.state(), OPERATION_ENABLED);
        assert_ne!(ros.status & FOLLOWS, 0);
    }
}

/// Its interpolated position mode: a record in every cycle, and bit 4 with it.
#[test]
fn d34_the_interpolated_position_mode_of_ros2_canopen() {
    // Mapped; and by SDO, as with its own `bus.yml`, which maps 607Ah alone and begins in mode 7.
    for targets in [&[RECORD][..], &[TARGET_POSITION]] {
        for rpdos in [Rpdos::Synchronous, Rpdos::EventDriven] {
            let mut ros = Ros::initialised(rpdos, targets);
            ros.drive.write_u8(0x60C2, 1, 10);
            ros.drive.write_u8(0x60C2, 2, i8::cast_unsigned(-3));
            ros.switches_mode(7);
            ros.cycles(20);
            assert_eq!(ros.drive.position(), 0);
            ros.follows([0; 50]);
            let first = ros.commanded.len();
            ros.follows(up_and_back());
            let end = up_and_back().last().unwrap();
            ros.follows([end; 20]);
            assert_eq!(ros.drive.position(), i64::from(end));
            assert!(ros.shown.iter().max() > Some(&7_000));
            if targets == [RECORD] {
                ros.is_exact(first);
            }
            assert_eq!(ros.state(), OPERATION_ENABLED);
            assert_ne!(ros.status & FOLLOWS, 0);
        }
    }
}

/// Recovery: bit 7 on top of enable operation and halt, with an edge, and the way up again from there.
#[test]
fn d34_ros2_canopen_recovers_from_a_fault() {
    for rpdos in [Rpdos::Synchronous, Rpdos::EventDriven] {
        let mut ros = Ros::initialised(rpdos, &[TARGET_POSITION, TARGET_VELOCITY]);
        ros.switches_mode(3);
        ros.target = Some(8_000);
        ros.cycles(20);
        ros.drive.set_fault(Some(0x4310));
        ros.waits_for(100, "no fault", |ros| ros.state() == FAULT);
        ros.drive.set_fault(None);
        ros.resets = true;
        ros.target = None;
        ros.switches_state(OPERATION_ENABLED);
        ros.cycles(10);
        assert_eq!(ros.velocity, 0, "halt is set without a target");
        ros.target = Some(8_000);
        ros.cycles(20);
        assert_eq!(ros.velocity, 8_000);
    }
}

/// Its halt is a quick stop; recovery enables again. Its shutdown is mode 0 and switch on disabled.
#[test]
fn d34_ros2_canopen_halts_recovers_and_shuts_down() {
    let mut ros = Ros::initialised(Rpdos::Synchronous, &[TARGET_POSITION, TARGET_VELOCITY]);
    ros.switches_mode(3);
    ros.target = Some(8_000);
    ros.cycles(20);
    let (set, clear) = Ros::transition(OPERATION_ENABLED, QUICK_STOP_ACTIVE);
    ros.controlword = ros.controlword & !clear | set;
    ros.cycles(10);
    assert_eq!(ros.state(), SWITCH_ON_DISABLED, "605Ah is 2");
    assert_eq!(ros.velocity, 0);
    ros.resets = true;
    ros.target = None;
    ros.switches_state(OPERATION_ENABLED);
    ros.target = Some(-8_000);
    ros.cycles(20);
    assert_eq!(ros.velocity, -8_000);
    ros.switches_mode(0);
    ros.switches_state(SWITCH_ON_DISABLED);
    ros.cycles(20);
    assert_eq!((ros.velocity, ros.display), (0, 0));
}

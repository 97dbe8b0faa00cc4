//! What ros2_canopen sends to a drive, replayed: the order of its objects, its masks and its times.
//!
//! It walks up one state in each cycle and waits for it; it changes the mode with halt set, whatever the state; and while it
//! has no target it keeps halt set. Everything goes by PDO in a cycle of 10 ms here.

use tests::DriveBench;
use tests::drive::{OPERATION_ENABLED, SWITCH_ON_DISABLED, TARGET_REACHED};

const HALT: u16 = 0x100;
/// Bits 4 to 6, which its velocity mode sets.
const RAMP: u16 = 0x70;
/// Bit 12 in profile position.
const ACKNOWLEDGE: u16 = 1 << 12;

/// The master: its controlword, and how long it waits for things.
struct Ros {
    drive: DriveBench,
    controlword: u16,
}

impl Ros {
    const CYCLE: u64 = 10;

    /// A master that has initialised its drive: fault reset first, then one state after the other, with halt.
    fn initialised() -> Self {
        let mut ros = Self {
            drive: DriveBench::started(4),
            controlword: 0,
        };
        ros.drive.command(0x80 | HALT);
        ros.drive.run_millis(Self::CYCLE);
        for (controlword, mask, state) in
            [(0x06, 0x6F, 0x21), (0x07, 0x6F, 0x23), (0x0F, 0x6F, 0x27)]
        {
            ros.write(controlword | HALT);
            ros.waits_for(mask, state, 1_000);
        }
        ros
    }

    fn write(&mut self, controlword: u16) {
        self.controlword = controlword;
        self.drive.command(controlword);
        self.drive.run_millis(Self::CYCLE);
    }

    #[track_caller]
    fn waits_for(&mut self, mask: u16, bits: u16, milliseconds: u64) {
        for _ in 0..milliseconds / Self::CYCLE {
            if self.drive.statusword() & mask == bits {
                return;
            }
            self.write(self.controlword);
        }
        panic!("statusword {:04X}h", self.drive.statusword());
    }

    /// Halt, 6060h, 6061h within five seconds; the mode is given its first target later.
    #[track_caller]
    fn switches_mode(&mut self, mode: i8) {
        self.write(self.controlword | HALT);
        self.drive.write_u8(0x6060, 0, mode.cast_unsigned());
        for _ in 0..500 {
            if self.drive.read_i8(0x6061, 0) == mode {
                return;
            }
            self.write(self.controlword);
        }
        panic!("mode switch timed out");
    }
}

/// Its velocity mode: 6042h, and bits 4 to 6 with it.
#[test]
fn d34_the_velocity_mode_of_ros2_canopen() {
    let mut ros = Ros::initialised();
    ros.switches_mode(2);
    for (target, expected) in [(5_000, 50), (-3_000, -30), (0, 0)] {
        ros.drive.write_i16(0x6042, 0, target);
        ros.write(0x0F | RAMP);
        ros.drive.run_millis(200);
        let begin = ros.drive.position();
        ros.write(0x0F | RAMP);
        assert_eq!(ros.drive.position() - begin, expected);
    }
    ros.switches_mode(0);
    ros.drive.stays_in(OPERATION_ENABLED, 50);
}

/// Its profiled velocity mode: 60FFh and nothing else.
#[test]
fn d34_the_profiled_velocity_mode_of_ros2_canopen() {
    let mut ros = Ros::initialised();
    // From a mode that is in motion, with halt.
    ros.drive.write_i32(0x60FF, 0, 8_000);
    ros.switches_mode(3);
    let halted = ros.drive.position();
    ros.drive.run_millis(100);
    assert_eq!(
        ros.drive.position(),
        halted,
        "halt is set while there is no target"
    );
    for (target, expected) in [(8_000, 80), (-8_000, -80)] {
        ros.drive.write_i32(0x60FF, 0, target);
        ros.write(0x0F);
        ros.drive.run_millis(300);
        let begin = ros.drive.position();
        ros.write(0x0F);
        assert_eq!(ros.drive.position() - begin, expected);
    }
    ros.switches_mode(1);
    ros.write(0x02);
    ros.waits_for(0x4F, 0x40, 1_000);
}

/// Its profiled position mode: always bit 5, 607Ah and bit 4 in one cycle, bit 4 falls with bit 12, and targets that follow each
/// other without waiting for bit 10.
#[test]
fn d34_the_profiled_position_mode_of_ros2_canopen() {
    let mut ros = Ros::initialised();
    ros.switches_mode(1);
    for target in [3_000, -2_000, 20_000, 20_000, 1_000] {
        ros.drive.write_i32(0x607A, 0, target);
        ros.write(0x3F);
        ros.waits_for(ACKNOWLEDGE, ACKNOWLEDGE, 1_000);
        ros.write(0x2F);
        ros.waits_for(ACKNOWLEDGE, 0, 1_000);
        ros.drive.run_millis(120);
    }
    ros.waits_for(TARGET_REACHED, TARGET_REACHED, 10_000);
    ros.drive.run_millis(20);
    assert_eq!(ros.drive.position(), 1_000);
}

/// Recovery: a fault, then its reset with halt, and the way up again.
#[test]
fn d34_ros2_canopen_recovers_from_a_fault() {
    let mut ros = Ros::initialised();
    ros.switches_mode(3);
    ros.drive.write_i32(0x60FF, 0, 8_000);
    ros.write(0x0F);
    ros.drive.run_millis(200);
    ros.drive.set_fault(Some(0x4310));
    ros.waits_for(0x4F, 0x08, 1_000);
    ros.drive.set_fault(None);
    ros.write(0x0000);
    ros.write(0x80 | HALT);
    ros.drive.reaches(SWITCH_ON_DISABLED, 400);
    for (controlword, state) in [(0x06, 0x21), (0x07, 0x23), (0x0F, 0x27)] {
        ros.write(controlword | HALT);
        ros.waits_for(0x6F, state, 1_000);
    }
    ros.write(0x0F);
    ros.drive.run_millis(200);
    assert_eq!(ros.drive.read_i32(0x606C, 0), 8_000);
}

/// Its cyclic position mode: 607Ah in every cycle and no halt, here without SYNC, so that each write is a set-point.
#[test]
fn d34_the_cyclic_position_mode_of_ros2_canopen() {
    let mut ros = Ros::initialised();
    ros.drive.write_u8(0x60C2, 1, 10);
    ros.switches_mode(8);
    for target in (0..100).map(|k: i32| (k * 10).min(500)) {
        ros.drive.write_i32(0x607A, 0, target);
        ros.write(0x0F);
    }
    assert_eq!(ros.drive.position(), 500);
    ros.waits_for(0x6F | 1 << 12, 0x27 | 1 << 12, 1_000);
}

/// Its interpolated position mode: bit 4, then a record in every cycle.
#[test]
fn d34_the_interpolated_position_mode_of_ros2_canopen() {
    let mut ros = Ros::initialised();
    ros.drive.write_u8(0x60C2, 1, 10);
    ros.switches_mode(7);
    for record in (0..100).map(|k: i32| (k * 10).min(500)) {
        ros.drive.write_i32(0x60C1, 1, record);
        ros.write(0x1F);
    }
    assert_eq!(ros.drive.position(), 500);
    ros.waits_for(0x6F, 0x27, 1_000);
}

//! The cyclic modes 7, 8 and 9 at software limits and limit switches, in virtual time.

use canopen::Frame;
use sim::plant::{Axis, Switch, Track};
use tests::DriveBench;
use tests::drive::{
    FAULT, FAULT_REACTION_ACTIVE, INTERNAL_LIMIT, OPERATION_ENABLED, SWITCH_ON_DISABLED,
    TARGET_REACHED,
};

use crate::cyclic_master::{FOLLOWS, Master, expedited, expedited_sub, hardest};

/// Statusword bit 13 in the modes that follow positions.
const FOLLOWING_ERROR: u16 = 1 << 13;

/// A master that gives a set-point in each millisecond, in whatever mode.
struct Walk {
    master: Master,
    mode: i8,
    /// The last set-point, as a position.
    at: i32,
}

impl Walk {
    /// A drive that follows, at 0.
    fn begin(drive: DriveBench, mode: i8) -> Self {
        let mut master = Master::of(drive, mode, 1_000);
        if mode == 7 {
            master.drive.command(0x1F);
        }
        let mut walk = Self {
            master,
            mode,
            at: 0,
        };
        walk.steps([0; 100]);
        assert!(walk.master.has(FOLLOWS), "mode {mode}");
        walk
    }

    /// On an axis with limit switches at −2,000 and 2,000.
    fn between_switches(mode: i8) -> Self {
        let axis = Axis {
            track: Track {
                negative_limit: Some(Switch::up_to(-2_000)),
                positive_limit: Some(Switch::from(2_000)),
                ..Track::default()
            },
            ..Axis::default()
        };
        let mut drive = DriveBench::on(axis);
        // Mode 9 knows no other ramps.
        drive.write_u32(0x60C5, 0, 1_000_000);
        drive.write_u32(0x60C6, 0, 1_000_000);
        Self::begin(drive, mode)
    }

    /// With software limits at −1,000 and 1,000.
    fn between_limits(mode: i8) -> Self {
        let mut drive = DriveBench::started(4);
        drive.write_i32(0x607D, 1, -1_000);
        drive.write_i32(0x607D, 2, 1_000);
        Self::begin(drive, mode)
    }

    fn step(&mut self, target: i32) {
        let frame = |data: [u8; 8]| Frame::data_frame(0x604, &data);
        match self.mode {
            7 => {
                let record = expedited_sub(0x60C1, 1, target);
                self.master.drive.send_frame(frame(record));
                self.master.sync(0);
            }
            8 => self.master.steps([target]),
            _ => {
                let velocity = expedited(0x60FF, (target - self.at) * 1_000);
                self.master.drive.send_frame(frame(velocity));
                self.master.sync(0);
            }
        }
        self.at = target;
    }

    fn steps(&mut self, targets: impl IntoIterator<Item = i32>) {
        for target in targets {
            self.step(target);
        }
    }

    /// To a position with so many increments in each period; it begins and ends on a ramp of 1 a period.
    fn go(&mut self, target: i32, pace: i32) {
        let sign = (target - self.at).signum();
        let mut speed = 0;
        while self.at != target {
            let left = (target - self.at).abs();
            speed = (speed + 1).min(pace);
            while speed * (speed + 1) / 2 > left {
                speed -= 1;
            }
            self.step(self.at + speed * sign);
        }
    }

    fn stay(&mut self, cycles: u32) {
        for _ in 0..cycles {
            self.step(self.at);
        }
    }

    fn position(&self) -> i64 {
        self.master.drive.position()
    }
}

#[test]
fn d31_and_m54_a_limit_switch_stops_the_cyclic_modes_and_lets_them_turn_back() {
    for (mode, sign) in [(7, 1), (8, 1), (9, 1), (8, -1), (9, -1)] {
        let what = format!("mode {mode}, {sign}");
        let mut walk = Walk::between_switches(mode);
        // Again and again: nothing is latched.
        for round in 0..2 {
            let what = format!("{what}, round {round}");
            walk.go(1_500 * sign, 20);
            walk.stay(20);
            assert!(walk.master.has(FOLLOWS), "{what}");
            assert!(!walk.master.has(INTERNAL_LIMIT), "{what}");
            let behind = i32::try_from(walk.position()).unwrap() - walk.at;
            walk.master.shown.clear();
            // 20,000 steps/s on 1,000,000 steps/s² are 200 steps; the switch is debounced for 3 ms, and some are under way.
            walk.go(3_000 * sign, 20);
            let rest = walk.position();
            assert!((2_050..2_450).contains(&rest.abs()), "{what}: {rest}");
            assert!(walk.master.has(INTERNAL_LIMIT), "{what}");
            assert!(!walk.master.has(FOLLOWS), "{what}: 60FFh is ignored");
            walk.go(3_500 * sign, 20);
            walk.stay(10);
            assert_eq!(walk.position(), rest, "{what}: farther in");
            // Back: at the switch the set-points come by at 20 a period.
            walk.go(1_000 * sign, 20);
            walk.stay(300);
            let change = hardest(&walk.master.shown);
            assert!(change <= 3, "{what}: {change} in one period");
            if mode != 9 {
                assert_eq!(walk.position(), i64::from(walk.at + behind), "{what}");
            }
            assert!(walk.position().abs() < 2_000, "{what}");
            assert!(walk.master.has(FOLLOWS), "{what}");
            assert!(!walk.master.has(INTERNAL_LIMIT), "{what}");
            walk.at = i32::try_from(walk.position()).unwrap();
        }
        assert!(OPERATION_ENABLED.is_shown_by(walk.master.drive.statusword()));
    }
}

#[test]
fn m44_a_software_limit_is_left_on_the_ramp_and_set_points_beyond_it_are_ignored() {
    for (mode, sign) in [(7, 1), (8, 1), (8, -1)] {
        let what = format!("mode {mode}, {sign}");
        let mut walk = Walk::between_limits(mode);
        for _ in 0..2 {
            walk.master.shown.clear();
            walk.go(2_000 * sign, 20);
            walk.stay(100);
            assert_eq!(walk.position(), i64::from(1_000 * sign), "{what}");
            assert!(walk.master.has(INTERNAL_LIMIT), "{what}");
            assert!(!walk.master.has(FOLLOWS), "{what}");
            walk.go(1_100 * sign, 20);
            assert_eq!(walk.position(), i64::from(1_000 * sign), "{what}");
            walk.go(-500 * sign, 20);
            walk.stay(500);
            assert_eq!(walk.position(), i64::from(-500 * sign), "{what}");
            assert!(walk.master.has(FOLLOWS), "{what}");
            assert!(!walk.master.has(INTERNAL_LIMIT), "{what}");
            let change = hardest(&walk.master.shown);
            assert!(change <= 3, "{what}: {change} in one period");
            let beyond = walk.master.shown.iter().filter(|at| at.abs() > 1_000);
            assert_eq!(beyond.count(), 0, "{what}");
        }
        // All at once: not in one period.
        walk.go(2_000 * sign, 20);
        walk.stay(100);
        walk.master.shown.clear();
        walk.step(900 * sign);
        walk.stay(500);
        assert_eq!(walk.position(), i64::from(900 * sign), "{what}");
        let change = hardest(&walk.master.shown);
        assert!(change <= 3, "{what}: {change} in one period");
    }
}

#[test]
fn m44_cyclic_velocity_does_not_follow_what_a_software_limit_keeps_it_from() {
    let mut walk = Walk::between_limits(9);
    walk.go(1_500, 5);
    assert!(walk.master.has(INTERNAL_LIMIT));
    assert!(!walk.master.has(FOLLOWS));
    let rest = walk.position();
    assert!((990..=1_000).contains(&rest), "{rest}");
    walk.go(1_000, 5);
    assert!(walk.master.has(FOLLOWS) && !walk.master.has(INTERNAL_LIMIT));
    assert!(walk.position() < 600, "{}", walk.position());
    // A velocity that is cut is followed all the same.
    walk.master.drive.write_u32(0x607F, 0, 1_000);
    walk.step(walk.at - 5);
    walk.step(walk.at - 5);
    walk.step(walk.at - 5);
    assert!(walk.master.has(FOLLOWS | INTERNAL_LIMIT));
}

/// Records that lead to a position, and keep it for a while, then none.
fn records_run_out(mut walk: Walk, target: i32) -> Walk {
    walk.go(target, 20);
    walk.stay(300);
    for _ in 0..300 {
        walk.master.sync(0);
    }
    assert!(OPERATION_ENABLED.is_shown_by(walk.master.drive.statusword()));
    assert_eq!(walk.master.drive.read_u16(0x60C4, 4), 0, "none waits");
    walk
}

#[test]
fn m36_interpolation_that_a_limit_ends_does_not_reach_its_last_record() {
    // A software limit.
    let mut walk = records_run_out(Walk::between_limits(7), 2_000);
    assert_eq!(walk.position(), 1_000);
    assert!(!walk.master.has(TARGET_REACHED));
    assert!(walk.master.has(INTERNAL_LIMIT));
    // The same drive gets to the next one.
    let mut walk = records_run_out(walk, 500);
    assert_eq!(walk.position(), 500);
    assert!(walk.master.has(TARGET_REACHED | FOLLOWS));
    // It is told as long as it stands there, bit 4 or not.
    walk.master.drive.command(0x0F);
    for _ in 0..20 {
        walk.master.sync(0);
    }
    assert!(walk.master.has(TARGET_REACHED));
    walk.step(600);
    assert!(!walk.master.has(TARGET_REACHED), "one waits");
    walk.master.drive.command(0x1F);
    while walk.position() != 600 {
        walk.master.sync(0);
        assert!(walk.position() == 600 || !walk.master.has(TARGET_REACHED));
    }
    for _ in 0..10 {
        walk.master.sync(0);
    }
    assert!(walk.master.has(TARGET_REACHED));
    // A limit switch.
    let mut walk = records_run_out(Walk::between_switches(7), 3_500);
    assert!(walk.position() < 2_450);
    assert!(!walk.master.has(TARGET_REACHED));
}

#[test]
fn m36_interpolation_that_was_stopped_on_the_way_does_not_reach_its_last_record() {
    // Too few records, and 2051h:2 = 0.
    let mut drive = DriveBench::started(4);
    drive.write_u8(0x2051, 2, 0);
    let mut walk = Walk::begin(drive, 7);
    walk.steps((1..=100).map(|k| k * 20));
    for _ in 0..300 {
        walk.master.sync(0);
    }
    assert!(OPERATION_ENABLED.is_shown_by(walk.master.drive.statusword()));
    assert!(walk.position() > 2_000, "it has gone on, and stopped");
    assert!(!walk.master.has(TARGET_REACHED));
    // Bit 4 falls before the motor is there.
    let mut walk = Walk::between_limits(7);
    walk.steps((1..=40).map(|k| k * 20));
    walk.master.drive.command(0x0F);
    for _ in 0..300 {
        walk.master.sync(0);
    }
    assert_ne!(walk.position(), 800);
    assert!(!walk.master.has(TARGET_REACHED));
}

#[test]
fn m60_a_following_error_in_cyclic_modes_stops_as_605eh_says() {
    // 20,000 steps/s on 100,000 and on 1,000,000 steps/s².
    for (mode, code, ramp) in [
        (7, 0, 0),
        (7, 1, 2_000),
        (8, 0, 0),
        (8, 1, 2_000),
        (8, 2, 200),
        (8, 3, 200),
    ] {
        let what = format!("mode {mode}, 605Eh = {code}");
        let mut drive = DriveBench::started(4);
        drive.write_u32(0x6065, 0, 5);
        drive.write_u16(0x6066, 0, 20);
        drive.write_i16(0x605E, 0, code);
        let mut walk = Walk::begin(drive, mode);
        walk.steps((1..=50).map(|k| k * 20));
        assert!(!walk.master.has(FOLLOWING_ERROR), "{what}");
        walk.master.drive.axis().plant_mut().displace(-10);
        let reacts = |walk: &mut Walk| {
            let statusword = walk.master.drive.statusword();
            FAULT.is_shown_by(statusword) || FAULT_REACTION_ACTIVE.is_shown_by(statusword)
        };
        let begin = walk.at;
        while !reacts(&mut walk) {
            walk.step(walk.at + 20);
            assert!(walk.at - begin < 1_000, "{what}: no fault");
        }
        assert!(walk.at - begin >= 20 * 20, "{what}: 6066h");
        assert!(walk.master.has(FOLLOWING_ERROR), "{what}");
        let begin = walk.position();
        for _ in 0..300 {
            walk.step(walk.at + 20);
        }
        let distance = walk.position() - begin;
        assert!(
            (ramp - 50..=ramp + 50).contains(&distance),
            "{what}: {distance}"
        );
        assert!(FAULT.is_shown_by(walk.master.drive.statusword()), "{what}");
        assert!(walk.master.has(FOLLOWING_ERROR), "{what}");
        assert_eq!(walk.master.drive.read_u16(0x603F, 0), 0x8611, "{what}");
        for controlword in [0x00, 0x80] {
            walk.master.controlword = controlword;
            walk.master.drive.command(controlword);
            walk.master.drive.run_millis(5);
        }
        walk.master.drive.reaches(SWITCH_ON_DISABLED, 10);
        assert!(!walk.master.has(FOLLOWING_ERROR), "{what}");
    }
}

#[test]
fn m44_a_stop_out_of_cyclic_position_ends_before_the_software_limit() {
    type Stops = fn(&mut Master);
    let stops: [(&str, Stops); 4] = [
        ("halt", |master| master.controlword = 0x010F),
        ("disable operation", |master| master.controlword = 0x0007),
        ("605Ah = 1", |master| master.controlword = 0x0002),
        ("another mode", |master| {
            let mode = [0x2F, 0x60, 0x60, 0, 1, 0, 0, 0];
            master.drive.send_frame(Frame::data_frame(0x604, &mode));
        }),
    ];
    for (what, stops) in stops {
        let mut master = Master::new(8, 1_000);
        master.drive.write_i32(0x607D, 1, -10_000);
        master.drive.write_i32(0x607D, 2, 10_000);
        master.drive.write_i16(0x605A, 0, 1);
        master.steps([0; 100]);
        // 20,000 increments/s: 2,000 to rest on 6084h, 200 on 6085h.
        master.steps((1..=480).map(|k| k * 20));
        assert!(!master.has(INTERNAL_LIMIT));
        stops(&mut master);
        master.steps((481..=490).map(|k| k * 20));
        assert!(master.has(INTERNAL_LIMIT), "{what}: another ramp");
        master.steps([9_800; 300]);
        let rest = master.drive.position();
        assert!((9_500..=10_000).contains(&rest), "{what}: {rest}");
        assert!(!master.has(INTERNAL_LIMIT), "{what}: it stands");
    }
}

/// Set-points on a ramp of so many increments/s² to so many increments/s and back to rest, in whole units of so many increments.
fn ramp(cycle: u64, acceleration: f64, velocity: f64, unit: i32) -> Vec<i32> {
    let seconds = cycle as f64 / 1e6;
    let (mut at, mut now) = (0.0, 0.0);
    let mut set_points = Vec::new();
    let up = (velocity / acceleration / seconds).ceil();
    for k in 0..(3.0 * up) as u32 {
        let next: f64 = match f64::from(k) {
            k if k < up => (now + acceleration * seconds).min(velocity),
            k if k < 2.0 * up => now,
            _ => (now - acceleration * seconds).max(0.0),
        };
        at += (now + next) / 2.0 * seconds;
        now = next;
        set_points.push((at / f64::from(unit)).round() as i32);
    }
    set_points
}

#[test]
fn m39_set_points_within_60c5h_and_60c6h_are_followed_exactly() {
    // Whole increments change the distance of a millisecond by many times what 60C5h allows.
    for (cycle, acceleration, velocity, unit) in [
        (1_000, 2_000.0, 300.0, 1),
        (1_000, 100_000.0, 20_000.0, 1),
        (1_000, 100_000.0, 20_000.0, 17),
        (2_000, 1_000_000.0, 50_000.0, 1),
        (10_000, 20_000.0, 5_000.0, 3),
    ] {
        let mut drive = DriveBench::started(4);
        // A unit is so many increments.
        drive.write_u32(0x6091, 1, u32::try_from(unit).unwrap());
        let limit = acceleration as u32 / u32::try_from(unit).unwrap() + 1;
        drive.write_u32(0x60C5, 0, limit);
        drive.write_u32(0x60C6, 0, limit);
        let mut master = Master::of(drive, 8, cycle);
        master.steps([0; 100]);
        assert!(master.has(FOLLOWS));
        for target in ramp(cycle, acceleration, velocity, unit) {
            master.steps([target]);
            let bits = master.drive.statusword() & (FOLLOWS | INTERNAL_LIMIT);
            assert_eq!(bits, FOLLOWS, "{cycle} us, {acceleration}, {unit}");
        }
    }
}

#[test]
fn m39_60c5h_and_60c6h_bound_what_cyclic_set_points_ask_for() {
    for (mode, hardness) in [(8, 5.0), (8, 50.0), (7, 5.0)] {
        let mut drive = DriveBench::started(4);
        for index in [0x60C5, 0x60C6, 0x6083, 0x6084] {
            drive.write_u32(index, 0, 200_000);
        }
        let mut walk = Walk {
            master: Master::of(drive, mode, 10_000),
            mode,
            at: 0,
        };
        if mode == 7 {
            walk.master.drive.command(0x1F);
        }
        walk.steps([0; 50]);
        assert!(walk.master.has(FOLLOWS), "mode {mode}");
        walk.master.drive.record_motion();
        let mut is_limited = false;
        for target in ramp(10_000, 200_000.0 * hardness, 40_000.0, 1) {
            walk.step(target);
            is_limited |= walk.master.has(INTERNAL_LIMIT) && !walk.master.has(FOLLOWS);
        }
        assert!(is_limited, "mode {mode}, {hardness}");
        walk.stay(200);
        assert_eq!(walk.position(), i64::from(walk.at), "mode {mode}");
        assert!(walk.master.has(FOLLOWS) && !walk.master.has(INTERNAL_LIMIT));
        let hardest = walk.master.drive.greatest_acceleration();
        assert!(hardest <= 220_000, "mode {mode}, {hardness}: {hardest}");
    }
}

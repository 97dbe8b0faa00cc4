//! Motion tasks of the S200: kept in flash and in RAM, started, chained, blended and stopped.

use canopen::Frame;

use crate::bench::Bench;
use crate::steer::{NODE, command, enabled, number, position, statusword, way};

/// O_C: relative, another one follows, without a stop, behind a delay.
const RELATIVE: u32 = 1;
const NEXT: u32 = 8;
const BLENDED: u32 = 16;
const DELAYED: u32 = 64;

/// A task: target, speed, O_C, the next one.
type Task = (i32, u32, u32, u32);

/// Writes task 0 and copies it there.
fn store(bench: &mut Bench, place: u32, task: Task) {
    write_task(bench, task);
    number(bench, 0x2082, 0, place << 16);
}

fn write_task(bench: &mut Bench, (target, speed, control, next): Task) {
    number(bench, 0x35BE, 1, target as u32);
    number(bench, 0x35BF, 1, speed);
    number(bench, 0x35B9, 1, control);
    number(bench, 0x35BC, 1, next);
}

/// A drive with these tasks, homed where it stands, with its motor on in mode 1.
fn homed(tasks: &[(u32, Task)]) -> Bench {
    let mut bench = Bench::node("s200", NODE);
    for (place, task) in tasks {
        store(&mut bench, *place, *task);
    }
    bench.write(NODE, 0x6060, 0, &[1]);
    bench.enable(NODE);
    number(&mut bench, 0x35F0, 1, 1);
    bench.run(100);
    assert_eq!(
        bench.read(NODE, 0x1002, 0) & 2,
        2,
        "SETREF has set a reference"
    );
    bench
}

/// 2080h and an edge of bits 4 and 5.
fn start(bench: &mut Bench, task: u16) {
    command(bench, 0x0F);
    bench.write(NODE, 0x2080, 0, &task.to_le_bytes());
    command(bench, 0x3F);
    bench.run(20);
}

fn running(bench: &mut Bench) -> u16 {
    bench.read(NODE, 0x2081, 0) as u16
}

fn refused(bench: &mut Bench, index: u16, sub: u8, value: u32) -> u32 {
    let [low, high] = index.to_le_bytes();
    let [a, b, c, d] = value.to_le_bytes();
    let answer = bench.sdo(NODE, [0x23, low, high, sub, a, b, c, d]);
    assert_eq!(answer[0], 0x80, "{index:04X}h:{sub} takes {value}");
    u32::from_le_bytes([answer[4], answer[5], answer[6], answer[7]])
}

/// 2080h starts a task in flash and one in RAM, falls back to 0, and 2081h tells which one was started.
#[test]
fn an_edge_starts_a_stored_motion_task() {
    let flash = (20_000, 100_000, 0, 0);
    let mut bench = homed(&[(7, flash), (300, (-3_000, 100_000, RELATIVE, 0))]);
    start(&mut bench, 7);
    assert_eq!(
        (bench.read(NODE, 0x2080, 0) as u16, running(&mut bench)),
        (0, 7)
    );
    bench.run(2_000);
    assert_eq!(position(&mut bench), 20_000);
    assert_eq!(bench.read(NODE, 0x3654, 1), 20_000, "PTARGET");
    start(&mut bench, 300);
    assert_eq!(running(&mut bench), 300);
    bench.run(2_000);
    assert_eq!(position(&mut bench), 17_000);
    // Without a number the last one is repeated, and a direct set-point is task 0.
    command(&mut bench, 0x0F);
    command(&mut bench, 0x3F);
    bench.run(2_000);
    assert_eq!((position(&mut bench), running(&mut bench)), (14_000, 300));
    number(&mut bench, 0x607A, 0, 1_000);
    number(&mut bench, 0x6081, 0, 100_000);
    command(&mut bench, 0x0F);
    command(&mut bench, 0x3F);
    bench.run(2_000);
    assert_eq!((position(&mut bench), running(&mut bench)), (1_000, 0));
}

/// Speed, acceleration time and braking time are the task's: OVRIDE slows it down, and PTMIN is the shortest ramp.
#[test]
fn a_motion_task_has_its_own_speed_and_ramps() {
    let mut bench = Bench::node("s200", NODE);
    number(&mut bench, 0x35B7, 1, 1_000);
    number(&mut bench, 0x35BA, 1, 500);
    store(&mut bench, 1, (400_000, 50_000, RELATIVE, 0));
    number(&mut bench, 0x35B7, 1, 1);
    store(&mut bench, 2, (400_000, 50_000, RELATIVE, 0));
    bench.write(NODE, 0x6060, 0, &[1]);
    bench.enable(NODE);
    start(&mut bench, 1);
    bench.run(980);
    // In a second it gains 50,000 counts/s, 25,000 counts on.
    assert!((24_000..27_000).contains(&position(&mut bench)));
    let fast = way(&mut bench, 1_000);
    assert!((49_000..51_000).contains(&fast), "{fast}");
    bench.run(10_000);
    number(&mut bench, 0x35B6, 1, 50);
    start(&mut bench, 1);
    bench.run(1_000);
    let slow = way(&mut bench, 1_000);
    assert!((24_500..25_500).contains(&slow), "{slow}");
    bench.run(20_000);
    number(&mut bench, 0x35B6, 1, 100);
    number(&mut bench, 0x35D6, 1, 1_000);
    start(&mut bench, 2);
    let first = way(&mut bench, 980);
    assert!((22_000..27_000).contains(&first), "PTMIN: {first}");
}

/// A task leads to the next one: at once, behind a delay, or without a stop; 2081h follows.
#[test]
fn motion_tasks_follow_each_other() {
    let mut bench = Bench::node("s200", NODE);
    number(&mut bench, 0x35BD, 1, 500);
    let mut bench = {
        store(&mut bench, 1, (10_000, 100_000, RELATIVE | NEXT, 2));
        store(
            &mut bench,
            2,
            (10_000, 100_000, RELATIVE | NEXT | DELAYED, 201),
        );
        store(&mut bench, 201, (-5_000, 100_000, RELATIVE, 0));
        bench.write(NODE, 0x6060, 0, &[1]);
        bench.enable(NODE);
        bench
    };
    start(&mut bench, 1);
    let mut seen = vec![];
    let mut rested = 0;
    for _ in 0..300 {
        bench.run(10);
        let task = running(&mut bench);
        if seen.last() != Some(&task) {
            seen.push(task);
        }
        rested += u32::from(position(&mut bench) == 20_000 && task == 2);
    }
    assert_eq!(seen, [1, 2, 201]);
    // A look at 2081h and 6064h takes time as well.
    assert!((38..=52).contains(&rested), "a delay of 500 ms: {rested}");
    assert_eq!(position(&mut bench), 15_000);
}

/// Without a stop the motor goes through the first target with its speed.
#[test]
fn a_blended_motion_task_does_not_stop() {
    for (control, stops) in [(RELATIVE | NEXT | BLENDED, false), (RELATIVE | NEXT, true)] {
        let mut bench = Bench::node("s200", NODE);
        store(&mut bench, 1, (50_000, 50_000, control, 2));
        store(&mut bench, 2, (50_000, 50_000, RELATIVE, 0));
        bench.write(NODE, 0x6060, 0, &[1]);
        bench.enable(NODE);
        start(&mut bench, 1);
        let mut slowest = i32::MAX;
        let mut tasks = vec![];
        while position(&mut bench) < 90_000 {
            let moved = way(&mut bench, 10);
            if (20_000..80_000).contains(&position(&mut bench)) {
                slowest = slowest.min(moved);
            }
            tasks.push(running(&mut bench));
        }
        assert_eq!(slowest < 400, stops, "{slowest} counts in 10 ms");
        tasks.dedup();
        assert_eq!(tasks, [1, 2]);
        bench.run(2_000);
        assert_eq!(position(&mut bench), 100_000);
    }
}

/// A task that leads to itself repeats until STOP, quick stop or another set-point ends it.
#[test]
fn a_motion_task_repeats_until_it_is_stopped() {
    let mut bench = Bench::node("s200", NODE);
    store(&mut bench, 5, (2_000, 100_000, RELATIVE | NEXT, 5));
    bench.write(NODE, 0x6060, 0, &[1]);
    bench.enable(NODE);
    number(&mut bench, 0x3642, 1, 5);
    bench.run(2_000);
    assert!(position(&mut bench) > 10_000);
    number(&mut bench, 0x35FE, 1, 1);
    bench.run(500);
    let stood = position(&mut bench);
    bench.run(1_000);
    assert_eq!(position(&mut bench), stood, "STOP");
    assert_eq!(statusword(&mut bench) & 0x6F, 0x27, "the motor is on");
    number(&mut bench, 0x3642, 1, 5);
    bench.run(1_000);
    assert!(position(&mut bench) > stood + 2_000);
    command(&mut bench, 0x0B);
    bench.run(500);
    let stood = position(&mut bench);
    bench.run(500);
    command(&mut bench, 0x0F);
    bench.enable(NODE);
    bench.run(1_000);
    assert_eq!(position(&mut bench), stood, "quick stop cancels the task");
}

/// MOVE starts a task whatever the mode is, and mode 88h is one of its own.
#[test]
fn the_motion_task_mode_carries_tasks_out() {
    let mut bench = Bench::node("s200", NODE);
    store(&mut bench, 9, (6_000, 100_000, RELATIVE, 0));
    bench.write(NODE, 0x6060, 0, &[0x88]);
    bench.enable(NODE);
    bench.run(20);
    assert_eq!(bench.read(NODE, 0x6061, 0) as u8, 0x88);
    assert_eq!(bench.read(NODE, 0x35B4, 1), 8, "OPMODE");
    number(&mut bench, 0x3642, 1, 9);
    bench.run(1_000);
    assert_eq!((position(&mut bench), running(&mut bench)), (6_000, 9));
    start(&mut bench, 9);
    bench.run(1_000);
    assert_eq!(position(&mut bench), 12_000);
}

/// NREFMT: homing leads to a task. MTMUX says which one the next edge starts.
#[test]
fn homing_leads_to_a_motion_task() {
    let mut bench = Bench::node("s200", NODE);
    store(&mut bench, 4, (8_000, 100_000, 0, 0));
    number(&mut bench, 0x36D2, 1, 4);
    bench.write(NODE, 0x6098, 0, &[35]);
    bench.write(NODE, 0x6060, 0, &[6]);
    bench.enable(NODE);
    bench.run(20);
    command(&mut bench, 0x1F);
    bench.run(1_500);
    assert_eq!((position(&mut bench), running(&mut bench)), (8_000, 4));
    number(&mut bench, 0x36D2, 1, 0);
    command(&mut bench, 0x0F);
    bench.write(NODE, 0x6060, 0, &[1]);
    bench.run(20);
    number(&mut bench, 0x607A, 0, 0);
    number(&mut bench, 0x365B, 1, 4);
    assert_eq!(bench.read(NODE, 0x2080, 0) as u16, 4);
    command(&mut bench, 0x3F);
    bench.run(20);
    assert_eq!(running(&mut bench), 4);
}

/// A number without a task is emergency 8681h and n08, an absolute one without a reference n09; neither moves.
#[test]
fn a_faulty_motion_task_is_told() {
    let mut bench = Bench::node("s200", NODE);
    store(&mut bench, 2, (9_000, 100_000, 0, 0));
    bench.write(NODE, 0x6060, 0, &[1]);
    bench.enable(NODE);
    bench.write(NODE, 0x2080, 0, &[150, 0]);
    bench.send(&Frame::full(0x604, [0x2B, 0x40, 0x60, 0, 0x3F, 0, 0, 0]));
    let message = bench.next(0x84, 100).expect("an emergency message");
    assert_eq!(message.payload()[..4], [0x81, 0x86, 0x81, 5]);
    bench.run(2);
    assert_eq!(bench.read(NODE, 0x2000, 0) & 0x180, 0x80);
    start(&mut bench, 2);
    assert_eq!(bench.read(NODE, 0x2000, 0) & 0x180, 0x100);
    assert_eq!(bench.read(NODE, 0x38F7, 1), 9, "WarningCode");
    bench.run(500);
    assert_eq!(position(&mut bench), 0);
    let limits = [(0x2082, 0x012D_0000), (0x3642, 301), (0x35BC, 301)];
    for (index, value) in limits {
        let sub = u8::from(index != 0x2082);
        assert_eq!(refused(&mut bench, index, sub, value), 0x0609_0030);
    }
}

/// A task is read back by copying it to task 0, from one place to another too; 200 lie in flash and 100 in RAM.
#[test]
fn motion_tasks_are_copied_and_read_back() {
    let mut bench = Bench::node("s200", NODE);
    for place in [1, 8, 9, 200, 201, 300] {
        let task = (-(place as i32), 1_000 + place, RELATIVE | NEXT, place - 1);
        store(&mut bench, place, task);
    }
    number(&mut bench, 0x2082, 0, 100 << 16 | 300);
    write_task(&mut bench, (0, 0, 0, 0));
    for (place, own) in [
        (1, 1),
        (8, 8),
        (9, 9),
        (200, 200),
        (201, 201),
        (300, 300),
        (100, 300),
    ] {
        number(&mut bench, 0x2082, 0, place);
        let values = [0x35BE, 0x35BF, 0x35B9, 0x35BC].map(|index| bench.read(NODE, index, 1));
        assert_eq!(
            values,
            [-(own as i32) as u32, 1_000 + own, 9, own - 1],
            "{place}"
        );
    }
    // Flash only without power; RAM always.
    bench.enable(NODE);
    assert_eq!(refused(&mut bench, 0x2082, 0, 5 << 16 | 300), 0x0800_0022);
    number(&mut bench, 0x2082, 0, 250 << 16 | 300);
}

/// Tasks 1 to 200 outlive power once they are saved, 201 to 300 do not.
#[test]
fn motion_tasks_in_flash_outlive_power() {
    let mut bench = Bench::node("s200", NODE);
    for place in [1, 200, 201] {
        store(&mut bench, place, (1_234, 5_000 + place, RELATIVE, 0));
    }
    write_task(&mut bench, (0, 0, 0, 0));
    bench.write(NODE, 0x1010, 1, b"save");
    bench.drive.power_cycle();
    bench.run(200);
    for (place, speed) in [(1, 5_001), (200, 5_200), (201, 0)] {
        number(&mut bench, 0x2082, 0, place);
        assert_eq!(bench.read(NODE, 0x35BF, 1), speed, "task {place}");
    }
}

fn has_task(bench: &mut Bench, place: u32) -> bool {
    number(bench, 0x2082, 0, place);
    bench.read(NODE, 0x35BF, 1) != 0
}

/// 4000h:2 deletes one task, 4000h:3 all, 2083h those in flash, with "prom", without power and before NMT operational.
#[test]
fn motion_tasks_are_deleted() {
    let mut bench = Bench::node("s200", NODE);
    let fill = |bench: &mut Bench| {
        for place in [10, 11, 210] {
            store(bench, place, (1, 1_000, RELATIVE, 0));
        }
    };
    let which = |bench: &mut Bench| [10, 11, 210].map(|place| has_task(bench, place));
    fill(&mut bench);
    bench.write(NODE, 0x4000, 2, &[10]);
    assert_eq!(which(&mut bench), [false, true, true]);
    fill(&mut bench);
    bench.write(NODE, 0x4000, 3, &[1]);
    assert_eq!(which(&mut bench), [false; 3]);
    fill(&mut bench);
    assert_eq!(refused(&mut bench, 0x2083, 0, 1), 0x0609_0030);
    bench.send(&Frame::data_frame(0, &[1, NODE]));
    let prom = u32::from_le_bytes(*b"prom");
    assert_eq!(
        refused(&mut bench, 0x2083, 0, prom),
        0x0800_0022,
        "operational"
    );
    bench.send(&Frame::data_frame(0, &[128, NODE]));
    bench.run(10);
    bench.enable(NODE);
    assert_eq!(refused(&mut bench, 0x2083, 0, prom), 0x0800_0022, "power");
    command(&mut bench, 0);
    bench.run(50);
    bench.write(NODE, 0x2083, 0, b"prom");
    assert_eq!(which(&mut bench), [false, false, true]);
}

/// A relative set-point counts from the last target, or with bit 1 of O_C from where the motor is.
#[test]
fn a_relative_set_point_counts_from_what_o_c_says() {
    for control in [0, 2] {
        let mut bench = enabled("s200", 1);
        number(&mut bench, 0x35B9, 1, control);
        number(&mut bench, 0x6081, 0, 50_000);
        number(&mut bench, 0x607A, 0, 20_000);
        command(&mut bench, 0x1F);
        bench.run(200);
        command(&mut bench, 0x0F);
        number(&mut bench, 0x607A, 0, 600);
        let here = position(&mut bench);
        command(&mut bench, 0x7F);
        bench.run(2_000);
        let expected = if control == 0 { 20_600 } else { here + 600 };
        let stands = position(&mut bench);
        assert!(
            stands.abs_diff(expected) <= 100,
            "O_C = {control}: {stands} from {here}"
        );
    }
}

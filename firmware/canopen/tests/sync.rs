//! SYNC and TIME as services of a node: Y01 to Y09 and T01 of the listed cases.

use crate::device::{Device, Sent, abort, frame};
use canopen::Duration;
use canopen::cia301::time_stamp::TimeOfDay;

fn write_u32(device: &mut Device, index: u16, value: u32) -> Vec<String> {
    let [low, high] = index.to_le_bytes();
    let bytes = value.to_le_bytes().map(|byte| format!("{byte:02X}"));
    device.ask(&format!("604#23{low:02X}{high:02X}00{}", bytes.concat()))
}

fn period(device: &mut Device, microseconds: u32) {
    assert_eq!(
        write_u32(device, 0x1006, microseconds).last(),
        Some(&"584#6006100000000000".to_string())
    );
}

fn counter(device: &mut Device, overflow: u8) -> Vec<String> {
    device.ask(&format!("604#2F191000{overflow:02X}000000"))
}

/// Sends SYNC every 10 ms.
fn produce(device: &mut Device) {
    period(device, 10_000);
    assert_eq!(
        write_u32(device, 0x1005, 0x4000_0080),
        ["584#6005100000000000"]
    );
}

fn syncs(times: &[u64]) -> Vec<Sent> {
    times.iter().map(|time| (*time, "080#".into())).collect()
}

#[test]
fn y01_the_producer_sends_every_period() {
    let mut device = Device::new();
    produce(&mut device);
    assert_eq!(device.pass(35), syncs(&[10, 20, 30]));
}

#[test]
fn y01_a_producer_that_is_called_late_keeps_its_rhythm() {
    let mut device = Device::new();
    produce(&mut device);
    device.now += Duration::from_ticks(13_000);
    assert_eq!(device.pass(10), syncs(&[0, 7]));
    device.now += Duration::from_ticks(100_000);
    assert_eq!(
        device.pass(15),
        syncs(&[0, 10]),
        "what was missed is left out"
    );
}

#[test]
fn y01_its_own_pdos_follow_its_sync() {
    let mut device = Device::new();
    device.ask("604#23001801840100C0");
    device.ask("604#2F00180201000000");
    device.ask("604#2300180184010040");
    produce(&mut device);
    device.send("000#0104");
    device.set_value(0x2005, 0, &[7, 0, 0, 0]);
    assert_eq!(
        device.pass(10),
        [
            (10, "080#".to_string()),
            (10, "184#0700000000000000".to_string())
        ]
    );
}

#[test]
fn y01_objects_written_within_a_period_do_not_move_the_next_sync() {
    let mut device = Device::new();
    period(&mut device, 200_000);
    write_u32(&mut device, 0x1005, 0x4000_0080);
    let mut sent = Vec::new();
    for (begun, index, value) in [
        (0, 0x1007, 0),
        (150, 0x1007, 50_000),
        (300, 0x1006, 200_000),
        (450, 0x1005, 0x4000_0080),
        (600, 0x1007, 0),
    ] {
        let frames = device.pass(150).into_iter();
        sent.extend(frames.map(|(moment, frame)| (begun + moment, frame)));
        write_u32(&mut device, index, value);
    }
    assert_eq!(sent, syncs(&[200, 400, 600]));
    period(&mut device, 100_000);
    assert_eq!(device.pass(100), syncs(&[100]), "a new period begins now");
}

/// TPDO 1 goes with every SYNC; `identifier` is that of SYNC, which the device produces every 10 ms.
fn produce_with_pdo(identifier: u32) -> Device {
    let mut device = Device::new();
    device.ask("604#23001801840100C0");
    device.ask("604#2F00180201000000");
    device.ask("604#2300180184010040");
    period(&mut device, 10_000);
    write_u32(&mut device, 0x1005, identifier);
    write_u32(&mut device, 0x1005, identifier | 0x4000_0000);
    device.send("000#0104");
    device
}

#[test]
fn y01_no_pdo_of_a_cycle_leaves_before_a_sync_of_lower_priority() {
    let mut device = produce_with_pdo(0x200);
    for cycle in 0..3 {
        device.set_value(0x2005, 0, &[cycle, 0, 0, 0]);
        device.now += Duration::from_ticks(10_000);
        device.poll();
        assert_eq!(
            device.sent(),
            ["200#".to_string(), format!("184#{cycle:02X}00000000000000")]
        );
    }
}

#[test]
fn y01_a_pdo_does_not_wait_for_a_sync_that_will_not_leave() {
    let mut device = produce_with_pdo(0x200);
    device.now += Duration::from_ticks(10_000);
    device.poll();
    device.put("604#2305100000020000");
    assert_eq!(
        device.sent(),
        ["184#0000000000000000", "584#6005100000000000"]
    );
}

#[test]
fn y01_other_frames_do_not_wait_for_sync() {
    let mut device = produce_with_pdo(0x6DF);
    device.now += Duration::from_ticks(10_000);
    device.put("604#4000100000000000");
    device.poll();
    assert_eq!(
        device.sent(),
        ["584#4300100092010200", "6DF#", "184#0000000000000000"]
    );
}

#[test]
fn y01_without_bit_30_or_a_period_nothing_is_sent() {
    let mut device = Device::new();
    produce(&mut device);
    assert_eq!(write_u32(&mut device, 0x1005, 0x80).len(), 1);
    assert!(device.pass(100).is_empty());
    write_u32(&mut device, 0x1005, 0x4000_0080);
    period(&mut device, 0);
    assert!(device.pass(100).is_empty());
}

#[test]
fn y01_a_sync_that_waits_is_not_sent_after_the_end_of_production() {
    let mut device = Device::new();
    produce(&mut device);
    device.now += Duration::from_ticks(10_000);
    device.poll();
    device.put("604#2305100080000000");
    assert_eq!(device.sent(), ["584#6005100000000000"]);
}

#[test]
fn y02_the_counter_runs_from_1_to_1019h() {
    let mut device = Device::new();
    counter(&mut device, 5);
    produce(&mut device);
    let sent: Vec<String> = device
        .pass(70)
        .into_iter()
        .map(|(_, frame)| frame)
        .collect();
    assert_eq!(
        sent,
        [
            "080#01", "080#02", "080#03", "080#04", "080#05", "080#01", "080#02"
        ]
    );
    device.send("000#0204");
    device.send("000#8004");
    assert_eq!(
        device.pass(10),
        [(10, "080#01".to_string())],
        "anew after Stopped"
    );
}

#[test]
fn y03_1019h_is_0_or_2_to_240() {
    let mut device = Device::new();
    for value in [1, 241, 255] {
        assert_eq!(counter(&mut device, value), [abort(0x1019, 0, 0x0609_0030)]);
    }
    for value in [2, 240, 0] {
        assert_eq!(counter(&mut device, value), ["584#6019100000000000"]);
    }
}

#[test]
fn y04_1019h_stays_while_1006h_is_not_0() {
    let mut device = Device::new();
    period(&mut device, 1);
    for value in [0, 1, 5] {
        assert_eq!(counter(&mut device, value), [abort(0x1019, 0, 0x0800_0022)]);
    }
}

#[test]
fn y05_the_identifier_stays_while_it_is_produced() {
    let mut device = Device::new();
    produce(&mut device);
    assert_eq!(
        write_u32(&mut device, 0x1005, 0x4000_0090),
        [abort(0x1005, 0, 0x0609_0030)]
    );
    assert_eq!(
        write_u32(&mut device, 0x1005, 0x4000_0080),
        ["584#6005100000000000"],
        "the same value is no change"
    );
    assert_eq!(
        write_u32(&mut device, 0x1005, 0x90),
        [abort(0x1005, 0, 0x0609_0030)],
        "it is the producer until the write has been taken"
    );
    write_u32(&mut device, 0x1005, 0x80);
    write_u32(&mut device, 0x1005, 0x90);
    write_u32(&mut device, 0x1005, 0x4000_0090);
    assert_eq!(device.pass(10), [(10, "090#".to_string())]);
}

#[test]
fn y05_a_second_producer_is_a_collision() {
    let mut device = Device::new();
    produce(&mut device);
    assert_eq!(device.ask("080#"), ["084#5081118000000000"]);
}

#[test]
fn y07_with_a_counter_a_sync_has_one_byte() {
    let mut device = Device::operational();
    device.ask("604#23001801840100C0");
    device.ask("604#2F00180201000000");
    device.ask("604#2300180184010040");
    counter(&mut device, 10);
    assert_eq!(device.ask("080#"), ["084#4082110000000000"]);
    assert_eq!(device.ask("080#0102"), [""; 0]);
    assert_eq!(
        device.ask("080#01"),
        ["084#0000000000000000", "184#0000000000000000"]
    );
    assert_eq!(device.ask("080#00"), [""; 0], "no counter is 0");
    assert_eq!(device.ask("080#F1"), [""; 0], "no counter is above 240");
    assert_eq!(device.ask("080#F0"), ["184#0000000000000000"]);
}

#[test]
fn y08_a_sync_is_missed_after_one_and_a_half_periods() {
    let mut device = Device::new();
    period(&mut device, 1_000_000);
    assert!(device.pass(5_000).is_empty(), "it waits from the first on");
    device.send("080#");
    assert!(device.pass(1_499).is_empty());
    device.send("080#");
    let missed = "084#0081110610000000";
    assert_eq!(device.pass(5_000), [(1_500, missed.to_string())]);
    assert_eq!(device.value(0x1001, 0), [0x11]);
    assert_eq!(device.ask("080#"), ["084#0000000000000000"]);
    assert_eq!(device.pass(5_000), [(1_500, missed.to_string())]);
    assert_eq!(
        write_u32(&mut device, 0x1006, 0),
        ["084#0000000000000000", "584#6006100000000000"],
        "nothing is awaited without a period"
    );
}

#[test]
fn y09_a_stopped_device_neither_sends_nor_misses_it() {
    let mut device = Device::new();
    produce(&mut device);
    device.pass(15);
    device.send("000#0204");
    assert!(device.pass(100).is_empty());
    device.send("000#0104");
    assert_eq!(device.pass(10).last(), Some(&(10, "080#".to_string())));
    device.send("000#8204");
    device.serve_reset();
    assert_eq!(device.pass(100).len(), 1, "the boot-up message alone");

    let mut device = Device::new();
    period(&mut device, 10_000);
    device.send("080#");
    device.send("000#0204");
    device.send("080#01");
    assert!(device.pass(100).is_empty());
    device.send("000#8004");
    assert!(device.pass(100).is_empty(), "it waits from the first on");
}

/// 0102_0304h ms after midnight, 0605h days.
const TIME: &str = "100#040302010506";

fn time() -> Option<TimeOfDay> {
    TimeOfDay::new(0x0605, 0x0102_0304)
}

#[test]
fn t01_a_consumer_takes_the_time_of_day() {
    let mut device = Device::new();
    device.send(TIME);
    assert_eq!(device.node.time_of_day(device.now), None, "bit 31 is 0");
    write_u32(&mut device, 0x1012, 0x8000_0100);
    device.send("100#0403");
    device.send("100#04030201050607");
    device.send("100#R");
    assert_eq!(device.node.time_of_day(device.now), None);
    device.send("000#0204");
    device.send(TIME);
    assert_eq!(device.node.time_of_day(device.now), None, "Stopped");
    device.send("000#8004");
    device.send(TIME);
    assert_eq!(device.node.time_of_day(device.now), time());
    device.pass(10);
    assert_eq!(
        device.node.time_of_day(device.now),
        TimeOfDay::new(0x0605, 0x0102_030E)
    );
}

#[test]
fn t01_a_producer_sends_it_when_it_is_asked_to() {
    let mut device = Device::new();
    device.node.set_time_of_day(time().unwrap(), device.now);
    assert!(!device.node.send_time_of_day(device.now), "bit 30 is 0");
    assert_eq!(
        write_u32(&mut device, 0x1012, 0x4000_0100),
        ["584#6012100000000000"]
    );
    assert!(device.node.send_time_of_day(device.now));
    assert_eq!(device.sent(), [TIME]);
    device.send("000#0204");
    assert!(!device.node.send_time_of_day(device.now));
    assert_eq!(device.sent(), [""; 0]);
}

#[test]
fn t01_the_identifier_moves_while_it_is_not_used() {
    let mut device = Device::new();
    let refused = [abort(0x1012, 0, 0x0609_0030)];
    for value in [0x180, 0x8000_0701, 0xA000_0100, 0x0000_0900] {
        assert_eq!(write_u32(&mut device, 0x1012, value), refused);
    }
    write_u32(&mut device, 0x1012, 0x8000_0100);
    assert_eq!(write_u32(&mut device, 0x1012, 0x8000_0200), refused);
    write_u32(&mut device, 0x1012, 0x0000_0200);
    write_u32(&mut device, 0x1012, 0x8000_0200);
    device.send("200#040302010506");
    assert_eq!(device.node.time_of_day(device.now), time());
}

#[test]
fn p36_the_stamp_of_a_frame_says_whether_it_came_after_the_window() {
    let mut device = Device::new();
    device.ask("604#2300140104020080");
    device.ask("604#2F00140201000000");
    device.ask("604#2300140104020000");
    write_u32(&mut device, 0x1007, 5_000);
    device.send("000#0104");
    device.send("080#");
    // Both are given before the device is called, as every frame that has arrived.
    device.now += Duration::from_ticks(4_999);
    device.put("204#0100000000000000");
    device.now += Duration::from_ticks(1);
    device.put("204#0200000000000000");
    device.send("080#");
    assert_eq!(device.value(0x2003, 0), [1, 0, 0, 0]);
}

#[test]
fn p36_a_synchronous_pdo_does_not_leave_after_the_window_though_frames_wait_to_be_given() {
    let mut device = Device::new();
    device.ask("604#2300140104020080");
    device.ask("604#2F00140201000000");
    device.ask("604#2300140104020000");
    // TPDO 1 at every SYNC, and by an event that waits.
    device.ask("604#2300180184010080");
    device.ask("604#2F00180201000000");
    device.ask("604#2300180184010000");
    write_u32(&mut device, 0x1007, 5_000);
    device.send("000#0104");
    device.send("080#");
    let received = device.now + Duration::from_ticks(4_999);
    device.now += Duration::from_ticks(5_000);
    device.node.drop_late(received);
    assert!(device.node.pending().is_some(), "the window is open");
    device.node.drop_late(device.now);
    assert_eq!(device.node.pending(), None);
    // A frame that arrived within the window is in time whenever it is given.
    device.node.receive(
        &frame("204#0700000000000000"),
        received,
        &mut device.firmware,
    );
    device.send("080#");
    assert_eq!(device.value(0x2003, 0), [7, 0, 0, 0]);
    assert_eq!(device.sent().len(), 1);
}

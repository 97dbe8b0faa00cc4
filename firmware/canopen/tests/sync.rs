//! SYNC and TIME as services of a node: Y01 to Y09 and T01 of the listed cases.

use crate::device::{Device, Sent, abort, frame};
use canopen::Duration;
use canopen::cia301::time_stamp::TimeOfDay;

fn write_u32(device: &mut Device, index: u16, value: u32) -> Vec<String> {
    let [low, high] = index.to_le_bytes();
    let bytes = value.to_le_bytes().map(|byte| format!("{byte:02X}"));
    device.ask(&format!(
        "604: 23 {low:02X} {high:02X} 00 {}",
        bytes.concat()
    ))
}

fn period(device: &mut Device, microseconds: u32) {
    assert_eq!(
        write_u32(device, 0x1006, microseconds).last(),
        Some(&"584: 60 06 10 00 00 00 00 00".to_string())
    );
}

fn counter(device: &mut Device, overflow: u8) -> Vec<String> {
    device.ask(&format!("604: 2F 19 10 00 {overflow:02X} 00 00 00"))
}

/// Sends SYNC every 10 ms.
fn produce(device: &mut Device) {
    period(device, 10_000);
    assert_eq!(
        write_u32(device, 0x1005, 0x4000_0080),
        ["584: 60 05 10 00 00 00 00 00"]
    );
}

fn syncs(times: &[u64]) -> Vec<Sent> {
    times.iter().map(|time| (*time, "080 [0]".into())).collect()
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
    device.ask("604: 23 00 18 01 84 01 00 C0");
    device.ask("604: 2F 00 18 02 01 00 00 00");
    device.ask("604: 23 00 18 01 84 01 00 40");
    produce(&mut device);
    device.send("000 [2] 01 04");
    device.set_value(0x2005, 0, &[7, 0, 0, 0]);
    assert_eq!(
        device.pass(10),
        [
            (10, "080 [0]".to_string()),
            (10, "184: 07 00 00 00 00 00 00 00".to_string())
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
    device.ask("604: 23 00 18 01 84 01 00 C0");
    device.ask("604: 2F 00 18 02 01 00 00 00");
    device.ask("604: 23 00 18 01 84 01 00 40");
    period(&mut device, 10_000);
    write_u32(&mut device, 0x1005, identifier);
    write_u32(&mut device, 0x1005, identifier | 0x4000_0000);
    device.send("000 [2] 01 04");
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
            [
                "200 [0]".to_string(),
                format!("184: {cycle:02X} 00 00 00 00 00 00 00")
            ]
        );
    }
}

#[test]
fn y01_a_pdo_does_not_wait_for_a_sync_that_will_not_leave() {
    let mut device = produce_with_pdo(0x200);
    device.now += Duration::from_ticks(10_000);
    device.poll();
    device.put("604: 23 05 10 00 00 02 00 00");
    assert_eq!(
        device.sent(),
        [
            "184: 00 00 00 00 00 00 00 00",
            "584: 60 05 10 00 00 00 00 00"
        ]
    );
}

#[test]
fn y01_other_frames_do_not_wait_for_sync() {
    let mut device = produce_with_pdo(0x6DF);
    device.now += Duration::from_ticks(10_000);
    device.put("604: 40 00 10 00 00 00 00 00");
    device.poll();
    assert_eq!(
        device.sent(),
        [
            "584: 43 00 10 00 92 01 02 00",
            "6DF [0]",
            "184: 00 00 00 00 00 00 00 00"
        ]
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
    device.put("604: 23 05 10 00 80 00 00 00");
    assert_eq!(device.sent(), ["584: 60 05 10 00 00 00 00 00"]);
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
            "080 [1] 01",
            "080 [1] 02",
            "080 [1] 03",
            "080 [1] 04",
            "080 [1] 05",
            "080 [1] 01",
            "080 [1] 02"
        ]
    );
    device.send("000 [2] 02 04");
    device.send("000 [2] 80 04");
    assert_eq!(
        device.pass(10),
        [(10, "080 [1] 01".to_string())],
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
        assert_eq!(
            counter(&mut device, value),
            ["584: 60 19 10 00 00 00 00 00"]
        );
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
        ["584: 60 05 10 00 00 00 00 00"],
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
    assert_eq!(device.pass(10), [(10, "090 [0]".to_string())]);
}

#[test]
fn y05_a_second_producer_is_a_collision() {
    let mut device = Device::new();
    produce(&mut device);
    assert_eq!(device.ask("080 [0]"), ["084: 50 81 11 80 00 00 00 00"]);
}

#[test]
fn y07_with_a_counter_a_sync_has_one_byte() {
    let mut device = Device::operational();
    device.ask("604: 23 00 18 01 84 01 00 C0");
    device.ask("604: 2F 00 18 02 01 00 00 00");
    device.ask("604: 23 00 18 01 84 01 00 40");
    counter(&mut device, 10);
    assert_eq!(device.ask("080 [0]"), ["084: 40 82 11 00 00 00 00 00"]);
    assert_eq!(device.ask("080 [2] 01 02"), [""; 0]);
    assert_eq!(
        device.ask("080 [1] 01"),
        [
            "084: 00 00 00 00 00 00 00 00",
            "184: 00 00 00 00 00 00 00 00"
        ]
    );
    assert_eq!(device.ask("080 [1] 00"), [""; 0], "no counter is 0");
    assert_eq!(device.ask("080 [1] F1"), [""; 0], "no counter is above 240");
    assert_eq!(device.ask("080 [1] F0"), ["184: 00 00 00 00 00 00 00 00"]);
}

#[test]
fn y08_a_sync_is_missed_after_one_and_a_half_periods() {
    let mut device = Device::new();
    period(&mut device, 1_000_000);
    assert!(device.pass(5_000).is_empty(), "it waits from the first on");
    device.send("080 [0]");
    assert!(device.pass(1_499).is_empty());
    device.send("080 [0]");
    let missed = "084: 00 81 11 06 10 00 00 00";
    assert_eq!(device.pass(5_000), [(1_500, missed.to_string())]);
    assert_eq!(device.value(0x1001, 0), [0x11]);
    assert_eq!(device.ask("080 [0]"), ["084: 00 00 00 00 00 00 00 00"]);
    assert_eq!(device.pass(5_000), [(1_500, missed.to_string())]);
    assert_eq!(
        write_u32(&mut device, 0x1006, 0),
        [
            "084: 00 00 00 00 00 00 00 00",
            "584: 60 06 10 00 00 00 00 00"
        ],
        "nothing is awaited without a period"
    );
}

#[test]
fn y09_a_stopped_device_neither_sends_nor_misses_it() {
    let mut device = Device::new();
    produce(&mut device);
    device.pass(15);
    device.send("000 [2] 02 04");
    assert!(device.pass(100).is_empty());
    device.send("000 [2] 01 04");
    assert_eq!(device.pass(10).last(), Some(&(10, "080 [0]".to_string())));
    device.send("000 [2] 82 04");
    device.serve_reset();
    assert_eq!(device.pass(100).len(), 1, "the boot-up message alone");

    let mut device = Device::new();
    period(&mut device, 10_000);
    device.send("080 [0]");
    device.send("000 [2] 02 04");
    device.send("080 [1] 01");
    assert!(device.pass(100).is_empty());
    device.send("000 [2] 80 04");
    assert!(device.pass(100).is_empty(), "it waits from the first on");
}

/// 0102_0304h ms after midnight, 0605h days.
const TIME: &str = "100 [6] 04 03 02 01 05 06";

fn time() -> Option<TimeOfDay> {
    TimeOfDay::new(0x0605, 0x0102_0304)
}

#[test]
fn t01_a_consumer_takes_the_time_of_day() {
    let mut device = Device::new();
    device.send(TIME);
    assert_eq!(device.node.time_of_day(device.now), None, "bit 31 is 0");
    write_u32(&mut device, 0x1012, 0x8000_0100);
    // Nothing else is TIME: this is the identifier of a transmit PDO of the device.
    write_u32(&mut device, 0x1800, 0x184);
    device.send("184 [6] 04 03 02 01 05 06");
    assert_eq!(device.sent(), ["084: 50 81 11 84 01 00 00 00"]);
    device.send("100 [2] 04 03");
    device.send("100 [7] 04 03 02 01 05 06 07");
    device.send("100 [8] rtr");
    assert_eq!(device.node.time_of_day(device.now), None);
    device.send("000 [2] 02 04");
    device.send(TIME);
    assert_eq!(device.node.time_of_day(device.now), None, "Stopped");
    device.send("000 [2] 80 04");
    device.send(TIME);
    assert_eq!(device.node.time_of_day(device.now), time());
    device.pass(10);
    assert_eq!(
        device.node.time_of_day(device.now),
        TimeOfDay::new(0x0605, 0x0102_030E)
    );
}

/// What a driver has to know: which frame may not leave before the SYNC that it answers.
#[test]
fn y01_only_synchronous_pdos_follow_the_sync() {
    let mut device = Device::operational();
    produce(&mut device);
    device.pass(5);
    for (kind, value, follows) in [(255, 1, None), (1, 2, Some(0x080))] {
        device.ask(&format!("604: 2F 00 18 02 {kind:02X} 00 00 00"));
        device.pass(10);
        device.set_value(0x2005, 0, &[value, 0, 0, 0]);
        device.now += Duration::millis(if kind == 1 { 10 } else { 1 });
        device.poll();
        let pending: Vec<_> = std::iter::from_fn(|| {
            let pending = device.node.pending()?;
            device.node.transmit(&mut device.firmware)?;
            Some(pending)
        })
        .collect();
        let pdo = pending.iter().find(|pending| pending.cob_id == 0x184);
        assert_eq!(pdo.map(|pdo| pdo.follows), Some(follows), "{pending:?}");
    }
}

#[test]
fn t01_a_producer_sends_it_when_it_is_asked_to() {
    let mut device = Device::new();
    device.node.set_time_of_day(time().unwrap(), device.now);
    assert!(!device.node.send_time_of_day(device.now), "bit 30 is 0");
    assert_eq!(
        write_u32(&mut device, 0x1012, 0x4000_0100),
        ["584: 60 12 10 00 00 00 00 00"]
    );
    assert!(device.node.send_time_of_day(device.now));
    assert_eq!(device.sent(), [TIME]);
    // What waits outlives a change of another identifier, but not the end of its own.
    for (index, value, waits) in [(0x1014, 0x8000_0084, true), (0x1012, 0x0100, false)] {
        assert!(device.node.send_time_of_day(device.now));
        let answered = write_u32(&mut device, index, value);
        assert_eq!(answered.contains(&TIME.to_string()), waits, "{answered:?}");
    }
    assert_eq!(
        write_u32(&mut device, 0x1012, 0x4000_0100),
        ["584: 60 12 10 00 00 00 00 00"]
    );
    device.send("000 [2] 02 04");
    assert!(!device.node.send_time_of_day(device.now));
    assert_eq!(device.sent(), [""; 0]);
}

#[test]
fn t01_a_producer_that_does_not_consume_is_told_of_another_one() {
    let mut device = Device::new();
    write_u32(&mut device, 0x1012, 0x4000_0100);
    device.send("100 [6] 04 03 02 01 05 06");
    assert_eq!(device.node.time_of_day(device.now), None);
    assert_eq!(device.sent(), ["084: 50 81 11 00 01 00 00 00"]);
    // As a consumer as well it hears the other one.
    write_u32(&mut device, 0x1012, 0x0000_0100);
    write_u32(&mut device, 0x1012, 0xC000_0100);
    device.send("100 [6] 04 03 02 01 05 06");
    assert_eq!(device.node.time_of_day(device.now), time());
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
    device.send("200 [6] 04 03 02 01 05 06");
    assert_eq!(device.node.time_of_day(device.now), time());
}

#[test]
fn p36_the_stamp_of_a_frame_says_whether_it_came_after_the_window() {
    let mut device = Device::new();
    device.ask("604: 23 00 14 01 04 02 00 80");
    device.ask("604: 2F 00 14 02 01 00 00 00");
    device.ask("604: 23 00 14 01 04 02 00 00");
    write_u32(&mut device, 0x1007, 5_000);
    device.send("000 [2] 01 04");
    device.send("080 [0]");
    // Both are given before the device is called, as every frame that has arrived.
    device.now += Duration::from_ticks(4_999);
    device.put("204: 01 00 00 00 00 00 00 00");
    device.now += Duration::from_ticks(1);
    device.put("204: 02 00 00 00 00 00 00 00");
    device.send("080 [0]");
    assert_eq!(device.value(0x2003, 0), [1, 0, 0, 0]);
}

#[test]
fn p36_a_synchronous_pdo_does_not_leave_after_the_window_though_frames_wait_to_be_given() {
    let mut device = Device::new();
    device.ask("604: 23 00 14 01 04 02 00 80");
    device.ask("604: 2F 00 14 02 01 00 00 00");
    device.ask("604: 23 00 14 01 04 02 00 00");
    // TPDO 1 at every SYNC, and by an event that waits.
    device.ask("604: 23 00 18 01 84 01 00 80");
    device.ask("604: 2F 00 18 02 01 00 00 00");
    device.ask("604: 23 00 18 01 84 01 00 00");
    write_u32(&mut device, 0x1007, 5_000);
    device.send("000 [2] 01 04");
    device.send("080 [0]");
    let received = device.now + Duration::from_ticks(4_999);
    device.now += Duration::from_ticks(5_000);
    device.node.drop_late(received);
    assert!(device.node.pending().is_some(), "the window is open");
    device.node.drop_late(device.now);
    assert_eq!(device.node.pending(), None);
    // A frame that arrived within the window is in time whenever it is given.
    device.node.receive(
        &frame("204: 07 00 00 00 00 00 00 00"),
        received,
        &mut device.firmware,
    );
    device.send("080 [0]");
    assert_eq!(device.value(0x2003, 0), [7, 0, 0, 0]);
    assert_eq!(device.sent().len(), 1);
}

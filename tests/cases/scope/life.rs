//! Who hears of a recording, and what outlives a power cut, a reset and a store.

use super::*;

#[test]
fn the_state_is_told_by_a_transmit_pdo() {
    let mut bench = DriveBench::booted(4);
    set_up(&mut bench, &[STATUSWORD], 5, 0);
    bench.write_u8(0x1A01, 0, 0);
    bench.write_u32(0x1A01, 1, 0x20D0_0208);
    bench.write_u8(0x1A01, 0, 1);
    bench.write_u32(0x1801, 1, 0x0000_0284);
    bench.start();
    // The event comes before the answer.
    bench.queue("604: 2F D0 20 01 01");
    bench.drain_until("284 [1] 01", 5);
    bench.queue("604: 2F D0 20 01 02");
    bench.drain_until("284 [1] 02", 5);
    bench.drain_until("284 [1] 03", 20);
}

#[test]
fn a_recorder_that_repeats_itself_waits_for_its_reader() {
    let mut bench = DriveBench::booted(4);
    set_up(&mut bench, &[STATUSWORD], 5, 0);
    bench.write_u8(0x20D0, 3, 1);
    order(&mut bench, ARM);
    order(&mut bench, TRIGGER);
    bench.drain(1_000);
    assert_eq!(state(&mut bench), FULL, "nobody has read it");
    bench.read(0x20D3, 0);
    bench.drain(50);
    bench.read(0x20D3, 0);
    bench.drain(95);
    assert_eq!(state(&mut bench), FULL, "read 95 ms ago");
    bench.drain(20);
    assert_eq!(state(&mut bench), ARMED);
}

#[test]
fn the_power_takes_the_recording_and_the_setup() {
    let mut bench = DriveBench::booted(4);
    set_up(&mut bench, &[STATUSWORD], 5, 0);
    order(&mut bench, ARM);
    order(&mut bench, TRIGGER);
    until_full(&mut bench, 20);
    bench.axis().power_cycle();
    bench.drain_until("704 [1] 00", 100);
    bench.drain(5);
    assert_eq!(state(&mut bench), IDLE);
    assert_eq!(bench.try_read(0x20D3, 0), Ok(Vec::new()));
    assert_eq!(bench.read_u16(0x20D0, 5), 0, "the data sheet's");
}

#[test]
fn a_reset_leaves_a_recording_that_is_done_and_ends_one_that_is_not() {
    let mut bench = DriveBench::booted(4);
    set_up(&mut bench, &[STATUSWORD], 5, 0);
    order(&mut bench, ARM);
    order(&mut bench, TRIGGER);
    until_full(&mut bench, 20);
    let data = bench.read(0x20D3, 0);
    bench.send("000 [2] 81 04");
    bench.drain_until("704 [1] 00", 50);
    assert_eq!(state(&mut bench), FULL);
    assert_eq!(bench.read(0x20D3, 0), data);
    assert_eq!(bench.read_u16(0x20D0, 5), 0, "the data sheet's");

    order(&mut bench, ARM);
    bench.send("000 [2] 82 04");
    bench.drain_until("704 [1] 00", 50);
    assert_eq!(state(&mut bench), ARMED, "communication alone was reset");
    bench.send("000 [2] 81 04");
    bench.drain_until("704 [1] 00", 50);
    assert_eq!(state(&mut bench), IDLE);
    assert_eq!(bench.try_read(0x20D3, 0), Ok(Vec::new()));
    // It begins again as ever.
    order(&mut bench, ARM);
    order(&mut bench, TRIGGER);
    until_full(&mut bench, 6_000);
}

#[test]
fn the_setup_is_stored_and_the_data_is_not() {
    let mut bench = DriveBench::booted(4);
    set_up(&mut bench, &[VELOCITY, STATUSWORD], 77, 11);
    trigger_at(&mut bench, STATUSWORD, 2, -5, 0x0400);
    bench.write_u8(0x20D0, 3, 1);
    order(&mut bench, ARM);
    bench.write(0x1010, 1, b"save");
    bench.axis().power_cycle();
    bench.drain_until("704 [1] 00", 100);
    bench.drain(5);
    assert_eq!(state(&mut bench), IDLE, "nothing begins by itself");
    assert_eq!(bench.read_u8(0x20D0, 1), 0);
    assert_eq!(bench.read_u8(0x20D0, 3), 1);
    assert_eq!(
        (bench.read_u16(0x20D0, 5), bench.read_u16(0x20D0, 6)),
        (77, 11)
    );
    assert_eq!(
        (bench.read_u32(0x20D1, 1), bench.read_u32(0x20D1, 3)),
        (VELOCITY, 0)
    );
    assert_eq!(
        (bench.read_u32(0x20D2, 1), bench.read_u32(0x20D2, 4)),
        (STATUSWORD, 0x0400)
    );
    assert_eq!(bench.read_u32(0x20D2, 3) as i32, -5);
    bench.write(0x1011, 1, b"load");
    bench.send("000 [2] 81 04");
    bench.drain_until("704 [1] 00", 50);
    assert_eq!(bench.read_u32(0x20D1, 1), STATUSWORD, "the data sheet's");
}

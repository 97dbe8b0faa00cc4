//! The scope: 20D0h to 20D3h, from the setup to the bytes of a recording.

use canopen::Duration;
use embedded_can::Frame as _;
use tests::DriveBench;

mod life;

/// Orders for 20D0h:1.
const STOP: u8 = 0;
const ARM: u8 = 1;
const TRIGGER: u8 = 2;

/// States of 20D0h:2.
const IDLE: u8 = 0;
const ARMED: u8 = 1;
const FULL: u8 = 3;

const STATUSWORD: u32 = 0x6041_0010;
const DEMAND: u32 = 0x6062_0020;
const POSITION: u32 = 0x6064_0020;
const VELOCITY: u32 = 0x606C_0020;

/// Abort code: not in this state of the device.
const DEVICE_STATE: Result<Vec<u8>, u32> = Err(0x0800_0022);

/// Maps channels, and sets samples and those before the trigger.
fn set_up(bench: &mut DriveBench, channels: &[u32], samples: u16, before: u16) {
    for sub in 1..=8 {
        let mapping = channels.get(usize::from(sub) - 1).copied().unwrap_or(0);
        bench.write_u32(0x20D1, sub, mapping);
    }
    bench.write_u16(0x20D0, 5, samples);
    bench.write_u16(0x20D0, 6, before);
}

/// An edge of a value: 1 rising, 2 falling, 3 both.
fn trigger_at(bench: &mut DriveBench, object: u32, edge: u8, level: i32, mask: u32) {
    bench.write_u32(0x20D2, 1, object);
    bench.write_u8(0x20D2, 2, edge);
    bench.write_u32(0x20D2, 3, level as u32);
    bench.write_u32(0x20D2, 4, mask);
}

fn order(bench: &mut DriveBench, order: u8) {
    bench.write_u8(0x20D0, 1, order);
}

fn state(bench: &mut DriveBench) -> u8 {
    bench.read_u8(0x20D0, 2)
}

/// Lets time pass until there is a recording.
#[track_caller]
fn until_full(bench: &mut DriveBench, milliseconds: u64) {
    for _ in 0..milliseconds {
        if state(bench) == FULL {
            return;
        }
        bench.drain(1);
    }
    panic!("no recording in {milliseconds} ms");
}

fn u16_at(data: &[u8], at: usize) -> u16 {
    u16::from_le_bytes(data[at..at + 2].try_into().unwrap())
}

fn u32_at(data: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(data[at..at + 4].try_into().unwrap())
}

/// A value of 32 bits in each sample, so many bytes from its beginning.
fn numbers(data: &[u8], at: usize) -> Vec<i32> {
    let stride = usize::from(u16_at(data, 12));
    let samples = data[64..].chunks_exact(stride);
    samples.map(|sample| u32_at(sample, at) as i32).collect()
}

#[test]
fn a_recording_is_made_and_read_by_frames() {
    let mut bench = DriveBench::started(4);
    bench.drain(5);
    for (request, answer) in [
        ("604: 23 D1 20 01 10 00 41 60", "584: 60 D1 20 01"),
        ("604: 23 D1 20 02 08 00 61 60", "584: 60 D1 20 02"),
        ("604: 23 D1 20 03 00 00 00 00", "584: 60 D1 20 03"),
        ("604: 23 D1 20 04 20 00 64 60", "584: 60 D1 20 04"),
        // Two samples, one of them older than the trigger.
        ("604: 2B D0 20 05 02 00", "584: 60 D0 20 05"),
        ("604: 2B D0 20 06 01 00", "584: 60 D0 20 06"),
        ("604: 2F D0 20 01 01", "584: 60 D0 20 01"),
        ("604: 40 D0 20 02", "584: 4F D0 20 02 01"),
        // Nothing to read yet.
        ("604: 40 D3 20 00", "584: 80 D3 20 00 22 00 00 08"),
        ("604: A4 D3 20 00 7F", "584: 80 D3 20 00 22 00 00 08"),
    ] {
        bench.queue(request);
        bench.expect(answer);
    }
    bench.drain(5);
    bench.queue("604: 2F D0 20 01 02");
    bench.expect("584: 60 D0 20 01");
    bench.drain(3);
    bench.queue("604: 40 D0 20 02");
    bench.expect("584: 4F D0 20 02 03");
    bench.queue("604: 40 D0 20 07");
    bench.expect("584: 4B D0 20 07 02 00");

    // A header of 64 bytes and two samples of eight.
    bench.queue("604: A4 D3 20 00 7F");
    bench.expect("584: C6 D3 20 00 50");
    bench.queue("604: A3");
    // Version 1, 64 bytes; a tick is 1,000,000 ns.
    bench.expect("584: 01 01 00 40 00 40 42 0F");
    // Every tick; three channels; eight bytes a sample; the sample is of the tick of the trigger.
    bench.expect("584: 02 00 01 00 03 00 08 00");
    // Two samples, one before the trigger.
    bench.expect("584: 03 00 00 02 00 00 00 01");
    // When the trigger came, eight bytes.
    bench.expect("584: 04 00 00 00 ..");
    bench.expect("584: 05 00 00 00 00 10 00 41");
    bench.expect("584: 06 60 08 00 61 60 00 00");
    bench.expect("584: 07 00 00 20 00 64 60 00");
    bench.expect("584: 08 00 00 00 00 00 00 00");
    bench.expect("584: 09 00 00 00 00 00 00 00");
    // 6041h, 6061h, 6064h and one byte more, twice.
    bench.expect("584: 0A 00 50 02 01 00 00 00");
    bench.expect("584: 0B 00 00 50 02 01 00 00");
    bench.expect("584: 8C 00 00 00");
}

#[test]
fn a_recording_has_what_transmit_pdos_show_of_the_same_ticks() {
    let mut bench = DriveBench::enabled(4);
    set_up(&mut bench, &[POSITION, DEMAND], 100, 40);
    trigger_at(&mut bench, VELOCITY, 1, 5_000, 0);
    bench.write_u32(0x6083, 0, 40_000);
    order(&mut bench, ARM);
    bench.begin_move(5_000);
    // TPDO 4 shows 6064h and 6062h as they are at each SYNC.
    let mut shown = Vec::new();
    for _ in 0..400 {
        let next = bench.now() + Duration::millis(1);
        bench.queue("080 [0]");
        let frame = bench.drain_until("484 [8] ..", 1);
        let bytes = frame.payload();
        shown.push((u32_at(bytes, 0) as i32, u32_at(bytes, 4) as i32));
        bench.run_micros(next.checked_duration_since(bench.now()).unwrap().ticks());
    }
    until_full(&mut bench, 10);
    let data = bench.read(0x20D3, 0);
    let recorded: Vec<(i32, i32)> = numbers(&data, 0)
        .into_iter()
        .zip(numbers(&data, 4))
        .collect();
    assert_eq!(recorded.len(), 100);
    let place = shown.windows(100).position(|shown| *shown == recorded);
    assert!(place.is_some(), "{recorded:?}\n{shown:?}");
    assert!(
        recorded[0].0 > 0 && recorded[99].0 > recorded[0].0,
        "it moves"
    );
}

#[test]
fn the_samples_before_the_trigger_are_as_many_as_asked_for() {
    for (before, wait) in [(0, 5), (1, 5), (49, 80), (20, 1_234), (10, 4)] {
        let mut bench = DriveBench::enabled(4);
        set_up(&mut bench, &[VELOCITY, STATUSWORD], 50, before);
        trigger_at(&mut bench, VELOCITY, 1, 300, 0);
        bench.write_u32(0x6083, 0, 20_000);
        order(&mut bench, ARM);
        // The ring goes round more than once where the wait is long.
        bench.drain(wait);
        assert_eq!(state(&mut bench), ARMED);
        bench.begin_move(5_000);
        until_full(&mut bench, 200);
        let data = bench.read(0x20D3, 0);
        let velocity = numbers(&data, 0);
        let index = u32_at(&data, 20) as usize;
        assert_eq!(u32_at(&data, 16) as usize, velocity.len());
        if wait > 4 {
            assert_eq!(
                (index, velocity.len()),
                (usize::from(before), 50),
                "before {before}"
            );
        }
        assert_eq!(
            velocity.len() - index,
            50 - usize::from(before),
            "as many behind it"
        );
        assert!(
            velocity[..index].iter().all(|velocity| *velocity < 300),
            "{velocity:?}"
        );
        assert!(
            velocity[index..].iter().all(|velocity| *velocity >= 300),
            "{velocity:?}"
        );
        assert!(velocity.is_sorted(), "oldest first: {velocity:?}");
    }
}

#[test]
fn with_a_divider_the_trigger_is_found_in_any_tick() {
    let mut bench = DriveBench::enabled(4);
    set_up(&mut bench, &[VELOCITY, POSITION], 10, 3);
    bench.write_u16(0x20D0, 4, 16);
    trigger_at(&mut bench, VELOCITY, 1, 300, 0);
    bench.write_u32(0x6083, 0, 5_000);
    order(&mut bench, ARM);
    bench.drain(100);
    bench.begin_move(5_000);
    until_full(&mut bench, 400);
    let data = bench.read(0x20D3, 0);
    assert_eq!(
        (u16_at(&data, 8), u32_at(&data, 16), u32_at(&data, 20)),
        (16, 10, 3)
    );
    let late = u16_at(&data, 14);
    assert!(late < 16, "{late}");
    // 5 steps/s more in each tick, give or take what the measurement lags.
    let velocity = numbers(&data, 0);
    let expected = 300 + 5 * i32::from(late);
    assert!(
        (velocity[3] - expected).abs() < 40,
        "{velocity:?}, {late} ticks late"
    );
    assert!((velocity[4] - velocity[3] - 80).abs() < 20, "{velocity:?}");
}

#[test]
fn a_fault_is_a_trigger() {
    let mut bench = DriveBench::enabled(4);
    set_up(&mut bench, &[0x603F_0010, STATUSWORD], 20, 10);
    trigger_at(&mut bench, STATUSWORD, 1, 0, 1 << 3);
    order(&mut bench, ARM);
    bench.drain(50);
    assert_eq!(state(&mut bench), ARMED);
    bench.set_fault(Some(0x2310));
    until_full(&mut bench, 50);
    let data = bench.read(0x20D3, 0);
    let codes: Vec<u16> = data[64..]
        .chunks_exact(4)
        .map(|sample| u16_at(sample, 0))
        .collect();
    assert_eq!(codes[..10], [0; 10]);
    assert_eq!(codes[10..], [0x2310; 10]);
}

#[test]
fn both_transfers_read_the_same() {
    let mut bench = DriveBench::enabled(4);
    set_up(&mut bench, &[POSITION, VELOCITY, STATUSWORD], 0, 0);
    bench.begin_move(3_000);
    order(&mut bench, ARM);
    order(&mut bench, TRIGGER);
    until_full(&mut bench, 3_000);
    let data = bench.read(0x20D3, 0);
    // 20,480 bytes hold 1,706 samples of twelve bytes.
    assert_eq!((u32_at(&data, 16), data.len()), (1_706, 64 + 1_706 * 12));
    for block_size in [127, 3] {
        let blocks = bench.block_upload(0x20D3, 0, block_size);
        assert!(
            blocks.as_ref() == Ok(&data),
            "{block_size}: {:?}",
            blocks.err()
        );
    }
}

#[test]
fn what_cannot_be_recorded_cannot_be_mapped() {
    let mut bench = DriveBench::booted(4);
    // No object, no value of a tick, a wrong length, a DOMAIN.
    for mapping in [
        0x7FFF_0020_u32,
        0x1018_0420,
        0x6064_0010,
        0x6064_0120,
        0x2020_0008,
        0x0005_0008,
    ] {
        let bytes = mapping.to_le_bytes();
        assert_eq!(
            bench.try_write(0x20D1, 3, &bytes),
            Err(0x0604_0041),
            "{mapping:08X}h"
        );
        assert_eq!(
            bench.try_write(0x20D2, 1, &bytes),
            Err(0x0604_0041),
            "{mapping:08X}h"
        );
    }
    assert_eq!(bench.read_u32(0x20D1, 3), POSITION, "as before");
    assert_eq!(bench.try_write(0x20D2, 2, &[0]), Err(0x0609_0032));
    assert_eq!(bench.try_write(0x20D2, 2, &[4]), Err(0x0609_0031));
    assert_eq!(bench.try_write(0x20D0, 4, &[0, 0]), Err(0x0609_0032));
    assert_eq!(bench.try_write(0x20D0, 1, &[3]), Err(0x0609_0031));
    assert_eq!(bench.try_write(0x20D0, 3, &[2]), Err(0x0609_0031));
}

#[test]
fn a_setup_that_does_not_fit_is_not_armed() {
    let mut bench = DriveBench::booted(4);
    bench.drain(5);
    assert_eq!(bench.read_u32(0x20D0, 8), 20_480);
    assert_eq!(bench.read_u32(0x20D0, 9), 1_000_000);
    set_up(&mut bench, &[], 10, 0);
    assert_eq!(
        bench.try_write(0x20D0, 1, &[ARM]),
        Err(0x0800_0022),
        "no channel"
    );
    set_up(&mut bench, &[POSITION], 5_121, 0);
    assert_eq!(bench.try_write(0x20D0, 1, &[ARM]), Err(0x0504_0005));
    set_up(&mut bench, &[POSITION], 10, 10);
    assert_eq!(bench.try_write(0x20D0, 1, &[ARM]), Err(0x0604_0043));
    set_up(&mut bench, &[POSITION], 5_120, 5_119);
    order(&mut bench, ARM);
    assert_eq!(state(&mut bench), ARMED);
}

#[test]
fn while_it_records_the_setup_stays() {
    let mut bench = DriveBench::booted(4);
    set_up(&mut bench, &[POSITION], 10, 0);
    order(&mut bench, ARM);
    for (index, sub, value) in [
        (0x20D0, 1, &[ARM][..]),
        (0x20D0, 4, &[2, 0]),
        (0x20D1, 1, &0_u32.to_le_bytes()),
        (0x20D2, 4, &0_u32.to_le_bytes()),
    ] {
        assert_eq!(
            bench.try_write(index, sub, value),
            Err(0x0800_0022),
            "{index:04X}h:{sub}"
        );
    }
    assert_eq!(bench.try_read(0x20D3, 0), DEVICE_STATE);
    order(&mut bench, STOP);
    assert_eq!(state(&mut bench), IDLE);
    assert_eq!(bench.try_write(0x20D0, 1, &[TRIGGER]), Err(0x0800_0022));
    bench.write_u16(0x20D0, 4, 2);
}

#[test]
fn a_recording_ends_with_the_order_for_the_next() {
    let mut bench = DriveBench::booted(4);
    set_up(&mut bench, &[STATUSWORD], 5, 0);
    order(&mut bench, ARM);
    order(&mut bench, TRIGGER);
    until_full(&mut bench, 20);
    let first = bench.read(0x20D3, 0);
    // What is set up for the next one does not change the one that is there.
    set_up(&mut bench, &[POSITION, VELOCITY], 7, 3);
    assert_eq!(bench.read(0x20D3, 0), first);

    // A transfer that is under way when the next one begins does not get bytes of both.
    bench.queue("604: 40 D3 20 00");
    bench.expect("584: 41 D3 20 00 ..");
    bench.queue("604: 60");
    bench.expect("584: 00 ..");
    // By a second client the order could come any time; here by the one that reads: it ends the transfer.
    order(&mut bench, ARM);
    assert_eq!(state(&mut bench), ARMED, "before a tick has come");
    assert_eq!(bench.try_read(0x20D3, 0), DEVICE_STATE);
    order(&mut bench, TRIGGER);
    until_full(&mut bench, 20);
    assert_eq!(
        u32_at(&bench.read(0x20D3, 0), 16),
        7 - 3 + u32_at(&bench.read(0x20D3, 0), 20)
    );
}

#[test]
fn two_clients_never_get_bytes_of_two_recordings() {
    let mut bench = DriveBench::booted(4);
    bench.write_u32(0x1201, 1, 0x680);
    bench.write_u32(0x1201, 2, 0x681);
    set_up(&mut bench, &[POSITION, VELOCITY], 200, 0);
    order(&mut bench, ARM);
    order(&mut bench, TRIGGER);
    until_full(&mut bench, 400);
    bench.queue("680: 40 D3 20 00");
    bench.expect("681: 41 D3 20 00 ..");
    bench.queue("680: 60");
    bench.expect("681: 00 ..");
    // Two may read one recording.
    bench.queue("604: 40 D3 20 00");
    bench.expect("584: 41 D3 20 00 ..");
    order(&mut bench, ARM);
    order(&mut bench, TRIGGER);
    until_full(&mut bench, 400);
    // The other client has not been told yet that its recording is gone.
    bench.queue("604: 40 D3 20 00");
    bench.expect("584: 80 D3 20 00 22 00 00 08");
    let mut toggle = 0x70;
    loop {
        bench.queue(&format!("680: {toggle:02X}"));
        let frame = bench.expect("681: ..");
        let answer = frame.data();
        if answer[0] == 0x80 {
            assert_eq!(answer, [0x80, 0xD3, 0x20, 0, 0x22, 0, 0, 0x08]);
            break;
        }
        assert_eq!(answer[0], toggle - 0x60, "its transfer does not end well");
        toggle ^= 0x10;
    }
    assert_eq!(bench.read(0x20D3, 0).len(), 64 + 1_600);
}

#[test]
fn a_stop_keeps_what_has_been_recorded() {
    let mut bench = DriveBench::booted(4);
    set_up(&mut bench, &[STATUSWORD], 5, 0);
    order(&mut bench, ARM);
    order(&mut bench, TRIGGER);
    until_full(&mut bench, 20);
    let data = bench.read(0x20D3, 0);
    order(&mut bench, STOP);
    bench.drain(5);
    assert_eq!(state(&mut bench), FULL);
    assert_eq!(bench.read(0x20D3, 0), data);
}

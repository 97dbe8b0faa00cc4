//! TIME, consumed and produced, and emergency messages of others.

use canopen::Event;
use canopen::cia301::time_stamp::TimeOfDay;
use tests::Bench;

fn time_of_day(bench: &mut Bench) -> Option<TimeOfDay> {
    let now = bench.now();
    bench.device().node().time_of_day(now)
}

/// 12:00:00 of 1 January 2026, which is day 15,341.
const NOON: &str = "100 [6] 00 2E 93 02 ED 3B";

#[test]
fn t01_a_time_of_six_bytes_is_taken() {
    let mut bench = Bench::node(4);
    assert_eq!(time_of_day(&mut bench), None);
    bench.send(NOON);
    let time = time_of_day(&mut bench).unwrap();
    assert_eq!((time.days(), time.milliseconds()), (15_341, 43_200_000));
    bench.run_millis(2_500);
    let time = time_of_day(&mut bench).unwrap();
    assert_eq!((time.days(), time.milliseconds()), (15_341, 43_202_500));
    bench.silence(100);
}

#[test]
fn t01_a_time_of_another_length_is_ignored() {
    let mut bench = Bench::node(4);
    for frame in [
        "100 [2] 00 2E",
        "100 [0]",
        "100 [8] 00 2E 93 02 ED 3B",
        "100 [6] rtr",
        "00000100 [6] 00 2E 93 02 ED 3B",
    ] {
        bench.send(frame);
        assert_eq!(time_of_day(&mut bench), None, "{frame}");
    }
    bench.silence(100);
    bench.send(NOON);
    assert!(time_of_day(&mut bench).is_some());
}

#[test]
fn t01_and_n09_a_stopped_device_takes_no_time() {
    let mut bench = Bench::node(4);
    bench.send("000 [2] 02 04");
    bench.send(NOON);
    assert_eq!(time_of_day(&mut bench), None);
    bench.send("000 [2] 80 04");
    bench.send(NOON);
    assert!(time_of_day(&mut bench).is_some());
}

#[test]
fn t01_a_device_that_consumes_no_time_takes_none() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x1012, 0, 0x100);
    bench.send(NOON);
    assert_eq!(time_of_day(&mut bench), None);
    bench.write_u32(0x1012, 0, 0x8000_0100);
    bench.send(NOON);
    assert!(time_of_day(&mut bench).is_some());
}

#[test]
fn t01_a_producer_tells_its_time() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x1012, 0, 0x4000_0100);
    let now = bench.now();
    let time = TimeOfDay::new(15_341, 43_200_000).unwrap();
    bench.device().node().set_time_of_day(time, now);
    assert!(bench.device().node().send_time_of_day(now));
    bench.expect("100 [6] xx 2E 93 02 ED 3B");
}

#[test]
fn s41_restricted_identifiers_are_no_time_and_no_emergency_consumer() {
    let mut bench = Bench::node(4);
    for (index, sub) in [(0x1012_u16, 0_u8), (0x1028, 1)] {
        for cob_id in [
            0x000_u32, 0x07F, 0x101, 0x180, 0x581, 0x5FF, 0x601, 0x67F, 0x6E0, 0x6FF, 0x701, 0x7FF,
        ] {
            let [low, high] = index.to_le_bytes();
            let [a, b, ..] = cob_id.to_le_bytes();
            bench.refused(
                &format!("604: 23 {low:02X} {high:02X} {sub:02X} {a:02X} {b:02X}"),
                0x0609_0030,
            );
        }
    }
}

#[test]
fn the_emergencies_of_others_are_told() {
    let mut bench = Bench::node(4);
    bench.write_u32(0x1028, 2, 0x85);
    bench.send("085: 10 42 09 01 02 03 04 05");
    bench.send("086: 10 43 09");
    bench.send("085 [7] 10 44 09");
    bench.silence(10);
    let received: Vec<_> = bench
        .device()
        .told
        .iter()
        .filter_map(|event| match event {
            Event::EmergencyReceived(emergency) => Some((
                emergency.consumer,
                emergency.code,
                emergency.register,
                emergency.info,
            )),
            _ => None,
        })
        .collect();
    assert_eq!(received, [(2, 0x4210, 9, [1, 2, 3, 4, 5])]);
}

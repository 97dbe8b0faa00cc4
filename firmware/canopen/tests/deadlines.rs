//! A device that is polled at the deadlines it names sends what it sends when it is polled all the time.

use crate::device::Device;
use canopen::cia301::emergency::Emergency;
use canopen::{Duration, Frame, Instant};
use proptest::prelude::*;
use proptest::test_runner::contextualize_config;

/// The finest unit of all times of a device, in µs.
const UNIT: u64 = 100;

/// What may happen to a device.
#[derive(Clone, Debug)]
enum Step {
    Frame(u16, Vec<u8>),
    /// The master asks whether the device lives.
    Guard,
    /// The firmware puts a number into 2005h, which both transmit PDOs send.
    Value(u8),
    Report(u8),
    Clear(u8),
    /// This much time, in units of 100 µs.
    Pass(u64),
}

/// An SDO download of a number, `size` bytes long.
fn write(index: u16, sub: u8, size: u8, value: u32) -> Vec<u8> {
    let [low, high] = index.to_le_bytes();
    let mut request = vec![0x23 | (4 - size) << 2, low, high, sub];
    request.extend(value.to_le_bytes());
    request
}

fn step() -> impl Strategy<Value = Step> {
    let nmt = prop::sample::select(vec![0x01, 0x01, 0x01, 0x02, 0x80]);
    let transmission_type = prop::sample::select(vec![0, 1, 2, 254, 255]);
    let request = prop_oneof![
        (0..2_u16, transmission_type).prop_map(|(pdo, value)| write(0x1800 + pdo, 2, 1, value)),
        prop::sample::select(vec![0, 1, 255]).prop_map(|value| write(0x1400, 2, 1, value)),
        (0..2_u16, 0..30_u32).prop_map(|(pdo, value)| write(0x1800 + pdo, 5, 2, value)),
        (0..2_u16, 0..100_u32).prop_map(|(pdo, value)| write(0x1800 + pdo, 3, 2, value)),
        // COB-IDs, valid and not valid: the inhibit time changes in between.
        (0..2_u16, any::<bool>()).prop_map(|(pdo, valid)| {
            let cob_id = 0x4000_0184 + u32::from(pdo) * 0x100;
            write(0x1800 + pdo, 1, 4, cob_id | if valid { 0 } else { 1 << 31 })
        }),
        (0..20_u32).prop_map(|value| write(0x1017, 0, 2, value)),
        (0..50_u32).prop_map(|value| write(0x1015, 0, 2, value)),
        // SYNC: who produces it, its period (missed after one and a half), its window, its counter.
        any::<bool>().prop_map(|on| write(0x1005, 0, 4, if on { 0x4000_0080 } else { 0x80 })),
        (0..100_u32).prop_map(|value| write(0x1006, 0, 4, value * 200)),
        (0..20_u32).prop_map(|value| write(0x1007, 0, 4, value * 100)),
        (0..4_u32).prop_map(|value| write(0x1019, 0, 1, value)),
        // Heartbeat consumers, life guarding, error behaviour.
        (1..4_u8, 0..30_u32, 4..7_u32).prop_map(|(sub, time, node)| write(
            0x1016,
            sub,
            4,
            node << 16 | time
        )),
        (0..30_u32).prop_map(|value| write(0x100C, 0, 2, value)),
        (0..4_u32).prop_map(|value| write(0x100D, 0, 1, value)),
        (0..3_u32).prop_map(|value| write(0x1029, 1, 1, value)),
        (0..3_u32).prop_map(|value| write(0x2006, 0, 4, value)),
        // A segmented upload that nobody goes on with: it times out.
        Just(vec![0x40, 0x10, 0x20, 0, 0, 0, 0, 0]),
    ];
    prop_oneof![
        2 => nmt.prop_map(|command| Step::Frame(0x000, vec![command, 4])),
        5 => request.prop_map(|request| Step::Frame(0x604, request)),
        3 => (0..=9_usize, 0..3_u8).prop_map(|(length, value)| Step::Frame(0x204, vec![value; length.min(8)])),
        3 => (0..4_usize).prop_map(|length| Step::Frame(0x080, vec![0; length / 3])),
        2 => (0..3_u16, 0..6_u8).prop_map(|(node, state)| Step::Frame(0x704 + node, vec![state])),
        1 => Just(Step::Guard),
        1 => (0..0x800_u16).prop_map(|cob_id| Step::Frame(cob_id | 0x100, vec![1, 2])),
        5 => (0..3_u8).prop_map(Step::Value),
        1 => (0..4_u8).prop_map(Step::Report),
        1 => (0..4_u8).prop_map(Step::Clear),
        8 => prop_oneof![8 => 0..300_u64, 1 => Just(11_000)].prop_map(Step::Pass),
    ]
}

/// A device in Operational whose first receive PDO goes where its transmit PDOs come from.
fn mirror() -> Device {
    let mut device = Device::operational();
    for request in [
        write(0x1400, 1, 4, 0x8000_0204),
        write(0x1600, 0, 1, 0),
        write(0x1600, 1, 4, 0x2005_0020),
        write(0x1600, 2, 4, 0x2006_0020),
        write(0x1600, 0, 1, 2),
        write(0x1400, 1, 4, 0x0000_0204),
    ] {
        happen(&mut device, &Step::Frame(0x604, request));
        device.poll();
        let answers = device.sent();
        assert!(
            answers.len() == 1 && answers[0].starts_with("584: 60"),
            "{answers:?}"
        );
    }
    device
}

/// What a device has sent, and when.
type Log = Vec<(Instant, String)>;

fn send_all(device: &mut Device, log: &mut Log) {
    let sent = device.sent();
    log.extend(sent.into_iter().map(|frame| (device.now, frame)));
}

/// Sleeps until the deadline that the device names, as the firmware does.
fn pass_by_deadlines(device: &mut Device, end: Instant, log: &mut Log) {
    loop {
        device.poll();
        send_all(device, log);
        // What has left may start an inhibit time.
        let deadline = device.poll();
        if deadline > end {
            device.now = end;
            return;
        }
        device.now = deadline;
    }
}

/// Never sleeps, and makes the device compare its PDOs each time.
fn pass_by_units(device: &mut Device, end: Instant, log: &mut Log) {
    loop {
        device.node.dictionary_mut();
        device.poll();
        send_all(device, log);
        device.poll();
        if device.now >= end {
            return;
        }
        device.now += Duration::from_ticks(UNIT);
    }
}

fn happen(device: &mut Device, step: &Step) {
    match step {
        Step::Frame(cob_id, data) => {
            let frame = Frame::data_frame(*cob_id, data);
            device
                .node
                .receive(&frame, device.now, &mut device.firmware);
        }
        Step::Guard => device.put("704 [8] rtr"),
        Step::Value(value) => device.set_value(0x2005, 0, &[*value, 0, 0, 0]),
        Step::Report(number) => {
            let emergency = Emergency {
                code: 0xFF00 + u16::from(*number),
                register: 0x80,
                info: [0; 5],
            };
            device.node.report(emergency, device.now);
        }
        Step::Clear(number) => device.node.clear(0xFF00 + u16::from(*number), device.now),
        Step::Pass(_) => {}
    }
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig::with_cases(200)))]

    #[test]
    fn deadlines_and_marked_changes_miss_nothing(steps in prop::collection::vec(step(), 1..80)) {
        let mut sleeping = mirror();
        let mut waking = mirror();
        let (mut slept, mut woke) = (Log::new(), Log::new());
        for step in &steps {
            happen(&mut sleeping, step);
            happen(&mut waking, step);
            let units = match step {
                Step::Pass(units) => *units,
                _ => 0,
            };
            let end = sleeping.now + Duration::from_ticks(units * UNIT);
            pass_by_deadlines(&mut sleeping, end, &mut slept);
            pass_by_deadlines(&mut sleeping, end, &mut slept);
            pass_by_units(&mut waking, end, &mut woke);
            prop_assert_eq!(&slept, &woke, "after {:?}", step);
        }
    }
}

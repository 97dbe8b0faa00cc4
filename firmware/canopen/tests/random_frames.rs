//! Whatever frames come at whatever times, the device neither panics nor breaks its contract.

use crate::device::Device;
use canopen::cia301::emergency::Emergency;
use canopen::cia301::nmt::NmtState;
use canopen::{Duration, Event, Frame};
use proptest::prelude::*;
use proptest::test_runner::contextualize_config;

/// What may happen to a device.
#[derive(Clone, Debug)]
enum Step {
    Frame(u16, Vec<u8>),
    Remote(u16),
    /// An SDO request that is nearly right: command, place in the dictionary, data.
    Request(u8, usize, [u8; 4]),
    Pass(u64),
    Report(u8),
    Clear(u8),
    /// The bus takes this many frames.
    Transmit(usize),
}

fn step() -> impl Strategy<Value = Step> {
    let own = prop::sample::select(vec![
        0x000, 0x080, 0x084, 0x184, 0x204, 0x304, 0x604, 0x604, 0x604, 0x704, 0x7E5,
    ]);
    let identifier = prop_oneof![8 => own, 2 => 0..0x800_u16];
    let nmt = (
        prop::sample::select(vec![0x01, 0x02, 0x80, 0x81, 0x82, 0x77]),
        0..6_u8,
    );
    let command = prop::sample::select(vec![
        0x40, 0x60, 0x70, 0x20, 0x21, 0x22, 0x23, 0x2B, 0x2F, 0x00, 0x10, 0x01, 0x11, 0x0F, 0x80,
        0xA0, 0xC2, 0xE0,
    ]);
    prop_oneof![
        4 => (identifier.clone(), prop::collection::vec(any::<u8>(), 0..=8)).prop_map(|(id, data)| Step::Frame(id, data)),
        2 => nmt.prop_map(|(command, node)| Step::Frame(0, vec![command, node])),
        1 => identifier.prop_map(Step::Remote),
        8 => (command, 0..200_usize, any::<[u8; 4]>()).prop_map(|(c, place, data)| Step::Request(c, place, data)),
        4 => (0..2_000_000_u64).prop_map(Step::Pass),
        1 => (0..30_u8).prop_map(Step::Report),
        1 => (0..30_u8).prop_map(Step::Clear),
        4 => (0..10_usize).prop_map(Step::Transmit),
    ]
}

/// What is owed to the master, kept beside the device.
#[derive(Default)]
struct Ledger {
    /// SDO requests; a time-out and an acknowledge that asks for lost segments may add an answer to each.
    requests: usize,
    answers: usize,
    boots: usize,
    boot_ups: usize,
}

fn check(device: &mut Device, ledger: &mut Ledger, frame: &Frame) -> Result<(), TestCaseError> {
    let id = frame.standard_id().unwrap();
    let state = device.node.state();
    prop_assert!(!frame.is_remote());
    match id {
        0x584 => {
            ledger.answers += 1;
            prop_assert_eq!(frame.length(), 8);
            prop_assert!(state.has_sdo_and_emergency());
        }
        0x704 if frame.payload() == [0] => ledger.boot_ups += 1,
        // A heartbeat, or the answer to a guarding request with its toggle bit.
        0x704 => {
            prop_assert_eq!(frame.length(), 1);
            prop_assert_eq!(frame.payload()[0] & 0x7F, state as u8);
        }
        0x7E4 => prop_assert_eq!(frame.length(), 8),
        // Emergency messages and PDOs: the master may give them any identifier that is not restricted.
        _ => {
            prop_assert!(!canopen::wire::cob_id::is_restricted(id));
            // A device that stops itself after a communication error says why.
            let says_why = state == NmtState::Stopped && frame.length() == 8;
            prop_assert!(state.has_sdo_and_emergency() || says_why);
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig::with_cases(400)))]

    #[test]
    fn random_frames_at_random_times_break_nothing(steps in prop::collection::vec(step(), 1..300)) {
        let mut device = Device::off();
        let mut ledger = Ledger::default();
        device.boot(canopen::cia301::nmt::Reset::Node);
        ledger.boots += 1;
        for step in steps {
            match step {
                Step::Frame(id, data) => {
                    ledger.requests += if id == 0x604 { 64 } else { 0 };
                    device.node.receive(&Frame::data_frame(id, &data), device.now, &mut device.firmware);
                }
                Step::Remote(id) => {
                    device.node.receive(&Frame::remote_frame(id, 8), device.now, &mut device.firmware);
                }
                Step::Request(command, place, [a, b, c, d]) => {
                    // A step of a block upload may set off a sub-block.
                    ledger.requests += if command >> 5 == 5 { 64 } else { 1 };
                    let entries = crate::device::entries();
                    let entry = &entries[place % entries.len()];
                    let [low, high] = entry.index.to_le_bytes();
                    let frame = Frame::data_frame(0x604, &[command, low, high, entry.sub, a, b, c, d]);
                    device.node.receive(&frame, device.now, &mut device.firmware);
                }
                Step::Pass(ticks) => device.now += Duration::from_ticks(ticks),
                Step::Report(number) => {
                    let emergency = Emergency { code: 0xFF00 + u16::from(number), register: number, info: [number; 5] };
                    device.node.report(emergency, device.now);
                }
                Step::Clear(number) => device.node.clear(0xFF00 + u16::from(number), device.now),
                Step::Transmit(frames) => {
                    for _ in 0..frames {
                        let Some(frame) = device.node.transmit(&mut device.firmware) else { break };
                        check(&mut device, &mut ledger, &frame)?;
                    }
                }
            }
            device.poll();
            for event in device.events() {
                match event {
                    Event::ResetRequested(reset) => {
                        prop_assert_eq!(device.node.state(), NmtState::Initialisation);
                        prop_assert!(device.node.transmit(&mut device.firmware).is_none());
                        device.boot(reset);
                        ledger.boots += 1;
                    }
                    Event::StoreSettings(_) => device.node.settings_stored(Ok(())),
                    _ => {}
                }
            }
            // LSS may have taken the node-ID away or changed it: the rest of this test speaks to node 4.
            if device.node.settings().node_id.get() != 4 {
                return Ok(());
            }
            prop_assert!(ledger.answers <= 3 * ledger.requests);
            prop_assert!(ledger.boot_ups <= ledger.boots);
            // The error register and its generic bit.
            let [register] = device.value(0x1001, 0)[..] else { panic!() };
            prop_assert!(register == 0 || register & 1 == 1);
        }
    }

    #[test]
    fn requests_of_any_bytes_get_one_answer_each(
        requests in prop::collection::vec((any::<u8>(), 0..200_usize, any::<[u8; 4]>()), 1..100),
    ) {
        let mut device = Device::new();
        let mut may_be_in_a_block = false;
        for (command, place, [a, b, c, d]) in requests {
            let entries = crate::device::entries();
            let entry = &entries[place % entries.len()];
            let [low, high] = entry.index.to_le_bytes();
            device.node.receive(
                &Frame::data_frame(0x604, &[command, low, high, entry.sub, a, b, c, d]),
                device.now,
                &mut device.firmware,
            );
            let answers = device.sent().iter().filter(|frame| frame.starts_with("584")).count();
            // Within a block transfer a segment looks like any request, and a request may set off a sub-block.
            may_be_in_a_block |= command >> 5 >= 5;
            match command >> 5 {
                5 => prop_assert!(answers <= 127),
                _ if may_be_in_a_block => prop_assert!(answers <= 1),
                service => prop_assert_eq!(answers, usize::from(service != 4)),
            }
        }
    }
}

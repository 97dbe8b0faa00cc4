//! Whatever frames come at whatever times, the device keeps its contract, every service of it included.

use canopen::wire::cob_id;
use canopen::{Duration, Frame};
use proptest::prelude::*;
use proptest::test_runner::contextualize_config;
use tests::watched::{Step, Watched};

/// Requests to a server: mostly such as a client sends, in any order.
fn request() -> impl Strategy<Value = [u8; 8]> {
    let command = prop_oneof![
        // Initiates, segments, and the steps of block transfers.
        6 => prop::sample::select(vec![
            0x40, 0x60, 0x70, 0x20, 0x21, 0x22, 0x23, 0x2B, 0x2F, 0x00, 0x10, 0x01, 0x11, 0x0F, 0x80, 0xA0, 0xA4, 0xA3, 0xA2, 0xA1, 0xC2, 0xC6,
            0xC1, 0xC5, 0xD5, 0xDD, 0x81, 0x82, 0x83, 0x02, 0x03,
        ]),
        1 => any::<u8>(),
    ];
    let object = prop::sample::select(vec![
        (0x1000_u16, 0_u8),
        (0x1003, 0),
        (0x1005, 0),
        (0x1006, 0),
        (0x1007, 0),
        (0x100C, 0),
        (0x100D, 0),
        (0x1010, 1),
        (0x1011, 1),
        (0x1012, 0),
        (0x1014, 0),
        (0x1015, 0),
        (0x1016, 1),
        (0x1017, 0),
        (0x1018, 1),
        (0x1019, 0),
        (0x1029, 1),
        (0x1201, 1),
        (0x1201, 2),
        (0x1400, 1),
        (0x1400, 2),
        (0x1400, 5),
        (0x1600, 0),
        (0x1600, 1),
        (0x1800, 1),
        (0x1800, 2),
        (0x1800, 3),
        (0x1800, 5),
        (0x1800, 6),
        (0x1A00, 0),
        (0x1A00, 1),
        (0x1A00, 2),
        (0x1F80, 0),
        (0x2000, 0),
        (0x2001, 0),
        (0x2005, 0),
        (0x2007, 0),
        (0x2010, 0),
        (0x2012, 0),
        (0x5FFF, 0),
    ]);
    let data = prop_oneof![
        3 => (0..20_u32).prop_map(u32::to_le_bytes),
        2 => prop::sample::select(vec![0x8000_0000_u32, 0x4000_0080, 0x4000_0100, 0x8000_0184, 0x184, 0x4000_0184, 0x680, 0x681, 0x0005_0064, 0x2005_0020, 0x2014_0101, 0x2015_0010, 0x2007_0040, 10_000])
            .prop_map(u32::to_le_bytes),
        1 => any::<[u8; 4]>(),
    ];
    (command, object, data).prop_map(|(command, (index, sub), [a, b, c, d])| {
        let [low, high] = index.to_le_bytes();
        [command, low, high, sub, a, b, c, d]
    })
}

fn frame() -> impl Strategy<Value = Frame> {
    let own = prop::sample::select(vec![
        0x000_u16, 0x080, 0x084, 0x100, 0x184, 0x204, 0x304, 0x404, 0x604, 0x680, 0x704, 0x705,
        0x7E5,
    ]);
    let id = prop_oneof![8 => own, 2 => 0..0x800_u16].boxed();
    let nmt = (
        prop::sample::select(vec![0x01, 0x02, 0x80, 0x81, 0x82, 0x77]),
        0..6_u8,
    );
    prop_oneof![
        8 => (prop::sample::select(vec![0x604, 0x604, 0x604, 0x680]), request()).prop_map(|(id, data)| Frame::data_frame(id, &data)),
        4 => (id.clone(), prop::collection::vec(any::<u8>(), 0..=8)).prop_map(|(id, data)| Frame::data_frame(id, &data)),
        2 => nmt.prop_map(|(command, node)| Frame::data_frame(0, &[command, node])),
        2 => (id, 0..=8_u8).prop_map(|(id, length)| Frame::remote_frame(id, length)),
        1 => (5..7_u16, prop::sample::select(vec![0x00, 0x04, 0x05, 0x7F])).prop_map(|(node, state)| Frame::data_frame(0x700 + node, &[state])),
        1 => (1..=10_u8).prop_map(|counter| Frame::data_frame(0x080, &[counter])),
    ]
}

fn step() -> impl Strategy<Value = Step> {
    let span = prop_oneof![3 => 0..2_000_u64, 2 => 0..200_000_u64, 1 => 0..2_000_000_u64];
    prop_oneof![
        12 => frame().prop_map(Step::Frame),
        4 => span.prop_map(|ticks| Step::Pass(Duration::from_ticks(ticks))),
        1 => (0..30_u8).prop_map(Step::Report),
        1 => (0..30_u8).prop_map(Step::Clear),
        1 => any::<u32>().prop_map(Step::Change),
        6 => (0..20_u8).prop_map(Step::Transmit),
    ]
}

proptest! {
    #![proptest_config(contextualize_config(ProptestConfig::with_cases(400)))]

    #[test]
    fn c06_random_frames_at_random_times(steps in prop::collection::vec(step(), 1..300)) {
        let mut device = Watched::booted(4);
        for step in &steps {
            device.take(step).map_err(TestCaseError::fail)?;
        }
        device.recover().map_err(TestCaseError::fail)?;
    }

    #[test]
    fn c06_one_answer_to_each_request_on_a_free_bus(requests in prop::collection::vec((prop::bool::ANY, request()), 1..150)) {
        let mut device = Watched::booted(4);
        for (second, data) in [(false, [0x23, 0x01, 0x12, 1, 0x80, 0x06, 0, 0]), (false, [0x23, 0x01, 0x12, 2, 0x81, 0x06, 0, 0])].into_iter().chain(requests) {
            let (request, answer) = if second { (0x680, 0x681) } else { (0x604, 0x584) };
            device.take(&Step::Frame(Frame::data_frame(request, &data))).map_err(TestCaseError::fail)?;
            let sent = device.drain().map_err(TestCaseError::fail)?;
            let answers = sent.iter().filter(|frame| frame.standard_id() == Some(answer)).count();
            // Block uploads send sub-blocks; everything else, one frame.
            let most = match data[0] { 0x80..=0x9F => 0, 0xA0..=0xBF => 127, _ => 1 };
            prop_assert!(answers <= most.max(1), "{} answers to {:02X?}", answers, data);
        }
    }

    #[test]
    fn c06_a_device_without_a_node_id_sends_only_lss(steps in prop::collection::vec(step(), 1..200)) {
        let mut device = Watched::booted(255);
        for step in &steps {
            device.take(step).map_err(TestCaseError::fail)?;
            let is_restricted = |frame: &Frame| frame.standard_id().is_some_and(cob_id::is_restricted);
            let sent = device.drain().map_err(TestCaseError::fail)?;
            // LSS may have given it one.
            if device.is_configured() {
                return Ok(());
            }
            prop_assert!(sent.iter().all(|frame| frame.standard_id() == Some(0x7E4) && is_restricted(frame)), "{:?}", sent);
        }
    }
}

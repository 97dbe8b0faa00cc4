//! What a device does in the way of its maker, and the same device as the standards say.

use crate::device::Objects;
use canopen::cia301::nmt::Reset;
use canopen::cia301::sdo::AbortCode;
use canopen::od::{Dictionary, Habits, Table};
use canopen::{Event, Frame, Instant, Node, NodeId, Settings};

/// The small dictionary in a device of a maker who has other habits, or none.
struct Device<const HAS_HABITS: bool>(Objects);

impl<const HAS_HABITS: bool> Dictionary for Device<HAS_HABITS> {
    const TABLE: &'static Table = Objects::TABLE;

    const HABITS: Habits = if HAS_HABITS {
        Habits {
            factory: Habits::STANDARD.factory,
            node_id_at_once: true,
            short_sdo_requests: true,
            maps_while_valid: true,
            no_remote_requests: true,
            wrong_signature: AbortCode::DeviceState,
            wrong_history_count: AbortCode::ValueTooHigh,
            missing_mapped_object: Some(AbortCode::NotMappable),
            mapping_too_long: AbortCode::NotMappable,
        }
    } else {
        Habits::STANDARD
    };

    type Counts = <Objects as Dictionary>::Counts;

    fn ram(&self) -> &[u8] {
        self.0.ram()
    }

    fn ram_mut(&mut self) -> &mut [u8] {
        self.0.ram_mut()
    }
}

const NOW: Instant = Instant::from_ticks(1_000_000);

/// Node 4 in Pre-operational, with a store.
fn node<const HAS_HABITS: bool>() -> Node<Device<HAS_HABITS>> {
    let settings = Settings {
        node_id: NodeId::new(4).unwrap(),
        ..Settings::default()
    };
    let mut node = Node::new(Device(Objects::new()), settings);
    node.boot(Reset::Node, NOW, &mut ());
    assert!(node.transmit(&mut ()).is_some(), "the boot-up message");
    node
}

/// The answer to an SDO request.
fn answer<const HAS_HABITS: bool>(
    node: &mut Node<Device<HAS_HABITS>>,
    request: &[u8],
) -> Option<[u8; 8]> {
    node.receive(&Frame::data_frame(0x604, request), NOW, &mut ());
    node.poll(NOW, &mut ());
    Some(*node.transmit(&mut ())?.bytes())
}

/// The abort code of a download of four bytes, or of one; 0 if it is taken.
fn refusal<const HAS_HABITS: bool>(
    node: &mut Node<Device<HAS_HABITS>>,
    (index, sub): (u16, u8),
    value: &[u8],
) -> u32 {
    let [low, high] = index.to_le_bytes();
    let command = 0x23 | ((4 - value.len() as u8) << 2);
    let mut request = vec![command, low, high, sub];
    request.extend(value);
    request.resize(8, 0);
    match answer(node, &request).unwrap() {
        [0x60, ..] => 0,
        [0x80, _, _, _, a, b, c, d] => u32::from_le_bytes([a, b, c, d]),
        other => panic!("{other:02X?}"),
    }
}

/// The refusals of the same downloads, of the standard and of the maker.
fn refusals(object: (u16, u8), value: &[u8]) -> (u32, u32) {
    let standard = refusal(&mut node::<false>(), object, value);
    (standard, refusal(&mut node::<true>(), object, value))
}

#[test]
fn a_number_of_errors_and_bit_30_are_refused_in_the_way_of_the_maker() {
    assert_eq!(refusals((0x1003, 0), &[1]), (0x0609_0030, 0x0609_0031));
    // TPDO 1 stays off, with remote requests allowed.
    let cob_id = 0x8000_0184_u32.to_le_bytes();
    assert_eq!(refusals((0x1800, 1), &cob_id), (0, 0x0609_0030));
    let cob_id = 0xC000_0184_u32.to_le_bytes();
    assert_eq!(refusals((0x1800, 1), &cob_id), (0, 0));
}

#[test]
fn a_wrong_signature_is_refused_in_the_way_of_the_maker() {
    fn refused<const HAS_HABITS: bool>() -> u32 {
        let mut node = node::<HAS_HABITS>().with_parameter_store();
        refusal(&mut node, (0x1011, 1), b"save")
    }
    assert_eq!(
        (refused::<false>(), refused::<true>()),
        (0x0800_0020, 0x0800_0022)
    );
}

#[test]
fn a_short_request_is_answered_or_is_none() {
    let short = [0x40, 0x00, 0x10, 0x00];
    assert_eq!(answer(&mut node::<false>(), &short), None);
    let answer = answer(&mut node::<true>(), &short);
    assert_eq!(
        answer,
        Some([0x43, 0x00, 0x10, 0x00, 0x92, 0x01, 0x02, 0x00])
    );
}

#[test]
fn a_mapping_is_written_while_its_pdo_is_valid_and_stays_if_it_is_refused() {
    let entry = |index: u32| (index << 16 | 32).to_le_bytes();
    assert_eq!(refusals((0x1A00, 0), &[0]), (0x0601_0000, 0));
    let mut node = node::<true>();
    assert_eq!(refusal(&mut node, (0x1A00, 0), &[9]), 0x0604_0041);
    // Objects 2005h and 2006h are still sent, on start.
    node.receive(&Frame::data_frame(0, &[1, 4]), NOW, &mut ());
    node.poll(NOW, &mut ());
    let sent = node.transmit(&mut ()).unwrap();
    assert_eq!((sent.standard_id(), sent.length()), (Some(0x184), 8));
    node.receive(&Frame::data_frame(0, &[128, 4]), NOW, &mut ());
    assert_eq!(refusal(&mut node, (0x1A00, 0), &[0]), 0);
    assert_eq!(refusal(&mut node, (0x1A00, 1), &entry(0x5FFF)), 0x0604_0041);
    assert_eq!(refusal(&mut node, (0x1A00, 1), &entry(0x2006)), 0);
    assert_eq!(refusal(&mut node, (0x1A00, 0), &[1]), 0);
    node.receive(&Frame::data_frame(0, &[1, 4]), NOW, &mut ());
    node.poll(NOW, &mut ());
    let sent = node.transmit(&mut ()).unwrap();
    assert_eq!((sent.standard_id(), sent.length()), (Some(0x184), 4));
}

#[test]
fn a_node_id_of_lss_is_in_force_at_once_or_with_the_next_reset() {
    fn resets<const HAS_HABITS: bool>() -> bool {
        let mut node = node::<HAS_HABITS>();
        for request in [[0x04, 1], [0x11, 9], [0x04, 0]] {
            let [a, b] = request;
            let request = Frame::full(0x7E5, [a, b, 0, 0, 0, 0, 0, 0]);
            node.receive(&request, NOW, &mut ());
        }
        std::iter::from_fn(|| node.event())
            .any(|event| matches!(event, Event::ResetRequested(Reset::Communication)))
    }
    assert!(!resets::<false>());
    assert!(resets::<true>());
}

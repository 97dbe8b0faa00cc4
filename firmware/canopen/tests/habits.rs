//! What a device does in the way of its maker, and the same device as the standards say.

use crate::device::Objects;
use crate::device::ram_store::RamStore;
use canopen::cia301::emergency::Emergency;
use canopen::cia301::nmt::Reset;
use canopen::cia301::sdo::AbortCode;
use canopen::od::{Dictionary, ErrorMapping, Habits, Table};
use canopen::{Duration, Event, Frame, Instant, Node, NodeId, Settings};

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
            errors: &[
                ErrorMapping {
                    cause: 0x3210,
                    code: 0x3110,
                    register: 0x04,
                    info: [1, 0, 0, 0, 0],
                    history: 0,
                    number_byte: None,
                },
                ErrorMapping {
                    cause: 0x8210,
                    code: 0x8210,
                    register: 0x10,
                    info: [0; 5],
                    history: 0,
                    number_byte: Some(5),
                },
            ],
            acyclic_is_each_sync: true,
            short_sizes: true,
            mapped_length_of_0: true,
            settings_are_objects: true,
            lss_100_kbit: true,
            receives_at_nth_sync: true,
            stored_identifiers_stay: true,
            event_timer_in_100_us: true,
            tells_its_state: true,
            tells_of_the_rest: true,
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

fn settings(node_id: u8) -> Settings {
    Settings {
        node_id: NodeId::new(node_id).unwrap(),
        ..Settings::default()
    }
}

/// Node 4 in Pre-operational, with a store.
fn node<const HAS_HABITS: bool>() -> Node<Device<HAS_HABITS>> {
    let settings = settings(4);
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

/// The frames of emergencies that the device has.
fn emergencies<const HAS_HABITS: bool>(node: &mut Node<Device<HAS_HABITS>>) -> Vec<[u8; 8]> {
    node.poll(NOW, &mut ());
    let frames = std::iter::from_fn(|| node.transmit(&mut ()));
    let own = frames.filter(|frame| frame.standard_id() == Some(0x084));
    own.map(|frame| *frame.full_payload().unwrap()).collect()
}

#[test]
fn an_error_is_told_in_the_way_of_the_maker_and_another_as_it_is() {
    fn told<const HAS_HABITS: bool>(code: u16) -> (Vec<[u8; 8]>, u32) {
        let mut node = node::<HAS_HABITS>();
        let error = Emergency {
            code,
            register: 0x04,
            info: [7, 8, 0, 0, 0],
        };
        node.report(error, NOW);
        assert!(node.has_error(code), "the firmware keeps its own code");
        let frames = emergencies(&mut node);
        let entry = answer(&mut node, &[0x40, 0x03, 0x10, 1, 0, 0, 0, 0]).unwrap();
        node.clear(code, NOW);
        assert_eq!(emergencies(&mut node), [[0; 8]]);
        (frames, u32::from_le_bytes(entry[4..].try_into().unwrap()))
    }
    let standard = [0x10, 0x32, 0x05, 7, 8, 0, 0, 0];
    assert_eq!(told::<false>(0x3210), (vec![standard], 0x0807_3210));
    let rest = [0, 0, 0x05, 0, 0, 0, 0, 0];
    let own = [0x10, 0x31, 0x05, 1, 0, 0, 0, 0];
    assert_eq!(told::<true>(0x3210), (vec![own, rest], 0x3110));
    let unlisted = [0x20, 0x32, 0x05, 7, 8, 0, 0, 0];
    assert_eq!(told::<true>(0x3220), (vec![unlisted, rest], 0x0807_3220));
}

#[test]
fn the_number_of_a_pdo_stands_in_the_byte_of_the_maker() {
    fn first<const HAS_HABITS: bool>() -> [u8; 8] {
        let mut node = node::<HAS_HABITS>();
        let error = |number| Emergency {
            code: 0x8210,
            register: 0x10,
            info: [number, 0, 0, 0, 0],
        };
        node.report(error(3), NOW);
        node.report(error(4), NOW);
        let told = emergencies(&mut node);
        assert_eq!(
            told.iter()
                .filter(|frame| frame[..2] == [0x10, 0x82])
                .count(),
            2
        );
        told[0]
    }
    assert_eq!(first::<false>(), [0x10, 0x82, 0x11, 3, 0, 0, 0, 0]);
    assert_eq!(first::<true>(), [0x10, 0x82, 0x11, 0, 0, 3, 0, 0]);
}

#[test]
fn a_number_may_be_told_shorter_than_it_is() {
    // 2005h has four bytes, and the request says one.
    fn taken<const HAS_HABITS: bool>() -> u32 {
        let mut node = node::<HAS_HABITS>();
        let request = [0x2F, 0x05, 0x20, 0, 0x78, 0x56, 0x34, 0x12];
        let answer = answer(&mut node, &request).unwrap();
        assert_eq!(answer[0] == 0x60, HAS_HABITS, "{answer:02X?}");
        let read = self::answer(&mut node, &[0x40, 0x05, 0x20, 0, 0, 0, 0, 0]).unwrap();
        u32::from_le_bytes(read[4..].try_into().unwrap())
    }
    assert_ne!(taken::<false>(), 0x1234_5678);
    assert_eq!(taken::<true>(), 0x1234_5678);
    // More than the object has is more in any case.
    assert_eq!(
        refusals((0x1017, 0), &[1, 2, 3, 4]),
        (0x0607_0012, 0x0607_0012)
    );
}

/// What TPDO 1 sends with a mapping of the entry 2005h without its length; `None` if that is refused.
#[test]
fn a_mapped_object_without_a_length_has_its_own() {
    fn sent<const HAS_HABITS: bool>() -> Option<u8> {
        let mut node = node::<HAS_HABITS>();
        refusal(&mut node, (0x1800, 1), &0xC000_0184_u32.to_le_bytes());
        refusal(&mut node, (0x1A00, 0), &[0]);
        if refusal(&mut node, (0x1A00, 1), &0x2005_0000_u32.to_le_bytes()) != 0 {
            return None;
        }
        assert_eq!(refusal(&mut node, (0x1A00, 0), &[1]), 0);
        assert_eq!(
            refusal(&mut node, (0x1800, 1), &0x4000_0184_u32.to_le_bytes()),
            0
        );
        node.receive(&Frame::data_frame(0, &[1, 4]), NOW, &mut ());
        node.poll(NOW, &mut ());
        Some(node.transmit(&mut ()).unwrap().length())
    }
    assert_eq!(sent::<false>(), None);
    assert_eq!(sent::<true>(), Some(4));
}

#[test]
fn type_0_is_sent_at_each_sync_or_behind_an_event() {
    fn sent<const HAS_HABITS: bool>() -> usize {
        let mut node = node::<HAS_HABITS>();
        refusal(&mut node, (0x1800, 1), &0xC000_0184_u32.to_le_bytes());
        assert_eq!(refusal(&mut node, (0x1800, 2), &[0]), 0);
        assert_eq!(
            refusal(&mut node, (0x1800, 1), &0x4000_0184_u32.to_le_bytes()),
            0
        );
        node.receive(&Frame::data_frame(0, &[1, 4]), NOW, &mut ());
        let mut count = 0;
        for _ in 0..3 {
            node.receive(&Frame::data_frame(0x080, &[]), NOW, &mut ());
            node.poll(NOW, &mut ());
            let frames = std::iter::from_fn(|| node.transmit(&mut ()));
            count += frames
                .filter(|frame| frame.standard_id() == Some(0x184))
                .count();
        }
        count
    }
    // The start is an event.
    assert_eq!((sent::<false>(), sent::<true>()), (1, 3));
}

#[test]
fn index_5_of_lss_is_100_kbit_or_reserved() {
    fn answered<const HAS_HABITS: bool>() -> Vec<u8> {
        let mut node = node::<HAS_HABITS>();
        let mut codes = Vec::new();
        // Outside of the configuration state nobody answers.
        for request in [
            [0x13, 0, 5, 0, 0, 0, 0, 0],
            [0x04, 1, 0, 0, 0, 0, 0, 0],
            [0x13, 0, 5, 0, 0, 0, 0, 0],
            [0x13, 1, 5, 0, 0, 0, 0, 0],
        ] {
            node.receive(&Frame::full(0x7E5, request), NOW, &mut ());
            node.poll(NOW, &mut ());
            codes.extend(node.transmit(&mut ()).map(|answer| answer.payload()[1]));
        }
        codes
    }
    assert_eq!(answered::<false>(), [1, 1]);
    assert_eq!(answered::<true>(), [0, 1]);
}

#[test]
fn a_receive_pdo_of_type_3_counts_at_the_third_sync_or_at_the_next() {
    /// What 2003h is behind each of four SYNCs.
    fn applied<const HAS_HABITS: bool>() -> Vec<u8> {
        let mut node = node::<HAS_HABITS>();
        refusal(&mut node, (0x1400, 1), &0x8000_0204_u32.to_le_bytes());
        assert_eq!(refusal(&mut node, (0x1400, 2), &[3]), 0);
        refusal(&mut node, (0x1400, 1), &0x0000_0204_u32.to_le_bytes());
        node.receive(&Frame::data_frame(0, &[1, 4]), NOW, &mut ());
        let mut seen = Vec::new();
        for beat in 1..=4 {
            // A newer frame takes the place of the one that waits, and begins no new count.
            node.receive(&Frame::full(0x204, [beat; 8]), NOW, &mut ());
            node.receive(&Frame::data_frame(0x080, &[]), NOW, &mut ());
            node.poll(NOW, &mut ());
            let entry = canopen::od::find::<Device<HAS_HABITS>>(0x2003, 0).unwrap();
            seen.push(canopen::od::value(node.dictionary(), entry)[0]);
        }
        seen
    }
    assert_eq!(applied::<false>(), [1, 2, 3, 4]);
    assert_eq!(applied::<true>(), [0, 0, 3, 3]);
}

#[test]
fn a_stored_identifier_follows_the_node_id_or_stays() {
    /// 1400h:1 of a device that was node 4 when it stored it, and is node 9.
    fn identifier<const HAS_HABITS: bool>() -> Vec<u8> {
        let mut store = RamStore::default();
        let mut node = node::<HAS_HABITS>().with_parameter_store();
        let save = [0x23, 0x10, 0x10, 1, b's', b'a', b'v', b'e'];
        assert_eq!(
            answer(&mut node, &save),
            None,
            "it is answered when it is done"
        );
        while node.is_storing() {
            node.store_parameters(&mut store, NOW);
        }
        let device = Device::<HAS_HABITS>(Objects::new());
        let mut node = Node::new(device, settings(9)).with_parameter_store();
        node.boot(Reset::Node, NOW, &mut ());
        node.load_parameters(&mut store, NOW, &mut ());
        let entry = canopen::od::find::<Device<HAS_HABITS>>(0x1400, 1).unwrap();
        canopen::od::value(node.dictionary(), entry).to_vec()
    }
    assert_eq!(identifier::<false>(), [0x09, 0x02, 0, 0]);
    assert_eq!(identifier::<true>(), [0x04, 0x02, 0, 0]);
}

#[test]
fn an_event_timer_counts_in_100_us_or_in_milliseconds() {
    /// The microseconds from one frame of TPDO 1 to the next, whose timer was 8 from the start and is 30 then.
    fn pauses<const HAS_HABITS: bool>() -> [u64; 2] {
        let mut node = node::<HAS_HABITS>();
        refusal(&mut node, (0x1800, 1), &0xC000_0184_u32.to_le_bytes());
        assert_eq!(refusal(&mut node, (0x1800, 2), &[255]), 0);
        assert_eq!(refusal(&mut node, (0x1800, 3), &[0, 0]), 0);
        assert_eq!(refusal(&mut node, (0x1800, 5), &[8, 0]), 0);
        let on = 0x4000_0184_u32.to_le_bytes();
        assert_eq!(refusal(&mut node, (0x1800, 1), &on), 0);
        node.receive(&Frame::data_frame(0, &[1, 4]), NOW, &mut ());
        let mut pauses = [0, 0];
        for (index, pause) in pauses.iter_mut().enumerate() {
            let mut came = Vec::new();
            for tick in 0..1_000 {
                let now = NOW + Duration::from_ticks(index as u64 * 100_000 + tick * 100);
                node.poll(now, &mut ());
                let frames = std::iter::from_fn(|| node.transmit(&mut ()));
                let own = |frame: &Frame| frame.standard_id() == Some(0x184);
                came.extend(frames.filter(own).map(|_| now));
            }
            let [.., before, last] = came[..] else {
                panic!("{came:?}")
            };
            *pause = last.ticks() - before.ticks();
            assert_eq!(refusal(&mut node, (0x1800, 5), &[30, 0]), 0);
        }
        pauses
    }
    assert_eq!(pauses::<false>(), [8_000, 30_000]);
    assert_eq!(pauses::<true>(), [800, 3_000]);
}

#[test]
fn a_change_of_the_state_is_told_or_not() {
    fn told<const HAS_HABITS: bool>() -> Vec<u8> {
        let mut node = node::<HAS_HABITS>();
        let mut states = Vec::new();
        for command in [1, 1, 2, 128] {
            node.receive(&Frame::data_frame(0, &[command, 4]), NOW, &mut ());
            node.poll(NOW, &mut ());
            while let Some(frame) = node.transmit(&mut ()) {
                if frame.standard_id() == Some(0x704) {
                    states.push(frame.payload()[0]);
                }
            }
        }
        states
    }
    assert_eq!(told::<false>(), []);
    assert_eq!(told::<true>(), [5, 4, 127]);
}

//! What a device does that was compiled without some services: as if it had never heard of them.

use crate::device::Objects;
use canopen::cia301::nmt::Reset;
use canopen::cia301::sdo::AbortCode;
use canopen::od::{Dictionary, Entry, Features, Table};
use canopen::{Application, Frame, Instant, Node, NodeId, Settings};

/// The small dictionary in a device that has no LSS and no block transfer, no object of guarding, and of the dummies UNSIGNED8 alone.
struct Plain(Objects);

impl Dictionary for Plain {
    const TABLE: &'static Table = Objects::TABLE;

    const FEATURES: Features = Features {
        lss: false,
        block_transfer: false,
        guarding: false,
        dummies: 1 << 5,
        ..Features::of(Objects::TABLE)
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

/// Node 4 in Pre-operational.
fn node() -> Node<Plain> {
    let settings = Settings {
        node_id: NodeId::new(4).unwrap(),
        ..Settings::default()
    };
    let mut node = Node::new(Plain(Objects::new()), settings);
    node.boot(Reset::Node, NOW, &mut ());
    assert!(node.transmit(&mut ()).is_some(), "the boot-up message");
    node
}

/// What is sent after this frame.
fn answer(node: &mut Node<Plain>, frame: &Frame) -> Option<(u16, [u8; 8])> {
    node.receive(frame, NOW, &mut ());
    node.poll(NOW, &mut ());
    let answer = node.transmit(&mut ())?;
    Some((answer.standard_id()?, *answer.bytes()))
}

#[test]
fn block_transfer_is_an_unknown_command() {
    let mut node = node();
    for command in [0xA4, 0xA3, 0xA2, 0xA1, 0xC6, 0xC2, 0xC1] {
        let request = Frame::full(0x604, [command, 0x08, 0x10, 0, 0x7F, 0, 0, 0]);
        // 05040001h: command specifier not valid.
        let expected = [0x80, 0x08, 0x10, 0, 0x01, 0x00, 0x04, 0x05];
        assert_eq!(
            answer(&mut node, &request),
            Some((0x584, expected)),
            "{command:02X}h"
        );
    }
    let request = Frame::full(0x604, [0x40, 0x00, 0x10, 0, 0, 0, 0, 0]);
    let (_, [command, ..]) = answer(&mut node, &request).unwrap();
    assert_eq!(command, 0x43, "other transfers go on");
}

#[test]
fn lss_requests_are_for_others() {
    let mut node = node();
    for request in [[4, 1, 0, 0, 0, 0, 0, 0], [0x5E, 0, 0, 0, 0, 0, 0, 0]] {
        assert_eq!(answer(&mut node, &Frame::full(0x7E5, request)), None);
    }
    assert!(node.event().is_some(), "Pre-operational");
    assert_eq!(node.event(), None);
    let request = Frame::full(0x604, [0x40, 0, 0x10, 0, 0, 0, 0, 0]);
    assert!(answer(&mut node, &request).is_some(), "what is for it");
}

#[test]
fn a_question_of_a_guarding_master_gets_no_answer() {
    let mut node = node();
    assert_eq!(answer(&mut node, &Frame::remote_frame(0x704, 1)), None);
    let upload = Frame::full(0x604, [0x40, 0x00, 0x10, 0, 0, 0, 0, 0]);
    assert!(answer(&mut node, &upload).is_some(), "it lives");
}

#[test]
fn p10_a_dummy_that_is_not_listed_is_refused() {
    let mut node = node();
    for (request, code) in [
        // RPDO 1 off, its mapping empty; then UNSIGNED8, UNSIGNED16 and BOOLEAN.
        ([0x23, 0x00, 0x14, 1, 0x04, 0x02, 0, 0x80], [0; 4]),
        ([0x2F, 0x00, 0x16, 0, 0, 0, 0, 0], [0; 4]),
        ([0x23, 0x00, 0x16, 1, 8, 0, 5, 0], [0; 4]),
        ([0x23, 0x00, 0x16, 1, 16, 0, 6, 0], [0x41, 0x00, 0x04, 0x06]),
        ([0x23, 0x00, 0x16, 1, 1, 0, 1, 0], [0x41, 0x00, 0x04, 0x06]),
    ] {
        let (_, bytes) = answer(&mut node, &Frame::full(0x604, request)).unwrap();
        assert_eq!(bytes[4..], code, "to {request:02X?}");
        assert_eq!(bytes[0], if code == [0; 4] { 0x60 } else { 0x80 });
    }
}

/// An application that tells how long its objects are, and nothing more.
struct Sizes;

impl Application<Objects> for Sizes {
    fn size(&mut self, _: &Objects, _: &Entry) -> Result<Option<u32>, AbortCode> {
        Ok(Some(4))
    }
}

#[test]
fn an_application_that_gives_no_bytes_of_a_stream_refuses_it() {
    let settings = Settings {
        node_id: NodeId::new(4).unwrap(),
        ..Settings::default()
    };
    let mut node = Node::new(Objects::new(), settings);
    node.boot(Reset::Node, NOW, &mut Sizes);
    node.transmit(&mut Sizes);
    let request = Frame::full(0x604, [0x40, 0x14, 0x20, 0, 0, 0, 0, 0]);
    node.receive(&request, NOW, &mut Sizes);
    let sent = node.transmit(&mut Sizes).unwrap();
    assert_eq!(*sent.bytes(), [0x80, 0x14, 0x20, 0, 0, 0, 0x01, 0x06]);
}

#[test]
fn an_application_that_serves_no_stream_refuses_it_before_the_first_segment() {
    let settings = Settings {
        node_id: NodeId::new(4).unwrap(),
        ..Settings::default()
    };
    let mut node = Node::new(Objects::new(), settings);
    node.boot(Reset::Node, NOW, &mut ());
    node.transmit(&mut ());
    // Up and down, by blocks and by segments: 06010000h, unsupported access.
    for (command, argument) in [(0xA4, 0x7F), (0x40, 0), (0xC0, 0), (0x20, 0)] {
        let request = Frame::full(0x604, [command, 0x14, 0x20, 0, argument, 0, 0, 0]);
        node.receive(&request, NOW, &mut ());
        let sent = node.transmit(&mut ()).unwrap();
        let refused = [0x80, 0x14, 0x20, 0, 0, 0, 0x01, 0x06];
        assert_eq!(*sent.bytes(), refused, "to {command:02X}h");
    }
}

//! The CANopen device: node-ID 10, four RPDOs and four TPDOs, of which the first are valid with two numbers of 32 bits each.

use canopen::cia301::emergency::{Emergency, ErrorRegister};
use canopen::cia301::nmt::Reset;
use canopen::{BitRate, Duration, Frame, Instant, Node, NodeId, Settings};
use core::mem::size_of;
use heapless::Vec;

use crate::block::Domain;
use crate::{block, count, row};

mod test_device {
    include!(concat!(env!("OUT_DIR"), "/test_device.rs"));
}

pub use test_device::Dictionary;

const NODE_ID: u16 = 10;
pub const REQUEST: u16 = 0x600 + NODE_ID;
pub const ANSWER: u16 = 0x580 + NODE_ID;

/// A transmit mailbox that always has room.
type Mailbox = Vec<Frame, 128>;

/// The device and what is around it.
pub struct Device {
    node: Node<Dictionary>,
    pub application: Domain,
    now: Instant,
    pub sent: Mailbox,
    /// Instructions in all regions since the last row.
    total: u32,
}

/// One pass of the node task with a frame.
#[inline(never)]
fn serve(
    node: &mut Node<Dictionary>,
    frame: &Frame,
    now: Instant,
    application: &mut Domain,
    sent: &mut Mailbox,
) {
    node.receive(frame, now, application);
    pass(node, now, application, sent);
}

/// One pass of the node task without.
#[inline(never)]
fn pass(node: &mut Node<Dictionary>, now: Instant, application: &mut Domain, sent: &mut Mailbox) {
    node.poll(now, application);
    while let Some(frame) = node.transmit(application) {
        let _ = sent.push(frame);
    }
}

impl Device {
    fn new() -> Self {
        let settings = Settings {
            node_id: NodeId::new(NODE_ID as u8).unwrap(),
            bit_rate: BitRate::Kbit1000,
        };
        let mut device = Self {
            node: Node::new(Dictionary::new(), settings),
            application: Domain::new(),
            now: Instant::from_ticks(0),
            sent: Mailbox::new(),
            total: 0,
        };
        device
            .node
            .boot(Reset::Node, device.now, &mut device.application);
        device
    }

    /// A millisecond passes, then a frame comes.
    pub fn receive(&mut self, cob_id: u16, data: &[u8]) {
        self.now += Duration::millis(1);
        self.sent.clear();
        let frame = Frame::data_frame(cob_id, data);
        let (count, ()) = count(|| {
            serve(
                &mut self.node,
                &frame,
                self.now,
                &mut self.application,
                &mut self.sent,
            );
        });
        self.total += count;
    }

    /// A millisecond passes.
    fn idle(&mut self) {
        self.now += Duration::millis(1);
        self.sent.clear();
        let (count, ()) = count(|| {
            pass(
                &mut self.node,
                self.now,
                &mut self.application,
                &mut self.sent,
            );
        });
        self.total += count;
    }

    /// Exactly this frame was sent.
    #[track_caller]
    pub fn expect(&self, cob_id: u16, data: &[u8]) {
        assert_eq!(self.sent.len(), 1, "one frame: {:?}", self.sent);
        let frame = &self.sent[0];
        assert_eq!(frame.standard_id(), Some(cob_id));
        assert_eq!(frame.payload(), data);
    }

    #[track_caller]
    pub fn expect_nothing(&self) {
        assert!(self.sent.is_empty(), "nothing: {:?}", self.sent);
    }

    /// An SDO request and its answer.
    #[track_caller]
    pub fn sdo(&mut self, request: [u8; 8], answer: [u8; 8]) {
        self.receive(REQUEST, &request);
        self.expect(ANSWER, &answer);
    }

    /// Writes an object of up to four bytes.
    #[track_caller]
    fn write(&mut self, index: u16, sub: u8, value: &[u8]) {
        let [low, high] = index.to_le_bytes();
        let mut request = [
            0x23 | (4 - value.len() as u8) << 2,
            low,
            high,
            sub,
            0,
            0,
            0,
            0,
        ];
        request[4..4 + value.len()].copy_from_slice(value);
        self.sdo(request, [0x60, low, high, sub, 0, 0, 0, 0]);
    }

    fn operational(&mut self) {
        self.receive(0x000, &[1, NODE_ID as u8]);
    }

    fn pre_operational(&mut self) {
        self.receive(0x000, &[0x80, NODE_ID as u8]);
    }

    /// Ends a workload.
    pub fn row(&mut self, name: &str) {
        row(name, self.total);
        self.total = 0;
    }

    /// What was done so far was preparation.
    fn ready(&mut self) {
        self.total = 0;
    }
}

/// All workloads of the device.
pub fn run() {
    let mut device = Device::new();
    device.idle();
    device.expect(0x700 + NODE_ID, &[0]);
    device.ready();
    sdo(&mut device);
    block::run(&mut device);
    pdo(&mut device);
    rest(&mut device);
}

fn sdo(device: &mut Device) {
    device.sdo(
        [0x40, 0x00, 0x20, 0, 0, 0, 0, 0],
        [0x43, 0x00, 0x20, 0, 0, 0, 0, 0],
    );
    device.row("SDO upload, expedited");

    device.sdo(
        [0x23, 0x00, 0x20, 0, 0x44, 0x33, 0x22, 0x11],
        [0x60, 0x00, 0x20, 0, 0, 0, 0, 0],
    );
    device.row("SDO download, expedited");
    assert_eq!(device.node.dictionary().number(), 0x1122_3344);

    device.sdo(
        [0x40, 0xFF, 0x5F, 0, 0, 0, 0, 0],
        [0x80, 0xFF, 0x5F, 0, 0x00, 0x00, 0x02, 0x06],
    );
    device.row("SDO abort, no such object");

    let text = *b"ABCDEFGHIJKLMNOPQRSTUVWXYZABCDEFGHIJKLMNOPQRSTUVWXYZABCDEFGHIJKL";
    device.sdo(
        [0x40, 0x01, 0x20, 0, 0, 0, 0, 0],
        [0x41, 0x01, 0x20, 0, 64, 0, 0, 0],
    );
    let mut toggle = 0;
    for segment in text.chunks(7) {
        let unused = 7 - segment.len() as u8;
        let last = u8::from(unused > 0);
        let mut answer = [0; 8];
        answer[0] = toggle | unused << 1 | last;
        answer[1..1 + segment.len()].copy_from_slice(segment);
        device.sdo([0x60 | toggle, 0, 0, 0, 0, 0, 0, 0], answer);
        toggle ^= 0x10;
    }
    device.row("SDO upload, segmented, 64 bytes");

    let text = text.map(|byte| byte.to_ascii_lowercase());
    device.sdo(
        [0x21, 0x01, 0x20, 0, 64, 0, 0, 0],
        [0x60, 0x01, 0x20, 0, 0, 0, 0, 0],
    );
    let mut toggle = 0;
    for segment in text.chunks(7) {
        let unused = 7 - segment.len() as u8;
        let mut request = [0; 8];
        request[0] = toggle | unused << 1 | u8::from(unused > 0);
        request[1..1 + segment.len()].copy_from_slice(segment);
        device.sdo(request, [0x20 | toggle, 0, 0, 0, 0, 0, 0, 0]);
        toggle ^= 0x10;
    }
    device.row("SDO download, segmented, 64 bytes");
    // Read back: the size, then the first segment.
    device.sdo(
        [0x40, 0x01, 0x20, 0, 0, 0, 0, 0],
        [0x41, 0x01, 0x20, 0, 64, 0, 0, 0],
    );
    device.sdo([0x60, 0, 0, 0, 0, 0, 0, 0], *b"\x00abcdefg");
    device.receive(REQUEST, &[0x80, 0x01, 0x20, 0, 0, 0, 0, 0]);
    device.ready();
}

fn pdo(device: &mut Device) {
    // Only the first PDOs are valid; the TPDO is sent by event.
    for n in 1..4u16 {
        let id = u32::from(NODE_ID);
        let invalid = 1 << 31;
        device.write(
            0x1400 + n,
            1,
            &(invalid | (0x200 + 0x100 * u32::from(n) + id)).to_le_bytes(),
        );
        device.write(
            0x1800 + n,
            1,
            &(invalid | (1 << 30) | (0x180 + 0x100 * u32::from(n) + id)).to_le_bytes(),
        );
    }
    device.write(0x1800, 2, &[254]);
    device.operational();
    device.idle();
    device.idle();
    device.ready();

    device.receive(0x200 + NODE_ID, &[1, 2, 3, 4, 5, 6, 7, 8]);
    device.expect_nothing();
    device.row("RPDO");
    assert_eq!(device.node.dictionary().received_number_1(), 0x0403_0201);
    assert_eq!(device.node.dictionary().received_number_2(), 0x0807_0605);

    device.node.dictionary_mut().set_sent_number_1(0x1122_3344);
    device.idle();
    device.expect(0x180 + NODE_ID, &[0x44, 0x33, 0x22, 0x11, 0, 0, 0, 0]);
    device.row("TPDO on event");

    device.receive(0x080, &[]);
    device.expect_nothing();
    device.row("SYNC, no synchronous PDO");

    device.pre_operational();
    device.write(0x1800, 2, &[1]);
    device.operational();
    device.idle();
    device.ready();
    device.node.dictionary_mut().set_sent_number_2(0x5566_7788);
    device.receive(0x080, &[]);
    device.expect(
        0x180 + NODE_ID,
        &[0x44, 0x33, 0x22, 0x11, 0x88, 0x77, 0x66, 0x55],
    );
    device.row("SYNC, one TPDO");

    device.pre_operational();
    device.write(0x1400, 2, &[1]);
    device.operational();
    device.idle();
    device.receive(0x200 + NODE_ID, &[8, 7, 6, 5, 4, 3, 2, 1]);
    device.expect_nothing();
    device.ready();
    assert_eq!(device.node.dictionary().received_number_1(), 0x0403_0201);
    device.receive(0x080, &[]);
    device.expect(
        0x180 + NODE_ID,
        &[0x44, 0x33, 0x22, 0x11, 0x88, 0x77, 0x66, 0x55],
    );
    device.row("SYNC, one RPDO and one TPDO");
    assert_eq!(device.node.dictionary().received_number_1(), 0x0506_0708);
    assert_eq!(device.node.dictionary().received_number_2(), 0x0102_0304);
}

fn rest(device: &mut Device) {
    device.receive(0x185, &[1, 2, 3, 4]);
    device.expect_nothing();
    device.row("foreign frame");

    for _ in 0..1000 {
        device.idle();
        device.expect_nothing();
    }
    device.total /= 1000;
    device.row("idle millisecond");

    // A new period begins with a heartbeat at once; the one after is counted.
    device.receive(REQUEST, &[0x2B, 0x17, 0x10, 0, 100, 0, 0, 0]);
    loop {
        device.ready();
        device.idle();
        if !device.sent.is_empty() {
            break;
        }
    }
    device.expect(0x700 + NODE_ID, &[5]);
    device.row("heartbeat, its millisecond");
    device.write(0x1017, 0, &[0, 0]);
    device.idle();
    device.ready();

    let emergency = Emergency {
        code: 0x2310,
        register: ErrorRegister::CURRENT,
        info: [1, 2, 3, 4, 5],
    };
    device.now += Duration::millis(1);
    device.sent.clear();
    let (count, ()) = count(|| {
        device.node.report(emergency, device.now);
        pass(
            &mut device.node,
            device.now,
            &mut device.application,
            &mut device.sent,
        );
    });
    device.total = count;
    device.expect(0x080 + NODE_ID, &[0x10, 0x23, 0x03, 1, 2, 3, 4, 5]);
    device.row("EMCY, report and send");
}

/// Frames of eight bytes that 1 Mbit/s carries in a second, back to back and without a stuff bit: 111 bits each.
const FULL_LOAD: u32 = 1_000_000 / 111;

/// Instructions of the STM32F405 in a second: 168 MHz, and a cycle and a half for each.
const INSTRUCTIONS_PER_SECOND: u32 = 168_000_000 * 2 / 3;

/// What the CPU is busy with when the bus never rests, in thousandths.
pub fn load() {
    let mut device = Device::new();
    device.operational();
    device.idle();
    device.ready();
    let frames = [
        ("every frame a receive PDO", 0x200 + NODE_ID),
        ("every frame for other devices", 0x185),
    ];
    for (name, cob_id) in frames {
        for number in 0..100 {
            device.now += Duration::from_ticks(111);
            device.sent.clear();
            let frame = Frame::full(cob_id, [number; 8]);
            let (count, ()) = count(|| {
                serve(
                    &mut device.node,
                    &frame,
                    device.now,
                    &mut device.application,
                    &mut device.sent,
                );
            });
            device.total += count;
        }
        let each = device.total / 100;
        let thousandths = u64::from(each * FULL_LOAD) * 1000 / u64::from(INSTRUCTIONS_PER_SECOND);
        row(name, thousandths as u32);
        device.ready();
    }
}

/// The RAM of the device, in bytes.
pub fn memory() {
    let values = size_of::<Dictionary>();
    let device = size_of::<Node<Dictionary>>();
    row("the device, in all", device as u32);
    row("of it, the values of the dictionary", values as u32);
    row("beside the values", (device - values) as u32);
}

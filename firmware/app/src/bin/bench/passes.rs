//! One pass of the node task of the whole drive, by the way that its product takes: [`cia402::Device`] and [`Outbox`].

use canopen::od;
use canopen::outbox::{Mailbox, Mailboxes};
use canopen::{Duration, Frame, Instant, Outbox};
use heapless::Vec;

use crate::drive::Bench;
use crate::{count, row};

const NODE_ID: u16 = 10;
const REQUEST: u16 = 0x600 + NODE_ID;
const ANSWER: u16 = 0x580 + NODE_ID;

/// Mailboxes that always have room.
struct Sent(Vec<Frame, 8>);

impl Mailboxes for Sent {
    fn mailbox_for(&mut self, _: u16) -> Mailbox {
        Mailbox::Free
    }

    fn put(&mut self, frame: &Frame) -> Option<Frame> {
        self.0.push(*frame).err()
    }
}

/// A pass of the node task.
#[inline(never)]
fn pass(
    bench: &mut Bench,
    outbox: &mut Outbox<3>,
    frame: Option<&Frame>,
    now: Instant,
    sent: &mut Sent,
) {
    let Bench {
        device, exchange, ..
    } = bench;
    if let Some(frame) = frame {
        device.receive(frame, now, exchange);
    }
    device.poll(now, exchange);
    device.drop_late(now);
    outbox.send(device, sent);
}

/// The drive in its workloads.
struct Passes {
    bench: Bench,
    outbox: Outbox<3>,
    now: Instant,
    sent: Sent,
    /// Instructions since the last row.
    total: u32,
}

impl Passes {
    /// A millisecond passes with its control tick, which is not counted; then a frame comes, or none.
    fn pass(&mut self, frame: Option<&Frame>) {
        self.now += Duration::millis(1);
        self.sent.0.clear();
        self.bench.tick(self.now);
        let Self {
            bench,
            outbox,
            now,
            sent,
            ..
        } = self;
        let (count, ()) = count(|| pass(bench, outbox, frame, *now, sent));
        self.total += count;
    }

    /// A number of 32 bits of the dictionary.
    fn number(&self, index: u16) -> Option<u32> {
        od::read_u32(self.bench.device.node().dictionary(), index, 0)
    }

    fn receive(&mut self, cob_id: u16, data: &[u8]) {
        self.pass(Some(&Frame::data_frame(cob_id, data)));
    }

    /// Exactly this frame was sent.
    #[track_caller]
    fn expect(&self, cob_id: u16, data: &[u8]) {
        assert_eq!(self.sent.0.len(), 1, "one frame: {:?}", self.sent.0);
        assert_eq!(self.sent.0[0].standard_id(), Some(cob_id));
        assert_eq!(self.sent.0[0].payload(), data);
    }

    #[track_caller]
    fn expect_nothing(&self) {
        assert!(self.sent.0.is_empty(), "nothing: {:?}", self.sent.0);
    }

    /// An SDO request with this command specifier, and the answer to it.
    #[track_caller]
    fn sdo_exchange(
        &mut self,
        [command, answer]: [u8; 2],
        index: u16,
        sub: u8,
        [value, answered]: [u32; 2],
    ) {
        let [low, high] = index.to_le_bytes();
        let bytes = |command, value: u32| {
            let [a, b, c, d] = value.to_le_bytes();
            [command, low, high, sub, a, b, c, d]
        };
        self.receive(REQUEST, &bytes(command, value));
        self.expect(ANSWER, &bytes(answer, answered));
    }

    fn write_u32(&mut self, index: u16, sub: u8, value: u32) {
        self.sdo_exchange([0x23, 0x60], index, sub, [value, 0]);
    }

    fn write_u8(&mut self, index: u16, sub: u8, value: u8) {
        self.sdo_exchange([0x2F, 0x60], index, sub, [value.into(), 0]);
    }

    fn state(&mut self, command: u8) {
        self.receive(0x000, &[command, NODE_ID as u8]);
        for _ in 0..3 {
            self.pass(None);
        }
        self.total = 0;
    }

    fn row(&mut self, name: &str) {
        row(name, self.total);
        self.total = 0;
    }

    fn sdo(&mut self) {
        let before = self.number(0x6081).unwrap();
        self.sdo_exchange([0x40, 0x43], 0x6081, 0, [0, before]);
        self.row("SDO upload, expedited");

        self.write_u32(0x6081, 0, 10_000);
        self.row("SDO download, expedited");
        assert_eq!(self.number(0x6081), Some(10_000));

        self.sdo_exchange([0x40, 0x80], 0x5FFF, 0, [0, 0x0602_0000]);
        self.row("SDO abort, no such object");
    }

    fn pdo(&mut self) {
        // The fourth PDOs are used, eight bytes each: 607Ah and 6081h, 6064h and 6062h.
        let id = u32::from(NODE_ID);
        for n in 0..3 {
            let offset = 0x100 * u32::from(n) + id;
            self.write_u32(0x1400 + n, 1, (1 << 31) + 0x200 + offset);
            self.write_u32(0x1800 + n, 1, (3 << 30) + 0x180 + offset);
        }
        self.write_u8(0x1803, 2, 254);
        let (rpdo, tpdo) = (0x500 + NODE_ID, 0x480 + NODE_ID);
        self.state(1);

        self.receive(rpdo, &[1, 2, 0, 0, 5, 6, 0, 0]);
        self.expect_nothing();
        self.row("RPDO");
        assert_eq!(self.number(0x607A), Some(0x0201));
        assert_eq!(self.number(0x6081), Some(0x0605));

        self.receive(0x080, &[]);
        self.expect_nothing();
        self.row("SYNC, no synchronous PDO");

        self.state(0x80);
        self.write_u8(0x1803, 2, 1);
        self.state(1);
        self.receive(0x080, &[]);
        self.expect(tpdo, &[0; 8]);
        self.row("SYNC, one TPDO");

        self.state(0x80);
        self.write_u8(0x1403, 2, 1);
        self.state(1);
        self.receive(rpdo, &[3, 4, 0, 0, 7, 8, 0, 0]);
        self.expect_nothing();
        self.total = 0;
        assert_eq!(self.number(0x607A), Some(0x0201));
        self.receive(0x080, &[]);
        self.expect(tpdo, &[0; 8]);
        self.row("SYNC, one RPDO and one TPDO");
        assert_eq!(self.number(0x607A), Some(0x0403));
        assert_eq!(self.number(0x6081), Some(0x0807));
    }

    fn rest(&mut self) {
        self.receive(0x185, &[1, 2, 3, 4]);
        self.expect_nothing();
        self.row("foreign frame");

        for _ in 0..1000 {
            self.pass(None);
            self.expect_nothing();
        }
        self.total /= 1000;
        self.row("idle millisecond");

        // A new period begins with a heartbeat at once; the one after is counted.
        self.receive(REQUEST, &[0x2B, 0x17, 0x10, 0, 100, 0, 0, 0]);
        assert_eq!(self.sent.0.len(), 2);
        loop {
            self.total = 0;
            self.pass(None);
            if !self.sent.0.is_empty() {
                break;
            }
        }
        self.expect(0x700 + NODE_ID, &[5]);
        self.row("heartbeat, its millisecond");
    }
}

/// The rows.
pub fn run() {
    let bench = Bench::new(false);
    let mut passes = Passes {
        now: bench.now,
        bench,
        outbox: Outbox::new(),
        sent: Sent(Vec::new()),
        total: 0,
    };
    passes.sdo();
    passes.pdo();
    passes.rest();
}

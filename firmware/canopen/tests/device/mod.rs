//! The device under test: a node with a small dictionary, on virtual time, and frames as the cases write them (`notation`).

pub mod block;
mod notation;
mod objects;
pub mod ram_store;
mod stream;

pub use notation::{frame, show};
pub use objects::Objects;
pub use stream::Stream;

use canopen::cia301::nmt::Reset;
use canopen::cia301::sdo::{AbortCode, Completion};
use canopen::od::{self, Dictionary, Entry};
use canopen::{Application, Duration, Event, Frame, Instant, Node, NodeId, Settings};

/// The firmware around the device: object 2013h cannot be written while a motor runs; the serial number is 12345678h.
#[derive(Debug, Default)]
pub struct Firmware {
    pub is_running: bool,
    pub written: Vec<(u16, u8)>,
    pub power_ons: usize,
    /// What the power-on value of 1F80h is, if it is not the one of the data sheet.
    pub startup: Option<u32>,
    /// What the power-on values of 1016h are, if they are not those of the data sheet.
    pub watched: [u32; 3],
    /// What objects 2014h and 2015h are.
    pub stream: Stream,
}

impl Application<Objects> for Firmware {
    fn validate(&mut self, _: &Objects, entry: &Entry, _: &[u8]) -> Result<(), AbortCode> {
        if entry.index == 0x2013 && self.is_running {
            return Err(AbortCode::DeviceState);
        }
        Ok(())
    }

    fn written(&mut self, _: &mut Objects, entry: &Entry) {
        self.written.push((entry.index, entry.sub));
    }

    fn size(&mut self, _: &Objects, _: &Entry) -> Result<Option<u32>, AbortCode> {
        Ok(self.stream.size())
    }

    fn read_at(
        &mut self,
        _: &Objects,
        _: &Entry,
        position: u32,
        into: &mut [u8],
    ) -> Result<usize, AbortCode> {
        self.stream.read_at(position, into)
    }

    fn begin_write(&mut self, _: &Objects, _: &Entry, _: Option<u32>) -> Result<(), AbortCode> {
        self.stream.begin_write()
    }

    fn write_at(
        &mut self,
        _: &Objects,
        _: &Entry,
        position: u32,
        data: &[u8],
    ) -> Result<(), AbortCode> {
        self.stream.write_at(position, data)
    }

    fn end_write(
        &mut self,
        _: &mut Objects,
        _: &Entry,
        length: u32,
    ) -> Result<Completion, AbortCode> {
        self.stream.end_write(length)
    }

    fn abandon_write(&mut self, _: &Objects, _: &Entry) {
        self.stream.abandon_write();
    }

    fn power_on(&mut self, dictionary: &mut Objects) {
        self.power_ons += 1;
        assert!(od::write_u32(dictionary, 0x1018, 4, 0x1234_5678));
        if let Some(startup) = self.startup {
            assert!(od::write_u32(dictionary, 0x1F80, 0, startup));
        }
        for (sub, watched) in (1..).zip(self.watched) {
            assert!(od::write_u32(dictionary, 0x1016, sub, watched));
        }
    }
}

/// A frame that was sent, with the moment in milliseconds.
pub type Sent = (u64, String);

/// A device with two receive and two transmit PDOs.
#[derive(Debug)]
pub struct Device {
    pub node: Node<Objects>,
    pub firmware: Firmware,
    pub now: Instant,
}

impl Device {
    /// Node 4, not booted.
    pub fn off() -> Self {
        Self::off_with(4)
    }

    /// Not booted; 255 for a device without a node-ID.
    pub fn off_with(node_id: u8) -> Self {
        let settings = Settings {
            node_id: NodeId::new(node_id).unwrap(),
            ..Settings::default()
        };
        Self {
            node: Node::new(Objects::new(), settings),
            firmware: Firmware::default(),
            now: Instant::from_ticks(5_000_000),
        }
    }

    /// Node 4 in Pre-operational; its boot-up message and its events are gone.
    pub fn new() -> Self {
        let mut device = Self::off();
        device.boot(Reset::Node);
        assert_eq!(device.sent(), ["704 [1] 00"]);
        device.events();
        device
    }

    /// Node 4 in Operational; the first TPDO is gone.
    pub fn operational() -> Self {
        let mut device = Self::new();
        device.send("000 [2] 01 04");
        assert_eq!(device.sent(), ["184: 00 00 00 00 00 00 00 00"]);
        device.events();
        device
    }

    pub fn boot(&mut self, reset: Reset) {
        self.node.boot(reset, self.now, &mut self.firmware);
    }

    /// Serves a commanded reset as a firmware does.
    pub fn serve_reset(&mut self) -> Reset {
        let reset = self.events().into_iter().find_map(|event| match event {
            Event::ResetRequested(reset) => Some(reset),
            _ => None,
        });
        let reset = reset.expect("a reset was requested");
        self.boot(reset);
        reset
    }

    /// Puts a frame on the bus; the device is not polled.
    pub fn put(&mut self, text: &str) {
        self.node
            .receive(&frame(text), self.now, &mut self.firmware);
    }

    /// Puts a frame on the bus, then polls.
    pub fn send(&mut self, text: &str) {
        self.put(text);
        self.poll();
    }

    pub fn poll(&mut self) -> Instant {
        let deadline = self.node.poll(self.now, &mut self.firmware);
        assert!(
            deadline > self.now,
            "a deadline that is over would never let the firmware sleep"
        );
        deadline
    }

    /// Everything that waits for the bus.
    pub fn sent(&mut self) -> Vec<String> {
        std::iter::from_fn(|| self.node.transmit(&mut self.firmware))
            .map(|frame| show(&frame))
            .collect()
    }

    /// Sends an SDO request and returns everything that is sent.
    pub fn ask(&mut self, text: &str) -> Vec<String> {
        self.send(text);
        self.sent()
    }

    /// Lets milliseconds pass on a free bus; returns what was sent meanwhile, with its moment since the start of this call.
    pub fn pass(&mut self, milliseconds: u64) -> Vec<Sent> {
        let start = self.now;
        let end = start + Duration::from_ticks(milliseconds * 1000);
        let mut log = Vec::new();
        loop {
            let deadline = self.poll();
            let moment = (self.now - start).ticks() / 1000;
            log.extend(self.sent().into_iter().map(|frame| (moment, frame)));
            // What has left may start an inhibit time.
            let deadline = deadline.min(self.poll());
            if deadline > end {
                self.now = end;
                return log;
            }
            self.now = deadline;
        }
    }

    pub fn events(&mut self) -> Vec<Event> {
        std::iter::from_fn(|| self.node.event()).collect()
    }

    /// The present bytes of an object, past all access rights.
    pub fn value(&self, index: u16, sub: u8) -> Vec<u8> {
        od::value(
            self.node.dictionary(),
            od::find::<Objects>(index, sub).unwrap(),
        )
        .to_vec()
    }

    /// Changes an object as the firmware does.
    pub fn set_value(&mut self, index: u16, sub: u8, bytes: &[u8]) {
        od::set(
            self.node.dictionary_mut(),
            od::find::<Objects>(index, sub).unwrap(),
            bytes,
        )
        .unwrap();
    }
}

/// All descriptors of the dictionary.
pub fn entries() -> &'static [Entry] {
    Objects::TABLE.entries
}

/// A frame with its bytes filled up to eight, as it is when it was sent: `full("604", "40 00 10")`.
pub fn full(id: &str, start: &str) -> String {
    show(&frame(&format!("{id}: {start}")))
}

/// The abort frame of node 4 for an object.
pub fn abort(index: u16, sub: u8, code: u32) -> String {
    let [low, high] = index.to_le_bytes();
    let [a, b, c, d] = code.to_le_bytes();
    show(&Frame::data_frame(
        0x584,
        &[0x80, low, high, sub, a, b, c, d],
    ))
}

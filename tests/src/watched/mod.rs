//! A device without a bus that is watched: whatever comes at whatever time, it sends only what it owes.
//!
//! The invariants, held against each frame it sends:
//! - The first frame of a boot is the boot-up message, and there is one of it.
//! - The identifier is its own: of its error control, a server, EMCY, SYNC, TIME or a TPDO as the dictionary has them now,
//!   or of the LSS slave.
//! - The NMT state has that service. A TPDO has the length of its mapping, a server's answer eight bytes.
//! - A server answers a request once. A block upload sends no more segments than were asked for; a time-out and the
//!   acknowledge that asks for lost segments may come by themselves, once for a request.
//! - The generic bit of the error register stands while any other does.
//! - A deadline lies ahead.

mod owed;
mod step;

use canopen::cia301::emergency::Emergency;
use canopen::cia301::nmt::{NmtState, Reset};
use canopen::od;
use canopen::{BitRate, Duration, Event, Frame, Instant, Node, NodeId, Settings};

use crate::firmware::{Firmware, Store};
use crate::test_device::Dictionary;
use owed::Owed;

pub use step::{Step, decode, encode};

/// What the LSS slave answers with.
const LSS_ANSWER: u16 = 0x7E4;

/// Frames that a device has waiting at most: more is a queue that never ends.
const MOST_FRAMES: usize = 400;

/// How often a device may want to be called before its time passes anyway.
const MOST_CALLS: usize = 64;

/// A broken invariant, in words.
pub type Broken = String;

/// A device, its firmware, and what it owes.
#[derive(Debug)]
pub struct Watched {
    node: Node<Dictionary>,
    firmware: Firmware,
    store: Store,
    now: Instant,
    owed: Owed,
}

impl Watched {
    /// A device that has booted; 255 for one without a node-ID.
    pub fn booted(node_id: u8) -> Self {
        let settings = Settings {
            node_id: NodeId::new(node_id).unwrap_or(NodeId::UNCONFIGURED),
            bit_rate: BitRate::Kbit1000,
        };
        let mut device = Self {
            node: Node::new(Dictionary::new(), settings).with_parameter_store(),
            firmware: Firmware::default(),
            store: Store::default(),
            now: Instant::from_ticks(1_000_000),
            owed: Owed::default(),
        };
        device.boot(Reset::Node);
        device
    }

    fn boot(&mut self, reset: Reset) {
        self.node.boot(reset, self.now, &mut self.firmware);
        self.node
            .load_parameters(&mut self.store, self.now, &mut self.firmware);
        self.owed.boot();
    }

    /// What happens next.
    ///
    /// # Errors
    /// What the device did that it must not do.
    pub fn take(&mut self, step: &Step) -> Result<(), Broken> {
        match step {
            Step::Frame(frame) => self.receive(frame),
            Step::Pass(span) => self.pass(*span)?,
            Step::Report(number) => {
                let emergency = Emergency {
                    code: 0xFF00 + u16::from(*number),
                    register: *number,
                    info: [*number; 5],
                };
                self.node.report(emergency, self.now);
            }
            Step::Clear(number) => self.node.clear(0xFF00 + u16::from(*number), self.now),
            Step::Change(value) => self.node.dictionary_mut().set_sent_number_1(*value),
            Step::Transmit(frames) => {
                self.transmit(usize::from(*frames))?;
            }
        }
        self.serve()
    }

    fn receive(&mut self, frame: &Frame) {
        if !frame.is_remote() && frame.length() == 8 && self.node.state().has_sdo_and_emergency() {
            let id = frame.standard_id();
            for server in 0..2 {
                if let Some((request, answer)) = self.server(server)
                    && id == Some(request)
                {
                    self.owed.request(server, answer, frame.bytes()[0]);
                }
            }
        }
        self.node.receive(frame, self.now, &mut self.firmware);
    }

    fn pass(&mut self, span: Duration) -> Result<(), Broken> {
        let end = self.now + span;
        for _ in 0..MOST_CALLS {
            let deadline = self.poll()?;
            if deadline >= end {
                break;
            }
            self.now = deadline;
            self.serve()?;
        }
        self.now = end;
        Ok(())
    }

    fn poll(&mut self) -> Result<Instant, Broken> {
        let deadline = self.node.poll(self.now, &mut self.firmware);
        if deadline <= self.now {
            return Err(format!(
                "the deadline {deadline:?} is over at {:?}",
                self.now
            ));
        }
        Ok(deadline)
    }

    /// What the firmware does after each call: it polls, and serves what it is asked for.
    fn serve(&mut self) -> Result<(), Broken> {
        self.poll()?;
        while let Some(event) = self.node.event() {
            match event {
                Event::ResetRequested(reset) => {
                    if self.node.state() != NmtState::Initialisation {
                        return Err(format!("a reset in {:?}", self.node.state()));
                    }
                    if let Some(frame) = self.node.transmit(&mut self.firmware) {
                        return Err(format!("{frame:?} between reset and boot"));
                    }
                    self.boot(reset);
                }
                Event::StoreSettings(_) => self.node.settings_stored(Ok(())),
                _ => {}
            }
        }
        if self.node.is_storing() {
            self.node.store_parameters(&mut self.store, self.now);
        }
        let register = self.read(0x1001, 0);
        if register != 0 && register & 1 == 0 {
            return Err(format!(
                "error register {register:02X}h without the generic bit"
            ));
        }
        Ok(())
    }

    /// The bus takes up to so many frames; returns them.
    ///
    /// # Errors
    /// A frame that the device must not send.
    pub fn transmit(&mut self, most: usize) -> Result<Vec<Frame>, Broken> {
        let mut sent = Vec::new();
        while sent.len() < most {
            let Some(frame) = self.node.transmit(&mut self.firmware) else {
                break;
            };
            self.check(&frame)
                .map_err(|why| format!("{frame:?} in {:?}: {why}", self.node.state()))?;
            sent.push(frame);
        }
        Ok(sent)
    }

    /// A free bus takes everything.
    ///
    /// # Errors
    /// As [`Watched::transmit`]; or the device never ends.
    pub fn drain(&mut self) -> Result<Vec<Frame>, Broken> {
        let sent = self.transmit(MOST_FRAMES)?;
        if sent.len() == MOST_FRAMES {
            return Err(format!("{MOST_FRAMES} frames and no end"));
        }
        Ok(sent)
    }

    /// Whatever has happened, the device can be brought back: it boots when commanded, and answers.
    ///
    /// # Errors
    /// What it did instead.
    pub fn recover(&mut self) -> Result<(), Broken> {
        // The silence of an LSS bit rate switch, and the time-out of every transfer.
        self.pass(Duration::secs(140))?;
        self.drain()?;
        self.take(&Step::Frame(Frame::data_frame(0, &[0x81, 0])))?;
        let node_id = self.node.settings().node_id;
        if !node_id.is_configured() {
            return Ok(());
        }
        self.drain()?;
        let id = u16::from(node_id.get());
        let request = [0x40, 0x18, 0x10, 0x01, 0, 0, 0, 0];
        self.take(&Step::Frame(Frame::data_frame(0x600 + id, &request)))?;
        let answer = Frame::data_frame(0x580 + id, &[0x43, 0x18, 0x10, 1, 0x44, 0x33, 0x22, 0x11]);
        if self.drain()?.contains(&answer) {
            Ok(())
        } else {
            Err("no answer after a reset".into())
        }
    }

    /// Whether the device has a node-ID.
    pub fn is_configured(&self) -> bool {
        self.node.settings().node_id.is_configured()
    }

    /// Whether this frame may be sent now.
    fn check(&mut self, frame: &Frame) -> Result<(), Broken> {
        let Some(id) = frame.standard_id().filter(|_| !frame.is_remote()) else {
            return Err("a remote or 29-bit frame".into());
        };
        if id == LSS_ANSWER {
            return expect(frame.length() == 8, "the length of an LSS answer");
        }
        let state = self.node.state();
        let node_id = u16::from(self.node.settings().node_id.get());
        if id == 0x700 + node_id {
            return match frame.payload() {
                [0] => self.owed.boot_up(),
                [byte] => {
                    self.owed.anything_else()?;
                    expect(byte & 0x7F == state as u8, "the state")
                }
                _ => Err("the length of error control".into()),
            };
        }
        self.owed.anything_else()?;
        for server in 0..2 {
            if self.server(server).is_some_and(|(_, answer)| answer == id) {
                expect(state.has_sdo_and_emergency(), "an SDO server in this state")?;
                expect(frame.length() == 8, "the length of an answer")?;
                return self.owed.answer(server);
            }
        }
        let is_cob_id = |index| self.valid_cob_id(index, 0) == Some(id);
        let produces = |index| self.read(index, 0) & 0x4000_0000 != 0;
        // A device that stops itself after a communication error (1029h = 2) says why.
        let says_why = state == NmtState::Stopped;
        if is_cob_id(0x1014) && frame.length() == 8 && (state.has_sdo_and_emergency() || says_why) {
            return Ok(());
        }
        if self.read(0x1005, 0) & 0x7FF == u32::from(id)
            && produces(0x1005)
            && frame.length() <= 1
            && state.has_sdo_and_emergency()
        {
            return Ok(());
        }
        if self.read(0x1012, 0) & 0x7FF == u32::from(id)
            && produces(0x1012)
            && frame.length() == 6
            && state.has_sdo_and_emergency()
        {
            return Ok(());
        }
        let lengths: Vec<usize> = (0..4)
            .filter(|pdo| self.valid_cob_id(0x1800 + pdo, 1) == Some(id))
            .map(|pdo| self.mapped_length(0x1A00 + pdo))
            .collect();
        if lengths.is_empty()
            && let Some(server) = self.owed.server(id)
        {
            // It was switched off by the request, or before its answer had left.
            return self.owed.answer(server);
        }
        expect(!lengths.is_empty(), "an identifier that is not its own")?;
        expect(state == NmtState::Operational, "a TPDO in this state")?;
        if lengths.contains(&frame.payload().len()) {
            Ok(())
        } else {
            Err(format!("a TPDO of another length than {lengths:?}"))
        }
    }

    /// The identifiers of requests and answers, while the server is valid.
    fn server(&self, number: u16) -> Option<(u16, u16)> {
        let index = 0x1200 + number;
        Some((self.valid_cob_id(index, 1)?, self.valid_cob_id(index, 2)?))
    }

    fn valid_cob_id(&self, index: u16, sub: u8) -> Option<u16> {
        let cob_id = self.read(index, sub);
        u16::try_from(cob_id & 0x7FF)
            .ok()
            .filter(|_| cob_id & 0x8000_0000 == 0)
    }

    /// The bytes of a PDO with this mapping.
    fn mapped_length(&self, index: u16) -> usize {
        match self.read(index, 0) {
            // A multiplexed PDO.
            0xFE | 0xFF => 8,
            count => {
                let bits = (1..=count).map(|sub| self.read(index, sub as u8) & 0xFF);
                bits.sum::<u32>().div_ceil(8) as usize
            }
        }
    }

    /// A number of the dictionary, past all access rights.
    fn read(&self, index: u16, sub: u8) -> u32 {
        let Ok(entry) = od::find::<Dictionary>(index, sub) else {
            return 0;
        };
        let mut bytes = [0; 4];
        for (to, from) in bytes
            .iter_mut()
            .zip(od::value(self.node.dictionary(), entry))
        {
            *to = *from;
        }
        u32::from_le_bytes(bytes)
    }
}

fn expect(holds: bool, what: &str) -> Result<(), Broken> {
    if holds { Ok(()) } else { Err(what.into()) }
}

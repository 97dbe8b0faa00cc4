//! A device under test and a scripted station on one simulated bus, in virtual time.

use std::collections::VecDeque;
use std::fmt::Write as _;

use canopen::time::NEVER;
use canopen::{BitRate, ControllerState, Duration, Frame, Instant};
use master::bus::Station;
use master::bus::simulated::{Bus, Handle, Interference, Logged};
use master::trace::candump;

use crate::notation::{Pattern, frame, show};

/// How long a case waits for a frame that must come.
const PATIENCE: Duration = Duration::millis(250);

/// The station that speaks the frames of a case and keeps what it hears.
#[derive(Debug, Default)]
pub struct Script {
    outbox: VecDeque<Frame>,
    inbox: VecDeque<Frame>,
    bit_rate: Option<BitRate>,
}

impl Station for Script {
    fn receive(&mut self, frame: &Frame, _now: Instant) {
        self.inbox.push_back(*frame);
    }

    fn poll(&mut self, _now: Instant) -> Instant {
        NEVER
    }

    fn transmit(&mut self) -> Option<Frame> {
        self.outbox.pop_front()
    }

    fn bit_rate(&self) -> Option<BitRate> {
        self.bit_rate
    }
}

/// A device `S` and a [`Script`] on one bus at 1 Mbit/s.
#[derive(Debug)]
pub struct Line<S> {
    pub(crate) bus: Bus,
    pub(crate) device: Handle<S>,
    script: Handle<Script>,
    /// Where the device's SDO server listens and answers.
    pub(crate) node_id: u8,
}

impl<S: Station> Line<S> {
    /// Attaches the device.
    pub fn new(device: S, node_id: u8) -> Self {
        let mut bus = Bus::new(BitRate::Kbit1000);
        let device = bus.attach(device);
        let script = bus.attach(Script::default());
        Self {
            bus,
            device,
            script,
            node_id,
        }
    }

    /// The present time.
    pub fn now(&self) -> Instant {
        self.bus.now()
    }

    /// From now on the script sends and hears at this bit rate alone. Before, it hears any and sends at 1 Mbit/s.
    pub fn set_bit_rate(&mut self, bit_rate: BitRate) {
        self.bus.station_mut(self.script).bit_rate = Some(bit_rate);
    }

    /// Gives a frame to the bus without waiting; frames queued together leave back to back.
    pub fn queue(&mut self, text: &str) {
        self.queue_frame(frame(text));
    }

    /// As [`Line::queue`], for a frame that is not written out.
    pub fn queue_frame(&mut self, frame: Frame) {
        self.bus.station_mut(self.script).outbox.push_back(frame);
    }

    /// Sends a frame and waits until the device has it.
    pub fn send(&mut self, text: &str) {
        self.send_frame(frame(text));
    }

    /// As [`Line::send`], for a frame that is not written out.
    pub fn send_frame(&mut self, frame: Frame) {
        self.queue_frame(frame);
        let end = self.now() + PATIENCE;
        let script = self.script.number();
        let before = self.sent_by(script);
        while self.sent_by(script) == before {
            assert!(self.now() < end, "the bus never took {}", show(&frame));
            self.bus.step(end);
        }
    }

    fn sent_by(&self, number: usize) -> usize {
        self.bus
            .trace()
            .iter()
            .filter(|logged| logged.sender == number)
            .count()
    }

    /// The next frame of the device, waiting up to `patience`.
    pub fn next(&mut self, patience: Duration) -> Option<Frame> {
        let end = self.now() + patience;
        loop {
            if let Some(frame) = self.bus.station_mut(self.script).inbox.pop_front() {
                return Some(frame);
            }
            if self.now() >= end {
                return None;
            }
            self.bus.step(end);
        }
    }

    /// The next frame of the device must be this one, within 250 ms.
    #[track_caller]
    pub fn expect(&mut self, text: &str) -> Frame {
        self.expect_within(text, PATIENCE.to_millis())
    }

    /// As [`Line::expect`], with another patience in milliseconds.
    #[track_caller]
    pub fn expect_within(&mut self, text: &str, milliseconds: u64) -> Frame {
        let pattern = Pattern::new(text);
        match self.next(Duration::millis(milliseconds)) {
            Some(frame) if pattern.matches(&frame) => frame,
            Some(frame) => panic!("expected {text}, got {}\n{}", show(&frame), self.recent()),
            None => panic!("expected {text}, got nothing\n{}", self.recent()),
        }
    }

    /// The device must send nothing for so many milliseconds.
    #[track_caller]
    pub fn silence(&mut self, milliseconds: u64) {
        if let Some(frame) = self.next(Duration::millis(milliseconds)) {
            panic!("expected silence, got {}\n{}", show(&frame), self.recent());
        }
    }

    /// Sends an SDO request that must be aborted with this code, for the same object.
    #[track_caller]
    pub fn refused(&mut self, request: &str, code: u32) {
        let sent = frame(request);
        self.queue_frame(sent);
        let [_, low, high, sub, ..] = *sent.bytes();
        let [a, b, c, d] = code.to_le_bytes();
        let answer = 0x580 + u16::from(self.node_id);
        self.expect(&format!(
            "{answer:03X}: 80 {low:02X} {high:02X} {sub:02X} {a:02X} {b:02X} {c:02X} {d:02X}"
        ));
    }

    /// Lets time pass.
    pub fn run_millis(&mut self, milliseconds: u64) {
        self.bus.run_for(Duration::millis(milliseconds));
    }

    /// Lets time pass.
    pub fn run_micros(&mut self, microseconds: u64) {
        self.bus.run_for(Duration::micros(microseconds));
    }

    /// Lets time pass and forgets what the device sent.
    pub fn drain(&mut self, milliseconds: u64) {
        self.run_millis(milliseconds);
        self.bus.station_mut(self.script).inbox.clear();
    }

    /// Lets time pass until this frame comes, whatever comes before it.
    #[track_caller]
    pub fn drain_until(&mut self, text: &str, milliseconds: u64) -> Frame {
        let pattern = Pattern::new(text);
        let end = self.now() + Duration::millis(milliseconds);
        while let Some(frame) = end
            .checked_duration_since(self.now())
            .and_then(|left| self.next(left))
        {
            if pattern.matches(&frame) {
                return frame;
            }
        }
        panic!(
            "{text} did not come within {milliseconds} ms\n{}",
            self.recent()
        );
    }

    /// Blocks the bus: no frame starts for so long.
    pub fn jam(&mut self, span: Duration) {
        self.bus.jam(span);
    }

    /// Lets somebody decide about every frame on the bus from now on.
    pub fn interfere(&mut self, interferer: impl FnMut(&Logged) -> Interference + 'static) {
        self.bus.interfere(interferer);
    }

    /// Ends interference.
    pub fn leave_in_peace(&mut self) {
        self.bus.leave_in_peace();
    }

    /// Every frame so far as candump shows it.
    pub fn candump(&self) -> String {
        let lines = self
            .bus
            .trace()
            .iter()
            .map(|logged| candump::line(logged.at, &logged.frame));
        lines.collect::<Vec<_>>().join("\n")
    }

    /// Brings the device's CAN controller into a state, as many errors on the bus do.
    pub fn set_controller(&mut self, state: ControllerState) {
        self.bus.set_controller(self.device, state);
    }

    /// The next `count` frames for the device get lost in its controller.
    pub fn lose_frames(&mut self, count: u32) {
        self.bus.lose_frames(self.device, count);
    }

    /// The identifiers of all frames the device has sent, oldest first; 29-bit ones as FFFFh.
    pub fn cob_ids_of_the_device(&self) -> Vec<u16> {
        let device = self.device.number();
        let sent = self
            .bus
            .trace()
            .iter()
            .filter(|logged| logged.sender == device);
        sent.map(|logged| logged.frame.standard_id().unwrap_or(u16::MAX))
            .collect()
    }

    /// Commands NMT start and forgets the PDOs that follow it.
    pub fn start(&mut self) {
        self.send_frame(Frame::data_frame(0, &[0x01, self.node_id]));
        self.drain(2);
    }

    /// The NMT state as a heartbeat tells it; the heartbeat is off before and after.
    pub fn state_in_heartbeat(&mut self) -> u8 {
        self.write_u16(0x1017, 0, 50);
        let id = 0x700 + u16::from(self.node_id);
        let beat = self.drain_until(&format!("{id:03X} [1] xx"), 100);
        self.write_u16(0x1017, 0, 0);
        self.drain(2);
        beat.payload()[0]
    }

    /// The last frames on the bus, for messages.
    fn recent(&self) -> String {
        let mut text = String::from("the last frames:");
        let trace = self.bus.trace();
        for logged in &trace[trace.len().saturating_sub(12)..] {
            let who = if logged.sender == self.script.number() {
                "→"
            } else {
                "←"
            };
            let _ = write!(
                text,
                "\n  {:>12} µs {who} {}",
                logged.at.ticks(),
                show(&logged.frame)
            );
        }
        text
    }
}

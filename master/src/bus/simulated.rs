//! A CAN bus inside one process, on virtual time.
//!
//! Whenever the bus is idle, the stations with something to send start together; the lowest identifier wins, the others
//! try again after it. A frame takes the time of its own bits at the sender's bit rate ([`super::timing`]) and reaches
//! every other station at its end. Identical frames that start together merge into one, as they do on copper (LSS
//! fastscan relies on this). A frame that nobody acknowledges, because no other station listens at its bit rate, is
//! repeated until somebody does.
//!
//! A station may listen in silence ([`Station::is_silent`]). It acknowledges nothing, and a frame at another bit rate is an error to
//! it. So is one that nobody acknowledges, as its sender marks it broken; but only until so many attempts have failed that the
//! sender is error passive, and its mark no longer seen (ISO 11898-1).
//!
//! The same stations, calls and interference always give the same trace: nothing here is random or reads a clock.

mod controller;
mod handle;

use std::any::Any;
use std::collections::VecDeque;
use std::fmt;

use canopen::time::NEVER;
use canopen::{BitRate, Duration, Frame, Instant};

use super::Station;
use super::timing::{ERROR_FRAME_BITS, INTERMISSION_BITS, arbitration, bit_time, frame_bits};

use controller::Controller;
pub use handle::Handle;

/// Frames a controller holds for sending, as many as a bxCAN has. One is taken from the station at each arbitration, so
/// that the station's own queue, where new process data replaces old, does most of the waiting.
const MAILBOXES: usize = 3;

/// Attempts after which a sender that nobody acknowledges is error passive: each counts 8, and 128 is the limit.
const ATTEMPTS_TO_PASSIVE: u32 = 128 / 8;

/// One frame that was on the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Logged {
    /// When its last bit had passed.
    pub at: Instant,
    /// The number of the station that sent it (the first of them if identical frames merged).
    pub sender: usize,
    /// The frame.
    pub frame: Frame,
}

/// What a test does to a frame on its way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interference {
    /// Nothing.
    None,
    /// The sender sees it sent, nobody receives it (it does not show in the trace).
    Lose,
    /// An error frame destroys it; the controller sends it again by itself.
    Destroy,
    /// Everybody receives it, and its sender alone sees an error in the last bit but one: it sends the frame again, and it is
    /// received twice (ISO 11898-1 leaves this hole).
    Repeat,
}

/// Decides about each frame at its end.
type Interferer = Box<dyn FnMut(&Logged) -> Interference>;

/// The bus and the stations on it.
pub struct Bus {
    bit_rate: BitRate,
    now: Instant,
    slots: Vec<Slot>,
    flight: Option<Flight>,
    idle_from: Instant,
    trace: Vec<Logged>,
    interferer: Option<Interferer>,
    destroyed: u64,
    collisions: u64,
}

struct Slot {
    station: Option<Box<dyn Station>>,
    wake: Instant,
    mailboxes: VecDeque<Frame>,
    refused: bool,
    /// How many attempts to send have not been acknowledged since the last that was.
    attempts: u32,
    controller: Controller,
}

struct Flight {
    logged: Logged,
    senders: Vec<usize>,
    bit_rate: BitRate,
    until: Instant,
}

impl Flight {
    /// The frame when one of its senders fell silent; `None` if nobody sends it any more.
    fn without(mut self, sender: usize) -> Option<Self> {
        self.senders.retain(|other| *other != sender);
        (!self.senders.is_empty()).then_some(self)
    }
}

impl Bus {
    /// An empty bus at time 0. `bit_rate` is that of stations that have none of their own.
    pub fn new(bit_rate: BitRate) -> Self {
        Self {
            bit_rate,
            now: Instant::from_ticks(0),
            slots: Vec::new(),
            flight: None,
            idle_from: Instant::from_ticks(0),
            trace: Vec::new(),
            interferer: None,
            destroyed: 0,
            collisions: 0,
        }
    }

    /// Attaches a station; it is polled for the first time when the bus runs on.
    pub fn attach<S: Station>(&mut self, station: S) -> Handle<S> {
        self.slots.push(Slot {
            station: Some(Box::new(station)),
            wake: self.now,
            mailboxes: VecDeque::new(),
            refused: false,
            attempts: 0,
            controller: Controller::new(),
        });
        Handle::new(self.slots.len() - 1)
    }

    /// Takes a station off the bus, with the frames its controller had not sent.
    ///
    /// # Panics
    /// If the handle is of another bus, or the station was detached before.
    pub fn detach<S: Station>(&mut self, handle: Handle<S>) -> S {
        let slot = &mut self.slots[handle.number()];
        slot.mailboxes.clear();
        slot.wake = NEVER;
        let station: Box<dyn Any> = slot.station.take().expect("the station is attached");
        *station
            .downcast()
            .expect("the handle carries the station's type")
    }

    /// A station.
    ///
    /// # Panics
    /// If the handle is of another bus, or the station was detached.
    pub fn station<S: Station>(&self, handle: Handle<S>) -> &S {
        let station: &dyn Any = self.slots[handle.number()]
            .station
            .as_deref()
            .expect("the station is attached");
        station
            .downcast_ref()
            .expect("the handle carries the station's type")
    }

    /// A station, to act on it; it is polled when the bus runs on.
    ///
    /// # Panics
    /// If the handle is of another bus, or the station was detached.
    pub fn station_mut<S: Station>(&mut self, handle: Handle<S>) -> &mut S {
        let slot = &mut self.slots[handle.number()];
        slot.wake = self.now;
        let station: &mut dyn Any = slot
            .station
            .as_deref_mut()
            .expect("the station is attached");
        station
            .downcast_mut()
            .expect("the handle carries the station's type")
    }

    /// The present time.
    pub fn now(&self) -> Instant {
        self.now
    }

    /// Every frame so far, oldest first.
    pub fn trace(&self) -> &[Logged] {
        &self.trace
    }

    /// Forgets the trace and returns it.
    pub fn take_trace(&mut self) -> Vec<Logged> {
        std::mem::take(&mut self.trace)
    }

    /// Frames that were destroyed or not acknowledged, and sent again.
    pub fn destroyed(&self) -> u64 {
        self.destroyed
    }

    /// Times that two stations sent different frames with one identifier together, which real stations must never do.
    /// The station attached first wins.
    pub fn collisions(&self) -> u64 {
        self.collisions
    }

    /// Lets `interferer` decide about every frame from now on, at the end of it.
    pub fn interfere(&mut self, interferer: impl FnMut(&Logged) -> Interference + 'static) {
        self.interferer = Some(Box::new(interferer));
    }

    /// Ends interference.
    pub fn leave_in_peace(&mut self) {
        self.interferer = None;
    }

    /// No frame starts for `span`: the bus is held dominant or flooded by others.
    pub fn jam(&mut self, span: Duration) {
        self.idle_from = self.idle_from.max(self.now + span);
    }

    /// Runs for a span of virtual time.
    pub fn run_for(&mut self, span: Duration) {
        self.run_until(self.now + span);
    }

    /// Runs until a point in virtual time; does nothing if it has passed.
    pub fn run_until(&mut self, end: Instant) {
        while self.step(end) {}
    }

    /// Runs to the next thing that happens, at `end` at the latest. Returns whether anything happened by then; if not,
    /// the time is `end`.
    pub fn step(&mut self, end: Instant) -> bool {
        self.poll_stations();
        self.start_frame();
        let next = self.next_event();
        if next > end {
            self.now = self.now.max(end);
            return false;
        }
        self.now = self.now.max(next);
        if self
            .flight
            .as_ref()
            .is_some_and(|flight| flight.until <= self.now)
        {
            self.end_frame();
        }
        self.poll_stations();
        self.start_frame();
        true
    }

    fn next_event(&self) -> Instant {
        let wake = self
            .slots
            .iter()
            .map(|slot| slot.wake)
            .min()
            .unwrap_or(NEVER);
        let bus = match &self.flight {
            Some(flight) => flight.until,
            None if self.idle_from > self.now => self.idle_from,
            None => NEVER,
        };
        let back = self.slots.iter().map(|slot| slot.controller.back_at);
        wake.min(bus).min(back.min().unwrap_or(NEVER))
    }

    fn poll_stations(&mut self) {
        for (number, slot) in self.slots.iter_mut().enumerate() {
            let Some(station) = &mut slot.station else {
                continue;
            };
            if slot.wake <= self.now {
                // A station that asks for "now" again still lets time pass.
                slot.wake = station
                    .poll(self.now)
                    .max(self.now + Duration::from_ticks(1));
            }
            if station.was_reset() {
                slot.mailboxes.clear();
                slot.refused = false;
                slot.attempts = 0;
                // A frame under way breaks off, unless another station sends the same.
                self.flight = self.flight.take().and_then(|flight| flight.without(number));
            }
        }
        self.serve_controllers();
    }

    /// Arbitration, when the bus is idle.
    fn start_frame(&mut self) {
        if self.flight.is_some() || self.now < self.idle_from {
            return;
        }
        for slot in &mut self.slots {
            let Some(station) = &mut slot.station else {
                continue;
            };
            if slot.controller.is_off() {
                continue;
            }
            let room = if slot.refused { 1 } else { MAILBOXES };
            if slot.mailboxes.len() < room
                && let Some(frame) = station.transmit()
            {
                slot.mailboxes.push_back(frame);
                // What has left may start a time.
                slot.wake = self.now;
            }
        }
        let Some((first, frame)) = self.winner() else {
            return;
        };
        let mut senders = Vec::new();
        for (number, slot) in self.slots.iter_mut().enumerate() {
            let same = slot.mailboxes.iter().position(|waiting| *waiting == frame);
            if let Some(place) = same {
                slot.mailboxes.remove(place);
                senders.push(number);
            } else if slot
                .mailboxes
                .iter()
                .any(|other| arbitration(other) == arbitration(&frame))
            {
                self.collisions += 1;
            }
        }
        let bit_rate = self.rate_of(first).unwrap_or(self.bit_rate);
        let until = self.now + bit_time(frame_bits(&frame), bit_rate);
        self.flight = Some(Flight {
            logged: Logged {
                at: until,
                sender: first,
                frame,
            },
            senders,
            bit_rate,
            until,
        });
    }

    /// The station that wins arbitration, with its frame. One that was not acknowledged lets others go first, so that a
    /// station at a wrong bit rate does not keep the bus.
    fn winner(&self) -> Option<(usize, Frame)> {
        let on_the_bus = self.slots.iter().enumerate();
        let on_the_bus = on_the_bus.filter(|(_, slot)| !slot.controller.is_off());
        let waiting = on_the_bus.filter_map(|(number, slot)| {
            let frame = slot
                .mailboxes
                .iter()
                .min_by_key(|frame| arbitration(frame))?;
            Some(((slot.refused, arbitration(frame), number), *frame))
        });
        let ((_, _, number), frame) = waiting.min_by_key(|(order, _)| *order)?;
        Some((number, frame))
    }

    fn end_frame(&mut self) {
        let Some(flight) = self.flight.take() else {
            return;
        };
        let interference = match &mut self.interferer {
            Some(interferer) => interferer(&flight.logged),
            None => Interference::None,
        };
        let receivers: Vec<usize> = (0..self.slots.len())
            .filter(|number| {
                !flight.senders.contains(number) && self.hears(*number, flight.bit_rate)
            })
            .collect();
        let (silent, receivers): (Vec<usize>, Vec<usize>) = receivers
            .into_iter()
            .partition(|number| self.is_silent(*number));
        let acknowledged = !receivers.is_empty() && interference != Interference::Destroy;
        let again = !acknowledged || interference == Interference::Repeat;
        for sender in &flight.senders {
            let slot = &mut self.slots[*sender];
            slot.refused = !acknowledged;
            slot.attempts = if acknowledged { 0 } else { slot.attempts + 1 };
            if again && slot.station.is_some() {
                slot.mailboxes.push_front(flight.logged.frame);
            }
        }
        let is_whole = acknowledged
            || interference == Interference::None
                && (flight.senders.iter())
                    .all(|sender| self.slots[*sender].attempts > ATTEMPTS_TO_PASSIVE);
        self.tell_listeners(&flight, if is_whole { &silent } else { &[] });
        if !acknowledged {
            self.destroyed += 1;
            self.occupy(ERROR_FRAME_BITS + INTERMISSION_BITS, flight.bit_rate);
            return;
        }
        self.occupy(INTERMISSION_BITS, flight.bit_rate);
        if interference == Interference::Lose {
            return;
        }
        self.trace.push(flight.logged);
        for receiver in receivers {
            let slot = &mut self.slots[receiver];
            if let Some(station) = &mut slot.station {
                if slot.controller.loses_a_frame() {
                    station.frames_lost(1, self.now);
                    slot.wake = self.now;
                    continue;
                }
                station.receive(&flight.logged.frame, self.now);
                slot.wake = self.now;
            }
        }
    }

    /// Gives a frame to the silent stations that can read it; to the other silent ones it is an error.
    fn tell_listeners(&mut self, flight: &Flight, readers: &[usize]) {
        for number in 0..self.slots.len() {
            let is_listener = self.is_silent(number) && !self.slots[number].controller.is_off();
            let slot = &mut self.slots[number];
            if let (true, Some(station)) = (is_listener, &mut slot.station) {
                if readers.contains(&number) {
                    station.receive(&flight.logged.frame, self.now);
                } else {
                    station.error_seen(self.now);
                }
                slot.wake = self.now;
            }
        }
    }

    fn is_silent(&self, number: usize) -> bool {
        let station = self.slots[number].station.as_ref();
        station.is_some_and(|station| station.is_silent())
    }

    fn occupy(&mut self, bits: u32, bit_rate: BitRate) {
        self.idle_from = self.idle_from.max(self.now + bit_time(bits, bit_rate));
    }

    fn rate_of(&self, number: usize) -> Option<BitRate> {
        self.slots[number]
            .station
            .as_ref()
            .and_then(|station| station.bit_rate())
    }

    fn hears(&self, number: usize, bit_rate: BitRate) -> bool {
        self.slots[number].station.is_some()
            && !self.slots[number].controller.is_off()
            && self.rate_of(number).is_none_or(|own| own == bit_rate)
    }
}

impl fmt::Debug for Bus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Bus")
            .field("now", &self.now)
            .field("stations", &self.slots.len())
            .field("frames", &self.trace.len())
            .finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests;

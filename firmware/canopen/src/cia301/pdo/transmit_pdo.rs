//! One transmit PDO: when it is sent, and with what.

use core::ops::Range;

use super::NOT_IN_USE;
use super::mapping::Layout;
use super::multiplexed::{self, Addressing, Message, Scan};
use super::pack::{NO_RAM, Packing, Source};
use super::parameters::{Parameters, TransmissionType};
use crate::od::{Dictionary, Slots, Unused};
use crate::time::{Duration, Instant, NEVER, earlier, has_come, with_length};
use crate::wire::Frame;

/// How a PDO is looked at when values may have changed, or time has passed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Watch {
    /// Not at all.
    No,
    /// It is sent when a value has changed, with no time to look at.
    Plain,
    /// There is more to it.
    Closely,
}

/// Between two objects of a scan, unless the inhibit time is longer: a scan leaves the bus to others.
const STEP: Duration = Duration::from_ticks(1000);

/// One transmit PDO; `M` is its place for mapped objects.
#[derive(Debug)]
pub struct TransmitPdo<M> {
    /// Its identifier, or [`NOT_IN_USE`].
    cob_id: u16,
    transmission_type: TransmissionType,
    /// How it is looked at when values may have changed.
    watch: Watch,
    /// Which one it is, 0 for the first.
    number: u16,
    /// Of types 1 to 240 the number, of others 0.
    every: u8,
    /// Whether types other than 252 and 253 answer a request.
    allows_request: bool,
    /// The SYNC counter to begin with, 0 for any.
    sync_start: u8,
    mapping: Packing<M>,
    /// What was last sampled or given out to be sent; a change is a difference from it.
    content: [u8; 8],
    /// SYNCs since the last transmission (types 1 to 240).
    sync_count: u8,
    /// Whether the SYNC with the start value has still to come.
    awaits_start: bool,
    /// Whether `content` still waits to be taken.
    is_waiting: bool,
    /// Whether an event has happened that `content` does not show yet.
    is_due: bool,
    /// How far the objects of the scanner lists have been sent.
    scan: Scan,
    inhibit_time: Duration,
    /// A frame has left, and the inhibit time has not begun yet.
    has_left: bool,
    /// The end of the inhibit time.
    free_at: Instant,
    /// Zero for none.
    event_timer: Duration,
    event_at: Instant,
}

impl<M: Slots<Source>> Unused for TransmitPdo<M> {
    const UNUSED: Self = Self {
        cob_id: NOT_IN_USE,
        transmission_type: TransmissionType::Event,
        watch: Watch::No,
        number: 0,
        every: 0,
        allows_request: false,
        sync_start: 0,
        mapping: Packing::NOTHING,
        content: [0; 8],
        sync_count: 0,
        awaits_start: false,
        is_waiting: false,
        is_due: false,
        scan: Scan::START,
        inhibit_time: Duration::from_ticks(0),
        has_left: false,
        free_at: Instant::from_ticks(0),
        event_timer: Duration::from_ticks(0),
        event_at: NEVER,
    };
}

impl<M: Slots<Source>> TransmitPdo<M> {
    /// Takes the parameters from the dictionary. Returns whether they are others than before; then nothing is sent before
    /// [`TransmitPdo::start`], and the inhibit time of the last transmission goes on.
    pub(super) fn configure<D: Dictionary>(
        &mut self,
        dictionary: &D,
        parameters: Parameters,
    ) -> bool {
        let mut next = Self::UNUSED;
        next.take_parameters(dictionary, parameters);
        if next.has_parameters_of(self) {
            return false;
        }
        if next.is_in_use() {
            next.free_at = with_length(self.free_at, self.inhibit_time, next.inhibit_time);
        } else {
            next.free_at = self.free_at;
            next.inhibit_time = self.inhibit_time;
        }
        next.has_left = self.has_left;
        *self = next;
        true
    }

    /// For a PDO that has just been made.
    fn take_parameters<D: Dictionary>(&mut self, dictionary: &D, parameters: Parameters) {
        let (Some(communication), Ok(mapping)) = (
            parameters.communicate(dictionary),
            parameters.resolve::<D, Packing<M>>(dictionary),
        ) else {
            return;
        };
        let transmission_type = communication.transmission_type;
        if mapping.length() > 0
            && let Some(transmission_type) = transmission_type.with(mapping.addressing())
        {
            self.cob_id = communication.cob_id;
            self.number = parameters.number;
            self.transmission_type = transmission_type;
            self.allows_request = communication.allows_request;
            self.sync_start = communication.sync_start;
            self.mapping = mapping;
            self.inhibit_time = Duration::from_ticks(u64::from(communication.inhibit_time) * 100);
            self.event_timer = milliseconds(communication.event_timer);
            self.every = match transmission_type {
                TransmissionType::Cyclic(every) => every,
                _ => 0,
            };
            self.find_watch();
        }
    }

    fn find_watch(&mut self) {
        let has_times = self.inhibit_time.ticks() != 0 || self.event_timer.ticks() != 0;
        self.watch = match self.transmission_type {
            TransmissionType::Event if !self.is_in_use() => Watch::No,
            TransmissionType::Event if !has_times => Watch::Plain,
            TransmissionType::Event
            | TransmissionType::Acyclic
            | TransmissionType::Multiplexed(Addressing::Source) => Watch::Closely,
            _ => Watch::No,
        };
    }

    /// Whether a change is all that is looked for.
    #[inline]
    pub(super) fn is_plain(&self) -> bool {
        self.watch == Watch::Plain
    }

    /// Whether there are times to look at, or more.
    pub(super) fn is_looked_at_closely(&self) -> bool {
        self.watch == Watch::Closely
    }

    /// The places in RAM that it looks at for changes.
    pub(super) fn watched(&self) -> Range<u16> {
        match self.transmission_type {
            TransmissionType::Event | TransmissionType::Acyclic => self.mapping.ram_range(),
            _ => NO_RAM,
        }
    }

    fn has_parameters_of(&self, other: &Self) -> bool {
        self.cob_id == other.cob_id
            && self.transmission_type == other.transmission_type
            && self.allows_request == other.allows_request
            && self.sync_start == other.sync_start
            && self.mapping == other.mapping
            && self.inhibit_time == other.inhibit_time
            && self.event_timer == other.event_timer
    }

    /// Operational begins for this PDO.
    pub(super) fn start(&mut self, ram: &[u8], rom: &[u8], now: Instant) {
        self.sync_count = 0;
        self.awaits_start = self.sync_start != 0;
        self.content = self.mapping.pack(ram, rom);
        if self.is_event_driven() {
            // The inhibit time holds across a short visit to another state.
            self.is_due = true;
            self.event_at = NEVER;
            self.poll(ram, rom, now);
        } else if self.transmission_type == TransmissionType::Acyclic {
            self.is_due = true;
        } else if self.addressing() == Some(Addressing::Source) {
            self.is_due = true;
            self.scan = Scan::START;
            self.restart_event_timer(now);
        }
    }

    /// Operational is over.
    pub(super) fn stop(&mut self) {
        self.is_waiting = false;
        self.is_due = false;
    }

    /// A new event timer in milliseconds, counted from now; 0 for none. The one that it has already goes on.
    pub(super) fn set_event_timer(&mut self, time: u32, now: Instant) {
        let event_timer = milliseconds(time);
        if event_timer != self.event_timer {
            self.event_timer = event_timer;
            self.find_watch();
            self.restart_event_timer(now);
        }
    }

    /// A SYNC, for a synchronous PDO: returns whether there is something to send.
    #[inline]
    pub(super) fn on_sync(&mut self, counter: Option<u8>, ram: &[u8], rom: &[u8]) -> bool {
        if self.every == 0 {
            return self.on_sync_after_event(ram, rom);
        }
        self.sync_count = self.sync_count.saturating_add(1);
        if self.awaits_start {
            self.count_to_start(counter, self.every);
        }
        self.sync_count >= self.every && self.give_out(self.mapping.pack(ram, rom))
    }

    /// A SYNC, for what is not sent at every n-th of them.
    #[inline(never)]
    fn on_sync_after_event(&mut self, ram: &[u8], rom: &[u8]) -> bool {
        let present = self.mapping.pack(ram, rom);
        if self.transmission_type == TransmissionType::SampledRequest {
            self.content = present;
            return false;
        }
        self.is_due |= present != self.content;
        self.is_due && self.give_out(present)
    }

    /// Nothing is counted before the SYNC with the start value, and at that one the PDO is sent. Without a counter there is
    /// nothing to wait for.
    #[cold]
    fn count_to_start(&mut self, counter: Option<u8>, every: u8) {
        self.awaits_start = counter.is_some_and(|counter| counter != self.sync_start);
        if self.awaits_start {
            self.sync_count = 0;
        } else if counter.is_some() {
            self.sync_count = every;
        }
    }

    /// The SYNC window has passed: what a SYNC has given out is too late. An event waits for the next SYNC.
    pub(super) fn window_passed(&mut self) {
        match self.transmission_type {
            TransmissionType::Acyclic => {
                self.is_due |= self.is_waiting;
                self.is_waiting = false;
            }
            TransmissionType::Cyclic(_) => self.is_waiting = false,
            _ => {}
        }
    }

    /// A remote frame asks for this PDO.
    pub(super) fn on_request(&mut self, ram: &[u8], rom: &[u8], now: Instant) {
        match self.transmission_type {
            TransmissionType::SampledRequest => self.is_waiting = true,
            TransmissionType::Request => {
                self.content = self.mapping.pack(ram, rom);
                self.is_waiting = true;
            }
            TransmissionType::Multiplexed(_) => {}
            _ if !self.allows_request => {}
            TransmissionType::Acyclic | TransmissionType::Cyclic(_) => self.is_waiting = true,
            TransmissionType::Event => {
                self.is_due = true;
                self.poll(ram, rom, now);
            }
        }
    }

    /// Looks for a change, for a plain PDO; returns whether it is sent.
    #[inline]
    pub(super) fn look(&mut self, ram: &[u8], rom: &[u8], now: Instant) -> bool {
        let present = self.mapping.pack(ram, rom);
        if !self.is_due && present == self.content {
            return false;
        }
        // A new inhibit time counts from here.
        self.free_at = now;
        self.give_out(present)
    }

    /// Looks for a change, and at the times; returns the next deadline.
    pub(super) fn look_closely<D: Dictionary>(
        &mut self,
        dictionary: &D,
        node_id: u8,
        now: Instant,
    ) -> Instant {
        if D::FEATURES.multiplexed_pdo && self.addressing().is_some() {
            self.scan(dictionary, node_id, now)
        } else {
            self.poll(dictionary.ram(), D::TABLE.rom, now)
        }
    }

    /// Looks for a change and at the timers, for a PDO in use; returns the next deadline.
    fn poll(&mut self, ram: &[u8], rom: &[u8], now: Instant) -> Instant {
        match self.transmission_type {
            TransmissionType::Cyclic(_)
            | TransmissionType::SampledRequest
            | TransmissionType::Request
            | TransmissionType::Multiplexed(_) => NEVER,
            TransmissionType::Acyclic => {
                self.is_due |= self.mapping.pack(ram, rom) != self.content;
                NEVER
            }
            TransmissionType::Event => {
                self.start_inhibit_time(now);
                let present = self.mapping.pack(ram, rom);
                if self.is_waiting {
                    // Not on the bus yet: the newest values take its place, and cost no transmission of their own.
                    self.content = present;
                } else {
                    self.is_due |= present != self.content;
                }
                self.is_due |= has_come(self.event_at, now);
                if self.is_due && has_come(self.free_at, now) {
                    self.give_out(present);
                    self.free_at = after(now, self.inhibit_time);
                    self.restart_event_timer(now);
                }
                if self.is_due {
                    self.free_at
                } else {
                    self.event_at
                }
            }
        }
    }

    /// Whose objects its frames name, if they do.
    #[inline]
    pub(super) const fn addressing(&self) -> Option<Addressing> {
        match self.transmission_type {
            TransmissionType::Multiplexed(addressing) => Some(addressing),
            _ => None,
        }
    }

    /// Goes on with a scan of objects, one at a time, or begins one when the event timer runs out; for a PDO in source address
    /// mode. Returns the next deadline.
    #[cold]
    #[inline(never)]
    fn scan<D: Dictionary>(&mut self, dictionary: &D, node_id: u8, now: Instant) -> Instant {
        if has_come(self.event_at, now) {
            self.is_due = true;
            self.restart_event_timer(now);
        }
        self.start_inhibit_time(now);
        if self.is_due && !self.is_waiting && has_come(self.free_at, now) {
            if let Some(entry) = self.scan.next(dictionary) {
                let message = Message {
                    addressing: Addressing::Source,
                    node_id,
                    index: entry.index,
                    sub: entry.sub,
                    value: multiplexed::bytes_of(dictionary, entry),
                };
                self.send(&message, now);
            } else {
                self.scan = Scan::START;
                self.is_due = false;
            }
        }
        if self.is_due {
            // The bus takes its time for a frame that waits.
            let next = after(now, STEP);
            earlier(
                self.event_at,
                if has_come(self.free_at, next) {
                    next
                } else {
                    self.free_at
                },
            )
        } else {
            self.event_at
        }
    }

    /// Sends this message, if the one before has left and the inhibit time is over; returns whether it does.
    pub(super) fn send(&mut self, message: &Message, now: Instant) -> bool {
        let is_free = !self.is_waiting && has_come(self.free_at, now);
        if is_free {
            self.content = message.bytes();
            self.is_waiting = true;
            self.free_at = after(now, self.inhibit_time);
        }
        is_free
    }

    /// Whether it moves at all.
    pub(super) const fn is_in_use(&self) -> bool {
        self.cob_id != NOT_IN_USE
    }

    /// Whether it waits for SYNC.
    #[inline]
    pub(super) const fn is_synchronous(&self) -> bool {
        self.transmission_type.is_synchronous()
    }

    pub(super) const fn is_waiting(&self) -> bool {
        self.is_waiting
    }

    /// Which one it is, 0 for the first; of a PDO in use.
    #[inline]
    pub(super) const fn number(&self) -> u16 {
        self.number
    }

    pub(super) const fn cob_id(&self) -> u16 {
        self.cob_id
    }

    /// The frame that waits.
    pub(super) fn take(&mut self) -> Option<Frame> {
        if !self.is_waiting {
            return None;
        }
        self.is_waiting = false;
        self.has_left = self.has_inhibit_time();
        Some(Frame::of_length(
            self.cob_id,
            self.content,
            self.mapping.length(),
        ))
    }

    /// Whether its inhibit time is to begin.
    #[inline]
    pub(super) const fn has_left(&self) -> bool {
        self.has_left
    }

    /// The inhibit time begins when a frame leaves, however long it has waited for the bus.
    fn start_inhibit_time(&mut self, now: Instant) {
        if self.has_left || self.is_waiting && self.has_inhibit_time() {
            self.has_left = false;
            self.free_at = after(now, self.inhibit_time);
        }
    }

    /// Whether frames keep a distance.
    #[inline]
    pub(super) fn has_inhibit_time(&self) -> bool {
        self.inhibit_time.ticks() != 0 && self.is_looked_at_closely()
    }

    fn is_event_driven(&self) -> bool {
        self.cob_id != NOT_IN_USE && self.transmission_type == TransmissionType::Event
    }

    /// These values are to be sent; true, as something waits now.
    fn give_out(&mut self, present: [u8; 8]) -> bool {
        self.content = present;
        self.is_waiting = true;
        self.is_due = false;
        self.sync_count = 0;
        self.is_waiting
    }

    fn restart_event_timer(&mut self, now: Instant) {
        let has_timer = self.is_event_driven() || self.addressing() == Some(Addressing::Source);
        let is_off = self.event_timer.ticks() == 0 || !has_timer;
        self.event_at = if is_off {
            NEVER
        } else {
            after(now, self.event_timer)
        };
    }
}

fn milliseconds(time: u32) -> Duration {
    Duration::from_ticks(u64::from(time) * 1000)
}

/// The end of a span that begins now. PDO times are a few seconds at most, so it is never near the end of time.
fn after(now: Instant, span: Duration) -> Instant {
    Instant::from_ticks(now.ticks().saturating_add(span.ticks()))
}

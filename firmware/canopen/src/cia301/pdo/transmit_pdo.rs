//! One transmit PDO: when it is sent, and with what.

use super::mapping::Mapped;
use super::multiplexed::{self, Addressing, Message, Scan};
use super::parameters::{Communication, Parameters, TransmissionType};
use super::record::Record;
use crate::agenda::{Agenda, Object, SendPolicy, Word};
use crate::od::{Dictionary, Slots, Unused};
use crate::time::{Duration, Instant, NEVER, earlier, has_come};
use crate::wire::Frame;

/// How a PDO is looked at when values may have changed, or time has passed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Watch {
    /// Not at all.
    No,
    /// It is sent when a value has changed, with no time to look at.
    Plain,
    /// There is more to it.
    Closely,
}

/// Between two objects of a scan, unless the inhibit time is longer: a scan leaves the bus to others.
const STEP: Duration = Duration::from_ticks(1000);

/// A span that has not begun. All of a PDO that is not in use is zero.
const NOT_RUNNING: Instant = Instant::from_ticks(0);

/// One transmit PDO; `M` is its place for mapped objects.
#[derive(Debug)]
pub struct TransmitPdo<M> {
    record: Record<M>,
    /// How it is looked at when values may have changed.
    watch: Watch,
    /// SYNCs since the last transmission (types 1 to 240).
    sync_count: u8,
    /// Whether the SYNC with the start value has still to come.
    awaits_start: bool,
    /// Its bit in the agenda says whether `content` still waits to be taken.
    object: Object,
    /// Whether an event has happened that `content` does not show yet.
    is_due: bool,
    /// A frame has left, and the inhibit time has not begun yet.
    has_left: bool,
    /// How far the objects of the scanner lists have been sent.
    scan: Scan,
    /// What was last sampled or given out to be sent; a change is a difference from it.
    content: [u8; 8],
    /// When the inhibit time has begun; 0 if it never has.
    left_at: Instant,
    /// When the event timer runs out; 0 if it does not run.
    event_at: Instant,
}

impl<M: Slots<Mapped>> Unused for TransmitPdo<M> {
    const UNUSED: Self = Self {
        record: Record::NONE,
        watch: Watch::No,
        sync_count: 0,
        awaits_start: false,
        object: Object::BOOT_UP,
        is_due: false,
        has_left: false,
        scan: Scan::START,
        content: [0; 8],
        left_at: NOT_RUNNING,
        event_at: NOT_RUNNING,
    };
}

impl<M: Slots<Mapped>> TransmitPdo<M> {
    /// Takes the parameters from the dictionary. Returns whether they are others than before; then nothing is sent before
    /// [`TransmitPdo::start`], and the inhibit time of the last transmission goes on.
    pub(super) fn configure<D: Dictionary>(
        &mut self,
        dictionary: &D,
        parameters: Parameters,
        agenda: &mut Agenda<impl Slots<Word>>,
    ) -> bool {
        let is_changed = self.record.configure(dictionary, parameters);
        if is_changed {
            self.stop(agenda);
            self.event_at = NOT_RUNNING;
            self.find_watch();
            agenda.name(self.object, self.cob_id(), self.policy());
        }
        is_changed
    }

    /// Forgets everything; it is this object of the agenda.
    pub(super) fn reset(&mut self, object: Object, agenda: &mut Agenda<impl Slots<Word>>) {
        self.object = object;
        self.record.communication = Communication::NONE;
        self.stop(agenda);
        self.watch = Watch::No;
        self.has_left = false;
        self.left_at = NOT_RUNNING;
        self.event_at = NOT_RUNNING;
    }

    /// The places for its objects.
    pub(super) fn places(&mut self) -> &mut [Mapped] {
        self.record.mapping.objects.as_mut()
    }

    /// Multiplexed PDOs name another object each.
    fn policy(&self) -> SendPolicy {
        match self.addressing() {
            Some(_) => SendPolicy::Every,
            None if self.is_synchronous() => SendPolicy::AtSync,
            None => SendPolicy::Newest,
        }
    }

    fn find_watch(&mut self) {
        let communication = &self.record.communication;
        let has_times = communication.inhibit_time != 0 || communication.event_timer != 0;
        let kind = communication.transmission_type;
        self.watch = match self.addressing() {
            _ if !self.record.is_in_use() => Watch::No,
            Some(Addressing::Source) => Watch::Closely,
            Some(Addressing::Destination) => Watch::No,
            None if kind == TransmissionType::EVENT && !has_times => Watch::Plain,
            None if matches!(kind, TransmissionType::EVENT | TransmissionType::ACYCLIC) => {
                Watch::Closely
            }
            None => Watch::No,
        };
    }

    /// How it is looked at when values may have changed.
    #[inline]
    pub(super) const fn watch(&self) -> Watch {
        self.watch
    }

    /// The places in RAM that it looks at for changes, as one range.
    pub(super) fn watched(&self) -> (u16, u16) {
        if self.watch == Watch::No || self.addressing().is_some() {
            (0, 0)
        } else {
            self.record.mapping.ram()
        }
    }

    /// Operational begins for this PDO.
    pub(super) fn start<D: Dictionary>(
        &mut self,
        dictionary: &D,
        now: Instant,
        agenda: &mut Agenda<impl Slots<Word>>,
    ) {
        if !self.record.is_in_use() {
            return;
        }
        self.sync_count = 0;
        self.awaits_start = self.record.communication.sync_start != 0;
        self.content = self.record.mapping.pack(dictionary);
        // Operational counts as an event. The inhibit time holds across a short visit to another state.
        self.is_due = self.watch != Watch::No;
        self.event_at = NOT_RUNNING;
        if self.addressing().is_some() {
            self.scan = Scan::START;
            self.restart_event_timer::<D>(now);
        } else if self.is_event_driven() {
            self.poll(dictionary, now, agenda);
        }
    }

    /// Operational is over.
    pub(super) fn stop(&mut self, agenda: &mut Agenda<impl Slots<Word>>) {
        agenda.set(self.object, false);
        self.is_due = false;
    }

    /// A new event timer, counted from now; 0 for none. The one that it has already goes on.
    pub(super) fn set_event_timer<D: Dictionary>(&mut self, time: u16, now: Instant) {
        let event_timer = &mut self.record.communication.event_timer;
        if self.record.communication.cob_id != 0 && time != *event_timer {
            *event_timer = time;
            self.find_watch();
            self.restart_event_timer::<D>(now);
        }
    }

    /// A SYNC, for a synchronous PDO.
    #[inline]
    pub(super) fn on_sync<D: Dictionary>(
        &mut self,
        counter: Option<u8>,
        dictionary: &D,
        agenda: &mut Agenda<impl Slots<Word>>,
    ) {
        let every = self.record.communication.transmission_type.every();
        if every == 0 {
            return self.on_sync_after_event(dictionary, agenda);
        }
        self.sync_count = self.sync_count.saturating_add(1);
        if self.awaits_start {
            self.count_to_start(counter, every);
        }
        if self.sync_count >= every {
            self.give_out(self.record.mapping.pack(dictionary), agenda);
        }
    }

    /// A SYNC, for what is not sent at every n-th of them.
    #[inline(never)]
    fn on_sync_after_event<D: Dictionary>(
        &mut self,
        dictionary: &D,
        agenda: &mut Agenda<impl Slots<Word>>,
    ) {
        let present = self.record.mapping.pack(dictionary);
        if self.record.communication.transmission_type == TransmissionType::SAMPLED_REQUEST {
            self.content = present;
            return;
        }
        self.is_due |= present != self.content;
        if self.is_due {
            self.give_out(present, agenda);
        }
    }

    /// Nothing is counted before the SYNC with the start value, and at that one the PDO is sent. Without a counter there is
    /// nothing to wait for.
    #[cold]
    fn count_to_start(&mut self, counter: Option<u8>, every: u8) {
        let start = self.record.communication.sync_start;
        self.awaits_start = counter.is_some_and(|counter| counter != start);
        if self.awaits_start {
            self.sync_count = 0;
        } else if counter.is_some() {
            self.sync_count = every;
        }
    }

    /// The SYNC window has passed: what a SYNC has given out is too late. An event waits for the next SYNC.
    pub(super) fn window_passed(&mut self, agenda: &mut Agenda<impl Slots<Word>>) {
        let kind = self.record.communication.transmission_type;
        if kind == TransmissionType::ACYCLIC {
            self.is_due |= agenda.waits(self.object);
        }
        if kind.is_synchronous() && kind != TransmissionType::SAMPLED_REQUEST {
            agenda.set(self.object, false);
        }
    }

    /// A remote frame asks for this PDO.
    pub(super) fn on_request<D: Dictionary>(
        &mut self,
        dictionary: &D,
        now: Instant,
        agenda: &mut Agenda<impl Slots<Word>>,
    ) {
        let kind = self.record.communication.transmission_type;
        if self.addressing().is_some() {
            return;
        }
        if kind == TransmissionType::REQUEST {
            self.content = self.record.mapping.pack(dictionary);
            agenda.set(self.object, true);
        } else if kind == TransmissionType::SAMPLED_REQUEST {
            agenda.set(self.object, true);
        } else if self.record.communication.allows_request {
            if kind == TransmissionType::EVENT {
                self.is_due = true;
                self.poll(dictionary, now, agenda);
            } else {
                agenda.set(self.object, true);
            }
        }
    }

    /// Looks for a change, for a plain PDO.
    #[inline]
    pub(super) fn look<D: Dictionary>(
        &mut self,
        dictionary: &D,
        now: Instant,
        agenda: &mut Agenda<impl Slots<Word>>,
    ) {
        let present = self.record.mapping.pack(dictionary);
        if self.is_due || present != self.content {
            // A new inhibit time counts from here.
            self.left_at = now;
            self.give_out(present, agenda);
        }
    }

    /// Looks for a change, and at the times; returns the next deadline.
    #[inline(never)]
    pub(super) fn look_closely<D: Dictionary>(
        &mut self,
        dictionary: &D,
        node_id: u8,
        now: Instant,
        agenda: &mut Agenda<impl Slots<Word>>,
    ) -> Instant {
        if D::FEATURES.multiplexed_pdo && self.addressing().is_some() {
            self.scan(dictionary, node_id, now, agenda)
        } else if self.is_event_driven() {
            self.poll(dictionary, now, agenda)
        } else {
            self.is_due |= self.record.mapping.pack(dictionary) != self.content;
            NEVER
        }
    }

    /// Looks for a change and at the timers, for an event-driven PDO; returns the next deadline.
    fn poll<D: Dictionary>(
        &mut self,
        dictionary: &D,
        now: Instant,
        agenda: &mut Agenda<impl Slots<Word>>,
    ) -> Instant {
        self.start_inhibit_time(now, agenda);
        let present = self.record.mapping.pack(dictionary);
        if agenda.waits(self.object) {
            // Not on the bus yet: the newest values take its place, and cost no transmission of their own.
            self.content = present;
        } else {
            self.is_due |= present != self.content;
        }
        self.is_due |= has_come(self.timer_end(), now);
        if self.is_due && has_come(self.free_at(), now) {
            self.give_out(present, agenda);
            self.left_at = now;
            self.restart_event_timer::<D>(now);
        }
        if self.is_due {
            self.free_at()
        } else {
            self.timer_end()
        }
    }

    /// When the event timer runs out.
    fn timer_end(&self) -> Instant {
        if self.event_at == NOT_RUNNING {
            NEVER
        } else {
            self.event_at
        }
    }

    /// Whose objects its frames name, if they do.
    #[inline]
    pub(super) const fn addressing(&self) -> Option<Addressing> {
        self.record.mapping.layout.addressing
    }

    /// Goes on with a scan of objects, one at a time, or begins one when the event timer runs out; for a PDO in source address
    /// mode. Returns the next deadline.
    #[cold]
    #[inline(never)]
    fn scan<D: Dictionary>(
        &mut self,
        dictionary: &D,
        node_id: u8,
        now: Instant,
        agenda: &mut Agenda<impl Slots<Word>>,
    ) -> Instant {
        if has_come(self.timer_end(), now) {
            self.is_due = true;
            self.restart_event_timer::<D>(now);
        }
        self.start_inhibit_time(now, agenda);
        if self.is_due && !agenda.waits(self.object) && has_come(self.free_at(), now) {
            if let Some(entry) = self.scan.next(dictionary) {
                let message = Message {
                    addressing: Addressing::Source,
                    node_id,
                    index: entry.index,
                    sub: entry.sub,
                    value: multiplexed::bytes_of(dictionary, entry),
                };
                self.send(&message, now, agenda);
            } else {
                self.scan = Scan::START;
                self.is_due = false;
            }
        }
        if self.is_due {
            // The bus takes its time for a frame that waits.
            let next = after(now, STEP);
            let free_at = self.free_at();
            let next = if has_come(free_at, next) {
                next
            } else {
                free_at
            };
            earlier(self.timer_end(), next)
        } else {
            self.timer_end()
        }
    }

    /// Sends this message, if the one before has left and the inhibit time is over; returns whether it does.
    pub(super) fn send(
        &mut self,
        message: &Message,
        now: Instant,
        agenda: &mut Agenda<impl Slots<Word>>,
    ) -> bool {
        let is_free = !agenda.waits(self.object) && has_come(self.free_at(), now);
        if is_free {
            self.content = message.bytes();
            agenda.set(self.object, true);
            self.left_at = now;
        }
        is_free
    }

    /// Whether it waits for SYNC.
    #[inline]
    pub(super) const fn is_synchronous(&self) -> bool {
        self.record.is_synchronous()
    }

    #[inline]
    pub(super) const fn cob_id(&self) -> u16 {
        self.record.cob_id()
    }

    /// The frame that waits.
    #[inline]
    pub(super) fn take(&mut self, agenda: &mut Agenda<impl Slots<Word>>) -> Frame {
        agenda.set(self.object, false);
        if self.has_inhibit_time() {
            self.has_left = true;
            agenda.look();
        }
        Frame::of_length(
            self.record.cob_id(),
            self.content,
            self.record.mapping.length(),
        )
    }

    /// The inhibit time begins when a frame leaves, however long it has waited for the bus.
    fn start_inhibit_time(&mut self, now: Instant, agenda: &Agenda<impl Slots<Word>>) {
        if self.has_left || agenda.waits(self.object) && self.has_inhibit_time() {
            self.has_left = false;
            self.left_at = now;
        }
    }

    /// Whether frames keep a distance.
    #[inline]
    fn has_inhibit_time(&self) -> bool {
        self.record.communication.inhibit_time != 0 && self.watch == Watch::Closely
    }

    /// The end of the inhibit time.
    fn free_at(&self) -> Instant {
        if self.left_at == NOT_RUNNING {
            return self.left_at;
        }
        let inhibit_time = u32::from(self.record.communication.inhibit_time) * 100;
        after(self.left_at, Duration::from_ticks(inhibit_time.into()))
    }

    fn is_event_driven(&self) -> bool {
        let kind = self.record.communication.transmission_type;
        kind == TransmissionType::EVENT && self.addressing().is_none()
    }

    /// These values are to be sent.
    #[inline]
    fn give_out(&mut self, present: [u8; 8], agenda: &mut Agenda<impl Slots<Word>>) {
        self.content = present;
        agenda.set(self.object, true);
        self.is_due = false;
        self.sync_count = 0;
    }

    fn restart_event_timer<D: Dictionary>(&mut self, now: Instant) {
        let unit = if D::HABITS.event_timer_in_100_us {
            100
        } else {
            1000
        };
        let time = u32::from(self.record.communication.event_timer) * unit;
        let has_timer = self.is_event_driven() || self.addressing() == Some(Addressing::Source);
        self.event_at = if time == 0 || !has_timer {
            NOT_RUNNING
        } else {
            after(now, Duration::from_ticks(time.into()))
        };
    }
}

/// The end of a span that begins now. PDO times are a few seconds at most, so it is never near the end of time.
const fn after(now: Instant, span: Duration) -> Instant {
    Instant::from_ticks(now.ticks().saturating_add(span.ticks()))
}

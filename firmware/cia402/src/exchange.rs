//! What passes between the communication task and the control tick.
//!
//! Commands and the configuration go one way, actual values the other, each copied whole, so neither side ever sees half of a
//! change; what has not changed is not copied. The exchange keeps the last three sets of actual values: the answer to a SYNC shows the
//! drive as it was when the SYNC arrived, even if an early tick and a control tick ran in between.

mod actuals;

pub use actuals::Actuals;
pub(crate) use actuals::TickResult;

use canopen::Instant;
use heapless::Deque;

use crate::commands::Commands;
use crate::configuration::Configuration;
use crate::controlword::{NEW_SET_POINT, takes_records};
use crate::cyclic::{Buffer, SyncEvent};
use crate::faults::FaultNotice;
use crate::periphery::{Latched, Readings};
use crate::scope::{Orders, Status};
use crate::state_machine::State;
use crate::statusword::{HOMING_ATTAINED, HOMING_ERROR, TARGET_REACHED};
use actuals::History;

/// What waits for a control tick beside the commands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Waiting {
    /// The configuration is a new one.
    pub is_configured: bool,
    /// 60C4h:6 was 0 since the last tick: data records from before are not to be carried out.
    pub clears_records: bool,
    /// So many data records.
    pub records: usize,
    /// So many sync events.
    pub sync_events: usize,
    /// A transmit PDO has shown the state that was published last, or none can.
    pub is_seen: bool,
    /// The commands ask for something else than those of the tick before, and not only with other numbers.
    pub has_orders: bool,
    /// There are other commands than in the tick before, or the same ones were given again.
    pub has_commands: bool,
}

/// Sync events that wait for a tick. There is about one for each.
const SYNC_EVENTS: usize = 4;

/// News of faults that wait for the device; more than one tick can bring.
const NOTICES: usize = 16;

/// The shared resource. The communication task posts commands and reads actual values as of a moment; the control tick takes
/// commands and publishes. No call is longer than copying one of them.
#[derive(Debug)]
pub struct Exchange {
    commands: Commands,
    configuration: Configuration,
    /// The configuration has been set and not been taken yet.
    is_configured: bool,
    /// Counts calls of `post`.
    posted: u32,
    /// The count that the commands of the running tick carry.
    taken: u32,
    /// The count that the newest actual values answer.
    answered: u32,
    /// An edge of bit 4 was posted, and no tick has taken it yet.
    start_posted: bool,
    /// A tick has taken an edge of bit 4, and has not published yet.
    start_taken: bool,
    /// A transmit PDO has the statusword, so that masters may see the state.
    is_watched: bool,
    /// A transmit PDO has shown the state that was published last, or none can.
    is_seen: bool,
    /// A command to stop came, and no tick has taken it yet.
    is_urgent: bool,
    /// A command, to stop or another one, came, and no tick has taken it yet.
    has_orders: bool,
    /// The last tick was an early one.
    was_early: bool,
    actuals: History,
    notices: Deque<FaultNotice, NOTICES>,
    /// Sync events and data records that no tick has taken yet. A master fills the buffer 60C4h with records back to back.
    sync_events: Deque<SyncEvent, SYNC_EVENTS>,
    records: Buffer,
    /// 60C4h:6 was 0 since the last tick.
    clears_records: bool,
    lost_notices: u32,
    latched: Latched,
    readings: Readings,
    /// `latched` or `readings` has not been taken yet.
    has_news: bool,
    /// For the scope, what no tick has taken yet.
    orders: Option<Orders>,
    scope: Status,
}

impl Exchange {
    /// Nothing commanded, nothing published yet.
    pub const fn new() -> Self {
        Self {
            commands: Commands::NONE,
            configuration: Configuration::NONE,
            is_configured: false,
            posted: 0,
            taken: 0,
            answered: 0,
            start_posted: false,
            start_taken: false,
            is_watched: false,
            is_seen: false,
            is_urgent: false,
            has_orders: false,
            was_early: false,
            actuals: History::new(),
            notices: Deque::new(),
            sync_events: Deque::new(),
            records: Buffer::new(),
            clears_records: false,
            lost_notices: 0,
            latched: Latched::NONE,
            readings: Readings::NONE,
            has_news: false,
            orders: None,
            scope: Status::NONE,
        }
    }

    /// Posts commands. They replace those that no tick has taken yet, but for edges and commands to stop, which add up, and
    /// for a set-point whose edge has not been seen yet. Returns whether the motor is to stop, and an early tick is to see to it.
    pub fn post(&mut self, commands: Commands) -> bool {
        self.start_posted |= commands.rising & NEW_SET_POINT != 0;
        self.is_urgent |= commands.stop_behind(&self.commands) && self.newest().is_stoppable();
        self.has_orders |= !commands.repeat(&self.commands);
        self.commands = commands.after(&self.commands);
        self.posted = self.posted.wrapping_add(1);
        self.calls_early()
    }

    /// Whether a command to stop waits that an early tick is to carry out. Between two regular ticks there is one at most, however often a
    /// master changes its mind.
    pub const fn calls_early(&self) -> bool {
        self.is_urgent && !self.was_early
    }

    /// Posts the configuration. Call it before [`Exchange::post`], so that a tick that sees the commands knows it.
    pub fn configure(&mut self, configuration: &Configuration) {
        if !configuration.cyclic.buffer.is_open {
            self.clears_records = true;
            self.records.clear();
        }
        self.configuration.assign(configuration);
        self.is_configured = true;
    }

    /// Brings a control tick's copy of the commands up to date. Edges and commands to stop are given once. Returns what else there is to
    /// take.
    pub fn take(&mut self, commands: &mut Commands) -> Waiting {
        let has_commands = self.take_commands(commands);
        self.was_early = false;
        Waiting {
            has_commands,
            clears_records: core::mem::take(&mut self.clears_records),
            records: self.records.len(),
            sync_events: self.sync_events.len(),
            ..self.waiting()
        }
    }

    /// The same for an early tick. Data records and sync events are left for the regular one.
    pub fn take_early(&mut self, commands: &mut Commands) -> Waiting {
        let has_commands = self.take_commands(commands);
        self.was_early = true;
        Waiting {
            has_commands,
            ..self.waiting()
        }
    }

    /// Returns whether there were any.
    fn take_commands(&mut self, commands: &mut Commands) -> bool {
        self.is_urgent = false;
        let is_new = self.taken != self.posted;
        if is_new {
            commands.assign(&self.commands);
            self.commands.forget_passed();
            self.taken = self.posted;
            self.start_taken |= core::mem::take(&mut self.start_posted);
        } else {
            commands.forget_passed();
        }
        is_new
    }

    /// What waits for any tick.
    const fn waiting(&mut self) -> Waiting {
        Waiting {
            has_orders: core::mem::replace(&mut self.has_orders, false),
            has_commands: false,
            is_configured: self.is_configured,
            clears_records: false,
            records: 0,
            sync_events: 0,
            is_seen: self.is_seen || !self.is_watched,
        }
    }

    /// Brings a control tick's copy of the configuration up to date. Called after the commands are taken.
    pub fn take_configuration(&mut self, configuration: &mut Configuration) {
        self.is_configured = false;
        configuration.assign(&self.configuration);
    }

    /// Publishes what a control tick has made.
    pub fn publish(&mut self, actuals: &Actuals) {
        self.is_seen &= (self.newest().statusword ^ actuals.statusword) & State::BITS == 0;
        self.actuals.put(actuals);
        self.answered = self.taken;
        self.start_taken = false;
    }

    /// Whether masters may see the state of the drive in a transmit PDO.
    pub const fn watch(&mut self, is_watched: bool) {
        self.is_watched = is_watched;
    }

    /// Notes that this state was sent in a transmit PDO, or that no PDO has it.
    pub fn mark_state_shown(&mut self, state: State) {
        self.is_seen |= State::from_statusword(self.newest().statusword) == Some(state);
    }

    /// The touch probes have stored something, or are set up anew.
    pub fn latch(&mut self, latched: &Latched) {
        self.latched.assign(latched);
        self.has_news = true;
    }

    /// New readings.
    pub fn show(&mut self, readings: Readings) {
        self.has_news |= readings != self.readings;
        self.readings = readings;
    }

    /// Whether there is something to [`Exchange::take_news`].
    pub const fn has_news(&self) -> bool {
        self.has_news
    }

    /// What touch probes and readings are now. They are the newest, and not those of a moment: what a probe has stored stays.
    pub const fn take_news(&mut self) -> (Latched, Readings) {
        self.has_news = false;
        (self.latched, self.readings)
    }

    /// The dictionary has started anew: probes and readings are to be shown again.
    pub const fn show_again(&mut self) {
        self.has_news = true;
    }

    /// The newest actual values that were there at `stamp`. A stamp older than the last three ticks gets the oldest of them.
    ///
    /// Homing that is about to begin shows as begun, without waiting for the tick: a master that reads the statusword right behind
    /// its start would take the bits from before for the result.
    pub fn actuals_at(&self, stamp: Instant) -> Actuals {
        let mut actuals = *self.actuals.at(stamp);
        if (self.start_posted || self.start_taken) && actuals.is_ready_to_home() {
            actuals.statusword &= !(TARGET_REACHED | HOMING_ATTAINED | HOMING_ERROR);
        }
        actuals
    }

    /// The newest actual values.
    pub const fn newest(&self) -> &Actuals {
        self.actuals.newest()
    }

    /// Orders for the scope, which the next tick takes.
    pub fn order(&mut self, orders: Orders) {
        self.scope = self.scope.behind(&orders);
        self.orders = Some(orders.after(self.orders.unwrap_or_default()));
    }

    /// Whether something was ordered of the scope that no tick has taken yet.
    pub(crate) const fn has_orders(&self) -> bool {
        self.orders.is_some()
    }

    /// What was ordered of the scope since the last call.
    pub(crate) fn take_orders(&mut self) -> Orders {
        self.orders.take().unwrap_or_default()
    }

    /// Publishes the status of the recorder.
    pub(crate) const fn set_scope(&mut self, status: Status) {
        self.scope = status;
    }

    /// How the scope is, with the orders that no tick has taken yet.
    pub const fn scope(&self) -> Status {
        self.scope
    }

    /// Whether a tick that has seen the latest commands found power off and the motor at rest.
    pub fn is_safe(&self) -> bool {
        self.newest().safe && self.answered == self.posted
    }

    /// A sync event came, behind the commands that were posted with it.
    pub fn sync_event(&mut self, event: SyncEvent) {
        if self.sync_events.is_full() {
            self.sync_events.pop_front();
        }
        let _ = self.sync_events.push_back(event);
    }

    /// The oldest sync event that no tick has taken yet.
    pub fn take_sync_event(&mut self) -> Option<SyncEvent> {
        self.sync_events.pop_front()
    }

    /// A data record of the interpolated position mode came, behind the commands that were posted with it: by these it is taken or not. As many
    /// wait for a tick as 60C4h lets wait.
    pub fn record(&mut self, record: i32) {
        if takes_records(self.commands.controlword) {
            self.records.push(record, self.configuration.cyclic.buffer);
        }
    }

    /// The data records that no tick has taken yet are not to be carried out.
    pub(crate) fn forget_records(&mut self) {
        self.records.clear();
    }

    /// The oldest data record that no tick has taken yet.
    pub fn take_record(&mut self) -> Option<i32> {
        self.records.pop()
    }

    /// Hands news of a fault to the device. When the device has not come for a long time, the news is counted as lost
    /// (603Fh and 6041h still tell).
    pub fn notify(&mut self, notice: FaultNotice) {
        if self.notices.push_back(notice).is_err() {
            self.lost_notices = self.lost_notices.saturating_add(1);
        }
    }

    /// The next news of a fault, oldest first.
    pub fn take_notice(&mut self) -> Option<FaultNotice> {
        self.notices.pop_front()
    }

    /// The drive has started anew: its news of faults is void.
    pub fn forget_notices(&mut self) {
        self.notices.clear();
    }

    /// How much news of faults was lost since power-on.
    pub const fn lost_notices(&self) -> u32 {
        self.lost_notices
    }
}

impl Default for Exchange {
    fn default() -> Self {
        Self::new()
    }
}

/// Access to the exchange: directly where one thread owns it, through a lock where two tasks share it.
pub trait Share {
    /// Runs `f` on the exchange, alone.
    fn lock<R>(&mut self, f: impl FnOnce(&mut Exchange) -> R) -> R;
}

impl Share for Exchange {
    fn lock<R>(&mut self, f: impl FnOnce(&mut Exchange) -> R) -> R {
        f(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cyclic::RECORDS;

    #[test]
    fn m68_a_buffer_that_is_filled_between_two_ticks_keeps_every_record() {
        let mut exchange = Exchange::new();
        exchange.commands.controlword = 0x0F;
        for record in 1..=40 {
            exchange.record(record);
        }
        let records = std::iter::from_fn(|| exchange.take_record());
        assert!(records.eq((1..=40).take(RECORDS)));
    }
}

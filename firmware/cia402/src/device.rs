//! The communication half: a CANopen node whose dictionary belongs to a drive.
//!
//! The network may command the drive in NMT states Pre-operational (by SDO) and Operational. In Stopped, and while the
//! device starts anew, it may not: statusword bit 9 is 0. What the loss means to a drive with power 6007h says: nothing, a
//! fault, power off, or the quick stop ramp and then power off. It stays so when the network comes back; there is no motion
//! without new commands.
//!
//! A communication error (a watched node silent, life guarding, bus-off) takes the right to command away as well, whatever NMT
//! state 1029h leads to, until the motor stands without power; with 6007h = 0 it does not.
//!
//! A reset (NMT reset node, reset communication) is carried out when the motor stands without power, 20A1h after it came at the
//! latest. While the motor has power the device goes on as it was: heartbeat, emergency messages and process data tell of the stop, "disable
//! voltage" ends it at once, and so does a second reset. Reset node also resets a fault; reset communication leaves it, and 1001h shows it.

mod behaviour;
mod commissioning;
mod controller;
mod hooks;
mod periphery;
mod storage;
mod transient;

use canopen::cia301::nmt::{NmtState, Reset};
use canopen::cia301::sdo::AbortCode;
use canopen::cia301::sync;
use canopen::node::StoreError;
use canopen::od::{self};
use canopen::outbox::{Pending, Sender};
use canopen::settings::Source;
use canopen::{Application, BitRate, Counters, Duration, Event, Frame, Instant, Node, Settings};

use crate::actuator::TORQUE_MODES;
use crate::behaviour::{Behaves, Behaviour, View};
use crate::configuration::Configuration;
use crate::cyclic::SyncStatus;
use crate::exchange::{Actuals, Exchange, Share};
use crate::faults::{FaultNotice, emergency};
use crate::objects::{DriveStatus, Objects};
use crate::option_codes::AbortConnectionOption;
use crate::scope::Status;

use hooks::{Hooks, Network};

/// Pre-defined error field.
const ERROR_HISTORY: u16 = 0x1003;
/// Error code of the network that is lost without an error of the node: it was stopped.
const COMMUNICATION: u16 = 0x8100;

/// So long after the last SYNC, set-points of the cyclic modes count as they come.
const SILENCE: Duration = Duration::from_ticks(2_000_000);

/// How often a device that waits for its drive wants to be called.
const WAIT: Duration = Duration::from_ticks(1_000);

/// What the device is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Activity {
    /// Not powered on yet.
    Off,
    /// Serving the network.
    Running,
    /// A reset is due as soon as the drive is safe.
    Stopping(Reset),
}

/// A CANopen node with the hooks of the drive objects, and with an application `A` of the firmware for everything that a drive
/// does not say: streamed objects (DOMAIN), objects of the manufacturer, further rules.
#[derive(Debug)]
pub struct Device<D: Behaves, A = ()> {
    node: Node<D>,
    hooks: Hooks<A, D::Behaviour>,
    activity: Activity,
    /// The state of the network that was posted last.
    network: Network,
    /// The network was lost with this error, and the motor does not stand without power yet.
    lost: Option<u16>,
    /// The counters that the dictionary shows.
    counters: Counters,
    /// Since when an order to store waits, as the motor is not safe (standing without power).
    unsafe_since: Option<Instant>,
    /// Where node-ID and bit rate come from.
    sources: (Source, Source),
    /// When the last SYNC came.
    synced: Option<Instant>,
    /// What 5FF0h shows.
    configuration: canopen::Configuration,
    transient: transient::TransientStates,
    /// The motor is to stop before the next control tick.
    calls_early: bool,
}

impl<D: Behaves> Device<D> {
    /// A device that has just been powered; call [`Device::power_on`] next. `serial_number` becomes 1018h:4.
    pub fn new(dictionary: D, settings: Settings, serial_number: u32) -> Self {
        Self::with_application(dictionary, settings, serial_number, ())
    }
}

impl<D: Behaves, A: Application<D>> Device<D, A> {
    /// The same with an application, which hears of every write that the drive allows (its rules come first), and serves the
    /// streamed objects. What it writes to objects of the drive is seen with the next write of one by the network.
    // Out of line, so that it is made where it stays.
    #[inline(never)]
    pub fn with_application(
        dictionary: D,
        settings: Settings,
        serial_number: u32,
        application: A,
    ) -> Self {
        Self {
            node: Node::new(dictionary, settings),
            sources: commissioning::FACTORY_SOURCES,
            configuration: settings.configuration(),
            hooks: Hooks::new(serial_number, application),
            activity: Activity::Off,
            network: Network::Resetting { restart: false },
            lost: None,
            counters: Counters::default(),
            unsafe_since: None,
            synced: None,
            transient: transient::TransientStates::new(),
            calls_early: false,
        }
    }

    /// Its controller reaches these bit rates only; LSS refuses the others.
    pub fn support(&mut self, bit_rates: &[BitRate]) {
        self.node.support(bit_rates);
    }

    /// Its actuator can do these modes (`Actuator::MODES`); 6060h refuses the others.
    pub const fn moved_by(&mut self, modes: u32) {
        self.hooks.modes = modes;
    }

    /// With automatic bit rate detection ([`canopen::Node::detect`]).
    pub const fn detect(&mut self) {
        self.node.detect();
    }

    /// The bit rate of the network was found ([`canopen::Node::bit_rate_found`]), at power-on or later.
    pub fn bit_rate_found(&mut self, bit_rate: BitRate, now: Instant) {
        self.node.bit_rate_found(bit_rate, now);
    }

    /// Boots the node.
    pub fn power_on<X: Share>(&mut self, now: Instant, exchange: &mut X) {
        self.boot(Reset::Node, now, exchange);
    }

    /// Takes a frame; `stamp` is when it arrived. The dictionary shows the drive as it was at that moment.
    pub fn receive<X: Share>(&mut self, frame: &Frame, stamp: Instant, exchange: &mut X) {
        if self.activity == Activity::Off {
            return;
        }
        let actuals = self.refresh(stamp, true, exchange);
        if self.activity == Activity::Running {
            self.node.hold_resets(actuals.is_driving());
        }
        self.node.stay_reachable(actuals.has_power());
        self.hooks
            .protection
            .prepare(actuals.has_power(), actuals.is_moving, stamp);
        self.node.receive(frame, stamp, &mut self.hooks);
        self.take_reset();
        self.follow_state(&actuals, exchange);
        self.serve_behaviour(stamp);
        self.post(exchange);
        self.sync_event(stamp, exchange);
    }

    /// Whether a command to stop has come since the last call: [`crate::Drive::early_tick`] is to run at once, and not with the next
    /// control tick.
    pub const fn calls_early(&mut self) -> bool {
        let calls = self.calls_early;
        self.calls_early = false;
        calls
    }

    /// Lets time pass; call it after each control tick and at the returned deadline.
    pub fn poll<X: Share>(&mut self, now: Instant, exchange: &mut X) -> Instant {
        let soon = now.checked_add_duration(WAIT).unwrap_or(now);
        match self.activity {
            Activity::Off => return canopen::time::NEVER,
            Activity::Running => {}
            Activity::Stopping(reset) => {
                let is_safe = exchange.lock(|exchange| exchange.is_safe());
                if is_safe && !self.node.holds_reset() {
                    self.boot(reset, now, exchange);
                } else if is_safe || !self.node.holds_reset() {
                    // One call in silence: what has not left yet is void.
                    self.node.hold_resets(false);
                    self.watch(exchange);
                    return soon;
                }
            }
        }
        let actuals = self.refresh(now, false, exchange);
        self.report_faults(now, exchange);
        self.keep_overrun(&actuals, now);
        let deadline = self.node.poll(now, &mut self.hooks);
        self.take_reset();
        self.follow_state(&actuals, exchange);
        self.serve_behaviour(now);
        self.post(exchange);
        self.sync_event(now, exchange);
        self.serve_controller();
        self.serve_commissioning();
        match self.activity {
            Activity::Stopping(_) => deadline.min(soon),
            Activity::Off | Activity::Running => deadline,
        }
    }

    /// The next frame to send.
    pub fn transmit(&mut self) -> Option<Frame> {
        let frame = self.node.transmit(&mut self.hooks)?;
        self.sees(&frame);
        Some(frame)
    }

    /// Drops what is too late to be sent ([`Node::drop_late`]).
    pub fn drop_late(&mut self, now: Instant) {
        self.node.drop_late(now);
    }

    /// The next event for the firmware. Resets do not show here: the device stops the drive, then boots by itself. Of
    /// changes of the NMT state that the firmware does not fetch some may be left out, never the last one; what it has to do
    /// is not ([`Node::event`]).
    pub fn event(&mut self) -> Option<Event> {
        self.take_reset();
        self.node.event()
    }

    /// The result of [`Event::StoreSettings`].
    pub fn settings_stored(&mut self, result: Result<(), StoreError>) {
        self.node.settings_stored(result);
        self.end_storing_settings(result);
    }

    /// The owner of an object has finished a write that was to be completed later ([`Node::complete_write`]).
    pub fn complete_write(&mut self, index: u16, sub: u8, result: Result<(), AbortCode>) {
        self.node.complete_write(index, sub, result);
    }

    /// The application of the firmware.
    pub fn application(&self) -> &A {
        &self.hooks.application
    }

    /// The application of the firmware, writable.
    pub fn application_mut(&mut self) -> &mut A {
        &mut self.hooks.application
    }

    /// The object dictionary, for the firmware to put in what it has measured beside the drive.
    pub fn dictionary_mut(&mut self) -> &mut D {
        self.node.dictionary_mut()
    }

    /// The node, for its dictionary and state.
    pub fn node(&self) -> &Node<D> {
        &self.node
    }

    fn boot<X: Share>(&mut self, reset: Reset, now: Instant, exchange: &mut X) {
        self.activity = Activity::Running;
        self.hooks.protection.load();
        self.node.boot(reset, now, &mut self.hooks);
        self.take_reset();
        exchange.lock(Exchange::show_again);
        self.refresh(now, false, exchange);
        self.start_controller();
        self.start_commissioning();
        self.hooks.post_all_anew();
        self.post(exchange);
    }

    /// Puts the actual values of a moment in the dictionary.
    fn refresh<X: Share>(
        &mut self,
        stamp: Instant,
        serves_frame: bool,
        exchange: &mut X,
    ) -> Actuals {
        // Beside the actual values, which then are copied once.
        let (mut has_news, mut scope) = (false, Status::NONE);
        let actuals = exchange.lock(|exchange| {
            (has_news, scope) = (exchange.has_news(), exchange.scope());
            exchange.actuals_at(stamp)
        });
        let status = self.status(&actuals);
        let dictionary = self.node.dictionary_mut();
        show(dictionary, &actuals);
        dictionary.set_error_code(D::HABITS.code(actuals.error_code));
        dictionary.show_status(&status);
        if has_news {
            let (latched, readings) = exchange.lock(Exchange::take_news);
            periphery::show(self.node.dictionary_mut(), &latched, &readings);
        }
        if D::DRIVE.scope {
            self.hooks.scope.show(self.node.dictionary_mut(), scope);
        }
        if D::Behaviour::IS_THERE {
            let view = View {
                actuals: &actuals,
                state: self.node.state(),
                is_storing: self.node.is_storing(),
                errors: status.errors,
                serves_frame,
                at: stamp,
            };
            self.hooks.behaviour.look(self.node.dictionary_mut(), &view);
        }
        actuals
    }

    /// What the status words of the manufacturer are made from.
    #[inline]
    fn status(&self, actuals: &Actuals) -> DriveStatus {
        let errors = D::TOLD_ERRORS.iter().rev();
        let errors = errors.fold(0, |all, code| {
            all << 1 | u32::from(self.node.has_error(*code))
        });
        DriveStatus {
            statusword: actuals.statusword,
            inputs: actuals.digital_inputs,
            has_power: actuals.has_power(),
            is_referenced: actuals.referenced,
            is_moving: actuals.is_moving,
            mode: actuals.mode_display,
            errors,
        }
    }

    fn report_faults<X: Share>(&mut self, now: Instant, exchange: &mut X) {
        while let Some(notice) = exchange.lock(|exchange| exchange.take_notice()) {
            match notice {
                FaultNotice::Raised(code) => self.node.report(emergency(code), now),
                FaultNotice::Cleared(code) => self.node.clear(code, now),
            }
        }
    }

    /// A loss of the network begins when the node tells of it, and ends when the motor is safe. It is none if 6007h says that
    /// nothing is to follow.
    fn follow_network<X: Share>(&mut self, exchange: &mut X) {
        if self.node.take_network_loss() {
            let dictionary = self.node.dictionary();
            let option =
                AbortConnectionOption::from_code(dictionary.abort_connection_option_code());
            self.lost = (option != Some(AbortConnectionOption::NoAction)).then(|| {
                // The node has entered the error in its history a moment ago.
                let [low, high, ..] = od::read_u32(dictionary, ERROR_HISTORY, 1)
                    .unwrap_or(COMMUNICATION.into())
                    .to_le_bytes();
                u16::from_le_bytes([low, high])
            });
        } else if self.lost.is_some()
            && self.network != Network::Remote
            && exchange.lock(|exchange| exchange.is_safe())
        {
            self.lost = None;
        }
    }

    /// Resets are for the device, the other events of the node for the firmware.
    #[inline(never)]
    fn take_reset(&mut self) {
        if let Some(reset) = self.node.take_reset() {
            let reset = match self.activity {
                Activity::Stopping(first) => {
                    // Whoever resets twice does not want to wait for the motor.
                    self.hooks.disable_voltage();
                    if first == Reset::Node { first } else { reset }
                }
                Activity::Off | Activity::Running => reset,
            };
            self.activity = Activity::Stopping(reset);
            self.hooks.post_all_anew();
        }
    }

    /// Posts what is set up.
    #[cold]
    #[inline(never)]
    fn configure<X: Share>(&mut self, exchange: &mut X) {
        let dictionary = self.node.dictionary();
        let mut configuration = Configuration::of(dictionary);
        configuration.cyclic.cycle = od::read_u32(dictionary, sync::PERIOD, 0).unwrap_or_default();
        configuration.cyclic.is_measured = !self.hooks.has_period();
        self.hooks.set_units(configuration.units);
        exchange.lock(|exchange| exchange.configure(&configuration));
    }

    /// Posts commands if something has changed.
    fn post<X: Share>(&mut self, exchange: &mut X) {
        self.follow_network(exchange);
        let network = match (self.activity, self.lost, self.node.state()) {
            (Activity::Running, Some(code), _) => Network::Lost(code),
            (Activity::Running, None, NmtState::PreOperational | NmtState::Operational) => {
                Network::Remote
            }
            (Activity::Running, None, NmtState::Stopped) => Network::Lost(COMMUNICATION),
            (activity, ..) => Network::Resetting {
                restart: activity == Activity::Stopping(Reset::Node),
            },
        };
        if self.hooks.take_configured() {
            self.configure(exchange);
        }
        if D::DRIVE.scope
            && let Some(orders) = self.hooks.scope.take_orders()
        {
            exchange.lock(|exchange| exchange.order(orders));
        }
        if self.hooks.take_written() || network != self.network {
            self.network = network;
            let commands = self.hooks.commands(self.node.dictionary(), network);
            self.calls_early |= exchange.lock(|exchange| exchange.post(commands));
        }
    }
}

impl<D: Behaves, A: Application<D>> Device<D, A> {
    /// Tells of the SYNC, or the set-point where there is none, that came at `stamp`.
    fn sync_event<X: Share>(&mut self, stamp: Instant, exchange: &mut X) {
        let is_sync = self.node.take_sync();
        if is_sync {
            self.synced = Some(stamp);
        }
        if !is_sync && !self.hooks.has_set_point() {
            return;
        }
        if let Some(record) = self.hooks.take_record() {
            exchange.lock(|exchange| exchange.record(record));
        }
        let is_alone = self
            .synced
            .and_then(|at| stamp.checked_duration_since(at))
            .is_none_or(|silence| silence > SILENCE);
        if is_sync || is_alone {
            let event = self
                .hooks
                .sync_event(self.node.dictionary(), stamp, is_sync);
            exchange.lock(|exchange| exchange.sync_event(event));
        }
    }
}

impl<D: Behaves, A: Application<D>> Sender for Device<D, A> {
    fn pending(&self) -> Option<Pending> {
        self.node.pending()
    }

    fn take(&mut self, next: &Pending) -> Option<Frame> {
        let frame = self.node.take(next, &mut self.hooks)?;
        self.sees(&frame);
        Some(frame)
    }
}

/// Writes the actual values to the objects that show them.
fn show<D: Objects>(dictionary: &mut D, actuals: &Actuals) {
    dictionary.set_statusword(actuals.statusword);
    dictionary.set_modes_of_operation_display(actuals.mode_display);
    dictionary.set_position_demand_value(actuals.position_demand);
    dictionary.set_position_actual_internal_value(actuals.position_actual_internal);
    dictionary.set_position_actual_value(actuals.position_actual);
    dictionary.set_vl_velocity_demand(actuals.vl_velocity_demand);
    dictionary.set_vl_velocity_actual_value(actuals.vl_velocity_actual);
    dictionary.set_velocity_demand_value(actuals.velocity_demand);
    dictionary.set_velocity_actual_value(actuals.velocity_actual);
    dictionary.set_following_error_actual_value(actuals.following_error);
    if D::DRIVE.modes & TORQUE_MODES != 0 {
        dictionary.set_torque_demand(actuals.torque.demand);
        dictionary.set_torque_actual_value(actuals.torque.actual);
        dictionary.set_current_actual_value(actuals.torque.current);
    }
    dictionary.set_digital_inputs(actuals.digital_inputs);
    dictionary.set_homing_referenced(actuals.referenced.into());
    dictionary.set_homing_failure(actuals.homing_failure);
    show_sync(dictionary, &actuals.sync);
}

/// 2050h and 60C4h:4.
fn show_sync<D: Objects>(dictionary: &mut D, sync: &SyncStatus) {
    dictionary.set_sync_state(sync.state);
    dictionary.set_sync_period(sync.period);
    dictionary.set_sync_jitter(sync.jitter);
    dictionary.set_missed_syncs(sync.missed);
    dictionary.set_rejected_syncs(sync.rejected);
    dictionary.set_lost_set_points(sync.lost_set_points);
    dictionary.set_cyclic_latency(sync.latency);
    dictionary.set_interpolation_buffer_position(sync.buffered);
}

#[cfg(test)]
mod tests;

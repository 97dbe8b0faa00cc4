//! The device: every service behind one value.
//!
//! A received frame is handed to its service by identifier; services change the object dictionary, and the dictionary
//! changes the services. Time passes in [`Node::poll`]; frames to be sent are fetched with [`Node::transmit`].
//!
//! The contract:
//! - The device sends nothing and hears nothing before [`Node::boot`], and again from a commanded reset until the next
//!   [`Node::boot`]. The firmware learns of the reset by [`Event::ResetRequested`] and may stop first what moves; while that moves it
//!   holds resets back ([`Node::hold_resets`]), and the device goes on as it is.
//! - A reset leads through [`NmtState::Initialisation`], and [`Event::StateChanged`] tells of it. LSS answers that wait for
//!   the bus outlive it; everything else that waits is dropped.
//! - The first frame after a boot is the boot-up message, once.
//! - Without a node-ID the device stays in [`NmtState::Initialisation`] and serves LSS only.
//! - A command is executed before [`Node::receive`] returns, so that none is lost between two calls of [`Node::poll`].
//! - While the bit rate is switched nothing is sent, and SDO requests other than aborts are not executed: no answer could tell of
//!   them.
//! - Settings to store, a switch of the bit rate and a reset are told whatever else waits to be told.
//! - Time is the stamp of a frame and the moment given to [`Node::poll`]. Give every frame that has arrived before calling
//!   it: what is silent at that moment has timed out.
//! - Some times begin when a frame leaves: that of a client to confirm a sub-block, and the inhibit times of emergency
//!   messages and of PDOs. Call [`Node::poll`] once more after [`Node::transmit`] has given frames, or they begin with the next call only.
//! - Nothing here waits, allocates or panics, whatever the bus brings.

mod controller;
mod events;
mod identifiers;
mod indicators;
mod multiplexed;
mod objects;
mod parameters;
mod poll;
mod receive;
mod services;
mod supervision;
mod timing;
mod transmit;

use events::Events;
use identifiers::Identifiers;
use objects::Streams;
use services::Services;
use transmit::TransmitQueue;

use crate::agenda::Object;
use crate::application::Application;
use crate::can_controller::Controller;
use crate::cia301::emergency::{Emergency, Meant, ReceivedEmergency};
use crate::cia301::error_behaviour::CommunicationError;
use crate::cia301::nmt::{NmtState, Reset};
use crate::cia301::sdo;
use crate::cia302::startup;
use crate::cia305::{self, LssEvent};
use crate::od::{self, Counts, Dictionary};
pub use crate::settings::StoreError;
use crate::settings::{BitRate, BitTiming, Configuration, NodeId, PowerOn, Settings, Wish};
use crate::time::{Duration, Instant};
use crate::wire::sdo::Multiplexer;

/// What the firmware around the device has to know or to do. Taken with [`Node::event`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Event {
    /// The NMT state changed.
    StateChanged(NmtState),
    /// The network is lost: a watched node is silent, nobody guards this device any more, or the controller is bus-off. The NMT
    /// state has followed 1029h already.
    CommunicationError(CommunicationError),
    /// A reset was commanded, or LSS has given a first node-ID. The device is silent until [`Node::boot`] is called with
    /// this reset, so that what moves can be stopped first; where resets are held back ([`Node::hold_resets`]) it goes on.
    ResetRequested(Reset),
    /// Bus-off was long enough ago: start the CAN controller again, and tell [`Node::controller_changed`] when it is back.
    RestartController,
    /// Another device that 1028h listens to tells of an error, or of its end.
    EmergencyReceived(ReceivedEmergency),
    /// LSS asks to store this; answer with [`Node::settings_stored`].
    StoreSettings(Configuration),
    /// LSS asks to change the bit rate: nothing is sent for a delay, then the rate changes, then nothing is sent
    /// for the same delay again. The device keeps the silence itself; the firmware switches its controller at `at`.
    SwitchBitRate {
        /// The new bit rate.
        bit_rate: BitRate,
        /// When to switch.
        at: Instant,
    },
    /// LSS asks to find the bit rate of the network ([`cia305::Detection`]). The firmware takes its controller off the bus at `at`
    /// and listens; when it is on the bus again it calls [`Node::bit_rate_found`]. The device is silent until then.
    FindBitRate {
        /// When to leave the present bit rate.
        at: Instant,
    },
}

/// A CANopen device over the dictionary `D`, with as many PDOs as its data sheet has.
#[derive(Debug)]
pub struct Node<D: Dictionary> {
    /// Which identifiers concern this device. In front, where it is reached with a short offset.
    identifiers: Identifiers,
    dictionary: D,
    services: Services<D::Counts>,
    sdo: sdo::Servers<D::Counts>,
    lss: cia305::Slave,
    queue: TransmitQueue,
    events: Events,
    controller: Controller,
    state: NmtState,
    /// The node-ID in force.
    node_id: NodeId,
    /// Silent and deaf until the next boot.
    is_resetting: bool,
    /// A commanded reset does not silence the device.
    holds_resets: bool,
    /// One was commanded, and waits for the next boot.
    is_held: bool,
}

impl<D: Dictionary> Node<D> {
    /// A device that has just been powered, still silent: call [`Node::boot`] with [`Reset::Node`].
    // Not out of line: it is to be made where it stays, and not on the stack first.
    pub fn new(dictionary: D, settings: Settings) -> Self {
        let () = <D::Counts as Counts>::ARE_ENOUGH_SENDERS;
        Self {
            identifiers: Identifiers::none(),
            dictionary,
            services: Services::NEW,
            sdo: sdo::Servers::new(),
            lss: cia305::Slave::new(settings),
            queue: TransmitQueue::new(),
            events: Events::new(),
            controller: Controller::new(),
            state: NmtState::Initialisation,
            node_id: settings.node_id,
            is_resetting: true,
            holds_resets: false,
            is_held: false,
        }
    }

    /// Its controller reaches these bit rates only; LSS refuses the others (CiA 305, service 13h).
    pub fn support(&mut self, bit_rates: &[BitRate]) {
        self.lss = self.lss.supporting(bit_rates);
    }

    /// With automatic bit rate detection: LSS takes index 9 of its bit timing table 0, and the firmware serves
    /// [`Event::FindBitRate`].
    pub const fn detect(&mut self) {
        self.lss = self.lss.detecting();
    }

    /// It was powered on with these sources of node-ID and bit rate. What is stored stays stored until it is
    /// configured anew, and what the build has fixed cannot be configured: 11h and 13h answer FFh 01h.
    pub fn start(&mut self, power_on: &PowerOn) {
        self.lss = self.lss.started(power_on);
    }

    /// Loads power-on values, applies a pending node-ID and sends the boot-up message; then Pre-operational. An
    /// unconfigured device ([`NodeId::UNCONFIGURED`]) stays silent but for LSS. With a parameter store the device stays
    /// silent until [`Node::load_parameters`].
    ///
    /// [`Reset::Node`] loads every object and forgets the errors that stand (who still sees one reports it again).
    /// [`Reset::Communication`] loads 1000h to 1FFFh, except the identity object 1018h, which the firmware fills in. Errors that
    /// stand are told again after the boot-up message, as for an error that a device finds when it starts (CiA 301, 7.2.8.1).
    pub fn boot<A: Application<D>>(&mut self, reset: Reset, now: Instant, application: &mut A) {
        self.silence();
        self.serve_sdo(now, application);
        self.events.forget_reset();
        self.node_id = self.lss.reset();
        match reset {
            Reset::Node => {
                od::load_defaults(&mut self.dictionary, self.node_id.get(), 0..=u16::MAX);
                self.services.emergency.reset();
                application.power_on(&mut self.dictionary);
            }
            Reset::Communication => {
                od::load_defaults(&mut self.dictionary, self.node_id.get(), 0x1000..=0x1017);
                od::load_defaults(&mut self.dictionary, self.node_id.get(), 0x1019..=0x1FFF);
            }
        }
        self.services
            .configure(&mut self.dictionary, self.node_id, now);
        if reset == Reset::Communication {
            self.services.emergency.show_history(&mut self.dictionary);
        }
        if !self.services.parameters.reset(reset) {
            self.end_boot(now);
        }
    }

    /// The parameters are those to start with.
    fn end_boot(&mut self, now: Instant) {
        self.is_resetting = false;
        self.services.agenda.is_mute = self.must_be_mute(now);
        self.listen();
        if self.node_id.is_configured() {
            self.services.agenda.set(Object::BOOT_UP, true);
            // Of the errors that stand all are told, of those that the boot has ended none.
            self.services.emergency.drop_messages();
            self.services.emergencies_changed();
            self.enter(NmtState::PreOperational, now);
            self.services.emergency.tell_all::<D>(now);
            self.services.emergencies_changed();
            self.services.agenda.wake();
            if startup::starts_itself(&self.dictionary) {
                self.enter(NmtState::Operational, now);
            }
        }
        // Not before Pre-operational, which is the first state with emergency messages.
        self.report_controller_again(now);
    }

    /// Whether the NMT state has heartbeats.
    #[inline]
    fn has_heartbeat(&self) -> bool {
        self.state != NmtState::Initialisation
    }

    /// The next event for the firmware: changes of state in their order, then what LSS asks for, then a reset.
    pub fn event(&mut self) -> Option<Event> {
        self.events.pop()
    }

    /// The reset of [`Event::ResetRequested`], ahead of the events that wait before it.
    pub fn take_reset(&mut self) -> Option<Reset> {
        self.events.take_reset()
    }

    /// Whether commanded resets are held back from now on: something moves, and the network must be able to stop it, and to hear of it, until
    /// it stands. The device goes on as it is then, in the NMT state it is in. Without that, a reset that is held back silences the device
    /// now; [`Node::boot`] is still to be called.
    pub fn hold_resets(&mut self, holds: bool) {
        self.holds_resets = holds;
        if self.is_held && !holds {
            self.silence();
        }
    }

    /// Whether the network must be able to reach the device from now on, as its motor has power: LSS makes it deaf for long neither by the
    /// delay of a new bit rate nor by a search for one ([`cia305::Slave::stay_reachable`]).
    pub const fn stay_reachable(&mut self, stays: bool) {
        self.lss.stay_reachable(stays);
    }

    /// Whether a commanded reset is held back.
    pub fn holds_reset(&self) -> bool {
        self.is_held
    }

    /// The bit rate of the network was found, and the controller is on the bus with it.
    pub fn bit_rate_found(&mut self, bit_rate: BitRate, now: Instant) {
        self.lss.bit_rate_found(bit_rate);
        self.services.agenda.is_mute = self.must_be_mute(now);
        self.services.agenda.wake();
    }

    /// Configures and stores node-ID and bit rate without LSS, as an object of the manufacturer does. The node-ID counts from the
    /// next reset on, the bit rate from the next power-on. [`Event::StoreSettings`] follows; [`Node::is_storing_settings`] is false
    /// when it has been served.
    ///
    /// # Errors
    /// [`cia305::Refused`]: the build has fixed it, or the controller does not make the bit rate.
    pub fn configure_and_store(&mut self, wish: &Wish) -> Result<(), cia305::Refused> {
        self.lss.configure_and_store(wish)?;
        self.serve_lss_events();
        Ok(())
    }

    /// Whether [`Event::StoreSettings`] has not been served yet.
    pub fn is_storing_settings(&self) -> bool {
        self.lss.is_storing()
    }

    /// Node-ID and bit rate as they are stored, with all that was configured since.
    pub fn configuration(&self) -> Configuration {
        self.lss.configuration()
    }

    /// Whether the node-ID can be configured: the build has not fixed it.
    pub fn takes_node_id(&self) -> bool {
        self.lss.takes_node_id()
    }

    /// Whether this bit rate can be configured: the build has not fixed another, and the controller makes it.
    pub fn takes(&self, timing: BitTiming) -> bool {
        self.lss.takes(timing)
    }

    /// LSS stores node-ID and bit rate, or objects do.
    const CAN_STORE_SETTINGS: bool = D::FEATURES.lss || D::HABITS.settings_are_objects;

    /// The result of storing the settings of [`Event::StoreSettings`]; sends the answer to the LSS master, or asks to
    /// store the newer settings that the master has ordered meanwhile.
    pub fn settings_stored(&mut self, result: Result<(), StoreError>) {
        if Self::CAN_STORE_SETTINGS
            && let Some(answer) = self.lss.settings_stored(result)
            && D::FEATURES.lss
        {
            self.push_lss(answer);
        }
        self.serve_lss_events();
    }

    /// How long the SDO servers wait for the next frame of a client ([`sdo::TIME_OUT`] unless this is called). It holds
    /// from the next frame on.
    pub fn set_sdo_time_out(&mut self, time_out: Duration) {
        self.sdo.set_time_out(time_out);
    }

    /// The owner of an object has finished a write that was to be completed later ([`sdo::Completion::Later`]): the client gets
    /// its answer, if it still waits for it.
    pub fn complete_write(&mut self, index: u16, sub: u8, result: Result<(), sdo::AbortCode>) {
        let object = Multiplexer { index, sub };
        self.sdo.complete(object, result, &mut self.services.agenda);
    }

    /// An error appeared: error register, history, emergency message. Reported once until [`Node::clear`].
    pub fn report(&mut self, emergency: Emergency, now: Instant) {
        let error = emergency.message();
        self.services.report(&mut self.dictionary, error, now);
    }

    /// Whether an error with this code of the firmware stands.
    pub fn has_error(&self, code: u16) -> bool {
        let mut standing = self.services.emergency.standing();
        standing.any(|word| word as u16 == code)
    }

    /// An error is gone: its register bits fall and "error reset" is sent.
    pub fn clear(&mut self, code: u16, now: Instant) {
        self.services
            .clear(&mut self.dictionary, Meant::all(code), now);
    }

    /// The NMT state.
    pub fn state(&self) -> NmtState {
        self.state
    }

    /// The settings in force (not those LSS has configured for the next reset).
    pub fn settings(&self) -> Settings {
        self.lss.settings()
    }

    /// The object dictionary.
    pub fn dictionary(&self) -> &D {
        &self.dictionary
    }

    /// The object dictionary, for the firmware to put in actual values. A communication object (1000h to 1FFFh) that is
    /// written here takes effect at the next boot. The next [`Node::poll`] looks for transmit PDOs that have changed.
    pub fn dictionary_mut(&mut self) -> &mut D {
        self.services.values_changed();
        &mut self.dictionary
    }

    /// Whether nothing may be sent now: before [`Node::boot`], after a commanded reset, while the bit rate is switched, and while the
    /// controller is bus-off.
    /// A frame that has been fetched and has not reached the bus must wait; in [`NmtState::Initialisation`] it is void.
    pub fn is_mute(&self) -> bool {
        self.is_resetting || self.services.agenda.is_mute
    }

    /// What was lost since power-on because a queue was full: emergency messages, SDO requests, LSS answers, changes of
    /// state.
    pub fn overflows(&self) -> u32 {
        self.services
            .emergency
            .overflows()
            .saturating_add(self.queue.overflows())
            .saturating_add(self.events.overflows())
    }

    /// Changes the NMT state; nothing happens if it is the present one.
    fn enter(&mut self, state: NmtState, now: Instant) {
        if state == self.state {
            return;
        }
        self.leave_operational();
        self.state = state;
        // Transmit PDOs start, and with them their timers.
        self.services.agenda.look();
        self.services.enter(state, now);
        if state.has_sdo_and_emergency() {
            self.configure_sdo();
        } else {
            self.end_sdo();
        }
        if state == NmtState::Operational {
            self.services.rpdos.enter_operational();
            let services = &mut self.services;
            services
                .tpdos
                .enter_operational(&self.dictionary, now, &mut services.agenda);
        }
        self.events.state_changed(state);
    }

    fn leave_operational(&mut self) {
        if self.state == NmtState::Operational {
            self.services.rpdos.leave_operational();
            let services = &mut self.services;
            services.tpdos.leave_operational(&mut services.agenda);
        }
    }

    /// Ends what only states with SDO have.
    fn end_sdo(&mut self) {
        self.sdo.reset(&mut self.services.agenda);
        self.drop_sync();
        self.services.agenda.set(Object::TIME, false);
        // The application may have to learn that a client will not go on.
        self.services.agenda.wake();
    }

    /// Nothing is sent or heard from now on.
    fn silence(&mut self) {
        self.leave_operational();
        self.end_sdo();
        self.services.agenda.clear();
        self.services.emergency.drop_messages();
        if self.state != NmtState::Initialisation {
            self.state = NmtState::Initialisation;
            self.events.state_changed(self.state);
        }
        self.is_resetting = true;
        self.is_held = false;
        self.services.agenda.is_mute = true;
        self.identifiers = Identifiers::none();
    }

    /// Whether nothing may be sent.
    #[inline(never)]
    fn must_be_mute(&self, now: Instant) -> bool {
        self.is_resetting || self.controller.is_bus_off() || self.is_switching(now)
    }

    /// Whether the bit rate is being switched.
    fn is_switching(&self, now: Instant) -> bool {
        D::FEATURES.lss && self.lss.is_silent(now)
    }

    fn request_reset(&mut self, reset: Reset) {
        if self.holds_resets {
            self.is_held = true;
        } else {
            self.silence();
        }
        self.events.request_reset(reset);
    }

    /// The time-outs of SDO transfers, and what the application has to learn of them.
    fn serve_sdo<A: Application<D>>(&mut self, now: Instant, application: &mut A) {
        let mut streams = Streams {
            dictionary: &self.dictionary,
            application,
        };
        self.sdo.poll(now, &mut streams, &mut self.services.agenda);
    }

    /// Passes on what the LSS slave wants done.
    fn serve_lss_events(&mut self) {
        while Self::CAN_STORE_SETTINGS
            && let Some(event) = self.lss.event()
        {
            match event {
                LssEvent::Boot => self.request_reset(Reset::Communication),
                LssEvent::Store(settings) => self.events.request_store(settings),
                LssEvent::SwitchBitRate { bit_rate, at } => {
                    self.events.request_switch(BitTiming::Fixed(bit_rate), at);
                }
                LssEvent::FindBitRate { at } => {
                    self.events.request_switch(BitTiming::Automatic, at);
                }
            }
        }
    }
}

//! The communication objects (1000h to 1FFFh) behind one door: each has its rules beside its own code; this is the only
//! place that knows which code owns which index.

use crate::agenda::{Agenda, Object};
use crate::application::Application;
use crate::cia301::cob_ids;
use crate::cia301::emergency::{self, Emergency, Meant, Message};
use crate::cia301::error_behaviour::{self, CommunicationError};
use crate::cia301::error_report::ErrorReport;
use crate::cia301::guarding::{self, Guarding};
use crate::cia301::heartbeat;
use crate::cia301::nmt::NmtState;
use crate::cia301::parameters::{self, Parameters};
use crate::cia301::pdo;
use crate::cia301::sdo::{self, AbortCode};
use crate::cia301::sync::{self, Beat, Sync};
use crate::cia301::time_stamp::{self, TimeStamp};
use crate::cia302::startup;
use crate::od::{Counts, Dictionary, Entry};
use crate::settings::NodeId;
use crate::time::{Instant, earlier};
use crate::wire::cob_id;

/// The places for the objects of one mapping.
type Mapping<C> = <C as Counts>::PdoObjects<pdo::Mapped>;

/// The services whose behaviour is set by communication objects.
#[derive(Debug)]
pub(super) struct Services<C: Counts> {
    pub(super) heartbeat: heartbeat::Producer,
    pub(super) consumers: heartbeat::Consumers<C::HeartbeatConsumers<heartbeat::Consumer>>,
    pub(super) guarding: Guarding,
    pub(super) emergency: emergency::Producer,
    pub(super) sync: Sync,
    /// There was a SYNC that nobody has asked for yet.
    pub(super) synced: bool,
    pub(super) time: TimeStamp,
    pub(super) parameters: Parameters,
    pub(super) rpdos: pdo::Receive<C::Rpdos<pdo::ReceivePdo<Mapping<C>>>, Mapping<C>>,
    pub(super) tpdos: pdo::Transmit<C::Tpdos<pdo::TransmitPdo<Mapping<C>>>, Mapping<C>>,
    /// What waits for the bus, and when there is something to do.
    pub(super) agenda: Agenda<C::Senders>,
    /// Whether an event-driven transmit PDO may look at the error register or the history.
    errors_are_watched: bool,
    /// Whether the set of identifiers that concern this device may have changed.
    pub(super) identifiers_changed: bool,
}

impl<C: Counts> Services<C> {
    /// All zero: [`Services::configure`] goes before everything else.
    pub(super) const NEW: Self = Self {
        heartbeat: heartbeat::Producer::new(),
        consumers: heartbeat::Consumers::new(),
        guarding: Guarding::new(),
        emergency: emergency::Producer::new(),
        sync: Sync::new(),
        synced: false,
        time: TimeStamp::new(),
        parameters: Parameters::new(),
        rpdos: pdo::Receive::new(),
        tpdos: pdo::Transmit::new(),
        agenda: Agenda::new(),
        errors_are_watched: false,
        identifiers_changed: false,
    };

    /// Takes every parameter from the dictionary, after power-on values have been loaded.
    pub(super) fn configure<D: Dictionary>(
        &mut self,
        dictionary: &mut D,
        node_id: NodeId,
        now: Instant,
    ) {
        self.agenda.wake();
        self.agenda.look();
        self.heartbeat.configure(dictionary, now);
        self.consumers.configure(dictionary);
        if D::FEATURES.guarding {
            self.guarding.configure(dictionary);
        }
        self.emergency.configure(dictionary);
        self.clear_network_errors(dictionary, now);
        if D::FEATURES.sync {
            self.sync.configure(dictionary, now);
        }
        if D::FEATURES.time {
            self.time.configure(dictionary);
        }
        if D::FEATURES.parameters || D::FEATURES.configuration_date {
            self.parameters.configure(dictionary);
        }
        self.rpdos.configure_all(dictionary, node_id.get());
        self.tpdos
            .configure_all(dictionary, node_id.get(), &mut self.agenda);
        self.watch_values::<D>();
        self.report_errors(dictionary, now);
        self.emergency.show_register(dictionary);
    }

    /// Whether a communication object may get this value, which has passed the dictionary's own checks.
    pub(super) fn validate<D: Dictionary>(
        &mut self,
        dictionary: &D,
        entry: &Entry,
        value: &[u8],
    ) -> Result<(), AbortCode> {
        match entry.index {
            0x1003 | 0x1014 | 0x1015 => self.emergency.validate(dictionary, entry, value),
            sync::COB_ID | sync::COUNTER_OVERFLOW if D::FEATURES.sync => {
                self.sync.validate(dictionary, entry, value)
            }
            parameters::STORE | parameters::RESTORE if D::FEATURES.parameters => {
                self.parameters.validate::<D>(entry, value)
            }
            heartbeat::CONSUMER_INDEX => self.consumers.validate(entry, value),
            time_stamp::COB_ID | emergency::consumer::CONSUMER_INDEX => {
                cob_ids::validate(dictionary, entry, value, true)
            }
            startup::INDEX if const { D::TABLE.is_written(startup::INDEX, startup::INDEX) } => {
                startup::validate(value)
            }
            0x1200..=0x127F if const { D::TABLE.is_written(0x1200, 0x127F) } => {
                sdo::parameters::validate(dictionary, entry, value)
            }
            error_behaviour::INDEX => error_behaviour::validate(entry.sub, value),
            0x1400..=0x17FF => self.rpdos.validate(dictionary, entry, value),
            0x1800..=0x1BFF => self.tpdos.validate(dictionary, entry, value),
            0x1FA0..=0x1FFF if D::FEATURES.multiplexed_pdo => pdo::validate_list::<D>(entry, value),
            _ => Ok(()),
        }
    }

    /// A communication object was written.
    pub(super) fn written<D: Dictionary>(
        &mut self,
        dictionary: &mut D,
        entry: &Entry,
        now: Instant,
    ) {
        self.identifiers_changed = true;
        match entry.index {
            0x1003 | 0x1014 | 0x1015 => {
                self.emergency.written(dictionary, entry);
                self.emergency.poll(now);
                self.emergencies_changed();
            }
            sync::COB_ID | sync::PERIOD | sync::WINDOW | sync::COUNTER_OVERFLOW
                if D::FEATURES.sync =>
            {
                self.sync.written(dictionary, now);
                self.agenda.wake();
                self.report_errors(dictionary, now);
            }
            time_stamp::COB_ID if D::FEATURES.time => self.time.configure(dictionary),
            parameters::VERIFY_CONFIGURATION if D::FEATURES.configuration_date => {
                self.parameters.read_date(dictionary);
            }
            guarding::GUARD_TIME | guarding::LIFE_TIME_FACTOR if D::FEATURES.guarding => {
                if self.guarding.written(dictionary, now) {
                    self.end_life_guarding_error(dictionary, now);
                }
                self.agenda.wake();
            }
            heartbeat::CONSUMER_INDEX => {
                if let Some(error) = self.consumers.written(dictionary, entry, now) {
                    self.clear_one(dictionary, &error.emergency(), now);
                }
                self.agenda.wake();
            }
            heartbeat::PRODUCER_INDEX => {
                self.heartbeat.written(dictionary, now);
                if D::FEATURES.guarding && self.heartbeat.is_on() && self.guarding.stop() {
                    self.end_life_guarding_error(dictionary, now);
                }
                self.agenda.wake();
            }
            0x1400..=0x17FF => {
                self.rpdos.written(dictionary, entry);
                self.watch_values::<D>();
                self.report_errors(dictionary, now);
            }
            0x1800..=0x1BFF => {
                self.tpdos.written(dictionary, entry, now, &mut self.agenda);
                self.watch_values::<D>();
            }
            _ => {}
        }
    }

    /// The NMT state changed.
    pub(super) fn enter(&mut self, state: NmtState, now: Instant) {
        self.sync.enter(state.has_sync_and_time(), now);
        self.emergency.enter(state.has_sdo_and_emergency(), now);
        self.emergencies_changed();
        self.agenda.wake();
    }

    /// A SYNC, received or produced: transmit PDOs sample what the objects are now, then receive PDOs that waited for it are applied.
    pub(super) fn synchronise<D: Dictionary, A: Application<D>>(
        &mut self,
        beat: Beat,
        dictionary: &mut D,
        application: &mut A,
    ) {
        self.synced = true;
        self.tpdos
            .on_sync(beat.counter, dictionary, &mut self.agenda);
        if self.rpdos.on_sync(dictionary, application) {
            self.agenda.look();
        }
    }

    /// An error appeared.
    #[inline(never)]
    pub(super) fn report<D: Dictionary>(
        &mut self,
        dictionary: &mut D,
        error: Message,
        now: Instant,
    ) {
        self.emergency.report(dictionary, error, now);
        self.errors_changed();
    }

    /// These errors are gone.
    #[inline(never)]
    pub(super) fn clear<D: Dictionary>(&mut self, dictionary: &mut D, errors: Meant, now: Instant) {
        self.emergency.clear(dictionary, errors, now);
        self.errors_changed();
    }

    /// This error is gone; others with its code stand.
    pub(super) fn clear_one<D: Dictionary>(
        &mut self,
        dictionary: &mut D,
        emergency: &Emergency,
        now: Instant,
    ) {
        self.clear(dictionary, Meant::one(emergency), now);
    }

    fn end_life_guarding_error<D: Dictionary>(&mut self, dictionary: &mut D, now: Instant) {
        self.clear_one(
            dictionary,
            &CommunicationError::LifeGuarding.emergency(),
            now,
        );
    }

    /// Communication starts anew: what was known of other nodes is void, and so are the errors of it.
    fn clear_network_errors<D: Dictionary>(&mut self, dictionary: &mut D, now: Instant) {
        for code in [emergency::code::ERROR_CONTROL, emergency::code::COLLISION] {
            self.clear(dictionary, Meant::all(code), now);
        }
    }

    /// Nobody is lost before this moment.
    #[inline]
    pub(super) fn supervision_deadline<D: Dictionary>(&self) -> Instant {
        match D::FEATURES.guarding {
            true => earlier(self.consumers.deadline(), self.guarding.deadline()),
            false => self.consumers.deadline(),
        }
    }

    /// Calls `add` for each identifier that a parameter object gives to a service, to listen to or to send.
    pub(super) fn identifiers<D: Dictionary>(&self, dictionary: &D, mut add: impl FnMut(u16)) {
        add(self.sync.cob_id());
        add(self.time.cob_id());
        add(self.emergency.cob_id());
        self.rpdos.cob_ids().for_each(&mut add);
        self.tpdos.cob_ids().for_each(&mut add);
        if D::FEATURES.emergency_consumer {
            emergency::consumer::consumed(dictionary).for_each(|(cob_id, _)| add(cob_id));
        }
        let watched = self.consumers.watched();
        watched.map(cob_id::error_control).for_each(&mut add);
    }

    /// Whether a service that its parameters switch on sends this identifier.
    pub(super) fn is_sent(&self, cob_id: u16) -> bool {
        let sends_sync = self.sync.is_producer() && cob_id == self.sync.cob_id();
        let sends_time = self.time.is_producer() && cob_id == self.time.cob_id();
        sends_sync
            || sends_time
            || self.emergency.cob_id() == cob_id
            || self.tpdos.cob_ids().any(|sent| sent == cob_id)
    }

    /// A message may wait, and the errors may be mapped.
    fn errors_changed(&mut self) {
        self.emergencies_changed();
        if self.errors_are_watched {
            self.agenda.look();
        }
    }

    /// Emergency messages wait for the bus, or for a time.
    #[inline]
    pub(super) fn emergencies_changed(&mut self) {
        let waits = self.emergency.is_pending();
        self.agenda.set(Object::EMERGENCY, waits);
        if !waits && self.emergency.has_inhibit_time() {
            self.agenda.wake_at(self.emergency.deadline());
        }
    }

    /// Values of the dictionary may have changed.
    #[inline]
    pub(super) fn values_changed(&mut self) {
        if self.tpdos.is_watching() {
            self.agenda.look();
        }
    }

    /// Finds out whose changes the event-driven transmit PDOs look at.
    fn watch_values<D: Dictionary>(&mut self) {
        let watched = self.tpdos.watched();
        self.rpdos.watch(&watched);
        self.errors_are_watched = emergency::Producer::shows_in::<D>(&watched);
    }

    /// The synchronous window is over.
    pub(super) fn window_over(&mut self) {
        self.tpdos.window_passed(&mut self.agenda);
        self.rpdos.window_passed();
    }

    /// Passes on what SYNC and receive PDOs have found wrong with the length of frames, or right again.
    #[cold]
    #[inline(never)]
    pub(super) fn report_errors<D: Dictionary>(&mut self, dictionary: &mut D, now: Instant) {
        let next = |services: &mut Self| {
            let report = if D::FEATURES.sync {
                services.sync.report()
            } else {
                None
            };
            report.or_else(|| services.rpdos.report())
        };
        while let Some(report) = next(self) {
            match report {
                ErrorReport::Appeared(emergency) => {
                    self.report(dictionary, emergency.message(), now);
                }
                ErrorReport::Gone(emergency) => self.clear_one(dictionary, &emergency, now),
            }
        }
    }
}

//! The LSS slave: its two states, and what it answers in each.

use super::fastscan::{Outcome, Scan};
use super::identity::Identity;
use super::request::{Request, answer};
use super::sequence::Sequence;
use crate::node::StoreError;
use crate::settings::{BitRate, BitTiming, Configuration, NodeId, PowerOn, Settings, Source, Wish};
use crate::time::{Duration, Instant, NEVER};

/// What the node has to do after a request. Taken with [`Slave::event`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LssEvent {
    /// A device without a node-ID got one and left the configuration state: boot with [`Slave::reset`].
    Boot,
    /// Store this, then call [`Slave::settings_stored`].
    Store(Configuration),
    /// Switch the bit rate at `at`. Nothing is sent meanwhile and as long again ([`Slave::is_silent`]).
    SwitchBitRate {
        /// The new bit rate.
        bit_rate: BitRate,
        /// When to switch.
        at: Instant,
    },
    /// Find the bit rate of the network, from `at` on. Nothing is sent until [`Slave::bit_rate_found`].
    FindBitRate {
        /// When to leave the present bit rate.
        at: Instant,
    },
}

/// The two states of CiA 305.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// Only switching and identifying.
    Waiting,
    /// This slave is being configured.
    Configuration,
}

/// A change of the bit rate that is going on.
#[derive(Clone, Copy, Debug)]
struct Switch {
    to: BitTiming,
    at: Instant,
    end: Instant,
}

/// Storing takes a while; each service 17h is owed the truth about the settings that it has seen.
#[derive(Clone, Copy, Debug)]
enum Storing {
    /// Nothing is stored, no answer is owed.
    Idle,
    /// The result is to come, then the answer.
    Running,
    /// Service 17h came again meanwhile: this is stored next, and the answer tells of it.
    Again(Configuration),
}

/// What was to be configured cannot be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Refused;

/// What of the settings cannot be configured, as the build has fixed it.
#[derive(Clone, Copy, Debug, Default)]
struct Fixed {
    node_id: bool,
    bit_timing: bool,
}

/// What was pending and kept before [`Slave::configure_and_store`], as far as nothing was configured since.
#[derive(Clone, Copy, Debug, Default)]
struct Undo {
    node_id: Option<(NodeId, NodeId)>,
    bit_timing: Option<(BitTiming, BitTiming)>,
}

/// Answer to 11h and 13h: an error of the manufacturer, whose number follows.
const SPECIFIC_ERROR: u8 = 0xFF;

/// The manufacturer's error: the build of this firmware has fixed it.
const FIXED_BY_BUILD: u8 = 0x01;

/// The LSS slave of a device.
#[derive(Debug)]
pub struct Slave {
    state: State,
    /// In force.
    active: Settings,
    /// Configured, to come into force later.
    pending: Configuration,
    /// What is stored, with all that was configured since. It differs from what is pending if at power-on another source went
    /// before the store, such as switches.
    kept: Configuration,
    /// What comes back if it cannot be stored.
    undo: Undo,
    fixed: Fixed,
    supported: u16,
    sequence: Sequence,
    scan: Scan,
    switch: Option<Switch>,
    storing: Storing,
    /// A master waits for the answer to service 17h.
    owes_answer: bool,
    event: Option<LssEvent>,
}

impl Slave {
    /// A slave in the waiting state with these settings in force. It supports all bit rates of [`BitRate::ALL`].
    pub const fn new(settings: Settings) -> Self {
        Self {
            state: State::Waiting,
            active: settings,
            pending: settings.configuration(),
            kept: settings.configuration(),
            undo: Undo {
                node_id: None,
                bit_timing: None,
            },
            fixed: Fixed {
                node_id: false,
                bit_timing: false,
            },
            supported: !DETECTION,
            sequence: Sequence::None,
            scan: Scan::IDLE,
            switch: None,
            storing: Storing::Idle,
            owes_answer: false,
            event: None,
        }
    }

    /// The same, but it refuses bit rates that are not in this list.
    pub fn supporting(self, bit_rates: &[BitRate]) -> Self {
        Self {
            supported: bit_rates
                .iter()
                .fold(self.supported & DETECTION, |mask, bit_rate| {
                    mask | bit(BitTiming::Fixed(*bit_rate))
                }),
            ..self
        }
    }

    /// The same with automatic bit rate detection (index 9 of table 0), which the firmware carries out.
    pub const fn detecting(self) -> Self {
        Self {
            supported: self.supported | DETECTION,
            ..self
        }
    }

    /// The same after a power-on with these sources: what is stored is kept until it is configured anew, even if another source
    /// went before it; what the build has fixed cannot be configured.
    pub fn started(self, power_on: &PowerOn) -> Self {
        Self {
            pending: power_on.configuration(),
            kept: power_on.stored,
            fixed: Fixed {
                node_id: power_on.node_id.source == Source::Build,
                bit_timing: power_on.bit_timing.source == Source::Build,
            },
            ..self
        }
    }

    /// A request of eight bytes arrived on [`super::REQUEST_COB_ID`]. Returns the answer for
    /// [`super::RESPONSE_COB_ID`], if there is one; then ask [`Slave::event`]. While the bit rate is being switched
    /// nothing is heard.
    pub fn receive(
        &mut self,
        request: &[u8; 8],
        identity: &Identity,
        now: Instant,
    ) -> Option<[u8; 8]> {
        if self.is_silent(now) {
            return None;
        }
        let request = Request::parse(request);
        self.sequence.hear(request.as_ref());
        match (request?, self.state) {
            (Request::SwitchGlobal(mode), _) => self.switch_global(mode),
            (Request::Identify { step, word }, _) => self
                .sequence
                .identify(step, word, identity)
                .then(|| message(answer::IDENTIFIED, &[])),
            (Request::IdentifyNonConfigured, _) => self
                .is_non_configured()
                .then(|| message(answer::NON_CONFIGURED_IDENTIFIED, &[])),
            (Request::SwitchSelective { step, word }, State::Waiting) => {
                self.sequence.select(step, word, identity).then(|| {
                    self.enter(State::Configuration);
                    message(answer::SWITCHED_SELECTIVE, &[])
                })
            }
            (Request::Fastscan(request), State::Waiting) if self.is_non_configured() => {
                match self.scan.receive(request, identity) {
                    Outcome::Silent => return None,
                    Outcome::Answer => {}
                    Outcome::Found => self.enter(State::Configuration),
                }
                Some(message(answer::IDENTIFIED, &[]))
            }
            (request, State::Configuration) => self.configure(request, identity, now),
            (_, State::Waiting) => None,
        }
    }

    /// Lets time pass: a new bit rate comes into force. Returns the next deadline.
    pub fn poll(&mut self, now: Instant) -> Instant {
        let Some(switch) = self.switch else {
            return NEVER;
        };
        if let BitTiming::Fixed(bit_rate) = switch.to
            && now >= switch.at
        {
            self.active.bit_rate = bit_rate;
        }
        if now >= switch.end {
            self.switch = None;
            return NEVER;
        }
        if now >= switch.at {
            switch.end
        } else {
            switch.at
        }
    }

    /// The bit rate of the network was found ([`LssEvent::FindBitRate`], or at power-on): it is in force, and the silence is over.
    pub fn bit_rate_found(&mut self, bit_rate: BitRate) {
        self.active.bit_rate = bit_rate;
        self.switch = self
            .switch
            .filter(|switch| switch.to != BitTiming::Automatic);
    }

    /// What the node has to do, once.
    pub fn event(&mut self) -> Option<LssEvent> {
        self.event.take()
    }

    /// The settings in force.
    pub const fn settings(&self) -> Settings {
        self.active
    }

    /// The node-ID that comes into force with the next reset communication.
    pub const fn pending_node_id(&self) -> NodeId {
        self.pending.node_id
    }

    /// Communication starts anew, at NMT reset node and reset communication and for [`LssEvent::Boot`]: the pending node-ID
    /// comes into force, and the slave is in the waiting state. A switch of the bit rate and a store go on.
    pub fn reset(&mut self) -> NodeId {
        self.enter(State::Waiting);
        self.sequence = Sequence::None;
        self.active.node_id = self.pending.node_id;
        self.active.node_id
    }

    /// The result of [`LssEvent::Store`]. Returns the answer for [`super::RESPONSE_COB_ID`]; `None` when none is owed, or
    /// not yet: then [`Slave::event`] has newer settings to store.
    pub fn settings_stored(&mut self, result: Result<(), StoreError>) -> Option<[u8; 8]> {
        match self.storing {
            Storing::Idle => return None,
            Storing::Again(settings) => {
                self.storing = Storing::Running;
                self.event = Some(LssEvent::Store(settings));
                return None;
            }
            Storing::Running => self.storing = Storing::Idle,
        }
        let undo = core::mem::take(&mut self.undo);
        if result.is_err() {
            self.put_back(undo);
        }
        let error = match result {
            Ok(()) => 0x00,
            Err(StoreError::NotSupported) => 0x01,
            Err(StoreError::Medium) => 0x02,
        };
        core::mem::take(&mut self.owes_answer).then(|| message(answer::STORED, &[error]))
    }

    /// Configures and stores by another way than the services, such as an object: node-ID or bit rate or both. Then ask
    /// [`Slave::event`]; [`Slave::is_storing`] is false when it is done. If it cannot be stored, what was configured before comes
    /// back, unless a master has configured it anew meanwhile.
    ///
    /// # Errors
    /// The build has fixed it, or this device does not make the bit rate; nothing has changed.
    pub fn configure_and_store(&mut self, wish: &Wish) -> Result<(), Refused> {
        let timing_is_good = wish.bit_timing.is_none_or(|timing| self.takes(timing));
        let node_id_is_good = wish.node_id.is_none() || self.takes_node_id();
        if !timing_is_good || !node_id_is_good {
            return Err(Refused);
        }
        if let Some(node_id) = wish.node_id {
            let before = (self.pending.node_id, self.kept.node_id);
            self.undo.node_id.get_or_insert(before);
            self.pending.node_id = node_id;
            self.kept.node_id = node_id;
        }
        if let Some(timing) = wish.bit_timing {
            let before = (self.pending.bit_timing, self.kept.bit_timing);
            self.undo.bit_timing.get_or_insert(before);
            self.pending.bit_timing = timing;
            self.kept.bit_timing = timing;
        }
        self.store();
        Ok(())
    }

    fn put_back(&mut self, undo: Undo) {
        if let Some((pending, kept)) = undo.node_id {
            self.pending.node_id = pending;
            self.kept.node_id = kept;
        }
        if let Some((pending, kept)) = undo.bit_timing {
            self.pending.bit_timing = pending;
            self.kept.bit_timing = kept;
        }
    }

    /// Whether settings are being stored.
    pub const fn is_storing(&self) -> bool {
        !matches!(self.storing, Storing::Idle)
    }

    /// What is stored, with all that was configured since.
    pub const fn configuration(&self) -> Configuration {
        self.kept
    }

    /// Whether the node-ID can be configured: the build has not fixed it.
    pub const fn takes_node_id(&self) -> bool {
        !self.fixed.node_id
    }

    /// Whether this bit rate can be configured.
    pub const fn takes(&self, timing: BitTiming) -> bool {
        !self.fixed.bit_timing && self.supported & bit(timing) != 0
    }

    fn store(&mut self) {
        if let Storing::Idle = self.storing {
            self.storing = Storing::Running;
            self.event = Some(LssEvent::Store(self.kept));
        } else {
            self.storing = Storing::Again(self.kept);
        }
    }

    /// Whether nothing may be sent because the bit rate is being switched.
    pub fn is_silent(&self, now: Instant) -> bool {
        self.switch.is_some_and(|switch| now < switch.end)
    }

    /// Whether a master configures this slave now, or the slave waits for one because it has no node-ID.
    pub fn is_being_configured(&self) -> bool {
        self.state == State::Configuration || !self.active.node_id.is_configured()
    }

    /// Neither has a node-ID nor will get one: the only slaves that fastscan is for.
    fn is_non_configured(&self) -> bool {
        !self.active.node_id.is_configured() && !self.pending.node_id.is_configured()
    }

    /// Services of the configuration state.
    fn configure(
        &mut self,
        request: Request,
        identity: &Identity,
        now: Instant,
    ) -> Option<[u8; 8]> {
        match request {
            Request::ConfigureNodeId(number) => {
                let node_id = NodeId::new(number).ok_or(OUT_OF_RANGE);
                let result = node_id.and_then(|node_id| self.configure_node_id(node_id));
                Some(message(answer::NODE_ID_CONFIGURED, &error_code(result)))
            }
            Request::ConfigureBitTiming { table, index } => {
                // Tables above 0 belong to makers; this device has none.
                let in_table = (table == 0)
                    .then(|| BitTiming::from_table_index(index))
                    .flatten()
                    .ok_or(OUT_OF_RANGE);
                let result = in_table.and_then(|timing| self.configure_bit_timing(timing));
                Some(message(answer::BIT_TIMING_CONFIGURED, &error_code(result)))
            }
            Request::ActivateBitTiming(delay) => {
                let delay = Duration::from_ticks(u64::from(delay) * 1000);
                let at = after(now, delay);
                self.switch_bit_rate(at, delay);
                None
            }
            Request::Store => {
                self.owes_answer = true;
                self.store();
                None
            }
            Request::InquireIdentity { step } => {
                let word = identity.words().get(usize::from(step)).copied()?;
                Some(message(
                    answer::IDENTITY.wrapping_add(step),
                    &word.to_le_bytes(),
                ))
            }
            Request::InquireNodeId => Some(message(answer::NODE_ID, &[self.active.node_id.get()])),
            _ => None,
        }
    }

    /// A new node-ID, for the next reset communication and to be stored; refused with the error of service 11h.
    fn configure_node_id(&mut self, node_id: NodeId) -> Result<(), [u8; 2]> {
        if self.fixed.node_id {
            return Err([SPECIFIC_ERROR, FIXED_BY_BUILD]);
        }
        self.undo.node_id = None;
        self.pending.node_id = node_id;
        self.kept.node_id = node_id;
        Ok(())
    }

    /// A new bit rate, for service 15h and to be stored; refused with the error of service 13h.
    fn configure_bit_timing(&mut self, timing: BitTiming) -> Result<(), [u8; 2]> {
        if self.fixed.bit_timing {
            return Err([SPECIFIC_ERROR, FIXED_BY_BUILD]);
        }
        if self.supported & bit(timing) == 0 {
            return Err(OUT_OF_RANGE);
        }
        self.undo.bit_timing = None;
        self.pending.bit_timing = timing;
        self.kept.bit_timing = timing;
        Ok(())
    }

    /// Activate bit timing: the pending bit rate comes into force at `at`, between two silences of `delay`.
    fn switch_bit_rate(&mut self, at: Instant, delay: Duration) {
        let to = self.pending.bit_timing;
        let (end, event) = match to {
            BitTiming::Fixed(bit_rate) => {
                (after(at, delay), LssEvent::SwitchBitRate { bit_rate, at })
            }
            // Until the bit rate is found.
            BitTiming::Automatic => (NEVER, LssEvent::FindBitRate { at }),
        };
        self.switch = Some(Switch { to, at, end });
        self.event = Some(event);
    }

    /// Switch state global: both ways without an answer; a mode that does not exist changes nothing.
    fn switch_global(&mut self, mode: u8) -> Option<[u8; 8]> {
        match mode {
            0 => {
                let boots = self.state == State::Configuration
                    && !self.active.node_id.is_configured()
                    && self.pending.node_id.is_configured();
                if boots {
                    self.event = Some(LssEvent::Boot);
                }
                self.enter(State::Waiting);
            }
            1 => self.enter(State::Configuration),
            _ => {}
        }
        None
    }

    /// A scan ends with the state it was made in.
    fn enter(&mut self, state: State) {
        self.state = state;
        self.scan = Scan::IDLE;
    }
}

/// The bit of a bit rate in a mask, by its table index.
const fn bit(timing: BitTiming) -> u16 {
    1_u16.wrapping_shl(timing.table_index() as u32)
}

/// The bit of automatic detection.
const DETECTION: u16 = bit(BitTiming::Automatic);

/// The answer to 11h and 13h for what the device does not have.
const OUT_OF_RANGE: [u8; 2] = [0x01, 0x00];

/// Error code and specific error of an answer.
fn error_code(result: Result<(), [u8; 2]>) -> [u8; 2] {
    result.err().unwrap_or_default()
}

/// An answer: command specifier, data, zeros.
#[inline(never)]
fn message(specifier: u8, data: &[u8]) -> [u8; 8] {
    let mut bytes = [0; 8];
    for (to, from) in bytes
        .iter_mut()
        .zip(core::iter::once(&specifier).chain(data))
    {
        *to = *from;
    }
    bytes
}

/// The end of a span that begins now; a switch delay is about a minute at most.
fn after(now: Instant, span: Duration) -> Instant {
    Instant::from_ticks(now.ticks().saturating_add(span.ticks()))
}

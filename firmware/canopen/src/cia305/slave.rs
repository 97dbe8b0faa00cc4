//! The LSS slave: its two states, and what it answers in each.

mod configuration;

use super::fastscan::{Fastscan, Outcome, Scan};
use super::identity::Identity;
use crate::settings::StoreError;
use crate::settings::{BitRate, BitTiming, Configuration, NodeId, PowerOn, Settings, Source, Wish};
use crate::time::{Duration, Instant, NEVER, has_come};

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
    /// When the silence is over; 0 if none is under way.
    end: Instant,
}

impl Switch {
    const NONE: Self = Self {
        to: BitTiming::Automatic,
        at: Instant::from_ticks(0),
        end: Instant::from_ticks(0),
    };
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

/// The longest delay of service 15h that a device takes which must stay reachable ([`Slave::stay_reachable`]).
pub const LONGEST_SILENCE: Duration = Duration::millis(1_000);

/// What was to be configured cannot be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Refused;

/// The LSS slave of a device.
#[derive(Clone, Copy, Debug)]
pub struct Slave {
    state: State,
    /// In force.
    active: Settings,
    /// Configured, to come into force later.
    pending: Configuration,
    /// What is stored, with all that was configured since. It differs from what is pending if at power-on another source went
    /// before the store, such as switches.
    kept: Configuration,
    /// What goes before both if it can be stored: configured by [`Slave::configure_and_store`], and not anew since.
    wish: Wish,
    /// What can be configured: a bit for each bit rate, and [`FREE_NODE_ID`], [`FREE_BIT_TIMING`].
    supported: u16,
    /// The message that goes on with a service of several, which come in order and with no other between them; 0 for none.
    expected: u8,
    scan: Scan,
    switch: Switch,
    storing: Storing,
    /// A master waits for the answer to service 17h.
    owes_answer: bool,
    /// See [`Slave::stay_reachable`].
    stays_reachable: bool,
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
            wish: Wish::NOTHING,
            supported: !DETECTION,
            expected: 0,
            scan: Scan::IDLE,
            switch: Switch::NONE,
            storing: Storing::Idle,
            owes_answer: false,
            stays_reachable: false,
            event: None,
        }
    }

    /// The same, but it refuses bit rates that are not in this list.
    pub fn supporting(self, bit_rates: &[BitRate]) -> Self {
        Self {
            supported: bit_rates
                .iter()
                .fold(self.supported & !BIT_RATES, |mask, bit_rate| {
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
        let mut supported = self.supported;
        if power_on.node_id.source == Source::Build {
            supported &= !FREE_NODE_ID;
        }
        if power_on.bit_timing.source == Source::Build {
            supported &= !FREE_BIT_TIMING;
        }
        Self {
            pending: power_on.configuration(),
            kept: power_on.stored,
            supported,
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
        let [specifier, a, b, c, d, ..] = *request;
        let word = u32::from_le_bytes([a, b, c, d]);
        // Any other request ends a service of several messages, answered or not.
        let is_next = core::mem::take(&mut self.expected) == specifier;
        match (specifier, self.state) {
            (0x04, _) => self.switch_global(a),
            (0x40..=0x43, State::Waiting) => {
                let is_mine = identity.words().get(usize::from(specifier & 3)) == Some(&word);
                self.go_on(specifier, is_mine && (is_next || specifier == 0x40), 0x43)
                    .then(|| {
                        self.enter(State::Configuration);
                        message(answer::SWITCHED_SELECTIVE, 0)
                    })
            }
            (0x46..=0x4B, _) => {
                let is_mine = match specifier {
                    0x46 => identity.vendor_id == word,
                    0x47 => identity.product_code == word,
                    0x48 => identity.revision_number >= word,
                    0x49 => identity.revision_number <= word,
                    0x4A => identity.serial_number >= word,
                    _ => identity.serial_number <= word,
                };
                self.go_on(specifier, is_mine && (is_next || specifier == 0x46), 0x4B)
                    .then(|| message(answer::IDENTIFIED, 0))
            }
            (0x4C, _) => self
                .is_non_configured()
                .then(|| message(answer::NON_CONFIGURED_IDENTIFIED, 0)),
            (0x51, State::Waiting) if self.is_non_configured() => {
                let [.., bit_check, sub, next] = *request;
                let request = Fastscan {
                    id_number: word,
                    bit_check,
                    sub,
                    next,
                };
                match self.scan.receive(request, identity) {
                    Outcome::Silent => return None,
                    Outcome::Answer => {}
                    Outcome::Found => self.enter(State::Configuration),
                }
                Some(message(answer::IDENTIFIED, 0))
            }
            (_, State::Configuration) => self.configure(specifier, [a, b], identity, now),
            (_, State::Waiting) => None,
        }
    }

    /// A message of a service of several, which fits or does not; returns whether it was the last one, and all have fitted.
    fn go_on(&mut self, specifier: u8, fits: bool, last: u8) -> bool {
        if fits && specifier != last {
            self.expected = specifier.wrapping_add(1);
        }
        fits && specifier == last
    }

    /// Lets time pass: a new bit rate comes into force. Returns the next deadline.
    pub fn poll(&mut self, now: Instant) -> Instant {
        let Switch { to, at, end } = self.switch;
        if end == Switch::NONE.end {
            return NEVER;
        }
        let has_switched = has_come(at, now);
        if let BitTiming::Fixed(bit_rate) = to
            && has_switched
        {
            self.active.bit_rate = bit_rate;
        }
        if has_come(end, now) {
            self.switch = Switch::NONE;
            NEVER
        } else if has_switched {
            end
        } else {
            at
        }
    }

    /// Whether the network must be able to reach the device from now on, as a motor has power. Meanwhile service 15h changes nothing
    /// where it would leave the device deaf for long: with a delay beyond [`LONGEST_SILENCE`], or with a search for the bit rate,
    /// which has no end. The service has no answer in which this could be told.
    pub const fn stay_reachable(&mut self, stays: bool) {
        self.stays_reachable = stays;
    }

    /// The bit rate of the network was found ([`LssEvent::FindBitRate`], or at power-on): it is in force, and the silence is over.
    pub fn bit_rate_found(&mut self, bit_rate: BitRate) {
        self.active.bit_rate = bit_rate;
        if self.switch.to == BitTiming::Automatic {
            self.switch = Switch::NONE;
        }
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
        self.pending().node_id
    }

    /// Whether the device has a node-ID and gets another one with the next reset communication.
    pub(crate) fn has_new_node_id(&self) -> bool {
        let (active, pending) = (self.active.node_id, self.pending().node_id);
        active.is_configured() && pending.is_configured() && active != pending
    }

    /// What is pending.
    const fn pending(&self) -> Configuration {
        self.wish.over(self.pending)
    }

    /// Communication starts anew, at NMT reset node and reset communication and for [`LssEvent::Boot`]: the pending node-ID
    /// comes into force, and the slave is in the waiting state. A switch of the bit rate and a store go on.
    pub fn reset(&mut self) -> NodeId {
        self.enter(State::Waiting);
        self.expected = 0;
        self.active.node_id = self.pending().node_id;
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
        if result.is_ok() {
            self.pending = self.pending();
            self.kept = self.configuration();
        }
        self.wish = Wish::NOTHING;
        let error = match result {
            Ok(()) => 0x00,
            Err(StoreError::NotSupported) => 0x01,
            Err(StoreError::Medium) => 0x02,
        };
        core::mem::take(&mut self.owes_answer).then(|| message(answer::STORED, error))
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
        self.wish = Wish {
            node_id: wish.node_id.or(self.wish.node_id),
            bit_timing: wish.bit_timing.or(self.wish.bit_timing),
        };
        self.store();
        Ok(())
    }

    /// Whether settings are being stored.
    pub const fn is_storing(&self) -> bool {
        !matches!(self.storing, Storing::Idle)
    }

    /// What is stored, with all that was configured since.
    pub const fn configuration(&self) -> Configuration {
        self.wish.over(self.kept)
    }

    /// Whether the node-ID can be configured: the build has not fixed it.
    pub const fn takes_node_id(&self) -> bool {
        self.supported & FREE_NODE_ID != 0
    }

    /// Whether this bit rate can be configured.
    pub const fn takes(&self, timing: BitTiming) -> bool {
        self.has_free_bit_timing() && self.supported & bit(timing) != 0
    }

    /// Whether a bit rate can be configured: the build has not fixed it.
    const fn has_free_bit_timing(&self) -> bool {
        self.supported & FREE_BIT_TIMING != 0
    }

    fn store(&mut self) {
        if let Storing::Idle = self.storing {
            self.storing = Storing::Running;
            self.event = Some(LssEvent::Store(self.configuration()));
        } else {
            self.storing = Storing::Again(self.configuration());
        }
    }

    /// Whether nothing may be sent because the bit rate is being switched.
    pub fn is_silent(&self, now: Instant) -> bool {
        !has_come(self.switch.end, now)
    }

    /// Whether a master configures this slave now, or the slave waits for one because it has no node-ID.
    pub fn is_being_configured(&self) -> bool {
        self.state == State::Configuration || !self.active.node_id.is_configured()
    }

    /// Neither has a node-ID nor will get one: the only slaves that fastscan is for.
    fn is_non_configured(&self) -> bool {
        !self.active.node_id.is_configured() && !self.pending().node_id.is_configured()
    }

    /// Switch state global: both ways without an answer; a mode that does not exist changes nothing.
    fn switch_global(&mut self, mode: u8) -> Option<[u8; 8]> {
        match mode {
            0 => {
                let boots = self.state == State::Configuration
                    && !self.active.node_id.is_configured()
                    && self.pending().node_id.is_configured();
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

/// The command specifiers of answers that are not those of their requests.
mod answer {
    pub(super) const STORED: u8 = 0x17;
    pub(super) const SWITCHED_SELECTIVE: u8 = 0x44;
    pub(super) const IDENTIFIED: u8 = 0x4F;
    pub(super) const NON_CONFIGURED_IDENTIFIED: u8 = 0x50;
}

/// The bit of a bit rate in a mask, by its table index.
const fn bit(timing: BitTiming) -> u16 {
    1_u16.wrapping_shl(timing.table_index() as u32)
}

/// The bit of automatic detection.
const DETECTION: u16 = bit(BitTiming::Automatic);

/// The build has not fixed the node-ID.
const FREE_NODE_ID: u16 = 1 << 15;

/// The build has not fixed the bit rate.
const FREE_BIT_TIMING: u16 = 1 << 14;

/// The bits of all bit rates.
const BIT_RATES: u16 = !(DETECTION | FREE_NODE_ID | FREE_BIT_TIMING);

/// An answer: command specifier, four bytes of data, zeros.
fn message(specifier: u8, data: u32) -> [u8; 8] {
    (u64::from(data) << 8 | u64::from(specifier)).to_le_bytes()
}

/// The end of a span that begins now; a switch delay is about a minute at most.
fn after(now: Instant, span: Duration) -> Instant {
    Instant::from_ticks(now.ticks().saturating_add(span.ticks()))
}

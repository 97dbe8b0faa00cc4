//! The heartbeat consumers: which other nodes are watched, and whether they live.
//!
//! Each entry of object 1016h has a node-ID and a time in milliseconds. The contract:
//! - A node is watched from its first heartbeat on. A boot-up message (state 0) is not one.
//! - A node that is silent for its time is lost: told once, until its next heartbeat.
//! - The boot-up message of a node that lived tells that it has started anew. It is watched again from its next heartbeat on.
//! - A new time for the same node counts from when it is written; another node is waited for anew.

use crate::cia301::emergency::{Emergency, ErrorRegister, code};
use crate::cia301::nmt::NmtState;
use crate::cia301::sdo::AbortCode;
use crate::od::{self, Dictionary, Entry, Slots, Unused};
use crate::settings::NodeId;
use crate::time::{Duration, Instant, NEVER, earlier, has_come};

/// Index of the consumer heartbeat times.
pub const CONSUMER_INDEX: u16 = 0x1016;

/// What is wrong with a watched node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum HeartbeatError {
    /// No heartbeat for longer than its time.
    Lost(NodeId),
    /// It has started anew without being told to by this device.
    Restarted(NodeId),
}

impl HeartbeatError {
    /// The emergency of this error: the node-ID is the first byte of the info, the second one tells lost (0) from
    /// restarted (1).
    pub const fn emergency(self) -> Emergency {
        let (node_id, kind) = match self {
            Self::Lost(node_id) => (node_id, 0),
            Self::Restarted(node_id) => (node_id, 1),
        };
        Emergency {
            code: code::ERROR_CONTROL,
            register: ErrorRegister::COMMUNICATION,
            info: [node_id.get(), kind, 0, 0, 0],
        }
    }
}

/// What the error control message of a watched node has changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heard {
    /// This error is over: the node lives.
    Returned(HeartbeatError),
    /// The node was alive and has started anew.
    Restarted(NodeId),
}

/// One consumer, an entry of 1016h.
#[derive(Debug)]
pub struct Consumer {
    /// When the node is lost, while it lives.
    deadline: Instant,
    /// The time in ms; 0 for an entry that is not used.
    time: u16,
    /// The watched node; [`NodeId::NONE`] for an entry that is not used.
    node_id: NodeId,
    life: Life,
}

/// What is known of a watched node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Life {
    /// Not heard of yet.
    Unknown,
    /// Alive, in the state with this number.
    Alive(u8),
    /// It was alive, and is silent.
    Lost,
    /// It was alive, and has started anew.
    Restarted,
}

impl Unused for Consumer {
    const UNUSED: Self = Self {
        deadline: Instant::from_ticks(0),
        time: 0,
        node_id: NodeId::NONE,
        life: Life::Unknown,
    };
}

impl Consumer {
    #[inline(never)]
    fn new(value: u32) -> Self {
        let (node_id, time) = watched(value).unwrap_or((NodeId::NONE, 0));
        Self {
            deadline: NEVER,
            time,
            node_id,
            life: Life::Unknown,
        }
    }

    fn is_used(&self) -> bool {
        self.time != 0
    }

    fn error(&self) -> Option<HeartbeatError> {
        match self.life {
            Life::Unknown | Life::Alive(_) => None,
            Life::Lost => Some(HeartbeatError::Lost(self.node_id)),
            Life::Restarted => Some(HeartbeatError::Restarted(self.node_id)),
        }
    }

    fn restart(&mut self, now: Instant) {
        self.deadline = now + Duration::from_ticks(u64::from(self.time) * 1000);
    }

    fn receive(&mut self, state: u8, now: Instant) -> Option<Heard> {
        if state != NmtState::Initialisation as u8 {
            let error = self.error();
            self.life = Life::Alive(state);
            self.restart(now);
            error.map(Heard::Returned)
        } else if let Life::Alive(_) = self.life {
            self.life = Life::Restarted;
            self.deadline = NEVER;
            Some(Heard::Restarted(self.node_id))
        } else {
            None
        }
    }
}

/// The heartbeat consumers of a device; as many as there are places in `S`, the entries of 1016h.
#[derive(Debug)]
pub struct Consumers<S> {
    consumers: S,
    /// No node is lost before this moment.
    next: Instant,
}

impl<S: Slots<Consumer>> Consumers<S> {
    /// Nobody is watched until [`Consumers::configure`].
    pub const fn new() -> Self {
        Self {
            consumers: S::UNUSED,
            next: Instant::from_ticks(0),
        }
    }

    /// Takes its parameters from 1016h after power-on values were loaded; every node is waited for anew. Errors that stand are for
    /// the caller to clear.
    pub fn configure<D: Dictionary>(&mut self, dictionary: &D) {
        self.next = NEVER;
        for (sub, consumer) in (1..).zip(self.consumers.as_mut()) {
            let value = od::read_u32(dictionary, CONSUMER_INDEX, sub).unwrap_or(0);
            *consumer = Consumer::new(value);
        }
    }

    /// Whether an entry of 1016h may get this value. Called when it has passed the dictionary's own checks; nothing changes.
    ///
    /// # Errors
    /// - [`AbortCode::InvalidValue`]: reserved bits (CiA 301, 7.5.2.19). A node-ID that no node has is stored, and watches nobody.
    /// - [`AbortCode::ParameterIncompatible`]: another entry watches this node.
    pub fn validate(&self, entry: &Entry, value: &[u8]) -> Result<(), AbortCode> {
        let Ok(value) = value.try_into().map(u32::from_le_bytes) else {
            return Ok(());
        };
        let [.., reserved] = value.to_le_bytes();
        if reserved != 0 {
            return Err(AbortCode::InvalidValue);
        }
        let Some((node_id, _)) = watched(value) else {
            return Ok(());
        };
        let mut others = (1..)
            .zip(self.consumers.as_ref())
            .filter(|(sub, _)| *sub != entry.sub);
        if others.any(|(_, other)| other.node_id == node_id) {
            Err(AbortCode::ParameterIncompatible)
        } else {
            Ok(())
        }
    }

    /// An entry of 1016h was written. Returns the error that ends with it: the node is not watched any more.
    pub fn written<D: Dictionary>(
        &mut self,
        dictionary: &D,
        entry: &Entry,
        now: Instant,
    ) -> Option<HeartbeatError> {
        let place = usize::from(entry.sub.checked_sub(1)?);
        let consumer = self.consumers.as_mut().get_mut(place)?;
        let value = od::read_u32(dictionary, CONSUMER_INDEX, entry.sub).unwrap_or(0);
        let before = core::mem::replace(consumer, Consumer::new(value));
        if consumer.node_id != before.node_id {
            return before.error();
        }
        consumer.life = before.life;
        if let Life::Alive(_) = consumer.life {
            consumer.restart(now);
            self.next = earlier(self.next, consumer.deadline);
        }
        None
    }

    /// The nodes that are watched.
    pub fn watched(&self) -> impl Iterator<Item = NodeId> {
        let used = self.consumers.as_ref().iter().filter(|c| c.is_used());
        used.map(|consumer| consumer.node_id)
    }

    /// Whether a node is watched.
    pub fn watches(&self, node_id: NodeId) -> bool {
        self.watched().any(|watched| watched == node_id)
    }

    /// An error control message of a node arrived; `state` is its byte.
    pub fn receive(&mut self, node_id: NodeId, state: u8, now: Instant) -> Option<Heard> {
        let consumer = self.find_mut(node_id)?;
        let heard = consumer.receive(state, now);
        let deadline = consumer.deadline;
        self.next = earlier(self.next, deadline);
        heard
    }

    /// The NMT state of a node that is watched and alive; `None` for all others.
    pub fn state(&self, node_id: NodeId) -> Option<NmtState> {
        let mut consumers = self.consumers.as_ref().iter();
        let consumer = consumers.find(|consumer| consumer.node_id == node_id)?;
        match consumer.life {
            Life::Alive(state) => NmtState::from_number(state),
            _ => None,
        }
    }

    /// Lets time pass; returns a node that has just been lost. Call it until there is none.
    pub fn poll(&mut self, now: Instant) -> Option<NodeId> {
        if !has_come(self.next, now) {
            return None;
        }
        self.next = NEVER;
        let mut lost = None;
        for consumer in self.consumers.as_mut() {
            if lost.is_none() && has_come(consumer.deadline, now) {
                consumer.deadline = NEVER;
                consumer.life = Life::Lost;
                lost = Some(consumer.node_id);
            }
            self.next = earlier(self.next, consumer.deadline);
        }
        lost
    }

    /// [`Consumers::poll`] has nothing to do before this moment.
    pub const fn deadline(&self) -> Instant {
        self.next
    }

    fn find_mut(&mut self, node_id: NodeId) -> Option<&mut Consumer> {
        let mut consumers = self.consumers.as_mut().iter_mut();
        consumers.find(|consumer| consumer.node_id == node_id && consumer.is_used())
    }
}

impl<S: Slots<Consumer>> Default for Consumers<S> {
    fn default() -> Self {
        Self::new()
    }
}

/// The node and the time of a value of 1016h; `None` if it watches nobody: the node-ID is 0 or above 127, or the time is 0
/// (CiA 301, 7.5.2.19).
fn watched(value: u32) -> Option<(NodeId, u16)> {
    let [low, high, node_id, _] = value.to_le_bytes();
    let time = u16::from_le_bytes([low, high]);
    let node_id = NodeId::new(node_id).filter(|node_id| node_id.is_configured())?;
    (time != 0).then_some((node_id, time))
}

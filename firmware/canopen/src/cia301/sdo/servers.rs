//! All servers of a device: which one a frame is for, and which one sends next.

use super::AbortCode;
use super::objects::Streams;
use super::parameters::CobIds;
use super::server::Server;
use crate::agenda::{Agenda, Object, SendPolicy};
use crate::od::{Counts, Dictionary, Entry, Unused};
use crate::settings::NodeId;
use crate::time::{Duration, Instant, NEVER, earlier};
use crate::wire::Frame;
use crate::wire::sdo::Multiplexer;

/// The SDO servers of a device, 1200h and up, each with its own transfer.
#[derive(Debug)]
pub struct Servers<C: Counts> {
    servers: C::SdoServers<Server<C::SdoBuffer>>,
}

/// What the other servers of the device have under way.
#[derive(Debug)]
pub(crate) struct Others<'a, B> {
    before: &'a [Server<B>],
    after: &'a [Server<B>],
}

impl<B> Others<'_, B> {
    /// There are no others.
    pub(crate) const fn none() -> Self {
        Self {
            before: &[],
            after: &[],
        }
    }
}

impl<B: AsRef<[u8]> + AsMut<[u8]>> Others<'_, B> {
    /// Whether one of them writes this streamed object.
    pub(crate) fn are_writing(&self, entry: &Entry) -> bool {
        let mut all = self.before.iter().chain(self.after);
        all.any(|server| server.is_writing(entry))
    }

    /// Whether one of them reads this streamed object.
    pub(crate) fn are_reading(&self, entry: &Entry) -> bool {
        let mut all = self.before.iter().chain(self.after);
        all.any(|server| server.is_reading(entry))
    }
}

impl<C: Counts> Servers<C> {
    /// All zero: [`Servers::reset`] goes before everything else.
    pub(crate) const fn new() -> Self {
        Self {
            servers: Unused::UNUSED,
        }
    }

    /// Takes the identifiers: a state with SDO begins, or one of 1201h and up was written. A server whose identifiers change
    /// drops its transfer; an answer that waits leaves under the identifier that its request belongs to. The device has so many
    /// transmit PDOs.
    pub(crate) fn configure<D: Dictionary>(
        &mut self,
        dictionary: &D,
        node_id: NodeId,
        pdos: usize,
        agenda: &mut Agenda<C::Senders>,
    ) {
        for (number, server) in (0..).zip(self.servers.as_mut()) {
            let cob_ids = match number {
                0 => Some(CobIds::predefined(node_id)),
                _ => CobIds::of(dictionary, number),
            };
            server.configure(cob_ids);
            server.sender = Object::answer(number.into(), pdos);
            agenda.name(server.sender, server.response, SendPolicy::Every);
        }
    }

    /// How long clients may be silent within a transfer, counted from the next frame on.
    pub(crate) fn set_time_out(&mut self, time_out: Duration) {
        for server in self.servers.as_mut() {
            server.time_out = time_out;
        }
    }

    /// The identifiers of all servers that are on, in any NMT state.
    pub(crate) fn identifiers<D: Dictionary>(
        &self,
        dictionary: &D,
        node_id: NodeId,
    ) -> impl Iterator<Item = CobIds> {
        let others = 1..self.servers.as_ref().len() as u16;
        core::iter::once(CobIds::predefined(node_id))
            .chain(others.filter_map(|number| CobIds::of(dictionary, number)))
    }

    /// The NMT state has no SDO any more: nothing is heard, transfers and answers are dropped. Streamed objects that were
    /// being written are abandoned with the next [`Servers::poll`].
    pub(crate) fn reset(&mut self, agenda: &mut Agenda<C::Senders>) {
        for server in self.servers.as_mut() {
            server.reset();
            agenda.set(server.sender, false);
        }
    }

    /// The number of the server that hears this identifier.
    #[inline]
    pub(crate) fn find(&self, cob_id: u16) -> Option<usize> {
        self.servers
            .as_ref()
            .iter()
            .position(|server| server.request == cob_id)
    }

    /// Whether the next frame for a server may be for [`Servers::pass`].
    #[inline]
    pub(crate) fn is_in_segments(&self, number: usize) -> bool {
        let server = self.servers.as_ref().get(number);
        server.is_some_and(Server::is_in_segments)
    }

    /// Gives the next segment of a transfer to a server that has nothing to send. Returns when the server wants to be called;
    /// `None` if the frame is something else, which [`Servers::receive`] has to look at.
    #[inline]
    pub(crate) fn pass<S: Streams>(
        &mut self,
        number: usize,
        request: &[u8; 8],
        now: Instant,
        streams: &mut S,
        agenda: &mut Agenda<C::Senders>,
    ) -> Option<Instant> {
        let server = self.servers.as_mut().get_mut(number)?;
        if server.is_pending() || !server.pass(request, now, streams) {
            return None;
        }
        if server.is_pending() {
            agenda.set(server.sender, true);
        }
        Some(server.deadline())
    }

    /// One server, and what the others have under way.
    #[inline]
    #[expect(clippy::type_complexity, reason = "a server, and all but it")]
    pub(crate) fn split(
        &mut self,
        number: usize,
    ) -> Option<(&mut Server<C::SdoBuffer>, Others<'_, C::SdoBuffer>)> {
        let (before, rest) = self.servers.as_mut().split_at_mut_checked(number)?;
        let (server, after) = rest.split_first_mut()?;
        Some((server, Others { before, after }))
    }

    /// What a server has to send, and when it wants to be called.
    #[inline(always)] // In the middle of every request.
    pub(crate) fn settle(&self, number: usize, agenda: &mut Agenda<C::Senders>) {
        if let Some(server) = self.servers.as_ref().get(number) {
            if server.is_pending() {
                agenda.set(server.sender, true);
            } else {
                agenda.set(server.sender, false);
            }
            if server.is_open() {
                agenda.wake_at(server.deadline());
            }
        }
    }

    /// The owner of an object has finished a write: the answer to those that still wait for it.
    pub(crate) fn complete(
        &mut self,
        object: Multiplexer,
        result: Result<(), AbortCode>,
        agenda: &mut Agenda<C::Senders>,
    ) {
        for server in self.servers.as_mut() {
            server.complete(object, result);
            agenda.set(server.sender, server.is_pending());
        }
    }

    /// Lets time pass.
    pub(crate) fn poll<S: Streams>(
        &mut self,
        now: Instant,
        streams: &mut S,
        agenda: &mut Agenda<C::Senders>,
    ) {
        for server in self.servers.as_mut() {
            server.poll(now, streams);
            agenda.set(server.sender, server.is_pending());
        }
    }

    /// [`Servers::poll`] has nothing to do before this moment.
    pub(crate) fn deadline(&self) -> Instant {
        let servers = self.servers.as_ref().iter();
        servers.fold(NEVER, |next, server| earlier(next, server.deadline()))
    }

    /// The next answer of a server.
    #[inline(always)] // One call for each application that there is: a frame is written where it goes to.
    pub(crate) fn answer(
        &mut self,
        number: usize,
        agenda: &mut Agenda<C::Senders>,
    ) -> Option<Frame> {
        let server = self.servers.as_mut().get_mut(number)?;
        let answer = server.answers.pop()?;
        if !server.is_pending() {
            agenda.set(server.sender, false);
        }
        Some(Frame::full(server.response, answer))
    }

    /// The next segment of a block upload of a server that has no answer to send.
    pub(crate) fn segment<S: Streams>(
        &mut self,
        number: usize,
        streams: &mut S,
        agenda: &mut Agenda<C::Senders>,
    ) -> Option<Frame> {
        let server = self.servers.as_mut().get_mut(number)?;
        let segment = server.segment(streams);
        if !server.is_pending() {
            agenda.set(server.sender, false);
            if server.has_sent_sub_block() {
                // The time of the client begins.
                agenda.wake();
            }
        }
        segment.map(|segment| Frame::full(server.response, segment))
    }
}

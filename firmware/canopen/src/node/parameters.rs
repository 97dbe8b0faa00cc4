//! Loading parameters at a boot, and storing them in steps: where the device meets the [`ParameterStore`].

use core::ops::RangeInclusive;

use super::Node;
use super::objects::{Objects, is_communication_object};
use crate::application::Application;
use crate::cia301::nmt::Reset;
use crate::cia301::parameters::{
    CHUNK, Job, PARAMETERS_LOST, PARAMETERS_REFUSED, ParameterSet, ParameterSets, ParameterStore,
    Replay, Walk, Writer, loss, refusal,
};
use crate::cia301::sdo::{self, AbortCode, Others};
use crate::od::{self, Dictionary, Entry};
use crate::settings::StoreError;
use crate::time::Instant;
use crate::wire::sdo::Multiplexer;

/// The objects that are loaded at a reset; the identity object has nothing that is stored.
const fn loaded_at(reset: Reset) -> RangeInclusive<u16> {
    match reset {
        Reset::Node => 0..=u16::MAX,
        Reset::Communication => 0x1000..=0x1FFF,
    }
}

impl<D: Dictionary> Node<D> {
    /// The same device on a board that stores parameters. From now on every [`Node::boot`] waits for
    /// [`Node::load_parameters`], and 1010h and 1011h take their orders.
    pub fn with_parameter_store(mut self) -> Self {
        self.store_parameters_here();
        self
    }

    /// [`Node::with_parameter_store`] of a device that lies where it stays.
    pub const fn store_parameters_here(&mut self) {
        self.services.parameters.support();
    }

    /// Whether a boot waits for [`Node::load_parameters`].
    pub fn is_loading(&self) -> bool {
        matches!(self.services.parameters.job(), Job::Load(_))
    }

    /// Whether a master waits for [`Node::store_parameters`].
    pub fn is_storing(&self) -> bool {
        let job = self.services.parameters.job();
        !matches!(job, Job::Nothing | Job::Load(_))
    }

    /// Carries out an order of 1010h or 1011h that an object of the maker stands for, with this sub-index. Does nothing without such an
    /// entry or a store, or while the store is busy.
    pub fn order(&mut self, index: u16, sub: u8) {
        let is_free = matches!(self.services.parameters.job(), Job::Nothing);
        if let Ok(entry) = od::find::<D>(index, sub)
            && self.services.parameters.is_order(entry)
            && self.services.parameters.has_store()
            && is_free
        {
            self.services.parameters.begin(entry);
        }
    }

    /// Writes an object as an SDO client does, by all rules: for a text interface or a program in the device. A write that is to be completed later
    /// goes on.
    ///
    /// # Errors
    /// It is refused with this code, and nothing has changed.
    pub fn write<A: Application<D>>(
        &mut self,
        (index, sub): (u16, u8),
        value: &[u8],
        now: Instant,
        application: &mut A,
    ) -> Result<(), AbortCode> {
        let mut objects = Objects {
            dictionary: &mut self.dictionary,
            application,
            services: &mut self.services,
            others: Others::none(),
            now,
            number: [0; 8],
        };
        let entry = sdo::Objects::writable(&mut objects, Multiplexer { index, sub })?;
        sdo::Objects::write(&mut objects, entry, value).map(|_| ())
    }

    /// Ends a boot: what is stored takes the place of the power-on values, as far as it fits this device. What is damaged or
    /// does not fit is reported (6310h, 6320h). Does nothing if no boot waits for it.
    #[inline(never)]
    pub fn load_parameters<S: ParameterStore, A: Application<D>>(
        &mut self,
        store: &mut S,
        now: Instant,
        application: &mut A,
    ) {
        let Job::Load(reset) = self.services.parameters.job() else {
            return;
        };
        self.services.parameters.set_job(Job::Nothing);
        // What the last loading has found is void: that of a device without a node-ID is nobody's business, and it cannot send.
        self.clear(PARAMETERS_REFUSED, now);
        self.clear(PARAMETERS_LOST, now);
        let is_stale = matches!(reset, Reset::Communication) && self.services.parameters.is_stale();
        let mut replay = Replay::new(self.node_id.get(), loaded_at(reset));
        let mut lost = None;
        for set in ParameterSet::ALL {
            let mut objects = Objects {
                dictionary: &mut self.dictionary,
                application,
                services: &mut self.services,
                others: Others::none(),
                now,
                number: [0; 8],
            };
            if load(store, set, &mut replay, &mut objects).is_err() {
                lost = lost.or(Some(set));
            }
        }
        let mut objects = Objects {
            dictionary: &mut self.dictionary,
            application,
            services: &mut self.services,
            others: Others::none(),
            now,
            number: [0; 8],
        };
        let refused = replay.end(&mut objects);
        let refused = self.services.parameters.loaded(reset, is_stale, refused);
        self.services
            .configure(&mut self.dictionary, self.node_id, now);
        if refused.count > 0 || lost.is_some() || is_stale {
            // What the device has now is not what was dated.
            self.services.parameters.forget_date(&mut self.dictionary);
        }
        self.end_boot(now);
        if let Some(set) = lost {
            self.report(loss(set), now);
        }
        // Identifiers that follow the node-ID are not legal without one, and the next reset loads them again.
        if refused.count > 0 && self.node_id.is_configured() {
            self.report(refusal(&refused), now);
        }
    }

    /// Does the next step of what 1010h or 1011h have ordered: one call of the store, or a few bytes of it. Call it when the
    /// flash may be written, until [`Node::is_storing`] is false; the master is answered then.
    pub fn store_parameters<S: ParameterStore>(&mut self, store: &mut S, now: Instant) {
        let next = match self.services.parameters.job() {
            Job::Nothing | Job::Load(_) => return,
            Job::BeginSave(sets) => store.begin(sets).map(|()| Job::after(sets, None)),
            Job::Save(sets, walk) => self.save_chunk(store, sets, walk),
            Job::Commit(sets) => store.commit().map(|()| {
                self.services.parameters.saved(sets == ParameterSets::ALL);
                if sets == ParameterSets::ALL {
                    self.clear(PARAMETERS_LOST, now);
                    self.clear(PARAMETERS_REFUSED, now);
                }
                Job::Nothing
            }),
            Job::Forget(sets) => store.begin(sets).and_then(|()| store.commit()).map(|()| {
                self.services.parameters.forget_date(&mut self.dictionary);
                Job::Nothing
            }),
        };
        match next {
            Ok(Job::Nothing) => self.end_storing(Ok(())),
            Ok(job) => self.services.parameters.set_job(job),
            Err(error) => self.end_storing(Err(error.into())),
        }
    }

    /// Hands over the next chunk.
    // Out of line, as loading is: the chunk is on the stack only as long as there is one.
    #[inline(never)]
    fn save_chunk<S: ParameterStore>(
        &self,
        store: &mut S,
        sets: ParameterSets,
        mut walk: Walk,
    ) -> Result<Job, StoreError> {
        let mut chunk = [0; CHUNK];
        let length = walk.fill(&self.dictionary, self.node_id.get(), &mut chunk);
        match chunk.get(..length) {
            None | Some([]) => Ok(Job::after(sets, Some(walk.set))),
            Some(chunk) => {
                store.append(walk.set, chunk)?;
                Ok(Job::Save(sets, walk))
            }
        }
    }

    /// The order of 1010h or 1011h cannot be carried out: 08000022h says that the device is not in a state to store. What
    /// was stored before stays. Does nothing if nothing was ordered.
    pub fn refuse_storing(&mut self, code: AbortCode) {
        if self.is_storing() {
            self.end_storing(Err(code));
        }
    }

    /// Answers the master, if it still waits.
    fn end_storing(&mut self, result: Result<(), AbortCode>) {
        self.services.parameters.set_job(Job::Nothing);
        let (index, sub) = self.services.parameters.order();
        self.complete_write(index, sub, result);
    }
}

/// Loads one set.
fn load<S: ParameterStore, W: Writer>(
    store: &mut S,
    set: ParameterSet,
    replay: &mut Replay,
    writer: &mut W,
) -> Result<(), StoreError> {
    for number in 0..store.open(set)? {
        let mut chunk = [0; CHUNK];
        let length = store.read(set, number, &mut chunk)?;
        replay.chunk(chunk.get(..length).unwrap_or(&[]), writer);
    }
    Ok(())
}

impl<D: Dictionary, A: Application<D>> Writer for Objects<'_, D, A> {
    type Dictionary = D;

    fn dictionary(&mut self) -> &mut D {
        self.dictionary
    }

    fn write(&mut self, entry: &'static Entry, value: &[u8]) -> Result<(), AbortCode> {
        let written = if is_communication_object(entry) {
            self.write_communication_object(entry, value, false)
        } else {
            sdo::Objects::write(self, entry, value)
        };
        written.map(|_| ())
    }
}

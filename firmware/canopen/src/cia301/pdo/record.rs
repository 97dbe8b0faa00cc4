//! What the two records of a PDO say, received or transmitted: when it moves, and which objects.

use super::mapping::{Mapped, Mapping};
use super::parameters::{Communication, Parameters};
use crate::od::{Dictionary, Slots};

/// The parameters of one PDO; `M` is its place for mapped objects.
#[derive(Debug)]
pub(super) struct Record<M> {
    pub(super) communication: Communication,
    pub(super) mapping: Mapping<M>,
}

impl<M: Slots<Mapped>> Record<M> {
    /// Not in use.
    pub(super) const NONE: Self = Self {
        communication: Communication::NONE,
        mapping: Mapping::NOTHING,
    };

    /// Takes the parameters from the dictionary. Returns whether they are others than before: a mapping changes only while the
    /// PDO is not in use, so the communication parameter tells.
    pub(super) fn configure<D: Dictionary>(
        &mut self,
        dictionary: &D,
        parameters: Parameters,
    ) -> bool {
        let objects = self.mapping.objects.as_mut();
        let (communication, layout) = parameters.read(dictionary, objects);
        self.mapping.layout = layout;
        let is_changed = communication != self.communication;
        self.communication = communication;
        is_changed
    }

    /// Its identifier; 0 when it is not in use.
    #[inline]
    pub(super) const fn cob_id(&self) -> u16 {
        self.communication.cob_id
    }

    /// Whether it moves at all.
    #[inline]
    pub(super) const fn is_in_use(&self) -> bool {
        self.communication.cob_id != 0
    }

    /// Whether SYNC makes the moment.
    #[inline]
    pub(super) const fn is_synchronous(&self) -> bool {
        self.is_in_use() && self.communication.transmission_type.is_synchronous()
    }
}

//! How a script names a station.

use std::fmt;
use std::marker::PhantomData;

/// A station attached to a [`super::Bus`], by its type.
pub struct Handle<S> {
    number: usize,
    station: PhantomData<fn() -> S>,
}

impl<S> Handle<S> {
    pub(super) fn new(number: usize) -> Self {
        Self {
            number,
            station: PhantomData,
        }
    }

    /// The number of the station, in order of attachment from 0; [`super::Logged::sender`] names it.
    pub fn number(self) -> usize {
        self.number
    }
}

impl<S> Clone for Handle<S> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<S> Copy for Handle<S> {}

impl<S> fmt::Debug for Handle<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "station {}", self.number)
    }
}

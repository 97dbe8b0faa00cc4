//! What a value is after a reset: what a DCF configures, or the default of the data sheet.

use std::ops::RangeInclusive;

use crate::model::{DefaultValue, Entry, Field, Model};
use crate::source::Span;

/// A number that the device starts with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Setting {
    /// Without the node-ID.
    pub(super) value: i128,
    pub(super) adds_node_id: bool,
    /// Where it is written.
    pub(super) span: Span,
}

impl Setting {
    /// The number of an entry; `None` of one that is no integer, and where nothing states it.
    pub(super) fn of(entry: &Entry) -> Option<Self> {
        let (value, field) = match (&entry.configured, &entry.default) {
            (Some(value), _) => (value, Field::ParameterValue),
            (None, Some(value)) => (value, Field::DefaultValue),
            (None, None) => return None,
        };
        let DefaultValue::Number {
            value,
            adds_node_id,
        } = *value
        else {
            return None;
        };
        Some(Self {
            value,
            adds_node_id,
            span: entry.places.of(field),
        })
    }

    /// The number at `index`, `sub`; `None` where there is none.
    pub(super) fn at(model: &Model, index: u16, sub: u8) -> Option<Self> {
        Self::of(model.entry(index, sub)?)
    }

    /// The node-IDs that make a difference: the one of a DCF, else all. One that means nothing where none is added.
    pub(super) fn node_ids(&self, model: &Model) -> RangeInclusive<u8> {
        match &model.commissioning {
            _ if !self.adds_node_id => 0..=0,
            // Where it is for no node yet any will do.
            Some(node) => node.node_id.max(1)..=node.node_id.max(1),
            None => 1..=127,
        }
    }

    /// The number in the device with this node-ID.
    pub(super) fn with(&self, node_id: u8) -> i128 {
        let added = if self.adds_node_id { node_id } else { 0 };
        self.value.saturating_add(i128::from(added))
    }
}

/// The number at `index`, `sub` without the node-ID; `None` where there is none.
pub(super) fn number(model: &Model, index: u16, sub: u8) -> Option<i128> {
    Some(Setting::at(model, index, sub)?.value)
}

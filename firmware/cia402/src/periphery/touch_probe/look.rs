//! What the inputs of a probe have seen in one tick.

use crate::inputs::{Captured, DigitalInputs, Edge, Edges};

/// What is seen in one tick.
pub(super) struct Look<'a> {
    pub(super) inputs: &'a DigitalInputs,
    /// Levels in the tick before, active is 1.
    pub(super) before: u8,
    /// Levels now, active is 1.
    pub(super) active: u8,
    pub(super) inverted: u8,
    /// Here and now.
    pub(super) now: Edge,
}

impl Look<'_> {
    /// The edges of these inputs to active, or to inactive, together.
    pub(super) fn edges(&self, mask: u8, to_active: bool) -> Option<Edges> {
        let mut all: Option<Edges> = None;
        let mut input = 1;
        for captured in &self.inputs.captured {
            if mask & input != 0
                && let Some(edges) = self.edges_of(captured, input, to_active)
            {
                all = Some(all.map_or(edges, |all| self.together(all, edges)));
            }
            input <<= 1;
        }
        all
    }

    fn edges_of(&self, captured: &Captured, input: u8, to_active: bool) -> Option<Edges> {
        let is_active = self.active & input != 0;
        let has_changed = (self.before & input != 0) != is_active;
        let rises = to_active != (self.inverted & input != 0);
        let edges = if rises { captured.rose } else { captured.fell };
        edges
            .filter(|_| self.inputs.changed & input != 0)
            .or((has_changed && is_active == to_active).then_some(Edges::one(self.now)))
    }

    /// The edges of two inputs, in the order of time.
    fn together(&self, one: Edges, other: Edges) -> Edges {
        // An edge may have come since the tick read its time.
        let age = |edge: Edge| self.now.time.wrapping_sub(edge.time).cast_signed();
        Edges {
            first: if age(one.first) >= age(other.first) {
                one.first
            } else {
                other.first
            },
            last: if age(one.last) <= age(other.last) {
                one.last
            } else {
                other.last
            },
            count: one.count.saturating_add(other.count),
        }
    }
}

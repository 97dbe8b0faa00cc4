//! The index pulse: home is the first one behind the edge of the switch, in the direction of the last move.

use super::{Failure, Homing, Inputs, Order, Speed, Stage, exceeds};
use crate::Direction;

impl Homing {
    /// Keeps the first index pulse behind an edge that is not noticed yet.
    pub(super) fn keep_pulse(&mut self, inputs: &Inputs) {
        let Some(pending) = self.pending else {
            self.early_pulse = None;
            return;
        };
        let edge = self.outermost(pending, !self.was_active);
        if edge != self.edge {
            self.edge = edge;
            self.early_pulse = None;
        }
        self.early_pulse = self
            .early_pulse
            .or(inputs.index.filter(|pulse| self.is_behind_edge(*pulse)));
    }

    pub(super) fn begin_index(&mut self, direction: Direction, edge: i32) -> Order {
        self.edge = edge;
        self.stage = Stage::ToIndex;
        self.run(direction, Speed::Zero)
    }

    pub(super) fn run_to_index(&mut self, inputs: &Inputs) -> Result<Order, Failure> {
        if let Some(pulse) = inputs.index.filter(|pulse| self.is_behind_edge(*pulse)) {
            return Ok(self.take_index(pulse));
        }
        self.check_limits(inputs, self.direction)?;
        let gone = inputs.position.wrapping_sub(self.edge).unsigned_abs();
        if exceeds(gone.into(), self.settings.longest_distance_to_index) {
            return Err(Failure::NoIndex);
        }
        Ok(Order::GoOn)
    }

    pub(super) fn take_index(&mut self, pulse: i32) -> Order {
        self.home = pulse;
        self.finish()
    }

    /// Whether an index pulse comes after the edge, in the direction of the run.
    pub(super) fn is_behind_edge(&self, pulse: i32) -> bool {
        let distance = pulse.wrapping_sub(self.edge);
        match self.direction {
            Direction::Forward => distance > 0,
            Direction::Reverse => distance < 0,
        }
    }
}

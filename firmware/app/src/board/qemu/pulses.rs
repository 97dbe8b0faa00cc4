//! Step pulses by interrupts, as the timers of the machine drive no pin.

use motion::step_interrupt::{Player, RecordQueue};
use motion::{PulseSink, Record, Ticks};

use super::inputs::Axis;
use super::step_timer::AlarmTimer;
use crate::board::{Pulses, Steps};

/// Pulses for the control tick.
pub struct InterruptPulses(pub RecordQueue<'static, AlarmTimer>);

impl PulseSink for InterruptPulses {
    fn push(&mut self, record: Record) -> Result<(), Record> {
        self.0.push(record)
    }

    fn pending(&self) -> Ticks {
        self.0.pending()
    }

    fn free(&self) -> usize {
        self.0.free()
    }
}

impl Pulses for InterruptPulses {
    fn service(&mut self) {}

    fn position(&mut self) -> i64 {
        self.0.position()
    }

    fn position_at(&self, count: u32) -> i32 {
        count.cast_signed()
    }

    fn drop_all(&mut self) {
        self.0.drop_all();
    }

    fn fault(&self) -> Option<u16> {
        None
    }

    fn mend(&mut self) {}
}

/// The step interrupt, and what the steps bring the motor to.
pub struct StepPlayer {
    pub player: Player<'static, AlarmTimer>,
    pub axis: Axis,
}

impl Steps for StepPlayer {
    fn on_interrupt(&mut self) {
        self.player.on_interrupt();
        self.axis.pass(self.player.position());
    }

    fn count(&mut self, _input: usize) -> u32 {
        self.player.position().cast_unsigned()
    }
}

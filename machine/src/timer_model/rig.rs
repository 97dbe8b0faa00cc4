//! An axis on the modelled timers: planner, train, slots, and the pins.

use motion::advanced_timer::{Output, Ring};
use motion::{AdvanceError, Axis, AxisConfig, Clock, DriverTiming, PulseSink};

use super::{Judge, TimerModel};

/// Clock of TIM1 on the board.
pub const HZ: u32 = 168_000_000;

/// A quarter of a millisecond: a time slice, and the time between two refills.
pub const TIME_SLICE: u32 = HZ / 4_000;

/// An axis whose pulses are made by modelled timers.
#[derive(Debug)]
pub struct Rig<'a> {
    /// The planner and the train.
    pub axis: Axis,
    /// What writes the registers.
    pub output: Output<'a, TimerModel<'a>>,
    /// The registers, and the pins.
    pub model: TimerModel<'a>,
    /// Refills that found the timer without pulses while the axis moved.
    pub underruns: u64,
}

impl<'a> Rig<'a> {
    /// An axis at rest at 0. `judge` watches the pins.
    ///
    /// # Panics
    /// Never: the clock is one that motion can use.
    pub fn new(ring: &'a Ring, timing: DriverTiming, judge: Judge) -> Self {
        let model = TimerModel::new(ring, judge);
        let clock = Clock::new(HZ).expect("a clock that motion can use");
        let config = AxisConfig {
            clock,
            time_slice: TIME_SLICE,
            timing,
        };
        Self {
            axis: Axis::new(config),
            output: Output::new(model.clone(), ring),
            model,
            underruns: 0,
        }
    }

    /// At rest where it is, with so much in the counter, as if it had come a long way.
    #[must_use]
    pub fn with_count(mut self, count: u32) -> Self {
        self.model
            .lose_count(self.model.count().wrapping_sub(count));
        // The output takes it as pulses that have left.
        self.output.drop_all();
        let position = self.output.position();
        self.model.judge_mut().position = position;
        self.axis.set_position(position);
        self
    }

    /// Hands out pulses, and lets time pass. Underruns that are told are counted.
    pub fn refill(&mut self, ticks: u64) {
        self.output.service();
        match self.axis.advance(&mut self.output) {
            Ok(()) | Err(AdvanceError::SinkFull) => {}
            Err(AdvanceError::Underrun | AdvanceError::Internal) => self.underruns += 1,
        }
        self.model.run(ticks);
    }

    /// Refills on time until everything has left.
    ///
    /// # Panics
    /// If that takes longer than so many refills.
    pub fn finish(&mut self, most: u64) {
        for _ in 0..most {
            self.refill(TIME_SLICE.into());
            if self.is_finished() {
                return;
            }
        }
        panic!("the motion does not end: {self:?}");
    }

    /// Whether the axis rests and every pulse has left.
    pub fn is_finished(&self) -> bool {
        self.axis.is_at_rest() && self.output.pending() == 0
    }

    /// Holds plan, counter and pins against each other, at rest.
    ///
    /// # Panics
    /// If they differ.
    pub fn account(&mut self) {
        let position = self.model.judge().position;
        assert_eq!(self.output.position(), position, "the counter and the pins");
        assert_eq!(
            self.axis.committed_position(),
            i64::from(position as i32),
            "the plan and the pins"
        );
    }
}

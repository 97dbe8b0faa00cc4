//! Homing (CiA 402-2, "homing mode"): finds where zero is, by switches, an index pulse or a hard stop.
//!
//! One engine for all methods, driven by one table. In every tick it is given its inputs and says what the motor is to do; it
//! knows no bus, no input pin and no speeds. A method that refers to a switch goes like this, from wherever the motor stands:
//!
//! 1. Look for the switch at search speed, until its edges passed tell on which side of the wanted one the motor is.
//! 2. Come to rest just before that edge, on the side from which the last move begins.
//! 3. Last move: over the edge at the slow homing speed (6099h:2), always in the same direction.
//!    Home is where the edge was captured, or the first index pulse behind it.
//!
//! The contract:
//! - The last edge is passed at the slow homing speed and in one direction whatever the start, so
//!   that the hysteresis of a switch does not shift home. Positions are those captured at the edge,
//!   not those at which it was noticed.
//! - Home is the outermost position at which the switch is active: a rising and a falling edge at one place are one home.
//! - An edge is noticed late, by the filter of the switch. So the motor turns back only when the filter has decided on all it has seen:
//!   an edge that is noticed belongs to the run under way, and so does the first index pulse behind it.
//! - Every change of direction is a full stop. The motor never goes on into a limit switch, other than the one it looks for.
//! - Nothing goes on for ever: see [`Settings`] for the bounds, and [`Failure`] for how it ends.

mod index;
mod interface;
mod method;

use crate::Direction;
pub use interface::{Failure, Fitted, Inputs, Order, Outcome, Settings, Speed, SwitchState};
pub use method::Method;
use method::{Approach, AtLimit, End, Reference, Switch};

/// Runs from one stop to the next while a switch is looked for, until homing gives up; from the
/// middle on they are at the slow speed, so that a narrow switch that was run over is found.
const MAX_RUNS: u8 = 12;

/// What the motor is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stage {
    /// It comes to rest, or stands: the next run is to be chosen.
    Choosing,
    /// It runs to the starting point of the last move.
    Approaching,
    /// It passes the last edge.
    LastMove,
    /// It runs to the index pulse.
    ToIndex,
    /// It runs into the hard stop.
    RunningIntoStop,
    /// It has met the hard stop; its pulses are being dropped.
    Blocked,
    /// It goes to this position, away from the hard stop.
    BackingOff(i32),
    /// It comes to rest behind the home position.
    Finishing,
    /// It goes back to the home position.
    Returning,
}

/// Homing under way.
#[derive(Debug, Clone)]
pub struct Homing {
    method: Method,
    settings: Settings,
    stage: Stage,
    /// The direction of the last run.
    direction: Direction,
    /// Where to look for the switch.
    search: Direction,
    /// A limit switch has turned the search round.
    turned: bool,
    /// The end of the switch's range that was passed last.
    passed: Option<End>,
    was_active: bool,
    /// The switch was touched since its last change, and its filter has dropped that.
    was_touched: bool,
    runs: u8,
    halted: bool,
    position: i32,
    travelled: u64,
    /// Microseconds.
    time: u64,
    blocked_time: u64,
    /// Where the distance to the index pulse begins: the reference edge, if there is one.
    edge: i32,
    /// The edge that the filter of the switch is not sure of yet.
    pending: Option<i32>,
    /// The first index pulse behind that edge.
    early_pulse: Option<i32>,
    home: i32,
}

impl Homing {
    /// Begins. Nothing is ordered before the motor is at rest; what it passes until then does not count.
    ///
    /// # Errors
    /// [`Failure::NotFitted`] if the method needs what is not there.
    pub fn begin(
        method: Method,
        settings: Settings,
        fitted: Fitted,
        inputs: &Inputs,
    ) -> Result<Self, Failure> {
        let method = if settings.other_block_signs {
            method.with_other_sign()
        } else {
            method
        };
        let (is_fitted, search, was_active) = match method.reference {
            Reference::Switch(approach) => {
                let is_fitted = match approach.switch {
                    Switch::NegativeLimit => fitted.negative_limit,
                    Switch::PositiveLimit => fitted.positive_limit,
                    Switch::Home => fitted.home,
                };
                (
                    is_fitted,
                    approach.search,
                    inputs.switch(approach.switch).active,
                )
            }
            Reference::Index(direction) => (true, direction, false),
            Reference::HardStop(direction) => (fitted.block, direction, false),
            Reference::Here => (true, Direction::Forward, false),
        };
        if !is_fitted || method.index && !fitted.index {
            return Err(Failure::NotFitted);
        }
        Ok(Self {
            method,
            settings,
            stage: Stage::Choosing,
            direction: search,
            search,
            turned: false,
            passed: None,
            was_active,
            was_touched: false,
            runs: 0,
            halted: false,
            position: inputs.position,
            travelled: 0,
            time: 0,
            blocked_time: 0,
            edge: inputs.position,
            pending: None,
            early_pulse: None,
            home: inputs.position,
        })
    }

    /// One control tick.
    pub fn tick(&mut self, inputs: &Inputs) -> Outcome {
        match self.step(inputs) {
            Ok(outcome) => outcome,
            Err(failure) => Outcome::Failed(failure),
        }
    }

    fn step(&mut self, inputs: &Inputs) -> Result<Outcome, Failure> {
        let passed = self.watch(inputs)?;
        let was_halted = core::mem::replace(&mut self.halted, inputs.halt);
        // What a halt brings to rest has not arrived.
        let arrived = inputs.standstill && !self.halted && !was_halted;
        let order = match self.go_on(inputs, passed, arrived)? {
            Outcome::UnderWay(order) => order,
            end => return Ok(end),
        };
        // What is seen in a halt counts, but nothing begins to move: what was ordered is ordered again after it.
        Ok(Outcome::UnderWay(match (was_halted, self.halted, order) {
            (_, _, Order::CutOff) => Order::CutOff,
            (false, true, _) => Order::Stop,
            (true, true, Order::Run(..) | Order::Go(_)) => Order::GoOn,
            (true, false, Order::GoOn) => self.resume(),
            _ => order,
        }))
    }

    /// The order of the present stage. `passed` is the edge passed in this tick; `arrived` says that the motor has come to rest where
    /// it was ordered to.
    fn go_on(
        &mut self,
        inputs: &Inputs,
        passed: Option<(i32, bool)>,
        arrived: bool,
    ) -> Result<Outcome, Failure> {
        let order = match self.stage {
            // What was passed before the stop must not be noticed on the way back.
            Stage::Choosing if arrived && self.pending.is_none() => return self.choose(inputs),
            Stage::Approaching => self.approach(inputs)?,
            Stage::LastMove => self.pass_edge(inputs, passed)?,
            Stage::ToIndex => self.run_to_index(inputs)?,
            Stage::RunningIntoStop => self.run_into_hard_stop(inputs)?,
            Stage::Blocked if !self.halted => self.back_off(inputs),
            Stage::BackingOff(_) if arrived => {
                if self.settings.home_is_backed_off {
                    self.home = inputs.position;
                }
                if self.method.index {
                    self.begin_index(self.direction.reversed(), inputs.position)
                } else {
                    self.finish()
                }
            }
            Stage::Finishing
                if arrived && self.settings.returns && inputs.position != self.home =>
            {
                self.stage = Stage::Returning;
                Order::Return(self.home)
            }
            Stage::Finishing | Stage::Returning if arrived => {
                return Ok(Outcome::Attained(self.home));
            }
            _ => Order::GoOn,
        };
        Ok(Outcome::UnderWay(order))
    }

    /// Follows the distance, the time and the edges of the switch. Returns where an edge was passed in this tick, and whether the
    /// switch became active there.
    fn watch(&mut self, inputs: &Inputs) -> Result<Option<(i32, bool)>, Failure> {
        if inputs.negative_limit.active && inputs.positive_limit.active {
            return Err(Failure::BothLimits);
        }
        let gone = inputs.position.wrapping_sub(self.position).unsigned_abs();
        self.position = inputs.position;
        self.travelled = self.travelled.saturating_add(gone.into());
        if !inputs.halt {
            self.time = self.time.saturating_add(inputs.elapsed.into());
        }
        let longest = u64::from(self.settings.longest_time) * 1_000;
        if exceeds(self.travelled, self.settings.longest_distance)
            || longest != 0 && self.time >= longest + 1_000
        {
            return Err(Failure::TooLong);
        }
        let Reference::Switch(approach) = self.method.reference else {
            return Ok(None);
        };
        let switch = inputs.switch(approach.switch);
        let pending = core::mem::replace(&mut self.pending, switch.pending);
        if switch.active == self.was_active {
            self.was_touched |= pending.is_some() && switch.pending.is_none();
            return Ok(None);
        }
        self.was_active = switch.active;
        self.was_touched = false;
        self.passed = Some(End::crossed(self.direction, switch.active));
        Ok(Some((
            switch.edge.unwrap_or(inputs.position),
            switch.active,
        )))
    }

    /// The motor stands: what comes next.
    fn choose(&mut self, inputs: &Inputs) -> Result<Outcome, Failure> {
        let order = match self.method.reference {
            Reference::Here => return Ok(Outcome::Attained(inputs.position)),
            Reference::Index(direction) => {
                self.check_limits(inputs, direction)?;
                self.begin_index(direction, inputs.position)
            }
            Reference::HardStop(direction) => {
                self.check_limits(inputs, direction)?;
                self.stage = Stage::RunningIntoStop;
                self.run(direction, Speed::Search)
            }
            Reference::Switch(approach) => self.choose_run(inputs, &approach)?,
        };
        Ok(Outcome::UnderWay(order))
    }

    fn choose_run(&mut self, inputs: &Inputs, approach: &Approach) -> Result<Order, Failure> {
        if self.runs == 0 {
            // Passed before the first run, in who knows which direction.
            self.passed = None;
        }
        let Some(mut direction) = self.heading(approach) else {
            let direction = approach.last();
            self.check_limits(inputs, direction)?;
            self.stage = Stage::LastMove;
            return Ok(self.run(direction, self.last_speed()));
        };
        if self.check_limits(inputs, direction).is_err() {
            self.turn(approach)?;
            direction = self.search;
            self.check_limits(inputs, direction)?;
        }
        self.runs = self.runs.saturating_add(1);
        if self.runs > MAX_RUNS {
            return Err(Failure::TooNarrow);
        }
        self.stage = Stage::Approaching;
        let speed = if self.runs > MAX_RUNS / 2 {
            Speed::Zero
        } else {
            Speed::Search
        };
        Ok(self.run(direction, speed))
    }

    /// Where to go to get to the starting point of the last move; `None` if the motor is there.
    fn heading(&self, approach: &Approach) -> Option<Direction> {
        let outwards = approach.end.outwards();
        let at_edge = self.passed == Some(approach.end);
        let is_direct = self.settings.is_direct && self.passed.is_none();
        match (self.was_active, approach.rising) {
            (true, false) if at_edge || is_direct => None,
            (true, _) => Some(outwards),
            (false, true) if at_edge => None,
            (false, false) if at_edge => Some(outwards.reversed()),
            // Behind the other end of the range: through it.
            (false, _) if self.passed.is_some() => Some(outwards),
            (false, _) => Some(self.search),
        }
    }

    /// A limit switch is in the way: the search turns round, if it is a search and may.
    fn turn(&mut self, approach: &Approach) -> Result<(), Failure> {
        let may_turn = match approach.at_limit {
            AtLimit::Fail => false,
            AtLimit::Turn => true,
            AtLimit::AsSet => self.settings.turns_at_limit,
        };
        if self.turned || !may_turn || self.passed.is_some() || self.was_active {
            return Err(self.at_limit());
        }
        self.turned = true;
        self.search = self.search.reversed();
        Ok(())
    }

    /// What it means to have met a limit switch on the way to an edge.
    const fn at_limit(&self) -> Failure {
        if self.was_touched {
            Failure::TooNarrow
        } else {
            Failure::Limit
        }
    }

    fn approach(&mut self, inputs: &Inputs) -> Result<Order, Failure> {
        let Reference::Switch(approach) = self.method.reference else {
            return Ok(Order::GoOn);
        };
        if self.heading(&approach) == Some(self.direction) {
            if self.check_limits(inputs, self.direction).is_ok() {
                return Ok(Order::GoOn);
            }
            self.turn(&approach)?;
        }
        self.stage = Stage::Choosing;
        Ok(Order::Stop)
    }

    fn pass_edge(
        &mut self,
        inputs: &Inputs,
        passed: Option<(i32, bool)>,
    ) -> Result<Order, Failure> {
        let Some((edge, rose)) = passed else {
            self.keep_pulse(inputs);
            self.check_limits(inputs, self.direction)
                .map_err(|_| self.at_limit())?;
            return Ok(Order::GoOn);
        };
        self.home = self.outermost(edge, rose);
        if !self.method.index {
            return Ok(self.finish());
        }
        let early = self.early_pulse.filter(|_| self.edge == self.home);
        // The last move was at the slow speed: it just goes on.
        let order = self.begin_index(self.direction, self.home);
        let mut pulses = [early, inputs.index].into_iter().flatten();
        Ok(match pulses.find(|pulse| self.is_behind_edge(*pulse)) {
            Some(pulse) => self.take_index(pulse),
            None => order,
        })
    }

    /// The outermost position at which the switch is active, at an edge that was passed in this run.
    const fn outermost(&self, edge: i32, rose: bool) -> i32 {
        if rose {
            edge
        } else {
            edge.wrapping_sub(self.direction.sign())
        }
    }

    fn run_into_hard_stop(&mut self, inputs: &Inputs) -> Result<Order, Failure> {
        if !inputs.blocked {
            self.blocked_time = 0;
            self.check_limits(inputs, self.direction)?;
            return Ok(Order::GoOn);
        }
        self.blocked_time = self.blocked_time.saturating_add(inputs.elapsed.into());
        if self.blocked_time < u64::from(self.settings.block_time).saturating_mul(1000) {
            return Ok(Order::GoOn);
        }
        self.stage = Stage::Blocked;
        Ok(Order::CutOff)
    }

    /// The pulses have been dropped: the motor is where it was blocked.
    fn back_off(&mut self, inputs: &Inputs) -> Order {
        self.home = inputs.position;
        let distance = self.settings.back_off.min(i32::MAX.cast_unsigned());
        let distance = distance
            .cast_signed()
            .wrapping_mul(self.direction.reversed().sign());
        let target = inputs.position.wrapping_add(distance);
        self.stage = Stage::BackingOff(target);
        Order::Go(target)
    }

    fn finish(&mut self) -> Order {
        self.stage = Stage::Finishing;
        Order::Stop
    }

    fn run(&mut self, direction: Direction, speed: Speed) -> Order {
        self.direction = direction;
        Order::Run(direction, speed)
    }

    /// A halt is over: goes on with what it interrupted.
    fn resume(&mut self) -> Order {
        match self.stage {
            Stage::Approaching => {
                self.stage = Stage::Choosing;
                Order::GoOn
            }
            Stage::LastMove => Order::Run(self.direction, self.last_speed()),
            Stage::ToIndex => Order::Run(self.direction, Speed::Zero),
            Stage::RunningIntoStop => Order::Run(self.direction, Speed::Search),
            Stage::BackingOff(target) => Order::Go(target),
            Stage::Returning => Order::Go(self.home),
            Stage::Choosing | Stage::Blocked | Stage::Finishing => Order::GoOn,
        }
    }

    fn last_speed(&self) -> Speed {
        if self.settings.last_move_is_fast && !self.method.index {
            Speed::Search
        } else {
            Speed::Zero
        }
    }

    /// Whether no limit switch forbids this direction; the one that is looked for does not.
    #[inline(never)]
    fn check_limits(&self, inputs: &Inputs, direction: Direction) -> Result<(), Failure> {
        let (switch, state) = match direction {
            Direction::Forward => (Switch::PositiveLimit, inputs.positive_limit),
            Direction::Reverse => (Switch::NegativeLimit, inputs.negative_limit),
        };
        let is_sought = matches!(
            self.method.reference,
            Reference::Switch(approach) if approach.switch == switch
        );
        if state.active && !is_sought {
            Err(Failure::Limit)
        } else {
            Ok(())
        }
    }
}

/// Whether an amount is above its bound; 0 is no bound.
const fn exceeds(amount: u64, bound: u32) -> bool {
    bound != 0 && amount > bound as u64
}

#[cfg(test)]
mod tests;

//! The digital inputs of the drive: limit switches, home switch, index pulse.
//!
//! Which input is what, which level means active and how long a change must last is up to the master: objects 2031h to 2033h.
//! A switch counts as changed when its input has been at the other level for the debounce time, less than that is a glitch and
//! ignored; while a contact chatters, the time at the old level counts back. Where it changed is the position that the board
//! captured at the first edge: bounces that follow do not shift it.
//!
//! A limit switch protects: where it is unsure, it is active. Its inactive time counts back half as fast only, so that one that is active
//! for half of the time counts after four debounce times at most, and it is left again after a debounce time without a break;
//! a captured edge between two ticks is one too.
//!
//! Several inputs may have one function; the switch is active when one of them is.
//!
//! 60FDh shows the switches in bits 0 (negative limit), 1 (positive limit) and 2 (home), and the bare levels of inputs 1 to 6
//! in bits 16 to 21.

mod active_limits;
mod capture;
mod source;

use motion::homing::SwitchState;
use motion::low;

use crate::objects::Objects;

pub(crate) use active_limits::ActiveLimits;
pub use capture::{Capture, time_of_edge};
pub use source::Source;
pub(crate) use source::{SOURCE, probe_functions};

/// How many inputs there may be.
pub const COUNT: usize = 6;

/// The inputs as the board has seen them since the last tick. Of inputs that are not there nothing is seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DigitalInputs {
    /// The level of input `n` in bit `n − 1`.
    pub levels: u8,
    /// The inputs of which something was captured, in the same order.
    pub changed: u8,
    /// What the board has captured of each input.
    pub captured: [Captured; COUNT],
}

/// Edges of an input since the last tick. A board that cannot capture leaves them out; then the position in the tick counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Captured {
    /// The rising edges.
    pub rose: Option<Edges>,
    /// The falling edges.
    pub fell: Option<Edges>,
}

/// An edge, as it was captured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Edge {
    /// The board's count in increments, modulo 2³².
    pub position: i32,
    /// The drive's time in nanoseconds, modulo 2³².
    pub time: u32,
}

/// The edges of one kind that an input has seen since the last tick. Of bouncing contacts the first is the true one, of a probe
/// that is sampled continuously the last.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Edges {
    /// The first.
    pub first: Edge,
    /// The last; the first again if there was one.
    pub last: Edge,
    /// How many there were, at least 1.
    pub count: u16,
}

impl Edges {
    /// A single edge.
    pub const fn one(edge: Edge) -> Self {
        Self {
            first: edge,
            last: edge,
            count: 1,
        }
    }

    /// A further edge.
    pub const fn add(&mut self, edge: Edge) {
        self.last = edge;
        self.count = self.count.saturating_add(1);
    }
}

/// What an input is for, 2031h.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum InputFunction {
    /// 0: nothing; its level shows in 60FDh.
    None = 0,
    /// 1: the negative limit switch.
    NegativeLimit = 1,
    /// 2: the positive limit switch.
    PositiveLimit = 2,
    /// 3: the home switch.
    Home = 3,
    /// 4: index pulses.
    Index = 4,
    /// 5: touch probe 1.
    TouchProbe1 = 5,
    /// 6: touch probe 2.
    TouchProbe2 = 6,
}

impl DigitalInputs {
    /// Nothing is seen.
    pub const NONE: Self = Self {
        levels: 0,
        changed: 0,
        captured: [Captured {
            rose: None,
            fell: None,
        }; COUNT],
    };
}

impl InputFunction {
    /// The function with this number; `None` if there is none.
    pub const fn from_code(code: u8) -> Option<Self> {
        match code {
            0 => Some(Self::None),
            1 => Some(Self::NegativeLimit),
            2 => Some(Self::PositiveLimit),
            3 => Some(Self::Home),
            4 => Some(Self::Index),
            5 => Some(Self::TouchProbe1),
            6 => Some(Self::TouchProbe2),
            _ => None,
        }
    }
}

/// How the inputs are set up: for each function a mask of its inputs, input `n` in bit `n − 1`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct InputConfiguration {
    /// The negative limit switch.
    pub negative_limit: u8,
    /// The positive limit switch.
    pub positive_limit: u8,
    /// The home switch.
    pub home: u8,
    /// Index pulses.
    pub index: u8,
    /// Touch probes 1 and 2.
    pub touch_probes: [u8; 2],
    /// 2032h: these inputs are active while they are low.
    pub inverted: u8,
    /// 2033h: how long a switch must keep a level, in milliseconds. Index pulses and touch probes are not debounced.
    pub debounce: u8,
}

impl InputConfiguration {
    /// What holds before anything is set up: no input is for anything.
    pub const NONE: Self = Self {
        negative_limit: 0,
        positive_limit: 0,
        home: 0,
        index: 0,
        touch_probes: [0; 2],
        inverted: 0,
        debounce: 0,
    };

    /// What the objects of a dictionary say.
    pub(crate) fn of<D: Objects>(dictionary: &D) -> Self {
        Self::new(
            [
                dictionary.input_1_function(),
                dictionary.input_2_function(),
                dictionary.input_3_function(),
                dictionary.input_4_function(),
                dictionary.input_5_function(),
                dictionary.input_6_function(),
            ],
            dictionary.inputs_inverted(),
            dictionary.input_debounce(),
        )
    }

    /// The set-up with these functions of inputs 1 to 6. A number that is no function counts as none.
    pub fn new(functions: [u8; COUNT], inverted: u8, debounce: u8) -> Self {
        let mut configuration = Self {
            inverted,
            debounce,
            ..Self::NONE
        };
        let mut input = 1;
        for code in functions {
            let [probe_1, probe_2] = &mut configuration.touch_probes;
            match InputFunction::from_code(code) {
                Some(InputFunction::NegativeLimit) => configuration.negative_limit |= input,
                Some(InputFunction::PositiveLimit) => configuration.positive_limit |= input,
                Some(InputFunction::Home) => configuration.home |= input,
                Some(InputFunction::Index) => configuration.index |= input,
                Some(InputFunction::TouchProbe1) => *probe_1 |= input,
                Some(InputFunction::TouchProbe2) => *probe_2 |= input,
                Some(InputFunction::None) | None => {}
            }
            input <<= 1;
        }
        configuration
    }
}

/// How the master counts what the board counts.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Count {
    /// Where the motor is in the tick, as the master counts.
    pub(crate) position: i64,
    /// What the master's count has beyond the board's, modulo 2³².
    pub(crate) shift: i32,
    /// The board counts in the other direction.
    pub(crate) is_reversed: bool,
}

impl Count {
    /// The master's count for one of the board's: of those that are the same modulo 2³² the nearest to where the motor is.
    pub(crate) const fn of(&self, board: i32) -> i64 {
        let position = self.directed(board).wrapping_add(self.shift);
        let distance = position.wrapping_sub(low::i32(self.position));
        self.position.wrapping_add(distance as i64)
    }

    /// The board's count where the motor is.
    pub(crate) const fn board_position(&self) -> i32 {
        self.directed(low::i32(self.position).wrapping_sub(self.shift))
    }

    const fn directed(&self, number: i32) -> i32 {
        if self.is_reversed {
            number.wrapping_neg()
        } else {
            number
        }
    }
}

/// The switches, filtered.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Switches {
    pub(crate) negative_limit: Switch,
    pub(crate) positive_limit: Switch,
    pub(crate) home: Switch,
    /// The position captured at an index pulse since the last tick.
    pub(crate) index: Option<i32>,
    /// Bare levels in the last tick: another 2032h is no edge.
    levels: u8,
    /// 60FDh.
    word: u32,
    /// Nothing is being filtered: the same levels with the same configuration change nothing.
    is_settled: bool,
}

impl Switches {
    /// The configuration may have changed.
    pub(crate) const fn look_anew(&mut self) {
        self.is_settled = false;
    }

    /// Looks at the inputs. `count` is how the master counts; `elapsed` are the microseconds since the last tick.
    pub(crate) fn observe(
        &mut self,
        inputs: &DigitalInputs,
        configuration: &InputConfiguration,
        count: Count,
        elapsed: u32,
    ) {
        if self.is_settled && inputs.levels == self.levels && inputs.changed == 0 {
            return;
        }
        self.look_closely(inputs, configuration, count, elapsed);
    }

    #[inline(never)]
    fn look_closely(
        &mut self,
        inputs: &DigitalInputs,
        configuration: &InputConfiguration,
        count: Count,
        elapsed: u32,
    ) {
        let position = low::i32(count.position);
        let before = self.levels ^ configuration.inverted;
        let active = inputs.levels ^ configuration.inverted;
        self.levels = inputs.levels;
        let look = Look {
            inputs,
            active,
            inverted: configuration.inverted,
            position,
            count,
            elapsed,
            debounce: u32::from(configuration.debounce) * 1000,
        };
        self.negative_limit
            .observe(configuration.negative_limit, true, &look);
        self.positive_limit
            .observe(configuration.positive_limit, true, &look);
        self.home.observe(configuration.home, false, &look);
        self.index = None;
        if configuration.index != 0 {
            let risen = configuration.index & active & !before;
            self.index = look
                .first_edge(configuration.index, true)
                .or((risen != 0).then_some(position));
        }
        self.word = u32::from(self.negative_limit.state.active)
            | u32::from(self.positive_limit.state.active) << 1
            | u32::from(self.home.state.active) << 2
            | u32::from(inputs.levels & ALL) << 16;
        let switches = [&self.negative_limit, &self.positive_limit, &self.home];
        let masks = [
            configuration.negative_limit,
            configuration.positive_limit,
            configuration.home,
        ];
        let is_still = |(switch, mask): (&Switch, u8)| switch.is_still(active & mask != 0);
        self.is_settled = self.index.is_none() && switches.into_iter().zip(masks).all(is_still);
    }

    /// Forgets the edges of the last tick, for a tick that does not look at the inputs.
    pub(crate) const fn forget_edges(&mut self) {
        self.negative_limit.state.edge = None;
        self.positive_limit.state.edge = None;
        self.home.state.edge = None;
        self.index = None;
    }

    /// The directions in which there is a limit switch.
    pub(crate) const fn active_limits(&self) -> ActiveLimits {
        ActiveLimits {
            reverse: self.negative_limit.state.active,
            forward: self.positive_limit.state.active,
        }
    }

    /// Whether both limit switches are active.
    pub(crate) const fn both_limits(&self) -> bool {
        self.negative_limit.state.active && self.positive_limit.state.active
    }

    /// 60FDh.
    pub(crate) const fn word(&self) -> u32 {
        self.word
    }
}

/// The bits of all inputs.
const ALL: u8 = (1 << COUNT) - 1;

/// What is seen in one tick.
struct Look<'a> {
    inputs: &'a DigitalInputs,
    active: u8,
    inverted: u8,
    position: i32,
    count: Count,
    elapsed: u32,
    debounce: u32,
}

impl Look<'_> {
    /// Where the first captured edge to active (or to inactive) of these inputs was.
    fn first_edge(&self, mask: u8, to_active: bool) -> Option<i32> {
        if self.inputs.changed & mask == 0 {
            return None;
        }
        let mut input = 1;
        for captured in &self.inputs.captured {
            if mask & input != 0 {
                let rises = to_active != (self.inverted & input != 0);
                let edges = if rises { captured.rose } else { captured.fell };
                if let Some(edges) = edges {
                    return Some(low::i32(self.count.of(edges.first.position)));
                }
            }
            input <<= 1;
        }
        None
    }
}

/// A switch behind its filter.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Switch {
    pub(crate) state: SwitchState,
    /// For how long it has been at the other level, less what counts of the time it was back since, in microseconds.
    changing: u32,
    /// Where a change may have begun.
    edge: Option<i32>,
    /// For how long nothing was seen of that change, and how long ago it began, in microseconds.
    quiet: u32,
    age: u32,
}

/// An edge that has led to no change after so many debounce times is dropped.
const LONGEST_BOUNCE: u32 = 4;

impl Switch {
    /// `protects`: it is a limit switch, which counts as active while it chatters.
    fn observe(&mut self, mask: u8, protects: bool, look: &Look<'_>) {
        self.state.edge = None;
        if mask == 0 {
            // A switch that is not fitted is not active.
            *self = Self::default();
            return;
        }
        let active = look.active & mask != 0;
        // It may begin to bounce between two ticks.
        if active != self.state.active
            || self.edge.is_some()
            || self.changing != 0
            || look.inputs.changed & mask != 0
        {
            self.follow(active, mask, protects, look);
        }
    }

    /// Whether the same level again changes nothing.
    const fn is_still(&self, active: bool) -> bool {
        self.state.active == active
            && self.state.edge.is_none()
            && self.edge.is_none()
            && self.changing == 0
    }

    /// A change, or what looks like one.
    #[cold]
    #[inline(never)]
    fn follow(&mut self, active: bool, mask: u8, protects: bool, look: &Look<'_>) {
        let differs = active != self.state.active;
        let captured = look.first_edge(mask, !self.state.active);
        let edge = captured.or(differs.then_some(look.position));
        let is_old = self.age > look.debounce.saturating_mul(LONGEST_BOUNCE);
        let mut is_dropped = false;
        if protects && self.state.active && look.first_edge(mask, true).is_some() {
            // It was touched again since the last tick: whatever the level is now, no break has lasted.
            self.changing = 0;
            self.edge = self.edge.filter(|_| !is_old);
            is_dropped = is_old;
        }
        if self.edge.is_none() {
            self.edge = edge;
            self.age = 0;
        }
        self.age = self.age.saturating_add(look.elapsed);
        if differs && self.changing >= look.debounce {
            *self = Self {
                state: SwitchState {
                    active,
                    edge: self.edge,
                    pending: None,
                },
                ..Self::default()
            };
            return;
        }
        if differs {
            self.changing = self.changing.saturating_add(look.elapsed);
            self.quiet = 0;
        } else {
            self.changing = match (protects, self.state.active) {
                (false, _) => self.changing.saturating_sub(look.elapsed),
                // Time counts back half as fast as it counted up.
                (true, false) => self.changing.saturating_sub(look.elapsed / 2),
                (true, true) => 0,
            };
            self.quiet = match captured {
                Some(_) => 0,
                None => self.quiet.saturating_add(look.elapsed),
            };
            let is_over = self.quiet >= look.debounce && self.changing == 0;
            if is_over || self.age > look.debounce.saturating_mul(LONGEST_BOUNCE) {
                *self = Self {
                    state: self.state,
                    changing: self.changing,
                    ..Self::default()
                };
            }
        }
        // An old edge has been decided on, even if the next change begins at once.
        self.state.pending = self.edge.filter(|_| !is_dropped);
    }
}

#[cfg(test)]
mod tests;

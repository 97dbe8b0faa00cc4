//! What the halves of the drive tell each other of the scope: what is to be recorded, what was ordered, and what the recorder does.

mod setup;
mod signal;
mod trigger;

pub use setup::{CHANNELS, Orders, Setup};
pub use signal::Signal;
pub(crate) use signal::every_signal;
pub use trigger::{Edge, Trigger};

/// Control and state of the scope.
pub(crate) const SCOPE: u16 = 0x20D0;
/// What each channel records.
pub(crate) const CHANNEL_MAP: u16 = 0x20D1;
/// What the trigger is.
pub(crate) const TRIGGER: u16 = 0x20D2;

/// The sub-indices of 20D0h.
pub(crate) mod sub {
    pub(crate) const CONTROL: u8 = 1;
    pub(crate) const STATE: u8 = 2;
    pub(crate) const MODE: u8 = 3;
    pub(crate) const DIVIDER: u8 = 4;
    pub(crate) const SAMPLES: u8 = 5;
    pub(crate) const BEFORE: u8 = 6;
    pub(crate) const RECORDED: u8 = 7;
    pub(crate) const MEMORY: u8 = 8;
    pub(crate) const TICK: u8 = 9;
}

/// What the recorder is doing, as 20D0h:2 shows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum State {
    /// Nothing, and there is nothing to read.
    #[default]
    Idle = 0,
    /// It records and waits for the trigger.
    Armed = 1,
    /// The trigger has come; the rest is being recorded.
    Triggered = 2,
    /// There is a recording to read.
    Full = 3,
}

impl State {
    /// Whether the memory belongs to the recorder.
    pub const fn is_at_work(self) -> bool {
        matches!(self, Self::Armed | Self::Triggered)
    }
}

/// What the recorder says of itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Status {
    /// 20D0h:2.
    pub state: State,
    /// 20D0h:7: samples that are there.
    pub recorded: u16,
    /// 20D0h:8: room for samples, in bytes; 0 for a firmware without a recorder.
    pub memory: u32,
    /// 20D0h:9: the period of the control tick in nanoseconds.
    pub tick: u32,
}

impl Status {
    /// What the recorder will say when it has carried out these orders.
    pub(crate) fn behind(self, orders: &Orders) -> Self {
        let (state, recorded) = if orders.arm.is_some() {
            (State::Armed, 0)
        } else if orders.stop && self.state.is_at_work() {
            (State::Idle, 0)
        } else {
            (self.state, self.recorded)
        };
        Self {
            state,
            recorded,
            ..self
        }
    }

    /// A recorder that has told nothing yet.
    pub const NONE: Self = Self {
        state: State::Idle,
        recorded: 0,
        memory: 0,
        tick: 0,
    };
}

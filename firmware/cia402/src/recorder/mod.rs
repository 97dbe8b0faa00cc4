//! The scope: values of the drive, recorded at the rate of the control tick around a trigger, and read as one DOMAIN.
//!
//! A master maps up to eight values to channels as it would map them to a PDO (20D1h), says what the trigger is (20D2h) and how much
//! is to be recorded (20D0h), and arms the recorder. From then on every n-th control tick leaves a sample in a ring; when the
//! trigger comes, as many samples follow as are left, and then 20D3h is there to be read. `docs/scope.md` has every byte.
//!
//! The parts:
//! - `Desk`, in the node task: the rules of the objects, and what a master has ordered.
//! - [`Recorder`], behind the control tick: takes orders, looks for the trigger, samples.
//! - [`Recording`], in the node task: the source of 20D3h.
//!
//! The contract:
//! - What is sampled is what the tick has published: all values of a sample are of one tick, and equal to what a PDO shows of it.
//! - Orders and the state pass through the [`Exchange`](crate::Exchange) as everything else does. The samples do not: they lie in a
//!   [`Memory`] of single words that both halves may touch, and only one of them does at a time. While the recorder is at work the
//!   memory is its own; when it is full it says so, and until the next recording begins the node may read.
//! - Nobody waits for a lock longer than the copy of a set of actual values, however large the memory is.
//! - A recorder that is idle costs a control tick one look at the exchange.

mod desk;
mod memory;
mod reading;
mod sampling;
mod setup;
mod signal;
mod trigger;

pub(crate) use desk::{Desk, foreseen};
pub use memory::{HEADER, Memory, VERSION};
pub use reading::Recording;
pub use sampling::Recorder;
pub use setup::{CHANNELS, Orders, Setup};
pub use signal::Signal;
pub(crate) use signal::Tick;
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
    /// A recorder that nobody has heard of.
    pub const NONE: Self = Self {
        state: State::Idle,
        recorded: 0,
        memory: 0,
        tick: 0,
    };
}

#[cfg(test)]
mod tests;

//! What a drive carries from tick to tick beside its state: what waits for its moment, and since when.

use canopen::Instant;

use crate::controlword::Command;

/// What a master has ordered that waits for its moment.
#[derive(Debug, Default)]
pub(super) struct Orders {
    /// "Shutdown" was written before the command that stands, and has not been carried out yet.
    pub(super) shutdown_first: bool,
    /// "Shutdown" or "disable operation" was the last command, and waits for the motor to stand.
    pub(super) pending: Option<Command>,
    /// The fault reaction is over, and goes on only to be seen.
    pub(super) is_only_shown: bool,
    /// A fault was reset meanwhile.
    pub(super) resets_early: bool,
    /// Operation is enabled, as was ordered, and nothing waits.
    pub(super) are_carried_out: bool,
}

impl Orders {
    /// The fault that was reset is none any more.
    pub(super) const fn forget_reset(&mut self) {
        self.resets_early = false;
    }
}

/// What the drive has made of the network so far.
#[derive(Debug, Default)]
pub(super) struct Network {
    /// The network may command the drive, or 6007h lets it go on without.
    pub(super) is_commanding: bool,
    /// The fault that 6007h = 1 makes of a loss of the network has been raised.
    pub(super) is_abandoned: bool,
    /// The restart that is asked for has been done.
    pub(super) has_restarted: bool,
}

/// How long states and stops last.
#[derive(Debug)]
pub(super) struct Stopping {
    /// When the state began.
    pub(super) entered: Instant,
    /// The state has been seen on the bus, or nobody looks.
    pub(super) is_seen: bool,
    /// When the drive began to stop on its own: no remote control, or a fault. Until the power is off.
    pub(super) own_stop: Option<Instant>,
}

impl Stopping {
    pub(super) const fn new() -> Self {
        Self {
            entered: Instant::from_ticks(0),
            is_seen: true,
            own_stop: None,
        }
    }

    /// Another state has begun.
    pub(super) const fn enter(&mut self, now: Instant) {
        self.entered = now;
    }
}

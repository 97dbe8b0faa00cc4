//! The CAN controller as the device sees it: how well it gets on with the bus (ISO 11898-1), and what is done when it has left it.
//!
//! The firmware tells each change of state and each frame that was lost. The contract:
//! - Error passive is emergency 8120h, bus-off 8140h, a frame lost before the device saw it 8110h. Each is told once, and its end.
//! - The messages of bus-off wait for the bus; they leave when it is back.
//! - Bus-off is a communication error: 1029h says which NMT state follows, and nothing is sent.
//! - After a delay the firmware is asked to start the controller again, and asked again every second until the controller is
//!   back. There is no second boot-up message.

use crate::time::{Duration, Instant, NEVER, earlier, has_come};

/// The state of the controller (fault confinement, ISO 11898-1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ControllerState {
    /// Few errors: it takes part in full.
    ErrorActive,
    /// It takes part in full, but one of its error counters has reached the warning limit, 96. The red light tells
    /// (CiA 303-3); no emergency message does.
    Warning,
    /// Many errors: it no longer disturbs the frames of others.
    ErrorPassive,
    /// Too many errors: it has left the bus, until it is started again.
    BusOff,
}

/// What has gone wrong on the bus since power-on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// How often the controller became error passive.
    pub error_passive: u32,
    /// How often it went bus-off.
    pub bus_off: u32,
    /// How often the firmware was asked to start it again.
    pub restarts: u32,
    /// Received frames that were lost before the device saw them.
    pub lost_frames: u32,
    /// What the device could not keep because a queue was full ([`crate::Node::overflows`]).
    pub overflows: u32,
}

/// How long no frame may be lost until the error 8110h is over.
const OVERRUN_TIME: Duration = Duration::from_ticks(1_000_000);

/// How long a restart may take until the firmware is asked again.
const RESTART_PATIENCE: Duration = Duration::from_ticks(1_000_000);

/// How long the controller stays off the bus unless the firmware says otherwise.
const DEFAULT_DELAY: Duration = Duration::from_ticks(100_000);

/// What time has brought.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Due {
    /// The controller may go on the bus again.
    Restart,
    /// No frame was lost for a while.
    OverrunOver,
}

/// What the device knows of its controller.
#[derive(Debug)]
pub(crate) struct Controller {
    pub(crate) state: ControllerState,
    pub(crate) counters: Counters,
    /// `None`: it stays off the bus.
    delay: Option<Duration>,
    restart_at: Instant,
    overrun_until: Instant,
}

impl Controller {
    pub(crate) const fn new() -> Self {
        Self {
            state: ControllerState::ErrorActive,
            counters: Counters {
                error_passive: 0,
                bus_off: 0,
                restarts: 0,
                lost_frames: 0,
                overflows: 0,
            },
            delay: Some(DEFAULT_DELAY),
            restart_at: NEVER,
            overrun_until: NEVER,
        }
    }

    /// A new delay counts from the next bus-off on.
    pub(crate) fn set_delay(&mut self, delay: Option<Duration>) {
        self.delay = delay;
    }

    pub(crate) fn is_bus_off(&self) -> bool {
        self.state == ControllerState::BusOff
    }

    /// The state of the controller now; returns the one before if it is another one.
    pub(crate) fn enter(
        &mut self,
        state: ControllerState,
        now: Instant,
    ) -> Option<ControllerState> {
        let before = core::mem::replace(&mut self.state, state);
        if before == state {
            return None;
        }
        self.restart_at = NEVER;
        match state {
            ControllerState::ErrorActive | ControllerState::Warning => {}
            ControllerState::ErrorPassive => count(&mut self.counters.error_passive, 1),
            ControllerState::BusOff => {
                count(&mut self.counters.bus_off, 1);
                self.restart_at = self.delay.map_or(NEVER, |delay| now + delay);
            }
        }
        Some(before)
    }

    /// So many frames were lost.
    pub(crate) fn lose(&mut self, frames: u32, now: Instant) {
        count(&mut self.counters.lost_frames, frames);
        self.overrun_until = now + OVERRUN_TIME;
    }

    /// Lets time pass. Call it until there is nothing due.
    pub(crate) fn poll(&mut self, now: Instant) -> Option<Due> {
        if has_come(self.restart_at, now) {
            self.restart_at = now + RESTART_PATIENCE;
            count(&mut self.counters.restarts, 1);
            Some(Due::Restart)
        } else if has_come(self.overrun_until, now) {
            self.overrun_until = NEVER;
            Some(Due::OverrunOver)
        } else {
            None
        }
    }

    /// [`Controller::poll`] has nothing to do before this moment.
    #[inline]
    pub(crate) const fn deadline(&self) -> Instant {
        earlier(self.restart_at, self.overrun_until)
    }
}

fn count(counter: &mut u32, by: u32) {
    *counter = counter.saturating_add(by);
}

//! The CAN controller of the drive: its state and what it has lost, and three objects of the manufacturer that say how long to wait
//! and what went wrong.
//!
//! | object | holds |
//! |---|---|
//! | 2010h | counters since power-on: error passive, bus-off, restarts, received frames lost, queue overflows |
//! | 2011h | how long the controller stays off the bus after bus-off, in ms; FFFFh: until the next power-on |
//! | 5FF3h | how long an SDO server waits for the next frame of a client, in ms |
//!
//! A dictionary may leave them out.

use canopen::od::{self};
use canopen::{Application, ControllerState, Duration, Instant};

use super::hooks::{RESTART_DELAY, SDO_TIME_OUT};
use super::{Activity, Device};
use crate::behaviour::Behaves;
use crate::exchange::{Actuals, Share};

const COUNTERS: u16 = 0x2010;

/// Emergency error code "CAN overrun" (CiA 301, table 26).
const OVERRUN: u16 = 0x8110;

/// Statusword bit 3, which is 1 in fault and in fault reaction active.
const FAULT: u16 = 1 << 3;

/// The value of 2011h that stands for "never".
const STAY_OFF: u16 = u16::MAX;

impl<D: Behaves, A: Application<D>> Device<D, A> {
    /// The state of the CAN controller ([`canopen::Node::controller_changed`]); bus-off brings the motor to rest.
    pub fn controller_changed<X: Share>(
        &mut self,
        state: ControllerState,
        now: Instant,
        exchange: &mut X,
    ) {
        self.node.controller_changed(state, now);
        self.look_at_bus(state == ControllerState::BusOff, exchange);
        if self.activity == Activity::Running {
            self.post(exchange);
        }
    }

    /// So many received frames were lost ([`canopen::Node::frames_lost`]).
    pub fn frames_lost(&mut self, count: u32, now: Instant) {
        self.node.frames_lost(count, now);
    }

    /// How long the controller stays off the bus after bus-off ([`canopen::Node::set_restart_delay`]).
    pub fn set_restart_delay(&mut self, delay: Option<Duration>) {
        self.node.set_restart_delay(delay);
    }

    /// Boot: the objects are at their power-on values.
    pub(super) fn start_controller(&mut self) {
        self.read_delays();
        self.show_counters();
    }

    /// A drive that stopped because frames were lost has the error of the controller for a cause: it stands as long as the
    /// fault does.
    pub(super) fn keep_overrun(&mut self, actuals: &Actuals, now: Instant) {
        if actuals.error_code == OVERRUN && actuals.statusword & FAULT != 0 {
            self.node.frames_lost(0, now);
        }
    }

    /// Shows what was counted, and takes new delays.
    pub(super) fn serve_controller(&mut self) {
        if self.hooks.take_delay_written() {
            self.read_delays();
        }
        if self.node.counters() != self.counters {
            self.show_counters();
        }
    }

    #[cold]
    #[inline(never)]
    fn read_delays(&mut self) {
        if let Some(milliseconds) = od::read_u16(self.node.dictionary(), RESTART_DELAY, 0) {
            let delay = (milliseconds != STAY_OFF).then(|| Duration::millis(milliseconds.into()));
            self.node.set_restart_delay(delay);
        }
        if let Some(milliseconds) = od::read_u16(self.node.dictionary(), SDO_TIME_OUT, 0) {
            self.node
                .set_sdo_time_out(Duration::millis(milliseconds.into()));
        }
    }

    #[cold]
    #[inline(never)]
    fn show_counters(&mut self) {
        self.counters = self.node.counters();
        let counts = [
            self.counters.error_passive,
            self.counters.bus_off,
            self.counters.restarts,
            self.counters.lost_frames,
            self.counters.overflows,
        ];
        for (sub, count) in (1..).zip(counts) {
            // A dictionary without the object has no place for it.
            let _ = od::write_u32(self.node.dictionary_mut(), COUNTERS, sub, count);
        }
    }
}

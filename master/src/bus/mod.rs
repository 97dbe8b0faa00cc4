//! Buses: where frames travel between stations.
//!
//! A [`Station`] is anything sans-I/O that speaks CAN: the virtual drive, a scripted master, a plain CANopen node in a
//! test. The [`simulated`] bus carries real frames between stations of one process on virtual time. The [`live`] bus
//! joins a drive or a master in real time with other programs: [`slcan_tcp`] for them, adapters by [`slcan_client`] and, on
//! Linux, SocketCAN.

pub mod live;
pub mod simulated;
pub mod slcan_client;
pub mod slcan_tcp;
#[cfg(target_os = "linux")]
pub mod socketcan;
pub mod timing;

use std::any::Any;
use std::fmt::Debug;

use canopen::{BitRate, ControllerState, Frame, Instant};

/// A participant of a CAN bus. Frames and time go in, frames and the next deadline come out; it never waits.
///
/// Time never runs backwards: each `now` is at least the one before.
pub trait Station: Any + Debug {
    /// A frame of another station has arrived completely at `now`.
    fn receive(&mut self, frame: &Frame, now: Instant);

    /// Lets time pass until `now`. Returns when it wants to be called again at the latest
    /// ([`canopen::time::NEVER`] if only a frame can wake it).
    fn poll(&mut self, now: Instant) -> Instant;

    /// The next frame to send, if there is one. A frame that was handed out is sent for sure, unless the station is
    /// detached or [`Station::was_reset`] says so.
    fn transmit(&mut self) -> Option<Frame>;

    /// The bit rate its controller is set to; `None` if it follows any (a station that no test is about).
    fn bit_rate(&self) -> Option<BitRate> {
        None
    }

    /// Whether its controller listens only: it sends nothing, and no frame is acknowledged by it.
    fn is_silent(&self) -> bool {
        false
    }

    /// Its controller is silent and has seen a frame that it cannot read: one of another bit rate, or one that broke off.
    fn error_seen(&mut self, now: Instant) {
        let _ = now;
    }

    /// Whether the controller was reset since the last call (a power cycle): frames it had taken are lost.
    fn was_reset(&mut self) -> bool {
        false
    }

    /// Its controller is in another state: bus-off, error passive, or well again.
    fn controller_changed(&mut self, state: ControllerState, now: Instant) {
        let _ = (state, now);
    }

    /// So many frames were lost in its controller, because the station did not fetch them in time.
    fn frames_lost(&mut self, count: u32, now: Instant) {
        let _ = (count, now);
    }

    /// Whether it has ordered its controller to go on the bus again since the last call. Only bus-off needs it.
    fn restarts_controller(&mut self) -> bool {
        false
    }
}

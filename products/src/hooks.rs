//! What hooks cost that nobody writes: the same device with an application that has none, and with one that leaves all of them out.
//!
//! Nothing calls this. `cargo xtask bench` compiles it both ways for the target and compares the sizes (feature `hooks`).

#[cfg(not(feature = "hooks"))]
use canopen::Application;
use canopen::{Frame, Instant, Node};

use crate::lmd::Dictionary;

/// An application without a word to say.
#[derive(Debug)]
pub struct Silent;

/// Without hooks.
#[cfg(not(feature = "hooks"))]
pub type Measured = Silent;

#[cfg(not(feature = "hooks"))]
impl Application<Dictionary> for Silent {}

/// With the hooks of the data sheet, all left out.
#[cfg(feature = "hooks")]
pub type Measured = crate::lmd::Hooked<Silent>;

#[cfg(feature = "hooks")]
impl crate::lmd::Hooks for Silent {}

/// Everything that the device does with its application.
pub fn device(
    node: &mut Node<Dictionary>,
    frame: &Frame,
    now: Instant,
    application: &mut Measured,
) -> Option<Frame> {
    node.boot(canopen::cia301::nmt::Reset::Node, now, application);
    node.receive(frame, now, application);
    node.poll(now, application);
    node.transmit(application)
}

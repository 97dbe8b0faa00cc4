//! The engine on a simple motor among switches.

mod axis;
mod bounds;
mod interruptions;
mod results;
mod starts;

use super::*;
pub(super) use axis::{Bench, Range, Track};

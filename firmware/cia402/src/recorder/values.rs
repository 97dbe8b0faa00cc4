//! The values of a control tick that can be recorded.

use crate::exchange::TickResult;
use crate::scope::{Signal, every_signal};

/// Makes [`bits`] of the table.
macro_rules! values {
    ($($(#[$doc:meta])* $signal:ident $index:literal $sub:literal $bits:literal $kind:ident $(with $feature:tt)? |$tick:ident| $value:expr;)*) => {
        /// The bits of a value in this tick; those above its length are 0.
        pub(super) fn bits(signal: Signal, tick: &TickResult<'_>) -> u32 {
            match signal {
                $($(#[cfg(feature = $feature)])? Signal::$signal => {
                    let $tick = tick;
                    $value
                })*
            }
        }
    };
}

every_signal!(values);

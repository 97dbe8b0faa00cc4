//! Why a step of a script failed: what was expected, and what came instead.

use std::fmt;

use canopen::{Duration, Frame, Instant};

use crate::LineDown;
use crate::trace::candump;

/// A step of a script that failed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Failure {
    /// What was expected did not come.
    Timeout {
        /// What was expected.
        expected: String,
        /// How long it was waited for.
        within: Duration,
        /// When the wait ended.
        at: Instant,
    },
    /// Something else came.
    Unexpected {
        /// What was expected.
        expected: String,
        /// What came.
        got: Frame,
        /// When it came.
        at: Instant,
    },
    /// The device aborted an SDO transfer (CiA 301).
    Abort {
        /// Index of the object.
        index: u16,
        /// Sub-index.
        sub: u8,
        /// The abort code.
        code: u32,
    },
    /// The device refused an LSS configuration service (CiA 305).
    LssRefused {
        /// Command specifier of the service.
        service: u8,
        /// Error code of the answer.
        error: u8,
    },
    /// An object had another value or length than it should.
    WrongValue {
        /// What was expected.
        expected: String,
        /// What it is.
        got: String,
    },
    /// The device sends more than it has told, or than anybody would wait for.
    Endless {
        /// What it sends.
        what: String,
        /// After how much nobody waits any longer.
        limit: String,
    },
    /// Whatever was going on has taken as long as it may ([`Master::set_time_limit`]).
    ///
    /// [`Master::set_time_limit`]: crate::Master::set_time_limit
    TimeIsUp {
        /// How long it might.
        limit: Duration,
    },
    /// The bus itself cannot be used any more.
    LineDown(LineDown),
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Timeout {
                expected,
                within,
                at,
            } => {
                write!(
                    f,
                    "expected {expected}, nothing came in {} ms until {}",
                    within.to_millis(),
                    candump::time(*at)
                )
            }
            Self::Unexpected { expected, got, at } => {
                write!(f, "expected {expected}, got {}", candump::line(*at, got))
            }
            Self::Abort { index, sub, code } => {
                write!(
                    f,
                    "SDO transfer of {index:04X}h:{sub:02X} aborted with {code:08X}h"
                )
            }
            Self::LssRefused { service, error } => {
                write!(
                    f,
                    "LSS service {service:02X}h refused with error {error:02X}h"
                )
            }
            Self::WrongValue { expected, got } => write!(f, "expected {expected}, got {got}"),
            Self::Endless { what, limit } => {
                write!(f, "{what} does not end: stopped after {limit}")
            }
            Self::TimeIsUp { limit } => {
                write!(f, "no end after {} s: stopped", limit.to_millis() / 1_000)
            }
            Self::LineDown(down) => write!(f, "{down}"),
        }
    }
}

impl std::error::Error for Failure {}

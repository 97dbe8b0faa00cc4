//! Why a command did not do what it should: one line, and an exit code.

use std::io;

use crate::command_line::cannot_write;
use crate::trace::abort_code;
use crate::{Failure, LineDown};

/// What went wrong.
#[derive(Debug)]
pub enum Problem {
    /// The command line, a file or an adapter is wrong, or the adapter has gone: exit code 2.
    Usage(String),
    /// The bus or a device did not do what was asked: exit code 1.
    Failed(String),
    /// The output could not be written: exit code 2, or 0 if its reader has seen enough.
    Output(io::Error),
    /// A person stopped it: exit code 130.
    Stopped,
}

impl Problem {
    /// What a failed conversation with a node means.
    pub fn with_node(node: u8, failure: Failure) -> Self {
        match failure {
            Failure::Timeout { .. } => Self::Failed(format!("node {node} does not answer")),
            Failure::Abort { index, sub, code } => Self::Failed(format!(
                "node {node} refuses {index:04X}h:{sub:02X} with {}",
                abort_code(code)
            )),
            other => other.into(),
        }
    }

    /// The line for people; nothing if there is nothing to say.
    pub fn line(&self) -> Option<String> {
        match self {
            Self::Usage(text) | Self::Failed(text) => Some(text.clone()),
            Self::Output(error) if error.kind() == io::ErrorKind::BrokenPipe => None,
            Self::Output(error) => Some(cannot_write(error)),
            Self::Stopped => None,
        }
    }

    /// The exit code.
    pub fn code(&self) -> u8 {
        match self {
            Self::Output(error) if error.kind() == io::ErrorKind::BrokenPipe => 0,
            Self::Usage(_) | Self::Output(_) => 2,
            Self::Failed(_) => 1,
            Self::Stopped => 130,
        }
    }
}

impl From<Failure> for Problem {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::LineDown(down) if down == LineDown::stopped() => Self::Stopped,
            Failure::LineDown(down) => Self::Usage(down.to_string()),
            Failure::LssRefused { service, error } => Self::Failed(refusal(service, error)),
            other => Self::Failed(other.to_string()),
        }
    }
}

impl From<io::Error> for Problem {
    fn from(error: io::Error) -> Self {
        Self::Output(error)
    }
}

/// What the error code of an LSS service means (CiA 305).
fn refusal(service: u8, error: u8) -> String {
    let why = match (service, error) {
        (0x11, 1) => "the node-ID is out of range",
        (0x13, 1) => "the device does not support this bit rate",
        (0x17, 1) => "the device does not store by LSS",
        (0x17, 2) => "the device cannot access its memory",
        (_, 0xFF) => "an error of the device's own kind, such as a value that its build fixes",
        _ => "an error the standard does not name",
    };
    format!("LSS service {service:02X}h is refused with error {error:02X}h: {why}")
}

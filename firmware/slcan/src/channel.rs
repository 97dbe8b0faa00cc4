//! Which command may come when, and what is replied.

use canopen::Frame;

use crate::{AdapterBitRate, Command, ERROR, OK};

/// One client's channel to the bus: closed, open, or listening only.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Channel {
    state: State,
    bit_rate: Option<AdapterBitRate>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum State {
    #[default]
    Closed,
    Open,
    ListenOnly,
}

/// What to do with a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Answer {
    /// What to send back.
    pub reply: &'static [u8],
    /// What to put on the bus.
    pub frame: Option<Frame>,
}

impl Channel {
    /// A closed channel, no bit rate chosen.
    pub const fn new() -> Self {
        Self {
            state: State::Closed,
            bit_rate: None,
        }
    }

    /// Whether frames from the bus are to be sent to the client.
    pub fn is_open(&self) -> bool {
        self.state != State::Closed
    }

    /// The bit rate the client chose with `S`; `None` if it did not, or gave register values.
    pub fn bit_rate(&self) -> Option<AdapterBitRate> {
        self.bit_rate
    }

    /// Carries out a command. A frame while the channel is closed or listens only, and a new bit rate while it is open, are
    /// errors, as with the adapters. Opening twice is none: python-can does it.
    pub fn command(&mut self, command: Command) -> Answer {
        let mut frame = None;
        let reply = match command {
            Command::Frame(sent) if self.state == State::Open => {
                frame = Some(sent);
                OK
            }
            Command::SetBitRate(bit_rate) if !self.is_open() => {
                self.bit_rate = Some(bit_rate);
                OK
            }
            Command::SetBitTiming(_) if !self.is_open() => {
                self.bit_rate = None;
                OK
            }
            Command::Frame(_) | Command::SetBitRate(_) | Command::SetBitTiming(_) => ERROR,
            Command::Open => self.enter(State::Open),
            Command::Listen => self.enter(State::ListenOnly),
            Command::Close => self.enter(State::Closed),
            Command::Version => b"V0100\r",
            Command::SerialNumber => b"NA402\r",
            Command::Status => b"F00\r",
            Command::TimeStamps(false) | Command::Setting | Command::Empty => OK,
            Command::TimeStamps(true) | Command::Malformed => ERROR,
        };
        Answer { reply, frame }
    }

    fn enter(&mut self, state: State) -> &'static [u8] {
        self.state = state;
        OK
    }
}

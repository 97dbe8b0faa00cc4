//! Bytes in, commands out.

use heapless::Vec;

use crate::{Command, LINE_LENGTH};

/// Collects bytes to lines. A line that is too long is dropped up to its CR and reported as [`Command::Malformed`].
#[derive(Clone, Debug, Default)]
pub struct Decoder {
    line: Vec<u8, LINE_LENGTH>,
    too_long: bool,
}

impl Decoder {
    /// At the start of a line.
    pub const fn new() -> Self {
        Self {
            line: Vec::new(),
            too_long: false,
        }
    }

    /// Takes one byte; gives the command when the byte was the CR that ends its line. Line feeds are ignored.
    pub fn push(&mut self, byte: u8) -> Option<Command> {
        match byte {
            b'\r' => {
                let command = if self.too_long {
                    Command::Malformed
                } else {
                    Command::parse(&self.line)
                };
                self.line.clear();
                self.too_long = false;
                Some(command)
            }
            b'\n' => None,
            _ => {
                self.too_long |= self.line.push(byte).is_err();
                None
            }
        }
    }
}

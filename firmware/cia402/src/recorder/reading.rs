//! 20D3h, read piece by piece from the memory of the recorder.

use core::ops::Deref;

use canopen::Source;
use canopen::cia301::sdo::AbortCode;
use canopen::od::{self, Dictionary};

use super::Memory;
use crate::scope::{SCOPE, State, sub};

/// The source of 20D3h: the recording while the recorder is full, nothing while it is idle, and 08000022h while it records; a
/// transfer during which the next recording begins ends with it, and not with bytes of both.
#[derive(Debug)]
pub struct Recording<M> {
    memory: M,
    /// Which recording is being read.
    run: Option<u32>,
    /// There was nothing to read when the transfer began.
    is_empty: bool,
}

impl<M: Deref<Target = Memory>> Recording<M> {
    /// What the recorder of the same memory records.
    pub const fn new(memory: M) -> Self {
        Self {
            memory,
            run: None,
            is_empty: false,
        }
    }

    /// The memory.
    pub const fn memory(&self) -> &M {
        &self.memory
    }

    /// Which recording is being read, if it is still there.
    fn run(&self) -> Result<u32, AbortCode> {
        self.run
            .filter(|run| self.memory.whole() == Some(*run))
            .ok_or(AbortCode::DeviceState)
    }
}

impl<D: Dictionary, M: Deref<Target = Memory>> Source<D> for Recording<M> {
    fn size(&mut self, dictionary: &D) -> Result<Option<u32>, AbortCode> {
        // An order to begin anew that no tick has taken yet shows in the dictionary alone.
        let state = od::read_u8(dictionary, SCOPE, sub::STATE);
        let is_full = state == Some(State::Full as u8);
        self.run = self.memory.whole().filter(|_| is_full);
        self.is_empty = state == Some(State::Idle as u8);
        if self.is_empty {
            return Ok(Some(0));
        }
        self.run()?;
        Ok(Some(self.memory.length()))
    }

    fn read_at(&mut self, _: &D, position: u32, into: &mut [u8]) -> Result<usize, AbortCode> {
        if self.is_empty {
            return Ok(0);
        }
        let run = self.run()?;
        let end = self.memory.length();
        let mut word = [0; 4];
        let mut copied: u32 = 0;
        for byte in into {
            let at = position.saturating_add(copied);
            if at >= end {
                break;
            }
            if copied == 0 || at & 3 == 0 {
                word = self.memory.word(at >> 2).to_le_bytes();
            }
            *byte = word.get((at & 3) as usize).copied().unwrap_or(0);
            copied = copied.saturating_add(1);
        }
        // A control tick may have come in between.
        self.run()?;
        self.memory
            .read(run, position.saturating_add(copied) >= end);
        Ok(copied as usize)
    }
}

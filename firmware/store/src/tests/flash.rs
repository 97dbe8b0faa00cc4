//! NOR flash in RAM whose power can be cut at any byte.

use std::vec;
use std::vec::Vec;

use crate::Store;
use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash, check_erase, check_read,
    check_write,
};

/// What the mock flash says when it cannot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// There is no power any more.
    PowerCut,
    /// This once it failed; the next write may not.
    Stumbled,
    /// The driver was called against its contract.
    Misuse(NorFlashErrorKind),
}

impl NorFlashError for Refusal {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::PowerCut | Self::Stumbled => NorFlashErrorKind::Other,
            Self::Misuse(kind) => *kind,
        }
    }
}

/// NOR flash in RAM: programming clears bits, erasing a sector sets them, and each byte programmed or erased takes one from the
/// budget. At the byte that finds the budget spent the power goes: that byte is left half done.
#[derive(Clone, Debug)]
pub struct Flash<const SECTOR: usize, const WORD: usize> {
    /// What it holds.
    pub bytes: Vec<u8>,
    budget: usize,
    /// The bytes programmed or erased so far, in their order: where each is and what it became.
    changes: Vec<(usize, u8)>,
    /// How many sectors were erased.
    pub erases: usize,
    /// Programming does nothing, as on a worn-out or write-protected device.
    pub deaf: bool,
    /// The next write fails.
    pub stumbles: bool,
}

impl<const SECTOR: usize, const WORD: usize> Flash<SECTOR, WORD> {
    /// Erased.
    pub fn new(sectors: usize) -> Self {
        Self::filled(sectors, 0xFF)
    }

    /// Every byte is this one.
    pub fn filled(sectors: usize, byte: u8) -> Self {
        Self {
            bytes: vec![byte; sectors * SECTOR],
            budget: usize::MAX,
            changes: Vec::new(),
            erases: 0,
            deaf: false,
            stumbles: false,
        }
    }

    /// All of it.
    pub fn range(&self) -> core::ops::Range<u32> {
        0..u32::try_from(self.bytes.len()).unwrap()
    }

    /// The store on all of it.
    pub fn store(self) -> Store<Self> {
        let range = self.range();
        Store::new(self, range).unwrap()
    }

    /// With power for so many bytes.
    pub fn powered(mut self, budget: usize) -> Self {
        self.budget = budget;
        self
    }

    /// Changes one byte, or half of its bits if the power goes now.
    fn change(&mut self, at: usize, to: u8) -> Result<(), Refusal> {
        if self.budget == 0 {
            return Err(Refusal::PowerCut);
        }
        self.budget -= 1;
        if self.budget == 0 {
            self.bytes[at] = half_done(self.bytes[at], to);
            return Err(Refusal::PowerCut);
        }
        self.changes.push((at, to));
        self.bytes[at] = to;
        Ok(())
    }

    /// What the flash holds if the power goes at each byte that `operation` programs or erases, and in the end what the whole of
    /// it leaves. The operation cannot see a cut coming, so it runs once, and its changes are done again up to each of them.
    pub fn cuts(&self, operation: impl FnOnce(&mut Store<Self>)) -> Vec<Vec<u8>> {
        let mut flash = self.clone();
        flash.changes.clear();
        let mut store = flash.store();
        operation(&mut store);
        let mut now = self.bytes.clone();
        let mut left = Vec::new();
        for (at, to) in store.release().changes {
            let mut cut = now.clone();
            cut[at] = half_done(now[at], to);
            left.push(cut);
            now[at] = to;
        }
        left.push(now);
        left
    }

    /// The same flash with other bytes.
    pub fn holding(&self, bytes: &[u8]) -> Self {
        Self {
            bytes: bytes.to_vec(),
            ..Self::new(0)
        }
    }
}

/// A byte whose change was cut: half of its bits are the new ones.
const fn half_done(from: u8, to: u8) -> u8 {
    (from & 0xAA) | (to & 0x55)
}

impl<const SECTOR: usize, const WORD: usize> ErrorType for Flash<SECTOR, WORD> {
    type Error = Refusal;
}

impl<const SECTOR: usize, const WORD: usize> ReadNorFlash for Flash<SECTOR, WORD> {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Refusal> {
        check_read(self, offset, bytes.len()).map_err(Refusal::Misuse)?;
        if self.budget == 0 {
            return Err(Refusal::PowerCut);
        }
        bytes.copy_from_slice(&self.bytes[offset as usize..][..bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl<const SECTOR: usize, const WORD: usize> NorFlash for Flash<SECTOR, WORD> {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = SECTOR;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Refusal> {
        check_erase(self, from, to).map_err(Refusal::Misuse)?;
        self.erases += 1;
        (from..to).try_for_each(|at| self.change(at as usize, 0xFF))
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Refusal> {
        check_write(self, offset, bytes.len()).map_err(Refusal::Misuse)?;
        if core::mem::take(&mut self.stumbles) {
            return Err(Refusal::Stumbled);
        }
        if self.deaf {
            return Ok(());
        }
        bytes.iter().enumerate().try_for_each(|(i, byte)| {
            let at = offset as usize + i;
            self.change(at, self.bytes[at] & byte)
        })
    }
}

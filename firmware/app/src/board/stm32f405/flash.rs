//! The parameter sectors of the chip's flash.
//!
//! Sectors 2 and 3, 16 KiB each (`memory.x`). Programming a word stops the core for some 16 µs each byte, erasing a
//! sector for 0.8 s at most, for program and constants lie in the same flash. So parameters are stored only while the
//! motor has no current, and an erase looks at the enable pin itself.

use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};
use stm32f4xx_hal::flash::FlashExt;
use stm32f4xx_hal::pac;

const SECTOR: u32 = 16 * 1024;
const SECTORS: u32 = 2;
const FIRST_SECTOR: u32 = 2;
const SIZE: u32 = SECTORS * SECTOR;

/// The first address of the parameter sectors, seen from the start of the flash.
const OFFSET: u32 = FIRST_SECTOR * SECTOR;

unsafe extern "C" {
    /// Where `memory.x` keeps room for the parameters.
    static _parameters_start: u8;
    static _parameters_end: u8;
}

/// The parameter sectors; addresses count from the first of them.
pub struct ParameterSectors {
    flash: pac::FLASH,
}

impl ParameterSectors {
    /// The sectors that the memory layout keeps free.
    ///
    /// # Panics
    /// If the layout keeps others, which a changed `memory.x` does at the first start.
    pub fn new(flash: pac::FLASH) -> Self {
        let kept = (&raw const _parameters_end as usize) - (&raw const _parameters_start as usize);
        assert!(
            &raw const _parameters_start as usize == flash.address() + OFFSET as usize
                && kept == SIZE as usize
        );
        Self { flash }
    }

    /// Flags of an operation that failed stand until they are written, and would fail the next one too.
    fn clear_flags(&mut self) {
        self.flash.sr().write(|w| {
            w.pgserr().clear_bit_by_one();
            w.pgperr().clear_bit_by_one();
            w.pgaerr().clear_bit_by_one();
            w.wrperr().clear_bit_by_one();
            w.operr().clear_bit_by_one()
        });
    }

    /// The data cache may hold what was there before (RM0090, 3.5.4).
    fn flush_cache(&mut self) {
        self.flash.acr().modify(|_, w| w.dcen().clear_bit());
        self.flash.acr().modify(|_, w| w.dcrst().set_bit());
        self.flash.acr().modify(|_, w| w.dcrst().clear_bit());
        self.flash.acr().modify(|_, w| w.dcen().set_bit());
    }
}

impl ErrorType for ParameterSectors {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for ParameterSectors {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        embedded_storage::nor_flash::check_read(self, offset, bytes.len())?;
        let start = (self.flash.address() + (OFFSET + offset) as usize) as *const u8;
        for (i, byte) in bytes.iter_mut().enumerate() {
            // SAFETY: the address lies in the parameter sectors, which are always readable and hold no Rust value. Volatile,
            // because they change behind the compiler's back.
            *byte = unsafe { start.add(i).read_volatile() };
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        SIZE as usize
    }
}

impl NorFlash for ParameterSectors {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = SECTOR as usize;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        embedded_storage::nor_flash::check_erase(self, from, to)?;
        if super::stage::has_power() {
            return Err(NorFlashErrorKind::Other);
        }
        self.clear_flags();
        for sector in from / SECTOR..to / SECTOR {
            // At most sector 3, so it fits.
            let number = (FIRST_SECTOR + sector) as u8;
            self.flash
                .unlocked()
                .erase(number)
                .map_err(|_| NorFlashErrorKind::Other)?;
        }
        self.flush_cache();
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        embedded_storage::nor_flash::check_write(self, offset, bytes.len())?;
        self.clear_flags();
        let written = self
            .flash
            .unlocked()
            .program((OFFSET + offset) as usize, bytes.iter());
        self.flush_cache();
        written.map_err(|_| NorFlashErrorKind::Other)
    }
}

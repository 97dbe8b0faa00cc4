//! The parameter sectors of the chip's flash.
//!
//! Sectors 2 and 3, 16 KiB each (`memory.x`). Programming a word of 32 bits stops the core for some 16 µs, 0.1 ms at most, erasing a
//! sector for 0.25 s, 0.5 s at most, for program and constants lie in the same flash. So parameters are stored only while the
//! motor has no current, and an erase looks at the enable pin itself. The supply has the 2.7 V that 32 bits need: it is watched ([`super::clocks`]).

use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};
use stm32f4xx_hal::pac::FLASH;

use super::watchdog::Watchdog;

const SECTOR: u32 = 16 * 1024;
const SECTORS: u32 = 2;
const FIRST_SECTOR: u32 = 2;
const SIZE: u32 = SECTORS * SECTOR;

/// The first address of the parameter sectors, seen from the start of the flash.
const OFFSET: u32 = FIRST_SECTOR * SECTOR;

/// Where the flash begins.
const FLASH_BASE: usize = 0x0800_0000;

/// What FLASH_CR opens with.
const KEYS: [u32; 2] = [0x4567_0123, 0xCDEF_89AB];

/// Looks at the status. Each waits for the flash, as does the core with every instruction, so that an operation takes one or two.
const MOST_POLLS: u32 = 100_000;

unsafe extern "C" {
    /// Where `memory.x` keeps room for the parameters.
    static _parameters_start: u8;
    static _parameters_end: u8;
}

/// The parameter sectors; addresses count from the first of them.
pub struct ParameterSectors {
    flash: FLASH,
}

impl ParameterSectors {
    /// The sectors that the memory layout keeps free.
    ///
    /// # Panics
    /// If the layout keeps others, which a changed `memory.x` does at the first start.
    pub fn new(flash: FLASH) -> Self {
        let kept = (&raw const _parameters_end as usize) - (&raw const _parameters_start as usize);
        assert!(
            &raw const _parameters_start as usize == FLASH_BASE + OFFSET as usize
                && kept == SIZE as usize
        );
        Self { flash }
    }

    /// Opens the controller, does something, and locks it again.
    fn opened(
        &mut self,
        work: impl FnOnce(&mut Self) -> Result<(), NorFlashErrorKind>,
    ) -> Result<(), NorFlashErrorKind> {
        self.clear_flags();
        for key in KEYS {
            // SAFETY: the keys of the register. What is opened lies in the hands of `work`.
            self.flash.keyr().write(|w| unsafe { w.bits(key) });
        }
        let done = work(self);
        self.flash.cr().write(|w| w.lock().set_bit());
        self.flush_cache();
        done
    }

    /// Waits until the operation is over, and looks how it went.
    fn finish(&mut self) -> Result<(), NorFlashErrorKind> {
        let idle = || self.flash.sr().read().bsy().bit_is_clear();
        let is_over = (0..MOST_POLLS).any(|_| idle());
        let status = self.flash.sr().read();
        let failed = status.pgserr().bit_is_set()
            || status.pgperr().bit_is_set()
            || status.pgaerr().bit_is_set()
            || status.wrperr().bit_is_set();
        if !is_over || failed {
            return Err(NorFlashErrorKind::Other);
        }
        Ok(())
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
        // A start that looks for a record at each word takes most of a second.
        Watchdog::feed_at_rest();
        let start = (FLASH_BASE + (OFFSET + offset) as usize) as *const u8;
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
        if crate::board::own::has_power() {
            return Err(NorFlashErrorKind::Other);
        }
        self.opened(|sectors| {
            for sector in from / SECTOR..to / SECTOR {
                Watchdog::feed_at_rest();
                // At most sector 3, so it fits.
                let number = (FIRST_SECTOR + sector) as u8;
                let control = sectors.flash.cr();
                // SAFETY: a parameter sector, in which nothing of the program lies.
                control.modify(|_, w| unsafe {
                    w.psize().psize32().ser().set_bit().snb().bits(number)
                });
                control.modify(|_, w| w.strt().set_bit());
                sectors.finish()?;
            }
            Ok(())
        })
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        embedded_storage::nor_flash::check_write(self, offset, bytes.len())?;
        let start = (FLASH_BASE + (OFFSET + offset) as usize) as *mut u32;
        Watchdog::feed_at_rest();
        self.opened(|sectors| {
            sectors
                .flash
                .cr()
                .modify(|_, w| w.psize().psize32().pg().set_bit());
            for (i, word) in bytes.chunks_exact(4).enumerate() {
                let mut number = [0; 4];
                number.copy_from_slice(word);
                // SAFETY: a word of the parameter sectors, as has been checked, which hold no Rust value; programming is on.
                unsafe { start.add(i).write_volatile(u32::from_le_bytes(number)) };
                sectors.finish()?;
            }
            Ok(())
        })
    }
}

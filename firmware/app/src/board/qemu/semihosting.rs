//! Files of the host, through the emulator's semihosting calls (Arm IHI, "Semihosting for AArch32 and AArch64").

use core::ffi::CStr;

use cortex_m_semihosting::{nr, syscall};

/// An open file of the host, in the folder where the emulator was started.
pub struct File(usize);

/// How to open a file, by the number of its `fopen` mode.
#[derive(Clone, Copy)]
pub enum Mode {
    /// "r+b": it must exist.
    Update = 3,
    /// "w+b": it is made, or emptied.
    Create = 7,
}

/// The host refused.
#[derive(Clone, Copy, Debug)]
pub struct Refused;

impl File {
    /// Opens a file.
    pub fn open(name: &CStr, mode: Mode) -> Result<Self, Refused> {
        let arguments = [name.as_ptr() as usize, mode as usize, name.count_bytes()];
        // SAFETY: SYS_OPEN takes the address of a name with a zero behind it, a mode and the length of the name; it
        // only reads.
        let handle = unsafe { syscall(nr::OPEN, &arguments) };
        if handle == usize::MAX {
            Err(Refused)
        } else {
            Ok(Self(handle))
        }
    }

    /// Reads from a position on; fewer bytes than asked for are an error.
    pub fn read(&mut self, position: usize, bytes: &mut [u8]) -> Result<(), Refused> {
        self.seek(position)?;
        let arguments = [self.0, bytes.as_mut_ptr() as usize, bytes.len()];
        // SAFETY: SYS_READ writes at most the given number of bytes to the given address, which are those of the slice.
        accomplished(unsafe { syscall(nr::READ, &arguments) })
    }

    /// Writes from a position on.
    pub fn write(&mut self, position: usize, bytes: &[u8]) -> Result<(), Refused> {
        self.seek(position)?;
        let arguments = [self.0, bytes.as_ptr() as usize, bytes.len()];
        // SAFETY: SYS_WRITE reads the given number of bytes from the given address, which are those of the slice.
        accomplished(unsafe { syscall(nr::WRITE, &arguments) })
    }

    fn seek(&mut self, position: usize) -> Result<(), Refused> {
        let arguments = [self.0, position];
        // SAFETY: SYS_SEEK takes two numbers.
        accomplished(unsafe { syscall(nr::SEEK, &arguments) })
    }
}

/// These calls answer 0 for success, else an error or the number of bytes left over.
fn accomplished(answer: usize) -> Result<(), Refused> {
    if answer == 0 {
        Ok(())
    } else {
        Err(Refused)
    }
}

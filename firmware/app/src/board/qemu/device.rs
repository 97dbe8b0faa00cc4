//! The peripherals of the MPS2 board with the image AN386, as far as this firmware takes them: what another board has from a crate, as there is none
//! for this one. From Arm DAI 0386 (addresses, interrupts) and DDI 0479 (registers of the CMSDK). All run at [`CLOCK_HZ`].

use core::cell::UnsafeCell;
use core::marker::PhantomData;
use core::ops::Deref;

use cortex_m::interrupt::InterruptNumber;

/// The one clock: core, timers, time.
pub const CLOCK_HZ: u32 = 25_000_000;

/// Bits of an interrupt's priority.
pub const NVIC_PRIO_BITS: u8 = 3;

/// RTIC asks for it. There is nothing in it: whoever wants a peripheral names it.
pub struct Peripherals;

impl Peripherals {
    /// All there is.
    ///
    /// # Safety
    /// None is needed; RTIC expects it.
    pub unsafe fn steal() -> Self {
        Self
    }
}

macro_rules! interrupts {
    ($($name:ident,)+) => {
        /// The interrupts, in the order of their numbers; nobody enables one of those behind.
        #[allow(clippy::upper_case_acronyms, reason = "the names of the data sheet")]
        #[derive(Clone, Copy)]
        #[repr(u16)]
        pub enum Interrupt {
            $($name,)+
        }

        #[allow(non_snake_case, reason = "the names of the data sheet")]
        mod handlers {
            extern "C" {
                // `device.x` gives one that ends the program to each that no task has.
                $(pub fn $name();)+
            }
        }

        /// The table that follows the exceptions of the core.
        #[link_section = ".vector_table.interrupts"]
        #[no_mangle]
        static __INTERRUPTS: [unsafe extern "C" fn(); [$(stringify!($name)),+].len()] = [$(handlers::$name),+];
    };
}

interrupts! {
    UART0RX, UART0TX, UART1RX, UART1TX, UART2RX, UART2TX, PORT0, PORT1,
    TIMER0, TIMER1, DUALTIMER, SPI, UARTOVF, ETHERNET, I2S, TSC,
}

// By this name RTIC looks for them.
pub use Interrupt as interrupt;

// SAFETY: each has its own number, which stays the same.
unsafe impl InterruptNumber for Interrupt {
    fn number(self) -> u16 {
        self as u16
    }
}

/// A register.
#[repr(transparent)]
pub struct Register(UnsafeCell<u32>);

impl Register {
    /// What it holds.
    #[inline(always)]
    pub fn read(&self) -> u32 {
        // SAFETY: a register is a word that is always there.
        unsafe { self.0.get().read_volatile() }
    }

    /// Writes all of it.
    #[inline(always)]
    pub fn write(&self, value: u32) {
        // SAFETY: as in `read`; none of these peripherals reaches memory.
        unsafe { self.0.get().write_volatile(value) }
    }
}

/// A peripheral at its address. Anybody may have it: an access is one load or store, and does nothing to memory.
pub struct Block<R> {
    address: usize,
    registers: PhantomData<fn() -> R>,
}

impl<R> Block<R> {
    /// # Safety
    /// The registers lie there.
    const unsafe fn at(address: usize) -> Self {
        Self {
            address,
            registers: PhantomData,
        }
    }
}

impl<R> Deref for Block<R> {
    type Target = R;

    #[inline(always)]
    fn deref(&self) -> &R {
        // SAFETY: who made the block has promised it; registers are cells.
        unsafe { &*(self.address as *const R) }
    }
}

/// A timer that counts downwards and begins anew with `reload`, or stops if that is 0.
#[repr(C)]
pub struct Timer {
    /// Bit 0: it counts. Bit 3: its interrupt.
    pub ctrl: Register,
    pub value: Register,
    /// One less than the period. A write is one to `value` too.
    pub reload: Register,
    /// Bit 0: it came to 0. Writing 1 clears it.
    pub intstatus: Register,
}

impl Timer {
    /// Of `ctrl`: it counts, with its interrupt.
    pub const RUN: u32 = 1 << 0 | 1 << 3;
}

/// One half of the double timer, which counts downwards.
#[repr(C)]
pub struct DualTimer {
    /// Where it begins. A write restarts it.
    pub load: Register,
    pub value: Register,
    pub control: Register,
    /// Any write clears its interrupt.
    pub intclr: Register,
}

impl DualTimer {
    /// Of `control`: once from `load` to 0 (bits 0 and 6), 32 bits (bit 1), its interrupt (bit 5).
    pub const ONCE: u32 = 1 << 0 | 1 << 1 | 1 << 5 | 1 << 6;
    /// Of `control`: it counts.
    pub const ENABLE: u32 = 1 << 7;
}

/// A serial port, with room for one byte each way.
#[repr(C)]
pub struct Uart {
    pub data: Register,
    pub state: Register,
    pub ctrl: Register,
    /// Which interrupts stand. Writing 1 clears.
    pub intstatus: Register,
    /// Clocks of a bit, 16 and more.
    pub bauddiv: Register,
}

impl Uart {
    /// Of `state`: there is a byte to send, and one that was received.
    pub const TX_FULL: u32 = 1 << 0;
    pub const RX_FULL: u32 = 1 << 1;
    /// Of `ctrl`: sends and receives; and with the interrupt for each byte received.
    pub const ENABLE: u32 = 1 << 0 | 1 << 1;
    pub const ENABLE_WITH_RX_INTERRUPT: u32 = Self::ENABLE | 1 << 3;
    /// Of `intstatus`: a byte was received.
    pub const RX_INTERRUPT: u32 = 1 << 1;
}

/// What the FPGA has beside the CMSDK.
#[repr(C)]
pub struct FpgaIo {
    not_taken: [Register; 6],
    /// Counts upwards at [`CLOCK_HZ`] for ever.
    pub counter: Register,
}

macro_rules! peripherals {
    ($($name:ident: $registers:ident at $address:literal,)+) => {$(
        // SAFETY: the address is that of the data sheet.
        pub const $name: Block<$registers> = unsafe { Block::at($address) };
    )+};
}

peripherals! {
    TIMER0: Timer at 0x4000_0000,
    TIMER1: Timer at 0x4000_1000,
    DUALTIMER1: DualTimer at 0x4000_2000,
    UART0: Uart at 0x4000_4000,
    FPGAIO: FpgaIo at 0x4002_8000,
}

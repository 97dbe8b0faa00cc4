//! What the core costs, in executed instructions.
//!
//! The image runs in QEMU with `-icount shift=0`: one nanosecond of virtual time is one instruction, and TIM5, which nobody
//! ever writes, counts them. Each workload is one line on the standard output, name, tab, count. The answer of each is
//! checked for its content; a wrong one ends the run with an error. A line `# heading` begins a table.
//!
//! A region begins when a received frame is handed to the device and ends when every frame of the answer is in a transmit
//! mailbox that always has room. It is one pass of the node task: receive, let time pass, transmit.
#![no_std]
#![no_main]
#![allow(
    missing_debug_implementations,
    reason = "nothing here is ever printed but counts"
)]

mod block;
mod device;
mod drive;
mod longest;
mod lookup;
mod passes;
mod plans;
mod pulses;
mod scope;
mod servo;

use cortex_m_rt::{entry, exception, ExceptionFrame};
use cortex_m_semihosting::{debug, heprintln, hprint, hprintln};
// Only for the linker script of the firmware, which expects its symbols.
use defmt as _;
use stm32f4xx_hal::pac;

/// Instructions executed since the start; wraps.
#[inline(always)]
fn instructions() -> u32 {
    // SAFETY: reading the counter of TIM5 has no effect, and nobody writes the timer.
    unsafe { (*pac::TIM5::ptr()).cnt().read().bits() }
}

/// Counts the instructions of `region`, without those of counting.
fn count<R>(region: impl FnOnce() -> R) -> (u32, R) {
    let empty = {
        let start = instructions();
        instructions().wrapping_sub(start)
    };
    let start = instructions();
    let result = region();
    let end = instructions();
    (end.wrapping_sub(start).wrapping_sub(empty), result)
}

/// The rows that follow belong under this heading.
fn heading(title: &str) {
    hprintln!("# {}", title);
}

/// One row of the table.
fn row(name: &str, count: u32) {
    hprintln!("{}\t{}", name, count);
}

/// One row of a table with several counts.
fn columns(name: &str, counts: &[u32]) {
    hprint!("{}", name);
    for count in counts {
        hprint!("\t{}", count);
    }
    hprintln!();
}

#[entry]
fn main() -> ! {
    heading("Instructions");
    device::run();
    plans::run();
    pulses::run();
    drive::run();
    scope::run();
    servo::run();
    heading("The whole drive");
    passes::run();
    drive::ticks();
    heading("Share of the CPU at full bus load");
    device::load();
    heading("Share of the CPU for stepping");
    pulses::share();
    heading("Longest paths");
    longest::run();
    heading("Look-up");
    lookup::run();
    heading("Memory of the device");
    device::memory();
    loop {
        debug::exit(debug::EXIT_SUCCESS);
    }
}

/// A wrong answer ends the run.
#[panic_handler]
fn panic(info: &core::panic::PanicInfo) -> ! {
    heprintln!("{}", info);
    loop {
        debug::exit(debug::EXIT_FAILURE);
    }
}

/// A fault ends the run.
#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    heprintln!("hard fault at {:#010x}", frame.pc());
    loop {
        debug::exit(debug::EXIT_FAILURE);
    }
}

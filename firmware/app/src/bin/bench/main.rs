//! What the core costs, in executed instructions.
//!
//! The image runs in QEMU with `-icount shift=8`: an instruction takes 256 ns of virtual time, which is 6.4 counts of the board's counter,
//! so what it counts tells the instructions exactly. Each workload is one line on the standard output, name, tab, count. The answer of each is
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

#[allow(dead_code, unused_imports, reason = "the counter is all that is taken")]
#[path = "../../board/qemu/device.rs"]
mod chip;

/// Nanoseconds of an instruction, as `xtask` starts the emulator, and of a count.
const INSTRUCTION: u64 = 1 << 8;
const COUNT: u64 = 1_000_000_000 / chip::CLOCK_HZ as u64;

/// The counter; it wraps.
#[inline(always)]
fn counter() -> u32 {
    chip::FPGAIO.counter.read()
}

/// Counts the instructions of `region`, without those of counting.
fn count<R>(region: impl FnOnce() -> R) -> (u32, R) {
    let empty = {
        let start = counter();
        counter().wrapping_sub(start)
    };
    let start = counter();
    let result = region();
    let end = counter();
    let passed = u64::from(end.wrapping_sub(start).wrapping_sub(empty)) * COUNT;
    (((passed + INSTRUCTION / 2) / INSTRUCTION) as u32, result)
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

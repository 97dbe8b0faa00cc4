//! Logs go nowhere: in the emulator its standard output belongs to its own messages, which they would corrupt; on the board nobody
//! listens without a debug probe.

#[defmt::global_logger]
struct NoLogger;

// SAFETY: nothing is acquired and nothing written, so there is nothing to protect.
unsafe impl defmt::Logger for NoLogger {
    fn acquire() {}

    unsafe fn flush() {}

    unsafe fn release() {}

    unsafe fn write(_bytes: &[u8]) {}
}
